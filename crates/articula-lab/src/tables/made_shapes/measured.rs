//! What is measured of the shapes of a head.

use super::contours::Contours;
use super::faults::Faults;
use super::gap::gap;
use super::heads::Head;
use crate::tables::seen::seen;
use articula_build::face::FaceSurface;
use articula_core::arkit_table::BLEND_SHAPES;
use glam::Vec3;

/// Share of the largest displacement from which a vertex counts.
const COUNTS: f32 = 0.05;
/// Displacement below which an eyeball rests, metres.
const RESTS: f32 = 1e-5;

/// A shape that was made, beside the own one where the head has it; lengths in millimetres.
#[derive(Debug, Clone)]
pub(super) struct Row {
    pub(super) shape: &'static str,
    /// Largest displacement of the own and of the made shape.
    pub(super) own: Option<f32>,
    pub(super) made: f32,
    /// At equal amplitude: mean error of the vertices, 95th percentile, contours of the lips and of the lids.
    pub(super) errors: Option<[f32; 2]>,
    pub(super) lips: Option<f32>,
    pub(super) lids: Option<f32>,
    /// What `eyeBlink` leaves open: the own, the made shape.
    pub(super) gaps: Option<[Option<f32>; 2]>,
    /// Triangles turned over: by the own shape, and by the made one alone.
    pub(super) flips: [usize; 2],
    /// Pairs of triangles that cross: the same.
    pub(super) crossings: [usize; 2],
}

/// All shapes of ARKit that the head or the made ones have; own alone where none was made.
pub(super) fn rows(head: &Head) -> Vec<Row> {
    let Ok(made) = &head.made else {
        return Vec::new();
    };
    let (own, points) = (&head.own, &head.points);
    let contours = Contours::of(own, points);
    let faults = Faults::new(own, points.skin());
    let seen = seen(own, points.height());
    let shapes = BLEND_SHAPES.iter().filter_map(|shape| {
        let made = shown(made, shape.name)?;
        Some(row(head, (&contours, &faults, &seen), shape.name, &made))
    });
    shapes.collect()
}

fn row(
    head: &Head,
    (contours, faults, seen): (&Contours, &Faults<'_>, &[bool]),
    shape: &'static str,
    made: &[Vec3],
) -> Row {
    let rest = &head.own.positions;
    let own = shown(&head.own, shape);
    let own = own.as_deref();
    let eye = usize::from(shape.ends_with("Right"));
    let seen = &counted(head, own, seen);
    let most = |moved: &[Vec3]| largest(moved, seen);
    let alike: Option<Vec<Vec3>> = own.map(|own| {
        let factor = most(own) / most(made).max(1e-9);
        made.iter().map(|d| factor * *d).collect()
    });
    let pair = own.zip(alike.as_deref());
    let of = |shapes: &[&str]| shapes.iter().any(|s| shape.starts_with(s));
    let lips = pair.filter(|_| of(&["mouth", "jaw"]));
    let lids = pair.filter(|_| of(&["eye"]));
    let opening = |moved: &[Vec3]| gap((&head.own, &head.points), moved, eye).map(|g| 1e3 * g);
    let flips = own.map(|own| faults.flips(own)).unwrap_or_default();
    let crossings = own.map(|own| faults.crossings(own)).unwrap_or_default();
    let alone = faults.flips(made).difference(&flips).count();
    let crossed = faults.crossings(made).difference(&crossings).count();
    Row {
        shape,
        own: own.map(|own| 1e3 * most(own)),
        made: 1e3 * most(made),
        errors: pair.map(|(own, alike)| errors(own, alike, seen)),
        lips: lips
            .and_then(|(own, alike)| contours.lips(rest, [own, alike]))
            .map(|d| 1e3 * d),
        lids: lids
            .and_then(|(own, alike)| contours.lids(eye, rest, [own, alike]))
            .map(|d| 1e3 * d),
        gaps: of(&["eyeBlink"]).then(|| [own.and_then(opening), opening(made)]),
        flips: [flips.len(), alone],
        crossings: [crossings.len(), crossed],
    }
}

/// What is looked at of a shape: `mouthClose` alone would take the lips through each other, it is made to be shown with
/// `jawOpen`.
fn shown(surface: &FaceSurface, shape: &str) -> Option<Vec<Vec3>> {
    let mut all = offsets(surface, shape)?.to_vec();
    if shape == "mouthClose" {
        let jaw = offsets(surface, "jawOpen")?;
        all.iter_mut().zip(jaw).for_each(|(d, jaw)| *d += *jaw);
    }
    Some(all)
}

fn offsets<'a>(surface: &'a FaceSurface, shape: &str) -> Option<&'a [Vec3]> {
    let found = surface.shapes.iter().find(|(name, _)| *name == shape);
    found.map(|(_, offsets)| offsets.as_slice())
}

/// The vertices that are seen, without eyeballs that the own shape leaves at rest: a head may turn them by other means.
fn counted(head: &Head, own: Option<&[Vec3]>, seen: &[bool]) -> Vec<bool> {
    let mut counted = seen.to_vec();
    let balls = head.points.eyeballs().into_iter().flatten().flatten();
    let balls: Vec<usize> = balls.map(|v| *v as usize).collect();
    if own.is_some_and(|own| balls.iter().all(|v| own[*v].length() < RESTS)) {
        balls.iter().for_each(|v| counted[*v] = false);
    }
    counted
}

fn largest(moved: &[Vec3], seen: &[bool]) -> f32 {
    let seen = moved.iter().zip(seen).filter(|(_, seen)| **seen);
    seen.map(|(d, _)| d.length()).fold(0.0, f32::max)
}

/// Mean and 95th percentile over the seen vertices that either shape moves, millimetres.
fn errors(own: &[Vec3], made: &[Vec3], seen: &[bool]) -> [f32; 2] {
    let least = COUNTS * largest(own, seen);
    let pairs = own.iter().zip(made).zip(seen).filter(|(_, seen)| **seen);
    let moved = pairs.filter(|((a, b), _)| a.length().max(b.length()) > least);
    let mut all: Vec<f32> = moved.map(|((a, b), _)| 1e3 * a.distance(*b)).collect();
    all.sort_by(f32::total_cmp);
    let count = all.len().max(1);
    let p95 = all.get(95 * count / 100).copied().unwrap_or(0.0);
    [all.iter().sum::<f32>() / count as f32, p95]
}
