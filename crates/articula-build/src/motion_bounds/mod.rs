//! Bounding volumes of a character for each second of each clip, made from every vertex.
//!
//! Source: `docs/methods/motion-lod.md` part 5. The skin is posed one or more times between every
//! two frames; its motion between these times is covered by a bound on its speed. The bounds
//! therefore hold for every vertex at every time, not only at the sampled ones.
//!
//! Without a mesh the joints are the skin, each with the minimum lever around it. Morph weights
//! follow the clip; a face that is driven otherwise needs a margin.

pub(crate) mod reach;

use crate::character::Asset;
use crate::motion_error::joint_lever::JointLever;
use articula_core::{
    Bound, Clip, ClipBounds, LocalPose, Mismatch, MotionBounds, PosedMesh, SkinnedMesh, Sphere,
    Wrap, sample, sample_morphs,
};
use glam::Vec3;
use reach::Reach;
use std::ops::RangeInclusive;

/// Distance of the skin from a sampled pose above which the interval gets more samples.
const SLACK_METRES: f32 = 0.01;

/// Maximum number of samples between two frames.
const MAX_LOOKS: usize = 8;

/// Covers f32 rounding in a pose that is computed in a different order.
const ROUNDING_METRES: f32 = 1e-4;

/// Computes the bounds of every clip of a character.
///
/// `margin_metres` is added on all sides, for cloth, hair, or a face that the clips do not drive.
///
/// # Errors
/// A [`Mismatch`] if the margin is negative or not finite, or a clip moves the skin to positions
/// that are not finite.
pub fn motion_bounds(asset: &Asset, margin_metres: f32) -> Result<MotionBounds, Mismatch> {
    if !(margin_metres.is_finite() && margin_metres >= 0.0) {
        let what = format!("must be finite and at least 0, found {margin_metres}");
        return Err(Mismatch::new("margin_metres", what));
    }
    let reach = Reach::new(asset);
    let margin = margin_metres + ROUNDING_METRES;
    let clips = asset.clips.iter();
    let measured = clips.map(|clip| measure(asset, &reach, clip, margin));
    Ok(MotionBounds {
        clips: measured.collect::<Result<_, _>>()?,
        reach_metres: reach.anchor_metres() + margin,
    })
}

fn measure(asset: &Asset, reach: &Reach, clip: &Clip, margin: f32) -> Result<ClipBounds, Mismatch> {
    let mut body = Body::new(asset);
    let sample_times = sample_times(asset, reach, clip);
    let mut anchor = Corners::NOTHING;
    let mut boxes = vec![Corners::NOTHING; ClipBounds::count(clip.duration_secs())];
    for sample in &sample_times {
        let skin = body.pose(clip, sample.secs);
        let mut around = Corners::NOTHING;
        for p in skin {
            around.hold(*p, sample.slack);
        }
        for second in sample.seconds.clone() {
            boxes[second].join(&around);
        }
        let at = reach
            .anchor()
            .map_or(Vec3::ZERO, |j| body.posed.model.position(j));
        anchor.hold(at, sample.slack);
    }
    // The sphere of a second is centred in its box and just encloses the skin: it is smaller than
    // one around the corners of the box.
    let mut radii = vec![0.0f32; boxes.len()];
    for sample in &sample_times {
        let skin = body.pose(clip, sample.secs);
        for second in sample.seconds.clone() {
            let middle = boxes[second].middle();
            let squared = skin.iter().map(|p| p.distance_squared(middle));
            let farthest = squared.fold(0.0, f32::max).sqrt() + sample.slack;
            radii[second] = radii[second].max(farthest);
        }
    }
    let bounds = boxes.iter().zip(radii).map(|(corners, radius)| {
        let out = margin + body.floor;
        let sphere = Sphere {
            centre: corners.middle(),
            radius: radius + out,
        };
        let bound = Bound {
            sphere,
            least: corners.least - out,
            greatest: corners.greatest + out,
        };
        let is_finite = corners.is_finite && radius.is_finite();
        is_finite.then_some(bound)
    });
    let seconds: Option<Vec<Bound>> = bounds.collect();
    let seconds = seconds.ok_or_else(|| {
        let what = "the skinned positions are not finite; check the clip and the skin weights";
        Mismatch::new(format!("clip \"{}\"", clip.name), what)
    })?;
    let anchors = Sphere::from_corners(anchor.least, anchor.greatest);
    ClipBounds::new(clip.duration_secs(), seconds, anchors)
}

/// A time at which the skin is posed.
pub(crate) struct SampleTime {
    pub(crate) secs: f64,
    /// Seconds of the clip that it belongs to.
    seconds: RangeInclusive<usize>,
    /// Maximum distance of the skin from this pose over the part of the interval that it covers.
    slack: f32,
    /// The frame before it, and the fraction of the interval to the next frame that it covers on
    /// either side.
    pub(crate) frame: usize,
    pub(crate) part: f32,
}

/// Sample times in the middle of equal parts of every interval between two frames, and at the last
/// frame. A stepped value is constant in an interval, so a part differs from its middle by motion
/// only.
pub(crate) fn sample_times(asset: &Asset, reach: &Reach, clip: &Clip) -> Vec<SampleTime> {
    let last_second = ClipBounds::count(clip.duration_secs()) - 1;
    let rate = f64::from(clip.rate_hz());
    let mut sample_times = Vec::new();
    for frame in 0..clip.frames() - 1 {
        let half_way = 0.5 * reach.way(asset, clip, frame);
        let parts = ((half_way / SLACK_METRES).ceil() as usize).clamp(1, MAX_LOOKS);
        // A boundary between two seconds belongs to both.
        let border = 1e-6;
        let first = (frame as f64 / rate - border).max(0.0) as usize;
        let last = ((frame + 1) as f64 / rate + border) as usize;
        for part in 0..parts {
            sample_times.push(SampleTime {
                secs: (frame as f64 + (part as f64 + 0.5) / parts as f64) / rate,
                seconds: first.min(last_second)..=last.min(last_second),
                slack: half_way / parts as f32,
                frame,
                part: 0.5 / parts as f32,
            });
        }
    }
    sample_times.push(SampleTime {
        // Beyond the end, where the last frame is held: the end itself may round to before that frame,
        // at which a stepped value is that of the frame before.
        secs: clip.frames() as f64 / rate,
        seconds: last_second..=last_second,
        slack: 0.0,
        frame: clip.frames() - 1,
        part: 0.0,
    });
    sample_times
}

/// A box that grows.
#[derive(Clone)]
struct Corners {
    least: Vec3,
    greatest: Vec3,
    is_finite: bool,
}

impl Corners {
    const NOTHING: Self = Self {
        least: Vec3::INFINITY,
        greatest: Vec3::NEG_INFINITY,
        is_finite: true,
    };

    fn hold(&mut self, point: Vec3, slack: f32) {
        self.least = self.least.min(point - slack);
        self.greatest = self.greatest.max(point + slack);
        // `min` and `max` ignore NaN.
        self.is_finite &= point.is_finite() && slack.is_finite();
    }

    fn join(&mut self, other: &Self) {
        self.least = self.least.min(other.least);
        self.greatest = self.greatest.max(other.greatest);
        self.is_finite &= other.is_finite;
    }

    fn middle(&self) -> Vec3 {
        0.5 * (self.least + self.greatest)
    }
}

/// A character to be posed; without a mesh its joints are its skin.
pub(crate) struct Body<'a> {
    asset: &'a Asset,
    local: LocalPose,
    pub(crate) posed: PosedMesh<'a>,
    morph_weights: Vec<f32>,
    skinned: SkinnedMesh,
    /// Margin around each point of the skin: the minimum lever for joints, 0 for vertices.
    floor: f32,
}

impl<'a> Body<'a> {
    pub(crate) fn new(asset: &'a Asset) -> Self {
        let (rig, mesh) = (&asset.rig, &asset.mesh);
        let mut skinned = SkinnedMesh::new(mesh);
        let is_bare = mesh.is_empty();
        if is_bare {
            skinned.positions = vec![Vec3::ZERO; rig.len()];
        }
        Self {
            asset,
            local: rig.rest_pose().clone(),
            posed: PosedMesh::new(rig, mesh),
            morph_weights: mesh.morph_weights.clone(),
            skinned,
            floor: if is_bare {
                JointLever::FLOOR_METRES
            } else {
                0.0
            },
        }
    }

    pub(crate) fn pose(&mut self, clip: &Clip, secs: f64) -> &[Vec3] {
        let (rig, mesh) = (&self.asset.rig, &self.asset.mesh);
        sample(clip, secs, Wrap::Clamp, &rig.all(), &mut self.local);
        sample_morphs(clip, secs, Wrap::Clamp, &mut self.morph_weights);
        self.posed.pose(&self.local);
        if mesh.is_empty() {
            for (joint, p) in self.skinned.positions.iter_mut().enumerate() {
                *p = self.posed.model.position(joint);
            }
        } else {
            self.posed.skin(&self.morph_weights, &mut self.skinned);
        }
        &self.skinned.positions
    }
}
