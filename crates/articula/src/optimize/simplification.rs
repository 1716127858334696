//! Fewer triangles, where the surface in motion stays within a share of the error.

use super::constraints::constraints;
use super::source::{MeshPrecision, Shares, Source};
use super::{OptimizeOptions, Prepared};
use crate::error::{Context, Result};
use crate::work::Executor;
use articula_build::{
    ChangedTriangles, SimplifiedWithin, greatest_surface_error, simplify_within, watched_poses,
};
use articula_core::Mesh;
use articula_formats::gltf::BytesByKind;

/// Shares of the error that the surface may take before anything is rounded, the later where the first is
/// too much.
pub(super) const SURFACE_SHARES: [f32; 2] = [0.65, 0.4];
/// Parts of that error which are taken from that of the vertices, in turn. Errors of surface and vertices
/// seldom meet in one place; all of it is always enough.
pub(super) const TAKEN: [f32; 3] = [0.3, 0.6, 1.0];
/// Bytes that a smaller error of keys costs at most, of those of all keys without compression.
const KEYS_SHARE: f64 = 0.02;

/// A character with fewer triangles.
pub(super) struct Simplification {
    pub(super) source: Source,
    /// Greatest distance of the surfaces in any pose, in metres.
    pub(super) metres: f32,
    changed: ChangedTriangles,
}

/// What fewer triangles save, by the bytes of the meshes alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Saving {
    None,
    Perhaps,
    Surely,
}

impl Simplification {
    /// Removes triangles within a share of a bound in metres; `None` if there are none to spare.
    pub(super) fn of(
        prepared: &Prepared,
        (bound, share): (f32, f32),
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Option<Self>> {
        let source = &prepared.source;
        let mut posed = source.posed()?;
        if source.triangles() == 0 || source.keeps_arrays() {
            return Ok(None);
        }
        let constraints = constraints(prepared, posed.mesh(), options)?;
        let poses = watched_poses(&mut posed, options.seed);
        let mesh = posed.mesh();
        let bound = share * bound;
        let within = |()| Ok(simplify_within(mesh, &poses, bound, &constraints)?);
        let found = work.map("simplifying the mesh", vec![()], within)?;
        let Some(found) = found.into_iter().flatten().next() else {
            return Ok(None);
        };
        let simple = written(source, mesh, &found).context("the simplified mesh")?;
        let changed = ChangedTriangles::between(mesh, simple.posed()?.mesh());
        Ok(Some(Self {
            source: simple,
            metres: found.metres,
            changed,
        }))
    }

    /// Compares the bytes of the meshes, each as exact as the error that is left for it asks.
    pub(super) fn saving(
        &self,
        source: &Source,
        bound: f32,
        options: &OptimizeOptions,
    ) -> Result<Saving> {
        let geometry = |source: &Source, bound: f32| -> Result<usize> {
            let precision = MeshPrecision::chosen(
                source,
                bound,
                Shares::of(&source.character),
                options.compression,
            )?;
            let glb = source.with_meshes(&precision, options.compression)?;
            Ok(BytesByKind::of_glb(&glb).geometry)
        };
        let before = geometry(source, bound)?;
        let after = geometry(&self.source, bound - TAKEN[0] * self.metres)?;
        let keys = source.file.document.bytes_by_kind().keys;
        Ok(match before.saturating_sub(after) {
            0 => Saving::None,
            saved if saved as f64 > KEYS_SHARE * keys as f64 => Saving::Surely,
            _ => Saving::Perhaps,
        })
    }

    /// Greatest distance between the surface of the source and that of a written file, in metres, in other
    /// poses than those that triangles were removed by.
    pub(super) fn surface_error(&self, source: &Source, glb: &[u8], seed: u64) -> Result<f32> {
        let shown = Source::read(glb)?;
        let (mut wanted, mut shown) = (source.posed()?, shown.posed()?);
        let seed = seed.wrapping_add(1);
        Ok(greatest_surface_error(
            &mut wanted,
            &mut shown,
            &self.changed,
            seed,
        )?)
    }
}

/// The character with other triangles.
fn written(source: &Source, mesh: &Mesh, found: &SimplifiedWithin) -> Result<Source> {
    let mut document = source.file.document.clone();
    for (m, node) in source.file.node_of_mesh.iter().enumerate() {
        let is_replaceable = document.replaceable_parts(*node)?;
        let parts = mesh.parts.iter().zip(&found.level.parts);
        let parts = parts.filter(|(part, _)| part.mesh == m).zip(is_replaceable);
        let parts: Vec<_> = parts
            .map(|((part, range), is_replaceable)| {
                let first = part.vertices.start as u32;
                let triangles = &found.level.triangles[range.clone()];
                let is_written = is_replaceable && !triangles.is_empty();
                let local = triangles.iter().map(|t| t.map(|v| v - first));
                is_written.then(|| local.collect())
            })
            .collect();
        document.replace_triangles(*node, &parts)?;
    }
    Source::ordered(document)
}
