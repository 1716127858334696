//! Tests of decisions: preferences, reasons, and the fall to another representation.

use super::*;

fn option(name: &str, bytes_once: u64, frame_ns: u64, error_px: f64) -> PartOption {
    let level = name.parse().unwrap_or(0);
    PartOption {
        name: format!("level {name}"),
        bytes_once,
        frame_ns,
        error_px,
        level,
        loa: Some(4 - level),
        regions: Some(0b111 >> level),
        ..Default::default()
    }
}

fn parts() -> [Part; 2] {
    let body = vec![
        option("0", 8000, 400_000, 0.2),
        option("1", 4000, 300_000, 1.0),
        option("2", 1000, 100_000, 5.0),
    ];
    let mesh = vec![
        option("0", 20_000, 900_000, 0.1),
        option("1", 6000, 300_000, 0.8),
        option("2", 2000, 100_000, 3.0),
    ];
    [
        Part::new("body", PartKind::BodyMotion, body),
        Part::new("mesh", PartKind::Mesh, mesh),
    ]
}

fn request(parts: &[Part], bytes: u64, frame_ns: u64) -> DecisionRequest<'_> {
    DecisionRequest {
        parts,
        parts_need: &[],
        choice: ChoiceRequest {
            budget: Budget {
                bytes,
                frame_ns,
                memory_bytes: Budget::UNBOUNDED,
            },
            window_secs: 1.0,
            pixels_per_metre: 100.0,
            enough_px: 0.0,
            effort: ChoiceRequest::EFFORT,
        },
        preferences: &[],
        representations: &[],
        capabilities: &[],
        modality: None,
        device: None,
    }
}

fn preference(rule: Rule, is_wish: bool) -> Preference {
    Preference {
        part: PartKind::BodyMotion,
        rule,
        source: LimitSource::User,
        is_wish,
    }
}

fn levels(decision: &Decision) -> Vec<usize> {
    decision.parts.iter().map(|p| p.option).collect()
}

#[test]
fn a_decision_says_what_bound_it_and_what_comes_next() {
    let parts = parts();
    let decision = decide(&request(&parts, 10_500, 10_000_000)).unwrap();
    assert_eq!(levels(&decision), [1, 1]);
    assert_eq!(decision.bounds, [Bound::Bytes]);
    let next = decision.parts[1].next.as_ref().unwrap();
    assert_eq!((next.option, next.more_bytes), (0, 14_000));
    assert!((next.gain_px - 0.7).abs() < 1e-12);
    assert_eq!(next.bounds, [Bound::Bytes]);
    let text = decision.to_string();
    for line in [
        "allowed: 10500 bytes for 1 s, 10.000 ms per frame, at 100.0 pixels per metre",
        "chosen: 3D, 10000 bytes, 0.600 ms per frame, error at most 1.80 px",
        "limited by: the bytes",
        "mesh: level 1, 6000 bytes, 0.300 ms, 0.80 px; next level 0: +14000 bytes, +0.600 ms, \
         0.70 px less, prevented by the bytes",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let slow = decide(&request(&parts, 1 << 30, 550_000)).unwrap();
    assert_eq!(slow.bounds, [Bound::FrameTime]);
    let ample = decide(&request(&parts, 1 << 30, 1 << 30)).unwrap();
    assert_eq!((levels(&ample), ample.bounds.len()), (vec![0, 0], 0));
    assert!(ample.parts[0].next.is_none());
    let mut far = request(&parts, 1 << 30, 1 << 30);
    far.choice.enough_px = 2.0;
    let far = decide(&far).unwrap();
    assert_eq!((levels(&far), far.bounds), (vec![1, 1], vec![Bound::View]));
}

#[test]
fn a_slower_device_gets_what_it_bears_and_is_told_so() {
    let parts = parts();
    let with = |score, frame_ns| {
        decide(&DecisionRequest {
            device: Some(DeviceBenchmark {
                reference_fps: 50.0,
                wanted_fps: 25.0,
                reference_score: 90.0,
                device_score: score,
                share: 1.0,
            }),
            ..request(&parts, 1 << 30, frame_ns)
        })
        .unwrap()
    };
    // The finest of both parts take 1.3 ms. A device three times slower bears two thirds of it at half
    // of the rate: 866,666 ns.
    let third = with(30.0, Budget::UNBOUNDED);
    assert_eq!(third.request.budget.frame_ns, 866_666);
    assert_eq!(
        (levels(&third), &*third.bounds),
        (vec![0, 1], &[Bound::Device][..])
    );
    assert_eq!(
        third.parts[1].next.as_ref().unwrap().bounds,
        [Bound::Device]
    );
    let text = third.to_string();
    for line in [
        "0.867 ms per frame, 66.7 % of that of everything, by the device, at",
        "limited by: the device\n",
        "prevented by the device\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
    // A time per frame that is less counts.
    let slow = with(30.0, 250_000);
    assert_eq!(
        (slow.bounds, slow.device_ratio),
        (vec![Bound::FrameTime], None)
    );
    // From a ratio of 1 on, nothing is adapted: 45 is half as fast, at half of the rate.
    let half = with(45.0, Budget::UNBOUNDED);
    assert_eq!((levels(&half), half.device_ratio), (vec![0, 0], None));
    // Below the coarsest levels there is no 3D.
    let phone = with(5.0, Budget::UNBOUNDED);
    assert_eq!(
        (phone.outcome, phone.bounds),
        (Outcome::Nothing, vec![Bound::Device])
    );
}

#[test]
fn what_limits_is_what_prevents_the_next_steps() {
    let mut dice = articula_mutate::Dice::new(44);
    for case in 0..2000 {
        let mut parts = parts();
        for part in &mut parts {
            part.weight = [0.0, 1.0, 1.0, 2.0][dice.roll(4)];
            for option in &mut part.options {
                option.memory_bytes = dice.roll(5000) as u64;
            }
        }
        let (bytes, ns) = (dice.roll(30_000) as u64, dice.roll(1_500_000) as u64);
        let preferences = [preference(Rule::FinestLevel(dice.roll(3) as u32), false)];
        let mut of = request(&parts, bytes, ns);
        of.preferences = &preferences[..dice.roll(2)];
        of.choice.enough_px = [0.0, 2.0, 8.0][dice.roll(3)];
        of.choice.budget.memory_bytes = [Budget::UNBOUNDED, 4000][dice.roll(2)];
        let decision = decide(&of).unwrap();
        for part in &decision.parts {
            for bound in part.next.iter().flat_map(|next| &next.bounds) {
                assert!(decision.bounds.contains(bound), "{case}: {decision}");
            }
        }
        // At the least error there is no next step.
        let has_next = decision.parts.iter().any(|part| part.next.is_some());
        let is_3d = matches!(decision.outcome, Outcome::Parts(_));
        assert!(
            !is_3d || has_next != decision.bounds.is_empty(),
            "{case}: {decision}"
        );
        if is_3d {
            continue;
        }
        // The least bytes are enough, and one fewer is not.
        let Some(least) = decision.least_bytes else {
            of.choice.budget.bytes = Budget::UNBOUNDED;
            assert_eq!(decide(&of).unwrap().outcome, Outcome::Nothing, "{case}");
            continue;
        };
        assert!(least > bytes, "{case}: {decision}");
        of.choice.budget.bytes = least;
        assert_ne!(decide(&of).unwrap().outcome, Outcome::Nothing, "{case}");
        if of.choice.budget.memory_bytes < Budget::UNBOUNDED {
            // Memory is kept without a proof of the least.
            continue;
        }
        of.choice.budget.bytes = least - 1;
        assert_eq!(decide(&of).unwrap().outcome, Outcome::Nothing, "{case}");
    }
}

#[test]
fn limits_hold_and_wishes_give_way() {
    let parts = parts();
    let preferences = [
        preference(Rule::FinestLevel(1), false),
        preference(Rule::CoarsestLevel(0), true),
    ];
    let mut ample = request(&parts, 1 << 30, 1 << 30);
    ample.preferences = &preferences;
    let decision = decide(&ample).unwrap();
    assert_eq!(levels(&decision), [1, 0]);
    assert_eq!(
        decision.unmet,
        preferences[1..],
        "the wish would break the limit"
    );
    assert_eq!(decision.bounds, [Bound::Preference(preferences[0])]);

    // The body is wanted fine: it takes what the mesh would gain more by.
    let preferences = [preference(Rule::LoaAtLeast(4), true)];
    let mut little = request(&parts, 10_500, 1 << 30);
    little.preferences = &preferences;
    let decision = decide(&little).unwrap();
    assert_eq!((levels(&decision), decision.unmet.len()), (vec![0, 2], 0));
    // With less, it gives way.
    little.choice.budget.bytes = 9000;
    let decision = decide(&little).unwrap();
    assert_eq!(
        (levels(&decision), decision.unmet),
        (vec![1, 2], preferences.to_vec())
    );

    let preferences = [preference(Rule::RegionsWithin(0b011), false)];
    let mut regions = request(&parts, 1 << 30, 1 << 30);
    regions.preferences = &preferences;
    assert_eq!(levels(&decide(&regions).unwrap()), [1, 0]);
    // A limit that no option meets is reported, not obeyed.
    let preferences = [preference(Rule::LoaAtMost(1), false)];
    regions.preferences = &preferences;
    let decision = decide(&regions).unwrap();
    assert_eq!(
        (levels(&decision), decision.unmet),
        (vec![0, 0], preferences.to_vec())
    );
}

#[test]
fn below_the_lowest_level_the_modality_falls_to_2d() {
    let parts = parts();
    let form = |modality: &str, bytes, error_px, needs: &[&str]| Representation {
        modality: modality.into(),
        bytes,
        error_px,
        needs: needs.iter().map(|n| (*n).to_owned()).collect(),
    };
    let forms = [
        form("vector/smil", 2500, 3.0, &["svg"]),
        form("portrait", 1500, 6.0, &["canvas"]),
        form("vector/still", 300, 20.0, &["svg"]),
    ];
    let client = ["svg".to_owned(), "webgl".to_owned()];
    let need = ["webgl".to_owned()];
    let mut of = request(&parts, 2900, 1 << 30);
    (of.parts_need, of.representations, of.capabilities) = (&need, &forms, &client);
    let decision = decide(&of).unwrap();
    assert_eq!(decision.outcome, Outcome::Representation(0));
    assert_eq!(decision.bounds, [Bound::Bytes]);
    assert!(decision.to_string().contains("not 3D because of the bytes"));
    of.choice.budget.bytes = 3000;
    assert_eq!(decide(&of).unwrap().modality, "3d");
    of.choice.budget.bytes = 2000;
    assert_eq!(
        decide(&of).unwrap().outcome,
        Outcome::Representation(2),
        "no canvas"
    );
    of.choice.budget.bytes = 200;
    assert_eq!(decide(&of).unwrap().outcome, Outcome::Nothing);
    // The time per frame may be too short, too, or the client without 3D.
    of.choice.budget = Budget {
        bytes: 1 << 30,
        frame_ns: 150_000,
        memory_bytes: Budget::UNBOUNDED,
    };
    assert_eq!(decide(&of).unwrap().bounds, [Bound::FrameTime]);
    of.choice.budget.frame_ns = 1 << 30;
    of.capabilities = &client[..1];
    assert_eq!(decide(&of).unwrap().bounds, [Bound::Capability]);
    // Asked for, it is taken although 3D would fit.
    of.capabilities = &client;
    of.modality = Some("vector");
    assert_eq!(decide(&of).unwrap().outcome, Outcome::Representation(0));
    of.modality = Some("portrait");
    assert_eq!(decide(&of).unwrap().modality, "3d", "no canvas");
}
