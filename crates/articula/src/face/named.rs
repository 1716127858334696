//! What the morph targets and expressions of a character show by their names.

use crate::error::{Context, Error, Result};
use crate::open::CharacterFile;
use articula_build::face::{FaceCandidate, NamedControl, choose_controls, face_control};
use articula_build::joint_names::MappingConfidence;
use articula_core::face_control::{FaceControl, FaceMap};
use articula_core::source::{Character, Expression};
use articula_formats::face_map;
use std::collections::{BTreeMap, BTreeSet};

/// A control of a face, with what it shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedTarget {
    /// What it shows at weight 1: a blend shape of ARKit or a part of some, a viseme or an emotion.
    pub control: FaceControl,
    /// How sure that is.
    pub confidence: MappingConfidence,
    /// Mesh and morph target of each morph target that shows it: at most one for each mesh.
    pub morphs: Vec<(usize, usize)>,
    /// Index of the expression that shows it; the file's own binding, which drives morph targets
    /// whatever they are called.
    pub expression: Option<usize>,
}

/// Returns what the face of a character can be driven by directly, without its parameters: the controls
/// among its expressions and morph targets whose names are known (`docs/formats/face-map.md`), or were
/// told by a face map. No two morph targets of a mesh show the same, so that all can be driven
/// together; an expression is listed apart from the morph targets, and drives some of them.
///
/// ```
/// use articula::core::face_control::FaceControl;
/// use articula::core::source::{Character, RawMesh};
/// use articula::core::viseme::Viseme;
/// use articula::face::named_controls;
///
/// let head = RawMesh {
///     morph_names: ["jawOpen", "mouthOpen", "vrc.v_pp"].map(str::to_owned).to_vec(),
///     morph_weights: vec![0.0; 3],
///     ..RawMesh::default()
/// };
/// let head = Character { meshes: vec![head], ..Character::default() };
/// let named = named_controls(&head);
/// let lips = named.iter().find(|n| n.control == FaceControl::Viseme(Viseme::Pp)).unwrap();
/// assert_eq!(lips.morphs, [(0, 2)]);
/// // Both open the jaw; the name of ARKit is the surer one.
/// assert_eq!(named.len(), 2);
/// ```
pub fn named_controls(character: &Character) -> Vec<NamedTarget> {
    let mut morphs = Vec::new();
    for (mesh, raw) in character.meshes.iter().enumerate() {
        for (slot, name) in raw.morph_names.iter().enumerate() {
            let candidate = |named| FaceCandidate {
                place: (mesh, slot),
                group: mesh,
                named,
            };
            morphs.extend(control_of(character, name).map(candidate));
        }
    }
    let moves = |e: &Expression| !e.morphs.is_empty() || !e.joints.is_empty();
    let all = character.expressions.iter().enumerate();
    let expressions: Vec<FaceCandidate<usize>> = all
        .filter(|(_, e)| moves(e))
        .filter_map(|(place, e)| {
            Some(FaceCandidate {
                place,
                group: 0,
                named: control_of(character, &e.name)?,
            })
        })
        .collect();
    let of_expressions = choose_controls(&expressions)
        .into_iter()
        .map(|c| NamedTarget {
            control: c.named.control,
            confidence: c.named.confidence,
            morphs: Vec::new(),
            expression: c.places.first().copied(),
        });
    let of_morphs = choose_controls(&morphs).into_iter().map(|c| NamedTarget {
        control: c.named.control,
        confidence: c.named.confidence,
        morphs: c.places,
        expression: None,
    });
    of_expressions.chain(of_morphs).collect()
}

/// Returns the face map of a character as JSON (`docs/formats/face-map.md`), for a person to edit: what
/// its expressions and morph targets show now, and the names without a meaning.
///
/// # Errors
/// [`Error::Unsupported`] that names the file, if it has no named morph target and no expression.
pub fn rig_face_map(opened: &CharacterFile) -> Result<Vec<u8>> {
    let character = opened.character();
    let morphs = character.meshes.iter().flat_map(|mesh| &mesh.morph_names);
    let names = morphs.chain(character.expressions.iter().map(|e| &e.name));
    let names: BTreeSet<&String> = names.filter(|name| !name.is_empty()).collect();
    if names.is_empty() {
        let what = "face: no morph target or expression has a name, so a face map cannot tell them";
        return Err(Error::unsuited(what)).context(opened.name());
    }
    let mut map = FaceMap {
        name: "face".to_owned(),
        title: format!("Face map of {}", opened.name()),
        source: "written by articula inspect".to_owned(),
        controls: BTreeMap::new(),
    };
    let mut unmapped = Vec::new();
    for name in names {
        match control_of(character, name) {
            Some(named) => _ = map.controls.insert(name.clone(), Some(named.control)),
            None if character.told_controls.contains_key(name) => {
                map.controls.insert(name.clone(), None);
            }
            None => unmapped.push(name.clone()),
        }
    }
    Ok(face_map::write(&map, unmapped))
}

/// What a name means in a character: as a face map told it, else by itself.
pub(super) fn control_of(character: &Character, name: &str) -> Option<NamedControl> {
    match character.told_controls.get(name) {
        Some(told) => told.map(|control| NamedControl {
            control,
            confidence: MappingConfidence::High,
        }),
        None => face_control(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::RawMesh;

    #[test]
    fn what_a_person_told_stands_above_the_name() {
        let names = ["jawOpen", "Key 3", "mouthPucker"].map(str::to_owned);
        let mut head = Character {
            meshes: vec![RawMesh {
                morph_weights: vec![0.0; names.len()],
                morph_names: names.to_vec(),
                ..RawMesh::default()
            }],
            ..Character::default()
        };
        let told = [
            ("Key 3", Some("mouthSmileLeft+mouthSmileRight")),
            ("mouthPucker", None),
        ];
        head.told_controls = told
            .map(|(name, control)| (name.to_owned(), control.map(|c| c.parse().unwrap())))
            .into();
        let shown: Vec<_> = named_controls(&head)
            .into_iter()
            .map(|n| (n.control.to_string(), n.morphs))
            .collect();
        let wanted = [("jawOpen", 0), ("mouthSmileLeft+mouthSmileRight", 1)];
        assert_eq!(
            shown,
            wanted.map(|(c, slot)| (c.to_owned(), vec![(0, slot)]))
        );
    }
}
