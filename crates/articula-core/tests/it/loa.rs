//! Acceptance test 1 of `docs/methods/motion-lod.md` part 10: masks of levels of articulation on the
//! standard's own 89 joints.

use articula_core::hanim_table::JOINTS;
use articula_core::loa::{self, LoaExpression, Rule, Selection};
use articula_core::source::{Joint, Skeleton};
use articula_core::{
    Articulation, Complexity, JointArticulation, JointSet, Region, Rig, Transform, Zone,
};
use proptest::prelude::*;

/// The 89 body joints of the standard, and below the left wrist a bracelet without H-Anim name.
fn standard() -> Rig {
    let body: Vec<_> = JOINTS.iter().take(89).collect();
    let mut joints: Vec<Joint> = body
        .iter()
        .map(|j| Joint {
            name: j.name.to_owned(),
            parent: j.parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        })
        .collect();
    let mut entries: Vec<JointArticulation> = body
        .iter()
        .map(|j| JointArticulation {
            hanim: Some(j.name.to_owned()),
            level: j.level,
            region: j.region,
        })
        .collect();
    // As assigned to an unknown joint by the matcher: the region of its parent and the next level.
    let wrist = body.iter().position(|j| j.name == "l_wrist").unwrap();
    joints.push(Joint {
        name: "bracelet".into(),
        parent: Some(wrist),
        ..joints[wrist].clone()
    });
    entries.push(JointArticulation {
        hanim: None,
        level: entries[wrist].level + 1,
        region: entries[wrist].region,
    });
    let articulation = Articulation {
        profile: "H-Anim".into(),
        joints: entries,
    };
    Rig::new(&Skeleton { joints }, articulation).unwrap()
}

fn joints(text: &str) -> JointSet {
    text.parse::<LoaExpression>()
        .unwrap()
        .joints(&standard())
        .unwrap()
}

#[test]
fn complexity_is_nested_and_has_the_published_counts() {
    let body = JointSet::first(89);
    let counts: Vec<usize> = Complexity::ALL
        .iter()
        .map(|c| loa::complexity(&standard(), *c).intersection(&body).len())
        .collect();
    assert_eq!(counts, [0, 5, 10, 24, 35, 51, 89]);
    for pair in Complexity::ALL.windows(2) {
        let [less, more] = [pair[0], pair[1]].map(|c| loa::complexity(&standard(), c));
        assert!(less.difference(&more).is_empty());
    }
}

/// Table 3.1 of the thesis, and the lists of `docs/methods/hanim.md` part 2.
#[test]
fn official_levels_are_nested_and_have_the_printed_lists() {
    let rig = standard();
    let body = JointSet::first(89);
    let level = |l: u8| joints(&format!("hanim({l})")).intersection(&body);
    assert_eq!([0, 1, 2, 3].map(|l| level(l).len()), [1, 18, 71, 89]);
    for l in 1..4 {
        assert!(level(l - 1).difference(&level(l)).is_empty());
    }
    let names = |set: JointSet| -> Vec<&str> { set.iter().map(|j| rig.name(j)).collect() };
    let sorted = |mut names: Vec<&'static str>| {
        names.sort_unstable();
        names
    };
    let both = |list: &[&'static str]| -> Vec<&'static str> {
        let of = |side: &str| -> Vec<&'static str> {
            let named = |name: &&str| JOINTS.iter().find(|j| j.name == format!("{side}_{name}"));
            list.iter().map(|n| named(n).unwrap().name).collect()
        };
        [of("l"), of("r")].concat()
    };
    assert_eq!(names(level(0)), ["humanoid_root"]);
    let limbs = [
        "hip",
        "knee",
        "ankle",
        "midtarsal",
        "shoulder",
        "elbow",
        "wrist",
    ];
    let first = [
        both(&limbs),
        vec!["humanoid_root", "sacroiliac", "vl5", "skullbase"],
    ]
    .concat();
    let mut found = names(level(1));
    found.sort_unstable();
    assert_eq!(found, sorted(first));
    let added = level(2).difference(&level(1));
    let fingers = |j: usize| rig.articulation().joints[j].region == Region::Hands;
    assert_eq!(added.iter().filter(|j| fingers(*j)).count(), 38);
    let limbs = [
        "subtalar",
        "metatarsal",
        "sternoclavicular",
        "acromioclavicular",
    ];
    let spine = vec!["vl3", "vl1", "vt10", "vt6", "vt1", "vc4", "vc2"];
    let mut found: Vec<&str> = added
        .iter()
        .filter(|j| !fingers(*j))
        .map(|j| rig.name(j))
        .collect();
    found.sort_unstable();
    assert_eq!(found, sorted([both(&limbs), spine].concat()));
    // The extended level 2 is official level 1 with toes and both collars.
    let medium = joints("loa(Medium)").intersection(&body);
    let toes_and_collars = ["metatarsal", "sternoclavicular", "acromioclavicular"];
    let mut more: Vec<&str> = medium
        .difference(&level(1))
        .iter()
        .map(|j| rig.name(j))
        .collect();
    more.sort_unstable();
    assert_eq!(more, sorted(both(&toes_and_collars)));
}

#[test]
fn joints_that_the_standard_does_not_name_have_an_official_level_too() {
    let rig = standard();
    // The wrist is of level 1, so the bracelet on it of level 2.
    let bracelet = rig.len() - 1;
    assert!(!loa::hanim(&rig, 1).contains(bracelet));
    assert!(loa::hanim(&rig, 2).contains(bracelet));

    // armature > (root > spine > strap), prop: root and spine have names.
    let joint = |parent| Joint {
        name: String::new(),
        parent,
        rest: Transform::IDENTITY,
        in_skin: true,
    };
    let parents = [None, Some(0), Some(1), Some(2), Some(0)];
    let skeleton = Skeleton {
        joints: parents.map(joint).to_vec(),
    };
    let rig_of = |names: [Option<&str>; 5]| {
        let entry = |name: Option<&str>| JointArticulation {
            hanim: name.map(str::to_owned),
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: names.map(entry).to_vec(),
        };
        Rig::new(&skeleton, articulation).unwrap()
    };
    let levels = |rig: &Rig| -> Vec<u8> {
        let least = |j| (0..4).find(|l| loa::hanim(rig, *l).contains(j)).unwrap();
        (0..rig.len()).map(least).collect()
    };
    let human = rig_of([None, Some("humanoid_root"), Some("vl5"), None, None]);
    assert_eq!(levels(&human), [0, 0, 1, 2, 3]);
    assert_eq!(levels(&rig_of([None; 5])), [0, 1, 2, 3, 1], "depths");
}

#[test]
fn regions_partition_the_joints() {
    let rig = standard();
    let sets: Vec<JointSet> = Region::ALL
        .iter()
        .map(|r| loa::zone(&rig, (*r).into()))
        .collect();
    assert_eq!(sets.iter().map(JointSet::len).sum::<usize>(), rig.len());
    assert_eq!(
        sets.iter().fold(JointSet::EMPTY, |a, b| a.union(b)),
        rig.all()
    );
    // The counts of `docs/methods/hanim.md` part 4 at level 5; the arms include the bracelet.
    assert_eq!(
        sets.iter().map(JointSet::len).collect::<Vec<_>>(),
        [2, 11, 25, 4, 4, 6, 38]
    );
}

#[test]
fn depth_counts_joints_from_the_root() {
    assert!(joints("depth(0)").is_empty());
    assert_eq!(joints("depth(1)").iter().collect::<Vec<_>>(), [0]);
    assert_eq!(joints("depth(2)").len(), 3, "root, sacroiliac, vl5");
    assert_eq!(joints("depth(1000)"), standard().all());
}

#[test]
fn a_close_up_takes_every_ancestor_along() {
    let rig = standard();
    let wrist = joints("joint(l_wrist)");
    let whole = loa::with_ancestors(&rig, &wrist);
    let above = |joint: usize| rig.is_at_or_below(wrist.iter().next().unwrap(), joint);
    assert_eq!(whole, (0..rig.len()).filter(|j| above(*j)).collect());
    assert!(whole.contains(rig.root()) && whole.len() > 10);
}

#[test]
fn an_unknown_joint_drops_one_level_before_its_parent() {
    let rig = standard();
    let bracelet = rig.find("bracelet").unwrap();
    assert!(
        !joints("loa(Medium)").contains(bracelet)
            && joints("loa(Medium) & joint(l_wrist)").len() == 1
    );
    assert!(joints("loa(High)").contains(bracelet));
    assert!(joints("zone(arms)").contains(bracelet));
}

#[test]
fn the_sample_of_annex_e() {
    // depth 3, complexity none, zones torso and legs, added together.
    let sample = Selection {
        rule: Rule::Sum,
        depth: Some(3),
        complexity: Some(Complexity::None),
        zone: Some(Zone::from(Region::Torso) | Region::Legs.into()),
        ..Selection::default()
    };
    let expected = joints("depth(3) + loa(None) + zone(torso|legs)");
    assert_eq!(sample.joints(&standard()).unwrap(), expected);
    // By hand: depth 3 is root, sacroiliac, vl5, both hips and vl4; the torso has 25 joints, of
    // which vl5 and vl4 are already counted; the legs have 4.
    assert_eq!(expected.len(), 6 + 23 + 4);
}

#[test]
fn absent_selectors_are_neutral_and_empty_ones_are_not() {
    let rig = standard();
    assert_eq!(Selection::default().joints(&rig).unwrap(), rig.all());
    let nothing = Selection {
        complexity: Some(Complexity::None),
        ..Selection::default()
    };
    assert!(nothing.joints(&rig).unwrap().is_empty());
    let restricted = Selection {
        rule: Rule::Restrict,
        ..nothing
    };
    assert!(restricted.joints(&rig).unwrap().is_empty());
    let unknown = Selection {
        plus: vec!["tail".into()],
        ..Selection::default()
    };
    assert!(
        unknown
            .joints(&rig)
            .unwrap_err()
            .to_string()
            .contains("tail")
    );
}

fn any_selection() -> impl Strategy<Value = Selection> {
    let names = || {
        prop::collection::vec(
            prop::sample::select(vec!["l_hip", "r_wrist", "vt6", "bracelet"]),
            0..3,
        )
    };
    (
        prop::option::of(0u32..20),
        prop::option::of(prop::sample::select(Complexity::ALL.to_vec())),
        prop::option::of(0u8..=loa::MAX_HANIM_LEVEL),
        prop::option::of(prop::sample::select(Region::ALL.to_vec())),
        names(),
        names(),
    )
        .prop_map(
            |(depth, complexity, hanim, region, plus, minus)| Selection {
                rule: Rule::Sum,
                depth,
                complexity,
                hanim,
                zone: region.map(Zone::from),
                plus: plus.into_iter().map(str::to_owned).collect(),
                minus: minus.into_iter().map(str::to_owned).collect(),
            },
        )
}

proptest! {
    #[test]
    fn laws_of_both_rules(selection in any_selection()) {
        let rig = standard();
        let sum = selection.joints(&rig).unwrap();
        let restrict = Selection { rule: Rule::Restrict, ..selection.clone() }.joints(&rig).unwrap();
        for name in &selection.minus {
            let joint = loa::joint(&rig, name).unwrap();
            prop_assert!(!sum.contains(joint) && !restrict.contains(joint), "minus always wins");
        }
        for name in selection.plus.iter().filter(|n| !selection.minus.contains(n)) {
            let joint = loa::joint(&rig, name).unwrap();
            prop_assert!(sum.contains(joint) && restrict.contains(joint));
        }
        let selectors = [
            selection.depth.is_some(),
            selection.complexity.is_some(),
            selection.hanim.is_some(),
            selection.zone.is_some(),
        ];
        if selectors.iter().any(|s| *s) {
            prop_assert!(restrict.difference(&sum).is_empty(), "meeting every selector meets one");
        }
    }
}
