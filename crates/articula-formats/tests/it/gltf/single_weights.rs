//! Channels of single morph weights (KHR_animation_pointer) are read as channels of all weights.

use super::tiny::Tiny;
use articula_core::source::{Channel, Interpolation, Property, evaluate};
use serde_json::{Value, json};

/// Default weights of the mesh.
const REST: [f32; 3] = [0.1, 0.2, 0.3];

/// The triangle with three morph targets on two nodes, the second of which has its own weights.
fn morphing() -> Tiny {
    let mut tiny = Tiny::triangle();
    let targets = [1.0, 2.0, 3.0].map(|far| json!({"POSITION": tiny.floats("VEC3", &[far; 9])}));
    tiny.json["meshes"][0]["primitives"][0]["targets"] = json!(targets);
    tiny.json["meshes"][0]["weights"] = json!(REST);
    tiny.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 0, 0]}]);
    tiny
}

fn pointed(pointer: &str) -> Value {
    json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}})
}

fn drive(tiny: &mut Tiny, pointer: &str, mode: &str, times: &[f32], values: &[f32]) {
    let values = tiny.floats("SCALAR", values);
    tiny.channel(pointed(pointer), mode, times, values);
}

/// A file with a linear, a stepped and a cubic weight, each with times of its own.
pub(super) fn every_mode() -> Tiny {
    let mut tiny = morphing();
    drive(
        &mut tiny,
        "/nodes/0/weights/0",
        "LINEAR",
        &[0., 1.],
        &[0., 1.],
    );
    drive(
        &mut tiny,
        "/nodes/0/weights/1",
        "STEP",
        &[0., 0.5],
        &[0., 1.],
    );
    let cubic = [0., 0., 2., 1., 1., 0.];
    drive(
        &mut tiny,
        "/nodes/0/weights/2",
        "CUBICSPLINE",
        &[0., 2.],
        &cubic,
    );
    tiny
}

/// Returns the channels of the only clip, and all warnings.
fn channels(tiny: &Tiny) -> (Vec<Channel>, Vec<String>) {
    let file = tiny.read().unwrap();
    let told = file.warnings.into_iter().map(|w| w.what);
    (
        file.value.character.clips[0].channels.clone(),
        told.collect(),
    )
}

fn at(channel: &Channel, time_secs: f32) -> [f32; 3] {
    let mut weights = [0.0; 3];
    evaluate::channel(channel, time_secs, &mut weights);
    weights
}

fn near(found: [f32; 3], wanted: [f32; 3]) {
    let apart = |(a, b): (f32, f32)| (a - b).abs();
    let most = found.into_iter().zip(wanted).map(apart).fold(0.0, f32::max);
    assert!(most < 1e-3, "{found:?} is not {wanted:?}");
}

#[test]
fn weights_of_equal_times_are_one_channel_with_those_keys() {
    let mut tiny = morphing();
    drive(
        &mut tiny,
        "/nodes/0/weights/2",
        "LINEAR",
        &[0., 1.],
        &[0., 1.],
    );
    drive(
        &mut tiny,
        "/nodes/0/weights/0",
        "LINEAR",
        &[0., 1.],
        &[0.5, 0.7],
    );
    let (found, told) = channels(&tiny);
    assert!(told.is_empty(), "{told:?}");
    let [all] = &found[..] else {
        panic!("{} channels", found.len());
    };
    assert_eq!((all.target, all.property), (0, Property::Weights));
    assert_eq!(all.times_secs, [0., 1.]);
    assert_eq!(all.values, [0.5, 0.2, 0.0, 0.7, 0.2, 1.0]);
}

#[test]
fn lines_and_steps_of_any_times_keep_their_values() {
    let mut lines = morphing();
    drive(
        &mut lines,
        "/nodes/0/weights/0",
        "LINEAR",
        &[0., 2.],
        &[0., 2.],
    );
    drive(
        &mut lines,
        "/nodes/0/weights/1",
        "LINEAR",
        &[0.5, 1.],
        &[0., 1.],
    );
    let (found, told) = channels(&lines);
    assert!(told.is_empty(), "{told:?}");
    assert_eq!(found[0].times_secs, [0., 0.5, 1., 2.]);
    near(at(&found[0], 0.75), [0.75, 0.5, 0.3]);
    near(at(&found[0], 1.5), [1.5, 1.0, 0.3]);
    let mut steps = morphing();
    drive(
        &mut steps,
        "/nodes/0/weights/0",
        "STEP",
        &[0., 2.],
        &[0., 1.],
    );
    drive(&mut steps, "/nodes/0/weights/1", "STEP", &[1.], &[0.9]);
    let (found, told) = channels(&steps);
    assert!(told.is_empty(), "{told:?}");
    assert_eq!(found[0].interpolation, Interpolation::Step);
    assert_eq!(at(&found[0], 1.9), [0.0, 0.9, 0.3]);
    assert_eq!(at(&found[0], 2.0), [1.0, 0.9, 0.3]);
}

#[test]
fn cubic_curves_of_equal_times_stay_cubic() {
    let mut tiny = morphing();
    // In-tangent, value and out-tangent of each key.
    let keys = [0., 0., 2., 1., 1., 0.];
    drive(
        &mut tiny,
        "/nodes/0/weights/1",
        "CUBICSPLINE",
        &[0., 2.],
        &keys,
    );
    let (found, told) = channels(&tiny);
    assert!(told.is_empty(), "{told:?}");
    assert_eq!(found[0].interpolation, Interpolation::CubicSpline);
    // Hermite at the middle of 2 s: the mean of the values, and an eighth of the span times the
    // difference of the tangents.
    near(
        at(&found[0], 1.0),
        [0.1, 0.5 + 2.0 / 8.0 * (2.0 - 1.0), 0.3],
    );
}

#[test]
fn curves_of_different_kinds_become_one_linear_curve() {
    let (found, told) = channels(&every_mode());
    assert!(told.len() == 1 && told[0].contains("linear"), "{told:?}");
    assert_eq!(
        (found.len(), found[0].interpolation),
        (1, Interpolation::Linear)
    );
    let hermite = |t: f32| {
        let (t2, t3) = (t * t, t * t * t);
        2.0 * (t3 - 2.0 * t2 + t) * 2.0 + (3.0 * t2 - 2.0 * t3) + 2.0 * (t3 - t2)
    };
    for (time, step) in [
        (0.1, 0.0),
        (0.499, 0.0),
        (0.5, 1.0),
        (0.93, 1.0),
        (1.7, 1.0),
    ] {
        let line = f32::min(time, 1.0);
        near(at(&found[0], time), [line, step, hermite(time / 2.0)]);
    }
}

#[test]
fn a_weight_of_a_mesh_drives_the_nodes_without_own_weights() {
    let mut tiny = morphing();
    let nodes = tiny.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"mesh": 0}));
    drive(
        &mut tiny,
        "/meshes/0/weights/1",
        "LINEAR",
        &[0., 1.],
        &[0., 1.],
    );
    let (found, told) = channels(&tiny);
    assert!(told.is_empty(), "{told:?}");
    let targets: Vec<usize> = found.iter().map(|c| c.target).collect();
    assert_eq!(targets, [0, 2]);
    assert_eq!(at(&found[1], 1.0), [0.1, 1.0, 0.3]);
}

#[test]
fn a_weight_has_one_channel_and_must_exist() {
    let single = |tiny: &mut Tiny, pointer: &str| drive(tiny, pointer, "LINEAR", &[0.], &[0.5]);
    let whole = |tiny: &mut Tiny| drive(tiny, "/nodes/0/weights", "LINEAR", &[0.], &[0.9; 3]);
    let mut twice = morphing();
    single(&mut twice, "/nodes/0/weights/1");
    single(&mut twice, "/meshes/0/weights/1");
    whole(&mut twice);
    let (found, told) = channels(&twice);
    assert_eq!((found.len(), told.len()), (1, 2), "{told:?}");
    assert_eq!(at(&found[0], 0.0), [0.1, 0.5, 0.3]);
    let mut after = morphing();
    whole(&mut after);
    single(&mut after, "/nodes/0/weights/1");
    let (found, told) = channels(&after);
    assert_eq!((found.len(), told.len()), (1, 1), "{told:?}");
    assert_eq!(at(&found[0], 0.0), [0.9; 3]);
    let mut missing = morphing();
    single(&mut missing, "/nodes/0/weights/3");
    single(&mut missing, "/nodes/7/weights/0");
    let (found, told) = channels(&missing);
    assert_eq!((found.len(), told.len()), (0, 2), "{told:?}");
}
