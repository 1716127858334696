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
        (item, adapted): (&Item, &AdaptedItem),
        decided: &Decided,
        engine: Engine,
        [decide_seconds, cut_seconds]: [f64; 2],
    ) -> Self {
        let sent: Vec<(String, u64)> = match adapted {
            AdaptedItem::Layers(item) => sizes(item.manifest.sizes()),
            AdaptedItem::Flat { files, .. } => {
                let sizes = files.iter().map(|(n, b)| (n.clone(), b.len() as u64));
                sizes.collect()
            }
        };
        let out = |name: &str| sent.iter().find(|(n, _)| n == name).map_or(0, |(_, b)| *b);
        let streams = item.manifest.sizes().into_iter();
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
            decision: match decided {
                Decided::Jointly(joint) => DecisionReport::of_choice(joint, adapted),
                Decided::ByTable(table, _) => DecisionReport::of_table(table, adapted),
            },
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

/// Joints that the motions of an adapted item move at most.
fn joints(adapted: &AdaptedItem) -> u64 {
    let AdaptedItem::Layers(item) = adapted else {
        return 0;
    };
    let layers = item.manifest.parts.iter().flat_map(|part| &part.layers);
    layers.filter_map(|layer| layer.joints).max().unwrap_or(0)
}
