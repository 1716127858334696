//! Edges at which keyed outlines leave a gap, and the room that corners have without one.
//!
//! Source: `docs/methods/vector.md` 7. Along an edge the triangle that is painted first reaches under the
//! other (`underlap`). What the errors of both corners at an end of the edge take from that must leave some
//! of it.

use super::clip::PlanarClip;
use super::keyed_clip::{GRID, KeyedTrack};
use super::neighbours::{Neighbours, faces_viewer, outward};
use super::order::Layer;
use super::shared_motion::Placed;
use super::tunnel::LEAST_REACH;
use glam::{DVec2, Vec2};
use std::collections::BTreeSet;
use std::rc::Rc;

/// Distance by which a triangle has to reach under one that is painted later, so that no gap is seen between
/// them, pixels; less where it reached less before.
const NEEDED_PX: f64 = 0.4;

/// What is lost by rounding, grid steps.
const ROUNDING: f64 = 1e-6;

/// A layer with its keyed outline.
pub(super) struct Shown<'a> {
    pub(super) layer: &'a Layer,
    pub(super) outline: &'a KeyedTrack,
    /// Its motion by frame; empty if it has none.
    pub(super) motion: Rc<[Placed]>,
}

impl Shown<'_> {
    fn placed(&self, frame: usize) -> Placed {
        self.motion.get(frame).copied().unwrap_or(Placed::STILL)
    }

    /// Corners on the picture, grid steps.
    pub(super) fn corners(&self, frame: usize) -> [DVec2; 3] {
        let at = self.outline.at(frame as f64);
        let placed = self.placed(frame);
        std::array::from_fn(|i| placed.to_picture(DVec2::new(at[2 * i], at[2 * i + 1])))
    }
}

/// Bounds of the coordinates of each layer in each frame, as [`super::tunnel::Windows`] takes them.
pub(super) struct Bounds {
    rows: Vec<Vec<[f64; 2]>>,
}

impl Bounds {
    pub(super) fn new(layers: usize) -> Self {
        Self {
            rows: vec![Vec::new(); layers],
        }
    }

    /// Bounds of a layer; empty where it has none.
    pub(super) fn of(&self, layer: usize) -> &[[f64; 2]] {
        &self.rows[layer]
    }

    /// Keeps a corner of a layer from being off its target by more than a distance in a direction.
    /// Returns whether that is less than before.
    fn keep(&mut self, layer: usize, frames: usize, at: usize, way: DVec2, most: f64) -> bool {
        let row = &mut self.rows[layer];
        row.resize(6 * frames, [f64::INFINITY; 2]);
        let most = (most / (way.x.abs() + way.y.abs()).max(1e-9)).max(LEAST_REACH);
        let mut is_less = false;
        for (n, along) in way.to_array().into_iter().enumerate() {
            let bound = &mut row[at + n][usize::from(along > 0.0)];
            if along.abs() > ROUNDING && *bound > most + ROUNDING {
                *bound = most;
                is_less = true;
            }
        }
        is_less
    }
}

/// An edge between two triangles; corners are those at its start and its end.
struct EdgePair {
    triangles: [usize; 2],
    corners: [[usize; 2]; 2],
}

/// All edges of a clip that two triangles have.
pub(super) struct EdgePairs {
    pairs: Vec<EdgePair>,
}

impl EdgePairs {
    pub(super) fn of(clip: &PlanarClip) -> Self {
        let neighbours = Neighbours::new(clip);
        let edges = (0..clip.triangles.len()).flat_map(|t| [(t, 0), (t, 1), (t, 2)]);
        let pairs = edges.flat_map(|(t, e)| {
            let later = neighbours.across(t, e).iter();
            let later = later.filter(move |n| n.triangle as usize > t);
            // The neighbour has the opposite direction: its edge ends where this one starts.
            later.map(move |n| EdgePair {
                triangles: [t, n.triangle as usize],
                corners: [
                    [e, (e + 1) % 3],
                    [(n.apex as usize + 2) % 3, (n.apex as usize + 1) % 3],
                ],
            })
        });
        Self {
            pairs: pairs.collect(),
        }
    }

    /// Bounds the corners at edges where outlines leave a gap. Returns the layers that have less room than
    /// before.
    ///
    /// O(frames x edges).
    pub(super) fn narrow(
        &self,
        clip: &PlanarClip,
        sealed: &[Vec<[Vec2; 3]>],
        shown: &[Shown<'_>],
        bounds: &mut Bounds,
    ) -> BTreeSet<usize> {
        let mut narrowed = BTreeSet::new();
        for (f, layers) in layers_by_frame(clip, shown).iter().enumerate() {
            let frame = Frame::new((clip, &sealed[f]), f, shown, layers);
            for pair in &self.pairs {
                for gap in frame.gaps(pair).into_iter().flatten().flatten() {
                    let way = shown[gap.layer].placed(f).direction_in_shape(gap.way);
                    let at = 6 * f + 2 * gap.corner;
                    if bounds.keep(gap.layer, clip.frames.len(), at, way, gap.most) {
                        narrowed.insert(gap.layer);
                    }
                }
            }
        }
        narrowed
    }
}

/// A corner that is too far off its target.
struct Gap {
    layer: usize,
    corner: usize,
    /// Direction on the picture in which it is off.
    way: DVec2,
    /// How far it may be off, grid steps.
    most: f64,
}

/// What a frame shows of each triangle.
struct Frame<'a> {
    clip: &'a PlanarClip,
    frame: usize,
    /// Corners after sealing, pixels.
    sealed: &'a [[Vec2; 3]],
    /// Layer and keyed corners of triangles that are shown and face the viewer, grid steps.
    keyed: Vec<Option<(usize, [DVec2; 3])>>,
}

impl<'a> Frame<'a> {
    fn new(
        (clip, sealed): (&'a PlanarClip, &'a [[Vec2; 3]]),
        frame: usize,
        shown: &[Shown<'_>],
        layers: &[usize],
    ) -> Self {
        let mut keyed = vec![None; clip.triangles.len()];
        for l in layers {
            let t = shown[*l].layer.triangle as usize;
            if faces_viewer(&clip.places(frame, t)) {
                keyed[t] = Some((*l, shown[*l].corners(frame)));
            }
        }
        Self {
            clip,
            frame,
            sealed,
            keyed,
        }
    }

    /// Corners that leave a gap at the start and the end of an edge, of the first and the second of its
    /// triangles to be painted.
    fn gaps(&self, pair: &EdgePair) -> [[Option<Gap>; 2]; 2] {
        let layer = |side: usize| self.keyed[pair.triangles[side]].map(|(layer, _)| layer);
        let (Some(a), Some(b)) = (layer(0), layer(1)) else {
            return Default::default();
        };
        let sides = if a < b { [0, 1] } else { [1, 0] };
        let places = self.clip.places(self.frame, pair.triangles[0]);
        let normal = outward(&places, pair.corners[0][0]).as_dvec2();
        let normal = if a < b { normal } else { -normal };
        [0, 1].map(|end| self.gaps_at(pair, end, sides, normal))
    }

    /// The same at one end of the edge; `normal` points from the triangle that is painted first.
    fn gaps_at(
        &self,
        pair: &EdgePair,
        end: usize,
        sides: [usize; 2],
        normal: DVec2,
    ) -> [Option<Gap>; 2] {
        let ways = [-normal, normal];
        let corners = sides.map(|side| (pair.triangles[side], pair.corners[side][end]));
        let wanted = corners.map(|(t, c)| self.sealed[t][c].as_dvec2() * f64::from(GRID));
        let over = normal.dot(wanted[0] - wanted[1]);
        let room = (over - f64::from(GRID) * NEEDED_PX).max(0.0);
        let off = [0, 1].map(|i| {
            let (t, c) = corners[i];
            self.keyed[t].map_or(0.0, |(_, keyed)| ways[i].dot(keyed[c] - wanted[i]))
        });
        if off[0] + off[1] <= room + ROUNDING {
            return Default::default();
        }
        // Each has half of the room, and what the other leaves.
        let most = [1, 0].map(|other: usize| (room / 2.0).max(room - off[other]));
        [0, 1].map(|i| {
            let (t, corner) = corners[i];
            let (layer, _) = self.keyed[t].filter(|_| off[i] > most[i] + ROUNDING)?;
            Some(Gap {
                layer,
                corner,
                way: ways[i],
                most: most[i],
            })
        })
    }
}

/// Layers that are shown in each frame.
fn layers_by_frame(clip: &PlanarClip, shown: &[Shown<'_>]) -> Vec<Vec<usize>> {
    let mut by_frame = vec![Vec::new(); clip.frames.len()];
    for (l, shown) in shown.iter().enumerate() {
        for f in shown.layer.frames.iter().cloned().flatten() {
            by_frame[f].push(l);
        }
    }
    by_frame
}
