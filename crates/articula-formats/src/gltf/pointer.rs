//! Animation targets given by a JSON pointer.
//!
//! Source: KHR_animation_pointer; RFC 6901. Supported are translation, rotation, scale and weights
//! of a node and weights of a mesh; single weights and all others are left out.

use super::place::Place;

/// Target of a pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pointed {
    /// A node, and the equivalent `path` without pointer.
    Node(usize, &'static str),
    /// The weights of a mesh, and so of its nodes that have no weights.
    MeshWeights(usize),
}

/// Returns the pointer of an animation target, if it has one.
pub(super) fn text<'a>(target: &Place<'a>) -> Option<&'a str> {
    let extension = target.dig(&["extensions", "KHR_animation_pointer"])?;
    (target.text("path") == "pointer").then(|| extension.text("pointer"))
}

/// Parses the target of a pointer; `None` if it is not part of a character.
pub(super) fn parse(pointer: &str) -> Option<Pointed> {
    let mut parts = pointer.strip_prefix('/')?.split('/');
    let (list, index, property) = (parts.next()?, parts.next()?, parts.next()?);
    let is_index =
        index.bytes().all(|b| b.is_ascii_digit()) && (index == "0" || !index.starts_with('0'));
    let index = index.parse().ok().filter(|_| is_index)?;
    if parts.next().is_some() {
        return None;
    }
    let paths = ["translation", "rotation", "scale", "weights"];
    match list {
        "nodes" => {
            let path = paths.into_iter().find(|path| *path == property)?;
            Some(Pointed::Node(index, path))
        }
        "meshes" if property == "weights" => Some(Pointed::MeshWeights(index)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_by_hand() {
        assert_eq!(parse("/nodes/12/scale"), Some(Pointed::Node(12, "scale")));
        assert_eq!(parse("/meshes/0/weights"), Some(Pointed::MeshWeights(0)));
        for other in [
            "",
            "nodes/1/scale",
            "/nodes/1",
            "/nodes/01/scale",
            "/nodes/+1/scale",
            "/nodes//scale",
            "/nodes/1/matrix",
            "/nodes/1/weights/0",
            "/meshes/0/scale",
            "/materials/0/alphaCutoff",
            "/nodes/99999999999999999999/scale",
        ] {
            assert_eq!(parse(other), None, "{other}");
        }
    }
}
