//! Seeded mutations of valid files, for tests that a reader ends with a value or an error for any
//! bytes.
//!
//! They complement fuzzing and give the same mutants on every machine. A test chooses the edits
//! that suit its format, the maximum number of edits per mutant and the number of mutants; it
//! asserts the properties of the values read.
//!
//! ```
//! use articula_mutate::{Edit, Mutations, cut_off};
//!
//! let read = |bytes: &[u8]| std::str::from_utf8(bytes).is_ok_and(|t| t.parse::<i32>().is_ok());
//! let mutations = Mutations {
//!     edits: &[Edit::FlipBit, Edit::Delete(3), Edit::Word(&["NaN", "-1"])],
//!     most: 2,
//! };
//! let good = mutations.read_of(b"1234", 500, read);
//! assert!(good > 0 && good < 500);
//! assert_eq!(cut_off(b"1234").filter(|bytes| read(bytes)).count(), 3);
//! ```
//!
//! No product uses this crate, only tests.

mod dice;
mod mutations;

pub use dice::Dice;
pub use mutations::{Edit, Mutations, cut_off};
