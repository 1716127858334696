//! Impostors: a far character as small pictures that are baked once, each shown on two triangles.
//!
//! [`ImpostorPlan::new`] chooses directions ([`ImpostorViews`]), key poses of each clip and the size
//! of a picture so that the error is least within a number of bytes; [`ImpostorPlan::draw`] draws
//! the pictures of one pose, and [`ImpostorPlan::atlas`] joins all. [`ImpostorPlan::to_json`] is
//! the table beside the picture (`docs/formats/impostor.md`).
//!
//! Each picture is drawn in parallel projection along a direction and shown on a plane through the
//! character's centre that stays where it is while the eye moves ([`ImpostorView`]): a vertex appears
//! where the direction through it meets the plane. So the error of a vertex is its distance from
//! the plane along the direction, times the sine of the angle between the direction and that of
//! the eye. Source of the error: `docs/metrics.md`.

mod buffers;
mod directions;
mod document;
mod error;
mod keys;
mod measure;
mod options;
mod pictures;
mod plan;
mod samples;
mod show;
mod views;

pub use buffers::ImpostorBuffers;
pub use error::ImpostorError;
pub use options::{ImpostorBound, ImpostorOptions};
pub use plan::{ImpostorCell, ImpostorClip, ImpostorPlan, ImpostorTrial};
pub use samples::ImpostorSource;
pub use show::ImpostorPainter;
pub use views::{ImpostorView, ImpostorViews, ViewRow};

#[cfg(test)]
mod tests;
