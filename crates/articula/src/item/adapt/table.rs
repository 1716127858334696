//! Decisions by a table: AQoS and context give a selection, the selection layers.

use super::cut::ItemCut;
use super::decision::{ItemDecision, decide_among};
use super::options::AdaptOptions;
use super::parts::Scope;
use super::regions::Regions;
use super::selected::keeps;
use crate::error::{Context as _, Result};
use crate::item::files::Item;
use crate::item::part::PartKind;
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

/// What is done where a selection does not fit.
const BEST: &str = "the best of it that fits is sent";

/// Bandwidths of the table of an item in bits per second: from 25 kbit/s, doubling.
const LEAST_BPS: f64 = 25e3;
const STEPS: i32 = 16;

/// The links of parameters to pins, for the BSDLink of a stream.
pub(in crate::item) fn parameters() -> Vec<(String, String)> {
    let owned = |(name, pin): &(&str, &str)| ((*name).to_owned(), (*pin).to_owned());
    PARAMETERS.iter().map(owned).collect()
}

/// The AQoS of an item: a table of what the joint choice takes at each bandwidth, for the view and the
/// device of a context, where all motions have one level of articulation and tier and all regions of a
/// mesh one level. The mask has the regions of the context.
///
/// # Errors
/// As [`decide`](super::decide).
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
        let even = Scope {
            is_even: true,
            ..Scope::default()
        };
        let decided = decide_among(item, &at, &options, even)?;
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
    let coarsest = |kind| {
        let parts = decided.parts.parts.iter().filter(|p| p.kind == kind);
        let levels = parts.flat_map(|p| p.options.iter().map(|o| o.level));
        levels.max().unwrap_or(0)
    };
    let motions = [ChoiceKind::BodyMotion, ChoiceKind::FaceMotion];
    let moving = motions.map(|kind| option(kind).filter(|_| decided.moves(kind)));
    // One tier is for both; beyond the coarsest, nothing moves.
    let tier = moving.iter().flatten().map(|o| o.level).min();
    let none = motions.into_iter().map(coarsest).max().unwrap_or(0) + 1;
    let loa = moving.map(|moving| moving.and_then(|o| o.loa).unwrap_or(0));
    let regions = context.preferences.body_regions.unwrap_or(127);
    let mesh = option(ChoiceKind::Mesh).map(|o| o.level);
    [
        f64::from(loa[0]),
        f64::from(regions),
        f64::from(tier.unwrap_or(none)),
        f64::from(mesh.unwrap_or_else(|| coarsest(ChoiceKind::Mesh))),
        f64::from(loa[1]) * 11_111_111.0,
    ]
}

/// Decides what of an item is sent by a table in place of the joint choice, as the thesis does: the
/// values of the AQoS select layers by level, region and tier. Textures, of which a table says nothing,
/// get the largest size for which bytes are left.
///
/// Where what is selected exceeds the bandwidth times [`AdaptOptions::wait_secs`], the best of it that
/// does not is sent, or a form in 2D. If nothing fits, the least of it is sent, and the last reason
/// tells how long that takes.
///
/// # Errors
/// An [`Error`](crate::Error) that names the pin or parameter: a table that contradicts itself, a
/// context without the bandwidth, a value that no parameter of the stylesheet has.
pub fn decide_by_table(
    item: &Item,
    aqos: &Aqos,
    context: &Context,
    options: &AdaptOptions,
) -> Result<(Decided, ItemCut)> {
    context.check()?;
    let mut decided = aqos.decide(&aqos.bind(context)).context("AQoS")?;
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
    let selected = item.manifest.parts.iter().map(|part| {
        let wanted: Vec<usize> = (0..part.layers.len())
            .filter(|layer| keeps(&selection, part.kind, &part.layers[*layer]))
            .collect();
        part.closure(&wanted)
    });
    let selected: Vec<Vec<bool>> = selected.collect();
    let mut context = context.clone();
    let preferences = &mut context.preferences;
    preferences.body_regions = selection.body_regions.or(preferences.body_regions);
    // What is selected is wanted, seen or not.
    preferences.tolerance_px = Some(0.0);
    let regions = Regions::of(&context.preferences);
    let within = Scope {
        within: Some(&selected),
        ..Scope::default()
    };
    let choice = decide_among(item, &context, options, within)?;
    let left = Selected {
        item: &regions.applied(item)?,
        layers: &selected,
        choice: &choice,
    };
    let (kept, reason) = match (left.with_textures(), choice.cut.clone()) {
        (Some(kept), _) => (kept, None),
        (None, Some(cut)) => {
            decided.reasons.push(format!("{}: {BEST}", left.exceeds()));
            return Ok((decided, cut));
        }
        (None, None) => {
            let least = left.least();
            let bytes = left.bytes(&least);
            let secs = options.wait_secs * bytes as f64 / left.allowed().max(1) as f64;
            let what = format!("nothing fits; the least, {bytes} bytes, takes {secs:.2} s");
            (least, Some(format!("{}: {what}", left.exceeds())))
        }
    };
    decided.reasons.extend(reason);
    Ok((decided, ItemCut::Layers { kept, regions }))
}

/// Layers that a table selects, all sizes of textures, and the choice among them.
struct Selected<'a> {
    /// The item with the regions that are wanted.
    item: &'a Item,
    layers: &'a [Vec<bool>],
    choice: &'a ItemDecision,
}

impl Selected<'_> {
    /// What is selected with the largest size of textures that fits; `None` if none fits.
    fn with_textures(&self) -> Option<Vec<Vec<bool>>> {
        let parts = self
            .choice
            .parts
            .parts
            .iter()
            .zip(&self.choice.parts.layers);
        let textures = parts.filter(|(part, _)| part.kind == ChoiceKind::Texture);
        let mut sizes: Vec<_> = textures.flat_map(|(_, layers)| layers).collect();
        let none = Vec::new();
        if sizes.is_empty() {
            sizes.push(&none);
        }
        let with = |size: &Vec<(usize, Vec<bool>)>| {
            let mut kept = self.without_textures();
            for (part, layers) in size {
                kept[*part].clone_from(layers);
            }
            kept
        };
        let mut all = sizes.into_iter().map(with);
        all.find(|kept| self.bytes(kept) <= self.allowed())
    }

    fn without_textures(&self) -> Vec<Vec<bool>> {
        let parts = self.item.manifest.parts.iter().zip(self.layers);
        let kept = parts.map(|(part, layers)| match part.kind {
            PartKind::Texture => vec![false; layers.len()],
            _ => layers.clone(),
        });
        kept.collect()
    }

    /// The fewest bytes of each part.
    fn least(&self) -> Vec<Vec<bool>> {
        let mut kept = self.without_textures();
        for (part, layers) in self
            .choice
            .parts
            .parts
            .iter()
            .zip(&self.choice.parts.layers)
        {
            let options = part.options.iter().zip(layers);
            let least = options.min_by_key(|(option, _)| option.bytes_once);
            for (part, layers) in least.iter().flat_map(|(_, layers)| *layers) {
                kept[*part].clone_from(layers);
            }
        }
        kept
    }

    /// Bytes that are sent with these layers.
    fn bytes(&self, kept: &[Vec<bool>]) -> u64 {
        let manifest = &self.item.manifest;
        let parts = manifest.parts.iter().zip(kept).enumerate();
        let sent = parts.filter(|(index, (_, kept))| manifest.has_part(*index, kept));
        // A texture without a size leaves the item.
        let bytes = sent.map(|(_, (part, kept))| part.bytes_of(kept));
        bytes.fold(self.choice.bytes_always, u64::saturating_add)
    }

    fn allowed(&self) -> u64 {
        self.choice.bytes_allowed.unwrap_or(u64::MAX)
    }

    fn exceeds(&self) -> String {
        format!("what is selected exceeds {} bytes", self.allowed())
    }
}
