//! The character before anything is rounded, and files that are written of it.

use super::OptimizeOptions;
use super::node_precision::node_tolerances;
use super::optimized_clip::OptimizedClip;
use super::surface_use::SurfaceUse;
use super::textures::{TextureOptimized, TextureRun, optimize_textures};
use super::worn::{MeasuredOn, Worn};
use crate::convert;
use crate::error::{Error, Result};
use crate::open::{CharacterFile, Format, GltfSource, OpenOptions, open};
use crate::work::Executor;
use articula_build::PosedVertices;
use articula_core::source::Character;
use articula_formats::Limits;
use articula_formats::gltf::{
    self, ArrayPrecision, BytesByKind, Compression, Document, KeySteps, NodeTolerance,
    WeightPrecision,
};

/// Numbers of all keys for each vertex below which they are few.
const FEW_KEYS: usize = 5;
/// Step of texture coordinates: a quarter of a texel of 1024.
const TEXCOORD_STEP: f32 = 1.0 / 4096.0;

/// A character and its document, whose vertices are in the order in which they are stored.
pub(super) struct Source {
    pub(super) character: Character,
    pub(super) file: GltfSource,
    /// The document without its animations, whose joints and meshes are the same.
    still: Option<Document>,
    /// What is measured in place of meshes, if the file has none.
    worn: Option<Worn>,
}

/// Shares of the error for meshes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shares {
    /// For the rounding of positions at rest. Halving it costs three bits a vertex.
    rest: f32,
    /// For the rounded mesh in motion, so that keys have the rest.
    pub(super) motion: f32,
}

impl Shares {
    pub(super) const OF_MOTION: Self = Self {
        rest: 0.25,
        motion: 0.8,
    };
    /// Where keys are few, a finer mesh costs more than further keys.
    pub(super) const OF_FEW_KEYS: Self = Self {
        rest: 0.5,
        motion: 0.95,
    };
    const STILL: Self = Self {
        rest: 0.95,
        motion: 1.0,
    };

    pub(super) fn of(character: &Character) -> Self {
        let numbers = character.clips.iter().flat_map(|clip| &clip.channels);
        let numbers: usize = numbers.map(|channel| channel.values.len()).sum();
        let primitives = character.meshes.iter().flat_map(|mesh| &mesh.primitives);
        let vertices: usize = primitives.map(|p| p.positions.len()).sum();
        match numbers {
            0 => Self::STILL,
            numbers if numbers < FEW_KEYS * vertices => Self::OF_FEW_KEYS,
            _ => Self::OF_MOTION,
        }
    }
}

/// The share of the error for the rounding of each joint at rest. Those of a chain add up.
const NODE_SHARE: f32 = 0.02;

/// Precision of the meshes, and of the skeleton at rest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeshPrecision {
    /// The first step of the positions of each mesh of the document.
    positions: Vec<f32>,
    /// The first tolerances of the nodes of the document.
    nodes: Vec<Option<NodeTolerance>>,
    /// Whether positions of skinned meshes are integers.
    is_quantized: bool,
    /// How often it was made finer.
    times: usize,
}

impl MeshPrecision {
    /// The precision within a bound, with positions as integers where that needs fewer bytes.
    pub(super) fn chosen(
        source: &Source,
        bound: f32,
        shares: Shares,
        compression: Compression,
    ) -> Result<Self> {
        let floats = Self::of(source, bound, shares)?;
        if compression == Compression::None || source.character.meshes.is_empty() {
            return Ok(floats);
        }
        let integers = Self {
            is_quantized: true,
            ..floats.clone()
        };
        let bytes = |precision: &Self| -> Result<usize> {
            Ok(source.with_meshes(precision, compression)?.len())
        };
        Ok(match bytes(&integers)? < bytes(&floats)? {
            true => integers,
            false => floats,
        })
    }

    /// Steps by which no vertex moves more than a share of the bound at rest.
    fn of(source: &Source, bound: f32, shares: Shares) -> Result<Self> {
        let document = &source.file.document;
        let rest = source.character.skeleton.model_rest();
        let share = shares.rest;
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
        Ok(Self {
            positions: steps.into_iter().map(exact).collect(),
            nodes: node_tolerances(
                source.body(),
                &source.file.node_of_joint,
                NODE_SHARE * bound,
            )?,
            is_quantized: false,
            times: 0,
        })
    }

    /// Whether it is finer than its share of the error asks.
    pub(super) fn is_finer(&self) -> bool {
        self.times > 0
    }

    /// One step finer.
    pub(super) fn finer(&self) -> Self {
        Self {
            times: self.times + 1,
            ..self.clone()
        }
    }

    /// Weights of 8 bits with positions of two bits more need less than weights of 10 bits.
    fn weights_and_factor(&self) -> (WeightPrecision, f32) {
        match self.times {
            0 => (WeightPrecision::Byte, 1.0),
            1 => (WeightPrecision::Byte, 0.25),
            2 => (WeightPrecision::TenBits, 1.0),
            3 => (WeightPrecision::TenBits, 0.25),
            more => (WeightPrecision::Exact, 0.25f32.powi(more as i32 - 3)),
        }
    }

    /// Rounds the nodes of a document, and makes integers of its positions.
    fn apply(&self, document: &mut Document) -> Result<()> {
        if !document.is_compressible() {
            return Ok(());
        }
        self.round_nodes(document);
        if self.is_quantized {
            let steps = self.arrays(Vec::new()).positions;
            document.quantise_positions(&steps)?;
        }
        Ok(())
    }

    fn round_nodes(&self, document: &mut Document) {
        let factor = 0.25f32.powi(self.times as i32);
        let of_factor = |t: &NodeTolerance| NodeTolerance {
            translation: factor * t.translation,
            rotation: factor * t.rotation,
            scale: factor * t.scale,
        };
        let nodes = self.nodes.iter().map(|t| t.as_ref().map(of_factor));
        document.round_nodes(&nodes.collect::<Vec<_>>());
    }

    fn arrays(&self, samplers: Vec<Vec<Option<KeySteps>>>) -> ArrayPrecision {
        let (weights, factor) = self.weights_and_factor();
        ArrayPrecision {
            positions: self.positions.iter().map(|step| factor * step).collect(),
            samplers,
            texcoords: TEXCOORD_STEP,
            weights,
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
        if document.is_compressible() && !options.keep_attributes {
            document.drop_unused_attributes();
        }
        let mut source = Self::ordered(document)?;
        if source.character.meshes.is_empty() {
            let skin = options.skin.as_deref();
            source.worn = Some(Worn::on(&source.character.skeleton, skin)?);
        }
        Ok((before, source))
    }

    /// The character of a document, with vertices and triangles in the order in which they are stored.
    pub(super) fn ordered(mut document: Document) -> Result<Self> {
        if document.is_compressible() {
            document.optimise_vertex_order(TEXCOORD_STEP)?;
        }
        Self::as_stored(document)
    }

    /// The character of a document whose vertices and triangles stay in their order.
    pub(super) fn as_stored(document: Document) -> Result<Self> {
        let read = gltf::read_document(document, &Limits::default())?;
        let (character, file) = GltfSource::split(read.value);
        Ok(Self {
            still: without_animations(&file.document, &character),
            character,
            file,
            worn: None,
        })
    }

    /// Number of vertices.
    pub(super) fn vertices(&self) -> usize {
        let primitives = self.character.meshes.iter().flat_map(|m| &m.primitives);
        primitives.map(|p| p.positions.len()).sum()
    }

    /// Number of triangles.
    pub(super) fn triangles(&self) -> usize {
        let primitives = self.character.meshes.iter().flat_map(|m| &m.primitives);
        primitives.map(|p| p.triangles.len()).sum()
    }

    /// The same with pictures in fewer bytes. A document that keeps its arrays keeps its pictures too, which
    /// lie beside them.
    pub(super) fn with_small_textures(
        mut self,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<(Self, Vec<TextureOptimized>)> {
        if self.keeps_arrays() {
            return Ok((self, Vec::new()));
        }
        let is_plain = !options.compression.is_of_arrays();
        let height_px = options.textures.screen_height_px;
        let surfaces = match height_px {
            Some(px) => {
                let scale = px as f32 / self.height_metres()?;
                let document = &self.file.document;
                Some(SurfaceUse::of(&mut self.posed()?, document, scale))
            }
            None => None,
        };
        let made = TextureRun {
            options: &options.textures,
            is_plain,
            surfaces: surfaces.as_ref(),
        };
        let (document, images) = (&mut self.file.document, &self.character.images);
        let textures = optimize_textures(document, images, &made, work)?;
        Ok((self, textures))
    }

    /// A written file, read as any file is.
    pub(super) fn read(glb: &[u8]) -> Result<Self> {
        let beside = &mut |uri: &str| Err(format!("{uri}: not in the file"));
        let opened = open(glb, "optimized.glb", &OpenOptions::default(), beside)?;
        let Some(file) = opened.gltf().cloned() else {
            return Err(Error::unsuited("the written file is not glTF"));
        };
        let character = opened.into_character();
        Ok(Self {
            character,
            file,
            still: None,
            worn: None,
        })
    }

    /// A file that was written of this one, with what is measured in place of meshes.
    pub(super) fn read_again(&self, glb: &[u8]) -> Result<Self> {
        let mut shown = Self::read(glb)?;
        if let Some(worn) = &self.worn {
            shown.worn = Some(worn.on_same_joints(&shown.character.skeleton)?);
        }
        Ok(shown)
    }

    /// Whether an unknown extension may refer to arrays, which then stay as they are.
    pub(super) fn keeps_arrays(&self) -> bool {
        !self.file.document.is_compressible()
    }

    /// The character whose vertices are measured: the file's, or what stands in for its meshes.
    pub(super) fn body(&self) -> &Character {
        let worn = self.worn.as_ref();
        worn.map_or(&self.character, |worn| &worn.character)
    }

    /// What errors are those of.
    pub(super) fn measured_on(&self) -> MeasuredOn {
        let worn = self.worn.as_ref();
        worn.map_or(MeasuredOn::Meshes, |worn| worn.measured_on)
    }

    pub(super) fn posed(&self) -> Result<PosedVertices<'_>> {
        Ok(PosedVertices::new(self.body())?)
    }

    /// Height of the figure at rest in metres; 1 if it has none.
    pub(super) fn height_metres(&self) -> Result<f32> {
        let mut posed = self.posed()?;
        let heights = posed.at(None, 0.0).iter().map(|p| p.y);
        let (low, high) = heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), y| {
            (low.min(y), high.max(y))
        });
        Ok(if high > low { high - low } else { 1.0 })
    }

    /// The same with meshes as the file that is written will have them.
    pub(super) fn with_rounded_mesh(&self, precision: &MeshPrecision) -> Result<Self> {
        self.read_again(&self.with_meshes(precision, Compression::None)?)
    }

    /// The file with rounded meshes, and clips, if it has them, as they are.
    pub(super) fn with_meshes(
        &self,
        precision: &MeshPrecision,
        compression: Compression,
    ) -> Result<Vec<u8>> {
        let arrays = precision.arrays(Vec::new());
        let mut document = self.still.as_ref().unwrap_or(&self.file.document).clone();
        precision.apply(&mut document)?;
        Ok(document.write_compressed(compression, &arrays)?)
    }

    /// The file with these clips.
    pub(super) fn written(
        &self,
        clips: &[OptimizedClip],
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
        precision.apply(&mut document)?;
        Ok(document.write_compressed(options.compression, &arrays)?)
    }
}

/// A document without its animations, if joints and meshes are not told by them.
fn without_animations(document: &Document, character: &Character) -> Option<Document> {
    if character.clips.is_empty() || !document.is_compressible() {
        return None;
    }
    let mut still = document.clone();
    still.remove_animations();
    let read = gltf::read_document(still.clone(), &Limits::default()).ok()?;
    let shown = read.value.character;
    let is_same = shown.skeleton == character.skeleton && shown.meshes == character.meshes;
    is_same.then_some(still)
}
