//! What the words of a joint name mean: a part of the body, its side and its place.

use super::words;
use articula_core::joint_names::Side;

/// The fingers, as in the names of the standard.
pub(super) const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// What the words of a name mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Hips,
    Spine,
    Neck,
    Head,
    Jaw,
    Eye,
    Collar,
    /// A collar bone, or an upper arm.
    Shoulder,
    UpperArm,
    /// An upper arm, or a forearm below one.
    Arm,
    Forearm,
    Hand,
    /// A finger, as an index into [`FINGERS`], and whether the joint is within the palm.
    Finger(usize, bool),
    Thigh,
    /// A thigh, or a shin below one.
    Leg,
    Shin,
    Foot,
    Toes,
    /// Something at or around a joint that is no joint of the standard.
    Other,
}

/// Words about the place of a part.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    upper: bool,
    lower: bool,
    palm: bool,
    other: bool,
}

/// Words without a meaning of their own.
const NOISE: [&str; 18] = [
    "joint", "jnt", "bone", "bind", "def", "deform", "bend", "rig", "skin", "sk", "bn", "j", "c",
    "f", "center", "centre", "phalanx", "phalange",
];

/// Words of what is no joint of the standard.
const OTHER: [&str; 17] = [
    "twist", "roll", "ik", "pole", "ctrl", "control", "target", "helper", "nub", "end", "tip",
    "top", "site", "effector", "hold", "attach", "socket",
];

/// Words that consist of others without a sign of it.
const COMPOUNDS: [(&str, &[&str]); 21] = [
    ("upperarm", &["upper", "arm"]),
    ("uparm", &["upper", "arm"]),
    ("bicep", &["upper", "arm"]),
    ("forearm", &["lower", "arm"]),
    ("lowerarm", &["lower", "arm"]),
    ("lowarm", &["lower", "arm"]),
    ("elbow", &["lower", "arm"]),
    ("wrist", &["hand"]),
    ("upperleg", &["upper", "leg"]),
    ("upleg", &["upper", "leg"]),
    ("thigh", &["upper", "leg"]),
    ("lowerleg", &["lower", "leg"]),
    ("lowleg", &["lower", "leg"]),
    ("knee", &["lower", "leg"]),
    ("shin", &["lower", "leg"]),
    ("calf", &["lower", "leg"]),
    ("ankle", &["foot"]),
    ("toebase", &["toes"]),
    ("ball", &["toes"]),
    ("upperchest", &["upper", "chest"]),
    ("eyeball", &["eye"]),
];

fn part(word: &str) -> Option<Part> {
    Some(match word {
        "hips" | "hip" | "pelvis" => Part::Hips,
        "spine" | "chest" | "torso" | "abdomen" | "waist" | "ribs" | "ribcage" | "back" => {
            Part::Spine
        }
        "neck" => Part::Neck,
        "head" => Part::Head,
        "jaw" => Part::Jaw,
        "eye" => Part::Eye,
        "clavicle" | "clav" | "collar" | "scapula" => Part::Collar,
        "shoulder" | "shldr" => Part::Shoulder,
        "arm" => Part::Arm,
        "hand" => Part::Hand,
        "thumb" => Part::Finger(0, false),
        "index" => Part::Finger(1, false),
        "middle" | "mid" => Part::Finger(2, false),
        "ring" => Part::Finger(3, false),
        "pinky" | "pinkie" | "little" => Part::Finger(4, false),
        "leg" => Part::Leg,
        "foot" => Part::Foot,
        "toes" | "toe" => Part::Toes,
        _ => return None,
    })
}

fn is_number(word: &str) -> bool {
    word.chars().all(|c| c.is_ascii_digit())
}

/// Whether a word has a meaning.
pub(super) fn is_known(word: &str) -> bool {
    let is_compound = COMPOUNDS.iter().any(|(name, _)| *name == word);
    words::side(word).is_some() || part(word).is_some() || is_compound || place(word).is_some()
}

/// What a word says about the place of a part; `None` if nothing.
fn place(word: &str) -> Option<Place> {
    let none = Place::default();
    Some(match word {
        "upper" | "up" | "uppr" => Place {
            upper: true,
            ..none
        },
        "lower" | "low" | "lwr" | "fore" => Place {
            lower: true,
            ..none
        },
        "metacarpal" | "meta" | "palm" => Place { palm: true, ..none },
        "proximal" | "intermediate" | "medial" | "distal" | "base" | "finger" => none,
        word if OTHER.contains(&word) => Place {
            other: true,
            ..none
        },
        word if NOISE.contains(&word) || is_number(word) => none,
        _ => return None,
    })
}

/// Meaning of the words of a name; `None` if one is unknown, or none is a part.
pub(super) fn meaning(words: &[String]) -> Option<(Part, Option<Side>)> {
    let (mut found, mut side, mut place) = (None, None, Place::default());
    let is_pelvis = words.iter().any(|word| word == "pelvis");
    for word in words {
        let mut word = word.as_str();
        if let Some(own) = words::side(word) {
            side = Some(own);
            continue;
        }
        if !is_known(word) {
            // A side without a sign of its end: lthigh, leftarm.
            let ends = ["left", "right", "l", "r"].into_iter();
            let (own, rest) = ends
                .filter_map(|s| Some((words::side(s)?, word.strip_prefix(s)?)))
                .find(|(_, rest)| is_known(rest))?;
            (side, word) = (Some(own), rest);
        }
        let compound = COMPOUNDS.iter().find(|(name, _)| *name == word);
        let single = [word];
        for word in compound.map_or(&single[..], |(_, words)| words) {
            match (part(word), self::place(word)) {
                // The finger of a hand, the toes of a foot: the finer part.
                (Some(own), _) if finer(found, own) => found = Some(own),
                (Some(_), _) => {}
                (None, Some(own)) => {
                    place.upper |= own.upper;
                    place.lower |= own.lower;
                    place.palm |= own.palm;
                    place.other |= own.other;
                }
                (None, None) => return None,
            }
        }
    }
    let found = match found? {
        _ if place.other => Part::Other,
        Part::Arm if place.lower => Part::Forearm,
        Part::Arm if place.upper => Part::UpperArm,
        Part::Leg if place.lower => Part::Shin,
        Part::Leg if place.upper => Part::Thigh,
        // Half of a pelvis, as beside the spine of Rigify.
        Part::Hips if side.is_some() && is_pelvis => Part::Other,
        Part::Hips if side.is_some() => Part::Thigh,
        Part::Finger(finger, _) => Part::Finger(finger, place.palm),
        part => part,
    };
    Some((found, side))
}

impl Part {
    /// Whether the place in the tree decides which joint this is.
    pub(super) fn is_ambiguous(self) -> bool {
        matches!(self, Self::Shoulder | Self::Arm | Self::Leg)
    }
}

/// Whether a part takes precedence over one that the same name has too.
fn finer(found: Option<Part>, own: Part) -> bool {
    match found {
        None => true,
        Some(Part::Hand | Part::Foot) => !matches!(own, Part::Hand | Part::Foot),
        Some(Part::Leg) => matches!(own, Part::Foot | Part::Toes),
        Some(Part::Arm) => matches!(own, Part::Hand | Part::Finger(..) | Part::Collar),
        Some(_) => false,
    }
}
