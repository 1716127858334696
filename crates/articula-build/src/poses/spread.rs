//! Farthest-point sampling: each selected pose is the farthest from all selected before.

use super::PoseOptions;
use super::candidates::Candidates;
use super::shape::Shape;
use super::skin_pose::SkinPose;

/// The poses selected so far.
#[derive(Debug)]
pub(super) struct Picked {
    /// Shapes that further poses must differ from.
    pub(super) known: Vec<Shape>,
    /// Distance below which two poses count as one.
    pub(super) min_metres: f32,
    /// Minimum distance of a measuring pose to the poses selected before.
    pub(super) separation_metres: f32,
}

impl Picked {
    pub(super) fn new(opts: &PoseOptions) -> Self {
        Self {
            known: Vec::with_capacity(1 + opts.shaping + opts.morphs),
            min_metres: 0.0,
            separation_metres: f32::INFINITY,
        }
    }

    /// Selects the pose farthest from all known ones, `count` times or until all remaining ones
    /// equal a known one.
    pub(super) fn farthest(&mut self, from: &Candidates, count: usize) -> Vec<SkinPose> {
        let mut nearest = self.nearest(from);
        let mut poses = Vec::new();
        while poses.len() < count {
            let Some(best) = greatest(&nearest, |i| nearest[i] >= self.min_metres) else {
                break;
            };
            let picked = &from.list[best];
            approach(&mut nearest, from, &picked.shape);
            self.known.push(picked.shape.clone());
            poses.push(picked.pose.clone());
        }
        poses
    }

    /// Selects poses that differ from all known ones: each time the farthest one of the groups with
    /// the fewest so far.
    pub(super) fn held_out(&mut self, from: &Candidates, count: usize) -> Vec<SkinPose> {
        let known = self.nearest(from);
        let is_new = |i: usize| known[i] >= self.min_metres;
        let mut nearest = known.clone();
        let mut taken = vec![false; known.len()];
        let mut of_group = vec![0usize; from.groups()];
        let mut poses = Vec::new();
        while poses.len() < count {
            let open = |i: &usize| is_new(*i) && !taken[*i];
            let groups = (0..known.len()).filter(open).map(|i| from.list[i].group);
            let Some(fewest) = groups.map(|g| of_group[g]).min() else {
                break;
            };
            let fits = |i: usize| open(&i) && of_group[from.list[i].group] == fewest;
            let Some(best) = greatest(&nearest, fits) else {
                break;
            };
            let picked = &from.list[best];
            approach(&mut nearest, from, &picked.shape);
            taken[best] = true;
            of_group[picked.group] += 1;
            self.separation_metres = self.separation_metres.min(known[best]);
            poses.push(picked.pose.clone());
        }
        poses
    }

    /// Distance of each candidate to the nearest known shape.
    fn nearest(&self, from: &Candidates) -> Vec<f32> {
        let mut nearest = vec![f32::INFINITY; from.list.len()];
        for shape in &self.known {
            approach(&mut nearest, from, shape);
        }
        nearest
    }
}

fn approach(nearest: &mut [f32], from: &Candidates, shape: &Shape) {
    for (near, candidate) in nearest.iter_mut().zip(&from.list) {
        *near = near.min(shape.separation_metres(&candidate.shape));
    }
}

/// Index of the maximum among those that fit; the first of equal ones.
fn greatest(values: &[f32], fits: impl Fn(usize) -> bool) -> Option<usize> {
    (0..values.len())
        .filter(|i| fits(*i))
        .reduce(|a, b| if values[b] > values[a] { b } else { a })
}
