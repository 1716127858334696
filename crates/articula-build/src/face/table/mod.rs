//! Face animation tables (FAT): how the vertices of a face move with each parameter, made from its
//! feature points alone.
//!
//! - `handles`: the points that the skin follows
//! - `eye_shape`: the surface of an eye
//! - `eyeballs`: eyeballs that turn and pupils that grow
//! - `tongue`: the tongue, inside of the mouth
//! - `graph`: distances along the skin
//! - `weights`: how much each vertex follows each handle
//! - `jaw`: how the lower jaw goes with the chin
//! - `lids`: rims that meet, in front of the eyeballs
//! - `lid_view`: what is seen of an eye between them
//! - `lid_parts`: lids that are parts of their own
//! - `lids_meet`: the last of the way of closed lids
//! - `mirror`: vertices at mirrored places
//! - `others`: what is inside of the mouth, and what is attached to the skin
//! - `normals`: how normals change with the vertices
//! - `pieces`: the parts of a parameter's range over which the table is straight
//! - `rules`: how handles move with parameters
//!
//! Method and constants: `docs/methods/faces.md`.

mod eye_shape;
mod eyeballs;
mod graph;
mod handles;
mod jaw;
mod lid_parts;
mod lid_view;
mod lids;
mod lids_meet;
mod mirror;
mod normals;
mod others;
mod pieces;
mod rules;
mod tongue;
mod weights;

use super::fap_values::FapValues;
use super::points::{FacePoints, FaceSurface, Snap};
use articula_core::LibmQuat;
use articula_core::fap_table::{LOW_FAPS, TABLE};
use articula_core::feature_points::PointId;
use eyeballs::{Eyeball, Gaze};
use glam::{Quat, Vec3};
use handles::{Handle, HandleKind, handles};
use lids::{EyeLids, LidInput};
use others::Others;
use rules::RuleFrame;
use tongue::Tongue;
use weights::{WeightInput, weights};

pub(super) use graph::{SurfaceGraph, nearest, smooth};
pub(super) use jaw::still_below_least;
pub(super) use mirror::Mirror;
pub(super) use weights::sheet;

pub use eye_shape::EyeShape;
pub use jaw::JawMotion;
pub use lid_view::NoLids;
pub use normals::normal_offsets;

/// Number of resting places that pin the skin around the face.
const PINS: usize = 60;
/// Offsets below this length are 0, metres.
const LEAST: f32 = 1e-5;

/// How the vertices of a head move with facial animation parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceTable {
    handles: Vec<Handle>,
    frame: RuleFrame,
    /// Vertices of the skin, ascending, and one weight for each handle, row by row.
    vertices: Vec<u32>,
    weights: Vec<f32>,
    /// Vertices of other parts, and the row of the skin that they follow.
    followers: Vec<(u32, usize)>,
    /// Vertices that turn with the lower jaw, and how much.
    jaw: Vec<(u32, f32)>,
    tongue: Option<Tongue>,
    /// The left and the right eyeball.
    eyeballs: Option<[Eyeball; 2]>,
    /// The lids of both eyes, and why there are none.
    lids: [Result<EyeLids, NoLids>; 2],
    /// Vertex of the bottom of the chin.
    chin: Option<u32>,
    positions: Vec<Vec3>,
    /// Height of the face, metres.
    height: f32,
}

impl FaceTable {
    /// Makes the table of a face from its feature points. `None` if they are too few or lie in a
    /// plane. O(handles² · vertices).
    pub fn new(surface: &FaceSurface, points: &FacePoints) -> Option<Self> {
        let parts = &points.parts;
        let height = points.height();
        let place = |point: PointId| points.get(point).map(|p| p.place);
        let at = |v: u32| surface.positions[v as usize];
        let eyes = eye_centres(points)?;
        let snap = Snap::new(surface, parts, height);
        let rim = |lid: PointId, near: Vec3| snap.vertex(lid, near);
        let handles = handles(points, rim, at);
        let frame = RuleFrame {
            units: points.units(),
            chin: place((2, 1))?,
            hinge: points.jaw_hinge()?,
        };
        let mirror = Mirror::of(&surface.positions, &parts.joined, place((9, 3))?.x);
        let graph = SurfaceGraph::of(&surface.positions, &parts.joined, &parts.skin, &mirror);
        let pins = pins(surface, points, height);
        let input = WeightInput {
            handles: &handles,
            pins: &pins,
            positions: &surface.positions,
            graph: &graph,
            height,
            eyes,
        };
        let vertices = parts.skin_vertices.clone();
        let mut weights = weights(&input, &vertices)?;
        exact_at_handles(&handles, &vertices, &parts.joined, &mut weights);
        let Others { followers, mut jaw } = Others::of(surface, points, &vertices, &mirror)?;
        let inside: Vec<u32> = jaw.iter().map(|(vertex, _)| *vertex).collect();
        let tongue = Tongue::of(surface, points, &inside, &mirror, height);
        // The tongue lies on the lower jaw, its upper side above the line between the lips.
        let on_jaw = tongue.iter().flat_map(|tongue| &tongue.vertices);
        for tongue in on_jaw {
            if let Ok(index) = jaw.binary_search_by_key(&tongue.vertex, |(vertex, _)| *vertex) {
                jaw[index].1 = jaw[index].1.max(tongue.share);
            }
        }
        let lids = EyeLids::of(&LidInput {
            surface,
            points,
            mirror: &mirror,
            vertices: &vertices,
            followers: &followers,
            height,
            eyes: eyes_of(surface, points, eyes),
            closed: frame.units.iris_diameter,
        });
        Some(Self {
            handles,
            frame,
            vertices,
            weights,
            followers,
            jaw,
            tongue,
            eyeballs: parts.eyeballs.as_ref().map(|eyes| {
                eyes.clone()
                    .map(|(ball, centre)| Eyeball::new(ball, centre, &surface.positions))
            }),
            lids,
            chin: points.get((2, 1)).and_then(|p| p.vertex),
            positions: surface.positions.clone(),
            height,
        })
    }

    /// Returns whether the table shows a parameter, by its number.
    pub fn moves(&self, fap: usize) -> bool {
        match fap {
            19..=22 => self.lids[(fap - 19) % 2].is_ok(),
            23..=30 => self.eyeballs.is_some(),
            43..=47 => self.tongue.is_some(),
            48..=50 => false,
            _ => {
                let point = TABLE[fap - 1].action.map(|a| a.point);
                point.is_some_and(|p| self.handles.iter().any(|h| h.what == HandleKind::Moving(p)))
            }
        }
    }

    /// Returns the displacement of each vertex of the surface by parameters, metres.
    pub fn displacements(&self, values: &FapValues) -> Vec<Vec3> {
        let closing = self.closing(values);
        let motion = self.frame.motion(values, &self.handles);
        let mut rows: Vec<Vec3> = (0..self.vertices.len())
            .map(|row| self.followed(row, &motion))
            .collect();
        for (eye, shares) in self.closed_lids(&closing) {
            eye.close(shares, &self.positions, &mut rows);
        }
        let mut all = self.spread(&rows);
        for (eye, shares) in self.closed_lids(&closing) {
            eye.move_others(shares, &self.positions, &mut all);
            eye.push_out(&self.positions, &mut all);
        }
        let turn = self.frame.jaw_radians(values);
        let jaw = Quat::libm_rotation_x(turn);
        let shift = self.frame.jaw_shift(values);
        for (vertex, share) in &self.jaw {
            let from = self.positions[*vertex as usize] - self.frame.hinge;
            all[*vertex as usize] = *share * (jaw * from - from + shift);
        }
        if let Some(tongue) = &self.tongue {
            let moved = tongue.displacements(values, |unit| self.frame.units.distance(unit));
            for (v, moved) in tongue.vertices.iter().zip(moved) {
                all[v.vertex as usize] += jaw * moved;
            }
        }
        let units = &self.frame.units;
        for (side, eye) in self.eyeballs.iter().flatten().enumerate() {
            let gaze = Gaze::of(values, side, units.eye_separation, units.iris_diameter);
            eye.apply(&gaze, &self.positions, &mut all);
        }
        still_below_least(&mut all);
        all
    }

    /// Displacements of the skin, if the handles move as `true_motion` says of their vertices; for
    /// measuring the weights apart from the rules.
    pub fn displacements_of_handles(&self, true_motion: impl Fn(u32) -> Vec3) -> Vec<Vec3> {
        let motion: Vec<Vec3> = self.handles.iter().map(|h| true_motion(h.vertex)).collect();
        let rows = (0..self.vertices.len()).map(|row| self.followed(row, &motion));
        self.spread(&rows.collect::<Vec<_>>())
    }

    /// The left and the right eye, where lids are found; without eyeballs, the largest balls behind the rims.
    pub fn eyes(&self) -> [Option<&EyeShape>; 2] {
        self.lids
            .each_ref()
            .map(|lids| lids.as_ref().ok().map(|l| &l.shape))
    }

    /// Returns why the lids of the left (0) or the right (1) eye are not moved; `None` where they are.
    pub fn without_lids(&self, eye: usize) -> Option<NoLids> {
        self.lids[eye].as_ref().err().copied()
    }

    /// Returns the values that move the feature points as displacements of all vertices say.
    pub fn values(&self, points: &FacePoints, displacements: &[Vec3]) -> FapValues {
        let mut values = FapValues::default();
        for fap in LOW_FAPS {
            let Some(action) = TABLE[fap - 1].action else {
                continue;
            };
            let vertex = points.get(action.point).and_then(|p| p.vertex);
            let (Some(vertex), Some(axis)) = (vertex, rules::axis(action.direction)) else {
                continue;
            };
            let unit = self.frame.units.distance(action.unit) / 1024.0;
            let along = displacements[vertex as usize].dot(axis) / unit;
            let is_two_sided = action.two_sided;
            values.set(fap, if is_two_sided { along } else { along.max(0.0) });
        }
        // The chin boss goes with the jaw; its own parameter is what is left.
        let jaw = self
            .frame
            .chin_boss(&values, points.get((2, 10)).map_or(Vec3::ZERO, |p| p.place));
        values.set(18, values.get(18) - jaw);
        values
    }

    /// The shares by which the upper and the lower lid of each eye close it.
    fn closing(&self, values: &FapValues) -> [[f32; 2]; 2] {
        let unit = self.frame.units.iris_diameter / 1024.0;
        [0, 1].map(|side: usize| {
            let [down, up] = [19 + side, 21 + side].map(|fap| values.get(fap) * unit);
            let lids = self.lids[side].as_ref();
            lids.map_or([0.0; 2], |lids| lids.closing(down, up))
        })
    }

    /// The lids that move.
    fn closed_lids(&self, closing: &[[f32; 2]; 2]) -> impl Iterator<Item = (&EyeLids, [f32; 2])> {
        let lids = self.lids.iter().zip(*closing);
        let moved = lids.filter(|(_, shares)| *shares != [0.0; 2]);
        moved.filter_map(|(lids, shares)| Some((lids.as_ref().ok()?, shares)))
    }

    /// Displacement of a row of the skin by the motion of the handles.
    fn followed(&self, row: usize, motion: &[Vec3]) -> Vec3 {
        let weights = &self.weights[row * motion.len()..(row + 1) * motion.len()];
        let all = weights.iter().zip(motion);
        all.map(|(w, m)| *w * *m).sum()
    }

    /// Displacements of all vertices from those of the skin, by row, and of what follows it.
    fn spread(&self, rows: &[Vec3]) -> Vec<Vec3> {
        let mut all = vec![Vec3::ZERO; self.positions.len()];
        for (vertex, moved) in self.vertices.iter().zip(rows) {
            all[*vertex as usize] = *moved;
        }
        for (vertex, row) in &self.followers {
            all[*vertex as usize] = rows[*row];
        }
        all
    }
}

/// Returns why the lids of the left and of the right eye of a face are not moved by parameters; `None` where they are.
/// As long as a table takes, but for its weights.
pub fn without_lids(surface: &FaceSurface, points: &FacePoints) -> [Option<NoLids>; 2] {
    let (Some(centres), Some(nose)) = (eye_centres(points), points.get((9, 3))) else {
        return [Some(NoLids::NoOpening); 2];
    };
    let lids = EyeLids::of(&LidInput {
        surface,
        points,
        mirror: &Mirror::of(&surface.positions, &points.parts.joined, nose.place.x),
        vertices: &points.parts.skin_vertices,
        followers: &[],
        height: points.height(),
        eyes: eyes_of(surface, points, centres),
        closed: points.units().iris_diameter,
    });
    lids.map(Result::err)
}

/// The centres of the left and the right eye: without eyeballs behind the pupils.
fn eye_centres(points: &FacePoints) -> Option<[Vec3; 2]> {
    if let Some(eyes) = &points.parts.eyeballs {
        return Some([eyes[0].1, eyes[1].1]);
    }
    let behind = 0.09 * points.height() * Vec3::Z;
    let place = |point: PointId| points.get(point).map(|p| p.place - behind);
    Some([place((3, 5))?, place((3, 6))?])
}

/// The surfaces of the eyes, without distances where there are no eyeballs.
fn eyes_of(surface: &FaceSurface, points: &FacePoints, centres: [Vec3; 2]) -> [EyeShape; 2] {
    [0, 1].map(|eye: usize| {
        let balls = points.parts.eyeballs.as_ref();
        let vertices = balls.iter().flat_map(|balls| &balls[eye].0);
        EyeShape::new(
            centres[eye],
            vertices.map(|v| surface.positions[*v as usize]),
        )
    })
}

/// Weights at the handles themselves: 1 for each, 0 for all others.
fn exact_at_handles(handles: &[Handle], vertices: &[u32], joined: &[u32], weights: &mut [f32]) {
    for (vertex, row) in vertices.iter().zip(weights.chunks_exact_mut(handles.len())) {
        let same = |h: &Handle| joined[h.vertex as usize] == joined[*vertex as usize];
        if let Some(own) = handles.iter().position(same) {
            row.fill(0.0);
            row[own] = 1.0;
        }
    }
}

/// Places that rest: behind the ears, below the chin and above the forehead, spread evenly over the
/// vertices there.
fn pins(surface: &FaceSurface, points: &FacePoints, height: f32) -> Vec<Vec3> {
    let place = |point: PointId| points.get(point).map_or(Vec3::ZERO, |p| p.place);
    let behind = 0.5 * (place((10, 3)).z + place((10, 4)).z) - 0.02 * height;
    let below = place((2, 1)).y - 0.35 * height;
    let above = place((11, 1)).y + 0.25 * height;
    let rests = |p: &Vec3| p.z < behind || p.y < below || p.y > above;
    // Of one half, and mirrored, so that the table of a symmetric face is symmetric.
    let middle = place((9, 3)).x;
    let skin = points.parts.skin_vertices.iter();
    let still: Vec<Vec3> = skin
        .map(|v| surface.positions[*v as usize])
        .filter(|p| rests(p) && p.x >= middle)
        .collect();
    let step = still.len().div_ceil(PINS / 2).max(1);
    let half = still.into_iter().step_by(step);
    half.flat_map(|p| [p, Vec3::new(2.0 * middle - p.x, p.y, p.z)])
        .collect()
}
