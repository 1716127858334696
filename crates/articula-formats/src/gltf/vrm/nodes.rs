//! Nodes that are human bones or carry the track of an expression.
//!
//! Source: member `humanoid.humanBones`, a list in VRM 0.x, an object in VRM 1.0 and VRM animation
//! 1.0; member `expressions` of VRM animation 1.0.

use super::super::khr_character;
use super::super::place::Place;
use super::super::reader::Reader;
use super::super::skeleton::HumanNodes;
use super::{expressions, extension};

/// Reads the human bones and expression tracks of a document with `nodes` nodes.
pub(in super::super) fn read(reader: &mut Reader<'_>, nodes: usize) -> HumanNodes {
    let mut human = HumanNodes {
        bones: khr_character::bones(&reader.root, nodes),
        ..HumanNodes::default()
    };
    if let Some(humanoid) = extension(&reader.root).and_then(|e| e.get("humanoid")) {
        human.bones = bones(reader, &humanoid, nodes);
    }
    for (i, node) in expressions::expression_nodes(reader.root.value())
        .iter()
        .enumerate()
    {
        if let Some(node) = node.filter(|n| *n < nodes) {
            human.expressions.entry(node).or_insert(i);
        }
    }
    human
}

fn bones(reader: &mut Reader<'_>, humanoid: &Place<'_>, nodes: usize) -> Vec<(usize, String)> {
    let listed = humanoid.entries("humanBones").unwrap_or_default();
    let listed = listed.into_iter().map(|bone| (bone.text("bone"), bone));
    let named = humanoid
        .get("humanBones")
        .map_or(Vec::new(), |b| b.members());
    let mut found = Vec::new();
    for (name, bone) in listed.chain(named) {
        match bone.index("node", nodes) {
            Ok(Some(_)) if name.is_empty() => {
                reader.warn(&bone, "a human bone has no name; left out")
            }
            Ok(Some(node)) => found.push((node, name.to_owned())),
            // VRM 0.x writes -1 for an absent bone.
            Ok(None) => {}
            Err(_) if bone.get("node").and_then(|n| n.value().as_i64()) == Some(-1) => {}
            Err(error) => reader.warn(&bone, format!("the human bone is left out: {error}")),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::super::document::Document;
    use super::super::super::reader::Notes;
    use super::*;
    use crate::Limits;
    use serde_json::{Value, json};

    fn bones_of(json: Value) -> (Vec<(usize, String)>, usize) {
        let document = Document {
            json,
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        let limits = Limits::default();
        let mut reader = Reader::new(&document, &limits, Notes::default());
        let found = read(&mut reader, 4).bones;
        (found, reader.notes.into_list().len())
    }

    #[test]
    fn three_forms_are_read() {
        let wanted = vec![(3, "hips".to_owned())];
        let old = json!({"extensions": {"VRM": {"humanoid": {"humanBones": [
            {"bone": "hips", "node": 3}, {"bone": "spine"}, {"bone": "neck", "node": -1}, 7]}}}});
        assert_eq!(bones_of(old), (wanted.clone(), 0));
        for name in ["VRMC_vrm", "VRMC_vrm_animation"] {
            let bones = json!({"hips": {"node": 3}, "spine": {"node": 4}});
            let new = json!({"extensions": {name: {"humanoid": {"humanBones": bones}}}});
            assert_eq!(bones_of(new), (wanted.clone(), 1));
        }
        assert_eq!(bones_of(json!({"extensions": {}})), (vec![], 0));
        assert_eq!(bones_of(json!({"extensions": 1})), (vec![], 0));
    }
}
