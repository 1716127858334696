//! What a mouth does for each viseme.

use articula_build::face::{FapValues, arkit_shape, control_column};
use articula_core::arkit_table::BLEND_SHAPE_COUNT;
use articula_core::face_control::FaceControl;
use articula_core::viseme::{VISEME_COUNT, Viseme};
use articula_speech::VisemeFrame;

/// Names of blend shapes and their weights; `mouthSmile` is `mouthSmileLeft` and `mouthSmileRight`.
type Shapes = &'static [(&'static str, f32)];

/// The blend shapes of each viseme, by its number: defaults that were judged by eye.
const SHAPES: [Shapes; VISEME_COUNT] = [
    &[],
    &[
        ("mouthPress", 0.5),
        ("mouthRollLower", 0.25),
        ("mouthRollUpper", 0.25),
    ],
    &[
        ("jawOpen", 0.06),
        ("mouthRollLower", 0.55),
        ("mouthUpperUp", 0.25),
    ],
    &[
        ("jawOpen", 0.16),
        ("tongueOut", 0.25),
        ("mouthLowerDown", 0.15),
        ("mouthUpperUp", 0.1),
    ],
    &[
        ("jawOpen", 0.13),
        ("mouthLowerDown", 0.15),
        ("mouthUpperUp", 0.08),
    ],
    &[
        ("jawOpen", 0.18),
        ("mouthLowerDown", 0.12),
        ("mouthUpperUp", 0.06),
    ],
    &[
        ("jawOpen", 0.11),
        ("mouthFunnel", 0.45),
        ("mouthPucker", 0.15),
    ],
    &[
        ("jawOpen", 0.06),
        ("mouthStretch", 0.12),
        ("mouthSmile", 0.1),
        ("mouthLowerDown", 0.2),
        ("mouthUpperUp", 0.12),
    ],
    &[
        ("jawOpen", 0.13),
        ("mouthLowerDown", 0.15),
        ("mouthUpperUp", 0.08),
    ],
    &[
        ("jawOpen", 0.12),
        ("mouthFunnel", 0.25),
        ("mouthPucker", 0.15),
    ],
    &[
        ("jawOpen", 0.48),
        ("mouthLowerDown", 0.2),
        ("mouthUpperUp", 0.06),
    ],
    &[
        ("jawOpen", 0.24),
        ("mouthSmile", 0.15),
        ("mouthStretch", 0.12),
        ("mouthLowerDown", 0.2),
    ],
    &[
        ("jawOpen", 0.15),
        ("mouthSmile", 0.25),
        ("mouthStretch", 0.15),
        ("mouthLowerDown", 0.15),
    ],
    &[
        ("jawOpen", 0.36),
        ("mouthFunnel", 0.45),
        ("mouthPucker", 0.1),
    ],
    &[
        ("jawOpen", 0.12),
        ("mouthPucker", 0.6),
        ("mouthFunnel", 0.15),
    ],
];

/// Amounts of the mouth at the loudest, and their slope in a decibel, and their bounds.
const LOUD: f32 = 1.1;
const SLOPE: f32 = 0.5 / 12.0;
const AMOUNT: [f32; 2] = [0.5, 1.15];

/// Weights of the blend shapes of each viseme.
#[derive(Debug, Clone)]
pub(super) struct MouthShapes {
    columns: [[f32; BLEND_SHAPE_COUNT]; VISEME_COUNT],
    jaw: usize,
    close: usize,
}

impl MouthShapes {
    pub(super) fn new() -> Self {
        let mut columns = [[0.0; BLEND_SHAPE_COUNT]; VISEME_COUNT];
        for (column, shapes) in columns.iter_mut().zip(SHAPES) {
            for (name, weight) in shapes {
                for side in ["", "Left", "Right"] {
                    if let Some(shape) = arkit_shape(&format!("{name}{side}")) {
                        column[shape] = *weight;
                    }
                }
            }
        }
        let shape = |name| arkit_shape(name).unwrap_or_default();
        Self {
            columns,
            jaw: shape("jawOpen"),
            close: shape("mouthClose"),
        }
    }

    /// Weights of the blend shapes in a frame, between 0 and 1.
    pub(super) fn weights(&self, frame: &VisemeFrame) -> [f32; BLEND_SHAPE_COUNT] {
        let mut weights = [0.0; BLEND_SHAPE_COUNT];
        for (column, amount) in self.columns.iter().zip(amounts(frame)) {
            for (weight, value) in weights.iter_mut().zip(column) {
                *weight += amount * value;
            }
        }
        // Lips that meet do so at any place of the jaw.
        weights[self.close] = weights[self.jaw] * frame.weights[Viseme::Pp.number()];
        weights.map(|weight| weight.clamp(0.0, 1.0))
    }
}

/// The weights of a frame by loudness; lips that meet do so for soft voices too.
pub(super) fn amounts(frame: &VisemeFrame) -> [f32; VISEME_COUNT] {
    let loud = (LOUD + SLOPE * frame.level_db).clamp(AMOUNT[0], AMOUNT[1]);
    let amount = |viseme: Viseme| match viseme {
        Viseme::Pp | Viseme::Ff => 1.0,
        _ => loud,
    };
    std::array::from_fn(|v| frame.weights[v] * amount(Viseme::ALL[v]))
}

/// Values of the low-level parameters in a frame.
pub(super) fn fap_values(frame: &VisemeFrame) -> FapValues {
    let mut values = FapValues::default();
    for (viseme, amount) in Viseme::ALL.into_iter().zip(amounts(frame)) {
        let whole = control_column(FaceControl::Viseme(viseme));
        for (sum, value) in values.0.iter_mut().zip(whole.0) {
            *sum += amount * value;
        }
    }
    values
}

/// The two visemes that show a frame best, and the weight of the first in 63rds, for FAP 1.
pub(super) fn strongest_two(frame: &VisemeFrame) -> ([u8; 2], u8) {
    let mut by_weight: Vec<usize> = (0..VISEME_COUNT).collect();
    by_weight.sort_by(|a, b| frame.weights[*b].total_cmp(&frame.weights[*a]));
    let [first, second] = [by_weight[0], by_weight[1]];
    let [a, b] = [frame.weights[first], frame.weights[second]];
    let blend = (63.0 * a / (a + b).max(1e-6)).round();
    ([first as u8, second as u8], blend as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::arkit_table::BLEND_SHAPES;

    fn alone(viseme: Viseme, level_db: f32) -> VisemeFrame {
        VisemeFrame {
            weights: std::array::from_fn(|v| f32::from(u8::from(v == viseme.number()))),
            level_db,
        }
    }

    fn weight(weights: &[f32; BLEND_SHAPE_COUNT], name: &str) -> f32 {
        weights[arkit_shape(name).unwrap()]
    }

    #[test]
    fn every_name_is_a_shape_or_a_pair() {
        for (name, _) in SHAPES.iter().copied().flatten() {
            let known = BLEND_SHAPES.iter().any(|s| s.name == *name);
            let pair = BLEND_SHAPES.iter().any(|s| s.name == format!("{name}Left"));
            assert!(known ^ pair, "{name}");
        }
    }

    #[test]
    fn vowels_open_by_their_height_and_lips_meet_at_any_loudness() {
        let mouth = MouthShapes::new();
        let jaw = |viseme| weight(&mouth.weights(&alone(viseme, 0.0)), "jawOpen");
        assert!(jaw(Viseme::Aa) > jaw(Viseme::E) && jaw(Viseme::E) > jaw(Viseme::I));
        let soft = mouth.weights(&alone(Viseme::Aa, -20.0));
        assert!((weight(&soft, "jawOpen") - 0.24).abs() < 1e-6);
        for level_db in [0.0, -30.0] {
            let closed = mouth.weights(&alone(Viseme::Pp, level_db));
            assert_eq!(weight(&closed, "jawOpen"), 0.0);
            assert_eq!(weight(&closed, "mouthPressLeft"), 0.5);
        }
        let mut half = alone(Viseme::Aa, 0.0);
        half.weights = half.weights.map(|w| w / 2.0);
        half.weights[Viseme::Pp.number()] = 0.5;
        let half = mouth.weights(&half);
        assert!((weight(&half, "mouthClose") - weight(&half, "jawOpen") / 2.0).abs() < 1e-6);
    }

    #[test]
    fn parameters_are_those_of_the_standards_visemes() {
        let values = fap_values(&alone(Viseme::Aa, -2.4));
        // "a" opens the jaw by 480; at 2.4 dB below the loudest the amount is 1.
        assert!((values.get(3) - 480.0).abs() < 0.5);
        let mut two = alone(Viseme::O, 0.0);
        two.weights[Viseme::O.number()] = 0.75;
        two.weights[Viseme::U.number()] = 0.25;
        assert_eq!(strongest_two(&two), ([13, 14], 47));
    }
}
