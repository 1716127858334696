//! The JSON head of an ABP-1 file.

use super::clip::{Abp1Clip, Bone, TrackKind, check_bones};
use crate::container::{self, Container};
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use serde::{Deserialize, Serialize};

pub(super) const MAGIC: [u8; 4] = *b"ABPF";
/// Step of all kinds with quantiser 1.
const BASE_STEP: f64 = 0.0001;

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Head {
    version: u32,
    #[serde(default)]
    pub(super) name: String,
    skeleton: Vec<Row>,
    frame_rate: f64,
    pub(super) total_frames: u32,
    base_steps: BaseSteps,
}

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    id: usize,
    name: String,
    parent: Option<u16>,
    center: [f32; 3],
    loa: u8,
    region: u8,
}

/// Steps with quantiser 1, in metres, radians and factors.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct BaseSteps {
    rotation: f64,
    translation: f64,
    center: f64,
    scale: f64,
}

impl BaseSteps {
    /// Those of this writer.
    pub(super) const OWN: Self = Self {
        rotation: BASE_STEP,
        translation: BASE_STEP,
        center: BASE_STEP,
        scale: BASE_STEP,
    };

    pub(super) fn of(&self, kind: TrackKind) -> f64 {
        match kind {
            TrackKind::Translation => self.translation,
            TrackKind::Rotation | TrackKind::ScaleOrientation => self.rotation,
            TrackKind::Scale => self.scale,
            TrackKind::Center => self.center,
        }
    }
}

/// What a checked head says.
#[derive(Debug)]
pub(super) struct Opened {
    pub(super) name: String,
    pub(super) bones: Vec<Bone>,
    pub(super) rate: FrameRate,
    pub(super) total_frames: usize,
    pub(super) base_steps: BaseSteps,
}

/// Splits a file and checks its head.
pub(super) fn open(
    bytes: &[u8],
    limits: &StreamLimits,
) -> Result<(Opened, Container<Head>), StreamError> {
    let mut container: Container<Head> = Container::read(bytes, MAGIC, limits)?;
    let head = &mut container.head;
    container::check_version(head.version)?;
    let bad = |what: String| StreamError::malformed("head", what);
    let mut bones = Vec::with_capacity(head.skeleton.len());
    for (b, row) in std::mem::take(&mut head.skeleton).into_iter().enumerate() {
        if row.id != b {
            return Err(bad(format!("bone {b} has the id {}", row.id)));
        }
        bones.push(Bone {
            name: row.name,
            parent: row.parent,
            center: row.center,
            loa: row.loa,
            region: row.region,
        });
    }
    check_bones(&bones).map_err(|e| bad(e.to_string()))?;
    let rate = FrameRate::nearest(head.frame_rate);
    let rate = rate.ok_or_else(|| bad(format!("a frame rate of {}", head.frame_rate)))?;
    for kind in TrackKind::ALL {
        let step = head.base_steps.of(kind);
        if !(1e-12..=1.0).contains(&step) {
            return Err(bad(format!("a step of {step}, expected 1e-12 to 1")));
        }
    }
    let opened = Opened {
        name: std::mem::take(&mut head.name),
        bones,
        rate,
        total_frames: head.total_frames as usize,
        base_steps: head.base_steps,
    };
    Ok((opened, container))
}

/// The head of a clip.
pub(super) fn of_clip(clip: &Abp1Clip) -> Head {
    let row = |(id, bone): (usize, &Bone)| Row {
        id,
        name: bone.name.clone(),
        parent: bone.parent,
        center: bone.center,
        loa: bone.loa,
        region: bone.region,
    };
    Head {
        version: container::VERSION,
        name: clip.name.clone(),
        skeleton: clip.bones.iter().enumerate().map(row).collect(),
        frame_rate: clip.rate.hz(),
        total_frames: clip.frames as u32,
        base_steps: BaseSteps::OWN,
    }
}
