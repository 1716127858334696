//! Messages of a session over a WebSocket (`docs/formats/session.md`).

use super::Client;
use crate::error::Result;
use articula::client::ServerMessage;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Client {
    /// The first message of a session; what is here stays.
    pub fn hello(&mut self, #[wasm_bindgen(js_name = nowSecs)] now_secs: f64) -> Vec<u8> {
        self.client.hello(now_secs).to_bytes()
    }

    /// A message about what has changed; `undefined` if there is nothing to tell.
    pub fn update(&mut self, #[wasm_bindgen(js_name = nowSecs)] now_secs: f64) -> Option<Vec<u8>> {
        let message = self.client.update(now_secs)?;
        Some(message.to_bytes())
    }

    /// Takes a message of the server; returns what is to be answered.
    ///
    /// Throws for a malformed one, and if the server ends the session.
    pub fn take(
        &mut self,
        message: &[u8],
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<Option<Vec<u8>>> {
        let message = ServerMessage::read(message);
        let message = self.thrown(message)?;
        let taken = self.client.take(message, now_secs);
        let answer = self.thrown(taken)?;
        Ok(answer.map(|answer| answer.to_bytes()))
    }
}
