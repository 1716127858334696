//! The clips of the table, and whether the start contexts of the codec were trained on them.

use anyhow::{Context, Result};
use articula::{CharacterFile, Figure};
use std::path::Path;

/// A file with the clips that are measured.
pub(super) struct Case {
    /// Name in the table.
    pub(super) name: &'static str,
    /// File of the data folder; empty for the mannequin.
    file: &'static str,
    /// Character onto which a motion without one is retargeted; empty for none.
    onto: &'static str,
    /// Names of clips; empty for the first.
    clips: &'static [&'static str],
    /// Whether the contexts of a stream were trained on the clips.
    pub(super) trained: bool,
    /// Tiers of its layered forms. The fox moves by hundreds of metres, which one tier cannot hold.
    pub(super) tiers: usize,
}

const fn case(
    name: &'static str,
    file: &'static str,
    clips: &'static [&'static str],
    trained: bool,
) -> Case {
    Case {
        name,
        file,
        onto: "",
        clips,
        trained,
        tiers: 5,
    }
}

/// All cases.
pub(super) const CASES: &[Case] = &[
    case(
        "pab",
        "glb/pab_arnaud.glb",
        &["walk", "jog", "run", "atlas"],
        true,
    ),
    case("mannequin", "", &["walk"], true),
    case(
        "KayKit Knight",
        "glb/KayKit_Knight.glb",
        &["Walking_A", "1H_Melee_Attack_Chop"],
        true,
    ),
    case("CMU 12_01 (BVH)", "bvh/cmu_12_01_walk.bvh", &[], true),
    case(
        "KayKit Mage",
        "glb/KayKit_Mage.glb",
        &["Spellcast_Long", "2H_Melee_Attack_Spinning", "Idle"],
        false,
    ),
    case(
        "RobotExpressive",
        "glb/RobotExpressive.glb",
        &["Robot_Dance", "Robot_Walking", "Robot_Jump"],
        false,
    ),
    case(
        "mannequiny",
        "glb/mannequiny.glb",
        &["idle_root.001", "run_root.001", "fight_kick_root.001"],
        false,
    ),
    case("FAIR1 dab (BVH)", "bvh/fair1_dab.bvh", &[], false),
    case("FAIR1 jumping (BVH)", "bvh/fair1_jumping.bvh", &[], false),
    case("fingers (BVH)", "bvh/dance_fingers.bvh", &[], false),
    Case {
        onto: "vrm/Godette_vrm_v4.vrm",
        ..case("Godette, VRMA", "vrm/idle_loop.vrma", &[], false)
    },
    case(
        "ICT head, ARKit",
        "glb/ict_head_talk_1095.glb",
        &["talk"],
        false,
    ),
    Case {
        tiers: 7,
        ..case("Fox", "glb/Fox.glb", &["Run"], false)
    },
    case("dancer", "glb/mh_female_dance.glb", &["dance"], false),
];

impl Case {
    /// Size of the BVH file that the clip is from, in Brotli; `None` for other sources.
    pub(super) fn source_bvh(&self, data: &Path) -> Result<Option<usize>> {
        if !self.file.ends_with(".bvh") {
            return Ok(None);
        }
        let text = std::fs::read(data.join(self.file)).context(self.file)?;
        Ok(Some(super::peers::brotli(&text)?))
    }

    /// Whether it is in the small run, with its first clip: that on which the bounds are.
    pub(super) fn is_small(&self) -> bool {
        self.name == "pab"
    }

    /// Opens the figure.
    pub(super) fn open(&self, data: &Path) -> Result<Figure> {
        let opened = if self.file.is_empty() {
            articula::reference_mannequin()?
        } else {
            self.character(data).with_context(|| self.file)?
        };
        Ok(Figure::new(opened)?)
    }

    fn character(&self, data: &Path) -> Result<CharacterFile> {
        let opened = articula::fs::open(data.join(self.file))?;
        if self.onto.is_empty() {
            return Ok(opened);
        }
        let mut character = articula::fs::open(data.join(self.onto))?;
        let options = articula::AddClipsOptions {
            keep_own: false,
            ..articula::AddClipsOptions::default()
        };
        character.add_clips(&[opened], &options, &articula::Executor::default())?;
        Ok(character)
    }

    /// Indices of the clips in a figure.
    pub(super) fn indices(&self, figure: &Figure) -> Result<Vec<usize>> {
        if self.clips.is_empty() {
            return Ok(vec![0]);
        }
        let index = |name: &&str| {
            let clips = &figure.asset.clips;
            let found = clips.iter().position(|clip| clip.name == **name);
            found.with_context(|| format!("{}: no clip {name}", self.name))
        };
        self.clips.iter().map(index).collect()
    }
}
