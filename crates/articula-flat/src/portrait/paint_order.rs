//! The order in which triangles are painted, back to front, for a range of turns.
//!
//! Source: `spec/vector.md` part 4: where the visible triangle b covers triangle a, a comes
//! before b, weighted by the samples of some poses of the range; a triangle that no longer waits
//! for others is painted next, and in a cycle the one that loses the fewest samples. Ties go far
//! to near.

use super::error::PortraitError;
use super::flat_mesh::{FlatMesh, corners_of};
use super::posing::{Poser, places, project};
use super::source::HeadPose;
use crate::item_buffer::{Faces, ItemBuffer, Samples};
use articula_core::view::Camera;
use glam::Vec4;
use std::collections::{BTreeMap, BTreeSet};

/// An order for turns from one angle on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sector {
    /// Least turn of the range, degrees; the first sector holds below it too.
    pub from_yaw_degrees: f32,
    /// Triangles, back to front.
    pub order: Vec<u32>,
}

/// A pose and the weights that are not zero.
pub(crate) type Probe = (HeadPose, Vec<(usize, f32)>);

/// Who covers whom: samples where the second is seen before the first.
#[derive(Default)]
struct Covers {
    samples: BTreeMap<(u32, u32), u32>,
    depth: Vec<f64>,
}

/// The order of one range of turns, told by some poses of it.
pub(crate) fn sector(
    flat: &FlatMesh,
    poser: &Poser<'_>,
    camera: &Camera,
    from_yaw_degrees: f32,
    probes: &[Probe],
) -> Result<Sector, PortraitError> {
    let mut covers = Covers {
        depth: vec![0.0; flat.triangles.len()],
        ..Covers::default()
    };
    for (pose, weights) in probes {
        let corners = project(&poser.skin(*pose, weights), camera, *pose)?;
        covers.add(flat, &corners, camera)?;
    }
    Ok(Sector {
        from_yaw_degrees,
        order: covers.order(),
    })
}

impl Covers {
    fn add(
        &mut self,
        flat: &FlatMesh,
        corners: &[Vec4],
        camera: &Camera,
    ) -> Result<(), PortraitError> {
        let viewport = camera.viewport;
        let size = (viewport.width_px.round() as u32, viewport.height_px.round() as u32);
        let mut buffer = ItemBuffer::new(size.0, size.1, Samples::One)?;
        let mut alone = buffer.clone();
        let places = places(corners);
        let of = |t: usize| flat.triangles[t].map(|v| corners[v as usize]);
        let shows = |t: &usize| flat.shows(*t, corners_of(&places, flat.triangles[*t]));
        let drawn: Vec<usize> = (0..flat.triangles.len()).filter(shows).collect();
        for &t in &drawn {
            buffer.draw(t as u32, of(t), Faces::Both);
        }
        for (t, depth) in self.depth.iter_mut().enumerate() {
            *depth += of(t).iter().map(|c| f64::from(c.w)).sum::<f64>();
        }
        for &t in &drawn {
            let samples = &mut self.samples;
            alone.draw_where(t as u32, of(t), Faces::Both, |at| {
                match buffer.item(at.x as u32, at.y as u32) {
                    Some(seen) if seen as usize != t => {
                        *samples.entry((t as u32, seen)).or_default() += 1;
                    }
                    _ => {}
                }
                false
            });
        }
        Ok(())
    }

    /// Back to front, as few samples as possible on the wrong side.
    fn order(&self) -> Vec<u32> {
        let count = self.depth.len();
        let mut rank: Vec<usize> = (0..count).collect();
        rank.sort_by(|a, b| self.depth[*b].total_cmp(&self.depth[*a]).then(a.cmp(b)));
        let mut place = vec![0; count];
        for (i, t) in rank.iter().enumerate() {
            place[*t] = i;
        }
        // What a triangle waits for, net of what waits for it the other way round.
        let mut waits = vec![0i64; count];
        let mut above: Vec<Vec<(u32, i64)>> = vec![Vec::new(); count];
        for ((below, over), samples) in &self.samples {
            waits[*over as usize] += i64::from(*samples);
            above[*below as usize].push((*over, i64::from(*samples)));
        }
        let key = |t: usize, waits: &[i64]| (waits[t], place[t], t);
        let mut left: BTreeSet<_> = (0..count).map(|t| key(t, &waits)).collect();
        let mut order = Vec::with_capacity(count);
        let mut done = vec![false; count];
        while let Some((_, _, t)) = left.pop_first() {
            order.push(t as u32);
            done[t] = true;
            for (over, samples) in &above[t] {
                let over = *over as usize;
                if !done[over] {
                    left.remove(&key(over, &waits));
                    waits[over] -= samples;
                    left.insert(key(over, &waits));
                }
            }
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covers(pairs: &[(u32, u32, u32)], depth: &[f64]) -> Covers {
        Covers {
            samples: pairs.iter().map(|(a, b, n)| ((*a, *b), *n)).collect(),
            depth: depth.to_vec(),
        }
    }

    #[test]
    fn constraints_beat_depth_and_depth_breaks_ties() {
        // 0 is the farthest by its middle and yet covers 1.
        let found = covers(&[(1, 0, 5)], &[9.0, 5.0, 7.0]).order();
        assert_eq!(found, [2, 1, 0]);
        assert_eq!(covers(&[], &[1.0, 3.0, 2.0]).order(), [1, 2, 0]);
    }

    #[test]
    fn a_cycle_is_cut_where_it_costs_least() {
        // 0 below 1 below 2 below 0; the last for two samples only.
        let found = covers(&[(0, 1, 9), (1, 2, 8), (2, 0, 2)], &[1.0; 3]).order();
        assert_eq!(found, [0, 1, 2]);
    }
}
