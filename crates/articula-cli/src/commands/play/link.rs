//! A session over WebSocket, on a thread of its own.

use super::event::Event;
use crate::commands::server::Server;
use anyhow::Context as _;
use articula::client::{ClientMessage, MOST_MESSAGE_BYTES, ServerMessage};
use std::io::ErrorKind;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::Duration;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Longest time between two looks at what is to be sent.
const TICK: Duration = Duration::from_millis(5);

/// The connection of a session; it ends when this is dropped.
pub(super) struct Link(Sender<ClientMessage>);

type Socket = WebSocket<MaybeTlsStream<std::net::TcpStream>>;

impl Link {
    /// Connects on a thread, and sends the first message.
    pub(super) fn start(server: &Server, hello: ClientMessage, events: &Sender<Event>) -> Self {
        let (sender, outgoing) = channel();
        let (url, events) = (server.session_url(), events.clone());
        let _ = sender.send(hello);
        std::thread::spawn(move || {
            let ended = connected(&url).and_then(|socket| run(socket, &outgoing, &events));
            if let Err(error) = ended {
                // Nobody listens after the end.
                let _ = events.send(Event::Lost(error.context(url)));
            }
        });
        Self(sender)
    }

    /// Sends a message; a connection that is lost tells so by itself.
    pub(super) fn send(&self, message: ClientMessage) {
        let _ = self.0.send(message);
    }
}

fn connected(url: &str) -> anyhow::Result<Socket> {
    let config = WebSocketConfig::default()
        .max_message_size(Some(MOST_MESSAGE_BYTES))
        .max_frame_size(Some(MOST_MESSAGE_BYTES));
    let (socket, _) = tungstenite::client::connect_with_config(url, Some(config), 0)?;
    if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
        stream.set_read_timeout(Some(TICK))?;
        stream.set_nodelay(true)?;
    }
    Ok(socket)
}

fn run(
    mut socket: Socket,
    outgoing: &Receiver<ClientMessage>,
    events: &Sender<Event>,
) -> anyhow::Result<()> {
    loop {
        loop {
            match outgoing.try_recv() {
                Ok(message) => socket.send(Message::Binary(message.to_bytes().into()))?,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    let _ = socket.close(None);
                    return Ok(());
                }
            }
        }
        match socket.read() {
            Ok(Message::Binary(bytes)) => {
                let message = ServerMessage::read(&bytes)?;
                if events.send(Event::Message(message)).is_err() {
                    return Ok(());
                }
            }
            Ok(Message::Close(_)) => anyhow::bail!("the server ended the session"),
            Ok(_) => {}
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => return Err(error).context("the session"),
        }
    }
}
