//! Cost of allocating a budget to a crowd: from scratch, with some changes, without changes.
#![allow(clippy::unwrap_used, reason = "a bench may stop at the first surprise")]

use articula_core::budget::{BudgetAllocator, BudgetPolicy, LodOption, LodRequest};
use divan::Bencher;

const COUNT: usize = 10_000;
/// Mean units per character; the finest options would cost 182.
const UNITS: f32 = 100.0;

fn main() {
    divan::main();
}

/// Random numbers from 0 to 1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }
}

/// Twenty option sets of eight levels, characters at distances from 5 to 245 m.
fn crowd() -> (BudgetAllocator, Vec<LodRequest>, Random) {
    let mut random = Random(7);
    let mut budget = BudgetAllocator::new(COUNT, BudgetPolicy::default());
    let mut option_set = || {
        let off = 0.15 + 0.3 * random.next();
        let lod_option = |joints: f32| LodOption {
            cost: 0.7 + 2.7 * joints,
            error_metres: off * (-0.09 * joints).exp(),
        };
        let joints = [4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 67.0];
        budget.add_options(&joints.map(lod_option)).unwrap()
    };
    let option_sets: Vec<_> = (0..20).map(|_| option_set()).collect();
    let requests = (0..COUNT).map(|c| {
        let pixels_per_metre = scale(&mut random);
        LodRequest {
            option_set: option_sets[c % option_sets.len()],
            weight: pixels_per_metre.powi(3),
            pixels_per_metre,
        }
    });
    let requests: Vec<LodRequest> = requests.collect();
    ask(&mut budget, &requests);
    budget.solve(UNITS * COUNT as f32);
    (budget, requests, random)
}

/// Pixels per metre at a random distance, for 1080 rows of pixels.
fn scale(random: &mut Random) -> f32 {
    1304.0 / (5.0 + 240.0 * random.next())
}

fn ask(budget: &mut BudgetAllocator, requests: &[LodRequest]) {
    for (character, request) in requests.iter().enumerate() {
        budget.request(character, *request);
    }
}

/// All choices from scratch.
#[divan::bench]
fn anew(bencher: Bencher<'_, '_>) {
    let (mut budget, ..) = crowd();
    bencher.bench_local(|| {
        budget.set_policy(BudgetPolicy::default());
        budget.solve(UNITS * COUNT as f32)
    });
}

/// Requests of all characters, 2 % of them changed, and the repair.
#[divan::bench]
fn some_changed(bencher: Bencher<'_, '_>) {
    let (mut budget, mut requests, mut random) = crowd();
    bencher.bench_local(|| {
        for _ in 0..COUNT / 50 {
            let character = (random.next() * COUNT as f32) as usize;
            let pixels_per_metre = scale(&mut random);
            requests[character].pixels_per_metre = pixels_per_metre;
            requests[character].weight = pixels_per_metre.powi(3);
        }
        ask(&mut budget, &requests);
        budget.solve(UNITS * COUNT as f32)
    });
}

/// Requests of all characters, none changed.
#[divan::bench]
fn nobody_changed(bencher: Bencher<'_, '_>) {
    let (mut budget, requests, _) = crowd();
    bencher.bench_local(|| {
        ask(&mut budget, &requests);
        budget.solve(UNITS * COUNT as f32)
    });
}
