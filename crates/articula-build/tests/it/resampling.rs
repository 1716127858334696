//! Clips of every pattern of keys are followed within 0.1 mm and 0.05 degrees, judged by trigonometry: an
//! arm of two segments turns about z, so that its angles and the place of its hand are known.

use articula_build::{ClipOptions, Played, resampling_error, sampled_clip};
use articula_core::source::{
    Channel, Character, Interpolation, JUMP_SECS, Joint, Property, RawClip, Skeleton,
};
use articula_core::{
    Articulation, Clip, JointArticulation, JointSet, Mesh, ModelPose, Region, Rig, Transform, Wrap,
    local_to_model, sample,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Lengths of the segments in metres.
const UPPER: f64 = 0.33;
const LOWER: f64 = 0.27;

/// Greatest distance and angle, with the rounding of single precision.
const METRES: f64 = 1.05e-4;
const DEGREES: f64 = 0.0525;

/// Least rate of a clip in which a jump takes a frame.
const JUMP_HZ: f32 = 119.9;

/// Angles of a joint in radians, or places of the shoulder in metres: times, values and slopes.
#[derive(Debug, Clone)]
struct Keys {
    interpolation: Interpolation,
    times: Vec<f32>,
    values: Vec<f32>,
    slopes: Vec<f32>,
}

impl Keys {
    /// The value at a time, after a jump.
    fn at(&self, secs: f64) -> f64 {
        let time = |i: usize| f64::from(self.times[i]);
        let value = |i: usize| f64::from(self.values[i]);
        let next = self.times.partition_point(|t| f64::from(*t) <= secs);
        if next == 0 || next == self.times.len() || self.interpolation == Interpolation::Step {
            return value(next.saturating_sub(1));
        }
        let span = time(next) - time(next - 1);
        let u = (secs - time(next - 1)) / span;
        let line = value(next - 1) + (value(next) - value(next - 1)) * u;
        if self.interpolation == Interpolation::Linear {
            return line;
        }
        // The line and two bends: a Hermite spline in the form of Bernstein.
        let slope = |i: usize| f64::from(self.slopes[i]) * span;
        let rise = value(next) - value(next - 1);
        let (a, b) = (slope(next - 1) - rise, rise - slope(next));
        line + u * (1.0 - u) * (a * (1.0 - u) + b * u)
    }

    fn channel(&self, target: usize, property: Property) -> Channel {
        let floats = |v: f32| match property {
            Property::Rotation => Quat::from_rotation_z(v).to_array().to_vec(),
            _ => vec![v, 0.0, 0.0],
        };
        let keys = self.values.iter().zip(&self.slopes);
        let values = keys.flat_map(|(value, slope)| match self.interpolation {
            Interpolation::CubicSpline => [floats(*slope), floats(*value), floats(*slope)].concat(),
            _ => floats(*value),
        });
        Channel {
            target,
            property,
            interpolation: self.interpolation,
            times_secs: self.times.clone(),
            values: values.collect(),
        }
    }
}

fn character() -> Character {
    let joint = |parent, x: f64| Joint {
        name: String::new(),
        parent,
        rest: Transform {
            translation: Vec3::X * x as f32,
            ..Transform::IDENTITY
        },
        in_skin: true,
    };
    let joints = vec![
        joint(None, 0.0),
        joint(Some(0), UPPER),
        joint(Some(1), LOWER),
    ];
    Character {
        skeleton: Skeleton { joints },
        ..Character::default()
    }
}

/// A clip of the shoulder's place and turn and the elbow's turn.
fn clip(slide: &Keys, shoulder: &Keys, elbow: &Keys) -> RawClip {
    let last = |k: &Keys| k.times.last().copied().unwrap_or(0.0);
    RawClip {
        name: "arm".into(),
        duration_secs: last(slide).max(last(shoulder)).max(last(elbow)),
        channels: vec![
            slide.channel(0, Property::Translation),
            shoulder.channel(0, Property::Rotation),
            elbow.channel(1, Property::Rotation),
        ],
    }
}

/// Where the hand is, and the angle of each segment in the plane, in degrees.
fn wanted(slide: &Keys, shoulder: &Keys, elbow: &Keys, secs: f64) -> ([f64; 2], [f64; 2]) {
    let (a, b) = (shoulder.at(secs), elbow.at(secs));
    let hand = [
        slide.at(secs) + UPPER * a.cos() + LOWER * (a + b).cos(),
        UPPER * a.sin() + LOWER * (a + b).sin(),
    ];
    (hand, [a.to_degrees(), b.to_degrees()])
}

/// The same of a clip as it is played.
fn played(rig: &Rig, clip: &Clip, secs: f64) -> ([f64; 2], [f64; 2]) {
    let mut local = rig.rest_pose().clone();
    sample(clip, secs, Wrap::Clamp, &JointSet::first(3), &mut local);
    let mut model = ModelPose::new(3);
    local_to_model(rig, &local, &mut model);
    let hand = model.position(2);
    let turn = |j: usize| {
        let q = local.rotations[j];
        f64::from(2.0 * q.z.atan2(q.w)).to_degrees()
    };
    ([hand.x.into(), hand.y.into()], [turn(0), turn(1)])
}

fn rig(character: &Character) -> Rig {
    let joint = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Arms,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![joint; 3],
    };
    Rig::new(&character.skeleton, articulation).unwrap()
}

/// Measures a clip at the key times, halfway between them and at further times.
fn check(slide: &Keys, shoulder: &Keys, elbow: &Keys) -> Result<(), TestCaseError> {
    let (character, source) = (character(), clip(slide, shoulder, elbow));
    let rig = rig(&character);
    let built = sampled_clip(
        &character,
        &source,
        &Mesh::default(),
        &ClipOptions::default(),
    );
    let built = built.unwrap();
    let all = [slide, shoulder, elbow];
    let mut keys: Vec<f64> = all
        .iter()
        .flat_map(|k| &k.times)
        .map(|t| f64::from(*t))
        .collect();
    keys.sort_by(f64::total_cmp);
    keys.dedup();
    let middles: Vec<f64> = keys.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    let end = f64::from(source.duration_secs);
    // Multiples of the golden section lie evenly and on no grid.
    let others = (1..200).map(|i| end * (0.618_033_988_75 * f64::from(i)).fract());
    let jumps: Vec<f64> = source
        .channels
        .iter()
        .flat_map(Channel::jump_times)
        .map(f64::from)
        .collect();
    let frame = 1.001 / f64::from(built.rate_hz());
    let may_jump = built.rate_hz() >= JUMP_HZ;
    // Keys are rounded to single precision, and steps show the key before until then.
    let keys = keys.iter().map(|t| t + 2e-6);
    for secs in keys.chain(middles).chain(others) {
        if may_jump && jumps.iter().any(|j| (j - secs).abs() < frame) {
            continue;
        }
        let (hand, angles) = wanted(slide, shoulder, elbow, secs);
        let (shown, turns) = played(&rig, &built, secs);
        let far = (hand[0] - shown[0]).hypot(hand[1] - shown[1]);
        let at = format!("at {secs} s, {} Hz", built.rate_hz());
        prop_assert!(far <= METRES, "{} mm {at}", 1e3 * far);
        for (a, b) in angles.iter().zip(turns) {
            let turned = (a - b + 180.0).rem_euclid(360.0) - 180.0;
            prop_assert!(turned.abs() <= DEGREES, "{turned} degrees {at}");
        }
    }
    let error = resampling_error(
        &character,
        &Mesh::default(),
        &source,
        Played::Frames(&built),
    );
    prop_assert!(error.metres <= METRES, "{error:?}");
    Ok(())
}

/// Keys at whole ticks of a grid, with values within half a turn.
fn keys(
    ticks: Vec<u32>,
    hz: f64,
    start: f64,
    interpolation: Interpolation,
) -> impl Strategy<Value = Keys> {
    let times: Vec<f32> = ticks
        .iter()
        .map(|t| (start + f64::from(*t) / hz) as f32)
        .collect();
    let count = times.len();
    let values = prop::collection::vec(-1.2f32..1.2, count);
    let slopes = prop::collection::vec(-2.0f32..2.0, count);
    (values, slopes).prop_map(move |(values, slopes)| Keys {
        interpolation,
        times: times.clone(),
        values,
        slopes,
    })
}

/// Rising ticks with gaps up to a number.
fn ticks(count: usize, gap: u32) -> impl Strategy<Value = Vec<u32>> {
    prop::collection::vec(1..=gap, count).prop_map(|gaps| {
        let mut at = 0;
        let later = gaps.into_iter().map(|gap| {
            at += gap;
            at
        });
        [0].into_iter().chain(later.collect::<Vec<u32>>()).collect()
    })
}

/// Three tracks with the same pattern.
fn arm(
    ticks: impl Strategy<Value = Vec<u32>>,
    hz: f64,
    start: f64,
    interpolation: Interpolation,
) -> impl Strategy<Value = (Keys, Keys, Keys)> {
    ticks.prop_flat_map(move |ticks| {
        let all = |interpolation| keys(ticks.clone(), hz, start, interpolation);
        // A spline of quaternions is no spline of angles: only the shoulder's place is one.
        let turns = match interpolation {
            Interpolation::CubicSpline => Interpolation::Linear,
            other => other,
        };
        (all(interpolation), all(turns), all(turns))
    })
}

/// Keys that turn so little that a normalised blend follows them.
fn slow(keys: &Keys) -> Keys {
    let values = keys.values.iter().map(|v| 0.12 * v).collect();
    Keys {
        values,
        ..keys.clone()
    }
}

const RATES_HZ: [f64; 6] = [24.0, 25.0, 24_000.0 / 1001.0, 30_000.0 / 1001.0, 30.0, 60.0];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn hand_set_keys_are_followed(
        (slide, shoulder, elbow) in arm(ticks(6, 12), 10.0, 0.0, Interpolation::Linear),
    ) {
        check(&slide, &shoulder, &elbow)?;
    }

    #[test]
    fn keys_of_video_rates_are_followed(
        (slide, shoulder, elbow) in prop::sample::select(&RATES_HZ[..])
            .prop_flat_map(|hz| arm(ticks(12, 1), hz, 0.0, Interpolation::Linear)),
    ) {
        // Each joint turns by up to 17 degrees in a frame, where a normalised blend lags by 1e-4 rad.
        check(&slide, &slow(&shoulder), &slow(&elbow))?;
    }

    #[test]
    fn keys_that_begin_late_are_followed(
        (slide, shoulder, elbow) in prop::sample::select(&[(24.0, 1.0 / 30.0), (24.0, 0.1), (30.0, 0.04)][..])
            .prop_flat_map(|(hz, start)| arm(ticks(12, 1), hz, start, Interpolation::Linear)),
    ) {
        check(&slide, &slow(&shoulder), &slow(&elbow))?;
    }

    #[test]
    fn thinned_keys_are_followed(
        (slide, shoulder, elbow) in arm(ticks(6, 40), 30.0, 0.0, Interpolation::Linear),
    ) {
        check(&slide, &shoulder, &elbow)?;
    }

    #[test]
    fn splines_are_followed(
        (slide, shoulder, elbow) in arm(ticks(5, 6), 10.0, 0.0, Interpolation::CubicSpline),
    ) {
        // The shoulder sways by 2.4 cm.
        let small = |all: &[f32]| all.iter().map(|v| 0.02 * v).collect();
        let slide = Keys { values: small(&slide.values), slopes: small(&slide.slopes), ..slide };
        check(&slide, &shoulder, &elbow)?;
    }

    #[test]
    fn steps_are_kept(
        (slide, shoulder, elbow) in arm(ticks(6, 9), 12.0, 0.0, Interpolation::Step),
    ) {
        check(&slide, &shoulder, &elbow)?;
    }

    #[test]
    fn jumps_are_kept(
        (slide, mut shoulder, elbow) in arm(ticks(6, 9), 10.0, 0.0, Interpolation::Linear),
        after in -1.2f32..1.2,
    ) {
        // Two keys at the time of the third one.
        shoulder.times.insert(2, shoulder.times[2] - JUMP_SECS);
        shoulder.values.insert(3, after);
        shoulder.slopes.insert(3, 0.0);
        check(&slide, &shoulder, &elbow)?;
    }
}

#[test]
fn what_frames_miss_is_measured() {
    // A shoulder that goes 1 m aside and back within a second is at both of the frames of 1 Hz at rest.
    let keys = |values: [f32; 3]| Keys {
        interpolation: Interpolation::Linear,
        times: vec![0.0, 0.5, 1.0],
        values: values.to_vec(),
        slopes: vec![0.0; 3],
    };
    let still = keys([0.0; 3]);
    let source = clip(&keys([0.0, 1.0, 0.0]), &still, &still);
    let opts = ClipOptions { rate_hz: Some(1.0) };
    let (character, mesh) = (character(), Mesh::default());
    let built = sampled_clip(&character, &source, &mesh, &opts).unwrap();
    let error = resampling_error(&character, &mesh, &source, Played::Frames(&built));
    assert!(
        (error.metres - 1.0).abs() < 1e-6 && error.secs == 0.5,
        "{error:?}"
    );
    let itself = Played::Keys {
        clip: &source,
        rate_hz: 2.0,
    };
    assert_eq!(
        resampling_error(&character, &mesh, &source, itself).metres,
        0.0
    );
}
