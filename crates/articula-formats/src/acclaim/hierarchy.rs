//! The bones of a skeleton file as a tree, parents before children.

use super::asf::{SkeletonText, at};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use crate::words::shortened;
use std::collections::HashMap;

/// The tree; its first slot is the root, which is not a bone.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Hierarchy {
    /// Slot of the parent of each slot; `None` for the root.
    pub(super) parents: Vec<Option<usize>>,
    /// Bone of each slot; `None` for the root.
    pub(super) bones: Vec<Option<usize>>,
    /// Slot of each bone; `None` for bones outside of the hierarchy.
    pub(super) slots: Vec<Option<usize>>,
    /// Slot of every name that a motion may use; `None` as for `slots`.
    pub(super) names: HashMap<String, Option<usize>>,
}

/// Orders the bones.
pub(super) fn build(
    text: &SkeletonText,
    limits: &Limits,
    notes: &mut Notes,
) -> Result<Hierarchy, ReadError> {
    let bones = by_name(text)?;
    let children = children(text, &bones)?;
    let mut tree = Hierarchy {
        parents: vec![None],
        bones: vec![None],
        slots: vec![None; text.bones.len()],
        names: HashMap::new(),
    };
    // Slot of the parent, depth of the child, and the child; the root's children come first.
    let entry = |slot: usize, depth: u64| move |&bone: &usize| (slot, depth, bone);
    let mut open: Vec<_> = children[0].iter().rev().map(entry(0, 2)).collect();
    while let Some((parent, depth, bone)) = open.pop() {
        Limits::check(
            at(text.bones[bone].line),
            "nested bones",
            depth,
            limits.depth,
        )?;
        let slot = tree.bones.len();
        tree.bones.push(Some(bone));
        tree.parents.push(Some(parent));
        tree.slots[bone] = Some(slot);
        open.extend(children[bone + 1].iter().rev().map(entry(slot, depth + 1)));
    }
    for (bone, slot) in text.bones.iter().zip(&tree.slots) {
        tree.names.insert(bone.name.clone(), *slot);
        if slot.is_none() {
            let name = shortened(&bone.name);
            let what = format!("the bone \"{name}\" is not connected to the root; left out");
            notes.add(at(bone.line), what);
        }
    }
    tree.names.insert("root".to_owned(), Some(0));
    Ok(tree)
}

fn by_name(text: &SkeletonText) -> Result<HashMap<&str, usize>, ReadError> {
    let mut bones = HashMap::new();
    for (index, bone) in text.bones.iter().enumerate() {
        let taken = bones.insert(bone.name.as_str(), index).is_some();
        if taken || bone.name == "root" {
            let what = format!("two bones have the name \"{}\"", shortened(&bone.name));
            return Err(ReadError::malformed(at(bone.line), what));
        }
    }
    Ok(bones)
}

/// Returns the children of the root, then of every bone. Each bone is a child once.
fn children(
    text: &SkeletonText,
    bones: &HashMap<&str, usize>,
) -> Result<Vec<Vec<usize>>, ReadError> {
    let mut children = vec![Vec::new(); text.bones.len() + 1];
    let mut has_parent = vec![false; text.bones.len()];
    for link in &text.links {
        let unknown = |name: &str| {
            let name = shortened(name);
            let what = format!("\"{name}\" is in :hierarchy but not in :bonedata");
            ReadError::malformed(at(link.line), what)
        };
        let find = |name: &str| bones.get(name).copied().ok_or_else(|| unknown(name));
        let parent = match link.parent.as_str() {
            "root" => 0,
            name => find(name)? + 1,
        };
        for name in &link.children {
            let child = find(name)?;
            if std::mem::replace(&mut has_parent[child], true) {
                let what = format!("\"{}\" has two parents", shortened(name));
                return Err(ReadError::malformed(at(link.line), what));
            }
            children[parent].push(child);
        }
    }
    Ok(children)
}
