//! Scenes as JSON files: positions, clips and camera paths.
//!
//! The format is described in `docs/formats/scene.md`. A scene names its characters and their clips, so
//! it is read in two steps: [`ParsedScene::parse`] finds the files of the characters, and
//! [`ParsedScene::resolve`], when these are open, the clips. Angles in degrees are converted here. Every number is checked here, so later code treats the result like the built-in
//! plaza scene.

use super::scene_cast::{
    CastFile, CharacterEntry, ViewFile, cast_of, check_cast, usual_fov_deg, usual_viewport,
};
use super::scene_roles::{CueFile, RolesFile, WallFile, ZoneFile};
use crate::camera_path::{Key, ensure, malformed};
use crate::error::{Context, Error, Result};
use crate::open::choose;
use articula_build::{ClipPlayback, CrossFade, Scene, SceneCharacter};
use articula_core::Clip;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Maximum number of characters in a scene.
pub const MAX_MEMBERS: usize = 1_000_000;

/// Maximum distance of a character from the origin in metres: beyond it single precision is
/// visible.
const FARTHEST_METRES: f32 = 1e5;

/// Scales of a character.
const SCALES: RangeInclusive<f32> = 0.01..=100.0;

/// Maximum playback speed, forwards or backwards.
const MAX_SPEED: f32 = 100.0;

/// A scene as written in files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    characters: Vec<CastFile>,
    #[serde(default = "usual_viewport")]
    viewport: [u32; 2],
    #[serde(default = "usual_fov_deg")]
    fov_deg: f32,
    camera: Vec<Key>,
    #[serde(default)]
    camera_loops: bool,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    views: Vec<ViewFile>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    roles: BTreeMap<String, f32>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    clip_importance: BTreeMap<String, f32>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    zones: Vec<ZoneFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    walls: Vec<WallFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    cues: Vec<CueFile>,
    members: Vec<MemberFile>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MemberFile {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    character: Option<String>,
    position: [f32; 3],
    #[serde(default)]
    yaw_deg: f32,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    scale: f32,
    clip: String,
    #[serde(default)]
    phase: f32,
    #[serde(default = "one")]
    speed: f32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cross_fade: Option<FadeFile>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    role: Option<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FadeFile {
    clip: String,
    #[serde(default)]
    phase: f32,
    #[serde(default = "one")]
    speed: f32,
    secs: f32,
    #[serde(default)]
    start: f32,
}

fn one() -> f32 {
    1.0
}

fn is_one(number: &f32) -> bool {
    *number == 1.0
}

/// A scene file that was read, whose characters and clips are still names.
#[derive(Debug)]
pub struct ParsedScene {
    file: SceneFile,
}

impl ParsedScene {
    /// Reads the JSON of `docs/formats/scene.md`.
    ///
    /// # Errors
    /// An [`Error`] that names the line, or the character and its fault.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let file: SceneFile = serde_json::from_slice(bytes)
            .map_err(|e| malformed(&e, "docs/formats/scene.md describes the format"))?;
        check_cast(&file.characters)?;
        Ok(Self { file })
    }

    /// Names and files of the characters that it names, each file relative to the folder of the scene
    /// file; none if the characters are given otherwise.
    pub fn characters(&self) -> impl ExactSizeIterator<Item = (&str, &str)> {
        let all = self.file.characters.iter();
        all.map(|character| (character.name.as_str(), character.file.as_str()))
    }

    /// Finds characters and clips by name in a cast; `display_hz` is the frame rate by which the length
    /// of camera paths is limited. Every number is checked here, so that what follows treats the scene
    /// like a built-in one.
    ///
    /// # Errors
    /// An [`Error`] that names the entry and its fault.
    pub fn resolve(self, cast: &[CharacterEntry<'_>], display_hz: f64) -> Result<Scene> {
        let file = self.file;
        let first = ViewFile {
            viewport: file.viewport,
            fov_deg: file.fov_deg,
            camera: file.camera,
            camera_loops: file.camera_loops,
        };
        let views = first.with_others(&file.views, display_hz)?;
        let count = file.members.len();
        ensure((1..=MAX_MEMBERS).contains(&count), || {
            format!("members: {count} characters; give 1 to {MAX_MEMBERS}")
        })?;
        let members = file.members.iter().enumerate();
        let members =
            members.map(|(i, m)| member(m, cast).with_context(|| format!("members[{i}]")));
        let members = members.collect::<Result<_>>()?;
        let roles: Vec<Option<&str>> = file.members.iter().map(|m| m.role.as_deref()).collect();
        let of_roles = RolesFile {
            roles: file.roles,
            clip_importance: file.clip_importance,
            zones: file.zones,
            walls: file.walls,
            cues: file.cues,
        };
        let (importance, walls) = of_roles.read(&roles, cast)?;
        Ok(Scene {
            members,
            views,
            importance,
            walls,
        })
    }
}

fn member(file: &MemberFile, cast: &[CharacterEntry<'_>]) -> Result<SceneCharacter> {
    let character = cast_of(file.character.as_deref(), cast)?;
    let clips = cast[character].clips;
    let near = file.position.iter().all(|p| p.abs() <= FARTHEST_METRES);
    ensure(near, || {
        format!("position: give metres within {FARTHEST_METRES} of the origin")
    })?;
    ensure(file.yaw_deg.is_finite(), || {
        "yaw_deg: give a finite number of degrees".to_owned()
    })?;
    ensure(SCALES.contains(&file.scale), || {
        let (least, most) = (SCALES.start(), SCALES.end());
        format!("scale: give {least} to {most}; 1 is the size of the file")
    })?;
    let cross_fade = file.cross_fade.as_ref().map(|fade| {
        let play = play((&fade.clip, fade.phase, fade.speed), clips)?;
        ensure((0.0..=3600.0).contains(&fade.secs), || {
            "secs: give 0 to 3600 seconds".to_owned()
        })?;
        ensure((0.0..=1.0).contains(&fade.start), || {
            "start: give 0 to 1".to_owned()
        })?;
        Ok::<_, Error>(CrossFade {
            other: play,
            fade_secs: fade.secs,
            start: fade.start,
        })
    });
    Ok(SceneCharacter {
        character: character as u16,
        position: Vec3::from(file.position),
        yaw_radians: file.yaw_deg.to_radians(),
        scale: file.scale,
        play: play((&file.clip, file.phase, file.speed), clips)?,
        cross_fade: cross_fade.transpose().context("cross_fade")?,
    })
}

fn play((clip, phase, speed): (&str, f32, f32), clips: &[Clip]) -> Result<ClipPlayback> {
    ensure((0.0..=1.0).contains(&phase), || {
        "phase: give 0 to 1".to_owned()
    })?;
    ensure(speed.abs() <= MAX_SPEED, || {
        format!("speed: give at most {MAX_SPEED}; negative plays backwards")
    })?;
    let names = clips.iter().map(|c| c.name.as_str());
    // A wrong name in a file is not an argument error.
    let found = choose("clip", clip, names).map_err(|e| Error::unsuited(e.to_string()))?;
    Ok(ClipPlayback {
        clip: found,
        phase,
        speed,
    })
}

/// Writes a scene as JSON, with the names of characters and clips. The characters of the cast that have
/// a file are listed with it.
pub fn write_scene(scene: &Scene, cast: &[CharacterEntry<'_>]) -> Vec<u8> {
    let importance = &scene.importance;
    let role = |member: usize| {
        let role = importance.role_of.get(member).copied().flatten()?;
        Some(importance.roles.get(usize::from(role))?.name.clone())
    };
    let members = scene.members.iter().enumerate();
    let members = members.map(|(i, m)| {
        let own = cast.get(usize::from(m.character));
        let name = |clip: usize| {
            let clip = own.and_then(|own| own.clips.get(clip));
            clip.map_or(String::new(), |c| c.name.clone())
        };
        MemberFile {
            character: own.filter(|_| cast.len() > 1).map(|c| c.name.to_owned()),
            position: m.position.to_array(),
            yaw_deg: m.yaw_radians.to_degrees(),
            scale: m.scale,
            clip: name(m.play.clip),
            phase: m.play.phase,
            speed: m.play.speed,
            cross_fade: m.cross_fade.map(|f| FadeFile {
                clip: name(f.other.clip),
                phase: f.other.phase,
                speed: f.other.speed,
                secs: f.fade_secs,
                start: f.start,
            }),
            role: role(i),
        }
    });
    let of_roles = RolesFile::of(importance, &scene.walls, cast);
    let mut views = scene.views.iter().map(ViewFile::of);
    let first = views.next().unwrap_or_default();
    let file = SceneFile {
        characters: cast.iter().filter_map(CastFile::of).collect(),
        viewport: first.viewport,
        fov_deg: first.fov_deg,
        camera: first.camera,
        camera_loops: first.camera_loops,
        views: views.collect(),
        roles: of_roles.roles,
        clip_importance: of_roles.clip_importance,
        zones: of_roles.zones,
        walls: of_roles.walls,
        cues: of_roles.cues,
        members: members.collect(),
    };
    // All map keys are strings and all numbers are finite, so writing cannot fail.
    let mut json = serde_json::to_vec_pretty(&file).unwrap_or_default();
    json.push(b'\n');
    json
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Tracks;

    fn clips() -> Vec<Clip> {
        let clip = |name: &str| Clip::new(name, 30.0, 31, 1, Tracks::default()).unwrap();
        vec![clip("idle"), clip("walk")]
    }

    const CAMERA: &str = r#""camera": [{"t": 0, "eye": [0, 1.7, 5], "target": [0, 1.7, 0]}]"#;

    fn scene(members: &str) -> Result<Scene> {
        let text = format!("{{{CAMERA}, \"members\": [{members}]}}");
        let clips = clips();
        let cast = CharacterEntry {
            name: "man",
            file: None,
            clips: &clips,
        };
        ParsedScene::parse(text.as_bytes())?.resolve(&[cast], 60.0)
    }

    #[test]
    fn what_is_left_out_is_usual() {
        let found = scene(r#"{"position": [1, 0, 2], "clip": "walk", "yaw_deg": 180}"#).unwrap();
        assert_eq!(found.views.len(), 1);
        assert_eq!(found.views[0].viewport.width_px, 1920.0);
        assert!(!found.views[0].camera_loops);
        let [member] = &found.members[..] else {
            panic!("one member")
        };
        assert_eq!(member.position, Vec3::new(1.0, 0.0, 2.0));
        assert!((member.yaw_radians - std::f32::consts::PI).abs() < 1e-6);
        let expected = ClipPlayback {
            clip: 1,
            phase: 0.0,
            speed: 1.0,
        };
        assert_eq!(member.play, expected);
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        let why = |members: &str| scene(members).unwrap_err().to_string();
        assert!(why("").contains("members: 0 characters"));
        let walk = r#"{"position": [0, 0, 0], "clip": "walk"}"#;
        let run = why(&format!(
            r#"{walk}, {{"position": [0, 0, 0], "clip": "run"}}"#
        ));
        assert!(
            run.contains("members[1]: ") && run.contains("\"idle\""),
            "{run}"
        );
        for (field, value) in [
            ("position", r#""position": [0, 1e9, 0]"#),
            ("phase", r#""position": [0, 0, 0], "phase": 1.5"#),
            ("speed", r#""position": [0, 0, 0], "speed": 1e30"#),
            ("scale", r#""position": [0, 0, 0], "scale": 0"#),
            (
                "cross_fade: secs",
                r#""position": [0, 0, 0], "cross_fade": {"clip": "idle", "secs": -1}"#,
            ),
            ("NaN", r#""position": [NaN, 0, 0]"#),
            ("unknown field", r#""position": [0, 0, 0], "colour": 1"#),
        ] {
            let found = why(&format!(r#"{{"clip": "walk", {value}}}"#));
            let place = if field == "NaN" { "line 1" } else { field };
            assert!(found.contains(place), "{field}: {found}");
        }
        let late = r#"{"camera": [{"t": 1, "eye": [0,0,1], "target": [0,0,0]}], "members": []}"#;
        let late = ParsedScene::parse(late.as_bytes()).unwrap();
        let late = late.resolve(&[], 60.0).unwrap_err();
        assert!(late.to_string().contains("camera[0].t"));
    }
}
