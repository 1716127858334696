//! The extension `ARTICULA_prepared`: data that is computed once for a character, as buffer views.
//!
//! The page is `docs/formats/ARTICULA_prepared.md`; the schema is next to it. The parts are coded by
//! [`prepared`](crate::prepared); here they are opaque bytes with a name, a version and a hash.

use super::append::{entries_mut, index, set};
use super::document::Document;
use super::extension::PREPARED;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// Version of the extension that is written and read.
const VERSION: u64 = 1;

/// Name of the part with the order of vertices in the source, and of its hash.
const VERTEX_ORDER: &str = "vertexOrder";

/// Name of the hash of the meshes.
const MESH: &str = "mesh";

/// What a document's parts were computed from, and how.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct PreparedHeader {
    /// Program that computed the parts, such as `Articula 0.1.0`.
    pub generator: String,
    /// Seed of the samples of vertices and frames.
    pub seed: u64,
    /// Hash of the skeleton, the meshes and the clips, by these names.
    pub hashes: Vec<(String, u64)>,
    /// Number of mesh levels that joint levels were paired with, or 0.
    pub mesh_levels: usize,
}

/// A named part of the extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PreparedEntry<'a> {
    /// Name of the part.
    pub name: &'a str,
    /// Version of its layout.
    pub version: u64,
    /// Hash of its bytes.
    pub hash: u64,
    /// Its bytes.
    pub bytes: &'a [u8],
}

/// State of the extension in a document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PreparedState {
    /// The document does not have it.
    Absent,
    /// It cannot be read, with the reason.
    Unreadable(String),
    /// It can be read.
    Present(PreparedHeader),
}

impl Document {
    /// Stores prepared parts in the document and replaces those that it has.
    pub fn set_prepared(&mut self, header: &PreparedHeader, parts: &[PreparedEntry<'_>]) {
        self.remove_prepared();
        let mut stored = Map::new();
        for part in parts {
            let view = self.add_buffer_view(part.bytes);
            let entry = json!({
                "bufferView": view,
                "version": part.version,
                "hash": hexadecimal(part.hash),
            });
            stored.insert(part.name.to_owned(), entry);
        }
        let mut hashes = Map::new();
        for (name, hash) in &header.hashes {
            hashes.insert(name.clone(), hexadecimal(*hash).into());
        }
        let mut value = json!({
            "version": VERSION,
            "generator": header.generator,
            "seed": header.seed,
            "hashes": hashes,
            "parts": stored,
        });
        if header.mesh_levels > 0 {
            set(&mut value, "meshLevels", header.mesh_levels);
        }
        self.extend(PREPARED, value);
    }

    /// Removes what was computed from clips. The order of vertices in the source belongs to the
    /// meshes and stays.
    pub(super) fn remove_prepared_motion(&mut self) {
        let PreparedState::Present(header) = self.prepared() else {
            return self.remove_prepared();
        };
        let Some(order) = self.prepared_part(VERTEX_ORDER) else {
            return self.remove_prepared();
        };
        let (version, hash, bytes) = (order.version, order.hash, order.bytes.to_vec());
        let hashes = header.hashes.into_iter();
        let header = PreparedHeader {
            hashes: hashes
                .filter(|(name, _)| name == MESH || name == VERTEX_ORDER)
                .collect(),
            mesh_levels: 0,
            ..header
        };
        let order = PreparedEntry {
            name: VERTEX_ORDER,
            version,
            hash,
            bytes: &bytes,
        };
        self.set_prepared(&header, &[order]);
    }

    /// Whether the document lists a part of a name, even if the part cannot be read.
    pub fn lists_prepared_part(&self, name: &str) -> bool {
        self.prepared_entries().any(|(listed, _)| listed == name)
    }

    /// Removes the extension and its bytes.
    pub fn remove_prepared(&mut self) {
        let views: BTreeSet<usize> = self
            .prepared_entries()
            .filter_map(|(_, e)| index(e, "bufferView"))
            .collect();
        if !self.remove_extension(PREPARED) {
            return;
        }
        let count = entries_mut(&mut self.json, "bufferViews").len();
        self.drop_unused_views(views.into_iter().filter(|v| *v < count).collect());
    }

    /// Returns what the parts were computed from.
    pub fn prepared(&self) -> PreparedState {
        let Some(value) = self.prepared_json() else {
            return PreparedState::Absent;
        };
        match header(value) {
            Ok(header) => PreparedState::Present(header),
            Err(what) => PreparedState::Unreadable(what),
        }
    }

    /// Returns the part of a name; `None` if it is absent or does not lie within the document.
    pub fn prepared_part(&self, name: &str) -> Option<PreparedEntry<'_>> {
        self.prepared_parts().find(|part| part.name == name)
    }

    /// Returns all parts that lie within the document.
    pub fn prepared_parts(&self) -> impl Iterator<Item = PreparedEntry<'_>> {
        self.prepared_entries().filter_map(|(name, entry)| {
            Some(PreparedEntry {
                name,
                version: entry.get("version")?.as_u64()?,
                hash: number(entry.get("hash")?)?,
                bytes: self.view_bytes(index(entry, "bufferView")?)?,
            })
        })
    }

    fn prepared_json(&self) -> Option<&Value> {
        self.json.get("extensions")?.get(PREPARED)
    }

    fn prepared_entries(&self) -> impl Iterator<Item = (&str, &Value)> {
        let parts = self
            .prepared_json()
            .and_then(|v| v.get("parts")?.as_object());
        parts
            .into_iter()
            .flatten()
            .map(|(name, entry)| (name.as_str(), entry))
    }
}

fn header(value: &Value) -> Result<PreparedHeader, String> {
    let version = value.get("version").and_then(Value::as_u64);
    if version != Some(VERSION) {
        return Err(match version {
            Some(other) => format!("version {other}, this program reads {VERSION}"),
            None => "the version is missing".to_owned(),
        });
    }
    let hashes = value.get("hashes").and_then(Value::as_object);
    let hashes = hashes.ok_or("the hashes are missing")?;
    let hash = |(name, value): (&String, &Value)| match number(value) {
        Some(hash) => Ok((name.clone(), hash)),
        None => Err(format!("the hash \"{name}\" is not 16 hexadecimal digits")),
    };
    Ok(PreparedHeader {
        generator: value
            .get("generator")
            .and_then(Value::as_str)
            .unwrap_or("")
            .to_owned(),
        seed: value
            .get("seed")
            .and_then(Value::as_u64)
            .ok_or("the seed is missing")?,
        hashes: hashes.iter().map(hash).collect::<Result<_, _>>()?,
        mesh_levels: index(value, "meshLevels").unwrap_or(0),
    })
}

fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}

fn number(value: &Value) -> Option<u64> {
    let text = value.as_str().filter(|t| t.len() == 16)?;
    u64::from_str_radix(text, 16).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn document() -> Document {
        Document {
            json: json!({"asset": {"version": "2.0"}}),
            buffers: Vec::new(),
            pictures: Vec::new(),
        }
    }

    fn part<'a>(name: &'a str, bytes: &'a [u8]) -> PreparedEntry<'a> {
        PreparedEntry {
            name,
            version: 3,
            hash: 0xfedc_ba98_7654_3210,
            bytes,
        }
    }

    #[test]
    fn parts_come_back_and_leave_nothing_behind() {
        let mut d = document();
        let kept = d.add_buffer_view(&[9; 8]);
        let before = d.clone();
        let header = PreparedHeader {
            generator: "Articula".into(),
            seed: 7,
            hashes: vec![("rig".into(), 1), ("mesh".into(), u64::MAX)],
            mesh_levels: 5,
        };
        d.set_prepared(&header, &[part("a", &[1, 2, 3]), part("b", &[4])]);
        d.set_prepared(&header, &[part("a", &[1, 2, 3]), part("b", &[4])]);
        assert_eq!(d.prepared(), PreparedState::Present(header));
        assert_eq!(d.prepared_part("a"), Some(part("a", &[1, 2, 3])));
        assert_eq!(d.prepared_parts().count(), 2);
        assert_eq!(d.prepared_part("c"), None);
        assert_eq!(d.view_bytes(kept), Some(&[9u8; 8][..]));
        let views = d.json["bufferViews"].as_array().map(Vec::len);
        assert_eq!(views, Some(3), "replaced parts leave no view behind");
        d.remove_prepared();
        assert_eq!(d, before);
        assert_eq!(d.prepared(), PreparedState::Absent);
    }

    #[test]
    fn what_cannot_be_read_says_why() {
        let mut d = document();
        let mut why = |value: Value| {
            d.json["extensions"] = json!({PREPARED: value});
            match d.prepared() {
                PreparedState::Unreadable(what) => what,
                other => format!("{other:?}"),
            }
        };
        assert!(why(json!({"version": 2})).contains("version 2"));
        assert!(why(json!({})).contains("version is missing"));
        assert!(why(json!({"version": 1})).contains("hashes"));
        let odd = json!({"version": 1, "seed": 1, "hashes": {"rig": "12"}});
        assert!(why(odd).contains("16 hexadecimal"));
    }

    #[test]
    fn a_part_beyond_the_buffer_does_not_exist() {
        let mut d = document();
        d.set_prepared(&PreparedHeader::default(), &[part("a", &[1])]);
        d.json["bufferViews"][0]["byteLength"] = json!(99);
        assert_eq!(d.prepared_part("a"), None);
    }
}
