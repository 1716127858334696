//! The motion of a blend shape that a head has, over the chart of its mouth.

use super::chart::{COLUMNS, MouthChart, Place, ROWS, STEP, node};
use super::motion::Motion;
use articula_core::Libm;
use glam::{DMat3, DVec3, Vec2, Vec3};

/// Least radius of the vertices that a node is fitted to, by half the width of the mouth, and that radius by the length of
/// a unit of the level.
const LEAST: f32 = 0.1;
const OF_CELL: f32 = 0.12;
/// Factors to it that are tried until enough vertices are within.
const WIDER: [f32; 6] = [1.0, 1.5, 2.2, 3.3, 5.0, 8.0];
/// Weight from which a vertex is within, and how many must be.
const WITHIN: f32 = 0.3;
const ENOUGH: usize = 4;
/// How much slopes are held back, by the weights and the radius.
const FLATTENED: f64 = 0.3;

/// The vertices that are fitted at a node, with the coefficient of each.
pub(super) struct Fit {
    terms: Vec<(u32, f32)>,
}

/// The fits of all nodes: moving least squares (Lancaster and Salkauskas 1981) over the seen vertices of the sheet; the
/// nodes beside the corners are of both sheets.
pub(super) fn fits(chart: &MouthChart) -> Vec<Fit> {
    let sheets = [0, 1].map(|sheet| {
        let of = chart.places.iter();
        let of = of.filter(|p| p.is_seen && (p.lower >= 0.5) == (sheet == 1));
        of.copied().collect::<Vec<Place>>()
    });
    let mut fits = Vec::with_capacity(COLUMNS * ROWS);
    for column in 0..COLUMNS {
        let of = match column {
            _ if column % (COLUMNS / 2) == 0 => &sheets[..],
            _ if column < COLUMNS / 2 => &sheets[..1],
            _ => &sheets[1..],
        };
        for row in 0..ROWS {
            fits.push(fit(of, node(column, row), radius(column, row)));
        }
    }
    fits
}

/// The radius of the vertices of a node: a share of what a unit of the level is long there.
fn radius(column: usize, row: usize) -> f32 {
    let length = (node(column, row + 1) - node(column, row)).length() / STEP;
    (OF_CELL * length).max(LEAST)
}

fn fit(sheets: &[Vec<Place>], at: Vec2, radius: f32) -> Fit {
    let of = sheets.iter().map(|sheet| of_sheet(sheet, at, radius));
    let of: Vec<Vec<(u32, f32)>> = of.filter(|terms| !terms.is_empty()).collect();
    let share = 1.0 / of.len().max(1) as f32;
    let terms = of.into_iter().flatten().map(|(v, c)| (v, share * c));
    Fit {
        terms: terms.collect(),
    }
}

/// The coefficients of vertices in the value at a place of the line fitted to them.
fn of_sheet(sheet: &[Place], at: Vec2, radius: f32) -> Vec<(u32, f32)> {
    let mut near: Vec<(&Place, f32)> = Vec::new();
    let mut reach = radius;
    for wider in WIDER {
        reach = radius * wider;
        let weight = |p: &Place| (-p.flat.distance_squared(at) / (2.0 * reach * reach)).libm_exp();
        near = sheet
            .iter()
            .map(|p| (p, weight(p)))
            .filter(|n| n.1 > 1e-4)
            .collect();
        if near.iter().filter(|n| n.1 > WITHIN).count() >= ENOUGH {
            break;
        }
    }
    let basis = |p: &Place| (p.flat - at).extend(1.0).as_dvec3();
    let mut matrix = DMat3::ZERO;
    let mut weights = 0.0;
    for (place, weight) in &near {
        let (b, w) = (basis(place), f64::from(*weight));
        matrix += w * DMat3::from_cols(b * b.x, b * b.y, b * b.z);
        weights += w;
    }
    if weights <= 0.0 {
        return Vec::new();
    }
    let held = FLATTENED * weights * f64::from(reach).powi(2);
    matrix += DMat3::from_diagonal(DVec3::new(held, held, 1e-9 * weights));
    let value = matrix.inverse() * DVec3::Z;
    let term = |(place, weight): &(&Place, f32)| {
        (
            place.vertex,
            (f64::from(*weight) * value.dot(basis(place))) as f32,
        )
    };
    near.iter().map(term).collect()
}

/// The motion that displacements of the vertices show, metres.
pub(super) fn motion(chart: &MouthChart, fits: &[Fit], displacements: &[Vec3]) -> Motion {
    let value = |fit: &Fit| -> Vec3 {
        let terms = fit.terms.iter();
        terms.map(|(v, c)| *c * displacements[*v as usize]).sum()
    };
    Motion {
        nodes: fits.iter().map(|fit| value(fit) / chart.height).collect(),
    }
}
