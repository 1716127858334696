//! Edits, mutants and truncations of a file.

use crate::dice::Dice;

/// Seed of all mutants, so that the result of a test depends only on its file and its edits.
const SEED: u64 = 20071;

/// An edit of a file at a random position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edit<'a> {
    /// Flips one bit.
    FlipBit,
    /// Replaces a byte by any byte.
    SetByte,
    /// Replaces a byte by one of these.
    SetOf(&'a [u8]),
    /// Inserts any byte.
    InsertByte,
    /// Inserts one of these bytes.
    InsertOf(&'a [u8]),
    /// Removes a byte.
    RemoveByte,
    /// Removes fewer bytes than this.
    Delete(usize),
    /// Repeats fewer bytes than this.
    Repeat(usize),
    /// Repeats everything from the position on.
    RepeatTail,
    /// Truncates the file.
    Truncate,
    /// Truncates the file within its last tenth.
    TruncateEnd,
    /// Inserts one of these words, with a blank on either side.
    Word(&'a [&'a str]),
    /// Replaces the next run of digits by one of these words.
    Number(&'a [&'a str]),
    /// Replaces the next run of digits by a number below this.
    NumberBelow(usize),
}

/// Options of the mutants of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mutations<'a> {
    /// Allowed edits, all with equal probability; an edit that is listed twice is applied twice as
    /// often.
    pub edits: &'a [Edit<'a>],
    /// Maximum number of edits of one mutant, at least 1.
    pub most: usize,
}

impl Mutations<'_> {
    /// Returns a mutant of a valid file.
    ///
    /// # Panics
    /// If there are no edits.
    pub fn mutant(&self, good: &[u8], dice: &mut Dice) -> Vec<u8> {
        let mut bytes = good.to_vec();
        for _ in 0..=dice.roll(self.most) {
            let at = dice.roll(bytes.len());
            let edit = dice.of(self.edits);
            apply(edit, &mut bytes, at, dice);
        }
        bytes
    }

    /// Reads `tries` mutants of a valid file and returns the number that were read successfully.
    /// `read` returns whether it could read the bytes, and panics if the value breaks a guarantee.
    ///
    /// # Panics
    /// If the file itself is not read, or there are no edits.
    pub fn read_of(&self, good: &[u8], tries: usize, mut read: impl FnMut(&[u8]) -> bool) -> usize {
        assert!(read(good), "the unharmed file is good");
        let mut dice = Dice::new(SEED);
        let of = |_: &usize| read(&self.mutant(good, &mut dice));
        (0..tries).filter(of).count()
    }
}

/// Returns the file truncated to every length from 0 up to, but without, its own.
pub fn cut_off(good: &[u8]) -> impl Iterator<Item = &[u8]> {
    (0..good.len()).map(|length| &good[..length])
}

fn apply(edit: Edit<'_>, bytes: &mut Vec<u8>, at: usize, dice: &mut Dice) {
    let up_to = |dice: &mut Dice, most: usize, length: usize| (at + dice.roll(most)).min(length);
    match edit {
        Edit::InsertByte => bytes.insert(at, dice.roll(256) as u8),
        Edit::InsertOf(list) => bytes.insert(at, dice.of(list)),
        Edit::RepeatTail => bytes.extend_from_within(at..),
        Edit::Truncate => bytes.truncate(at),
        Edit::TruncateEnd => bytes.truncate(at.max(bytes.len() * 9 / 10)),
        Edit::Delete(most) => {
            let end = up_to(dice, most, bytes.len());
            bytes.drain(at..end);
        }
        Edit::Repeat(most) => {
            let end = up_to(dice, most, bytes.len());
            let copy = bytes[at..end].to_vec();
            bytes.splice(at..at, copy);
        }
        Edit::Word(words) => {
            let word = dice.of(words).bytes();
            bytes.splice(at..at, [b' '].into_iter().chain(word).chain([b' ']));
        }
        Edit::Number(words) => replace_number(bytes, at, dice.of(words)),
        Edit::NumberBelow(end) => replace_number(bytes, at, &dice.roll(end).to_string()),
        // An empty file has no byte to edit.
        _ if bytes.is_empty() => {}
        Edit::FlipBit => bytes[at] ^= 1 << dice.roll(8),
        Edit::SetByte => bytes[at] = dice.roll(256) as u8,
        Edit::SetOf(list) => bytes[at] = dice.of(list),
        Edit::RemoveByte => drop(bytes.remove(at)),
    }
}

/// Replaces the next run of digits by a word.
fn replace_number(bytes: &mut Vec<u8>, at: usize, word: &str) {
    let is_digit = |b: &u8| b.is_ascii_digit();
    let Some(start) = bytes[at..].iter().position(is_digit).map(|i| at + i) else {
        return;
    };
    let length = bytes[start..].iter().take_while(|b| is_digit(b)).count();
    bytes.splice(start..start + length, word.bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mutants with one edit each.
    fn mutants(good: &[u8], edit: Edit<'_>) -> Vec<Vec<u8>> {
        let mutations = Mutations {
            edits: &[edit],
            most: 1,
        };
        let mut dice = Dice::new(1);
        let of = |_| mutations.mutant(good, &mut dice);
        (0..200).map(of).collect()
    }

    #[test]
    fn each_edit_does_what_it_says() {
        let good = b"ab 12 cd";
        let lengths = |edit| {
            let lengths = mutants(good, edit).into_iter().map(|m| m.len());
            let lengths: std::collections::BTreeSet<usize> = lengths.collect();
            (*lengths.first().unwrap(), *lengths.last().unwrap())
        };
        for edit in [Edit::FlipBit, Edit::SetByte, Edit::SetOf(b"x")] {
            assert_eq!(lengths(edit), (8, 8), "{edit:?}");
        }
        assert_eq!(lengths(Edit::InsertByte), (9, 9));
        assert_eq!(lengths(Edit::InsertOf(b"xy")), (9, 9));
        assert_eq!(lengths(Edit::RemoveByte), (7, 7));
        assert_eq!(lengths(Edit::Delete(4)), (5, 8));
        assert_eq!(lengths(Edit::Repeat(4)), (8, 11));
        assert_eq!(lengths(Edit::RepeatTail), (9, 16));
        assert_eq!(lengths(Edit::Truncate), (0, 7));
        assert_eq!(lengths(Edit::TruncateEnd), (7, 7));
        assert_eq!(lengths(Edit::Word(&["xyz"])), (13, 13));
        let numbers = mutants(good, Edit::Number(&["-7"]));
        assert!(numbers.contains(&b"ab -7 cd".to_vec()));
        assert!(
            numbers.contains(&good.to_vec()),
            "no digit behind the place"
        );
        assert!(mutants(good, Edit::NumberBelow(3)).contains(&b"ab 2 cd".to_vec()));
    }

    #[test]
    fn an_empty_file_survives_every_edit() {
        let words: &[&str] = &["a"];
        let edits = [
            Edit::FlipBit,
            Edit::SetByte,
            Edit::SetOf(b"x"),
            Edit::InsertByte,
            Edit::InsertOf(b"x"),
            Edit::RemoveByte,
            Edit::Delete(4),
            Edit::Repeat(4),
            Edit::RepeatTail,
            Edit::Truncate,
            Edit::TruncateEnd,
            Edit::Word(words),
            Edit::Number(words),
            Edit::NumberBelow(4),
        ];
        for edit in edits {
            assert_eq!(mutants(b"", edit).len(), 200);
        }
    }

    #[test]
    fn the_same_mutants_every_time() {
        let mutations = Mutations {
            edits: &[Edit::FlipBit, Edit::Truncate],
            most: 3,
        };
        let all = || {
            let mut seen = Vec::new();
            mutations.read_of(b"a good file", 50, |bytes| {
                seen.push(bytes.to_vec());
                true
            });
            seen
        };
        assert_eq!(all(), all());
        assert_eq!(all().len(), 51);
    }
}
