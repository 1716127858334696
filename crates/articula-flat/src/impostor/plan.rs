//! The choice of directions, key poses and picture size.

use super::directions::{Directions, Extent};
use super::error::{ImpostorError, refuse};
use super::keys::{Distances, Key, starts};
use super::measure::error_m;
use super::options::{ImpostorBound, ImpostorOptions};
use super::samples::{ImpostorSource, MotionSamples};
use super::views::ImpostorViews;
use crate::render::Light;
use articula_core::{ClipImpostors, Impostors, Mismatch, Progress};
use glam::Vec3;
use std::f32::consts::FRAC_PI_2;

/// Coarsest error that is tried, in heights of the character.
const COARSEST: f32 = 0.4;

/// Factor between the errors that are tried.
const FINER: f32 = 0.87;

/// Number of errors that are tried: down to about a 600th of the height.
const TRIALS: usize = 40;

/// Parts of the error that half of a pixel and the directions may take; poses take the rest.
const SHARES: [(f32, f32); 6] = [
    (0.15, 0.35),
    (0.15, 0.5),
    (0.15, 0.65),
    (0.3, 0.25),
    (0.3, 0.35),
    (0.3, 0.45),
];

/// Multiple of the sides of a picture, pixels, so that it can be compressed in blocks.
const BLOCK: u32 = 4;

/// Size and place of every picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpostorCell {
    /// Width and height in pixels, multiples of 4.
    pub size_px: [u32; 2],
    /// Side of a pixel in metres.
    pub metres_per_px: f32,
    /// Lower left corner in metres, relative to the centre of the pose.
    pub corner_m: [f32; 2],
}

/// Poses of one clip.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpostorClip {
    /// Name of the clip.
    pub name: String,
    /// Duration, seconds.
    pub duration_secs: f32,
    /// Time from which each pose is shown, ascending from 0, seconds.
    pub from_secs: Vec<f32>,
    /// Time of each pose, seconds.
    pub pose_secs: Vec<f32>,
    /// Centre of the pictures of each pose, model space, metres.
    pub centres: Vec<Vec3>,
    /// Index of the first pose; the poses of all clips are counted one after the other.
    pub first_pose: usize,
    /// Error in metres: across the view of any eye, the distance between a vertex and where it is
    /// shown, and half of a pixel; the larger of the 95th percentile and half of the maximum over
    /// vertices, the maximum over times and eyes.
    pub error_m: f32,
}

impl ImpostorClip {
    /// Index of the pose that is shown at a time of the clip, among those of the clip.
    pub fn pose_at(&self, secs: f32) -> usize {
        let after = self.from_secs.partition_point(|from| *from <= secs);
        after.saturating_sub(1)
    }
}

/// An error that was tried, with the bytes that it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImpostorTrial {
    /// Error that directions, poses and pixels together may reach, metres.
    pub error_m: f32,
    /// Bytes of the pixels.
    pub bytes: usize,
    /// Number of directions.
    pub views: usize,
    /// Number of poses of all clips.
    pub poses: usize,
    /// Size of a picture, pixels.
    pub size_px: [u32; 2],
}

/// Which pictures are baked, and their errors; without the pictures themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpostorPlan {
    /// Directions of the pictures of each pose.
    pub views: ImpostorViews,
    /// Size and place of every picture.
    pub cell: ImpostorCell,
    /// The clips; the rest pose, without a name, if there is none.
    pub clips: Vec<ImpostorClip>,
    /// The errors that were tried, from the coarsest, with the bytes that each needs.
    pub trials: Vec<ImpostorTrial>,
    pub(super) light: Light,
}

/// The parts of a trial.
struct Candidate {
    trial: ImpostorTrial,
    views: ImpostorViews,
    keys: Vec<Vec<Key>>,
    cell: ImpostorCell,
}

impl ImpostorPlan {
    /// Chooses directions, key poses and the size of a picture so that the error is least within
    /// the bound, and measures the error of each clip.
    ///
    /// # Errors
    /// [`ImpostorError::Nothing`] without a mesh, [`ImpostorError::LimitExceeded`] if not even the
    /// coarsest pictures are within the bound, [`ImpostorError::Mismatch`] if the bound is not
    /// positive, [`ImpostorError::Cancelled`] if the caller cancelled.
    pub fn new(
        source: &ImpostorSource<'_>,
        options: &ImpostorOptions,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImpostorError> {
        if let ImpostorBound::Metres(metres) = options.bound
            && !(metres > 0.0 && metres.is_finite())
        {
            return Err(refuse("bound", "metres must be positive"));
        }
        let [low, high] = options.pitches_radians;
        if !(-FRAC_PI_2..high).contains(&low) || high > FRAC_PI_2 {
            let what = "must rise within a quarter turn down and up";
            return Err(refuse("pitches_radians", what));
        }
        let samples = MotionSamples::new(source, progress)?;
        progress.step(0.0)?;
        let directions = Directions::new(&samples, options.pitches_radians);
        let mut distances: Vec<Distances<'_>> = samples.clips.iter().map(Distances::new).collect();
        let mut trials = Vec::new();
        let mut best = None;
        for i in 0..TRIALS {
            progress.step(i as f32 / TRIALS as f32)?;
            let error = match options.bound {
                ImpostorBound::Bytes(_) => COARSEST * samples.height_m * FINER.powi(i as i32),
                ImpostorBound::Metres(metres) => metres,
            };
            let tried = SHARES
                .iter()
                .filter_map(|shares| candidate(error, *shares, &directions, &mut distances));
            let Some(least) = tried.min_by_key(|c| c.trial.bytes) else {
                break;
            };
            trials.push(least.trial);
            match options.bound {
                ImpostorBound::Metres(_) => {
                    best = Some(least);
                    break;
                }
                ImpostorBound::Bytes(limit) if least.trial.bytes <= limit => best = Some(least),
                ImpostorBound::Bytes(limit) => {
                    // Two finer ones that do not fit show what more bytes would bring.
                    let over = trials.iter().filter(|t| t.bytes > limit).count();
                    if over > 2 || best.is_none() {
                        break;
                    }
                }
            }
        }
        drop(distances);
        let Some(best) = best else {
            let needed = trials.first().map_or(usize::MAX, |t| t.bytes);
            let limit = match options.bound {
                ImpostorBound::Bytes(limit) => limit,
                ImpostorBound::Metres(_) => 0,
            };
            return Err(ImpostorError::LimitExceeded { needed, limit });
        };
        Self::measured(source, options, &samples, best, trials, progress)
    }

    fn measured(
        source: &ImpostorSource<'_>,
        options: &ImpostorOptions,
        samples: &MotionSamples,
        chosen: Candidate,
        trials: Vec<ImpostorTrial>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ImpostorError> {
        let mut clips = Vec::with_capacity(samples.clips.len());
        let mut first_pose = 0;
        for (i, (of_clip, keys)) in samples.clips.iter().zip(&chosen.keys).enumerate() {
            progress.step(i as f32 / samples.clips.len() as f32)?;
            let pose = |key: &Key| of_clip.times_secs[key.pose];
            let pixel = 0.5 * chosen.cell.metres_per_px;
            clips.push(ImpostorClip {
                name: source
                    .clips
                    .get(i)
                    .map_or(String::new(), |c| c.name.clone()),
                duration_secs: of_clip.duration_secs,
                from_secs: starts(keys, of_clip),
                pose_secs: keys.iter().map(pose).collect(),
                centres: keys.iter().map(|key| of_clip.centres[key.pose]).collect(),
                first_pose,
                error_m: error_m(of_clip, keys, &chosen.views) + pixel,
            });
            first_pose += keys.len();
        }
        Ok(Self {
            views: chosen.views,
            cell: chosen.cell,
            clips,
            trials,
            light: options.light,
        })
    }

    /// What a crowd needs: the pose of each clip at each time, and the errors.
    ///
    /// # Errors
    /// A [`Mismatch`] if a value was changed to one that is not finite.
    pub fn table(&self) -> Result<Impostors, Mismatch> {
        let durations: Vec<f32> = self.clips.iter().map(|c| c.duration_secs).collect();
        let clip = |clip: &ImpostorClip| {
            Some(ClipImpostors::of_stretches(
                clip.first_pose as u32,
                &clip.from_secs,
                clip.duration_secs,
                clip.error_m,
            ))
        };
        Impostors::new(self.clips.iter().map(clip).collect(), &durations)
    }

    /// The clip of a pose and the place of the pose in it; `None` if there is no such pose.
    pub fn clip_of(&self, pose: usize) -> Option<(usize, usize)> {
        let clip = self.clips.iter().rposition(|c| c.first_pose <= pose)?;
        let place = pose - self.clips[clip].first_pose;
        (place < self.clips[clip].pose_secs.len()).then_some((clip, place))
    }

    /// Number of poses of all clips.
    pub fn poses(&self) -> usize {
        self.clips.iter().map(|c| c.pose_secs.len()).sum()
    }

    /// Number of pictures: all directions of all poses.
    pub fn pictures(&self) -> usize {
        self.poses() * self.views.len()
    }

    /// Bytes of the pixels of all pictures, four for each pixel.
    pub fn bytes(&self) -> usize {
        4 * self.pictures() * (self.cell.size_px[0] * self.cell.size_px[1]) as usize
    }
}

/// The fewest bytes for an error with these shares; `None` if it needs too many directions.
fn candidate(
    error_m: f32,
    (pixel, view): (f32, f32),
    directions: &Directions,
    distances: &mut [Distances<'_>],
) -> Option<Candidate> {
    let views = directions.views(view * error_m)?;
    let cell = cell(directions.extent(&views), 2.0 * pixel * error_m)?;
    let pose = (1.0 - pixel - view) * error_m;
    let keys: Vec<Vec<Key>> = distances.iter_mut().map(|d| d.keys(pose)).collect();
    let poses = keys.iter().map(Vec::len).sum();
    let trial = ImpostorTrial {
        error_m,
        bytes: 4 * views.len() * poses * (cell.size_px[0] * cell.size_px[1]) as usize,
        views: views.len(),
        poses,
        size_px: cell.size_px,
    };
    Some(Candidate {
        trial,
        views,
        keys,
        cell,
    })
}

/// The smallest picture that holds an extent with pixels of at most this side, with half of a pixel
/// around it; `None` above 1024 pixels.
fn cell(extent: Extent, most_m: f32) -> Option<ImpostorCell> {
    let (width_m, height_m) = (2.0 * extent.side_m, extent.high_m - extent.low_m);
    let sides = [width_m, height_m].map(|m| m / most_m + 1.0);
    if !sides.iter().all(|s| *s <= 1024.0) {
        return None;
    }
    let size_px = sides.map(|s| (s.ceil() as u32).next_multiple_of(BLOCK));
    // The pixels that rounding adds are used.
    let fits = |metres: f32, px: u32| metres / (px - 1) as f32;
    let metres_per_px = fits(width_m, size_px[0]).max(fits(height_m, size_px[1]));
    let middle = 0.5 * (extent.low_m + extent.high_m);
    let half = size_px.map(|px| 0.5 * metres_per_px * px as f32);
    Some(ImpostorCell {
        size_px,
        metres_per_px,
        corner_m: [-half[0], middle - half[1]],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_holds_the_extent_in_blocks() {
        let extent = Extent {
            low_m: -1.0,
            high_m: 0.8,
            side_m: 0.4,
        };
        let cell = cell(extent, 0.1).unwrap();
        // 0.8 m and 1.8 m are 9 and 19 pixels with half a pixel around.
        assert_eq!(cell.size_px, [12, 20]);
        assert!((cell.metres_per_px - 1.8 / 19.0).abs() < 1e-6);
        let [x, y] = cell.corner_m;
        assert!(x <= -0.4 && y <= -1.0);
        assert!(y + 20.0 * cell.metres_per_px >= 0.8);
        assert!(super::cell(extent, 1e-4).is_none());
    }

    #[test]
    fn the_pose_of_a_time_is_the_last_that_began() {
        let clip = ImpostorClip {
            name: String::new(),
            duration_secs: 1.0,
            from_secs: vec![0.0, 0.25, 0.5],
            pose_secs: vec![0.1, 0.3, 0.7],
            centres: vec![Vec3::ZERO; 3],
            first_pose: 0,
            error_m: 0.1,
        };
        let at = [-1.0, 0.0, 0.24, 0.25, 9.0].map(|secs| clip.pose_at(secs));
        assert_eq!(at, [0, 0, 0, 1, 2]);
    }
}
