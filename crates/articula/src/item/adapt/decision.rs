//! From a context to the request of a decision, and its answer.

use super::cut::ItemCut;
use super::options::AdaptOptions;
use super::parts::{ItemParts, Scope};
use super::regions::Regions;
use crate::clip_streams::StreamKind;
use crate::error::{Error, Result};
use crate::item::files::Item;
use crate::item::manifest::FlatEntry;
use crate::item::part::PartKind as ItemKind;
use articula_stream::decide::{
    self, Assumptions, Budget, ChoiceRequest, Decision, DecisionRequest, DeviceBenchmark,
    NetworkShare, Outcome, PartKind, Preference, Representation, wanted_modality, weigh_parts,
};
use articula_stream::description::Context;

/// Distance at which errors are compared where the context has none, metres.
const DISTANCE_M: f32 = 3.5;
/// Error that is not seen, in pixels, where a context tells how the character is seen, but no
/// tolerance.
const TOLERANCE_PX: f64 = 1.0;
/// Bytes and nanoseconds of a budget that nothing bounds.
const UNBOUNDED: u64 = Budget::UNBOUNDED;

/// A decision about an item.
#[derive(Debug, Clone, PartialEq)]
pub struct ItemDecision {
    /// What was decided, with its reasons.
    pub decision: Decision,
    /// The parts that were decided on, with their options.
    pub parts: ItemParts,
    /// What is kept of the item; `None` if nothing fits.
    pub cut: Option<ItemCut>,
    /// Motions that are not sent, as no layer of them is kept.
    pub absent: Vec<String>,
    /// Bytes that are sent whatever is chosen: the figure, and files that are carried whole.
    pub bytes_always: u64,
    /// Bytes that may be sent in all; `None` without a bound.
    pub bytes_allowed: Option<u64>,
    /// If nothing fits: the fewest bytes that would, figure and carried files included; `None` if it is
    /// not the bytes that prevent it.
    pub least_bytes: Option<u64>,
    /// The time that these take at the bandwidth of the context, seconds.
    pub least_secs: Option<f64>,
    /// Share of the item that the network carries in the time, 0 to 1 (`R_A` of the thesis); `None`
    /// without a bandwidth.
    pub network_ratio: Option<f64>,
}

impl ItemDecision {
    /// Returns the chosen option of the first part of a kind.
    pub fn chosen(&self, kind: PartKind) -> Option<&decide::PartOption> {
        let Outcome::Parts(choice) = &self.decision.outcome else {
            return None;
        };
        let index = self.parts.parts.iter().position(|p| p.kind == kind)?;
        let option = *choice.options.get(index)?;
        self.parts.parts[index].options.get(option)
    }

    /// Returns whether the chosen option of the first part of a kind keeps a layer.
    pub(super) fn moves(&self, kind: PartKind) -> bool {
        let Outcome::Parts(choice) = &self.decision.outcome else {
            return false;
        };
        let index = self.parts.parts.iter().position(|p| p.kind == kind);
        let layers = index.and_then(|i| self.parts.layers[i].get(*choice.options.get(i)?));
        layers.is_some_and(|layers| layers.iter().any(|(_, kept)| kept.contains(&true)))
    }
}

/// Decides what of an item is sent in a context: the least visible error for the bytes and the time
/// allowed, over motions, meshes and textures at once.
///
/// - Bytes: the bandwidth times [`AdaptOptions::wait_secs`], at most [`AdaptOptions::max_bytes`].
/// - Time: `frame_budget_ms` of the terminal, with its speeds; what it does not tell costs nothing. With
///   `benchmarks`, at most the share of the cost of everything that the device bears, in times of a
///   reference machine where the terminal tells no speeds.
/// - Memory: `memory_bytes` of the terminal, for decoded meshes, textures and clips.
/// - Errors are compared in pixels at the distance of the view (3.5 m if unknown) on the display of
///   the terminal (1280 x 720 at 45 degrees if unknown). An error up to `tolerance_px` (1 if a
///   distance is known, else 0) is not seen, so bytes are saved instead.
/// - `body_loa`, `face_loa`, `body_regions` and `mesh_level` bound what is sent.
///
/// # Errors
/// An [`Error`] that names a value of the context or option out of its bounds, or an index that does
/// not belong to its stream.
pub fn decide(item: &Item, context: &Context, options: &AdaptOptions) -> Result<ItemDecision> {
    decide_among(item, context, options, Scope::default())
}

/// The same among some options of each part.
pub(super) fn decide_among(
    item: &Item,
    context: &Context,
    options: &AdaptOptions,
    scope: Scope<'_>,
) -> Result<ItemDecision> {
    context.check()?;
    if !(options.wait_secs > 0.0 && options.wait_secs.is_finite()) {
        let what = format!("wait_secs: found {}, expected above 0", options.wait_secs);
        return Err(Error::argument(what));
    }
    let regions = Regions::of(&context.preferences);
    let item = &regions.applied(item)?;
    let mut request = ChoiceRequest::of_context(context, &assumptions(options));
    let device = DeviceBenchmark::of_context(context);
    let known = device.map_or_else(|| context.clone(), |_| with_reference_speeds(context));
    let mut parts = ItemParts::of(item, &known, options, request.pixels_per_metre, scope);
    weigh_parts(&mut parts.parts, context);
    let sent_bytes = |file: &String| item.manifest.sent_bytes(file);
    let carried = item.manifest.whole.iter().map(|file| &file.file);
    let whole: u64 = carried.map(sent_bytes).sum();
    let bytes_always = sent_bytes(&item.manifest.figure.file) + whole;
    let allowed = request
        .budget
        .bytes
        .min(options.max_bytes.unwrap_or(UNBOUNDED));
    request.budget.bytes = match allowed {
        UNBOUNDED.. => UNBOUNDED,
        bounded => bounded.saturating_sub(bytes_always),
    };
    request.effort = options.effort;
    if context.view.distance_m.is_some() && context.preferences.tolerance_px.is_none() {
        request.enough_px = TOLERANCE_PX;
    }
    let network = context.network.usable_bps().map(|bps| NetworkShare {
        bits_per_second: bps,
        window_secs: options.wait_secs,
        content_bits: 8.0 * item.sent_bytes_of_layers() as f64,
    });
    let representations: Vec<Representation> = representations(item, allowed, whole);
    let needs = needs(item);
    let capabilities = match context.terminal.codecs.as_slice() {
        // Nothing is known: everything is supported.
        [] => {
            let all = representations.iter().flat_map(|form| &form.needs);
            all.chain(&needs).cloned().collect()
        }
        known => known.to_vec(),
    };
    let preferences = Preference::of_context(context);
    let mut decision = decide::decide(&DecisionRequest {
        parts: &parts.parts,
        parts_need: &needs,
        choice: request,
        preferences: &preferences,
        representations: &representations,
        capabilities: &capabilities,
        modality: wanted_modality(context),
        device,
    })?;
    if let Outcome::Representation(form) = decision.outcome {
        decision.bytes = sent_bytes(&item.manifest.flat[form].file);
    }
    if !matches!(decision.outcome, Outcome::Parts(_)) && allowed < UNBOUNDED {
        // Without 3D there is no figure.
        decision.request.budget.bytes = allowed.saturating_sub(whole);
    }
    let cut = kept_of(item, &parts, &decision.outcome, regions);
    let absent = cut.as_ref().map(|cut| item.manifest.absent(cut));
    let least_bytes = match decision.outcome {
        Outcome::Nothing => least_bytes(item, &decision, &capabilities, bytes_always),
        _ => None,
    };
    let secs = |bytes: u64| Some(8.0 * bytes as f64 / context.network.usable_bps()?);
    Ok(ItemDecision {
        least_secs: least_bytes.and_then(secs).filter(|secs| secs.is_finite()),
        least_bytes,
        decision,
        parts,
        cut,
        absent: absent.unwrap_or_default(),
        bytes_always,
        bytes_allowed: (allowed < UNBOUNDED).then_some(allowed),
        network_ratio: network.map(|n| n.ratio()),
    })
}

/// Speeds of the machine that scores of benchmarks are compared with, where the terminal tells none: how
/// much of the time of a frame joints, parameters of the face and triangles take.
const REFERENCE_JOINTS_PER_MS: f64 = 1e4;
const REFERENCE_FAPS_PER_MS: f64 = 1e4;
const REFERENCE_TRIANGLES_PER_S: f64 = 1e8;

/// The context with the speeds of the reference machine in place of those that are unknown.
fn with_reference_speeds(context: &Context) -> Context {
    let mut known = context.clone();
    let terminal = &mut known.terminal;
    for (speed, reference) in [
        (&mut terminal.joints_per_ms, REFERENCE_JOINTS_PER_MS),
        (&mut terminal.faps_per_ms, REFERENCE_FAPS_PER_MS),
        (&mut terminal.triangles_per_s, REFERENCE_TRIANGLES_PER_S),
    ] {
        speed.get_or_insert(reference);
    }
    known
}

/// What counts where the context says nothing: no bound, and the usual distance.
fn assumptions(options: &AdaptOptions) -> Assumptions {
    Assumptions {
        bits_per_second: 8.0 * UNBOUNDED as f64 / options.wait_secs,
        window_secs: options.wait_secs,
        frame_ns: UNBOUNDED,
        distance_m: DISTANCE_M,
        ..Assumptions::default()
    }
}

/// The fewest bytes of anything that the client shows.
fn least_bytes(
    item: &Item,
    decision: &Decision,
    capabilities: &[String],
    bytes_always: u64,
) -> Option<u64> {
    let sent_bytes = |file: &String| item.manifest.sent_bytes(file);
    let whole = bytes_always - sent_bytes(&item.manifest.figure.file);
    let shown = |form: &&FlatEntry| form.needs.iter().all(|need| capabilities.contains(need));
    let forms = item.manifest.flat.iter().filter(shown);
    let forms = forms.map(|form| sent_bytes(&form.file).saturating_add(whole));
    let parts = decision.least_bytes.map(|bytes| bytes + bytes_always);
    forms.chain(parts).min()
}

/// The forms in 2D, of which none is too large that the bytes allow together with the files that are
/// carried whole.
fn representations(item: &Item, allowed: u64, whole: u64) -> Vec<Representation> {
    let forms = item.manifest.flat.iter();
    let of = |form: &FlatEntry| Representation {
        modality: form.modality.clone(),
        // The budget of the choice has the figure taken off, which these do not need.
        bytes: if item.manifest.sent_bytes(&form.file).saturating_add(whole) <= allowed {
            0
        } else {
            u64::MAX
        },
        error_px: form.error_px,
        needs: form.needs.clone(),
    };
    forms.map(of).collect()
}

/// What a client must decode to show the item in 3D.
fn needs(item: &Item) -> Vec<String> {
    let mut needs: Vec<String> = Vec::new();
    for part in &item.manifest.parts {
        let stream = part.file.as_deref().and_then(|file| item.file(file));
        let kind = stream.and_then(StreamKind::of);
        let name = match (part.kind, kind, part.comes_whole()) {
            (ItemKind::Texture, ..) => continue,
            (ItemKind::Mesh, ..) => "ams",
            (_, Some(StreamKind::Abp1), _) => "abp1",
            (_, Some(StreamKind::Abp2), _) => "abp2",
            (_, Some(StreamKind::Afp1), _) => "afp1",
            (_, Some(StreamKind::Afp2), _) => "afp2",
            (_, Some(_), _) => continue,
            // Of a stream that is not here, the manifest tells whether its units are bytes.
            (ItemKind::BodyMotion, None, true) => "abp1",
            (ItemKind::BodyMotion, None, false) => "abp2",
            (ItemKind::FaceMotion, None, true) => "afp1",
            (ItemKind::FaceMotion, None, false) => "afp2",
        };
        let name = name.to_owned();
        if !needs.contains(&name) {
            needs.push(name);
        }
    }
    needs
}

/// What an outcome keeps of the item.
fn kept_of(item: &Item, parts: &ItemParts, outcome: &Outcome, regions: Regions) -> Option<ItemCut> {
    match outcome {
        Outcome::Nothing => None,
        Outcome::Representation(form) => Some(ItemCut::Flat(*form)),
        Outcome::Parts(choice) => {
            let kept = kept(item, parts, &choice.options);
            Some(ItemCut::Layers { kept, regions })
        }
    }
}

/// The layers of the item that the chosen options keep.
fn kept(item: &Item, parts: &ItemParts, options: &[usize]) -> Vec<Vec<bool>> {
    let none = |part: &crate::item::ItemPart| vec![false; part.layers.len()];
    let mut kept: Vec<Vec<bool>> = item.manifest.parts.iter().map(none).collect();
    for (layers, option) in parts.layers.iter().zip(options) {
        for (part, of_part) in &layers[*option] {
            kept[*part].clone_from(of_part);
        }
    }
    kept
}
