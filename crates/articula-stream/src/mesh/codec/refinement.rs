//! What one level adds to a coarser one, as bytes and back; a level alone adds to nothing.
//!
//! Source: `docs/methods/clustered-mesh.md` 8.1, scheme RT. In the order of the bytes: number of faces;
//! connectivity with the known points matched on the way; seams and wedges; positions of the new
//! points; all other values of what is new; a check sum. Both sides see the coarser level in
//! canonical order, so it may come in any.

use super::attributes;
use super::canonical::{Canonical, compare_points, compare_wedges};
use super::connectivity::{self, Fault, Truth};
use super::half_edges::NONE;
use super::matching::Coarse;
use super::mesh::{Layout, QuantisedMesh};
use super::number::Natural;
use super::positions;
use super::range_coder::{Coder, Decoder, Encoder};
use super::seams::{self, Known, Wedges};
use super::surface::Surface;
use crate::{StreamError, StreamLimits};
use articula_core::Mismatch;

/// One level alone, or what turns a coarser level into it.
///
/// Points and wedges that no face uses are not part of a level alone.
///
/// # Errors
/// A [`Mismatch`] if either mesh is not of the layout.
pub fn encode_level(
    coarse: Option<&QuantisedMesh>,
    fine: &QuantisedMesh,
    layout: &Layout,
) -> Result<Vec<u8>, Mismatch> {
    let nothing = QuantisedMesh::empty(layout);
    let coarse = coarse.unwrap_or(&nothing);
    coarse.check(layout)?;
    fine.check(layout)?;
    let (coarse, fine) = (Canonical::new(coarse), Canonical::new(fine));
    let (points, wedges) = coarse.matches(&fine);
    let mut encoder = Encoder::new();
    let truth = TrueLevel {
        fine: &fine.mesh,
        points: &points,
        wedges: &wedges,
    };
    let coded = code(
        &mut encoder,
        &coarse.mesh,
        layout,
        &Bounds::none(),
        Some(truth),
    );
    // Only a decoder finds faults, with the one exception of a level beyond all bounds.
    coded.map_err(|fault| Mismatch::new("fine", fault))?;
    Ok(encoder.finish())
}

/// The level that [`encode_level`] was given, over the same coarser level if there was one. Its
/// first points and wedges are then those of the coarser one, by the same ids, new ones follow in
/// the order of discovery; the faces are its own. A level alone comes in an order of its own.
///
/// # Errors
/// A [`StreamError`] that says where the bytes make no level over this coarser one, or that it is
/// too large.
pub fn decode_level(
    coarse: Option<&QuantisedMesh>,
    bytes: &[u8],
    layout: &Layout,
    limits: &StreamLimits,
) -> Result<QuantisedMesh, StreamError> {
    let nothing = QuantisedMesh::empty(layout);
    let coarse = coarse.unwrap_or(&nothing);
    let wrong = |m: Mismatch| StreamError::malformed(format!("coarser level: {}", m.at), m.what);
    coarse.check(layout).map_err(wrong)?;
    let sorted = Canonical::new(coarse);
    let mut decoder = Decoder::new(bytes);
    let bounds = Bounds {
        elements: limits.elements,
    };
    let coded = code(&mut decoder, &sorted.mesh, layout, &bounds, None);
    let mesh = coded.map_err(|fault| StreamError::malformed("mesh level", fault))?;
    if !decoder.is_spent() {
        let what = "there are bytes after the end of the level";
        return Err(StreamError::malformed("mesh level", what));
    }
    let mesh = restored(mesh, coarse, &sorted);
    let wrong = |m: Mismatch| StreamError::malformed(format!("mesh level: {}", m.at), m.what);
    mesh.check(layout).map_err(wrong)?;
    Ok(mesh)
}

/// How much a level may hold.
struct Bounds {
    elements: u64,
}

impl Bounds {
    fn none() -> Self {
        Self { elements: u64::MAX }
    }
}

/// The level that an encoder describes, and what of it is known.
#[derive(Clone, Copy)]
struct TrueLevel<'a> {
    fine: &'a QuantisedMesh,
    points: &'a [u32],
    wedges: &'a [u32],
}

/// Largest number of faces, so that corners can be counted.
const MAX_FACES: usize = 1 << 28;
/// What a face takes while a level is put together, in numbers of four bytes: a few bytes may name
/// very many faces.
const FACE_ELEMENTS: u64 = 24;

/// Codes a level over a coarser one in canonical order; gives it with the coarser one's ids
/// first.
fn code(
    coder: &mut impl Coder,
    coarse: &QuantisedMesh,
    layout: &Layout,
    bounds: &Bounds,
    truth: Option<TrueLevel<'_>>,
) -> Result<QuantisedMesh, Fault> {
    let count = truth.map_or(0, |t| t.fine.faces.len());
    let count = Natural::default().code(coder, count as u32) as usize;
    if count > MAX_FACES || count as u64 * FACE_ELEMENTS > bounds.elements {
        return Err("more faces than the limit allows");
    }
    let true_faces: Option<Vec<[u32; 3]>> = truth.map(|t| t.fine.point_faces().collect());
    let mut true_walk = truth
        .zip(true_faces.as_ref())
        .map(|(t, faces)| Truth::new(faces, t.points, coarse.points()));
    let view = Coarse::new(coarse);
    let walked = connectivity::walk(coder, &view, true_walk.as_mut(), count)?;
    let points = coarse.points() + walked.new_points;
    // Every point has a wedge.
    check_size(layout, bounds, points, points)?;
    let true_corners: Option<Vec<[u32; 3]>> = truth.zip(true_walk.as_ref()).map(|(t, walk)| {
        let corner = |h: u32| t.fine.faces[h as usize / 3][h as usize % 3];
        let turned = |&h: &u32| {
            let face = h - h % 3;
            [h, face + (h + 1) % 3, face + (h + 2) % 3].map(corner)
        };
        walk.firsts().iter().map(turned).collect()
    });
    let true_wedges = truth
        .zip(true_corners.as_deref())
        .map(|(t, corners)| (corners, t.wedges));
    let known = Known::new(coarse);
    let wedges = seams::code_wedges(coder, &walked.faces, points, (&view, &known), true_wedges)?;
    check_size(
        layout,
        bounds,
        points,
        coarse.wedges() + wedges.new_points.len(),
    )?;
    let given = truth.zip(true_walk.as_ref()).zip(true_corners.as_deref());
    let mut mesh = given.map_or_else(
        || coarse.clone(),
        |((t, walk), corners)| coarse.extended(t.fine, walk.ids(), corners, &wedges),
    );
    mesh.reserve_values(layout, points, &wedges);
    let is_given = truth.is_some();
    let places = (mesh.positions.as_mut_slice(), is_given);
    let known_points = coarse.points();
    positions::code_positions(
        coder,
        &walked.faces,
        known_points,
        layout.position_bits,
        places,
    )?;
    code_rest(coder, coarse, layout, &mut mesh);
    if coder.is_exhausted() {
        return Err("the bytes end within the values");
    }
    let sum = check_sum(&mesh);
    if coder.raw(16, sum) != sum {
        return Err("the check sum is that of another level");
    }
    Ok(mesh)
}

fn code_rest(
    coder: &mut impl Coder,
    coarse: &QuantisedMesh,
    layout: &Layout,
    mesh: &mut QuantisedMesh,
) {
    let faces = mesh.faces.clone();
    let wedge_points = mesh.wedge_points.clone();
    let surface = Surface {
        faces: &faces,
        wedge_points: &wedge_points,
        known_points: coarse.points(),
        known_wedges: coarse.wedges(),
    };
    attributes::code_values(coder, &surface, layout, mesh);
}

/// Refuses more points and wedges than the limit allows, before there is room for their values.
fn check_size(layout: &Layout, bounds: &Bounds, points: usize, wedges: usize) -> Result<(), Fault> {
    let of_skin = if layout.joints > 0 { 8 } else { 0 };
    let of_point = 3 + of_skin + layout.morphs.len() as u64 * 3;
    let of_wedge = 8 + layout.morphs.len() as u64 * 3;
    let elements = points as u64 * of_point + wedges as u64 * of_wedge;
    if elements > bounds.elements {
        return Err("more values than the limit allows");
    }
    Ok(())
}

/// A sum over faces and values, FNV-1a folded to 16 bits.
fn check_sum(mesh: &QuantisedMesh) -> u32 {
    let mut sum = 0xcbf2_9ce4_8422_2325_u64;
    let mut add = |x: u32| sum = (sum ^ u64::from(x)).wrapping_mul(0x0100_0000_01b3);
    mesh.faces.as_flattened().iter().for_each(|&x| add(x));
    mesh.wedge_points.iter().for_each(|&x| add(x));
    let whole = [&mesh.positions].into_iter().chain(&mesh.morphs);
    for values in whole.chain(&mesh.morph_normals) {
        values.as_flattened().iter().for_each(|&x| add(x as u32));
    }
    for values in [&mesh.normals, &mesh.texcoords] {
        values.as_flattened().iter().for_each(|&x| add(x as u32));
    }
    for &(joint, weight) in mesh.skins.iter().flatten() {
        add(u32::from(joint) << 8 | u32::from(weight));
    }
    mesh.colors.iter().for_each(|c| add(u32::from_le_bytes(*c)));
    ((sum >> 32 ^ sum ^ sum >> 16 ^ sum >> 48) & 0xffff) as u32
}

impl QuantisedMesh {
    /// Nothing, with the lists of morphs that a layout asks for.
    fn empty(layout: &Layout) -> Self {
        Self {
            morphs: vec![Vec::new(); layout.morphs.len()],
            morph_normals: vec![Vec::new(); layout.morphs.len()],
            ..Self::default()
        }
    }

    /// This and what is new in a finer level, whose points have the ids `point_ids`, and whose
    /// wedges stand at `corners` of the faces of `wedges`.
    fn extended(
        &self,
        fine: &Self,
        point_ids: &[u32],
        corners: &[[u32; 3]],
        wedges: &Wedges,
    ) -> Self {
        let known_points = self.points() as u32;
        let mut points: Vec<(u32, u32)> = (0u32..)
            .zip(point_ids)
            .filter(|(_, id)| **id >= known_points)
            .map(|(point, &id)| (id, point))
            .collect();
        points.sort_unstable();
        let points: Vec<u32> = points.into_iter().map(|p| p.1).collect();
        let known_wedges = self.wedges() as u32;
        let mut sources = vec![NONE; wedges.new_points.len()];
        for (&wedge, &source) in wedges.faces.iter().flatten().zip(corners.iter().flatten()) {
            if wedge >= known_wedges {
                sources[(wedge - known_wedges) as usize] = source;
            }
        }
        let mut joined = self.clone();
        joined.append(fine.picked(&points, &sources));
        // The points of new wedges come with the faces.
        joined.wedge_points.truncate(self.wedges());
        joined
    }

    fn append(&mut self, other: Self) {
        self.positions.extend(other.positions);
        self.skins.extend(other.skins);
        self.wedge_points.extend(other.wedge_points);
        self.normals.extend(other.normals);
        self.texcoords.extend(other.texcoords);
        self.colors.extend(other.colors);
        let pairs = self.morphs.iter_mut().zip(other.morphs);
        let normals = self.morph_normals.iter_mut().zip(other.morph_normals);
        for (mine, theirs) in pairs.chain(normals) {
            mine.extend(theirs);
        }
    }

    /// Gives a level its faces, and room for the values of what is new where there is none yet.
    fn reserve_values(&mut self, layout: &Layout, points: usize, wedges: &Wedges) {
        let known_wedges = self.wedge_points.len();
        self.wedge_points.extend(&wedges.new_points);
        self.faces = wedges.faces.clone();
        let count = known_wedges + wedges.new_points.len();
        let there = |has: bool, n: usize| if has { n } else { 0 };
        self.positions.resize(points, [0; 3]);
        self.skins
            .resize(there(layout.joints > 0, points), Vec::new());
        self.normals
            .resize(there(layout.normal_bits > 0, count), [0; 2]);
        self.texcoords
            .resize(there(layout.texcoord_bits > 0, count), [0; 2]);
        self.colors.resize(there(layout.has_colors, count), [0; 4]);
        for (m, morph) in layout.morphs.iter().enumerate() {
            self.morphs[m].resize(points, [0; 3]);
            self.morph_normals[m].resize(there(morph.has_normals, count), [0; 3]);
        }
    }
}

/// A level over the canonical ids of the coarser one, with the ids that the coarser one came
/// with, and with what none of its faces used; a new value that is one of those becomes that one.
fn restored(mesh: QuantisedMesh, coarse: &QuantisedMesh, sorted: &Canonical) -> QuantisedMesh {
    let mut unused = rest(&sorted.points, coarse.points());
    unused.sort_by(|&i, &j| compare_points((coarse, i), (coarse, j)));
    let find = |point: u32| {
        let at = unused.binary_search_by(|&u| compare_points((coarse, u), (&mesh, point)));
        at.ok().map(|at| unused[at])
    };
    let (points, new_points) = ids(&sorted.points, coarse.points(), mesh.points(), find);

    let compare = |(m, i, p): (&QuantisedMesh, u32, u32), (n, j, q): (&QuantisedMesh, u32, u32)| {
        p.cmp(&q).then_with(|| compare_wedges((m, i), (n, j)))
    };
    let mut unused = rest(&sorted.wedges, coarse.wedges());
    let known = |w: u32| (coarse, w, coarse.wedge_points[w as usize]);
    unused.sort_by(|&i, &j| compare(known(i), known(j)));
    let point_of = |w: u32| points[mesh.wedge_points[w as usize] as usize];
    let find = |wedge: u32| {
        let new = (&mesh, wedge, point_of(wedge));
        let at = unused.binary_search_by(|&u| compare(known(u), new));
        at.ok().map(|at| unused[at])
    };
    let (wedges, new_wedges) = ids(&sorted.wedges, coarse.wedges(), mesh.wedges(), find);

    let mut new = mesh.picked(&new_points, &new_wedges);
    for point in &mut new.wedge_points {
        *point = points[*point as usize];
    }
    let mut found = coarse.clone();
    found.append(new);
    let faces = mesh.faces.iter();
    found.faces = faces.map(|f| f.map(|w| wedges[w as usize])).collect();
    found
}

/// The ids below `total` that a list does not name.
fn rest(list: &[u32], total: usize) -> Vec<u32> {
    let mut is_named = vec![false; total];
    for &id in list {
        is_named[id as usize] = true;
    }
    let all = 0..total as u32;
    all.filter(|&id| !is_named[id as usize]).collect()
}

/// The final id of each of `count` values, of which the first are `known`, and those of the
/// others that are neither found elsewhere nor among the first `total`.
fn ids(
    known: &[u32],
    total: usize,
    count: usize,
    find: impl Fn(u32) -> Option<u32>,
) -> (Vec<u32>, Vec<u32>) {
    let mut ids = known.to_vec();
    let mut new = Vec::new();
    for value in known.len() as u32..count as u32 {
        ids.push(find(value).unwrap_or_else(|| {
            new.push(value);
            (total + new.len()) as u32 - 1
        }));
    }
    (ids, new)
}

#[cfg(test)]
mod tests;
