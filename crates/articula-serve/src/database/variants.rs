//! Variants: what queries made of items.

use super::jobs::{ItemRow, put_item};
use rusqlite::{Connection, OptionalExtension, params};

/// The form of a query for a cut, and for a GLB.
pub(crate) const CUT: &str = "cut";
pub(crate) const GLB: &str = "glb";

/// Which object a query made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Variant {
    /// BLAKE3 of all that it was made of.
    pub(crate) variant: String,
    /// The manifest of the item.
    pub(crate) item: String,
    /// [`CUT`] or [`GLB`].
    pub(crate) form: String,
    /// The query; what an earlier version recorded has none.
    pub(crate) query: Option<String>,
    pub(crate) object: String,
}

/// The object of a variant.
pub(crate) fn object(db: &Connection, variant: &str) -> rusqlite::Result<Option<String>> {
    let select = "SELECT object FROM variants WHERE variant = ?";
    db.query_row(select, [variant], |row| row.get(0)).optional()
}

/// A variant, in the place of what the same query made before. Its item is put if it is not there.
pub(crate) fn put(db: &Connection, of: &Variant, item: &ItemRow<'_>) -> rusqlite::Result<()> {
    put_item(db, item)?;
    let insert = "INSERT OR REPLACE INTO variants (variant, item, form, query, object) VALUES (?, ?, ?, ?, ?)";
    let values = params![of.variant, item.manifest, of.form, of.query, of.object];
    db.execute(insert, values).map(drop)
}

pub(crate) fn count(db: &Connection) -> rusqlite::Result<usize> {
    db.query_row("SELECT count(*) FROM variants", [], |row| row.get(0))
}

/// All variants, by their keys.
pub(crate) fn all(db: &Connection) -> rusqlite::Result<Vec<Variant>> {
    let select = "SELECT variant, item, form, query, object FROM variants ORDER BY variant";
    let mut rows = db.prepare(select)?;
    let rows = rows.query_map([], |row| {
        Ok(Variant {
            variant: row.get(0)?,
            item: row.get(1)?,
            form: row.get(2)?,
            query: row.get(3)?,
            object: row.get(4)?,
        })
    });
    rows?.collect()
}
