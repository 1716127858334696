//! Who in a scene is hidden by its walls, or by other characters.
//!
//! Hiders are drawn into a coarse depth grid, against which the boxes of all characters are tested
//! ([`Occlusion`]). Who is wholly hidden keeps its clock, its events and its root motion, and is not
//! evaluated. Whoever is hidden is tested in every frame, since it must not come into view late; the
//! others in turns, since to show them for some frames more costs little.

use super::player::CrowdPlayer;
use crate::error::{Error, Result};
use articula_build::{Scene, Wall, occluders};
use articula_core::visibility::{BoxOcclusion, Occlusion};
use articula_core::{Bound, Camera, Capsule, ClipBounds, Sphere};
use articula_core::{Libm, LibmQuat};
use glam::{Quat, Vec3};
use std::f32::consts::SQRT_2;

/// Cells of the grid.
const GRID: (usize, usize) = (160, 90);

/// Maximum number of capsules that stand for a character.
const CAPSULES: usize = 4;

/// Number of characters, the nearest ones, that hide others.
const HIDING: usize = 128;

/// Number of neighbours in the order of the crowd that are first looked at together.
const TOGETHER: usize = 16;

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

/// Number of frames in which all who are not hidden are tested once.
const TURNS: usize = 8;

/// What is hidden in each view of a scene.
#[derive(Debug)]
pub(super) struct Hidden {
    /// Number of frames that were looked at.
    frames: usize,
    walls: Vec<Wall>,
    /// Of each crowd.
    hiding: Vec<Hiding>,
    views: Vec<HiddenInView>,
}

/// How the characters of a crowd hide others, and are hidden.
#[derive(Debug)]
struct Hiding {
    /// Capsules inside the body, for each clip; empty where characters hide nobody.
    capsules: Vec<Vec<Capsule>>,
    /// Upright cylinder around the origin that holds the skin in each clip.
    cylinders: Vec<Cylinder>,
    /// Distance from the origin of the character that its skin reaches in any clip, metres.
    reach_metres: f32,
}

/// An upright cylinder around the origin of a character: its radius, and its least and greatest height.
#[derive(Debug, Clone, Copy)]
struct Cylinder {
    radius: f32,
    heights: [f32; 2],
}

impl Cylinder {
    /// The cylinder around a box, however it is turned about +Y.
    fn of_box(bound: &Bound) -> Self {
        let far = bound.least.abs().max(bound.greatest.abs());
        Self {
            radius: far.x.libm_hypot(far.z),
            heights: [bound.least.y, bound.greatest.y],
        }
    }

    fn of_sphere(sphere: Sphere) -> Self {
        Self {
            radius: sphere.centre.x.libm_hypot(sphere.centre.z) + sphere.radius,
            heights: [-sphere.radius, sphere.radius].map(|r| sphere.centre.y + r),
        }
    }
}

/// A grid, and the occluded fraction of each character of each crowd.
#[derive(Debug)]
struct HiddenInView {
    grid: Occlusion,
    occluded: Vec<Vec<f32>>,
    /// Characters before the camera, by squared distance from the eye: crowd and character.
    nearest: Vec<(f32, [u32; 2])>,
}

impl Hidden {
    /// Prepares what is drawn; `None` if nothing hides anybody.
    pub(super) fn new(
        crowds: &[CrowdPlayer],
        scene: &Scene,
        hiders: Hiders,
    ) -> Result<Option<Self>> {
        let hiding = crowds.iter().map(|crowd| Hiding::new(crowd, hiders));
        let hiding: Vec<Hiding> = hiding.collect();
        let characters_hide = hiding.iter().any(Hiding::hides);
        let walls = match hiders {
            Hiders::Nothing => Vec::new(),
            _ => scene.walls.clone(),
        };
        if walls.is_empty() && !characters_hide {
            return Ok(None);
        }
        let characters = scene.members.len();
        let view = || {
            Ok(HiddenInView {
                grid: Occlusion::new(GRID.0, GRID.1).map_err(|e| Error::unsuited(e.to_string()))?,
                occluded: crowds
                    .iter()
                    .map(|c| vec![0.0; c.positions().len()])
                    .collect(),
                nearest: Vec::with_capacity(if characters_hide { characters } else { 0 }),
            })
        };
        let views = scene.views.iter().map(|_| view());
        Ok(Some(Self {
            frames: 0,
            walls,
            hiding,
            views: views.collect::<Result<_>>()?,
        }))
    }

    /// Finds what each view's camera does not see. Does not allocate.
    pub(super) fn look(&mut self, cameras: &[Camera], crowds: &[CrowdPlayer]) {
        // Everyone in the first frame.
        let turn = (self.frames > 0).then_some(self.frames % TURNS);
        self.frames += 1;
        for (view, camera) in self.views.iter_mut().zip(cameras) {
            view.grid.begin(camera);
            for wall in &self.walls {
                let turn = Quat::libm_rotation_y(wall.yaw_radians);
                view.grid.draw_box(wall.centre, 0.5 * wall.size, turn);
            }
            view.draw_characters(camera, crowds, &self.hiding);
            if view.grid.is_empty() {
                view.occluded.iter_mut().for_each(|o| o.fill(0.0));
                continue;
            }
            let of_each = self.hiding.iter().zip(crowds);
            for (occluded, (hiding, crowd)) in view.occluded.iter_mut().zip(of_each) {
                look_at(&view.grid, (crowd, hiding), turn, occluded);
            }
        }
    }

    /// Occluded fraction of each character of a crowd in a view.
    pub(super) fn occluded(&self, view: usize, crowd: usize) -> &[f32] {
        &self.views[view].occluded[crowd]
    }

    /// Number of characters that are wholly hidden in a view and shown in no other one.
    pub(super) fn count(&self, crowds: &[CrowdPlayer]) -> usize {
        let of = |(c, crowd): (usize, &CrowdPlayer)| {
            let hidden = |i: &usize| self.views.iter().any(|v| v.occluded[c][*i] >= 1.0);
            let all = (0..crowd.positions().len()).filter(hidden);
            all.filter(|i| crowd.crowd().level(*i).is_none()).count()
        };
        crowds.iter().enumerate().map(of).sum()
    }
}

impl Hiding {
    fn new(crowd: &CrowdPlayer, hiders: Hiders) -> Self {
        let asset = crowd.asset();
        let capsules = match hiders {
            Hiders::Everything => {
                let full = asset.full();
                let clips = full.clips.iter();
                clips.map(|clip| occluders(full, clip, CAPSULES)).collect()
            }
            _ => Vec::new(),
        };
        let bounds = &asset.model().parts().bounds;
        let most = |of: &dyn Fn(&ClipBounds) -> Sphere| {
            let all = bounds.clips.iter().map(of);
            let reaches = all.map(|sphere| sphere.centre.length() + sphere.radius);
            reaches.fold(0.0, f32::max)
        };
        // The smallest sphere around two that lie in a ball leaves it by less than the root of 2.
        let blended = SQRT_2 * most(&|clip| clip.anchors()) + bounds.reach_metres;
        let cylinders = bounds.clips.iter();
        let cylinders = cylinders.map(|clip| Cylinder::of_box(clip.whole()));
        Self {
            capsules,
            cylinders: cylinders.collect(),
            reach_metres: most(&|clip| clip.whole().sphere).max(blended),
        }
    }

    fn hides(&self) -> bool {
        self.capsules.iter().any(|of_clip| !of_clip.is_empty())
    }
}

/// Occluded fraction of each character of a crowd. Neighbours in the order are first looked at together.
///
/// Of those who are not hidden only the ones of a turn are tested, if there are turns.
fn look_at(
    grid: &Occlusion,
    (crowd, hiding): (&CrowdPlayer, &Hiding),
    turn: Option<usize>,
    occluded: &mut [f32],
) {
    let bounds = &crowd.asset().model().parts().bounds;
    let positions = crowd.positions();
    let groups = positions
        .chunks(TOGETHER)
        .zip(occluded.chunks_mut(TOGETHER));
    for (group, (places, occluded)) in groups.enumerate() {
        let first = group * TOGETHER;
        let (mut least, mut greatest) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (i, place) in places.iter().enumerate() {
            let reach = hiding.reach_metres * crowd.scale(first + i);
            least = least.min(*place - reach);
            greatest = greatest.max(*place + reach);
        }
        match grid.occluded_box(least, greatest) {
            BoxOcclusion::Nothing => occluded.fill(0.0),
            BoxOcclusion::All => occluded.fill(1.0),
            BoxOcclusion::Some => {
                for (i, (place, occluded)) in places.iter().zip(occluded).enumerate() {
                    let character = first + i;
                    if *occluded < 1.0 && turn.is_some_and(|turn| character % TURNS != turn) {
                        continue;
                    }
                    let cylinder = match crowd.crowd().clips(character) {
                        (clip, None) => hiding.cylinders[clip],
                        (clip, Some(to)) => Cylinder::of_sphere(bounds.blended(clip, to)),
                    };
                    let scale = crowd.scale(character);
                    let heights = cylinder.heights.map(|height| height * scale);
                    let turn = crowd.rotations()[character];
                    // Scenes turn characters about +Y; who was turned otherwise is not hidden.
                    *occluded = match turn.x == 0.0 && turn.z == 0.0 {
                        true => grid.occluded_upright(*place, cylinder.radius * scale, heights),
                        false => 0.0,
                    };
                }
            }
        }
    }
}

impl HiddenInView {
    /// Draws the nearest characters before the camera.
    fn draw_characters(&mut self, camera: &Camera, crowds: &[CrowdPlayer], hiding: &[Hiding]) {
        self.nearest.clear();
        let forward = camera.forward();
        let of_each = crowds.iter().zip(hiding).enumerate();
        for (c, (crowd, _)) in of_each.filter(|(_, (_, hiding))| hiding.hides()) {
            for (character, position) in crowd.positions().iter().enumerate() {
                let to = *position - camera.eye;
                if to.dot(forward) > 0.0 {
                    let who = [c as u32, character as u32];
                    self.nearest.push((to.length_squared(), who));
                }
            }
        }
        if self.nearest.len() > HIDING {
            let by_distance =
                |a: &(f32, [u32; 2]), b: &(f32, [u32; 2])| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            self.nearest.select_nth_unstable_by(HIDING, by_distance);
            self.nearest.truncate(HIDING);
        }
        for (_, who) in &self.nearest {
            let [crowd, character] = who.map(|i| i as usize);
            let (hiding, player) = (&hiding[crowd], &crowds[crowd]);
            let state = player.crowd().state(character);
            // Between two clips the body may be anywhere.
            if state.next().is_some() {
                continue;
            }
            let world = player.world_from_model(character);
            let scale = player.scale(character);
            for capsule in &hiding.capsules[state.clip_state().clip()] {
                self.grid.draw(&Capsule {
                    ends: capsule.ends.map(|end| world.transform_point3(end)),
                    radius: capsule.radius * scale,
                });
            }
        }
    }
}
