//! Face, eyes, mouth and hair.

use super::{SKIN, between, mix, noise, spot};
use crate::eyes::{self, EYE, Lid};
use crate::mouth::{self, CORNER, LINE, Side};
use glam::Vec3;
use std::f32::consts::TAU;

const BLUSH: Vec3 = Vec3::new(0.66, 0.24, 0.18);
const LASHES: Vec3 = Vec3::new(0.05, 0.028, 0.02);

/// The skin of head and neck.
pub(super) fn skin(p: Vec3) -> Vec3 {
    let cheek = 0.55 * spot(p, [0.042, 1.597, 0.062], 0.03);
    let nose = 0.4 * spot(p, [0.0, 1.6, 0.1], 0.02);
    let ear = 0.5 * spot(p, [0.08, 1.632, -0.015], 0.036);
    let chin = 0.25 * spot(p, [0.0, 1.54, 0.078], 0.022);
    let red = mix(SKIN, BLUSH, cheek.max(nose).max(ear).max(chin));
    // Thinner skin around the eyes, and the light on the bridge of the nose.
    let socket = 0.5 * spot(p, [EYE.x, EYE.y, EYE.z + 0.012], 0.03);
    let dark = mix(red, Vec3::new(0.5, 0.25, 0.18), socket);
    let bridge = 0.3 * spot(p, [0.0, 1.62, 0.09], 0.018);
    mix(dark, Vec3::new(0.8, 0.52, 0.38), bridge)
}

/// The lips: darker where they meet, fading into the skin at the outer contour.
pub(super) fn lips(p: Vec3) -> Vec3 {
    let line = mouth::line(p.x);
    let side = if p.y > line { Side::Upper } else { Side::Lower };
    let along = (p.x / (1.04 * CORNER)).min(1.0);
    let height = (mouth::outer_contour(side, along)[1] - line)
        .abs()
        .max(5e-4);
    let share = (p.y - line).abs() / height;
    let base = match side {
        Side::Upper => Vec3::new(0.48, 0.18, 0.145),
        Side::Lower => Vec3::new(0.57, 0.235, 0.19),
    };
    let dark = mix(base, Vec3::new(0.26, 0.075, 0.065), 1.0 - share / 0.22);
    let full = between(share, 0.35, 0.7, 0.2) * between(p.x, -0.011, 0.011, 0.004);
    let lit = mix(dark, Vec3::new(0.72, 0.38, 0.32), 0.3 * full);
    mix(lit, SKIN, (share - 0.75) / 0.35 * 0.8)
}

/// The lids: lashes along the rims, the upper ones thicker, and a fold.
pub(super) fn lids(p: Vec3) -> Vec3 {
    let arm = p - EYE;
    let longitude = (arm.x / arm.length()).clamp(-1.0, 1.0).asin();
    let latitude = arm.y.atan2(arm.z);
    let is_upper =
        latitude > 0.5 * (eyes::rim(Lid::Upper, longitude) + eyes::rim(Lid::Lower, longitude));
    let lid = if is_upper { Lid::Upper } else { Lid::Lower };
    let far = (latitude - eyes::rim(lid, longitude)).abs() * arm.length();
    let skin = mix(SKIN, Vec3::new(0.56, 0.29, 0.21), 0.55);
    let outwards = 0.6 + 0.4 * (longitude / eyes::CORNER).clamp(-1.0, 1.0);
    match lid {
        Lid::Upper => {
            let fold = 0.5 * between(far, 0.0048, 0.0058, 0.0008);
            let folded = mix(skin, Vec3::new(0.36, 0.17, 0.12), fold);
            mix(
                folded,
                LASHES,
                between(far, -1.0, 0.0008 + 0.0009 * outwards, 0.0004),
            )
        }
        Lid::Lower => {
            let rim = mix(
                skin,
                Vec3::new(0.62, 0.3, 0.24),
                between(far, -1.0, 0.0005, 0.0003),
            );
            mix(
                rim,
                LASHES,
                0.55 * outwards * between(far, 0.0004, 0.0012, 0.0004),
            )
        }
    }
}

/// The brows, with hairs that lean outwards.
pub(super) fn brows(p: Vec3) -> Vec3 {
    let across = 0.9 * p.x - 0.45 * p.y;
    let hair = noise(across * 520.0);
    mix(
        Vec3::new(0.05, 0.028, 0.018),
        Vec3::new(0.16, 0.095, 0.06),
        hair,
    )
}

/// The hair, in strands from the crown.
pub(super) fn hair(p: Vec3) -> Vec3 {
    let arm = p - Vec3::new(0.0, 1.7, -0.03);
    let around = arm.x.atan2(arm.z);
    let strand = 0.6 * noise(around * 14.0) + 0.4 * noise(around * 41.0 + 7.0);
    let base = mix(
        Vec3::new(0.045, 0.024, 0.015),
        Vec3::new(0.15, 0.088, 0.055),
        strand,
    );
    // A ring of light around the crown.
    let shine = between(arm.y, 0.028, 0.042, 0.014) * strand;
    mix(base, Vec3::new(0.3, 0.19, 0.125), 0.5 * shine)
}

/// Teeth with the gaps between them, and gums.
pub(super) fn teeth(p: Vec3) -> Vec3 {
    const GAPS: [[f32; 4]; 2] = [[0.0, 0.0082, 0.0146, 0.0186], [0.0, 0.0052, 0.0106, 0.0158]];
    let height = p.y - LINE;
    let is_upper = height > -0.003;
    let gap = GAPS[usize::from(!is_upper)].iter();
    let near = gap.map(|x| (p.x - x).abs()).fold(1.0, f32::min);
    let enamel = mix(
        Vec3::new(0.82, 0.79, 0.72),
        Vec3::new(0.45, 0.36, 0.29),
        0.7 * between(near, -1.0, 0.0002, 0.0003),
    );
    let arch = 0.0006 * (1.0 - (near / 0.003).min(1.0));
    let gum = match is_upper {
        true => height - 0.0058 + arch,
        false => -0.0088 - height + arch,
    };
    mix(enamel, Vec3::new(0.5, 0.19, 0.17), 0.5 + gum / 0.0006)
}

/// The tongue, with its middle line.
pub(super) fn tongue(p: Vec3) -> Vec3 {
    let middle = 1.0 - p.x / 0.0025;
    mix(
        Vec3::new(0.5, 0.17, 0.15),
        Vec3::new(0.36, 0.1, 0.09),
        0.6 * middle,
    )
}

/// Sclera, iris and pupil, by the angle from the direction of the gaze.
pub(super) fn eyeball(p: Vec3) -> Vec3 {
    /// Angles at which the pupil and the iris end.
    const PUPIL: f32 = 0.2;
    const IRIS: f32 = 0.45;
    let arm = (p - EYE).normalize_or(Vec3::Z);
    let angle = arm.z.clamp(-1.0, 1.0).acos();
    let white = {
        let corner = ((arm.x.abs() - 0.45) / 0.4).clamp(0.0, 1.0);
        let pink = mix(
            Vec3::new(0.84, 0.82, 0.78),
            Vec3::new(0.72, 0.46, 0.4),
            0.7 * corner,
        );
        // The upper lid and its lashes shade it.
        mix(
            pink,
            Vec3::new(0.42, 0.38, 0.36),
            0.8 * ((arm.y - 0.05) / 0.4).clamp(0.0, 1.0),
        )
    };
    let along = ((angle - PUPIL) / (IRIS - PUPIL)).clamp(0.0, 1.0);
    let turn = arm.y.atan2(arm.x) / TAU + 0.5;
    let streak = noise(turn * 48.0);
    let iris = mix(
        mix(
            Vec3::new(0.26, 0.2, 0.09),
            Vec3::new(0.1, 0.17, 0.12),
            along * 2.2,
        ),
        Vec3::new(0.02, 0.035, 0.03),
        (along - 0.72) / 0.28,
    );
    let iris = iris * (0.8 + 0.4 * streak) * (1.0 - 0.35 * (arm.y / 0.4).clamp(0.0, 1.0));
    let colored = mix(Vec3::splat(0.006), iris, (angle - PUPIL) / 0.03 - 0.2);
    mix(colored, white, (angle - IRIS) / 0.03 + 0.5)
}
