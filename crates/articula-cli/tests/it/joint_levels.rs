//! `inspect --joint-levels` on the command line.

use crate::program::{BVH, articula, fault, folder, json, short, word};
use serde_json::Value;

fn levels(found: &Value) -> &Vec<Value> {
    found["joint_levels"]["levels"].as_array().unwrap()
}

fn number(level: &Value, name: &str) -> f64 {
    level[name].as_f64().unwrap()
}

/// What holds for the levels of any character.
fn check(levels: &[Value], joints: f64) {
    assert_eq!(number(&levels[0], "joints"), joints);
    assert_eq!(number(&levels[0], "error_m"), 0.0);
    assert_eq!(levels[0]["far"], false);
    for pair in levels.windows(2) {
        let [fine, coarse] = pair else { continue };
        assert!(number(coarse, "joints") < number(fine, "joints"));
        assert!(number(coarse, "matrices") <= number(fine, "matrices"));
        assert!(number(coarse, "error_m") >= number(fine, "error_m"));
        assert!(
            coarse["far"] == true || fine["far"] == false,
            "near levels first"
        );
        if coarse["far"] == fine["far"] {
            let dropped = coarse["drops"].as_array().unwrap().len() as f64;
            assert_eq!(dropped, number(fine, "joints") - number(coarse, "joints"));
        }
    }
    for level in levels {
        let clips = level["clips"].as_array().unwrap();
        let most = clips
            .iter()
            .map(|c| number(c, "error_m"))
            .fold(0.0, f64::max);
        assert_eq!(number(level, "error_m"), most);
        for clip in clips {
            let half = number(clip, "max_m") / 2.0;
            let expected = number(clip, "p95_m").max(half);
            assert!((number(clip, "error_m") - expected).abs() < 1e-6);
        }
    }
}

#[test]
fn levels_of_joints_are_listed_and_far_ones_are_marked() {
    let here = folder("joint-levels");
    let human = word(short());
    let found = json(&here, &["inspect", human, "--joint-levels"]);
    let all = levels(&found);
    check(all, 89.0);
    assert_eq!(all[0]["clips"].as_array().unwrap().len(), 3);
    let far: Vec<&Value> = all.iter().filter(|l| l["far"] == true).collect();
    assert!(!far.is_empty(), "the coarse levels drop ancestors");
    let near = json(&here, &["inspect", human, "--joint-levels=1e9"]);
    check(levels(&near), 89.0);
    assert!(levels(&near).iter().all(|l| l["far"] == false));
    // With as few joints, a far level is better than a near one.
    let last = far[far.len() - 1];
    let alike = levels(&near)
        .iter()
        .filter(|l| number(l, "joints") <= number(last, "joints"));
    for level in alike {
        assert!(number(level, "error_m") > number(last, "error_m"));
    }
    let one = json(
        &here,
        &["inspect", human, "--joint-levels", "--clip", "idle"],
    );
    let names = levels(&one)[0]["clips"].as_array().unwrap();
    assert_eq!(names.len(), 1);
    assert_eq!(names[0]["clip"], "idle");
    let ran = articula(&here, &["inspect", human, "--joint-levels"]);
    let table = ran.out.split("joint levels\n").nth(1).unwrap();
    assert!(
        table.contains("matrices") && table.contains("far"),
        "{table}"
    );
    assert_eq!(
        json(&here, &["inspect", human])["joint_levels"],
        Value::Null
    );
}

#[test]
fn without_a_skin_points_on_the_bones_count() {
    let here = folder("joint-levels-bones");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let found = json(&here, &["inspect", "a.bvh", "--joint-levels"]);
    assert_eq!(found["joint_levels"]["on_bones"], true);
    check(levels(&found), 5.0);
    std::fs::write(here.join("a.fap"), "2.1 a 25 0\n").unwrap();
    let line = fault(&here, 2, &["inspect", "a.fap", "--joint-levels"]);
    assert!(line.contains("no joints"), "{line}");
}
