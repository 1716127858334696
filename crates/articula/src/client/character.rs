//! A character as far as it is here, and what is shown of it.

use super::order::CharacterPlan;
use super::report::CharacterReport;
use crate::error::Result;
use crate::figure::Figure;
use crate::item::{ItemChange, ItemReceiver, PartKind};
use articula_core::Clip;
use articula_core::crowd::{CharacterState, ClipState};
use articula_core::joint_state::{LoaRange, TransitionOptions};
use articula_core::playback::{FigureModel, FigurePlayer, FigureViews, FullDetail, LoaController};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Time in which a refined motion takes the place of the one before, seconds.
const REFINEMENT_SECS: f32 = 0.2;
/// Least time between two figures of a character, seconds: making one takes longer than a frame.
const REMAKE_SECS: f64 = 0.25;

/// Level of articulation at level 0 of the articulation of a rig.
const FINEST_LOA: u32 = 5;

/// A character of a client.
#[derive(Debug)]
pub struct ClientCharacter {
    pub(super) name: String,
    pub(super) importance: f64,
    pub(super) distance_m: Option<f64>,
    pub(super) clip: Option<String>,
    /// Where its motion begins, seconds.
    start_secs: f64,
    pub(super) receiver: Option<ItemReceiver>,
    /// BLAKE3 of the manifest, 64 hexadecimal digits; empty before there is one.
    pub(super) manifest: String,
    /// Whether the manifest is that of the whole item.
    pub(super) is_whole: bool,
    /// Bytes that arrived, without manifests.
    pub(super) bytes: u64,
    /// Number of times at which playback waits.
    pub(super) stalls: u64,
    /// Why the server sends nothing of it, or nothing more.
    pub(super) fault: Option<String>,
    /// What changed since the figure and the motions were made.
    changed: Changed,
    shown: Option<Shown>,
    version: u64,
    /// For each piece of the plan whether it is there.
    there: Option<Vec<bool>>,
    /// What is shown, in numbers: a figure is made anew a little after its bytes have come. With the access unit
    /// that it is about; nothing if other pieces are there since.
    described: CharacterReport,
    described_unit: Option<Option<usize>>,
    is_waiting: bool,
    /// Whether a later stage of the item is received, and what plays is not there of it.
    is_renewed: bool,
}

#[derive(Debug, Default)]
struct Changed {
    figure: bool,
    motions: BTreeSet<usize>,
}

/// What is shown of a character.
#[derive(Debug)]
struct Shown {
    figure: Arc<Figure>,
    player: FigurePlayer,
    articulation: LoaController<FullDetail>,
    made_secs: f64,
}

impl ClientCharacter {
    pub(super) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            importance: 1.0,
            distance_m: None,
            clip: None,
            start_secs: 0.0,
            receiver: None,
            manifest: String::new(),
            is_whole: false,
            bytes: 0,
            stalls: 0,
            fault: None,
            changed: Changed::default(),
            shown: None,
            version: 0,
            there: None,
            described: CharacterReport::default(),
            described_unit: None,
            is_waiting: false,
            is_renewed: false,
        }
    }

    /// Returns its name at the server.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns its distance from the camera, if it has one of its own.
    pub fn distance_m(&self) -> Option<f64> {
        self.distance_m
    }

    /// Returns why the server sends nothing of it, or nothing more: it is unknown there, cannot be packaged, or
    /// has nothing for the context.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Returns the receiver of its item, once there is a manifest.
    pub fn receiver(&self) -> Option<&ItemReceiver> {
        self.receiver.as_ref()
    }

    /// Returns the figure that is shown: mesh, textures, rig. It is replaced when finer ones have arrived.
    pub fn figure(&self) -> Option<&Arc<Figure>> {
        self.shown.as_ref().map(|shown| &shown.figure)
    }

    /// Returns how often the figure was replaced, to know when what is made of it must be made anew.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Returns the player, with the pose of the last frame.
    pub fn player(&self) -> Option<&FigurePlayer> {
        self.shown.as_ref().map(|shown| &shown.player)
    }

    /// Returns the form in 2D that is shown as long as there is no figure: its file and bytes.
    pub fn flat(&self) -> Option<(&str, &[u8])> {
        let receiver = self.receiver.as_ref().filter(|_| self.shown.is_none())?;
        let mut forms = receiver.manifest().flat.iter();
        forms.find_map(|form| Some((&*form.file, receiver.file(&form.file)?)))
    }

    /// Time within the motion that plays, seconds.
    pub fn position_secs(&self) -> f64 {
        let state = self.player().and_then(FigurePlayer::state);
        state.map_or(self.start_secs, |state| f64::from(playing(state).secs()))
    }

    /// Notes what bytes changed.
    pub(super) fn note(&mut self, change: &ItemChange) {
        self.there = None;
        match change {
            ItemChange::Nothing => {}
            ItemChange::Motion { part, .. } => {
                self.changed.motions.insert(*part);
            }
            ItemChange::Figure
            | ItemChange::Mesh { .. }
            | ItemChange::Texture { .. }
            | ItemChange::File => self.changed.figure = true,
        }
    }

    /// Notes whether the manifest is that of the whole item: then no earlier state of it comes again.
    pub(super) fn set_whole(&mut self, is_whole: bool) {
        self.is_whole = is_whole;
        if let Some(receiver) = self.receiver.as_mut().filter(|_| is_whole) {
            receiver.settle();
        }
    }

    /// Notes that a later state of the item is received.
    pub(super) fn note_stage(&mut self) {
        self.there = None;
        self.changed.figure = true;
        self.is_renewed = true;
    }

    /// Notes that other pieces may be there, or others asked for.
    pub(super) fn note_plan(&mut self) {
        self.there = None;
    }

    /// Moves time on: plays, unless what comes next is not there, and shows what has arrived.
    pub(super) fn frame(
        &mut self,
        plan: Option<&CharacterPlan>,
        now_secs: f64,
        dt_secs: f64,
        level: usize,
    ) -> Result<()> {
        let Some(plan) = plan else {
            return Ok(());
        };
        self.update_there(plan);
        let ahead = self.position_secs() + dt_secs;
        let is_ready = plan.is_ready(self.there.as_deref().unwrap_or_default(), ahead);
        if is_ready {
            self.is_renewed = false;
            self.refresh(now_secs)?;
        }
        // What a stage before had plays on until this one has it.
        let plays = is_ready || self.is_renewed;
        if self.shown.is_some() && !plays && !self.is_waiting {
            self.stalls += 1;
        }
        self.is_waiting = !plays;
        let there = self.there.as_deref().unwrap_or_default();
        let unit = plan.unit(ahead);
        let is_shown = self.shown.is_some() && !self.changed.figure;
        if is_shown && self.described_unit != Some(unit) {
            self.described = plan.describe(there, ahead);
            self.described.is_complete &= self.is_whole;
            self.described_unit = Some(unit);
        }
        // What was not sent rests, and costs nothing.
        let sent = plan
            .loa(there, ahead)
            .map_or(0, |loa| FINEST_LOA.saturating_sub(loa) as usize);
        if let Some(shown) = &mut self.shown {
            let dt_secs = if plays { dt_secs } else { 0.0 };
            shown.player.advance(dt_secs as f32, &mut |_| {});
            shown.articulation.request(level.max(sent));
            let views = FigureViews::Cameras(&[]);
            shown.player.control(&mut shown.articulation, views);
        }
        Ok(())
    }

    /// Makes figure and motions anew of what has arrived.
    fn refresh(&mut self, now_secs: f64) -> Result<()> {
        let Some(receiver) = &self.receiver else {
            return Ok(());
        };
        let last = self.shown.as_ref().map(|shown| shown.made_secs);
        let is_due = last.is_none_or(|last| now_secs - last >= REMAKE_SECS);
        if (self.changed.figure || self.shown.is_none()) && is_due {
            let figure = Arc::new(Figure::new(receiver.character()?)?);
            self.changed = Changed::default();
            self.show(figure, now_secs)?;
        } else if let (Some(shown), false) = (&mut self.shown, self.changed.motions.is_empty()) {
            let parts = std::mem::take(&mut self.changed.motions);
            let model = shown.player.model();
            let mut clips = model.clips().to_vec();
            for part in parts {
                // A motion that is new belongs to another figure, and a face is fitted to one.
                let is_refined = receiver
                    .clip(part)
                    .is_some_and(|clip| refine(&mut clips, clip));
                self.changed.figure |= !is_refined;
            }
            let model = FigureModel::new(Arc::clone(model.rig()), clips)?;
            if shown.player.set_model(model, REFINEMENT_SECS).is_err() {
                self.changed.figure = true;
            }
        }
        Ok(())
    }

    /// Shows another figure: the motion goes on where it was.
    fn show(&mut self, figure: Arc<Figure>, now_secs: f64) -> Result<()> {
        let asset = &figure.asset;
        let rig = Arc::clone(&asset.rig);
        let mut clips = asset.clips.to_vec();
        if let Some(receiver) = &self.receiver {
            let parts = receiver.manifest().parts.iter().enumerate();
            for (part, _) in parts.filter(|(_, part)| part.kind == PartKind::BodyMotion) {
                if let Some(clip) = receiver.clip(part) {
                    refine(&mut clips, clip);
                }
            }
        }
        let wanted = self.clip.as_deref();
        let named = clips.iter().position(|clip| Some(&*clip.name) == wanted);
        let position = self.position_secs();
        let model = FigureModel::new(rig, clips)?;
        let known = self.shown.take();
        let (mut player, articulation) = match known {
            Some(known) if **known.player.model().rig() == **model.rig() => {
                let mut player = known.player;
                // Other clips than before are another model.
                if player.set_model(model.clone(), REFINEMENT_SECS).is_err() {
                    player = FigurePlayer::new(model, &asset.mesh.morph_weights);
                }
                (player, known.articulation)
            }
            _ => {
                let range = LoaRange::named(&asset.rig, 0);
                let options = TransitionOptions::default();
                let articulation =
                    LoaController::new(&asset.rig, range, options, FullDetail::default());
                (
                    FigurePlayer::new(model, &asset.mesh.morph_weights),
                    articulation,
                )
            }
        };
        if let Some(clip) = named.or((!player.model().clips().is_empty()).then_some(0)) {
            let state = ClipState::new(&**player.model(), clip);
            let state = state.at_secs(&**player.model(), position as f32);
            if player.state().is_none_or(|now| *playing(now) != state) {
                player.play(state);
            }
        }
        self.version += 1;
        self.shown = Some(Shown {
            figure,
            player,
            articulation,
            made_secs: now_secs,
        });
        Ok(())
    }

    /// Plays another motion from a time within it on.
    pub(super) fn play(&mut self, clip: Option<&str>, from_secs: f64) {
        self.clip = clip.map(str::to_owned);
        self.start_secs = from_secs;
        let Some(shown) = &mut self.shown else { return };
        let model = Arc::clone(shown.player.model());
        let named = model.clips().iter().position(|c| Some(&*c.name) == clip);
        if let Some(clip) = named.or((!model.clips().is_empty()).then_some(0)) {
            let state = ClipState::new(&*model, clip).at_secs(&*model, from_secs as f32);
            shown.player.fade_to(state, REFINEMENT_SECS);
        }
    }

    fn update_there(&mut self, plan: &CharacterPlan) {
        if self.there.is_none() {
            self.described_unit = None;
            let held = self.receiver.as_ref().map(ItemReceiver::held);
            self.there = Some(plan.there(&held.unwrap_or_default()));
        }
    }

    /// What is shown, in numbers.
    pub(super) fn report(&self) -> CharacterReport {
        CharacterReport {
            bytes: self.bytes,
            stalls: self.stalls,
            ..self.described.clone()
        }
    }
}

/// The clip that plays, or is faded to.
fn playing(state: &CharacterState) -> &ClipState {
    state.next().unwrap_or(state.clip_state())
}

/// Puts a motion in the place of the one of its name; returns whether there is one.
fn refine(clips: &mut [Clip], clip: Clip) -> bool {
    let known = clips.iter_mut().find(|known| known.name == clip.name);
    known.map(|known| *known = clip).is_some()
}
