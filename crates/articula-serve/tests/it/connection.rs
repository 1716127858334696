//! A session over a plain connection, and what came in it: also for the tests of the program.

use articula::client::{Client, ClientMessage, ServerMessage};
use std::collections::BTreeMap;
use std::net::TcpStream;
use std::ops::Range;
use tungstenite::{Message, WebSocket};

/// A connection of a session.
pub(crate) struct Connection(pub(crate) WebSocket<TcpStream>);

impl Connection {
    /// Connects to an address, `HOST:PORT`.
    pub(crate) fn open(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        let url = format!("ws://{address}/v1/session");
        Self(tungstenite::client(url, stream).unwrap().0)
    }

    /// Sends a message; returns whether the connection takes it.
    pub(crate) fn send(&mut self, message: &ClientMessage) -> bool {
        let bytes = message.to_bytes();
        self.0.send(Message::Binary(bytes.into())).is_ok()
    }

    /// The next message of the server; `None` at the end of the session.
    pub(crate) fn next(&mut self) -> Option<ServerMessage> {
        loop {
            match self.0.read() {
                Ok(Message::Binary(bytes)) => return Some(ServerMessage::read(&bytes).unwrap()),
                Ok(Message::Close(_)) | Err(_) => return None,
                Ok(_) => {}
            }
        }
    }
}

/// Bytes of objects that came, by their hashes.
#[derive(Default)]
pub(crate) struct Came(pub(crate) BTreeMap<String, Vec<Range<u64>>>);

impl Came {
    /// Notes bytes of which none came before.
    pub(crate) fn add(&mut self, hash: &str, range: Range<u64>) {
        let known = self.0.entry(hash.to_owned()).or_default();
        let is_new = known
            .iter()
            .all(|r| r.end <= range.start || range.end <= r.start);
        assert!(is_new, "{range:?} of {hash} came twice, after {known:?}");
        known.push(range);
    }

    /// Notes the bytes of a message to a client with one character, if it has some.
    pub(crate) fn note(&mut self, client: &Client, message: &ServerMessage) {
        let ServerMessage::Bytes {
            file,
            offset,
            is_compressed,
            bytes,
            ..
        } = message
        else {
            return;
        };
        let receiver = client.character(0).unwrap().receiver().unwrap();
        let mut files = receiver.manifest().files.values();
        let entry = files.nth(usize::from(*file)).unwrap();
        let count = match is_compressed {
            true => entry.bytes,
            false => bytes.len() as u64,
        };
        self.add(&entry.hash, *offset..*offset + count);
    }
}
