//! Jobs: what is to be packaged, is, and was, and the items that came of it.

use rusqlite::types::{FromSql, FromSqlError, FromSqlResult, ValueRef};
use rusqlite::{Connection, OptionalExtension, Row, params};

/// How far a job is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JobState {
    Waiting,
    Packaging,
    Ready,
    Failed,
}

impl JobState {
    pub(crate) const ALL: [Self; 4] = [Self::Waiting, Self::Packaging, Self::Ready, Self::Failed];

    /// The word of the column.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Waiting => "waiting",
            Self::Packaging => "packaging",
            Self::Ready => "ready",
            Self::Failed => "failed",
        }
    }
}

impl FromSql for JobState {
    fn column_result(value: ValueRef<'_>) -> FromSqlResult<Self> {
        let word = value.as_str()?;
        let mut all = Self::ALL.into_iter();
        all.find(|state| state.word() == word)
            .ok_or(FromSqlError::InvalidType)
    }
}

/// A job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Job {
    pub(crate) state: JobState,
    /// The manifest of what is made of it.
    pub(crate) item: Option<String>,
    /// Why it failed.
    pub(crate) why: Option<String>,
}

/// An item, whole or a stage of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ItemRow<'a> {
    pub(crate) manifest: &'a str,
    pub(crate) bytes: u64,
    pub(crate) sent_bytes: u64,
}

pub(crate) fn get(db: &Connection, job: &str) -> rusqlite::Result<Option<Job>> {
    let select = "SELECT state, item, why FROM jobs WHERE job = ?";
    db.query_row(select, [job], of_row).optional()
}

fn of_row(row: &Row<'_>) -> rusqlite::Result<Job> {
    Ok(Job {
        state: row.get(0)?,
        item: row.get(1)?,
        why: row.get(2)?,
    })
}

/// Lets a job wait that is new, or was not ended, or whose result was lost.
pub(crate) fn wait(db: &Connection, job: &str) -> rusqlite::Result<()> {
    let insert = "INSERT INTO jobs (job, state) VALUES (?, 'waiting') ON CONFLICT DO UPDATE \
         SET state = 'waiting', stages = 0, item = NULL, why = NULL, queued = unixepoch(), started = NULL, ended = NULL";
    db.execute(insert, [job]).map(drop)
}

/// Begins to package.
pub(crate) fn begin(db: &Connection, job: &str) -> rusqlite::Result<()> {
    wait(db, job)?;
    let update = "UPDATE jobs SET state = 'packaging', attempts = attempts + 1, started = unixepoch() WHERE job = ?";
    db.execute(update, [job]).map(drop)
}

/// A stage of the item is made.
pub(crate) fn stage(db: &Connection, job: &str, item: &ItemRow<'_>) -> rusqlite::Result<()> {
    put_item(db, item)?;
    let update =
        "UPDATE jobs SET stages = stages + 1, item = ? WHERE job = ? AND state = 'packaging'";
    db.execute(update, params![item.manifest, job]).map(drop)
}

/// All of the item is made, or was found made.
pub(crate) fn finish(db: &Connection, job: &str, item: &ItemRow<'_>) -> rusqlite::Result<()> {
    put_item(db, item)?;
    let insert = "INSERT INTO jobs (job, state, item, ended) VALUES (?, 'ready', ?, unixepoch()) ON CONFLICT DO UPDATE \
         SET state = 'ready', item = excluded.item, why = NULL, ended = excluded.ended";
    db.execute(insert, params![job, item.manifest]).map(drop)
}

/// It cannot be made.
pub(crate) fn fail(db: &Connection, job: &str, why: &str) -> rusqlite::Result<()> {
    let insert = "INSERT INTO jobs (job, state, why, ended) VALUES (?, 'failed', ?, unixepoch()) ON CONFLICT DO UPDATE \
         SET state = 'failed', item = NULL, why = excluded.why, ended = excluded.ended";
    db.execute(insert, params![job, why]).map(drop)
}

/// What a server was packaging that was killed waits again.
pub(crate) fn take_up(db: &Connection) -> rusqlite::Result<usize> {
    let update = "UPDATE jobs SET state = 'waiting', stages = 0, item = NULL, started = NULL WHERE state = 'packaging'";
    db.execute(update, [])
}

/// Removes jobs that no character has for so many seconds, and items that then no job has, with what queries made of them.
/// Returns the number of jobs and of what queries made.
pub(crate) fn sweep(db: &Connection, age_secs: u64) -> rusqlite::Result<usize> {
    let old = "max(queued, ifnull(ended, 0)) <= unixepoch() - ?";
    let jobs = format!("DELETE FROM jobs WHERE job NOT IN (SELECT job FROM characters) AND {old}");
    let jobs = db.execute(&jobs, [age_secs])?;
    let unused = "item NOT IN (SELECT item FROM jobs WHERE item IS NOT NULL)";
    let variants = format!("DELETE FROM variants WHERE {unused} AND made <= unixepoch() - ?");
    let variants = db.execute(&variants, [age_secs])?;
    let items = "DELETE FROM items WHERE manifest NOT IN (SELECT item FROM jobs WHERE item IS NOT NULL) \
         AND manifest NOT IN (SELECT item FROM variants)";
    db.execute(items, [])?;
    Ok(jobs + variants)
}

/// An item, which others can then name.
pub(super) fn put_item(db: &Connection, item: &ItemRow<'_>) -> rusqlite::Result<()> {
    let insert = "INSERT INTO items VALUES (?, ?, ?) ON CONFLICT DO NOTHING";
    db.execute(insert, params![item.manifest, item.bytes, item.sent_bytes])
        .map(drop)
}
