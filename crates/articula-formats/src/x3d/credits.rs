//! Credits of a figure, from the head of the file and the humanoid node.
//!
//! Source: ISO/IEC 19775-1, 7.2.5.6 (META); ISO/IEC 19774-1, 6.2 (`info`, `name=value`), which
//! newer files write as metadata nodes.

use super::fields::Reader;
use super::scene::NodeId;
use crate::error::ReadError;
use articula_core::source::Credits;

/// Reads origin and licence of a file; `None` if it states neither.
pub(super) fn read(
    reader: &mut Reader<'_>,
    humanoid: NodeId,
) -> Result<Option<Credits>, ReadError> {
    let mut credits = Credits::default();
    for (name, content) in &reader.scene.metas {
        take(&mut credits, name, content);
    }
    for line in reader.strings(humanoid, "info")? {
        if let Some((name, value)) = line.split_once('=') {
            take(&mut credits, name, value);
        }
    }
    for set in reader.nodes(humanoid, "metadata") {
        for entry in [reader.nodes(set, "value"), reader.nodes(set, "metadata")].concat() {
            reader.visit(entry, 0)?;
            let value = reader.strings(entry, "value")?.join(", ");
            take(
                &mut credits,
                reader.text(entry, "name").unwrap_or(""),
                &value,
            );
        }
    }
    Ok((credits != Credits::default()).then_some(credits))
}

/// Stores one statement in its field; statements about neither origin nor licence are ignored.
fn take(credits: &mut Credits, name: &str, value: &str) {
    let value = value.trim();
    if value.is_empty() {
        return;
    }
    let set = |field: &mut String| {
        if field.is_empty() {
            value.clone_into(field);
        }
    };
    match name.trim() {
        "title" => set(&mut credits.title),
        "version" => set(&mut credits.version),
        "creator" | "author" | "authorName" | "contributor" | "translator" => {
            let known = credits.authors.iter().any(|author| author == value);
            if !known {
                credits.authors.push(value.to_owned());
            }
        }
        "authorEmail" => set(&mut credits.contact),
        "copyright" | "rights" => set(&mut credits.copyright),
        "reference" | "identifier" => credits.references.push(value.to_owned()),
        "license" => set(&mut credits.licence_url),
        "generator" => set(&mut credits.generator),
        "usageRestrictions" | "accessRights" => {
            credits
                .terms
                .push((name.trim().to_owned(), value.to_owned()));
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::notes::Notes;
    use crate::x3d::xml;

    fn of(head: &str, humanoid: &str) -> Option<Credits> {
        let text = format!("<X3D><head>{head}</head><Scene>{humanoid}</Scene></X3D>");
        let limits = Limits::default();
        let scene = xml::parse(&text, &limits).unwrap().scene;
        let mut reader = Reader::new(&scene, &limits, Notes::default());
        read(&mut reader, scene.roots[0]).unwrap()
    }

    #[test]
    fn head_info_and_metadata_are_gathered() {
        let head = "<meta name='title' content='Jin'/><meta name='creator' content='A. B.'/>
            <meta name='license' content='../license.html'/><meta name='mood' content='x'/>";
        let humanoid = r#"<HAnimHumanoid info='"authorName=A. B." "copyright=2031 A. B."'>
            <MetadataSet name='HAnimHumanoid.info' containerField='metadata'>
            <MetadataString name='usageRestrictions' value='"none"'/>
            <MetadataString name='authorEmail'/></MetadataSet></HAnimHumanoid>"#;
        let credits = of(head, humanoid).unwrap();
        assert_eq!(
            (&*credits.title, &credits.authors[..]),
            ("Jin", &["A. B.".to_owned()][..])
        );
        assert_eq!(
            (&*credits.copyright, &*credits.licence_url),
            ("2031 A. B.", "../license.html")
        );
        assert_eq!(
            credits.terms,
            [("usageRestrictions".to_owned(), "none".to_owned())]
        );
        assert_eq!(of("", "<HAnimHumanoid/>"), None);
    }
}
