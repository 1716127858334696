//! The order in which one character comes: what is worth most for its bytes first.

use super::plan::{DeliveryPlan, Place, Planned, Turn};
use crate::item::delivery::{PieceOf, access_units, is_motion, largest, side};
use crate::item::{ItemBytes, PartKind};
use articula_stream::decide::{LayerSwitch, SwitchRule};
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

/// The order in which a character comes.
#[derive(Debug)]
pub(super) struct CharacterPlan {
    pub(super) planned: Arc<Planned>,
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
    pub(super) playing: Option<usize>,
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

    /// The level of quality that the bandwidth carries, of [`Self::levels`]; all of them once nothing is left to come.
    pub(super) fn target(&self) -> usize {
        match self.is_over() {
            true => self.levels(),
            false => self.switch.layers(),
        }
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
    pub(super) fn near(&self, position_secs: f64) -> Vec<(Option<usize>, f64)> {
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
            let is_wanted = all || turn.level < target.max(1);
            is_wanted && !std::mem::replace(&mut seen[turn.piece], true)
        });
        // What has the same level stays in order.
        turns.sort_by_key(|turn| turn.level);
        turns
    }
}
