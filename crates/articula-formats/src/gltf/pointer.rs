//! Animation targets given by a JSON pointer.
//!
//! Source: KHR_animation_pointer; RFC 6901. Supported are translation, rotation, scale and weights
//! of a node and weights of a mesh, together or singly; all others are left out.

use super::place::Place;

/// Target of a pointer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pointed {
    /// A node, and the equivalent `path` without pointer.
    Node(usize, &'static str),
    /// The weights of a mesh, and so of its nodes that have no weights.
    MeshWeights(usize),
    /// A weight of a node, by node and morph target.
    NodeWeight(usize, usize),
    /// A weight of a mesh, by mesh and morph target.
    MeshWeight(usize, usize),
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
    let index = whole(index)?;
    if let Some(morph) = parts.next() {
        let morph = whole(morph)?;
        let is_single = property == "weights" && parts.next().is_none();
        return match list {
            "nodes" if is_single => Some(Pointed::NodeWeight(index, morph)),
            "meshes" if is_single => Some(Pointed::MeshWeight(index, morph)),
            _ => None,
        };
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

/// Parses an index of RFC 6901: digits without leading zeros.
fn whole(text: &str) -> Option<usize> {
    let is_index =
        text.bytes().all(|b| b.is_ascii_digit()) && (text == "0" || !text.starts_with('0'));
    text.parse().ok().filter(|_| is_index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_by_hand() {
        assert_eq!(parse("/nodes/12/scale"), Some(Pointed::Node(12, "scale")));
        assert_eq!(parse("/meshes/0/weights"), Some(Pointed::MeshWeights(0)));
        assert_eq!(parse("/nodes/1/weights/0"), Some(Pointed::NodeWeight(1, 0)));
        assert_eq!(
            parse("/meshes/2/weights/10"),
            Some(Pointed::MeshWeight(2, 10))
        );
        for other in [
            "",
            "nodes/1/scale",
            "/nodes/1",
            "/nodes/01/scale",
            "/nodes/+1/scale",
            "/nodes//scale",
            "/nodes/1/matrix",
            "/nodes/1/weights/",
            "/nodes/1/weights/01",
            "/nodes/1/weights/0/0",
            "/nodes/1/scale/0",
            "/meshes/0/scale",
            "/materials/0/alphaCutoff",
            "/nodes/99999999999999999999/scale",
        ] {
            assert_eq!(parse(other), None, "{other}");
        }
    }
}
