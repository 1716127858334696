//! What happens to a client: news of the network, and keys.

use articula::client::{ClientAnswer, ServerMessage};

/// Something that happened.
#[derive(Debug)]
pub(super) enum Event {
    /// The answer of a request.
    Answer(u64, ClientAnswer),
    /// A request that failed.
    Fault(u64, anyhow::Error),
    /// A message of a session.
    Message(ServerMessage),
    /// The connection of a session ended.
    Lost(anyhow::Error),
    /// A key.
    Key(Key),
}

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    /// Twice or half the bandwidth.
    Bandwidth(bool),
    /// Nearer or farther.
    Distance(bool),
    /// The clip of this place.
    Clip(usize),
    /// The monitor, shown or not.
    Monitor,
    /// The end.
    Quit,
}
