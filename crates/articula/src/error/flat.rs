//! Errors of 2D output as errors of the library.

use super::Error;
use articula_flat::PictureError;
use articula_flat::impostor::ImpostorError;
use articula_flat::planar::PlanarError;
use articula_flat::portrait::PortraitError;

impl From<PictureError> for Error {
    fn from(error: PictureError) -> Self {
        Self::Picture(Box::new(error))
    }
}

impl From<ImpostorError> for Error {
    fn from(error: ImpostorError) -> Self {
        match error {
            ImpostorError::Cancelled(_) => Self::Cancelled,
            other => Self::Picture(Box::new(other)),
        }
    }
}

impl From<PlanarError> for Error {
    fn from(error: PlanarError) -> Self {
        match error {
            PlanarError::Cancelled(_) => Self::Cancelled,
            other => Self::Picture(Box::new(other)),
        }
    }
}

impl From<PortraitError> for Error {
    fn from(error: PortraitError) -> Self {
        match error {
            PortraitError::Cancelled(_) => Self::Cancelled,
            other => Self::Picture(Box::new(other)),
        }
    }
}
