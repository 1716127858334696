//! A deterministic scalar rasteriser: stores which triangle each sample of a picture shows.
//!
//! Source: `docs/methods/vector.md` part 3; edge functions after Pineda 1988, homogeneous
//! interpolation after Olano and Greer 1997. Corners are snapped to 1/256 pixel and edges are
//! evaluated in integers, so two triangles with a common edge neither overlap nor leave a gap;
//! depth ties go to the smaller id, so the result does not depend on the order of drawing.
//! Triangles that reach behind the near plane or far outside the picture are clipped before they
//! are snapped.

use crate::error::PictureError;
use glam::{Vec2, Vec3, Vec4};

/// Maximum side of a picture, in pixels.
pub(crate) const MAX_SIDE: u32 = 16_384;
/// Maximum number of samples of one buffer; 2 GiB of memory.
const MAX_SAMPLES: u64 = 1 << 28;
/// Steps of the snapping grid per pixel.
const GRID: i64 = 256;
/// Half width of the region in which corners may lie, in pixels. At this size an `f32` still
/// resolves the snapping grid.
const GUARD: f32 = 32_768.0;
/// Minimum homogeneous weight (metres ahead of a perspective camera) that is drawn.
const NEAR: f32 = 1e-2;
/// Maximum number of corners of a triangle after clipping by five planes.
const MAX_CORNERS: usize = 8;
/// The id of a sample that shows nothing.
const NOTHING: u32 = u32::MAX;

/// Number of samples per pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
pub enum Supersampling {
    /// One sample in the centre.
    One,
    /// 2 x 2 samples.
    #[default]
    Two,
    /// 4 x 4 samples.
    Four,
    /// 8 x 8 samples, for reference pictures.
    Eight,
}

impl Supersampling {
    /// Samples along one side of a pixel.
    pub(crate) fn per_side(self) -> u32 {
        1 << self as u32
    }

    /// Samples in a pixel.
    pub(crate) fn per_pixel(self) -> u32 {
        self.per_side() * self.per_side()
    }
}

/// Sides of a triangle that are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Faces {
    /// Both sides.
    #[default]
    Both,
    /// Only triangles that appear counter-clockwise.
    Front,
}

/// Triangle id and nearness of every sample of a picture.
///
/// Corners are homogeneous, `(x w, y w, n, w)`: `(x, y)` in pixels from the top left, `w` the depth
/// under perspective (1 in a parallel view) and `n / w` the nearness, which is linear on the screen
/// (`1 / depth`, or minus the depth in a parallel view).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ItemBuffer {
    width: u32,
    height: u32,
    samples: Supersampling,
    ids: Vec<u32>,
    nearness: Vec<f32>,
}

impl ItemBuffer {
    /// Returns an empty buffer for a picture of this size in pixels.
    ///
    /// # Errors
    /// [`PictureError::LimitExceeded`] if a side is longer than [`MAX_SIDE`] or there are too many
    /// samples.
    pub(crate) fn new(
        width: u32,
        height: u32,
        samples: Supersampling,
    ) -> Result<Self, PictureError> {
        let refuse = |limit| PictureError::LimitExceeded {
            width,
            height,
            samples: samples.per_pixel(),
            limit,
        };
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(refuse("16384 pixels per side"));
        }
        let count = u64::from(width) * u64::from(height) * u64::from(samples.per_pixel());
        if count > MAX_SAMPLES {
            return Err(refuse("268435456 samples in total"));
        }
        Ok(Self {
            width,
            height,
            samples,
            ids: vec![NOTHING; count as usize],
            nearness: vec![f32::NEG_INFINITY; count as usize],
        })
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// Number of samples per pixel.
    pub(crate) fn samples(&self) -> Supersampling {
        self.samples
    }

    /// Width and height in samples.
    pub(crate) fn sample_size(&self) -> (u32, u32) {
        let n = self.samples.per_side();
        (self.width * n, self.height * n)
    }

    /// Removes all triangles.
    pub(crate) fn clear(&mut self) {
        self.ids.fill(NOTHING);
        self.nearness.fill(f32::NEG_INFINITY);
    }

    /// Triangle that a sample shows; `None` for samples that show nothing or lie outside.
    pub(crate) fn item(&self, x: u32, y: u32) -> Option<u32> {
        self.sample(x, y).0
    }

    /// Nearness at a sample; minus infinity where it shows nothing.
    pub(crate) fn nearness(&self, x: u32, y: u32) -> f32 {
        self.sample(x, y).1
    }

    /// [`Self::item`] and [`Self::nearness`] together.
    pub(crate) fn sample(&self, x: u32, y: u32) -> (Option<u32>, f32) {
        let Some(i) = self.index(x, y) else {
            return (None, f32::NEG_INFINITY);
        };
        let id = self.ids[i];
        ((id != NOTHING).then_some(id), self.nearness[i])
    }

    /// Whether no sample of a pixel shows a triangle.
    pub(crate) fn is_blank(&self, x: u32, y: u32) -> bool {
        let n = self.samples.per_side();
        (y * n..(y + 1) * n).all(|sample_y| {
            let first = self.index(x * n, sample_y);
            first.is_none_or(|i| self.ids[i..i + n as usize].iter().all(|id| *id == NOTHING))
        })
    }

    /// Position of a sample in the picture, in pixels.
    pub(crate) fn position(&self, x: u32, y: u32) -> Vec2 {
        let n = self.samples.per_side() as f32;
        Vec2::new((x as f32 + 0.5) / n, (y as f32 + 0.5) / n)
    }

    /// Draws a triangle: it takes every sample that it covers, unless something nearer owns it.
    ///
    /// O(samples of its bounding box); does not allocate. Triangles with a corner that is not
    /// finite, and those without area, cover nothing.
    pub(crate) fn draw(&mut self, id: u32, corners: [Vec4; 3], faces: Faces) {
        self.draw_where(id, corners, faces, |_| true);
    }

    /// Draws a triangle like [`Self::draw`], but only at samples whose position (in pixels) `keep`
    /// accepts.
    pub(crate) fn draw_where(
        &mut self,
        id: u32,
        corners: [Vec4; 3],
        faces: Faces,
        mut keep: impl FnMut(Vec2) -> bool,
    ) {
        for part in pieces(corners) {
            self.fill(id, part, faces, &mut keep);
        }
    }

    /// Calls `visit` with every sample that a triangle covers, regardless of nearer triangles;
    /// draws nothing. These are the samples that [`Self::draw`] would take in an empty buffer.
    pub(crate) fn visit(&self, corners: [Vec4; 3], faces: Faces, mut visit: impl FnMut(u32, u32)) {
        for part in pieces(corners) {
            if let Some(scan) = Scan::new(part, faces, self.sample_size(), self.step()) {
                scan.each(|x, y| visit(x as u32, y as u32));
            }
        }
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        let (w, h) = self.sample_size();
        (x < w && y < h).then(|| y as usize * w as usize + x as usize)
    }

    fn fill(
        &mut self,
        id: u32,
        corners: [Snapped; 3],
        faces: Faces,
        keep: &mut impl FnMut(Vec2) -> bool,
    ) {
        let size = self.sample_size();
        let Some(scan) = Scan::new(corners, faces, size, self.step()) else {
            return;
        };
        let plane = Plane::through(scan.corners, scan.area, self.step());
        scan.each(|x, y| {
            let nearness = plane.at(x, y);
            let i = y as usize * size.0 as usize + x as usize;
            let held = self.nearness[i];
            let wins = nearness > held || (nearness == held && id < self.ids[i]);
            if wins && keep(self.position(x as u32, y as u32)) {
                self.nearness[i] = nearness;
                self.ids[i] = id;
            }
        });
    }

    /// Distance between samples in steps of the snapping grid.
    fn step(&self) -> i64 {
        GRID / i64::from(self.samples.per_side())
    }
}

/// Clips a triangle to what is ahead of the camera and near the picture, as triangles on the
/// snapping grid; nothing if a corner is not finite.
fn pieces(corners: [Vec4; 3]) -> impl Iterator<Item = [Snapped; 3]> {
    let is_finite = corners.iter().all(|c| c.is_finite());
    let mut polygon = Polygon::new(corners);
    if is_finite {
        polygon.clip();
    }
    let mut fan = [Snapped::default(); MAX_CORNERS];
    for (slot, corner) in fan.iter_mut().zip(polygon.corners()) {
        *slot = Snapped::new(corner);
    }
    let end = if is_finite { polygon.len } else { 0 };
    (2..end).map(move |i| [fan[0], fan[i - 1], fan[i]])
}

/// Iterates over the samples that a triangle covers.
struct Scan {
    /// Clockwise on the screen.
    corners: [Snapped; 3],
    /// Twice the area.
    area: i64,
    columns: (i64, i64),
    rows: (i64, i64),
    edges: [Edge; 3],
}

impl Scan {
    /// `None` if the triangle has no area or shows a side that is not drawn.
    fn new(
        mut corners: [Snapped; 3],
        faces: Faces,
        (width, height): (u32, u32),
        step: i64,
    ) -> Option<Self> {
        let area = double_area(corners);
        // The picture's y axis points down, so a counter-clockwise triangle has negative area.
        if area == 0 || (faces == Faces::Front && area > 0) {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let columns = span(corners.map(|c| c.x), step, width);
        let rows = span(corners.map(|c| c.y), step, height);
        let first = (columns.0 * step + step / 2, rows.0 * step + step / 2);
        let edges = [0, 1, 2].map(|i| Edge::new(corners[i], corners[(i + 1) % 3], first, step));
        Some(Self {
            corners,
            area: area.abs(),
            columns,
            rows,
            edges,
        })
    }

    fn each(&self, mut visit: impl FnMut(i64, i64)) {
        let mut edges = self.edges;
        let end = self.columns.1;
        // Inside all three edges if no value has its sign bit set.
        let is_inside = |at: &[i64; 3]| (at[0] | at[1] | at[2]) >= 0;
        for y in self.rows.0..self.rows.1 {
            let mut at = edges.map(|e| e.value);
            let right = edges.map(|e| e.right);
            let advance = |at: &mut [i64; 3]| {
                for (value, right) in at.iter_mut().zip(right) {
                    *value += right;
                }
            };
            // What is inside is one run of the row.
            let mut x = self.columns.0;
            while x < end && !is_inside(&at) {
                advance(&mut at);
                x += 1;
            }
            while x < end && is_inside(&at) {
                visit(x, y);
                advance(&mut at);
                x += 1;
            }
            for edge in &mut edges {
                edge.value += edge.down;
            }
        }
    }
}

/// Weights of the three corners at a position of the picture, perspective-correct.
///
/// They sum to 1; positions outside the triangle get the nearest weights on it. `None` if the
/// triangle is seen edge-on.
pub(crate) fn barycentric(corners: &[Vec4; 3], at: Vec2) -> Option<Vec3> {
    // Relative to the position itself, to keep precision far from the picture's corner.
    let [a, b, c] = corners.map(|c| Vec2::new(c.x, c.y) - at * c.w);
    let weights = Vec3::new(b.perp_dot(c), c.perp_dot(a), a.perp_dot(b));
    let sum = weights.x + weights.y + weights.z;
    let weights = (weights / sum).max(Vec3::ZERO);
    let sum = weights.x + weights.y + weights.z;
    (sum.is_finite() && sum > 0.0).then(|| weights / sum)
}

/// A corner on the snapping grid, with its nearness.
#[derive(Debug, Clone, Copy, Default)]
struct Snapped {
    x: i64,
    y: i64,
    nearness: f64,
}

impl Snapped {
    fn new(corner: Vec4) -> Self {
        let snap = |v: f32| (v * GRID as f32).round() as i64;
        Self {
            x: snap(corner.x / corner.w),
            y: snap(corner.y / corner.w),
            nearness: f64::from(corner.z / corner.w),
        }
    }
}

/// Twice the signed area, positive if the corners run clockwise on the screen.
fn double_area([a, b, c]: [Snapped; 3]) -> i64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

/// Range of samples whose centres may lie between the coordinates.
fn span(coordinates: [i64; 3], step: i64, count: u32) -> (i64, i64) {
    let least = coordinates.into_iter().fold(i64::MAX, i64::min);
    let greatest = coordinates.into_iter().fold(i64::MIN, i64::max);
    let from = (least - step / 2 + step - 1).div_euclid(step);
    let to = (greatest - step / 2).div_euclid(step) + 1;
    (
        from.clamp(0, i64::from(count)),
        to.clamp(0, i64::from(count)),
    )
}

/// Edge function: samples with a value that is not negative are inside.
#[derive(Clone, Copy)]
struct Edge {
    value: i64,
    right: i64,
    down: i64,
}

impl Edge {
    fn new(a: Snapped, b: Snapped, (x, y): (i64, i64), step: i64) -> Self {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        // A sample exactly on an edge belongs to the triangle to its right or below it.
        let is_top_left = dy < 0 || (dy == 0 && dx > 0);
        Self {
            value: dx * (y - a.y) - dy * (x - a.x) - i64::from(!is_top_left),
            right: -dy * step,
            down: dx * step,
        }
    }
}

/// Nearness over the samples, clamped to the range of the corners.
struct Plane {
    origin: f64,
    right: f64,
    down: f64,
    least: f64,
    greatest: f64,
}

impl Plane {
    fn through([a, b, c]: [Snapped; 3], area: i64, step: i64) -> Self {
        let (ab, ac) = (b.nearness - a.nearness, c.nearness - a.nearness);
        let scale = 1.0 / area as f64;
        let slope_x = (ab * (c.y - a.y) as f64 - ac * (b.y - a.y) as f64) * scale;
        let slope_y = (ac * (b.x - a.x) as f64 - ab * (c.x - a.x) as f64) * scale;
        let middle = (step / 2) as f64;
        Self {
            origin: a.nearness + slope_x * (middle - a.x as f64) + slope_y * (middle - a.y as f64),
            right: slope_x * step as f64,
            down: slope_y * step as f64,
            least: a.nearness.min(b.nearness).min(c.nearness),
            greatest: a.nearness.max(b.nearness).max(c.nearness),
        }
    }

    fn at(&self, x: i64, y: i64) -> f32 {
        let value = self.origin + self.right * x as f64 + self.down * y as f64;
        // The slope of a sliver is steep; clamping keeps rounding from pushing it through others.
        value.clamp(self.least, self.greatest) as f32
    }
}

/// A convex polygon: a triangle during clipping.
struct Polygon {
    points: [Vec4; MAX_CORNERS],
    len: usize,
}

impl Polygon {
    fn new(corners: [Vec4; 3]) -> Self {
        let mut points = [Vec4::ZERO; MAX_CORNERS];
        points[..3].copy_from_slice(&corners);
        Self { points, len: 3 }
    }

    fn corners(&self) -> impl Iterator<Item = Vec4> + '_ {
        self.points[..self.len].iter().copied()
    }

    /// Removes what lies behind the near plane or outside the guard region.
    fn clip(&mut self) {
        self.cut(|p| p.w - NEAR);
        self.cut(|p| GUARD * p.w - p.x);
        self.cut(|p| GUARD * p.w + p.x);
        self.cut(|p| GUARD * p.w - p.y);
        self.cut(|p| GUARD * p.w + p.y);
    }

    /// Keeps the part where `inside` is not negative (Sutherland and Hodgman 1974).
    fn cut(&mut self, inside: impl Fn(Vec4) -> f32) {
        if self.corners().all(|p| inside(p) >= 0.0) {
            return;
        }
        let before = self.points;
        let count = std::mem::take(&mut self.len);
        for i in 0..count {
            let (p, q) = (before[i], before[(i + 1) % count]);
            let (dp, dq) = (inside(p), inside(q));
            if dp >= 0.0 {
                self.push(p);
            }
            // Always from the inner to the outer end, so that both triangles of an edge get the
            // same point, bit for bit.
            if dp >= 0.0 && dq < 0.0 {
                self.push(p + (q - p) * (dp / (dp - dq)));
            } else if dp < 0.0 && dq >= 0.0 {
                self.push(q + (p - q) * (dq / (dq - dp)));
            }
        }
    }

    fn push(&mut self, point: Vec4) {
        // A convex polygon gains at most one corner per plane; rounding may add more.
        if self.len < MAX_CORNERS {
            self.points[self.len] = point;
            self.len += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flat(x: f32, y: f32) -> Vec4 {
        Vec4::new(x, y, 0.0, 1.0)
    }

    fn covered(corners: [Vec4; 3], samples: Supersampling) -> Vec<(u32, u32)> {
        let mut buffer = ItemBuffer::new(24, 24, samples).unwrap();
        buffer.draw(7, corners, Faces::Both);
        let (w, h) = buffer.sample_size();
        let all = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
        all.filter(|(x, y)| buffer.item(*x, *y).is_some()).collect()
    }

    #[test]
    fn a_right_triangle_by_hand() {
        // Centres (x + .5, y + .5) with x + y + 1 < 3; those on the long edge belong to the
        // triangle on its other side.
        let cells = covered(
            [flat(0.0, 0.0), flat(3.0, 0.0), flat(0.0, 3.0)],
            Supersampling::One,
        );
        assert_eq!(cells, [(0, 0), (1, 0), (0, 1)]);
        let other = covered(
            [flat(3.0, 3.0), flat(3.0, 0.0), flat(0.0, 3.0)],
            Supersampling::One,
        );
        let expected = [(2, 0), (1, 1), (2, 1), (0, 2), (1, 2), (2, 2)];
        assert_eq!(other, expected);
    }

    #[test]
    fn front_faces_are_counter_clockwise_on_the_screen() {
        let mut buffer = ItemBuffer::new(4, 4, Supersampling::One).unwrap();
        let clockwise = [flat(0.0, 0.0), flat(4.0, 0.0), flat(0.0, 4.0)];
        buffer.draw(0, clockwise, Faces::Front);
        assert_eq!(buffer.item(0, 0), None);
        buffer.draw(0, [clockwise[0], clockwise[2], clockwise[1]], Faces::Front);
        assert_eq!(buffer.item(0, 0), Some(0));
    }

    #[test]
    fn the_nearer_one_shows_and_ties_go_to_the_smaller_id() {
        let at = |nearness: f32| {
            [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)].map(|(x, y)| Vec4::new(x, y, nearness, 1.0))
        };
        let mut buffer = ItemBuffer::new(4, 4, Supersampling::Two).unwrap();
        buffer.draw(5, at(0.5), Faces::Both);
        buffer.draw(3, at(0.25), Faces::Both);
        assert_eq!(buffer.item(1, 1), Some(5));
        buffer.draw(4, at(0.5), Faces::Both);
        assert_eq!(buffer.item(1, 1), Some(4));
        buffer.draw(9, at(0.5), Faces::Both);
        assert_eq!(buffer.item(1, 1), Some(4));
        assert_eq!(buffer.nearness(1, 1), 0.5);
        buffer.clear();
        assert_eq!(buffer.item(1, 1), None);
    }

    #[test]
    fn weights_are_right_under_perspective() {
        // From depth 1 at x = 0 to depth 3 at x = 12: the midpoint of the edge in space appears at
        // (0 * 1 + 12 * 3) / (1 + 3) = 9.
        let corners = [
            Vec4::new(0.0, 0.0, 1.0, 1.0),
            Vec4::new(36.0, 0.0, 1.0, 3.0),
            Vec4::new(0.0, 30.0, 1.0, 1.0),
        ];
        let weights = barycentric(&corners, Vec2::new(9.0, 0.0)).unwrap();
        assert!((weights - Vec3::new(0.5, 0.5, 0.0)).length() < 1e-6);
        assert_eq!(barycentric(&[corners[0]; 3], Vec2::ONE), None);
    }

    #[test]
    fn what_lies_behind_the_camera_is_cut_off() {
        // A floor strip from one metre ahead to one metre behind; only its front half shows.
        let floor =
            |depth: f32, x: f32| Vec4::new((12.0 + x) * depth, 12.0 * depth + 4.0, 1.0, depth);
        let mut buffer = ItemBuffer::new(24, 24, Supersampling::One).unwrap();
        buffer.draw(
            0,
            [floor(1.0, -9.0), floor(1.0, 9.0), floor(-1.0, 0.0)],
            Faces::Both,
        );
        assert_eq!(buffer.item(12, 14), None, "beyond the far end");
        assert_eq!(buffer.item(12, 23), Some(0));
        buffer.clear();
        buffer.draw(
            0,
            [floor(-1.0, -9.0), floor(-1.0, 9.0), floor(-2.0, 0.0)],
            Faces::Both,
        );
        assert!(buffer.ids.iter().all(|id| *id == NOTHING));
    }

    #[test]
    fn odd_triangles_cover_nothing_and_huge_ones_all() {
        assert!(covered([flat(1.0, 1.0); 3], Supersampling::Eight).is_empty());
        let no_number = [flat(f32::NAN, 0.0), flat(9.0, 0.0), flat(0.0, 9.0)];
        assert!(covered(no_number, Supersampling::One).is_empty());
        let huge = [flat(-1e6, -1e6), flat(1e6, -1e6), flat(0.0, 1e6)];
        assert_eq!(covered(huge, Supersampling::One).len(), 24 * 24);
    }

    #[test]
    fn visiting_finds_what_nearer_ones_hide_and_draws_nothing() {
        let corners = [(0.0, 0.0), (3.0, 0.0), (0.0, 3.0)];
        let mut buffer = ItemBuffer::new(24, 24, Supersampling::One).unwrap();
        let wall = [(-9.0, -9.0), (99.0, -9.0), (-9.0, 99.0)];
        buffer.draw(1, wall.map(|(x, y)| Vec4::new(x, y, 9.0, 1.0)), Faces::Both);
        let before = buffer.clone();
        let mut seen = Vec::new();
        let corners = corners.map(|(x, y)| flat(x, y));
        buffer.visit(corners, Faces::Both, |x, y| seen.push((x, y)));
        assert_eq!(seen, [(0, 0), (1, 0), (0, 1)]);
        assert_eq!(buffer, before);
        buffer.visit(corners, Faces::Front, |_, _| panic!("it shows its back"));
    }

    #[test]
    fn refuses_what_would_not_fit() {
        assert!(ItemBuffer::new(16_385, 1, Supersampling::One).is_err());
        assert!(ItemBuffer::new(16_384, 16_384, Supersampling::Two).is_err());
        assert!(ItemBuffer::new(0, 0, Supersampling::Eight).is_ok());
    }

    fn any_samples() -> impl Strategy<Value = Supersampling> {
        prop::sample::select(vec![
            Supersampling::One,
            Supersampling::Two,
            Supersampling::Four,
            Supersampling::Eight,
        ])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        /// Every sample of a jittered grid is covered exactly once, with either winding.
        #[test]
        fn shared_edges_neither_overlap_nor_gap(
            jitter in prop::collection::vec((-0.49f32..0.49, -0.49f32..0.49), 49),
            flips in prop::collection::vec(any::<(bool, bool)>(), 36),
            samples in any_samples(),
        ) {
            let corner = |i: usize, j: usize| {
                let inner = (1..6).contains(&i) && (1..6).contains(&j);
                let (dx, dy) = if inner { jitter[j * 7 + i] } else { (0.0, 0.0) };
                flat((i as f32 + dx) * 4.0, (j as f32 + dy) * 4.0)
            };
            let mut count = vec![0u8; 24 * 24 * samples.per_pixel() as usize];
            let width = 24 * samples.per_side();
            for (cell, (diagonal, wind)) in flips.iter().enumerate() {
                let (i, j) = (cell % 6, cell / 6);
                let q = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                // A jittered quad may be concave; then only one diagonal lies inside.
                let turn = |a: Vec4, b: Vec4, c: Vec4| (b - a).truncate().truncate()
                    .perp_dot((c - a).truncate().truncate());
                let first = turn(q[0], q[1], q[2]) > 0.0 && turn(q[0], q[2], q[3]) > 0.0;
                let second = turn(q[0], q[1], q[3]) > 0.0 && turn(q[1], q[2], q[3]) > 0.0;
                let halves = if first && (*diagonal || !second) {
                    [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
                } else {
                    [[q[0], q[1], q[3]], [q[1], q[2], q[3]]]
                };
                for mut half in halves {
                    if *wind {
                        half.swap(0, 2);
                    }
                    for (x, y) in covered(half, samples) {
                        count[(y * width + x) as usize] += 1;
                    }
                }
            }
            prop_assert!(count.iter().all(|n| *n == 1));
        }

        /// Agrees with the sign of three cross products, computed per sample.
        #[test]
        fn agrees_with_point_in_triangle(
            points in prop::array::uniform3((-1000i32..8000, -1000i32..8000)),
            samples in any_samples(),
        ) {
            let corners = points.map(|(x, y)| flat(x as f32 / 256.0, y as f32 / 256.0));
            let cells = covered(corners, samples);
            let step = 256 / samples.per_side() as i32;
            for y in 0..24 * samples.per_side() {
                for x in 0..24 * samples.per_side() {
                    let at = (x as i32 * step + step / 2, y as i32 * step + step / 2);
                    let sides = [0, 1, 2].map(|i| {
                        let (a, b) = (points[i], points[(i + 1) % 3]);
                        let (abx, aby) = (i64::from(b.0 - a.0), i64::from(b.1 - a.1));
                        abx * i64::from(at.1 - a.1) - aby * i64::from(at.0 - a.0)
                    });
                    let inside = sides.iter().all(|s| *s > 0) || sides.iter().all(|s| *s < 0);
                    let outside = sides.iter().any(|s| *s > 0) && sides.iter().any(|s| *s < 0);
                    let found = cells.binary_search_by_key(&(y, x), |c| (c.1, c.0)).is_ok();
                    prop_assert!(!inside || found);
                    prop_assert!(!outside || !found);
                }
            }
        }

        /// Clipping at the near plane leaves no gap between two triangles of one floor.
        #[test]
        fn clipped_neighbours_meet(tilt in -0.9f32..0.9, shift in -3.0f32..3.0) {
            let at = |x: f32, depth: f32| {
                Vec4::new(12.0 * depth + x * 20.0, 12.0 * depth + 9.0 + tilt * x, 1.0, depth)
            };
            let quad = [at(-4.0 + shift, 6.0), at(4.0 + shift, 6.0), at(4.0, -1.0), at(-4.0, -1.0)];
            let mut buffer = ItemBuffer::new(24, 24, Supersampling::Two).unwrap();
            buffer.draw(0, [quad[0], quad[1], quad[2]], Faces::Both);
            buffer.draw(1, [quad[0], quad[2], quad[3]], Faces::Both);
            let (w, h) = buffer.sample_size();
            for y in 0..h {
                let shown: Vec<u32> = (0..w).filter(|x| buffer.item(*x, y).is_some()).collect();
                let gaps = shown.windows(2).any(|pair| pair[1] != pair[0] + 1);
                prop_assert!(!gaps, "row {}: {:?}", y, shown);
            }
        }
    }
}
