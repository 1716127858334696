//! What is fetched over HTTP, and what came of it.

use super::Client;
use crate::error::Result;
use articula::client::{ClientAnswer, ClientRequest};
use articula::stream::decide::Transfer;
use wasm_bindgen::prelude::*;

/// What to fetch from a server (`docs/formats/delivery.md`): the manifest of a character, or bytes of an object.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Request {
    id: u64,
    request: ClientRequest,
}

impl Request {
    pub(super) fn new(id: u64, request: ClientRequest) -> Self {
        Self { id, request }
    }
}

#[wasm_bindgen]
impl Request {
    /// Number for the answer.
    #[wasm_bindgen(getter)]
    pub fn id(&self) -> f64 {
        self.id as f64
    }

    /// Name of the character whose manifest is asked for; `undefined` if bytes are.
    #[wasm_bindgen(getter)]
    pub fn manifest(&self) -> Option<String> {
        match &self.request {
            ClientRequest::Manifest { name, .. } => Some(name.clone()),
            ClientRequest::Bytes { .. } => None,
        }
    }

    /// Hash of the manifest that is here: the answer may wait for another.
    #[wasm_bindgen(getter)]
    pub fn known(&self) -> Option<String> {
        match &self.request {
            ClientRequest::Manifest { known, .. } => known.clone(),
            ClientRequest::Bytes { .. } => None,
        }
    }

    /// Name of the object that bytes are asked of; `undefined` for a manifest.
    #[wasm_bindgen(getter)]
    pub fn object(&self) -> Option<String> {
        match &self.request {
            ClientRequest::Manifest { .. } => None,
            ClientRequest::Bytes { object, .. } => Some(object.clone()),
        }
    }

    /// Whether all bytes of the object are asked for, which may then travel compressed.
    #[wasm_bindgen(getter, js_name = isWhole)]
    pub fn is_whole(&self) -> bool {
        match &self.request {
            ClientRequest::Manifest { .. } => true,
            ClientRequest::Bytes { increment, .. } => increment.is_whole,
        }
    }

    /// First byte.
    #[wasm_bindgen(getter)]
    pub fn start(&self) -> f64 {
        match &self.request {
            ClientRequest::Manifest { .. } => 0.0,
            ClientRequest::Bytes { increment, .. } => increment.range.start as f64,
        }
    }

    /// Byte after the last.
    #[wasm_bindgen(getter)]
    pub fn end(&self) -> f64 {
        match &self.request {
            ClientRequest::Manifest { .. } => 0.0,
            ClientRequest::Bytes { increment, .. } => increment.range.end as f64,
        }
    }
}

#[wasm_bindgen]
impl Client {
    /// Takes a manifest. `isWhole` tells whether it is that of the whole item.
    ///
    /// Throws for a malformed one, and for one of which the context gets nothing.
    #[wasm_bindgen(js_name = answerManifest)]
    pub fn answer_manifest(
        &mut self,
        id: f64,
        bytes: Vec<u8>,
        #[wasm_bindgen(js_name = isWhole)] is_whole: bool,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<()> {
        self.answered(id, ClientAnswer::Manifest { bytes, is_whole }, now_secs)
    }

    /// Takes that there is no other manifest, or none yet.
    #[wasm_bindgen(js_name = answerUnchanged)]
    pub fn answer_unchanged(
        &mut self,
        id: f64,
        #[wasm_bindgen(js_name = isWhole)] is_whole: bool,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<()> {
        self.answered(id, ClientAnswer::Unchanged { is_whole }, now_secs)
    }

    /// Takes the bytes that were asked for, not compressed: how many came over the network, and when the body began.
    /// It ends now.
    ///
    /// Throws if bytes are damaged again and again.
    #[wasm_bindgen(js_name = answerBytes)]
    pub fn answer_bytes(
        &mut self,
        id: f64,
        bytes: Vec<u8>,
        sent: f64,
        #[wasm_bindgen(js_name = firstByteSecs)] first_byte_secs: f64,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<()> {
        let transfer = Transfer {
            bytes: sent as u64,
            first_byte_secs,
            last_byte_secs: now_secs,
        };
        self.answered(id, ClientAnswer::Bytes { bytes, transfer }, now_secs)
    }

    /// Takes that nothing came; the request is made again after a pause.
    #[wasm_bindgen(js_name = answerNothing)]
    pub fn answer_nothing(
        &mut self,
        id: f64,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<()> {
        self.answered(id, ClientAnswer::Failed, now_secs)
    }
}

impl Client {
    fn answered(&mut self, id: f64, answer: ClientAnswer, now_secs: f64) -> Result<()> {
        let taken = self.client.answer(id as u64, answer, now_secs);
        self.thrown(taken)
    }
}
