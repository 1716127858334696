//! Motions that many shapes share: each shape is described relative to the motion that it follows, so
//! that what moves with others needs no keys of its own.
//!
//! Source: `docs/methods/vector.md` 7. A motion is an affine map per frame, fitted to the corners of all
//! triangles that follow it (`fit`); triangles follow the motion that leaves them the fewest bytes
//! (`clusters`, `cost`). The painting order is changed where that changes no sample, so that triangles of
//! one motion come one after the other (`regroup`), and runs of shapes are given motions such that the
//! shapes' keys and the motions together take the fewest bytes (`runs`).

mod clusters;
mod cost;
mod fit;
mod item;
mod placed;
mod regroup;
mod runs;

pub(crate) use placed::Placed;

use super::clip::PlanarClip;
use super::keyed_motion::KeyedMotion;
use super::order::{Epoch, Layer, Overlaps, Painting};
use articula_core::{Cancelled, Progress};
use clusters::clusters;
use cost::Costs;
use item::items;
use regroup::regrouped;
use runs::cheapest;

/// Number of times that the painting order is changed for runs that were found.
const ROUNDS: usize = 6;
/// Most layers times frames for which motions are looked for: some seconds' work.
const MOST: usize = 1 << 21;

/// Layers and the motions that they share.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SharedMotions {
    /// Painting order of the layers.
    pub painting: Painting,
    /// The layers, back to front.
    pub layers: Vec<Layer>,
    /// The motions.
    pub motions: Vec<KeyedMotion>,
    /// For each layer the index of its motion; `None` if it follows none.
    pub of_layer: Vec<Option<u32>>,
}

impl SharedMotions {
    /// No motions.
    pub(crate) fn none(painting: &Painting, layers: &[Layer]) -> Self {
        Self {
            painting: painting.clone(),
            layers: layers.to_vec(),
            motions: Vec::new(),
            of_layer: vec![None; layers.len()],
        }
    }

    /// Finds motions for layers, back to front, and changes their order where that shows the same
    /// samples; orders of several epochs stay as they are. A clip of more than two million layers and frames
    /// gets none.
    ///
    /// O(motions x layers x frames + runs x pairs of layers that share a sample) per round; few rounds.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn of(
        (clip, painting, layers, overlaps): (&PlanarClip, &Painting, &[Layer], &Overlaps),
        pos_tol_px: f32,
        progress: &mut Progress<'_>,
    ) -> Result<Self, Cancelled> {
        if layers.len().saturating_mul(clip.frames.len()) > MOST {
            return Ok(Self::none(painting, layers));
        }
        let items = items(clip, layers, pos_tol_px);
        let motions = clusters(&items, clip.frames.len(), &mut progress.part(0.0, 0.8))?;
        let costs = Costs::new(&items, &motions, &mut progress.part(0.8, 0.9))?;
        let mut order: Vec<usize> = (0..layers.len()).collect();
        let mut of_layer = if let [_] = &painting.epochs[..] {
            let before = pairs(layers, overlaps);
            let mut wanted = costs.best();
            for round in 0..ROUNDS {
                progress.step(0.9 + 0.1 * round as f32 / ROUNDS as f32)?;
                order = regrouped(&order, &before, &wanted);
                wanted = cheapest(&costs, &order);
            }
            wanted
        } else {
            cheapest(&costs, &order)
        };
        let motions = used(motions, &mut of_layer);
        let layers: Vec<Layer> = order.iter().map(|l| layers[*l].clone()).collect();
        let painting = match &painting.epochs[..] {
            [only] => Painting {
                epochs: vec![Epoch {
                    frames: only.frames.clone(),
                    order: layers.iter().map(|l| l.triangle).collect(),
                }],
            },
            _ => painting.clone(),
        };
        Ok(Self {
            painting,
            of_layer: order.iter().map(|l| of_layer[*l]).collect(),
            layers,
            motions,
        })
    }
}

/// Pairs of layers that share a sample which the second owns, in each order; one layer per triangle.
fn pairs(layers: &[Layer], overlaps: &Overlaps) -> Vec<(usize, usize)> {
    let most = layers.iter().map(|l| l.triangle as usize + 1).max();
    let mut layer_of = vec![None; most.unwrap_or(0)];
    for (l, layer) in layers.iter().enumerate() {
        layer_of[layer.triangle as usize] = Some(l);
    }
    let layer = |t: u32| layer_of.get(t as usize).copied().flatten();
    let mut pairs = Vec::new();
    for set in 0..overlaps.sets() {
        let [owner, others @ ..] = overlaps.members(set) else {
            continue;
        };
        let Some(owner) = layer(*owner) else {
            continue;
        };
        let others = others.iter().filter_map(|t| layer(*t));
        pairs.extend(others.map(|other| (owner.min(other), owner.max(other))));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Leaves out motions that no layer follows.
fn used(motions: Vec<KeyedMotion>, of_layer: &mut [Option<u32>]) -> Vec<KeyedMotion> {
    let mut is_used = vec![false; motions.len()];
    for motion in of_layer.iter().flatten() {
        is_used[*motion as usize] = true;
    }
    let mut place = 0;
    let places: Vec<u32> = is_used
        .iter()
        .map(|is_used| {
            place += u32::from(*is_used);
            place.saturating_sub(1)
        })
        .collect();
    for motion in of_layer.iter_mut().flatten() {
        *motion = places[*motion as usize];
    }
    let kept = motions.into_iter().zip(is_used);
    kept.filter_map(|(motion, is_used)| is_used.then_some(motion))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::Drawn;
    use crate::planar::clip::fixture;
    use crate::planar::order::Painting;
    use glam::Vec2;
    use std::ops::ControlFlow;

    /// Sixteen small triangles on each of two plates that swing about their own points; the plates
    /// alternate in the clip.
    fn swinging(frames: usize) -> PlanarClip {
        let corners = |i: usize| {
            let (plate, n) = (i % 2, i / 2);
            let x = 40.0 + 120.0 * plate as f32 + 8.0 * (n % 4) as f32;
            let y = 40.0 + 8.0 * (n / 4) as f32;
            [[x, y, 0.5], [x, y + 6.0, 0.5], [x + 6.0, y, 0.5]]
        };
        let all: Vec<_> = (0..32)
            .map(|i| (corners(i), [i as u8 * 7, 90, 40]))
            .collect();
        let mut clip = PlanarClip {
            width: 220,
            height: 120,
            ..fixture::loose(&all, frames)
        };
        for (f, frame) in clip.frames.iter_mut().enumerate() {
            let angle = 0.6 * (f as f32 / frames as f32 * std::f32::consts::TAU).sin();
            for (v, place) in frame.xy.iter_mut().enumerate() {
                let plate = v / 3 % 2;
                let pivot = Vec2::new(55.0 + 120.0 * plate as f32, 30.0);
                let turn = if plate == 0 { angle } else { -1.3 * angle };
                *place = pivot + Vec2::from_angle(turn).rotate(*place - pivot);
            }
        }
        for (t, part) in clip.part.iter_mut().enumerate() {
            *part = (t % 2) as u16;
        }
        clip
    }

    fn within(
        clip: &PlanarClip,
        pos_tol_px: f32,
        progress: &mut Progress<'_>,
    ) -> Result<SharedMotions, Cancelled> {
        let drawn = Drawn::of(clip).unwrap();
        let painting = Painting::single(clip, &drawn).unwrap();
        let overlaps = Overlaps::of(clip, &drawn).unwrap();
        let layers = painting.layers(&drawn);
        SharedMotions::of((clip, &painting, &layers, &overlaps), pos_tol_px, progress)
    }

    fn shared(clip: &PlanarClip) -> SharedMotions {
        within(clip, 0.5, &mut Progress::none()).unwrap()
    }

    #[test]
    fn two_plates_are_two_motions_that_leave_nothing_to_move() {
        let clip = swinging(40);
        let shared = shared(&clip);
        assert_eq!(shared.motions.len(), 2);
        let plates: Vec<u32> = shared.layers.iter().map(|l| l.triangle % 2).collect();
        // Each plate in one run.
        assert_eq!(plates.chunk_by(|a, b| a == b).count(), 2, "{plates:?}");
        for (layer, motion) in shared.layers.iter().zip(&shared.of_layer) {
            let motion = &shared.motions[motion.unwrap() as usize];
            let placed = Placed::of(motion, clip.frames.len());
            let corner = |f: usize| {
                let place = clip.places(f, layer.triangle as usize)[0].as_dvec2() * 4.0;
                placed[f].to_shape(place)
            };
            // Half a pixel is two grid steps.
            let off = (1..40)
                .map(|f| corner(f).distance(corner(0)))
                .fold(0.0, f64::max);
            assert!(off < 2.0, "triangle {}: {off}", layer.triangle);
        }
    }

    #[test]
    fn what_lies_over_the_other_plate_keeps_its_place_in_the_order() {
        let mut clip = swinging(12);
        // The last triangle is behind all others.
        for frame in &mut clip.frames {
            for (corner, to) in [[-90.0, -90.0], [-90.0, 690.0], [690.0, -90.0]]
                .into_iter()
                .enumerate()
            {
                frame.xy[93 + corner] = Vec2::from(to);
                frame.nearness[93 + corner] = 0.1;
            }
        }
        let shared = shared(&clip);
        assert_eq!(shared.layers[0].triangle, 31);
        let drawn = Drawn::of(&clip).unwrap();
        let before = Painting::single(&clip, &drawn).unwrap();
        let overlaps = Overlaps::of(&clip, &drawn).unwrap();
        assert_eq!(overlaps.wrong(&shared.painting), overlaps.wrong(&before));
    }

    #[test]
    fn a_wheel_that_turns_too_often_for_a_file_has_no_motion() {
        let mut clip = swinging(400);
        for (f, frame) in clip.frames.iter_mut().enumerate() {
            for (v, place) in frame.xy.iter_mut().enumerate() {
                let pivot = Vec2::new(55.0 + 120.0 * (v / 3 % 2) as f32, 60.0);
                *place = pivot + Vec2::from_angle(0.7 * f as f32).rotate(*place - pivot);
            }
        }
        let shared = shared(&clip);
        assert!(shared.motions.iter().all(|m| m.check(400).is_ok()));
    }

    #[test]
    fn shapes_whose_grid_would_be_coarser_than_the_tolerance_follow_no_motion() {
        // Half a grid step, which a turned grid exceeds.
        let shared = within(&swinging(40), 0.125, &mut Progress::none()).unwrap();
        assert!(shared.motions.is_empty());
    }

    #[test]
    fn a_listener_hears_of_every_part_and_may_end_it() {
        let clip = swinging(40);
        let mut heard = Vec::new();
        let mut hook = |done| {
            heard.push(done);
            ControlFlow::Continue(())
        };
        within(&clip, 0.5, &mut Progress::new(&mut hook)).unwrap();
        assert!(heard.is_sorted(), "{heard:?}");
        assert!(heard.iter().all(|done| (0.0..=1.0).contains(done)));
        // Nothing takes longer than a tenth of the whole without a word.
        let longest = heard.windows(2).map(|pair| pair[1] - pair[0]);
        assert!(longest.fold(heard[0], f32::max) < 0.1, "{heard:?}");
        for most in [0.0, 0.3, 0.7, 0.95] {
            let mut hook = |done: f32| match done <= most {
                true => ControlFlow::Continue(()),
                false => ControlFlow::Break(()),
            };
            let ended = within(&clip, 0.5, &mut Progress::new(&mut hook));
            assert_eq!(ended, Err(Cancelled));
        }
    }

    #[test]
    fn a_clip_that_does_not_move_has_no_motions() {
        let mut clip = swinging(9);
        let first = clip.frames[0].clone();
        clip.frames.fill(first);
        let shared = shared(&clip);
        assert!(shared.motions.is_empty());
        assert!(shared.of_layer.iter().all(Option::is_none));
        let one = swinging(1);
        let overlaps = Overlaps::of(&one, &Drawn::of(&one).unwrap()).unwrap();
        let none = Painting { epochs: vec![] };
        let subject = (&one, &none, &[][..], &overlaps);
        let nothing = SharedMotions::of(subject, 0.5, &mut Progress::none()).unwrap();
        assert!(nothing.motions.is_empty() && nothing.layers.is_empty());
    }
}
