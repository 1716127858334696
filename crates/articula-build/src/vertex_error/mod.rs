//! The greatest distance of any vertex between two characters in motion, as their files are read.
//!
//! - `posed`: a character whose vertices are posed
//! - `reference`: one clip beside many versions of it
//! - `skin`: its vertices, without influences of no weight

mod posed;
mod reference;
mod skin;

pub use posed::PosedVertices;
pub use reference::ReferenceClip;

use crate::key_times::key_times;
use crate::split_mix::SplitMix;
use articula_core::source::RawClip;

/// Maximum number of times of a clip that are posed, of its keys and the middles between them.
const MAX_TIMES: usize = 1500;
/// Number of random times besides.
const RANDOM_TIMES: usize = 32;

/// Greatest distance of any vertex between two characters of one order of vertices, each over a clip of
/// its own or at rest, in metres.
///
/// Posed are all key times of the first clip and the middles between them, at most 1500 that are drawn
/// by the seed if there are more, and 32 random times.
pub fn greatest_vertex_error(
    wanted: (&mut PosedVertices<'_>, Option<&RawClip>),
    shown: (&mut PosedVertices<'_>, Option<&RawClip>),
    seed: u64,
) -> f32 {
    let (from, clip) = wanted;
    let (to, other) = shown;
    let times = clip.map_or_else(|| vec![0.0], |clip| times(clip, seed));
    let mut worst = 0.0f32;
    for secs in times {
        let pairs = from.at(clip, secs).iter().zip(to.at(other, secs));
        let farthest = pairs.map(|(a, b)| a.distance_squared(*b));
        worst = farthest.fold(worst, f32::max);
    }
    worst.sqrt()
}

/// The times at which a clip is posed, ascending.
fn times(clip: &RawClip, seed: u64) -> Vec<f32> {
    let mut times: Vec<f32> = key_times(clip).collect();
    times.sort_by(f32::total_cmp);
    times.dedup();
    let middles: Vec<f32> = times.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    times.extend(middles);
    let mut random = SplitMix(seed);
    for i in 0..times.len().min(MAX_TIMES) {
        let other = i + random.below(times.len() - i);
        times.swap(i, other);
    }
    times.truncate(MAX_TIMES);
    times.extend((0..RANDOM_TIMES).map(|_| clip.duration_secs * random.unit()));
    times.sort_by(f32::total_cmp);
    times
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{
        Channel, Character, Interpolation, Joint, Primitive, Property, RawMesh, Skeleton, Skin,
    };
    use glam::{Affine3A, Quat, Vec3};

    /// A vertex 2 m from a joint that turns by an angle in a second.
    fn arm(radians: f32, length: f32) -> (Character, RawClip) {
        let primitive = Primitive {
            positions: vec![Vec3::ZERO, Vec3::X * length, Vec3::Y * 0.1],
            normals: vec![Vec3::Z; 3],
            influences: 1,
            joints: vec![0; 3],
            weights: vec![1.0; 3],
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![Joint {
                    name: "arm".into(),
                    parent: None,
                    rest: Transform::IDENTITY,
                    in_skin: true,
                }],
            },
            meshes: vec![RawMesh {
                name: "arm".into(),
                skin: Skin {
                    joints: vec![0],
                    inverse_bind: vec![Affine3A::IDENTITY],
                },
                primitives: vec![primitive],
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        let turns = [0.0, radians].map(|a| Quat::from_rotation_z(a).to_array());
        let clip = RawClip {
            name: "turn".into(),
            duration_secs: 1.0,
            channels: vec![Channel {
                target: 0,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                times_secs: vec![0.0, 1.0],
                values: turns.as_flattened().to_vec(),
            }],
        };
        (character, clip)
    }

    #[test]
    fn the_end_of_an_arm_is_a_chord_away() {
        let (character, clip) = arm(1.0, 2.0);
        let (_, other) = arm(0.9, 2.0);
        let mut from = PosedVertices::new(&character).unwrap();
        let mut to = PosedVertices::new(&character).unwrap();
        assert_eq!(from.count(), 3);
        let same = greatest_vertex_error((&mut from, Some(&clip)), (&mut to, Some(&clip)), 1);
        assert_eq!(same, 0.0);
        let error = greatest_vertex_error((&mut from, Some(&clip)), (&mut to, Some(&other)), 1);
        assert!((error - 4.0 * 0.05f32.sin()).abs() < 1e-5, "{error}");
        let (longer, _) = arm(0.0, 2.5);
        let mut to = PosedVertices::new(&longer).unwrap();
        let at_rest = greatest_vertex_error((&mut from, None), (&mut to, None), 1);
        assert!((at_rest - 0.5).abs() < 1e-6);
    }
}
