//! Builds tiny glTF files in code.

use articula_formats::gltf::{self, GltfFile};
use articula_formats::{Limits, Parsed, ReadError};
use serde_json::{Value, json};

/// Returns the height of the hips above the ground at rest, in metres.
pub(crate) fn hips_height_metres(file: &GltfFile) -> f32 {
    let mut bones = file.humanoid.iter().flatten();
    let (hips, _) = bones.find(|(_, bone)| bone == "hips").unwrap();
    let joints = &file.character.skeleton.joints;
    let above = std::iter::successors(Some(*hips), |j| joints[*j].parent);
    let place = above.fold(glam::Vec3::ZERO, |place, j| {
        joints[j].rest.to_affine().transform_point3(place)
    });
    place.y
}

/// A document under construction with one buffer.
pub(crate) struct Tiny {
    pub(crate) json: Value,
    pub(crate) bytes: Vec<u8>,
}

impl Tiny {
    pub(crate) fn new() -> Self {
        let json = json!({"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []});
        let bytes = Vec::new();
        Self { json, bytes }
    }

    /// A triangle in the xy plane as mesh 0, without node.
    pub(crate) fn triangle() -> Self {
        let mut tiny = Self::new();
        let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
        let positions = tiny.floats("VEC3", &corners);
        tiny.json["accessors"][positions]["min"] = json!([0, 0, 0]);
        tiny.json["accessors"][positions]["max"] = json!([1, 1, 0]);
        tiny.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
        tiny
    }

    /// The triangle on node 2, skinned to nodes 0 and 1, one the parent of the other.
    pub(crate) fn skinned() -> Self {
        let mut tiny = Self::triangle();
        let joints = tiny.bytes_accessor("VEC4", 5121, &[0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
        let weights = [0.25, 0.75, 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.];
        let weights = tiny.floats("VEC4", &weights);
        let attributes = &mut tiny.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        tiny.json["nodes"] = json!([
            {"name": "hips", "children": [1]},
            {"name": "chest", "translation": [0, 1, 0]},
            {"name": "body", "mesh": 0, "skin": 0},
        ]);
        tiny.json["skins"] = json!([{"joints": [0, 1]}]);
        tiny.json["scenes"] = json!([{"nodes": [0, 2]}]);
        tiny.json["scene"] = json!(0);
        tiny
    }

    /// Adds a channel with a new sampler to animation 0.
    pub(crate) fn channel(&mut self, target: Value, mode: &str, times: &[f32], output: usize) {
        let input = self.floats("SCALAR", times);
        let (least, greatest) = (times[0], times[times.len() - 1]);
        self.json["accessors"][input]["min"] = json!([least]);
        self.json["accessors"][input]["max"] = json!([greatest]);
        if self.json["animations"].is_null() {
            self.json["animations"] = json!([{"channels": [], "samplers": []}]);
        }
        let animation = &mut self.json["animations"][0];
        let samplers = animation["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": mode}));
        let sampler = samplers.len() - 1;
        let channels = animation["channels"].as_array_mut().unwrap();
        channels.push(json!({"sampler": sampler, "target": target}));
    }

    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
        }));
        self.bytes.extend_from_slice(bytes);
        views.len() - 1
    }

    pub(crate) fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.bytes_accessor(kind, 5126, &bytes)
    }

    pub(crate) fn bytes_accessor(&mut self, kind: &str, component: u32, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let width = [
            ("SCALAR", 1),
            ("VEC2", 2),
            ("VEC3", 3),
            ("VEC4", 4),
            ("MAT4", 16),
        ];
        let width = width.iter().find(|(k, _)| *k == kind).unwrap().1;
        let size = match component {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        self.accessor(json!({
            "bufferView": view,
            "componentType": component,
            "count": bytes.len() / (width * size),
            "type": kind,
        }))
    }

    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"].is_null() && !self.bytes.is_empty() {
            json["buffers"] = json!([{"byteLength": self.bytes.len()}]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        let total = 12 + 8 + text.len() + 8 + binary.len();
        out.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &binary)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }

    pub(crate) fn read(&self) -> Result<Parsed<GltfFile>, ReadError> {
        read(&self.glb())
    }
}

/// Reads a file without external data.
pub(crate) fn read(bytes: &[u8]) -> Result<Parsed<GltfFile>, ReadError> {
    let mut alone = |_: &str| Err("there is nothing beside it".to_owned());
    gltf::read(bytes, &Limits::default(), &mut alone)
}
