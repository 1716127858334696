//! The acceptance bounds of `docs/methods/vector.md`, part 9, and the measured values.

use super::Found;
use super::cases::Kind;
use super::profiles::{FLAT, GOURAUD, PLAYER, PLAYER_COARSE};
use articula_flat::flatten::Flattened;

/// A bound and the measured value.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// Number of the bound in `docs/methods/vector.md`, part 9.
    pub(super) number: u8,
    pub(super) what: &'static str,
    pub(super) bound: Bound,
    pub(super) found: f64,
}

/// An upper or lower limit.
#[derive(Debug, Clone, Copy)]
pub(super) enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

impl Target {
    pub(super) fn holds(&self) -> bool {
        match self.bound {
            Bound::AtMost(most) => self.found <= most,
            Bound::AtLeast(least) => self.found >= least,
        }
    }
}

/// The bounds of a case.
pub(super) fn of(found: &Found) -> Vec<Target> {
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

fn at_most(number: u8, what: &'static str, most: f64, found: f64) -> Target {
    let bound = Bound::AtMost(most);
    Target {
        number,
        what,
        bound,
        found,
    }
}

fn at_least(number: u8, what: &'static str, least: f64, found: f64) -> Target {
    let bound = Bound::AtLeast(least);
    Target {
        number,
        what,
        bound,
        found,
    }
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
        at_most(1, "flat smil, bytes per triangle and frame", raw_most, raw),
        at_most(1, "the same, brotli", brotli_most, brotli),
        at_most(1, "corner error, px", 0.5, off),
    ]);
}

fn gouraud(found: &Found, all: &mut Vec<Target>) {
    let Some(row) = found.row(GOURAUD) else {
        return;
    };
    let (raw, brotli) = per(&row.flat);
    let image = row.flat.errors.image;
    all.extend([
        at_most(2, "gouraud smil, bytes per triangle and frame", 12.0, raw),
        at_most(2, "the same, brotli", 1.9, brotli),
        at_most(
            2,
            "colour RMSE in levels, worst frame",
            6.5,
            image.rmse_levels_max,
        ),
        at_least(2, "SSIM, worst frame", 0.985, image.ssim_min),
    ]);
}

fn still(found: &Found, all: &mut Vec<Target>) {
    let flat = &found.stills.ours;
    let image = flat.errors.image;
    all.extend([
        at_most(3, "still, bytes per triangle", 125.0, per(flat).0),
        at_most(3, "colour RMSE in levels", 4.5, image.rmse_levels),
        at_least(3, "SSIM", 0.99, image.ssim),
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
            4,
            "player, bytes per triangle and frame",
            bytes,
            per(&row.flat).0,
        ),
        at_most(4, "corner error, px", off, found_off),
    ]);
}

fn order(found: &Found, all: &mut Vec<Target>) {
    let orders = &found.orders;
    let share = orders.split / orders.depth_sort.max(1e-9);
    all.push(at_most(
        5,
        "wrong pixels, fraction of the depth sort's",
        0.5,
        share,
    ));
    if found.case.kind == Kind::Walk {
        let what = "wrong pixels after cutting, percent";
        all.push(at_most(5, what, 0.5, orders.split));
    }
}
