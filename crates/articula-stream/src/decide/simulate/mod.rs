//! Simulator of players: plays content over a bandwidth trace on a virtual clock.
//!
//! Rules: `docs/methods/adaptation.md` part 5. One request is in flight at a time; its first byte comes
//! a latency after the request. A segment is shown with the layers that are there when it starts;
//! without its base, playback stalls.
//!
//! - [`Content`], [`BandwidthTrace`]: what is played, and how fast it comes
//! - [`Policy`]: what is requested next; [`Layered`], [`ThesisRatio`], [`RateBased`], [`BufferBased`],
//!   [`Versions`], [`FixedVersion`]
//! - [`simulate`]: plays and returns bytes, stalls, switches, waste and error

mod content;
mod layered;
mod play;
mod playback;
#[cfg(test)]
mod tests;
mod versions;
mod view;

pub use content::{Content, Segment};
pub use layered::{Layered, ThesisRatio};
pub use play::{SimulationOptions, simulate};
pub use playback::{Playback, Shown};
pub use versions::{BufferBased, FixedVersion, RateBased, Versions};
pub use view::{Action, Delivery, PlayerView, Policy, Request};
