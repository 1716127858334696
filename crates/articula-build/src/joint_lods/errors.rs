//! Error of each level in each clip: the table that the frame loop uses for level selection.
//!
//! Source: `docs/methods/motion-lod.md` parts 4.3 and 8; definitions in `docs/metrics.md`.

use super::measure::{Poser, WatchedSkin, measure};
use super::moments::{model_of, pose_of, share_frames, spread_frames};
use super::prefixes::Prefixes;
use super::skins::{placed_skins, skin_part};
use super::watch::{Watched, skin_of};
use super::{JointLodOptions, check, check_tolerances};
use crate::character::Asset;
use articula_core::percentile;
use articula_core::{
    Binding, Clip, ClipLodErrors, JointLods, LevelSkin, LevelSkins, LodErrors, Mesh, Mismatch,
};
use glam::Vec3;

/// Maximum number of frames, over all clips, at which errors are measured; shorter clips are
/// sampled at every frame.
pub(crate) const MAX_FRAMES: usize = 3000;

/// Measures the error of every level in every clip: the full character against the skin of the
/// level, with kept joints at their true transforms. The maximum is that of every vertex, the
/// percentile that of a sample. Without a mesh, points on the bones are compared.
///
/// O(frames x levels x vertices); of clips with more than 3000 frames in all, so many are compared.
/// Errors never fall from one level to the next coarser one. Morph targets are ignored. Root motion
/// counts for the speed and the seam as far as the clip contains it.
///
/// # Errors
/// A [`Mismatch`] if a clip, the mesh, the joint LODs or the skins belong to another character.
pub fn lod_errors(
    asset: &Asset,
    joint_lods: &JointLods,
    skins: &LevelSkins,
    opts: &JointLodOptions,
) -> Result<LodErrors, Mismatch> {
    check(asset)?;
    check_tolerances(asset, joint_lods)?;
    let full = skin_of(asset);
    if asset.mesh.is_empty() {
        let prefixes = Prefixes::of(&asset.rig, joint_lods);
        let skins = placed_skins(asset, &full, &prefixes, opts)?;
        return table(asset, &full, &skins.levels[1..], &skins.bindings, opts);
    }
    let fits = |s: &LevelSkin| s.positions.len() == full.len();
    if skins.levels.len() != joint_lods.levels() || !skins.levels.iter().all(fits) {
        let what = "the skins must belong to this character";
        return Err(Mismatch::new("skins", what));
    }
    // Level 0 is the full character and has no error.
    table(asset, &full, &skins.levels[1..], &skins.bindings, opts)
}

/// Measures coarser skins, whose bindings refer to the full rig, against the full mesh.
pub(super) fn table(
    asset: &Asset,
    full: &Mesh,
    skins: &[LevelSkin],
    bindings: &[Binding],
    opts: &JointLodOptions,
) -> Result<LodErrors, Mismatch> {
    let every = Watched::every(full, opts.vertices, opts.seed);
    let mut before = Skinning::of_mesh(full);
    let mut watched = Vec::with_capacity(skins.len());
    for skin in skins {
        let shown = Skinning::of_skin(skin, bindings);
        // A vertex that is skinned as at the level before errs as there, and errors never fall.
        let changes = |v: u32| !shown.equals(&before, v as usize);
        let watched_here = every.only_drawn_or(changes);
        watched.push(WatchedSkin {
            mesh: skin_part(skin, bindings, &watched_here.vertices),
            watched: watched_here,
        });
        before = shown;
    }
    let tallies = measure(asset, full, &watched, MAX_FRAMES);
    let mut poser = Poser::new(full, drawn(&every));
    let counts = share_frames(&asset.clips, MAX_FRAMES);
    let clips = asset.clips.iter().zip(tallies).zip(counts);
    let clips = clips.map(|((clip, tallies), count)| ClipLodErrors {
        levels_metres: rising(tallies.iter().map(|t| t.percentile_metres)),
        worst_metres: rising(tallies.iter().map(|t| t.worst_metres)),
        speed_metres_per_sec: speed(asset, clip, &mut poser, count),
        seam_metres: seam(asset, clip, &mut poser),
    });
    let errors = LodErrors {
        clips: clips.collect(),
    };
    errors.check(asset.clips.len(), skins.len() + 1)?;
    Ok(errors)
}

/// Positions and influences of all vertices.
#[derive(Clone, Copy)]
struct Skinning<'a> {
    positions: &'a [Vec3],
    influences: usize,
    binding_indices: &'a [u16],
    weights: &'a [f32],
    bindings: &'a [Binding],
}

impl<'a> Skinning<'a> {
    fn of_mesh(mesh: &'a Mesh) -> Self {
        Self {
            positions: &mesh.positions,
            influences: mesh.influences,
            binding_indices: &mesh.binding_indices,
            weights: &mesh.weights,
            bindings: &mesh.bindings,
        }
    }

    fn of_skin(skin: &'a LevelSkin, bindings: &'a [Binding]) -> Self {
        Self {
            positions: &skin.positions,
            influences: skin.influences,
            binding_indices: &skin.binding_indices,
            weights: &skin.weights,
            bindings,
        }
    }

    /// Whether a vertex is at the same place in every pose, by the same sum.
    fn equals(&self, other: &Self, vertex: usize) -> bool {
        self.positions[vertex] == other.positions[vertex] && self.of(vertex).eq(other.of(vertex))
    }

    /// Influences of a vertex, without those of no weight.
    fn of(&self, vertex: usize) -> impl Iterator<Item = (&'a Binding, f32)> {
        let of = vertex * self.influences..(vertex + 1) * self.influences;
        let bindings = self.bindings;
        let indices = self.binding_indices[of.clone()].iter();
        let pairs = indices.zip(&self.weights[of]);
        pairs
            .filter(|(_, weight)| **weight != 0.0)
            .map(|(index, weight)| (&bindings[usize::from(*index)], *weight))
    }
}

/// Adds an error per clip to all levels but the full one.
pub(super) fn add(errors: &mut LodErrors, metres: &[f32]) {
    for (clip, extra) in errors.clips.iter_mut().zip(metres) {
        let percentiles = clip.levels_metres.iter_mut().skip(1);
        let all = percentiles.chain(clip.worst_metres.iter_mut().skip(1));
        all.for_each(|e| *e += extra);
    }
}

/// Errors of the near levels followed by those of the far levels.
pub(super) fn joined(near: LodErrors, far: &LodErrors) -> LodErrors {
    let after = |near: &[f32], far: &[f32]| rising(near.iter().chain(&far[1..]).copied().skip(1));
    let clips = near.clips.into_iter().zip(&far.clips);
    let clips = clips.map(|(n, f)| ClipLodErrors {
        levels_metres: after(&n.levels_metres, &f.levels_metres),
        worst_metres: after(&n.worst_metres, &f.worst_metres),
        ..n
    });
    LodErrors {
        clips: clips.collect(),
    }
}

/// Vertices of the uniform random sample.
fn drawn(watched: &Watched) -> Vec<u32> {
    let all = watched.vertices.iter().zip(&watched.drawn);
    all.filter(|(_, d)| **d).map(|(v, _)| *v).collect()
}

/// Zero for the full character, then the running maximum, so that a coarser level never has a
/// smaller error.
pub(crate) fn rising(errors: impl Iterator<Item = f32>) -> Vec<f32> {
    let mut last = 0.0f32;
    let climbed = errors.map(|e| {
        last = last.max(e);
        last
    });
    std::iter::once(0.0).chain(climbed).collect()
}

fn points(asset: &Asset, clip: &Clip, frame: usize, poser: &mut Poser<'_>) -> Vec<Vec3> {
    let model = model_of(asset, &pose_of(asset, clip, frame));
    poser.pose(&model).to_vec()
}

fn apart(a: &[Vec3], b: &[Vec3]) -> f32 {
    let lengths = a.iter().zip(b).map(|(a, b)| a.distance(*b));
    let mut lengths: Vec<f32> = lengths.filter(|d| d.is_finite()).collect();
    percentile(&mut lengths, 0.95)
}

/// Maximum speed of the skin between consecutive frames, in m/s.
fn speed(asset: &Asset, clip: &Clip, poser: &mut Poser<'_>, count: usize) -> f32 {
    let mut greatest = 0.0f32;
    let mut last: Option<(usize, Vec<Vec3>)> = None;
    for frame in spread_frames(clip.frames(), count) {
        let next = (frame + 1).min(clip.frames() - 1);
        let here = match last.take().filter(|(at, _)| *at == frame) {
            Some((_, points)) => points,
            None => points(asset, clip, frame, poser),
        };
        let there = points(asset, clip, next, poser);
        greatest = greatest.max(apart(&here, &there) * clip.rate_hz());
        last = Some((next, there));
    }
    greatest
}

fn seam(asset: &Asset, clip: &Clip, poser: &mut Poser<'_>) -> f32 {
    let first = points(asset, clip, 0, poser);
    let last = points(asset, clip, clip.frames() - 1, poser);
    apart(&first, &last)
}

#[cfg(test)]
mod tests {
    use super::super::test_figures::arm;
    use super::*;
    use articula_core::{Track, Tracks};

    fn errors(levels: &[f32], worst: &[f32]) -> LodErrors {
        LodErrors {
            clips: vec![ClipLodErrors {
                levels_metres: levels.to_vec(),
                worst_metres: worst.to_vec(),
                speed_metres_per_sec: 3.0,
                seam_metres: 0.5,
            }],
        }
    }

    #[test]
    fn coarser_levels_never_err_less() {
        assert_eq!(
            rising([0.25, 0.125, 0.5].into_iter()),
            [0.0, 0.25, 0.25, 0.5]
        );
        assert_eq!(rising([].into_iter()), [0.0]);
        let near = errors(&[0.0, 0.25], &[0.0, 0.5]);
        let far = errors(&[0.0, 0.125, 1.0], &[0.0, 0.75, 2.0]);
        let expected = errors(&[0.0, 0.25, 0.25, 1.0], &[0.0, 0.5, 0.75, 2.0]);
        assert_eq!(joined(near, &far), expected);
    }

    #[test]
    fn an_extra_error_counts_for_all_but_the_full_level() {
        let mut found = errors(&[0.0, 0.25, 0.5], &[0.0, 0.5, 1.0]);
        add(&mut found, &[0.125]);
        assert_eq!(found, errors(&[0.0, 0.375, 0.625], &[0.0, 0.625, 1.125]));
    }

    #[test]
    fn speed_is_that_of_neighbouring_frames_and_the_seam_that_of_the_ends() {
        let asset = arm(2);
        let tracks = Tracks {
            translations: vec![Track {
                target: 0,
                step: false,
                values: [0.0, 0.1, 0.4, 0.3, 0.25].map(|x| Vec3::X * x).to_vec(),
            }],
            ..Tracks::default()
        };
        let clip = Clip::new("c", 30.0, 5, 2, tracks).unwrap();
        let mut poser = Poser::new(&asset.mesh, (0..16).collect());
        let mut of = |count| speed(&asset, &clip, &mut poser, count);
        assert!((of(5) - 9.0).abs() < 1e-3, "0.3 m in a frame");
        // The first, middle and last frames, each to the next one.
        assert!((of(3) - 3.0).abs() < 1e-3);
        assert!((seam(&asset, &clip, &mut poser) - 0.25).abs() < 1e-5);
        let watched = Watched {
            vertices: vec![2, 5, 9],
            drawn: vec![true, false, true],
        };
        assert_eq!(drawn(&watched), [2, 9]);
        // A point that is lost does not count.
        let far = [Vec3::X * 2.0, Vec3::Y * 2.0, Vec3::NAN];
        assert_eq!(apart(&[Vec3::ZERO; 3], &far), 2.0);
    }
}
