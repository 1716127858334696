//! What was saved, and the errors.

use super::MergedJoints;
use super::errors::Errors;
use super::optimized_clip::OptimizedClip;
use super::source::Source;
use super::textures::TextureOptimized;
use super::worn::MeasuredOn;
use articula_core::source::RawClip;
use articula_formats::gltf::BytesByKind;
use serde::Serialize;

/// One clip before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClipOptimized {
    /// Name of the clip.
    pub clip: String,
    /// Number of channels before.
    pub channels_in: usize,
    /// Number of channels after.
    pub channels_out: usize,
    /// Number of keys of all channels before.
    pub keys_in: usize,
    /// Number of keys of all channels after.
    pub keys_out: usize,
    /// Greatest error of a vertex over the clip, in millimetres.
    pub error_mm: f32,
}

/// What was saved, and the errors measured on the written file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OptimizeReport {
    /// Bytes of the source file without the files beside it; 0 for a character that a program made.
    pub bytes_in: usize,
    /// Bytes of the written file.
    pub bytes_out: usize,
    /// Whether the file is the source itself, since nothing worth an error could be saved.
    #[serde(rename = "kept_as_it_is")]
    pub is_kept: bool,
    /// Bytes of the parts of the source, without compression.
    pub before: BytesByKind,
    /// Bytes of the parts of the written file.
    pub after: BytesByKind,
    /// The greatest error that was allowed, in millimetres.
    pub bound_mm: f32,
    /// What the errors are those of.
    pub measured_on: MeasuredOn,
    /// The greater of the two errors that follow, in millimetres.
    pub error_mm: f32,
    /// Greatest error of a vertex that is left, at rest and over all clips, in millimetres.
    pub vertex_error_mm: f32,
    /// Greatest distance between the surfaces of source and file where triangles were removed, in
    /// millimetres, in poses of clips and morph targets; 0 if all triangles are left.
    pub surface_error_mm: f32,
    /// The joints that were merged to be within a limit. Their error comes on top of the others, which are
    /// measured against the source with fewer joints.
    pub merged_joints: Option<MergedJoints>,
    /// Number of triangles of the source.
    pub triangles_in: usize,
    /// Number of triangles of the written file.
    pub triangles_out: usize,
    /// Greatest error of a vertex at rest, in millimetres.
    pub rest_error_mm: f32,
    /// The clips.
    pub clips: Vec<ClipOptimized>,
    /// The pictures.
    pub textures: Vec<TextureOptimized>,
    /// Whether the arrays stayed as they were, since an unknown extension may refer to them.
    pub keeps_arrays: bool,
}

impl OptimizeReport {
    /// The report without what the source and the bound say.
    pub(super) fn new(
        source: &Source,
        clips: &[OptimizedClip],
        errors: &Errors,
        glb: &[u8],
    ) -> Self {
        let keys = |clip: &RawClip| clip.channels.iter().map(|c| c.times_secs.len()).sum();
        let pairs = source.character.clips.iter().zip(clips).zip(&errors.clips);
        Self {
            bytes_in: 0,
            bytes_out: glb.len(),
            is_kept: false,
            before: BytesByKind::default(),
            after: BytesByKind::of_glb(glb),
            bound_mm: 0.0,
            measured_on: source.measured_on(),
            error_mm: 1e3 * errors.greatest(),
            vertex_error_mm: 1e3 * errors.greatest(),
            surface_error_mm: 0.0,
            merged_joints: None,
            triangles_in: source.triangles(),
            triangles_out: source.triangles(),
            rest_error_mm: 1e3 * errors.rest,
            clips: pairs
                .map(|((before, after), error)| ClipOptimized {
                    clip: before.name.clone(),
                    channels_in: before.channels.len(),
                    channels_out: after.clip.channels.len(),
                    keys_in: keys(before),
                    keys_out: keys(&after.clip),
                    error_mm: 1e3 * error,
                })
                .collect(),
            textures: Vec::new(),
            keeps_arrays: source.keeps_arrays(),
        }
    }

    /// Adds the greatest distance between the surfaces in metres.
    pub(super) fn add_surface(&mut self, metres: f32) {
        self.surface_error_mm = 1e3 * metres;
        self.error_mm = self.vertex_error_mm.max(self.surface_error_mm);
    }

    /// The report of the source itself, which has no error.
    pub(super) fn kept(self, source: &[u8]) -> Self {
        let kept_clip = |clip: ClipOptimized| ClipOptimized {
            channels_out: clip.channels_in,
            keys_out: clip.keys_in,
            error_mm: 0.0,
            ..clip
        };
        let kept_texture = |texture: TextureOptimized| TextureOptimized {
            bytes_out: texture.bytes_in,
            type_out: texture.type_in.clone(),
            size_out: texture.size_in,
            delta_e: None,
            levels: None,
            ..texture
        };
        Self {
            bytes_in: source.len(),
            bytes_out: source.len(),
            is_kept: true,
            after: BytesByKind::of_glb(source),
            error_mm: 0.0,
            vertex_error_mm: 0.0,
            surface_error_mm: 0.0,
            triangles_out: self.triangles_in,
            rest_error_mm: 0.0,
            clips: self.clips.into_iter().map(kept_clip).collect(),
            textures: self.textures.into_iter().map(kept_texture).collect(),
            ..self
        }
    }
}
