//! What a portrait leaves out at coarser levels of articulation.

use articula_build::face::{FapInterval, FapValues, control_column, face_control};
use articula_core::face_levels::{FaceLevel, FaceLevels, FapRole, FapRoles};
use articula_core::fap_table::{FAP_COUNT, LOW_FAPS};
use articula_flat::portrait::{PortraitExpression, PortraitLevel};

/// Levels below the finest, which leaves out nothing, and their names in documents.
const COARSER: [(FaceLevel, &str); 3] = [
    (FaceLevel::Medium, "medium"),
    (FaceLevel::Low, "low"),
    (FaceLevel::VeryLow, "veryLow"),
];

/// The coarser levels of a portrait with these expressions.
pub(super) fn levels(expressions: &[PortraitExpression]) -> Vec<PortraitLevel> {
    let columns: Vec<Option<FapValues>> = expressions.iter().map(|e| column(&e.name)).collect();
    let level = |(level, name): (FaceLevel, &str)| {
        let roles = FaceLevels::all(level).roles();
        let number = |fap: usize| match roles.role(fap) {
            FapRole::Own => fap as u8,
            FapRole::Copied(leader) => leader,
            FapRole::Removed => 0,
        };
        let motions = columns.iter();
        let motions = motions.map(|column| Some(Motion::of(column.as_ref()?, &roles)));
        let motions: Vec<Option<Motion>> = motions.collect();
        let of = (0..expressions.len()).map(|e| role(e, &motions));
        PortraitLevel {
            name: name.to_owned(),
            faps: (1..=FAP_COUNT).map(number).collect(),
            expressions: of.collect(),
        }
    };
    COARSER.into_iter().map(level).collect()
}

/// The parameters that an expression shows, by its name; `None` for unknown names and those of a table.
fn column(name: &str) -> Option<FapValues> {
    if FapInterval::parse(name).is_some() {
        return None;
    }
    face_control(name).map(|named| control_column(named.control))
}

/// What becomes of the motion of an expression at a level, as sums of the values of its parameters.
struct Motion {
    /// That of parameters which are kept, or follow others of the expression itself, as outer lips do inner ones.
    kept: f32,
    /// That of parameters which follow those of other expressions.
    copied: f32,
    removed: f32,
    /// The motion by the parameters that lead it.
    led: FapValues,
}

impl Motion {
    fn of(column: &FapValues, roles: &FapRoles) -> Self {
        let mut motion = Self {
            kept: 0.0,
            copied: 0.0,
            removed: 0.0,
            led: FapValues::default(),
        };
        for fap in LOW_FAPS {
            let moved = column.get(fap).abs();
            let leader = match roles.role(fap) {
                FapRole::Own => fap,
                FapRole::Copied(leader) => usize::from(leader),
                FapRole::Removed => {
                    motion.removed += moved;
                    continue;
                }
            };
            match column.get(leader) != 0.0 {
                true => motion.kept += moved,
                false => motion.copied += moved,
            }
            let led = motion.led.get(leader) + column.get(fap);
            motion.led.set(leader, led);
        }
        motion
    }

    fn is_kept(&self) -> bool {
        self.kept >= self.copied && self.kept >= self.removed
    }

    /// Share of another expression's motion that leads this one.
    fn led_by(&self, other: &Self) -> f32 {
        // What goes the other way leads nothing.
        let both = LOW_FAPS.map(|fap| match (self.led.get(fap), other.led.get(fap)) {
            (own, led) if own * led > 0.0 => own.abs().min(led.abs()),
            _ => 0.0,
        });
        both.sum::<f32>() / (other.kept + other.copied).max(1.0)
    }
}

/// What becomes of an expression: what becomes of most of its motion. One that copies takes the weight of the expression
/// that shows most of the parameters it copies, and stays if there is none.
fn role(of: usize, motions: &[Option<Motion>]) -> Option<u16> {
    let itself = u16::try_from(of).ok();
    let Some(motion) = motions[of].as_ref().filter(|motion| !motion.is_kept()) else {
        return itself;
    };
    if motion.removed > motion.copied {
        return None;
    }
    let others = motions.iter().enumerate().filter_map(|(other, found)| {
        let found = found.as_ref().filter(|found| found.is_kept())?;
        Some((other, motion.led_by(found)))
    });
    let leader = others.max_by(|(_, a), (_, b)| a.total_cmp(b));
    leader
        .filter(|(_, share)| *share > 0.5)
        .and_then(|(other, _)| u16::try_from(other).ok())
        .or(itself)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parameters that the thesis' annex C has in 2D.
    fn of_annex(fap: usize) -> bool {
        matches!(fap, 3..=13 | 19..=32 | 35..=38 | 51..=60)
    }

    #[test]
    fn parameters_in_2d_are_39_22_15_and_9() {
        let found = levels(&[]);
        let kept = |level: &PortraitLevel| {
            let all = (1..=FAP_COUNT).zip(&level.faps);
            let own = all.filter(|(fap, of)| usize::from(**of) == *fap && of_annex(*fap));
            own.count()
        };
        assert_eq!((1..=FAP_COUNT).filter(|fap| of_annex(*fap)).count(), 39);
        let names: Vec<&str> = found.iter().map(|level| &*level.name).collect();
        assert_eq!(names, ["medium", "low", "veryLow"]);
        assert_eq!(found.iter().map(kept).collect::<Vec<_>>(), [22, 15, 9]);
    }

    #[test]
    fn shapes_follow_their_parameters() {
        let names = [
            "jawOpen",
            "eyeBlinkLeft",
            "eyeBlinkRight",
            "mouthSmile_L",
            "mouthSmile_R",
            "cheekPuff",
            "noseSneerLeft",
            "jawForward",
            "browInnerUp",
            "browDown_L",
            "browDown_R",
            "fap19_0_1080",
            "wink of a stranger",
        ];
        let all: Vec<PortraitExpression> = names
            .iter()
            .map(|name| PortraitExpression::of_morph(*name, 0))
            .collect();
        let [medium, low, lowest] = &levels(&all)[..] else {
            panic!("three levels");
        };
        let of = |level: &PortraitLevel, name: &str| {
            level.expressions[names.iter().position(|n| *n == name).unwrap()]
                .map(|other| names[usize::from(other)])
        };
        for level in [medium, low, lowest] {
            for kept in [
                "jawOpen",
                "eyeBlinkRight",
                "mouthSmile_R",
                "fap19_0_1080",
                "wink of a stranger",
            ] {
                assert_eq!(of(level, kept), Some(kept), "{}", level.name);
            }
        }
        for own in names {
            let is_kept = of(medium, own) == Some(own);
            assert!(is_kept || own == "noseSneerLeft", "{own}");
        }
        assert_eq!(of(low, "eyeBlinkLeft"), Some("eyeBlinkLeft"));
        assert_eq!(of(lowest, "eyeBlinkLeft"), Some("eyeBlinkRight"));
        assert_eq!(of(lowest, "mouthSmile_L"), Some("mouthSmile_R"));
        // Never by brows that rise.
        assert_ne!(of(lowest, "browDown_L"), Some("browInnerUp"));
        for gone in ["cheekPuff", "jawForward"] {
            assert_eq!(of(low, gone), None, "{gone}");
        }
        assert_eq!(of(lowest, "noseSneerLeft"), None);
    }
}
