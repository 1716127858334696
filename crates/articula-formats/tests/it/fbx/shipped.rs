//! Real files against the values of an independent reader, ufbx: joints, rest poses, clips at frames and between
//! them, vertices after skin and shapes.

use super::read;
use crate::{real, world};
use articula_core::source::{Character, Property, evaluate};
use glam::{Affine3A, Vec3};
use serde_json::Value;

/// Distance in metres from the other reader's values.
const METRES: f32 = 1e-4;
/// The same at sparse keys between frames of the file's rate.
const SPARSE_METRES: f32 = 1e-3;
/// Between frames, where rotations are blended on the sphere.
const BETWEEN_METRES: f32 = 25e-3;
/// Number of the first times that are frames.
const ON_FRAMES: usize = 5;

struct Case {
    name: String,
    character: Character,
    warnings: Vec<String>,
    expected: Value,
}

fn case(name: &str) -> Option<Case> {
    let folder = real::fbx_folder()?;
    let bytes = std::fs::read(folder.join(format!("{name}.fbx"))).unwrap();
    let of = |stem: String| std::fs::read(folder.join("expected").join(stem + ".json"));
    let expected = of(name.to_owned())
        .or_else(|_| of(format!("u_{name}")))
        .unwrap();
    let parsed = read(&bytes).unwrap_or_else(|fault| panic!("{name}: {fault}"));
    Some(Case {
        name: name.to_owned(),
        character: parsed.value.character,
        warnings: parsed.warnings.into_iter().map(|w| w.what).collect(),
        expected: serde_json::from_slice(&expected).unwrap(),
    })
}

fn point(value: &Value) -> Vec3 {
    let at = |i: usize| value[i].as_f64().unwrap() as f32;
    Vec3::new(at(0), at(1), at(2))
}

impl Case {
    /// The joint of a name; the other reader numbers a name that a mesh has too.
    fn joint(&self, numbered: &str) -> usize {
        let name = numbered.split('#').next().unwrap();
        let joints = &self.character.skeleton.joints;
        let bone = joints.iter().position(|j| j.in_skin && j.name == name);
        let found = bone.or_else(|| self.character.skeleton.find(name));
        found.unwrap_or_else(|| panic!("{}: no {name}", self.name))
    }

    fn check(&self) {
        self.check_rest();
        self.check_shapes();
        self.check_clips();
    }

    fn check_rest(&self) {
        let joints = self.character.skeleton.joints.iter();
        let count = joints.filter(|j| j.in_skin).count() as u64;
        assert_eq!(
            Some(count),
            self.expected["joints"].as_u64(),
            "{}",
            self.name
        );
        let rest = self.character.skeleton.model_rest();
        // An end without a cluster follows the bound bone above it, not the stored pose.
        let mut follow: Vec<&str> = Vec::new();
        for row in self.expected["rest_world"].as_array().unwrap() {
            let name = row[0].as_str().unwrap();
            let bound = &self.expected["bind_world"][name];
            let above = row[1].as_str().unwrap_or_default();
            let is_above_bound = self.expected["bind_world"][above].is_array();
            if !bound.is_array() && (is_above_bound || follow.contains(&above)) {
                follow.push(name);
                continue;
            }
            let wanted = point(if bound.is_array() { bound } else { &row[2] });
            let found: Vec3 = rest[self.joint(name)].translation.into();
            let apart = found.distance(wanted);
            assert!(apart < METRES, "{}: {name} rests {apart} m off", self.name);
        }
    }

    fn check_shapes(&self) {
        let mut meshes = self.character.meshes.iter();
        for channel in self.expected["blend_channels"].as_array().unwrap() {
            let name = channel["channel"].as_str().unwrap();
            let targets = channel["targets"].as_array().unwrap();
            for (at, target) in targets.iter().enumerate() {
                let full = target["full_weight"].as_f64().unwrap();
                let called = match at + 1 == targets.len() {
                    true => name.to_owned(),
                    false => format!("{name}_{:.0}", 100.0 * full),
                };
                let found = meshes.clone().find_map(|mesh| {
                    let which = mesh.morph_names.iter().position(|n| *n == called)?;
                    Some((mesh, which))
                });
                let (mesh, which) = found.unwrap_or_else(|| panic!("no {called}"));
                let mut moved: Vec<[u32; 3]> = Vec::new();
                let mut farthest = 0.0_f32;
                for primitive in &mesh.primitives {
                    let offsets = &primitive.morphs[which].positions;
                    for (offset, at) in offsets.iter().zip(&primitive.positions) {
                        farthest = farthest.max(offset.length());
                        if *offset != Vec3::ZERO {
                            moved.push(at.to_array().map(f32::to_bits));
                        }
                    }
                }
                moved.sort_unstable();
                moved.dedup();
                let wanted = target["max_offset_world_m"].as_f64().unwrap() as f32;
                assert!((farthest - wanted).abs() < METRES, "{called}: {farthest} m");
                assert!(moved.len() as u64 <= target["offsets"].as_u64().unwrap());
                assert!(!moved.is_empty(), "{called} moves nothing");
            }
        }
        let count = meshes.next().map_or(0, |mesh| mesh.morph_names.len());
        let channels = self.expected["blend_channels"].as_array().unwrap();
        let targets = channels
            .iter()
            .map(|c| c["targets"].as_array().unwrap().len());
        assert_eq!(count, targets.sum::<usize>());
    }

    fn check_clips(&self) {
        let clips = self.expected["clips"].as_array().unwrap();
        assert_eq!(self.character.clips.len(), clips.len(), "{}", self.name);
        for (index, wanted) in clips.iter().enumerate() {
            let mut alone = self.character.clone();
            alone.clips = vec![alone.clips.swap_remove(index)];
            let clip = &alone.clips[0];
            assert_eq!(clip.name, wanted["name"].as_str().unwrap());
            let begin = wanted["begin"].as_f64().unwrap();
            let duration = wanted["end"].as_f64().unwrap() - begin;
            assert!((f64::from(clip.duration_secs) - duration).abs() < 2e-6);
            let times = wanted["times_first_five_on_frames"].as_array().unwrap();
            let times: Vec<f32> = times
                .iter()
                .map(|t| (t.as_f64().unwrap() - begin) as f32)
                .collect();
            for (at, secs) in times.iter().enumerate() {
                let near = match at < ON_FRAMES {
                    false => BETWEEN_METRES,
                    true if self.name.starts_with("pab") => SPARSE_METRES,
                    true => METRES,
                };
                let places = world::places(&alone, *secs);
                for (name, positions) in wanted["joints_world"].as_object().unwrap() {
                    let apart = places[self.joint(name)].distance(point(&positions[at]));
                    let (file, clip) = (&self.name, &clip.name);
                    assert!(
                        apart < near,
                        "{file}: {clip}: {name} is {apart} m off at {secs} s"
                    );
                }
            }
            for shown in wanted["skinned_world"].as_array().unwrap() {
                self.check_vertices(&alone, shown, &times);
            }
        }
    }

    /// Each point of the other reader is a vertex that is near it at all times.
    fn check_vertices(&self, alone: &Character, shown: &Value, times: &[f32]) {
        let name = shown["node"].as_str().unwrap();
        let name = name.split('#').next().unwrap();
        let mesh = alone.meshes.iter().position(|m| m.name == name);
        let mesh = mesh.unwrap_or_else(|| panic!("{}: no mesh {name}", self.name));
        let world = shown["world"].as_array().unwrap();
        let count = world[0].as_array().unwrap().len();
        let mut apart: Vec<Vec<f32>> = vec![Vec::new(); count];
        for (at, secs) in times.iter().take(ON_FRAMES).enumerate() {
            let vertices = vertices(alone, mesh, *secs);
            for (point_index, apart) in apart.iter_mut().enumerate() {
                apart.resize(vertices.len(), 0.0);
                let wanted = point(&world[at][point_index]);
                for (most, vertex) in apart.iter_mut().zip(&vertices) {
                    *most = most.max(vertex.distance(wanted));
                }
            }
        }
        for (at, apart) in apart.iter().enumerate() {
            let nearest = apart.iter().copied().fold(f32::MAX, f32::min);
            assert!(
                nearest < METRES,
                "{}: {name}: point {at} is {nearest} m off",
                self.name
            );
        }
    }
}

/// Vertices of a mesh after shapes and skin.
fn vertices(character: &Character, mesh: usize, secs: f32) -> Vec<Vec3> {
    let worlds = world::matrices(character, secs);
    let mut weights = character.meshes[mesh].morph_weights.clone();
    let channels = character.clips.iter().flat_map(|clip| &clip.channels);
    let mut of_mesh = channels.filter(|c| c.property == Property::Weights && c.target == mesh);
    if let Some(channel) = of_mesh.next() {
        evaluate::channel(channel, secs, &mut weights);
    }
    let mesh = &character.meshes[mesh];
    let skin = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
    let palette: Vec<Affine3A> = skin.map(|(joint, bind)| worlds[*joint] * *bind).collect();
    let mut placed = Vec::new();
    for primitive in &mesh.primitives {
        for (vertex, position) in primitive.positions.iter().enumerate() {
            let mut position = *position;
            for (target, weight) in primitive.morphs.iter().zip(&weights) {
                position += target.positions[vertex] * *weight;
            }
            let at = vertex * primitive.influences..(vertex + 1) * primitive.influences;
            let list = primitive.joints[at.clone()]
                .iter()
                .zip(&primitive.weights[at]);
            let moved = list.map(|(entry, weight)| {
                palette[usize::from(*entry)].transform_point3(position) * *weight
            });
            placed.push(moved.sum());
        }
    }
    placed
}

/// Checks a file and what its warnings say, in their order.
fn check(name: &str, told: &[&str]) {
    let Some(case) = case(name) else {
        return;
    };
    case.check();
    let said = &case.warnings;
    assert_eq!(said.len(), told.len(), "{said:?}");
    for (said, told) in said.iter().zip(told) {
        assert!(said.contains(told), "{said}");
    }
}

#[test]
fn a_human_of_3ds_max() {
    check("rocketbox_m01", &["without its picture (and 2 more)"]);
}

#[test]
fn a_motion_of_motion_builder() {
    let told = [
        "binary data, which is not read (and 59 more)",
        "bytes beyond ASCII",
        "a camera is not read (and 6 more)",
        "mirrored",
    ];
    check("pab_run", &told);
}

#[test]
fn a_robot_of_blender_with_many_clips() {
    check("q_robot", &[]);
}

#[test]
fn a_text_file_with_componentwise_scale() {
    let name = "motionbuilder_sausage_rrss_7700_ascii";
    check(name, &["a camera is not read"]);
}

#[test]
fn a_skin_of_blender() {
    check("blender_279_sausage_7400_binary", &[]);
}

#[test]
fn shapes_with_others_in_between() {
    check("maya_blend_inbetween_7500_binary", &[]);
}

#[test]
fn layers_and_orders_of_rotation() {
    check("maya_anim_layers_over_acc_orders_7500_binary", &[]);
}

#[test]
fn a_skin_below_a_transformed_node() {
    check("max_transformed_skin_7500_binary", &["dual quaternions"]);
}
