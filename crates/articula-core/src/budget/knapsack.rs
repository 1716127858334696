//! The choice for everyone: greedy by gain per cost, repaired from frame to frame.
//!
//! Source: `spec/motion-lod.md` part 7. The plain form starts everyone at the cheapest option
//! and takes the upgrade with the greatest error drop per cost until the budget is used; its
//! total error differs from the least possible by at most one upgrade. Differs: no heap. The
//! taken upgrades are those above one key, which [`super::frontier`] finds; a repair gives
//! exactly what solving anew would, and looks at the characters that changed and at those whose
//! next or last upgrade lies near that key.

use super::frontier::{Break, Frontier, Span};
use super::menu::{Menu, MenuId, Offer, Point, from_fixed, to_fixed};
use super::report::{Change, FrameReport, survey};
use crate::Mismatch;

/// A change of scale below this factor leaves a character's judgement as it is.
const SCALE_HYSTERESIS: f32 = 1.1;
/// The same for weights, which go with the third power of the scale (pixels per metre times the
/// pixels covered).
const WEIGHT_HYSTERESIS: f32 = 1.331;
/// Bounds that keep every product of weight, ageing and gain a normal number.
const WEIGHTS: (f32, f32) = (1e-12, 1e15);
const MOST_AGEING: f32 = 1e12;
const MOST_PIXELS_PER_METRE: f32 = 1e9;
/// A key for characters that must be looked at in any case; no upgrade has it.
const TOUCHED: u32 = u32::MAX;
/// Marks upgrades of a character that is above the cap: they come before all others.
const URGENT: u32 = 1 << 31;
/// No option: hidden.
const NOTHING: u8 = u8::MAX;

/// What the budget aims at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Policy {
    /// Error that no character should exceed, pixels. Upgrades of those above it come first.
    /// Infinite: there is no cap.
    pub cap_px: f32,
    /// Error below which a character is not improved any more, pixels; 0 spends the whole
    /// budget, the cap spends no more than the cap asks for.
    pub enough_px: f32,
    /// A character that stays above the cap gains weight each time it has waited for so many
    /// frames: after `w` frames it counts `(1 + w / patience)³` times. 0: nobody ages.
    pub patience_frames: u32,
    /// For so many frames a character that had to wait keeps the weight that it gained.
    pub hold_frames: u32,
}

impl Default for Policy {
    /// A cap of one pixel, the whole budget is spent, 16 frames each to wait and to hold.
    fn default() -> Self {
        Self {
            cap_px: 1.0,
            enough_px: 0.0,
            patience_frames: 16,
            hold_frames: 16,
        }
    }
}

/// What a visible character asks for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Its options.
    pub menu: MenuId,
    /// What a metre of its error counts: salience × pixels per metre × covered pixels. What is
    /// negative or no number counts as 0: such a character is brought to the cap, no further.
    pub weight: f32,
    /// Pixels that one metre spans at its nearest depth; several views: the largest.
    pub pixels_per_metre: f32,
}

/// How one character was judged last.
#[derive(Debug, Clone, Copy)]
struct Seat {
    menu: u32,
    weight: f32,
    pixels_per_metre: f32,
    /// Factor of the weight while it is above the cap.
    ageing: f32,
    /// Frame since which it waits, or at which its turn began.
    waits_since: u32,
    turn_since: u32,
    /// Points up to this one are needed for the cap, up to `last` they are wanted.
    target: u8,
    last: u8,
    chosen: u8,
    visible: bool,
    /// Above the cap for want of budget.
    starved: bool,
    /// It waited, and was served less than the hold ago.
    turn: bool,
    /// Judged anew at the next request, whatever it says.
    due: bool,
}

const EMPTY: Seat = Seat {
    menu: 0,
    weight: 0.0,
    pixels_per_metre: 0.0,
    ageing: 1.0,
    waits_since: 0,
    turn_since: 0,
    target: 0,
    last: 0,
    chosen: 0,
    visible: false,
    starved: false,
    turn: false,
    due: false,
};

impl Seat {
    /// Key of the upgrade from point `i`.
    fn key(&self, menu: &Menu, i: u8) -> u32 {
        let gain = menu.steps()[usize::from(i)].gain_per_cost;
        if i < self.target {
            (self.weight * self.ageing * gain).to_bits() | URGENT
        } else {
            (self.weight * gain).to_bits().max(1)
        }
    }

    fn judge(&mut self, menu: &Menu, request: &Request, policy: &Policy) {
        *self = Self {
            menu: request.menu.0,
            weight: request.weight,
            pixels_per_metre: request.pixels_per_metre,
            due: false,
            visible: true,
            ..*self
        };
        let within = |limit| first_within(menu.points(), request.pixels_per_metre, limit);
        self.target = within(policy.cap_px);
        self.last = self.target;
        if request.weight > WEIGHTS.0 {
            self.last = within(policy.enough_px).max(self.target);
        }
    }
}

impl Seat {
    /// The factor that its wait has earned it.
    fn aged(&mut self, frame: u32, policy: &Policy) -> f32 {
        if self.turn && frame.wrapping_sub(self.turn_since) >= policy.hold_frames {
            self.turn = false;
            self.waits_since = frame;
        }
        if !(self.turn || self.starved) {
            return 1.0;
        }
        let waited = frame.wrapping_sub(self.waits_since) as f32 / policy.patience_frames as f32;
        // Others are looked at up to one patience earlier or later; two keep a turn from them.
        let lead = if self.turn { 2.0 } else { 0.0 };
        (1.0 + waited + lead).powi(3).min(MOST_AGEING)
    }
}

impl Request {
    /// Without what would break sums and products.
    fn tamed(self) -> Self {
        Self {
            menu: self.menu,
            weight: tamed(self.weight, WEIGHTS.0, WEIGHTS.1),
            pixels_per_metre: tamed(self.pixels_per_metre, 0.0, MOST_PIXELS_PER_METRE),
        }
    }
}

/// Clamps; what is no number is the least.
fn tamed(x: f32, least: f32, most: f32) -> f32 {
    if x >= least { x.min(most) } else { least }
}

/// The first point whose error is within a limit, or the best one.
fn first_within(points: &[Point], pixels_per_metre: f32, limit_px: f32) -> u8 {
    let within = |p: &Point| p.error_metres * pixels_per_metre <= limit_px;
    points.iter().position(within).unwrap_or(points.len() - 1) as u8
}

/// The choice for a fixed number of characters, all hidden at first.
///
/// Each frame: [`request`](Self::request) or [`hide`](Self::hide) for every character whose view
/// may have changed, then [`solve`](Self::solve).
#[derive(Debug, Clone)]
pub struct Budget {
    policy: Policy,
    menus: Vec<Menu>,
    seats: Vec<Seat>,
    /// Keys of the upgrade that each would take next and of the one it took last.
    next_key: Vec<u32>,
    last_key: Vec<u32>,
    /// What is shown now: error, scale, option.
    error_metres: Vec<f32>,
    pixels_per_metre: Vec<f32>,
    shown: Vec<u8>,
    frontier: Frontier,
    /// Cost of the cheapest options, of those chosen and of all that is wanted, fixed point.
    base: u64,
    used: u64,
    demand: u64,
    visible: usize,
    room: u64,
    stirred: bool,
    frame: u32,
    looked_at: Vec<u32>,
    /// Whose turn began in the frame before.
    newly_served: Vec<u32>,
    changes: Vec<Change>,
    per_option: Vec<u32>,
}

impl Budget {
    /// A budget for `characters` that are all hidden.
    pub fn new(characters: usize, policy: Policy) -> Self {
        Self {
            policy,
            menus: Vec::new(),
            seats: vec![EMPTY; characters],
            next_key: vec![0; characters],
            last_key: vec![TOUCHED; characters],
            error_metres: vec![0.0; characters],
            pixels_per_metre: vec![0.0; characters],
            shown: vec![NOTHING; characters],
            frontier: Frontier::new(),
            base: 0,
            used: 0,
            demand: 0,
            visible: 0,
            room: 0,
            stirred: false,
            frame: 0,
            looked_at: Vec::with_capacity(characters),
            newly_served: Vec::with_capacity(characters),
            changes: Vec::with_capacity(characters),
            per_option: Vec::new(),
        }
    }

    /// Adds the options of a kind of character. Allocates: menus are made when things are put
    /// together.
    ///
    /// # Errors
    /// As [`Menu::new`].
    pub fn add_menu(&mut self, offers: &[Offer]) -> Result<MenuId, Mismatch> {
        let id = MenuId(self.menus.len() as u32);
        self.menus.push(Menu::new(offers)?);
        let most = self.per_option.len().max(offers.len());
        self.per_option.resize(most, 0);
        Ok(id)
    }

    /// The options behind an id.
    pub fn menu(&self, id: MenuId) -> &Menu {
        &self.menus[id.0 as usize]
    }

    /// Says how a visible character stands in this frame. It is judged anew only if it was hidden,
    /// has another menu, or its scale changed by more than 10 % (its weight: by more than a
    /// third) since it was judged last. O(1), does not allocate.
    ///
    /// # Panics
    /// If there is no such character, or the menu is of another budget with more menus.
    pub fn request(&mut self, character: usize, request: Request) {
        let request = request.tamed();
        self.pixels_per_metre[character] = request.pixels_per_metre;
        let seat = &self.seats[character];
        let (scale, weight) = (request.pixels_per_metre, request.weight);
        let same = seat.visible
            && !seat.due
            && seat.menu == request.menu.0
            && near(seat.pixels_per_metre, scale, SCALE_HYSTERESIS)
            && near(seat.weight, weight, WEIGHT_HYSTERESIS);
        if !same {
            self.judge(character, &request);
        }
    }

    /// Says that nobody sees a character: it costs nothing and has no error.
    pub fn hide(&mut self, character: usize) {
        if self.seats[character].visible {
            self.retract(character);
            self.seats[character] = EMPTY;
            self.touch(character);
        }
    }

    /// Has a character judged anew at its next request: its hold ended.
    pub fn requeue(&mut self, character: usize) {
        self.seats[character].due = true;
    }

    /// Replaces the policy; everyone is judged anew by it. O(characters), does not allocate.
    pub fn set_policy(&mut self, policy: Policy) {
        self.policy = policy;
        self.rebuild();
    }

    /// Gives every option a new cost, by its menu and index; see [`Menu::reprice`]. Everyone is
    /// placed anew. O(characters + options), does not allocate.
    pub fn reprice(&mut self, mut cost: impl FnMut(MenuId, usize) -> f32) {
        for (id, menu) in self.menus.iter_mut().enumerate() {
            menu.reprice(|option| cost(MenuId(id as u32), option));
        }
        self.rebuild();
    }

    /// Chooses for everyone within `budget`, in the units of the menus; what is no number counts
    /// as 0. Does not allocate. Costs hardly more than the report if nothing changed.
    pub fn solve(&mut self, budget: f32) -> FrameReport {
        self.frame = self.frame.wrapping_add(1);
        self.changes.clear();
        self.age();
        let budget = to_fixed(budget);
        let room = budget.saturating_sub(self.base);
        if self.stirred || room != self.room {
            self.room = room;
            self.stirred = false;
            self.repair();
        }
        self.report(budget)
    }

    /// The option a character is shown with, by its index in the menu's offers; nothing if it is
    /// hidden.
    pub fn choice(&self, character: usize) -> Option<usize> {
        option(self.shown[character]).map(usize::from)
    }

    /// Who changed in the frame that was solved last, in the order of characters.
    pub fn changes(&self) -> &[Change] {
        &self.changes
    }

    /// How many characters are shown with each option, by its index in the menus' offers.
    pub fn per_option(&self) -> &[u32] {
        &self.per_option
    }

    fn judge(&mut self, character: usize, request: &Request) {
        if self.seats[character].visible {
            self.retract(character);
        }
        let menu = &self.menus[request.menu.0 as usize];
        self.seats[character].judge(menu, request, &self.policy);
        self.enter(character);
    }

    /// Takes a visible character's options out of all sums.
    fn retract(&mut self, character: usize) {
        let seat = &self.seats[character];
        let menu = &self.menus[seat.menu as usize];
        let base = u64::from(menu.points()[0].cost);
        for i in 0..seat.last {
            let cost = menu.steps()[usize::from(i)].cost;
            self.frontier.remove(seat.key(menu, i), cost);
        }
        self.base -= base;
        self.demand -= u64::from(menu.points()[usize::from(seat.last)].cost);
        self.used -= u64::from(menu.points()[usize::from(seat.chosen)].cost);
        self.visible -= 1;
    }

    /// Puts a visible character's options into all sums, itself at the cheapest.
    fn enter(&mut self, character: usize) {
        let seat = &mut self.seats[character];
        seat.chosen = 0;
        let menu = &self.menus[seat.menu as usize];
        let base = u64::from(menu.points()[0].cost);
        for i in 0..seat.last {
            let cost = menu.steps()[usize::from(i)].cost;
            self.frontier.add(seat.key(menu, i), cost);
        }
        self.base += base;
        self.demand += u64::from(menu.points()[usize::from(seat.last)].cost);
        self.used += base;
        self.visible += 1;
        self.touch(character);
    }

    fn touch(&mut self, character: usize) {
        self.next_key[character] = TOUCHED;
        self.stirred = true;
    }

    fn rebuild(&mut self) {
        self.frontier.clear();
        (self.base, self.used, self.demand, self.visible) = (0, 0, 0, 0);
        for character in 0..self.seats.len() {
            let seat = &mut self.seats[character];
            if self.policy.patience_frames == 0 {
                (seat.ageing, seat.turn) = (1.0, false);
            }
            if seat.visible {
                let request = Request {
                    menu: MenuId(seat.menu),
                    weight: seat.weight,
                    pixels_per_metre: seat.pixels_per_metre,
                };
                seat.judge(&self.menus[seat.menu as usize], &request, &self.policy);
                self.enter(character);
            }
        }
    }

    /// Looks at one block of characters, another one each frame, so that everyone comes up once in
    /// `patience_frames`: who waits gains weight, who was served long enough loses it again.
    fn age(&mut self) {
        let patience = self.policy.patience_frames as usize;
        if patience == 0 {
            self.newly_served.clear();
            return;
        }
        // Whose turn began is set apart at once, before those who wait overtake it.
        for k in 0..self.newly_served.len() {
            self.age_one(self.newly_served[k] as usize);
        }
        self.newly_served.clear();
        let block = self.seats.len().div_ceil(patience);
        let from = block * (self.frame as usize % patience);
        for character in from..(from + block).min(self.seats.len()) {
            self.age_one(character);
        }
    }

    fn age_one(&mut self, character: usize) {
        let seat = &mut self.seats[character];
        let before = seat.ageing;
        let ageing = seat.aged(self.frame, &self.policy);
        if seat.visible && ageing != before {
            self.retract(character);
            self.seats[character].ageing = ageing;
            self.enter(character);
        }
    }

    /// Finds where the room ends now and moves those characters across who stand on the wrong side.
    fn repair(&mut self) {
        let span = self.frontier.seek(self.room);
        self.look_for(span);
        for k in 0..self.looked_at.len() {
            let character = self.looked_at[k] as usize;
            let (seat, menu) = seat_and_menu(&mut self.seats, &self.menus, character);
            let before = seat.chosen;
            seat.chosen = (0..seat.last)
                .find(|i| seat.key(menu, *i) <= span.greatest)
                .unwrap_or(seat.last);
            if seat.visible {
                let cost = |i: u8| u64::from(menu.points()[usize::from(i)].cost);
                self.used = self.used - cost(before) + cost(seat.chosen);
            }
        }
        let (seats, menus, looked_at) = (&self.seats, &self.menus, &self.looked_at);
        let end = self.frontier.find(self.room, |each| {
            for character in looked_at {
                let seat = &seats[*character as usize];
                let menu = &menus[seat.menu as usize];
                for i in seat.chosen..seat.last {
                    let key = seat.key(menu, i);
                    if key < span.least {
                        break;
                    }
                    each(key, menu.steps()[usize::from(i)].cost);
                }
            }
        });
        self.settle(end);
    }

    /// Characters that changed, or have an upgrade on the wrong side of the span or in it.
    fn look_for(&mut self, span: Span) {
        /// Characters that are tested at once.
        const ROW: usize = 16;
        self.looked_at.clear();
        let rows = self.next_key.chunks(ROW).zip(self.last_key.chunks(ROW));
        for (row, (next, last)) in rows.enumerate() {
            let near =
                |(next, last): (&u32, &u32)| (*next >= span.least) | (*last <= span.greatest);
            let any = next
                .iter()
                .zip(last)
                .fold(false, |any, pair| any | near(pair));
            if any {
                let pairs = next.iter().zip(last).enumerate();
                let found = pairs.filter(|(_, pair)| near(*pair));
                let found = found.map(|(i, _)| (row * ROW + i) as u32);
                self.looked_at.extend(found);
            }
        }
    }

    /// Takes what lies above the break, and of what lies on it the first that fit, by character.
    fn settle(&mut self, mut end: Break) {
        for k in 0..self.looked_at.len() {
            let character = self.looked_at[k] as usize;
            let (seat, menu) = seat_and_menu(&mut self.seats, &self.menus, character);
            while seat.chosen < seat.last {
                let key = seat.key(menu, seat.chosen);
                let cost = u64::from(menu.steps()[usize::from(seat.chosen)].cost);
                if key < end.key {
                    break;
                }
                if key == end.key {
                    if cost > end.room {
                        // Nothing behind the first that does not fit, so that a larger budget
                        // never takes anything back.
                        end.room = 0;
                        break;
                    }
                    end.room -= cost;
                }
                self.used += cost;
                seat.chosen += 1;
            }
            self.show(character);
        }
    }

    /// Writes down what follows from a character's choice.
    fn show(&mut self, character: usize) {
        let seat = &mut self.seats[character];
        let (mut now, mut error) = (NOTHING, 0.0);
        (self.next_key[character], self.last_key[character]) = (0, TOUCHED);
        if seat.visible {
            let menu = &self.menus[seat.menu as usize];
            let point = &menu.points()[usize::from(seat.chosen)];
            (now, error) = (point.option, point.error_metres);
            if seat.chosen < seat.last {
                self.next_key[character] = seat.key(menu, seat.chosen);
            }
            if seat.chosen > 0 {
                self.last_key[character] = seat.key(menu, seat.chosen - 1);
            }
        }
        let starved = seat.visible && seat.chosen < seat.target;
        match (seat.starved, starved) {
            _ if seat.turn => {}
            (true, false) => {
                (seat.turn, seat.turn_since) = (true, self.frame);
                self.newly_served.push(character as u32);
            }
            (false, true) => seat.waits_since = self.frame,
            _ => {}
        }
        seat.starved = starved;
        self.error_metres[character] = error;
        let before = std::mem::replace(&mut self.shown[character], now);
        if before != now {
            if let Some(option) = option(before) {
                self.per_option[usize::from(option)] -= 1;
            }
            if let Some(option) = option(now) {
                self.per_option[usize::from(option)] += 1;
            }
            self.changes.push(Change {
                character: character as u32,
                from: option(before),
                to: option(now),
            });
        }
    }

    fn report(&self, budget: u64) -> FrameReport {
        let (worst_px, sum, above_cap) = survey(
            &self.error_metres,
            &self.pixels_per_metre,
            self.policy.cap_px,
        );
        FrameReport {
            budget: from_fixed(budget),
            used: from_fixed(self.used),
            demand: from_fixed(self.demand),
            visible: self.visible,
            above_cap,
            worst_px,
            mean_px: (sum / self.visible.max(1) as f64) as f32,
            changes: self.changes.len(),
        }
    }
}

fn seat_and_menu<'a>(
    seats: &'a mut [Seat],
    menus: &'a [Menu],
    character: usize,
) -> (&'a mut Seat, &'a Menu) {
    let seat = &mut seats[character];
    let menu = &menus[seat.menu as usize];
    (seat, menu)
}

/// Whether two numbers, neither negative, are within a factor of each other.
fn near(a: f32, b: f32, factor: f32) -> bool {
    a <= b * factor && b <= a * factor
}

fn option(shown: u8) -> Option<u8> {
    (shown != NOTHING).then_some(shown)
}
