//! What `adapt` prints, and writes beside what is sent.

use super::Engine;
use crate::fault::clean;
use crate::table::Table;
use articula::item::{AdaptedItem, DecisionReport, Item, ItemCut, ItemDecision};
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

    /// The least that would fit, in words.
    pub(super) fn least(&self) -> Option<String> {
        let Self::Jointly(decided) = self else {
            return None;
        };
        let Some(bytes) = decided.least_bytes else {
            let what = "whatever its bytes: the device, its memory, the time per frame or what the client \
                 supports do not allow it";
            return Some(format!(", {what}"));
        };
        let secs = decided
            .least_secs
            .map(|secs| format!(", {secs:.2} s at this bandwidth"));
        Some(format!(
            "; the least is {bytes} bytes{}",
            secs.unwrap_or_default()
        ))
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

#[derive(Debug, Serialize)]
struct StreamReport {
    name: String,
    bytes_in: u64,
    bytes_out: u64,
}

impl AdaptReport {
    pub(crate) fn new(
        name: String,
        (item, asked, adapted): (&Item, &Item, &AdaptedItem),
        decided: &Decided,
        engine: Engine,
        [decide_seconds, cut_seconds]: [f64; 2],
    ) -> Self {
        let out = |name: &str| match adapted {
            AdaptedItem::Layers(cut) => cut.manifest.sent_bytes(name),
            AdaptedItem::Flat { files, .. } => {
                let is_sent = files.iter().any(|(file, _)| file == name);
                if is_sent {
                    item.manifest.sent_bytes(name)
                } else {
                    0
                }
            }
        };
        let streams = item.manifest.sizes().into_iter();
        let streams = streams.map(|(name, _)| StreamReport {
            name: name.to_owned(),
            bytes_in: item.manifest.sent_bytes(name),
            bytes_out: out(name),
        });
        Self {
            item: name,
            engine: match engine {
                Engine::Native => "native",
                Engine::Xslt => "xslt",
            },
            decision: match decided {
                Decided::Jointly(joint) => DecisionReport::of_choice(joint, adapted),
                Decided::ByTable(table, cut) => {
                    DecisionReport::of_table(table, adapted, asked.manifest.absent(cut))
                }
            },
            streams: streams.collect(),
            bytes_in: item.sent_bytes(),
            bytes_out: adapted.sent_bytes(),
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
        if !self.decision.absent.is_empty() {
            let names: Vec<String> = self
                .decision
                .absent
                .iter()
                .map(|name| clean(name))
                .collect();
            text.push_str(&format!("not sent: {}\n", names.join(", ")));
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

/// Joints that the motions of an adapted item move at most.
fn joints(adapted: &AdaptedItem) -> u64 {
    let AdaptedItem::Layers(item) = adapted else {
        return 0;
    };
    let layers = item.manifest.parts.iter().flat_map(|part| &part.layers);
    layers.filter_map(|layer| layer.joints).max().unwrap_or(0)
}
