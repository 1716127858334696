//! Characters: which file each is, and which job packages it.

use rusqlite::{Connection, params};

/// A character of the folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct CharacterRow {
    pub(crate) name: String,
    /// The file or folder, in that of the characters.
    pub(crate) file: String,
    /// By what it is known unchanged, if it is sure.
    pub(crate) stamp: Option<String>,
    /// BLAKE3 of it.
    pub(crate) source: String,
    pub(crate) job: String,
}

/// All characters, by name.
pub(crate) fn all(db: &Connection) -> rusqlite::Result<Vec<CharacterRow>> {
    let select = "SELECT name, file, stamp, source, job FROM characters ORDER BY name";
    let mut rows = db.prepare(select)?;
    let rows = rows.query_map([], |row| {
        Ok(CharacterRow {
            name: row.get(0)?,
            file: row.get(1)?,
            stamp: row.get(2)?,
            source: row.get(3)?,
            job: row.get(4)?,
        })
    });
    rows?.collect()
}

/// A character, in the place of one of the same name. Its job is there.
pub(crate) fn put(db: &Connection, row: &CharacterRow) -> rusqlite::Result<()> {
    let insert =
        "INSERT OR REPLACE INTO characters (name, file, stamp, source, job) VALUES (?, ?, ?, ?, ?)";
    let values = params![row.name, row.file, row.stamp, row.source, row.job];
    db.execute(insert, values).map(drop)
}

pub(crate) fn remove(db: &Connection, name: &str) -> rusqlite::Result<()> {
    db.execute("DELETE FROM characters WHERE name = ?", [name])
        .map(drop)
}
