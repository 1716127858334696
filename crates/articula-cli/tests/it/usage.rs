//! The command line itself: exit statuses, help, and one line for every error.

use crate::program::{articula, fault, folder, human, json, word};

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
        &["lod", "a.glb", "--schedule", "s.json", "--variant", "view"],
        &["inspect", "a.bvh", "--unit-metres", "0"],
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
fn wrong_usage_says_what_would_be_right() {
    let here = folder("wrong");
    let human = word(human());
    let cases: &[(&[&str], &str)] = &[
        (&["demo", "--serve"], "studio"),
        (&["human", "--triangles", "7", "a.glb"], "2000 to 70000"),
        (&["human", "a.obj"], ".glb"),
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
            &["lod", human, "--method", "thesis", "--variant", "view"],
            "skin-px",
        ),
        (
            &["lod", human, "--cluster-key", "least-sum"],
            "--method ahn",
        ),
        (&["lod", human, "--passive", "rest"], "--loa"),
        (&["lod", human, "--plot", "a.png"], ".svg"),
        (&["lod", human, "--contact-sheet", "a.jpg"], ".png"),
        (&["lod", human, "--d-min", "9", "--d-max", "9"], "nearer"),
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
