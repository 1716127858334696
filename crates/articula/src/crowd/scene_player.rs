//! Playback of a scene, frame by frame.
//!
//! Adds to a [`CrowdPlayer`] what a scene defines: positions, cameras, and repeated cross-fades.

use super::asset::CrowdAsset;
use super::hidden::{Hidden, Hiders};
use super::player::CrowdPlayer;
use crate::error::{Error, Result};
use articula_build::{ClipPlayback, CrossFade, Scene};
use articula_core::crowd::{
    CacheUse, CharacterState, ClipState, CrowdReport, CrowdSection, Culling, Detail,
};
use articula_core::visibility::View;
use articula_core::{Camera, ClipSet};

/// Time by which the camera path is sampled ahead, so that characters are updated before they
/// become visible.
const AHEAD_SECS: f64 = 0.25;

/// Level-of-detail goal of a crowd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DetailGoal {
    /// Full detail for all characters, visible or not.
    Full,
    /// One level for all visible characters.
    Level(usize),
    /// The coarsest level within an error in pixels.
    Tolerance(f32),
    /// The least tolerance within a time per frame, which
    /// [`ScenePlayer::set_tolerance`] sets before each frame.
    Budget {
        /// Processor time per frame, in milliseconds.
        ms: f32,
        /// Error above which the time does not suffice, in pixels.
        cap_px: f32,
    },
}

/// Options of [`ScenePlayer`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Level-of-detail goal.
    pub detail: DetailGoal,
    /// Whether characters may share poses within their tolerance.
    pub share: bool,
    /// Processor that blends cached poses.
    pub cache: CacheUse,
    /// What hides characters.
    pub hiders: Hiders,
}

/// A crowd that follows a scene.
#[derive(Debug)]
pub struct ScenePlayer<'a> {
    scene: &'a Scene,
    player: CrowdPlayer,
    detail: DetailGoal,
    secs: f64,
    fades: Vec<Turning>,
    /// Role of each character now; empty where nobody ever has one.
    roles: Vec<Option<u16>>,
    /// Number of cues that have passed.
    cues: usize,
    hidden: Option<Hidden>,
}

/// A cross-fade that alternates between two clips.
#[derive(Debug, Clone, Copy)]
struct Turning {
    character: usize,
    own: ClipPlayback,
    fade: CrossFade,
    /// Whether it fades to the second clip, as opposed to back.
    goes: bool,
}

impl<'a> ScenePlayer<'a> {
    /// Creates the crowd in its state at time 0.
    ///
    /// # Errors
    /// An [`Error`] if the palettes would take too much memory.
    pub fn new(asset: &CrowdAsset, scene: &'a Scene, options: SceneOptions) -> Result<Self> {
        let mut player = CrowdPlayer::new(asset, scene.members.len())?;
        let clips = &asset.model().parts().clips;
        let mut fades = Vec::new();
        for (character, member) in scene.members.iter().enumerate() {
            player.place(character, member.position, member.yaw_radians);
            let own = clip_state(clips, &member.play, 0.0);
            let Some(fade) = member.cross_fade else {
                player.crowd_mut().play(character, own.into());
                continue;
            };
            let turning = Turning {
                character,
                own: member.play,
                fade,
                goes: fade.start.rem_euclid(1.0) < 0.5,
            };
            player.crowd_mut().play(character, turning.start(clips));
            if fade.fade_secs > 0.0 {
                fades.push(turning);
            }
        }
        match options.detail {
            DetailGoal::Full => player.detail = Detail::Full,
            DetailGoal::Level(level) => player.detail = Detail::Level(level),
            DetailGoal::Tolerance(px) => player.detail = Detail::Tolerance { px },
            DetailGoal::Budget { cap_px, .. } => player.detail = Detail::Tolerance { px: cap_px },
        }
        player.share = options.share;
        player.cache = options.cache;
        let importance = &scene.importance;
        let mut roles = Vec::new();
        if !importance.is_neutral() {
            roles.clone_from(&importance.role_of);
            roles.resize(scene.members.len(), None);
            for (character, (member, role)) in scene.members.iter().zip(&roles).enumerate() {
                player.set_importance(character, importance.of(member, *role));
            }
        }
        Ok(Self {
            scene,
            hidden: Hidden::new(asset, scene, options.hiders)?,
            player,
            detail: options.detail,
            secs: 0.0,
            fades,
            roles,
            cues: 0,
        })
    }

    /// Returns the crowd.
    pub fn player(&self) -> &CrowdPlayer {
        &self.player
    }

    /// Returns the crowd, to be evaluated.
    pub fn player_mut(&mut self) -> &mut CrowdPlayer {
        &mut self.player
    }

    /// Returns the role of a character now, as an index into the roles of the scene.
    pub fn role(&self, character: usize) -> Option<usize> {
        let role = self.roles.get(character).copied().flatten()?;
        Some(usize::from(role))
    }

    /// Returns the number of characters that were wholly hidden in the last frame.
    pub fn hidden(&self) -> usize {
        self.hidden.as_ref().map_or(0, Hidden::count)
    }

    /// Returns the time of the scene in seconds.
    pub fn secs(&self) -> f64 {
        self.secs
    }

    /// Returns the camera at the current time.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has none.
    pub fn camera(&self) -> Result<Camera> {
        let camera = self.scene.camera_at(self.secs);
        camera.ok_or_else(|| Error::unsuited("the scene has no camera"))
    }

    /// Sets the tolerance of the next frames in pixels.
    pub fn set_tolerance(&mut self, px: f32) {
        self.player.detail = Detail::Tolerance { px };
    }

    /// Advances by `dt_secs` seconds and plans the frame.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has no camera.
    pub fn plan(&mut self, dt_secs: f64) -> Result<CrowdReport> {
        self.plan_by(dt_secs, |player, dt_secs, culling| {
            player.plan(dt_secs, culling, &mut |_| ())
        })
    }

    /// [`plan`](Self::plan) on several threads, as [`CrowdPlayer::plan_on`].
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn plan_on(
        &mut self,
        dt_secs: f64,
        run: impl FnOnce(&mut [CrowdSection], &(dyn Fn(&mut CrowdSection) + Sync)),
    ) -> Result<CrowdReport> {
        self.plan_by(dt_secs, |player, dt_secs, culling| {
            player.plan_on(dt_secs, culling, &mut |_| (), run)
        })
    }

    fn plan_by(
        &mut self,
        dt_secs: f64,
        plan: impl FnOnce(&mut CrowdPlayer, f32, Culling<'_>) -> CrowdReport,
    ) -> Result<CrowdReport> {
        self.secs += dt_secs;
        let camera = self.camera()?;
        let (way, turn) = self.ahead(&camera);
        self.turn_fades();
        self.change_roles();
        let occluded = match &mut self.hidden {
            Some(hidden) => hidden.look(&camera, &self.player),
            None => &[],
        };
        let view = View::of(&camera).with_cull_margin(way, turn);
        let views = [view.with_occluded(occluded)];
        let culling = match self.detail {
            DetailGoal::Full => Culling::Off,
            _ => Culling::Views(&views),
        };
        Ok(plan(&mut self.player, dt_secs as f32, culling))
    }

    /// Distance and angle that the camera moves in the time ahead, in metres and radians.
    fn ahead(&self, camera: &Camera) -> (f32, f32) {
        let Some(later) = self.scene.camera_at(self.secs + AHEAD_SECS) else {
            return (0.0, 0.0);
        };
        if later.eye == camera.eye && later.orientation == camera.orientation {
            return (0.0, 0.0);
        }
        let way = later.eye.distance(camera.eye);
        (way, later.orientation.angle_between(camera.orientation))
    }

    /// Changes the roles of the cues up to the current time.
    fn change_roles(&mut self) {
        let importance = &self.scene.importance;
        let due = importance.cues[self.cues..].iter();
        for cue in due.take_while(|cue| cue.secs <= self.secs) {
            for character in cue.members.iter().map(|m| *m as usize) {
                self.roles[character] = cue.role;
                let member = &self.scene.members[character];
                let value = importance.of(member, cue.role);
                self.player.set_importance(character, value);
            }
            self.cues += 1;
        }
    }

    /// Reverses cross-fades that are complete.
    fn turn_fades(&mut self) {
        for turning in &mut self.fades {
            if self
                .player
                .crowd()
                .state(turning.character)
                .next()
                .is_none()
            {
                turning.goes = !turning.goes;
                let next = turning.next(&self.player.asset().model().parts().clips, self.secs);
                let fade_secs = turning.fade.fade_secs;
                let crowd = self.player.crowd_mut();
                crowd.fade_to(turning.character, next, fade_secs);
            }
        }
    }
}

impl Turning {
    /// Clip states at time 0.
    fn start(&self, clips: &ClipSet) -> CharacterState {
        let own = clip_state(clips, &self.own, 0.0);
        let other = clip_state(clips, &self.fade.other, 0.0);
        let share = self.fade.share(0.0);
        if self.fade.fade_secs > 0.0 && self.goes {
            CharacterState::fading(own, other, share, self.fade.fade_secs)
        } else if self.fade.fade_secs > 0.0 {
            CharacterState::fading(other, own, 1.0 - share, self.fade.fade_secs)
        } else {
            CharacterState::blend(own, other, share)
        }
    }

    /// Target of the next cross-fade.
    fn next(&self, clips: &ClipSet, secs: f64) -> ClipState {
        let play = if self.goes {
            &self.fade.other
        } else {
            &self.own
        };
        clip_state(clips, play, secs)
    }
}

/// State of a clip at a time of the scene.
fn clip_state(clips: &ClipSet, play: &ClipPlayback, secs: f64) -> ClipState {
    let duration = clips.duration_secs(play.clip);
    let secs = play.clip_secs(secs, duration) as f32;
    ClipState::new(clips, play.clip)
        .at_speed(play.speed)
        .at_secs(clips, secs)
}
