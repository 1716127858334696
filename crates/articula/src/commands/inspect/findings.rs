//! What `inspect` reports. The field names are a promise to scripts (`docs/commands.md`).

use super::extent::{Extent, Measure};
use super::human::{self, Human};
use super::mesh_levels::{self, Levels, MeshLevel};
use super::skeletons;
use crate::console::Console;
use crate::load;
use crate::motion_tables::Stored;
use crate::prepared::Prepared;
use articula_build::joint_names::GapReason;
use articula_build::source_rate_hz;
use articula_core::loa::MAX_LEVEL;
use articula_core::source;
use articula_core::{Articulation, JointSet, Region, Rig};
use articula_flat::Appearance;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Everything that was found in one file.
#[derive(Debug, Serialize)]
pub(super) struct Findings {
    pub(super) file: String,
    pub(super) format: &'static str,
    pub(super) name: String,
    pub(super) bytes: usize,
    pub(super) skeletons: Vec<Skeleton>,
    pub(super) clips: Vec<Clip>,
    pub(super) meshes: Vec<Mesh>,
    /// Levels of all meshes together; null if the file stores none.
    pub(super) mesh_levels: Option<Levels>,
    pub(super) materials: usize,
    pub(super) images: usize,
    pub(super) face: Option<Face>,
    /// Height of the skinned rest pose, metres.
    pub(super) height_m: Option<f32>,
    /// Box around the skinned rest pose.
    pub(super) bounds: Option<Extent>,
    /// Whether the boxes are around joints, because there is no mesh.
    pub(super) bounds_of_joints: bool,
    /// Whether the file stores levels and regions of its own.
    pub(super) articulation_stored: bool,
    #[serde(flatten)]
    pub(super) human: Human,
    pub(super) map: Vec<Joint>,
    pub(super) warnings: Vec<Warning>,
}

/// One group of joints that belong together.
#[derive(Debug, Serialize)]
pub(super) struct Skeleton {
    pub(super) root: String,
    /// Distinct joints of its skins.
    pub(super) joints: usize,
    /// How many of them are mapped to H-Anim.
    pub(super) mapped: usize,
    /// Joints up to level of articulation 0, 1, 2, 3, 4 and 5.
    pub(super) levels: Vec<usize>,
    pub(super) regions: BTreeMap<&'static str, usize>,
    pub(super) profile: String,
    /// Joints of the standard up to level 2 that are not there.
    pub(super) missing: Vec<&'static str>,
    pub(super) unmapped: Vec<Unmapped>,
}

/// A joint without a twin in the standard.
#[derive(Debug, Serialize)]
pub(super) struct Unmapped {
    pub(super) joint: String,
    pub(super) why: &'static str,
}

/// One joint or node.
#[derive(Debug, Serialize)]
pub(super) struct Joint {
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    pub(super) in_skin: bool,
    pub(super) hanim: Option<String>,
    pub(super) level: u8,
    pub(super) region: &'static str,
}

/// One motion.
#[derive(Debug, Serialize)]
pub(super) struct Clip {
    pub(super) name: String,
    pub(super) duration_secs: f32,
    /// Rate at which the source is keyed.
    pub(super) fps: f32,
    /// Frames of the source, at its rate.
    pub(super) frames: usize,
    /// Joints that move.
    pub(super) joints_animated: usize,
    /// Joints that have keys, moving or not.
    pub(super) joints_keyed: usize,
    pub(super) morphs_animated: usize,
    /// Expressions that it drives.
    pub(super) expressions_keyed: usize,
    pub(super) keys: usize,
    pub(super) bounds: Option<Extent>,
    /// Bytes of the motion tables that the file has for it; null where meshes are left out.
    pub(super) motion_tables: Option<Stored>,
}

/// One mesh.
#[derive(Debug, Serialize)]
pub(super) struct Mesh {
    pub(super) name: String,
    pub(super) vertices: usize,
    pub(super) triangles: usize,
    pub(super) influences_max: usize,
    pub(super) morph_targets: usize,
    /// Least share of the screen that it is made for, as the file says.
    pub(super) screen_coverage: Option<f32>,
    /// Coarser forms that the file brings, the finest first.
    pub(super) levels: Vec<MeshLevel>,
}

/// What there is to animate a face with.
#[derive(Debug, Serialize)]
pub(super) struct Face {
    /// Facial animation parameters with a table.
    pub(super) faps: usize,
    /// Morph targets, counted once where meshes share a name.
    pub(super) morphs: usize,
}

/// Something odd.
#[derive(Debug, Serialize)]
pub(super) struct Warning {
    pub(super) at: String,
    pub(super) what: String,
}

/// Looks at a character; `clips` are the ones to measure.
pub(super) fn of(prepared: &Prepared, clips: &[usize], console: &Console) -> Findings {
    let (loaded, asset) = (&prepared.loaded, &prepared.asset);
    let character = &loaded.character;
    let bar = console.progress("measuring clips", clips.len());
    let mut measure = Measure::new(asset);
    let bounds = measure.rest();
    let clip = |c: &usize| {
        bar.inc(1);
        clip_of(&character.clips[*c], prepared, *c, measure.clip(*c))
    };
    let clips: Vec<Clip> = clips.iter().map(clip).collect();
    bar.finish_and_clear();
    let mut findings = Findings {
        file: loaded.place(),
        format: loaded.format.name(),
        name: character.name.clone(),
        bytes: loaded.bytes,
        skeletons: skeletons_of(prepared),
        clips,
        meshes: character.meshes.iter().map(mesh_of).collect(),
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
        human: human::of(loaded),
        map: joints_of(&asset.rig),
        warnings: warnings_of(prepared),
    };
    let odd = oddities(&findings);
    findings.warnings.extend(odd);
    findings
}

fn skeletons_of(prepared: &Prepared) -> Vec<Skeleton> {
    let (rig, mapping) = (&prepared.asset.rig, &prepared.loaded.mapping);
    let articulation = rig.articulation();
    let groups = skeletons::of(&prepared.loaded.character, rig);
    let skeleton = |joints: &JointSet| Skeleton {
        root: joints.iter().next().map_or("", |j| rig.name(j)).to_owned(),
        joints: joints.len(),
        mapped: count(articulation, joints, |j| j.hanim.is_some()),
        levels: (0..=MAX_LEVEL)
            .map(|level| count(articulation, joints, |j| j.level <= level))
            .collect(),
        regions: Region::ALL
            .map(|r| (r.name(), count(articulation, joints, |j| j.region == r)))
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
    };
    groups.iter().map(skeleton).collect()
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

fn why(reason: GapReason) -> &'static str {
    match reason {
        GapReason::NoEntry => "unknown name",
        GapReason::Duplicate => "another joint stands for the same",
        GapReason::Helper => "a detail of its region",
        GapReason::Ignored => "left out by the profile",
    }
}

fn joints_of(rig: &Rig) -> Vec<Joint> {
    let articulation = &rig.articulation().joints;
    (0..rig.len())
        .map(|j| Joint {
            name: rig.name(j).to_owned(),
            parent: rig.parent(j),
            in_skin: rig.skin_joints().contains(j),
            hanim: articulation[j].hanim.clone(),
            level: articulation[j].level,
            region: articulation[j].region.name(),
        })
        .collect()
}

fn clip_of(
    source: &source::Clip,
    prepared: &Prepared,
    index: usize,
    bounds: Option<Extent>,
) -> Clip {
    let built = &prepared.asset.clips[index];
    let mut moving = BTreeSet::new();
    moving.extend(moving_targets(built.rotations()));
    moving.extend(moving_targets(built.translations()));
    moving.extend(moving_targets(built.scales()));
    let joint_channels = || {
        let channels = source.channels.iter();
        channels.filter(|c| c.property.is_of_joint())
    };
    let keyed: BTreeSet<usize> = joint_channels().map(|c| c.target).collect();
    let fps = source_rate_hz(source);
    Clip {
        name: source.name.clone(),
        duration_secs: source.duration_secs,
        fps,
        frames: (source.duration_secs * fps).round() as usize + 1,
        joints_animated: moving.len(),
        joints_keyed: keyed.len(),
        morphs_animated: moving_targets(built.morphs()).count(),
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

fn mesh_of(mesh: &source::Mesh) -> Mesh {
    let most = |p: &source::Primitive| {
        let vertices = p.weights.chunks(p.influences.max(1));
        vertices
            .map(|v| v.iter().filter(|w| **w > 0.0).count())
            .max()
    };
    let vertices = |parts: &[source::Primitive]| parts.iter().map(|p| p.positions.len()).sum();
    let triangles = |parts: &[source::Primitive]| parts.iter().map(|p| p.triangles.len()).sum();
    Mesh {
        name: mesh.name.clone(),
        vertices: vertices(&mesh.primitives),
        triangles: triangles(&mesh.primitives),
        influences_max: mesh.primitives.iter().filter_map(most).max().unwrap_or(0),
        morph_targets: mesh.morph_weights.len(),
        screen_coverage: mesh.screen_coverage,
        levels: mesh_levels::of_mesh(mesh),
    }
}

fn face_of(character: &source::Character) -> Option<Face> {
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
    (morphs > 0).then_some(Face { faps: 0, morphs })
}

fn warnings_of(prepared: &Prepared) -> Vec<Warning> {
    let character = &prepared.loaded.character;
    let read = prepared.loaded.warnings.iter().map(|w| Warning {
        at: w.at.clone(),
        what: load::advised(w),
    });
    let (_, broken) = Appearance::new(&character.materials, &character.images);
    let pictures = broken.into_iter().map(|fault| Warning {
        at: format!("images[{}]", fault.image),
        what: format!("its surface is shown in plain colour: {}", fault.what),
    });
    read.chain(pictures).collect()
}

/// What is odd about the whole, beside what the reader noticed.
fn oddities(found: &Findings) -> Vec<Warning> {
    let mut odd = Vec::new();
    let mut say = |at: &str, what: String| {
        odd.push(Warning {
            at: at.into(),
            what,
        });
    };
    if found.skeletons.is_empty() {
        say(
            "skeletons",
            "no joint: there is nothing to articulate".into(),
        );
    }
    for skeleton in &found.skeletons {
        if skeleton.mapped == 0 && skeleton.joints > 1 {
            let what = format!(
                "none of the {} joint names below \"{}\" is known; levels follow tree depth (--profile takes a map of your own)",
                skeleton.joints, skeleton.root
            );
            say("skeletons", what);
        }
    }
    if let Some(height) = found.height_m.filter(|h| *h > 10.0 || *h < 0.1) {
        let shown = match height {
            0.001..1e6 => format!("{height:.3}"),
            _ => format!("{height:e}"),
        };
        let what = format!("{shown} m high: no human size, check the unit of the file");
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
