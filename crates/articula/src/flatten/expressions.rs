//! Expressions of a face that can be driven.

use crate::figure::Figure;
use articula_flat::portrait::PortraitExpression;

/// Returns what can be driven: the file's named expressions, then morph targets by name.
pub(crate) fn expressions(figure: &Figure) -> Vec<PortraitExpression> {
    let character = figure.opened.character();
    let slots = &figure.asset.mesh.morph_slots;
    let mut all: Vec<PortraitExpression> = Vec::new();
    for expression in &character.expressions {
        let morphs = expression.morphs.iter().filter_map(|m| {
            let slot = slots.get(m.mesh)? + m.target;
            Some((u16::try_from(slot).ok()?, m.weight))
        });
        let morphs: Vec<_> = morphs.collect();
        if !morphs.is_empty() {
            all.push(PortraitExpression {
                name: expression.name.clone(),
                morphs,
                joints: Vec::new(),
            });
        }
    }
    for (mesh, first) in character.meshes.iter().zip(slots) {
        for (target, name) in mesh.morph_names.iter().enumerate() {
            let Ok(slot) = u16::try_from(first + target) else {
                continue;
            };
            let name = if name.is_empty() {
                format!("{}.{target}", mesh.name)
            } else {
                name.clone()
            };
            // Meshes of one face (skin, lashes, teeth) share names and move together.
            let is_own = |e: &PortraitExpression| {
                e.morphs
                    .iter()
                    .any(|(s, _)| (*first..first + target).contains(&usize::from(*s)))
            };
            match all.iter_mut().find(|e| e.name == name && !is_own(e)) {
                Some(known) if !known.morphs.iter().any(|(s, _)| *s == slot) => {
                    known.morphs.push((slot, 1.0));
                }
                Some(_) => {}
                None => all.push(PortraitExpression::of_morph(name, slot)),
            }
        }
    }
    all
}
