//! The command line itself: exit statuses, help, and one line for every error.

use crate::program::{BVH, articula, fault, folder, human, json, word};

#[test]
fn help_is_no_error_and_wrong_words_are_usage() {
    let here = folder("usage");
    for words in [
        &["--help"][..],
        &["lod", "--help"],
        &["--version"],
        &["completions", "bash"],
    ] {
        let ran = articula(&here, words);
        assert_eq!(ran.status, 0, "{words:?}");
        assert!(!ran.out.is_empty() && ran.err.is_empty(), "{words:?}");
    }
    for words in [
        &[][..],
        &["dance"],
        &["inspect"],
        &["lod", "a.glb", "--viewport", "0x0"],
        &["lod", "a.glb", "--fov-deg", "180"],
        &["lod", "a.glb", "--distances", "3,-1"],
        &["lod", "a.glb", "--method", "magic"],
        &["lod", "a.glb", "--calibrate", "1", "--parameter", "1"],
        &["lod", "a.glb", "--beta", "2"],
        &["lod", "a.glb", "--distances", "1e30"],
        &["lod", "a.glb", "--display-hz", "30"],
        &["lod", "a.glb", "--chain", "split"],
        &["lod", "a.glb", "--finest-level", "2"],
        &[
            "lod",
            "a.glb",
            "--schedule",
            "s.json",
            "--finest-level",
            "7",
        ],
        &[
            "lod",
            "a.glb",
            "--schedule",
            "s.json",
            "--method",
            "skin-px-view",
        ],
        &["inspect", "a.bvh", "--read", "unit-metres=0"],
        &["build", "a.glb", "b.glb", "--levels", "0"],
        &[
            "build",
            "a.glb",
            "b.glb",
            "--levels",
            "3",
            "--targets",
            "100,50",
        ],
        &["build", "a.glb", "b.glb", "--targets", "100,50,60"],
        &[
            "build",
            "a.glb",
            "b.glb",
            "--levels",
            "3",
            "--region-weight",
            "nose=2",
        ],
        &[
            "build", "a.glb", "b.glb", "--levels", "3", "--split", "nose",
        ],
        &["build", "a.glb", "b.glb", "--msft-lod"],
        &["build", "a.glb", "b.glb", "--weighting", "rest"],
        &[
            "build",
            "a.glb",
            "b.glb",
            "--levels",
            "2",
            "--split",
            "upper,upper",
        ],
        &["human", "--triangles", "many", "a.glb"],
    ] {
        assert_eq!(articula(&here, words).status, 2, "{words:?}");
    }
}

#[test]
fn every_shell_gets_completions_that_name_the_commands() {
    let here = folder("completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let ran = articula(&here, &["completions", shell]);
        for command in ["inspect", "convert", "human", "build", "lod", "demo"] {
            assert!(ran.out.contains(command), "{shell}: {command}");
        }
    }
}

#[test]
fn options_may_stand_between_files() {
    let here = folder("between");
    std::fs::write(here.join("a.bvh"), BVH).unwrap();
    let unit = ["--read", "unit-metres=0.01"];
    json(
        &here,
        &[&["convert", "a.bvh"], &unit[..], &["o.glb"]].concat(),
    );
    json(&here, &[&["convert", "a.bvh", "p.glb"], &unit[..]].concat());
    let read = |name: &str| std::fs::read(here.join(name)).unwrap();
    assert_eq!(read("o.glb"), read("p.glb"));
    // The words are understood if what is missed is the file.
    let cases: &[&[&str]] = &[
        &[
            "convert", "gone.bvh", "--onto", "gone.glb", "o.glb", "--force",
        ],
        &["convert", "gone.bvh", "--loop", "q.glb"],
        &[
            "build", "gone.glb", "--seed", "2", "gone.bvh", "--levels", "2", "q.glb",
        ],
        &["flatten", "gone.glb", "--triangles", "9", "q.svg"],
        &["flatten", "frame", "gone.svg", "--at", "1", "q.png"],
        &["flatten", "movie", "gone.svg", "--fps", "9", "q.gif"],
        &["package", "gone.glb", "--no-2d", "item"],
        &["gbsd", "gone.abp", "--out", "q.xml"],
        &["demo", "gone.glb", "--out", "d", "gone.bvh"],
        &["inspect", "--map", "gone.glb"],
        &["lod", "--seed", "2", "gone.glb"],
        &["crowd", "--seed", "2", "gone.glb"],
    ];
    for words in cases {
        let line = fault(&here, 1, words);
        assert!(line.contains("gone."), "{words:?}: {line}");
    }
    let words = [
        "convert", "gone.bvh", "--trim", "..1", "gone.glb", "--to", "glb", "out/",
    ];
    let ran = articula(&here, &words);
    assert_eq!(ran.status, 1);
    assert!(
        ran.err.contains("gone.bvh: ") && ran.err.contains("gone.glb: "),
        "{}",
        ran.err
    );
    let line = fault(&here, 2, &["adapt", "gone", "--max-bytes", "9", "out"]);
    assert!(line.contains("no digital item"), "{line}");
}

#[test]
fn wrong_settings_name_the_flag_and_what_is_allowed() {
    let here = folder("settings");
    let cases: &[(&[&str], &str, &str)] = &[
        (&["inspect", "a.bvh", "--read", "up=x"], "--read", "y or z"),
        (
            &["inspect", "a.bvh", "--read", "size=1"],
            "--read",
            "unit-metres, up",
        ),
        (
            &["inspect", "a.bvh", "--write", "map=a.json"],
            "--write",
            "joint-map, face-map, face-points",
        ),
        (
            &["lod", "a.glb", "--thesis", "curve=round"],
            "--thesis",
            "literal or fixed",
        ),
        (
            &["lod", "a.glb", "--write", "plot=a.svg"],
            "--write",
            "loa-profile, fap",
        ),
        (
            &["convert", "a.glb", "a.abp", "--stream", "tiers=9"],
            "--stream",
            "from 1 to 8",
        ),
        (
            &["convert", "a.glb", "b.glb", "--root-motion", "away"],
            "--root-motion",
            "in-place",
        ),
        (
            &["flatten", "a.glb", "a.svg", "--quality", "colour=0"],
            "--quality",
            "above 0",
        ),
        (
            &["adapt", "item", "--limit", "face-loa=4"],
            "--limit",
            "0 (very low) to 3 (high)",
        ),
        (
            &["adapt", "item", "--trace", "t.csv", "--play", "secs=0"],
            "--play",
            "above 0",
        ),
    ];
    for (words, flag, allowed) in cases {
        let ran = articula(&here, words);
        assert_eq!(ran.status, 2, "{words:?}");
        let found = words[words.len() - 1];
        let line = ran.err.lines().next().unwrap_or_default();
        let has = |what: &&str| line.contains(what);
        assert!(
            [*flag, found, *allowed].iter().all(has),
            "{words:?}: {line}"
        );
    }
}

#[test]
fn the_version_is_that_of_the_program() {
    let here = folder("version");
    let ran = articula(&here, &["--version"]);
    assert_eq!(ran.out, format!("articula {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(articula(&here, &["build", "--version"]).status, 2);
}

#[test]
fn wrong_usage_says_what_would_be_right() {
    let here = folder("wrong");
    let human = word(human());
    let cases: &[(&[&str], &str)] = &[
        (&["human", "--triangles", "7", "a.glb"], "2000 to 70000"),
        (&["human", "a.obj"], ".glb"),
        (
            &["human", "a.glb", "--painted", "--triangles", "7"],
            "2000 to 70000",
        ),
        (&["build", human, "a.vrm"], ".glb"),
        (
            &["convert", human, "a.obj"],
            "unknown extension; supported conversions: glb, gltf",
        ),
        (
            &["convert", human, "a.vrm"],
            "conversion from glb to vrm is not supported",
        ),
        (&["convert", human, "a.glb", "--passive", "rest"], "--loa"),
        (
            &["convert", human, "a.glb", "--loa", "loa(Lots)"],
            "VeryLow",
        ),
        (&["convert", human, "a.glb", "--clip", "swim"], "\"walk\""),
        (&["inspect", human, "--hide", "hat"], "\"skin\""),
        (&["lod", human, "--clip", "swim"], "\"idle\""),
        (
            &["lod", human, "--method", "thesis", "--loa", "loa(Low)"],
            "--method loa",
        ),
        (
            &["lod", human, "--method", "all", "--parameter", "1"],
            "--calibrate",
        ),
        (
            &["lod", human, "--method", "thesis", "--protect-contacts"],
            "skin-px",
        ),
        (&["lod", human, "--write", "fap=a.fap"], "--onto HEAD"),
        (
            &["convert", human, "a.glb", "--mesh-level", "2px"],
            "--mesh-distance",
        ),
        (&["convert", human], "IN OUT"),
        (&["lod", human, "--passive", "rest"], "--loa"),
        (&["lod", human, "--plot", "a.png"], ".svg"),
        (&["lod", human, "--contact-sheet", "a.jpg"], ".png"),
        (
            &["lod", human, "--thesis", "d-min=9", "--d-max", "9"],
            "nearer",
        ),
        (
            &["lod", human, "--method", "skip-hold", "--parameter", "2.5"],
            "whole number",
        ),
        (
            &["lod", human, "--method", "loa", "--parameter", "7"],
            "to 6",
        ),
    ];
    for (words, mend) in cases {
        let line = fault(&here, 2, words);
        assert!(line.contains(mend), "{words:?}: {line}");
    }
    assert!(
        !here.join("a.glb").exists(),
        "nothing is written on an error"
    );
}

#[test]
fn the_world_in_the_way_is_answered_with_a_mend() {
    let here = folder("world");
    std::fs::write(here.join("empty.glb"), b"").unwrap();
    std::fs::create_dir_all(here.join("folder.glb")).unwrap();
    let human = word(human());
    let cases: &[(&[&str], &str)] = &[
        (&["inspect", "gone.glb"], "check its name"),
        (&["inspect", "empty.glb"], "empty"),
        (&["inspect", "folder.glb"], "name a file"),
        (&["convert", human, "folder.glb"], "name a file"),
        (&["human", "empty.glb/a.glb"], "is a file; name another"),
    ];
    for (words, mend) in cases {
        let line = fault(&here, 1, words);
        assert!(line.contains(mend), "{words:?}: {line}");
    }
}

#[test]
fn completions_come_as_json_too() {
    let here = folder("completions-json");
    let found = json(&here, &["completions", "bash"]);
    assert_eq!(found["shell"], "bash");
    assert!(found["script"].as_str().unwrap().contains("_articula"));
}
