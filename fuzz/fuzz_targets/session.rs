//! Any bytes as messages of a session, to the server and to the client: all ends in values or errors, and what
//! is read is written the same.
#![no_main]

use articula::client::{Client, ClientMessage, ClientOptions, Feed, ServerMessage};
use articula::stream::description::Context;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(message) = ClientMessage::read(bytes) {
        let again = ClientMessage::read(&message.to_bytes()).unwrap();
        assert_eq!(again, message);
        if let Ok(mut feed) = Feed::new(message.clone(), 0.0) {
            let _ = feed.take(message, 0.1);
            let _ = feed.next(0.2);
        }
    }
    if let Ok(message) = ServerMessage::read(bytes) {
        let again = ServerMessage::read(&message.to_bytes()).unwrap();
        assert_eq!(again, message);
        let mut client = Client::new(&Context::default(), &ClientOptions::default()).unwrap();
        client.add("anyone");
        let _ = client.take(message, 0.1);
        let _ = client.next_request(0.2);
    }
});
