//! Materials whose textures can share an atlas.
//!
//! A material is left out if its coordinates leave one repetition of the texture, since an atlas does not repeat,
//! and so is each that shows a picture together with one that is left out, since a picture is in the atlas or not.
//! Meshes whose parts have other coordinates beside the first ones stay whole.

use articula_core::source::{Character, Material, Primitive, TextureWrap};
use articula_flat::Picture;
use articula_formats::gltf::{Document, ShownPictures};
use glam::Vec2;
use std::collections::{BTreeMap, BTreeSet};

/// How far texture coordinates may leave a repetition: a tenth of a pixel of 1,000.
const TOLERANCE: f32 = 1e-4;

/// Materials that show the same pictures by the same kinds of textures.
#[derive(Debug, Clone)]
pub(super) struct Cell {
    /// Pictures with the kind of texture in whose atlas each is.
    pub(super) pictures: BTreeMap<usize, String>,
    materials: BTreeSet<usize>,
}

/// All that an atlas is to have.
#[derive(Debug, Default)]
pub(super) struct Cells {
    pub(super) cells: Vec<Cell>,
    /// Repetition of the texture in which each material is, in whole numbers.
    shifts: BTreeMap<usize, Vec2>,
    /// Materials with textures that are in no cell, with the reason.
    pub(super) left_out: Vec<(usize, &'static str)>,
    /// The pictures of all cells.
    pub(super) decoded: BTreeMap<usize, Picture>,
}

impl Cells {
    /// Finds the cells of a character.
    pub(super) fn of(character: &Character, document: &Document) -> Self {
        let shown = document.shown_pictures();
        let (shifts, mut reasons) = placed(character, &shown);
        let kinds = kinds(&shown, &shifts);
        for (m, of) in shown.iter().enumerate() {
            let named: BTreeSet<&str> = of
                .textures
                .keys()
                .filter_map(|i| kinds.get(i).copied())
                .collect();
            if shifts.contains_key(&m) && named.len() != of.textures.len() {
                reasons.insert(
                    m,
                    "two pictures of it would be in one atlas: a texture of it has a second picture, or another \
                     material shows its pictures by other textures",
                );
            }
        }
        let decode = |i: &usize| {
            let image = character.images.get(*i)?;
            Some((*i, Picture::decode(&image.bytes).ok()?))
        };
        let decoded: BTreeMap<usize, Picture> = kinds.keys().filter_map(decode).collect();
        for m in shifts.keys() {
            if shown[*m].textures.keys().any(|i| !decoded.contains_key(i)) {
                reasons.insert(*m, "a picture of it cannot be decoded");
            }
        }
        spread(&shown, &mut reasons);
        let mut found = Self {
            left_out: reasons.iter().map(|(m, why)| (*m, *why)).collect(),
            decoded,
            ..Self::default()
        };
        for (m, shift) in shifts {
            if reasons.contains_key(&m) {
                continue;
            }
            let pictures = shown[m]
                .textures
                .keys()
                .map(|i| (*i, kinds[i].to_owned()))
                .collect();
            found.shifts.insert(m, shift);
            match found
                .cells
                .iter_mut()
                .find(|cell| cell.pictures == pictures)
            {
                Some(cell) => _ = cell.materials.insert(m),
                None => found.cells.push(Cell {
                    pictures,
                    materials: BTreeSet::from([m]),
                }),
            }
        }
        found
    }

    /// The cell of a material, and by how much its texture coordinates are moved before.
    pub(super) fn of_material(&self, material: usize) -> Option<(usize, Vec2)> {
        let shift = self.shifts.get(&material)?;
        let mut cells = self.cells.iter();
        let cell = cells.position(|cell| cell.materials.contains(&material))?;
        Some((cell, *shift))
    }

    /// The materials of all cells.
    pub(super) fn materials(&self) -> impl Iterator<Item = usize> {
        self.shifts.keys().copied()
    }
}

/// The materials with textures that stay within one repetition, and why others cannot be in an atlas.
fn placed(
    character: &Character,
    shown: &[ShownPictures],
) -> (BTreeMap<usize, Vec2>, BTreeMap<usize, &'static str>) {
    let (mut shifts, mut reasons) = (BTreeMap::new(), BTreeMap::new());
    let varies = |part: &Primitive| part.material.is_some_and(|m| shown[m].varies);
    let meshes = character.meshes.iter().map(|mesh| &mesh.primitives);
    let bound: BTreeSet<usize> = meshes
        .filter(|parts| parts.iter().any(varies))
        .flat_map(|parts| parts.iter().filter_map(|part| part.material))
        .collect();
    for (m, of) in shown
        .iter()
        .enumerate()
        .filter(|(_, of)| !of.textures.is_empty())
    {
        let parts = character.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let parts: Vec<&Primitive> = parts.filter(|part| part.material == Some(m)).collect();
        let why = if of.varies {
            "its textures vary or have coordinates of their own"
        } else if bound.contains(&m) {
            "textures of a part beside it vary or have coordinates of their own"
        } else if parts
            .iter()
            .any(|part| part.texcoords.len() != part.positions.len())
        {
            "a part of it has no texture coordinates"
        } else if parts.is_empty() {
            "no part has it"
        } else if let Some(shift) = repetition(&parts, repeats(&character.materials[m])) {
            shifts.insert(m, shift);
            continue;
        } else {
            "its texture repeats"
        };
        reasons.insert(m, why);
    }
    (shifts, reasons)
}

/// Whether the textures of a material repeat along both axes.
fn repeats(material: &Material) -> bool {
    let wraps = [material.base_color_wrap, material.emissive_wrap];
    wraps
        .as_flattened()
        .iter()
        .all(|wrap| *wrap == TextureWrap::Repeat)
}

/// The repetition of the texture in which all coordinates are; of one that does not repeat the first alone.
fn repetition(parts: &[&Primitive], repeats: bool) -> Option<Vec2> {
    let all = || parts.iter().flat_map(|part| &part.texcoords);
    let least = all().copied().reduce(Vec2::min)?;
    let most = all().copied().reduce(Vec2::max)?;
    let shift = (least + TOLERANCE).floor();
    let is_inside = most.cmple(shift + 1.0 + TOLERANCE).all();
    let is_shown = repeats || shift == Vec2::ZERO;
    (is_inside && is_shown && shift.is_finite()).then_some(shift)
}

/// The kind of texture in whose atlas each picture is.
fn kinds<'a>(
    shown: &'a [ShownPictures],
    shifts: &BTreeMap<usize, Vec2>,
) -> BTreeMap<usize, &'a str> {
    let mut kinds = BTreeMap::new();
    for (picture, name) in shifts.keys().flat_map(|m| &shown[*m].textures) {
        let kind = kinds.entry(*picture).or_insert(name.as_str());
        *kind = (*kind).min(name);
    }
    kinds
}

/// Leaves out what shares a picture with what is left out.
fn spread(shown: &[ShownPictures], reasons: &mut BTreeMap<usize, &'static str>) {
    loop {
        let bound: BTreeSet<usize> = reasons
            .keys()
            .flat_map(|m| shown[*m].textures.keys())
            .copied()
            .collect();
        let mut grows = false;
        for (m, of) in shown.iter().enumerate() {
            if !reasons.contains_key(&m) && of.textures.keys().any(|i| bound.contains(i)) {
                reasons.insert(m, "it shares a picture with a material that is left out");
                grows = true;
            }
        }
        if !grows {
            return;
        }
    }
}
