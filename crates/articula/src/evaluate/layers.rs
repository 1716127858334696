//! What each part of a motion stream shows: the error of leaving it out.

use crate::clip_streams::abp2::decode;
use crate::clip_streams::{AccessUnitCount, region_name};
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::{Clip, PosedMesh, SkinnedMesh, Viewport, Wrap, sample_morphs};
use articula_formats::Limits;
use articula_stream::abp2::{Grouping, MotionHead, prefix_map};
use articula_stream::{StreamLimits, Unit, cut};
use serde::Serialize;
use std::collections::BTreeSet;

/// Most frames that are measured; of a longer clip, every n-th.
const MOST_FRAMES: usize = 600;

/// Distances of a [`LayersReport`].
#[derive(Debug, Clone, PartialEq)]
pub struct LayerOptions {
    /// Distances from the camera in metres.
    pub distances_m: Vec<f32>,
    /// Picture in whose pixels errors are measured.
    pub viewport: Viewport,
}

/// Bytes and errors of the parts of a motion stream.
///
/// Errors are distances in 3D from the place that the whole stream shows, over all vertices.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayersReport {
    /// Name of the stream's file.
    pub file: String,
    /// Name of the character's file.
    pub character: String,
    /// Name of the clip.
    pub clip: String,
    /// Size of the stream in bytes.
    pub bytes: usize,
    /// Greatest error of the whole stream itself, in millimetres of skin, as stated by the stream.
    pub tolerance_mm: f64,
    /// Number of frames.
    pub frames: usize,
    /// Every how many frames errors are measured.
    pub every: usize,
    /// Frames per second.
    pub rate_hz: f32,
    /// Number of vertices, all of which are measured.
    pub vertices: usize,
    /// Distances of `px`, in metres.
    pub distances_m: Vec<f32>,
    /// The stream cut to each tier, finest first.
    pub tiers: Vec<LayerReport>,
    /// The stream cut to levels of articulation, finest first; each keeps the coarser ones.
    pub levels: Vec<LayerReport>,
    /// The stream with one group cut to a tier, by group and tier, finest first; the last of each
    /// group is the stream without it. Cuts that leave nothing out are not listed.
    pub groups: Vec<LayerReport>,
    /// Warnings about the stream's file: access units that are missing, tracks that were left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// A cut of a stream.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerReport {
    /// Level of articulation of the group; of a cut to levels, the finest that is kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub loa: Option<u8>,
    /// Region of the group.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Joint of the group.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Whether it is a group of morph targets, with a level and a region of the face.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_face: bool,
    /// Finest tier that is kept; `None` if none is.
    pub finest_tier: Option<usize>,
    /// Size of what is left, in bytes.
    pub bytes: usize,
    /// Greatest error in millimetres.
    pub error_mm_max: f32,
    /// Mean error in millimetres.
    pub error_mm_mean: f32,
    /// Greatest error in pixels at each distance.
    pub px: Vec<f32>,
    /// Where the error is greatest; `None` if there is none.
    pub worst: Option<WorstVertex>,
}

/// The vertex with the greatest error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct WorstVertex {
    /// Index of the vertex in the figure's mesh.
    pub vertex: usize,
    /// Name of the joint that it follows most.
    pub joint: String,
    /// Time in seconds.
    pub at_secs: f32,
}

/// Which cut: the units that are kept.
struct Wanted {
    loa: Option<u8>,
    region: Option<u8>,
    joint: Option<u16>,
    is_face: bool,
    finest_tier: Option<usize>,
    scope: Scope,
}

#[derive(Clone, Copy, PartialEq)]
enum Scope {
    Whole,
    Levels,
    Group,
}

impl Wanted {
    /// Whether a unit of a group and a tier is kept.
    fn keeps(&self, unit: &Unit) -> bool {
        let Some(tier) = unit.marker("tier") else {
            return true;
        };
        let is =
            |scheme: &str, wanted: Option<u32>| wanted.is_none() || unit.marker(scheme) == wanted;
        let is_fine_enough = self
            .finest_tier
            .is_some_and(|finest| tier as usize >= finest);
        match self.scope {
            Scope::Whole => is_fine_enough,
            Scope::Levels => unit.marker("loa") <= self.loa.map(u32::from),
            Scope::Group => {
                let [loa, region] = if self.is_face {
                    ["face_loa", "face_region"]
                } else {
                    ["loa", "region"]
                };
                let is_of_group = is(loa, self.loa.map(u32::from))
                    && is(region, self.region.map(u32::from))
                    && is("joint", self.joint.map(u32::from));
                !is_of_group || is_fine_enough
            }
        }
    }
}

/// Measures the parts of a motion stream on the character that it was made from; `name` identifies
/// the stream in errors. There is one job per cut.
///
/// # Errors
/// As from [`CharacterFile::decode_motion`](crate::CharacterFile::decode_motion); [`Error::Cancelled`](crate::Error::Cancelled).
pub fn layers(
    bytes: &[u8],
    name: &str,
    of: &Figure,
    options: &LayerOptions,
    work: &Executor<'_>,
) -> Result<LayersReport> {
    let limits = Limits::default();
    let (rig, mesh) = (&of.asset.rig, &of.asset.mesh);
    let decoded = |bytes: &[u8]| decode(bytes, rig, of.opened.name(), &limits).context(name);
    let stream_limits = StreamLimits::default();
    let head = MotionHead::open(bytes, &stream_limits).context(name)?;
    let map = prefix_map(bytes, &stream_limits).context(name)?;
    let count = AccessUnitCount::new(&head, &map);
    // Of a stream that ends early, the access units that are there as a whole are measured.
    let bytes = &bytes[..(map.bits.end / 8) as usize];
    let clip = decoded(bytes)?;
    let every = clip.frames().div_ceil(MOST_FRAMES).max(1);
    let measured = |wanted: Wanted| -> Result<(Scope, LayerReport)> {
        let cut = cut(bytes, &map, |unit| wanted.keeps(unit)).context(name)?;
        let shown = decoded(&cut.bytes)?;
        let found = compare(of, &clip, &shown, every);
        let px = |distance: &f32| options.viewport.pixels_per_metre(*distance) * found.max_metres;
        let report = LayerReport {
            loa: wanted.loa,
            region: wanted
                .region
                .map(|number| region_name(wanted.is_face, number)),
            is_face: wanted.is_face,
            joint: wanted.joint.map(|j| rig.name(usize::from(j)).to_owned()),
            finest_tier: wanted.finest_tier,
            bytes: cut.bytes.len(),
            error_mm_max: 1e3 * found.max_metres,
            error_mm_mean: 1e3 * found.mean_metres,
            px: options.distances_m.iter().map(px).collect(),
            worst: (found.max_metres > 0.0).then(|| WorstVertex {
                vertex: found.vertex,
                joint: most_followed(of, found.vertex),
                at_secs: found.frame as f32 / clip.rate_hz(),
            }),
        };
        Ok((wanted.scope, report))
    };
    let rows = work.map("measuring layers", wanted(&head), measured)?;
    let of_scope = |scope: Scope| {
        // Groups that do not move have no units.
        let leaves_out = |row: &LayerReport| scope != Scope::Group || row.bytes < bytes.len();
        let rows = rows
            .iter()
            .filter(|(of, row)| *of == scope && leaves_out(row));
        rows.map(|(_, row)| row.clone()).collect()
    };
    Ok(LayersReport {
        file: name.to_owned(),
        character: of.opened.name().to_owned(),
        clip: head.name.clone(),
        bytes: bytes.len(),
        tolerance_mm: 1e-3 * f64::from(head.tolerance_micrometres),
        frames: clip.frames(),
        every,
        rate_hz: clip.rate_hz(),
        vertices: mesh.len(),
        distances_m: options.distances_m.clone(),
        tiers: of_scope(Scope::Whole),
        levels: of_scope(Scope::Levels),
        groups: of_scope(Scope::Group),
        warnings: count
            .is_partial()
            .then(|| count.to_string())
            .into_iter()
            .collect(),
    })
}

/// All cuts of a stream.
fn wanted(head: &MotionHead) -> Vec<Wanted> {
    let plain = |scope, finest_tier| Wanted {
        loa: None,
        region: None,
        joint: None,
        is_face: false,
        finest_tier,
        scope,
    };
    let mut all: Vec<Wanted> = (0..head.tiers)
        .map(|tier| plain(Scope::Whole, Some(tier)))
        .collect();
    let levels: BTreeSet<u8> = head.groups.iter().map(|group| group.loa).collect();
    all.extend(levels.iter().rev().map(|loa| Wanted {
        loa: Some(*loa),
        ..plain(Scope::Levels, Some(0))
    }));
    let joints = head.groups.iter().map(|group| (group, false));
    let faces = head.morph_groups.iter().map(|group| (group, true));
    for (group, is_face) in joints.chain(faces) {
        let has_region = is_face || head.grouping != Grouping::Loa;
        let tiers = (1..head.tiers).map(Some).chain([None]);
        all.extend(tiers.map(|tier| Wanted {
            loa: Some(group.loa),
            region: has_region.then_some(group.region),
            joint: group.joint,
            is_face,
            ..plain(Scope::Group, tier)
        }));
    }
    all
}

/// Difference of two clips on a figure.
#[derive(Default)]
struct Difference {
    max_metres: f32,
    mean_metres: f32,
    vertex: usize,
    frame: usize,
}

fn compare(of: &Figure, a: &Clip, b: &Clip, every: usize) -> Difference {
    let (rig, mesh) = (&of.asset.rig, &of.asset.mesh);
    let (mut posed, mut left, mut right) = (
        PosedMesh::new(rig, mesh),
        SkinnedMesh::new(mesh),
        SkinnedMesh::new(mesh),
    );
    let mut show = |clip: &Clip, frame: usize, out: &mut SkinnedMesh| {
        let secs = frame as f64 / f64::from(clip.rate_hz());
        let mut weights = mesh.morph_weights.clone();
        sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
        posed.pose_at(clip, secs, Wrap::Clamp).skin(&weights, out);
    };
    let (mut found, mut sum, mut count) = (Difference::default(), 0.0_f64, 0_usize);
    for frame in (0..a.frames()).step_by(every) {
        show(a, frame, &mut left);
        show(b, frame, &mut right);
        for (vertex, (a, b)) in left.positions.iter().zip(&right.positions).enumerate() {
            let distance = a.distance(*b);
            sum += f64::from(distance);
            count += 1;
            if distance > found.max_metres {
                found = Difference {
                    max_metres: distance,
                    vertex,
                    frame,
                    ..found
                };
            }
        }
    }
    found.mean_metres = (sum / count.max(1) as f64) as f32;
    found
}

/// Name of the joint that a vertex follows most.
fn most_followed(of: &Figure, vertex: usize) -> String {
    let influences = of.asset.mesh.influences_of(vertex);
    let most = influences.max_by(|a, b| a.1.total_cmp(&b.1));
    most.map_or_else(String::new, |(joint, _)| {
        of.asset.rig.name(joint).to_owned()
    })
}
