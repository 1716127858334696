//! The simplifiers under comparison.

use super::characters::Subject;
use crate::peers::meshopt::{Seams, Simplifier};
use anyhow::Result;
use articula_build::{ErrorWeighting, LevelTriangles, SimplifyOptions, simplify};
use articula_build::{PoseOptions, SkinPose, SkinPoseSource, poses, positions};
use glam::Vec3;

/// Factor by which the thesis' weighting increases errors of vertices with two equal weights,
/// halved.
const JOINT_STRENGTH: f32 = 4.0;

/// Number of triangles relative to the requested one above which seams may be crossed instead.
const STUCK: f32 = 1.02;

/// A simplifier with its settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contestant {
    /// Articula: errors summed over poses.
    Ours,
    /// Articula, the rest pose only.
    Rest,
    /// Articula, the rest pose, with larger weights near joints.
    Joint,
    /// meshoptimizer by positions.
    Meshopt,
    /// meshoptimizer by positions and normals.
    MeshoptNormals,
}

impl Contestant {
    pub(super) const ALL: [Self; 5] = [
        Self::Ours,
        Self::Rest,
        Self::Joint,
        Self::Meshopt,
        Self::MeshoptNormals,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Rest => "ours, rest pose only",
            Self::Joint => "ours, rest pose and joint weight",
            Self::Meshopt => "meshopt",
            Self::MeshoptNormals => "meshopt with normals",
        }
    }
}

/// Positions of all vertices in poses, metres.
pub(super) struct Posed {
    pub(super) source: SkinPoseSource,
    /// Poses for simplification by Articula, the rest pose first.
    pub(super) shaping: Vec<Vec<Vec3>>,
    /// Poses on which all simplifiers are measured.
    pub(super) measuring: Vec<Vec<Vec3>>,
    /// The same poses as joints and morph weights.
    pub(super) measuring_poses: Vec<SkinPose>,
}

impl Posed {
    pub(super) fn of(subject: &Subject, measuring: usize) -> Result<Self> {
        let opts = PoseOptions {
            measuring,
            ..PoseOptions::default()
        };
        let found = poses(&subject.asset, &opts)?;
        Ok(Self {
            source: found.source,
            shaping: positions(&subject.asset, &found.shaping),
            measuring: positions(&subject.asset, &found.measuring),
            measuring_poses: found.measuring,
        })
    }

    pub(super) fn rest(&self) -> &[Vec3] {
        &self.shaping[0]
    }
}

/// Levels made by one simplifier.
pub(super) struct Made {
    pub(super) who: Contestant,
    /// Coarsest first; the last is the original.
    pub(super) levels: Vec<LevelTriangles>,
    /// Whether seams were crossed, for each level.
    pub(super) crossed_seams: Vec<bool>,
}

/// Five levels of a character, coarsest first, the last the original. meshoptimizer is given the
/// number of triangles of Articula's level; it may keep more if it cannot continue.
pub(super) fn levels(
    who: Contestant,
    subject: &Subject,
    posed: &Posed,
    ours: &[LevelTriangles],
) -> Result<Made> {
    let whole = |levels: Vec<LevelTriangles>| Made {
        who,
        crossed_seams: vec![false; levels.len()],
        levels,
    };
    let weighting = match who {
        Contestant::Ours => return Ok(whole(ours.to_vec())),
        Contestant::Rest => ErrorWeighting::Rest,
        Contestant::Joint => ErrorWeighting::Joint {
            strength: JOINT_STRENGTH,
        },
        Contestant::Meshopt | Contestant::MeshoptNormals => {
            return peer(who, subject, posed, ours);
        }
    };
    let opts = SimplifyOptions {
        weighting,
        ..SimplifyOptions::default()
    };
    let mut levels = simplify(&subject.asset.mesh, &posed.shaping, &opts)?.levels;
    levels.reverse();
    Ok(whole(levels))
}

fn peer(
    who: Contestant,
    subject: &Subject,
    posed: &Posed,
    ours: &[LevelTriangles],
) -> Result<Made> {
    let mut made = Made {
        who,
        levels: Vec::new(),
        crossed_seams: Vec::new(),
    };
    let Some((original, coarser)) = ours.split_last() else {
        return Ok(made);
    };
    let mesh = &subject.asset.mesh;
    let simplifier = Simplifier::new(mesh, &original.triangles, posed.rest());
    let by_normals = who == Contestant::MeshoptNormals;
    for level in coarser {
        let target = level.triangles.len();
        let mut found = simplifier.run(target, by_normals, Seams::Kept)?;
        let stuck = found.len() as f32 > STUCK * target as f32;
        if stuck {
            found = simplifier.run(target, by_normals, Seams::Crossed)?;
        }
        made.levels.push(part_by_part(subject, found));
        made.crossed_seams.push(stuck);
    }
    made.levels.push(original.clone());
    made.crossed_seams.push(false);
    Ok(made)
}

/// Triangles sorted by the part that their vertices belong to.
fn part_by_part(subject: &Subject, mut triangles: Vec<[u32; 3]>) -> LevelTriangles {
    let parts = &subject.asset.mesh.parts;
    let part = |t: &[u32; 3]| parts.partition_point(|p| p.vertices.end <= t[0] as usize);
    triangles.sort_by_key(part);
    let ends = (0..parts.len()).map(|p| triangles.partition_point(|t| part(t) <= p));
    let mut first = 0;
    let parts = ends
        .map(|end| {
            let range = first..end;
            first = end;
            range
        })
        .collect();
    LevelTriangles { triangles, parts }
}
