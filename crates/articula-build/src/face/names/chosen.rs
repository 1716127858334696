//! The controls of a face among which no two show the same.

use super::NamedControl;
use articula_core::arkit_table::BLEND_SHAPE_COUNT;
use articula_core::face_control::FaceControl;
use articula_core::viseme::VISEME_COUNT;
use std::collections::BTreeMap;

/// A named morph target of a mesh, or an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceCandidate<T> {
    /// Where it is.
    pub place: T,
    /// Index of its mesh; all expressions have the same.
    pub group: usize,
    /// What its name means.
    pub named: NamedControl,
}

/// A control with the places that show it; several meshes may have it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenControl<T> {
    /// What it shows, with the least confidence of its places.
    pub named: NamedControl,
    /// The morph targets or expressions that show it.
    pub places: Vec<T>,
}

/// What the controls of one mesh show already.
#[derive(Clone)]
struct Shown {
    /// Quarters of each shape.
    quarters: [u8; BLEND_SHAPE_COUNT],
    visemes: [bool; VISEME_COUNT],
    emotions: Vec<FaceControl>,
}

impl Shown {
    /// Whether nothing of a control is shown yet; it is from then on.
    fn take(&mut self, control: FaceControl) -> bool {
        match control {
            FaceControl::Shapes(shapes, part) => {
                let free = shapes
                    .iter()
                    .all(|shape| self.quarters[shape] & part.quarters() == 0);
                if free {
                    shapes
                        .iter()
                        .for_each(|shape| self.quarters[shape] |= part.quarters());
                }
                free
            }
            FaceControl::Viseme(viseme) => {
                !std::mem::replace(&mut self.visemes[viseme.number()], true)
            }
            FaceControl::Emotion(_) => {
                let free = !self.emotions.contains(&control);
                self.emotions.push(control);
                free
            }
        }
    }
}

/// Chooses the controls of a face: of two in a mesh that show the same, even in part, the surer one,
/// then the one with fewer shapes, then the first. `mouthSmile` beside `mouthSmileLeft` is left out.
pub fn choose_controls<T: Copy>(candidates: &[FaceCandidate<T>]) -> Vec<ChosenControl<T>> {
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    let shapes = |index: &usize| match candidates[*index].named.control {
        FaceControl::Shapes(shapes, _) => shapes.iter().count(),
        _ => 1,
    };
    order.sort_by_key(|i| {
        (
            std::cmp::Reverse(candidates[*i].named.confidence),
            shapes(i),
        )
    });
    let mut shown: BTreeMap<usize, Shown> = BTreeMap::new();
    let nothing = Shown {
        quarters: [0; BLEND_SHAPE_COUNT],
        visemes: [false; VISEME_COUNT],
        emotions: Vec::new(),
    };
    let mut is_kept = vec![false; candidates.len()];
    for index in order {
        let candidate = &candidates[index];
        let of_mesh = shown
            .entry(candidate.group)
            .or_insert_with(|| nothing.clone());
        is_kept[index] = of_mesh.take(candidate.named.control);
    }
    let mut chosen: Vec<ChosenControl<T>> = Vec::new();
    for (candidate, _) in candidates.iter().zip(is_kept).filter(|(_, kept)| *kept) {
        let FaceCandidate { place, named, .. } = *candidate;
        match chosen.iter_mut().find(|c| c.named.control == named.control) {
            Some(known) => {
                known.places.push(place);
                known.named.confidence = known.named.confidence.min(named.confidence);
            }
            None => chosen.push(ChosenControl {
                named,
                places: vec![place],
            }),
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::super::face_control;
    use super::*;

    fn chosen(names: &[(usize, &str)]) -> Vec<(String, Vec<usize>)> {
        let candidates: Vec<FaceCandidate<usize>> = names
            .iter()
            .enumerate()
            .map(|(place, (group, name))| FaceCandidate {
                place,
                group: *group,
                named: face_control(name).unwrap(),
            })
            .collect();
        let chosen = choose_controls(&candidates).into_iter();
        chosen
            .map(|c| (c.named.control.to_string(), c.places))
            .collect()
    }

    #[test]
    fn what_is_shown_twice_is_driven_once() {
        let head = [
            (0, "mouthSmile"),
            (0, "mouthOpen"),
            (0, "jawOpen"),
            (0, "mouthSmileLeft"),
            (1, "jawOpen"),
            (1, "mouthSmile"),
        ];
        let wanted = [
            ("jawOpen", vec![2, 4]),
            ("mouthSmileLeft", vec![3]),
            ("mouthSmileLeft+mouthSmileRight", vec![5]),
        ];
        let wanted = wanted.map(|(name, places)| (name.to_owned(), places));
        assert_eq!(chosen(&head), wanted);
    }

    #[test]
    fn parts_of_a_shape_stand_beside_each_other() {
        let head = [
            (0, "Mouth_Funnel_Up_L"),
            (0, "Mouth_Funnel_Up_R"),
            (0, "mouthFunnel"),
        ];
        assert_eq!(chosen(&head), [("mouthFunnel".to_owned(), vec![2])]);
        assert_eq!(chosen(&head[..2]).len(), 2);
    }
}
