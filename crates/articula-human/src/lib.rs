//! The reference human, on the 89 joints of H-Anim, and a plain mannequin for measurements.
//!
//! A substitute wherever no character is available: 89 joints with names, levels and regions, meshes
//! with 2,000 to 70,000 triangles in all, and the clips `idle`, `walk` and `wave`.
//!
//! ```
//! use articula_human::{HumanOptions, human};
//!
//! let character = human(&HumanOptions { triangles: 2_000, face: true })?;
//! assert_eq!(character.skeleton.joints.len(), 89);
//! # Ok::<(), articula_human::HumanError>(())
//! ```
//!
//! The body is one signed distance field. It is polygonised finely, simplified to the requested
//! triangle count, skinned by position and animated by formulas: options → field → surfaces →
//! weights → character. The same options give the same bytes.
//!
//! Not included: files. Simplification is that of `articula-build`.

mod bake;
mod body;
mod charts;
mod expression;
mod eyes;
mod field;
mod foot;
mod gait;
mod gestures;
mod hand;
mod head;
mod jaw;
mod landmarks;
mod leg;
mod mannequin;
mod morphs;
mod motion;
mod mouth;
mod paint;
mod painted;
mod performance;
mod person;
mod person_head;
mod person_pieces;
mod pieces;
mod polygonise;
mod primitive;
mod skeleton;
mod suit;
mod thin;
mod weights;

use articula_core::source::Character;
pub use landmarks::{FeaturePoint, feature_points};
pub use painted::PaintedHuman;
use std::ops::RangeInclusive;

/// Supported triangle counts of [`human`].
pub const TRIANGLES: RangeInclusive<usize> = 2_000..=70_000;

/// Options of [`human`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HumanOptions {
    /// Number of triangles of all meshes together, within [`TRIANGLES`]; met to 5 %.
    pub triangles: usize,
    /// Whether it is a human with a face, hair and clothes; the plain mannequin without, whose figure
    /// stays the same for measurements.
    pub face: bool,
}

impl Default for HumanOptions {
    fn default() -> Self {
        Self {
            triangles: 12_000,
            face: true,
        }
    }
}

impl HumanOptions {
    /// The mannequin with this number of triangles.
    #[must_use]
    pub fn mannequin(triangles: usize) -> Self {
        Self {
            triangles,
            face: false,
        }
    }
}

/// Error of [`human`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HumanError {
    /// The triangle count is outside of [`TRIANGLES`].
    #[error("{found} triangles were requested; choose {} to {} triangles", TRIANGLES.start(), TRIANGLES.end())]
    Triangles {
        /// The requested count.
        found: usize,
    },
}

/// Creates the reference human, or the mannequin, with looping clips.
///
/// It is 1.75 m tall, stands on y = 0, faces +Z and has its left side at +X, with the arms hanging;
/// all rest rotations are the identity. The meshes are symmetric about x = 0.
///
/// # Errors
/// [`HumanError::Triangles`] if the count is outside of [`TRIANGLES`].
pub fn human(options: &HumanOptions) -> Result<Character, HumanError> {
    if !TRIANGLES.contains(&options.triangles) {
        return Err(HumanError::Triangles {
            found: options.triangles,
        });
    }
    Ok(if options.face {
        person::character(options.triangles)
    } else {
        mannequin::character(options.triangles)
    })
}

/// Creates the human with a face, with its colours in a picture of 512 px instead of its materials.
///
/// Shape, skin, blend shapes and clips are those of [`human`]; vertices between two charts of the picture are there
/// once for each. Both halves of the body have the same texture coordinates, which depend on the position alone, so that a
/// picture painted for one number of triangles fits all. The picture also holds how much light reaches folds.
///
/// # Errors
/// [`HumanError::Triangles`] if the count is outside of [`TRIANGLES`].
pub fn painted_human(triangles: usize) -> Result<PaintedHuman, HumanError> {
    if !TRIANGLES.contains(&triangles) {
        return Err(HumanError::Triangles { found: triangles });
    }
    Ok(painted::human(triangles))
}
