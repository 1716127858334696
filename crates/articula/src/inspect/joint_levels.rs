//! Joint levels of a character: what each computes, and its error in each clip.

use crate::error::{Context, Error, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_build::{JointLodOptions, MergedLevels, merged_levels};
use articula_core::lod_error_metres;
use serde::Serialize;

/// Tolerance in metres from which levels may drop ancestors of kept joints, unless stated otherwise.
pub const FAR_FROM_METRES: f32 = 4e-3;

/// Joint levels of a character, derived from the motion of all its clips.
#[derive(Debug, Serialize)]
pub struct JointLevelsInspection {
    /// Tolerance in metres, of the 95th percentile over vertices, from which far levels are used.
    pub far_from_m: f32,
    /// Whether errors are those of points on the bones, since the file has no mesh.
    pub on_bones: bool,
    /// The levels, finest first.
    pub levels: Vec<JointLevelInspection>,
}

/// One joint level.
#[derive(Debug, Serialize)]
pub struct JointLevelInspection {
    /// Number of the level; 0 is the finest and has all joints.
    pub level: usize,
    /// Whether it is a far level: it may keep a joint without its ancestors, on a rig of its own.
    pub far: bool,
    /// Number of joints that it computes.
    pub joints: usize,
    /// Number of skin matrices; 0 without a mesh.
    pub matrices: usize,
    /// Maximum number of influences per vertex.
    pub influences: usize,
    /// Maximum error over the clips, metres; the error of a clip is that by which levels are
    /// chosen.
    pub error_m: f32,
    /// Errors in each clip.
    pub clips: Vec<JointLevelError>,
    /// Names of the joints that this level drops from those of the next finer one.
    pub drops: Vec<String>,
}

/// Error of a joint level in a clip: distances of the skin from that of the full character.
#[derive(Debug, Serialize)]
pub struct JointLevelError {
    /// Name of the clip.
    pub clip: String,
    /// Error by which levels are chosen: the larger of `p95_m` and half of `max_m`, metres.
    pub error_m: f32,
    /// 95th percentile over vertices, maximum over frames, metres.
    pub p95_m: f32,
    /// Maximum over vertices and frames, metres.
    pub max_m: f32,
}

/// Computes the joint levels of a figure and lists them with their errors in some of its clips.
///
/// Levels for a tolerance of at least `far_from_metres` may be far levels; with infinity there are
/// none.
///
/// # Errors
/// An [`Error`] that names the file: it has no clip, or
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn joint_levels(
    figure: &Figure,
    clips: &[usize],
    far_from_metres: f32,
    work: &Executor<'_>,
) -> Result<JointLevelsInspection> {
    const WHAT: &str = "computing joint levels";
    let asset = &figure.asset;
    if asset.clips.is_empty() {
        let what = "clips: the file has none, and joint levels follow from motion; add one by \
                    building the file with a motion";
        return Err(Error::unsuited(what)).context(figure.opened.name());
    }
    work.step(WHAT, 0, 1)?;
    let options = JointLodOptions {
        far_from_metres,
        ..JointLodOptions::default()
    };
    let merged = merged_levels(asset, &options).with_context(|| figure.opened.name())?;
    work.step(WHAT, 1, 1)?;
    let kept = kept(&merged);
    let near = merged.joint_lods.levels();
    let level = |l: usize| {
        let (far, skin) = match &merged.far {
            Some(far) if l >= near => (true, &far.skins.levels[l - near]),
            _ => (false, &merged.skins.levels[l]),
        };
        let errors: Vec<JointLevelError> = clips
            .iter()
            .map(|c| error(&asset.clips[*c].name, &merged, *c, l))
            .collect();
        let dropped = match l {
            0 => Vec::new(),
            _ => kept[l - 1]
                .iter()
                .filter(|j| !kept[l].contains(j))
                .map(|j| asset.rig.name(usize::from(*j)).to_owned())
                .collect(),
        };
        JointLevelInspection {
            level: l,
            far,
            joints: kept[l].len(),
            matrices: skin.palette,
            influences: skin.influences,
            error_m: errors.iter().fold(0.0, |most, e| most.max(e.error_m)),
            clips: errors,
            drops: dropped,
        }
    };
    Ok(JointLevelsInspection {
        far_from_m: far_from_metres,
        on_bones: asset.mesh.is_empty(),
        levels: (0..kept.len()).map(level).collect(),
    })
}

/// Joints of the rig that each level keeps, near levels first.
fn kept(merged: &MergedLevels) -> Vec<Vec<u16>> {
    let lods = &merged.joint_lods;
    let near = (0..lods.levels()).map(|l| lods.joints()[..lods.joint_count(l)].to_vec());
    let mut all: Vec<Vec<u16>> = near.collect();
    if let Some(far) = &merged.far {
        let lods = &far.joint_lods;
        let of = |l: usize| far.joints[..lods.joint_count(l)].to_vec();
        all.extend((0..lods.levels()).map(of));
    }
    all
}

fn error(name: &str, merged: &MergedLevels, clip: usize, level: usize) -> JointLevelError {
    let errors = &merged.errors.clips[clip];
    let (p95_m, max_m) = (errors.levels_metres[level], errors.worst_metres[level]);
    JointLevelError {
        clip: name.to_owned(),
        error_m: lod_error_metres(p95_m, max_m),
        p95_m,
        max_m,
    }
}
