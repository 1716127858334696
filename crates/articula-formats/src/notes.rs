//! Collection of a reader's warnings.

use crate::error::Warning;

/// Maximum number of warnings that are stored; further ones are only counted.
const MAX_WARNINGS: usize = 1000;

/// Warnings in the order in which they arose, bounded in number.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    list: Vec<Warning>,
    left_out: usize,
}

impl Notes {
    pub(crate) fn add(&mut self, at: impl Into<String>, what: impl Into<String>) {
        self.push(Warning::new(at, what));
    }

    pub(crate) fn push(&mut self, warning: Warning) {
        if self.list.len() < MAX_WARNINGS {
            self.list.push(warning);
        } else {
            self.left_out += 1;
        }
    }

    pub(crate) fn into_list(mut self) -> Vec<Warning> {
        if self.left_out > 0 {
            let what = format!("{} more warnings are not listed", self.left_out);
            self.list.push(Warning::new("file", what));
        }
        self.list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_are_bounded_and_counted() {
        let mut notes = Notes::default();
        for i in 0..MAX_WARNINGS + 7 {
            notes.add("here", format!("{i}"));
        }
        let list = notes.into_list();
        assert_eq!(list.len(), MAX_WARNINGS + 1);
        assert_eq!(list[MAX_WARNINGS].what, "7 more warnings are not listed");
    }
}
