//! Events of clips, from JSON.

use crate::error::{Fault, Result};
use articula::crowd::ClipEvent;
use serde::Deserialize;
use std::collections::BTreeMap;

/// An event at a time of a clip.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Event {
    secs: f32,
    id: u32,
}

/// Events by the names of clips.
#[derive(Debug, Default, Deserialize)]
#[serde(transparent)]
pub(crate) struct ClipEvents(BTreeMap<String, Vec<Event>>);

impl ClipEvents {
    /// Reads events; none without JSON.
    pub(crate) fn read(json: Option<&str>) -> Result<Self> {
        match json {
            None => Ok(Self::default()),
            Some(json) => serde_json::from_str(json)
                .map_err(|error| Fault::argument(format!("events: {error}"))),
        }
    }

    /// The events as the library takes them.
    pub(crate) fn named(self) -> Vec<(String, ClipEvent)> {
        let of_clip = |(clip, events): (String, Vec<Event>)| {
            let events = events.into_iter();
            events.map(move |Event { secs, id }| (clip.clone(), ClipEvent { secs, id }))
        };
        self.0.into_iter().flat_map(of_clip).collect()
    }
}
