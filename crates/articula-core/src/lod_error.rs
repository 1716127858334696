//! LOD errors: the error of each joint LOD in each clip, by which levels are chosen.
//!
//! Source: `docs/methods/motion-lod.md` 4.3 and 8, `docs/methods/runtime.md` 4.1. Written by
//! `articula-build`, read every frame.

use crate::Mismatch;

/// Factor by which a small part of a character, such as an object in its hand, may exceed the
/// tolerance: the 95th percentile over vertices does not include it, but a viewer sees it.
pub const SMALL_PART: f32 = 2.0;

/// Returns the LOD error in metres, by which a level is chosen: the larger of the 95th percentile
/// over vertices and half of the maximum.
#[inline]
pub fn lod_error_metres(p95_metres: f32, max_metres: f32) -> f32 {
    p95_metres.max(max_metres / SMALL_PART)
}

/// Errors of all levels in one clip.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ClipLodErrors {
    /// Error of each level in metres of skin: per frame the 95th percentile over vertices of the
    /// distance to the full character, then the maximum over frames. Rising.
    pub levels_metres: Vec<f32>,
    /// The same with the maximum over vertices. Rising.
    pub worst_metres: Vec<f32>,
    /// Maximum speed of a vertex while the clip plays at speed 1, metres per second (95th
    /// percentile over vertices, maximum over frames); bounds the error of a shift in time.
    pub speed_metres_per_sec: f32,
    /// Distance between the last and the first frame of the clip, metres (95th percentile over
    /// vertices): 0 for a closed loop.
    pub seam_metres: f32,
}

impl ClipLodErrors {
    /// LOD error of each level ([`lod_error_metres`]).
    pub fn judged(&self) -> impl Iterator<Item = f32> + '_ {
        let pairs = self.levels_metres.iter().zip(&self.worst_metres);
        pairs.map(|(most, worst)| lod_error_metres(*most, *worst))
    }
}

/// LOD errors of all clips of a rig.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LodErrors {
    /// One entry for each clip.
    pub clips: Vec<ClipLodErrors>,
}

impl LodErrors {
    /// Checks the table against the number of clips and levels it is used with.
    ///
    /// # Errors
    /// A [`Mismatch`] if an entry is missing, is NaN, is negative or falls with the level, or if
    /// the error of level 0 is not 0.
    pub fn check(&self, clips: usize, levels: usize) -> Result<(), Mismatch> {
        if self.clips.len() != clips {
            let what = format!("{} entries for {clips} clips", self.clips.len());
            return Err(Mismatch::new("clips", what));
        }
        for (c, clip) in self.clips.iter().enumerate() {
            for (name, errors) in [
                ("levels_metres", &clip.levels_metres),
                ("worst_metres", &clip.worst_metres),
            ] {
                let rising = errors.windows(2).all(|w| w[0] <= w[1]);
                if errors.len() != levels || errors.first() != Some(&0.0) || !rising {
                    let what = format!("expected {levels} values that start at 0 and never fall");
                    return Err(Mismatch::new(format!("clips[{c}].{name}"), what));
                }
            }
            let rest = [clip.speed_metres_per_sec, clip.seam_metres];
            if !rest.iter().all(|v| *v >= 0.0) {
                let what = "speed_metres_per_sec and seam_metres must be at least 0 and not NaN";
                return Err(Mismatch::new(format!("clips[{c}]"), what));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_percentile_or_half_the_maximum() {
        assert_eq!(lod_error_metres(0.25, 0.25), 0.25);
        assert_eq!(lod_error_metres(0.25, 1.0), 0.5);
        let clip = ClipLodErrors {
            levels_metres: vec![0.0, 0.25, 0.5],
            worst_metres: vec![0.0, 1.0, 1.0],
            ..ClipLodErrors::default()
        };
        assert_eq!(clip.judged().collect::<Vec<_>>(), [0.0, 0.5, 0.5]);
    }

    #[test]
    fn each_list_and_number_of_a_clip_is_checked() {
        let right = ClipLodErrors {
            levels_metres: vec![0.0, 0.1, 0.1],
            worst_metres: vec![0.0, 0.0, 0.2],
            speed_metres_per_sec: 0.0,
            seam_metres: 0.0,
        };
        let at = |change: fn(&mut ClipLodErrors)| {
            let mut clip = right.clone();
            change(&mut clip);
            let clips = vec![right.clone(), clip];
            LodErrors { clips }.check(2, 3).err().map(|e| e.at)
        };
        assert_eq!(at(|_| ()), None);
        let levels = Some("clips[1].levels_metres".to_owned());
        assert_eq!(at(|c| c.levels_metres.truncate(2)), levels);
        assert_eq!(at(|c| c.levels_metres[0] = 0.01), levels);
        assert_eq!(at(|c| c.levels_metres[2] = 0.09), levels);
        let worst = Some("clips[1].worst_metres".to_owned());
        assert_eq!(at(|c| c.worst_metres.push(0.3)), worst);
        let rest = Some("clips[1]".to_owned());
        assert_eq!(at(|c| c.speed_metres_per_sec = -0.1), rest);
        assert_eq!(at(|c| c.seam_metres = f32::NAN), rest);
    }

    #[test]
    fn validity_table() {
        let table = |levels: &[f32], speed| LodErrors {
            clips: vec![ClipLodErrors {
                levels_metres: levels.to_vec(),
                worst_metres: levels.to_vec(),
                speed_metres_per_sec: speed,
                seam_metres: 0.0,
            }],
        };
        assert!(table(&[0.0, 0.1], 1.0).check(1, 2).is_ok());
        let at = |t: LodErrors, clips, levels| t.check(clips, levels).unwrap_err().at;
        assert_eq!(at(table(&[0.0], 1.0), 2, 1), "clips");
        assert_eq!(at(table(&[0.0], 1.0), 1, 2), "clips[0].levels_metres");
        assert_eq!(at(table(&[0.1], 1.0), 1, 1), "clips[0].levels_metres");
        assert_eq!(
            at(table(&[0.0, f32::NAN], 1.0), 1, 2),
            "clips[0].levels_metres"
        );
        assert_eq!(at(table(&[0.0], f32::NAN), 1, 1), "clips[0]");
    }
}
