//! Edits of an opened file, each with all that depends on it.

use super::mapped_joints::MappedJoints;
use super::{CharacterFile, Format, GltfSource};
use articula_build::joint_names::JointMapping;
use articula_core::source::{Character, RawClip};
use articula_formats::{Assumption, Warning};
use glam::Vec3;

impl CharacterFile {
    /// Returns the clips for an edit of any kind; from then on they count as
    /// [changed](Self::clips_changed).
    ///
    /// [`set_clips`](Self::set_clips) and [`select_clips`](Self::select_clips) tell more of the edit.
    pub fn clips_mut(&mut self) -> &mut Vec<RawClip> {
        self.clips_changed = true;
        &mut self.character.clips
    }

    /// Replaces all clips.
    pub fn set_clips(&mut self, clips: Vec<RawClip>) {
        self.clips_changed |= !clips.is_empty() || !self.character.clips.is_empty();
        self.character.clips = clips;
    }

    /// Keeps the clips with these indices, in this order; returns the new index of every clip that
    /// there was, `None` for those left out. Indices without a clip, or given before, are passed over.
    pub fn select_clips(&mut self, indices: &[usize]) -> Vec<Option<usize>> {
        let clips = std::mem::take(&mut self.character.clips);
        let mut clips: Vec<Option<RawClip>> = clips.into_iter().map(Some).collect();
        let mut new_index = vec![None; clips.len()];
        for index in indices {
            if let Some(clip) = clips.get_mut(*index).and_then(Option::take) {
                new_index[*index] = Some(self.character.clips.len());
                self.character.clips.push(clip);
            }
        }
        let mut moved = new_index.iter().enumerate();
        self.clips_changed |= moved.any(|(old, new)| *new != Some(old));
        new_index
    }

    /// Edits the character as a program does that knows of no file; returns what `edit` does.
    ///
    /// The glTF document and the BAP parameters, which show the character as it was, are dropped. Joints
    /// keep what they were mapped to, whatever their names are now, unless their number changes: then
    /// they are mapped by name again, and end sites of joints that are gone are dropped.
    pub fn edit_character<T>(&mut self, edit: impl FnOnce(&mut Character) -> T) -> T {
        let before = self.character.skeleton.joints.len();
        let out = edit(&mut self.character);
        self.gltf = None;
        self.parameters = None;
        if self.character.skeleton.joints.len() != before {
            self.map_again();
        }
        out
    }

    /// Maps the joints by name, and drops the end sites of joints that are gone.
    fn map_again(&mut self) {
        let skeleton = &self.character.skeleton;
        self.mapping = MappedJoints::by_name(skeleton);
        let joints = skeleton.joints.len();
        self.end_sites.retain(|(joint, _)| *joint < joints);
    }

    /// Takes the glTF document away, so that the character is written anew.
    pub fn detach_document(&mut self) -> Option<GltfSource> {
        self.gltf.take()
    }

    /// Returns the warnings for additions.
    pub fn warnings_mut(&mut self) -> &mut Vec<Warning> {
        &mut self.warnings
    }

    /// Returns the file as part of another one, such as an MP4 file, of which it then has format, size
    /// in bytes and further warnings.
    #[must_use]
    pub fn found_in(
        mut self,
        format: Format,
        bytes: usize,
        warnings: impl IntoIterator<Item = Warning>,
    ) -> Self {
        (self.format, self.bytes) = (format, bytes);
        self.warnings.extend(warnings);
        self
    }

    /// Removes the warnings about first frames, which are gone.
    pub(crate) fn forget_first_frames(&mut self) {
        let is_of_another = |w: &Warning| w.guess != Some(Assumption::FirstFrame);
        self.warnings.retain(is_of_another);
    }

    /// The file under another name.
    #[cfg(all(feature = "item", not(target_family = "wasm")))]
    pub(crate) fn renamed(self, name: String) -> Self {
        Self { name, ..self }
    }

    /// Puts a character in place whose meshes were edited, and its document, edited alike. Its clips
    /// may differ where they drive morph targets.
    pub(crate) fn set_meshes(&mut self, character: Character, gltf: Option<GltfSource>) {
        self.clips_changed |= character.clips != self.character.clips;
        self.character = character;
        self.gltf = gltf;
    }

    /// Puts a character in place whose joints were edited, with the mapping of these joints and its
    /// document, edited alike. As clips name joints by their index, they count as changed.
    pub(crate) fn set_joints(
        &mut self,
        character: Character,
        mapping: JointMapping,
        end_sites: Vec<(usize, Vec3)>,
        gltf: Option<GltfSource>,
    ) {
        self.character = character;
        self.mapping = mapping.into();
        self.end_sites = end_sites;
        self.gltf = gltf;
        self.clips_changed = true;
    }

    /// Puts a document in place that shows the character, and the character as it is read from it. Of
    /// the joints of a document that was there before, those stay whose nodes are joints in both.
    #[cfg(feature = "prepare")]
    pub(crate) fn attach_document(&mut self, character: Character, gltf: GltfSource) {
        if let Some(before) = self.gltf.take() {
            let mut new_index = vec![None; before.node_of_joint.len()];
            for (new, node) in gltf.node_of_joint.iter().enumerate() {
                if let Some(old) = before.node_of_joint.iter().position(|n| n == node) {
                    new_index[old] = Some(new);
                }
            }
            let mut mapping = self.mapping().clone();
            keep_joints(&mut mapping, &new_index);
            self.mapping = mapping.into();
        }
        self.character = character;
        self.gltf = Some(gltf);
        self.parameters = None;
        self.clips_changed = false;
        if self.mapping().articulation.joints.len() != self.character.skeleton.joints.len() {
            self.map_again();
        }
    }
}

/// Keeps the mapping of the joints that have a new index; the order of joints stays.
#[cfg(any(feature = "prepare", test))]
fn keep_joints(mapping: &mut JointMapping, new_index: &[Option<usize>]) {
    let moved = |joint: &mut usize| {
        let new = new_index.get(*joint).copied().flatten();
        *joint = new.unwrap_or(*joint);
        new.is_some()
    };
    let mut kept = new_index.iter().map(Option::is_some);
    let joints = &mut mapping.articulation.joints;
    joints.retain(|_| kept.next().unwrap_or(false));
    let mut kept = new_index.iter().map(Option::is_some);
    mapping.evidence.retain(|_| kept.next().unwrap_or(false));
    mapping.gaps.retain_mut(|gap| moved(&mut gap.joint));
    mapping.crossed.retain_mut(moved);
    mapping.doubts.retain_mut(|doubt| moved(&mut doubt.joint));
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{Joint, Skeleton};

    fn with_clips(names: &[&str]) -> CharacterFile {
        let clip = |name: &&str| RawClip {
            name: (*name).to_owned(),
            ..RawClip::default()
        };
        let character = Character {
            clips: names.iter().map(clip).collect(),
            ..Character::default()
        };
        CharacterFile::from_character("a", character)
    }

    #[test]
    fn a_selection_of_clips_tells_where_each_went() {
        let mut file = with_clips(&["a", "b", "c"]);
        let same = file.select_clips(&[0, 1, 2]);
        assert_eq!(same, [Some(0), Some(1), Some(2)]);
        assert!(!file.clips_changed());
        // The second is asked for twice, and there is no eighth.
        let moved = file.select_clips(&[2, 1, 1, 7]);
        assert_eq!(moved, [None, Some(1), Some(0)]);
        assert!(file.clips_changed());
        let names = file.character().clips.iter().map(|c| c.name.as_str());
        assert_eq!(names.collect::<Vec<_>>(), ["c", "b"]);
    }

    #[test]
    fn clips_count_as_changed_after_every_edit_but_none_for_none() {
        let mut file = with_clips(&[]);
        file.set_clips(Vec::new());
        assert!(!file.clips_changed());
        file.set_clips(with_clips(&["a"]).into_character().clips);
        assert!(file.clips_changed());
        let mut file = with_clips(&["a"]);
        file.clips_mut()[0].duration_secs = 1.0;
        assert!(file.clips_changed());
        let mut file = with_clips(&["a"]);
        file.set_clips(Vec::new());
        assert!(file.clips_changed());
    }

    #[test]
    fn joints_are_mapped_again_when_their_number_changes() {
        let joint = |name: &str| Joint {
            name: name.to_owned(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let character = Character {
            skeleton: Skeleton {
                joints: vec![joint("hips"), joint("tip")],
            },
            ..Character::default()
        };
        let mut file = CharacterFile::from_character("a", character);
        file.end_sites = vec![(0, Vec3::Y), (1, Vec3::X)];
        file.edit_character(|c| c.skeleton.joints[1].name.push('s'));
        assert_eq!(file.mapping().articulation.joints.len(), 2);
        assert_eq!(file.end_sites().len(), 2);
        file.edit_character(|c| c.skeleton.joints.truncate(1));
        assert_eq!(file.mapping().articulation.joints.len(), 1);
        assert_eq!(file.mapping().evidence.len(), 1);
        assert_eq!(file.end_sites(), [(0, Vec3::Y)]);
    }

    #[test]
    fn a_joint_that_is_gone_takes_its_mapping_along() {
        let character = articula_human::human(&articula_human::HumanOptions::mannequin(12_000));
        let file = CharacterFile::from_character("a", character.unwrap());
        let mut mapping = file.mapping().clone();
        let count = mapping.articulation.joints.len();
        let new_index: Vec<Option<usize>> = (0..count).map(|j| j.checked_sub(1)).collect();
        keep_joints(&mut mapping, &new_index);
        let whole = file.mapping();
        assert_eq!(mapping.articulation.joints, whole.articulation.joints[1..]);
        assert_eq!(mapping.evidence, whole.evidence[1..]);
        let gaps = whole.gaps.iter().filter_map(|gap| gap.joint.checked_sub(1));
        assert!(mapping.gaps.iter().map(|gap| gap.joint).eq(gaps));
    }
}
