//! Contacts: intervals in which feet and hands stand still and errors are visible as sliding.
//!
//! Source: `docs/methods/motion-lod.md` 4.6: slower than 0.15 m/s and, for feet, within 5 cm of the
//! lowest height of the clip, for 80 ms or more.

use super::tables::table_hashes;
use crate::character::Asset;
use articula_core::{Clip, Contact, ContactTable, ModelPose, Wrap, local_to_model, sample};
use glam::Vec3;
use std::ops::Range;

/// Attention multiplier of the tolerance on the chain from the root to a joint in contact.
pub(crate) const CONTACT_ATTENTION: f32 = 0.25;

const SLOWER_THAN_METRES_PER_SEC: f32 = 0.15;
const FOOT_WITHIN_METRES: f32 = 0.05;
const MIN_SECS: f32 = 0.08;

/// Contacts of the feet (and toes) of a clip, identified by their H-Anim names; hands only if
/// `hands` is set, and for them low speed alone decides.
pub(crate) fn contacts(asset: &Asset, clip: &Clip, hands: bool) -> Vec<Contact> {
    let is = |names: &[&str]| -> Vec<usize> {
        let joints = &asset.rig.articulation().joints;
        (0..joints.len())
            .filter(|j| {
                joints[*j]
                    .hanim
                    .as_deref()
                    .is_some_and(|n| names.contains(&n))
            })
            .collect()
    };
    let feet = is(&["l_ankle", "r_ankle", "l_metatarsal", "r_metatarsal"]);
    let wrists = if hands {
        is(&["l_wrist", "r_wrist"])
    } else {
        Vec::new()
    };
    let paths = paths(asset, clip, &[feet.as_slice(), wrists.as_slice()].concat());
    let mut found = Vec::new();
    for (i, joint) in feet.iter().chain(&wrists).enumerate() {
        let path: Vec<Vec3> = paths.iter().map(|frame| frame[i]).collect();
        let lowest = path.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        let is_foot = i < feet.len();
        let stands = |f: usize| {
            let near = [f.saturating_sub(1), (f + 1).min(path.len() - 1)];
            let secs = (near[1] - near[0]) as f32 / clip.rate_hz();
            let slow = path[near[1]].distance(path[near[0]]) <= SLOWER_THAN_METRES_PER_SEC * secs;
            slow && (!is_foot || path[f].y <= lowest + FOOT_WITHIN_METRES)
        };
        let least = (MIN_SECS * clip.rate_hz()).ceil() as usize;
        found.extend(
            runs(path.len(), stands, least)
                .into_iter()
                .map(|frames| Contact {
                    joint: *joint,
                    frames,
                }),
        );
    }
    found
}

/// Finds the intervals in which the feet of a character stand still in a clip, at the rate of its
/// keys.
pub fn contact_table(asset: &Asset, clip: &Clip) -> ContactTable {
    let played = clip.at_key_rate();
    ContactTable {
        hashes: table_hashes(&asset.rig, clip, &asset.mesh),
        rate_hz: played.rate_hz(),
        frames: played.frames() as u32,
        contacts: contacts(asset, &played, false),
    }
}

/// Attention of every joint at a frame: [`CONTACT_ATTENTION`] from the root to a joint in contact,
/// 1 elsewhere.
pub(crate) fn attention(asset: &Asset, contacts: &[Contact], frame: usize, out: &mut [f32]) {
    out.fill(1.0);
    for contact in contacts.iter().filter(|c| c.frames.contains(&frame)) {
        let mut at = Some(contact.joint);
        while let Some(j) = at {
            out[j] = CONTACT_ATTENTION;
            at = asset.rig.parent(j);
        }
    }
}

/// Runs of at least `least` frames for which `stands` holds.
fn runs(frames: usize, stands: impl Fn(usize) -> bool, least: usize) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut start = None;
    for f in 0..=frames {
        match (start, f < frames && stands(f)) {
            (None, true) => start = Some(f),
            (Some(s), false) => {
                if f - s >= least.max(1) {
                    runs.push(s..f);
                }
                start = None;
            }
            _ => {}
        }
    }
    runs
}

fn paths(asset: &Asset, clip: &Clip, joints: &[usize]) -> Vec<Vec<Vec3>> {
    let mut pose = asset.rig.rest_pose().clone();
    let mut model = ModelPose::new(asset.rig.len());
    (0..clip.frames())
        .map(|i| {
            let secs = i as f64 / f64::from(clip.rate_hz());
            sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut pose);
            local_to_model(&asset.rig, &pose, &mut model);
            joints.iter().map(|j| model.position(*j)).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::rig_with;
    use articula_core::{Mesh, Track, Tracks};

    #[test]
    fn a_foot_stands_low_and_still_a_hand_anywhere() {
        let names = [None, Some("l_ankle"), Some("r_wrist"), Some("skullbase")];
        let asset = Asset {
            rig: rig_with(&[None, Some(0), Some(0), Some(1)], &names).into(),
            mesh: Mesh::default().into(),
            clips: Vec::new(),
        };
        // Still, half a metre per second ahead, still but 10 cm up, still but 4 cm up.
        let path: Vec<Vec3> = (0..=40)
            .map(|f| match f {
                0..=10 => Vec3::ZERO,
                11..=20 => Vec3::X * 0.01 * (f - 10) as f32,
                21..=30 => Vec3::new(0.1, 0.1, 0.0),
                _ => Vec3::new(0.1, 0.04, 0.0),
            })
            .collect();
        let tracks = Tracks {
            translations: (1..=3)
                .map(|target| Track {
                    target,
                    step: false,
                    values: path.clone(),
                })
                .collect(),
            ..Tracks::default()
        };
        let clip = Clip::new("c", 50.0, path.len(), 4, tracks).unwrap();
        let contact = |joint, frames| Contact { joint, frames };
        // A frame beside one that moves moves itself.
        let feet = [contact(1, 0..10), contact(1, 32..41)];
        assert_eq!(contacts(&asset, &clip, false), feet);
        let hands = [contact(2, 0..10), contact(2, 22..30), contact(2, 32..41)];
        assert_eq!(
            contacts(&asset, &clip, true),
            [&feet[..], &hands[..]].concat()
        );
        let mut attention_at = [0.0; 4];
        for (frame, expected) in [
            (9, [0.25, 0.25, 1.0, 1.0]),
            (10, [1.0; 4]),
            (25, [0.25, 1.0, 0.25, 1.0]),
        ] {
            let found = contacts(&asset, &clip, true);
            let found: Vec<Contact> = if frame == 9 { feet.to_vec() } else { found };
            attention(&asset, &found, frame, &mut attention_at);
            assert_eq!(attention_at, expected, "frame {frame}");
        }
    }

    #[test]
    fn slow_is_less_than_fifteen_centimetres_a_second() {
        let asset = Asset {
            rig: rig_with(&[None, Some(0)], &[None, Some("r_metatarsal")]).into(),
            mesh: Mesh::default().into(),
            clips: Vec::new(),
        };
        for (metres_per_sec, stands) in [(0.14, true), (0.16, false)] {
            let ahead = |f: usize| Vec3::X * (f as f32 / 50.0 * metres_per_sec);
            let tracks = Tracks {
                translations: vec![Track {
                    target: 1,
                    step: false,
                    values: (0..20).map(ahead).collect(),
                }],
                ..Tracks::default()
            };
            let clip = Clip::new("c", 50.0, 20, 2, tracks).unwrap();
            let found = contacts(&asset, &clip, false);
            let expected = Contact {
                joint: 1,
                frames: 0..20,
            };
            let expected = if stands { vec![expected] } else { Vec::new() };
            assert_eq!(found, expected, "{metres_per_sec} m/s");
        }
    }

    #[test]
    fn short_stops_are_no_contacts() {
        let still = [true, false, true, true, true, false, true, true];
        assert_eq!(runs(8, |f| still[f], 3), vec![2..5; 1]);
        assert_eq!(runs(8, |f| still[f], 2), [2..5, 6..8]);
        assert_eq!(runs(0, |_| true, 1), Vec::<Range<usize>>::new());
    }
}
