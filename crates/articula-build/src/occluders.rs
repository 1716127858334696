//! Occluder capsules that stay inside a body throughout a clip.
//!
//! They are used by [`articula_core::occlusion`]. Balls are placed where the skin leaves most room
//! around the joints of the mean pose. The segment between any two of them gets the largest radius
//! that the skin leaves free at every time, and the best few are kept: the trunk, the head, a thigh
//! of a standing character. Limbs that swing in the clip get none.
//!
//! A point is inside if its generalised winding number (Jacobson, Kavan and Sorkine-Hornung 2013,
//! by the solid angles of Van Oosterom and Strackee 1983) is a whole number and not 0; a skin with
//! holes therefore has no inside and no occluders. This is tested at one time only: skin that never
//! comes near a point cannot have passed it.
//!
//! The skin must be opaque; this is not checked.

use crate::character::Asset;
use crate::motion_bounds::reach::Reach;
use crate::motion_bounds::{Body, SampleTime, sample_times};
use articula_core::Libm;
use articula_core::{Capsule, Clip, Track, triangle_distance_squared};
use glam::Vec3;

/// Minimum radius of a capsule, in metres.
const MIN_RADIUS_METRES: f32 = 0.03;

/// Number of points along a segment at which the distance to the skin is measured.
const PLACES: usize = 17;

/// Number of sample times that select the segments to measure through the whole clip, and the
/// number of these segments.
const FIRST_LOOKS: usize = 8;
const MEASURED: usize = 12;

/// Minimum room at a starting point, in metres; less room is a finger or an ear.
const MIN_START_METRES: f32 = 0.01;

/// Step sizes of the search for more room, from a few centimetres to a few millimetres.
const STEPS_METRES: [f32; 4] = [0.04, 0.02, 0.01, 0.005];

/// Distance below which two balls count as one, in metres.
const SAME_METRES: f32 = 0.03;

/// Maximum distance of the winding number from a whole number: holes that cover a hundredth of the
/// sphere.
const HOLES: f32 = 0.01;

/// Returns at most `most` capsules in model space that lie inside the body at every time of the
/// clip, the largest first. Returns none if the skin is not closed, or the clip has stepped tracks.
pub fn occluders(asset: &Asset, clip: &Clip, most: usize) -> Vec<Capsule> {
    if asset.mesh.triangles.is_empty() || jumps(clip) {
        return Vec::new();
    }
    let reach = Reach::new(asset);
    let sample_times = sample_times(asset, &reach, clip);
    let mut body = Body::new(asset);
    let mut skin_at = |sample: &SampleTime| Skin::new(asset, clip, sample, &reach, &mut body);
    let apart = sample_times.len().div_ceil(FIRST_LOOKS);
    let first: Vec<Skin> = sample_times
        .iter()
        .step_by(apart)
        .map(&mut skin_at)
        .collect();
    let mut segments = segments(&balls(asset, clip, &sample_times, &first));
    for skin in &first {
        skin.narrow(&mut segments);
    }
    let mut segments = largest(segments, MEASURED);
    for sample in &sample_times {
        skin_at(sample).narrow(&mut segments);
    }
    largest(segments, most)
        .iter()
        .map(Segment::capsule)
        .collect()
}

/// The largest segments, without those that lie to a half or more inside larger ones.
fn largest(mut segments: Vec<Segment>, most: usize) -> Vec<Segment> {
    segments.sort_by(|a, b| b.area().total_cmp(&a.area()));
    let mut chosen: Vec<Segment> = Vec::new();
    for segment in segments {
        let covered = |place: &Vec3| chosen.iter().any(|c| c.capsule().contains(*place));
        let new = segment.places().iter().filter(|p| !covered(p)).count();
        if chosen.len() < most && 2 * new > PLACES {
            chosen.push(segment);
        }
    }
    chosen
}

/// Whether any track holds its values until the next frame, so that skin may pass a point between
/// two sample times.
fn jumps(clip: &Clip) -> bool {
    fn any<T>(tracks: &[Track<T>]) -> bool {
        tracks.iter().any(|t| t.step && t.values.len() > 1)
    }
    any(&clip.tracks().rotations)
        || any(&clip.tracks().translations)
        || any(&clip.tracks().scales)
        || any(&clip.tracks().morphs)
}

/// A segment inside the body and its distance from the skin.
struct Segment {
    ends: [Vec3; 2],
    free: f32,
}

impl Segment {
    fn places(&self) -> [Vec3; PLACES] {
        let [a, b] = self.ends;
        std::array::from_fn(|i| a.lerp(b, i as f32 / (PLACES - 1) as f32))
    }

    /// Any point within this radius of the segment is within the free distance of a sampled point.
    fn radius(&self) -> f32 {
        let half_step = 0.5 * self.ends[0].distance(self.ends[1]) / (PLACES - 1) as f32;
        (self.free * self.free - half_step * half_step)
            .max(0.0)
            .sqrt()
    }

    fn capsule(&self) -> Capsule {
        Capsule {
            ends: self.ends,
            radius: self.radius(),
        }
    }

    /// Projected area from the side.
    fn area(&self) -> f32 {
        let r = self.radius();
        2.0 * r * self.ends[0].distance(self.ends[1]) + std::f32::consts::PI * r * r
    }
}

/// Points where the skin leaves most room at the first sample times, found by ascent from the mean
/// positions of the joints and the points half-way between them.
fn balls(asset: &Asset, clip: &Clip, sample_times: &[SampleTime], skins: &[Skin]) -> Vec<Vec3> {
    let rig = &asset.rig;
    let mut body = Body::new(asset);
    let mut means = vec![Vec3::ZERO; rig.len()];
    for sample in sample_times {
        body.pose(clip, sample.secs);
        for (joint, mean) in means.iter_mut().enumerate() {
            *mean += body.posed.model.position(joint) / sample_times.len() as f32;
        }
    }
    let halves = (0..rig.len()).filter_map(|j| Some(0.5 * (means[rig.parent(j)?] + means[j])));
    let mut starts: Vec<Vec3> = halves.collect();
    starts.extend(&means);
    let room = |place: Vec3| {
        let skins = skins.iter();
        skins.fold(f32::INFINITY, |free, skin| skin.free(place, free))
    };
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    let directions = axes.into_iter().chain(axes.map(|axis| -axis));
    let mut balls: Vec<Vec3> = Vec::new();
    for start in starts {
        let (mut place, mut free) = (start, room(start));
        if free < MIN_START_METRES || !skins[0].is_inside(start) {
            continue;
        }
        for step in STEPS_METRES {
            // A step no longer than the free distance does not cross the skin.
            let around = |place: Vec3, free: f32| {
                let tries = directions.clone().map(|d| place + d * step.min(free));
                let rooms = tries.map(|p| (p, room(p)));
                rooms
                    .max_by(|a, b| a.1.total_cmp(&b.1))
                    .filter(|b| b.1 > free)
            };
            while let Some((p, more)) = around(place, free) {
                (place, free) = (p, more);
            }
        }
        let is_new = balls.iter().all(|b| b.distance(place) > SAME_METRES);
        if is_new && free >= MIN_RADIUS_METRES {
            balls.push(place);
        }
    }
    balls
}

/// All segments between two balls, and from each to itself. If no skin is near, all of a segment is
/// inside if its ends are; segments that cross skin are found by the distance.
fn segments(balls: &[Vec3]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (i, from) in balls.iter().enumerate() {
        segments.extend(balls[i..].iter().map(|to| Segment {
            ends: [*from, *to],
            free: f32::INFINITY,
        }));
    }
    segments
}

/// A triangle of the skin, and its maximum travel around the sample time.
struct Face {
    corners: [Vec3; 3],
    slack: f32,
    /// Bounding sphere, including the travel.
    centre: Vec3,
    radius: f32,
}

/// The skin at one sample time.
struct Skin {
    faces: Vec<Face>,
}

impl Skin {
    fn new(
        asset: &Asset,
        clip: &Clip,
        sample: &SampleTime,
        reach: &Reach,
        body: &mut Body<'_>,
    ) -> Self {
        let mesh = &asset.mesh;
        let ways = reach.ways(asset, clip, sample.frame);
        let slack = |v: u32| {
            let joints = mesh.influences_of(v as usize).map(|(joint, _)| ways[joint]);
            joints.fold(0.0, f32::max) * sample.part
        };
        let positions = body.pose(clip, sample.secs);
        let face = |triangle: &[u32; 3]| {
            let corners = triangle.map(|v| positions[v as usize]);
            let centre = corners.iter().sum::<Vec3>() / 3.0;
            let slack = triangle.map(slack).into_iter().fold(0.0, f32::max);
            let out = corners.map(|c| c.distance(centre));
            Face {
                corners,
                slack,
                centre,
                radius: out.into_iter().fold(0.0, f32::max) + slack,
            }
        };
        Self {
            faces: mesh.triangles.iter().map(face).collect(),
        }
    }

    /// Lower bound on the distance of the skin from a point, around the sample time; at most
    /// `at_most`.
    fn free(&self, place: Vec3, at_most: f32) -> f32 {
        let mut free = at_most;
        for face in &self.faces {
            let beyond = free + face.radius;
            if beyond < 0.0 || place.distance_squared(face.centre) < beyond * beyond {
                let distance = triangle_distance_squared(place, face.corners).sqrt();
                free = free.min(distance - face.slack);
            }
        }
        free
    }

    /// Reduces the free distances of segments to those at this time, and removes segments that
    /// become too thin.
    fn narrow(&self, segments: &mut Vec<Segment>) {
        segments.retain_mut(|segment| {
            for place in segment.places() {
                segment.free = self.free(place, segment.free);
                if segment.free < MIN_RADIUS_METRES {
                    return false;
                }
            }
            segment.radius() >= MIN_RADIUS_METRES
        });
    }

    fn is_inside(&self, place: Vec3) -> bool {
        let angle = |face: &Face| {
            let [a, b, c] = face.corners.map(|corner| (corner - place).as_dvec3());
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let volume = a.dot(b.cross(c));
            let rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * volume.libm_atan2(rest)
        };
        let whole = 4.0 * std::f64::consts::PI;
        let winds = (self.faces.iter().map(angle).sum::<f64>() / whole).abs();
        winds > 0.5 && (winds - winds.round()).abs() <= f64::from(HOLES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_segment_by_hand() {
        // 0.8 m in sixteen steps of 0.05 m; 65 mm are free: 60 mm beside the middle of a step.
        let segment = Segment {
            ends: [Vec3::ZERO, Vec3::Y * 0.8],
            free: 0.065,
        };
        assert_eq!(segment.places()[16], Vec3::Y * 0.8);
        assert!((segment.radius() - 0.06).abs() < 1e-6);
        assert!((segment.area() - (0.096 + 0.003_6 * std::f32::consts::PI)).abs() < 1e-6);
    }
}
