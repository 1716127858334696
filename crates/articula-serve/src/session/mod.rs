//! Sessions over WebSocket: a client tells its context, and gets what it can use.
//!
//! Form: `docs/formats/session.md`; what comes next is decided by `articula::client::Feed`.
//!
//! - `route`: the upgrade, and places for so many sessions
//! - `run`: one session
//! - `plans`: plans that sessions share
//! - `state`: what is shown of sessions to people

mod plans;
mod route;
mod run;
mod state;

pub(crate) use plans::Plans;
pub(crate) use route::routes;
pub(crate) use state::{SessionReport, Sessions};
