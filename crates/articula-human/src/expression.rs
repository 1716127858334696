//! How the face moves: the 52 blend shapes of ARKit as displacements of a point at rest.
//!
//! Displacements depend on the rest position and the sheet of a point alone, so that the meshes of all
//! triangle counts move equally, and the right side is the exact mirror image of the left. Amplitudes
//! are engineering defaults for this face at weight 1.

use crate::eyes::{self, EYE, Lid};
use crate::jaw::Jaw;
use crate::mouth::{CORNER, LINE, Side, line, parting};
use crate::person_pieces::Sheet;
use articula_core::arkit_table::BLEND_SHAPES;
use glam::{Quat, Vec3};

const FLIP: Vec3 = Vec3::new(-1.0, 1.0, 1.0);

/// The displacements of all blend shapes.
pub(crate) struct Expressions {
    jaw: Jaw,
    /// Left corner of the mouth.
    corner: Vec3,
    /// Middle of the mouth.
    middle: Vec3,
}

/// A point of the face at rest, with x towards the side that moves.
#[derive(Debug, Clone, Copy)]
struct Site {
    p: Vec3,
    sheet: Sheet,
}

/// A smooth bump: 1 at the centre, 0 from `reach` on.
fn bump(p: Vec3, center: [f32; 3], reach: f32) -> f32 {
    let share = p.distance_squared(Vec3::from(center)) / (reach * reach);
    (1.0 - share).max(0.0).powi(2)
}

/// Millimetres.
fn mm(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z) * 1e-3
}

impl Site {
    /// Whether skin, brows or lips: what is drawn out over the skull.
    fn is_soft(&self) -> bool {
        matches!(self.sheet, Sheet::Skin | Sheet::Brow | Sheet::Lip(_))
    }

    /// Whether the point is below the line of the mouth.
    fn is_lower(&self) -> bool {
        match self.sheet {
            Sheet::Lip(side) => side == Side::Lower,
            _ => self.p.y < line(self.p.x),
        }
    }

    /// Share of the side of positive x: both halves meet smoothly.
    fn own_side(&self) -> f32 {
        crate::weights::smooth_step(-0.012, 0.012, self.p.x)
    }
}

impl Expressions {
    pub(crate) fn new(closed: &crate::field::Group) -> Self {
        let at = |x: f32| crate::front::on_skin(closed, [x, line(x)], 0.0);
        Self {
            jaw: Jaw::new(at(CORNER)),
            corner: at(CORNER),
            middle: at(0.0),
        }
    }

    /// The displacement of a point by a blend shape of ARKit at weight 1.
    pub(crate) fn offset(&self, name: &str, p: Vec3, sheet: Sheet) -> Vec3 {
        let site = Site { p, sheet };
        let mirrored = Site { p: p * FLIP, sheet };
        if let Some(stem) = name.strip_suffix("Left") {
            self.one_side(stem, site)
        } else if let Some(stem) = name.strip_suffix("Right") {
            self.one_side(stem, mirrored) * FLIP
        } else {
            let half = Site {
                p: Vec3::new(p.x.abs(), p.y, p.z),
                sheet,
            };
            let moved = self.both_sides(name, half);
            if p.x < 0.0 { moved * FLIP } else { moved }
        }
    }

    /// A shape of one side, on the left.
    fn one_side(&self, stem: &str, site: Site) -> Vec3 {
        match stem {
            "jaw" => self.jaw.weight(site.p, site.sheet) * mm(6.5, 0.0, 0.0),
            "mouth" if site.is_soft() => self.around_mouth(site, 0.05) * mm(7.5, 0.0, 0.0),
            _ if stem.starts_with("eye") => eye(stem, site),
            _ if stem.starts_with("mouth") && site.is_soft() => self.mouth_side(stem, site),
            _ if site.is_soft() => upper_face(stem, site),
            _ => Vec3::ZERO,
        }
    }

    /// 1 at the mouth, 0 from a distance on.
    fn around_mouth(&self, site: Site, reach: f32) -> f32 {
        bump(site.p, (self.middle - Vec3::Z * 0.01).to_array(), reach)
    }

    fn mouth_side(&self, stem: &str, site: Site) -> Vec3 {
        let corner = self.corner.to_array();
        let at_corner = |reach: f32, moved: Vec3| bump(site.p, corner, reach) * moved;
        let cheek = |moved: Vec3| bump(site.p, [0.039, 1.599, 0.064], 0.034) * moved;
        let lip = |lower: bool, moved: Vec3| {
            let near = bump(site.p, [0.0105, LINE, self.middle.z - 0.002], 0.026);
            let on = site.is_lower() == lower;
            f32::from(u8::from(on)) * near * parting(site.p.x) * moved
        };
        match stem {
            "mouthSmile" => at_corner(0.042, mm(6.5, 7.5, -4.5)) + cheek(mm(1.0, 2.5, 1.5)),
            "mouthFrown" => at_corner(0.036, mm(0.5, -7.0, -1.0)),
            "mouthDimple" => at_corner(0.028, mm(4.5, 0.8, -4.0)),
            "mouthStretch" => at_corner(0.042, mm(7.5, -2.5, -4.5)),
            "mouthPress" => {
                let squeeze = 0.4 * (line(site.p.x) - site.p.y).clamp(-0.008, 0.008);
                let near = bump(site.p, [0.012, LINE, self.middle.z - 0.002], 0.024);
                near * (Vec3::Y * squeeze + mm(0.0, 0.0, -0.9))
            }
            "mouthLowerDown" => lip(true, mm(0.8, -8.0, 0.5)),
            "mouthUpperUp" => lip(false, mm(0.5, 7.0, 0.8)),
            _ => Vec3::ZERO,
        }
    }

    /// A shape of both sides, on the left half.
    fn both_sides(&self, name: &str, site: Site) -> Vec3 {
        match name {
            "jawOpen" => self.jaw.opened(site.p, site.sheet),
            "jawForward" => self.jaw.weight(site.p, site.sheet) * mm(0.0, 0.0, 6.0),
            "tongueOut" if site.sheet == Sheet::Tongue => {
                let along = ((site.p.z - self.middle.z + 0.0395) / 0.026).clamp(0.0, 1.0);
                mm(0.0, 11.0 * along - 2.5 * along * along, 28.0 * along)
            }
            _ if !site.is_soft() => Vec3::ZERO,
            "mouthClose" => self.jaw.closed_lips(site.p, site.sheet),
            "browInnerUp" => bump(site.p, [0.016, 1.662, 0.08], 0.032) * mm(0.0, 6.5, 0.0),
            "cheekPuff" => bump(site.p, [0.041, 1.582, 0.058], 0.036) * mm(6.5, 0.0, 5.0),
            _ => self.lips(name, site),
        }
    }

    /// Shapes of both lips: rounding, rolling and shrugging.
    fn lips(&self, name: &str, site: Site) -> Vec3 {
        let near = self.around_mouth(site, 0.04);
        let sign = if site.is_lower() { -1.0 } else { 1.0 };
        let inward = (site.p.x / CORNER).min(1.0);
        let open = sign * parting(site.p.x);
        // 1 on the lip itself, 0 from 11 mm beside the line.
        let band = bump(Vec3::Y * (site.p.y - line(site.p.x)), [0.0; 3], 0.013) * parting(site.p.x);
        match name {
            "mouthFunnel" => near * mm(-8.0 * inward, 4.2 * open, 6.5 - 1.0 * inward),
            "mouthPucker" => near * mm(-11.0 * inward, 0.0, 7.0 + 1.0 * inward),
            "mouthRollLower" if sign < 0.0 => near * band * mm(0.0, 1.2, -5.5),
            "mouthRollUpper" if sign > 0.0 => near * band * mm(0.0, -1.2, -5.5),
            "mouthShrugLower" => {
                let chin = bump(site.p, [0.0, 1.55, self.middle.z - 0.002], 0.034);
                let lower = if sign < 0.0 {
                    1.0
                } else {
                    1.0 - 0.25 * parting(site.p.x)
                };
                chin.max(near * 0.8) * lower * mm(0.0, 4.0, 1.5)
            }
            "mouthShrugUpper" if sign > 0.0 => near * parting(site.p.x) * mm(0.0, 3.0, 1.5),
            _ => Vec3::ZERO,
        }
    }
}

/// Lids and the gaze of the left eye.
fn eye(stem: &str, site: Site) -> Vec3 {
    let p = site.p;
    match site.sheet {
        Sheet::Lid(lid) if p.x > 0.0 => eyes::closing(lid, p, lid_share(stem, lid)) - p,
        Sheet::Eyeball if p.x > 0.0 => gaze(stem) * (p - EYE) + EYE - p,
        Sheet::Skin if stem == "eyeSquint" => {
            bump(p, [0.035, 1.611, 0.072], 0.024) * mm(0.0, 2.2, 0.6)
        }
        _ => Vec3::ZERO,
    }
}

/// Share of the closing by which a lid moves; negative shares open it.
fn lid_share(stem: &str, lid: Lid) -> f32 {
    match (stem, lid) {
        ("eyeBlink", _) => 1.0,
        ("eyeSquint", Lid::Upper) => 0.28,
        ("eyeSquint", Lid::Lower) => 0.85,
        ("eyeWide", Lid::Upper) => -0.3,
        ("eyeWide", Lid::Lower) => -0.2,
        ("eyeLookDown", Lid::Upper) => 0.42,
        ("eyeLookDown", Lid::Lower) => -0.45,
        ("eyeLookUp", Lid::Upper) => -0.26,
        ("eyeLookUp", Lid::Lower) => 0.35,
        _ => 0.0,
    }
}

fn gaze(stem: &str) -> Quat {
    let degrees: f32 = match stem {
        "eyeLookDown" | "eyeLookUp" => 22.0,
        "eyeLookIn" | "eyeLookOut" => 28.0,
        _ => 0.0,
    };
    let angle = degrees.to_radians();
    match stem {
        "eyeLookDown" => Quat::from_rotation_x(angle),
        "eyeLookUp" => Quat::from_rotation_x(-angle),
        "eyeLookOut" => Quat::from_rotation_y(angle),
        _ => Quat::from_rotation_y(-angle),
    }
}

/// Brows, cheeks and nose of the left side.
fn upper_face(stem: &str, site: Site) -> Vec3 {
    let at = |center: [f32; 3], reach: f32, moved: Vec3| bump(site.p, center, reach) * moved;
    match stem {
        "browDown" => {
            at([0.018, 1.661, 0.08], 0.032, mm(-2.2, -5.0, 0.6))
                + at([0.04, 1.661, 0.072], 0.026, mm(-0.6, -2.2, 0.0))
        }
        "browOuterUp" => at([0.04, 1.662, 0.07], 0.032, mm(0.4, 6.0, -0.5)),
        "cheekSquint" => at([0.037, 1.608, 0.068], 0.034, mm(0.6, 4.0, 1.6)),
        "noseSneer" => {
            let lip = if site.is_lower() { 0.0 } else { 1.0 };
            at([0.0105, 1.598, 0.087], 0.022, mm(0.6, 3.4, -0.4))
                + at([0.011, 1.58, 0.083], 0.022, mm(0.3, 2.4, 0.4)) * lip * site.own_side()
        }
        _ => Vec3::ZERO,
    }
}

/// Names of the blend shapes, in the order of the morph targets.
pub(crate) fn names() -> Vec<String> {
    BLEND_SHAPES
        .iter()
        .map(|shape| shape.name.to_owned())
        .collect()
}
