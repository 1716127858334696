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
use clusters::clusters;
use cost::Costs;
use item::items;
use regroup::regrouped;
use runs::cheapest;

/// Number of times that the painting order is changed for runs that were found.
const ROUNDS: usize = 3;

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
    /// Finds motions for layers, back to front, and changes their order where that shows the same
    /// samples; orders of several epochs stay as they are.
    ///
    /// O(motions x layers x frames) per round; few rounds.
    pub(crate) fn of(
        clip: &PlanarClip,
        painting: &Painting,
        layers: &[Layer],
        overlaps: &Overlaps,
        pos_tol_px: f32,
    ) -> Self {
        let items = items(clip, layers, pos_tol_px);
        let motions = clusters(&items, clip.frames.len());
        let costs = Costs::new(&items, &motions);
        let mut order: Vec<usize> = (0..layers.len()).collect();
        let mut of_layer = if let [_] = &painting.epochs[..] {
            let before = pairs(layers, overlaps);
            let mut wanted = costs.best();
            for _ in 0..ROUNDS {
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
        Self {
            painting,
            of_layer: order.iter().map(|l| of_layer[*l]).collect(),
            layers,
            motions,
        }
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
