//! Writing of a document as one GLB, with all buffers and pictures in a single binary chunk.
//!
//! Source: glTF 2.0, chapter 4.

use super::append::{entries_mut, index, object, push, set};
use super::document::Document;
use super::matrices::split_animated;
use crate::uri::mime_type;
use crate::written::WriteError;
use serde_json::{Value, json};

impl Document {
    /// Writes the document as one GLB.
    ///
    /// External and inline buffers, and the pictures that were fetched, move into the binary chunk;
    /// a picture that could not be fetched keeps its URI. A node that an animation moves gets a
    /// translation, rotation and scale in place of its matrix, as the format requires. Everything
    /// else, including unknown extensions and extras, is written unchanged.
    ///
    /// # Errors
    /// [`WriteError::TooLarge`] from 4 GiB on; [`WriteError::Mismatch`] if `buffers` does not match
    /// the JSON.
    pub fn write_glb(&self) -> Result<Vec<u8>, WriteError> {
        let (json, binary) = self.packed()?;
        glb(&json, &binary)
    }

    /// Returns the JSON for a single buffer, and that buffer.
    pub(super) fn packed(&self) -> Result<(Value, Vec<u8>), WriteError> {
        if self.count("buffers") != self.buffers.len() {
            let what = format!("{} for {}", self.buffers.len(), self.count("buffers"));
            return Err(WriteError::mismatch("buffers", what));
        }
        let mut json = self.json.clone();
        let mut binary = Vec::new();
        let mut starts = Vec::new();
        for buffer in &self.buffers {
            binary.resize(binary.len().next_multiple_of(4), 0);
            starts.push(binary.len());
            binary.extend_from_slice(buffer);
        }
        if starts.len() > 1 {
            for view in entries_mut(&mut json, "bufferViews") {
                rebase(view, &starts);
                // An unknown extension of a view may refer to a second buffer.
                let extensions = view.get_mut("extensions").and_then(Value::as_object_mut);
                for (_, extension) in extensions.into_iter().flatten() {
                    rebase(extension, &starts);
                }
            }
        }
        self.pack_pictures(&mut json, &mut binary);
        split_animated(&mut json);
        keep_one_buffer(&mut json, binary.len());
        Ok((json, binary))
    }

    fn pack_pictures(&self, json: &mut Value, binary: &mut Vec<u8>) {
        let mut views = self.count("bufferViews");
        for (i, picture) in self.pictures.iter().enumerate() {
            let (Some(bytes), Some(image)) = (picture, entries_mut(json, "images").get_mut(i))
            else {
                continue;
            };
            let declared = image.get("mimeType").and_then(Value::as_str).unwrap_or("");
            let mime = mime_type(declared, bytes);
            // A picture in a buffer needs a media type; one of unknown type stays external.
            if mime.is_empty() || bytes.is_empty() {
                continue;
            }
            binary.resize(binary.len().next_multiple_of(4), 0);
            let view = json!({
                "buffer": 0,
                "byteOffset": binary.len(),
                "byteLength": bytes.len(),
            });
            binary.extend_from_slice(bytes);
            object(image).shift_remove("uri");
            set(image, "mimeType", mime);
            set(image, "bufferView", views);
            push(json, "bufferViews", view);
            views += 1;
        }
    }
}

/// Returns a GLB of a document and its one buffer.
pub(super) fn glb(json: &Value, binary: &[u8]) -> Result<Vec<u8>, WriteError> {
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let chunk = binary.len().next_multiple_of(4);
    let has_binary = !binary.is_empty();
    let total = 20 + text.len() as u64 + if has_binary { 8 + chunk as u64 } else { 0 };
    let length = u32::try_from(total).map_err(|_| WriteError::TooLarge { bytes: total })?;
    let mut out = Vec::with_capacity(total as usize);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length.to_le_bytes());
    out.extend_from_slice(&(text.len() as u32).to_le_bytes());
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    if has_binary {
        out.extend_from_slice(&(chunk as u32).to_le_bytes());
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(binary);
        out.resize(total as usize, 0);
    }
    Ok(out)
}

/// Adjusts a reference to one of several buffers after they were merged.
fn rebase(view: &mut Value, starts: &[usize]) {
    let Some(start) = index(view, "buffer").and_then(|b| starts.get(b)) else {
        return;
    };
    let offset = index(view, "byteOffset").unwrap_or(0);
    set(view, "buffer", 0);
    set(view, "byteOffset", start + offset);
}

fn keep_one_buffer(json: &mut Value, length: usize) {
    let first = entries_mut(json, "buffers").first_mut().map(Value::take);
    if length == 0 {
        object(json).shift_remove("buffers");
        return;
    }
    let mut buffer = first.unwrap_or_default();
    object(&mut buffer).shift_remove("uri");
    set(&mut buffer, "byteLength", length);
    set(json, "buffers", json!([buffer]));
}
