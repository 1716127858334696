//! Decisions by a table: AQoS and context give a selection, the selection layers.

use super::cut::ItemCut;
use super::options::AdaptOptions;
use super::regions::Regions;
use super::selected::keeps;
use super::{decide, decision::ItemDecision};
use crate::error::{Context as _, Result};
use crate::item::files::Item;
use articula_stream::decide::{ChoiceRequest, PartKind as ChoiceKind};
use articula_stream::description::{
    Aqos, Axis, BANDWIDTH, BsdLink, Content, Context, Decided, IoPin, LAYERS, LookUpTable, Module,
};

/// Parameters of the stylesheet with the pins of the AQoS that set them.
const PARAMETERS: [(&str, &str); 5] = [
    ("nLayersOut", LAYERS),
    ("regionMask", "BODY_REGIONS"),
    ("tierOut", "TIER"),
    ("meshLevelOut", "MESH_LEVEL"),
    ("faceLevels", "FACE_LEVELS"),
];

/// Bandwidths of the table of an item in bits per second: from 25 kbit/s, doubling.
const LEAST_BPS: f64 = 25e3;
const STEPS: i32 = 16;

/// The links of parameters to pins, for the BSDLink of a stream.
pub(in crate::item) fn parameters() -> Vec<(String, String)> {
    let owned = |(name, pin): &(&str, &str)| ((*name).to_owned(), (*pin).to_owned());
    PARAMETERS.iter().map(owned).collect()
}

/// The AQoS of an item: a table of what the joint choice takes at each bandwidth, for the view and the
/// device of a context. Levels of articulation and tiers are those of all motions, the mask has the
/// regions of the context; a mesh whose regions differ counts by its finest one.
///
/// # Errors
/// As [`decide`].
pub fn aqos(item: &Item, context: &Context, options: &AdaptOptions) -> Result<Aqos> {
    let rates: Vec<f64> = (0..STEPS).map(|i| LEAST_BPS * f64::from(1 << i)).collect();
    let mut rows: Vec<[f64; 5]> = Vec::with_capacity(rates.len());
    for rate in &rates {
        let mut at = context.clone();
        at.network.max_capacity_bps = None;
        at.network.min_available_bps = None;
        at.network.max_available_bps = None;
        at.network.available_bps = Some(*rate);
        let options = AdaptOptions {
            effort: ChoiceRequest::EFFORT.min(options.effort),
            ..*options
        };
        let decided = decide(item, &at, &options)?;
        rows.push(row(&decided, context));
    }
    let content = |column: usize, pin: &str| Content {
        pin: pin.to_owned(),
        values: rows.iter().map(|row| row[column]).collect(),
        is_linear: false,
    };
    let table = LookUpTable {
        axes: vec![Axis {
            pin: BANDWIDTH.to_owned(),
            values: rates,
        }],
        contents: PARAMETERS
            .iter()
            .enumerate()
            .map(|(column, (_, pin))| content(column, pin))
            .collect(),
    };
    let pin = |id: &str, semantics: Option<&str>| IoPin {
        id: id.to_owned(),
        semantics: semantics.map(str::to_owned),
        choices: Vec::new(),
    };
    let pins = PARAMETERS.iter().map(|(_, name)| pin(name, None));
    Ok(Aqos {
        pins: [pin(BANDWIDTH, Some(":VH:usable_bps"))]
            .into_iter()
            .chain(pins)
            .collect(),
        modules: vec![Module::LookUpTable(table)],
        ..Aqos::default()
    })
}

/// Values of the parameters for a decision; the coarsest ones if it fell to 2D or nothing fits.
fn row(decided: &ItemDecision, context: &Context) -> [f64; 5] {
    let option = |kind| decided.chosen(kind);
    let body = option(ChoiceKind::BodyMotion);
    let coarsest = |kind| {
        let parts = decided.parts.parts.iter().filter(|p| p.kind == kind);
        let levels = parts.flat_map(|p| p.options.iter().map(|o| o.level));
        f64::from(levels.max().unwrap_or(0))
    };
    let face = option(ChoiceKind::FaceMotion)
        .and_then(|o| o.loa)
        .unwrap_or(0);
    let regions = context.preferences.body_regions.unwrap_or(127);
    [
        f64::from(body.and_then(|o| o.loa).unwrap_or(0)),
        f64::from(regions),
        body.map_or_else(|| coarsest(ChoiceKind::BodyMotion), |o| f64::from(o.level)),
        option(ChoiceKind::Mesh).map_or_else(|| coarsest(ChoiceKind::Mesh), |o| f64::from(o.level)),
        f64::from(face) * 11_111_111.0,
    ]
}

/// Decides what of an item is sent by a table in place of the joint choice, as the thesis does: the
/// values of the AQoS select layers by level, region and tier. Textures stay whole.
///
/// # Errors
/// An [`Error`](crate::Error) that names the pin or parameter: a table that contradicts itself, a
/// context without the bandwidth, a value that no parameter of the stylesheet has.
pub fn decide_by_table(item: &Item, aqos: &Aqos, context: &Context) -> Result<(Decided, ItemCut)> {
    context.check()?;
    let decided = aqos.decide(&aqos.bind(context)).context("AQoS")?;
    let known = parameters().into_iter();
    let link = BsdLink {
        steering: None,
        description: "gbsd.xml".parse()?,
        transformation: None,
        parameters: known
            .filter(|(_, pin)| decided.values.contains_key(pin))
            .collect(),
    };
    let selection = link.selection(&decided.values).context("AQoS")?;
    let kept = item.manifest.parts.iter().map(|part| {
        let wanted: Vec<usize> = (0..part.layers.len())
            .filter(|layer| keeps(&selection, part.kind, &part.layers[*layer]))
            .collect();
        part.closure(&wanted)
    });
    let kept = kept.collect();
    let mut preferences = context.preferences.clone();
    preferences.body_regions = selection.body_regions.or(preferences.body_regions);
    let regions = Regions::of(&preferences);
    Ok((decided, ItemCut::Layers { kept, regions }))
}
