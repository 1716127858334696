//! Who in a scene is hidden by its walls, or by other characters.
//!
//! Hiders are drawn into a coarse depth grid, against which the boxes of all characters are tested
//! ([`Occlusion`]). Who is wholly hidden keeps its clock, its events and its root motion, and is not
//! evaluated.

use super::asset::CrowdAsset;
use super::player::CrowdPlayer;
use crate::error::{Error, Result};
use articula_build::{Scene, Wall, occluders};
use articula_core::visibility::Occlusion;
use articula_core::{Bound, Camera, Capsule, Sphere};
use glam::Quat;

/// Cells of the grid.
const GRID: (usize, usize) = (160, 90);

/// Maximum number of capsules that stand for a character.
const CAPSULES: usize = 4;

/// Number of characters, the nearest ones, that hide others.
const HIDING: usize = 128;

/// What hides the characters of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Hiders {
    /// Nothing: who is in the picture is evaluated.
    Nothing,
    /// The walls of the scene.
    #[default]
    Walls,
    /// The walls, and the nearest characters.
    Everything,
}

/// A grid, and the occluded fraction of each character.
#[derive(Debug)]
pub(super) struct Hidden {
    grid: Occlusion,
    walls: Vec<Wall>,
    /// Capsules inside the body, for each clip; empty where characters hide nobody.
    capsules: Vec<Vec<Capsule>>,
    occluded: Vec<f32>,
    /// Characters before the camera, by squared distance from the eye.
    nearest: Vec<(f32, u32)>,
}

impl Hidden {
    /// Prepares what is drawn; `None` if nothing hides anybody.
    pub(super) fn new(asset: &CrowdAsset, scene: &Scene, hiders: Hiders) -> Result<Option<Self>> {
        let capsules: Vec<Vec<Capsule>> = match hiders {
            Hiders::Everything => {
                let full = asset.full();
                let clips = full.clips.iter();
                clips.map(|clip| occluders(full, clip, CAPSULES)).collect()
            }
            _ => Vec::new(),
        };
        let has_walls = hiders != Hiders::Nothing && !scene.walls.is_empty();
        if !has_walls && capsules.iter().all(Vec::is_empty) {
            return Ok(None);
        }
        let characters = scene.members.len();
        Ok(Some(Self {
            grid: Occlusion::new(GRID.0, GRID.1).map_err(|e| Error::unsuited(e.to_string()))?,
            walls: scene.walls.clone(),
            occluded: vec![0.0; characters],
            nearest: Vec::with_capacity(if capsules.is_empty() { 0 } else { characters }),
            capsules,
        }))
    }

    /// Number of characters that are wholly hidden.
    pub(super) fn count(&self) -> usize {
        self.occluded.iter().filter(|o| **o >= 1.0).count()
    }

    /// Occluded fraction of each character, seen by a camera. Does not allocate.
    pub(super) fn look(&mut self, camera: &Camera, player: &CrowdPlayer) -> &[f32] {
        self.grid.begin(camera);
        for wall in &self.walls {
            let turn = Quat::from_rotation_y(wall.yaw_radians);
            self.grid.draw_box(wall.centre, 0.5 * wall.size, turn);
        }
        self.draw_characters(camera, player);
        if self.grid.is_empty() {
            self.occluded.fill(0.0);
            return &self.occluded;
        }
        let bounds = &player.asset().model().parts().bounds;
        let (crowd, forward) = (player.crowd(), camera.forward());
        for (character, occluded) in self.occluded.iter_mut().enumerate() {
            *occluded = 0.0;
            let position = player.positions()[character];
            let rotation = player.rotations()[character];
            let state = crowd.state(character);
            let clip = state.clip_state().clip();
            let bound = match state.next() {
                None => *bounds.clips[clip].whole(),
                Some(next) => around(bounds.blended(clip, next.clip())),
            };
            let scale = player.scale(character);
            let reach = scale * (bound.sphere.centre.length() + bound.sphere.radius);
            if (position - camera.eye).dot(forward) > -reach {
                *occluded = self.grid.occluded(&bound, position, rotation, scale);
            }
        }
        &self.occluded
    }

    /// Draws the nearest characters before the camera.
    fn draw_characters(&mut self, camera: &Camera, player: &CrowdPlayer) {
        if self.capsules.is_empty() {
            return;
        }
        self.nearest.clear();
        let forward = camera.forward();
        for (character, position) in player.positions().iter().enumerate() {
            let to = *position - camera.eye;
            if to.dot(forward) > 0.0 {
                self.nearest.push((to.length_squared(), character as u32));
            }
        }
        if self.nearest.len() > HIDING {
            let by_distance =
                |a: &(f32, u32), b: &(f32, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            self.nearest.select_nth_unstable_by(HIDING, by_distance);
            self.nearest.truncate(HIDING);
        }
        for (_, character) in &self.nearest {
            let character = *character as usize;
            let state = player.crowd().state(character);
            // Between two clips the body may be anywhere.
            if state.next().is_some() {
                continue;
            }
            let world = player.world_from_model(character);
            let scale = player.scale(character);
            for capsule in &self.capsules[state.clip_state().clip()] {
                self.grid.draw(&Capsule {
                    ends: capsule.ends.map(|end| world.transform_point3(end)),
                    radius: capsule.radius * scale,
                });
            }
        }
    }
}

/// A box around a sphere.
fn around(sphere: Sphere) -> Bound {
    Bound {
        sphere,
        least: sphere.centre - sphere.radius,
        greatest: sphere.centre + sphere.radius,
    }
}
