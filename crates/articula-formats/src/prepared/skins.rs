//! The part `skins`: the skin of each joint LOD, as changes to that of the next finer one.
//!
//! The skin of level 0 is that of the mesh with its bindings in another order, so it takes almost
//! no bytes; each coarser level stores only the vertices whose position, normal or influences
//! differ.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::{Binding, JointLods, LevelSkin, LevelSkins, Mesh, Morph, PaletteMap};
use glam::{Affine3A, Mat3A, Vec3, Vec3A};

const POSITION: u8 = 1;
const NORMAL: u8 = 2;
const INFLUENCES: u8 = 4;

/// Influences of one vertex: binding and weight.
type Influences = Vec<(u16, f32)>;

/// The skin of a level while it is coded: influences as one list for each vertex.
#[derive(Clone)]
struct Coded {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    influences: Vec<Influences>,
    morphs: Vec<Morph>,
}

impl Coded {
    /// The mesh itself, with `places` in place of its bindings.
    fn of_mesh(mesh: &Mesh, places: &[u16]) -> Self {
        let place = |b: u16| places.get(usize::from(b)).copied().unwrap_or(u16::MAX);
        let influences = lists(mesh.influences, &mesh.binding_indices, &mesh.weights);
        let placed = |list: Influences| list.into_iter().map(|(b, w)| (place(b), w)).collect();
        Self {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            influences: influences.map(placed).collect(),
            morphs: mesh.morphs.clone(),
        }
    }

    fn of_level(skin: &LevelSkin) -> Self {
        Self {
            positions: skin.positions.clone(),
            normals: skin.normals.clone(),
            influences: lists(skin.influences, &skin.binding_indices, &skin.weights).collect(),
            morphs: skin.morphs.clone(),
        }
    }

    fn level(&self, palette: usize) -> LevelSkin {
        let influences = self.influences.iter().map(Vec::len).max().unwrap_or(1);
        let mut skin = LevelSkin {
            positions: self.positions.clone(),
            normals: self.normals.clone(),
            influences,
            morphs: self.morphs.clone(),
            palette,
            ..LevelSkin::default()
        };
        skin.binding_indices
            .reserve(influences * self.influences.len());
        skin.weights.reserve(influences * self.influences.len());
        for list in &self.influences {
            // Padding repeats the first binding of the vertex, with weight 0.
            let filler = (list.first().map_or(0, |i| i.0), 0.0);
            let padded = list.iter().copied().chain(std::iter::repeat(filler));
            for (binding, weight) in padded.take(influences) {
                skin.binding_indices.push(binding);
                skin.weights.push(weight);
            }
        }
        skin
    }
}

/// Influences of each vertex without zero weights; if all are 0, the first.
fn lists<'a>(
    each: usize,
    bindings: &'a [u16],
    weights: &'a [f32],
) -> impl Iterator<Item = Influences> + 'a {
    let vertices = bindings
        .chunks(each.max(1))
        .zip(weights.chunks(each.max(1)));
    vertices.map(|(bindings, weights)| {
        let all = || bindings.iter().copied().zip(weights.iter().copied());
        let used: Influences = all().filter(|(_, w)| *w != 0.0).collect();
        if used.is_empty() {
            all().take(1).collect()
        } else {
            used
        }
    })
}

/// Encodes the skins of all levels; `full` is the mesh that they were made from.
pub fn write_level_skins(skins: &LevelSkins, full: &Mesh) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(skins.bindings.len());
    for binding in &skins.bindings {
        out.count(usize::from(binding.joint));
        let matrix = &binding.inverse_bind;
        let (m, t) = (matrix.matrix3, matrix.translation);
        [m.x_axis, m.y_axis, m.z_axis, t]
            .iter()
            .for_each(|c| out.vector(Vec3::from(*c)));
    }
    let place = |b: &Binding| skins.bindings.iter().position(|s| s == b);
    let places: Vec<u16> = full
        .bindings
        .iter()
        .map(|b| place(b).map_or(u16::MAX, |p| p as u16))
        .collect();
    places.iter().for_each(|p| out.count(usize::from(*p)));
    let mut before = Coded::of_mesh(full, &places);
    out.count(skins.levels.len());
    for level in &skins.levels {
        let after = Coded::of_level(level);
        out.count(level.palette);
        put_changes(&mut out, &before, &after);
        before = after;
    }
    out.0
}

fn put_changes(out: &mut Writer, before: &Coded, after: &Coded) {
    let bits = |v: &Vec3| v.to_array().map(f32::to_bits);
    let flags = |v: usize| {
        let mut flags = 0;
        if bits(&before.positions[v]) != bits(&after.positions[v]) {
            flags |= POSITION;
        }
        if bits(&before.normals[v]) != bits(&after.normals[v]) {
            flags |= NORMAL;
        }
        if before.influences[v] != after.influences[v] {
            flags |= INFLUENCES;
        }
        flags
    };
    let changed: Vec<u32> = (0..after.positions.len())
        .filter(|v| flags(*v) != 0)
        .map(|v| v as u32)
        .collect();
    out.ascending(&changed);
    for v in changed {
        let v = v as usize;
        let flags = flags(v);
        out.byte(flags);
        if flags & POSITION != 0 {
            out.vector(after.positions[v]);
        }
        if flags & NORMAL != 0 {
            out.vector(after.normals[v]);
        }
        if flags & INFLUENCES != 0 {
            out.count(after.influences[v].len());
            for (binding, weight) in &after.influences[v] {
                out.count(usize::from(*binding));
                out.float(*weight);
            }
        }
    }
    for (before, after) in before.morphs.iter().zip(&after.morphs) {
        let is_changed = |i: &usize| {
            bits(&before.positions[*i]) != bits(&after.positions[*i])
                || bits(&before.normals[*i]) != bits(&after.normals[*i])
        };
        let changed: Vec<u32> = (0..after.vertices.len())
            .filter(is_changed)
            .map(|i| i as u32)
            .collect();
        out.ascending(&changed);
        for i in changed {
            out.vector(after.positions[i as usize]);
            out.vector(after.normals[i as usize]);
        }
    }
}

/// Decodes the output of [`write_level_skins`] for the same mesh and the joint LODs of the skins.
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, also if the skins are of another mesh;
/// [`ReadError::LimitExceeded`].
pub fn read_level_skins(
    bytes: &[u8],
    full: &Mesh,
    joint_lods: &JointLods,
    limits: &Limits,
) -> Result<LevelSkins, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.count(49, "bindings")?;
    let mut bindings = Vec::with_capacity(count);
    let joints = joint_lods.joints().len();
    for _ in 0..count {
        let joint = r.at_most(joints.saturating_sub(1), "a joint")?;
        let columns = r.groups(4, |c: [f32; 3]| Vec3A::from_array(c))?;
        bindings.push(Binding {
            joint: joint as u16,
            inverse_bind: Affine3A {
                matrix3: Mat3A::from_cols(columns[0], columns[1], columns[2]),
                translation: columns[3],
            },
        });
    }
    let mut places = Vec::with_capacity(full.bindings.len());
    for _ in &full.bindings {
        places.push(r.at_most(usize::from(u16::MAX), "a binding")? as u16);
    }
    let mut skin = Coded::of_mesh(full, &places);
    let levels = r.at_most(JointLods::MAX_LEVELS, "a number of levels")?;
    if levels != joint_lods.levels() {
        let what = format!("{levels} skins for {} levels", joint_lods.levels());
        return Err(r.bytes.bad(what).into());
    }
    let numbers = (levels * full.len() * (6 + 2 * full.influences)) as u64;
    Limits::check("skins", "numbers", numbers, limits.elements)?;
    let mut out = Vec::with_capacity(levels);
    for _ in 0..levels {
        let palette = r.at_most(bindings.len(), "a number of matrices")?;
        apply_changes(&mut r, &mut skin, full.influences)?;
        let most = skin
            .influences
            .iter()
            .flatten()
            .map(|i| usize::from(i.0))
            .max();
        if most.is_some_and(|b| b >= palette) {
            return Err(r
                .bytes
                .bad("an influence names a binding beyond the palette")
                .into());
        }
        out.push(skin.level(palette));
    }
    r.bytes.end()?;
    let placed = bindings.iter().map(|b| {
        (
            joint_lods.place(usize::from(b.joint)) as u16,
            b.inverse_bind,
        )
    });
    let placed: Vec<(u16, Affine3A)> = placed.collect();
    let palette = PaletteMap::skin(joint_lods, &placed).map_err(|e| r.bytes.bad(e.to_string()))?;
    if let Some(level) = (0..levels).find(|l| palette.len(*l) != out[*l].palette) {
        let what = format!("level {level} has another number of matrices than its joints need");
        return Err(r.bytes.bad(what).into());
    }
    Ok(LevelSkins {
        bindings,
        palette,
        levels: out,
    })
}

/// Applies the changes of a level; a vertex never has more influences than in the mesh.
fn apply_changes(r: &mut Numbers<'_>, skin: &mut Coded, most: usize) -> Result<(), ReadError> {
    for v in r.ascending(skin.positions.len(), "vertex")? {
        let v = v as usize;
        let flags = r.byte()?;
        if flags & POSITION != 0 {
            skin.positions[v] = r.vector()?;
        }
        if flags & NORMAL != 0 {
            skin.normals[v] = r.vector()?;
        }
        if flags & INFLUENCES != 0 {
            let count = r.at_most(most, "a number of influences")?;
            let mut list = Vec::with_capacity(count);
            for _ in 0..count {
                let binding = r.at_most(usize::from(u16::MAX), "a binding")? as u16;
                list.push((binding, r.float()?));
            }
            if list.is_empty() {
                return Err(r.bytes.bad("a vertex without influences").into());
            }
            skin.influences[v] = list;
        }
    }
    for morph in &mut skin.morphs {
        for i in r.ascending(morph.vertices.len(), "morph offset")? {
            morph.positions[i as usize] = r.vector()?;
            morph.normals[i as usize] = r.vector()?;
        }
    }
    Ok(())
}
