//! What the buffers of a crowd's frame hold, as a document beside them.
//!
//! Form: `docs/formats/crowd-buffers.md`.

use super::buffer_vertices::{stored_influences, vertex_bytes};
use super::palettes::rows;
use super::player::CrowdPlayer;
use crate::error::{Error, Result};
use articula_core::crowd::DrawKind;
use articula_core::{CachedRows, PaletteForm};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::ops::Not;

/// Names of the files with the buffers.
pub(super) const BUFFER_FILES: [&str; 9] = [
    "palettes.bin",
    "draws.bin",
    "records.bin",
    "stepped.bin",
    "cached.bin",
    "morph_weights.bin",
    "transforms.bin",
    "vertices.bin",
    "triangles.bin",
];

/// Counts, groups, levels and entries of the buffers of a frame.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BufferManifest {
    /// `articula-crowd-buffers`.
    pub format: &'static str,
    /// Version of the layouts, 2.
    pub version: u32,
    /// Form of all palettes: `matrix`, `half`, `rigid` or `half-rigid`.
    pub form: &'static str,
    /// Number of characters of the crowd, shown or not.
    pub characters: usize,
    /// Size of each buffer in bytes, by its file name.
    pub bytes: BufferSizes,
    /// Number of matrices that the CPU has written.
    pub palette_matrices: usize,
    /// Number of matrices of all cached palettes.
    pub cached_matrices: usize,
    /// Characters with a written palette.
    pub draws: DrawnManifest,
    /// Characters whose palette is blended from two cached ones.
    pub records: DrawnManifest,
    /// Characters that show a cached palette as it is.
    pub stepped: DrawnManifest,
    /// Number of weights of a set of morph target weights.
    pub morph_targets: usize,
    /// Weights of characters without a set.
    pub morph_defaults: Vec<f32>,
    /// Joint and inverse bind matrix of each palette entry; a level uses the first of them.
    pub entries: Vec<EntryManifest>,
    /// All levels of the character, finest first.
    pub levels: Vec<LevelManifest>,
}

/// Sizes of the buffers in bytes, in the order of [`CrowdBuffers::FILES`](super::CrowdBuffers::FILES).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BufferSizes(pub [usize; 9]);

impl Serialize for BufferSizes {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        let mut map = out.serialize_map(Some(self.0.len()))?;
        for (name, bytes) in BUFFER_FILES.iter().zip(self.0) {
            map.serialize_entry(name, &bytes)?;
        }
        map.end()
    }
}

/// A list of characters by level: draws, records or stepped draws.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DrawnManifest {
    /// Number of them.
    pub count: usize,
    /// Number of them, from the first on, that have a set of morph target weights.
    pub with_morph_sets: usize,
    /// Index of the set of the first of them.
    pub first_morph_set: usize,
    /// Runs of one level.
    pub groups: Vec<GroupManifest>,
}

/// Draws, records or stepped draws of one level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct GroupManifest {
    /// The level.
    pub level: usize,
    /// Index of the first one.
    pub first: usize,
    /// Number of them.
    pub count: usize,
}

/// One entry of every palette.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EntryManifest {
    /// Name of the joint.
    pub joint: String,
    /// Inverse bind matrix, which the entry includes: 3x4, row by row.
    pub inverse_bind: [f32; 12],
}

/// A level: its palette and its mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LevelManifest {
    /// Number of matrices of a palette: the first entries.
    pub matrices: usize,
    /// Offset of its vertices in bytes.
    pub vertices_at: usize,
    /// Number of its vertices.
    pub vertices: usize,
    /// Bytes of a vertex.
    pub vertex_bytes: usize,
    /// Influences of a stored vertex, a multiple of 4.
    pub influences: usize,
    /// Offset of its triangles in bytes.
    pub triangles_at: usize,
    /// Number of its triangles.
    pub triangles: usize,
    /// The triangles of each material.
    pub parts: Vec<PartManifest>,
}

/// Triangles of one material of a mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct PartManifest {
    /// Material of the character, as a file of glTF numbers them; `None` for the usual one.
    pub material: Option<usize>,
    /// First triangle, counted from the first of the level.
    pub first: usize,
    /// Number of triangles.
    pub count: usize,
    /// Whether its material differs from that of the part before in the base colour factor alone, so that one draw can
    /// show both.
    #[serde(skip_serializing_if = "Not::not")]
    pub joins_previous: bool,
}

impl BufferManifest {
    /// Describes a frame, without the sizes of its buffers.
    pub(super) fn new(player: &CrowdPlayer) -> Self {
        let parts = player.asset().model().parts();
        let list = player.crowd().draw_list();
        let morphs = parts.morphs.as_ref().filter(|m| m.levels() > 0);
        let cached = parts.cache.as_ref().map_or(0, |cache| match cache.rows() {
            CachedRows::Float(rows) => rows.len() / 3,
            CachedRows::Half(rows) => rows.len() / 3,
        });
        let drawn = |kind| {
            let groups = list.groups_of(kind).map(|group| GroupManifest {
                level: group.level,
                first: group.range.start,
                count: group.range.len(),
            });
            DrawnManifest {
                count: list.characters(kind).len(),
                with_morph_sets: list.with_morphs(kind),
                first_morph_set: list.first_morph_set(kind),
                groups: groups.collect(),
            }
        };
        Self {
            format: "articula-crowd-buffers",
            version: 2,
            form: form_name(parts.form),
            characters: player.positions().len(),
            bytes: BufferSizes([0; 9]),
            palette_matrices: list.matrices,
            cached_matrices: cached,
            draws: drawn(DrawKind::Palette),
            records: drawn(DrawKind::Record),
            stepped: drawn(DrawKind::Step),
            morph_targets: morphs.map_or(0, |m| m.targets()),
            morph_defaults: player.asset().full().mesh.morph_weights.clone(),
            entries: entries(player),
            levels: levels(player),
        }
    }

    /// Returns the document as JSON, one member a line.
    pub(super) fn to_json(&self) -> Result<Vec<u8>> {
        let text = serde_json::to_vec_pretty(self);
        let mut text = text.map_err(|e| Error::Write(Box::new(e)))?;
        text.push(b'\n');
        Ok(text)
    }
}

/// Name of a form.
fn form_name(form: PaletteForm) -> &'static str {
    match form {
        PaletteForm::Matrix => "matrix",
        PaletteForm::HalfMatrix => "half",
        PaletteForm::Rigid => "rigid",
        PaletteForm::HalfRigid => "half-rigid",
    }
}

/// The entries of a palette at level 0, of which every other level uses the first.
fn entries(player: &CrowdPlayer) -> Vec<EntryManifest> {
    let asset = player.asset();
    let bindings = asset.mesh(0).bindings.iter();
    let entry = |binding: &articula_core::Binding| {
        let mut inverse_bind = [0.0; 12];
        inverse_bind.copy_from_slice(rows(&binding.inverse_bind).as_flattened());
        EntryManifest {
            joint: asset.full().rig.name(usize::from(binding.joint)).to_owned(),
            inverse_bind,
        }
    };
    bindings.map(entry).collect()
}

fn levels(player: &CrowdPlayer) -> Vec<LevelManifest> {
    let asset = player.asset();
    let (mut vertices_at, mut triangles_at) = (0, 0);
    let level = |level: usize| {
        let mesh = asset.mesh(level);
        let ranges = asset.material_ranges(level).iter();
        let parts = ranges.map(|range| PartManifest {
            material: range.material,
            first: range.triangles.start,
            count: range.triangles.len(),
            joins_previous: range.joins_previous,
        });
        let made = LevelManifest {
            matrices: asset.level(level).matrices,
            vertices_at,
            // Points on the bones of a character without a mesh are not drawn.
            vertices: if asset.has_mesh() { mesh.len() } else { 0 },
            vertex_bytes: vertex_bytes(mesh),
            influences: stored_influences(mesh),
            triangles_at,
            triangles: mesh.triangles.len(),
            parts: parts.collect(),
        };
        vertices_at += made.vertices * made.vertex_bytes;
        triangles_at += 12 * made.triangles;
        made
    };
    (0..asset.levels()).map(level).collect()
}
