//! Seeded mutations of good files, for the tests of readers: whatever the bytes, reading ends
//! with a value or an error.
//!
//! The stable twin of fuzzing: the same mutants on every machine. A test says which edits harm
//! its format, how many of them a mutant has, and how many mutants it tries; what must hold of
//! whatever was read it asserts itself.
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
//! What is deliberately absent: anything that a product links; only tests name this crate.

mod dice;
mod mutations;

pub use dice::Dice;
pub use mutations::{Edit, Mutations, cut_off};
