//! Characters of a server, shown while they arrive.

mod arrival;
mod carried;
mod messages;
mod request;

use crate::error::{Fault, Result};
use crate::opening::open_options;
use arrival::Arrival;
use articula::client::{ClientCharacter, ClientOptions};
use articula::item::PartKind;
use articula::stream::description::Context;
use request::Request;
use wasm_bindgen::prelude::*;

/// Forms that are asked for where the context names none: what a figure is made of, and no 2D pictures.
const CODECS: [&str; 3] = ["ams", "abp2", "afp2"];

/// A client of a server of characters. It opens no connections: JavaScript fetches what `request` asks for and hands it
/// over by one of the `answer` methods; or it sends what `hello` and `update` return over a WebSocket, hands over what
/// comes by `take`, and sends what that returns. Each frame is a call of `frame`, and `pose` of what is shown.
///
/// Times are seconds on one clock of the page.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Client {
    client: articula::client::Client,
}

#[wasm_bindgen]
impl Client {
    /// A client without characters. `context` is JSON of what is known of network, device, viewer and view
    /// (`docs/formats/context.md`).
    ///
    /// Throws for a member that is unknown or a value out of its bounds.
    #[wasm_bindgen(constructor)]
    pub fn new(context: Option<String>) -> Result<Client> {
        let context = read_context(context.as_deref())?;
        let options = ClientOptions {
            open: open_options(),
            ..ClientOptions::default()
        };
        let client = articula::client::Client::new(&context, &options);
        let thrown = |error| Fault::of_file(&error, "context");
        Ok(Self {
            client: client.map_err(thrown)?,
        })
    }

    /// Adds a character by its name at the server, and returns its number.
    pub fn add(&mut self, name: &str) -> usize {
        self.client.add(name)
    }

    /// Changes the context.
    ///
    /// Throws as the constructor does, and for a character that gets nothing in this context.
    #[wasm_bindgen(js_name = setContext)]
    pub fn set_context(
        &mut self,
        context: &str,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) -> Result<()> {
        let context = read_context(Some(context))?;
        let set = self.client.set_context(&context, now_secs);
        set.map_err(|error| Fault::of_file(&error, "context"))
    }

    /// Sets how much a character matters beside others, and how far it is from the camera in metres.
    ///
    /// Throws if there is no such character, or it gets nothing at this distance.
    #[wasm_bindgen(js_name = setView)]
    pub fn set_view(
        &mut self,
        character: usize,
        importance: f64,
        #[wasm_bindgen(js_name = distanceM)] distance_m: Option<f64>,
    ) -> Result<()> {
        let set = self.client.set_view(character, importance, distance_m);
        set.map_err(|error| Fault::of_file(&error, self.name(character)))
    }

    /// Plays a clip of a character from a time in seconds; the first without a name. What it lacks of it is asked for.
    pub fn play(
        &mut self,
        character: usize,
        clip: Option<String>,
        #[wasm_bindgen(js_name = fromSecs)] from_secs: f64,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
    ) {
        self.client
            .play_from(character, clip.as_deref(), from_secs, now_secs);
    }

    /// Returns what to fetch next; `undefined` if there is nothing now. Call it until then, after each answer and each
    /// frame.
    pub fn request(&mut self, #[wasm_bindgen(js_name = nowSecs)] now_secs: f64) -> Option<Request> {
        let (id, request) = self.client.next_request(now_secs)?;
        Some(Request::new(id, request))
    }

    /// Moves time on by a step: shows what has arrived, and plays.
    ///
    /// Throws for a file that is malformed.
    pub fn frame(
        &mut self,
        #[wasm_bindgen(js_name = nowSecs)] now_secs: f64,
        #[wasm_bindgen(js_name = dtSecs)] dt_secs: f64,
    ) -> Result<()> {
        let moved = self.client.frame(now_secs, dt_secs);
        moved.map_err(|error| Fault::of_file(&error, self.name(0)))
    }

    /// Tells how long the last frame took the page in milliseconds: beyond the budget of the context fewer joints move.
    #[wasm_bindgen(js_name = frameTook)]
    pub fn frame_took(&mut self, #[wasm_bindgen(js_name = nowSecs)] now_secs: f64, ms: f64) {
        self.client.frame_took(now_secs, 1e6 * ms);
    }

    /// Names of the clips of a character, those too that are not here; empty before there is a manifest.
    pub fn clips(&self, character: usize) -> Vec<String> {
        let of = self.client.character(character);
        let receiver = of.and_then(ClientCharacter::receiver);
        let parts = receiver.map_or(&[][..], |receiver| &receiver.manifest().parts);
        let motions = parts.iter().filter(|p| p.kind == PartKind::BodyMotion);
        motions.map(|part| part.name.clone()).collect()
    }

    /// How often what is shown of a character was replaced: when it changes, `arrival` has other meshes and pictures.
    pub fn version(&self, character: usize) -> f64 {
        let of = self.client.character(character);
        of.map_or(0.0, |of| of.version() as f64)
    }

    /// What is shown of a character; `undefined` before its base is here.
    pub fn arrival(&self, character: usize) -> Option<Arrival> {
        let figure = self.client.character(character)?.figure()?;
        Some(Arrival::new(figure.clone()))
    }

    /// What is shown of a character in numbers, as JSON: `{level, target, levels, loa, tier, joints, mesh_level,
    /// texture_px, error_px, bytes, stalls, is_complete}`.
    ///
    /// Throws if there is no such character.
    pub fn report(&self, character: usize) -> Result<String> {
        let report = self.client.report(character);
        serde_json::to_string(&report).map_err(|error| Fault::argument(error.to_string()))
    }

    /// Why the server sends nothing of a character, or nothing more.
    pub fn fault(&self, character: usize) -> Option<String> {
        let of = self.client.character(character)?;
        of.fault().map(str::to_owned)
    }
}

impl Client {
    fn name(&self, character: usize) -> &str {
        let of = self.client.character(character);
        of.map_or("", ClientCharacter::name)
    }

    fn thrown<T>(&self, made: articula::Result<T>) -> Result<T> {
        made.map_err(|error| Fault::of_file(&error, self.name(0)))
    }
}

fn read_context(json: Option<&str>) -> Result<Context> {
    let mut context: Context = match json {
        None | Some("") => Context::default(),
        Some(json) => serde_json::from_str(json)
            .map_err(|error| Fault::argument(format!("context: {error}")))?,
    };
    if context.terminal.codecs.is_empty() {
        context.terminal.codecs = CODECS.map(str::to_owned).to_vec();
    }
    Ok(context)
}
