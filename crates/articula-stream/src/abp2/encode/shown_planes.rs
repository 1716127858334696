//! What a motion shows without some planes of its tracks, decoded where it is looked at and as far as it has
//! changed.

use super::quantise::{Coding, Levels, show};
use super::truth::Truth;
use std::ops::Range;

/// A motion of which each track may lack planes.
pub(super) struct ShownPlanes<'a> {
    coding: &'a Coding<'a>,
    levels: &'a Levels,
    motion: Truth,
    /// Planes that the tracks lack in `motion`: `[access unit][track]`.
    dropped: Vec<Vec<u8>>,
    /// Buffer of the values of a track.
    values: Vec<i64>,
}

impl<'a> ShownPlanes<'a> {
    /// `whole` is what all planes show.
    pub(super) fn new(coding: &'a Coding<'a>, levels: &'a Levels, whole: &Truth) -> Self {
        Self {
            coding,
            levels,
            motion: whole.clone(),
            dropped: vec![vec![0; levels.tracks.len()]; coding.orders.len()],
            values: Vec::new(),
        }
    }

    /// The motion if each track drops so many planes, right in these frames.
    pub(super) fn in_frames(&mut self, dropped: &[u8], frames: Range<usize>) -> &Truth {
        for number in self.coding.head.access_units_of(frames) {
            self.update(number, dropped);
        }
        &self.motion
    }

    /// Decodes the tracks of an access unit that have lacked another number of planes.
    fn update(&mut self, access_unit: usize, dropped: &[u8]) {
        let head = self.coding.head;
        let known = &mut self.dropped[access_unit];
        for (t, (known, dropped)) in known.iter_mut().zip(dropped).enumerate() {
            let track = &self.levels.tracks[t];
            if *known == *dropped || track.moving().is_none() {
                continue;
            }
            *known = *dropped;
            let levels = &self.levels.levels[t][access_unit];
            (self.coding).values(track, levels, access_unit, *dropped, &mut self.values);
            let frames = head.frames_of(access_unit);
            let values = Some(&self.values[..]);
            show(track, self.coding.rig, frames, values, &mut self.motion);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::abp2::encode::near_points::tests::{rig, tube};
    use crate::abp2::encode::skin_points::{SkinPoints, offsets_by_vertex};
    use crate::abp2::encode::{MotionOptions, head, levers::Rest, plan::plan};
    use articula_core::{Clip, Track, Tracks};
    use articula_mutate::Dice;
    use glam::Quat;

    /// A clip that turns all joints of the chain and moves the morph target.
    fn waving() -> Clip {
        let track = |joint: u16| Track {
            target: joint,
            step: false,
            values: (0..50)
                .map(|f| Quat::from_rotation_z(0.3 * (0.2 * f as f32 + f32::from(joint)).sin()))
                .collect(),
        };
        let tracks = Tracks {
            rotations: (0..5).map(track).collect(),
            morphs: vec![Track {
                target: 0,
                step: false,
                values: (0..50).map(|f| (0.3 * f as f32).cos()).collect(),
            }],
            ..Tracks::default()
        };
        Clip::new("waving", 25.0, 50, 5, tracks).unwrap()
    }

    #[test]
    fn what_is_decoded_in_part_is_what_all_tracks_show() {
        let (rig, mesh, clip) = (rig(), tube(), waving());
        let options = MotionOptions {
            access_unit_secs: 0.5,
            ..MotionOptions::default()
        };
        let head = head(&rig, &mesh, &clip, &options).unwrap();
        assert!(head.access_units > 3);
        let truth = Truth::new(&rig, &mesh, &clip);
        let offsets = offsets_by_vertex(&mesh);
        let points = SkinPoints::of_vertices(&mesh, &offsets, 0..mesh.len());
        let rest = Rest::new(&rig, &points, &mesh.morph_weights);
        let planned = plan(&rig, &points, &rest, &truth);
        assert_eq!(planned.iter().filter(|track| track.moves).count(), 6);
        let coding = Coding::new(&rig, &head, &truth, &planned);
        let steps = vec![1e-4; planned.len()];
        let (levels, whole) = coding.quantise(&steps).unwrap();
        let mut shown = ShownPlanes::new(&coding, &levels, &whole);
        let mut dice = Dice::new(3);
        let mut last = whole.clone();
        for _ in 0..12 {
            let dropped: Vec<u8> = planned.iter().map(|_| dice.roll(5) as u8).collect();
            let expected = coding.shown(&levels, &dropped, &whole);
            assert_ne!(expected.rotations, last.rotations);
            let at = dice.roll(50);
            let found = shown.in_frames(&dropped, at..at + 1);
            let of_frame = at * 5..(at + 1) * 5;
            assert_eq!(
                found.rotations[of_frame.clone()],
                expected.rotations[of_frame]
            );
            assert_eq!(found.weights(at), expected.weights(at));
            if dice.roll(2) == 0 {
                let found = shown.in_frames(&dropped, 0..50);
                assert_eq!(found.rotations, expected.rotations);
                assert_eq!(found.weights, expected.weights);
            }
            last = expected;
        }
    }
}
