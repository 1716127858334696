//! What drives a portrait with a face animation table besides its expressions: the blend shapes of
//! ARKit and the visemes that it lacks.

use articula_build::face::{FapInterval, FapValues, blend_shape, control_column};
use articula_core::arkit_table::BLEND_SHAPES;
use articula_core::face_control::FaceControl;
use articula_core::fap_table::LOW_FAPS;
use articula_core::viseme::Viseme;
use articula_flat::portrait::{PortraitExpression, PortraitInput};

/// The inputs of a portrait with these expressions; none without a face animation table.
pub(super) fn inputs(expressions: &[PortraitExpression]) -> Vec<PortraitInput> {
    let names = || expressions.iter().map(|e| e.name.as_str());
    let parts: Vec<FapInterval> = names().filter_map(FapInterval::parse).collect();
    let is_table = parts.iter().any(|part| !(23..=26).contains(&part.fap));
    if !is_table {
        return Vec::new();
    }
    let shapes = BLEND_SHAPES.iter();
    let shapes = shapes.map(|s| (s.name.to_owned(), blend_shape(s.name).unwrap_or_default()));
    let visemes = Viseme::ALL.into_iter().map(|viseme| {
        let name = format!("viseme_{}", viseme.name());
        (name, control_column(FaceControl::Viseme(viseme)))
    });
    let absent = |name: &String| !names().any(|own| folded(own) == folded(name));
    let all = shapes.chain(visemes).filter(|(name, _)| absent(name));
    all.map(|(name, values)| PortraitInput {
        faps: moved(&values),
        name,
    })
    .filter(|input| !input.faps.is_empty())
    .collect()
}

/// The parameters that are not 0.
fn moved(values: &FapValues) -> Vec<(u8, f32)> {
    let all = LOW_FAPS.map(|fap| (fap as u8, values.get(fap)));
    all.filter(|(_, value)| *value != 0.0).collect()
}

/// A name as the player compares it: `eyeBlinkLeft` and `eyeBlink_L` are one.
fn folded(name: &str) -> String {
    let name = name.to_lowercase();
    for (side, short) in [("left", "_l"), ("right", "_r")] {
        if let Some(stem) = name.strip_suffix(side) {
            return format!("{}{short}", stem.strip_suffix('_').unwrap_or(stem));
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[&str]) -> Vec<PortraitExpression> {
        let of = |name: &&str| PortraitExpression::of_morph(*name, 0);
        names.iter().map(of).collect()
    }

    #[test]
    fn shapes_and_visemes_that_a_table_shows_are_inputs() {
        let found = inputs(&named(&["fap3_0_540", "eyeBlink_L"]));
        let find = |name: &str| found.iter().find(|i| i.name == name);
        let jaw = find("jawOpen").unwrap();
        assert!(
            jaw.faps
                .iter()
                .any(|(fap, value)| *fap == 3 && *value > 0.0)
        );
        assert!(find("eyeBlinkLeft").is_none() && find("eyeBlinkRight").is_some());
        assert!(find("viseme_aa").is_some() && find("viseme_sil").is_none());
    }

    #[test]
    fn without_a_table_there_are_none() {
        assert!(inputs(&named(&["jawOpen", "fap23_0_52000"])).is_empty());
    }
}
