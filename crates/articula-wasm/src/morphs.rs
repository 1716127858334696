//! Morph targets by name.

use articula::Figure;

/// Name of each morph target of all meshes, in the order of their weights.
pub(crate) fn names(figure: &Figure) -> Vec<String> {
    let mesh = &figure.asset.mesh;
    let mut names = vec![String::new(); mesh.morph_weights.len()];
    let meshes = figure.opened.character().meshes.iter();
    for (raw, first) in meshes.zip(&mesh.morph_slots) {
        let slots = names.get_mut(*first..).unwrap_or_default();
        for (name, known) in slots.iter_mut().zip(&raw.morph_names) {
            name.clone_from(known);
        }
    }
    names
}
