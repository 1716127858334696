//! The shape of a default inside of the mouth, placed by the feature points of a face.
//!
//! Lengths are shares of the height of the face, from its chin to its brows; those of teeth and tongue are of the average
//! head whose feature points are known.

use articula_build::face::FacePoints;
use articula_core::feature_points::PointId;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, TAU};

/// Teeth of a row that are seen, and columns of one: its sides are darker than its middle.
const TEETH: usize = 10;
const COLUMNS: usize = 2 * TEETH + 1;
/// Columns of the 2D mesh are every fourth.
const COARSE: usize = 4;
/// Half of the turn that a row of teeth takes about its arch, as a share of a quarter.
const ROUND: f32 = 0.86;
/// Half of the width of the arch by that of the mouth, and its depth by that half.
const ARCH: f32 = 1.0;
const ARCH_DEPTH: f32 = 1.5;
/// Least distance of teeth from the skin of the lips.
const LIPS: f32 = 0.035;
/// Heights above the line between the lips: top of the gum, border of gum and teeth, edge of the teeth.
const UPPER: [f32; 3] = [0.16, 0.07, -0.04];
const LOWER: [f32; 3] = [-0.005, -0.09, -0.18];
/// Distances of the two rows behind that line where the template gives none that is likely.
const BEHIND: [f32; 2] = [0.085, 0.125];
const BEHIND_RANGE: [f32; 2] = [0.05, 0.15];
/// Columns and rows of the tongue.
const TONGUE: usize = 7;
/// Length, half of the width, and height below the line between the lips of the tongue.
const TONGUE_SIZE: Vec3 = Vec3::new(0.15, 0.055, 0.42);
/// Columns of the dark hollow.
const AROUND: usize = 16;
/// How far its rim goes into the lips: aside, up and back.
const RIM: Vec3 = Vec3::new(0.02, 0.03, 0.03);
/// Depths of its rings behind the line between the lips, and their height by that of the gums.
const HOLLOW: [(f32, f32); 2] = [(0.2, 1.0), (0.55, 0.7)];

/// Points of the inner contour of the lips, from the left corner over the upper lip.
const CONTOUR: [PointId; 8] = [
    (2, 4),
    (2, 6),
    (2, 2),
    (2, 7),
    (2, 5),
    (2, 9),
    (2, 3),
    (2, 8),
];

/// Linear colours.
const TOOTH: Vec3 = Vec3::new(0.66, 0.62, 0.53);
const GUM: Vec3 = Vec3::new(0.36, 0.10, 0.10);
const FLESH: Vec3 = Vec3::new(0.45, 0.13, 0.12);
const DARK: [Vec3; 3] = [
    Vec3::new(0.16, 0.04, 0.04),
    Vec3::new(0.06, 0.014, 0.014),
    Vec3::new(0.015, 0.004, 0.004),
];
/// Depths behind the lips over which the skin of a bag takes the colours of the dark, by the height of the face.
const BAG: [f32; 3] = [0.03, 0.12, 0.35];
/// Brightness between two teeth, and at the end of a row, where the cheeks keep the light off.
const BETWEEN_TEETH: f32 = 0.5;
const END_OF_ROW: f32 = 0.35;

/// A vertex of the inside of the mouth, in the frame of the head.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MouthVertex {
    pub(super) place: Vec3,
    pub(super) normal: Vec3,
    /// Linear.
    pub(super) color: Vec3,
    /// Share with which it turns with the lower jaw.
    pub(super) jaw: f32,
    /// Two points of the lips that it follows instead, and the share of the second.
    pub(super) lips: Option<([PointId; 2], f32)>,
    /// Shares with which it follows the tip and the body of the tongue.
    pub(super) tongue: [f32; 2],
}

/// A default inside of the mouth.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct MouthShape {
    pub(super) vertices: Vec<MouthVertex>,
    /// Triangles that pictures show.
    pub(super) fine: Vec<[u32; 3]>,
    /// Triangles of the 2D mesh, over the same vertices.
    pub(super) coarse: Vec<[u32; 3]>,
}

/// Measures of a mouth at rest.
struct Measures {
    /// Middle of the line between the lips.
    seam: Vec3,
    /// Height of the face.
    height: f32,
    /// Half of the width between the corners, and how far they lie behind the middle.
    half_width: f32,
    corners_behind: f32,
    /// Distances of the upper and the lower teeth behind the seam.
    behind: [f32; 2],
}

impl MouthShape {
    /// Makes teeth and tongue, and with `is_hollow` the dark walls behind them; `None` without the points of the lips.
    pub(super) fn new(points: &FacePoints, is_hollow: bool) -> Option<Self> {
        let measures = Measures::of(points)?;
        let mut shape = Self::default();
        if is_hollow {
            shape.add_hollow(points, &measures)?;
        }
        shape.add_row(&measures, measures.behind[0], UPPER, 0.0);
        shape.add_row(&measures, measures.behind[1], LOWER, 1.0);
        shape.add_tongue(&measures);
        shape.set_normals();
        Some(shape)
    }

    /// A row of teeth with its gum; heights from the top down.
    fn add_row(&mut self, measures: &Measures, behind: f32, heights: [f32; 3], jaw: f32) {
        let [top, middle, low] = heights;
        let is_upper = jaw < 0.5;
        // The colours change at the border, so it is there twice.
        let rows = [
            (top, is_upper),
            (middle, is_upper),
            (middle, !is_upper),
            (low, !is_upper),
        ];
        let rows = rows.map(|(height, is_gum)| {
            let column = |c: usize| {
                let round = 2.0 * c as f32 / (COLUMNS - 1) as f32 - 1.0;
                let light = if c.is_multiple_of(2) {
                    BETWEEN_TEETH
                } else {
                    1.0
                };
                let light = if is_gum { 1.0 } else { light };
                let end = 1.0 - (1.0 - END_OF_ROW) * round * round;
                let color = if is_gum { GUM } else { TOOTH };
                self.push(MouthVertex {
                    place: measures.on_arch(round, height, behind),
                    color: light * end * color,
                    jaw,
                    ..MouthVertex::plain()
                })
            };
            (0..COLUMNS).map(column).collect::<Vec<u32>>()
        });
        self.fine.extend(grid(&rows[..2], 1));
        self.fine.extend(grid(&rows[2..], 1));
        let [first, _, _, last] = rows;
        self.coarse.extend(grid(&[first, last], COARSE));
    }

    /// The tongue, from its root to below its tip.
    fn add_tongue(&mut self, measures: &Measures) {
        let Measures { seam, height, .. } = *measures;
        let size = TONGUE_SIZE * height;
        let tip = seam.z - measures.behind[1] - 0.03 * height;
        let last = TONGUE - 1;
        let row = |r: usize| {
            let along = r as f32 / last as f32;
            let column = |c: usize| {
                let aside = 2.0 * c as f32 / last as f32 - 1.0;
                // Round at the tip, high in the middle, with borders that fall.
                let width = (1.0 - along.powi(4)).max(0.0).sqrt().max(0.25);
                let arch = 0.03 * (1.0 - (2.0 * along - 1.0).powi(2)) - 0.04 * aside * aside;
                let fall = if r == last { 0.09 } else { 0.0 };
                let back = (1.0 - along) * size.z;
                let place = Vec3::new(
                    seam.x + width * aside * size.x,
                    seam.y - size.y + (arch - fall) * height,
                    tip - back - 0.05 * height * aside * aside * along,
                );
                let follow = smooth(along * 1.1);
                self.push(MouthVertex {
                    place,
                    color: (0.4 + 0.6 * along) * (1.0 - 0.25 * (1.0 - aside.abs()).powi(3)) * FLESH,
                    jaw: 1.0,
                    tongue: [follow, smooth(1.0 - (along - 0.5).abs() / 0.6)],
                    ..MouthVertex::plain()
                })
            };
            (0..TONGUE).map(column).collect::<Vec<u32>>()
        };
        let rows: Vec<Vec<u32>> = (0..TONGUE).map(row).collect();
        self.fine.extend(grid(&rows, 1));
        let coarse: Vec<Vec<u32>> = rows.into_iter().step_by(2).collect();
        self.coarse.extend(grid(&coarse, 2));
    }

    /// The dark walls: from the lips, which carry their rim, over the gums into the throat.
    fn add_hollow(&mut self, points: &FacePoints, measures: &Measures) -> Option<()> {
        let place = |point: PointId| points.get(point).map(|p| p.place);
        let per_point = AROUND / CONTOUR.len();
        let mut rim = Vec::new();
        for column in 0..AROUND {
            let (sin, cos) = (TAU * column as f32 / AROUND as f32).sin_cos();
            let at = column / per_point;
            let between = [CONTOUR[at], CONTOUR[(at + 1) % CONTOUR.len()]];
            let share = (column % per_point) as f32 / per_point as f32;
            let into = Vec3::new(cos, sin, -1.0) * RIM * measures.height;
            rim.push(self.push(MouthVertex {
                place: place(between[0])?.lerp(place(between[1])?, share) + into,
                color: DARK[0],
                lips: Some((between, share)),
                ..MouthVertex::plain()
            }));
        }
        let mut rows = vec![rim];
        for ((depth, tall), color) in HOLLOW.into_iter().zip([DARK[1], DARK[2]]) {
            let column = |column: usize| {
                let (sin, cos) = (TAU * column as f32 / AROUND as f32).sin_cos();
                let gum = if sin > 0.0 { UPPER[0] } else { -LOWER[2] };
                let wide = 1.2 * measures.half_width * (0.5 + 0.5 * tall);
                // The sides begin behind the rows of teeth.
                let depth = depth + 0.25 * (1.0 - tall.min(0.7)) * cos * cos;
                self.push(MouthVertex {
                    place: measures.seam
                        + Vec3::new(
                            wide * cos,
                            gum * tall * measures.height * sin,
                            -depth * measures.height,
                        ),
                    color,
                    jaw: smooth(0.5 - 0.8 * sin),
                    ..MouthVertex::plain()
                })
            };
            rows.push((0..AROUND).map(column).collect());
        }
        let throat = self.push(MouthVertex {
            place: measures.seam - Vec3::new(0.0, 0.02, 0.65) * measures.height,
            color: DARK[2],
            jaw: 0.5,
            ..MouthVertex::plain()
        });
        rows.push(vec![throat; AROUND]);
        for row in &mut rows {
            row.push(row[0]);
        }
        // Seen from inside.
        let turned = |[a, b, c]: [u32; 3]| [a, c, b];
        let is_whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        for (step, to) in [(1, &mut self.fine), (2, &mut self.coarse)] {
            to.extend(grid(&rows, step).into_iter().filter(is_whole).map(turned));
        }
        Some(())
    }

    fn push(&mut self, vertex: MouthVertex) -> u32 {
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }

    fn set_normals(&mut self) {
        for t in &self.fine {
            let [a, b, c] = t.map(|v| self.vertices[v as usize].place);
            let normal = (b - a).cross(c - a);
            t.iter()
                .for_each(|v| self.vertices[*v as usize].normal += normal);
        }
        for vertex in &mut self.vertices {
            vertex.normal = vertex.normal.try_normalize().unwrap_or(Vec3::Z);
        }
    }
}

impl MouthVertex {
    fn plain() -> Self {
        Self {
            place: Vec3::ZERO,
            normal: Vec3::ZERO,
            color: Vec3::ONE,
            jaw: 0.0,
            lips: None,
            tongue: [0.0; 2],
        }
    }
}

impl Measures {
    fn of(points: &FacePoints) -> Option<Self> {
        let place = |point: PointId| points.get(point).map(|p| p.place);
        let height = points.height();
        let (left, right) = (place((2, 4))?, place((2, 5))?);
        let seam = place((2, 2))?.midpoint(place((2, 3))?);
        let behind = [((9, 10), BEHIND[0]), ((9, 11), BEHIND[1])].map(|(tooth, usual)| {
            let found = place(tooth).map(|p| (seam.z - p.z) / height);
            let likely = found.filter(|b| (BEHIND_RANGE[0]..BEHIND_RANGE[1]).contains(b));
            likely.unwrap_or(usual) * height
        });
        let measures = Self {
            seam,
            height,
            half_width: 0.5 * (left.x - right.x),
            corners_behind: seam.z - 0.5 * (left.z + right.z),
            behind: [behind[0], behind[1].max(behind[0] + 0.03 * height)],
        };
        (height > 0.0 && measures.half_width > 0.05 * height).then_some(measures)
    }

    /// A place on the arch of a row of teeth, -1 to 1 from its right to its left end.
    fn on_arch(&self, round: f32, height: f32, behind: f32) -> Vec3 {
        let (sin, cos) = (ROUND * FRAC_PI_2 * round).sin_cos();
        let wide = ARCH * self.half_width;
        let (aside, back) = (wide * sin, ARCH_DEPTH * wide * (1.0 - cos));
        // The skin of the lips is a parabola through the corners.
        let lips = self.corners_behind * (aside / self.half_width).powi(2);
        let back = (behind + back).max(lips + LIPS * self.height);
        self.seam + Vec3::new(aside, height * self.height, -back)
    }
}

/// The factor to the colour of skin that goes on inside of the mouth, at a depth behind the lips.
pub(super) fn shade_of_bag(depth: f32) -> Vec3 {
    let share = |from: f32, to: f32| ((depth - from) / (to - from)).clamp(0.0, 1.0);
    let [lips, cheeks, throat] = BAG;
    let near = Vec3::ONE.lerp(2.0 * DARK[0], share(lips, cheeks));
    near.lerp(DARK[1], share(cheeks, throat))
}

/// Triangles between rows of as many vertices, from the top down and from the right of the figure to its left, that face
/// forward; every `step`th column.
fn grid(rows: &[Vec<u32>], step: usize) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for pair in rows.windows(2) {
        let of = |row: &[u32]| row.iter().copied().step_by(step).collect::<Vec<u32>>();
        let [upper, lower] = [of(&pair[0]), of(&pair[1])];
        for (up, low) in upper.windows(2).zip(lower.windows(2)) {
            triangles.extend([[up[0], low[0], up[1]], [up[1], low[0], low[1]]]);
        }
    }
    triangles
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
