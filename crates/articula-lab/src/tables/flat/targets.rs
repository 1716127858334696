//! The acceptance bounds of `docs/methods/vector.md`, part 9, and the measured values.

use super::Found;
use super::cases::Kind;
use super::profiles::{FLAT, GOURAUD, PLAYER, PLAYER_COARSE};
use crate::tables::targets::{self, Target};
use articula_flat::flatten::Flattened;

/// A quantity with the number of its bound in `docs/methods/vector.md`, part 9.
type Numbered = (u8, &'static str);

/// The section of the page.
pub(super) fn section(all: &[Found]) -> String {
    let targets: Vec<Target> = all.iter().flat_map(of).collect();
    targets::section(ABOUT, &["bound", "case", "quantity"], &targets)
}

const ABOUT: &str = "The acceptance bounds of docs/methods/vector.md, part 9.";

/// The bounds of a case.
fn of(found: &Found) -> Vec<Target> {
    let mut all = Vec::new();
    let is_face = found.case.kind == Kind::Face;
    if found.case.kind != Kind::Other {
        flat(found, is_face, &mut all);
    }
    if is_face {
        gouraud(found, &mut all);
        still(found, &mut all);
    }
    if found.case.kind != Kind::Other {
        player(found, is_face, &mut all);
    }
    order(found, &mut all);
    all
}

fn at_most(found: &Found, (number, what): Numbered, most: f64, value: f64) -> Target {
    let labels = [&number.to_string(), found.case.name, what];
    Target::at_most(labels, most, value)
}

fn at_least(found: &Found, (number, what): Numbered, least: f64, value: f64) -> Target {
    let labels = [&number.to_string(), found.case.name, what];
    Target::at_least(labels, least, value)
}

/// Bytes per triangle and frame, raw and with Brotli.
fn per(flat: &Flattened) -> (f64, f64) {
    let of = |bytes| flat.per_triangle_and_frame(bytes);
    (of(flat.sizes.raw), of(flat.sizes.brotli))
}

fn flat(found: &Found, is_face: bool, all: &mut Vec<Target>) {
    let Some(row) = found.row(FLAT) else {
        return;
    };
    let (raw, brotli) = per(&row.flat);
    let (raw_most, brotli_most) = if is_face { (6.0, 1.1) } else { (18.0, 3.0) };
    let off = row.flat.errors.position_rmse_px;
    all.extend([
        at_most(
            found,
            (1, "flat smil, bytes per triangle and frame"),
            raw_most,
            raw,
        ),
        at_most(found, (1, "the same, brotli"), brotli_most, brotli),
        at_most(found, (1, "corner error, px"), 0.5, off),
    ]);
}

fn gouraud(found: &Found, all: &mut Vec<Target>) {
    let Some(row) = found.row(GOURAUD) else {
        return;
    };
    let (raw, brotli) = per(&row.flat);
    let image = row.flat.errors.image;
    all.extend([
        at_most(
            found,
            (2, "gouraud smil, bytes per triangle and frame"),
            12.0,
            raw,
        ),
        at_most(found, (2, "the same, brotli"), 1.9, brotli),
        at_most(
            found,
            (2, "colour RMSE in levels, worst frame"),
            6.5,
            image.rmse_levels_max,
        ),
        at_least(found, (2, "SSIM, worst frame"), 0.985, image.ssim_min),
    ]);
}

fn still(found: &Found, all: &mut Vec<Target>) {
    let flat = &found.stills.ours;
    let image = flat.errors.image;
    all.extend([
        at_most(found, (3, "still, bytes per triangle"), 125.0, per(flat).0),
        at_most(found, (3, "colour RMSE in levels"), 4.5, image.rmse_levels),
        at_least(found, (3, "SSIM"), 0.99, image.ssim),
    ]);
}

fn player(found: &Found, is_face: bool, all: &mut Vec<Target>) {
    let (name, bytes, off) = if is_face {
        (PLAYER, 0.5, 0.1)
    } else {
        (PLAYER_COARSE, 0.8, 0.2)
    };
    let Some(row) = found.row(name) else {
        return;
    };
    let found_off = row.flat.errors.position_rmse_px;
    all.extend([
        at_most(
            found,
            (4, "player, bytes per triangle and frame"),
            bytes,
            per(&row.flat).0,
        ),
        at_most(found, (4, "corner error, px"), off, found_off),
    ]);
}

fn order(found: &Found, all: &mut Vec<Target>) {
    let orders = &found.orders;
    let share = orders.split / orders.depth_sort.max(1e-9);
    all.push(at_most(
        found,
        (5, "wrong pixels, fraction of the depth sort's"),
        0.5,
        share,
    ));
    if found.case.kind == Kind::Walk {
        let what = "wrong pixels after cutting, percent";
        all.push(at_most(found, (5, what), 0.5, orders.split));
    }
}
