//! Bytes of the parts of glTF files as a table.

use crate::table::Table;
use articula::optimize::BytesByKind;

/// Bytes of one kind.
type Kind = fn(&BytesByKind) -> usize;

/// A column for each file; parts that none has are left out.
pub(crate) fn parts_table(files: &[(&'static str, BytesByKind)]) -> Table {
    let head: Vec<&str> = [vec!["bytes"], files.iter().map(|(name, _)| *name).collect()].concat();
    let mut table = Table::new(&head);
    let kinds: [(&str, Kind); 6] = [
        ("document (JSON)", |bytes| bytes.json),
        ("keys", |bytes| bytes.keys),
        ("geometry", |bytes| bytes.geometry),
        ("morph targets", |bytes| bytes.morphs),
        ("textures", |bytes| bytes.textures),
        ("other", |bytes| bytes.other),
    ];
    for (name, of) in kinds {
        let bytes: Vec<usize> = files.iter().map(|(_, file)| of(file)).collect();
        if bytes.iter().any(|bytes| *bytes > 0) {
            let cells = bytes.iter().map(usize::to_string);
            table.row([name.to_owned()].into_iter().chain(cells));
        }
    }
    table
}
