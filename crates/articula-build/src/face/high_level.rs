//! The high-level parameters FAP 1 (viseme) and FAP 2 (expression) as low-level ones.
//!
//! ISO/IEC 14496-2 describes their look in words; the values are engineering defaults
//! (`docs/methods/faces.md`). Those of the outer lips (51 to 60) equal their inner twins.

use super::fap_values::{FapList, FapValues};

/// The expressions by the number that FAP 2 selects; 0 is neutral.
#[rustfmt::skip]
pub(super) static EXPRESSIONS: [FapList; 7] = [
    &[],
    // Joy
    &[(3, 150), (6, 260), (7, 260), (12, 220), (13, 220), (21, 200), (22, 200), (41, 400), (42, 400)],
    // Sadness
    &[(12, -180), (13, -180), (19, 250), (20, 250), (31, 300), (32, 300), (33, 80), (34, 80), (37, 150), (38, 150)],
    // Anger
    &[(4, -60), (5, 60), (16, 60), (17, 60), (19, -150), (20, -150), (31, -250), (32, -250), (33, -150), (34, -150), (37, 300), (38, 300), (61, 120), (62, 120)],
    // Fear
    &[(3, 200), (5, -160), (19, -280), (20, -280), (31, 400), (32, 400), (33, 280), (34, 280), (35, 120), (36, 120), (37, 220), (38, 220)],
    // Disgust
    &[(4, -200), (8, -180), (9, -180), (18, 200), (19, 150), (20, 150), (41, 200), (42, 200), (61, 200), (62, 200), (63, 250)],
    // Surprise
    &[(3, 600), (5, -480), (10, -480), (11, -480), (19, -300), (20, -300), (31, 450), (32, 450), (33, 450), (34, 450), (35, 450), (36, 450)],
];

/// The visemes by the number that FAP 1 selects, with their English phonemes; 0 is neutral.
#[rustfmt::skip]
pub(super) static VISEMES: [FapList; 15] = [
    &[],
    // p, b, m
    &[(4, 60), (5, 60), (16, 80), (17, 80)],
    // f, v
    &[(3, 60), (4, -60), (5, 180), (16, -120)],
    // th
    &[(3, 160), (5, -120), (44, 120), (45, 160)],
    // t, d
    &[(3, 130), (5, -110), (44, 250)],
    // k, g
    &[(3, 180), (5, -150), (46, 250)],
    // ch, j, sh
    &[(3, 110), (4, -80), (5, -120), (6, -120), (7, -120), (16, 220), (17, 220)],
    // s, z
    &[(3, 60), (4, -60), (5, -110), (6, 90), (7, 90)],
    // n, l
    &[(3, 130), (5, -110), (44, 250)],
    // r
    &[(3, 120), (6, -90), (7, -90), (16, 120), (17, 120), (44, 180)],
    // a (car)
    &[(3, 480), (4, -60), (5, -380), (10, -380), (11, -380)],
    // e (bed)
    &[(3, 240), (5, -200), (6, 130), (7, 130), (10, -200), (11, -200)],
    // i (tip)
    &[(3, 150), (5, -140), (6, 200), (7, 200), (10, -140), (11, -140)],
    // o (top)
    &[(3, 360), (5, -280), (6, -150), (7, -150), (10, -280), (11, -280), (16, 160), (17, 160)],
    // u (book)
    &[(3, 200), (4, -60), (5, -140), (6, -260), (7, -260), (16, 300), (17, 300)],
];

/// Adds FAP 1: the first viseme with weight `blend` (in 63rds), the second with the rest.
pub fn add_viseme(values: &mut FapValues, select: [u8; 2], blend: u8) {
    let first = f32::from(blend) / 63.0;
    for (select, weight) in select.into_iter().zip([first, 1.0 - first]) {
        if let Some(list) = VISEMES.get(usize::from(select)) {
            values.add(list, weight);
        }
    }
}

/// Adds FAP 2: two expressions, each with its intensity (in 63rds).
pub fn add_expression(values: &mut FapValues, select: [u8; 2], intensity: [u8; 2]) {
    for (select, intensity) in select.into_iter().zip(intensity) {
        if let Some(list) = EXPRESSIONS.get(usize::from(select)) {
            values.add(list, f32::from(intensity) / 63.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visemes_blend_and_expressions_add() {
        let mut values = FapValues::default();
        // A third of "a", two thirds of "u": the jaw opens by 480 / 3 + 200 * 2 / 3.
        add_viseme(&mut values, [10, 14], 21);
        assert!((values.get(3) - (160.0 + 400.0 / 3.0)).abs() < 1e-3);
        // Joy and half a surprise, on top.
        add_expression(&mut values, [1, 6], [63, 0]);
        assert!((values.get(3) - (160.0 + 400.0 / 3.0 + 150.0)).abs() < 1e-3);
        assert!((values.get(41) - 400.0).abs() < 1e-3);
        // Outer lips follow the inner ones.
        assert_eq!(values.get(59), values.get(12));
    }

    #[test]
    fn nothing_is_selected_by_zeros_or_by_numbers_out_of_range() {
        let mut values = FapValues::default();
        add_viseme(&mut values, [0, 0], 63);
        add_viseme(&mut values, [15, 200], 10);
        add_expression(&mut values, [0, 7], [63, 63]);
        assert_eq!(values, FapValues::default());
    }
}
