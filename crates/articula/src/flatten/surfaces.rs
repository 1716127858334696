//! Surfaces that pictures show otherwise than the file has them.

use crate::figure::Figure;
use articula_core::source::Material;
use articula_flat::{Appearance, Picture};
use std::collections::BTreeSet;

/// Least share of the texels of a mixed surface that are neither transparent nor opaque.
const PARTLY: f32 = 0.02;
/// Shares of the light of a glowing surface that count as none and as all.
const MIXED: std::ops::Range<f32> = 0.02..0.98;

/// Returns a sentence for each surface that pictures of a figure show otherwise than the file has it:
/// partly transparent ones, ones that glow and are lit at once, and ones with a picture that is
/// malformed. Pictures of unknown formats are told where a file is opened.
pub fn surfaces_shown_otherwise(figure: &Figure) -> Vec<String> {
    let character = figure.opened.character();
    let (appearance, faults) = Appearance::new(&character.materials, &character.images);
    let is_known = |image: usize| Picture::is_known_format(&character.images[image].bytes);
    let faults = faults.iter().filter(|fault| is_known(fault.image));
    let faults = faults.map(|fault| {
        format!(
            "images[{}]: the surface is drawn in its plain colour: {}",
            fault.image, fault.what
        )
    });
    let drawn: BTreeSet<usize> = figure
        .asset
        .mesh
        .parts
        .iter()
        .filter_map(|p| p.material)
        .collect();
    let drawn = drawn
        .iter()
        .filter_map(|m| Some((*m, character.materials.get(*m)?)));
    let of_materials = drawn.flat_map(|(m, material)| {
        let named = match material.name.as_str() {
            "" => format!("materials[{m}]"),
            name => format!("material \"{name}\""),
        };
        of_material(&appearance, material)
            .into_iter()
            .map(move |what| format!("{named}: {what}"))
    });
    faults.chain(of_materials).collect()
}

fn of_material(appearance: &Appearance, material: &Material) -> Vec<&'static str> {
    let mut told = Vec::new();
    if material.blends && appearance.partly_transparent(material) > PARTLY {
        told.push("it is partly transparent; drawn where it is at least half opaque, and left out elsewhere");
    }
    if MIXED.contains(&appearance.own_light(material)) {
        told.push("it glows and is lit; vector graphics show both as one brightness");
    }
    told
}
