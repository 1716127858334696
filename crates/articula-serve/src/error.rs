//! What goes wrong before or beside an answer.

use thiserror::Error;

/// An error of the server.
#[derive(Debug, Error)]
pub enum ServeError {
    /// A file or folder of the store cannot be read or written.
    #[error("{place}: {what}")]
    Store {
        /// The file or folder.
        place: String,
        /// What is wrong, and what mends it.
        what: String,
    },
    /// A name that no character can have.
    #[error(
        "\"{0}\": a name has 1 to 100 letters, digits, `-`, `_` and `.`, and does not begin with `.`"
    )]
    Name(String),
    /// Bytes that are no character which holds all its data.
    #[error("the body is no binary glTF (.glb, .vrm) and no .fbx")]
    Form,
    /// A character cannot be opened or packaged.
    #[error(transparent)]
    Character(#[from] articula::Error),
    /// The network.
    #[error(transparent)]
    Network(#[from] std::io::Error),
}

impl ServeError {
    /// An error of a place in the store.
    pub(crate) fn store(place: &std::path::Path, error: &std::io::Error) -> Self {
        use std::io::ErrorKind;
        let what = match error.kind() {
            ErrorKind::StorageFull => "the disk is full; free space".to_owned(),
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "no permission to write here; serve it with --read-only".to_owned()
            }
            _ => error.to_string(),
        };
        Self::Store {
            place: place.display().to_string(),
            what,
        }
    }
}
