//! Parts of an item and their layers, as the manifest has them.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What a part is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PartKind {
    /// Mesh levels, an `.ams` stream.
    Mesh,
    /// A motion of the whole character, an `.abp` stream.
    BodyMotion,
    /// Facial animation parameters, an `.afp` stream.
    FaceMotion,
    /// A picture at several sizes.
    Texture,
}

/// Size of a picture that the figure has in place of one of the character: the smallest size of a texture,
/// which needs no file.
pub(super) const PIXEL: [u32; 2] = [1, 1];

impl PartKind {
    /// Whether it is a motion, of the body or of the face.
    pub fn is_motion(self) -> bool {
        matches!(self, Self::BodyMotion | Self::FaceMotion)
    }
}

/// A part of an item: its layers are sent or left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ItemPart {
    /// Name, unique among parts of its kind.
    pub name: String,
    /// What it is.
    pub kind: PartKind,
    /// The stream; `None` for a texture, each size of which is a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The unit index of the stream.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<String>,
    /// Bytes of all layers and of `base_bytes`.
    pub bytes: u64,
    /// Bytes that stay when all layers are cut: the head of a stream. 0 for a texture.
    pub base_bytes: u64,
    /// Where they lie in the stream: first byte and number of bytes, rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub base_ranges: Vec<[u64; 2]>,
    /// Greatest error in metres when all layers are cut; `None` where nothing is shown then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base_error_m: Option<f64>,
    /// Duration of a motion in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub duration_secs: Option<f64>,
    /// Frames of a motion per second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate_hz: Option<f64>,
    /// Frames on which errors were measured: of motions the frames of the clip, of meshes poses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames_measured: Option<u64>,
    /// Index of a texture among the pictures of the figure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<usize>,
    /// Layers; each comes after those that it needs.
    pub layers: Vec<ItemLayer>,
    /// Of a mesh: all of it at each level, finest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<MeshLevelEntry>,
    /// Names of the regions of layers, by the numbers of the marker `region`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<RegionEntry>,
    /// Of a motion of the body with morph targets of the face: the stream without levels of articulation
    /// of the face above `number`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub face_levels: Vec<RegionEntry>,
    /// Regions of a motion that were cut away, all or in part. The errors of layers do not count them:
    /// they are added ([`ItemPart::left_out_m`]).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<RegionEntry>,
}

/// What a part holds beyond other layers of it.
///
/// Errors are those of the part with this layer and all that it needs, directly or not, against the
/// packaged character.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ItemLayer {
    /// Name for people, such as `tier 2`.
    pub name: String,
    /// Values of markers that its units have.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub keep: BTreeMap<String, u32>,
    /// Indices of the layers that it builds on; all are smaller than its own.
    pub needs: Vec<usize>,
    /// Bytes of this layer alone.
    pub bytes: u64,
    /// Where they lie in the stream: first byte and number of bytes, rising. Empty for a texture, and
    /// where layers do not begin and end at whole bytes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ranges: Vec<[u64; 2]>,
    /// Greatest error in metres on the skin, in motion.
    pub error_m: f64,
    /// Mean error in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_mean_m: Option<f64>,
    /// Of one region of a mesh: the greatest error with all others at level 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_alone_m: Option<f64>,
    /// Number of joints that are moved at most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joints: Option<u64>,
    /// Number of triangles that are shown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub triangles: Option<u64>,
    /// Number of vertices that they use.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertices: Option<u64>,
    /// Of a texture: the file; `None` for its mean colour, which the figure has.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Of a texture: width and height in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_px: Option<[u32; 2]>,
    /// Of a texture: side of a texel on the skin in metres, the median over the skin by area; `None`
    /// where no triangle shows it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texel_m: Option<f64>,
    /// Of a texture: its error in views.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub views: Vec<TextureView>,
}

/// The mesh at one level, all regions together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeshLevelEntry {
    /// Number; 0 is the finest.
    pub level: u32,
    /// Number of triangles.
    pub triangles: u64,
    /// Number of vertices that they use.
    pub vertices: u64,
    /// Bytes of the stream cut to this level.
    pub bytes: u64,
    /// Greatest distance of the packaged surface from the decoded level at rest, in metres.
    pub error_rest_m: f64,
    /// The same in motion.
    pub error_motion_m: f64,
    /// 95th percentile of the distances in motion.
    pub error_motion_p95_m: f64,
}

/// A region of a part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RegionEntry {
    /// Value of the marker `region` (`face_region` of a face).
    pub number: u32,
    /// Name.
    pub name: String,
    /// Of a motion: bytes of the stream without this region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bytes_without: Option<u64>,
    /// Of a motion: greatest error in metres of the stream without this region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_without_m: Option<f64>,
}

/// Error of a texture in one view: the same picture with the original and with this size.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TextureView {
    /// Distance from the camera in metres.
    pub distance_m: f64,
    /// Pixels that one metre spans there.
    pub px_per_metre: f64,
    /// Root mean square difference over the character, in levels of 0 to 255.
    pub rms_levels: f64,
    /// The shift of the picture that would make the same difference, in pixels.
    pub error_px: f64,
    /// Side of a texel in pixels, by `texel_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texel_px: Option<f64>,
}

impl ItemPart {
    /// A part without a file or layers.
    pub(super) fn new(name: impl Into<String>, kind: PartKind) -> Self {
        Self {
            name: name.into(),
            kind,
            file: None,
            index: None,
            bytes: 0,
            base_bytes: 0,
            base_ranges: Vec::new(),
            base_error_m: None,
            duration_secs: None,
            rate_hz: None,
            frames_measured: None,
            image: None,
            layers: Vec::new(),
            levels: Vec::new(),
            regions: Vec::new(),
            face_levels: Vec::new(),
            left_out: Vec::new(),
        }
    }

    /// Returns the first kept layer that needs one which is not kept.
    pub(super) fn unmet(&self, kept: &[bool]) -> Option<usize> {
        let has = |i: &usize| kept.get(*i) == Some(&true);
        (0..self.layers.len()).find(|i| has(i) && !self.layers[*i].needs.iter().all(&has))
    }

    /// Returns for each layer whether it is one of these, or one of these needs it, directly or not.
    pub fn closure(&self, layers: &[usize]) -> Vec<bool> {
        let mut kept = vec![false; self.layers.len()];
        for layer in layers {
            if let Some(kept) = kept.get_mut(*layer) {
                *kept = true;
            }
        }
        // What a layer needs comes before it.
        for layer in (0..kept.len()).rev().filter(|i| *i < self.layers.len()) {
            if kept[layer] {
                for need in &self.layers[layer].needs {
                    if let Some(kept) = kept.get_mut(*need) {
                        *kept = true;
                    }
                }
            }
        }
        kept
    }

    /// Bound in metres of the error that regions which were cut away add to that of any layers.
    ///
    /// A chain of joints is compared region by region, from the root on: what lies above is moved
    /// rigidly, what lies below is as it should be, so each region adds at most its own error.
    pub fn left_out_m(&self) -> f64 {
        let held = self.base_error_m.unwrap_or(0.0);
        let errors = self.left_out.iter();
        errors.map(|r| r.error_without_m.unwrap_or(held)).sum()
    }

    /// Error in metres with all layers: of a mesh that of its finest level, since each of its layers is
    /// measured beside coarser regions. `None` if the part has neither layers nor levels.
    pub fn whole_error_m(&self) -> Option<f64> {
        let finest = self.levels.iter().min_by_key(|level| level.level);
        let layers = self.layers.iter().map(|layer| layer.error_m);
        finest
            .map(|level| level.error_motion_m)
            .or_else(|| layers.reduce(f64::min))
    }

    /// Bytes of the part with some of its layers.
    pub fn bytes_of(&self, kept: &[bool]) -> u64 {
        let of_layers = self.layers.iter().zip(kept).filter(|(_, kept)| **kept);
        let bytes = of_layers.map(|(layer, _)| layer.bytes);
        bytes.fold(self.base_bytes, u64::saturating_add)
    }
}
