//! A budget over several crowds: it is kept, replayed, announced when it does not suffice, and
//! spares nobody near for those who are far.

use crate::crowd::{camera, fixed_figure, model, with_cache};
use articula_core::crowd::{
    Budget, BudgetReport, ClipState, Crowd, CrowdModel, Culling, Detail, Frame,
};
use articula_core::visibility::View;
use glam::{Quat, Vec3};

/// Two crowds, one without and one with a cache, and where their characters are.
struct Two {
    models: [CrowdModel; 2],
    crowds: [Crowd; 2],
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
}

const COUNT: usize = 800;

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
        }
    }

    /// Plays one frame of both and returns the greatest bound on an error and the number of joints
    /// and matrices that are computed.
    fn frame(&mut self, detail: Detail, budget: &mut Budget) -> (f32, f64) {
        let camera = camera();
        let views = [View::of(&camera)];
        let (mut bound_px, mut work) = (0.0_f32, 0.0);
        for (crowd, model) in self.crowds.iter_mut().zip(&self.models) {
            let frame = Frame {
                dt_secs: 1.0 / 60.0,
                positions: &self.positions,
                rotations: &self.rotations,
                culling: Culling::Views(&views),
                detail,
                ..Frame::default()
            };
            let report = crowd.tick(model, &frame, &mut |_| {});
            budget.add(crowd, model);
            bound_px = bound_px.max(report.bound_px);
            work += report.work.fk_joints as f64 + crowd.draw_list().matrices as f64;
        }
        (bound_px, work)
    }
}

/// A made-up machine: so many nanoseconds for each joint and matrix, varied by a few per cent from
/// frame to frame.
fn measured(work: f64, ns: f64, frame: usize) -> f64 {
    let noise = ((frame * 7919) % 101) as f64 / 101.0 - 0.5;
    1000.0 + work * ns * (1.0 + 0.05 * noise)
}

/// Plays 300 frames under a limit that follows from the times of a frame at one pixel and with
/// everyone at the cheapest.
fn played(limit: impl Fn(f64, f64) -> f64, ns: f64) -> (Vec<BudgetReport>, Vec<f64>, Vec<f32>) {
    let mut two = Two::new();
    let mut nothing = Budget::new(0.0, 1.0);
    let [at_cap, least] = [1.0, 1e6].map(|px| {
        let (_, work) = two.frame(Detail::Tolerance { px }, &mut nothing);
        5000.0 + measured(work, ns, 0)
    });
    let limit = limit(at_cap, least);
    let mut two = Two::new();
    let mut budget = Budget::new(limit, 1.0);
    let (mut reports, mut used, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
    for frame in 0..300 {
        let (bound_px, work) = two.frame(budget.detail(), &mut budget);
        let evaluate_ns = measured(work, ns, frame);
        reports.push(budget.observe(5000.0, evaluate_ns));
        used.push((evaluate_ns + 5000.0) / limit);
        bounds.push(bound_px);
    }
    (reports, used, bounds)
}

#[test]
fn a_budget_is_kept_and_used() {
    for (share, ns) in [(3.0, 3.0), (1.0, 0.3), (0.7, 3.0), (0.3, 30.0)] {
        let (reports, used, bounds) = played(|at_cap, least| least + share * (at_cap - least), ns);
        let settled = &used[60..];
        let late = settled.iter().filter(|u| **u > 1.05).count();
        assert!(
            late * 20 <= settled.len(),
            "{share}: {late} of {}",
            settled.len()
        );
        let mean = settled.iter().sum::<f64>() / settled.len() as f64;
        assert!(
            mean > 0.8 || share > 1.0,
            "{share}: only {mean} of the budget is used"
        );
        // Nobody, near or far, is farther off than the tolerance.
        for (report, bound_px) in reports.iter().zip(&bounds) {
            assert!(
                *bound_px <= report.px * 1.001,
                "{share}: {bound_px} of {}",
                report.px
            );
        }
        let last = reports.last().unwrap();
        // Between the costs at the cap and at the cheapest, the cap cannot be kept.
        if share != 1.0 {
            assert_eq!(last.is_overloaded(), share < 1.0, "{share}");
        }
    }
}

#[test]
fn recorded_times_give_the_same_frames() {
    let one = played(|at_cap, least| 0.5 * (at_cap + least), 3.0);
    let again = played(|at_cap, least| 0.5 * (at_cap + least), 3.0);
    assert_eq!(one, again);
}

#[test]
fn too_little_is_announced_and_what_would_fit() {
    let (reports, used, _) = played(|at_cap, least| 0.5 * (at_cap + least), 3.0);
    let last = reports.last().unwrap();
    assert!(last.is_overloaded() && last.next_px > 1.0);
    assert!(used.last().unwrap() < &1.1);
    // Nothing is enough: everyone at the cheapest, and no number is lost.
    let (reports, ..) = played(|_, _| 0.0, 3.0);
    let last = reports.last().unwrap();
    assert!(last.is_overloaded() && last.next_px.is_finite());
    for odd in [f64::NAN, -1.0, 0.0, f64::INFINITY] {
        let mut two = Two::new();
        let mut budget = Budget::new(odd, f32::NAN);
        two.frame(budget.detail(), &mut budget);
        let report = budget.observe(odd, odd);
        assert_eq!((report.px, report.next_px), (1.0, 1.0));
        let report = budget.observe(5000.0, 9000.0);
        assert!(report.next_px > 0.0, "no crowd is no cost: {report:?}");
    }
}

#[test]
fn a_budgeted_frame_allocates_nothing() {
    let mut two = Two::new();
    let mut budget = Budget::new(50_000.0, 1.0);
    two.frame(budget.detail(), &mut budget);
    let counted = allocation_counter::measure(|| {
        for frame in 0..40 {
            let (_, work) = two.frame(budget.detail(), &mut budget);
            budget.observe(5000.0, measured(work, 3.0, frame));
        }
    });
    assert_eq!(counted.count_total, 0);
}
