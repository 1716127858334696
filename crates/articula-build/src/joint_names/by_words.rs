//! Recognition of a human by the words in its joint names, where no joint map fits.
//!
//! A word tells the part of the body and its side; where it may mean two joints (`shoulder` is a
//! collar bone or an upper arm, `leg` a thigh or a shin), the place in the tree decides. Names with
//! unknown words are left out, unless most joints have these words.

use super::{rest, words};
use articula_core::joint_names::{JointTarget, Side};
use articula_core::source::Skeleton;

/// Name of the joint map of joints that are found by their words.
pub(super) const NAME: &str = "words";

const FINGERS: [&str; 5] = ["thumb", "index", "middle", "ring", "pinky"];

/// What the words of a name mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
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
const NOISE: [&str; 15] = [
    "joint", "jnt", "bone", "bind", "def", "deform", "bend", "rig", "skin", "sk", "bn", "j", "c",
    "center", "centre",
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

fn is_known(word: &str) -> bool {
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
fn meaning(words: &[String]) -> Option<(Part, Option<Side>)> {
    let (mut found, mut side, mut place) = (None, None, Place::default());
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
        Part::Hips if side.is_some() => Part::Thigh,
        Part::Finger(finger, _) => Part::Finger(finger, place.palm),
        part => part,
    };
    Some((found, side))
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

/// The target of each joint, if the words of the names are those of a human.
pub(super) fn human(skeleton: &Skeleton, eligible: &[bool]) -> Option<Vec<Option<JointTarget>>> {
    let mut names: Vec<Vec<String>> = Vec::with_capacity(skeleton.joints.len());
    names.extend(skeleton.joints.iter().map(|j| words::split(&j.name)));
    words::without_common(&mut names, is_known);
    let meanings: Vec<Option<(Part, Option<Side>)>> = names
        .iter()
        .zip(eligible)
        .map(|(words, eligible)| meaning(words).filter(|_| *eligible))
        .collect();
    let mut body = Body {
        skeleton,
        meanings,
        found: vec![None; skeleton.joints.len()],
    };
    let limbs = Side::BOTH.map(|side| body.limbs(side));
    let [Some(left), Some(right)] = limbs else {
        return None;
    };
    body.middle([left.0, right.0], [left.1, right.1])?;
    (!body.stands_on_four()).then_some(body.found)
}

struct Body<'a> {
    skeleton: &'a Skeleton,
    meanings: Vec<Option<(Part, Option<Side>)>>,
    found: Vec<Option<JointTarget>>,
}

impl Body<'_> {
    /// Joints of these parts on a side, parents first.
    fn of(&self, side: Option<Side>, is: impl Fn(Part) -> bool) -> Vec<usize> {
        let all = self.meanings.iter().enumerate();
        let matching = all.filter(|(_, m)| m.is_some_and(|(part, own)| own == side && is(part)));
        matching.map(|(joint, _)| joint).collect()
    }

    /// The nearest joint above another one that is one of these parts on the same side.
    fn nearest_above(
        &self,
        joint: usize,
        side: Option<Side>,
        is: impl Fn(Part) -> bool,
    ) -> Option<usize> {
        let fits = |j: &usize| self.meanings[*j].is_some_and(|(part, own)| own == side && is(part));
        self.above(joint).find(fits)
    }

    /// The joints above one, from its parent to the root.
    fn above(&self, joint: usize) -> impl Iterator<Item = usize> {
        let parent = |j: &usize| self.skeleton.joints[*j].parent;
        std::iter::successors(parent(&joint), parent)
    }

    fn is_below(&self, joint: usize, above: usize) -> bool {
        self.above(joint).any(|j| j == above)
    }

    /// Whether the rest pose is that of an animal: feet below the hips, hands below the knees.
    fn stands_on_four(&self) -> bool {
        let places = rest::positions(self.skeleton);
        let height = |name: &str| {
            let is_named = |target: &Option<JointTarget>| match target {
                Some(JointTarget::Joint(joint)) => joint.name == name,
                _ => false,
            };
            Some(places[self.found.iter().position(is_named)?].y)
        };
        let is_above = |a: &str, b: &str| {
            let [a, b] = [a, b].map(height);
            a.zip(b).is_some_and(|(a, b)| a > b)
        };
        ["l", "r"].iter().all(|side| {
            let [knee, ankle, wrist] = ["knee", "ankle", "wrist"].map(|j| format!("{side}_{j}"));
            is_above("humanoid_root", &ankle) && is_above(&knee, &wrist)
        })
    }

    fn set(&mut self, joint: usize, name: &str) {
        self.found[joint] = JointTarget::standard(name);
    }

    /// Names leg, arm and fingers of a side; returns thigh and upper arm if all of both limbs is
    /// found.
    fn limbs(&mut self, side: Side) -> Option<(usize, usize)> {
        let named = |part: &str| format!("{}_{part}", side.letter());
        let thigh = self.leg(side, &named)?;
        let upper = self.arm(side, &named)?;
        let eye = self.of(Some(side), |p| p == Part::Eye);
        if let Some(eye) = eye.first() {
            self.set(*eye, &named("eyeball_joint"));
        }
        Some((thigh, upper))
    }

    fn leg(&mut self, side: Side, named: &dyn Fn(&str) -> String) -> Option<usize> {
        let own = Some(side);
        let is_thigh = |p| matches!(p, Part::Thigh | Part::Leg);
        let shins = self.of(own, |p| p == Part::Shin).into_iter();
        let mut shins = shins.chain(self.of(own, |p| p == Part::Leg));
        // A leg is a shin if it is below another one.
        let (shin, thigh) = shins.find_map(|j| Some((j, self.nearest_above(j, own, is_thigh)?)))?;
        self.set(thigh, &named("hip"));
        self.set(shin, &named("knee"));
        let feet = self.of(own, |p| matches!(p, Part::Foot | Part::Toes));
        let mut feet = feet.into_iter().filter(|j| self.is_below(*j, shin));
        let (ankle, ball) = (feet.next(), feet.next());
        if let Some(ankle) = ankle {
            self.set(ankle, &named("ankle"));
        }
        if let Some(ball) = ball {
            self.set(ball, &named("metatarsal"));
        }
        Some(thigh)
    }

    fn arm(&mut self, side: Side, named: &dyn Fn(&str) -> String) -> Option<usize> {
        let own = Some(side);
        let is_upper = |p| matches!(p, Part::UpperArm | Part::Arm | Part::Shoulder);
        let is_collar = |p| matches!(p, Part::Collar | Part::Shoulder);
        let lowers = self.of(own, |p| p == Part::Forearm).into_iter();
        let mut lowers = lowers.chain(self.of(own, |p| p == Part::Arm));
        let (lower, upper) =
            lowers.find_map(|j| Some((j, self.nearest_above(j, own, is_upper)?)))?;
        let collar = self.nearest_above(upper, own, is_collar);
        if let Some(collar) = collar {
            self.set(collar, &named("sternoclavicular"));
        }
        self.set(upper, &named("shoulder"));
        self.set(lower, &named("elbow"));
        let hands = self.of(own, |p| p == Part::Hand);
        if let Some(hand) = hands.into_iter().find(|j| self.is_below(*j, lower)) {
            self.set(hand, &named("wrist"));
        }
        for (finger, name) in FINGERS.iter().enumerate() {
            let joints = self.of(own, |p| matches!(p, Part::Finger(f, _) if f == finger));
            let mut next = 1;
            for joint in joints {
                let palm = matches!(self.meanings[joint], Some((Part::Finger(_, true), _)));
                if palm && finger > 0 {
                    self.set(joint, &named(&format!("{name}0")));
                } else if next <= 3 {
                    self.set(joint, &named(&format!("{name}{next}")));
                    next += 1;
                }
            }
        }
        Some(upper)
    }

    /// Names hips, spine, neck and head.
    fn middle(&mut self, thighs: [usize; 2], arms: [usize; 2]) -> Option<()> {
        let holds = |joint: usize, all: &[usize]| all.iter().all(|j| self.is_below(*j, joint));
        let limbs = [thighs[0], thighs[1], arms[0], arms[1]];
        let named = self.of(None, |p| p == Part::Hips);
        let by_name = named.iter().copied().rfind(|j| holds(*j, &limbs));
        // The joint where legs and arms part, whatever its name is.
        let by_tree = (0..self.skeleton.joints.len()).rfind(|j| holds(*j, &limbs));
        let hips = by_name.or(by_tree)?;
        let pelvis = named
            .iter()
            .copied()
            .find(|j| *j != hips && holds(*j, &thighs));
        let spine = self.of(None, |p| p == Part::Spine);
        let spine: Vec<usize> = spine.into_iter().filter(|j| *j != hips).collect();
        let head = self.of(None, |p| p == Part::Head).into_iter().next();
        let neck = self.of(None, |p| p == Part::Neck).into_iter().next();
        let jaw = self.of(None, |p| p == Part::Jaw).into_iter().next();
        self.set(hips, "humanoid_root");
        for joint in spine {
            self.found[joint] = Some(JointTarget::Spine);
        }
        let singles = [
            (pelvis, "sacroiliac"),
            (neck, "vc4"),
            (head, "skullbase"),
            (jaw, "temporomandibular"),
        ];
        for (joint, name) in singles {
            if let Some(joint) = joint {
                self.set(joint, name);
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::Joint;

    /// A rig of joints with the depth in the tree by which they are indented, and what they are.
    fn rig(text: &str) -> (Skeleton, Vec<&str>) {
        let mut joints: Vec<Joint> = Vec::new();
        let mut above: Vec<usize> = Vec::new();
        let mut wanted = Vec::new();
        for line in text.lines().filter(|l| !l.trim().is_empty()) {
            let depth = line.len() - line.trim_start().len();
            let (name, hanim) = line.trim().split_once(" = ").unwrap();
            above.truncate(depth);
            joints.push(Joint {
                name: name.to_owned(),
                parent: above.last().copied(),
                rest: Transform::IDENTITY,
                in_skin: true,
            });
            above.push(joints.len() - 1);
            wanted.push(hanim);
        }
        (Skeleton { joints }, wanted)
    }

    fn check(text: &str) {
        let (skeleton, wanted) = rig(text);
        let eligible = vec![true; wanted.len()];
        let found = human(&skeleton, &eligible).expect("a human");
        for ((joint, target), wanted) in skeleton.joints.iter().zip(&found).zip(wanted) {
            let found = match target {
                Some(JointTarget::Joint(joint)) => joint.name.as_str(),
                Some(JointTarget::Spine) => "spine",
                _ => "-",
            };
            assert_eq!(found, wanted, "{}", joint.name);
        }
    }

    #[test]
    fn names_of_daz_and_poser() {
        check(
            "
hip = humanoid_root
 abdomen = spine
  chest = spine
   neck = vc4
    head = skullbase
     leftEye = l_eyeball_joint
   lCollar = l_sternoclavicular
    lShldr = l_shoulder
     lForeArm = l_elbow
      lHand = l_wrist
       lThumb1 = l_thumb1
        lThumb2 = l_thumb2
       lMid1 = l_middle1
   rCollar = r_sternoclavicular
    rShldr = r_shoulder
     rForeArm = r_elbow
      rHand = r_wrist
 lThigh = l_hip
  lShin = l_knee
   lFoot = l_ankle
    lToe = l_metatarsal
 rThigh = r_hip
  rShin = r_knee
   rFoot = r_ankle
",
        );
    }

    #[test]
    fn words_in_any_order_with_numbers_of_the_exporter() {
        check(
            "
C_root0000_bind_JNT = humanoid_root
 C_spine0001_bind_JNT = spine
  C_head0002_bind_JNT = skullbase
  L_clavicle0001_bind_JNT = l_sternoclavicular
   L_armUpper0001_bind_JNT = l_shoulder
    L_armLower0001_bind_JNT = l_elbow
     L_hand0001_bind_JNT = l_wrist
  R_clavicle0001_bind_JNT = r_sternoclavicular
   R_armUpper0001_bind_JNT = r_shoulder
    R_armUpperTwist0001_bind_JNT = -
    R_armLower0001_bind_JNT = r_elbow
 L_legUpper0001_bind_JNT = l_hip
  L_legLower0001_bind_JNT = l_knee
   L_foot0001_bind_JNT = l_ankle
 R_legUpper0001_bind_JNT = r_hip
  R_legLower0001_bind_JNT = r_knee
   R_foot0001_bind_JNT = r_ankle
",
        );
    }

    #[test]
    fn conventions_in_one_rig_are_told_apart_by_the_tree() {
        check(
            "
mixamorig:Hips_01 = humanoid_root
 mixamorig:Spine_02 = spine
  mixamorig:Chest3_03 = spine
   mixamorig:LeftCollar_04 = l_sternoclavicular
    mixamorig:LeftShoulder_05 = l_shoulder
     mixamorig:LeftElbow_06 = l_elbow
      mixamorig:LeftWrist_07 = l_wrist
   mixamorig:RightShoulder_08 = r_sternoclavicular
    mixamorig:RightArm_09 = r_shoulder
     mixamorig:RightForeArm_010 = r_elbow
      mixamorig:RightHand_011 = r_wrist
       mixamorig:RightHandIndex1_012 = r_index1
        mixamorig:RightHandIndex2_013 = r_index2
         mixamorig:RightHandIndex3_014 = r_index3
          mixamorig:RightHandIndex4_015 = -
 mixamorig:LeftHip_016 = l_hip
  mixamorig:LeftKnee_017 = l_knee
   mixamorig:LeftAnkle_018 = l_ankle
    mixamorig:LeftToes_019 = l_metatarsal
 mixamorig:RightUpLeg_020 = r_hip
  mixamorig:RightLeg_021 = r_knee
   mixamorig:RightFoot_022 = r_ankle
",
        );
    }

    #[test]
    fn limbs_without_lower_joints_are_no_human() {
        let (skeleton, wanted) = rig("
hips = -
 leftarm = -
 rightarm = -
 leftleg = -
 rightleg = -
");
        assert!(human(&skeleton, &vec![true; wanted.len()]).is_none());
    }
}
