//! The choice of directions: as few as keep what an eye between them sees within a distance.
//!
//! With a plane that a picture is shown on, what an eye sees wrong of a vertex is the depth of the
//! vertex off the plane, along the direction of the picture, times the sine of the angle between
//! that direction and the eye. So the depths are measured once, by pitch, and a row's height and
//! number of yaws follow. Upright planes have the smaller depths for a figure that stands, except
//! for eyes far above or below.

use super::keys::judged;
use super::samples::MotionSamples;
use super::views::{ImpostorView, ImpostorViews, ViewRow};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Step of the pitches at which depths are measured, radians: 2.5 degrees.
const STEP: f32 = PI / 72.0;

/// Number of measured pitches, from straight below to straight above.
const PITCHES: usize = 73;

/// Yaws at which depths are measured.
const YAWS: u32 = 12;

/// Poses at which depths are measured, over all clips.
const POSES: usize = 48;

/// Vertices at which depths are measured.
const MAX_VERTICES: usize = 250;

/// Steepest pitch at which an upright plane is tried, radians: 75 degrees.
const UPRIGHT_TO: f32 = 5.0 * PI / 12.0;

/// Leans of planes that are tried, in tangents of the pitch: across the direction, upright, and
/// between.
const LEANS: [f32; 3] = [0.0, 0.5, 1.0];

/// Maximum number of yaws of a row.
const MAX_YAWS: u32 = 128;

/// Tallest row, radians: 45 degrees.
const TALLEST: f32 = PI / 4.0;

/// What the character spans at one pitch.
#[derive(Debug, Clone, Copy, Default)]
struct AtPitch {
    /// Lean of the plane with the least depths, in tangents of the pitch; one of [`LEANS`].
    lean: f32,
    /// Depth of vertices off that plane, metres: the larger of the 95th percentile and half of the
    /// maximum over vertices, the maximum over yaws and poses of a clip, the upper median over clips.
    depth_m: f32,
    /// Lowest and highest point in the picture, metres.
    low_m: f32,
    high_m: f32,
    /// Farthest point to either side, metres.
    side_m: f32,
}

/// What the character spans from all pitches.
#[derive(Debug)]
pub(super) struct Directions {
    pitches: Vec<AtPitch>,
    /// Lowest and highest pitch of eyes.
    range: [f32; 2],
}

/// Extent of pictures in metres, relative to the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub(super) low_m: f32,
    pub(super) high_m: f32,
    pub(super) side_m: f32,
}

impl Directions {
    pub(super) fn new(samples: &MotionSamples, range: [f32; 2]) -> Self {
        let at = |i: usize| at_pitch(samples, STEP * i as f32 - FRAC_PI_2);
        Self {
            pitches: (0..PITCHES).map(at).collect(),
            range,
        }
    }

    /// The fewest directions, row by row, with depth times sine within `most_m`; `None` if a row
    /// would need too many yaws.
    pub(super) fn views(&self, most_m: f32) -> Option<ImpostorViews> {
        let [low, high] = self.range;
        let cap = [self.cap(most_m, -1.0), self.cap(most_m, 1.0)];
        let (bottom, top) = (cap[0].max(low), cap[1].min(high));
        let mut rows = if bottom < 0.0 && top > 0.0 {
            let (middle, height) = self.row(most_m, None, 0.0, top.min(-bottom))?;
            let half = 0.5 * height;
            let mut rows = self.rows(most_m, (-half, bottom), -1.0)?;
            rows.reverse();
            rows.push(middle);
            rows.extend(self.rows(most_m, (half, top), 1.0)?);
            rows
        } else {
            self.rows(most_m, (bottom, top), 1.0)?
        };
        let pole = |from_radians, pitch_radians| ViewRow {
            from_radians,
            pitch_radians,
            lean: 0.0,
            yaws: 1,
        };
        if cap[0] > low {
            rows.insert(0, pole(low, -FRAC_PI_2));
        }
        if cap[1] < high {
            rows.push(pole(top, FRAC_PI_2));
        }
        (!rows.is_empty()).then_some(ImpostorViews {
            rows,
            to_radians: high,
        })
    }

    /// Extent of the pictures of these directions.
    pub(super) fn extent(&self, views: &ImpostorViews) -> Extent {
        let all = views.rows.iter().map(|row| self.at(row.pitch_radians));
        let start = Extent {
            low_m: 0.0,
            high_m: 0.0,
            side_m: 0.0,
        };
        all.fold(start, |e, at| Extent {
            low_m: e.low_m.min(at.low_m),
            high_m: e.high_m.max(at.high_m),
            side_m: e.side_m.max(at.side_m),
        })
    }

    /// Border from which one picture from straight above (`side` 1) or below (-1) will do.
    fn cap(&self, most_m: f32, side: f32) -> f32 {
        let depth = self.at(side * FRAC_PI_2).depth_m.max(f32::MIN_POSITIVE);
        side * (FRAC_PI_2 - (most_m / depth).min(0.7).asin())
    }

    /// Rows from one border to another, away from the horizon.
    fn rows(&self, most_m: f32, borders: (f32, f32), side: f32) -> Option<Vec<ViewRow>> {
        let (mut at, to) = borders;
        let mut rows = Vec::new();
        while side * (to - at) > 1e-3 {
            let (row, height) = self.row(most_m, Some(side), at, to)?;
            let end = at + side * height;
            rows.push(ViewRow {
                from_radians: at.min(end),
                ..row
            });
            at = end;
        }
        Some(rows)
    }

    /// The row that needs the fewest pictures for the part of the sphere that it covers, and its
    /// height: from a border to one side, but not past `to`, or around the horizon.
    fn row(&self, most_m: f32, side: Option<f32>, at: f32, to: f32) -> Option<(ViewRow, f32)> {
        let room = match side {
            Some(_) => (to - at).abs(),
            None => 2.0 * to.max(STEP),
        };
        let heights = (1..=48).map(|i| TALLEST * i as f32 / 48.0);
        let heights = heights.take_while(|h| *h < room).chain([room.min(TALLEST)]);
        let row = |height: f32| {
            let (low, high) = match side {
                Some(side) => (at.min(at + side * height), at.max(at + side * height)),
                None => (-0.5 * height, 0.5 * height),
            };
            let pitch_radians = 0.5 * (low + high);
            let known = self.at(pitch_radians);
            let yaws = yaws(known.depth_m, most_m, pitch_radians, [low, high])?;
            let row = ViewRow {
                from_radians: low,
                pitch_radians,
                lean: known.lean * pitch_radians.tan(),
                yaws,
            };
            Some((yaws as f32 / (high.sin() - low.sin()), row, height))
        };
        let best = heights.filter_map(row).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, row, height)| (row, height))
    }

    /// The nearest measured pitch.
    fn at(&self, pitch_radians: f32) -> AtPitch {
        let i = ((pitch_radians + FRAC_PI_2) / STEP).round().max(0.0) as usize;
        self.pitches[i.min(PITCHES - 1)]
    }
}

/// Fewest yaws with depth times sine within a distance up to these borders.
fn yaws(depth_m: f32, most_m: f32, pitch: f32, borders: [f32; 2]) -> Option<u32> {
    // A direction more than 60 degrees off shows another side of the character.
    let least_cos = (1.0 - (most_m / depth_m.max(1e-6)).powi(2))
        .max(0.25)
        .sqrt();
    let fits = |yaws: u32| {
        let half = TAU / (2 * yaws) as f32;
        borders.iter().all(|border| {
            let cos = pitch.sin() * border.sin() + pitch.cos() * border.cos() * half.cos();
            cos >= least_cos
        })
    };
    (3..=MAX_YAWS).find(|yaws| fits(*yaws))
}

fn at_pitch(samples: &MotionSamples, pitch: f32) -> AtPitch {
    let parts: &[f32] = match pitch.abs() {
        steep if steep > UPRIGHT_TO => &[0.0],
        _ => &LEANS,
    };
    let leans: Vec<f32> = parts.iter().map(|part| part * pitch.tan()).collect();
    let mut out = AtPitch::default();
    let mut depths: Vec<Vec<f32>> = vec![Vec::new(); leans.len()];
    let poses = (POSES / samples.clips.len()).max(3);
    let mut room = Vec::new();
    for clip in &samples.clips {
        let mut most = vec![0.0f32; leans.len()];
        let step = clip.points.len().div_ceil(poses).max(1);
        for pose in (0..clip.points.len()).step_by(step) {
            let points: Vec<Vec3> = clip.centred(pose).collect();
            let every = points.len().div_ceil(MAX_VERTICES).max(1);
            for yaw in 0..YAWS {
                let view = ImpostorView::new(TAU * yaw as f32 / YAWS as f32, pitch, 0.0);
                for p in &points {
                    let y = view.up.dot(*p);
                    out.low_m = out.low_m.min(y);
                    out.high_m = out.high_m.max(y);
                    out.side_m = out.side_m.max(view.right.dot(*p).abs());
                }
                for (most, lean) in most.iter_mut().zip(&leans) {
                    let normal = view.to_eye - *lean * view.up;
                    room.clear();
                    room.extend(points.iter().step_by(every).map(|p| normal.dot(*p).abs()));
                    *most = most.max(judged(&mut room));
                }
            }
        }
        depths.iter_mut().zip(most).for_each(|(d, m)| d.push(m));
    }
    let medians = depths.into_iter().map(|mut of_clips| {
        of_clips.sort_unstable_by(f32::total_cmp);
        of_clips.get(of_clips.len() / 2).copied().unwrap_or(0.0)
    });
    let best = medians.zip(parts).min_by(|a, b| a.0.total_cmp(&b.0));
    let (depth_m, part) = best.unwrap_or((0.0, &0.0));
    AtPitch {
        lean: *part,
        depth_m,
        ..out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::impostor::samples::ClipSamples;

    const EVERYWHERE: [f32; 2] = [-FRAC_PI_2, FRAC_PI_2];

    /// An upright rod of two metres, or a cross of rods of 0.6 m across it.
    fn figure(is_cross: bool) -> MotionSamples {
        let points = (0..21).flat_map(|i| {
            let t = 0.1 * i as f32 - 1.0;
            let across = if is_cross { 0.3 * t } else { 0.0 };
            [Vec3::new(across, t, 0.0), Vec3::new(0.0, t, across)]
        });
        MotionSamples {
            height_m: 2.0,
            clips: vec![ClipSamples {
                duration_secs: 0.0,
                times_secs: vec![0.0],
                points: vec![points.collect()],
                centres: vec![Vec3::ZERO],
            }],
        }
    }

    #[test]
    fn an_upright_rod_needs_no_turn_but_from_above() {
        let directions = Directions::new(&figure(false), EVERYWHERE);
        let views = directions.views(0.2).unwrap();
        // Its depth off an upright plane is 0: the yaws are those that keep the side.
        let near = views.rows.iter().filter(|r| r.pitch_radians.abs() < 1.0);
        for row in near {
            assert!(row.yaws <= 4, "{row:?}");
            assert!((row.lean - row.pitch_radians.tan()).abs() < 1e-6, "{row:?}");
        }
        let extent = directions.extent(&views);
        assert!((extent.high_m - 1.0).abs() < 1e-3 && extent.side_m < 1e-3);
    }

    #[test]
    fn rows_cover_the_sphere_and_grow_with_accuracy() {
        let directions = Directions::new(&figure(true), EVERYWHERE);
        let mut least = 0;
        for most_m in [0.2, 0.1, 0.05] {
            let views = directions.views(most_m).unwrap();
            assert_eq!(views.rows[0].from_radians, -FRAC_PI_2);
            for pair in views.rows.windows(2) {
                assert!(pair[0].from_radians < pair[1].from_radians);
                assert!(pair[0].pitch_radians < pair[1].from_radians + 1e-5);
                assert!(pair[1].pitch_radians > pair[1].from_radians - 1e-5);
            }
            assert!(views.len() > least, "{} at {most_m}", views.len());
            least = views.len();
        }
        assert!(directions.views(1e-3).is_none());
        let level = Directions::new(&figure(true), [-0.1, 0.6])
            .views(0.1)
            .unwrap();
        assert_eq!((level.rows[0].from_radians, level.to_radians), (-0.1, 0.6));
        assert!(2 * level.len() < directions.views(0.1).unwrap().len());
    }
}
