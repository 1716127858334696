//! Warnings, one for each kind.

use crate::notes::Notes;

/// What was odd about a file, by kind.
#[derive(Debug, Default)]
pub(super) struct Kinds {
    list: Vec<Kind>,
}

#[derive(Debug)]
struct Kind {
    at: String,
    what: &'static str,
    more: usize,
}

impl Kinds {
    /// Notes one case of a kind; the place of the first is told.
    pub(super) fn note(&mut self, at: impl FnOnce() -> String, what: &'static str) {
        self.note_all(at, what, 1);
    }

    /// Notes several cases of a kind.
    pub(super) fn note_all(
        &mut self,
        at: impl FnOnce() -> String,
        what: &'static str,
        count: usize,
    ) {
        if count == 0 {
            return;
        }
        match self.list.iter_mut().find(|kind| kind.what == what) {
            Some(kind) => kind.more += count,
            None => self.list.push(Kind {
                at: at(),
                what,
                more: count - 1,
            }),
        }
    }

    pub(super) fn tell(self, notes: &mut Notes) {
        for Kind { at, what, more } in self.list {
            let more = match more {
                0 => String::new(),
                more => format!(" (and {more} more)"),
            };
            notes.add(at, format!("{what}{more}"));
        }
    }
}
