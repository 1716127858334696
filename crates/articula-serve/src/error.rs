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
    /// The store has no space.
    #[error("{place}: the disk, or what may be used of it, is full; free space")]
    Full {
        /// The file or folder.
        place: String,
    },
    /// Another program writes to the catalogue, and does not end.
    #[error("{place}: another program writes to the catalogue; close it, or try again")]
    Locked {
        /// The file.
        place: String,
    },
    /// A name that no character can have.
    #[error(
        "\"{0}\": a name has 1 to 100 letters, digits, `-`, `_` and `.`, and does not begin with `.`"
    )]
    Name(String),
    /// Bytes that are no character which holds all its data.
    #[error("the body is no binary glTF (.glb, .vrm), no .fbx and no item in a .zip")]
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
        let place = place.display().to_string();
        let what = match error.kind() {
            // A limit of a process or of a file system is one of space too.
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
                return Self::Full { place };
            }
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                "no permission to write here; serve it with --read-only".to_owned()
            }
            _ => error.to_string(),
        };
        Self::Store { place, what }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::StatusCode;
    use axum::response::IntoResponse;
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_full_disk_is_told_apart_from_other_faults_of_the_store() {
        let status = |kind: ErrorKind| {
            let error = ServeError::store("objects".as_ref(), &Error::from(kind));
            assert!(error.to_string().starts_with("objects: "));
            error.into_response().status()
        };
        assert_eq!(
            status(ErrorKind::StorageFull),
            StatusCode::INSUFFICIENT_STORAGE
        );
        assert_eq!(
            status(ErrorKind::PermissionDenied),
            StatusCode::INTERNAL_SERVER_ERROR
        );
    }
}
