//! Outlines of shapes as few keys, within a tolerance, without gaps between neighbours.
//!
//! Source: `docs/methods/vector.md` 7. Shapes are keyed one by one, so that both sides of an edge may be off
//! in opposite directions, by more than sealing covers (`open_edges`). Where that opens a gap in some frame,
//! the two corners have less room in that frame, and their shapes are keyed again.

use super::clip::PlanarClip;
use super::keyed_clip::{GRID, KeyedTrack};
use super::keyed_motion::KeyedMotion;
use super::open_edges::{Bounds, EdgePairs, Shown};
use super::order::Layer;
use super::shared_motion::Placed;
use super::tunnel::{Windows, fewest_keys};
use articula_core::{Cancelled, Progress};
use glam::Vec2;
use std::ops::Range;
use std::rc::Rc;

/// Number of times that gaps are looked for: closing one may open another.
const ROUNDS: usize = 4;

/// Target positions of a layer's corners in the coordinates of its shape, with tolerances.
pub(super) struct Wish {
    /// Target x and y of each point for each frame, grid steps.
    targets: Vec<f64>,
    /// Tolerance in each frame, grid steps; infinite where the position is irrelevant.
    pub(super) reach: Vec<f64>,
    pub(super) is_shown: Vec<bool>,
    /// Motion of the shape by frame; empty if it has none.
    motion: Rc<[Placed]>,
}

impl Wish {
    pub(super) fn motion(&self, frame: usize) -> Placed {
        self.motion.get(frame).copied().unwrap_or(Placed::STILL)
    }

    fn width(&self) -> usize {
        self.targets.len() / self.reach.len().max(1)
    }

    pub(super) fn row(&self, frame: usize) -> &[f64] {
        &self.targets[frame * self.width()..(frame + 1) * self.width()]
    }

    /// The fewest keys within the tolerance and some bounds.
    pub(super) fn keyed(&self, bounds: &[[f64; 2]]) -> KeyedTrack {
        fewest_keys(&Windows {
            targets: &self.targets,
            width: self.width(),
            reach: &self.reach,
            bounds,
        })
    }
}

/// Points of a shape by frame, pixels.
pub(super) struct Outline<'a> {
    /// Points after sealing.
    pub(super) sealed: &'a dyn Fn(usize) -> Vec<Vec2>,
    /// Points of the clip.
    pub(super) places: &'a dyn Fn(usize) -> Vec<Vec2>,
}

/// Position in grid steps.
pub(super) fn on_grid(place: Vec2) -> [f64; 2] {
    [place.x, place.y].map(|v| f64::from(v) * f64::from(GRID))
}

/// What outlines are made from.
pub(super) struct Outlines<'a> {
    pub(super) clip: &'a PlanarClip,
    /// The corners of every triangle in every frame after sealing, pixels.
    pub(super) sealed: &'a [Vec<[Vec2; 3]>],
    /// Each motion by frame.
    placed: Vec<Rc<[Placed]>>,
    /// Tolerance of positions, grid steps.
    tolerance: f64,
}

impl<'a> Outlines<'a> {
    pub(super) fn new(
        clip: &'a PlanarClip,
        sealed: &'a [Vec<[Vec2; 3]>],
        motions: &[KeyedMotion],
        pos_tol_px: f32,
    ) -> Self {
        let frames = clip.frames.len();
        let placed = motions.iter().map(|m| Placed::of(m, frames).into());
        Self {
            clip,
            sealed,
            placed: placed.collect(),
            tolerance: f64::from(pos_tol_px) * f64::from(GRID),
        }
    }

    /// Outlines of layers with the motions that they follow.
    ///
    /// O(layers x frames x longest segment).
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn closed(
        &self,
        layers: &[(&Layer, Option<u32>)],
        progress: &mut Progress<'_>,
    ) -> Result<Vec<KeyedTrack>, Cancelled> {
        let wish = |l: usize| self.of_layer(layers[l].0, layers[l].1);
        let mut outlines: Vec<KeyedTrack> = Vec::with_capacity(layers.len());
        for l in 0..layers.len() {
            progress.step(0.5 * l as f32 / layers.len() as f32)?;
            outlines.push(wish(l).keyed(&[]));
        }
        let mut bounds = Bounds::new(layers.len());
        let pairs = EdgePairs::of(self.clip);
        for round in 0..ROUNDS {
            progress.step(0.5 + 0.5 * round as f32 / ROUNDS as f32)?;
            let shown = |l: usize| Shown {
                layer: layers[l].0,
                outline: &outlines[l],
                motion: self.placed_of(layers[l].1),
            };
            let shown: Vec<Shown<'_>> = (0..layers.len()).map(shown).collect();
            let narrowed = pairs.narrow(self.clip, self.sealed, &shown, &mut bounds);
            if narrowed.is_empty() {
                break;
            }
            for l in narrowed {
                outlines[l] = wish(l).keyed(bounds.of(l));
            }
        }
        Ok(outlines)
    }

    fn placed_of(&self, motion: Option<u32>) -> Rc<[Placed]> {
        let placed = motion.map(|m| Rc::clone(&self.placed[m as usize]));
        placed.unwrap_or_default()
    }

    /// Targets of a layer's triangle.
    pub(super) fn of_layer(&self, layer: &Layer, motion: Option<u32>) -> Wish {
        let t = layer.triangle as usize;
        self.wish(
            &layer.frames,
            self.placed_of(motion),
            &Outline {
                sealed: &|f| self.sealed[f][t].to_vec(),
                places: &|f| self.clip.places(f, t).to_vec(),
            },
        )
    }

    /// Targets of an outline. Hidden frames have no tolerance bound; those next to shown ones have
    /// a wide one, since a shape is shown for half a frame longer.
    pub(super) fn wish(
        &self,
        shown: &[Range<usize>],
        motion: Rc<[Placed]>,
        outline: &Outline<'_>,
    ) -> Wish {
        let frames = self.clip.frames.len();
        let mut is_shown = vec![false; frames];
        for span in shown {
            is_shown[span.clone()].fill(true);
        }
        let mut wish = Wish {
            targets: Vec::new(),
            reach: Vec::with_capacity(frames),
            is_shown,
            motion,
        };
        for f in 0..frames {
            let beside = |g: usize| wish.is_shown.get(g).copied().unwrap_or(false);
            let neighbour = [f.wrapping_sub(1), f + 1].into_iter().find(|g| beside(*g));
            let mut points = (outline.sealed)(f);
            let reach = match (wish.is_shown[f], neighbour) {
                (true, _) => self.tolerance,
                (false, Some(g)) => {
                    // The sealed outline of the shown frame, moved on as the triangle moves.
                    points = (outline.sealed)(g);
                    let moves = (outline.places)(f).into_iter().zip((outline.places)(g));
                    for (point, (here, there)) in points.iter_mut().zip(moves) {
                        *point += here - there;
                    }
                    2.0 * self.tolerance
                }
                (false, None) => f64::INFINITY,
            };
            let placed = wish.motion(f);
            wish.reach.push(placed.tolerance(reach));
            let local = |point| placed.to_shape(on_grid(point).into()).to_array();
            wish.targets.extend(points.into_iter().flat_map(local));
        }
        wish
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planar::Drawn;
    use crate::planar::clip::fixture;
    use crate::planar::order::Painting;
    use crate::planar::underlap::{UnderlapOptions, seal};
    use proptest::prelude::*;

    const FRAMES: usize = 24;
    const TOLERANCE_PX: f32 = 0.5;

    /// Two triangles that share a diagonal, and a third beside the second; each corner is moved in each
    /// frame.
    fn shaken(shakes: &[(f32, f32)]) -> PlanarClip {
        let place = |x: f32, y: f32| [x, y, 0.5];
        let (nw, sw) = (place(10.0, 10.0), place(10.0, 40.0));
        let (ne, se, e) = (place(40.0, 10.0), place(40.0, 40.0), place(70.0, 30.0));
        let all = [[nw, sw, ne], [ne, sw, se], [ne, se, e]];
        let mut clip = fixture::loose(&all.map(|places| (places, [90; 3])), FRAMES);
        let corners = [nw, sw, ne, se, e];
        for (f, frame) in clip.frames.iter_mut().enumerate() {
            for xy in &mut frame.xy {
                let corner = corners.iter().position(|c| c[0] == xy.x && c[1] == xy.y);
                let (x, y) = shakes[(7 * f + corner.unwrap()) % shakes.len()];
                *xy += Vec2::new(x, y);
            }
        }
        clip
    }

    /// Turns by a third of a turn about a point of the picture, so that shapes have other axes than it.
    fn turning() -> KeyedMotion {
        KeyedMotion {
            translation: KeyedTrack::still(vec![600, 900]),
            rotation: KeyedTrack {
                frames: vec![0, FRAMES as u32 - 1],
                values: vec![0, 12_000],
                width: 1,
            },
            skew: KeyedTrack::still(vec![300]),
            scale: KeyedTrack::still(vec![10_000, 9000]),
        }
    }

    /// The least by which the second corner of an edge's end is within the first triangle, of what it
    /// should be: at most 0.4 pixels, or what sealing gives.
    fn least_of_what_is_needed(
        clip: &PlanarClip,
        sealed: &[Vec<[Vec2; 3]>],
        shown: &[Shown<'_>],
    ) -> f64 {
        // Triangle and corners of both sides of each edge, the first to be painted first.
        let edges = [((0, [1, 2]), (1, [1, 0])), ((1, [2, 0]), (2, [1, 0]))];
        let mut least = f64::INFINITY;
        for f in 0..clip.frames.len() {
            for ((a, from), (b, to)) in edges {
                let places = clip.places(f, a);
                let along = (places[from[1]] - places[from[0]]).as_dvec2().normalize();
                let normal = glam::DVec2::new(-along.y, along.x);
                for end in 0..2 {
                    let over = |p: glam::DVec2, q: glam::DVec2| normal.dot(p - q) / 4.0;
                    let wish = |t: usize, c: usize| sealed[f][t][c].as_dvec2() * 4.0;
                    let wanted = over(wish(a, from[end]), wish(b, to[end])).min(0.4);
                    let is = over(shown[a].corners(f)[from[end]], shown[b].corners(f)[to[end]]);
                    least = least.min(is - wanted);
                }
            }
        }
        least
    }

    /// With and without bounds at edges.
    fn least(clip: &PlanarClip, motions: [Option<u32>; 3]) -> [f64; 2] {
        let drawn = Drawn::of(clip).unwrap();
        let painting = Painting::single(clip, &drawn).unwrap();
        let mut layers = painting.layers(&drawn);
        layers.sort_by_key(|l| l.triangle);
        let painting = Painting {
            epochs: vec![crate::planar::Epoch {
                frames: 0..FRAMES,
                order: vec![0, 1, 2],
            }],
        };
        let sealed = seal(clip, &drawn, &painting, UnderlapOptions::default()).corners;
        let outlines = Outlines::new(clip, &sealed, &[turning()], TOLERANCE_PX);
        let layers: Vec<(&Layer, Option<u32>)> = layers.iter().zip(motions).collect();
        let of = |tracks: Vec<KeyedTrack>| {
            let shown = |(outline, (layer, motion)): (&_, &(_, Option<u32>))| Shown {
                layer,
                outline,
                motion: outlines.placed_of(*motion),
            };
            let shown: Vec<Shown<'_>> = tracks.iter().zip(&layers).map(shown).collect();
            least_of_what_is_needed(clip, &sealed, &shown)
        };
        let alone = layers
            .iter()
            .map(|(l, m)| outlines.of_layer(l, *m).keyed(&[]));
        let closed = outlines.closed(&layers, &mut Progress::none()).unwrap();
        [of(closed), of(alone.collect())]
    }

    #[test]
    fn shapes_alone_leave_gaps_at_their_edges_and_together_none() {
        // Corners go to and fro within the tolerance; each shape alone stays where it is.
        let shakes = [(0.45, 0.4), (-0.45, -0.4), (-0.4, 0.45), (0.2, -0.45)];
        let [closed, alone] = least(&shaken(&shakes), [None, Some(0), None]);
        assert!(alone < -0.5, "{alone}");
        // An eighth of a pixel of both is left to the grid.
        assert!(closed > -0.4, "{closed}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn what_is_needed_at_an_edge_is_left(
            shakes in prop::collection::vec((-0.6f32..0.6, -0.6f32..0.6), 60..90),
            motions in prop::collection::vec(prop::option::of(Just(0u32)), 3),
        ) {
            let [closed, _] = least(&shaken(&shakes), [motions[0], motions[1], motions[2]]);
            prop_assert!(closed > -0.4, "{closed}");
        }
    }
}
