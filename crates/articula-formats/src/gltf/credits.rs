//! Credits: authors and licence of a file.
//!
//! Source: glTF 2.0 `asset` (with the extras that Sketchfab writes), `KHR_xmp_json_ld` with Dublin
//! Core. Credits of VRM take precedence over both.

use super::append::{object, set};
use super::document::Document;
use super::place::Place;
use super::vrm;
use articula_core::source::Credits;
use serde_json::{Value, json};

/// Name of the metadata extension.
const XMP: &str = "KHR_xmp_json_ld";

/// Reads the credits of a document; `None` if it names only the program that wrote it.
pub(super) fn read(root: &Place<'_>) -> Option<Credits> {
    let mut credits = vrm::read_meta(root).unwrap_or_default();
    if let Some(packet) = packet(root) {
        fill(&mut credits, of_packet(&packet));
    }
    if let Some(asset) = root.get("asset") {
        fill(&mut credits, of_asset(&asset));
    }
    let nothing = Credits {
        generator: credits.generator.clone(),
        ..Credits::default()
    };
    (credits != nothing).then_some(credits)
}

impl Document {
    /// Writes the copyright notice to the asset, and title, authors, rights, licence and references
    /// as a packet of KHR_xmp_json_ld; existing values are kept.
    pub(super) fn set_credits(&mut self, credits: &Credits) {
        let asset = object(&mut self.json)
            .entry("asset")
            .or_insert_with(|| json!({}));
        if asset.get("copyright").is_none() && !credits.copyright.is_empty() {
            set(asset, "copyright", credits.copyright.as_str());
        }
        let known = self.json.get("extensions").and_then(|e| e.get(XMP));
        let mut packet = json!({"@context": {"dc": "http://purl.org/dc/elements/1.1/"}});
        let mut say = |key: &str, words: Vec<&str>| {
            let words: Vec<&str> = words.into_iter().filter(|w| !w.is_empty()).collect();
            match words[..] {
                [] => {}
                [one] if key != "dc:creator" => set(&mut packet, key, one),
                _ => set(&mut packet, key, json!({"@list": words})),
            }
        };
        let licence = vec![&*credits.licence_name, &*credits.licence_url];
        say("dc:title", vec![&credits.title]);
        say("dc:creator", credits.authors.iter().map(|a| &**a).collect());
        say("dc:rights", vec![&credits.copyright]);
        say("dc:license", licence);
        say(
            "dc:source",
            credits.references.iter().map(|r| &**r).collect(),
        );
        // A packet with only the context, or with a copyright that the asset has, is not written.
        let says = ["dc:title", "dc:creator", "dc:license", "dc:source"];
        if known.is_some() || says.iter().all(|key| packet.get(key).is_none()) {
            return;
        }
        self.extend(XMP, json!({"packets": [packet]}));
        let asset = object(&mut self.json)
            .entry("asset")
            .or_insert_with(|| json!({}));
        let extensions = object(asset)
            .entry("extensions")
            .or_insert_with(|| json!({}));
        set(extensions, XMP, json!({"packet": 0}));
    }
}

/// Fills empty fields from other credits.
fn fill(credits: &mut Credits, other: Credits) {
    let texts = [
        (&mut credits.title, other.title),
        (&mut credits.copyright, other.copyright),
        (&mut credits.generator, other.generator),
    ];
    for (known, new) in texts {
        if known.is_empty() {
            *known = new;
        }
    }
    if credits.authors.is_empty() {
        credits.authors = other.authors;
    }
    if credits.references.is_empty() {
        credits.references = other.references;
    }
    if credits.licence_name.is_empty() && credits.licence_url.is_empty() {
        credits.licence_name = other.licence_name;
        credits.licence_url = other.licence_url;
    }
}

fn of_asset(asset: &Place<'_>) -> Credits {
    let extra = |key: &str| {
        let extras = asset.get("extras");
        extras.map_or("", |extras| extras.text(key)).to_owned()
    };
    let list = |word: String| match word.is_empty() {
        true => Vec::new(),
        false => vec![word],
    };
    let (licence_name, licence_url) = licence(vec![extra("license")]);
    Credits {
        title: extra("title"),
        authors: list(extra("author")),
        copyright: asset.text("copyright").to_owned(),
        references: list(extra("source")),
        licence_name,
        licence_url,
        generator: asset.text("generator").to_owned(),
        ..Credits::default()
    }
}

/// Returns the metadata packet of the asset or of the character.
fn packet<'a>(root: &Place<'a>) -> Option<Place<'a>> {
    let owners = [
        root.dig(&["asset", "extensions", XMP]),
        root.dig(&["extensions", "KHR_character", "extensions", XMP]),
        root.dig(&["extensions", "KHR_avatar", "extensions", XMP]),
    ];
    let index = owners
        .iter()
        .flatten()
        .find_map(|o| o.get("packet")?.whole().ok());
    let packets = root.dig(&["extensions", XMP])?;
    packets.entry("packets", usize::try_from(index.unwrap_or(0)).ok()?)
}

fn of_packet(packet: &Place<'_>) -> Credits {
    let words = |key: &str| {
        let mut found = Vec::new();
        if let Some(value) = packet.get(key) {
            collect(value.value(), &mut found);
        }
        found
    };
    let first = |key: &str| words(key).into_iter().next().unwrap_or_default();
    let (licence_name, licence_url) = licence(words("dc:license"));
    Credits {
        title: first("dc:title"),
        authors: words("dc:creator"),
        copyright: first("dc:rights"),
        references: words("dc:source"),
        licence_name,
        licence_url,
        ..Credits::default()
    }
}

/// Collects the strings of a JSON-LD value: a text, a list or set, or one text per language.
fn collect(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::String(text) if !text.is_empty() => found.push(text.clone()),
        Value::Array(list) => list.iter().for_each(|v| collect(v, found)),
        Value::Object(members) => {
            let told = members
                .iter()
                .filter(|(key, _)| *key != "@type" && *key != "@language");
            told.for_each(|(_, v)| collect(v, found));
        }
        _ => {}
    }
}

/// Separates name and address of a licence; `NAME (ADDRESS)` contains both.
fn licence(words: Vec<String>) -> (String, String) {
    let is_address = |word: &str| word.starts_with("http://") || word.starts_with("https://");
    let (mut name, mut address) = (String::new(), String::new());
    for word in words {
        let both = word.strip_suffix(')').and_then(|w| w.rsplit_once(" ("));
        let (first, second) = match both.filter(|(_, inner)| is_address(inner)) {
            Some((first, second)) => (first.to_owned(), second.to_owned()),
            None if is_address(&word) => (String::new(), word),
            None => (word, String::new()),
        };
        for (known, new) in [(&mut name, first), (&mut address, second)] {
            if known.is_empty() {
                *known = new;
            }
        }
    }
    (name, address)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn plain_assets_and_their_extras() {
        let json = json!({"asset": {"copyright": "(c) k", "generator": "g", "extras": {
            "author": "A", "title": "T", "source": "https://s",
            "license": "CC-BY-4.0 (http://creativecommons.org/licenses/by/4.0/)"}}});
        let credits = read(&Place::root(&json)).unwrap();
        assert_eq!(credits.licence_name, "CC-BY-4.0");
        assert_eq!(
            credits.licence_url,
            "http://creativecommons.org/licenses/by/4.0/"
        );
        assert_eq!(
            (credits.title.as_str(), credits.copyright.as_str()),
            ("T", "(c) k")
        );
        assert_eq!(credits.authors, ["A"]);
        assert_eq!(
            read(&Place::root(&json!({"asset": {"version": "2.0"}}))),
            None
        );
    }

    #[test]
    fn what_is_written_is_read() {
        let credits = Credits {
            title: "T".into(),
            authors: vec!["A".into()],
            copyright: "(c)".into(),
            references: vec!["r".into(), "s".into()],
            licence_name: "CC0".into(),
            licence_url: "https://l".into(),
            ..Credits::default()
        };
        let mut document = Document {
            json: json!({}),
            buffers: Vec::new(),
            pictures: Vec::new(),
        };
        document.set_credits(&credits);
        assert_eq!(read(&Place::root(&document.json)), Some(credits));
        let before = document.json.clone();
        document.set_credits(&Credits::default());
        assert_eq!(document.json, before);
    }

    #[test]
    fn packets_in_every_spelling() {
        let json = json!({"asset": {"extensions": {"KHR_xmp_json_ld": {"packet": 1}}},
            "extensions": {"KHR_xmp_json_ld": {"packets": [{}, {
                "dc:title": {"@type": "rdf:Alt", "rdf:_1": {"@language": "en", "@value": "T"}},
                "dc:creator": {"@list": ["A", "B"]},
                "dc:license": {"@list": ["CC0", "https://l"]}}]}}});
        let credits = read(&Place::root(&json)).unwrap();
        assert_eq!(credits.title, "T");
        assert_eq!(credits.authors, ["A", "B"]);
        assert_eq!(
            (credits.licence_name, credits.licence_url),
            ("CC0".into(), "https://l".into())
        );
    }

    #[test]
    fn vrm_stands_above_the_asset() {
        let json = json!({"asset": {"copyright": "c", "extras": {"author": "B"}},
            "extensions": {"VRM": {"meta": {"author": "A"}}}});
        let credits = read(&Place::root(&json)).unwrap();
        assert_eq!(
            (credits.authors, credits.copyright),
            (vec!["A".to_owned()], "c".to_owned())
        );
    }
}
