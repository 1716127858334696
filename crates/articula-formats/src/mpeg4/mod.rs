//! Text formats of MPEG-4 face and body animation (ISO/IEC 14496-2, annex C).
//!
//! - [`fap`]: facial animation parameters; read and write
//! - [`bap`]: body animation parameters, which drive the standard humanoid; read and write
//! - [`epf`]: parameters of the encoder; read as data
//! - [`fdp`]: Xface's description of a face; read and write
//!
//! The standard defines bits, not text: the text formats are those of its reference encoder and of
//! Xface, see `docs/formats/mpeg4.md`.

pub mod bap;
mod bap_body;
mod bap_limb;
mod bap_sample;
mod bap_split;
mod bap_table;
pub mod epf;
pub mod fap;
pub mod fdp;
mod fdp_write;
mod parameter_text;
