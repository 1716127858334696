//! The colours of the painted human at points of its left half, in linear light.
//!
//! A colour depends on the material, the position at rest and the normal alone.

mod clothes;
mod face;
mod hand;

use crate::body::Body;
use crate::field::Group;
use crate::person_head::{self, ARMS, BARE, INSIDE, SHIRT, TROUSERS};
use crate::person_pieces::material;
use glam::Vec3;

/// Bare skin of the face, of arms and hands.
pub(crate) const SKIN: Vec3 = Vec3::new(0.71, 0.42, 0.29);

/// Distances above a surface, in metres, at which other surfaces shade it.
const AROUND: [f32; 4] = [0.004, 0.01, 0.022, 0.045];

/// How much of the light is gone where surfaces touch.
const DARKEST: f32 = 0.75;

/// What the colours of the human depend on.
pub(crate) struct Painter<'a> {
    body: &'a Body,
    hair: Group,
    shirt: clothes::Shirt<'a>,
    hand: hand::Hand,
}

impl<'a> Painter<'a> {
    pub(crate) fn new(body: &'a Body) -> Self {
        Self {
            body,
            hair: person_head::hair(),
            shirt: clothes::Shirt::new(body),
            hand: hand::Hand::new(),
        }
    }

    /// The colour of a point of a material.
    pub(crate) fn color(&self, material: usize, p: Vec3, normal: Vec3) -> Vec3 {
        const BARE_SKIN: usize = BARE as usize;
        const MOUTH: usize = INSIDE as usize;
        const TORSO: usize = SHIRT as usize;
        const LEGS: usize = TROUSERS as usize;
        match material {
            BARE_SKIN if p.y > ARMS => face::skin(p),
            BARE_SKIN => self.hand.skin(p, normal),
            MOUTH => Vec3::new(0.22, 0.05, 0.045),
            TORSO => self.shirt.color(p, normal),
            LEGS => clothes::trousers(p, normal),
            material::LIPS => face::lips(p),
            material::LIDS => face::lids(p),
            material::BROWS => face::brows(p),
            material::HAIR => face::hair(p),
            material::TEETH => face::teeth(p),
            material::TONGUE => face::tongue(p),
            material::SCLERA.. => face::eyeball(p),
            _ => clothes::shoes(p, normal),
        }
    }

    /// The share of the light of its surroundings that reaches a point of skin, clothes or hair at rest: less in
    /// folds and where parts are near each other. 1 for all other materials, which the skin surrounds.
    ///
    /// Source: A. Evans, *Fast approximations for global illumination on dynamic scenes* (2006): distances along
    /// the normal.
    pub(crate) fn openness(&self, material: usize, p: Vec3, normal: Vec3) -> f32 {
        if material > usize::from(person_head::SHOES) && material != material::HAIR {
            return 1.0;
        }
        let normal = normal.normalize_or_zero();
        let (mut closed, mut whole) = (0.0, 0.0);
        for (i, far) in AROUND.iter().enumerate() {
            let at = p + normal * *far;
            let at = Vec3::new(at.x.abs(), at.y, at.z);
            let free = self.body.distance(at).min(self.hair.distance(at));
            let weight = 0.6_f32.powi(i as i32);
            closed += weight * ((far - free) / far).clamp(0.0, 1.0);
            whole += weight;
        }
        1.0 - DARKEST * closed / whole
    }
}

/// `from` at 0, `to` at 1.
fn mix(from: Vec3, to: Vec3, share: f32) -> Vec3 {
    from.lerp(to, share.clamp(0.0, 1.0))
}

/// 1 at the middle of a round spot, 0 from its radius on.
fn spot(p: Vec3, middle: [f32; 3], radius: f32) -> f32 {
    let left = (1.0 - p.distance_squared(Vec3::from(middle)) / (radius * radius)).max(0.0);
    left * left
}

/// 1 between two values, 0 beyond them by more than `soft`.
fn between(value: f32, from: f32, to: f32, soft: f32) -> f32 {
    let inside = (value - from).min(to - value);
    (0.5 + inside / (2.0 * soft)).clamp(0.0, 1.0)
}

/// Smooth values from 0 to 1 that differ from one whole number to the next.
fn noise(at: f32) -> f32 {
    let cell = at.floor();
    let value = |cell: f32| {
        let bits = (cell as i32 as u32).wrapping_mul(0x9e37_79b1);
        let bits = (bits ^ (bits >> 15)).wrapping_mul(0x85eb_ca77);
        ((bits ^ (bits >> 13)) & 0xffff) as f32 / 65_535.0
    };
    let t = at - cell;
    let smooth = t * t * (3.0 - 2.0 * t);
    value(cell) * (1.0 - smooth) + value(cell + 1.0) * smooth
}
