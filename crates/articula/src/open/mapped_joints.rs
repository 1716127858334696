//! The mapping of a file's joints to H-Anim, found when it is first asked for.
//!
//! A stored character has its articulation beside it and plays without the mapping, which takes the built-in joint
//! maps: to read these takes longer than all else of opening such a file in a page.

use articula_build::joint_names::{JointMapping, map_as_told};
use articula_core::joint_names::JointMap;
use articula_core::source::Skeleton;
use articula_formats::joint_map;
use std::sync::OnceLock;

/// What joints are mapped to, or what it follows from: the joints as they were when they were mapped, whatever edits
/// come before it is asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct MappedJoints {
    found: OnceLock<JointMapping>,
    skeleton: Skeleton,
    told: Vec<JointMap>,
    given: Option<Vec<(usize, String)>>,
}

impl MappedJoints {
    /// The joints of a file, by joint maps of the caller, by its own map to VRM human bones, or by name.
    pub(super) fn of_file(
        skeleton: &Skeleton,
        told: &[JointMap],
        given: Option<&[(usize, String)]>,
    ) -> Self {
        Self {
            found: OnceLock::new(),
            skeleton: skeleton.clone(),
            told: told.to_vec(),
            given: given.map(<[_]>::to_vec),
        }
    }

    /// Joints by name.
    pub(super) fn by_name(skeleton: &Skeleton) -> Self {
        Self::of_file(skeleton, &[], None)
    }

    /// The mapping; O(joints x joint maps) when it is first asked for.
    pub(super) fn get(&self) -> &JointMapping {
        self.found.get_or_init(|| {
            let (told, given) = (&self.told, self.given.as_deref());
            map_as_told(&self.skeleton, told, joint_map::builtin(), given)
        })
    }
}

impl From<JointMapping> for MappedJoints {
    fn from(found: JointMapping) -> Self {
        Self {
            found: found.into(),
            ..Self::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::reference_mannequin;
    use crate::open::{CharacterFile, OpenOptions, open};
    use articula_core::source::Character;
    use articula_formats::gltf::Document;

    fn mannequin() -> CharacterFile {
        reference_mannequin().unwrap()
    }

    fn reopened(character: &Character) -> CharacterFile {
        let glb = Document::from_character(character).unwrap().write_glb();
        let mut alone = |_: &str| Err(String::new());
        open(&glb.unwrap(), "a.glb", &OpenOptions::default(), &mut alone).unwrap()
    }

    #[test]
    fn a_stored_articulation_is_played_without_the_mapping() {
        let file = mannequin();
        let mut character = file.character().clone();
        character.articulation = Some(file.mapping().articulation.clone());
        let stored = reopened(&character);
        assert_eq!(Some(stored.articulation()), character.articulation);
        assert!(stored.mapping.found.get().is_none());
        assert_eq!(stored.mapping().articulation, file.mapping().articulation);
        character.articulation = None;
        let plain = reopened(&character);
        assert!(plain.mapping.found.get().is_some());
        assert_eq!(plain.mapping(), stored.mapping());
    }

    #[test]
    fn joints_keep_what_they_were_mapped_to_however_late_it_is_asked_for() {
        let mut character = mannequin().character().clone();
        let expected = mannequin().mapping().clone();
        character.articulation = Some(expected.articulation.clone());
        let mut file = reopened(&character);
        file.edit_character(|c| {
            c.skeleton
                .joints
                .iter_mut()
                .for_each(|j| j.name = "x".to_owned());
        });
        assert!(file.mapping.found.get().is_none());
        assert_eq!(file.mapping().articulation, expected.articulation);
    }
}
