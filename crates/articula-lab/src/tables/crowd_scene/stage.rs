//! The mixed scene: a cast of clothed game characters, walls, roles and two cameras.

use super::{Run, SEED};
use anyhow::{Context, Result};
use articula::crowd::{CharacterEntry, CrowdAsset, CrowdOptions};
use articula::inspect::inspect;
use articula::{Executor, Figure};
use articula_build::evaluate::CameraKey;
use articula_build::{Plaza, Scene, SceneView, Wall, plaza};
use glam::Vec3;
use std::path::PathBuf;
use std::sync::Arc;

const COUNT: usize = 10_000;
/// Number of characters of a small run.
const FEW: usize = 200;
/// Height of every character, metres.
const HEIGHT_METRES: f32 = 1.8;
/// Members of the main role: each n-th, from the front of the crowd on.
const MAIN_ONE_OF: usize = 97;
/// Duration of the drive, seconds.
const LAP_SECS: f64 = 8.0;

/// The characters: name, file, clips.
const CAST: [(&str, &str, &[&str]); 6] = [
    (
        "knight",
        "KayKit_Knight.glb",
        &["Idle", "Walking_A", "1H_Melee_Attack_Chop", "Cheer"],
    ),
    (
        "mage",
        "KayKit_Mage.glb",
        &["Idle", "Walking_A", "Spellcasting", "Cheer"],
    ),
    (
        "fighter",
        "Quaternius_cyberpunk_pack__Character.glb",
        &[
            "CharacterArmature|Idle_Neutral",
            "CharacterArmature|Walk",
            "CharacterArmature|Punch_Left",
            "CharacterArmature|Wave",
        ],
    ),
    (
        "soldier",
        "Quaternius_single_knight_pack__KnightCharacter.glb",
        &[
            "HumanArmature|Idle",
            "HumanArmature|Walking",
            "HumanArmature|Run_swordAttack",
        ],
    ),
    (
        "hero",
        "Quaternius_platformer_game_pack__Character.glb",
        &[
            "CharacterArmature|Idle",
            "CharacterArmature|Walk",
            "CharacterArmature|Wave",
        ],
    ),
    (
        "robot",
        "RobotExpressive.glb",
        &["Robot_Idle", "Robot_Walking", "Robot_Dance", "Robot_Wave"],
    ),
];

/// The characters of a small run, which are files of the repository.
const SMALL: [&str; 2] = ["soldier", "hero"];

/// A character that is prepared.
pub(super) struct Member {
    pub(super) name: &'static str,
    file: &'static str,
    pub(super) asset: CrowdAsset,
    /// Scale to the height of all.
    scale: f32,
}

impl Member {
    /// What scene files know of it.
    pub(super) fn of_file<'a>(&'a self, file: &'a str) -> CharacterEntry<'a> {
        CharacterEntry {
            name: self.name,
            file: Some(file),
            clips: self.asset.clips(),
        }
    }
}

/// The scene and its cast.
pub(super) struct Stage {
    pub(super) cast: Vec<Member>,
    pub(super) scene: Arc<Scene>,
}

impl Stage {
    pub(super) fn new(run: &Run) -> Result<Self> {
        let chosen = CAST.iter().filter(|c| !run.small || SMALL.contains(&c.0));
        let cast = chosen.map(|(name, file, clips)| member(run, name, file, clips));
        let cast = cast.collect::<Result<Vec<Member>>>()?;
        let count = if run.small { FEW } else { COUNT };
        let clips: Vec<usize> = cast.iter().map(|c| c.asset.clips().len()).collect();
        let mut scene = plaza(count, &clips, SEED, Plaza::Still);
        let importance = &mut scene.importance;
        let role = |name: &str| {
            let found = importance.roles.iter().position(|r| r.name == name);
            Some(found.context("a usual role")? as u16).context("a usual role")
        };
        let (main, audience) = (role("main")?, role("audience")?);
        let role_of = (0..count).map(|i| match i {
            i if i % MAIN_ONE_OF == MAIN_ONE_OF / 2 => Some(main),
            i if i % 2 == 0 => Some(audience),
            _ => None,
        });
        importance.role_of = role_of.collect();
        for member in &mut scene.members {
            member.scale = cast[usize::from(member.character)].scale;
        }
        let half = scene.members[0].position.z;
        scene.walls = walls(half);
        scene.views = views(&scene.views[0], half);
        let scene = scene.into();
        Ok(Self { cast, scene })
    }

    /// Absolute paths of the files of the cast.
    pub(super) fn files(&self, run: &Run) -> Result<Vec<String>> {
        let path = |member: &Member| {
            let path = std::path::absolute(file(run, member.file))?;
            Ok(path.to_str().context("a name in UTF-8")?.to_owned())
        };
        self.cast.iter().map(path).collect()
    }

    /// Whether a member begins in the main role.
    pub(super) fn is_main(&self, member: usize) -> bool {
        let importance = &self.scene.importance;
        let role = importance.role_of[member].map(|r| &importance.roles[usize::from(r)]);
        role.is_some_and(|role| role.name == "main")
    }

    /// Number of members of the main role.
    pub(super) fn mains(&self) -> usize {
        (0..self.scene.members.len())
            .filter(|m| self.is_main(*m))
            .count()
    }
}

fn file(run: &Run, name: &str) -> PathBuf {
    run.data.join("glb").join(name)
}

fn member(run: &Run, name: &'static str, of: &'static str, clips: &[&str]) -> Result<Member> {
    let opened = articula::fs::open(file(run, of))?;
    let figure = Figure::new(opened)?;
    let height = inspect(&figure, &[], &Executor::default())?.height_m;
    let height = height.with_context(|| format!("{of}: no height"))?;
    let options = CrowdOptions {
        clips: clips.iter().map(|c| (*c).to_owned()).collect(),
        pose_cache: true,
        ..CrowdOptions::default()
    };
    Ok(Member {
        name,
        file: of,
        asset: CrowdAsset::new(&figure, &options, &Executor::default())?,
        scale: HEIGHT_METRES / height,
    })
}

/// Walls between the rows: two lines of six, with gaps.
fn walls(half: f32) -> Vec<Wall> {
    let step = 2.0 * half / 6.0;
    let at = |line: f32, i: usize| Wall {
        centre: Vec3::new((i as f32 + 0.5) * step - half, 1.5, line * half),
        size: Vec3::new(0.7 * step, 3.0, 0.4),
        yaw_radians: 0.0,
    };
    let lines = [0.65, -0.15];
    lines
        .into_iter()
        .flat_map(|line| (0..6).map(move |i| at(line, i)))
        .collect()
}

/// A drive into the crowd and back, and a balcony at its side that looks across.
fn views(usual: &SceneView, half: f32) -> Vec<SceneView> {
    let key = |secs: f64, z: f32| CameraKey {
        secs,
        eye: Vec3::new(0.0, 1.7, z),
        target: Vec3::new(0.0, 1.7, z - 1.0),
    };
    let drive = SceneView {
        viewport: usual.viewport,
        camera: vec![
            key(0.0, half + 3.0),
            key(0.5 * LAP_SECS, half - 15.0),
            key(LAP_SECS, half + 3.0),
        ],
        camera_loops: true,
    };
    let balcony = SceneView {
        viewport: usual.viewport,
        camera: vec![CameraKey {
            secs: 0.0,
            eye: Vec3::new(half + 6.0, 9.0, 0.3 * half),
            target: Vec3::new(0.0, 0.0, 0.0),
        }],
        camera_loops: false,
    };
    vec![drive, balcony]
}
