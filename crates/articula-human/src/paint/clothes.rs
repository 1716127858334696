//! Shirt, trousers and shoes.

use super::{between, mix, spot};
use crate::body::Body;
use crate::person_head::Borders;
use glam::{Vec2, Vec3};

const PALE: Vec3 = Vec3::new(0.72, 0.66, 0.53);
const THREAD: Vec3 = Vec3::new(0.3, 0.18, 0.075);
const LEATHER: Vec3 = Vec3::new(0.1, 0.05, 0.028);

/// A shirt with a collar, a short row of buttons and stripes.
pub(super) struct Shirt<'a> {
    borders: Borders<'a>,
}

impl<'a> Shirt<'a> {
    pub(super) fn new(body: &'a Body) -> Self {
        Self {
            borders: Borders::new(body),
        }
    }

    pub(super) fn color(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let base = Vec3::new(0.16, 0.36, 0.43);
        let dark = Vec3::new(0.055, 0.15, 0.2);
        let stripe = between(p.y, 1.262, 1.296, 0.001).max(between(p.y, 1.243, 1.25, 0.001));
        let striped = mix(base, PALE, stripe);
        // Ribs of collar, sleeves and hem.
        let border = self.borders.shirt(p);
        let rib = between(border, -1.0, 0.013, 0.0008).max(between(p.y, 0.0, 1.003, 0.0008));
        let seam = between(border, 0.013, 0.0155, 0.0008).max(between(p.y, 1.003, 1.0055, 0.0008));
        let ribbed = mix(mix(striped, dark, 0.6 * seam), dark, rib);
        if normal.z < 0.2 || p.y < 1.33 {
            return ribbed;
        }
        let placket = between(p.x, -1.0, 0.0125, 0.0008) * between(p.y, 1.338, 2.0, 0.001);
        let edge = between(p.x, 0.0105, 0.0125, 0.0008) * placket;
        let buttoned = mix(
            mix(ribbed, base * 0.85, placket * (1.0 - rib)),
            dark,
            0.7 * edge,
        );
        let button = [1.355, 1.395, 1.435].map(|y| {
            let far = Vec2::new(p.x, p.y - y).length();
            between(far, -1.0, 0.0048, 0.0008)
        });
        let button = button.into_iter().fold(0.0, f32::max);
        mix(buttoned, PALE, button)
    }
}

/// Trousers with a belt, pockets and seams, worn at the knees.
pub(super) fn trousers(p: Vec3, normal: Vec3) -> Vec3 {
    let is_front = normal.z >= 0.0;
    let base = Vec3::new(0.06, 0.075, 0.135);
    let worn = match is_front {
        true => spot(p, [0.1, 0.5, 0.055], 0.12).max(0.8 * spot(p, [0.095, 0.72, 0.078], 0.17)),
        false => 0.7 * spot(p, [0.075, 0.885, -0.11], 0.13),
    };
    let cloth = mix(base, Vec3::new(0.14, 0.17, 0.27), 0.75 * worn);
    let hem = between(Borders::shoe(p), 0.015, 0.0185, 0.001);
    let stitches = match is_front {
        true => front_stitches(p),
        false => back_stitches(p),
    };
    let sewn = mix(
        cloth,
        THREAD,
        0.9 * hem.max(stitches) * between(p.y, 0.0, 0.95, 0.001),
    );
    let fly = between(p.x, -1.0, 0.0012, 0.0008) * between(p.y, 0.87, 0.95, 0.001);
    let sewn = mix(sewn, base * 0.3, fly * f32::from(is_front));
    let belt = between(p.y, 0.952, 2.0, 0.0008);
    let belted = mix(sewn, belt_color(p, is_front), belt);
    let loops = [0.062, 0.125].map(|x| between(p.x, x - 0.0045, x + 0.0045, 0.0008));
    mix(
        belted,
        base,
        loops[0].max(loops[1]) * between(p.y, 0.948, 2.0, 0.001),
    )
}

/// Leather with a buckle in front.
fn belt_color(p: Vec3, is_front: bool) -> Vec3 {
    if !is_front {
        return LEATHER;
    }
    let metal = Vec3::new(0.52, 0.46, 0.34);
    let within = |x: f32, y: f32| {
        between(p.x, -1.0, x, 0.0008) * between((p.y - 0.969).abs(), -1.0, y, 0.0008)
    };
    mix(
        mix(LEATHER, metal, within(0.021, 0.0125)),
        LEATHER,
        within(0.0155, 0.0075),
    )
}

/// The curved opening of a pocket, and the seam beside the fly.
fn front_stitches(p: Vec3) -> f32 {
    let far = Vec2::new(p.x - 0.148, p.y - 0.965).length();
    let pocket = between(far, 0.0595, 0.0635, 0.0008);
    let fly = between(p.x, 0.0135, 0.0165, 0.0008) * between(p.y, 0.885, 0.95, 0.001);
    pocket.max(fly)
}

/// The outline of a pocket.
fn back_stitches(p: Vec3) -> f32 {
    let pocket = |by: f32| {
        let low = 0.842 + 0.25 * (p.x - 0.078).abs() - by;
        between(p.x, 0.042 - by, 0.114 + by, 0.0006) * between(p.y, low, 0.925 + by, 0.0006)
    };
    pocket(0.0018) * (1.0 - pocket(-0.0018))
}

/// Shoes with a light sole and laces.
pub(super) fn shoes(p: Vec3, normal: Vec3) -> Vec3 {
    let leather = Vec3::new(0.3, 0.19, 0.12);
    let heel = between(p.z, -1.0, -0.062, 0.001) * between(p.y, 0.0, 0.068, 0.001);
    let cap = between(p.z, 0.102, 1.0, 0.001);
    let patched = mix(leather, leather * 0.62, heel.max(cap));
    let seam = between(p.z, 0.0995, 0.1025, 0.0008).max(between(p.z, -0.0625, -0.0595, 0.0008));
    let sewn = mix(
        patched,
        leather * 0.35,
        0.7 * seam * between(p.y, 0.0, 0.07, 0.001),
    );
    let laced = laces(sewn, p, normal);
    let edge = between(p.y, 0.0, 0.0235, 0.0006);
    let sole = between(p.y, 0.0, 0.0205, 0.0006);
    let soled = mix(mix(laced, leather * 0.3, edge), PALE, sole);
    // The floor has flattened the sole.
    if p.y > 0.0035 {
        return soled;
    }
    let tread = between((p.z / 0.018).rem_euclid(1.0), 0.0, 0.55, 0.06);
    mix(
        Vec3::new(0.2, 0.17, 0.14),
        Vec3::new(0.11, 0.095, 0.08),
        tread,
    )
}

/// The tongue of the shoe below its laces.
fn laces(color: Vec3, p: Vec3, normal: Vec3) -> Vec3 {
    let middle = 0.1045 + 0.08 * p.z.max(0.0);
    let across = (p.x - middle).abs();
    let along = between(p.z, -0.002, 0.084, 0.001);
    let up = f32::from(normal.y > 0.2);
    let tongue = between(across, -1.0, 0.0105, 0.001) * along * up;
    let lace = between((p.z / 0.0165).rem_euclid(1.0), 0.22, 0.68, 0.06);
    let laced =
        between(across, -1.0, 0.0175, 0.001) * between(p.z, 0.001, 0.082, 0.001) * up * lace;
    let shaft = spot(p, [0.104, 0.12, -0.04], 0.03);
    let below = mix(color, Vec3::new(0.13, 0.085, 0.055), tongue.max(shaft));
    mix(below, PALE, laced)
}
