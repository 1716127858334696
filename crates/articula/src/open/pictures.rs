//! Pictures of surfaces in formats that are not decoded.

use super::CharacterFile;
use articula_flat::Picture;
use articula_formats::Warning;
use std::collections::BTreeSet;

/// Returns one warning for all pictures that a surface shows and that are of no format that is
/// decoded.
pub(super) fn of_unknown_format(opened: &CharacterFile) -> Option<Warning> {
    let character = &opened.character;
    let shown = character.materials.iter().flat_map(|m| m.images());
    let unknown: BTreeSet<usize> = shown
        .filter(|i| {
            let image = character.images.get(*i);
            image.is_some_and(|i| !i.bytes.is_empty() && !Picture::is_known_format(&i.bytes))
        })
        .collect();
    let first = unknown.first()?;
    let kind = match character.images[*first].mime_type.as_str() {
        "" => "of an unknown format".to_owned(),
        mime => mime.chars().take(40).collect(),
    };
    let more = match unknown.len() - 1 {
        0 => String::new(),
        more => format!(" (and {more} more pictures)"),
    };
    Some(Warning {
        at: format!("images[{first}]"),
        what: format!(
            "the picture is {kind}, which is not decoded{more}; it is kept, and its surface drawn in \
             its plain colour; use PNG, JPEG or WebP to draw it"
        ),
        guess: None,
    })
}
