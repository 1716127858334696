//! Blend shapes as morph targets: one for each target shape of a channel, those in between named by their
//! amount.
//!
//! A channel has an amount; between none and its targets the effect is linear in pieces, and goes on beyond the
//! last.

use super::source::Reader;
use crate::error::ReadError;
use articula_core::source::{MorphTarget, Primitive};
use glam::{DAffine3, DVec3, Vec3};
use std::collections::HashMap;

/// Amounts up to this size are none.
const NONE: f64 = 1e-9;

/// A morph target of a mesh.
pub(super) struct Target {
    pub(super) name: String,
    /// Weight at the stored amount.
    pub(super) stored: f32,
    shape: usize,
    /// Channel of the scene.
    channel: usize,
    /// Amounts at which the channel's targets have their full effect, rising.
    amounts: Vec<f64>,
    /// Which of them is this one.
    which: usize,
}

/// The morph targets of a mesh.
pub(super) fn targets(reader: &Reader<'_>, mesh: usize) -> Vec<Target> {
    let mut targets = Vec::new();
    for channel in reader.scene.channels(mesh) {
        let mut amounts: Vec<f64> = channel.targets.iter().map(|t| t.0).collect();
        amounts
            .iter_mut()
            .filter(|a| !a.is_finite())
            .for_each(|a| *a = 0.0);
        let last = channel.targets.len().saturating_sub(1);
        for (which, (full, shape)) in channel.targets.iter().enumerate() {
            let name = match which == last {
                true => channel.name.clone(),
                false => format!("{}_{:.0}", channel.name, 100.0 * full),
            };
            let stored = effect(&amounts, which, channel.amount);
            targets.push(Target {
                name,
                stored: if stored.is_finite() { stored } else { 0.0 },
                shape: *shape,
                channel: channel.index,
                amounts: amounts.clone(),
                which,
            });
        }
    }
    targets
}

/// Weight of the target `which` at an amount of its channel.
fn effect(amounts: &[f64], which: usize, amount: f64) -> f32 {
    // The targets and, between them, none.
    let mut steps: Vec<(f64, Option<usize>)> = vec![(0.0, None)];
    let full = amounts.iter().enumerate().filter(|(_, a)| a.abs() > NONE);
    steps.extend(full.map(|(target, a)| (*a, Some(target))));
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    steps.dedup_by(|b, a| b.0 == a.0);
    if steps.len() < 2 {
        return 0.0;
    }
    let behind = steps.partition_point(|step| step.0 <= amount);
    let next = behind.clamp(1, steps.len() - 1);
    let (from, to) = (steps[next - 1], steps[next]);
    let share = (amount - from.0) / (to.0 - from.0);
    match Some(which) {
        of if of == from.1 => (1.0 - share) as f32,
        of if of == to.1 => share as f32,
        _ => 0.0,
    }
}

/// Weights of all targets of a mesh for each frame of the channels' amounts.
pub(super) fn weights(targets: &[Target], amounts: &[Vec<f64>]) -> Vec<Vec<f32>> {
    let frames = targets.first().and_then(|t| amounts.get(t.channel));
    let frames = frames.map_or(0, Vec::len);
    let at = |frame: usize| {
        let of = |target: &Target| {
            let amount = amounts[target.channel][frame];
            let weight = effect(&target.amounts, target.which, amount);
            if weight.is_finite() {
                weight
            } else {
                target.stored
            }
        };
        targets.iter().map(of).collect()
    };
    (0..frames).map(at).collect()
}

/// Adds the targets to a primitive; `points` has the control point of each vertex.
pub(super) fn apply(
    reader: &mut Reader<'_>,
    targets: &[Target],
    place: &DAffine3,
    points: &[u32],
    primitive: &mut Primitive,
) -> Result<(), ReadError> {
    if targets.is_empty() {
        return Ok(());
    }
    let mut vertices: HashMap<u32, Vec<usize>> = HashMap::new();
    for (vertex, point) in points.iter().enumerate() {
        vertices.entry(*point).or_default().push(vertex);
    }
    let normal_matrix = place.matrix3.inverse().transpose();
    for target in targets {
        let bends = reader.scene.bends_normals(target.shape) && !primitive.normals.is_empty();
        let width = if bends { 6 } else { 3 };
        reader.charge(&target.name, width * points.len())?;
        let mut made = MorphTarget {
            positions: vec![Vec3::ZERO; points.len()],
            normals: vec![Vec3::ZERO; if bends { points.len() } else { 0 }],
        };
        // A point may be named twice; both offsets count.
        let mut of_point: HashMap<u32, (DVec3, DVec3)> = HashMap::new();
        for (point, offset, normal) in reader.scene.shape(target.shape) {
            let (moved, bent) = of_point.entry(point).or_default();
            (*moved, *bent) = (*moved + offset, *bent + normal);
        }
        for (point, (offset, normal)) in of_point {
            let offset = finite(place.matrix3 * offset);
            let normal = finite(normal_matrix * normal);
            for &vertex in vertices.get(&point).into_iter().flatten() {
                made.positions[vertex] = offset;
                if bends {
                    made.normals[vertex] = normal;
                }
            }
        }
        primitive.morphs.push(made);
    }
    Ok(())
}

fn finite(v: DVec3) -> Vec3 {
    let v = v.as_vec3();
    if v.is_finite() { v } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::effect;

    #[test]
    fn effects_are_linear_in_pieces_and_go_on() {
        // Targets at 50 % and 100 %.
        let of = |amount| [0, 1].map(|which| effect(&[0.5, 1.0], which, amount));
        assert_eq!(of(0.0), [0.0, 0.0]);
        assert_eq!(of(0.25), [0.5, 0.0]);
        assert_eq!(of(0.5), [1.0, 0.0]);
        assert_eq!(of(0.75), [0.5, 0.5]);
        assert_eq!(of(1.0), [0.0, 1.0]);
        assert_eq!(of(1.5), [-1.0, 2.0]);
        assert_eq!(of(-0.5), [-1.0, 0.0]);
        // One on either side of none.
        let of = |amount| [0, 1].map(|which| effect(&[-1.0, 1.0], which, amount));
        assert_eq!(of(-0.5), [0.5, 0.0]);
        assert_eq!(of(0.5), [0.0, 0.5]);
        assert_eq!(of(-2.0), [2.0, 0.0]);
        assert_eq!(effect(&[0.0], 0, 1.0), 0.0);
    }
}
