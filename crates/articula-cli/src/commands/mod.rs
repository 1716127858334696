//! One module per command; a command reads files, calls the libraries and prints the result.

pub(crate) mod adapt;
pub(crate) mod bench;
pub(crate) mod build;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod crowd;
pub(crate) mod demo;
pub(crate) mod device_score;
mod face_shapes;
pub(crate) mod flatten;
pub(crate) mod gbsd;
pub(crate) mod human;
pub(crate) mod inspect;
pub(crate) mod lod;
pub(crate) mod optimize;
pub(crate) mod package;
mod phones;
pub(crate) mod play;
pub(crate) mod serve;
pub(crate) mod server;
pub(crate) mod speak;
