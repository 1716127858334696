//! Encoding and decoding of a level as refinement of a coarser one; a level alone refines an empty
//! mesh.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1, scheme RT. In the order of the bytes: number
//! of faces; connectivity with matching of known points; seams and wedges; positions of new points;
//! all other values of new points and wedges; a check sum. Both sides sort the coarser level into
//! canonical order, so its original order does not matter.

use super::attributes;
use super::canonical::{Canonical, compare_points, compare_wedges};
use super::connectivity::{self, Fault, Truth};
use super::half_edges::NONE;
use super::matching::Coarse;
use super::mesh::{Layout, QuantisedMesh};
use super::number::Natural;
use super::positions;
use super::seams::{self, Known, Wedges};
use super::surface::Surface;
use crate::range_coder::{Coder, Decoder, Encoder};
use crate::{StreamError, StreamLimits};
use articula_core::Mismatch;

/// Encodes a level, alone or as a refinement of `coarse`.
///
/// Points and wedges that no face uses are not part of a level alone.
///
/// # Errors
/// A [`Mismatch`] if either mesh does not fit the layout.
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
    // Only a decoder finds faults, except for a level that exceeds all bounds.
    coded.map_err(|fault| Mismatch::new("fine", fault))?;
    Ok(encoder.finish())
}

/// Decodes a level that [`encode_level`] encoded over the same coarser level. Its first points and
/// wedges are those of `coarse`, with the same ids; new ones follow in the order of discovery.
/// Faces are those of the level itself. The order of a level decoded alone differs from the
/// encoder's input.
///
/// # Errors
/// A [`StreamError`] if the bytes are not a valid level over this coarser one, or the level is too
/// large.
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
        let what = "unexpected bytes after the end of the level";
        return Err(StreamError::malformed("mesh level", what));
    }
    let mesh = restored(mesh, coarse, &sorted);
    let wrong = |m: Mismatch| StreamError::malformed(format!("mesh level: {}", m.at), m.what);
    mesh.check(layout).map_err(wrong)?;
    Ok(mesh)
}

/// Size limit of a level.
struct Bounds {
    elements: u64,
}

impl Bounds {
    fn none() -> Self {
        Self { elements: u64::MAX }
    }
}

/// The level to be encoded, with its matches in the coarser one.
#[derive(Clone, Copy)]
struct TrueLevel<'a> {
    fine: &'a QuantisedMesh,
    points: &'a [u32],
    wedges: &'a [u32],
}

/// Maximum number of faces, so that corner indices fit in 32 bits.
const MAX_FACES: usize = 1 << 28;
/// Memory per face while a level is decoded, in numbers of four bytes; limited because a few bytes
/// may code very many faces.
const FACE_ELEMENTS: u64 = 24;

/// Codes a level over a coarser one in canonical order; returns it with the coarser level's ids
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
        return Err("unexpected end of the bytes within the values");
    }
    let sum = check_sum(&mesh);
    if coder.raw(16, sum) != sum {
        return Err(
            "the checksum does not match; the chunk belongs to another level or is damaged",
        );
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

/// Refuses more points and wedges than the limit allows, before memory for their values is
/// allocated.
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

/// Check sum over faces and values: FNV-1a folded to 16 bits.
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
    /// An empty mesh, with the morph lists of a layout.
    fn empty(layout: &Layout) -> Self {
        Self {
            morphs: vec![Vec::new(); layout.morphs.len()],
            morph_normals: vec![Vec::new(); layout.morphs.len()],
            ..Self::default()
        }
    }

    /// Returns this mesh extended by the new points and wedges of a finer level; `point_ids` has
    /// the ids of its points, `corners` its wedges in the order of `wedges`.
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
        // The points of new wedges are added together with the faces.
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

    /// Sets the faces of a level, and adds placeholders for the values of new points and wedges.
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

/// Maps a level from canonical ids back to the ids of the given coarser level, and adds its unused
/// points and wedges; a new value that equals an unused one takes its id.
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

/// The ids below `total` that are not in a list.
fn rest(list: &[u32], total: usize) -> Vec<u32> {
    let mut is_named = vec![false; total];
    for &id in list {
        is_named[id as usize] = true;
    }
    let all = 0..total as u32;
    all.filter(|&id| !is_named[id as usize]).collect()
}

/// Returns the final id of each of `count` values, of which the first are `known`, and the list of
/// values that `find` does not identify with one of the first `total` ids.
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
