//! What a client has and shows at a moment, as facts and as text.

use articula::client::{CharacterReport, Client};
use serde::Serialize;

/// A moment.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Sample {
    /// Seconds since the first picture; before it, since the start, below 0.
    pub(super) secs: f64,
    /// The bandwidth of the slider, bits per second; null without a bound.
    pub(super) slider_bps: Option<f64>,
    /// The bandwidth as it is measured.
    pub(super) measured_bps: f64,
    /// Bytes a second since the sample before.
    pub(super) bytes_per_second: f64,
    /// Pictures a second since then.
    pub(super) fps: f64,
    /// Processor time of a picture, milliseconds.
    pub(super) frame_ms: f64,
    /// Joints that were sampled.
    pub(super) joints_sampled: usize,
    /// Triangles that are drawn.
    pub(super) triangles: usize,
    /// Time within the clip, seconds.
    pub(super) clip_secs: f64,
    /// What is said.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) caption: Option<String>,
    /// Memory of the program, bytes; null where the system does not tell.
    pub(super) memory_bytes: Option<u64>,
    /// What is shown of the character.
    #[serde(flatten)]
    pub(super) shown: CharacterReport,
}

impl Sample {
    /// What is shown of the only character of a client.
    pub(super) fn of(client: &Client) -> Self {
        let character = client.character(0);
        let player = character.and_then(|of| of.player());
        let figure = character.and_then(|of| of.figure());
        Self {
            secs: 0.0,
            slider_bps: client.context().network.available_bps,
            measured_bps: client.measured_bps(),
            bytes_per_second: 0.0,
            fps: 0.0,
            frame_ms: 0.0,
            joints_sampled: player.map_or(0, |player| player.report().sampled.len()),
            triangles: figure.map_or(0, |figure| figure.asset.mesh.triangles.len()),
            clip_secs: character.map_or(0.0, |of| of.position_secs()),
            caption: None,
            memory_bytes: memory_bytes(),
            shown: client.report(0),
        }
    }

    /// One line.
    pub(super) fn line(&self) -> String {
        let rest = match self.shown.is_complete {
            true => "all that is chosen",
            false => "more to come",
        };
        format!(
            "{:.1} kB, error at most {:.2} px, {} triangles, level {} of {}; {rest}",
            self.shown.bytes as f64 / 1e3,
            self.shown.error_px.unwrap_or(f64::NAN),
            self.triangles,
            self.shown.level,
            self.shown.levels
        )
    }

    /// The monitor: a line for each topic, with the reasons of the server in a session.
    pub(super) fn monitor(&self, client: &Client) -> Vec<String> {
        let number = |value: Option<u32>| value.map_or("-".to_owned(), |value| value.to_string());
        let kbps = |bps: f64| format!("{:.0} kbit/s", bps / 1e3);
        let slider = self.slider_bps.map_or("full".to_owned(), kbps);
        let memory = self.memory_bytes.map_or(String::new(), |bytes| {
            format!(", memory {:.0} MB", bytes as f64 / 1e6)
        });
        let own = client.character(0).and_then(|of| of.distance_m());
        let distance = own.or(client.context().view.distance_m);
        let mut lines = vec![
            self.line(),
            format!(
                "bandwidth {slider}, measured {}, {:.1} kB/s",
                kbps(self.measured_bps),
                self.bytes_per_second / 1e3
            ),
            format!(
                "level {} of {} for {}: LoA {}, tier {}, mesh level {}, textures {} px",
                self.shown.target,
                self.shown.levels,
                match distance {
                    Some(metres) => format!("{metres:.1} m"),
                    None => "an unknown distance".to_owned(),
                },
                number(self.shown.loa),
                number(self.shown.tier),
                number(self.shown.mesh_level),
                number(self.shown.texture_px)
            ),
            format!(
                "{} joints, {:.0} pictures/s, {:.1} ms each{memory}, {} stalls",
                self.joints_sampled, self.fps, self.frame_ms, self.shown.stalls
            ),
        ];
        let decision = client.decision(0).map(|decided| &decided.decision);
        let bounds = decision.and_then(|decision| decision["bounds"].as_array());
        let words = bounds
            .into_iter()
            .flatten()
            .filter_map(|bound| bound.as_str());
        let words: Vec<&str> = words.collect();
        if decision.is_some() {
            lines.push(match words.as_slice() {
                [] => "the server says: limited by nothing".to_owned(),
                words => format!("the server says: limited by {}", words.join(", ")),
            });
        }
        lines
    }
}

/// Memory that the program has in use.
#[allow(clippy::disallowed_methods, reason = "the system tells it in a file")]
fn memory_bytes() -> Option<u64> {
    let told = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = told.split_whitespace().nth(1)?.parse().ok()?;
    // Pages of other sizes are rare where there is such a file.
    Some(4096 * pages)
}
