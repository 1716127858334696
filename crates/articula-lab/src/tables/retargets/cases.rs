//! The pairs of motions and characters.

use super::variants::Variant;
use anyhow::{Context, Result};
use articula::convert::{FittedClip, fit_clips};
use articula::{AddClipsOptions, CharacterFile, OpenOptions};
use articula_build::source_rate_hz;
use articula_core::source::RawClip;
use articula_formats::mpeg4::bap;
use articula_human::{HumanError, HumanOptions};
use std::path::Path;
use std::sync::LazyLock;

/// Source of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MotionSource {
    /// A clip of a data file; the first clip if the name is empty.
    File(&'static str, &'static str),
    /// Body animation parameters, made from another motion on the reference human.
    Bap(&'static str),
}

/// Character that receives a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum MotionTarget {
    File(&'static str),
    /// The reference human.
    Human,
}

/// One row of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Case {
    pub(super) motion: &'static str,
    pub(super) source: MotionSource,
    pub(super) onto: &'static str,
    pub(super) target: MotionTarget,
    /// Leading seconds that are left out: captures begin with a frame of the rest pose.
    pub(super) skip_secs: f32,
    /// How its files differ from those of the data.
    pub(super) variant: Variant,
    /// Whether it is part of a small run.
    pub(super) small: bool,
    /// Whether it is in the picture of the page.
    pub(super) shown: bool,
}

/// A character and its name in the table.
type Onto = (&'static str, MotionTarget);

const CMU_WALK: &str = "bvh/cmu_12_01_walk.bvh";
const PAB: &str = "glb/pab_arnaud.glb";
const KAYKIT: &str = "glb/kaykit_mannequin/Med_MovementBasic.glb";
const KAYKIT_WALK: &str = "Rig_Medium|Walking_A";
const DANCE: &str = "glb/mh_female_dance.glb";
const IDLE: &str = "vrm/idle_loop.vrma";

const MH_WOMAN: Onto = onto("MakeHuman woman", "glb/mh_female_default163_arkit52.glb");
const MH_MAN: Onto = onto("MakeHuman man", "glb/mh_male_cmu31.glb");
const MAN: Onto = onto("Quaternius man", "glb/Quaternius_modular_men__Casual2.glb");
const WOMAN: Onto = onto(
    "Quaternius woman",
    "glb/Quaternius_modular_women__Casual.glb",
);
const KNIGHT: Onto = onto("KayKit Knight", "glb/KayKit_Knight.glb");
const GODETTE: Onto = onto("Godette", "vrm/Godette_vrm_v4.vrm");
const HUMAN: Onto = ("our human", MotionTarget::Human);

/// The rows of the table, in order: every kind of motion, every kind of character.
pub(super) const CASES: [Case; 24] = [
    case("CMU walk", file(CMU_WALK), MH_MAN).skip(),
    case("CMU walk", file(CMU_WALK), KNIGHT)
        .skip()
        .small()
        .shown(),
    case("CMU jumps", file("bvh/cmu_01_01.amc"), HUMAN).shown(),
    case("FAIR1 dab", file("bvh/fair1_dab.bvh"), MH_WOMAN),
    case("FAIR1 jumping", file("bvh/fair1_jumping.bvh"), MAN).shown(),
    case("FAIR1 zombie", file("bvh/fair1_zombie.bvh"), GODETTE).shown(),
    case("pab run", clip(PAB, "run"), WOMAN).small(),
    case("pab walk", clip(PAB, "walk"), HUMAN),
    case(
        "KayKit running",
        clip(KAYKIT, "Rig_Medium|Running_A"),
        MH_WOMAN,
    ),
    case("KayKit walking", clip(KAYKIT, KAYKIT_WALK), GODETTE).small(),
    case("VRMA idle", file(IDLE), KNIGHT),
    case("VRMA idle", file(IDLE), WOMAN),
    case("BAP walk", MotionSource::Bap(CMU_WALK), MH_MAN),
    case("X3D Jin", file("hanim/HAnimMotion.x3d"), HUMAN),
    case("CMU walk, random zero pose", file(CMU_WALK), MH_MAN)
        .skip()
        .as_variant(Variant::ZeroPose(1)),
    case(
        "FAIR1 dab, random zero pose",
        file("bvh/fair1_dab.bvh"),
        MH_WOMAN,
    )
    .as_variant(Variant::ZeroPose(2)),
    case("pab walk, random zero pose", clip(PAB, "walk"), HUMAN)
        .small()
        .as_variant(Variant::ZeroPose(3)),
    case(
        "KayKit walking, random zero pose",
        clip(KAYKIT, KAYKIT_WALK),
        GODETTE,
    )
    .as_variant(Variant::ZeroPose(4)),
    case("CMU walk, DAZ names", file(CMU_WALK), KNIGHT)
        .skip()
        .as_variant(Variant::DazNames),
    case("MakeHuman dance, DAZ names", file(DANCE), WOMAN).as_variant(Variant::DazNames),
    case(
        "dance, hands alone",
        file("bvh/dance_fingers.bvh"),
        MH_WOMAN,
    )
    .as_variant(Variant::HandsAlone),
    case("MakeHuman dance, hands alone", file(DANCE), GODETTE).as_variant(Variant::HandsAlone),
    case(
        "FAIR1 jumping, 20 m tall",
        file("bvh/fair1_jumping.bvh"),
        MAN,
    )
    .as_variant(Variant::Scaled(12.0)),
    case(
        "pab run, unknown names",
        clip(PAB, "run"),
        onto("pab of half size", PAB),
    )
    .small()
    .as_variant(Variant::UnknownNames),
];

const fn case(motion: &'static str, source: MotionSource, (onto, target): Onto) -> Case {
    Case {
        motion,
        source,
        onto,
        target,
        skip_secs: 0.0,
        variant: Variant::AsRead,
        small: false,
        shown: false,
    }
}

const fn onto(name: &'static str, file: &'static str) -> Onto {
    (name, MotionTarget::File(file))
}

const fn file(name: &'static str) -> MotionSource {
    MotionSource::File(name, "")
}

const fn clip(name: &'static str, clip: &'static str) -> MotionSource {
    MotionSource::File(name, clip)
}

impl Case {
    /// Whether a folder has the files of the case; the repository's own has a part of them.
    pub(super) fn is_in(&self, data: &Path) -> bool {
        let (MotionSource::File(motion, _) | MotionSource::Bap(motion)) = self.source;
        let has = |name: &str| data.join(name).is_file();
        has(motion)
            && match self.target {
                MotionTarget::File(name) => has(name),
                MotionTarget::Human => true,
            }
    }

    const fn skip(self) -> Self {
        Self {
            skip_secs: 0.009,
            ..self
        }
    }

    const fn as_variant(self, variant: Variant) -> Self {
        Self { variant, ..self }
    }

    const fn shown(self) -> Self {
        Self {
            shown: true,
            ..self
        }
    }

    const fn small(self) -> Self {
        Self {
            small: true,
            ..self
        }
    }
}

fn open(data: &Path, name: &str) -> Result<CharacterFile> {
    Ok(articula::fs::open(data.join(name))?)
}

/// The reference human, made once: several motions go onto it.
fn human() -> Result<CharacterFile> {
    static HUMAN: LazyLock<Result<CharacterFile, HumanError>> = LazyLock::new(|| {
        let character = articula_human::human(&HumanOptions::mannequin(12_000))?;
        Ok(CharacterFile::from_character("human", character))
    });
    Ok(HUMAN.clone()?)
}

/// The motion of a case, as the only clip of its character.
pub(super) fn source(data: &Path, case: &Case) -> Result<CharacterFile> {
    let mut actor = match case.source {
        MotionSource::File(name, wanted) => {
            let mut actor = open(data, name)?;
            let clips = &actor.character().clips;
            let index = clips
                .iter()
                .position(|c| wanted.is_empty() || c.name == wanted);
            let index = index.with_context(|| format!("{name}: no clip \"{wanted}\""))?;
            actor.select_clips(&[index]);
            actor
        }
        MotionSource::Bap(name) => bap_of(data, name)?,
    };
    if case.skip_secs > 0.0 {
        skip(&mut actor.clips_mut()[0], case.skip_secs);
    }
    Ok(actor)
}

/// The character of a case.
pub(super) fn target(data: &Path, case: &Case) -> Result<CharacterFile> {
    match case.target {
        MotionTarget::File(name) => {
            let mut actor = open(data, name)?;
            if case.target == KNIGHT.1 {
                // Without shields and other meshes that hide its limbs.
                let names = actor.character().meshes.iter().map(|m| m.name.clone());
                let hidden: Vec<String> = names.filter(|n| !n.starts_with("Knight_")).collect();
                actor.keep_meshes(&[], &hidden)?;
            }
            Ok(actor)
        }
        MotionTarget::Human => human(),
    }
}

/// The first clip of a figure retargeted onto another by the H-Anim map.
pub(super) fn retargeted(from: &CharacterFile, onto: &CharacterFile) -> Result<FittedClip> {
    let options = AddClipsOptions {
        by_names: false,
        clip: from.character().clips.first().map(|c| c.name.clone()),
        ..AddClipsOptions::default()
    };
    let fitted = fit_clips(from, onto, &options)?.pop();
    fitted.context("no clip")
}

/// The motion of a file as body animation parameters: retargeted onto the reference human, sampled,
/// written and read.
fn bap_of(data: &Path, name: &str) -> Result<CharacterFile> {
    let mut from = open(data, name)?;
    skip(&mut from.clips_mut()[0], 0.009);
    let mut human = human()?;
    let fitted = retargeted(&from, &human)?;
    human.set_clips(vec![fitted.clip]);
    let told = bap::sample(human.character(), &human.articulation(), 0, 30.0)?;
    let text = bap::write(&told.clip);
    let mut nothing = |_: &str| Err("nothing lies beside it".to_owned());
    let read = articula::open(&text, "told.bap", &OpenOptions::default(), &mut nothing);
    Ok(read?)
}

/// Removes the beginning of a clip whose keys have one rate.
fn skip(clip: &mut RawClip, secs: f32) {
    let frame_secs = 1.0 / source_rate_hz(clip);
    let start = (secs / frame_secs).round() * frame_secs;
    for channel in &mut clip.channels {
        let first = channel
            .times_secs
            .partition_point(|t| *t < start - 0.5 * frame_secs);
        let first = first.min(channel.times_secs.len() - 1);
        let width = channel.values.len() / channel.times_secs.len();
        channel.times_secs.drain(..first);
        channel.values.drain(..first * width);
        for time in &mut channel.times_secs {
            *time = (*time - start).max(0.0);
        }
    }
    clip.duration_secs -= start;
}
