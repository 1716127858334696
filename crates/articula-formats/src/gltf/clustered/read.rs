//! Reading of levels from a document, after validation of all indices.

use super::level_table;
use super::version::{Counts, MAX_LEVELS};
use crate::error::ReadError;
use crate::gltf::extension::CLUSTERED_MESH;
use crate::gltf::origin::origins;
use crate::gltf::place::Place;
use crate::gltf::reader::Reader;
use articula_core::source::Primitive;
use articula_core::{Cluster, ClusteredTriangles, Clusters};

/// Reads the levels of each part of a mesh; empty, with a warning, if any is invalid. The finest
/// level is shown by the primitives in any case.
pub(in crate::gltf) fn read_parts(
    reader: &mut Reader<'_>,
    mesh: &Place<'_>,
    parts: &[Primitive],
) -> Vec<ClusteredTriangles> {
    let places = mesh.entries("primitives").unwrap_or_default();
    let has_levels = |p: &Place<'_>| p.dig(&["extensions", CLUSTERED_MESH]).is_some();
    if !places.iter().any(has_levels) {
        return Vec::new();
    }
    match try_read(reader, mesh, parts) {
        Ok(found) => found,
        Err(error) => {
            reader.warn(mesh, format!("the levels are left out: {error}"));
            Vec::new()
        }
    }
}

fn try_read(
    reader: &mut Reader<'_>,
    mesh: &Place<'_>,
    parts: &[Primitive],
) -> Result<Vec<ClusteredTriangles>, ReadError> {
    let origins = origins(reader, mesh)?;
    if origins.len() != parts.len() {
        return Err(mesh.malformed("a primitive of the mesh could not be read"));
    }
    let mut out = Vec::with_capacity(parts.len());
    for (origin, part) in origins.iter().zip(parts) {
        let missing = || mesh.malformed("the primitive does not exist");
        let place = mesh
            .entry("primitives", origin.primitive)
            .ok_or_else(missing)?;
        let extension = place.require("extensions")?.require(CLUSTERED_MESH)?;
        let object = read_part(reader, &extension)?;
        let expected = level_table::count(&reader.root);
        if object.clusters.levels() != expected {
            let what = format!(
                "{} levels, the table has {expected}",
                object.clusters.levels()
            );
            return Err(extension.malformed(what));
        }
        // Fails if several primitives share vertices, of which not all were kept.
        let fits = object.check(part.positions.len());
        fits.map_err(|e| extension.malformed(e.to_string()))?;
        if !object.level(0).eq(part.triangles.iter().copied()) {
            return Err(
                extension.malformed("the finest level differs from the triangles of the primitive")
            );
        }
        out.push(object);
    }
    Ok(out)
}

/// Reads the extension of a primitive and validates it on its own.
pub(super) fn read_part(
    reader: &mut Reader<'_>,
    extension: &Place<'_>,
) -> Result<ClusteredTriangles, ReadError> {
    let accessor = reader.accessor(&extension.require("indices")?)?;
    accessor.expect_type(&["SCALAR"])?;
    let corners = reader.integers(&accessor)?;
    let (triangles, rest) = corners.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(extension.malformed("the number of indices must be a multiple of 3"));
    }
    let vertices = extension.entries("vertices")?;
    if vertices.len() > MAX_LEVELS {
        let what = format!("{} levels, the limit is {MAX_LEVELS}", vertices.len());
        return Err(extension.malformed(what));
    }
    let counts = Counts::of(extension)?;
    let vertices = vertices.iter().map(number::<u32>);
    let vertices = counts.list(vertices.collect::<Result<Vec<_>, _>>()?);
    let count = vertices.len();
    let level = |place: &Place<'_>| {
        let found = number::<u16>(place)?;
        let level = counts.level(found.into(), count);
        let beyond = || {
            place.malformed(format!(
                "level {found} is out of range: there are {count} levels"
            ))
        };
        level.map(|l| l as u16).ok_or_else(beyond)
    };
    let mut clusters = Vec::new();
    let mut end = 0u32;
    for place in extension.entries("clusters")? {
        let count = number::<u32>(&place.require("triangles")?)?;
        let start = end;
        let too_many = || place.malformed("the number of triangles exceeds 32 bits");
        end = end.checked_add(count).ok_or_else(too_many)?;
        let [first, last] = [
            level(&place.require("first")?)?,
            level(&place.require("last")?)?,
        ];
        let (finest_level, coarsest_level) = match counts {
            Counts::FromFinest => (first, last),
            Counts::FromCoarsest => (last, first),
        };
        clusters.push(Cluster {
            finest_level,
            coarsest_level,
            region: place.get("region").map_or(Ok(0), |r| number(&r))?,
            triangles: start..end,
        });
    }
    let clusters = Clusters::new(vertices, clusters);
    Ok(ClusteredTriangles {
        clusters: clusters.map_err(|e| extension.malformed(e.to_string()))?,
        triangles: triangles.to_vec(),
    })
}

fn number<T: TryFrom<u64>>(place: &Place<'_>) -> Result<T, ReadError> {
    let found = place.whole()?;
    T::try_from(found).map_err(|_| place.malformed(format!("{found} is too large")))
}
