//! The 84 feature points of the face of [`human`](crate::human), where it is constructed.
//!
//! They do not depend on the number of triangles, and no search finds them: a truth for those that
//! are found on meshes.

use crate::body::Body;
use crate::eyes::{self, EYE, EYE_RADIUS, Lid};
use crate::field::Group;
use crate::front::on_skin;
use crate::mouth::{self, CORNER, LINE, OPENING, Side};
use crate::person_head;
use crate::polygonise::onto;
use crate::skeleton;
use articula_core::feature_points::{FEATURE_POINTS, PointId};
use glam::Vec3;

/// A feature point of the human's face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeaturePoint {
    /// Group and number.
    pub point: PointId,
    /// Place in the rest pose in metres.
    pub position: Vec3,
}

/// The feature points of the human with a face, in the order of
/// [`FEATURE_POINTS`]. They are the same for every triangle count, and the right side is the exact
/// mirror image of the left. Closed lips touch: 2.2 and 2.3 are at the same place.
pub fn feature_points() -> Vec<FeaturePoint> {
    let face = Face {
        body: person_head::body(),
        closed: person_head::closed_head(),
        hair: person_head::hair(),
    };
    let of = |point: PointId, mirror: PointId| match face.left(point) {
        Some(position) => position,
        None => face.left(mirror).unwrap_or(Vec3::ZERO) * Vec3::new(-1.0, 1.0, 1.0),
    };
    let points = FEATURE_POINTS.iter().map(|entry| FeaturePoint {
        point: entry.point,
        position: of(entry.point, entry.mirror),
    });
    points.collect()
}

struct Face {
    body: Body,
    closed: Group,
    hair: Group,
}

impl Face {
    /// A point in the middle or on the left; `None` for one on the right.
    fn left(&self, point: PointId) -> Option<Vec3> {
        match point.0 {
            2 => self.jaw(point.1),
            3 => self.eye(point.1),
            4 | 5 => self.brow_or_cheek(point),
            6 => Some(mouth::tongue_point(&self.closed, point.1)).filter(|_| point.1 != 4),
            7 => Some(skeleton::centers()[skeleton::joint("skullbase")]),
            8 => self.lip(point.1),
            9 => self.nose_or_teeth(point.1),
            10 => self.ear(point.1),
            _ => self.skull(point.1),
        }
    }

    /// The point of the head nearest to one before it.
    fn near(&self, x: f32, y: f32, z: f32) -> Vec3 {
        let field = |p: Vec3| self.body.distance(p);
        onto(&field, Vec3::new(x, y, z), x == 0.0, 40)
    }

    /// The point of the face at x and y, seen from the front.
    fn front(&self, x: f32, y: f32) -> Vec3 {
        let p = on_skin(&self.closed, [x, y], 0.0);
        Vec3::new(x, p.y, p.z)
    }

    fn jaw(&self, number: u8) -> Option<Vec3> {
        let inner = |x: f32| mouth::inner_contour(&self.closed, x);
        Some(match number {
            1 => self.near(0.0, 1.515, 0.066),
            2 | 3 => inner(0.0),
            4 => inner(OPENING),
            6 | 8 => inner(0.5 * OPENING),
            10 => self.front(0.0, 1.54),
            11 => self.front(0.02, 1.54),
            13 => self.near(0.065, 1.562, -0.004),
            _ => return None,
        })
    }

    fn eye(&self, number: u8) -> Option<Vec3> {
        let rim = |lid: Lid| eyes::rim_point(lid, 0.0);
        Some(match number {
            1 => rim(Lid::Upper),
            3 => rim(Lid::Lower),
            5 => EYE + Vec3::Z * EYE_RADIUS,
            7 => eyes::rim_point(Lid::Upper, eyes::CORNER),
            11 => eyes::rim_point(Lid::Upper, -eyes::CORNER),
            // Where the lids come out below the skin.
            9 => self.front(EYE.x, EYE.y - 0.0115),
            13 => self.front(EYE.x, EYE.y + 0.0105),
            _ => return None,
        })
    }

    fn brow_or_cheek(&self, point: PointId) -> Option<Vec3> {
        let [x, y] = match point {
            (4, 1) => [0.0115, 1.6585],
            (4, 3) => [0.034, 1.6656],
            (4, 5) => [0.0512, 1.657],
            (5, 1) => [0.04, 1.588],
            (5, 3) => [0.045, 1.612],
            _ => return None,
        };
        Some(self.front(x, y))
    }

    fn lip(&self, number: u8) -> Option<Vec3> {
        let outer = |side: Side, along: f32| {
            let [x, y] = mouth::outer_contour(side, along);
            self.front(x, y)
        };
        Some(match number {
            1 => outer(Side::Upper, 0.0),
            2 => outer(Side::Lower, 0.0),
            3 => self.front(1.04 * CORNER, mouth::line(CORNER)),
            5 => outer(Side::Upper, 0.5),
            7 => outer(Side::Lower, 0.5),
            10 => outer(Side::Upper, mouth::BOW),
            _ => return None,
        })
    }

    fn nose_or_teeth(&self, number: u8) -> Option<Vec3> {
        let teeth = |side, row: usize| mouth::teeth_point(&self.closed, side, row);
        Some(match number {
            1 => self.near(0.0175, 1.598, 0.084),
            3 => self.front(0.0, 1.6005),
            5 => self.near(0.009, 1.588, 0.09),
            7 => self.front(0.0075, 1.638),
            8 => teeth(Side::Upper, 0),
            9 => teeth(Side::Lower, 0),
            10 => teeth(Side::Upper, 2),
            11 => teeth(Side::Lower, 2),
            12 => self.front(0.0, 1.618),
            13 => self.front(0.0085, 1.614),
            15 => self.front(0.0, 1.5905),
            _ => return None,
        })
    }

    fn ear(&self, number: u8) -> Option<Vec3> {
        Some(match number {
            1 => self.near(0.0765, 1.664, -0.019),
            3 => self.near(0.081, 1.634, -0.038),
            5 => self.near(0.073, 1.598, -0.011),
            7 => self.near(0.0685, 1.609, -0.002),
            9 => self.near(0.071, 1.648, -0.001),
            _ => return None,
        })
    }

    fn skull(&self, number: u8) -> Option<Vec3> {
        Some(match number {
            1 => self.hairline(0.0),
            3 => self.hairline(0.05),
            4 => self.near(0.0, 1.752, -0.012),
            5 => onto(
                &|p: Vec3| self.hair.distance(p),
                Vec3::new(0.0, 1.765, -0.012),
                true,
                40,
            ),
            6 => self.near(0.0, 1.665, -0.11),
            _ => return None,
        })
    }

    /// The lowest point of the forehead at x that hair covers.
    fn hairline(&self, x: f32) -> Vec3 {
        let steps = (0..400).map(|i| self.front(x, LINE + 0.1 + 2.5e-4 * i as f32));
        let mut points = steps.peekable();
        let highest = points.peek().copied().unwrap_or_default();
        points
            .find(|p| self.hair.distance(*p) < 0.0)
            .unwrap_or(highest)
    }
}
