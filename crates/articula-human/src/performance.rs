//! Clips of the human with a face: idle with blinks and gaze, and talking.

use crate::expression::names;
use crate::gestures::standing;
use crate::motion::{Pose, RATE, Side, cycle};
use crate::skeleton::joint;
use crate::weights::smooth_step;
use articula_core::source::{Channel, Interpolation, Property, RawClip};

/// Index of the mesh of the face.
const FACE: usize = 0;

/// The idle clip of four seconds: that of the mannequin, with two blinks and a look to each side.
pub(crate) fn idle() -> RawClip {
    const FRAMES: usize = 120;
    const LOOKS: [(f32, [f32; 2]); 3] = [(0.9, [-7.0, 2.0]), (2.0, [6.0, -1.0]), (3.1, [0.0, 0.0])];
    let clip = cycle("idle", FRAMES, |phase| {
        let mut pose = standing(phase, 1.0);
        look(&mut pose, phase * seconds(FRAMES), &LOOKS);
        pose
    });
    with_face(clip, |secs| {
        // An eye blinks while it leaps.
        let closed = blink(secs, 0.88) + blink(secs, 3.08);
        let mut face = blinks(closed);
        face.extend(both("mouthSmile", 0.12));
        face
    })
}

/// What is said in the clip `talk`: the time of each sound in seconds, and its shapes.
const SPEECH: [(f32, &[(&str, f32)]); 20] = [
    (0.30, &[("jawOpen", 0.3), ("mouthSmile", 0.25)]),
    (0.44, &[("jawOpen", 0.16), ("mouthUpperUp", 0.1)]),
    (0.58, &[("jawOpen", 0.28), ("mouthFunnel", 0.55)]),
    (0.92, &[("jawOpen", 0.08), ("mouthUpperUp", 0.15)]),
    (1.04, &[("jawOpen", 0.45), ("mouthLowerDown", 0.15)]),
    (1.17, &[("jawOpen", 0.14), ("mouthSmile", 0.35)]),
    (
        1.27,
        &[
            ("jawOpen", 0.04),
            ("mouthStretch", 0.3),
            ("mouthLowerDown", 0.3),
        ],
    ),
    (1.40, &[("jawOpen", 0.1), ("mouthPucker", 0.5)]),
    (1.53, &[("mouthPress", 0.6)]),
    (
        1.65,
        &[
            ("jawOpen", 0.14),
            ("mouthSmile", 0.45),
            ("mouthUpperUp", 0.15),
        ],
    ),
    (1.78, &[("jawOpen", 0.06), ("mouthLowerDown", 0.2)]),
    (1.95, &[("jawOpen", 0.12), ("mouthPucker", 0.65)]),
    (2.58, &[("jawOpen", 0.2)]),
    (2.70, &[("jawOpen", 0.5), ("mouthLowerDown", 0.1)]),
    (2.84, &[("jawOpen", 0.22), ("mouthFunnel", 0.45)]),
    (3.00, &[("jawOpen", 0.48)]),
    (3.15, &[("jawOpen", 0.2), ("mouthFunnel", 0.2)]),
    (3.28, &[("jawOpen", 0.12), ("mouthPucker", 0.7)]),
    (3.42, &[("jawOpen", 0.06), ("mouthPucker", 0.35)]),
    (3.70, &[("mouthSmile", 0.3)]),
];

/// Half the time in seconds over which a sound's shapes rise and fall.
const SOUND: f32 = 0.13;

/// The talk clip of 4.8 seconds: "hello, nice to meet you", "how are you" and a smile.
pub(crate) fn talk() -> RawClip {
    const FRAMES: usize = 144;
    const LOOKS: [(f32, [f32; 2]); 4] = [
        (0.75, [4.0, -2.0]),
        (1.1, [0.0, 0.0]),
        (2.2, [-5.0, 1.0]),
        (2.5, [0.0, 0.0]),
    ];
    let clip = cycle("talk", FRAMES, |phase| {
        let mut pose = standing(phase, 0.8);
        let secs = phase * seconds(FRAMES);
        look(&mut pose, secs, &LOOKS);
        accompany(&mut pose, secs);
        pose
    });
    with_face(clip, |secs| {
        let mut face = blinks(blink(secs, 0.74) + blink(secs, 2.2) + blink(secs, 4.1));
        for (at, shapes) in SPEECH {
            let near = smooth_step(SOUND, 0.0, (secs - at).abs());
            for (name, weight) in shapes {
                face.extend(both(name, near * weight));
            }
        }
        let smile = smooth_step(3.5, 3.8, secs) * smooth_step(4.7, 4.3, secs);
        face.extend(both("mouthSmile", 0.1 + 0.3 * smile));
        face.extend(both("cheekSquint", 0.25 * smile));
        let stress = beat(secs, 1.04) + beat(secs, 2.7);
        face.push(("browInnerUp".to_owned(), 0.5 * stress));
        face.extend(both("browOuterUp", 0.35 * stress));
        face
    })
}

/// Head and hand stress the words.
fn accompany(pose: &mut Pose, secs: f32) {
    let stress = beat(secs, 1.04) + beat(secs, 2.7);
    let nod = beat(secs, 0.4) + 0.6 * beat(secs, 3.0);
    let greeting = smooth_step(0.1, 0.6, secs) * smooth_step(2.4, 1.8, secs);
    let asking = smooth_step(2.4, 2.8, secs) * smooth_step(4.4, 3.6, secs);
    let tilt = [3.0 * nod - 2.0 * stress, 2.0 * greeting, 3.0 * asking];
    pose.turn(joint("skullbase"), tilt);
    for (side, raised) in [(Side::Right, greeting), (Side::Left, asking)] {
        pose.turn_side(side, "shoulder", [-8.0 * raised, 0.0, 3.0 * raised]);
        pose.turn_side(
            side,
            "elbow",
            [-48.0 * raised - 8.0 * stress * raised, 0.0, 0.0],
        );
        pose.turn_side(side, "wrist", [0.0, -35.0 * raised, 0.0]);
    }
}

fn seconds(frames: usize) -> f32 {
    frames as f32 / RATE
}

/// Rises and falls smoothly within a quarter of a second of a time.
fn beat(secs: f32, at: f32) -> f32 {
    smooth_step(0.25, 0.0, (secs - at).abs())
}

/// Share of the closing at a time, of a blink that begins at another: lids fall faster than they rise.
fn blink(secs: f32, at: f32) -> f32 {
    smooth_step(at, at + 0.09, secs) * smooth_step(at + 0.28, at + 0.12, secs)
}

/// Turns both eyes: each look begins at its time, with yaw and pitch in degrees.
fn look(pose: &mut Pose, secs: f32, looks: &[(f32, [f32; 2])]) {
    let mut angles = [0.0; 2];
    for (at, to) in looks {
        let share = smooth_step(*at, at + 0.1, secs);
        angles = [0, 1].map(|i| angles[i] + share * (to[i] - angles[i]));
    }
    for name in ["l_eyeball_joint", "r_eyeball_joint"] {
        pose.turn(joint(name), [angles[1], angles[0], 0.0]);
    }
}

/// A shape of both sides, or the one in the middle.
fn both(name: &str, weight: f32) -> Vec<(String, f32)> {
    if names().iter().any(|n| n == name) {
        return vec![(name.to_owned(), weight)];
    }
    let sides = ["Left", "Right"];
    sides.map(|side| (format!("{name}{side}"), weight)).to_vec()
}

fn blinks(closed: f32) -> Vec<(String, f32)> {
    both("eyeBlink", closed)
}

/// The clip with the weights that a function of the time in seconds tells; equal shapes are added.
fn with_face(mut clip: RawClip, face: impl Fn(f32) -> Vec<(String, f32)>) -> RawClip {
    let names = names();
    let times_secs = clip.channels[0].times_secs.clone();
    let mut values = vec![0.0; times_secs.len() * names.len()];
    let last = times_secs.len() - 1;
    for (key, weights) in values.chunks_exact_mut(names.len()).enumerate() {
        // The last key is the first one again.
        for (name, weight) in face(times_secs[key % last]) {
            let index = names.iter().position(|n| *n == name);
            let index = index.expect("the shapes of the clips are in the table");
            weights[index] = (weights[index] + weight).clamp(0.0, 1.0);
        }
    }
    clip.channels.push(Channel {
        target: FACE,
        property: Property::Weights,
        interpolation: Interpolation::Linear,
        times_secs,
        values,
    });
    clip
}
