//! The joint choice against all combinations, against its bound and against simpler choices.

use super::*;
use crate::decide::part::{PartKind, PartOption};
use articula_mutate::Dice;
use proptest::prelude::*;

fn unit(dice: &mut Dice) -> f64 {
    dice.roll(1 << 30) as f64 / f64::from(1 << 30)
}

/// A part whose error falls with its bytes, as curves of streams and meshes do: a power law with
/// noise, so that some options lie off the hull; `chain`: what is finer also takes longer.
fn part(kind: PartKind, options: usize, chain: bool, dice: &mut Dice) -> Part {
    let mut bytes = 200.0 + 3000.0 * unit(dice);
    let mut error_m = 0.01 + 0.2 * unit(dice);
    let mut ns = 1000.0 + 50_000.0 * unit(dice);
    let exponent = 0.4 + 1.2 * unit(dice);
    let all = (0..options).map(|i| {
        let option = PartOption {
            name: format!("option {i}"),
            bytes_once: if kind == PartKind::Mesh {
                bytes as u64
            } else {
                0
            },
            bytes_per_second: if kind == PartKind::Mesh { 0.0 } else { bytes },
            frame_ns: ns as u64,
            error_m,
            ..Default::default()
        };
        let grow = 1.05 + 1.5 * unit(dice) * (8.0 / options as f64).min(1.0);
        bytes *= grow;
        error_m *= grow.powf(-exponent) * (0.6 + 0.6 * unit(dice)).min(1.0);
        ns *= if chain {
            1.0 + 0.6 * unit(dice)
        } else {
            0.7 + 0.8 * unit(dice)
        };
        option
    });
    Part::new(format!("{kind:?}"), kind, all.collect())
}

const KINDS: [PartKind; 5] = [
    PartKind::BodyMotion,
    PartKind::FaceMotion,
    PartKind::Mesh,
    PartKind::Texture,
    PartKind::Other,
];

/// Parts and a request whose budgets lie between the cheapest and the finest options.
fn case(counts: &[usize], chain: bool, seed: u64) -> (Vec<Part>, ChoiceRequest) {
    let mut dice = Dice::new(seed);
    let of = |(i, count): (usize, &usize)| part(KINDS[i % 5], *count, chain, &mut dice);
    let parts: Vec<Part> = counts.iter().enumerate().map(of).collect();
    let sum = |of: &dyn Fn(&Part) -> u64| -> u64 { parts.iter().map(of).sum() };
    let window_secs = 2.0;
    let bytes = |p: &Part| {
        p.options
            .iter()
            .map(|o| o.bytes(window_secs, 0))
            .collect::<Vec<_>>()
    };
    let times = |p: &Part| p.options.iter().map(|o| o.frame_ns).collect::<Vec<_>>();
    let least = |all: Vec<u64>| all.into_iter().min().unwrap_or(0);
    let most = |all: Vec<u64>| all.into_iter().max().unwrap_or(0);
    let mut between = |least: u64, most: u64, from: f64| {
        least + ((most - least) as f64 * (from + (1.0 - from) * unit(&mut dice)).powi(2)) as u64
    };
    let request = ChoiceRequest {
        budget: Budget {
            bytes: between(sum(&|p| least(bytes(p))), sum(&|p| most(bytes(p))), 0.0),
            frame_ns: between(sum(&|p| least(times(p))), sum(&|p| most(times(p))), 0.1),
            memory_bytes: Budget::UNBOUNDED,
        },
        window_secs,
        pixels_per_metre: 100.0,
        enough_px: 0.0,
        effort: ChoiceRequest::EFFORT,
    };
    (parts, request)
}

fn problem_of(parts: &[Part], request: &ChoiceRequest) -> Option<Problem> {
    let all = |part: &Part| (0..part.options.len()).collect();
    let allowed: Vec<Vec<usize>> = parts.iter().map(all).collect();
    let items = items(parts, &allowed, request);
    let items = items
        .iter()
        .map(|part| part.iter().map(Costed::by_error).collect());
    Problem::new(items, [request.budget.bytes, request.budget.frame_ns])
}

#[test]
fn a_choice_by_hand() {
    // Bytes 10; per byte the first upgrade of a drops 4 px, that of b 3, the second of a 1.
    let option = |bytes_once, error_px| PartOption {
        bytes_once,
        error_px,
        ..Default::default()
    };
    let a = vec![option(1, 20.0), option(3, 12.0), option(8, 7.0)];
    let b = vec![option(2, 10.0), option(4, 4.0)];
    let parts = [
        Part::new("a", PartKind::BodyMotion, a),
        Part::new("b", PartKind::Mesh, b),
    ];
    let of = |bytes: u64| {
        let request = ChoiceRequest {
            budget: Budget {
                bytes,
                frame_ns: 0,
                memory_bytes: Budget::UNBOUNDED,
            },
            window_secs: 1.0,
            pixels_per_metre: 1.0,
            enough_px: 0.0,
            effort: ChoiceRequest::EFFORT,
        };
        let choice = choose(&parts, &request).unwrap();
        choice.map(|c| (c.options, c.error_px, c.bytes))
    };
    assert_eq!(of(2), None);
    assert_eq!(of(3), Some((vec![0, 0], 30.0, 3)));
    assert_eq!(of(5), Some((vec![1, 0], 22.0, 5)));
    assert_eq!(of(7), Some((vec![1, 1], 16.0, 7)));
    // Not the greedy order: with 10 or 11 bytes, a's last upgrade fits only without b's.
    assert_eq!(of(11), Some((vec![1, 1], 16.0, 7)));
    assert_eq!(of(12), Some((vec![2, 1], 11.0, 12)));
}

#[test]
fn the_best_of_all_combinations_is_found() {
    let mut cases = 0;
    for seed in 0..3000 {
        let mut dice = Dice::new(seed);
        let counts: Vec<usize> = (0..2 + dice.roll(4)).map(|_| 1 + dice.roll(7)).collect();
        let (parts, request) = case(&counts, seed % 3 != 0, seed);
        let found = choose(&parts, &request).unwrap();
        let best = choose_exhaustively(&parts, &request, 1 << 20).unwrap();
        assert_eq!(found.is_some(), best.is_some(), "seed {seed}");
        let (Some(found), Some(best)) = (found, best) else {
            continue;
        };
        cases += 1;
        assert!(found.bytes <= request.budget.bytes && found.frame_ns <= request.budget.frame_ns);
        let excess = found.error_px / best.error_px - 1.0;
        assert!(excess.abs() < 1e-8, "seed {seed}: {excess}");
        assert_eq!(found.bound_px, found.error_px, "seed {seed}");
    }
    assert!(cases > 2500, "{cases}");
}

#[test]
fn greedy_and_polish_alone_are_within_two_percent_in_most_cases() {
    let (mut cases, mut of_greedy, mut of_polish) = (0, 0, 0);
    for seed in 0..1500 {
        let (parts, request) = case(&[6, 5, 5, 4], true, seed);
        let Some(problem) = problem_of(&parts, &request) else {
            continue;
        };
        let best = choose_exhaustively(&parts, &request, 1 << 20)
            .unwrap()
            .unwrap();
        let dual = dual::dual(&problem);
        let (picks, _) = greedy::greedy(&problem, dual.price);
        let sums = problem.sums(&picks);
        assert!(
            problem.fits(sums.cost),
            "seed {seed}: a chain starts within the budget"
        );
        let polished = problem.sums(&polish::polish(&problem, picks));
        let near = |error: f64| usize::from(error <= 1.02 * best.error_px);
        cases += 1;
        of_greedy += near(sums.error);
        of_polish += near(polished.error);
    }
    // Measured 82 and 96 %.
    println!("{cases} cases, within 2 %: greedy {of_greedy}, polished {of_polish}");
    assert!(of_polish * 10 > cases * 9, "{of_polish} of {cases}");
    assert!(of_greedy < of_polish);
}

#[test]
fn never_worse_than_cutting_one_part_or_all_alike() {
    let (mut met, mut better, mut by_greedy) = (0, 0, 0);
    for seed in 0..2000 {
        let (parts, request) = case(&[8, 5, 6, 4], true, seed);
        let choice = choose(&parts, &request).unwrap();
        let mut others: Vec<Choice> = (0..parts.len())
            .filter_map(|p| cut_one(&parts, &request, p).unwrap())
            .collect();
        others.extend(cut_equally(&parts, &request).unwrap());
        let quick = ChoiceRequest {
            effort: 0,
            ..request
        };
        let quick = choose(&parts, &quick).unwrap();
        for other in others {
            let choice = choice.as_ref().unwrap();
            met += 1;
            assert!(
                choice.error_px <= other.error_px * (1.0 + 1e-9),
                "seed {seed}"
            );
            better += usize::from(choice.error_px < other.error_px * 0.999);
            by_greedy +=
                usize::from(quick.as_ref().unwrap().error_px <= other.error_px * (1.0 + 1e-9));
        }
    }
    println!(
        "{met} simpler choices met the budget; {better} beaten; {by_greedy} met without search"
    );
    assert!(met > 500 && better * 10 > met * 8);
}

#[test]
fn forty_options_of_eight_parts_are_proved_within_a_percent() {
    for seed in 0..12 {
        let (parts, request) = case(&[40; 8], seed % 2 == 0, seed);
        let choice = choose(&parts, &request).unwrap().unwrap();
        let gap = choice.error_px / choice.bound_px - 1.0;
        assert!(gap < 0.01, "seed {seed}: {gap}");
        assert_eq!(choose(&parts, &request).unwrap().unwrap(), choice);
    }
}

#[test]
fn memory_is_kept_where_any_choice_keeps_it() {
    let mut dice = Dice::new(7);
    let (mut found, mut ratios) = (0, Vec::new());
    for seed in 0..300 {
        let (mut parts, mut request) = case(&[4, 5, 3], true, seed);
        for part in &mut parts {
            // Memory rises with the quality, as that of textures does, or not.
            let rises = dice.roll(3) > 0;
            for (i, option) in part.options.iter_mut().enumerate() {
                let base = if rises { 100 << i } else { 500 };
                option.memory_bytes = base + dice.roll(300) as u64;
            }
        }
        request.budget.memory_bytes = 500 + dice.roll(3000) as u64;
        let best = choose_exhaustively(&parts, &request, 100).unwrap();
        let choice = choose(&parts, &request).unwrap();
        if let Some(choice) = &choice {
            assert!(choice.fits(&request.budget), "{seed}: {choice:?}");
        }
        let (Some(best), Some(choice)) = (best, choice) else {
            continue;
        };
        found += 1;
        assert!(choice.bound_px <= best.error_px * (1.0 + 1e-9), "{seed}");
        ratios.push(choice.error_px / best.error_px);
    }
    assert!(found > 100, "{found}");
    let close = ratios.iter().filter(|ratio| **ratio < 1.0 + 1e-9).count();
    assert!(close * 10 > found * 8, "{close} of {found} are the best");
}

#[test]
fn what_is_not_seen_saves_bytes() {
    for seed in 0..400 {
        let (parts, request) = case(&[6, 5, 4], seed % 2 == 0, seed);
        let Some(best) = choose(&parts, &request).unwrap() else {
            continue;
        };
        let enough = ChoiceRequest {
            enough_px: 1.5 * best.error_px,
            ..request
        };
        let cheap = choose(&parts, &enough).unwrap().unwrap();
        let oracle = choose_exhaustively(&parts, &enough, 1 << 20)
            .unwrap()
            .unwrap();
        assert!(cheap.is_enough && cheap.error_px <= enough.enough_px);
        assert_eq!(cheap.bytes, oracle.bytes, "seed {seed}");
        assert!(cheap.bytes <= best.bytes);
        let far = ChoiceRequest {
            enough_px: 0.5 * best.error_px,
            ..request
        };
        assert_eq!(
            choose(&parts, &far).unwrap().unwrap().error_px,
            best.error_px
        );
    }
}

proptest! {
    /// The proof of `docs/methods/adaptation.md` part 3.
    #[test]
    fn greedy_is_within_its_steps_of_the_linear_relaxation(
        seed: u64,
        counts in prop::collection::vec(1_usize..12, 1..7),
        ample in any::<bool>(),
    ) {
        let (parts, mut request) = case(&counts, true, seed);
        if ample {
            request.budget.frame_ns = MOST;
        }
        let problem = problem_of(&parts, &request).unwrap();
        let dual = dual::dual(&problem);
        let (picks, largest) = greedy::greedy(&problem, dual.price);
        let sums = problem.sums(&picks);
        prop_assert!(problem.fits(sums.cost));
        let both = dual.price.iter().all(|p| *p > 0.0);
        let steps = if both { 2.0 } else { 1.0 };
        prop_assert!(!(ample && both));
        let most = dual.bound + steps * largest;
        // Prices end at a million times the errors, where budgets are all but spent by the start.
        prop_assert!(sums.error <= most * (1.0 + 1e-6), "{} {}", sums.error, most);
        // Every choice is above the bound, so the best is.
        let best = choose(&parts, &request).unwrap().unwrap();
        prop_assert!(best.error_px >= dual.bound * (1.0 - 1e-9));
    }

    #[test]
    fn more_budget_is_never_worse_and_none_is_exceeded(
        seed: u64,
        counts in prop::collection::vec(1_usize..9, 1..6),
        chain in any::<bool>(),
        more in 1.0_f64..3.0,
    ) {
        let (parts, request) = case(&counts, chain, seed);
        let mut wide = request;
        wide.budget.bytes = (wide.budget.bytes as f64 * more) as u64;
        wide.budget.frame_ns = (wide.budget.frame_ns as f64 * more) as u64;
        let narrow = choose(&parts, &request).unwrap();
        let wide_choice = choose(&parts, &wide).unwrap();
        if let Some(narrow) = narrow {
            prop_assert!(narrow.bytes <= request.budget.bytes);
            prop_assert!(narrow.frame_ns <= request.budget.frame_ns);
            let wide = wide_choice.unwrap();
            prop_assert!(wide.error_px <= narrow.error_px * (1.0 + 1e-8));
        }
    }
}
