//! The part `vertexOrder`: vertices and triangles of the source file, where mesh levels have
//! reordered them.

use super::numbers::{Numbers, Writer};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::Mismatch;
use articula_core::source::{Primitive, RawMesh};

/// Order of one primitive in the file that an asset was made from.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SourceOrder {
    /// For each stored vertex, its index in the source: a permutation.
    pub vertices: Vec<u32>,
    /// Triangles of the source as indices into its vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl SourceOrder {
    /// Returns the stored index of each vertex of the source.
    ///
    /// # Errors
    /// A [`Mismatch`] if the vertices are not a permutation of `count` indices.
    pub fn places(&self, count: usize) -> Result<Vec<u32>, Mismatch> {
        if self.vertices.len() != count {
            let what = format!(
                "{} vertices, the primitive has {count}",
                self.vertices.len()
            );
            return Err(Mismatch::new("vertices", what));
        }
        let mut places = vec![u32::MAX; count];
        for (place, source) in self.vertices.iter().enumerate() {
            let free = places.get_mut(*source as usize).filter(|p| **p == u32::MAX);
            let Some(free) = free else {
                let what = format!("vertex {source} is listed twice or is not below {count}");
                return Err(Mismatch::new("vertices", what));
            };
            *free = place as u32;
        }
        Ok(places)
    }

    /// Returns a primitive with vertices and triangles in the order of the source.
    ///
    /// # Errors
    /// A [`Mismatch`] if the primitive has another number of vertices, the vertices are not a
    /// permutation, or a triangle names a vertex that does not exist.
    pub fn restore(&self, stored: &Primitive) -> Result<Primitive, Mismatch> {
        let count = stored.positions.len();
        let places = self.places(count)?;
        let is_outside = |t: &[u32; 3]| t.iter().any(|v| *v as usize >= count);
        if let Some(t) = self.triangles.iter().position(is_outside) {
            let what = format!("a vertex is not below {count}");
            return Err(Mismatch::new(format!("triangles[{t}]"), what));
        }
        Ok(stored.reordered(&places, self.triangles.clone()))
    }
}

/// Returns meshes with the vertices and triangles of the source, without mesh levels. `orders` has
/// one entry for each primitive of all meshes.
///
/// # Errors
/// A [`Mismatch`] if the numbers of primitives differ, or an order is not one of its primitive.
pub fn restore_order(meshes: &[RawMesh], orders: &[SourceOrder]) -> Result<Vec<RawMesh>, Mismatch> {
    let primitives: usize = meshes.iter().map(|m| m.primitives.len()).sum();
    if primitives != orders.len() {
        let what = format!("{} orders for {primitives} primitives", orders.len());
        return Err(Mismatch::new("orders", what));
    }
    let mut orders = orders.iter();
    let mut out = Vec::with_capacity(meshes.len());
    for (m, mesh) in meshes.iter().enumerate() {
        let mut primitives = Vec::with_capacity(mesh.primitives.len());
        for (p, (primitive, order)) in mesh.primitives.iter().zip(&mut orders).enumerate() {
            let at = |e: Mismatch| {
                Mismatch::new(format!("meshes[{m}].primitives[{p}].{}", e.at), e.what)
            };
            primitives.push(order.restore(primitive).map_err(at)?);
        }
        out.push(RawMesh {
            name: mesh.name.clone(),
            skin: mesh.skin.clone(),
            morph_names: mesh.morph_names.clone(),
            morph_weights: mesh.morph_weights.clone(),
            screen_coverage: mesh.screen_coverage,
            // Nodes of MSFT_lod that repeat stored levels are no levels of the source.
            levels: match mesh.clustered.is_empty() {
                true => mesh.levels.clone(),
                false => Vec::new(),
            },
            clustered: Vec::new(),
            primitives,
        });
    }
    Ok(out)
}

/// Encodes the orders of all primitives.
pub fn write_source_orders(orders: &[SourceOrder]) -> Vec<u8> {
    let mut out = Writer::default();
    out.count(orders.len());
    for order in orders {
        out.count(order.vertices.len());
        signed_gaps(&mut out, order.vertices.iter().copied());
        out.count(order.triangles.len());
        signed_gaps(&mut out, order.triangles.iter().flatten().copied());
    }
    out.0
}

/// Decodes the output of [`write_source_orders`].
///
/// # Errors
/// [`ReadError::Malformed`] with the byte offset, [`ReadError::LimitExceeded`].
pub fn read_source_orders(bytes: &[u8], limits: &Limits) -> Result<Vec<SourceOrder>, ReadError> {
    let mut r = Numbers::new(bytes, limits)?;
    let count = r.count(2, "primitives")?;
    let mut orders = Vec::with_capacity(count);
    for _ in 0..count {
        let vertices = r.count(1, "vertices")?;
        let vertices = gaps(&mut r, vertices)?;
        let triangles = r.count(3, "triangles")?;
        let corners = gaps(&mut r, 3 * triangles)?;
        orders.push(SourceOrder {
            vertices,
            triangles: corners.as_chunks::<3>().0.to_vec(),
        });
    }
    r.bytes.end()?;
    Ok(orders)
}

/// Writes the difference of each number to the one before, as `2 d` or `-2 d - 1`.
fn signed_gaps(out: &mut Writer, values: impl Iterator<Item = u32>) {
    let mut before = 0i64;
    for value in values.map(i64::from) {
        let d = value - before;
        let folded = if d >= 0 { 2 * d } else { -2 * d - 1 };
        out.count(folded as usize);
        before = value;
    }
}

fn gaps(r: &mut Numbers<'_>, count: usize) -> Result<Vec<u32>, ReadError> {
    let mut values = Vec::with_capacity(count);
    let mut before = 0i64;
    for _ in 0..count {
        let folded = r.index()? as i64;
        let d = if folded % 2 == 0 {
            folded / 2
        } else {
            -(folded + 1) / 2
        };
        before += d;
        let Ok(value) = u32::try_from(before) else {
            return Err(r
                .bytes
                .bad(format!("index {before} is out of range"))
                .into());
        };
        values.push(value);
    }
    Ok(values)
}
