//! Files that an item carries whole, such as sound and captions, and the clock that they go by.

use super::Client;
use crate::error::{Fault, Result};
use articula::client::ClientCharacter;
use articula::item::WholeFile;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Client {
    /// Files that a character carries whole, those too that are not here, as JSON: `[{"file": "with/talk.mp3", "bytes":
    /// 2400, "mime": "audio/mpeg"}]`; none before there is a manifest.
    pub fn carried(&self, character: usize) -> Result<String> {
        let of = self.client.character(character);
        let receiver = of.and_then(ClientCharacter::receiver);
        let files: &[WholeFile] = receiver.map_or(&[], |receiver| &receiver.manifest().whole);
        serde_json::to_string(files).map_err(|error| Fault::argument(error.to_string()))
    }

    /// Bytes of a file that a character carries, copied; `undefined` while it is not here.
    #[wasm_bindgen(js_name = carriedFile)]
    pub fn carried_file(&self, character: usize, file: &str) -> Option<Vec<u8>> {
        let receiver = self.client.character(character)?.receiver()?;
        receiver.file(file).map(<[u8]>::to_vec)
    }

    /// Name of the clip that plays; `undefined` before one does.
    pub fn clip(&self, character: usize) -> Option<String> {
        let player = self.client.character(character)?.player()?;
        let playing = player.state()?.clip_state().clip();
        let clip = player.model().clips().get(playing)?;
        Some(clip.name.clone())
    }

    /// Time within it in seconds.
    #[wasm_bindgen(js_name = clipSecs)]
    pub fn clip_secs(&self, character: usize) -> f64 {
        let of = self.client.character(character);
        of.map_or(0.0, ClientCharacter::position_secs)
    }
}
