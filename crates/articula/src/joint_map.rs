//! The joint map of a rig as it was recognised, written for a person to edit.

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use articula_build::joint_names::{UnmappedReason, map_as_told};
use articula_core::joint_names::{RigScope, folded};
use articula_formats::Limits;
use articula_formats::joint_map::{self, JointMapText};
use std::collections::HashSet;
use std::path::Path;

/// A joint map of one rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RigJointMap {
    /// The map as JSON (`docs/formats/joint-map.md`).
    pub bytes: Vec<u8>,
    /// Number of joints with an H-Anim joint.
    pub joints: usize,
    /// Number of joints without a meaning, listed for editing.
    pub unmapped: usize,
    /// Mapped joints that the map cannot tell, because they have no name or share it with another
    /// joint.
    pub untold: Vec<String>,
}

/// Returns the joint map that gives the joints of a rig the H-Anim joints that they have now.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if names cannot tell the joints.
pub fn rig_joint_map(opened: &CharacterFile) -> Result<RigJointMap> {
    made(opened).with_context(|| opened.name())
}

fn made(opened: &CharacterFile) -> Result<RigJointMap> {
    let skeleton = &opened.character().skeleton;
    let articulation = opened.articulation();
    let hanim = |joint: usize| articulation.joints[joint].hanim.as_deref();
    let mapped = articulation.mapped();
    let mut text = JointMapText {
        name: stem(opened.name()),
        title: format!("Joint map of {}", file_name(opened.name())),
        source: match articulation.profile.as_str() {
            "" => "written by articula inspect; no joint was recognised".to_owned(),
            by => format!("written by articula inspect; recognised by {by}"),
        },
        scope: if opened.mapping().is_hands_alone() {
            RigScope::Hand
        } else {
            RigScope::Body
        },
        ..JointMapText::default()
    };
    let mut used = HashSet::new();
    let mut is_new = |name: &str| {
        let folded = folded(name);
        !folded.is_empty() && used.insert(folded)
    };
    for (joint, own) in skeleton.joints.iter().enumerate() {
        if let Some(hanim) = hanim(joint).filter(|_| is_new(&own.name)) {
            text.joints.push((own.name.clone(), hanim.to_owned()));
        }
    }
    let any_skin = skeleton.joints.iter().any(|j| j.in_skin);
    let is_joint = |joint: usize| skeleton.joints[joint].in_skin || !any_skin;
    for gap in &opened.mapping().gaps {
        if hanim(gap.joint).is_some() || !is_joint(gap.joint) || !is_new(&gap.name) {
            continue;
        }
        let name = gap.name.clone();
        match gap.reason {
            UnmappedReason::Ignored => text.ignored.push(name),
            UnmappedReason::NoEntry | UnmappedReason::Duplicate => text.unmapped.push(name),
            UnmappedReason::Helper => {
                let region = articulation.joints[gap.joint].region;
                match text.helpers.iter_mut().find(|(r, _)| *r == region) {
                    Some((_, names)) => names.push(name),
                    None => text.helpers.push((region, vec![name])),
                }
            }
        }
    }
    let bytes = joint_map::write(&text);
    let map = joint_map::parse(&bytes, &Limits::default())?;
    let again = map_as_told(skeleton, &[map], &[], None).articulation;
    let is_read = !text.joints.is_empty() && again.profile == text.name;
    if mapped > 0 && !is_read || mapped == 0 && text.unmapped.is_empty() {
        let what = "joints: no joint map can tell them, because their names are empty or all \
                    alike; name the joints in the program that made the file";
        return Err(Error::unsuited(what));
    }
    let is_untold =
        |joint: &usize| is_read && again.joints[*joint].hanim.as_deref() != hanim(*joint);
    let untold = (0..skeleton.joints.len()).filter(is_untold);
    let untold: Vec<String> = untold.map(|j| skeleton.joints[j].name.clone()).collect();
    Ok(RigJointMap {
        bytes,
        joints: text.joints.len(),
        unmapped: text.unmapped.len(),
        untold,
    })
}

fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn stem(path: &str) -> String {
    let name = Path::new(path).file_stem().unwrap_or_default();
    name.to_string_lossy().into_owned()
}
