//! The surfaces of the human with a face within a triangle budget.

use crate::body::Body;
use crate::eyes::{self, EYE, Lid};
use crate::mouth::{self, Side};
use crate::person_head::{self, Borders};
use crate::pieces::{SKIN_STEP, both_sides, fine_half, mirrored, skin_step, solid};
use crate::polygonise::Surface;
use crate::suit::{split, toned};
use crate::thin::{Options, thinned};
use glam::Vec3;

/// What a vertex of the face belongs to: sheets that touch each other move apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sheet {
    Skin,
    Lip(Side),
    Lid(Lid),
    Eyeball,
    Brow,
    Teeth(Side),
    Tongue,
    Hair,
}

/// A surface of one material, or of one for each tone.
pub(crate) struct Piece {
    pub(crate) surface: Surface,
    pub(crate) sheet: Sheet,
    pub(crate) material: usize,
}

/// Index into the materials of the human with a face.
pub(crate) mod material {
    pub(crate) const LIPS: usize = 5;
    pub(crate) const LIDS: usize = 6;
    pub(crate) const BROWS: usize = 7;
    pub(crate) const HAIR: usize = 8;
    pub(crate) const TEETH: usize = 9;
    pub(crate) const TONGUE: usize = 10;
    pub(crate) const SCLERA: usize = 11;
}

/// All surfaces, the skin first; its tones are the first materials.
pub(crate) fn pieces(body: &Body, triangles: usize) -> Vec<Piece> {
    let mut pieces = small_pieces(triangles);
    let spent: usize = pieces.iter().map(|p| p.surface.triangles.len()).sum();
    let skin = Piece {
        surface: mirrored(&skin_half(body, triangles.saturating_sub(spent) / 2)),
        sheet: Sheet::Skin,
        material: 0,
    };
    pieces.insert(0, skin);
    pieces
}

fn small_pieces(triangles: usize) -> Vec<Piece> {
    let closed = person_head::closed_head();
    let detail = (triangles as f32 / 12_000.0).sqrt();
    let count = |base: f32, least: usize| ((base * detail).round() as usize).max(least);
    let piece = |surface, sheet, material| Piece {
        surface,
        sheet,
        material,
    };
    let mut pieces = Vec::new();
    for side in [Side::Upper, Side::Lower] {
        let lip = mirrored(&mouth::lip(&closed, side, count(9.0, 4)));
        pieces.push(piece(lip, Sheet::Lip(side), material::LIPS));
    }
    for lid in [Lid::Upper, Lid::Lower] {
        let lids = both_sides(&eyes::lid(lid, count(14.0, 6), count(4.0, 4)));
        pieces.push(piece(lids, Sheet::Lid(lid), material::LIDS));
    }
    let brow = solid(&person_head::brow(&closed), triangles / 130, 0.0008);
    pieces.push(piece(both_sides(&brow), Sheet::Brow, material::BROWS));
    let hair = mirrored(&solid(
        &person_head::hair(),
        (triangles / 26).min(1_600),
        0.004,
    ));
    pieces.push(piece(hair, Sheet::Hair, material::HAIR));
    for side in [Side::Upper, Side::Lower] {
        let teeth = mirrored(&mouth::teeth(&closed, side, count(5.0, 3)));
        pieces.push(piece(teeth, Sheet::Teeth(side), material::TEETH));
    }
    let tongue = mirrored(&mouth::tongue(&closed, count(4.0, 2)));
    pieces.push(piece(tongue, Sheet::Tongue, material::TONGUE));
    let eyeball = eyes::eyeball(count(18.0, 8));
    for (i, band) in eyeball.iter().enumerate() {
        pieces.push(piece(
            both_sides(band),
            Sheet::Eyeball,
            material::SCLERA + i,
        ));
    }
    pieces
}

/// The left half of the skin, with about `target` triangles.
fn skin_half(body: &Body, target: usize) -> Surface {
    let borders = Borders::new(body);
    let mut fine = fine_half(body, face_step);
    fine = split(&fine, body, &|p| borders.mouth(p));
    fine = split(&fine, body, &|p| borders.shirt(p));
    fine = split(&fine, body, &|p| borders.belt(p));
    fine = split(&fine, body, &Borders::shoe);
    let fine = toned(fine, |p| borders.tone(p));
    // The fewer triangles, the larger the share of the face.
    let focus = (6_000.0 / target as f32).sqrt().clamp(1.0, 3.0);
    let options = Options {
        target,
        mirrored: true,
        importance: &|p| importance(p, focus),
    };
    thinned(&fine, &options)
}

/// Spacing of the samples: as for the mannequin, and finer at the mouth.
fn face_step(axis: usize, at: f32) -> f32 {
    match (axis, at) {
        (1, 1.5625..1.5755) => 0.4 * SKIN_STEP,
        _ => skin_step(axis, at),
    }
}

/// Weight of errors, as for the mannequin; what hair and shoes hide or simplify counts little.
fn importance(p: Vec3, focus: f32) -> f32 {
    let eye = p.distance(EYE + Vec3::Z * 0.01) < 0.024;
    let mouth = p.distance(Vec3::new(0.0, mouth::LINE, 0.075)) < 0.03;
    let face = p.y > 1.525 && p.z > 0.01 && p.y < 1.69;
    let ear = p.y > 1.595 && p.y < 1.67 && p.x > 0.066;
    let hand = p.y < 0.87 && p.x > 0.2;
    if eye || mouth {
        36.0 * focus
    } else if face || ear {
        26.0 * focus
    } else if hand {
        7.0
    } else if p.y > 1.64 {
        0.3
    } else if p.y > 1.46 && p.x < 0.08 {
        4.0
    } else if p.y < 0.09 {
        3.0
    } else {
        1.0
    }
}
