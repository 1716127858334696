//! Prepared data: what is computed once for a character, stored in its GLB and played by crowds and
//! evaluations.
//!
//! [`prepare()`](crate::prepare()) computes and writes it ([`write`]); [`Figure`](crate::Figure) and
//! [`CrowdAsset`](crate::crowd::CrowdAsset) read it ([`stored`]) where it belongs to the character
//! and the options beside it ([`hash`]), and compute it where it does not. The form is described in
//! `docs/formats/ARTICULA_prepared.md`.

mod check;
pub(crate) mod hash;
mod options;
pub(crate) mod part;
pub(crate) mod state;
pub(crate) mod stored;
pub(crate) mod write;

pub use check::{CheckedPart, PartState, PreparedCheck, check_prepared};
pub use options::PrepareOptions;
pub use part::{PartBytes, PreparedPart};
