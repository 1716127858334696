//! Time sensors: `TimeSensor` → interpolator → joint or displacer, the older form of animation.
//!
//! Each sensor that moves the figure is a clip with the length of its cycle.
//!
//! Source: ISO/IEC 19775-1, 4.4.8 (routes), 8.4.1 (TimeSensor), clause 19 (interpolators).

use super::draft::{Draft, Stage, WeightTrack, key_times};
use super::fields::Reader;
use super::scene::{NodeId, Route};
use crate::error::ReadError;
use glam::DVec3;
use std::collections::HashMap;

/// Accepted cycle lengths: a microsecond to a day.
const CYCLE_SECS: std::ops::RangeInclusive<f64> = 1e-6..=86400.0;

type Routes<'s> = HashMap<NodeId, Vec<&'s Route>>;

/// Reads all time sensors that move a figure.
pub(super) fn read_all(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
) -> Result<Vec<Draft>, ReadError> {
    let scene = reader.scene;
    let mut from: Routes<'_> = HashMap::new();
    for route in &scene.routes {
        from.entry(route.from).or_default().push(route);
    }
    let mut drafts = Vec::new();
    for (id, node) in scene.nodes.iter().enumerate() {
        if node.kind == "TimeSensor" && from.contains_key(&id) {
            let draft = sensor(reader, stage, &from, id)?;
            drafts.extend(draft.filter(|d| !d.channels.is_empty() || !d.weights.is_empty()));
        }
    }
    Ok(drafts)
}

fn sensor(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
    from: &Routes<'_>,
    id: NodeId,
) -> Result<Option<Draft>, ReadError> {
    let cycle_secs = reader.number(id, "cycleInterval", 1.0)?;
    if !CYCLE_SECS.contains(&cycle_secs) {
        let what = format!("cycleInterval is {cycle_secs} s; the sensor is left out");
        reader.warn(id, what);
        return Ok(None);
    }
    let mut draft = Draft {
        name: reader.spelled_name(id),
        duration_secs: cycle_secs as f32,
        channels: Vec::new(),
        weights: Vec::new(),
    };
    for route in from.get(&id).into_iter().flatten() {
        if plain(&route.from_field) != "fraction" {
            continue;
        }
        match (reader.kind(route.to), plain(&route.to_field)) {
            ("HAnimDisplacer", "weight") if stage.is_seen(route.to) => {
                draft.weights.push(WeightTrack {
                    displacer: route.to,
                    times_secs: vec![0.0, cycle_secs as f32],
                    values: vec![0.0, 1.0],
                });
            }
            (_, "fraction") => {
                for onward in from.get(&route.to).into_iter().flatten() {
                    if plain(&onward.from_field) == "value" {
                        track(reader, stage, &mut draft, (onward, cycle_secs))?;
                    }
                }
            }
            _ => {}
        }
    }
    // A single key is a pose of zero length.
    let keys = |times: &[f32]| times.len();
    let lengths = draft.channels.iter().map(|c| keys(&c.times_secs));
    let most = lengths
        .chain(draft.weights.iter().map(|w| keys(&w.times_secs)))
        .max();
    if most == Some(1) {
        let ends = draft.channels.iter().map(|c| c.times_secs[0]);
        let ends = ends.chain(draft.weights.iter().map(|w| w.times_secs[0]));
        draft.duration_secs = ends.fold(0.0, f32::max);
    }
    Ok(Some(draft))
}

/// Returns the name of a field without the affixes that routes may use.
fn plain(field: &str) -> &str {
    let field = field.strip_prefix("set_").unwrap_or(field);
    field.strip_suffix("_changed").unwrap_or(field)
}

/// Adds the effect of one interpolator on one node.
fn track(
    reader: &mut Reader<'_>,
    stage: &Stage<'_>,
    draft: &mut Draft,
    (route, cycle_secs): (&Route, f64),
) -> Result<(), ReadError> {
    let (id, to) = (route.from, route.to);
    let joint = stage.joint(to);
    let field = plain(&route.to_field);
    match (reader.kind(id), joint, field) {
        ("OrientationInterpolator", Some(joint), "rotation") => {
            let values = reader.tuples::<4>(id, "keyValue")?;
            let (times, keys) = keys(reader, id, cycle_secs, values.len())?;
            if !times.is_empty() {
                let values = keys.iter().map(|&key| reader.turn(values[key]));
                draft.channels.push(stage.rotations(joint, times, values));
            }
        }
        ("PositionInterpolator", Some(joint), "translation" | "scale") => {
            let values = reader.tuples::<3>(id, "keyValue")?;
            let (times, keys) = keys(reader, id, cycle_secs, values.len())?;
            if !times.is_empty() {
                let values = keys.iter().map(|&key| DVec3::from_array(values[key]));
                draft.channels.push(match field {
                    "translation" => stage.translations(joint, times, values),
                    _ => stage.scales(joint, times, values),
                });
            }
        }
        ("ScalarInterpolator", None, "weight") if stage.is_seen(to) => {
            let values = reader.numbers(id, "keyValue")?;
            let (times_secs, keys) = keys(reader, id, cycle_secs, values.len())?;
            if !times_secs.is_empty() {
                draft.weights.push(WeightTrack {
                    displacer: to,
                    times_secs,
                    values: keys.iter().map(|&key| values[key] as f32).collect(),
                });
            }
        }
        (kind, _, _) => {
            let part_of_figure = joint.is_some() || to == stage.figure.id || stage.is_seen(to);
            if part_of_figure {
                let what = format!("{kind} onto {}.{field} is left out", reader.kind(to));
                reader.warn(id, what);
            }
        }
    }
    Ok(())
}

/// Returns times and indices of an interpolator's keys.
fn keys(
    reader: &mut Reader<'_>,
    id: NodeId,
    cycle_secs: f64,
    values: usize,
) -> Result<(Vec<f32>, Vec<usize>), ReadError> {
    let mut fractions = reader.numbers(id, "key")?;
    if fractions.len() != values {
        let what = format!(
            "{} keys and {values} values; the excess is left out",
            fractions.len()
        );
        reader.warn(id, what);
        fractions.truncate(values);
    }
    // One interpolator may drive many joints.
    reader.charge(id, 8 * fractions.len())?;
    let times = key_times(reader, id, &fractions, cycle_secs)?;
    Ok(times.into_iter().unzip())
}
