//! Decoding of compressed buffer views when a document is opened.
//!
//! Afterwards the document has uncompressed views only, so no other module handles compression.
//!
//! Source: KHR_meshopt_compression; EXT_meshopt_compression has the same members.

use super::accessor::bytes_of;
use super::append::{entries_mut, index, object, push, set};
use super::container;
use super::document::Document;
use super::place::Place;
use super::reader::Notes;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::meshopt::{Filter, Mode, ViewLayout, decode};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The two names of the extension.
pub(super) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// Whether a file has views that are compressed by meshopt. What is not a glTF file has none.
#[must_use]
pub fn has_compressed_views(file: &[u8]) -> bool {
    let opened = container::open(file, &Limits::default(), &mut Notes::default());
    opened.is_ok_and(|(json, _)| {
        let views = json.get("bufferViews").and_then(Value::as_array);
        let is_compressed = |view: &Value| {
            let extensions = view.get("extensions");
            NAMES
                .iter()
                .any(|name| extensions.is_some_and(|e| e.get(name).is_some()))
        };
        views.into_iter().flatten().any(is_compressed)
    })
}

/// A view that was compressed.
struct Decoded {
    view: usize,
    name: &'static str,
    bytes: Vec<u8>,
    /// Whether the decoded bytes are not exactly those that were encoded.
    is_rounded: bool,
}

/// Returns for each buffer whether it is only a placeholder for compressed views: it is marked as a
/// fallback, or all its views are compressed.
pub(super) fn placeholders(root: &Place<'_>) -> Result<Vec<bool>, ReadError> {
    let buffers = root.entries("buffers")?;
    let mut compressed = BTreeSet::new();
    let mut plain = BTreeSet::new();
    for view in root.entries("bufferViews")? {
        let buffer = view.get("buffer").and_then(|b| b.whole().ok());
        let views = if extension(&view).is_some() {
            &mut compressed
        } else {
            &mut plain
        };
        views.extend(buffer);
    }
    let is_marked = |buffer: &Place<'_>| {
        let mark = extension(buffer).map(|(_, mark)| mark.is_true("fallback"));
        mark.unwrap_or(false)
    };
    let each = (0u64..).zip(&buffers);
    Ok(each
        .map(|(i, b)| is_marked(b) || compressed.contains(&i) && !plain.contains(&i))
        .collect())
}

fn extension<'a>(owner: &Place<'a>) -> Option<(&'static str, Place<'a>)> {
    let named = |name| Some((name, owner.dig(&["extensions", name])?));
    NAMES.into_iter().find_map(named)
}

/// Decodes every compressed view; `fetched` bytes already count against the limit.
pub(super) fn expand(
    document: &mut Document,
    fetched: u64,
    limits: &Limits,
    notes: &mut Notes,
) -> Result<(), ReadError> {
    let views = decode_all(document, fetched, limits)?;
    for name in NAMES {
        let count = views.iter().filter(|v| v.name == name).count();
        if count > 0 {
            let what = format!(
                "{count} buffer views are compressed ({name}); they are written uncompressed"
            );
            notes.add("bufferViews", what);
        }
    }
    if views.is_empty() {
        return Ok(());
    }
    let rounded = views.iter().filter(|v| v.is_rounded).map(|v| v.view);
    let rounded: BTreeSet<usize> = rounded.collect();
    put(document, views);
    mend_bounds(document, &rounded, limits);
    for name in NAMES {
        document.disuse_extension(name);
    }
    Ok(())
}

fn decode_all(
    document: &Document,
    fetched: u64,
    limits: &Limits,
) -> Result<Vec<Decoded>, ReadError> {
    let root = Place::root(&document.json);
    let mut spent = fetched;
    let mut out = Vec::new();
    for (i, view) in root.entries("bufferViews")?.iter().enumerate() {
        let Some((name, extension)) = extension(view) else {
            continue;
        };
        let shape = shape(view, &extension)?;
        let encoded = bytes_of(&extension, &document.buffers)?;
        // Cannot overflow: the size was compared with the view's length.
        spent = spent.saturating_add(shape.count * shape.stride);
        let which = "bytes of buffers and pictures";
        Limits::check(&extension, which, spent, limits.bytes)?;
        let bytes = decode(encoded, &shape, limits).map_err(|e| placed(&extension, e))?;
        out.push(Decoded {
            view: i,
            name,
            bytes,
            is_rounded: shape.filter != Filter::None,
        });
    }
    Ok(out)
}

fn shape(view: &Place<'_>, extension: &Place<'_>) -> Result<ViewLayout, ReadError> {
    let unknown = |key: &str| {
        let what = format!("unknown {key}");
        ReadError::malformed(extension.path(key), what)
    };
    let shape = ViewLayout {
        mode: match extension.text("mode") {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            "INDICES" => Mode::Indices,
            _ => return Err(unknown("mode")),
        },
        filter: match extension.get("filter").map(|f| f.value().as_str()) {
            None | Some(Some("NONE")) => Filter::None,
            Some(Some("OCTAHEDRAL")) => Filter::Octahedral,
            Some(Some("QUATERNION")) => Filter::Quaternion,
            Some(Some("EXPONENTIAL")) => Filter::Exponential,
            Some(Some("COLOR")) => Filter::Color,
            _ => return Err(unknown("filter")),
        },
        count: extension.require_whole("count")?,
        stride: extension.require_whole("byteStride")?,
    };
    let length = view.require_whole("byteLength")?;
    if shape.count.checked_mul(shape.stride) != Some(length) {
        let (count, stride) = (shape.count, shape.stride);
        let what =
            format!("{count} elements of {stride} bytes do not fill the view of {length} bytes");
        return Err(extension.malformed(what));
    }
    Ok(shape)
}

/// Adds the position of the view to an error of the decoder, which counts bytes from its start.
fn placed(extension: &Place<'_>, error: ReadError) -> ReadError {
    match error {
        ReadError::Malformed { at, what } => extension.malformed(format!("{at}: {what}")),
        other => other,
    }
}

/// Puts the views into a new buffer, and drops what only their compressed form used.
fn put(document: &mut Document, views: Vec<Decoded>) {
    let new = document.buffers.len();
    let mut bytes: Vec<u8> = Vec::new();
    let mut gone = Vec::new();
    for decoded in views {
        let Some(view) = entries_mut(&mut document.json, "bufferViews").get_mut(decoded.view)
        else {
            continue;
        };
        for name in NAMES {
            gone.extend(take_extension(view, name));
        }
        gone.push(view.clone());
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        set(view, "buffer", new);
        set(view, "byteOffset", bytes.len());
        bytes.extend_from_slice(&decoded.bytes);
    }
    for buffer in entries_mut(&mut document.json, "buffers") {
        for name in NAMES {
            take_extension(buffer, name);
        }
    }
    document.drop_ranges(&gone);
    push(
        &mut document.json,
        "buffers",
        json!({ "byteLength": bytes.len() }),
    );
    document.buffers.push(bytes);
    document.drop_unused_buffers();
}

pub(super) fn take_extension(owner: &mut Value, name: &str) -> Option<Value> {
    let extensions = owner.get_mut("extensions").filter(|e| e.is_object())?;
    let taken = object(extensions).shift_remove(name);
    if object(extensions).is_empty() {
        object(owner).shift_remove("extensions");
    }
    taken
}

/// Recomputes the bounds of accessors whose numbers a filter rounded: the format requires exact
/// bounds, and the declared ones belong to the numbers before rounding.
fn mend_bounds(document: &mut Document, rounded: &BTreeSet<usize>, limits: &Limits) {
    let root = Place::root(&document.json);
    let mut stale = Vec::new();
    for (i, place) in root
        .entries("accessors")
        .unwrap_or_default()
        .iter()
        .enumerate()
    {
        let values = place.dig(&["sparse", "values"]);
        let owners = [Some(place.clone()), values].into_iter().flatten();
        let mut views = owners.filter_map(|owner| index(owner.value(), "bufferView"));
        let is_stated = place.get("min").is_some() || place.get("max").is_some();
        if is_stated && views.any(|view| rounded.contains(&view)) {
            stale.push(i);
        }
    }
    document.state_bounds(&stale, limits);
}
