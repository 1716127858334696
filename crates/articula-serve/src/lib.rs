//! Serves digital items over HTTP: a folder of characters becomes objects that never change, named by
//! their BLAKE3, and manifests by which a client fetches what it can use, range by range.
//!
//! Form: `docs/formats/delivery.md`. A character file of the folder is packaged in stages by threads of
//! its own; each stage is served as soon as it is made, and what was packaged is never packaged again.
//!
//! ```text
//! folder ─ Catalogue::open ─▶ Catalogue ─ Preparation (threads) ─▶ stages: objects, manifest
//! Catalogue ─ router ─▶ axum::Router ─ serve ─▶ connections
//! ```
//!
//! - `error`: what goes wrong
//! - `objects`: bytes by their hash, in a folder
//! - `source`, `packed`: a character as it lies in the folder; items that were packaged elsewhere
//! - `stamp`, `found`: by what an unchanged file is known; a character that was found, and its job
//! - `database`: the catalogue as a file: characters, jobs, queries, devices; `takeover`: what earlier versions kept instead
//! - `served`, `state`: an item whose files are objects; how far each character is
//! - `queue`: jobs that wait; `catalogue`: the characters of a folder, made of all of these
//! - `prepare`: the threads that package them; `sweep`: what nothing names any more
//! - `range`: parts of a body
//! - `answer`: bodies with their tags
//! - `metrics`, `page`: the state of the server for programs and people
//! - `reply`: answers that several routes give
//! - `plans`, `sessions`, `session`: plans that sessions share, those that are open, and one over WebSocket
//! - `query`, `making`, `made`: queries in one form, and what they make of items, once each
//! - `cut`, `glb`: an item that is cut, and a character as one GLB, by query
//! - `upload`: bodies that clients send; `watcher`: what each request was
//! - `device_store`, `devices`: results of benchmarks of devices, and their routes
//! - `http`: routes; `openapi`: the document of them; `origins`: pages that may read them
//! - `paced`, `addresses`, `connections`: connections at a rate, so many at once and of one address, and how they end
//!
//! ```no_run
//! use articula_serve::{Catalogue, Preparation, ServeOptions, serve};
//!
//! # async fn run() -> Result<(), articula_serve::ServeError> {
//! let catalogue = Catalogue::open("characters".as_ref(), &ServeOptions::default())?;
//! let preparation = Preparation::start(catalogue.clone());
//! let listener = tokio::net::TcpListener::bind("127.0.0.1:8080").await?;
//! serve(listener, catalogue, std::future::pending()).await?;
//! preparation.stop();
//! # Ok(())
//! # }
//! ```

mod addresses;
mod answer;
mod catalogue;
mod connections;
mod cut;
mod database;
mod device_store;
mod devices;
mod error;
mod found;
mod glb;
mod http;
mod made;
mod making;
mod metrics;
mod objects;
mod openapi;
mod options;
mod origins;
mod paced;
mod packed;
mod page;
mod plans;
mod prepare;
mod query;
mod queue;
mod range;
mod reply;
mod served;
mod session;
mod sessions;
mod source;
mod stamp;
mod state;
mod studio;
mod sweep;
mod takeover;
mod upload;
mod watcher;

pub use catalogue::Catalogue;
pub use error::ServeError;
pub use http::{router, serve};
pub use options::ServeOptions;
pub use page::path_of;
pub use prepare::Preparation;
pub use state::{CharacterState, Progress};
pub use watcher::{AnsweredRequest, RequestWatcher};
