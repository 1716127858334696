//! Bounding volumes of a character for each second of each clip, made from every vertex.
//!
//! Source: `docs/methods/motion-lod.md` part 5. The skin is posed one or more times between every
//! two frames; its motion between these times is covered by a bound on its speed. The bounds
//! therefore hold for every vertex at every time, not only at the sampled ones. Vertices are left out
//! where the box around their [patch](patches) lies within the bound that is known by then.
//!
//! Without a mesh the joints are the skin, each with the minimum lever around it. Morph weights
//! follow the clip; a face that is driven otherwise needs a margin.

mod patches;
pub(crate) mod reach;

use crate::character::Asset;
use crate::motion_error::joint_lever::JointLever;
use articula_core::{
    Bound, Clip, ClipBounds, LocalPose, Mismatch, MotionBounds, PosedMesh, SkinnedMesh, Sphere,
    Wrap, palette, sample, sample_morphs,
};
use glam::{Affine3A, Vec3};
use patches::{MorphedSkin, Patches};
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
    let patches = Patches::new(&asset.mesh);
    let margin = margin_metres + ROUNDING_METRES;
    let clips = asset.clips.iter();
    let measured = clips.map(|clip| {
        let skin = BoundedSkin::new(asset, &patches, clip);
        measure(asset, &reach, skin, margin)
    });
    Ok(MotionBounds {
        clips: measured.collect::<Result<_, _>>()?,
        reach_metres: reach.anchor_metres() + margin,
    })
}

/// Bounds of the clips of a character that no pose is needed for: a sphere around the origin of the model
/// that no skin leaves, whatever the rotations of its joints. They are wider than those of
/// [`motion_bounds`] and take milliseconds.
///
/// # Errors
/// A [`Mismatch`] if a position or length of the character or its clips is not finite.
pub fn reach_bounds(asset: &Asset) -> Result<MotionBounds, Mismatch> {
    let reach = Reach::new(asset);
    let out = reach.origin_metres() + ROUNDING_METRES;
    if !out.is_finite() {
        let what = "the lengths of the skeleton are not finite";
        return Err(Mismatch::new("rig", what));
    }
    let around = Sphere {
        centre: Vec3::ZERO,
        radius: out,
    };
    let bound = Bound {
        sphere: around,
        least: Vec3::splat(-out),
        greatest: Vec3::splat(out),
    };
    let of = |clip: &Clip| {
        let secs = clip.duration_secs();
        ClipBounds::new(secs, vec![bound; ClipBounds::count(secs)], around)
    };
    Ok(MotionBounds {
        clips: asset.clips.iter().map(of).collect::<Result<_, _>>()?,
        reach_metres: reach.anchor_metres() + ROUNDING_METRES,
    })
}

fn measure(
    asset: &Asset,
    reach: &Reach,
    mut skin: BoundedSkin<'_>,
    margin: f32,
) -> Result<ClipBounds, Mismatch> {
    let clip = skin.clip;
    let sample_times = sample_times(asset, reach, clip);
    let mut anchor = Corners::NOTHING;
    let mut boxes = vec![Corners::NOTHING; ClipBounds::count(clip.duration_secs())];
    for sample in &sample_times {
        skin.pose(sample.secs);
        let mut around = Corners::NOTHING;
        let seconds = &mut boxes[sample.seconds.clone()];
        let is_within = |least: Vec3, greatest: Vec3| {
            let slack = Vec3::splat(sample.slack);
            let mut seconds = seconds.iter();
            seconds.all(|known| known.holds(least - slack, greatest + slack))
        };
        skin.beyond(is_within, |p| around.hold(p, sample.slack));
        for second in seconds {
            second.join(&around);
        }
        let at = reach
            .anchor()
            .map_or(Vec3::ZERO, |j| skin.body.posed.model.position(j));
        anchor.hold(at, sample.slack);
    }
    // The sphere of a second is centred in its box and just encloses the skin: it is smaller than
    // one around the corners of the box.
    let mut radii = vec![0.0f32; boxes.len()];
    for sample in &sample_times {
        skin.pose(sample.secs);
        for second in sample.seconds.clone() {
            let middle = boxes[second].middle();
            let known = radii[second] - sample.slack;
            let is_within = |least: Vec3, greatest: Vec3| {
                let corner = (least - middle).abs().max((greatest - middle).abs());
                corner.length() <= known
            };
            let mut squared = 0.0f32;
            skin.beyond(is_within, |p| {
                squared = squared.max(p.distance_squared(middle));
            });
            radii[second] = radii[second].max(squared.sqrt() + sample.slack);
        }
    }
    let bounds = boxes.iter().zip(radii).map(|(corners, radius)| {
        let out = margin + skin.body.floor;
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

    /// Whether a box lies within, which one that is not finite does not.
    fn holds(&self, least: Vec3, greatest: Vec3) -> bool {
        least.cmpge(self.least).all() && greatest.cmple(self.greatest).all()
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

/// The skin of a character in a clip, of which only what may lie beyond a bound is posed.
struct BoundedSkin<'a> {
    body: Body<'a>,
    clip: &'a Clip,
    skin: Skin<'a>,
    palette: Vec<Affine3A>,
    points: Vec<Vec3>,
}

/// How the points of a skin are found.
enum Skin<'a> {
    /// All of them, as of a character without a mesh.
    Whole,
    /// By patches.
    Rigid(&'a Patches),
    /// By patches that morph targets move.
    Morphed(Box<MorphedSkin<'a>>),
}

impl<'a> BoundedSkin<'a> {
    fn new(asset: &'a Asset, patches: &'a Patches, clip: &'a Clip) -> Self {
        let mesh = &*asset.mesh;
        let is_morphed = mesh.morph_weights.iter().any(|w| *w != 0.0)
            || !(mesh.morphs.is_empty() || clip.tracks().morphs.is_empty());
        Self {
            body: Body::new(asset),
            clip,
            skin: match (mesh.is_empty(), is_morphed) {
                (true, _) => Skin::Whole,
                (false, false) => Skin::Rigid(patches),
                (false, true) => Skin::Morphed(Box::new(MorphedSkin::new(mesh, patches))),
            },
            palette: vec![Affine3A::IDENTITY; mesh.bindings.len()],
            points: Vec::new(),
        }
    }

    fn pose(&mut self, secs: f64) {
        let body = &mut self.body;
        if let Skin::Whole = self.skin {
            body.pose(self.clip, secs);
            return;
        }
        body.pose_joints(self.clip, secs);
        palette(&body.asset.mesh, &body.posed.model, &mut self.palette);
        if let Skin::Morphed(skin) = &mut self.skin {
            sample_morphs(self.clip, secs, Wrap::Clamp, &mut body.morph_weights);
            skin.set(&body.morph_weights);
        }
    }

    /// Calls `see` with the points of the skin, but for those around which there is a box, given by two
    /// corners, that is within what is known.
    fn beyond(&mut self, is_within: impl FnMut(Vec3, Vec3) -> bool, mut see: impl FnMut(Vec3)) {
        let (palette, points) = (&self.palette[..], &mut self.points);
        match &mut self.skin {
            Skin::Whole => self.body.skinned.positions.iter().for_each(|p| see(*p)),
            Skin::Rigid(patches) => {
                let mesh = &*self.body.asset.mesh;
                patches.beyond((mesh, palette, points), is_within, see);
            }
            Skin::Morphed(skin) => skin.beyond(palette, points, is_within, see),
        }
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

    fn pose_joints(&mut self, clip: &Clip, secs: f64) {
        let joints = self.asset.rig.all();
        sample(clip, secs, Wrap::Clamp, &joints, &mut self.local);
        self.posed.pose(&self.local);
    }

    pub(crate) fn pose(&mut self, clip: &Clip, secs: f64) -> &[Vec3] {
        self.pose_joints(clip, secs);
        let mesh = &self.asset.mesh;
        sample_morphs(clip, secs, Wrap::Clamp, &mut self.morph_weights);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{arm, moving};
    use articula_core::{Morph, Track, Tracks};
    use glam::Quat;
    use std::sync::Arc;

    #[test]
    fn bounds_are_those_of_the_whole_skin() {
        let mut asset = arm(6);
        let turn = |i: usize| Quat::from_rotation_z(0.3 * i as f32) * Quat::from_rotation_x(0.2);
        let turns: Vec<Quat> = (0..90).map(turn).collect();
        asset.clips = vec![moving(6, 2, &turns), moving(6, 4, &turns[..7])];
        let tracks = Tracks {
            morphs: vec![Track {
                target: 0,
                step: false,
                values: (0..20).map(|i| 0.1 * i as f32 - 0.5).collect(),
            }],
            ..Tracks::default()
        };
        asset
            .clips
            .push(Clip::new("bulge", 30.0, 20, 6, tracks).unwrap());
        let mesh = Arc::make_mut(&mut asset.mesh);
        mesh.morph_weights = vec![0.0];
        mesh.morphs = vec![Morph {
            slot: 0,
            vertices: vec![1, 11, 40],
            positions: vec![Vec3::X, Vec3::new(0.1, -2.0, 0.3), Vec3::splat(0.7)],
            normals: vec![Vec3::ZERO; 3],
        }];
        let reach = Reach::new(&asset);
        let patches = Patches::new(&asset.mesh);
        for clip in &asset.clips {
            let bounded = BoundedSkin::new(&asset, &patches, clip);
            let whole = BoundedSkin {
                skin: Skin::Whole,
                ..BoundedSkin::new(&asset, &patches, clip)
            };
            let found = [bounded, whole].map(|skin| measure(&asset, &reach, skin, 0.1).unwrap());
            assert_eq!(found[0], found[1], "{}", clip.name);
        }
    }
}
