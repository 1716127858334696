//! What is saved of a damaged catalogue: the rows that can still be read. All else of it is found in the folder or made
//! anew, as objects are what they were.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use super::connection::{beside, reading};
use super::schema::{APPLICATION_ID, VERSION, version};
use crate::error::ServeError;
use rusqlite::types::Value;
use rusqlite::{Connection, params_from_iter};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The tables, each after those that it refers to.
const TABLES: [&str; 6] = [
    "items",
    "jobs",
    "characters",
    "variants",
    "devices",
    "device_runs",
];
/// What a server that was killed leaves beside a file.
const COMPANIONS: [&str; 2] = ["-wal", "-shm"];

/// Whether the head of a file says that it is a catalogue, however damaged the rest is.
pub(super) fn is_catalogue(place: &Path) -> bool {
    let mut head = [0; 72];
    let read = std::fs::File::open(place).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head[68..] == APPLICATION_ID.to_be_bytes()
}

/// Moves a file away, with what is beside it, to a name that is free, which is returned.
pub(super) fn move_away(place: &Path) -> Result<PathBuf, ServeError> {
    let names = (1..).map(|number| beside(place, &format!(".damaged-{number}")));
    let mut free = names.skip_while(|path| path.exists());
    let away = free.next().unwrap_or_default();
    std::fs::rename(place, &away).map_err(|error| ServeError::store(place, &error))?;
    for companion in COMPANIONS {
        // Without them less can be read.
        let _ = std::fs::rename(beside(place, companion), beside(&away, companion));
    }
    Ok(away)
}

/// Copies the rows that can be read of a file; returns their number.
pub(super) fn save(away: &Path, to: &Connection) -> usize {
    let Ok(from) = reading(away) else {
        return 0;
    };
    // Of another version the tables may differ.
    match version(&from) {
        Ok(VERSION) => TABLES
            .iter()
            .map(|table| save_table(&from, table, to))
            .sum(),
        _ => 0,
    }
}

/// Copies the rows of a table up to the first that cannot be read, in both directions; rows that refer to lost ones
/// are left out.
fn save_table(from: &Connection, table: &str, to: &Connection) -> usize {
    let mut saved = 0;
    for order in ["ASC", "DESC"] {
        let select = format!("SELECT * FROM {table} ORDER BY 1 {order}");
        let Ok(mut rows) = from.prepare(&select) else {
            continue;
        };
        let places = vec!["?"; rows.column_count()].join(", ");
        let insert = format!("INSERT OR IGNORE INTO {table} VALUES ({places})");
        let count = rows.column_count();
        let Ok(mut rows) = rows.query([]) else {
            continue;
        };
        while let Ok(Some(row)) = rows.next() {
            let values: Result<Vec<Value>, _> = (0..count).map(|column| row.get(column)).collect();
            let Ok(values) = values else {
                break;
            };
            saved += to
                .execute(&insert, params_from_iter(values))
                .unwrap_or_default();
        }
    }
    saved
}
