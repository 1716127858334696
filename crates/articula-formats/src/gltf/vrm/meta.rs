//! Credits of a VRM character: authors, licence and terms.
//!
//! Source: `meta` of VRM 0.x and of VRM 1.0. Terms that a VRM 1.0 file omits get the default of the
//! format, which always forbids.

use super::super::place::Place;
use articula_core::source::Credits;
use serde_json::Value;

/// Terms of VRM 0.x, by their names in the file (the spelling is the format's).
const OLD_TERMS: [&str; 5] = [
    "allowedUserName",
    "violentUssageName",
    "sexualUssageName",
    "commercialUssageName",
    "otherPermissionUrl",
];

/// Terms of VRM 1.0 and their defaults.
const TERMS: [(&str, &str); 11] = [
    ("avatarPermission", "onlyAuthor"),
    ("allowExcessivelyViolentUsage", "false"),
    ("allowExcessivelySexualUsage", "false"),
    ("commercialUsage", "personalNonProfit"),
    ("allowPoliticalOrReligiousUsage", "false"),
    ("allowAntisocialOrHateUsage", "false"),
    ("creditNotation", "required"),
    ("allowRedistribution", "false"),
    ("modification", "prohibited"),
    ("thirdPartyLicenses", ""),
    ("otherLicenseUrl", ""),
];

/// The only licence document that VRM 1.0 names.
const PUBLIC_LICENCE: (&str, &str) = ("https://vrm.dev/licenses/1.0/", "VRM Public License 1.0");

/// Reads origin and licence of a VRM file; `None` without such a member.
pub(in super::super) fn read(root: &Place<'_>) -> Option<Credits> {
    let meta = |extension: &str| root.dig(&["extensions", extension, "meta"]);
    meta("VRMC_vrm")
        .map(|m| new(&m))
        .or_else(|| meta("VRM").map(|m| old(&m)))
}

fn new(meta: &Place<'_>) -> Credits {
    let text = |key: &str| meta.text(key).to_owned();
    let url = text("licenseUrl");
    let term = |(key, otherwise): (&str, &str)| {
        let said = meta
            .get(key)
            .map_or(otherwise.to_owned(), |v| word(v.value()));
        (!said.is_empty()).then(|| (key.to_owned(), said))
    };
    Credits {
        title: text("name"),
        version: text("version"),
        authors: words(meta, "authors"),
        contact: text("contactInformation"),
        copyright: text("copyrightInformation"),
        references: words(meta, "references"),
        licence_name: match url == PUBLIC_LICENCE.0 {
            true => PUBLIC_LICENCE.1.to_owned(),
            false => String::new(),
        },
        licence_url: url,
        terms: TERMS.into_iter().filter_map(term).collect(),
        generator: String::new(),
    }
}

fn old(meta: &Place<'_>) -> Credits {
    let text = |key: &str| meta.text(key).to_owned();
    let list = |key: &str| match meta.text(key) {
        "" => Vec::new(),
        one => vec![one.to_owned()],
    };
    let terms = OLD_TERMS.iter().map(|key| ((*key).to_owned(), text(key)));
    Credits {
        title: text("title"),
        version: text("version"),
        authors: list("author"),
        contact: text("contactInformation"),
        references: list("reference"),
        licence_name: text("licenseName"),
        licence_url: text("otherLicenseUrl"),
        terms: terms.filter(|(_, said)| !said.is_empty()).collect(),
        ..Credits::default()
    }
}

fn words(meta: &Place<'_>, key: &str) -> Vec<String> {
    let list = meta.entries(key).unwrap_or_default();
    let words = list.iter().map(|entry| word(entry.value()));
    words.filter(|word| !word.is_empty()).collect()
}

/// Returns a string, number or boolean as text; empty for anything else.
fn word(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Bool(_) | Value::Number(_) => value.to_string(),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_vrm_1_leaves_out_is_forbidden() {
        let json = json!({"extensions": {"VRMC_vrm": {"meta": {"name": "n", "authors": ["a", 1],
            "licenseUrl": "https://vrm.dev/licenses/1.0/", "allowRedistribution": true}}}});
        let credits = read(&Place::root(&json)).unwrap();
        assert_eq!(credits.authors, ["a", "1"]);
        assert_eq!(credits.licence_name, "VRM Public License 1.0");
        let term = |key: &str| credits.terms.iter().find(|(k, _)| k == key).unwrap();
        assert_eq!(term("allowRedistribution").1, "true");
        assert_eq!(term("commercialUsage").1, "personalNonProfit");
        assert_eq!(credits.terms.len(), 9, "without the two that are empty");
    }

    #[test]
    fn vrm_0_says_what_it_says() {
        let json = json!({"extensions": {"VRM": {"meta": {"title": "t", "author": "a",
            "licenseName": "CC_BY", "commercialUssageName": "Allow", "reference": ""}}}});
        let credits = read(&Place::root(&json)).unwrap();
        assert_eq!(
            (credits.title.as_str(), &credits.authors[..]),
            ("t", &["a".to_owned()][..])
        );
        assert_eq!(credits.licence_name, "CC_BY");
        assert_eq!(
            credits.terms,
            [("commercialUssageName".to_owned(), "Allow".to_owned())]
        );
        assert!(credits.references.is_empty());
        assert_eq!(read(&Place::root(&json!({}))), None);
    }
}
