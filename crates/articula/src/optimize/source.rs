//! The character before anything is rounded, and files that are written of it.

use super::OptimizeOptions;
use super::optimized_clip::OptimizedClip;
use crate::convert;
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Format, GltfSource, OpenOptions, open};
use articula_build::PosedVertices;
use articula_core::source::Character;
use articula_formats::Limits;
use articula_formats::gltf::{
    self, ArrayPrecision, BytesByKind, Compression, Document, KeySteps, WeightPrecision,
};

/// Share of the error for the rounding of positions, with clips and without. Halving it costs three bits
/// a vertex.
const MESH_SHARE: f32 = 0.25;
const STILL_SHARE: f32 = 0.5;
/// Step of texture coordinates: a quarter of a texel of 1024.
const TEXCOORD_STEP: f32 = 1.0 / 4096.0;

/// A character and its document, whose vertices are in the order in which they are stored.
pub(super) struct Source {
    pub(super) character: Character,
    file: GltfSource,
}

/// Precision of the meshes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeshPrecision {
    /// The step of the positions of each mesh of the document.
    positions: Vec<f32>,
    weights: WeightPrecision,
}

impl MeshPrecision {
    /// Steps by which no vertex moves more than a share of the bound at rest.
    pub(super) fn of(source: &Source, bound: f32) -> Self {
        let document = &source.file.document;
        let rest = source.character.skeleton.model_rest();
        let share = match source.character.clips.is_empty() {
            true => STILL_SHARE,
            false => MESH_SHARE,
        };
        let mut steps = vec![f32::INFINITY; document.mesh_count()];
        for (mesh, node) in source
            .character
            .meshes
            .iter()
            .zip(&source.file.node_of_mesh)
        {
            let Some(index) = document.mesh_of_node(*node) else {
                continue;
            };
            let skin = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
            let scale = skin.map(|(joint, bind)| {
                let matrix = (rest[*joint] * *bind).matrix3;
                let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
                axes.iter().map(|axis| axis.length()).fold(0.0, f32::max)
            });
            let scale = scale.fold(0.0, f32::max).max(1e-9);
            // Half a step in each of three axes.
            let step = 2.0 * share * bound / (3.0f32.sqrt() * scale);
            steps[index] = steps[index].min(step);
        }
        // Meshes that the character does not show keep their precision.
        let exact = |step: f32| if step.is_finite() { step } else { 0.0 };
        Self {
            positions: steps.into_iter().map(exact).collect(),
            weights: WeightPrecision::default(),
        }
    }

    /// One step finer: first the weights, then the positions too.
    pub(super) fn finer(&self) -> Self {
        let (weights, factor) = match self.weights {
            WeightPrecision::Byte => (WeightPrecision::Short, 1.0),
            _ => (WeightPrecision::Exact, 0.25),
        };
        Self {
            positions: self.positions.iter().map(|step| factor * step).collect(),
            weights,
        }
    }

    fn arrays(&self, samplers: Vec<Vec<Option<KeySteps>>>) -> ArrayPrecision {
        ArrayPrecision {
            positions: self.positions.clone(),
            samplers,
            texcoords: TEXCOORD_STEP,
            weights: self.weights,
        }
    }
}

impl Source {
    /// The character of a file, and the bytes of its parts without compression.
    pub(super) fn of(
        opened: &CharacterFile,
        options: &OptimizeOptions,
    ) -> Result<(BytesByKind, Self)> {
        let mut document = match opened.gltf() {
            Some(behind) if !opened.clips_changed() => behind.document.clone(),
            // A file of another format, or other clips than those of the document.
            _ => {
                let written = convert::write(opened, Format::Glb)?.bytes;
                Self::read(&written)?.file.document
            }
        };
        let before = document.bytes_by_kind();
        document.remove_prepared();
        document.remove_motion_tables();
        if document.is_compressible() {
            if !options.keep_attributes {
                document.drop_unused_attributes();
            }
            document.optimise_vertex_order()?;
        }
        let read = gltf::read_document(document, &Limits::default())?;
        let (character, file) = GltfSource::split(read.value);
        Ok((before, Self { character, file }))
    }

    /// A written file, read as any file is.
    pub(super) fn read(glb: &[u8]) -> Result<Self> {
        let beside = &mut |uri: &str| Err(format!("{uri}: not in the file"));
        let opened = open(glb, "optimized.glb", &OpenOptions::default(), beside)?;
        let Some(file) = opened.gltf().cloned() else {
            return Err(Error::unsuited("the written file is not glTF"));
        };
        let character = opened.into_character();
        Ok(Self { character, file })
    }

    /// Whether an unknown extension may refer to arrays, which then stay as they are.
    pub(super) fn keeps_arrays(&self) -> bool {
        !self.file.document.is_compressible()
    }

    pub(super) fn posed(&self) -> Result<PosedVertices<'_>> {
        Ok(PosedVertices::new(&self.character)?)
    }

    /// The same with meshes as the file that is written will have them.
    pub(super) fn with_rounded_mesh(&self, precision: &MeshPrecision) -> Result<Self> {
        let arrays = precision.arrays(Vec::new());
        let document = &self.file.document;
        Self::read(&document.write_compressed(Compression::None, &arrays)?)
    }

    /// The file with these clips.
    pub(super) fn written(
        &self,
        clips: &[&OptimizedClip],
        precision: &MeshPrecision,
        options: &OptimizeOptions,
    ) -> Result<Vec<u8>> {
        let mut document: Document = self.file.document.clone();
        if !document.is_compressible() {
            return Ok(document.write_glb()?);
        }
        let keys: Vec<_> = clips.iter().map(|clip| clip.clip.clone()).collect();
        let (joints, meshes) = (&self.file.node_of_joint, &self.file.node_of_mesh);
        let held = document.replace_keys(&keys, joints, meshes)?;
        let samplers = held.iter().zip(clips).map(|(held, clip)| {
            let step = |c: &Option<usize>| c.and_then(|c| clip.steps.get(c).copied());
            held.iter().map(step).collect()
        });
        let arrays = precision.arrays(samplers.collect());
        document.compact();
        Ok(document.write_compressed(options.compression, &arrays)?)
    }
}
