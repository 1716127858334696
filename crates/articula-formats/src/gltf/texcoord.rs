//! Texture coordinates of the base colour picture: index of the set, and its transform.
//!
//! Source: KHR_texture_transform. The rotation follows its text, its test model
//! (TextureTransformTest) and other readers; the code listing in its text rotates the other way
//! (KhronosGroup/glTF issue 1563).

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use articula_core::Libm;
use glam::{Affine2, Mat2, Vec2};

const NAME: &str = "KHR_texture_transform";

/// Texture coordinates that a material uses.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Texcoords {
    /// Index of the set.
    pub(super) set: u64,
    transform: Affine2,
}

impl Texcoords {
    /// Reads a texture reference without its picture. A broken extension is only a warning.
    pub(super) fn read(reader: &mut Reader<'_>, info: &Place<'_>) -> Result<Self, ReadError> {
        let plain = Self {
            set: info.whole_or("texCoord", 0)?,
            ..Self::default()
        };
        let Some(extension) = info.dig(&["extensions", NAME]) else {
            return Ok(plain);
        };
        match moved(&extension, plain.set) {
            Ok(moved) => Ok(moved),
            Err(error) => {
                reader.warn(
                    info,
                    format!("the texture transform is not applied: {error}"),
                );
                Ok(plain)
            }
        }
    }

    /// Transforms texture coordinates for the lookup in the picture. Without a transform they stay
    /// unchanged bit for bit.
    pub(super) fn apply(&self, texcoords: &mut [Vec2]) -> Result<(), String> {
        if self.transform == Affine2::IDENTITY {
            return Ok(());
        }
        for place in texcoords.iter_mut() {
            let moved = self.transform.transform_point2(*place);
            if !moved.is_finite() {
                return Err(format!("{NAME} moves {place} out of bounds"));
            }
            *place = moved;
        }
        Ok(())
    }
}

/// Reads the transform: scale first, then rotation, then offset.
fn moved(extension: &Place<'_>, set: u64) -> Result<Texcoords, ReadError> {
    let offset = extension.floats::<2>("offset")?.unwrap_or_default();
    let scale = extension.floats::<2>("scale")?.unwrap_or([1.0; 2]);
    let angle = extension.get("rotation").map_or(Ok(0.0), |r| r.float())?;
    // Counter-clockwise in the picture, whose second axis points down.
    let (sin, cos) = (-angle).libm_sin_cos();
    let turn = Mat2::from_cols_array(&[cos, sin, -sin, cos]);
    let matrix2 = turn * Mat2::from_diagonal(Vec2::from_array(scale));
    Ok(Texcoords {
        set: extension.whole_or("texCoord", set)?,
        transform: Affine2::from_mat2_translation(matrix2, Vec2::from_array(offset)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn transform(extension: &serde_json::Value) -> Texcoords {
        moved(&Place::root(extension), 3).unwrap()
    }

    #[test]
    fn scaled_then_turned_then_shifted_by_hand() {
        let quarter = std::f32::consts::FRAC_PI_2;
        let json = json!({"offset": [0, 1], "rotation": quarter, "scale": [0.5, 0.25]});
        let mut places = [Vec2::ZERO, Vec2::X, Vec2::Y];
        transform(&json).apply(&mut places).unwrap();
        // The example of the extension's text, the lower left quadrant of the picture: u runs up
        // from its lower left corner, v to the right (here with another scale for v).
        let wanted = [Vec2::Y, Vec2::new(0.0, 0.5), Vec2::new(0.25, 1.0)];
        for (a, b) in places.iter().zip(wanted) {
            assert!(a.distance(b) < 1e-6, "{a} {b}");
        }
    }

    #[test]
    fn sets_and_defaults() {
        assert_eq!(transform(&json!({})).set, 3);
        assert_eq!(transform(&json!({"texCoord": 1})).set, 1);
        let mut places = [Vec2::new(0.1, -7.3)];
        transform(&json!({"scale": [1, 1], "offset": [0, 0]}))
            .apply(&mut places)
            .unwrap();
        assert_eq!(places, [Vec2::new(0.1, -7.3)]);
        let huge = transform(&json!({"scale": [3e38, 1]}));
        assert!(huge.apply(&mut [Vec2::splat(2.0)]).is_err());
    }
}
