//! Properties of the reference human: its joints, its surface at every triangle count, its motions.
#![allow(
    clippy::unwrap_used,
    reason = "a failed step of a test is a failed test"
)]

use articula_core::hanim_table::{BODY_JOINTS, JOINTS};
use articula_core::source::{Character, Primitive, Property, RawClip};
use articula_core::{Mesh, ModelPose, PosedMesh, Rig, local_to_model};
use articula_human::{HumanError, HumanOptions, human};
use glam::{Quat, Vec3};
use std::collections::{HashMap, HashSet};
use std::sync::OnceLock;

fn of(triangles: usize) -> Character {
    human(&HumanOptions::mannequin(triangles)).unwrap()
}

/// The human with the fewest triangles, created once.
fn smallest_human() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| of(2_000))
}

/// The default human, of 12,000 triangles, created once.
fn default_human() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions::mannequin(12_000)).unwrap())
}

/// Both tones of the skin as one surface: vertices at the same position are merged.
fn skin_of(character: &Character) -> Primitive {
    let mut whole = Primitive {
        influences: 4,
        ..Primitive::default()
    };
    let mut places = HashMap::new();
    for part in &character.meshes[0].primitives {
        let renamed: Vec<u32> = (0..part.positions.len())
            .map(|v| {
                let key = (part.positions[v] + Vec3::ZERO)
                    .to_array()
                    .map(f32::to_bits);
                *places.entry(key).or_insert_with(|| {
                    whole.positions.push(part.positions[v]);
                    whole.normals.push(part.normals[v]);
                    whole.joints.extend(&part.joints[4 * v..4 * v + 4]);
                    whole.weights.extend(&part.weights[4 * v..4 * v + 4]);
                    whole.positions.len() as u32 - 1
                })
            })
            .collect();
        let triangles = part.triangles.iter();
        whole
            .triangles
            .extend(triangles.map(|t| t.map(|v| renamed[v as usize])));
    }
    whole
}

fn clip<'a>(character: &'a Character, name: &str) -> &'a RawClip {
    character.clips.iter().find(|c| c.name == name).unwrap()
}

fn total(character: &Character) -> usize {
    let parts = character.meshes.iter().flat_map(|m| &m.primitives);
    parts.map(|p| p.triangles.len()).sum()
}

/// Poses a character at one key of a clip.
struct Player {
    rig: Rig,
    mesh: Mesh,
}

impl Player {
    fn new(character: &Character) -> Self {
        let articulation = character.articulation.clone().unwrap();
        Self {
            rig: Rig::new(&character.skeleton, articulation).unwrap(),
            mesh: Mesh::new(&character.meshes, BODY_JOINTS).unwrap(),
        }
    }

    fn pose(&self, clip: &RawClip, key: usize) -> ModelPose {
        let mut local = self.rig.rest_pose().clone();
        for channel in &clip.channels {
            match channel.property {
                Property::Rotation => {
                    let value = &channel.values[4 * key..4 * key + 4];
                    local.rotations[channel.target] = Quat::from_slice(value);
                }
                Property::Translation => {
                    let value = Vec3::from_slice(&channel.values[3 * key..3 * key + 3]);
                    local.translations[channel.target] = value;
                }
                _ => panic!("the human's clips only turn joints and move the root"),
            }
        }
        let mut model = ModelPose::new(BODY_JOINTS);
        local_to_model(&self.rig, &local, &mut model);
        model
    }

    fn skinned(&self, pose: &ModelPose) -> Vec<Vec3> {
        let mut posed = PosedMesh::new(&self.rig, &self.mesh);
        posed.model.clone_from(pose);
        posed.skinned(&[]).positions
    }

    fn joint(&self, pose: &ModelPose, name: &str) -> Vec3 {
        pose.matrices[self.rig.find(name).unwrap()]
            .translation
            .into()
    }
}

#[test]
fn it_has_the_89_joints_of_the_standard_at_identity() {
    let character = default_human();
    let joints = &character.skeleton.joints;
    assert_eq!(joints.len(), BODY_JOINTS);
    for (joint, row) in joints.iter().zip(&JOINTS) {
        assert_eq!((joint.name.as_str(), joint.parent), (row.name, row.parent));
        assert_eq!(joint.rest.rotation, Quat::IDENTITY);
        assert_eq!(joint.rest.scale, Vec3::ONE);
    }
    let articulation = character.articulation.as_ref().unwrap();
    assert_eq!(
        (articulation.profile.as_str(), articulation.mapped()),
        ("H-Anim", 89)
    );
}

#[test]
fn counts_are_met_and_the_skin_is_one_closed_surface() {
    for (triangles, character) in [
        (2_000, smallest_human()),
        (12_000, default_human()),
        (70_000, &of(70_000)),
    ] {
        let found = total(character);
        assert!(
            found.abs_diff(triangles) * 20 <= triangles,
            "{found} of {triangles}"
        );
        let skin = skin_of(character);
        assert_closed(&skin, &format!("skin at {triangles}"));
        for mesh in &character.meshes[1..3] {
            assert_closed(
                &mesh.primitives[0],
                &format!("{} at {triangles}", mesh.name),
            );
        }
        assert_eq!(pieces(&skin), 1, "the skin is in one piece");
        // A slender adult of 1.75 m.
        assert!((0.052..0.07).contains(&volume(&skin)));
    }
}

#[test]
fn the_border_of_the_tones_is_the_same_on_both_sides() {
    for (triangles, character) in [(2_000, smallest_human()), (12_000, default_human())] {
        let [bare, suit] = &character.meshes[0].primitives[..] else {
            panic!("two tones");
        };
        let vertices = |part: &Primitive| -> HashMap<[u32; 3], usize> {
            let places = part.positions.iter().enumerate();
            places
                .map(|(v, p)| (p.to_array().map(f32::to_bits), v))
                .collect()
        };
        let (here, there) = (vertices(bare), vertices(suit));
        let shared: Vec<_> = here
            .iter()
            .filter_map(|(p, v)| Some((*v, *there.get(p)?)))
            .collect();
        // Five loops: a collar, two sleeves, two legs.
        assert!(shared.len() >= 5 * 5, "{} at {triangles}", shared.len());
        for (v, w) in shared {
            assert_eq!(bare.normals[v], suit.normals[w]);
            assert_eq!(bare.joints[4 * v..4 * v + 4], suit.joints[4 * w..4 * w + 4]);
            assert_eq!(
                bare.weights[4 * v..4 * v + 4],
                suit.weights[4 * w..4 * w + 4]
            );
        }
    }
}

fn assert_closed(primitive: &Primitive, at: &str) {
    let mut directed = HashSet::new();
    for [a, b, c] in &primitive.triangles {
        for edge in [(*a, *b), (*b, *c), (*c, *a)] {
            assert!(
                directed.insert(edge),
                "{at}: edge {edge:?} is used twice in one direction"
            );
        }
        let [p, q, r] = [a, b, c].map(|v| primitive.positions[*v as usize]);
        assert!(
            (q - p).cross(r - p).length() > 1e-11,
            "{at}: a triangle without area at {p}"
        );
    }
    assert!(
        directed.iter().all(|(a, b)| directed.contains(&(*b, *a))),
        "{at}: an open edge"
    );
    assert!(volume(primitive) > 0.0, "{at}: inside out");
}

fn volume(primitive: &Primitive) -> f32 {
    let corner = |v: u32| primitive.positions[v as usize];
    let sixth = |t: &[u32; 3]| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0;
    primitive.triangles.iter().map(sixth).sum()
}

/// Number of connected pieces.
fn pieces(primitive: &Primitive) -> usize {
    let mut parent: Vec<usize> = (0..primitive.positions.len()).collect();
    fn root(parent: &mut [usize], mut v: usize) -> usize {
        while parent[v] != v {
            parent[v] = parent[parent[v]];
            v = parent[v];
        }
        v
    }
    for [a, b, c] in &primitive.triangles {
        for v in [b, c] {
            let (x, y) = (
                root(&mut parent, *a as usize),
                root(&mut parent, *v as usize),
            );
            parent[x] = y;
        }
    }
    (0..parent.len()).filter(|v| parent[*v] == *v).count()
}

#[test]
fn both_halves_are_mirror_images_with_mirrored_weights() {
    let names: HashMap<&str, usize> = JOINTS
        .iter()
        .enumerate()
        .map(|(j, r)| (r.name, j))
        .collect();
    let twin = |j: u16| {
        let name = JOINTS[usize::from(j)].name;
        let other = match name.split_at(2.min(name.len())) {
            ("l_", rest) => format!("r_{rest}"),
            ("r_", rest) => format!("l_{rest}"),
            _ => name.to_owned(),
        };
        names[other.as_str()] as u16
    };
    let skin = skin_of(default_human());
    let at = |p: Vec3| [p.x + 0.0, p.y, p.z].map(f32::to_bits);
    let vertices: HashMap<_, usize> = skin
        .positions
        .iter()
        .enumerate()
        .map(|(v, p)| (at(*p), v))
        .collect();
    let influences = |v: usize| {
        let range = v * skin.influences..(v + 1) * skin.influences;
        let pairs = skin.joints[range.clone()].iter().zip(&skin.weights[range]);
        pairs
            .filter(|(_, w)| **w > 0.0)
            .map(|(j, w)| (*j, *w))
            .collect::<HashMap<u16, f32>>()
    };
    for (v, p) in skin.positions.iter().enumerate() {
        let other = vertices[&at(*p * Vec3::new(-1.0, 1.0, 1.0))];
        let (here, there) = (influences(v), influences(other));
        assert_eq!(here.len(), there.len());
        for (joint, weight) in here {
            assert!((there[&twin(joint)] - weight).abs() < 1e-6, "{p}");
        }
    }
}

#[test]
fn weights_are_whole_and_no_finger_pulls_another() {
    let skin = skin_of(default_human());
    assert_eq!(skin.influences, 4);
    for (weights, joints) in skin.weights.chunks(4).zip(skin.joints.chunks(4)) {
        assert!(weights.iter().all(|w| *w >= 0.0));
        assert!((weights.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        let digits: HashSet<&str> = joints
            .iter()
            .zip(weights)
            .filter(|(_, w)| **w > 0.0)
            .map(|(j, _)| JOINTS[usize::from(*j)].name)
            .filter(|name| name.ends_with(['1', '2', '3']) && !name.contains('v'))
            .map(|name| name.trim_end_matches(['1', '2', '3']))
            .collect();
        assert!(digits.len() <= 1, "{digits:?}");
    }
    let used: HashSet<u16> = skin
        .joints
        .iter()
        .zip(&skin.weights)
        .filter(|(_, w)| **w > 0.0)
        .map(|(j, _)| *j)
        .collect();
    for (j, row) in JOINTS[..BODY_JOINTS].iter().enumerate() {
        let carries = used.contains(&(j as u16)) || row.name.contains("eyeball");
        // The thumb has no metacarpal joint of its own; vc1 lies inside the skull.
        assert!(carries || row.name == "vc1", "{} moves no skin", row.name);
    }
}

#[test]
fn normals_are_unit_and_agree_with_the_triangles() {
    let skin = skin_of(default_human());
    assert!(skin.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
    let against = skin.triangles.iter().filter(|t| {
        let [a, b, c] = t.map(|v| skin.positions[v as usize]);
        let mean: Vec3 = t.iter().map(|v| skin.normals[*v as usize]).sum();
        (b - a).cross(c - a).dot(mean) <= 0.0
    });
    // Only slivers in creases, such as the lids, may disagree.
    assert!(against.count() * 200 < skin.triangles.len());
}

#[test]
fn it_stands_on_the_floor_and_is_as_tall_as_it_says() {
    let skin = skin_of(default_human());
    let heights = skin.positions.iter().map(|p| p.y);
    let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), y| (l.min(y), h.max(y)));
    assert!(low.abs() < 0.002, "lowest point at {low}");
    assert!((high - 1.75).abs() < 0.005, "highest point at {high}");
    let hand = skin
        .positions
        .iter()
        .filter(|p| p.y < 0.8 && p.x.abs() > 0.2)
        .map(|p| p.x.abs());
    let thigh = skin
        .positions
        .iter()
        .filter(|p| (0.6..0.86).contains(&p.y) && p.x.abs() < 0.19);
    let gap = hand.fold(f32::MAX, f32::min) - thigh.map(|p| p.x.abs()).fold(0.0, f32::max);
    assert!(gap > 0.01, "the hands hang clear of the thighs: {gap}");
}

#[test]
fn clips_loop_exactly_and_without_a_kink() {
    let character = default_human();
    let names: Vec<&str> = character.clips.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["idle", "walk", "wave"]);
    for clip in &character.clips {
        for channel in &clip.channels {
            let size = channel.values.len() / channel.times_secs.len();
            let last = channel.times_secs.len() - 1;
            let key = |k: usize| &channel.values[k * size..(k + 1) * size];
            assert_eq!(key(0), key(last));
            assert_eq!(channel.times_secs[last], clip.duration_secs);
            let step = |a: usize, b: usize| -> f32 {
                key(a)
                    .iter()
                    .zip(key(b))
                    .map(|(x, y)| (x - y).powi(2))
                    .sum::<f32>()
                    .sqrt()
            };
            let second = |a: usize, b: usize, c: usize| -> f32 {
                (0..size)
                    .map(|i| (key(a)[i] - 2.0 * key(b)[i] + key(c)[i]).powi(2))
                    .sum::<f32>()
                    .sqrt()
            };
            // The bend of the motion at the seam is no sharper than elsewhere.
            let sharpest = (1..last)
                .map(|k| second(k - 1, k, k + 1))
                .fold(0.0, f32::max);
            assert!(
                second(last - 1, 0, 1) <= sharpest + 1e-6,
                "{} joint {}",
                clip.name,
                channel.target
            );
            let fastest = (0..last).map(|k| step(k, k + 1)).fold(0.0, f32::max);
            assert!(
                fastest < 0.25,
                "{} joint {} leaps by {fastest}",
                clip.name,
                channel.target
            );
        }
    }
}

#[test]
fn feet_stay_above_the_floor_and_planted_feet_do_not_slip() {
    let character = default_human();
    let player = Player::new(character);
    for clip in &character.clips {
        for key in 0..clip.channels[0].times_secs.len() {
            let points = player.skinned(&player.pose(clip, key));
            let lowest = points.iter().map(|p| p.y).fold(f32::MAX, f32::min);
            assert!(lowest > -0.005, "{} key {key}: {lowest}", clip.name);
            assert!(lowest < 0.005, "{} key {key} floats at {lowest}", clip.name);
        }
    }
    // From foot flat to heel off the ball of the foot moves back with the ground, 1.3 m/s.
    let walk = clip(character, "walk");
    let ball = |key: usize, name: &str| player.joint(&player.pose(walk, key), name);
    for (name, first) in [("l_metatarsal", 4), ("r_metatarsal", 20)] {
        for key in first..first + 12 {
            let travelled = ball(key, name) - ball(key + 1, name);
            assert!(
                (travelled.z * 30.0 - 1.3).abs() < 0.1,
                "{name} key {key}: {travelled}"
            );
            assert!(travelled.y.abs() < 0.003, "{name} key {key}: {travelled}");
        }
    }
}

#[test]
fn knees_and_elbows_only_bend_their_way() {
    let character = default_human();
    let player = Player::new(character);
    for clip in &character.clips {
        for key in 0..clip.channels[0].times_secs.len() {
            let pose = player.pose(clip, key);
            for side in ["l_", "r_"] {
                let at = |name: &str| player.joint(&pose, &format!("{side}{name}"));
                let [hip, knee, ankle] = ["hip", "knee", "ankle"].map(at);
                // Offset of the knee from the line between hip and ankle, forward.
                let line = ankle - hip;
                let on_line = hip + line * ((knee - hip).dot(line) / line.length_squared());
                assert!((knee - on_line).z > -0.002, "{} key {key}", clip.name);
            }
        }
    }
    let wave = clip(character, "wave");
    let highest = (0..wave.channels[0].times_secs.len())
        .map(|key| player.pose(wave, key))
        .map(|pose| player.joint(&pose, "r_middle3").y - player.joint(&pose, "r_eyeball_joint").y)
        .fold(f32::MIN, f32::max);
    assert!(highest > 0.0, "the waving hand rises beside the head");
}

#[test]
fn the_walk_stays_in_place() {
    let walk = clip(default_human(), "walk");
    let root = &walk.channels[0];
    assert_eq!((root.target, root.property), (0, Property::Translation));
    let bob = |axis: usize| {
        let values = root.values.iter().skip(axis).step_by(3);
        let (low, high) = values.fold((f32::MAX, f32::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    assert!((0.02..0.06).contains(&bob(1)), "it bobs");
    assert!((0.02..0.06).contains(&bob(0)), "it sways");
    assert!(bob(2) < 0.03, "it does not walk away");
    assert!((1.0..1.2).contains(&walk.duration_secs));
}

#[test]
fn the_same_options_give_the_same_bytes() {
    let (one, two) = (smallest_human(), &of(2_000));
    assert_eq!(one, two);
    let bits = |c: &Character| -> Vec<u32> {
        let skin = skin_of(c);
        skin.positions
            .iter()
            .flat_map(|p| p.to_array())
            .map(f32::to_bits)
            .collect()
    };
    assert_eq!(bits(one), bits(two));
}

#[test]
fn a_count_out_of_range_names_the_range() {
    for triangles in [0, 1_999, 70_001, usize::MAX] {
        let error = human(&HumanOptions::mannequin(triangles)).unwrap_err();
        assert_eq!(error, HumanError::Triangles { found: triangles });
        assert!(error.to_string().contains("2000 to 70000"), "{error}");
    }
}

#[test]
fn the_recipe_takes_it_as_it_is() {
    let asset = articula_build::character(
        default_human(),
        None,
        &articula_build::ClipOptions::default(),
    )
    .unwrap();
    assert_eq!(asset.rig.len(), BODY_JOINTS);
    assert_eq!(asset.clips.len(), 3);
    assert_eq!(asset.mesh.triangles.len(), total(default_human()));
}
