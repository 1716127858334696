//! What regions that are left out cost: a part without a choice for the motions of the body, and one for
//! those of the face.

use crate::item::part::{ItemPart, PartKind as ItemKind};
use articula_stream::decide::{Part, PartKind, PartOption};

/// The parts of what motions were cut to. They weigh nothing in the choice, since whoever leaves a region
/// out does not want bytes for it, and count in its error.
pub(super) fn parts(parts: &[ItemPart]) -> Vec<Part> {
    let kinds = [ItemKind::BodyMotion, ItemKind::FaceMotion];
    let of_kind = |kind| parts.iter().filter(move |part| part.kind == kind);
    kinds
        .into_iter()
        .filter_map(|kind| part(of_kind(kind)))
        .collect()
}

fn part<'a>(motions: impl Iterator<Item = &'a ItemPart>) -> Option<Part> {
    let mut names: Vec<&str> = Vec::new();
    // One motion plays at a time.
    let mut error_m = 0.0_f64;
    for motion in motions {
        for region in &motion.left_out {
            if !names.contains(&region.name.as_str()) {
                names.push(&region.name);
            }
        }
        error_m = error_m.max(motion.left_out_m());
    }
    if names.is_empty() {
        return None;
    }
    let option = PartOption {
        name: "as asked".to_owned(),
        error_m,
        ..PartOption::default()
    };
    let name = format!("without {}", names.join(", "));
    Some(Part {
        weight: 0.0,
        ..Part::new(name, PartKind::Other, vec![option])
    })
}
