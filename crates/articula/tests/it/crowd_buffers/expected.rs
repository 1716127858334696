//! What the buffers must hold, by the plain path alone: clips sampled joint by joint, joints multiplied
//! from the root on, inverse bind matrices of the source. No batch, palette or layout of the crowd.

use super::figure::{Figure, KEPT};
use articula_core::{
    JointSet, LocalPose, ModelPose, PoseCache, Wrap, blend, local_to_model, sample, sample_morphs,
};
use glam::{Affine3A, Quat, Vec3};
use serde_json::{Value, json};

/// A character as the test places it.
pub(crate) struct Member {
    pub(crate) position: Vec3,
    pub(crate) yaw_radians: f32,
    pub(crate) scale: f32,
    /// Clip and time in seconds.
    pub(crate) shows: (usize, f32),
    /// A second clip with its time and weight.
    pub(crate) fades_to: Option<(usize, f32, f32)>,
    /// Level that it must have; `None` if it must be hidden.
    pub(crate) level: Option<usize>,
}

/// What is shown of a cache in a frame.
#[derive(Clone, Copy)]
pub(crate) struct Shown<'a> {
    pub(crate) cache: Option<&'a PoseCache>,
    pub(crate) is_by_gpu: bool,
    /// Characters of records, and those of stepped draws.
    pub(crate) recorded: &'a [u32],
    pub(crate) stepped: &'a [u32],
}

/// All shown characters, as JSON: matrices of each skin's joints in the order of its source, `null` for
/// joints that the level drops; weights; world transforms.
///
/// Poses of the cache are those of its two key times, of a record perhaps those of two equal parts of the clip, blended
/// matrix by matrix; of stepped characters those at the nearest of these parts.
pub(crate) fn expected(figure: &Figure, members: &[Member], shown: Shown<'_>) -> Value {
    let names = |j: &usize| figure.asset.rig.name(*j).to_owned();
    let skins = figure.skins.iter().map(|skin| {
        let binds: Vec<Value> = skin.inverse_bind.iter().map(numbers).collect();
        json!({"joints": skin.joints.iter().map(names).collect::<Vec<_>>(), "inverse_bind": binds})
    });
    let all = members.iter().enumerate();
    let all = all.filter_map(|(c, member)| Some((c, member, member.level?)));
    let characters = all.map(|(c, member, level)| {
        let source = match c as u32 {
            c if shown.stepped.contains(&c) => "stepped",
            c if shown.recorded.contains(&c) => "record",
            _ => "draw",
        };
        let keys = keys(figure, member, level, (shown, source));
        let matrices = figure.skins.iter().map(|skin| {
            let all = skin.joints.iter().zip(&skin.inverse_bind);
            let of = |(joint, bind): (&usize, &Affine3A)| match level > 0
                && !KEPT.contains(&names(joint).as_str())
            {
                true => Value::Null,
                false => matrix(figure, member, &keys, (*joint, bind)),
            };
            all.map(of).collect::<Vec<_>>()
        });
        let (turn, scale) = (
            Quat::from_rotation_y(member.yaw_radians),
            Vec3::splat(member.scale),
        );
        let world = Affine3A::from_scale_rotation_translation(scale, turn, member.position);
        json!({
            "character": c,
            "level": level,
            "source": source,
            "matrices": matrices.collect::<Vec<_>>(),
            "morph_weights": (level == 0).then(|| weights(figure, member)),
            "world": numbers(&world),
        })
    });
    json!({"skins": skins.collect::<Vec<_>>(), "characters": characters.collect::<Vec<_>>()})
}

/// The matrix of one joint and bind matrix, from one pose or blended from those at two of the times.
fn matrix(
    figure: &Figure,
    member: &Member,
    keys: &[f32],
    (joint, bind): (usize, &Affine3A),
) -> Value {
    let (clip, secs) = member.shows;
    let at = |secs: f32| posed(figure, (clip, secs), member.fades_to).matrices[joint] * *bind;
    let after = keys.iter().position(|key| *key > secs);
    let after = after.unwrap_or(keys.len() - 1);
    let before = after.saturating_sub(usize::from(keys[after] > secs));
    let span = keys[after] - keys[before];
    let share = if span > 0.0 {
        (secs - keys[before]) / span
    } else {
        0.0
    };
    let ends = [before, after].map(|key| cells(&at(keys[key])));
    let mixed = |i: usize| ends[0][i] + (ends[1][i] - ends[0][i]) * f64::from(share);
    rounded((0..12).map(mixed))
}

/// The times of the poses that a member is shown in or between; its own where it is evaluated.
fn keys(
    figure: &Figure,
    member: &Member,
    level: usize,
    (shown, source): (Shown<'_>, &str),
) -> Vec<f32> {
    let (clip, secs) = member.shows;
    let Some(cache) = shown.cache.filter(|_| member.fades_to.is_none()) else {
        return vec![secs];
    };
    let of_keys = cache.error_metres(clip, level);
    if source == "record" && cache.record_error_metres(clip, level) != of_keys {
        return steps(figure, cache, level, clip);
    }
    let apart = |step: &f32| (step - secs).abs();
    let nearest = |steps: Vec<f32>| {
        let of = |a: &f32, b: &f32| apart(a).total_cmp(&apart(b));
        steps.into_iter().min_by(of).unwrap()
    };
    match (source, cache.times_secs(clip, level)) {
        ("stepped", _) => vec![nearest(steps(figure, cache, level, clip))],
        ("record", Some(keys)) => keys.collect(),
        (_, Some(keys)) if !shown.is_by_gpu => keys.collect(),
        _ => vec![secs],
    }
}

/// The times between the equal parts of a clip.
fn steps(figure: &Figure, cache: &PoseCache, level: usize, clip: usize) -> Vec<f32> {
    // The palettes of the parts follow each other; they may be those of a level with more joints.
    let [first, last] = [0.0, f32::MAX].map(|t| cache.nearest(clip, level, t).unwrap());
    let beside = cache.between_steps(clip, level, 0.0).unwrap();
    let spans = (last - first) / (beside.after - beside.before);
    let end_secs = figure.asset.clips[clip].duration_secs();
    let part = |i: u32| end_secs * i as f32 / spans as f32;
    (0..=spans).map(part).collect()
}

fn posed(
    figure: &Figure,
    (clip, secs): (usize, f32),
    fades_to: Option<(usize, f32, f32)>,
) -> ModelPose {
    let asset = &figure.asset;
    let all = JointSet::first(asset.rig.len());
    let local = |clip: usize, secs: f32| {
        let mut pose: LocalPose = asset.rig.rest_pose().clone();
        sample(
            &asset.clips[clip],
            f64::from(secs),
            Wrap::Clamp,
            &all,
            &mut pose,
        );
        pose
    };
    let mut pose = local(clip, secs);
    if let Some((other, secs, weight)) = fades_to {
        blend(&mut pose, &local(other, secs), weight, &all);
    }
    let mut model = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, &pose, &mut model);
    model
}

fn weights(figure: &Figure, member: &Member) -> Value {
    let at = |clip: usize, secs: f32| {
        let mut weights = figure.asset.mesh.morph_weights.clone();
        sample_morphs(
            &figure.asset.clips[clip],
            f64::from(secs),
            Wrap::Clamp,
            &mut weights,
        );
        weights
    };
    let mut weights = at(member.shows.0, member.shows.1);
    if let Some((other, secs, share)) = member.fades_to {
        let others = at(other, secs);
        let each = weights.iter_mut().zip(others);
        each.for_each(|(own, other)| *own += (other - *own) * share);
    }
    rounded(weights.iter().map(|w| f64::from(*w)))
}

/// The upper three rows of a 4x4 matrix.
fn cells(matrix: &Affine3A) -> [f64; 12] {
    let columns = glam::Mat4::from(*matrix).to_cols_array_2d();
    std::array::from_fn(|i| f64::from(columns[i % 4][i / 4]))
}

fn numbers(matrix: &Affine3A) -> Value {
    rounded(cells(matrix))
}

fn rounded(numbers: impl IntoIterator<Item = f64>) -> Value {
    let short = |n: f64| (n * 1e7).round() / 1e7;
    // Negative zeros become zeros.
    numbers.into_iter().map(|n| short(n) + 0.0).collect()
}

/// Whether two documents differ by no more than rounding on another machine.
pub(crate) fn is_near(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|n| n.as_f64().unwrap());
            (a - b).abs() <= 5e-6
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_near(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter()
                    .all(|(k, a)| b.get(k).is_some_and(|b| is_near(a, b)))
        }
        _ => a == b,
    }
}
