//! Writes the player's container `ARTV`.
//!
//! Source: `docs/methods/vector.md` 8.3, `docs/formats/artv.md` (byte by byte).

use super::clip::PlayerClip;
use super::deflate::smallest;
use super::stream::Writer;
use super::topology::{parents, wedge_parents};
use crate::low_rank::quantised::QuantisedComponent;
use crate::planar::shading::Shading;

/// First bytes of a container.
pub(crate) const MAGIC: [u8; 4] = *b"ARTV";
/// Version of the container that is written and read.
pub(crate) const VERSION: u8 = 1;
/// Flag: triangles are shaded, so wedges have light and colours.
pub(super) const GOURAUD: u32 = 1;
/// Flag: components are inputs, whose names follow at the end.
pub(super) const INPUTS: u32 = 2;
/// Flag: triangles show a picture, which follows at the end.
pub(super) const TEXTURE: u32 = 4;

/// Size of each part before compression, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct PartSizes {
    /// Sizes, rates and units.
    pub header: usize,
    /// Corners of the triangles.
    pub triangles: usize,
    /// Colours.
    pub colors: usize,
    /// Spans in which triangles are drawn.
    pub shown: usize,
    /// Painting orders.
    pub epochs: usize,
    /// Mean positions and light.
    pub mean: usize,
    /// Bases of the components.
    pub bases: usize,
    /// Coefficients of the components.
    pub coefficients: usize,
    /// Names of inputs.
    pub inputs: usize,
    /// Texture coordinates and the picture.
    pub texture: usize,
}

/// Encodes a clip as bytes of the script player's container.
pub fn encode(clip: &PlayerClip) -> Vec<u8> {
    encode_parts(clip).0
}

/// Returns the bytes of a container and the sizes of its parts.
pub(crate) fn encode_parts(clip: &PlayerClip) -> (Vec<u8>, PartSizes) {
    let mut to = Writer::default();
    let mut sizes = PartSizes::default();
    let mut at = 0;
    let mut passed = |to: &Writer| to.0.len() - std::mem::replace(&mut at, to.0.len());
    header(&mut to, clip);
    sizes.header = passed(&to);
    corners(&mut to, clip);
    sizes.triangles = passed(&to);
    colors(&mut to, &clip.colors);
    sizes.colors = passed(&to);
    shown(&mut to, clip);
    sizes.shown = passed(&to);
    epochs(&mut to, clip);
    sizes.epochs = passed(&to);
    let has_light = clip.shading == Shading::Gouraud;
    let parents = parents(&clip.triangles, &clip.wedge_points, has_light);
    predicted(&mut to, &clip.motion.mean, &parents);
    sizes.mean = passed(&to);
    for component in &clip.motion.components {
        basis(&mut to, component, &parents);
    }
    sizes.bases = passed(&to);
    for component in &clip.motion.components {
        coefficients(&mut to, &component.coefficients);
    }
    sizes.coefficients = passed(&to);
    for name in &clip.inputs {
        to.unsigned(name.encode_utf16().count() as u32);
        name.encode_utf16()
            .for_each(|unit| to.unsigned(unit.into()));
    }
    sizes.inputs = passed(&to);
    if let Some(texture) = &clip.texture {
        texture.write(&mut to, &clip.triangles, &wedge_parents(&clip.triangles));
    }
    sizes.texture = passed(&to);
    (packed(&to.0), sizes)
}

/// Magic, version and the smallest Deflate stream.
fn packed(body: &[u8]) -> Vec<u8> {
    [&MAGIC[..], &[VERSION], &smallest(body)].concat()
}

fn header(to: &mut Writer, clip: &PlayerClip) {
    let gouraud = u32::from(clip.shading == Shading::Gouraud) * GOURAUD;
    let inputs = u32::from(!clip.inputs.is_empty()) * INPUTS;
    let texture = u32::from(clip.texture.is_some()) * TEXTURE;
    for value in [
        clip.width,
        clip.height,
        clip.frames,
        clip.triangles.len() as u32,
        clip.epochs.len() as u32,
        clip.motion.components.len() as u32,
        gouraud | inputs | texture,
    ] {
        to.unsigned(value);
    }
    to.real(f64::from(clip.fps));
    to.real(clip.motion.step);
    to.real(clip.light_weight);
}

fn corners(to: &mut Writer, clip: &PlayerClip) {
    let (mut wedges, mut points) = (0, 0);
    for wedge in clip.triangles.iter().flatten() {
        to.unsigned(wedges - wedge);
        if *wedge == wedges {
            let point = clip.wedge_points[wedges as usize];
            to.unsigned(points - point);
            points += u32::from(point == points);
            wedges += 1;
        }
    }
}

fn colors(to: &mut Writer, colors: &[[u8; 3]]) {
    let mut known: Vec<[u8; 3]> = Vec::new();
    for color in colors {
        let at = known.iter().position(|k| k == color).unwrap_or(known.len());
        to.unsigned((known.len() - at) as u32);
        if at == known.len() {
            to.0.extend_from_slice(color);
            known.push(*color);
        }
    }
}

fn shown(to: &mut Writer, clip: &PlayerClip) {
    for spans in &clip.shown {
        let turns: Vec<u32> = spans
            .iter()
            .flat_map(|span| [span.start, span.end])
            .filter(|frame| *frame < clip.frames)
            .collect();
        to.unsigned(turns.len() as u32);
        let mut before = 0;
        for turn in turns {
            to.unsigned(turn - before);
            before = turn;
        }
    }
}

fn epochs(to: &mut Writer, clip: &PlayerClip) {
    let mut first = 0;
    for epoch in &clip.epochs {
        to.unsigned(epoch.first_frame - first);
        first = epoch.first_frame;
        to.unsigned(epoch.order.len() as u32);
        let mut next = 0;
        for triangle in &epoch.order {
            let triangle = *triangle as i32;
            to.signed(triangle - next);
            next = triangle + 1;
        }
    }
}

fn differences(values: &[i32], parents: &[u32]) -> Vec<i32> {
    let pairs = values.iter().zip(parents).enumerate();
    pairs
        .map(|(at, (value, parent))| match *parent as usize {
            own if own == at => *value,
            parent => value - values[parent],
        })
        .collect()
}

fn predicted(to: &mut Writer, values: &[i32], parents: &[u32]) {
    for value in differences(values, parents) {
        to.signed(value);
    }
}

/// Estimated number of bits of the encoded numbers.
fn bits(values: &[i32]) -> f64 {
    let of = |v: &i32| (1.0 + f64::from(v.unsigned_abs())).log2();
    values.iter().map(of).sum()
}

fn basis(to: &mut Writer, component: &QuantisedComponent, parents: &[u32]) {
    to.real(component.scale);
    let guessed = differences(&component.basis, parents);
    let is_guessed = bits(&guessed) < bits(&component.basis);
    to.unsigned(u32::from(is_guessed));
    let values = if is_guessed {
        &guessed
    } else {
        &component.basis
    };
    values.iter().for_each(|v| to.signed(*v));
}

fn coefficients(to: &mut Writer, values: &[i32]) {
    let change = |of: &[i32]| {
        let mut before = 0;
        of.iter()
            .map(|v| v - std::mem::replace(&mut before, *v))
            .collect::<Vec<_>>()
    };
    let first = change(values);
    let second = change(&first);
    let is_second = bits(&second) < bits(&first);
    to.unsigned(u32::from(is_second));
    let values = if is_second { second } else { first };
    values.iter().for_each(|v| to.signed(*v));
}
