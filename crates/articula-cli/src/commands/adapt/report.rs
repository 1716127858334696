//! What `adapt` prints, and writes beside what is sent.

use super::Engine;
use crate::fault::clean;
use crate::table::Table;
use articula::core::Region;
use articula::item::{AdaptedItem, Item, ItemCut, ItemDecision};
use articula::stream::decide::{Bound, Budget, PartDecision, PartKind};
use serde::Serialize;

/// Name of the file with the decision, in the folder of what is sent.
pub(crate) const DECISION: &str = "decision.json";

/// A decision, and how it was made.
pub(crate) enum Decided {
    /// By the joint choice.
    Jointly(Box<ItemDecision>),
    /// By a table, with the values of its pins and reasons.
    ByTable(articula::stream::description::Decided, ItemCut),
}

impl Decided {
    /// What is kept, if anything fits.
    pub(super) fn cut(&self) -> Option<&ItemCut> {
        match self {
            Self::Jointly(decided) => decided.cut.as_ref(),
            Self::ByTable(_, cut) => Some(cut),
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Jointly(decided) => decided.decision.to_string(),
            Self::ByTable(decided, _) => {
                let mut words = decided.reasons.join("\n");
                words.push('\n');
                words
            }
        }
    }
}

/// The answer of `adapt`.
#[derive(Debug, Serialize)]
pub(crate) struct AdaptReport {
    item: String,
    /// Which program cut the streams: `native` or `xslt`.
    pub(crate) engine: &'static str,
    decision: DecisionReport,
    streams: Vec<StreamReport>,
    bytes_in: u64,
    bytes_out: u64,
    /// Joints that move at most, of the motions that are kept; 0 in 2D.
    joints: u64,
    /// Time of the decision and of the cut.
    seconds: f64,
    decide_seconds: f64,
    cut_seconds: f64,
    #[serde(skip)]
    words: String,
}

#[derive(Debug, Default, Serialize)]
struct DecisionReport {
    /// `3d`, or the kind of the form in 2D.
    modality: String,
    /// `joint choice` or `aqos`.
    by: &'static str,
    loa: Option<u32>,
    /// Regions of the body whose motion is kept.
    zones: Vec<String>,
    tier: Option<u32>,
    face_loa: Option<u32>,
    mesh_level: Option<u32>,
    texture: Option<String>,
    /// Bound of the error on the screen; null if nothing fits.
    error_px: Option<f64>,
    /// Bytes that may be sent in all; null without a bound.
    bytes_allowed: Option<u64>,
    pixels_per_metre: Option<f64>,
    /// Share of the item that the network carries in the time; null without a bandwidth.
    network_ratio: Option<f64>,
    /// What keeps the error from being smaller.
    bounds: Vec<String>,
    parts: Vec<PartReport>,
    /// The decision in words.
    explanation: String,
}

#[derive(Debug, Serialize)]
struct PartReport {
    part: String,
    option: String,
    bytes: u64,
    frame_ns: u64,
    error_px: f64,
    /// The upgrade that gains most for its cost.
    next: Option<NextReport>,
}

#[derive(Debug, Serialize)]
struct NextReport {
    option: String,
    more_bytes: i64,
    more_frame_ns: i64,
    gain_px: f64,
    bounds: Vec<String>,
}

#[derive(Debug, Serialize)]
struct StreamReport {
    name: String,
    bytes_in: u64,
    bytes_out: u64,
}

impl AdaptReport {
    pub(crate) fn new(
        name: String,
        (item, adapted): (&Item, &AdaptedItem),
        decided: &Decided,
        engine: Engine,
        [decide_seconds, cut_seconds]: [f64; 2],
    ) -> Self {
        let sent: Vec<(String, u64)> = match adapted {
            AdaptedItem::Layers(item) => sizes(item.manifest.files()),
            AdaptedItem::Flat { files, .. } => {
                let sizes = files.iter().map(|(n, b)| (n.clone(), b.len() as u64));
                sizes.collect()
            }
        };
        let out = |name: &str| sent.iter().find(|(n, _)| n == name).map_or(0, |(_, b)| *b);
        let streams = item.manifest.files().into_iter();
        let streams = streams.map(|(name, bytes)| StreamReport {
            name: name.to_owned(),
            bytes_in: bytes,
            bytes_out: out(name),
        });
        Self {
            item: name,
            engine: match engine {
                Engine::Native => "native",
                Engine::Xslt => "xslt",
            },
            decision: DecisionReport::new(decided, adapted),
            streams: streams.collect(),
            bytes_in: item.bytes(),
            bytes_out: adapted.bytes(),
            joints: joints(adapted),
            seconds: decide_seconds + cut_seconds,
            decide_seconds,
            cut_seconds,
            words: decided.words(),
        }
    }

    pub(crate) fn text(&self) -> String {
        let mut text = self.words.clone();
        let mut table = Table::new(&["file", "bytes before", "bytes after"]);
        for stream in &self.streams {
            table.row([
                clean(&stream.name),
                stream.bytes_in.to_string(),
                stream.bytes_out.to_string(),
            ]);
        }
        text.push('\n');
        text.push_str(&table.text());
        text.push_str(&format!(
            "\n{} -> {} bytes ({:.1} %), decided in {:.2} ms, cut in {:.2} ms ({})\n",
            self.bytes_in,
            self.bytes_out,
            100.0 * self.bytes_out as f64 / self.bytes_in.max(1) as f64,
            1e3 * self.decide_seconds,
            1e3 * self.cut_seconds,
            self.engine
        ));
        text
    }
}

fn sizes(files: Vec<(&str, u64)>) -> Vec<(String, u64)> {
    files.into_iter().map(|(n, b)| (n.to_owned(), b)).collect()
}

impl DecisionReport {
    fn new(decided: &Decided, adapted: &AdaptedItem) -> Self {
        match decided {
            Decided::Jointly(joint) => Self::of_choice(joint, adapted),
            Decided::ByTable(table, _) => Self::of_table(table, adapted),
        }
    }

    /// What a table says, by the names of the pins of an item's own.
    fn of_table(table: &articula::stream::description::Decided, adapted: &AdaptedItem) -> Self {
        let of = |pin: &str| table.values.get(pin).map(|value| *value as u32);
        Self {
            modality: "3d".to_owned(),
            by: "aqos",
            loa: of(articula::stream::description::LAYERS),
            zones: zones(adapted),
            tier: of("TIER"),
            face_loa: of("FACE_LEVELS").map(|digits| digits / 10_000_000),
            mesh_level: of("MESH_LEVEL"),
            explanation: table.reasons.join("\n"),
            ..Self::default()
        }
    }

    fn of_choice(decided: &ItemDecision, adapted: &AdaptedItem) -> Self {
        let decision = &decided.decision;
        let body = decided.chosen(PartKind::BodyMotion);
        let budget = decision.request.budget.bytes;
        Self {
            modality: decision.modality.clone(),
            by: "joint choice",
            loa: body.and_then(|option| option.loa),
            zones: zones(adapted),
            tier: body.map(|option| option.level),
            face_loa: decided
                .chosen(PartKind::FaceMotion)
                .and_then(|option| option.loa),
            mesh_level: decided.chosen(PartKind::Mesh).map(|option| option.level),
            texture: decided
                .chosen(PartKind::Texture)
                .map(|option| option.name.clone()),
            error_px: decision.error_px.is_finite().then_some(decision.error_px),
            bytes_allowed: (budget < Budget::UNBOUNDED).then_some(budget + decided.bytes_always),
            pixels_per_metre: Some(decision.request.pixels_per_metre),
            network_ratio: decided.network_ratio,
            bounds: words(&decision.bounds),
            parts: decision.parts.iter().map(PartReport::new).collect(),
            explanation: decision.to_string(),
        }
    }
}

impl PartReport {
    fn new(part: &PartDecision) -> Self {
        let next = part.next.as_ref().map(|next| NextReport {
            option: next.option_name.clone(),
            more_bytes: next.more_bytes,
            more_frame_ns: next.more_frame_ns,
            gain_px: next.gain_px,
            bounds: words(&next.bounds),
        });
        Self {
            part: part.name.clone(),
            option: part.option_name.clone(),
            bytes: part.bytes,
            frame_ns: part.frame_ns,
            error_px: part.error_px,
            next,
        }
    }
}

fn words(bounds: &[Bound]) -> Vec<String> {
    bounds.iter().map(ToString::to_string).collect()
}

/// Names of the regions of the body that the motions of an adapted item have.
fn zones(adapted: &AdaptedItem) -> Vec<String> {
    let AdaptedItem::Layers(item) = adapted else {
        return Vec::new();
    };
    let parts = item.manifest.parts.iter();
    let bodies = parts.filter(|p| p.kind == articula::item::PartKind::BodyMotion);
    let numbers: Vec<u32> = bodies
        .flat_map(|part| part.regions.iter().map(|region| region.number))
        .collect();
    let numbered = Region::ALL.into_iter().zip(1..);
    let named = numbered.filter(|(_, number)| numbers.contains(number));
    named.map(|(region, _)| region.to_string()).collect()
}

/// Joints that the motions of an adapted item move at most.
fn joints(adapted: &AdaptedItem) -> u64 {
    let AdaptedItem::Layers(item) = adapted else {
        return 0;
    };
    let layers = item.manifest.parts.iter().flat_map(|part| &part.layers);
    layers.filter_map(|layer| layer.joints).max().unwrap_or(0)
}
