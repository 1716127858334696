//! Where the characters of a crowd are: world-space bounds in tiles of eight, and cells of
//! neighbouring characters that are skipped as a whole.
//!
//! A cell is [`CELL`] characters that follow each other in the caller's order, with the box around
//! their bounds. If no view sees the box, or all see it and the tolerances of all its characters stay
//! within the ranges in which they keep their levels, nobody in it is looked at. Crowds whose
//! neighbours in the world are neighbours in the order gain most.

use super::frame::{Frame, Moved};
use crate::allowance::Allowance;
use crate::simd::{LANES, Tile};
use crate::sphere::Sphere;
use crate::visibility::{Spheres, carry_four, filled};
use glam::{Quat, Vec3};
use std::ops::Range;

/// Tiles of a cell.
pub(crate) const CELL_TILES: usize = 8;
/// Characters of a cell.
pub(crate) const CELL: usize = CELL_TILES * LANES;

/// Range of tolerances that no tolerance is in: the level is chosen again.
pub(crate) const ANEW: [f32; 2] = [f32::INFINITY, 0.0];

/// Neighbouring characters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// Corners of the box around the bounds.
    pub(crate) least: Vec3,
    pub(crate) greatest: Vec3,
    /// Time of the crowd until which the model-space bounds hold, seconds.
    pub(crate) due_secs: f64,
    /// Number of characters that are visible, and of those in the cull margin.
    pub(crate) visible: u8,
    pub(crate) in_margin: u8,
    /// Whether the characters have to be looked at whatever the views are.
    pub(crate) is_fresh: bool,
    /// Whether the views have changed since the characters were last looked at.
    pub(crate) is_stale: bool,
    /// What its characters are allowed; `None` before their first frame.
    pub(crate) allowance: Option<Allowance>,
    /// Whether that is new since the characters were last looked at.
    pub(crate) has_new_allowance: bool,
    /// Tolerances in metres at which every visible character keeps its level.
    pub(crate) keeps: [f32; 2],
    /// Upper bound on the error of the visible characters, pixels.
    pub(crate) bound_px: f32,
}

impl Cell {
    /// What its characters are allowed.
    #[inline]
    pub(crate) fn allowance(&self) -> Allowance {
        self.allowance.unwrap_or(Allowance::of(1.0))
    }
}

/// World-space bounds of all characters.
#[derive(Debug, Clone)]
pub(crate) struct WorldBounds {
    x: Vec<Tile>,
    y: Vec<Tile>,
    z: Vec<Tile>,
    radius: Vec<Tile>,
    /// Tiles whose bounds have to be computed again.
    dirty: Vec<bool>,
    pub(crate) cells: Vec<Cell>,
}

impl WorldBounds {
    /// Bytes of each character.
    pub(crate) const BYTES: usize = 4 * size_of::<f32>();

    /// Bounds of so many characters, not known yet.
    pub(crate) fn new(characters: usize) -> Self {
        let tiles = characters.div_ceil(LANES);
        let nowhere = vec![Tile([f32::NAN; LANES]); tiles];
        let cell = Cell {
            least: Vec3::NAN,
            greatest: Vec3::NAN,
            due_secs: f64::NEG_INFINITY,
            visible: 0,
            in_margin: 0,
            is_fresh: true,
            is_stale: false,
            allowance: None,
            has_new_allowance: false,
            keeps: ANEW,
            bound_px: 0.0,
        };
        Self {
            x: nowhere.clone(),
            y: nowhere.clone(),
            z: nowhere.clone(),
            radius: nowhere,
            dirty: vec![true; tiles],
            cells: vec![cell; tiles.div_ceil(CELL_TILES)],
        }
    }

    /// Marks a character that has moved, or whose model-space bound has changed.
    #[inline]
    pub(crate) fn touch(&mut self, character: usize) {
        self.dirty[character / LANES] = true;
        self.cells[character / CELL].is_fresh = true;
    }

    /// Computes the bounds of the characters that were marked, or of all if they are not listed, and
    /// the boxes around them.
    pub(crate) fn update(&mut self, frame: &Frame<'_>, bounds: &[Sphere]) {
        if frame.moved == Moved::All {
            self.dirty.fill(true);
            self.cells.iter_mut().for_each(|c| c.is_fresh = true);
        }
        for cell in 0..self.cells.len() {
            if !self.cells[cell].is_fresh {
                continue;
            }
            let tiles = cell * CELL_TILES..((cell + 1) * CELL_TILES).min(self.dirty.len());
            let mut changed = false;
            for tile in tiles.clone() {
                if std::mem::replace(&mut self.dirty[tile], false) {
                    self.place(tile, frame, bounds);
                    changed = true;
                }
            }
            if changed {
                let [least, greatest] = self.corners(tiles);
                self.cells[cell].least = least;
                self.cells[cell].greatest = greatest;
            }
        }
    }

    /// Corners of the box around the bounds of some tiles. A bound that is no number is never visible
    /// and widens no box.
    fn corners(&self, tiles: Range<usize>) -> [Vec3; 2] {
        // One corner for every lane, so that compilers use vectors; minima leave NaN out.
        let (mut least, mut greatest) = ([[f32::MAX; LANES]; 3], [[f32::MIN; LANES]; 3]);
        for tile in tiles {
            let radius = &self.radius[tile].0;
            for (axis, centres) in [&self.x, &self.y, &self.z].into_iter().enumerate() {
                let centre = &centres[tile].0;
                for lane in 0..LANES {
                    least[axis][lane] = least[axis][lane].min(centre[lane] - radius[lane]);
                    greatest[axis][lane] = greatest[axis][lane].max(centre[lane] + radius[lane]);
                }
            }
        }
        [
            least.map(|lanes| lanes.into_iter().fold(f32::MAX, f32::min)),
            greatest.map(|lanes| lanes.into_iter().fold(f32::MIN, f32::max)),
        ]
        .map(Vec3::from_array)
    }

    fn place(&mut self, tile: usize, frame: &Frame<'_>, bounds: &[Sphere]) {
        for half in 0..2 {
            let first = tile * LANES + 4 * half;
            let scales = frame.scales.get(first..).unwrap_or_default();
            let filler = if frame.scales.is_empty() { 1.0 } else { 0.0 };
            let nowhere = Sphere {
                centre: Vec3::NAN,
                radius: 0.0,
            };
            let found = carry_four(
                filled(frame.positions.get(first..).unwrap_or_default(), Vec3::ZERO),
                filled(
                    frame.rotations.get(first..).unwrap_or_default(),
                    Quat::IDENTITY,
                ),
                filled(scales, filler),
                filled(bounds.get(first..).unwrap_or_default(), nowhere),
            );
            let [x, y, z, radius] = found.map(|v| v.to_array());
            for lane in 0..4 {
                let is_number = (x[lane].abs() + y[lane].abs() + z[lane].abs()).is_finite()
                    && (0.0..=f32::MAX).contains(&radius[lane]);
                let or_nothing = |v: f32| if is_number { v } else { f32::NAN };
                let to = 4 * half + lane;
                self.x[tile].0[to] = or_nothing(x[lane]);
                self.y[tile].0[to] = or_nothing(y[lane]);
                self.z[tile].0[to] = or_nothing(z[lane]);
                self.radius[tile].0[to] = or_nothing(radius[lane]);
            }
        }
    }

    /// The bounds of all tiles, of which the first is tile `first_tile` of those of the views.
    pub(crate) fn spheres(&self, first_tile: usize) -> Spheres<'_> {
        Spheres {
            first_tile,
            x: &self.x,
            y: &self.y,
            z: &self.z,
            radius: &self.radius,
        }
    }

    /// Bound of a character.
    pub(crate) fn sphere(&self, character: usize) -> Sphere {
        let (tile, lane) = (character / LANES, character % LANES);
        Sphere {
            centre: Vec3::new(
                self.x[tile].0[lane],
                self.y[tile].0[lane],
                self.z[tile].0[lane],
            ),
            radius: self.radius[tile].0[lane],
        }
    }
}
