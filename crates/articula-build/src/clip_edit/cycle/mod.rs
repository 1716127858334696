//! Loops: finding the part of a clip that repeats best, and making its ends meet.
//!
//! - [`find`]: the best part of a clip, if there is one
//! - [`close`]: a clip whose last pose equals its first

mod close;
mod find;

pub use close::{CloseOptions, ClosedLoop, close_loop};
pub use find::{LoopCycle, MIN_SCORE, find_loop};

#[cfg(test)]
mod tests {
    use super::super::EditSubject;
    use super::super::test_clips::bar;
    use super::*;
    use articula_core::angle_between;
    use articula_core::source::{Channel, Character, Interpolation, Property, RawClip, evaluate};
    use glam::{Quat, Vec3};
    use std::f32::consts::TAU;

    /// A bar that walks along x, bobs, and waves its end once a second.
    fn walk(secs: f32, wave: impl Fn(f32) -> f32) -> RawClip {
        let times: Vec<f32> = (0..=(30.0 * secs) as usize)
            .map(|i| i as f32 / 30.0)
            .collect();
        let channel = |target, property, values: Vec<f32>| Channel {
            target,
            property,
            interpolation: Interpolation::Linear,
            times_secs: times.clone(),
            values,
        };
        let way = |t: &f32| [1.3 * t, 0.9 + 0.02 * (TAU * t).sin() + 0.01 * t, 0.0];
        let turn = |t: &f32| Quat::from_rotation_z(wave(*t)).to_array();
        RawClip {
            name: "walk".into(),
            duration_secs: times[times.len() - 1],
            channels: vec![
                channel(
                    0,
                    Property::Translation,
                    times.iter().flat_map(way).collect(),
                ),
                channel(1, Property::Rotation, times.iter().flat_map(turn).collect()),
            ],
        }
    }

    fn figure(character: &Character) -> EditSubject<'_> {
        let (_, articulation) = bar(3);
        EditSubject::new(character, articulation, &[]).unwrap()
    }

    #[test]
    fn the_period_of_a_wave_is_found_and_a_slow_turn_has_none() {
        let (character, _) = bar(3);
        let subject = figure(&character);
        let wave = walk(3.7, |t| 0.6 * (TAU * t).sin());
        let cycle = find_loop(&subject, &wave).unwrap().unwrap();
        assert!(cycle.is_loop && !cycle.is_whole);
        assert!(
            (cycle.end_secs - cycle.start_secs - 1.0).abs() < 0.02,
            "{cycle:?}"
        );
        // It has risen by a centimetre as it travels.
        assert!(
            (cycle.seam_metres - 0.01).abs() < 0.003 && cycle.score > 0.95,
            "{cycle:?}"
        );
        let turn = find_loop(&subject, &walk(3.0, |t| 0.5 * t))
            .unwrap()
            .unwrap();
        assert!(!turn.is_loop && turn.score < 0.7, "{turn:?}");
        let short = find_loop(&subject, &walk(0.2, |t| t)).unwrap();
        assert_eq!(short, None);
    }

    #[test]
    fn a_clip_whose_ends_meet_is_a_loop_as_it_is() {
        let (character, _) = bar(3);
        let subject = figure(&character);
        // Two waves, the second a little greater.
        let wave = |t: f32| if t < 1.0 { 0.5 } else { 0.6 } * (TAU * t).sin();
        let mut twice = walk(2.0, wave);
        for key in 0..twice.channels[0].times_secs.len() {
            twice.channels[0].values[3 * key + 1] = 0.9;
        }
        let found = find_loop(&subject, &twice).unwrap().unwrap();
        // A bar has no height, so it must meet exactly.
        assert!(found.is_loop && found.seam_metres < 0.001, "{found:?}");
    }

    #[test]
    fn closing_shares_the_seam_between_both_ends() {
        let (character, _) = bar(3);
        let subject = figure(&character);
        let open = walk(1.0, |t| 0.1 * t);
        let opts = CloseOptions {
            window_secs: Some(0.2),
        };
        let closed = close_loop(&subject, &open, &opts).unwrap();
        assert!(closed.seam_radians < 1e-6);
        assert!((closed.travel_metres - 1.3).abs() < 1e-5 && closed.turn_radians == 0.0);
        let at = |secs: f32| {
            let mut value = [0.0; 4];
            evaluate::channel(&closed.clip.channels[1], secs, &mut value);
            angle_between(Quat::IDENTITY, Quat::from_array(value))
        };
        // The difference is 0.1 rad: half of it at either end, nothing beyond the windows.
        assert!((at(0.0) - 0.05).abs() < 1e-5 && (at(1.0) - 0.05).abs() < 1e-5);
        assert!((at(0.5) - 0.05).abs() < 1e-5 && (at(0.7) - 0.07).abs() < 1e-5);
        // In the middle of a window half of the half.
        assert!((at(0.9) - (0.09 - 0.025)).abs() < 1e-4);
        let mut hips = [[0.0; 3]; 2];
        evaluate::channel(&closed.clip.channels[0], 0.0, &mut hips[0]);
        evaluate::channel(&closed.clip.channels[0], 1.0, &mut hips[1]);
        // The travel is kept, the rise of a centimetre is shared.
        assert!((Vec3::from(hips[0]) - Vec3::new(0.0, 0.905, 0.0)).length() < 1e-5);
        assert!((Vec3::from(hips[1]) - Vec3::new(1.3, 0.905, 0.0)).length() < 1e-5);
    }

    #[test]
    fn a_curve_goes_on_and_a_drift_does_not() {
        let (character, _) = bar(3);
        let subject = figure(&character);
        let turning = |total: f32| {
            let mut clip = walk(1.0, |_| 0.2);
            let times = clip.channels[0].times_secs.clone();
            let turn = |t: &f32| Quat::from_rotation_y(total * t).to_array();
            clip.channels.push(Channel {
                target: 0,
                property: Property::Rotation,
                interpolation: Interpolation::Linear,
                values: times.iter().flat_map(turn).collect(),
                times_secs: times,
            });
            close_loop(&subject, &clip, &CloseOptions::default()).unwrap()
        };
        let (drift, curve) = (turning(0.2), turning(1.2));
        assert_eq!(drift.turn_radians, 0.0);
        assert!((curve.turn_radians - 1.2).abs() < 1e-5);
        let end = |closed: &ClosedLoop| Quat::from_slice(&closed.clip.channels[2].values[30 * 4..]);
        let start = |closed: &ClosedLoop| Quat::from_slice(&closed.clip.channels[2].values);
        assert!(angle_between(start(&drift), end(&drift)) < 1e-6);
        assert!((angle_between(start(&curve), end(&curve)) - 1.2).abs() < 1e-5);
        assert!(curve.seam_radians < 1e-6 && curve.moved_metres < 0.01);
    }
}
