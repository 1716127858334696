//! Skins to which a joint is added, or from which one is removed.

use super::{InsertedJoint, MergedJoint};
use articula_core::source::{Character, Skin};
use glam::Affine3A;

/// Skins of all meshes and their levels.
pub(super) fn skins(character: &mut Character) -> impl Iterator<Item = &mut Skin> {
    character.meshes.iter_mut().flat_map(|mesh| {
        let levels = mesh.levels.iter_mut().map(|level| &mut level.skin);
        std::iter::once(&mut mesh.skin).chain(levels)
    })
}

/// Lists an inserted joint in a skin that has its parent or its child, so that it is part of the
/// same skeleton for programs that read skins. Indices are those after the insertion.
pub(super) fn list_inserted(skin: &mut Skin, inserted: &InsertedJoint) {
    let slot = |joint: usize| skin.joints.iter().position(|j| *j == joint);
    let bind = if let Some(slot) = slot(inserted.parent) {
        Affine3A::from_translation(-inserted.offset) * skin.inverse_bind[slot]
    } else if let Some(slot) = slot(inserted.joint + 1) {
        inserted.child_rest.to_affine() * skin.inverse_bind[slot]
    } else {
        return;
    };
    // A mesh attached to one joint is not skinned.
    if skin.joints.len() > 1 {
        skin.joints.push(inserted.joint);
        skin.inverse_bind.push(bind);
    }
}

/// Removes a joint from a skin in favour of the one that takes its skin; returns the new slots.
pub(super) fn drop_from_skin(skin: &mut Skin, merged: &MergedJoint) -> impl Fn(u16) -> u16 + use<> {
    let slot = |joint: usize| skin.joints.iter().position(|j| *j == joint);
    let slots = (slot(merged.joint), slot(merged.into));
    if let (Some(own), None) = slots {
        skin.joints[own] = merged.into;
        skin.inverse_bind[own] = merged.rest.to_affine() * skin.inverse_bind[own];
    }
    if let (Some(own), Some(_)) = slots {
        skin.joints.remove(own);
        skin.inverse_bind.remove(own);
    }
    move |joint| match slots {
        (Some(own), Some(other)) => {
            let slot = if usize::from(joint) == own {
                other
            } else {
                usize::from(joint)
            };
            (slot - usize::from(slot > own)) as u16
        }
        _ => joint,
    }
}
