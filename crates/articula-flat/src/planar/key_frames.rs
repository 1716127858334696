//! Key-frame reduction: replaces positions and light per frame by few keys.
//!
//! Source: `docs/methods/vector.md` 7. Keys need not lie on the data (`tunnel`, `moving_gradient`).
//! Where the format allows it, a gradient line is stored as fractions of its shape's bounding box,
//! since it then moves along with the shape and most lines are constant.

use super::changing_color::CornerColors;
use super::clip::PlanarClip;
use super::drawn::Drawn;
use super::error::PlanarError;
use super::few_colors::few_colors;
use super::keyed_clip::{BOX, GRID, KeyedClip, KeyedPaint, KeyedShape, KeyedTrack, LineUnits};
use super::keyed_motion::KeyedMotion;
use super::merge::{Region, merge, seal_regions};
use super::moving_gradient::{self, Corners, SLACKS, Wanted};
use super::order::Layer;
use super::shading::{Colors, Shading};
use super::shared_motion::Placed;
use super::small_shapes::{area, slack_of_small};
use super::tunnel::{Windows, fewest_keys};
use super::underlap::{Sealed, UnderlapOptions};
use articula_core::Progress;
use glam::{DVec2, Vec2};
use std::collections::BTreeMap;
use std::ops::Range;
use std::rc::Rc;

/// The tolerance of colours, divided by what of it may be spent on having few colours.
const SHARE_OF_COLORS: f32 = 4.0;

/// Share of the tolerance within which one colour takes the place of a gradient that is as close for its bytes alone:
/// beside gradients it shows more.
const CHANGING: f64 = 0.5;
/// Factor by which one colour is closer than a gradient where it takes its place otherwise.
const CLOSER: f64 = 1.6;
/// Length of an element without what it names, about.
const ELEMENT: usize = 50;

/// Tolerances, shading and units of the key-frame reduction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KeyOptions {
    /// Maximum distance of a corner's x or y from its position in a frame, pixels; at least 1/8,
    /// since corners lie on a grid.
    pub pos_tol_px: f32,
    /// Maximum colour difference at a corner, levels.
    pub col_tol_levels: f32,
    /// Shading of the triangles.
    pub shading: Shading,
    /// Units of gradient lines.
    pub lines: LineUnits,
    /// Neighbours whose colours differ by at most this many levels become one shape, sealed with
    /// the default underlap; only without gradients.
    pub merge_levels: Option<f32>,
}

impl Default for KeyOptions {
    fn default() -> Self {
        Self {
            pos_tol_px: 0.5,
            col_tol_levels: 8.0,
            shading: Shading::Gouraud,
            lines: LineUnits::Box,
            merge_levels: None,
        }
    }
}

/// Errors and numbers of keys of a key-frame reduction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct KeyStats {
    /// RMS distance of x or y from its position, over drawn corners and frames, pixels.
    pub position_rmse_px: f64,
    /// Maximum of that distance, pixels.
    pub position_max_px: f64,
    /// Number of shapes.
    pub shapes: usize,
    /// Number of keys of outlines.
    pub outline_keys: usize,
    /// Number of shapes with a gradient.
    pub gradients: usize,
    /// Number of gradients whose line moves.
    pub moving_gradients: usize,
    /// Number of keys of moving gradients.
    pub line_keys: usize,
    /// Number of shapes with one colour that changes, in place of a gradient.
    pub changing_colors: usize,
    /// Number of keys of these colours.
    pub color_keys: usize,
    /// RMS error of gradients at corners in drawn frames, weighted by area, levels.
    pub color_rmse_levels: f64,
}

/// Converts a clip to shapes with keys. `layers` are back to front.
///
/// O(layers x frames x longest segment).
///
/// # Errors
/// Errors of the clip, or [`PlanarError::Mismatch`] if the arguments belong to different clips.
pub(crate) fn keyed(
    clip: &PlanarClip,
    drawn: &Drawn,
    layers: &[Layer],
    sealed: &Sealed,
    options: &KeyOptions,
) -> Result<(KeyedClip, KeyStats), PlanarError> {
    let subject = (clip, drawn, layers, sealed);
    keyed_along(subject, (&[], &[]), options, &mut Progress::none())
}

/// The same with motions that layers follow, and the index of each layer's; layers beyond these follow
/// none. Merged shapes follow none.
///
/// # Errors
/// As [`keyed`]; [`PlanarError::Mismatch`] if an index is out of range; [`PlanarError::Cancelled`].
pub(crate) fn keyed_along(
    (clip, drawn, layers, sealed): (&PlanarClip, &Drawn, &[Layer], &Sealed),
    (motions, of_layer): (&[KeyedMotion], &[Option<u32>]),
    options: &KeyOptions,
    progress: &mut Progress<'_>,
) -> Result<(KeyedClip, KeyStats), PlanarError> {
    clip.check()?;
    check_shapes(clip, drawn, layers, sealed)?;
    check_motions(clip, motions, of_layer)?;
    if let (Shading::Flat, Some(levels)) = (options.shading, options.merge_levels) {
        let regions = merge(clip, drawn, layers, levels)?;
        let sealed = seal_regions(clip, &regions, UnderlapOptions::default());
        return keyed_regions(clip, &regions, &sealed, options);
    }
    let mut reducer = Reducer::new(clip, &sealed.corners, motions, options);
    let triangles = layers.iter().filter(|l| !l.frames.is_empty());
    let triangles = triangles.map(|l| l.triangle);
    let tolerance = (options.col_tol_levels / SHARE_OF_COLORS) as u8;
    let colors = few_colors(clip, drawn, triangles, (options.shading, tolerance));
    let mut shapes = Vec::new();
    let motions = of_layer.iter().copied().chain(std::iter::repeat(None));
    let shown = layers.iter().zip(motions).enumerate();
    for (l, (layer, motion)) in shown.filter(|(_, (l, _))| !l.frames.is_empty()) {
        progress.step(l as f32 / layers.len() as f32)?;
        shapes.push(reducer.shape(layer, colors[&layer.triangle], motion));
    }
    Ok(reducer.finish(shapes))
}

/// Converts regions of one colour to shapes with keys, back to front. `sealed` are their points,
/// `[region][frame][point]`, from [`super::merge::seal_regions`].
///
/// # Errors
/// Errors of the clip, or [`PlanarError::Mismatch`] if the arguments belong to different clips.
pub(crate) fn keyed_regions(
    clip: &PlanarClip,
    regions: &[Region],
    sealed: &[Vec<Vec<Vec2>>],
    options: &KeyOptions,
) -> Result<(KeyedClip, KeyStats), PlanarError> {
    clip.check()?;
    let frames = clip.frames.len();
    let fits = |(region, sealed): (&Region, &Vec<Vec<Vec2>>)| {
        let points = region.outlines.iter().map(Vec::len).sum::<usize>();
        let mut edges = region.outlines.iter().flatten();
        sealed.len() == frames
            && sealed.iter().all(|row| row.len() == points)
            && edges.all(|(t, e)| (*t as usize) < clip.triangles.len() && *e < 3)
            && are_spans(&region.frames, frames)
    };
    if regions.len() != sealed.len() || !regions.iter().zip(sealed).all(fits) {
        return Err(PlanarError::Mismatch {
            at: "regions",
            what: "regions, sealed points and clip must belong together".to_owned(),
        });
    }
    let mut reducer = Reducer::new(clip, &[], &[], options);
    let shown = regions
        .iter()
        .zip(sealed)
        .filter(|(r, _)| !r.frames.is_empty());
    let shapes = shown
        .map(|(region, sealed)| reducer.region(region, sealed))
        .collect();
    let (keyed, stats) = reducer.finish(shapes);
    keyed.check()?;
    Ok((keyed, stats))
}

/// Whether spans are ascending, disjoint and within the number of frames.
fn are_spans(spans: &[Range<usize>], frames: usize) -> bool {
    let mut end = None;
    spans.iter().all(|span| {
        let is_apart = end.is_none_or(|end| span.start > end);
        end = Some(span.end);
        is_apart && span.start < span.end && span.end <= frames
    })
}

fn check_shapes(
    clip: &PlanarClip,
    drawn: &Drawn,
    layers: &[Layer],
    sealed: &Sealed,
) -> Result<(), PlanarError> {
    let mismatch = |at: &'static str, what: &str| {
        let what = what.to_owned();
        Err(PlanarError::Mismatch { at, what })
    };
    let (frames, triangles) = (clip.frames.len(), clip.triangles.len());
    if drawn.frames() != frames {
        return mismatch("drawn", "must have the frames of the clip");
    }
    let rows = sealed.corners.iter().map(Vec::len);
    if sealed.corners.len() != frames || rows.into_iter().any(|r| r != triangles) {
        return mismatch("sealed", "must have the frames and triangles of the clip");
    }
    let fits = |l: &Layer| (l.triangle as usize) < triangles && are_spans(&l.frames, frames);
    if !layers.iter().all(fits) {
        return mismatch("layers", "a triangle or a span is outside the clip");
    }
    Ok(())
}

fn check_motions(
    clip: &PlanarClip,
    motions: &[KeyedMotion],
    of_layer: &[Option<u32>],
) -> Result<(), PlanarError> {
    let frames = clip.frames.len() as u32;
    let is_known = |m: &u32| (*m as usize) < motions.len();
    let fits = motions.iter().all(|m| m.check(frames).is_ok());
    if fits && of_layer.iter().flatten().all(is_known) {
        return Ok(());
    }
    Err(PlanarError::Mismatch {
        at: "motions",
        what: "must have the frames of the clip and contain those of the layers".to_owned(),
    })
}

/// Target positions of a layer's corners in the coordinates of its shape, with tolerances.
struct Wish {
    /// Target x and y of each point for each frame, grid steps.
    targets: Vec<f64>,
    /// Tolerance in each frame, grid steps; infinite where the position is irrelevant.
    reach: Vec<f64>,
    is_shown: Vec<bool>,
    /// Motion of the shape by frame; empty if it has none.
    motion: Rc<[Placed]>,
}

impl Wish {
    fn motion(&self, frame: usize) -> Placed {
        self.motion.get(frame).copied().unwrap_or(Placed::STILL)
    }

    fn width(&self) -> usize {
        self.targets.len() / self.reach.len().max(1)
    }

    fn row(&self, frame: usize) -> &[f64] {
        &self.targets[frame * self.width()..(frame + 1) * self.width()]
    }
}

/// Points of a shape by frame, pixels.
struct Outline<'a> {
    /// Points after sealing.
    sealed: &'a dyn Fn(usize) -> Vec<Vec2>,
    /// Points of the clip.
    places: &'a dyn Fn(usize) -> Vec<Vec2>,
}

/// Position in grid steps.
fn on_grid(place: Vec2) -> [f64; 2] {
    [place.x, place.y].map(|v| f64::from(v) * f64::from(GRID))
}

struct Reducer<'a> {
    clip: &'a PlanarClip,
    sealed: &'a [Vec<[Vec2; 3]>],
    motions: &'a [KeyedMotion],
    /// Each motion by frame.
    placed: Vec<Rc<[Placed]>>,
    options: &'a KeyOptions,
    ramps: BTreeMap<[u8; 3], u32>,
    stats: KeyStats,
    positions: Mean,
    levels: Mean,
}

/// Weighted mean of squares.
#[derive(Debug, Default)]
struct Mean {
    sum: f64,
    weight: f64,
}

impl Mean {
    fn add(&mut self, value: f64, weight: f64) {
        self.sum += value * value * weight;
        self.weight += weight;
    }

    fn root(&self) -> f64 {
        (self.sum / self.weight.max(1e-9)).sqrt()
    }
}

impl<'a> Reducer<'a> {
    fn new(
        clip: &'a PlanarClip,
        sealed: &'a [Vec<[Vec2; 3]>],
        motions: &'a [KeyedMotion],
        options: &'a KeyOptions,
    ) -> Self {
        let frames = clip.frames.len();
        Self {
            clip,
            sealed,
            motions,
            placed: motions
                .iter()
                .map(|m| Placed::of(m, frames).into())
                .collect(),
            options,
            ramps: BTreeMap::new(),
            stats: KeyStats::default(),
            positions: Mean::default(),
            levels: Mean::default(),
        }
    }

    fn finish(mut self, shapes: Vec<KeyedShape>) -> (KeyedClip, KeyStats) {
        let mut ramps = vec![[0; 3]; self.ramps.len()];
        for (color, index) in &self.ramps {
            ramps[*index as usize] = *color;
        }
        self.stats.position_rmse_px = self.positions.root();
        self.stats.color_rmse_levels = self.levels.root();
        let keyed = KeyedClip {
            width: self.clip.width,
            height: self.clip.height,
            fps: self.clip.fps,
            frames: self.clip.frames.len() as u32,
            ramps,
            lines: self.options.lines,
            motions: self.motions.to_vec(),
            shapes,
        };
        (keyed, self.stats)
    }

    fn shape(&mut self, layer: &Layer, colors: Colors, motion: Option<u32>) -> KeyedShape {
        let t = layer.triangle as usize;
        let (clip, sealed) = (self.clip, self.sealed);
        let placed = motion.map(|m| Rc::clone(&self.placed[m as usize]));
        let wish = self.wish(
            &layer.frames,
            placed.unwrap_or_default(),
            &Outline {
                sealed: &|f| sealed[f][t].to_vec(),
                places: &|f| clip.places(f, t).to_vec(),
            },
        );
        let outline = self.outline(&wish);
        let frames = clip.frames.len() as u32;
        let paint = match colors {
            Colors::Flat(color) => KeyedPaint::Flat(color),
            Colors::Ramp(_) | Colors::Own(_) => self.shaded(layer, colors, &wish, &outline),
        };
        KeyedShape {
            motion,
            outline,
            further_outlines: Vec::new(),
            paint,
            shown: KeyedShape::shown_in(&layer.frames, frames),
        }
    }

    /// Targets of an outline. Hidden frames have no tolerance bound; those next to shown ones have
    /// a wide one, since a shape is shown for half a frame longer.
    fn wish(&self, shown: &[Range<usize>], motion: Rc<[Placed]>, outline: &Outline<'_>) -> Wish {
        let frames = self.clip.frames.len();
        let tol = f64::from(self.options.pos_tol_px) * f64::from(GRID);
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
                (true, _) => tol,
                (false, Some(g)) => {
                    // The sealed outline of the shown frame, moved on as the triangle moves.
                    points = (outline.sealed)(g);
                    let moves = (outline.places)(f).into_iter().zip((outline.places)(g));
                    for (point, (here, there)) in points.iter_mut().zip(moves) {
                        *point += here - there;
                    }
                    2.0 * tol
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

    /// A shape with any number of points and one colour.
    fn region(&mut self, region: &Region, sealed: &[Vec<Vec2>]) -> KeyedShape {
        let clip = self.clip;
        let wish = self.wish(
            &region.frames,
            Rc::default(),
            &Outline {
                sealed: &|f| sealed[f].clone(),
                places: &|f| region.points(clip, f),
            },
        );
        KeyedShape {
            motion: None,
            outline: self.outline(&wish),
            further_outlines: region.further_outlines(),
            paint: KeyedPaint::Flat(region.color),
            shown: KeyedShape::shown_in(&region.frames, clip.frames.len() as u32),
        }
    }

    fn outline(&mut self, wish: &Wish) -> KeyedTrack {
        let outline = fewest_keys(&Windows {
            targets: &wish.targets,
            width: wish.width(),
            reach: &wish.reach,
        });
        self.count(wish, &outline);
        outline
    }

    fn count(&mut self, wish: &Wish, outline: &KeyedTrack) {
        self.stats.shapes += 1;
        self.stats.outline_keys += outline.len();
        for f in (0..wish.is_shown.len()).filter(|f| wish.is_shown[*f]) {
            let placed = wish.motion(f);
            let point = |p: &[f64]| placed.to_picture(DVec2::new(p[0], p[1]));
            let pairs = outline.at(f as f64);
            let pairs = pairs.chunks_exact(2).zip(wish.row(f).chunks_exact(2));
            for off in pairs.flat_map(|(a, b)| (point(a) - point(b)).abs().to_array()) {
                let off = off / f64::from(GRID);
                self.positions.add(off, 1.0);
                self.stats.position_max_px = self.stats.position_max_px.max(off);
            }
        }
    }

    /// Paint of a layer whose outline is already keyed: a gradient, or one colour that changes where that needs fewer
    /// bytes or is closer.
    fn shaded(
        &mut self,
        layer: &Layer,
        colors: Colors,
        wish: &Wish,
        outline: &KeyedTrack,
    ) -> KeyedPaint {
        let t = layer.triangle as usize;
        let level = 1.0 / f64::from(colors.span_levels().max(1.0));
        let tolerance = |f: usize| {
            let tol = f64::from(self.options.col_tol_levels.max(0.5));
            let tol = if wish.is_shown[f] { tol } else { 2.0 * tol };
            let is_relevant = wish.reach[f].is_finite();
            is_relevant.then(|| tol * slack_of_small(&self.clip.places(f, t)))
        };
        let mut of_corners = CornerColors::default();
        for f in 0..wish.is_shown.len() {
            let corners = self.clip.triangles[t].map(|v| self.clip.color(f, v));
            of_corners.push(corners, tolerance(f));
        }
        let frame = |f: usize| {
            let corners = self.painted(f, (t, colors), wish, outline);
            Some((corners, tolerance(f)? * level))
        };
        let wanted = Wanted {
            frames: (0..wish.is_shown.len()).map(frame).collect(),
            level,
            steps: match self.options.lines {
                LineUnits::Grid => &[1],
                LineUnits::Box => &[BOX / 10, BOX / 100, 1],
            },
        };
        let slack = of_corners.least_slack();
        let line = moving_gradient::few_keys(&wanted, CLOSER * slack);
        let changing = match &line {
            Some(line) if line.is_still() || slack > CHANGING => None,
            Some(line) => {
                let color = of_corners.few_keys(CHANGING);
                (text_of_color(&color) < text_of_line(line)).then_some(color)
            }
            None => {
                let slack = SLACKS.into_iter().find(|s| slack <= *s).unwrap_or(slack);
                Some(of_corners.few_keys(slack))
            }
        };
        if let Some(color) = changing {
            return self.changing(of_corners, color, t, wish);
        }
        let line = line.unwrap_or_default();
        self.stats.gradients += 1;
        for f in (0..wish.is_shown.len()).filter(|f| wish.is_shown[*f]) {
            let area = area(&self.clip.places(f, t));
            for apart in wanted.off(f, &line).into_iter().flatten() {
                self.levels.add(apart / level, area);
            }
        }
        if !line.is_still() {
            self.stats.moving_gradients += 1;
            self.stats.line_keys += line.len();
        }
        match colors {
            Colors::Own(stops) => KeyedPaint::Own { stops, line },
            Colors::Ramp(color) | Colors::Flat(color) => {
                let next = self.ramps.len() as u32;
                let ramp = *self.ramps.entry(color).or_insert(next);
                KeyedPaint::Ramp { ramp, line }
            }
        }
    }

    /// Paint of a triangle with one colour that changes.
    fn changing(
        &mut self,
        of_corners: CornerColors,
        color: KeyedTrack,
        triangle: usize,
        wish: &Wish,
    ) -> KeyedPaint {
        for f in (0..wish.is_shown.len()).filter(|f| wish.is_shown[*f]) {
            let area = area(&self.clip.places(f, triangle));
            if let Some(apart) = of_corners.off(f, &color) {
                self.levels.add(apart, area);
            }
        }
        self.stats.changing_colors += 1;
        self.stats.color_keys += color.len();
        if color.is_still() {
            let levels = color.key(0);
            return KeyedPaint::Flat(std::array::from_fn(|c| levels[c] as u8));
        }
        KeyedPaint::Changing(color)
    }

    /// Positions at which the colours of the corners are to be painted: the corners before sealing,
    /// shifted by the error of the keyed outline, in the units of lines.
    fn painted(
        &self,
        f: usize,
        (t, colors): (usize, Colors),
        wish: &Wish,
        outline: &KeyedTrack,
    ) -> Corners {
        let shares = colors.shares(self.clip, f, t);
        let places = self.clip.places(f, t);
        let keyed = outline.at(f as f64);
        let sealed = wish.row(f);
        let placed = wish.motion(f);
        let place = |i: usize| {
            let place = placed.to_shape(on_grid(places[i]).into()).to_array();
            let off = |n: usize| place[n] + keyed[2 * i + n] - sealed[2 * i + n];
            [off(0), off(1)]
        };
        let units = |point: [f64; 2]| match self.options.lines {
            LineUnits::Grid => point,
            LineUnits::Box => in_box(&keyed, point),
        };
        std::array::from_fn(|i| (units(place(i)), f64::from(shares[i])))
    }
}

/// Length of the text of a colour that changes, about.
fn text_of_color(color: &KeyedTrack) -> usize {
    ELEMENT + 8 * color.len()
}

/// Length of the text of a gradient and its line, about.
fn text_of_line(line: &KeyedTrack) -> usize {
    let moves = |n: &usize| (1..line.len()).any(|k| line.key(k)[*n] != line.key(0)[*n]);
    let moving = (0..line.width).filter(moves).count();
    2 * ELEMENT + moving * (ELEMENT + 5 * line.len())
}

/// Position relative to an outline's bounding box, in thousandths.
fn in_box(outline: &[f64], place: [f64; 2]) -> [f64; 2] {
    let of = |n: usize| {
        let numbers = outline.iter().skip(n).step_by(2);
        let (low, high) = numbers.fold((f64::MAX, f64::MIN), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
        (place[n] - low) / (high - low).max(1e-3) * f64::from(BOX)
    };
    [of(0), of(1)]
}

#[cfg(test)]
mod tests;
