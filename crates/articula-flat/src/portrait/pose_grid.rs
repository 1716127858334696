//! Positions of the vertices of a portrait for any yaw, pitch and expression, as tables of few
//! modes.
//!
//! Source: `docs/methods/vector.md` part 10. Positions are stored at the nodes of a grid of yaw and
//! pitch and interpolated linearly between them. The rest shape and the offsets of all expressions
//! share the modes of one truncated decomposition over the nodes, so a node costs a few numbers,
//! independent of the numbers of vertices and expressions.

use super::head::HeadPose;
use crate::low_rank::modes;
use glam::Vec2;

/// Maximum number of modes; turning heads need four to seven, those with a face animation table more.
const MAX_MODES: usize = 16;
/// Greatest error of a position, by the tolerance of the root mean square.
const GREATEST: f64 = 3.0;
/// Offsets smaller than this at every node are omitted, pixels.
const STILL_PX: f32 = 0.02;

/// Values of one mode over vertices, as integers with a common step.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Quantised<T> {
    /// Size of one step.
    pub scale: f32,
    /// The values, in steps.
    pub steps: Vec<T>,
}

/// Contribution of an expression to the modes of the vertices that it moves.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ExpressionTable {
    /// Name of the expression.
    pub name: String,
    /// Vertices that move, ascending.
    pub vertices: Vec<u32>,
    /// For each mode, one value per vertex.
    pub modes: Vec<Quantised<i8>>,
}

/// Positions of all vertices by yaw, pitch and expressions.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct PoseGrid {
    /// Yaw of the nodes, ascending, degrees.
    pub yaw_degrees: Vec<f32>,
    /// Pitch of the nodes, ascending, degrees.
    pub pitch_degrees: Vec<f32>,
    /// For each node (yaw within pitch), for x then y: the offset, then the coefficient of each
    /// mode.
    pub coefficients: Vec<f32>,
    /// For each mode, one value per vertex at rest.
    pub rest: Vec<Quantised<i16>>,
    /// Contribution of each expression.
    pub expressions: Vec<ExpressionTable>,
}

/// Positions of all vertices at all nodes, before the reduction to modes.
pub(crate) struct Samples {
    pub(crate) yaw_degrees: Vec<f32>,
    pub(crate) pitch_degrees: Vec<f32>,
    /// For each node (yaw within pitch) the positions at rest.
    pub(crate) rest: Vec<Vec<Vec2>>,
    /// For each expression and node the positions.
    pub(crate) expressions: Vec<(String, Vec<Vec<Vec2>>)>,
}

impl PoseGrid {
    /// Reduces samples to the fewest modes whose root mean square error is within the tolerance, and whose
    /// greatest error is within three times as much, at rest and for every expression, and quantises
    /// them.
    pub(crate) fn new(samples: &Samples, tolerance_px: f32) -> Self {
        let vertices = samples.rest.first().map_or(0, Vec::len);
        let moved: Vec<Vec<u32>> = samples
            .expressions
            .iter()
            .map(|(_, nodes)| moved(&samples.rest, nodes))
            .collect();
        let (offsets, rows) = rows(samples, &moved);
        let all = modes(&rows, MAX_MODES);
        let columns = project_rows(&rows, &all);
        let groups = groups(vertices, &moved);
        let rank = fewest(&rows, &all, &columns, &groups, f64::from(tolerance_px));
        let mut coefficients = Vec::with_capacity(rows.len() * (rank + 1));
        for (row, offset) in offsets.iter().enumerate() {
            coefficients.push(*offset as f32);
            coefficients.extend(all[..rank].iter().map(|mode| mode[row] as f32));
        }
        let slice = |k: usize, at: &std::ops::Range<usize>| &columns[k][at.clone()];
        let rest = (0..rank)
            .map(|k| quantise_wide(slice(k, &groups[0])))
            .collect();
        let named = samples.expressions.iter().zip(moved).zip(&groups[1..]);
        let expressions = named.map(|(((name, _), vertices), at)| ExpressionTable {
            name: name.clone(),
            vertices,
            modes: (0..rank).map(|k| quantise_narrow(slice(k, at))).collect(),
        });
        Self {
            yaw_degrees: samples.yaw_degrees.clone(),
            pitch_degrees: samples.pitch_degrees.clone(),
            coefficients,
            rest,
            expressions: expressions.collect(),
        }
    }

    /// Number of modes.
    pub(crate) fn rank(&self) -> usize {
        self.rest.len()
    }

    /// Positions of all vertices without roll. Angles are clamped to the grid; weights without an
    /// expression are ignored.
    pub(crate) fn places(&self, pose: &HeadPose, weights: &[f32]) -> Vec<Vec2> {
        let shape = self.shape(weights);
        let mixed = self.mixed(pose);
        let width = self.rank() + 1;
        let count = shape.first().map_or(0, Vec::len);
        let place = |v: usize| {
            let axis = |first: usize| {
                let shares = &mixed[first + 1..first + width];
                let modes = shares.iter().zip(&shape);
                mixed[first] + modes.map(|(share, mode)| share * mode[v]).sum::<f32>()
            };
            Vec2::new(axis(0), axis(width))
        };
        (0..count).map(place).collect()
    }

    /// For each mode one value per vertex, expressions added.
    fn shape(&self, weights: &[f32]) -> Vec<Vec<f32>> {
        let wide = |q: &Quantised<i16>| q.steps.iter().map(|s| f32::from(*s) * q.scale).collect();
        let mut shape: Vec<Vec<f32>> = self.rest.iter().map(wide).collect();
        for (expression, weight) in self.expressions.iter().zip(weights) {
            if *weight == 0.0 {
                continue;
            }
            for (mode, table) in shape.iter_mut().zip(&expression.modes) {
                for (v, step) in expression.vertices.iter().zip(&table.steps) {
                    mode[*v as usize] += f32::from(*step) * table.scale * weight;
                }
            }
        }
        shape
    }

    /// Coefficients at a pose, bilinear between the four nodes around it.
    fn mixed(&self, pose: &HeadPose) -> Vec<f32> {
        let (yaw, right) = between(&self.yaw_degrees, pose.yaw_degrees);
        let (pitch, up) = between(&self.pitch_degrees, pose.pitch_degrees);
        let stride = 2 * (self.rank() + 1);
        let mut out = vec![0.0; stride];
        for (y, p, share) in [
            (yaw, pitch, (1.0 - right) * (1.0 - up)),
            (yaw + 1, pitch, right * (1.0 - up)),
            (yaw, pitch + 1, (1.0 - right) * up),
            (yaw + 1, pitch + 1, right * up),
        ] {
            if share > 0.0 {
                let first = (p * self.yaw_degrees.len() + y) * stride;
                let node = &self.coefficients[first..first + stride];
                out.iter_mut().zip(node).for_each(|(o, n)| *o += share * n);
            }
        }
        out
    }
}

/// Index of the node before a value and the fraction to the next; clamped to the nodes.
fn between(nodes: &[f32], value: f32) -> (usize, f32) {
    let after = nodes.partition_point(|n| *n <= value);
    if after == 0 {
        return (0, 0.0);
    }
    if after == nodes.len() {
        return (after - 1, 0.0);
    }
    let (low, high) = (nodes[after - 1], nodes[after]);
    (after - 1, (value - low) / (high - low))
}

/// Vertices that an expression moves at some node.
fn moved(rest: &[Vec<Vec2>], nodes: &[Vec<Vec2>]) -> Vec<u32> {
    let moves = |v: usize| {
        let mut both = rest.iter().zip(nodes);
        both.any(|(a, b)| (a[v] - b[v]).abs().max_element() > STILL_PX)
    };
    let count = rest.first().map_or(0, Vec::len);
    (0..count).filter(|v| moves(*v)).map(|v| v as u32).collect()
}

/// Matrix to be reduced: a row for each node and axis; vertices at rest, then the offsets of each
/// expression. The mean of the rest columns of each row is returned separately.
fn rows(samples: &Samples, moved: &[Vec<u32>]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut offsets = Vec::new();
    let mut rows = Vec::new();
    for (node, rest) in samples.rest.iter().enumerate() {
        for axis in 0..2 {
            let value = |p: &Vec2| f64::from(p[axis]);
            let mean = rest.iter().map(value).sum::<f64>() / rest.len().max(1) as f64;
            let mut row: Vec<f64> = rest.iter().map(|p| value(p) - mean).collect();
            for ((_, nodes), vertices) in samples.expressions.iter().zip(moved) {
                let offset = |v: &u32| {
                    let v = *v as usize;
                    value(&nodes[node][v]) - value(&rest[v])
                };
                row.extend(vertices.iter().map(offset));
            }
            offsets.push(mean);
            rows.push(row);
        }
    }
    (offsets, rows)
}

/// Ranges of columns: rest, then each expression.
fn groups(vertices: usize, moved: &[Vec<u32>]) -> Vec<std::ops::Range<usize>> {
    let mut at = 0;
    let mut range = |length: usize| {
        at += length;
        at - length..at
    };
    let mut out = vec![range(vertices)];
    out.extend(moved.iter().map(|m| range(m.len())));
    out
}

/// For each mode the coefficient of each column.
fn project_rows(rows: &[Vec<f64>], modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let project = |mode: &Vec<f64>| {
        let mut out = vec![0.0; rows.first().map_or(0, Vec::len)];
        for (row, share) in rows.iter().zip(mode) {
            out.iter_mut().zip(row).for_each(|(o, r)| *o += share * r);
        }
        out
    };
    modes.iter().map(project).collect()
}

/// Minimum number of modes that keeps the errors of every group within the tolerance.
fn fewest(
    rows: &[Vec<f64>],
    modes: &[Vec<f64>],
    columns: &[Vec<f64>],
    groups: &[std::ops::Range<usize>],
    tolerance: f64,
) -> usize {
    let mut left = rows.to_vec();
    for (rank, (mode, column)) in modes.iter().zip(columns).enumerate() {
        for (row, share) in left.iter_mut().zip(mode) {
            row.iter_mut()
                .zip(column)
                .for_each(|(l, c)| *l -= share * c);
        }
        if groups.iter().all(|group| fits(&left, group, tolerance)) {
            return rank + 1;
        }
    }
    modes.len()
}

/// Whether what is left of a group of columns is within the tolerance.
fn fits(left: &[Vec<f64>], group: &std::ops::Range<usize>, tolerance: f64) -> bool {
    let all = || left.iter().flat_map(|row| &row[group.clone()]);
    let count = left.len() * group.len();
    let squares: f64 = all().map(|e| e * e).sum();
    let greatest = all().fold(0.0f64, |most, e| most.max(e.abs()));
    squares <= tolerance * tolerance * count as f64 && greatest <= GREATEST * tolerance
}

fn step(values: &[f64], most: f64) -> f64 {
    let greatest = values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if greatest > 0.0 { greatest / most } else { 1.0 }
}

fn quantise_wide(values: &[f64]) -> Quantised<i16> {
    let scale = step(values, f64::from(i16::MAX)) as f32;
    let to = |v: &f64| (v / f64::from(scale)).round() as i16;
    Quantised {
        scale,
        steps: values.iter().map(to).collect(),
    }
}

fn quantise_narrow(values: &[f64]) -> Quantised<i8> {
    let scale = step(values, f64::from(i8::MAX)) as f32;
    let to = |v: &f64| (v / f64::from(scale)).round() as i8;
    Quantised {
        scale,
        steps: values.iter().map(to).collect(),
    }
}
