//! Names of expressions: those of the file, and morph targets that stand for one.

use crate::morphs;
use articula::Figure;
use articula::core::arkit_table::BLEND_SHAPES;

/// Whether a morph target of this name is an expression: a blend shape of ARKit, or a viseme.
pub(crate) fn is_named_for_face(name: &str) -> bool {
    let arkit = BLEND_SHAPES
        .iter()
        .any(|shape| shape.name.eq_ignore_ascii_case(name));
    arkit || name.starts_with("viseme_")
}

/// Names of all expressions of a figure.
pub(crate) fn known_names(figure: &Figure) -> Vec<String> {
    let expressions = figure.opened.character().expressions.iter();
    let mut names: Vec<String> = expressions.map(|e| e.name.clone()).collect();
    for name in morphs::names(figure) {
        if is_named_for_face(&name) && !names.contains(&name) {
            names.push(name);
        }
    }
    names
}
