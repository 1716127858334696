//! Arrays of one layout as one compressed view.

use super::super::accessor::Component;
use super::super::append::{entries_mut, index, object, push, set};
use super::super::document::Document;
use super::super::prune::{each_accessor_reference, each_view_reference};
use super::super::reader::{Notes, Reader};
use super::super::write::glb;
use super::array::{Array, Part};
use super::element::elements;
use super::influences::influences;
use super::offsets::Offsets;
use super::role::{Role, roles};
use super::sparse;
use super::{ArrayPrecision, Compression};
use crate::error::ReadError;
use crate::limits::Limits;
use crate::meshopt::encode::{Bitstream, encode};
use crate::meshopt::{Filter, Mode, ViewLayout, decode};
use crate::written::WriteError;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What arrays of one stream have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Kind {
    buffer: Buffer,
    is_compressed: bool,
    filter: u8,
    component: Component,
    stride: usize,
}

/// What a view is a buffer of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Buffer {
    /// Keys and matrices.
    Other,
    Vertices,
    /// Indices. Compressed ones are stored relative to those before, from which a list of triangles begins anew
    /// with the corners 0, 1 and 2; others have a stream for each accessor.
    Indices(Option<usize>),
}

/// Writes a document with rounded and compressed arrays.
pub(super) fn write(
    document: &Document,
    compression: Compression,
    precision: &ArrayPrecision,
) -> Result<Vec<u8>, WriteError> {
    let mut document = document.clone();
    document.drop_unnamed((0..document.count("accessors")).collect());
    let (json, binary) = document.packed()?;
    let mut document = Document {
        json,
        buffers: vec![binary],
        pictures: Vec::new(),
    };
    let mut arrays = arrays(&mut document, precision, compression).map_err(|error| {
        let what = "an array cannot be read";
        WriteError::mismatch("accessors", format!("{what}: {error}"))
    })?;
    share_equal(&mut document, &mut arrays);
    share_samplers(&mut document.json);
    arrays = sparse::with_sparse(&mut document.json, arrays, compression);
    let mut out = Output::new(&mut document, compression, &arrays);
    let mut streams: BTreeMap<Kind, Vec<&Array>> = BTreeMap::new();
    for array in &arrays {
        streams
            .entry(array.kind(compression))
            .or_default()
            .push(array);
    }
    let nodes = nodes_of_keys(out.json);
    for (kind, mut arrays) in streams {
        // Clips begin the motion of a joint near where others do, and the codec stores what changes.
        if kind.buffer == Buffer::Other {
            arrays.sort_by_key(|array| nodes.get(&array.accessor));
        }
        out.put(kind, &arrays)?;
    }
    out.finish()
}

/// For each array of keys the property and the node that it moves first.
fn nodes_of_keys(json: &Value) -> BTreeMap<usize, (String, usize)> {
    let list = |value: &Value, key: &str| value.get(key).and_then(Value::as_array).cloned();
    let mut out = BTreeMap::new();
    for animation in list(json, "animations").into_iter().flatten() {
        let samplers = list(&animation, "samplers").unwrap_or_default();
        for channel in list(&animation, "channels").into_iter().flatten() {
            let sampler = index(&channel, "sampler").and_then(|s| samplers.get(s));
            let output = sampler.and_then(|sampler| index(sampler, "output"));
            let Some(target) = channel.get("target") else {
                continue;
            };
            let path = target.get("path").and_then(Value::as_str);
            if let (Some(output), Some(node), Some(path)) = (output, index(target, "node"), path) {
                out.entry(output).or_insert((path.to_owned(), node));
            }
        }
    }
    out
}

/// All arrays that the document refers to, as they are stored, in the order of their first use.
fn arrays(
    document: &mut Document,
    precision: &ArrayPrecision,
    compression: Compression,
) -> Result<Vec<Array>, ReadError> {
    let roles = roles(&mut document.json, precision);
    let mut order = Vec::new();
    let mut seen = BTreeSet::new();
    each_accessor_reference(&mut document.json, &mut |i| {
        if seen.insert(i) {
            order.push(i);
        }
        i
    });
    let limits = Limits::default();
    let mut reader = Reader::new(document, &limits, Notes::default());
    let mut of_influences = influences(&mut reader, precision.weights)?;
    let mut offsets = Offsets::new(compression == Compression::Khr);
    let mut out = Vec::with_capacity(order.len());
    for accessor in order {
        let role = roles.get(&accessor).copied().unwrap_or(Role::Exact);
        let own = reader.root.entry("accessors", accessor);
        let rounded = of_influences
            .remove(&accessor)
            .filter(|_| matches!(role, Role::Joints | Role::Weights));
        let elements = match (rounded, own) {
            (Some(rounded), _) => rounded,
            (None, Some(own)) => match role {
                Role::Offsets { step, base } => {
                    offsets.elements(&mut reader, own, (base, step), precision)?
                }
                _ => elements(&mut reader, own, role, precision)?,
            },
            (None, None) => continue,
        };
        out.push(Array {
            accessor,
            role,
            part: Part::Whole,
            elements,
        });
    }
    Ok(out)
}

/// Lets references to arrays that rounding made equal name the first of them.
fn share_equal(document: &mut Document, arrays: &mut Vec<Array>) {
    let mut first = HashMap::new();
    let mut same = BTreeMap::new();
    let mut copies = BTreeSet::new();
    for array in arrays.iter() {
        let elements = &array.elements;
        let is_of_indices = elements.mode != Mode::Attributes;
        let form = (
            (
                array.role.is_of_vertices(),
                is_of_indices,
                elements.filter as u8,
            ),
            (elements.component, elements.normalized, elements.stride),
            document.element_type(array.accessor),
            elements.bytes.as_slice(),
        );
        let known = *first.entry(form).or_insert(array.accessor);
        same.insert(array.accessor, known);
        if known != array.accessor {
            copies.insert(array.accessor);
        }
    }
    each_accessor_reference(&mut document.json, &mut |i| {
        same.get(&i).copied().unwrap_or(i)
    });
    arrays.retain(|array| !copies.contains(&array.accessor));
    let new = document.drop_copies(copies);
    for array in arrays {
        array.accessor = new(array.accessor);
    }
}

/// Lets channels of one animation share samplers that are equal.
fn share_samplers(json: &mut Value) {
    for animation in entries_mut(json, "animations") {
        let samplers = animation.get("samplers").and_then(Value::as_array);
        let mut kept: Vec<Value> = Vec::new();
        let mut first: HashMap<String, usize> = HashMap::new();
        let mut new_index = Vec::new();
        for sampler in samplers.into_iter().flatten() {
            let index = *first.entry(sampler.to_string()).or_insert_with(|| {
                kept.push(sampler.clone());
                kept.len() - 1
            });
            new_index.push(index);
        }
        if kept.len() == new_index.len() {
            continue;
        }
        set(animation, "samplers", kept);
        for channel in entries_mut(animation, "channels") {
            let new = index(channel, "sampler").and_then(|s| new_index.get(s));
            new.into_iter()
                .for_each(|new| set(channel, "sampler", *new));
        }
    }
}

impl Array {
    fn kind(&self, compression: Compression) -> Kind {
        let elements = &self.elements;
        let is_compressed = elements.is_compressible && compression.is_of_arrays();
        let buffer = match elements.mode {
            Mode::Attributes if self.role.is_of_vertices() && self.part == Part::Whole => {
                Buffer::Vertices
            }
            Mode::Attributes => Buffer::Other,
            _ => {
                let is_alone = is_compressed && !elements.begins_anew();
                Buffer::Indices(is_alone.then_some(self.accessor))
            }
        };
        Kind {
            buffer,
            is_compressed,
            filter: elements.filter as u8,
            component: elements.component,
            stride: elements.stride,
        }
    }
}

/// The document that is being written, and its one buffer.
struct Output<'a> {
    json: &'a mut Value,
    binary: Vec<u8>,
    compression: Compression,
    /// Length of the views when they are decoded.
    decoded: usize,
    /// Whether vertices have integers that the format itself does not allow.
    is_quantized: bool,
}

impl<'a> Output<'a> {
    /// Keeps the views that no accessor uses, such as pictures.
    fn new(document: &'a mut Document, compression: Compression, arrays: &[Array]) -> Self {
        let source = std::mem::take(&mut document.buffers[0]);
        let json = &mut document.json;
        for array in arrays.iter().filter(|array| array.part == Part::Whole) {
            let accessor = &mut entries_mut(json, "accessors")[array.accessor];
            for member in ["bufferView", "byteOffset", "sparse"] {
                object(accessor).shift_remove(member);
            }
        }
        let mut used = BTreeSet::new();
        each_view_reference(json, &mut |view| {
            used.insert(view);
            view
        });
        let old = object(json).shift_remove("bufferViews");
        let old = old.as_ref().and_then(Value::as_array);
        let mut binary = Vec::new();
        let mut new_index = BTreeMap::new();
        for (i, view) in old.into_iter().flatten().enumerate() {
            let number = |key: &str| view.get(key).and_then(Value::as_u64).unwrap_or(0) as usize;
            let (start, length) = (number("byteOffset"), number("byteLength"));
            let bytes = start
                .checked_add(length)
                .and_then(|end| source.get(start..end));
            let Some(bytes) = bytes.filter(|_| used.contains(&i)) else {
                continue;
            };
            binary.resize(binary.len().next_multiple_of(4), 0);
            let mut view = view.clone();
            set(&mut view, "buffer", 0);
            set(&mut view, "byteOffset", binary.len());
            binary.extend_from_slice(bytes);
            new_index.insert(i, push(json, "bufferViews", view));
        }
        each_view_reference(json, &mut |view| {
            new_index.get(&view).copied().unwrap_or(view)
        });
        Self {
            json,
            binary,
            compression,
            decoded: 0,
            is_quantized: arrays.iter().any(|array| {
                let is_integer = array.elements.component != Component::F32;
                let role = array.role;
                is_integer && matches!(role, Role::Normals | Role::Tangents | Role::Offsets { .. })
            }),
        }
    }

    fn put(&mut self, kind: Kind, arrays: &[&Array]) -> Result<(), WriteError> {
        let mut bytes = Vec::new();
        let mut count = 0;
        let mut starts = Vec::with_capacity(arrays.len());
        for array in arrays {
            starts.push(count * kind.stride);
            bytes.extend_from_slice(&array.elements.bytes);
            count += array.elements.count;
        }
        let Some(first) = arrays.first().map(|array| &array.elements) else {
            return Ok(());
        };
        let layout = ViewLayout {
            mode: first.mode,
            filter: first.filter,
            count: count as u64,
            stride: kind.stride as u64,
        };
        let (stored, decoded) = self.stored(&bytes, &layout, kind.is_compressed)?;
        let view = self.view(kind, &layout, &stored, decoded.len());
        for (array, start) in arrays.iter().zip(starts) {
            self.describe(array, view, start);
        }
        Ok(())
    }

    /// The bytes of a view, and what a reader has of them.
    fn stored(
        &self,
        bytes: &[u8],
        layout: &ViewLayout,
        is_compressed: bool,
    ) -> Result<(Vec<u8>, Vec<u8>), WriteError> {
        let wrong = || WriteError::mismatch("bufferViews", "a view cannot be encoded");
        let is_plain = layout.filter == Filter::None && layout.mode == Mode::Attributes;
        if !is_compressed && is_plain {
            return Ok((bytes.to_vec(), bytes.to_vec()));
        }
        let version = match self.compression {
            Compression::Khr => Bitstream::V1,
            Compression::Ext | Compression::Quantized | Compression::None => Bitstream::V0,
        };
        if !is_compressed && layout.mode != Mode::Attributes {
            let corners = bytes.as_chunks::<4>().0.iter();
            let stride = layout.stride as usize;
            let decoded: Vec<u8> = corners.flat_map(|c| c[..stride].to_vec()).collect();
            return Ok((decoded.clone(), decoded));
        }
        let encoded = encode(bytes, layout, version).ok_or_else(wrong)?;
        let decoded = decode(&encoded, layout, &Limits::default()).map_err(|_| wrong())?;
        match is_compressed {
            true => Ok((encoded, decoded)),
            false => Ok((decoded.clone(), decoded)),
        }
    }

    fn view(&mut self, kind: Kind, layout: &ViewLayout, stored: &[u8], decoded: usize) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let start = self.binary.len();
        self.binary.extend_from_slice(stored);
        let mut view = json!({
            "buffer": 0,
            "byteOffset": start,
            "byteLength": stored.len(),
        });
        match kind.buffer {
            Buffer::Vertices => {
                set(&mut view, "byteStride", kind.stride);
                set(&mut view, "target", 34962);
            }
            Buffer::Indices(_) => set(&mut view, "target", 34963),
            Buffer::Other => {}
        }
        if kind.is_compressed {
            let mut extension = json!({
                "buffer": 0,
                "byteOffset": start,
                "byteLength": stored.len(),
                "byteStride": layout.stride,
                "count": layout.count,
                "mode": mode(layout.mode),
            });
            if layout.filter != Filter::None {
                set(&mut extension, "filter", filter(layout.filter));
            }
            self.decoded = self.decoded.next_multiple_of(4);
            set(&mut view, "buffer", 1);
            set(&mut view, "byteOffset", self.decoded);
            set(&mut view, "byteLength", decoded);
            set(&mut view, "extensions", json!({ self.name(): extension }));
            self.decoded += decoded;
        }
        push(self.json, "bufferViews", view)
    }

    /// Describes an array whose bytes were stored.
    fn describe(&mut self, array: &Array, view: usize, start: usize) {
        let elements = &array.elements;
        let Some(accessor) = entries_mut(self.json, "accessors").get_mut(array.accessor) else {
            return;
        };
        let described = match array.part {
            Part::Whole => &mut *accessor,
            Part::Indices => &mut accessor["sparse"]["indices"],
            Part::Values => &mut accessor["sparse"]["values"],
        };
        set(described, "bufferView", view);
        if start > 0 {
            set(described, "byteOffset", start);
        }
        if array.part != Part::Whole {
            return;
        }
        set(accessor, "componentType", elements.component.code());
        object(accessor).shift_remove("normalized");
        if elements.normalized {
            set(accessor, "normalized", true);
        }
        let is_offset = matches!(array.role, Role::Offsets { .. });
        let is_short = elements.component == Component::I16 && elements.normalized;
        // Other integers are as they were, and so are their bounds.
        let is_made = elements.component == Component::F32 || (is_offset && is_short);
        if is_made || !elements.is_bounded {
            object(accessor).shift_remove("min");
            object(accessor).shift_remove("max");
        }
        // The format wants the bounds of the numbers as they are stored.
        if elements.is_bounded && is_made {
            elements.set_bounds(accessor);
        }
    }

    fn name(&self) -> &'static str {
        match self.compression {
            Compression::Khr => "KHR_meshopt_compression",
            Compression::Ext | Compression::Quantized | Compression::None => {
                "EXT_meshopt_compression"
            }
        }
    }

    fn finish(self) -> Result<Vec<u8>, WriteError> {
        let name = self.name();
        let mut document = Document {
            json: std::mem::take(self.json),
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        let mut buffers = json!([{ "byteLength": self.binary.len() }]);
        if self.decoded > 0 {
            let placeholder = json!({
                "byteLength": self.decoded,
                "extensions": { name: { "fallback": true } },
            });
            buffers = json!([buffers[0], placeholder]);
            document.use_extension(name);
            document.require_extension(name);
        }
        if self.is_quantized {
            document.use_extension("KHR_mesh_quantization");
            document.require_extension("KHR_mesh_quantization");
        }
        if self.binary.is_empty() {
            object(&mut document.json).shift_remove("buffers");
        } else {
            set(&mut document.json, "buffers", buffers);
        }
        glb(&document.json, &self.binary)
    }
}

fn mode(mode: Mode) -> &'static str {
    match mode {
        Mode::Attributes => "ATTRIBUTES",
        Mode::Triangles => "TRIANGLES",
        Mode::Indices => "INDICES",
    }
}

fn filter(filter: Filter) -> &'static str {
    match filter {
        Filter::None => "NONE",
        Filter::Octahedral => "OCTAHEDRAL",
        Filter::Quaternion => "QUATERNION",
        Filter::Exponential => "EXPONENTIAL",
        Filter::Color => "COLOR",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::{KeySteps, WeightPrecision};

    /// Two primitives: positions of floats and of integers, of which the first two vertices of each are
    /// equal after rounding; one animation with two rotations that round to the same.
    fn document() -> Document {
        let mut bytes = Vec::new();
        let mut views = Vec::new();
        let mut put = |part: Vec<u8>| {
            views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len()}));
            bytes.extend_from_slice(&part);
        };
        let floats = |numbers: &[f32]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let shorts = |numbers: &[i16]| numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        put(floats(&[0.0, 0.1, 0.2, 1.0, 1.1, 1.2, 2.0, 0.0, 0.0]));
        put(shorts(&[1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0]));
        put(floats(&[0.0, 1.0]));
        put(floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]));
        put(floats(&[0.0, 0.0, 1e-7, 1.0, 0.0, 0.0, 1.0, 1e-7]));
        put(b"picture".to_vec());
        views[1]["byteStride"] = json!(8);
        let float = |view: usize, count: usize, kind: &str| json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
        let mut positions = float(0, 3, "VEC3");
        positions["min"] = json!([0.0, 0.0, 0.0]);
        positions["max"] = json!([2.0, 1.1, 1.2]);
        let length = bytes.len();
        Document {
            json: json!({
                "asset": {"version": "2.0"},
                "extensionsUsed": ["KHR_mesh_quantization"],
                "extensionsRequired": ["KHR_mesh_quantization"],
                "buffers": [{"byteLength": length}],
                "bufferViews": views,
                "accessors": [positions,
                    {"bufferView": 1, "componentType": 5122, "count": 3, "type": "VEC3",
                        "min": [1, 2, 3], "max": [7, 8, 9]},
                    float(2, 2, "SCALAR"), float(3, 2, "VEC4"), float(4, 2, "VEC4")],
                "images": [{"bufferView": 5, "mimeType": "image/png"}],
                "nodes": [{"mesh": 0}, {}],
                "scenes": [{"nodes": [0, 1]}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}},
                    {"attributes": {"POSITION": 1}}]}],
                "animations": [{"channels": [
                    {"sampler": 0, "target": {"node": 0, "path": "rotation"}},
                    {"sampler": 1, "target": {"node": 1, "path": "rotation"}}],
                    "samplers": [{"input": 2, "output": 3}, {"input": 2, "output": 4}]}],
            }),
            buffers: vec![bytes],
            pictures: vec![None],
        }
    }

    fn precision() -> ArrayPrecision {
        let keys = KeySteps {
            values: 0.01,
            times_secs: 0.1,
        };
        ArrayPrecision {
            positions: vec![0.25],
            samplers: vec![vec![Some(keys); 2]],
            texcoords: 0.1,
            weights: WeightPrecision::Byte,
        }
    }

    fn read(glb: &[u8]) -> (Document, Value) {
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        let json = serde_json::from_slice(&glb[20..20 + length]).unwrap();
        let mut none = |_: &str| Err("none".to_owned());
        let file = crate::gltf::read(glb, &Limits::default(), &mut none).unwrap();
        (file.value.document, json)
    }

    #[test]
    fn arrays_round_share_and_keep_what_is_not_theirs() {
        for compression in [Compression::Ext, Compression::Khr, Compression::None] {
            let glb = document()
                .write_compressed(compression, &precision())
                .unwrap();
            let (read, json) = read(&glb);
            // Of the two rotations one is left, and one sampler for both channels.
            assert_eq!(
                json["accessors"].as_array().unwrap().len(),
                4,
                "{compression:?}"
            );
            let animation = &json["animations"][0];
            assert_eq!(animation["samplers"].as_array().unwrap().len(), 1);
            assert_eq!(animation["channels"][1]["sampler"], 0);
            let accessor = |primitive: usize| {
                let at = format!("/meshes/0/primitives/{primitive}/attributes/POSITION");
                &json["accessors"][json.pointer(&at).unwrap().as_u64().unwrap() as usize]
            };
            assert_eq!(accessor(0)["min"], json!([0, 0, 0]));
            assert_eq!(accessor(0)["max"], json!([2, 1, 1.25]));
            assert_eq!(accessor(1)["min"], json!([1, 2, 3]));
            let view = json["images"][0]["bufferView"].as_u64().unwrap() as usize;
            let view = &read.json["bufferViews"][view];
            let start = view["byteOffset"].as_u64().unwrap() as usize;
            let buffer = view["buffer"].as_u64().unwrap() as usize;
            assert_eq!(&read.buffers[buffer][start..start + 7], b"picture");
        }
    }

    #[test]
    fn a_document_with_an_unknown_extension_is_written_as_it_is() {
        let mut unknown = document();
        unknown.json["meshes"][0]["extensions"] = json!({"EXT_new": {"bufferView": 1}});
        let plain = unknown.write_glb().unwrap();
        assert_eq!(
            unknown
                .write_compressed(Compression::Ext, &precision())
                .unwrap(),
            plain
        );
    }
}
