//! Sessions over WebSocket: a client tells its context, and gets what it can use.
//!
//! Form: `docs/formats/session.md`; what comes next is decided by `articula::client::Feed`.
//!
//! - `route`: the upgrade, and places for so many sessions
//! - `run`: one session

mod route;
mod run;

pub(crate) use route::routes;
