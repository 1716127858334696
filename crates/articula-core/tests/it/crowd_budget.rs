//! A budget over several crowds: it is kept, replayed, announced when it does not suffice, and
//! spares nobody near for those who are far.

use crate::crowd::{camera, fixed_figure, model, with_cache};
use articula_core::crowd::{
    Allowance, Budget, BudgetReport, ClipState, Crowd, CrowdModel, Culling, Detail, DrawKind, Frame,
};
use articula_core::visibility::View;
use glam::{Quat, Vec3};

/// Two crowds, one without and one with a cache, and where their characters are.
struct Two {
    models: [CrowdModel; 2],
    crowds: [Crowd; 2],
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
    dt_secs: f32,
}

const COUNT: usize = 800;

/// Frames after which everybody has what the first of them was allowed, at the latest.
const TAKEN_OVER: usize = 33;

/// What a frame computes: joints and matrices of poses that are evaluated, matrices of blended ones.
#[derive(Debug, Clone, Copy, Default)]
struct Computed {
    evaluated: f64,
    blended: f64,
    /// The greatest bound on an error.
    bound_px: f32,
}

impl Two {
    fn new() -> Self {
        let (rig, clips, sets) = fixed_figure();
        let plain = model(&rig, &clips, &sets);
        let models = [plain.clone(), with_cache(plain)];
        let crowds = models.each_ref().map(|model| {
            let mut crowd = Crowd::new(model, COUNT);
            for c in (0..COUNT).step_by(9) {
                crowd.fade_to(c, ClipState::new(model, 1), 3.0);
            }
            crowd
        });
        let place =
            |i: usize| Vec3::new((i % 20) as f32 - 10.0, -1.0, -3.0 - 3.0 * (i / 20) as f32);
        Self {
            models,
            crowds,
            positions: (0..COUNT).map(place).collect(),
            rotations: vec![Quat::IDENTITY; COUNT],
            dt_secs: 1.0 / 60.0,
        }
    }

    /// Plays one frame of both and returns what is computed.
    fn frame(&mut self, detail: Detail, budget: &mut Budget) -> Computed {
        let mut computed = Computed::default();
        for (crowd, model) in self.crowds.iter_mut().zip(&self.models) {
            let view = View::of(&camera());
            let frame = Frame {
                dt_secs: self.dt_secs,
                positions: &self.positions,
                rotations: &self.rotations,
                culling: Culling::Views(std::slice::from_ref(&view)),
                detail,
                ..Frame::default()
            };
            let report = crowd.tick(model, &frame, &mut |_| {});
            budget.add(crowd, model);
            computed.bound_px = computed.bound_px.max(report.bound_px);
            computed.evaluated += (report.work.fk_joints + report.work.matrices) as f64;
            computed.blended += crowd.draw_list().matrices as f64 - report.work.matrices as f64;
        }
        computed
    }

    /// The greatest bound on an error of those of whom a metre spans as many pixels as of near ones.
    fn near_px(&self) -> f32 {
        let mut near_px = 0.0_f32;
        for (crowd, model) in self.crowds.iter().zip(&self.models) {
            for character in 0..COUNT {
                let density = crowd.cull_result(character).pixels_per_metre;
                let Some(level) = crowd.level(character) else {
                    continue;
                };
                let (from, to) = crowd.clips(character);
                let error = model.error_metres(from, to.unwrap_or(from), level);
                if density >= 1.001 * Allowance::NEAR_PX_PER_METRE {
                    near_px = near_px.max(error * density);
                }
            }
        }
        near_px
    }
}

/// A made-up machine.
#[derive(Debug, Clone, Copy)]
struct Machine {
    /// Nanoseconds for each joint and matrix of an evaluated pose, and for each blended matrix.
    evaluated_ns: f64,
    blended_ns: f64,
    /// Nanoseconds of a tick, and what one takes in addition in which all levels are chosen again.
    tick_ns: f64,
    change_ns: f64,
    /// What the first frame takes in addition, in tick and evaluation each.
    cold_ns: f64,
    /// Range of a time from frame to frame, as a part of it.
    noise: f64,
}

impl Machine {
    fn even(ns: f64) -> Self {
        Self {
            evaluated_ns: ns,
            blended_ns: ns,
            tick_ns: 5000.0,
            change_ns: 0.0,
            cold_ns: 0.0,
            noise: 0.05,
        }
    }

    fn evaluate_ns(&self, computed: Computed, frame: usize) -> f64 {
        let work = computed.evaluated * self.evaluated_ns + computed.blended * self.blended_ns;
        let noise = ((frame * 7919) % 101) as f64 / 101.0 - 0.5;
        1000.0 + work * (1.0 + self.noise * noise)
    }
}

/// What was played: reports, times over the limit, greatest bounds of all and of near characters.
#[derive(Debug, PartialEq)]
struct Played {
    reports: Vec<BudgetReport>,
    used: Vec<f64>,
    bounds_px: Vec<f32>,
    near_px: f32,
}

impl Played {
    /// 95th percentile of the time beyond the limit once costs are learned, as a part of it; where the floor
    /// that the frame before told is above the limit, beyond that.
    fn overrun(&self) -> f64 {
        let told = self.reports[59..].iter();
        let over = self.used[60..].iter().zip(told).map(|(used, told)| {
            let floor = told.floor_ns / told.limit_ns;
            used / floor.max(1.0) - 1.0
        });
        let mut over: Vec<f64> = over.collect();
        over.sort_by(f64::total_cmp);
        over[over.len() * 95 / 100].max(0.0)
    }

    /// Whether the floor was ever above the limit once costs were learned.
    fn is_at_floor(&self) -> bool {
        self.reports[59..].iter().any(|r| r.floor_ns > r.limit_ns)
    }

    fn last(&self) -> &BudgetReport {
        self.reports.last().unwrap()
    }
}

/// Plays 300 frames under a limit that follows from the times of a frame at one pixel and with
/// everyone at the cheapest.
fn played(limit: impl Fn(f64, f64) -> f64, machine: Machine) -> Played {
    let mut two = Two::new();
    let mut nothing = Budget::new(0.0, 1.0);
    let [at_cap, least] = [1.0, 1e6].map(|px| {
        let computed = two.frame(Detail::Tolerance { px }, &mut nothing);
        machine.tick_ns + machine.evaluate_ns(computed, 0)
    });
    let limit = limit(at_cap, least);
    let mut two = Two::new();
    let mut budget = Budget::new(limit, 1.0);
    let mut played = Played {
        reports: Vec::new(),
        used: Vec::new(),
        bounds_px: Vec::new(),
        near_px: 0.0,
    };
    let mut before = budget.allowance();
    for frame in 0..300 {
        let computed = two.frame(budget.detail(), &mut budget);
        let is_changed = std::mem::replace(&mut before, budget.allowance()) != before;
        let cold_ns = if frame == 0 { machine.cold_ns } else { 0.0 };
        let change_ns = if is_changed { machine.change_ns } else { 0.0 };
        let tick_ns = machine.tick_ns + change_ns + cold_ns;
        let evaluate_ns = machine.evaluate_ns(computed, frame) + cold_ns;
        played.near_px = played.near_px.max(two.near_px());
        played.reports.push(budget.observe(tick_ns, evaluate_ns));
        played.used.push((evaluate_ns + tick_ns) / limit);
        played.bounds_px.push(computed.bound_px);
    }
    played
}

#[test]
fn a_budget_is_kept_and_used() {
    for (share, ns) in [(3.0, 3.0), (1.0, 0.3), (0.7, 3.0), (0.5, 30.0)] {
        let found = played(
            |at_cap, least| least + share * (at_cap - least),
            Machine::even(ns),
        );
        let over = found.overrun();
        assert!(over <= 0.05, "{share}: {over}, {:?}", found.last());
        let settled = &found.used[60..];
        let mean = settled.iter().sum::<f64>() / settled.len() as f64;
        assert!(
            mean > 0.8 || share > 1.0,
            "{share}: only {mean} of the budget is used"
        );
        // Nobody, near or far, is farther off than a tolerance that is still taken over.
        for (frame, bound_px) in found.bounds_px.iter().enumerate() {
            let shown = found.reports[..=frame].iter().rev().map(|r| r.shown);
            let px = shown.take(TAKEN_OVER).map(|s| s.px);
            let px = px.fold(0.0, f32::max);
            assert!(*bound_px <= px * 1.001, "{share}: {bound_px} of {px}");
        }
        // Between the costs at the cap and at the cheapest, the cap cannot be kept.
        let last = found.last();
        if share != 1.0 {
            assert_eq!(last.is_overloaded(), share < 1.0, "{share}");
            assert_eq!(last.is_satisfied(), share > 1.0, "{share}");
        }
        // What is saved by more than the error asked for is not spent on less.
        assert!(found.reports.iter().all(|r| r.shown.px >= 1.0));
    }
}

/// No constant of the model is that of these machines: evaluation and blending cost ten times as much and
/// as little, and to choose again takes as long as a frame.
#[test]
fn a_budget_is_kept_on_machines_unlike_the_model() {
    let even = Machine::even(3.0);
    let machines = [
        Machine {
            blended_ns: 12.0,
            change_ns: 8000.0,
            ..even
        },
        Machine {
            evaluated_ns: 12.0,
            blended_ns: 0.4,
            change_ns: 8000.0,
            ..even
        },
        Machine {
            tick_ns: 40_000.0,
            change_ns: 40_000.0,
            noise: 0.1,
            ..even
        },
    ];
    for (m, machine) in machines.into_iter().enumerate() {
        for share in [2.0, 1.0, 0.75, 0.5, 0.1] {
            let found = played(|at_cap, _| share * at_cap, machine);
            let (last, over) = (found.last(), found.overrun());
            let place = format!("machine {m}, {share}: {over}, {last:?}");
            // At the floor there is nothing left to give: it is told, and it is what is used.
            let allowed = if found.is_at_floor() { 0.1 } else { 0.05 };
            assert!(over <= allowed, "{place}");
            // What the machine needs for the cap is well above its floor.
            assert!(share < 1.0 || !last.sacrifice().time, "{place}");
            assert!(!last.sacrifice().time || !last.is_satisfied(), "{place}");
            assert!(found.near_px <= 2.0 * 1.001, "{place}: {}", found.near_px);
            if share >= 2.0 {
                assert!(last.is_satisfied() && last.next.px == 1.0, "{place}");
            }
            if last.floor_ns > last.limit_ns {
                assert!(!last.is_satisfied(), "{place}");
            }
        }
    }
}

#[test]
fn recorded_times_give_the_same_frames() {
    let [one, again] =
        [(); 2].map(|()| played(|at_cap, least| 0.5 * (at_cap + least), Machine::even(3.0)));
    assert_eq!(one, again);
}

#[test]
fn too_little_is_announced_and_what_would_fit() {
    let found = played(|at_cap, least| 0.5 * (at_cap + least), Machine::even(3.0));
    let last = found.last();
    assert!(last.is_overloaded() && last.next.px > 1.0);
    assert!(last.sacrifice().pixels && !last.is_satisfied());
    assert!(found.used.last().unwrap() < &1.1);
    // Nothing is enough: everyone at the cheapest, and no number is lost.
    let found = played(|_, _| 0.0, Machine::even(3.0));
    let last = found.last();
    assert!(last.is_overloaded() && last.next.px.is_finite());
    assert!(last.sacrifice().time && last.floor_ns > 0.0);
    for odd in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        let mut two = Two::new();
        let mut budget = Budget::new(odd, f32::NAN);
        two.frame(budget.detail(), &mut budget);
        let report = budget.observe(odd, odd);
        assert_eq!((report.shown.px, report.next.px), (1.0, 1.0));
        let report = budget.observe(5000.0, 9000.0);
        assert!(report.next.px > 0.0, "no crowd is no cost: {report:?}");
    }
}

/// Below the limit nobody is asked what another tolerance would cost, which takes as long as a frame of characters
/// that stand still; what is shown is what is shown without a budget.
#[test]
fn a_budget_far_above_the_cost_rests() {
    for (share, rests) in [(2.0, true), (1.5, true), (0.9, false), (0.7, false)] {
        let found = played(|at_cap, _| share * at_cap, Machine::even(3.0));
        // While those who fade at first still do.
        let settled = &found.reports[60..150];
        assert!(settled.iter().all(|r| r.rests == rests), "{share}");
        let is_floor_possible = |r: &BudgetReport| r.floor_ns <= r.expected_next_ns * 1.001;
        assert!(settled.iter().all(is_floor_possible), "{share}");
        if rests {
            assert!(settled.iter().all(|r| r.is_satisfied() && r.next.px == 1.0));
            let mut two = Two::new();
            let mut nothing = Budget::new(0.0, 1.0);
            let detail = Detail::Tolerance { px: 1.0 };
            for bound_px in &found.bounds_px {
                assert_eq!(two.frame(detail, &mut nothing).bound_px, *bound_px);
            }
        }
    }
}

/// The first frame, which chooses all levels and finds nothing in the cache of the processor, may take forty times as
/// long as others: no triangles are given up for it.
#[test]
fn the_first_frame_is_not_taken_for_the_usual_one() {
    let machine = Machine {
        cold_ns: 4e6,
        ..Machine::even(3.0)
    };
    let found = played(|at_cap, _| 2.0 * at_cap, machine);
    for report in &found.reports[1..] {
        assert!(!report.sacrifice().triangles, "{report:?}");
        assert_eq!(report.next.px, 1.0);
    }
    assert!(found.reports[60..].iter().all(|r| r.rests));
}

/// Where nothing is left to give, a change of the tolerance would cost time and save none: the time of a frame is that
/// of the floor, and does not vary with changes.
#[test]
fn a_budget_at_the_floor_changes_nothing() {
    for noise in [0.05, 0.2] {
        let machine = Machine {
            change_ns: 5000.0,
            noise,
            ..Machine::even(3.0)
        };
        for (at_floor, more) in [(0.0, 0.0), (0.5, 0.0), (1.0, 0.005)] {
            let found = played(|at_cap, least| at_floor * least + more * at_cap, machine);
            let settled = &found.reports[150..];
            let changes = settled.iter().filter(|r| r.next != r.shown).count();
            assert!(changes <= 1, "{noise}, {at_floor}: {changes} changes");
            let floor_ns = found.last().floor_ns;
            assert!(
                found.last().expected_next_ns <= 1.05 * floor_ns,
                "{:?}",
                found.last()
            );
        }
    }
}

/// Characters come nearer after the budget rested so long that it knows nothing of them.
#[test]
fn a_budget_that_rested_is_kept_again() {
    let machine = Machine::even(3.0);
    let nearer = |two: &mut Two| two.positions.iter_mut().for_each(|p| p.z *= 0.2);
    let ns = |computed: Computed, frame: usize| {
        let evaluate_ns = machine.evaluate_ns(computed, frame);
        (evaluate_ns, machine.tick_ns + evaluate_ns)
    };
    let mut nothing = Budget::new(0.0, 1.0);
    let mut two = Two::new();
    let detail = Detail::Tolerance { px: 1.0 };
    let (_, far) = ns(two.frame(detail, &mut nothing), 0);
    nearer(&mut two);
    let (_, near) = ns(two.frame(detail, &mut nothing), 0);
    assert!(near > 1.5 * far, "{near} {far}");
    let limit = 0.9 * near;
    let mut budget = Budget::new(limit, 1.0);
    let mut two = Two::new();
    for frame in 0..400 {
        if frame == 200 {
            nearer(&mut two);
        }
        let (evaluate_ns, used) = ns(two.frame(budget.detail(), &mut budget), frame);
        let report = budget.observe(machine.tick_ns, evaluate_ns);
        if (40..200).contains(&frame) {
            assert!(report.rests, "{frame}");
        }
        // All are asked in 16 frames, and all have taken over what follows in 8 more.
        if frame >= 200 + 16 + 8 + 8 {
            assert!(
                used <= 1.05 * limit.max(report.floor_ns),
                "{frame}: {used} of {limit}"
            );
        }
    }
}

#[test]
fn a_budgeted_frame_allocates_nothing() {
    let mut two = Two::new();
    let mut budget = Budget::new(50_000.0, 1.0);
    let machine = Machine::even(3.0);
    let computed = two.frame(budget.detail(), &mut budget);
    budget.observe(5000.0, machine.evaluate_ns(computed, 0));
    let counted = allocation_counter::measure(|| {
        for frame in 0..40 {
            let computed = two.frame(budget.detail(), &mut budget);
            budget.observe(5000.0, machine.evaluate_ns(computed, frame));
        }
    });
    assert_eq!(counted.count_total, 0);
}

/// A new allowance is taken over cell by cell: in a frame by no more than a part of the crowd, and by all within as
/// many frames as it says, after which each is shown as if it had been taken over at once.
#[test]
fn an_allowance_reaches_everybody_within_its_frames() {
    const CELL: usize = 64;
    let frames: u16 = 5;
    let cells = COUNT.div_ceil(CELL);
    let allowance = |px: f32, by_processor: bool, frames: u16| Allowance {
        px,
        near_px: 2.0,
        by_processor,
        frames,
    };
    let mut nothing = Budget::new(0.0, 1.0);
    let [mut slowly, mut at_once] = [Two::new(), Two::new()];
    let shown = |two: &Two| -> Vec<(Option<usize>, Option<DrawKind>)> {
        let all = two.crowds.iter().flat_map(|crowd| {
            let kind = |c: usize| {
                let list = crowd.draw_list();
                let mut kinds = DrawKind::ALL.into_iter();
                kinds.find(|kind| list.characters(*kind).contains(&(c as u32)))
            };
            (0..COUNT).map(move |c| (crowd.level(c), kind(c)))
        });
        all.collect()
    };
    for two in [&mut slowly, &mut at_once] {
        two.dt_secs = 0.0;
        two.frame(Detail::Within(allowance(0.5, false, 1)), &mut nothing);
    }
    let mut changes = 0;
    for next in [(6.0, false), (6.0, true), (0.7, true), (2.5, false)] {
        at_once.frame(Detail::Within(allowance(next.0, next.1, 1)), &mut nothing);
        let aim = shown(&at_once);
        let mut before = shown(&slowly);
        changes += before.iter().zip(&aim).filter(|(a, b)| a != b).count();
        for _ in 0..frames {
            let within = allowance(next.0, next.1, frames);
            slowly.frame(Detail::Within(within), &mut nothing);
            let now = shown(&slowly);
            let changed = |crowd: usize| {
                let of = crowd * COUNT..(crowd + 1) * COUNT;
                let pairs = before[of.clone()].iter().zip(&now[of]);
                pairs.filter(|(a, b)| a != b).count()
            };
            let most = cells.div_ceil(usize::from(frames)) * CELL;
            assert!(changed(0) <= most && changed(1) <= most);
            assert!(
                now.iter()
                    .zip(&aim)
                    .zip(&before)
                    .all(|((now, aim), before)| now == aim || now == before)
            );
            before = now;
        }
        assert_eq!(before, aim, "{next:?}");
    }
    assert!(changes > COUNT, "{changes} changes");
}
