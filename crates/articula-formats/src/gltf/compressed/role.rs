//! What the arrays of a document are used for, which decides how they may be rounded.

use super::super::append::{entries_mut, index};
use super::super::extension::CLUSTERED_MESH;
use super::{ArrayPrecision, KeySteps};
use serde_json::Value;
use std::collections::BTreeMap;

/// Use of an array, with the precision that it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Role {
    /// Positions: step in the units of the mesh.
    Positions(f32),
    /// Offsets of positions by morph targets: step of the moved positions, and the array of those.
    Offsets {
        step: f32,
        base: usize,
    },
    Normals,
    /// Offsets of normals by morph targets.
    NormalOffsets,
    Tangents,
    Texcoords,
    Colors,
    Joints,
    Weights,
    /// Corners of a list of triangles.
    Triangles,
    /// Other indices of vertices.
    Indices,
    /// Times of keys: step in seconds.
    Times(f32),
    /// Rotations of keys: step in radians.
    Rotations(f32),
    /// Translations, scales and weights of keys: step in their units.
    Values(f32),
    /// Anything else, and what is used in more than one way: kept to the bit.
    Exact,
}

impl Role {
    /// The use that serves both; the finer step of two.
    fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Positions(a), Self::Positions(b)) => Self::Positions(a.min(b)),
            (
                Self::Offsets { step: a, base },
                Self::Offsets {
                    step: b,
                    base: other,
                },
            ) if base == other => {
                let step = a.min(b);
                Self::Offsets { step, base }
            }
            // Rounded by themselves, offsets serve every position.
            (Self::Offsets { step: a, .. }, Self::Offsets { step: b, .. }) => {
                Self::Positions(0.5 * a.min(b))
            }
            (Self::Rotations(a), Self::Rotations(b)) => Self::Rotations(a.min(b)),
            (Self::Values(a), Self::Values(b)) => Self::Values(a.min(b)),
            (Self::Times(a), Self::Times(b)) => Self::Times(a.min(b)),
            (a, b) if a == b => a,
            _ => Self::Exact,
        }
    }

    /// Whether a view of such arrays is a vertex buffer.
    pub(super) fn is_of_vertices(self) -> bool {
        matches!(
            self,
            Self::Positions(_)
                | Self::Offsets { .. }
                | Self::Normals
                | Self::NormalOffsets
                | Self::Tangents
                | Self::Texcoords
                | Self::Colors
                | Self::Joints
                | Self::Weights
        )
    }
}

/// The uses of all accessors that the document itself refers to.
pub(super) fn roles(json: &mut Value, precision: &ArrayPrecision) -> BTreeMap<usize, Role> {
    let mut found = Roles::default();
    for (m, mesh) in entries_mut(json, "meshes").iter_mut().enumerate() {
        let positions = match precision.positions.get(m) {
            Some(step) => Role::Positions(*step),
            None => Role::Exact,
        };
        for primitive in entries_mut(mesh, "primitives") {
            found.primitive(primitive, positions);
        }
    }
    for (a, animation) in entries_mut(json, "animations").iter_mut().enumerate() {
        let steps = precision.samplers.get(a).map_or(&[][..], Vec::as_slice);
        found.animation(animation, steps);
    }
    for skin in entries_mut(json, "skins") {
        found.add(index(skin, "inverseBindMatrices"), Role::Exact);
    }
    found.separate_offsets();
    found.0
}

#[derive(Default)]
struct Roles(BTreeMap<usize, Role>);

impl Roles {
    fn add(&mut self, accessor: Option<usize>, role: Role) {
        let Some(accessor) = accessor else {
            return;
        };
        let known = self.0.entry(accessor).or_insert(role);
        *known = known.and(role);
    }

    /// Offsets whose positions have another step are rounded by themselves.
    fn separate_offsets(&mut self) {
        let all = self.0.clone();
        for role in self.0.values_mut() {
            if let Role::Offsets { step, base } = *role
                && all.get(&base) != Some(&Role::Positions(step))
            {
                *role = Role::Positions(0.5 * step);
            }
        }
    }

    fn primitive(&mut self, primitive: &Value, positions: Role) {
        let is_list = index(primitive, "mode").is_none_or(|mode| mode == 4);
        let corners = if is_list {
            Role::Triangles
        } else {
            Role::Indices
        };
        self.add(index(primitive, "indices"), corners);
        let levels = primitive
            .get("extensions")
            .and_then(|e| e.get(CLUSTERED_MESH));
        self.add(levels.and_then(|l| index(l, "indices")), Role::Exact);
        self.attributes(primitive.get("attributes"), |name| {
            of_attribute(name, positions)
        });
        let base = primitive
            .get("attributes")
            .and_then(|a| index(a, "POSITION"));
        let offsets = match (positions, base) {
            (Role::Positions(step), Some(base)) => Role::Offsets { step, base },
            _ => positions,
        };
        let targets = primitive.get("targets").and_then(Value::as_array);
        for target in targets.into_iter().flatten() {
            self.attributes(Some(target), |name| match name {
                "POSITION" => offsets,
                "NORMAL" => Role::NormalOffsets,
                _ => Role::Exact,
            });
        }
    }

    fn attributes(&mut self, list: Option<&Value>, role: impl Fn(&str) -> Role) {
        let list = list.and_then(Value::as_object);
        for (name, accessor) in list.into_iter().flatten() {
            self.add(accessor.as_u64().map(|i| i as usize), role(name));
        }
    }

    fn animation(&mut self, animation: &Value, steps: &[Option<KeySteps>]) {
        let list = |key| animation.get(key).and_then(Value::as_array);
        let mut paths: BTreeMap<usize, &str> = BTreeMap::new();
        for channel in list("channels").into_iter().flatten() {
            let path = channel.get("target").and_then(|t| t.get("path"));
            let path = path.and_then(Value::as_str).unwrap_or("");
            if let Some(sampler) = index(channel, "sampler") {
                let known = paths.entry(sampler).or_insert(path);
                if *known != path {
                    *known = "";
                }
            }
        }
        for (s, sampler) in list("samplers").into_iter().flatten().enumerate() {
            let interpolation = sampler.get("interpolation").and_then(Value::as_str);
            let is_spline = interpolation == Some("CUBICSPLINE");
            let step = steps.get(s).copied().flatten();
            let role = match (step, paths.get(&s)) {
                (Some(step), Some(&"rotation")) if !is_spline => Role::Rotations(step.values),
                (Some(step), Some(&("translation" | "scale" | "weights"))) if !is_spline => {
                    Role::Values(step.values)
                }
                _ => Role::Exact,
            };
            let times = step.map_or(Role::Exact, |step| Role::Times(step.times_secs));
            self.add(index(sampler, "input"), times);
            self.add(index(sampler, "output"), role);
        }
    }
}

/// The use of an attribute of vertices.
pub(super) fn of_attribute(name: &str, positions: Role) -> Role {
    let set_of = |family: &str| {
        let set = name.strip_prefix(family);
        set.is_some_and(|set| set.bytes().all(|b| b.is_ascii_digit()))
    };
    match name {
        "POSITION" => positions,
        "NORMAL" => Role::Normals,
        "TANGENT" => Role::Tangents,
        _ if set_of("TEXCOORD_") => Role::Texcoords,
        _ if set_of("COLOR_") => Role::Colors,
        _ if set_of("JOINTS_") => Role::Joints,
        _ if set_of("WEIGHTS_") => Role::Weights,
        _ => Role::Exact,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn arrays_that_serve_two_uses_stay_exact_and_steps_are_the_finer() {
        let mut json = json!({
            "meshes": [
                {"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1, "_X": 2}, "indices": 3,
                    "targets": [{"POSITION": 4, "NORMAL": 5}]}]},
                {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_1": 1}, "mode": 5, "indices": 6}]},
            ],
            "animations": [{
                "channels": [{"sampler": 0, "target": {"path": "rotation"}},
                    {"sampler": 1, "target": {"path": "scale"}},
                    {"sampler": 2, "target": {"path": "rotation"}}],
                "samplers": [{"input": 7, "output": 8}, {"input": 7, "output": 9},
                    {"input": 7, "output": 10, "interpolation": "CUBICSPLINE"}],
            }],
        });
        let keys = |values| {
            let times_secs = 1e-4;
            Some(KeySteps { values, times_secs })
        };
        let precision = ArrayPrecision {
            positions: vec![0.5, 0.25],
            samplers: vec![[0.1, 0.2, 0.3].map(keys).into()],
            texcoords: 1e-3,
            weights: super::super::WeightPrecision::Byte,
        };
        let roles = roles(&mut json, &precision);
        let expected = [
            Role::Positions(0.25),
            Role::Exact,
            Role::Exact,
            Role::Triangles,
            // Their positions are those of the second mesh too, with another step.
            Role::Positions(0.25),
            Role::NormalOffsets,
            Role::Indices,
            Role::Times(1e-4),
            Role::Rotations(0.1),
            Role::Values(0.2),
            Role::Exact,
        ];
        assert_eq!(roles.into_values().collect::<Vec<_>>(), expected);
    }
}
