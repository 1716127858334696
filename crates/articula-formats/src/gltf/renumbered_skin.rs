//! Vertices of skins from which a joint is removed: new joint indices, and weights that are added
//! up.

use super::append::{entries_mut, float_bytes, index, set};
use super::document::Document;
use super::place::Place;
use super::reader::{Notes, Reader};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::written::WriteError;
use articula_core::source::renumber_influences;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};

/// The place in a skin of a removed joint, and that of the joint which takes its weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Slots {
    pub(super) own: usize,
    pub(super) other: usize,
}

impl Slots {
    fn renumber(self, joint: u16) -> u16 {
        let joint = usize::from(joint);
        let slot = if joint == self.own { self.other } else { joint };
        (slot - usize::from(slot > self.own)) as u16
    }
}

/// Accessors of joints and weights of one set.
type Set = (usize, usize);

/// The influences of a primitive, renumbered; weights only where they change.
struct Renumbered {
    joints: Vec<u16>,
    weights: Option<Vec<f32>>,
    influences: usize,
}

impl Document {
    /// Renumbers the vertices of all meshes with skins that lose a joint; returns the arrays that
    /// are no longer used.
    pub(super) fn renumber_skinned(
        &mut self,
        slots: &BTreeMap<usize, Slots>,
    ) -> Result<BTreeSet<usize>, WriteError> {
        let mut of_mesh: BTreeMap<usize, Option<Slots>> = BTreeMap::new();
        for node in entries_mut(&mut self.json, "nodes") {
            let (Some(mesh), Some(skin)) = (index(node, "mesh"), index(node, "skin")) else {
                continue;
            };
            let own = slots.get(&skin).copied();
            if *of_mesh.entry(mesh).or_insert(own) != own {
                let what = "nodes show it with skins of which the joint is in different places";
                return Err(WriteError::mismatch(format!("meshes[{mesh}]"), what));
            }
        }
        // All arrays are read before the document changes.
        let mut known: BTreeMap<(Vec<Set>, Slots), Renumbered> = BTreeMap::new();
        let mut parts = Vec::new();
        for (mesh, slots) in of_mesh {
            let Some(slots) = slots else { continue };
            for (part, sets) in self.skinned_parts(mesh) {
                let key = (sets, slots);
                if !known.contains_key(&key) {
                    let read = self.renumbered(&key.0, slots).map_err(|e| {
                        let at = format!("meshes[{mesh}].primitives[{part}]");
                        WriteError::mismatch(at, e.to_string())
                    })?;
                    known.insert(key.clone(), read);
                }
                parts.push((mesh, part, key));
            }
        }
        let mut stored: BTreeMap<(Vec<Set>, Slots), Vec<Set>> = BTreeMap::new();
        for (key, new) in known {
            let sets = self.add_influences(&key.0, &new);
            stored.insert(key, sets);
        }
        let mut stale = BTreeSet::new();
        for (mesh, part, key) in parts {
            let value = &mut self.json["meshes"][mesh]["primitives"][part]["attributes"];
            for (n, (joints, weights)) in stored[&key].iter().enumerate() {
                set(value, &format!("JOINTS_{n}"), *joints);
                set(value, &format!("WEIGHTS_{n}"), *weights);
            }
            stale.extend(
                key.0
                    .iter()
                    .flat_map(|(joints, weights)| [*joints, *weights]),
            );
        }
        Ok(stale)
    }

    /// The parts of a mesh that have influences, with their arrays.
    fn skinned_parts(&mut self, mesh: usize) -> Vec<(usize, Vec<Set>)> {
        let Some(value) = entries_mut(&mut self.json, "meshes").get_mut(mesh) else {
            return Vec::new();
        };
        let parts = entries_mut(value, "primitives").iter().enumerate();
        let sets = |(part, value): (usize, &serde_json::Value)| {
            let attributes = value.get("attributes")?;
            let of = |n: usize| {
                let joints = index(attributes, &format!("JOINTS_{n}"))?;
                Some((joints, index(attributes, &format!("WEIGHTS_{n}"))?))
            };
            let sets: Vec<Set> = (0..).map_while(of).collect();
            (!sets.is_empty()).then_some((part, sets))
        };
        parts.filter_map(sets).collect()
    }

    fn renumbered(&self, sets: &[Set], slots: Slots) -> Result<Renumbered, ReadError> {
        let limits = Limits::default();
        let mut reader = Reader::new(self, &limits, Notes::default());
        let influences = 4 * sets.len();
        let (mut joints, mut weights) = (Vec::new(), Vec::new());
        for (n, (of_joints, of_weights)) in sets.iter().enumerate() {
            let accessor = reader.accessor_at(entry(&reader, *of_joints)?)?;
            accessor.expect_type(&["VEC4"])?;
            let count = accessor.count;
            let own = reader.integers(&accessor)?;
            let accessor = reader.accessor_at(entry(&reader, *of_weights)?)?;
            accessor.expect_type(&["VEC4"])?;
            accessor.expect_count(count, "joints")?;
            let of_set = reader.floats_as_they_are(&accessor)?;
            if n == 0 {
                reader.charge("influences", (count * influences) as u64)?;
                joints = vec![0u16; count * influences];
                weights = vec![0.0f32; count * influences];
            } else if joints.len() != count * influences {
                return Err(ReadError::malformed("JOINTS", "sets of different lengths"));
            }
            for v in 0..count {
                for i in 0..4 {
                    let to = v * influences + 4 * n + i;
                    joints[to] = u16::try_from(own[4 * v + i]).unwrap_or(u16::MAX);
                    weights[to] = of_set[4 * v + i];
                }
            }
        }
        let before = weights.clone();
        renumber_influences(&mut joints, &mut weights, influences, |j| slots.renumber(j));
        let is_same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits();
        let changes = !before.iter().zip(&weights).all(is_same);
        Ok(Renumbered {
            joints,
            weights: changes.then_some(weights),
            influences,
        })
    }

    /// Stores influences set by set; weights that do not change stay in their arrays.
    fn add_influences(&mut self, old: &[Set], new: &Renumbered) -> Vec<Set> {
        let is_short = new.joints.iter().all(|j| u8::try_from(*j).is_ok());
        let count = new.joints.len() / new.influences;
        let mut sets = Vec::new();
        for (n, (_, of_weights)) in old.iter().enumerate() {
            let places = |v: usize| v * new.influences + 4 * n..v * new.influences + 4 * n + 4;
            let own = (0..count).flat_map(|v| &new.joints[places(v)]);
            let bytes: Vec<u8> = match is_short {
                true => own.map(|j| *j as u8).collect(),
                false => own.flat_map(|j| j.to_le_bytes()).collect(),
            };
            let size = if is_short { 4 } else { 8 };
            let view = self.add_elements(&bytes, size);
            let component = if is_short { 5121 } else { 5123 };
            let joints = self.add_vectors(view, component, count);
            let weights = match &new.weights {
                None => *of_weights,
                Some(weights) => {
                    let own = (0..count).flat_map(|v| &weights[places(v)]);
                    let view = self.add_elements(&float_bytes(own), 16);
                    self.add_vectors(view, 5126, count)
                }
            };
            sets.push((joints, weights));
        }
        sets
    }

    fn add_vectors(&mut self, view: usize, component: u32, count: usize) -> usize {
        self.add_accessor(json!({
            "bufferView": view,
            "componentType": component,
            "count": count,
            "type": "VEC4",
        }))
    }
}

fn entry<'a>(reader: &Reader<'a>, accessor: usize) -> Result<Place<'a>, ReadError> {
    let missing = || ReadError::malformed("accessors", format!("{accessor} does not exist"));
    reader.root.entry("accessors", accessor).ok_or_else(missing)
}
