//! What of one character comes next: its pieces in the order in which they are worth most.

use super::report::CharacterReport;
use crate::error::Result;
use crate::item::delivery::{
    Delivery, Kept, PieceOf, access_units, is_motion, largest, mesh_level, side,
};
use crate::item::{
    AdaptOptions, Item, ItemBytes, ItemLayer, ItemPart, Manifest, PartKind, texture_error_px,
};
use articula_stream::decide::{LayerSwitch, SwitchRule};
use articula_stream::description::Context;
use articula_stream::difference;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

/// Time ahead for which the coarsest layers of the motion that plays are there first, seconds.
const HORIZON_SECS: f64 = 10.0;
/// The same for the finest layers.
const FINEST_HORIZON_SECS: f64 = 2.0;
/// Most bytes of an increment: what a slow network carries in a moment, so that others get their turn.
const MOST_BYTES: u64 = 1 << 16;

/// An item in pieces with its levels of quality in a context, as the manifest alone tells them. Clones share
/// them, as the sessions of a server do.
#[derive(Debug, Clone)]
pub struct DeliveryPlan(pub(super) Arc<Planned>);

/// What a plan holds: what is asked for again and again is found once.
#[derive(Debug)]
pub(super) struct Planned {
    delivery: Delivery,
    /// What shows at all times, from coarse to fine.
    shape: Vec<Turn>,
    /// Of each part the access units of a motion, each from coarse to fine; one list for a motion without
    /// access units, none for what is no motion.
    motions: Vec<Vec<Vec<Turn>>>,
    /// All motions together, level by level; only what plays now is of the least level.
    later: Vec<Turn>,
    /// Where the bytes of each piece lie.
    places: Vec<Vec<Place>>,
}

/// Bytes of a file.
#[derive(Debug, Clone)]
struct Place {
    file: String,
    range: Range<u64>,
    /// Bytes of the whole file.
    bytes: u64,
}

impl DeliveryPlan {
    /// Plans an item for the view, the device and the wishes of a context, whatever its bandwidth.
    ///
    /// # Errors
    /// As [`decide`](crate::item::decide); if the context gets no 3D, or the manifest has no ranges of bytes.
    pub fn new(manifest: &Manifest, context: &Context, options: &AdaptOptions) -> Result<Self> {
        let mut units = |part: &_| Ok(access_units(part));
        let item = Item::elsewhere(manifest.clone());
        let delivery = Delivery::of(&item, context, options, &mut units)?;
        Ok(Self(Arc::new(Planned::of(delivery))))
    }
}

/// Bytes of a file that come together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunk {
    pub(super) file: String,
    pub(super) range: Range<u64>,
    /// Whether this is the whole file, which may travel compressed.
    pub(super) is_whole: bool,
}

/// How far ahead an order goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// What the bandwidth carries of what plays.
    Playing,
    /// All that the context asks for.
    All,
    /// Nothing is left.
    Over,
}

/// A piece in its turn.
#[derive(Debug, Clone, Copy)]
struct Turn {
    piece: usize,
    /// Level of quality that it belongs to.
    level: usize,
}

/// The order in which a character comes.
#[derive(Debug)]
pub(super) struct CharacterPlan {
    planned: Arc<Planned>,
    /// For each piece whether it is there or on the way.
    has: Vec<bool>,
    /// Bytes that are there or on the way.
    held: ItemBytes,
    turns: VecDeque<Turn>,
    chunks: VecDeque<Chunk>,
    /// Level of the chunks.
    level: usize,
    reach: Reach,
    switch: LayerSwitch,
    /// Part of the motion that plays.
    playing: Option<usize>,
}

impl CharacterPlan {
    pub(super) fn new(plan: &DeliveryPlan, held: &ItemBytes) -> Self {
        let mut made = Self {
            has: Vec::new(),
            held: held.clone(),
            turns: VecDeque::new(),
            chunks: VecDeque::new(),
            level: 0,
            reach: Reach::Playing,
            switch: LayerSwitch::new(SwitchRule::default()),
            playing: None,
            planned: Arc::clone(&plan.0),
        };
        made.look_again();
        made
    }

    /// Changes the levels of quality of the same item, as when the view changes: its pieces are the same.
    pub(super) fn set_plan(&mut self, plan: &DeliveryPlan) {
        self.planned = Arc::clone(&plan.0);
        self.begin_anew();
    }

    /// Tells what is there after all, as when bytes were lost on the way.
    pub(super) fn set_held(&mut self, held: &ItemBytes) {
        self.held = held.clone();
        self.look_again();
    }

    /// Sets the motion that plays, the first one without a name that the item has.
    pub(super) fn play(&mut self, clip: Option<&str>) {
        let parts = self.planned.delivery.manifest.parts.iter().enumerate();
        let motions = parts.filter(|(_, part)| is_motion(part));
        let named = motions.clone().find(|(_, part)| Some(&*part.name) == clip);
        let playing = named.or(motions.clone().next()).map(|(part, _)| part);
        if self.playing != playing {
            self.playing = playing;
            self.begin_anew();
        }
    }

    /// Orders what comes anew at the next increment.
    pub(super) fn begin_anew(&mut self) {
        self.turns.clear();
        self.reach = Reach::Playing;
    }

    /// Whether all that the context asks for is there or on the way.
    pub(super) fn is_over(&self) -> bool {
        self.reach == Reach::Over && self.chunks.is_empty()
    }

    /// Whether what comes next is of the least that is shown.
    pub(super) fn is_base_next(&self) -> bool {
        match (self.chunks.is_empty(), self.turns.front()) {
            (false, _) => self.level == 0,
            (true, Some(turn)) => turn.level == 0,
            (true, None) => false,
        }
    }

    /// The level of quality that the bandwidth carries, of [`Self::levels`].
    pub(super) fn target(&self) -> usize {
        self.switch.layers()
    }

    pub(super) fn levels(&self) -> usize {
        self.planned.delivery.ladder.levels.len()
    }

    /// Brings the order up to date: at a time, with a position in the motion that plays, for a bandwidth.
    pub(super) fn order(&mut self, now_secs: f64, position_secs: f64, bits_per_second: f64) {
        while self.chunks.is_empty() && self.turns.is_empty() && self.reach != Reach::Over {
            let near = self.near(position_secs);
            let rates = self.rates(&near);
            let target = self.switch.update(now_secs, &rates, bits_per_second);
            let all = self.reach == Reach::All;
            self.turns = self.turns_of(&near, target, all).into();
            self.reach = match (all, self.turns.is_empty()) {
                (true, true) => Reach::Over,
                (false, true) => Reach::All,
                (_, false) => self.reach,
            };
        }
    }

    /// The next bytes, which are on the way from now on.
    pub(super) fn next(&mut self) -> Option<Chunk> {
        loop {
            if let Some(chunk) = self.chunks.pop_front() {
                let range = chunk.range.clone();
                self.held.add(&chunk.file, std::iter::once(range));
                return Some(chunk);
            }
            let turn = self.turns.pop_front()?;
            if !std::mem::replace(&mut self.has[turn.piece], true) {
                self.level = turn.level;
                self.chunks = self.chunks_of(turn.piece);
            }
        }
    }

    /// The next bytes if they go on where these end.
    pub(super) fn next_after(&mut self, before: &Chunk) -> Option<Chunk> {
        if self.chunks.is_empty() {
            let turn = *self.turns.front()?;
            if self.has[turn.piece] {
                return None;
            }
            let chunks = self.chunks_of(turn.piece);
            self.turns.pop_front();
            self.has[turn.piece] = true;
            self.level = turn.level;
            self.chunks = chunks;
        }
        let next = self.chunks.front()?;
        let goes_on = next.file == before.file && next.range.start == before.range.end;
        if !goes_on || next.range.end - before.range.start > MOST_BYTES {
            return None;
        }
        self.next()
    }

    /// For each piece whether all of it is among some bytes.
    pub(super) fn there(&self, held: &ItemBytes) -> Vec<bool> {
        let has = |place: &Place| held.has(&place.file, &place.range);
        let pieces = self.planned.places.iter();
        pieces.map(|places| places.iter().all(has)).collect()
    }

    /// Whether what plays at a position shows: its coarsest layer is among the pieces that are there, and the
    /// coarsest of all else.
    pub(super) fn is_ready(&self, there: &[bool], position_secs: f64) -> bool {
        let delivery = &self.planned.delivery;
        let least = &delivery.ladder.levels[0];
        let now = self.near(position_secs).into_iter().next();
        let has_unit = |(unit, _): (Option<usize>, f64)| {
            let layers = |part: usize| (part, &least[part]);
            self.playing.map(layers).is_none_or(|(part, layers)| {
                delivery
                    .missing_of_unit(there, (part, unit), layers)
                    .is_empty()
            })
        };
        delivery.missing_of_shape(there, least).is_empty() && now.is_none_or(has_unit)
    }

    /// The finest level of articulation of the body that is there of what plays at a position; `None` of a
    /// motion without levels.
    pub(super) fn loa(&self, there: &[bool], position_secs: f64) -> Option<u32> {
        let delivery = &self.planned.delivery;
        let part = self.playing?;
        let unit = self.near(position_secs).first().and_then(|(unit, _)| *unit);
        let layers = delivery.layers_there(there, part, unit);
        let layers = delivery.manifest.parts[part].layers.iter().zip(layers);
        let loa = layers.filter_map(|(layer, there)| layer.keep.get("loa").filter(|_| there));
        loa.max().copied()
    }

    /// Describes what is there of what plays at a position.
    pub(super) fn describe(
        &self,
        there: &[bool],
        position_secs: f64,
        report: &mut CharacterReport,
    ) {
        let delivery = &self.planned.delivery;
        let levels = &delivery.ladder.levels;
        let unit = self.near(position_secs).first().and_then(|(unit, _)| *unit);
        let has_level = |level: &&Kept| {
            let of_unit = |part: usize| {
                delivery
                    .missing_of_unit(there, (part, unit), &level[part])
                    .is_empty()
            };
            delivery.missing_of_shape(there, level).is_empty() && self.playing.is_none_or(of_unit)
        };
        report.level = levels.iter().take_while(has_level).count();
        report.levels = levels.len();
        report.target = self.target();
        report.is_complete = self.is_complete(there);
        let scale = delivery.pixels_per_metre();
        let mut errors_px = [0.0_f64; 3];
        for (index, part) in delivery.manifest.parts.iter().enumerate() {
            let unit = match is_motion(part) {
                true if self.playing == Some(index) => unit,
                true => continue,
                false => None,
            };
            let layers = delivery.layers_there(there, index, unit);
            let shown = || part.layers.iter().zip(&layers).filter(|(_, there)| **there);
            match part.kind {
                PartKind::Texture => {
                    let px = largest(part, &layers);
                    report.texture_px = Some(report.texture_px.map_or(px, |least| least.min(px)));
                    let error = texture_error_px(part, &layers, scale);
                    errors_px[0] = errors_px[0].max(error);
                }
                PartKind::Mesh => {
                    report.mesh_level = mesh_level(part, &layers);
                    let level = part
                        .levels
                        .iter()
                        .find(|l| Some(l.level) == report.mesh_level);
                    errors_px[1] = level.map_or(0.0, |level| scale * level.error_motion_m);
                }
                PartKind::BodyMotion | PartKind::FaceMotion => {
                    let value =
                        |(layer, _): (&ItemLayer, _), name: &str| layer.keep.get(name).copied();
                    let loa = |layer| value(layer, "loa").or_else(|| value(layer, "face_loa"));
                    report.loa = shown().filter_map(loa).max();
                    let of_loa = shown().filter(|layer| loa(*layer) == report.loa);
                    report.tier = of_loa.filter_map(|layer| value(layer, "tier")).min();
                    report.joints = shown().filter_map(|(layer, _)| layer.joints).max();
                    let least = shown().map(|(layer, _)| layer.error_m).reduce(f64::min);
                    let error = least.or(part.base_error_m).unwrap_or(0.0) + part.left_out_m();
                    errors_px[2] = scale * error;
                }
            }
        }
        report.error_px = Some(errors_px.iter().sum());
    }

    /// Whether all that the context asks for is among the pieces that are there.
    fn is_complete(&self, there: &[bool]) -> bool {
        let delivery = &self.planned.delivery;
        let top = delivery.ladder.top();
        let mut parts = delivery.manifest.parts.iter().enumerate();
        let has_unit = |part: usize, unit: Option<usize>| {
            delivery
                .missing_of_unit(there, (part, unit), &top[part])
                .is_empty()
        };
        delivery.missing_of_shape(there, top).is_empty()
            && parts.all(|(part, of)| {
                !is_motion(of) || units_of(of).into_iter().all(|unit| has_unit(part, unit))
            })
    }

    fn look_again(&mut self) {
        self.has = self.there(&self.held);
        self.chunks.clear();
        self.begin_anew();
    }

    /// Bytes of a piece that are not there.
    fn chunks_of(&self, piece: usize) -> VecDeque<Chunk> {
        let mut chunks = VecDeque::new();
        for place in &self.planned.places[piece] {
            let wanted = std::iter::once(place.range.clone()).collect();
            let missing = difference(&self.held.of(&place.file), &wanted);
            for range in missing.ranges() {
                // A whole file may travel compressed; one that is large, bit by bit.
                let is_whole = *range == (0..place.bytes) && place.bytes <= MOST_BYTES;
                let mut start = range.start;
                while start < range.end {
                    let end = range.end.min(start + MOST_BYTES);
                    chunks.push_back(Chunk {
                        file: place.file.clone(),
                        range: start..end,
                        is_whole,
                    });
                    start = end;
                }
            }
        }
        chunks
    }

    /// The access units of the motion that plays, from a position on, each with the time until it begins.
    fn near(&self, position_secs: f64) -> Vec<(Option<usize>, f64)> {
        let Some(part) = self.playing else {
            return Vec::new();
        };
        let of = &self.planned.delivery.manifest.parts[part];
        let secs = of.duration_secs.unwrap_or(0.0).max(1e-3);
        let units = access_units(of).len();
        if units == 0 {
            return vec![(None, 0.0)];
        }
        let of_unit = secs / units as f64;
        let at = position_secs.rem_euclid(secs) / of_unit;
        let first = (at as usize).min(units - 1);
        let starts = (0..units).map(|n| ((first + n) % units, (n as f64 - at.fract()) * of_unit));
        starts
            .map(|(unit, secs)| (Some(unit), secs.max(0.0)))
            .collect()
    }

    /// The pieces of the motion that plays and begin within some seconds, by access unit.
    fn ahead(&self, near: &[(Option<usize>, f64)]) -> impl Iterator<Item = (&[Turn], f64)> {
        let motion = self.playing.map(|part| &self.planned.motions[part]);
        let near = near.to_vec();
        motion.into_iter().flat_map(move |units| {
            let near = near.clone().into_iter();
            near.filter_map(|(unit, secs)| Some((&**units.get(unit.unwrap_or(0))?, secs)))
        })
    }

    /// For each level the bits per second that bring what is missing of it for the time ahead.
    fn rates(&self, near: &[(Option<usize>, f64)]) -> Vec<f64> {
        let mut seen = self.has.clone();
        let mut bytes = vec![0; self.levels()];
        let ahead = self.ahead(near).filter(|(_, secs)| *secs < HORIZON_SECS);
        let motions = ahead.flat_map(|(turns, _)| turns);
        for turn in self.shape().chain(motions) {
            if !std::mem::replace(&mut seen[turn.piece], true) {
                bytes[turn.level] += self.planned.delivery.catalogue.pieces[turn.piece].bytes;
            }
        }
        let mut sum = 0;
        let rates = bytes.into_iter().map(|bytes| {
            sum += bytes;
            8.0 * sum as f64 / HORIZON_SECS
        });
        rates.collect()
    }

    /// What is missing of what shows at all times: of a texture no size below one that is there.
    fn shape(&self) -> impl Iterator<Item = &Turn> {
        let delivery = &self.planned.delivery;
        let is_smaller = |turn: &Turn| {
            let PieceOf::Part { part, layer, .. } = delivery.catalogue.pieces[turn.piece].of else {
                return false;
            };
            let of = &delivery.manifest.parts[part];
            let (PartKind::Texture, Some(layer)) = (of.kind, layer) else {
                return false;
            };
            let there = delivery.layers_there(&self.has, part, None);
            largest(of, &there) > side(&of.layers[layer])
        };
        let missing = self
            .planned
            .shape
            .iter()
            .filter(|turn| !self.has[turn.piece]);
        missing.filter(move |turn| !is_smaller(turn))
    }

    /// What is missing, in order: level by level up to a target, of each first what shows at all times, then
    /// the motion that plays from now on. With `all` the other motions too, and the finer levels.
    fn turns_of(&self, near: &[(Option<usize>, f64)], target: usize, all: bool) -> Vec<Turn> {
        let levels = self.levels();
        let wanted = if all { levels } else { target };
        let mut turns: Vec<Turn> = self.shape().copied().collect();
        for (unit, secs) in self.ahead(near) {
            let is_due = |turn: &&Turn| {
                let share = turn.level as f64 / levels.max(2) as f64;
                all || secs < HORIZON_SECS + share * (FINEST_HORIZON_SECS - HORIZON_SECS)
            };
            turns.extend(unit.iter().filter(is_due));
        }
        if all {
            turns.extend(&self.planned.later);
        }
        let mut seen = self.has.clone();
        turns.retain(|turn| {
            let is_wanted = turn.level < wanted.max(1) || all;
            is_wanted && !std::mem::replace(&mut seen[turn.piece], true)
        });
        // What has the same level stays in order.
        turns.sort_by_key(|turn| turn.level);
        turns
    }
}

impl Planned {
    fn of(delivery: Delivery) -> Self {
        let parts = delivery.manifest.parts.iter().enumerate();
        let levels = &delivery.ladder.levels;
        let nothing = vec![false; delivery.catalogue.pieces.len()];
        let shape = turns(levels, &nothing, &|level, has| {
            delivery.missing_of_shape(has, level)
        });
        let motions = parts.map(|(part, of)| {
            let of_unit = |unit| {
                turns(levels, &nothing, &|level, has| {
                    delivery.missing_of_unit(has, (part, unit), &level[part])
                })
            };
            match is_motion(of) {
                true => units_of(of).into_iter().map(of_unit).collect(),
                false => Vec::new(),
            }
        });
        let motions: Vec<Vec<Vec<Turn>>> = motions.collect();
        let later = motions.iter().flatten().flatten().map(|turn| Turn {
            level: turn.level.max(1),
            ..*turn
        });
        let mut later: Vec<Turn> = later.collect();
        later.sort_by_key(|turn| turn.level);
        let pieces = 0..delivery.catalogue.pieces.len();
        Self {
            motions,
            later,
            places: pieces.map(|piece| places(&delivery, piece)).collect(),
            shape,
            delivery,
        }
    }
}

/// The pieces that levels ask for, each at the first one that does.
fn turns(
    levels: &[Kept],
    nothing: &[bool],
    missing: &dyn Fn(&Kept, &[bool]) -> Vec<usize>,
) -> Vec<Turn> {
    let mut seen = nothing.to_vec();
    let mut turns = Vec::new();
    for (number, level) in levels.iter().enumerate() {
        for piece in missing(level, nothing) {
            if !std::mem::replace(&mut seen[piece], true) {
                turns.push(Turn {
                    piece,
                    level: number,
                });
            }
        }
    }
    turns
}

/// The access units of a motion; `None` alone if it has none.
fn units_of(part: &ItemPart) -> Vec<Option<usize>> {
    match access_units(part).len() {
        0 => vec![None],
        count => (0..count).map(Some).collect(),
    }
}

/// Where the bytes of a piece lie.
fn places(delivery: &Delivery, piece: usize) -> Vec<Place> {
    let manifest = &delivery.manifest;
    let piece = &delivery.catalogue.pieces[piece];
    let whole = |file: &str, bytes: u64| Place {
        file: file.to_owned(),
        range: 0..bytes,
        bytes,
    };
    match piece.of {
        // It is there before there is a plan.
        PieceOf::Manifest => Vec::new(),
        PieceOf::Figure => {
            let figure = [whole(&manifest.figure.file, manifest.figure.bytes)];
            let carried = manifest.whole.iter();
            let carried = carried.map(|file| whole(&file.file, file.bytes));
            figure.into_iter().chain(carried).collect()
        }
        PieceOf::Part { part, layer, .. } => {
            let part = &manifest.parts[part];
            match (&part.file, layer.map(|layer| &part.layers[layer])) {
                (Some(file), _) => {
                    let place = |range: &Range<u64>| Place {
                        file: file.clone(),
                        range: range.clone(),
                        bytes: part.bytes,
                    };
                    piece.ranges.iter().map(place).collect()
                }
                (None, Some(size)) => {
                    let file = size.file.iter();
                    file.map(|file| whole(file, size.bytes)).collect()
                }
                (None, None) => Vec::new(),
            }
        }
    }
}
