//! A decision about an item as plain facts, under the names of the JSON report (`docs/commands.md`).

use super::adapt::{AdaptedItem, ItemDecision};
use articula_core::Region;
use articula_stream::decide::{Bound, PartDecision, PartKind};
use articula_stream::description::{Decided, LAYERS};
use serde::Serialize;

/// What is sent of an item, and why.
#[derive(Debug, Clone, Default, Serialize)]
pub struct DecisionReport {
    /// `3d`, or the kind of the form in 2D.
    pub modality: String,
    /// `joint choice` or `aqos`.
    pub by: &'static str,
    /// Finest level of articulation of the body.
    pub loa: Option<u32>,
    /// Regions of the body whose motion is kept.
    pub zones: Vec<String>,
    /// Tier of the motions.
    pub tier: Option<u32>,
    /// Finest level of articulation of the face.
    pub face_loa: Option<u32>,
    /// Mesh level.
    pub mesh_level: Option<u32>,
    /// Size of the textures.
    pub texture: Option<String>,
    /// Bound of the error on the screen; null if nothing fits.
    pub error_px: Option<f64>,
    /// Bytes that may be sent in all; null without a bound.
    pub bytes_allowed: Option<u64>,
    /// Pixels per metre at the distance of the character.
    pub pixels_per_metre: Option<f64>,
    /// Share of the item that the network carries in the time; null without a bandwidth.
    pub network_ratio: Option<f64>,
    /// Share of the time per frame of everything that the device bears, if that bounds it; else null.
    pub device_ratio: Option<f64>,
    /// What keeps the error from being smaller.
    pub bounds: Vec<String>,
    /// Motions that are not sent, and may be fetched later.
    pub absent: Vec<String>,
    /// The option of each part.
    pub parts: Vec<PartReport>,
    /// The decision in words.
    pub explanation: String,
}

/// The option that is sent of a part.
#[derive(Debug, Clone, Serialize)]
pub struct PartReport {
    /// Name of the part.
    pub part: String,
    /// Name of the option.
    pub option: String,
    /// Bytes of the option.
    pub bytes: u64,
    /// Time of a frame, nanoseconds.
    pub frame_ns: u64,
    /// Bound of the error, pixels.
    pub error_px: f64,
    /// The upgrade that gains most for its cost.
    pub next: Option<NextReport>,
}

/// The upgrade of a part that gains most for its cost.
#[derive(Debug, Clone, Serialize)]
pub struct NextReport {
    /// Name of the option.
    pub option: String,
    /// Bytes that it adds.
    pub more_bytes: i64,
    /// Time of a frame that it adds, nanoseconds.
    pub more_frame_ns: i64,
    /// Error that it saves, pixels.
    pub gain_px: f64,
    /// What keeps it from being taken.
    pub bounds: Vec<String>,
}

impl DecisionReport {
    /// Returns the decision of a table, by the names of the pins of an item's own, with the motions that are
    /// not sent.
    pub fn of_table(table: &Decided, adapted: &AdaptedItem, absent: Vec<String>) -> Self {
        let of = |pin: &str| table.values.get(pin).map(|value| *value as u32);
        Self {
            modality: match adapted {
                AdaptedItem::Layers(_) => "3d".to_owned(),
                AdaptedItem::Flat { entry, .. } => entry.modality.clone(),
            },
            by: "aqos",
            loa: of(LAYERS),
            zones: zones(adapted),
            tier: of("TIER"),
            face_loa: of("FACE_LEVELS").map(|digits| digits / 10_000_000),
            mesh_level: of("MESH_LEVEL"),
            absent,
            explanation: table.reasons.join("\n"),
            ..Self::default()
        }
    }

    /// Returns the joint choice.
    pub fn of_choice(decided: &ItemDecision, adapted: &AdaptedItem) -> Self {
        Self {
            zones: zones(adapted),
            ..Self::of_decision(decided)
        }
    }

    /// Returns the joint choice without the zones that are kept, which only the adapted item tells.
    pub fn of_decision(decided: &ItemDecision) -> Self {
        let decision = &decided.decision;
        let body = decided.chosen(PartKind::BodyMotion);
        Self {
            modality: decision.modality.clone(),
            by: "joint choice",
            loa: body.and_then(|option| option.loa),
            zones: Vec::new(),
            tier: body.map(|option| option.level),
            face_loa: decided
                .chosen(PartKind::FaceMotion)
                .and_then(|option| option.loa),
            mesh_level: decided.chosen(PartKind::Mesh).map(|option| option.level),
            texture: decided
                .chosen(PartKind::Texture)
                .map(|option| option.name.clone()),
            error_px: decision.error_px.is_finite().then_some(decision.error_px),
            bytes_allowed: decided.bytes_allowed,
            pixels_per_metre: Some(decision.request.pixels_per_metre),
            network_ratio: decided.network_ratio,
            device_ratio: decision.device_ratio,
            bounds: words(&decision.bounds),
            absent: decided.absent.clone(),
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
    let bodies = parts.filter(|p| p.kind == super::part::PartKind::BodyMotion);
    let numbers: Vec<u32> = bodies
        .flat_map(|part| part.regions.iter().map(|region| region.number))
        .collect();
    let numbered = Region::ALL.into_iter().zip(1..);
    let named = numbered.filter(|(_, number)| numbers.contains(number));
    named.map(|(region, _)| region.to_string()).collect()
}
