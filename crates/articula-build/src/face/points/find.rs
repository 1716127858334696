//! All feature points of a face, from those that its geometry shows and a template.

use super::anchors::Anchors;
use super::surface::{FaceSurface, SurfacePart};
use super::template::{EYE_CENTRES, FOUND, POINTS, WIDTHS, face_height, of, template_height};
use super::units::FaceUnits;
use super::warp::Warp;
use articula_core::feature_points::{FEATURE_POINTS, PointId, feature_point_index};
use articula_core::triangle_distance_squared;
use glam::Vec3;
use thiserror::Error;

/// How a feature point was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PointSource {
    /// Given by the caller.
    Given,
    /// Seen in the geometry: profile, line of the lips, opening of the lids.
    Geometry,
    /// Shown by the motion of blend shapes.
    Shapes,
    /// Carried over from the template by the points around it.
    Template,
}

impl PointSource {
    /// All sources.
    pub const ALL: [Self; 4] = [Self::Given, Self::Geometry, Self::Shapes, Self::Template];

    /// Returns its name in reports and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Given => "given",
            Self::Geometry => "geometry",
            Self::Shapes => "shapes",
            Self::Template => "template",
        }
    }
}

/// A feature point of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    /// Group and number.
    pub point: PointId,
    /// Place in the frame of the head, metres.
    pub place: Vec3,
    /// Vertex of the skin that stands for it; `None` for points inside the head.
    pub vertex: Option<u32>,
    /// How it was found.
    pub source: PointSource,
    /// 0 to 1: the share of test heads on which points of this kind were within 3 % of the height
    /// of the face.
    pub confidence: f32,
}

/// The feature points of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct FacePoints {
    /// The 84 points, in the order of the standard.
    pub points: Vec<FacePoint>,
    /// Points that the geometry seemed to show at places where no face has them, so that the template
    /// was followed.
    pub dropped: Vec<PointId>,
    /// Places that the geometry shows. The points themselves may differ: what is seen of the template
    /// has a known distance from its points.
    pub seen: Vec<(PointId, Vec3)>,
    /// What the parts of the surface are.
    pub(in crate::face) parts: FaceParts,
}

/// The parts of a head.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::face) struct FaceParts {
    /// First vertex of the same place and offsets, for each vertex.
    pub(in crate::face) joined: Vec<u32>,
    /// Triangles of the skin.
    pub(in crate::face) skin: Vec<[u32; 3]>,
    /// Vertices of the skin, ascending.
    pub(in crate::face) skin_vertices: Vec<u32>,
    /// Vertices of the left and the right eyeball with the layers around it, such as a cornea, and
    /// their centres.
    pub(in crate::face) eyeballs: Option<[(Vec<u32>, Vec3); 2]>,
    /// Vertices of the other parts.
    pub(in crate::face) others: Vec<u32>,
}

impl FaceParts {
    fn of(joined: Vec<u32>, parts: &[SurfacePart], anchors: &Anchors, positions: &[Vec3]) -> Self {
        let skin = &parts[anchors.skin];
        let eyeballs = anchors.eyeballs.map(|eyes| {
            eyes.map(|eye| {
                let layers = (0..parts.len()).filter(|p| *p != anchors.skin);
                let layers = layers.filter(|p| *p == eye.part || eye.has(&parts[*p], positions));
                let mut vertices: Vec<u32> = layers
                    .flat_map(|p| parts[p].vertices.iter().copied())
                    .collect();
                vertices.sort_unstable();
                vertices.dedup();
                (vertices, eye.centre)
            })
        });
        let is_eye = |vertex: &u32| {
            let mut eyes = eyeballs.iter().flatten();
            eyes.any(|(vertices, _)| vertices.binary_search(vertex).is_ok())
        };
        let others = parts.iter().enumerate();
        let others = others.filter(|(p, _)| *p != anchors.skin);
        let mut others: Vec<u32> = others
            .flat_map(|(_, p)| p.vertices.iter().copied())
            .collect();
        others.retain(|v| !is_eye(v));
        others.retain(|v| skin.vertices.binary_search(v).is_err());
        others.sort_unstable();
        others.dedup();
        Self {
            joined,
            skin: skin.triangles.clone(),
            skin_vertices: skin.vertices.clone(),
            eyeballs,
            others,
        }
    }
}

/// A surface has no face on which points can be placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum NoFace {
    /// The largest connected part has no nose.
    #[error("the largest connected part of the mesh has no nose")]
    Nose,
    /// Neither the mouth nor the eyes were found.
    #[error("neither the line between the lips nor two eyeballs were found")]
    MouthAndEyes,
}

/// Greatest distance of a found point from its forecast, as a fraction of the height of the face:
/// where the eyes are known, and where they are not.
const GATE: [f32; 2] = [0.12, 0.2];

impl FacePoints {
    /// Finds the points of a face. `given` are points that are known, which are kept as they are.
    ///
    /// # Errors
    /// [`NoFace`] if the surface shows too little of a face.
    pub fn find(surface: &FaceSurface, given: &[(PointId, Vec3)]) -> Result<Self, NoFace> {
        let joined = surface.joined();
        let parts = surface.parts(&joined);
        let mut anchors = Anchors::find(surface, &parts).ok_or(NoFace::Nose)?;
        anchors
            .points
            .retain(|(p, _)| !given.iter().any(|(g, _)| g == p));
        let dropped = gate(&mut anchors);
        let mut pairs: Vec<(Vec3, Vec3)> = anchors
            .points
            .iter()
            .filter_map(|(point, place)| Some((of(&FOUND, *point)?, *place)))
            .collect();
        let shown = || {
            anchors
                .shown
                .iter()
                .filter(|(p, _)| !given.iter().any(|(g, _)| g == p))
        };
        pairs.extend(shown().filter_map(|(p, place)| Some((of(&POINTS, *p)?, *place))));
        pairs.extend(
            anchors
                .widths
                .iter()
                .map(|(i, at)| (Vec3::from(WIDTHS[*i]), *at)),
        );
        if let Some(centres) = anchors.eye_centres {
            pairs.extend(EYE_CENTRES.map(Vec3::from).into_iter().zip(centres));
        }
        pairs.extend(
            given
                .iter()
                .filter_map(|(p, place)| Some((of(&POINTS, *p)?, *place))),
        );
        let has =
            |point: PointId| anchors.get(point).is_some() || given.iter().any(|(g, _)| *g == point);
        let has_eyes = has((3, 5)) || anchors.eye_centres.is_some() || !anchors.shown.is_empty();
        if !has((2, 2)) && !has_eyes {
            return Err(NoFace::MouthAndEyes);
        }
        let warp = Warp::fit(&pairs).ok_or(NoFace::MouthAndEyes)?;
        let height = face_height(|point| of(&POINTS, point).map_or(Vec3::ZERO, |p| warp.apply(p)));
        let face_parts = FaceParts::of(joined, &parts, &anchors, &surface.positions);
        let snap = Snap::new(surface, &face_parts, height);
        let points = FEATURE_POINTS.iter().filter_map(|entry| {
            let point = entry.point;
            let known = given.iter().find(|(g, _)| *g == point);
            let place = match known {
                Some((_, place)) => *place,
                None => warp.apply(of(&POINTS, point)?),
            };
            let source = match known {
                Some(_) => PointSource::Given,
                None if anchors.get(point).is_some() => PointSource::Geometry,
                None if shown().any(|(p, _)| *p == point) => PointSource::Shapes,
                None => PointSource::Template,
            };
            let vertex = (!is_inside(point))
                .then(|| snap.vertex(point, place))
                .flatten();
            let away = vertex.map_or(0.0, |v| snap.away(v, place));
            let is_blind = point.0 == 3 && source == PointSource::Template && !has_eyes;
            let unseen = if is_blind { UNSEEN_EYE } else { 1.0 };
            Some(FacePoint {
                point,
                place,
                vertex,
                source,
                confidence: unseen * on_skin(away / height) * confidence(point, source),
            })
        });
        let points = points.collect();
        Ok(Self {
            points,
            dropped,
            parts: face_parts,
            seen: anchors.points,
        })
    }

    /// Returns a point; `None` if the standard has no such point.
    pub fn get(&self, point: PointId) -> Option<&FacePoint> {
        self.points.get(feature_point_index(point)?)
    }

    /// Returns the height of the inner brows above the bottom of the chin, metres.
    pub fn height(&self) -> f32 {
        face_height(|point| self.get(point).map_or(Vec3::ZERO, |p| p.place))
    }

    /// Returns the triangles of the skin.
    pub fn skin(&self) -> &[[u32; 3]] {
        &self.parts.skin
    }

    /// Returns the vertices of the left and the right eyeball with the layers around it, ascending; `None` without
    /// eyeballs.
    pub fn eyeballs(&self) -> Option<[&[u32]; 2]> {
        let eyes = self.parts.eyeballs.as_ref()?;
        Some([0, 1].map(|eye: usize| eyes[eye].0.as_slice()))
    }

    /// Returns the distances by which FAPs are measured.
    pub fn units(&self) -> FaceUnits {
        FaceUnits::between(|point| self.get(point).map_or(Vec3::ZERO, |p| p.place))
    }
}

/// The warp that carries a head with these points to the template. `None` if they lie in a plane.
pub(in crate::face) fn to_template(points: &FacePoints) -> Option<Warp> {
    let pair = |p: &FacePoint| Some((p.place, of(&POINTS, p.point)?));
    let pairs: Vec<(Vec3, Vec3)> = points.points.iter().filter_map(pair).collect();
    Warp::fit(&pairs)
}

/// Removes points of mouth and chin that are far from where nose, skull and eyes let expect them;
/// returns them.
fn gate(anchors: &mut Anchors) -> Vec<PointId> {
    let both = |point: PointId| Some((of(&FOUND, point)?, anchors.get(point)?));
    let (Some((nose_t, nose)), Some((top_t, top))) = (both((9, 3)), both((11, 4))) else {
        return Vec::new();
    };
    let tall = (top.y - nose.y) / (top_t.y - nose_t.y);
    let eyes = both((3, 5)).zip(both((3, 6)));
    let scale = match eyes {
        Some(((left_t, left), (right_t, right))) => {
            let wide = (left.x - right.x) / (left_t.x - right_t.x);
            let high = (left.y + right.y - 2.0 * nose.y) / (left_t.y + right_t.y - 2.0 * nose_t.y);
            let tall = 0.5 * (tall + high);
            Vec3::new(wide, tall, 0.5 * (wide + tall))
        }
        None => Vec3::splat(tall),
    };
    let gate = GATE[usize::from(eyes.is_none())] * template_height() * scale.y;
    let mut dropped = Vec::new();
    anchors.points.retain(|(point, place)| {
        let Some(at) = of(&FOUND, *point) else {
            return true;
        };
        let forecast = nose + scale * (at - nose_t);
        let far = place.distance(forecast) > gate && matches!(point.0, 2 | 8);
        if far {
            dropped.push(*point);
        }
        !far
    });
    dropped
}

/// Whether a point is inside the head or above it, not on the skin.
fn is_inside(point: PointId) -> bool {
    matches!(point, (3, 5 | 6) | (6, _) | (7, _) | (9, 8..=11) | (11, 5))
}

/// Shares of test heads on which points are within 3 % of the height of the face
/// (`docs/results/face-points.md`). Corners of the jaw and brows are the worst of those carried over;
/// points without a landmark were looked at, not measured, and count as half sure.
fn confidence(point: PointId, source: PointSource) -> f32 {
    match (source, point) {
        (PointSource::Given, _) => 1.0,
        (PointSource::Geometry, (2, 10) | (3, 5 | 6) | (11, 4)) => 0.9,
        (PointSource::Geometry, _) => 0.99,
        (PointSource::Template, (2, 13 | 14)) => 0.75,
        (PointSource::Template, (4, 1 | 2)) => 0.8,
        (PointSource::Template, (4, _)) => 0.9,
        (PointSource::Template, (2, 1..=9) | (3, 1..=4 | 7 | 8 | 11 | 12) | (8, _)) => 0.95,
        (PointSource::Template, (9, 1..=5 | 12 | 15)) => 0.95,
        (PointSource::Shapes | PointSource::Template, _) => 0.5,
    }
}

/// Factor to the confidence of points of an eye of which nothing is seen.
const UNSEEN_EYE: f32 = 0.5;
/// Distance from the skin, by height of the face, up to which a place may be as sure as its kind: it is that within
/// which the points of test heads count as found.
const ON_SKIN: f32 = 0.03;

/// Factor to the confidence of a point whose place is this far from the skin, by height of the face: it cannot be right
/// there.
fn on_skin(away: f32) -> f32 {
    (ON_SKIN / away.max(ON_SKIN)).powi(2)
}

/// Search of the vertex that stands for a place.
pub(in crate::face) struct Snap<'a> {
    surface: &'a FaceSurface,
    parts: &'a FaceParts,
    normals: Vec<Vec3>,
    height: f32,
}

impl<'a> Snap<'a> {
    /// Computes the normals of the skin. `height` is that of the face.
    pub(in crate::face) fn new(
        surface: &'a FaceSurface,
        parts: &'a FaceParts,
        height: f32,
    ) -> Self {
        let mut normals = vec![Vec3::ZERO; surface.positions.len()];
        for triangle in &parts.skin {
            let normal = surface.doubled_normal(triangle);
            triangle.iter().for_each(|v| normals[*v as usize] += normal);
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        Self {
            surface,
            parts,
            normals,
            height,
        }
    }

    /// Distance of a place from the skin, but at most that from a vertex of it; vertices of a coarse skin are far apart.
    fn away(&self, vertex: u32, place: Vec3) -> f32 {
        let near = self.surface.positions[vertex as usize].distance(place);
        if near <= ON_SKIN * self.height {
            return near;
        }
        let triangles = self.parts.skin.iter().map(|t| self.surface.corners(t));
        let squares = triangles.map(|corners| triangle_distance_squared(place, corners));
        squares.fold(near * near, f32::min).sqrt()
    }

    /// The nearest vertex; for the rims of lips and lids, one that faces the opening.
    pub(in crate::face) fn vertex(&self, point: PointId, place: Vec3) -> Option<u32> {
        // Towards which side the rim faces: upper ones down.
        let faces = match point {
            (2, 2 | 6 | 7) | (3, 1 | 2) => -1.0,
            (2, 3 | 8 | 9) | (3, 3 | 4) => 1.0,
            _ => 0.0,
        };
        let cost = |v: &u32| {
            let at = self.surface.positions[*v as usize];
            let turned: f32 = 0.15 - faces * self.normals[*v as usize].y;
            let wrong = if faces == 0.0 { 0.0 } else { turned.max(0.0) };
            at.distance(place) + 0.06 * self.height * wrong
        };
        let vertices = self.parts.skin_vertices.iter().copied();
        vertices.min_by(|a, b| cost(a).total_cmp(&cost(b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_far_from_the_skin_is_not_sure() {
        // Up to 3 % of the height of the face as sure as its kind, at 12 % a sixteenth of that.
        assert_eq!([0.0, 0.02, 0.03].map(on_skin), [1.0; 3]);
        assert!((on_skin(0.12) - 1.0 / 16.0).abs() < 1e-6);
    }
}
