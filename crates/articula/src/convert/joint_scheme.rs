//! Conversion of a character to a joint scheme, with the document that it came from.

use crate::error::{Context, Result};
use crate::open::{CharacterFile, GltfSource};
use articula_build::JointScheme;
use articula_build::joint_names::{JointMapping, MappingEvidence};
use articula_build::{JointEdit, set_joint_scheme};
use articula_core::hanim_table::named;
use articula_core::{Articulation, JointArticulation};
use articula_formats::gltf::{NewJoint, OldJoint, PreparedState};
use glam::Vec3;
use serde::{Serialize, Serializer};

/// Joints that a conversion to a joint scheme removed and inserted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointSchemeReport {
    /// The scheme.
    #[serde(serialize_with = "scheme_name")]
    pub scheme: JointScheme,
    /// Joints that were removed.
    pub merged: Vec<JointMerged>,
    /// Joints that were inserted.
    pub inserted: Vec<JointInserted>,
    /// Number of joints now.
    pub joints: usize,
    /// Maximum distance in metres of a kept joint from where it was, at the keys of all clips and
    /// halfway between them.
    pub joints_m: f32,
    /// The same of a vertex of the finest meshes.
    pub skin_m: f32,
    /// Whether data was removed that `prepare` had computed for the joints before.
    pub drops_prepared: bool,
    /// New index of every joint that there was; `None` for those removed.
    #[serde(skip)]
    pub new_index: Vec<Option<usize>>,
}

/// A joint that was removed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct JointMerged {
    /// Its name in the file.
    pub joint: String,
    /// Name of the joint that took its rotation and its skin.
    pub into: String,
}

/// A joint that was inserted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct JointInserted {
    /// Its name, an H-Anim name.
    pub joint: String,
    /// Name of its parent.
    pub parent: String,
    /// Name of its child.
    pub child: String,
}

impl CharacterFile {
    /// Converts the character, its clips and the document behind it to a joint scheme. A rig that
    /// has no joint of the other scheme and no place for one of this scheme stays as it is.
    ///
    /// The articulation becomes part of the character, so that files that can store it do.
    ///
    /// # Errors
    /// An [`Error`](crate::Error) that names the file, if a joint that is involved has a scale that
    /// differs along its axes, an expression moves a joint that would be removed, or the document is
    /// inconsistent; the file is then unchanged.
    pub fn set_joint_scheme(&mut self, scheme: JointScheme) -> Result<JointSchemeReport> {
        let place = self.name().to_owned();
        let mut character = self.character().clone();
        let mut articulation = self.articulation();
        let mut ends = self.end_sites().to_vec();
        let change = set_joint_scheme(&mut character, &mut articulation, &mut ends, scheme);
        let change = change.with_context(|| &place)?;
        let mut report = JointSchemeReport {
            scheme,
            merged: Vec::new(),
            inserted: Vec::new(),
            joints: articulation.joints.len(),
            joints_m: change.joints_metres,
            skin_m: change.skin_metres,
            drops_prepared: false,
            new_index: (0..self.character().skeleton.joints.len())
                .map(Some)
                .collect(),
        };
        if change.edits.is_empty() {
            return Ok(report);
        }
        let mut gltf = self.gltf().cloned();
        for edit in &change.edits {
            if let Some(gltf) = &mut gltf {
                edit_document(gltf, edit).with_context(|| &place)?;
            }
        }
        if let Some(gltf) = &mut gltf {
            report.drops_prepared = finish_document(gltf, &articulation).with_context(|| &place)?;
        }
        let mut mapping = self.mapping().clone();
        for edit in &change.edits {
            edit_mapping(&mut mapping, edit);
            let indices = report.new_index.iter_mut();
            indices.for_each(|index| *index = index.and_then(|joint| renumbered(joint, edit)));
            match edit {
                JointEdit::Merged(merged) => report.merged.push(JointMerged {
                    joint: merged.name.clone(),
                    into: merged.into_name.clone(),
                }),
                JointEdit::Inserted(inserted) => report.inserted.push(JointInserted {
                    joint: inserted.name.clone(),
                    parent: inserted.parent_name.clone(),
                    child: inserted.child_name.clone(),
                }),
            }
        }
        character.articulation = Some(articulation);
        self.set_joints(character, mapping, ends, gltf);
        Ok(report)
    }
}

fn edit_document(gltf: &mut GltfSource, edit: &JointEdit) -> Result<()> {
    match edit {
        JointEdit::Inserted(inserted) => {
            let nodes = &mut gltf.node_of_joint;
            let child_rest = (inserted.offset != Vec3::ZERO).then_some(inserted.child_rest);
            let new = gltf.document.insert_joint(&NewJoint {
                name: &inserted.name,
                parent: nodes[inserted.parent],
                child: nodes[inserted.joint],
                offset: inserted.offset,
                child_rest,
            })?;
            nodes.insert(inserted.joint, new);
        }
        JointEdit::Merged(merged) => {
            let nodes = &mut gltf.node_of_joint;
            let children = merged.children.iter();
            gltf.document.remove_joint(&OldJoint {
                node: nodes[merged.joint],
                into: nodes[merged.into],
                rest: merged.rest,
                children: children.map(|(c, rest)| (nodes[*c], *rest)).collect(),
            })?;
            nodes.remove(merged.joint);
        }
    }
    let rigs = gltf.khr_character.iter_mut().flat_map(|khr| &mut khr.rigs);
    let known = rigs.map(|rig| &mut rig.joints).chain(&mut gltf.humanoid);
    for joints in known {
        joints.retain_mut(|(joint, _)| {
            let new = renumbered(*joint, edit);
            *joint = new.unwrap_or(*joint);
            new.is_some()
        });
    }
    Ok(())
}

/// Stores the articulation and removes what was computed for other joints; returns whether anything
/// was.
fn finish_document(gltf: &mut GltfSource, articulation: &Articulation) -> Result<bool> {
    let drops = gltf.document.prepared() != PreparedState::Absent;
    gltf.document.remove_prepared();
    gltf.document.remove_motion_tables();
    gltf.kept_meshes = None;
    let nodes = &gltf.node_of_joint;
    gltf.document.set_articulation(articulation, nodes)?;
    Ok(drops)
}

/// Index of a joint after an edit; `None` if it was removed.
fn renumbered(joint: usize, edit: &JointEdit) -> Option<usize> {
    match edit {
        JointEdit::Inserted(inserted) => Some(joint + usize::from(joint >= inserted.joint)),
        JointEdit::Merged(merged) if joint == merged.joint => None,
        JointEdit::Merged(merged) => Some(joint - usize::from(joint > merged.joint)),
    }
}

fn edit_mapping(mapping: &mut JointMapping, edit: &JointEdit) {
    let moved = |joint: &mut usize| {
        let new = renumbered(*joint, edit);
        *joint = new.unwrap_or(*joint);
        new.is_some()
    };
    mapping.gaps.retain_mut(|gap| moved(&mut gap.joint));
    mapping.crossed.retain_mut(moved);
    mapping.doubts.retain_mut(|doubt| moved(&mut doubt.joint));
    let joints = &mut mapping.articulation.joints;
    match edit {
        JointEdit::Inserted(inserted) => {
            let Some(row) = named(&inserted.name) else {
                return;
            };
            let entry = JointArticulation {
                hanim: Some(row.name.to_owned()),
                level: row.level,
                region: row.region,
            };
            joints.insert(inserted.joint, entry);
            let told = Some(MappingEvidence::JointMap);
            mapping.evidence.insert(inserted.joint, told);
        }
        JointEdit::Merged(merged) => {
            joints.remove(merged.joint);
            mapping.evidence.remove(merged.joint);
        }
    }
}

fn scheme_name<S: Serializer>(scheme: &JointScheme, to: S) -> std::result::Result<S::Ok, S::Error> {
    to.collect_str(scheme)
}
