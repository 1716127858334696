//! Prepared data as a document stores it: what was computed once for a character, to be played by
//! crowds and evaluations.
//!
//! [`prepare()`](crate::prepare()) computes and writes it; [`Figure`](crate::Figure) and
//! [`CrowdAsset`](crate::crowd::CrowdAsset) read it ([`stored`]) where it belongs to the character
//! and the options beside it ([`hash`], [`state`]), and compute it where it does not. The form is
//! described in `docs/formats/ARTICULA_prepared.md`.

pub(crate) mod hash;
pub(crate) mod part;
pub(crate) mod state;
pub(crate) mod stored;
