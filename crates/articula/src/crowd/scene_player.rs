//! Playback of a scene, frame by frame.
//!
//! Adds to the [`CrowdPlayer`]s of its characters, one crowd for each of the cast, what a scene defines:
//! positions, cameras, roles, and repeated cross-fades.

use super::asset::CrowdAsset;
use super::hidden::{Hidden, Hiders};
use super::lod_error::ErrorView;
use super::player::CrowdPlayer;
use super::scene_cast::MAX_VIEWS;
use crate::error::{Error, Result};
use articula_build::{ClipPlayback, CrossFade, Scene, SceneView};
use articula_core::crowd::{
    Allowance, Budget, CacheUse, CharacterState, ClipState, CrowdReport, CrowdSection, Culling,
    Detail,
};
use articula_core::visibility::View;
use articula_core::{Camera, ClipSet};
use std::sync::Arc;

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
    /// A tolerance as long as it fits a time per frame, and the least one that does where it does not:
    /// [`ScenePlayer::allow`] sets it before each frame.
    Budget {
        /// Processor time per frame, in milliseconds.
        ms: f32,
        /// Error that should not be exceeded, in pixels.
        cap_px: f32,
    },
}

/// Options of [`ScenePlayer`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Level-of-detail goal.
    pub detail: DetailGoal,
    /// Processor that blends cached poses.
    pub cache: CacheUse,
    /// What hides characters.
    pub hiders: Hiders,
}

/// The crowds of a scene, one for each character of its cast. Owns them, and shares the scene.
#[derive(Debug)]
pub struct ScenePlayer {
    scene: Arc<Scene>,
    crowds: Vec<CrowdPlayer>,
    /// Index in the scene of each character of each crowd.
    members: Vec<Vec<u32>>,
    /// Crowd and character of each member of the scene.
    places: Vec<(u16, u32)>,
    detail: DetailGoal,
    secs: f64,
    fades: Vec<Turning>,
    /// Role of each member now; empty where nobody ever has one.
    roles: Vec<Option<u16>>,
    /// Number of cues that have passed.
    cues: usize,
    hidden: Option<Hidden>,
}

/// A cross-fade that alternates between two clips.
#[derive(Debug, Clone, Copy)]
struct Turning {
    crowd: usize,
    character: usize,
    own: ClipPlayback,
    fade: CrossFade,
    /// Whether it fades to the second clip, as opposed to back.
    goes: bool,
}

impl ScenePlayer {
    /// Creates the crowds in their state at time 0. `cast` has the asset of each character of the cast.
    ///
    /// # Errors
    /// An [`Error`] if a character of the scene is not in the cast, the scene has more than [`MAX_VIEWS`]
    /// views, or the palettes would take too much memory.
    pub fn new(
        cast: &[CrowdAsset],
        scene: impl Into<Arc<Scene>>,
        options: SceneOptions,
    ) -> Result<Self> {
        let scene = scene.into();
        if scene.views.len() > MAX_VIEWS {
            return Err(Error::unsuited(format!(
                "the scene has {} views, at most {MAX_VIEWS}",
                scene.views.len()
            )));
        }
        let mut members = vec![Vec::new(); cast.len()];
        let mut places = Vec::with_capacity(scene.members.len());
        for (i, member) in scene.members.iter().enumerate() {
            let Some(of_crowd) = members.get_mut(usize::from(member.character)) else {
                let (which, count) = (member.character, cast.len());
                return Err(Error::unsuited(format!(
                    "members[{i}]: character {which} of a cast of {count}"
                )));
            };
            places.push((member.character, of_crowd.len() as u32));
            of_crowd.push(i as u32);
        }
        let crowds = cast.iter().zip(&members);
        let crowds = crowds.map(|(asset, members)| CrowdPlayer::new(asset, members.len()));
        let mut crowds = crowds.collect::<Result<Vec<_>>>()?;
        let detail = match options.detail {
            DetailGoal::Full => Detail::Full,
            DetailGoal::Level(level) => Detail::Level(level),
            DetailGoal::Tolerance(px) => Detail::Tolerance { px },
            DetailGoal::Budget { cap_px, .. } => Detail::Tolerance { px: cap_px },
        };
        for crowd in &mut crowds {
            crowd.detail = detail;
            crowd.cache = options.cache;
        }
        let mut made = Self {
            hidden: Hidden::new(&crowds, &scene, options.hiders)?,
            scene,
            crowds,
            members,
            places,
            detail: options.detail,
            secs: 0.0,
            fades: Vec::new(),
            roles: Vec::new(),
            cues: 0,
        };
        made.place_members();
        Ok(made)
    }

    /// Places the members and starts their clips.
    fn place_members(&mut self) {
        let importance = &self.scene.importance;
        if !importance.is_neutral() {
            self.roles.clone_from(&importance.role_of);
            self.roles.resize(self.scene.members.len(), None);
        }
        for (i, (member, place)) in self.scene.members.iter().zip(&self.places).enumerate() {
            let (crowd, character) = (usize::from(place.0), place.1 as usize);
            let player = &mut self.crowds[crowd];
            player.place(character, member.position, member.yaw_radians);
            if member.scale != 1.0 {
                player.set_scale(character, member.scale);
            }
            if let Some(role) = self.roles.get(i) {
                player.set_importance(character, importance.of(member, *role));
            }
            let clips = &player.asset().model().parts().clips;
            let mut state = clip_state(clips, &member.play, 0.0).into();
            if let Some(fade) = member.cross_fade {
                let turning = Turning {
                    crowd,
                    character,
                    own: member.play,
                    fade,
                    goes: fade.start.rem_euclid(1.0) < 0.5,
                };
                state = turning.start(clips);
                if fade.fade_secs > 0.0 {
                    self.fades.push(turning);
                }
            }
            player.crowd_mut().play(character, state);
        }
    }

    /// Returns the scene that is played.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Returns the crowds, one for each character of the cast, in its order.
    pub fn crowds(&self) -> &[CrowdPlayer] {
        &self.crowds
    }

    /// Returns the crowds, to be evaluated.
    pub fn crowds_mut(&mut self) -> &mut [CrowdPlayer] {
        &mut self.crowds
    }

    /// Returns the index in the scene of a character of a crowd.
    ///
    /// # Panics
    /// If there is no such crowd or character.
    pub fn member(&self, crowd: usize, character: usize) -> usize {
        self.members[crowd][character] as usize
    }

    /// Returns the crowd of a member of the scene, and its index among the characters of that.
    ///
    /// # Panics
    /// If there is no such member.
    pub fn place(&self, member: usize) -> (usize, usize) {
        let (crowd, character) = self.places[member];
        (usize::from(crowd), character as usize)
    }

    /// Returns the role of a member of the scene now, as an index into the roles of the scene.
    pub fn role(&self, member: usize) -> Option<usize> {
        let role = self.roles.get(member).copied().flatten()?;
        Some(usize::from(role))
    }

    /// Returns the number of characters that were wholly hidden in the last frame.
    pub fn hidden(&self) -> usize {
        let hidden = self.hidden.as_ref();
        hidden.map_or(0, |hidden| hidden.count(&self.crowds))
    }

    /// Returns the time of the scene in seconds.
    pub fn secs(&self) -> f64 {
        self.secs
    }

    /// Returns the camera of the first view at the current time.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the scene has none.
    pub fn camera(&self) -> Result<Camera> {
        let camera = self.scene.camera_at(self.secs);
        camera.ok_or_else(no_camera)
    }

    /// Returns the cameras of all views at the current time. Allocates.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if a view has none.
    pub fn cameras(&self) -> Result<Vec<Camera>> {
        let views = self.scene.views.iter();
        let cameras = views.map(|view| view.camera_at(self.secs).ok_or_else(no_camera));
        cameras.collect()
    }

    /// Returns how all views see a crowd at the current time, with what hid its characters in the last
    /// frame. Allocates.
    ///
    /// # Errors
    /// As [`cameras`](Self::cameras).
    ///
    /// # Panics
    /// If there is no such crowd.
    pub fn error_views(&self, crowd: usize) -> Result<Vec<ErrorView<'_>>> {
        let cameras = self.cameras()?.into_iter().enumerate();
        let error_views = cameras.map(|(view, camera)| ErrorView {
            camera,
            occluded: match &self.hidden {
                Some(hidden) => hidden.occluded(view, crowd),
                None => &[],
            },
        });
        Ok(error_views.collect())
    }

    /// Sets what a budget allows the next frames ([`Budget::allowance`]).
    pub fn allow(&mut self, allowance: Allowance) {
        for crowd in &mut self.crowds {
            crowd.detail = Detail::Within(allowance);
        }
    }

    /// Adds the planned frame of all crowds to a budget, within whose [`Budget::allowance`] it was planned.
    pub fn add_to(&mut self, budget: &mut Budget) {
        for crowd in &mut self.crowds {
            crowd.add_to(budget);
        }
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

    /// [`plan`](Self::plan) on several threads, as [`CrowdPlayer::plan_on`], one crowd after the other.
    ///
    /// # Errors
    /// As [`plan`](Self::plan).
    pub fn plan_on(
        &mut self,
        dt_secs: f64,
        mut run: impl FnMut(&mut [CrowdSection], &(dyn Fn(&mut CrowdSection) + Sync)),
    ) -> Result<CrowdReport> {
        self.plan_by(dt_secs, |player, dt_secs, culling| {
            player.plan_on(dt_secs, culling, &mut |_| (), &mut run)
        })
    }

    /// Poses all characters as planned.
    pub fn evaluate(&mut self) {
        self.crowds.iter_mut().for_each(CrowdPlayer::evaluate);
    }

    fn plan_by(
        &mut self,
        dt_secs: f64,
        mut plan: impl FnMut(&mut CrowdPlayer, f32, Culling<'_>) -> CrowdReport,
    ) -> Result<CrowdReport> {
        self.secs += dt_secs;
        let mut cameras = [self.camera()?; MAX_VIEWS];
        let count = self.scene.views.len();
        for (camera, view) in cameras.iter_mut().zip(&self.scene.views) {
            *camera = view.camera_at(self.secs).ok_or_else(no_camera)?;
        }
        let cameras = &cameras[..count];
        self.turn_fades();
        self.change_roles();
        if let Some(hidden) = &mut self.hidden {
            hidden.look(cameras, &self.crowds);
        }
        let mut seen = [View::of(&cameras[0]); MAX_VIEWS];
        for (v, (seen, camera)) in seen.iter_mut().zip(cameras).enumerate() {
            let (way, turn) = self.ahead(&self.scene.views[v], camera);
            *seen = View::of(camera).with_cull_margin(way, turn);
        }
        let mut report = CrowdReport::default();
        for (c, crowd) in self.crowds.iter_mut().enumerate() {
            let mut views = seen;
            if let Some(hidden) = &self.hidden {
                for (v, view) in views[..count].iter_mut().enumerate() {
                    *view = view.with_occluded(hidden.occluded(v, c));
                }
            }
            let culling = match self.detail {
                DetailGoal::Full => Culling::Off,
                _ => Culling::Views(&views[..count]),
            };
            report = report.and(plan(crowd, dt_secs as f32, culling));
        }
        Ok(report)
    }

    /// Distance and angle that the camera of a view moves in the time ahead, in metres and radians.
    fn ahead(&self, view: &SceneView, camera: &Camera) -> (f32, f32) {
        let Some(later) = view.camera_at(self.secs + AHEAD_SECS) else {
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
            for member in cue.members.iter().map(|m| *m as usize) {
                self.roles[member] = cue.role;
                let value = importance.of(&self.scene.members[member], cue.role);
                let (crowd, character) = self.places[member];
                self.crowds[usize::from(crowd)].set_importance(character as usize, value);
            }
            self.cues += 1;
        }
    }

    /// Reverses cross-fades that are complete.
    fn turn_fades(&mut self) {
        for turning in &mut self.fades {
            let player = &mut self.crowds[turning.crowd];
            if player.crowd().state(turning.character).next().is_none() {
                turning.goes = !turning.goes;
                let next = turning.next(&player.asset().model().parts().clips, self.secs);
                let fade_secs = turning.fade.fade_secs;
                player
                    .crowd_mut()
                    .fade_to(turning.character, next, fade_secs);
            }
        }
    }
}

fn no_camera() -> Error {
    Error::unsuited("the scene has no camera")
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
