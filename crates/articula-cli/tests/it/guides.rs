//! The commands of the readme and of the guides run as they stand there, one after the other in one
//! folder, and the numbers of the readme are those of the pages that it names.

use crate::judges::{is_here, is_required};
use crate::program::{articula, edited, folder, human};
use crate::serving;
use serde_json::json;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn page(name: &str) -> String {
    std::fs::read_to_string(root().join(name)).unwrap()
}

/// A figure of 21 joints and 800 triangles, and a walk of another one.
fn case(name: &str) -> PathBuf {
    root()
        .join("crates/articula-formats/tests/cases")
        .join(name)
}

/// The commands of this program in the shell blocks of a page, without comments.
fn commands(page: &str) -> Vec<String> {
    let mut commands = Vec::new();
    let mut in_block = false;
    for line in page.lines() {
        match line {
            "```sh" => in_block = true,
            "```" => in_block = false,
            _ if in_block => {
                let command = line.split(" #").next().unwrap_or_default().trim();
                let rest = command.strip_prefix("articula ");
                commands.extend(rest.map(str::to_owned));
            }
            _ => {}
        }
    }
    commands
}

/// Runs the commands of a page in a folder, each with `more` words.
fn run(name: &str, folder: &Path, more: &[&str]) {
    let commands = commands(&page(name));
    assert!(commands.len() > 4, "{name} has no commands");
    for command in commands {
        if command.ends_with("--engine xslt") && !is_here("xsltproc", "--version") {
            assert!(!is_required("ARTICULA_REQUIRE_TOOLS"), "no xsltproc");
            continue;
        }
        let words = command.replace('"', "");
        let words: Vec<&str> = words.split_whitespace().collect();
        if let ["serve", of, ..] = words[..] {
            // It would go on for ever.
            std::fs::create_dir_all(folder.join(of)).unwrap();
            serving::answers(folder, of);
            continue;
        }
        if words[0] == "play" {
            // Tested where a server goes on.
            continue;
        }
        let ran = articula(folder, &[&words[..], more].concat());
        assert_eq!(ran.status, 0, "{name}: {command}: {}", ran.err);
    }
}

/// Files that the readme asks for.
fn start(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::copy(case("b_base.bvh"), folder.join("walk.bvh")).unwrap();
    folder
}

#[test]
fn the_readme_runs_with_a_character_that_has_clips() {
    let folder = start("guide-readme-clips");
    std::fs::copy(case("base.glb"), folder.join("my.glb")).unwrap();
    run("README.md", &folder, &[]);
}

#[test]
fn the_readme_runs_with_a_character_that_has_none() {
    let folder = start("guide-readme-still");
    edited(&case("base.glb"), &folder.join("my.glb"), |document| {
        document.as_object_mut().unwrap().remove("animations");
    });
    run("README.md", &folder, &[]);
}

#[test]
fn the_guide_to_adaptation_runs() {
    let folder = folder("guide-adaptation");
    edited(&case("base.glb"), &folder.join("knight.glb"), |document| {
        document["animations"][0]["name"] = json!("Walking_A");
    });
    let phone = r#"<UsageEnvironmentProperty><Description>
        <NetworkCharacteristic><AvailableBandwidth average="500000"/></NetworkCharacteristic>
        </Description></UsageEnvironmentProperty>"#;
    std::fs::write(folder.join("phone.xml"), phone).unwrap();
    let server = json!({"network": {"max_capacity_bps": 2_000_000}});
    std::fs::write(folder.join("server.json"), server.to_string()).unwrap();
    std::fs::write(folder.join("train.csv"), "0 120000\n6 0\n14 120000\n").unwrap();
    run("docs/adaptation.md", &folder, &[]);
}

#[test]
fn the_reference_of_commands_runs() {
    let folder = folder("guide-commands");
    for name in [
        "hero.glb",
        "figure.glb",
        "idle.glb",
        "mannequin.gltf",
        "clips.glb",
    ] {
        std::fs::copy(case("base.glb"), folder.join(name)).unwrap();
    }
    std::fs::copy(case("b_base.bvh"), folder.join("walk.bvh")).unwrap();
    std::fs::create_dir(folder.join("clips")).unwrap();
    std::fs::copy(case("b_base.bvh"), folder.join("clips/walk.bvh")).unwrap();
    std::fs::copy(human(), folder.join("head.glb")).unwrap();
    let talk = root().join("assets/fap/speech_synthetic.fap");
    std::fs::copy(talk, folder.join("talk.fap")).unwrap();
    for (name, to) in [
        ("glb/ict_head_talk_554.glb", "face.glb"),
        ("speech/librivox_austen_0880.wav", "hello.wav"),
        ("speech/librivox_austen_0880.lab", "hello.TextGrid"),
    ] {
        std::fs::copy(root().join("assets").join(name), folder.join(to)).unwrap();
    }
    for command in [
        "convert talk.fap talk.afp",
        "package figure.glb item --no-2d",
    ] {
        let words: Vec<&str> = command.split(' ').collect();
        assert_eq!(articula(&folder, &words).status, 0, "{command}");
    }
    // The page shows several ways to make the same file.
    run("docs/commands.md", &folder, &["--force"]);
}

/// Numbers of a text, without the commas between thousands.
fn numbers(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let words = text.split(|c| !is_part(c));
    words
        .map(|word| word.trim_matches(['.', ',']).replace(',', ""))
        .filter(|word| word.starts_with(|c: char| c.is_ascii_digit()))
        .collect()
}

/// A text without the targets of its links, whose numbers are no claims.
fn without_links(text: &str) -> String {
    let mut parts = text.split("](");
    let mut kept = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        kept.push_str(part.split_once(')').map_or("", |(_, after)| after));
    }
    kept
}

#[test]
fn the_numbers_of_the_readme_are_in_the_results_that_it_names() {
    let readme = page("README.md");
    let mut checked = 0;
    for bullet in readme.split("\n- **").skip(1) {
        let Some((text, rest)) = bullet.split_once("([`articula-lab") else {
            continue;
        };
        let (_, link) = rest.split_once("](").unwrap();
        let (results, _) = link.split_once(')').unwrap();
        let found = numbers(&page(results));
        for number in numbers(&without_links(text)) {
            assert!(found.contains(&number), "{results} does not have {number}");
            checked += 1;
        }
    }
    assert!(checked > 20, "{checked} numbers");
}
