//! Crowd scenes: positions of characters, their clips and the camera path, as plain values.
//!
//! [`plaza`] makes the default scenes from a seed; a scene file is read into the same [`Scene`].
//! Nothing here opens a file or evaluates a pose.

mod importance;
mod plaza;

use articula_core::LibmQuat;
pub use importance::{Cue, IMPORTANCE_RANGE, Role, SceneImportance, USUAL_ROLES, Zone};
pub use plaza::{PLAZA_COUNT, Plaza, plaza};

use crate::evaluate::{CameraKey, camera_at};
use articula_core::{Camera, Viewport};
use glam::{Affine3A, Quat, Vec3};

/// One character of a scene, animated in place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneCharacter {
    /// Which character of the scene's cast it is, from 0; 0 where the cast has only one.
    pub character: u16,
    /// Position in the world, in metres.
    pub position: Vec3,
    /// Rotation about +Y in radians; at 0 the character faces +Z.
    pub yaw_radians: f32,
    /// Uniform scale: 1 is the size of its file.
    pub scale: f32,
    /// Clip that the character plays.
    pub play: ClipPlayback,
    /// Permanent cross-fade to a second clip and back.
    pub cross_fade: Option<CrossFade>,
}

/// A looping clip with start phase and speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipPlayback {
    /// Index of the clip among those of the character.
    pub clip: usize,
    /// Start position as a fraction of the clip: 0 is the first frame, 1 the last.
    pub phase: f32,
    /// Playback speed: seconds of the clip per second of the scene.
    pub speed: f32,
}

impl ClipPlayback {
    /// Returns the clip time at a time of the scene, in seconds, not wrapped.
    pub fn clip_secs(&self, secs: f64, duration_secs: f32) -> f64 {
        secs * f64::from(self.speed) + f64::from(self.phase) * f64::from(duration_secs)
    }
}

/// A cross-fade that repeats throughout the scene: to another clip and back, in equal times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossFade {
    /// The clip to fade to.
    pub other: ClipPlayback,
    /// Duration of the fade in one direction, in seconds.
    pub fade_secs: f32,
    /// Phase of the fade at the start of the scene, 0 to 1; one cycle is there and back.
    pub start: f32,
}

impl CrossFade {
    /// Returns the weight of the other clip at a time of the scene, 0 to 1.
    pub fn share(&self, secs: f64) -> f32 {
        let there_and_back = 2.0 * f64::from(self.fade_secs);
        let turns = if there_and_back > 0.0 {
            secs / there_and_back
        } else {
            0.0
        };
        let way = (turns + f64::from(self.start)).rem_euclid(1.0);
        (1.0 - (2.0 * way - 1.0).abs()) as f32
    }
}

impl SceneCharacter {
    /// Returns the world transform of the character.
    pub fn world_from_model(&self) -> Affine3A {
        let turn = Quat::libm_rotation_y(self.yaw_radians);
        Affine3A::from_scale_rotation_translation(Vec3::splat(self.scale), turn, self.position)
    }
}

/// Characters, seen by one camera or more.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The characters.
    pub members: Vec<SceneCharacter>,
    /// The views, each with its camera; the first is the one of pictures.
    pub views: Vec<SceneView>,
    /// Who matters.
    pub importance: SceneImportance,
    /// What hides characters.
    pub walls: Vec<Wall>,
}

/// A camera path and the picture that it is seen in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SceneView {
    /// Picture size in pixels and field of view.
    pub viewport: Viewport,
    /// Keys of the camera path, in order of time, starting at 0.
    pub camera: Vec<CameraKey>,
    /// Whether the camera path repeats after its last key; otherwise the camera stays there.
    pub camera_loops: bool,
}

/// An opaque box that stands in a scene: a wall, a house.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Centre of the box in the world, in metres.
    pub centre: Vec3,
    /// Width, height and depth in metres.
    pub size: Vec3,
    /// Rotation about +Y in radians.
    pub yaw_radians: f32,
}

impl Scene {
    /// Keeps the first `count` characters, with their roles and their parts in cues.
    pub fn truncate(&mut self, count: usize) {
        self.members.truncate(count);
        self.importance.role_of.truncate(count);
        for cue in &mut self.importance.cues {
            cue.members.retain(|member| (*member as usize) < count);
        }
    }

    /// Returns the duration of the longest camera path in seconds: one lap, if it loops.
    pub fn loop_secs(&self) -> f64 {
        let laps = self.views.iter().map(SceneView::loop_secs);
        laps.fold(0.0, f64::max)
    }

    /// Returns the camera of the first view at a time; `None` if it has no camera key.
    pub fn camera_at(&self, secs: f64) -> Option<Camera> {
        self.views.first()?.camera_at(secs)
    }
}

impl SceneView {
    /// Returns the time of the last camera key in seconds: one lap of a looping path.
    pub fn loop_secs(&self) -> f64 {
        self.camera.last().map_or(0.0, |key| key.secs)
    }

    /// Returns the camera at a time; `None` if there is no camera key.
    pub fn camera_at(&self, secs: f64) -> Option<Camera> {
        let lap = self.loop_secs();
        let secs = if self.camera_loops && lap > 0.0 {
            secs.rem_euclid(lap)
        } else {
            secs
        };
        camera_at(&self.camera, secs, self.viewport)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shorter_scene_names_nobody_who_is_gone() {
        let mut scene = plaza(9, &[1], 1, Plaza::Still);
        scene.importance.role_of = vec![Some(0); 9];
        scene.importance.cues = vec![Cue {
            secs: 1.0,
            role: None,
            members: vec![0, 8, 3, 4],
        }];
        scene.truncate(4);
        assert_eq!(scene.members.len(), 4);
        assert_eq!(scene.importance.role_of.len(), 4);
        assert_eq!(scene.importance.cues[0].members, [0, 3]);
    }

    #[test]
    fn a_cross_fade_goes_there_and_back() {
        let other = ClipPlayback {
            clip: 1,
            phase: 0.0,
            speed: 1.0,
        };
        let fade = CrossFade {
            other,
            fade_secs: 2.0,
            start: 0.0,
        };
        for (secs, share) in [(0.0, 0.0), (1.0, 0.5), (2.0, 1.0), (3.0, 0.5), (5.0, 0.5)] {
            assert!((fade.share(secs) - share).abs() < 1e-6, "at {secs} s");
        }
        let still = CrossFade {
            fade_secs: 0.0,
            start: 0.25,
            ..fade
        };
        assert_eq!(still.share(7.0), 0.5, "a fade without a length stays");
    }

    #[test]
    fn a_member_faces_where_its_yaw_says() {
        let play = ClipPlayback {
            clip: 0,
            phase: 0.5,
            speed: 2.0,
        };
        let member = SceneCharacter {
            character: 0,
            position: Vec3::new(1.0, 0.0, 2.0),
            yaw_radians: std::f32::consts::FRAC_PI_2,
            scale: 2.0,
            play,
            cross_fade: None,
        };
        let ahead = member.world_from_model().transform_point3(Vec3::Z);
        assert!(
            (ahead - Vec3::new(3.0, 0.0, 2.0)).length() < 1e-6,
            "2 m ahead"
        );
        assert_eq!(play.clip_secs(3.0, 4.0), 8.0);
    }

    #[test]
    fn without_a_key_there_is_no_camera() {
        let mut scene = plaza(1, &[1], 1, Plaza::Still);
        scene.views[0].camera.clear();
        assert_eq!(scene.camera_at(1.0), None);
        assert_eq!(scene.loop_secs(), 0.0);
        scene.views.clear();
        assert_eq!(scene.camera_at(1.0), None);
    }
}
