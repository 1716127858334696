//! Names in a gBSD: labels of units with the alias of their stream, and markers as tokens.
//!
//! The names of ABP-1 are those of annex B of the thesis. A name that is in no table is written as
//! `:VH:name`, a marker as `vh:scheme:value`, so that every map comes back as it was.

use crate::unit::{Marker, Unit};
use std::borrow::Cow;
use std::fmt::Write;

/// Codec whose names a description uses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Abp1,
    Afp1,
    Abp2,
    Afp2,
    Mesh,
    /// No codec that is known.
    Unknown,
}

const ALIAS: &str = ":VH:";
const BBA: &str = ":MG4:";
const FACE: &str = ":AFP1:";

/// For each name of a map the name in a description.
const LABELS: &[(Family, &str, &str)] = &[
    (Family::Abp1, "BoneMask", ":MG4:BoneMask"),
    (Family::Abp1, "BoneValue", ":MG4:BoneValue"),
    (Family::Abp1, "Padding", ":MG4:Padding"),
    (Family::Abp1, "BBAPlane", ":MG4:BBAPlane"),
    (Family::Abp1, "MainHeader", ":MG4:MainHeader"),
    (Family::Abp1, "BoneSegment", ":MG4:BoneSegment"),
    (Family::Abp1, "BBACodingType", ":MG4:BBACodingType"),
    (Family::Abp1, "BBAPlaneEnd", ":MG4:BBAPlaneEnd"),
    (Family::Abp1, "NoOfBones", ":MG4:NoOfBones"),
    (Family::Abp1, "NoOfMuscles", ":MG4:NoOfMuscles"),
    (
        Family::Abp1,
        "NoOfInterpolatedFrames",
        ":MG4:NoOfInterpolatedFrames",
    ),
    (Family::Abp1, "QuantizationValue", ":MG4:QuantizationValue"),
    (Family::Abp1, "Pow2Quantizer", ":MG4:Pow2Quantizer"),
    (Family::Abp1, "ABP-1", ":ABP1:Stream"),
    (Family::Abp1, "AccessUnit", ":ABP1:AccessUnit"),
    (Family::Abp1, "Head", ":ABP1:Head"),
    (Family::Abp1, "length", ":ABP1:Length"),
    (Family::Afp1, "AFP-1", ":AFP1:Stream"),
    (Family::Afp1, "fap_count", ":AFP1:NoOfFaps"),
    (Family::Afp1, "length", ":AFP1:Length"),
    (Family::Abp2, "unit", ":ABP2:Unit"),
    (Family::Abp2, "access_unit", ":ABP2:AccessUnit"),
    (Family::Abp2, "au_bytes", ":ABP2:AuBytes"),
    (Family::Abp2, "frames", ":ABP2:Frames"),
    (Family::Abp2, "head", ":ABP2:Head"),
    (Family::Abp2, "head_bytes", ":ABP2:HeadBytes"),
    (Family::Abp2, "pose", ":ABP2:Pose"),
    (Family::Abp2, "skeleton", ":ABP2:Skeleton"),
    (Family::Abp2, "abp2", ":ABP2:Stream"),
    (Family::Afp2, "unit", ":AFP2:Unit"),
    (Family::Afp2, "access_unit", ":AFP2:AccessUnit"),
    (Family::Afp2, "au_bytes", ":AFP2:AuBytes"),
    (Family::Afp2, "frames", ":AFP2:Frames"),
    (Family::Afp2, "head", ":AFP2:Head"),
    (Family::Afp2, "head_bytes", ":AFP2:HeadBytes"),
    (Family::Afp2, "pose", ":AFP2:Pose"),
    (Family::Afp2, "afp2", ":AFP2:Stream"),
    (Family::Mesh, "chunk", ":AMS:Chunk"),
    (Family::Mesh, "level", ":AMS:Level"),
    (Family::Mesh, "head", ":AMS:Head"),
    (Family::Mesh, "length", ":AMS:Length"),
    (Family::Mesh, "mesh stream", ":AMS:Stream"),
];

/// For each scheme of markers its token. A letter is not the end of another.
const SCHEMES: &[(&str, &str)] = &[
    ("loa", "L"),
    ("region", "R"),
    ("joint", "J"),
    ("tier", "T"),
    ("level", "M"),
    ("parameter", "P"),
    ("face_loa", "FL"),
    ("face_region", "FR"),
    ("pose_loa", "PL"),
    ("object", "O"),
    ("mesh", "S"),
    (ACCESS_UNIT, "A"),
];

/// Scheme and bare token of an access unit.
pub(super) const ACCESS_UNIT: &str = "access_unit";

impl Family {
    /// The codec of a map, by the name of the whole, else by a name of annex B within it.
    pub(super) fn of(map: &Unit) -> Self {
        let root = LABELS
            .iter()
            .find(|row| row.2.ends_with(":Stream") && row.1 == map.label);
        if let Some(row) = root {
            return row.0;
        }
        let mut has_bones = false;
        map.visit(&mut |unit| has_bones |= unit.label == "BoneSegment");
        if has_bones { Self::Abp1 } else { Self::Unknown }
    }

    /// The name in a description.
    pub(super) fn written(self, label: &str) -> Cow<'_, str> {
        let found = LABELS.iter().find(|row| row.0 == self && row.1 == label);
        let candidate = match (found, self) {
            (Some(row), _) => Cow::Borrowed(row.2),
            (None, Self::Abp1) => Cow::Owned(format!("{BBA}{label}")),
            (None, Self::Afp1) => Cow::Owned(format!("{FACE}{label}")),
            (None, _) => Cow::Borrowed(label),
        };
        if read(&candidate) == label {
            candidate
        } else if read(label) == label && label.starts_with(':') {
            Cow::Borrowed(label)
        } else {
            Cow::Owned(format!("{ALIAS}{label}"))
        }
    }
}

/// The name in a map of a name in a description; those of annex B in any case.
pub(super) fn read(written: &str) -> Cow<'_, str> {
    let known = LABELS
        .iter()
        .find(|row| row.2.eq_ignore_ascii_case(written));
    if let Some(row) = known {
        return Cow::Borrowed(row.1);
    }
    let after = |alias| written.strip_prefix(alias);
    let rest = after(ALIAS).or_else(|| after(BBA)).or_else(|| after(FACE));
    Cow::Borrowed(rest.unwrap_or(written))
}

/// The same as an owned or static name.
pub(super) fn read_owned(written: &str) -> Cow<'static, str> {
    let label = read(written);
    let known = LABELS.iter().find(|row| row.1 == label);
    known.map_or_else(
        || Cow::Owned(label.into_owned()),
        |row| Cow::Borrowed(row.1),
    )
}

/// The tokens of markers.
pub(super) fn tokens(markers: &[Marker]) -> String {
    let mut out = String::new();
    for marker in markers {
        let space = if out.is_empty() { "" } else { " " };
        let known = SCHEMES.iter().find(|row| row.0 == marker.scheme);
        // Writing to a text cannot fail.
        let _ = match known {
            Some((ACCESS_UNIT, token)) => {
                write!(out, "{space}{ACCESS_UNIT} {token}:{}", marker.value)
            }
            Some((_, token)) => write!(out, "{space}{token}:{}", marker.value),
            None => {
                let scheme = percent(&marker.scheme);
                write!(out, "{space}vh:{scheme}:{}", marker.value)
            }
        };
    }
    out
}

fn percent(scheme: &str) -> String {
    let mut out = String::new();
    for byte in scheme.bytes() {
        if byte.is_ascii_alphanumeric() || b"-_.".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _ = write!(out, "%{byte:02x}");
        }
    }
    out
}

fn from_percent(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digit = |d: u8| char::from(d).to_digit(16);
        let (high, low) = (rest.next()?, rest.next()?);
        bytes.push((digit(high)? * 16 + digit(low)?) as u8);
    }
    String::from_utf8(bytes).ok()
}

/// What the markers of a unit say.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Tokens {
    pub(super) markers: Vec<Marker>,
    /// Whether it is an access unit.
    pub(super) is_access_unit: bool,
    /// Tokens that are no marker of ours.
    pub(super) other: Vec<String>,
    /// The first token of a known scheme without a number.
    pub(super) malformed: Option<String>,
}

/// Reads the markers of a unit. An access unit without a number has the given one.
pub(super) fn markers(text: &str, ordinal: u32) -> Tokens {
    let mut found = Tokens::default();
    let mut has_number = false;
    for token in text.split_ascii_whitespace() {
        if token.eq_ignore_ascii_case(ACCESS_UNIT) {
            found.is_access_unit = true;
            continue;
        }
        let (name, value) = token.rsplit_once(':').unwrap_or((token, ""));
        let known = SCHEMES.iter().find(|row| row.1.eq_ignore_ascii_case(name));
        let own = name.strip_prefix("vh:").and_then(from_percent);
        let scheme = match (known, own) {
            (Some(row), _) => Cow::Borrowed(row.0),
            (None, Some(own)) => Cow::Owned(own),
            (None, None) => {
                found.other.push(token.to_owned());
                continue;
            }
        };
        has_number |= scheme == ACCESS_UNIT;
        match value.parse() {
            Ok(value) if value_is_plain(token) => found.markers.push(Marker { scheme, value }),
            _ => drop(found.malformed.get_or_insert_with(|| token.to_owned())),
        }
    }
    if found.is_access_unit && !has_number {
        let scheme = Cow::Borrowed(ACCESS_UNIT);
        found.markers.push(Marker {
            scheme,
            value: ordinal,
        });
    }
    found
}

/// Numbers have no sign.
fn value_is_plain(token: &str) -> bool {
    token.bytes().last().is_some_and(|b| b.is_ascii_digit()) && !token.contains('+')
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn names_of_annex_b() {
        assert_eq!(Family::Abp1.written("BoneMask"), ":MG4:BoneMask");
        assert_eq!(Family::Abp2.written("au_bytes"), ":ABP2:AuBytes");
        assert_eq!(read(":mg4:noofbones"), "NoOfBones");
        assert_eq!(read(":MG4:Muscle"), "Muscle");
        assert_eq!(read(":Other:Thing"), ":Other:Thing");
        assert_eq!(Family::Abp1.written("bonemask"), ":VH:bonemask");
        assert_eq!(Family::Mesh.written(":MG4:Padding"), ":VH::MG4:Padding");
    }

    #[test]
    fn tokens_of_annex_b() {
        let marker = |scheme: &'static str, value| Marker {
            scheme: scheme.into(),
            value,
        };
        let found = markers("L:2", 0);
        assert_eq!(found.markers, [marker("loa", 2)]);
        let found = markers("access_unit", 7);
        assert_eq!(found.markers, [marker("access_unit", 7)]);
        let found = markers("codingType  l:1 FR:3 L:x R:+1", 0);
        assert_eq!(found.markers, [marker("loa", 1), marker("face_region", 3)]);
        assert_eq!(found.other, ["codingType"]);
        assert_eq!(found.malformed.as_deref(), Some("L:x"));
        assert_eq!(
            tokens(&[marker("access_unit", 3), marker("tier", 1)]),
            "access_unit A:3 T:1"
        );
    }

    proptest! {
        #[test]
        fn all_names_come_back(label in "\\PC{0,9}|:(MG4|VH|AFP1|ABP2):[A-Za-z]{0,9}", family in 0..6usize) {
            use Family::*;
            let family = [Abp1, Afp1, Abp2, Afp2, Mesh, Unknown][family];
            let written = family.written(&label).into_owned();
            prop_assert_eq!(read(&written), label.as_str());
            prop_assert_eq!(read_owned(&written), label.as_str());
        }

        #[test]
        fn all_markers_come_back(schemes in prop::collection::vec(("\\PC{0,6}|L|loa|region|access_unit", any::<u32>()), 0..5)) {
            let markers: Vec<_> = schemes.into_iter().map(|(scheme, value)| Marker { scheme: scheme.into(), value }).collect();
            let found = super::markers(&tokens(&markers), 9);
            prop_assert_eq!(found.markers, markers);
            prop_assert_eq!(found.other, Vec::<String>::new());
            prop_assert_eq!(found.malformed, None);
        }
    }
}
