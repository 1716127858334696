//! Options of `package`.

use crate::mesh_levels::MeshLevelOptions;
use articula_core::{Viewport, Zone};
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::abp2::{Grouping, MotionOptions};
use articula_stream::afp2::Afp2Options;

/// A motion of the face that an item gets.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceMotion {
    /// Name of the file that it came from.
    pub file: String,
    /// The motion.
    pub clip: FapClip,
}

/// A file that an item carries whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CarriedFile {
    /// Name of the file, with its extension.
    pub name: String,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Options of [`package`](super::package()).
#[derive(Debug, Clone, PartialEq)]
pub struct PackageOptions {
    /// Maximum number of mesh levels, 1 to 16.
    pub mesh_levels: usize,
    /// Zones whose mesh levels can be chosen separately; the rest is one more.
    pub split: Vec<(String, Zone)>,
    /// Names of the clips to package; empty for all.
    pub clips: Vec<String>,
    /// Options of motion streams; the hash of the rig is set.
    pub motion: MotionOptions,
    /// Motions of the face.
    pub faces: Vec<FaceMotion>,
    /// Options of face streams.
    pub face: Afp2Options,
    /// Least length of the longer side of a reduced texture in pixels.
    pub least_texture_px: u32,
    /// Distances from the camera in metres at which textures are compared.
    pub texture_distances_m: Vec<f32>,
    /// Picture in whose pixels textures are compared.
    pub viewport: Viewport,
    /// Files that are carried whole.
    pub with: Vec<CarriedFile>,
    /// Whether forms in 2D are made: a still and an animated picture of the first clip.
    pub flat: bool,
    /// Width and height of forms in 2D in pixels.
    pub flat_px: u32,
}

impl Default for PackageOptions {
    /// Five mesh levels with face and hands apart, all clips in groups of level and region with five
    /// tiers, textures down to 64 pixels, compared from 1.5 to 24 metres.
    fn default() -> Self {
        let zones = ["face", "hands"];
        let zone = |name: &str| Some((name.to_owned(), name.parse().ok()?));
        Self {
            mesh_levels: 5,
            split: zones.into_iter().filter_map(zone).collect(),
            clips: Vec::new(),
            motion: MotionOptions {
                grouping: Grouping::LoaRegion,
                ..MotionOptions::default()
            },
            faces: Vec::new(),
            face: Afp2Options::default(),
            least_texture_px: 64,
            texture_distances_m: vec![1.5, 3.0, 6.0, 12.0, 24.0],
            viewport: Viewport::default(),
            with: Vec::new(),
            flat: true,
            flat_px: 400,
        }
    }
}

impl PackageOptions {
    /// Options of the mesh levels.
    pub(super) fn of_mesh(&self) -> MeshLevelOptions {
        MeshLevelOptions {
            split: self.split.clone(),
            // What a client decodes is measured again; of these errors the greatest decide.
            full_every: usize::MAX,
            sizes_alone: false,
            // The coarsest level is most of the least that an item can be cut to.
            halvings: 3,
            ..MeshLevelOptions::levels(self.mesh_levels.clamp(1, 16))
        }
    }
}
