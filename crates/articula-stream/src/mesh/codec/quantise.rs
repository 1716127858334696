//! Conversion from floating point to whole numbers and back: one [`QuantisedMesh`] per level of a
//! part.
//!
//! Source: `docs/methods/clustered-mesh.md` parts 5 and 8: one grid for all levels (otherwise
//! vertices would move between levels) and for all parts of a mesh (otherwise gaps would open
//! between touching parts). Octahedral normals after Cigolle et al., "A survey of efficient
//! representations for independent unit vectors", 2014: the nearest of the four corners is taken,
//! and where a normal has two representations at the rim, always the same one. Differs: an even
//! number of steps, so that the axes are represented exactly.

use super::mesh::{Layout, MorphLayout, QuantisedMesh};
use articula_core::Mismatch;
use articula_core::source::{MorphTarget, Primitive};
use glam::{DVec3, Vec2, Vec3, Vec4};

mod levels;
mod octahedral;
mod weights;

pub(super) use octahedral::normal_of;

/// Number of bits per quantised coordinate, by kind of value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Precision {
    /// Bits of each position coordinate, 1 to 20.
    pub position_bits: u8,
    /// Bits of each octahedral coordinate of a normal, 2 to 16.
    pub normal_bits: u8,
    /// Bits of each texture coordinate, 1 to 20.
    pub texcoord_bits: u8,
}

impl Default for Precision {
    fn default() -> Self {
        Self {
            position_bits: 14,
            normal_bits: 10,
            texcoord_bits: 12,
        }
    }
}

/// Maximum morph offset in steps of the grid, either way.
pub(super) const LARGEST_OFFSET: i32 = 1 << 24;
/// Maximum change of a normal's coordinate in 1/127, either way.
pub(super) const LARGEST_TURN: i32 = 1023;
/// Minimum grid step relative to the largest coordinate, so that neighbouring grid values differ as
/// `f32`.
const FINEST: f64 = 1.0 / (1 << 22) as f64;

/// Grid of quantised positions: `origin + step * n`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Position of (0, 0, 0), in metres.
    pub origin: Vec3,
    /// Distance of neighbouring grid positions along an axis, in metres.
    pub step: f32,
}

/// Scale from whole numbers to metres and texture coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// Grid of positions and morph offsets.
    pub grid: Grid,
    /// Texture coordinates of (0, 0); values are `origin + step * n`.
    pub texcoord_origin: Vec2,
    /// Distance of neighbouring texture coordinates.
    pub texcoord_step: f32,
}

/// All levels of a part as quantised meshes, with the scale back to floating point.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantised {
    /// Layout of all levels.
    pub layout: Layout,
    /// Scale back to floating point.
    pub scale: Scale,
    /// One mesh per level, finest first. By value, a finer level contains all points and wedges of
    /// a coarser one, if its triangles use all of the coarser level's vertices.
    pub levels: Vec<QuantisedMesh>,
    /// Number of faces left out because rounding made two of their corners equal, over all levels.
    pub degenerate_faces: usize,
    /// Number of faces left out because they equal another face of their level.
    pub duplicate_faces: usize,
    /// Maximum distance that rounding moved a vertex, in metres.
    pub rounding_metres: f32,
}

impl Grid {
    /// Creates the grid of the parts of a mesh, with 2^`bits` - 1 steps along the widest axis.
    ///
    /// # Errors
    /// A [`Mismatch`] if a position is not finite or `bits` is not 1 to 20.
    pub fn new(parts: &[Primitive], bits: u8) -> Result<Self, Mismatch> {
        check_bits("position_bits", bits, 1..=20)?;
        let mut bounds: Option<(Vec3, Vec3)> = None;
        for (i, part) in parts.iter().enumerate() {
            let at = |a| format!("parts[{i}].positions[{a}]");
            for (v, p) in part.positions.iter().enumerate() {
                check_finite(p.to_array(), || at(v))?;
                let (low, high) = bounds.unwrap_or((*p, *p));
                bounds = Some((low.min(*p), high.max(*p)));
            }
        }
        let (low, high) = bounds.unwrap_or_default();
        let extent = (high.as_dvec3() - low.as_dvec3()).max_element();
        let reach = low.abs().max(high.abs()).max_element();
        Ok(Self {
            origin: low,
            step: step_of(extent, f64::from(reach), bits),
        })
    }

    /// Position of a grid value, in metres.
    fn place(&self, n: [i32; 3]) -> Vec3 {
        let n = DVec3::from(n.map(f64::from));
        (self.origin.as_dvec3() + n * f64::from(self.step)).as_vec3()
    }

    fn round(&self, p: Vec3, bits: u8) -> [i32; 3] {
        let n = (p.as_dvec3() - self.origin.as_dvec3()) / f64::from(self.step);
        n.to_array().map(|n| on_grid(n, bits))
    }
}

/// Step that divides `extent` into 2^bits - 1, but large enough that values up to `reach` differ as
/// `f32`.
fn step_of(extent: f64, reach: f64, bits: u8) -> f32 {
    let most = f64::from((1u32 << bits) - 1);
    let step = (extent / most).max(reach * FINEST) as f32;
    // Rounding to f32 cannot push the far end beyond the last grid value by half a step; an extent
    // that underflows can.
    if step.is_normal() { step } else { 1.0 }
}

fn on_grid(n: f64, bits: u8) -> i32 {
    n.round().clamp(0.0, f64::from((1u32 << bits) - 1)) as i32
}

fn check_bits(at: &str, bits: u8, may: std::ops::RangeInclusive<u8>) -> Result<(), Mismatch> {
    if may.contains(&bits) {
        return Ok(());
    }
    let what = format!("{bits} bits, expected {} to {}", may.start(), may.end());
    Err(Mismatch::new(at, what))
}

fn check_finite<const N: usize>(
    values: [f32; N],
    at: impl FnOnce() -> String,
) -> Result<(), Mismatch> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(v) => Err(Mismatch::new(at(), format!("{v} is not finite"))),
    }
}

fn check_length(at: &str, found: usize, expected: usize) -> Result<(), Mismatch> {
    if found == expected {
        return Ok(());
    }
    Err(Mismatch::new(
        at,
        format!("{found} entries, expected {expected}"),
    ))
}

/// Quantises one part. `levels` are its triangles at each level, finest first, as indices of its
/// vertices; the part's own triangle list is ignored.
///
/// Vertices that no level uses are left out; equal ones are merged. A normal of zero length becomes
/// +Z; colours are clamped to 0 to 1.
///
/// # Errors
/// A [`Mismatch`] if lists differ in length, an index is out of range, a number is not finite, a
/// vertex has no weight, a morph offset exceeds 2^24 steps, or a change of a normal exceeds 8.
pub fn quantise(
    part: &Primitive,
    levels: &[Vec<[u32; 3]>],
    grid: &Grid,
    precision: &Precision,
) -> Result<Quantised, Mismatch> {
    let layout = layout_of(part, precision)?;
    let (texcoord_origin, texcoord_step) = texcoord_grid(part, layout.texcoord_bits)?;
    let scale = Scale {
        grid: *grid,
        texcoord_origin,
        texcoord_step,
    };
    let whole = whole_numbers(part, &layout, &scale)?;
    let moved = part.positions.iter().zip(&whole.positions);
    let rounding_metres = moved
        .map(|(p, n)| p.distance(grid.place(*n)))
        .fold(0.0, f32::max);
    let mut out = Quantised {
        layout,
        scale,
        levels: Vec::with_capacity(levels.len()),
        degenerate_faces: 0,
        duplicate_faces: 0,
        rounding_metres,
    };
    levels::merge(&whole, levels, &mut out)?;
    Ok(out)
}

/// Converts a mesh back to floating point: one vertex per wedge, in the same order.
///
/// `mesh` must be valid for its layout ([`QuantisedMesh::check`]).
pub fn restore(mesh: &QuantisedMesh, layout: &Layout, scale: &Scale) -> Primitive {
    let points = || mesh.wedge_points.iter().map(|p| *p as usize);
    let influences = mesh.skins.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let mut out = Primitive {
        positions: points()
            .map(|p| scale.grid.place(mesh.positions[p]))
            .collect(),
        normals: mesh
            .normals
            .iter()
            .map(|n| normal_of(*n, layout.normal_bits).as_vec3())
            .collect(),
        influences,
        triangles: mesh.faces.clone(),
        ..Primitive::default()
    };
    let place = |n: &[i32; 2]| {
        let n = n.map(f64::from);
        let at =
            |i: usize| f64::from(scale.texcoord_origin[i]) + n[i] * f64::from(scale.texcoord_step);
        Vec2::new(at(0) as f32, at(1) as f32)
    };
    out.texcoords = mesh.texcoords.iter().map(place).collect();
    let share = |c: &[u8; 4]| Vec4::from(c.map(|c| f32::from(c) / 255.0));
    out.colors = mesh.colors.iter().map(share).collect();
    if layout.joints > 0 {
        for skin in points().map(|p| &mesh.skins[p]) {
            let filler = skin.first().map_or(0, |i| i.0);
            for k in 0..influences {
                let (joint, weight) = skin.get(k).copied().unwrap_or((filler, 0));
                out.joints.push(joint);
                out.weights.push(f32::from(weight) / 255.0);
            }
        }
    }
    let step = f64::from(scale.grid.step);
    let metres = |o: [i32; 3]| (DVec3::from(o.map(f64::from)) * step).as_vec3();
    for (m, offsets) in mesh.morphs.iter().enumerate() {
        let turns = mesh.morph_normals.get(m);
        let turn = |t: &[i32; 3]| Vec3::from(t.map(|t| t as f32 / 127.0));
        out.morphs.push(MorphTarget {
            positions: points().map(|p| metres(offsets[p])).collect(),
            normals: turns.map_or(Vec::new(), |t| t.iter().map(turn).collect()),
        });
    }
    out
}

fn layout_of(part: &Primitive, precision: &Precision) -> Result<Layout, Mismatch> {
    check_bits("position_bits", precision.position_bits, 1..=20)?;
    check_bits("normal_bits", precision.normal_bits, 2..=16)?;
    check_bits("texcoord_bits", precision.texcoord_bits, 1..=20)?;
    let vertices = part.positions.len();
    let lengths = [
        ("normals", part.normals.len()),
        ("texcoords", part.texcoords.len()),
        ("colors", part.colors.len()),
    ];
    for (at, length) in lengths.into_iter().filter(|l| l.1 > 0) {
        check_length(at, length, vertices)?;
    }
    for (m, morph) in part.morphs.iter().enumerate() {
        check_length(
            &format!("morphs[{m}].positions"),
            morph.positions.len(),
            vertices,
        )?;
        if !morph.normals.is_empty() {
            check_length(
                &format!("morphs[{m}].normals"),
                morph.normals.len(),
                vertices,
            )?;
        }
    }
    if !part.joints.is_empty() || !part.weights.is_empty() {
        check_length("joints", part.joints.len(), vertices * part.influences)?;
        check_length("weights", part.weights.len(), vertices * part.influences)?;
    }
    let joints = part.joints.iter().max().map_or(0, |j| u32::from(*j) + 1);
    let joints = u16::try_from(joints)
        .map_err(|_| Mismatch::new("joints", "65536 joints, the codec supports at most 65535"))?;
    let bits = |has: bool, bits: u8| if has { bits } else { 0 };
    Ok(Layout {
        position_bits: precision.position_bits,
        normal_bits: bits(!part.normals.is_empty(), precision.normal_bits),
        texcoord_bits: bits(!part.texcoords.is_empty(), precision.texcoord_bits),
        has_colors: !part.colors.is_empty(),
        joints,
        morphs: part.morphs.iter().map(morph_layout).collect(),
    })
}

fn morph_layout(morph: &MorphTarget) -> MorphLayout {
    MorphLayout {
        has_normals: !morph.normals.is_empty(),
    }
}

/// Origin and step of the texture coordinates.
fn texcoord_grid(part: &Primitive, bits: u8) -> Result<(Vec2, f32), Mismatch> {
    let Some(first) = part.texcoords.first() else {
        return Ok((Vec2::ZERO, 1.0));
    };
    let (mut low, mut high) = (*first, *first);
    for (v, t) in part.texcoords.iter().enumerate() {
        check_finite(t.to_array(), || format!("texcoords[{v}]"))?;
        (low, high) = (low.min(*t), high.max(*t));
    }
    let extent = (high.as_dvec2() - low.as_dvec2()).max_element();
    let reach = low.abs().max(high.abs()).max_element();
    Ok((low, step_of(extent, f64::from(reach), bits)))
}

/// Quantises the part to a mesh with one point and one wedge per vertex, without faces.
fn whole_numbers(
    part: &Primitive,
    layout: &Layout,
    scale: &Scale,
) -> Result<QuantisedMesh, Mismatch> {
    let vertices = part.positions.len();
    let mut out = QuantisedMesh {
        wedge_points: (0..vertices as u32).collect(),
        ..QuantisedMesh::default()
    };
    for (v, p) in part.positions.iter().enumerate() {
        check_finite(p.to_array(), || format!("positions[{v}]"))?;
        out.positions
            .push(scale.grid.round(*p, layout.position_bits));
    }
    for (v, n) in part.normals.iter().enumerate() {
        check_finite(n.to_array(), || format!("normals[{v}]"))?;
        out.normals
            .push(octahedral::nearest(n.as_dvec3(), layout.normal_bits));
    }
    for t in &part.texcoords {
        let n = (t.as_dvec2() - scale.texcoord_origin.as_dvec2()) / f64::from(scale.texcoord_step);
        out.texcoords
            .push(n.to_array().map(|n| on_grid(n, layout.texcoord_bits)));
    }
    for (v, c) in part.colors.iter().enumerate() {
        check_finite(c.to_array(), || format!("colors[{v}]"))?;
        let byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
        out.colors.push(c.to_array().map(byte));
    }
    if layout.joints > 0 {
        for v in 0..vertices {
            let at = v * part.influences..(v + 1) * part.influences;
            let skin = weights::bytes(&part.joints[at.clone()], &part.weights[at])
                .map_err(|what| Mismatch::new(format!("weights of vertex {v}"), what))?;
            out.skins.push(skin);
        }
    }
    for (m, morph) in part.morphs.iter().enumerate() {
        let step = f64::from(scale.grid.step);
        let at = |list: &str, v: usize| format!("morphs[{m}].{list}[{v}]");
        let offsets = rounded(&morph.positions, 1.0 / step, LARGEST_OFFSET);
        let turns = rounded(&morph.normals, 127.0, LARGEST_TURN);
        let wrong = |list| move |(v, what)| Mismatch::new(at(list, v), what);
        out.morphs.push(offsets.map_err(wrong("positions"))?);
        out.morph_normals.push(turns.map_err(wrong("normals"))?);
    }
    Ok(out)
}

/// Scales and rounds vectors; the error names the first that is not finite or too large.
fn rounded(vectors: &[Vec3], scale: f64, largest: i32) -> Result<Vec<[i32; 3]>, (usize, String)> {
    let whole = |(v, o): (usize, &Vec3)| {
        let n = (o.as_dvec3() * scale).round();
        if n.abs().max_element() <= f64::from(largest) && n.is_finite() {
            return Ok(n.to_array().map(|n| n as i32));
        }
        Err((v, format!("{o} is not finite or too large")))
    };
    vectors.iter().enumerate().map(whole).collect()
}

#[cfg(test)]
mod tests;
