//! Contents of a file, and warnings about it.
//!
//! Field names are stable, since scripts read them as JSON (`docs/commands.md`).

mod access_units;
mod data;
mod extent;
mod human;
mod joint_levels;
mod listed;
mod mesh_levels;
mod motion_stream;
mod mp4;
mod skeletons;
mod stream;

pub use access_units::{AccessUnitsInspection, StreamShare, inspect_access_units};
pub use data::{
    CaptureShape, DataClip, DataInspection, EncoderSettings, FaceStreamInspection, FaceUnits,
    FapGroup, FapParameter, FeaturePointInspection, inspect_data,
};
pub use extent::Extent;
pub use human::{
    CreditsInspection, ExpressionInspection, HumanoidInspection, KhrCharacterInspection, MappedRig,
    MorphInspection, PassThroughItem, ReferencePoseClip, Term,
};
pub use joint_levels::{
    FAR_FROM_METRES, JointLevelError, JointLevelInspection, JointLevelsInspection, joint_levels,
};
pub use listed::{has_too_many_joints, inspect_listed};
pub use mesh_levels::{CoarserMesh, MeshLevelInspection, MeshLevelsInspection};
pub use motion_stream::{MotionStreamInspection, StreamGroup, StreamTier, inspect_motion_stream};
pub use mp4::{TrackInspection, inspect_mp4};
pub use stream::{StreamInspection, StreamLevel, inspect_stream};

use crate::error::Result;
use crate::face::{FaceLayout, NamedTarget, driven_faps, named_controls};
use crate::figure::Figure;
use crate::motion_tables::StoredTables;
use crate::optimize::{BytesByKind, OptimizeReport};
use crate::resampling::{ClipResampling, told_mm};
use crate::work::Executor;
use articula_build::joint_names::{
    DoubtReason, JointDoubt, MappingConfidence, MappingEvidence, UnmappedReason,
};
use articula_build::source_rate_hz;
use articula_core::face_control::{Emotion, FaceControl};
use articula_core::loa::MAX_LEVEL;
use articula_core::source;
use articula_core::{Articulation, JointSet, Region};
use articula_flat::{Appearance, Picture};
use articula_formats::Assumption;
use extent::Measure;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Contents of a character file.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// Name of the file, as in errors.
    pub file: String,
    /// Name of the format.
    pub format: &'static str,
    /// Name of the character.
    pub name: String,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// Bytes of the parts of a glTF file; null unless they were asked for ([`BytesByKind::of_glb`]).
    pub parts: Option<BytesByKind>,
    /// What an optimised file would save; null unless it was asked for ([`optimize`](crate::optimize::optimize)).
    pub optimized: Option<OptimizeReport>,
    /// Connected groups of skin joints.
    pub skeletons: Vec<SkeletonInspection>,
    /// The clips.
    pub clips: Vec<ClipInspection>,
    /// The meshes.
    pub meshes: Vec<MeshInspection>,
    /// Mesh levels of all meshes together; null if the file has none.
    pub mesh_levels: Option<MeshLevelsInspection>,
    /// Joint levels; null unless they were asked for ([`joint_levels()`]).
    pub joint_levels: Option<JointLevelsInspection>,
    /// Access units; null for files that are no stream of a motion
    /// ([`inspect_access_units`]).
    pub stream: Option<AccessUnitsInspection>,
    /// Tracks of an MP4 file; left out of others.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tracks: Vec<TrackInspection>,
    /// Number of materials.
    pub materials: usize,
    /// Number of pictures.
    pub images: usize,
    /// Face animation data.
    pub face: Option<FaceInspection>,
    /// Feature points; null unless they were asked for ([`face_layout`](crate::face::face_layout)).
    pub face_layout: Option<FaceLayout>,
    /// Height of the skinned rest pose, in metres.
    pub height_m: Option<f32>,
    /// Bounding box of the skinned rest pose.
    pub bounds: Option<Extent>,
    /// Whether boxes are around joints because there is no mesh.
    pub bounds_of_joints: bool,
    /// Whether the file stores levels and regions of its joints.
    pub articulation_stored: bool,
    /// Humanoid data.
    #[serde(flatten)]
    pub human: HumanoidInspection,
    /// All joints and nodes.
    pub map: Vec<JointInspection>,
    /// Files that were written.
    pub written: Vec<String>,
    /// Warnings.
    pub warnings: Vec<WarningInspection>,
}

/// A connected group of skin joints.
#[derive(Debug, Serialize)]
pub struct SkeletonInspection {
    /// Name of its first joint.
    pub root: String,
    /// Number of distinct skin joints.
    pub joints: usize,
    /// Number of joints mapped to H-Anim.
    pub mapped: usize,
    /// Number of joints up to level of articulation 0, 1, 2, 3, 4 and 5.
    pub levels: Vec<usize>,
    /// Number of joints by body region.
    pub regions: BTreeMap<String, usize>,
    /// Name of the matching joint map; empty if none matches.
    pub profile: String,
    /// H-Anim joints up to level 2 that are missing.
    pub missing: Vec<&'static str>,
    /// Joints without an H-Anim mapping.
    pub unmapped: Vec<Unmapped>,
    /// Mapped joints that may be other joints than the mapping says.
    pub doubtful: Vec<DoubtfulJoint>,
}

/// A mapped joint with a reason to doubt its mapping.
#[derive(Debug, Serialize)]
pub struct DoubtfulJoint {
    /// Name of the joint.
    pub joint: String,
    /// H-Anim joint that it is mapped to.
    pub hanim: String,
    /// Confidence: `low`, `medium` or `high`.
    pub confidence: &'static str,
    /// The reason.
    pub why: &'static str,
}

/// A joint without an H-Anim mapping.
#[derive(Debug, Serialize)]
pub struct Unmapped {
    /// Name of the joint.
    pub joint: String,
    /// Reason why it has none.
    pub why: &'static str,
}

/// A joint or node.
#[derive(Debug, Serialize)]
pub struct JointInspection {
    /// Name of the joint.
    pub name: String,
    /// Index of the parent joint.
    pub parent: Option<usize>,
    /// Whether a skin uses it.
    pub in_skin: bool,
    /// H-Anim name.
    pub hanim: Option<String>,
    /// What told the H-Anim joint: `file map`, `joint map`, `words`, `words and tree`, `shape` or
    /// `tree`; null if it has none, or if it is stored in the file.
    pub told_by: Option<&'static str>,
    /// Confidence in the H-Anim joint, `low`, `medium` or `high`; null as `told_by`.
    pub confidence: Option<&'static str>,
    /// H-Anim level of articulation.
    pub level: u8,
    /// Body region.
    pub region: String,
}

/// An animation clip.
#[derive(Debug, Serialize)]
pub struct ClipInspection {
    /// Name of the clip.
    pub name: String,
    /// Duration, in seconds.
    pub duration_secs: f32,
    /// Key rate of the source, in frames per second.
    pub fps: f32,
    /// Number of frames at that rate.
    pub frames: usize,
    /// Rate of the clip that is played and streamed, in frames per second; `None` if the file has more
    /// joints than can be played.
    pub rate_hz: Option<f32>,
    /// Greatest displacement of the skin of that clip from the keys of the file in millimetres; of
    /// joints where there is no mesh.
    pub resampling_mm: Option<f64>,
    /// Number of joints of the skeletons that move; of all nodes if there is no skeleton.
    pub joints_animated: usize,
    /// Number of these joints with keys, moving or not.
    pub joints_keyed: usize,
    /// Number of morph targets that move.
    pub morphs_animated: usize,
    /// Number of expressions that it drives.
    pub expressions_keyed: usize,
    /// Number of keys in all channels.
    pub keys: usize,
    /// Bounding box of the skin over the clip.
    pub bounds: Option<Extent>,
    /// Sizes of the stored motion tables; null if meshes were removed.
    pub motion_tables: Option<StoredTables>,
}

/// A mesh.
#[derive(Debug, Serialize)]
pub struct MeshInspection {
    /// Name of the mesh.
    pub name: String,
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Maximum number of influences per vertex.
    pub influences_max: usize,
    /// Number of morph targets.
    pub morph_targets: usize,
    /// Minimum screen coverage for which it is intended, as stored in the file.
    pub screen_coverage: Option<f32>,
    /// Coarser levels stored in the file, finest first.
    pub levels: Vec<CoarserMesh>,
}

/// Face animation data.
#[derive(Debug, Serialize)]
pub struct FaceInspection {
    /// Number of MPEG-4 facial animation parameters with a table.
    pub faps: usize,
    /// Number of morph targets; those of the same name in several meshes count once.
    pub morphs: usize,
    /// What morph targets and expressions show by their names; null if nothing is known.
    pub driven_by: Option<FaceDrives>,
}

/// What a face can be driven by.
#[derive(Debug, Serialize)]
pub struct FaceDrives {
    /// Number of the 52 blend shapes of ARKit that are shown, at least in part.
    pub arkit_shapes: usize,
    /// Number of the 15 visemes.
    pub visemes: usize,
    /// Names of the emotions of VRM.
    pub emotions: Vec<&'static str>,
    /// Number of the 68 facial animation parameters that are shown through them.
    pub faps: usize,
    /// Names and meanings that a person should check.
    pub unsure: Vec<(String, String)>,
}

impl FaceDrives {
    fn of(character: &source::Character) -> Option<Self> {
        let named = named_controls(character);
        let name = |target: &NamedTarget| match target.expression {
            Some(expression) => character.expressions[expression].name.clone(),
            None => {
                let (mesh, slot) = target.morphs[0];
                character.meshes[mesh].morph_names[slot].clone()
            }
        };
        let mut shapes = BTreeSet::new();
        let (mut visemes, mut emotions) = (BTreeSet::new(), BTreeSet::new());
        for target in &named {
            match target.control {
                FaceControl::Shapes(set, _) => shapes.extend(set.iter()),
                FaceControl::Viseme(viseme) => _ = visemes.insert(viseme),
                FaceControl::Emotion(emotion) => _ = emotions.insert(emotion),
            }
        }
        let unsure = named
            .iter()
            .filter(|n| n.confidence == MappingConfidence::Low);
        let found = Self {
            arkit_shapes: shapes.len(),
            visemes: visemes.len(),
            emotions: emotions.into_iter().map(Emotion::name).collect(),
            faps: driven_faps(character),
            unsure: unsure.map(|n| (name(n), n.control.to_string())).collect(),
        };
        (!named.is_empty()).then_some(found)
    }
}

/// A warning about a file.
#[derive(Debug, Serialize)]
pub struct WarningInspection {
    /// Location, as a path into the file.
    pub at: String,
    /// What was found.
    pub what: String,
}

/// Summarises a character; `clips` are the indices of the clips to measure.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled) only.
pub fn inspect(figure: &Figure, clips: &[usize], work: &Executor<'_>) -> Result<Inspection> {
    let (opened, asset) = (&figure.opened, &figure.asset);
    let character = opened.character();
    const WHAT: &str = "measuring clips";
    work.step(WHAT, 0, clips.len())?;
    let mut measure = Measure::new(asset);
    let bounds = measure.rest();
    let mut measured = Vec::with_capacity(clips.len());
    for clip in clips {
        let bounds = measure.clip(*clip);
        measured.push(clip_of(&character.clips[*clip], figure, *clip, bounds));
        work.step(WHAT, measured.len(), clips.len())?;
    }
    let mut findings = Inspection {
        file: opened.name().to_owned(),
        format: opened.format().name(),
        name: character.name.clone(),
        bytes: opened.bytes(),
        parts: None,
        optimized: None,
        skeletons: skeletons_of(figure),
        clips: measured,
        meshes: character.meshes.iter().map(mesh_of).collect(),
        joint_levels: None,
        stream: None,
        tracks: Vec::new(),
        face_layout: None,
        mesh_levels: {
            let table = character.mesh_levels.as_ref();
            table.map(|table| mesh_levels::of(table, &character.meshes))
        },
        materials: character.materials.len(),
        images: character.images.len(),
        face: face_of(character),
        height_m: bounds.map(|b| b.size().y),
        bounds,
        bounds_of_joints: asset.mesh.is_empty(),
        articulation_stored: character.articulation.is_some(),
        human: human::of(opened),
        map: joints_of(figure),
        written: Vec::new(),
        warnings: warnings_of(figure),
    };
    let odd = oddities(&findings, figure);
    findings.warnings.extend(odd);
    Ok(findings)
}

fn skeletons_of(figure: &Figure) -> Vec<SkeletonInspection> {
    let (rig, mapping) = (&figure.asset.rig, figure.opened.mapping());
    let articulation = rig.articulation();
    let groups = skeletons::of(figure.opened.character(), rig);
    let skeleton = |joints: &JointSet| SkeletonInspection {
        root: joints.iter().next().map_or("", |j| rig.name(j)).to_owned(),
        joints: joints.len(),
        mapped: count(articulation, joints, |j| j.hanim.is_some()),
        levels: (0..=MAX_LEVEL)
            .map(|level| count(articulation, joints, |j| j.level <= level))
            .collect(),
        regions: Region::ALL
            .map(|r| {
                (
                    r.to_string(),
                    count(articulation, joints, |j| j.region == r),
                )
            })
            .into_iter()
            .filter(|(_, n)| *n > 0)
            .collect(),
        profile: articulation.profile.clone(),
        missing: mapping.missing.clone(),
        unmapped: mapping
            .gaps
            .iter()
            .filter(|g| joints.contains(g.joint))
            .map(|g| Unmapped {
                joint: g.name.clone(),
                why: why(g.reason),
            })
            .collect(),
        doubtful: doubtful(figure, joints),
    };
    groups.iter().map(skeleton).collect()
}

/// The doubts about joints; none about joints that the file stores.
fn doubtful(figure: &Figure, joints: &JointSet) -> Vec<DoubtfulJoint> {
    let mapping = figure.opened.mapping();
    if figure.opened.character().articulation.is_some() {
        return Vec::new();
    }
    let own = mapping.doubts.iter().filter(|d| joints.contains(d.joint));
    let doubt = |doubt: &JointDoubt| {
        let hanim = &mapping.articulation.joints[doubt.joint].hanim;
        Some(DoubtfulJoint {
            joint: figure.asset.rig.name(doubt.joint).to_owned(),
            hanim: hanim.clone()?,
            confidence: confidence_name(mapping.confidence(doubt.joint)?),
            why: match doubt.reason {
                DoubtReason::UnknownName => "unknown name; found by its place in the tree",
                DoubtReason::CrossedName => "its name says the other side; it goes with its limb",
                DoubtReason::OtherSide => "it rests on the other side of the body",
                DoubtReason::NotBelow => "it is not below the joint that carries it in a human",
                DoubtReason::UnequalLengths => {
                    "its segment and that of the other side differ in length by more than half"
                }
            },
        })
    };
    own.filter_map(doubt).collect()
}

fn confidence_name(confidence: MappingConfidence) -> &'static str {
    match confidence {
        MappingConfidence::Low => "low",
        MappingConfidence::Medium => "medium",
        MappingConfidence::High => "high",
    }
}

fn told_by(evidence: MappingEvidence) -> &'static str {
    match evidence {
        MappingEvidence::FileMap => "file map",
        MappingEvidence::JointMap => "joint map",
        MappingEvidence::Words => "words",
        MappingEvidence::WordsAndTree => "words and tree",
        MappingEvidence::Shape => "shape",
        MappingEvidence::Tree => "tree",
    }
}

fn count(
    articulation: &Articulation,
    joints: &JointSet,
    is: impl Fn(&articula_core::JointArticulation) -> bool,
) -> usize {
    joints
        .iter()
        .filter(|j| is(&articulation.joints[*j]))
        .count()
}

fn why(reason: UnmappedReason) -> &'static str {
    match reason {
        UnmappedReason::NoEntry => "unknown name",
        UnmappedReason::Duplicate => "another joint has the same meaning",
        UnmappedReason::Helper => "a detail joint of its region",
        UnmappedReason::Ignored => "ignored by the joint map",
    }
}

fn joints_of(figure: &Figure) -> Vec<JointInspection> {
    let (rig, mapping) = (&figure.asset.rig, figure.opened.mapping());
    let is_stored = figure.opened.character().articulation.is_some();
    let told = |joint: usize| {
        mapping
            .evidence
            .get(joint)
            .copied()
            .flatten()
            .filter(|_| !is_stored)
    };
    let articulation = &rig.articulation().joints;
    (0..rig.len())
        .map(|j| JointInspection {
            name: rig.name(j).to_owned(),
            parent: rig.parent(j),
            in_skin: rig.skin_joints().contains(j),
            hanim: articulation[j].hanim.clone(),
            told_by: told(j).map(told_by),
            confidence: told(j)
                .and_then(|_| mapping.confidence(j))
                .map(confidence_name),
            level: articulation[j].level,
            region: articulation[j].region.to_string(),
        })
        .collect()
}

fn clip_of(
    source: &source::RawClip,
    figure: &Figure,
    index: usize,
    bounds: Option<Extent>,
) -> ClipInspection {
    let built = &figure.asset.clips[index];
    let mut moving = BTreeSet::new();
    moving.extend(moving_targets(&built.tracks().rotations));
    moving.extend(moving_targets(&built.tracks().translations));
    moving.extend(moving_targets(&built.tracks().scales));
    let joint_channels = || {
        let channels = source.channels.iter();
        channels.filter(|c| c.property.is_of_joint())
    };
    let keyed: BTreeSet<usize> = joint_channels().map(|c| c.target).collect();
    let listed = figure.asset.rig.skin_joints();
    let is_listed = |joint: usize| listed.is_empty() || listed.contains(joint);
    let fps = source_rate_hz(source);
    let resampling = figure.resampling_of(index);
    ClipInspection {
        name: source.name.clone(),
        duration_secs: source.duration_secs,
        fps,
        frames: (source.duration_secs * fps).round() as usize + 1,
        rate_hz: Some(built.rate_hz()),
        resampling_mm: Some(resampling.resampling_mm),
        joints_animated: moving
            .iter()
            .filter(|j| is_listed(usize::from(**j)))
            .count(),
        joints_keyed: keyed.iter().filter(|j| is_listed(**j)).count(),
        morphs_animated: moving_targets(&built.tracks().morphs).count(),
        expressions_keyed: source
            .channels
            .iter()
            .filter(|c| c.property == source::Property::Expression)
            .count(),
        keys: source.channels.iter().map(|c| c.times_secs.len()).sum(),
        bounds,
        motion_tables: None,
    }
}

fn moving_targets<T>(tracks: &[articula_core::Track<T>]) -> impl Iterator<Item = u16> {
    tracks
        .iter()
        .filter(|t| t.values.len() > 1)
        .map(|t| t.target)
}

fn mesh_of(mesh: &source::RawMesh) -> MeshInspection {
    let most = |p: &source::Primitive| {
        let vertices = p.weights.chunks(p.influences.max(1));
        vertices
            .map(|v| v.iter().filter(|w| **w > 0.0).count())
            .max()
    };
    let vertices = |parts: &[source::Primitive]| parts.iter().map(|p| p.positions.len()).sum();
    let triangles = |parts: &[source::Primitive]| parts.iter().map(|p| p.triangles.len()).sum();
    MeshInspection {
        name: mesh.name.clone(),
        vertices: vertices(&mesh.primitives),
        triangles: triangles(&mesh.primitives),
        influences_max: mesh.primitives.iter().filter_map(most).max().unwrap_or(0),
        morph_targets: mesh.morph_weights.len(),
        screen_coverage: mesh.screen_coverage,
        levels: mesh_levels::of_mesh(mesh),
    }
}

fn face_of(character: &source::Character) -> Option<FaceInspection> {
    let mut names = BTreeSet::new();
    let mut unnamed = 0;
    for mesh in &character.meshes {
        for slot in 0..mesh.morph_weights.len() {
            match mesh.morph_names.get(slot).filter(|n| !n.is_empty()) {
                Some(name) => {
                    names.insert(name.as_str());
                }
                None => unnamed += 1,
            }
        }
    }
    let morphs = names.len() + unnamed;
    let driven_by = FaceDrives::of(character);
    (morphs > 0 || driven_by.is_some()).then_some(FaceInspection {
        faps: 0,
        morphs,
        driven_by,
    })
}

fn warnings_of(figure: &Figure) -> Vec<WarningInspection> {
    let character = figure.opened.character();
    let read = figure.opened.warnings().iter().map(|w| WarningInspection {
        at: w.at.clone(),
        what: w.what.clone(),
    });
    let (_, broken) = Appearance::new(&character.materials, &character.images);
    // The reader has warned of those of an unknown format.
    let is_known = |image: usize| Picture::is_known_format(&character.images[image].bytes);
    let broken = broken.into_iter().filter(|fault| is_known(fault.image));
    let pictures = broken.map(|fault| WarningInspection {
        at: format!("images[{}]", fault.image),
        what: format!("the surface is shown in its plain colour: {}", fault.what),
    });
    read.chain(pictures).collect()
}

/// Warnings about the character as a whole, in addition to those of the reader.
fn oddities(found: &Inspection, figure: &Figure) -> Vec<WarningInspection> {
    let mut odd = Vec::new();
    let mut say = |at: &str, what: String| {
        odd.push(WarningInspection {
            at: at.into(),
            what,
        });
    };
    if found.skeletons.is_empty() {
        say("skeletons", "the file has no joint".into());
    }
    for skeleton in &found.skeletons {
        if skeleton.mapped == 0 && skeleton.joints > 1 {
            let what = format!(
                "none of the {} joint names below \"{}\" is known; the levels follow the depth in \
                 the hierarchy (give a joint map)",
                skeleton.joints, skeleton.root
            );
            say("skeletons", what);
        }
    }
    for clip in &found.clips {
        let resampling = clip.resampling_mm.map(|resampling_mm| ClipResampling {
            clip: clip.name.clone(),
            rate_hz: clip.rate_hz,
            resampling_mm,
            told_mm: told_mm(&figure.opened.character().skeleton),
        });
        if let Some(what) = resampling.and_then(|clip| clip.warning()) {
            say("clips", what);
        }
    }
    let mut told = figure.opened.warnings().iter();
    let is_told = told.any(|w| w.guess == Some(Assumption::Unit));
    let unusual = found.height_m.filter(|h| *h > 10.0 || *h < 0.1);
    if let Some(height) = unusual.filter(|_| !is_told) {
        let shown = match height {
            0.001..1e6 => format!("{height:.3}"),
            _ => format!("{height:e}"),
        };
        let what = format!("{shown} m high: not the size of a human; check the unit of the file");
        say("bounds", what);
    }
    if found.bounds.is_none() {
        say(
            "bounds",
            "the skinned rest pose is not finite or empty".into(),
        );
    }
    odd
}
