//! The MPEG-4 text formats are read and written, and BAP drives the standard humanoid.

mod bap_text;
mod fap_text;
mod fdp_files;
mod mutated;
mod real_files;
mod texts;
