//! Digital items over a network: what a client asks for and shows, and what a server sends it.
//!
//! Neither sockets nor clocks: bytes and times in, requests, messages and poses out. The server of a session and
//! a client that fetches by itself decide by the same code what comes next. Forms: `docs/formats/delivery.md`
//! (over HTTP), `docs/formats/session.md` (in a session); method: `docs/methods/adaptation.md`, part 7.
//!
//! ```text
//! Manifest, Context ─ DeliveryPlan::new ─▶ DeliveryPlan: pieces, levels of quality
//! DeliveryPlan, bytes that are there, bandwidth, position ─ Planner ─▶ Increment: which bytes come next
//! Client ─ Client::next_request ─▶ ClientRequest ─ Client::answer ─▶ Client ─ Client::frame ─▶ poses
//! Client ─ Client::hello, Client::update ─▶ ClientMessage ─ Feed::take ─▶ Feed
//! Feed ─ Feed::next ─▶ ServerMessage ─ Client::take ─▶ Client
//! ```
//!
//! - `plan`, `order`: the pieces of one character, and the order in which they come; `described`: what is there of them
//! - `planner`: all characters, by importance
//! - `pace`: a bound on bytes per second
//! - `message`: messages of a session, as bytes
//! - `report`, `character`: what is here of a character, and shown
//! - `machine`: the client; `requests`, `session`: its two ways to a server; `transfers`: the bandwidth that it measures
//! - `feed`: the server's side of a session

mod character;
mod described;
mod feed;
mod machine;
mod message;
mod order;
mod pace;
mod plan;
mod planner;
mod report;
mod requests;
mod session;
mod transfers;

pub use character::ClientCharacter;
pub use feed::{Feed, FeedChange, FeedNext, FeedPlan};
pub use machine::{Client, ClientOptions};
pub use message::{
    ClientMessage, HeldFiles, MOST_CHARACTERS, MOST_MESSAGE_BYTES, SESSION_VERSION, ServerMessage,
    SessionDecision, SessionError, SessionStatistics, SessionUpdate, ShownReport, WantedCharacter,
};
pub use plan::DeliveryPlan;
pub use planner::Increment;
pub use report::CharacterReport;
pub use requests::{ClientAnswer, ClientRequest};
