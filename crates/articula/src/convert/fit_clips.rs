//! Transfer of clips from one file to the character of another.
//!
//! Joints are matched by name if the skeletons are the same, by their H-Anim mapping if both are
//! human, and else by name again, with the motion as change from the rest pose. Morph targets and
//! expressions are matched by name.

use super::morphs;
use super::same_joints::Twins;
use super::same_names::Namesakes;
use crate::error::{Context, Error, Result};
use crate::open::{CharacterFile, ClipProvenance, FittedClip, Format, NameTransfer, choose};
use crate::resampling::{ClipResampling, keyed_mm, told_mm};
use crate::work::Executor;
use articula_build::retarget::{
    RetargetFigure, RetargetOptions, RetargetReport, Retargeter, is_hands_alone, retarget_hands,
};
use articula_build::{bake, sampling_rate_hz};
use articula_core::JointArticulation;
use articula_core::source::{RawClip, Skeleton};
use std::borrow::Cow;
use std::path::Path;

/// Maximum share of a character's main joints that a motion may leave at rest.
const MOST_NOT_DRIVEN: f32 = 0.4;

/// Options for adding clips from other files.
#[derive(Debug, Clone, PartialEq)]
pub struct AddClipsOptions {
    /// Whether the character keeps its own clips.
    pub keep_own: bool,
    /// Name of the clip taken from each file; `None` takes all.
    pub clip: Option<String>,
    /// Prefix of the names of added clips.
    pub prefix: String,
    /// Whether the file name is prepended to clip names if the file has several clips; a single
    /// clip is always named after its file.
    pub file_in_names: bool,
    /// Whether clips of the same skeleton are copied unchanged; if not, all are retargeted.
    pub by_names: bool,
    /// Options for retargeting clips from other skeletons.
    pub retarget: RetargetOptions,
}

impl Default for AddClipsOptions {
    fn default() -> Self {
        Self {
            keep_own: true,
            clip: None,
            prefix: String::new(),
            file_in_names: false,
            by_names: true,
            retarget: RetargetOptions::default(),
        }
    }
}

impl CharacterFile {
    /// Adds the clips of other files to this character, under unique names.
    ///
    /// Clips of the same skeleton are copied; others are retargeted by the H-Anim mapping if both
    /// figures are human, else by the names of their joints. Morph
    /// targets and expressions that both characters have, by name, follow too. There is one job per
    /// file.
    ///
    /// ```no_run
    /// use articula::convert::AddClipsOptions;
    /// use articula::{Executor, fs};
    ///
    /// # fn main() -> articula::Result<()> {
    /// let mut hero = fs::open("hero.glb")?;
    /// let clips = [fs::open("walk.bvh")?, fs::open("idle.glb")?];
    /// hero.add_clips(&clips, &AddClipsOptions::default(), &Executor::default())?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// An [`Error`] that names the file: it has no clip (or not the requested one), or its joints
    /// cannot be matched with the character's ([`Error::Unmapped`]).
    pub fn add_clips(
        &mut self,
        files: &[Self],
        options: &AddClipsOptions,
        work: &Executor<'_>,
    ) -> Result<Vec<ClipProvenance>> {
        if files.is_empty() {
            return Ok(Vec::new());
        }
        let options = AddClipsOptions {
            file_in_names: options.file_in_names || files.len() > 1,
            ..options.clone()
        };
        let fit = |file: &Self| fit_clips(file, self, &options);
        let fitted = work.map("fitting clips", files.iter().collect(), fit)?;
        let fitted = fitted.into_iter().flatten().collect();
        Ok(self.put_clips(fitted, options.keep_own))
    }

    /// Checks that hips, legs and arms are known, either from the file itself or from joint names.
    ///
    /// # Errors
    /// [`Error::Unmapped`] that names the file and the remedy.
    pub fn check_human(&self) -> Result<()> {
        if self.is_human() {
            return Ok(());
        }
        let what = match self.hands() {
            Some(hands) => hands,
            None => "joints: the joint names do not identify hips, legs and arms; give a joint map"
                .to_owned(),
        };
        Err(Error::Unmapped(what)).context(self.name())
    }

    /// What a rig of hands alone has and lacks.
    fn hands(&self) -> Option<String> {
        let joints = &self.mapping().articulation.joints;
        let of = |side: &str| {
            let is_of_side =
                |j: &&JointArticulation| j.hanim.as_deref().is_some_and(|n| n.starts_with(side));
            joints.iter().filter(is_of_side).count()
        };
        let hands = match (of("l_"), of("r_")) {
            (0, right) => format!("the right hand alone ({right} joints)"),
            (left, 0) => format!("the left hand alone ({left} joints)"),
            (left, right) => format!("two hands alone ({left} and {right} joints)"),
        };
        let is_it = self.mapping().is_hands_alone() && !self.is_human();
        is_it.then(|| {
            format!(
                "joints: the rig is {hands}; hips, legs and the rest of a body are missing, and without \
                 two knuckles of a hand its motion cannot be retargeted onto a body"
            )
        })
    }

    fn is_human(&self) -> bool {
        self.mapping().humanoid || self.character().articulation.is_some()
    }
}

/// Transfers clips of a file to the character of another, which is not changed;
/// [`CharacterFile::put_clips`] adds the result.
///
/// # Errors
/// See [`CharacterFile::add_clips`].
pub fn fit_clips(
    file: &CharacterFile,
    character: &CharacterFile,
    options: &AddClipsOptions,
) -> Result<Vec<FittedClip>> {
    let clips = chosen(file, options).with_context(|| file.name())?;
    let (from, onto) = (&file.character().skeleton, &character.character().skeleton);
    let same = || Twins::of(from, &clips, onto);
    let articulations = (file.articulation(), character.articulation());
    let from_figure = RetargetFigure {
        skeleton: from,
        articulation: &articulations.0,
        clips: &file.character().clips,
    };
    let onto_figure = RetargetFigure {
        skeleton: onto,
        articulation: &articulations.1,
        clips: &character.character().clips,
    };
    // The rest of a motion in FBX may be its first frame.
    let is_posed = file.format() == Format::Fbx && file.character().meshes.is_empty();
    let posed = || Twins::of_posed(from, &clips, onto);
    let is_hands = file.hands().is_some() && is_hands_alone(&from_figure);
    let way = if let Some(twins) = options.by_names.then(same).flatten() {
        Fitting::Names(twins)
    } else if let Some(twins) = (options.by_names && is_posed).then(posed).flatten() {
        Fitting::Posed(twins, from, onto)
    } else if is_hands && character.is_human() {
        Fitting::Hands(from_figure, onto_figure)
    } else if let Some(namesakes) = namesakes(file, character, &clips)? {
        Fitting::Namesakes(namesakes)
    } else {
        let retargeter = Retargeter::new(from_figure, onto_figure).with_context(|| file.name())?;
        check_driven(&retargeter).context(file.name())?;
        Fitting::Map(Box::new(retargeter))
    };
    let fitted = clips.into_iter().map(|clip| {
        let place = || format!("{}: clip \"{}\"", file.name(), clip.name);
        let Moved {
            clip: mut new,
            retargeted,
            by_name,
        } = way.joints(clip, options).with_context(place)?;
        new.name = name(file, clip, options);
        let morphs = morphs::channels(file.character(), clip, character.character());
        let morph_channels = morphs.len();
        new.channels.extend(morphs);
        if new.channels.is_empty() {
            let what = "the clip animates no joint or morph target of the character; give a clip \
                        made for it";
            return Err(Error::unsuited(what)).with_context(place);
        }
        let clip_there = match bake(character.character(), &new).with_context(place)? {
            Cow::Owned(baked) => baked,
            Cow::Borrowed(_) => new,
        };
        let resampling = match &retargeted {
            Some(_) => Some(resampling(file, clip, options).with_context(place)?),
            None => None,
        };
        Ok(FittedClip {
            fit: ClipProvenance {
                name: clip_there.name.clone(),
                file: file.name().to_owned(),
                from: clip.name.clone(),
                morph_channels,
                resampling,
                retargeted,
                by_name,
            },
            clip: clip_there,
        })
    });
    fitted.collect()
}

/// How far the frames that are retargeted are from the keys of a clip.
fn resampling(
    file: &CharacterFile,
    clip: &RawClip,
    options: &AddClipsOptions,
) -> Result<ClipResampling> {
    let character = file.character();
    let own = || sampling_rate_hz(clip, &character.skeleton);
    let rate_hz = options.retarget.rate_hz.unwrap_or_else(own);
    Ok(ClipResampling {
        clip: clip.name.clone(),
        rate_hz: Some(rate_hz),
        resampling_mm: keyed_mm(character, clip, rate_hz)?,
        told_mm: told_mm(&character.skeleton),
    })
}

/// Method by which joints of a file drive those of the character.
enum Fitting<'a> {
    Names(Twins),
    Posed(Twins, &'a Skeleton, &'a Skeleton),
    Hands(RetargetFigure<'a>, RetargetFigure<'a>),
    Namesakes(Namesakes<'a>),
    Map(Box<Retargeter<'a>>),
}

/// The joint motion of a clip on the character; the clip has no name.
struct Moved {
    clip: RawClip,
    retargeted: Option<RetargetReport>,
    by_name: Option<NameTransfer>,
}

impl Fitting<'_> {
    /// Transfers the joint motion.
    fn joints(&self, clip: &RawClip, options: &AddClipsOptions) -> Result<Moved> {
        let moved = |clip| Moved {
            clip,
            retargeted: None,
            by_name: None,
        };
        Ok(match self {
            Self::Names(twins) => {
                let channels = clip.channels.iter().filter_map(|c| twins.channel(c));
                moved(RawClip {
                    name: String::new(),
                    duration_secs: clip.duration_secs,
                    channels: channels.collect(),
                })
            }
            Self::Posed(twins, from, onto) => {
                let mut channels = twins.held(from, clip, onto);
                channels.extend(clip.channels.iter().filter_map(|c| twins.channel(c)));
                moved(RawClip {
                    name: String::new(),
                    duration_secs: clip.duration_secs,
                    channels,
                })
            }
            Self::Namesakes(namesakes) => {
                let (clip, report) = namesakes.transfer(clip);
                Moved {
                    by_name: Some(report),
                    ..moved(clip)
                }
            }
            Self::Hands(hands, body) => {
                let made = retarget_hands(hands, body, clip, &options.retarget)?;
                Moved {
                    retargeted: Some(made.report),
                    ..moved(made.clip)
                }
            }
            Self::Map(retargeter) => {
                let made = retargeter.retarget(clip, &options.retarget)?;
                Moved {
                    retargeted: Some(made.report),
                    ..moved(made.clip)
                }
            }
        })
    }
}

/// The joints of the same names, if the figures are not both human; `None` if they are.
///
/// # Errors
/// [`Error::Unmapped`] if too few of the moving joints have a joint of the same name.
fn namesakes<'a>(
    file: &'a CharacterFile,
    character: &'a CharacterFile,
    clips: &[&RawClip],
) -> Result<Option<Namesakes<'a>>> {
    let Some(unknown) = [character, file].into_iter().find(|o| !o.is_human()) else {
        return Ok(None);
    };
    // Hands have the names of a body's hands, but their wrists move freely.
    if character.is_human() && file.hands().is_some() {
        file.check_human()?;
    }
    let (from, onto) = (&file.character().skeleton, &character.character().skeleton);
    let namesakes = Namesakes::of(from, onto);
    if namesakes.are_useful(clips) {
        return Ok(Some(namesakes));
    }
    let (there, moving) = namesakes.coverage(clips);
    let what = format!(
        "joints: the joint names do not identify hips, legs and arms, and only {there} of the \
         {moving} moving joints of {} have a joint of the same name in {}; give a joint map",
        file.name(),
        character.name()
    );
    Err(Error::Unmapped(what)).context(unknown.name())
}

/// Checks that the motion drives enough of the character.
fn check_driven(retargeter: &Retargeter<'_>) -> Result<()> {
    let missing = retargeter.not_driven();
    if missing.share <= MOST_NOT_DRIVEN {
        return Ok(());
    }
    let what = format!(
        "joints: too few of the figure of the motion are known to move the character: nothing drives \
         {}; give a joint map",
        missing.joints.join(", ")
    );
    Err(Error::Unmapped(what))
}

/// The selected clips of a file.
fn chosen<'a>(file: &'a CharacterFile, options: &AddClipsOptions) -> Result<Vec<&'a RawClip>> {
    let clips = &file.character().clips;
    if clips.is_empty() {
        let what = "clips: the file has no clip to add to the character";
        return Err(Error::unsuited(what));
    }
    let Some(name) = &options.clip else {
        return Ok(clips.iter().collect());
    };
    let index = choose("clip", name, clips.iter().map(|c| c.name.as_str()))?;
    Ok(vec![&clips[index]])
}

/// Name of a transferred clip: the file's name if it has one clip, else the clip's own name, with
/// the file's name in front on request.
fn name(file: &CharacterFile, clip: &RawClip, options: &AddClipsOptions) -> String {
    let stem = Path::new(file.name()).file_stem().unwrap_or_default();
    let stem = stem.to_string_lossy();
    let prefix = &options.prefix;
    if file.character().clips.len() == 1 {
        format!("{prefix}{stem}")
    } else if options.file_in_names {
        format!("{prefix}{stem} {}", clip.name)
    } else {
        format!("{prefix}{}", clip.name)
    }
}
