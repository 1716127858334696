//! The catalogue of a store: one SQLite file that holds what is known of characters, jobs, queries and devices, while
//! the bytes themselves are [objects](crate::objects).
//!
//! Tables: `docs/formats/delivery.md`, 5.
//!
//! - `schema`: the tables, and how those of an earlier version become them
//! - `fault`: what an error of SQLite means for who runs the server
//! - `connection`: a file that is opened, for writing and for reading
//! - `turn`: one server at a time writes
//! - `damaged`: what is saved of a damaged file
//! - `opening`: whether a file can be a catalogue, and what is done where it cannot
//! - `store`: a catalogue, made of all of this
//! - `characters`, `jobs`, `variants`, `devices`: the rows of each table

pub(crate) mod characters;
mod connection;
mod damaged;
pub(crate) mod devices;
mod fault;
pub(crate) mod jobs;
mod opening;
mod schema;
mod store;
mod turn;
pub(crate) mod variants;

pub(crate) use store::{Database, Opened};

#[cfg(test)]
mod model;
#[cfg(test)]
mod saved;
