//! Contents of a file with more joints than a rig can have: what is listed without posing it.

use super::{
    ClipInspection, Inspection, JointInspection, SkeletonInspection, WarningInspection,
    confidence_name, face_of, human, mesh_levels, mesh_of, told_by,
};
use crate::open::CharacterFile;
use articula_build::source_rate_hz;
use articula_core::MAX_JOINTS;
use articula_core::loa::MAX_LEVEL;
use articula_core::source::{Channel, Property, RawClip};
use std::collections::{BTreeMap, BTreeSet};

/// Returns whether a file has more joints than can be posed.
pub fn has_too_many_joints(opened: &CharacterFile) -> bool {
    opened.character().skeleton.joints.len() > MAX_JOINTS
}

/// Lists the contents of a file without posing it: joints, clips and meshes, without sizes and without
/// the joints that lack a counterpart in H-Anim. All joints count as one skeleton.
pub fn inspect_listed(opened: &CharacterFile) -> Inspection {
    let character = opened.character();
    let count = character.skeleton.joints.len();
    let mut warnings: Vec<WarningInspection> = opened
        .warnings()
        .iter()
        .map(|w| WarningInspection {
            at: w.at.clone(),
            what: w.what.clone(),
        })
        .collect();
    warnings.push(WarningInspection {
        at: "joints".to_owned(),
        what: format!(
            "{count} joints, at most {MAX_JOINTS} can be posed: the contents are listed, but not \
             measured"
        ),
    });
    Inspection {
        file: opened.name().to_owned(),
        format: opened.format().name(),
        name: character.name.clone(),
        bytes: opened.bytes(),
        parts: None,
        optimized: None,
        skeletons: vec![skeleton_of(opened)],
        clips: character.clips.iter().map(clip_of).collect(),
        meshes: character.meshes.iter().map(mesh_of).collect(),
        mesh_levels: character
            .mesh_levels
            .as_ref()
            .map(|table| mesh_levels::of(table, &character.meshes)),
        joint_levels: None,
        stream: None,
        tracks: Vec::new(),
        materials: character.materials.len(),
        images: character.images.len(),
        face: face_of(character),
        face_layout: None,
        height_m: None,
        bounds: None,
        bounds_of_joints: character.meshes.is_empty(),
        articulation_stored: character.articulation.is_some(),
        human: human::of(opened),
        map: joints_of(opened),
        written: Vec::new(),
        warnings,
    }
}

fn skeleton_of(opened: &CharacterFile) -> SkeletonInspection {
    let joints = &opened.character().skeleton.joints;
    let articulation = opened.articulation();
    let up_to = |level: u8| {
        articulation
            .joints
            .iter()
            .filter(|j| j.level <= level)
            .count()
    };
    let mut regions = BTreeMap::new();
    for joint in &articulation.joints {
        *regions.entry(joint.region.to_string()).or_insert(0) += 1;
    }
    SkeletonInspection {
        root: joints.first().map_or_else(String::new, |j| j.name.clone()),
        joints: joints.len(),
        mapped: articulation.mapped(),
        levels: (0..=MAX_LEVEL).map(up_to).collect(),
        regions,
        profile: articulation.profile.clone(),
        missing: opened.mapping().missing.clone(),
        unmapped: Vec::new(),
        doubtful: Vec::new(),
    }
}

fn joints_of(opened: &CharacterFile) -> Vec<JointInspection> {
    let articulation = opened.articulation();
    let mapping = opened.mapping();
    let is_stored = opened.character().articulation.is_some();
    let joints = opened.character().skeleton.joints.iter().enumerate();
    joints
        .zip(&articulation.joints)
        .map(|((index, joint), known)| {
            let told = mapping.evidence.get(index).copied().flatten();
            let told = told.filter(|_| !is_stored);
            let confidence = told.and_then(|_| mapping.confidence(index));
            JointInspection {
                name: joint.name.clone(),
                parent: joint.parent,
                in_skin: joint.in_skin,
                hanim: known.hanim.clone(),
                told_by: told.map(told_by),
                confidence: confidence.map(confidence_name),
                level: known.level,
                region: known.region.to_string(),
            }
        })
        .collect()
}

fn clip_of(clip: &RawClip) -> ClipInspection {
    let targets = |is: &dyn Fn(&Channel) -> bool| -> usize {
        let channels = clip.channels.iter().filter(|c| is(c));
        channels.map(|c| c.target).collect::<BTreeSet<_>>().len()
    };
    let moves = |c: &Channel| {
        let width = c.values.len() / c.times_secs.len().max(1);
        c.values
            .chunks(width.max(1))
            .any(|key| key != &c.values[..width])
    };
    let fps = source_rate_hz(clip);
    ClipInspection {
        name: clip.name.clone(),
        duration_secs: clip.duration_secs,
        fps,
        frames: (clip.duration_secs * fps).round() as usize + 1,
        rate_hz: None,
        resampling_mm: None,
        joints_animated: targets(&|c| c.property.is_of_joint() && moves(c)),
        joints_keyed: targets(&|c| c.property.is_of_joint()),
        morphs_animated: targets(&|c| c.property == Property::Weights && moves(c)),
        expressions_keyed: targets(&|c| c.property == Property::Expression),
        keys: clip.channels.iter().map(|c| c.times_secs.len()).sum(),
        bounds: None,
        motion_tables: None,
    }
}
