//! What a GPU reads in a frame of a crowd, as bytes.
//!
//! Form: `docs/formats/crowd-buffers.md`, version 2. A renderer in the same program reads the arrays of a
//! [`CrowdPlayer`] instead, which have the same layout and are not copied; these bytes are for files, other
//! programs and tests.

use super::buffer_manifest::{BUFFER_FILES, BufferManifest, BufferSizes};
use super::buffer_vertices::{floats, push_vertices};
use super::options::PaletteMatrices;
use super::palettes::{PaletteSlice, rows};
use super::player::CrowdPlayer;
use crate::error::{Error, Result};
use articula_core::CachedRows;
use articula_core::crowd::Draw;

/// The buffers of one frame, each little endian and without gaps, and what they hold.
///
/// Cached palettes, vertices and triangles are the same in every frame of an asset.
///
/// ```
/// use articula::crowd::{CrowdBuffers, CrowdPlayer};
///
/// # fn sent(player: &CrowdPlayer) -> articula::Result<()> {
/// let buffers = CrowdBuffers::new(player)?;
/// let manifest = &buffers.manifest;
/// let characters = manifest.draws.count + manifest.records.count + manifest.stepped.count;
/// let draws = buffers.draws.len() + buffers.stepped.len();
/// assert_eq!(draws + buffers.records.len() / 2, 8 * characters);
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdBuffers {
    /// What the buffers hold: counts, groups, levels, entries.
    pub manifest: BufferManifest,
    /// Palettes that the CPU has written, in the form of the manifest.
    pub palettes: Vec<u8>,
    /// Draws of 8 bytes: character, index of the first matrix.
    pub draws: Vec<u8>,
    /// Blend records of 16 bytes: two indices of first matrices, blend, character.
    pub records: Vec<u8>,
    /// Draws of 8 bytes: character, index of the first matrix among the cached ones.
    pub stepped: Vec<u8>,
    /// Cached palettes that records and stepped draws refer to.
    pub cached: Vec<u8>,
    /// Sets of morph target weights, 4 bytes each.
    pub morph_weights: Vec<u8>,
    /// World transforms of all characters, 48 bytes each.
    pub transforms: Vec<u8>,
    /// Vertices of the mesh of each level.
    pub vertices: Vec<u8>,
    /// Vertex indices of the triangles of each level, 12 bytes a triangle.
    pub triangles: Vec<u8>,
}

impl CrowdBuffers {
    /// Name of the file with the manifest.
    pub const MANIFEST: &'static str = "crowd.json";

    /// Names of the files with the buffers, in the order of the fields.
    pub const FILES: [&'static str; 9] = BUFFER_FILES;

    /// Copies the buffers of a player's current frame, which must be evaluated.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the palettes are those of [`PaletteMatrices::Joints`], whose matrices do
    /// not place a vertex without the inverse bind matrix.
    pub fn new(player: &CrowdPlayer) -> Result<Self> {
        let asset = player.asset();
        if asset.matrices() != PaletteMatrices::Skin {
            return Err(Error::unsuited(
                "the palettes are of joints, without the inverse bind matrix; prepare the crowd with palettes of the skin",
            ));
        }
        let list = player.crowd().draw_list();
        let records = player.records().iter();
        let characters = 0..player.positions().len();
        let cache = asset.model().parts().cache.as_ref();
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        let levels = if asset.has_mesh() { asset.levels() } else { 0 };
        for mesh in (0..levels).map(|level| asset.mesh(level)) {
            push_vertices(mesh, &mut vertices);
            triangles.extend(
                mesh.triangles
                    .as_flattened()
                    .iter()
                    .flat_map(|v| v.to_le_bytes()),
            );
        }
        let mut buffers = Self {
            manifest: BufferManifest::new(player),
            palettes: palette_bytes(player.palettes()),
            draws: draw_bytes(&list.draws),
            records: records.flat_map(|r| r.to_le_bytes()).collect(),
            stepped: draw_bytes(player.stepped()),
            cached: cache.map_or_else(Vec::new, |c| cached_bytes(c.rows())),
            morph_weights: floats(player.morph_weights()).collect(),
            transforms: characters
                .map(|c| rows(&player.world_from_model(c)))
                .flat_map(|rows| floats(rows.as_flattened()).collect::<Vec<u8>>())
                .collect(),
            vertices,
            triangles,
        };
        buffers.manifest.bytes = BufferSizes(buffers.parts().map(Vec::len));
        Ok(buffers)
    }

    /// Returns the files of a folder: each buffer, empty ones too, then the manifest.
    ///
    /// # Errors
    /// [`Error::Write`] if the manifest cannot be written as JSON.
    pub fn files(&self) -> Result<Vec<(&'static str, Vec<u8>)>> {
        let buffers = self.parts().map(Vec::clone);
        let mut files: Vec<_> = Self::FILES.into_iter().zip(buffers).collect();
        files.push((Self::MANIFEST, self.manifest.to_json()?));
        Ok(files)
    }

    /// The buffers in the order of [`FILES`](Self::FILES).
    fn parts(&self) -> [&Vec<u8>; 9] {
        [
            &self.palettes,
            &self.draws,
            &self.records,
            &self.stepped,
            &self.cached,
            &self.morph_weights,
            &self.transforms,
            &self.vertices,
            &self.triangles,
        ]
    }
}

fn draw_bytes(draws: &[Draw]) -> Vec<u8> {
    let words = draws.iter().flat_map(|d| [d.character, d.first_matrix]);
    words.flat_map(u32::to_le_bytes).collect()
}

fn halves(numbers: &[u16]) -> impl Iterator<Item = u8> + '_ {
    numbers.iter().flat_map(|n| n.to_le_bytes())
}

fn palette_bytes(rows: PaletteSlice<'_>) -> Vec<u8> {
    match rows {
        PaletteSlice::Float(rows) => floats(rows.as_flattened()).collect(),
        PaletteSlice::Half(rows) => halves(rows.as_flattened()).collect(),
    }
}

fn cached_bytes(rows: &CachedRows) -> Vec<u8> {
    palette_bytes(match rows {
        CachedRows::Float(rows) => PaletteSlice::Float(rows),
        CachedRows::Half(rows) => PaletteSlice::Half(rows),
    })
}
