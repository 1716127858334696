//! The targets of the specification, and what was found.
//!
//! Source: `spec/vector.md` 9.

use super::Found;
use super::cases::Kind;
use super::profiles::{FLAT, GOURAUD, PLAYER};

/// A bound and what was found.
#[derive(Debug, Clone)]
pub(super) struct Target {
    /// Number in the specification.
    pub(super) number: u8,
    pub(super) what: &'static str,
    pub(super) bound: Bound,
    pub(super) found: f64,
}

/// Which side of a number is good.
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

/// The targets of a case.
pub(super) fn of(found: &Found) -> Vec<Target> {
    let mut all = Vec::new();
    let mut add = |number, what, bound, found| {
        all.push(Target {
            number,
            what,
            bound,
            found,
        });
    };
    let per = |name: &str| {
        found.row(name).map(|row| {
            let flat = &row.flat;
            let (raw, brotli) = (flat.sizes.raw, flat.sizes.brotli);
            (
                flat,
                flat.per_triangle_and_frame(raw),
                flat.per_triangle_and_frame(brotli),
            )
        })
    };
    let bounds = match found.case.kind {
        Kind::Face => Some((6.0, 1.1, 0.5)),
        Kind::Walk => Some((18.0, 3.0, 0.8)),
        Kind::Other => None,
    };
    if let Some((raw_most, brotli_most, player_most)) = bounds {
        if let Some((flat, raw, brotli)) = per(FLAT) {
            add(
                1,
                "flat smil, bytes a triangle and frame",
                Bound::AtMost(raw_most),
                raw,
            );
            add(1, "the same by brotli", Bound::AtMost(brotli_most), brotli);
            add(
                1,
                "corners off, px",
                Bound::AtMost(0.5),
                flat.errors.position_rmse_px,
            );
        }
        let player = if found.case.kind == Kind::Face {
            PLAYER
        } else {
            "player gouraud 0.2 px"
        };
        if let Some((flat, raw, _)) = per(player) {
            let off = if found.case.kind == Kind::Face {
                0.1
            } else {
                0.2
            };
            add(
                4,
                "player, bytes a triangle and frame",
                Bound::AtMost(player_most),
                raw,
            );
            add(
                4,
                "corners off, px",
                Bound::AtMost(off),
                flat.errors.position_rmse_px,
            );
        }
    }
    if found.case.kind == Kind::Face {
        if let Some((flat, raw, brotli)) = per(GOURAUD) {
            let image = flat.errors.image;
            add(
                2,
                "gouraud smil, bytes a triangle and frame",
                Bound::AtMost(12.0),
                raw,
            );
            add(2, "the same by brotli", Bound::AtMost(1.9), brotli);
            add(
                2,
                "levels off, worst moment",
                Bound::AtMost(6.5),
                image.rmse_levels_max,
            );
            add(
                2,
                "SSIM, worst moment",
                Bound::AtLeast(0.985),
                image.ssim_min,
            );
        }
        let still = &found.stills.ours;
        let image = still.errors.image;
        let bytes = still.per_triangle_and_frame(still.sizes.raw);
        add(3, "still, bytes a triangle", Bound::AtMost(125.0), bytes);
        add(3, "levels off", Bound::AtMost(4.5), image.rmse_levels);
        add(3, "SSIM", Bound::AtLeast(0.99), image.ssim);
    }
    let orders = &found.orders;
    let share = orders.epochs / orders.depth_sort.max(1e-9);
    add(
        5,
        "wrong pixels, share of the depth sort's",
        Bound::AtMost(0.5),
        share,
    );
    all
}
