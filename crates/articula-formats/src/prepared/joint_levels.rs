//! The parts `jointLevels` and `figureLevels`: levels of joints, pairs of joint and mesh levels,
//! and their errors in each clip.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{
    ClipLodErrors, FigureLevel, JointLods, LocalPose, LodErrors, MAX_JOINTS, Rig, Transform,
};

/// Joint LODs and the errors of each level in each clip.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLevels {
    /// Joint order, levels and mean pose.
    pub joint_lods: JointLods,
    /// Errors of each level.
    pub errors: LodErrors,
}

/// Levels of joints and mesh that are shown together, and their errors.
#[derive(Debug, Clone, PartialEq)]
pub struct PairedLevels {
    /// Contents of each level, the full character first.
    pub levels: Vec<FigureLevel>,
    /// Errors of each level.
    pub errors: LodErrors,
}

/// Encodes joint LODs.
pub fn write_joint_levels(levels: &JointLevels) -> Vec<u8> {
    let mut out = Writer::default();
    let lods = &levels.joint_lods;
    out.count(lods.joints().len());
    lods.joints()
        .iter()
        .for_each(|j| out.count(usize::from(*j)));
    lods.mean().iter().for_each(|t| out.transform(t));
    out.count(lods.levels());
    (0..lods.levels()).for_each(|l| out.count(lods.joint_count(l)));
    put_errors(&mut out, &levels.errors);
    out.0
}

/// Decodes the output of [`write_joint_levels`] for a rig.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, also if the levels are of another rig;
/// [`ReadError::LimitExceeded`].
pub fn read_joint_levels(
    bytes: &[u8],
    rig: &Rig,
    limits: &Limits,
) -> Result<JointLevels, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.at_most(MAX_JOINTS, "a number of joints")?;
    let mut joints = Vec::with_capacity(count);
    for _ in 0..count {
        joints.push(r.at_most(usize::from(u16::MAX), "a joint")? as u16);
    }
    let rest = rig.rest_pose();
    let mut mean: Vec<Transform> = (0..rig.len()).map(|j| rest.get(j)).collect();
    for joint in &joints {
        let transform = r.transform()?;
        if let Some(place) = mean.get_mut(usize::from(*joint)) {
            *place = transform;
        }
    }
    let mut kept = Vec::new();
    for _ in 0..r.at_most(JointLods::MAX_LEVELS, "a number of levels")? {
        kept.push(r.at_most(MAX_JOINTS, "a number of joints")? as u16);
    }
    let mean: LocalPose = mean.into_iter().collect();
    let joint_lods = JointLods::new(rig, joints, kept, &mean);
    let joint_lods = joint_lods.map_err(|e| r.bytes.bad(e.to_string()))?;
    let errors = errors(&mut r, joint_lods.levels())?;
    r.bytes.end()?;
    Ok(JointLevels { joint_lods, errors })
}

/// Encodes pairs of joint and mesh levels.
pub fn write_paired_levels(levels: &PairedLevels) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(levels.levels.len());
    for level in &levels.levels {
        for number in [
            level.joint_level,
            level.mesh_level,
            level.joints,
            level.triangles,
            level.vertices,
            level.influences,
        ] {
            out.count(number);
        }
        out.float(level.cost);
    }
    put_errors(&mut out, &levels.errors);
    out.0
}

/// Decodes the output of [`write_paired_levels`].
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_paired_levels(bytes: &[u8], limits: &Limits) -> Result<PairedLevels, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.at_most(JointLods::MAX_LEVELS, "a number of levels")?;
    let mut levels = Vec::with_capacity(count);
    for _ in 0..count {
        levels.push(FigureLevel {
            joint_level: r.index()?,
            mesh_level: r.index()?,
            joints: r.index()?,
            triangles: r.index()?,
            vertices: r.index()?,
            influences: r.index()?,
            cost: r.float()?,
        });
    }
    let errors = errors(&mut r, count)?;
    r.bytes.end()?;
    Ok(PairedLevels { levels, errors })
}

fn put_errors(out: &mut Writer, errors: &LodErrors) {
    out.count(errors.clips.len());
    for clip in &errors.clips {
        out.floats(&clip.levels_metres);
        out.floats(&clip.worst_metres);
        out.float(clip.speed_metres_per_sec);
        out.float(clip.seam_metres);
    }
}

fn errors(r: &mut Numbers<'_>, levels: usize) -> Result<LodErrors, ReadError> {
    let count = r.count(8 * levels + 8, "clips")?;
    let mut clips = Vec::with_capacity(count);
    for _ in 0..count {
        clips.push(ClipLodErrors {
            levels_metres: r.groups(levels, |[metres]| metres)?,
            worst_metres: r.groups(levels, |[metres]| metres)?,
            speed_metres_per_sec: r.float()?,
            seam_metres: r.float()?,
        });
    }
    let errors = LodErrors { clips };
    match errors.check(count, levels) {
        Ok(()) => Ok(errors),
        Err(e) => Err(r.bytes.bad(e.to_string()).into()),
    }
}
