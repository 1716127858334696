//! A motion and its retargeted result, side by side at several times.

use super::measure::Played;
use anyhow::{Context, Result};
use articula::CharacterFile;
use articula_core::{Camera, Mesh, ModelPose, PosedMesh, Rig, SkinnedMesh, Viewport};
use articula_flat::{Appearance, Bounds, Ground, Picture, RenderOptions, orbit_view, render};
use articula_report::{SheetCell, SheetRow, draw_skeleton, influencing_joints};
use glam::{Affine3A, Vec2, Vec3};

/// Size of one picture in pixels.
const TILE: (u32, u32) = (128, 162);
/// Direction of view: slightly from the figure's left and from above.
const AZIMUTH: f32 = 0.6;
const ELEVATION: f32 = 0.15;

/// Number of frames of a clip that are shown.
pub(super) const MOMENTS: usize = 6;

/// Draws one figure in its poses.
pub(super) struct Artist<'a> {
    played: &'a Played,
    mesh: Mesh,
    look: Appearance,
    camera: Camera,
    ground: Ground,
    bones: bool,
}

impl<'a> Artist<'a> {
    /// Frames the camera on the shown frames; it follows the root over the ground.
    pub(super) fn new(
        actor: &CharacterFile,
        played: &'a Played,
        moments: &[usize],
    ) -> Result<Self> {
        let character = actor.character();
        let (look, _) = Appearance::new(&character.materials, &character.images);
        let mesh = Mesh::new(&character.meshes, played.rig.len())?;
        let mut artist = Self {
            played,
            bones: mesh.is_empty(),
            mesh,
            look,
            camera: Camera::looking_at(Vec3::Z, Vec3::ZERO, Viewport::default()),
            ground: Ground::below(
                &Bounds {
                    low: Vec3::ZERO,
                    high: Vec3::ONE,
                },
                0.0,
            ),
        };
        let mut cloud = Vec::new();
        for moment in moments {
            let model = artist.influencing_joints(*moment);
            if artist.bones {
                cloud.extend((0..model.matrices.len()).map(|j| model.position(j)));
            } else {
                cloud.extend(artist.skinned(&model).positions);
            }
        }
        let bounds = Bounds::around(cloud.iter().map(|p| (*p, *p))).context("nothing to draw")?;
        let viewport = Viewport {
            width_px: TILE.0 as f32,
            height_px: TILE.1 as f32,
            fov_y_radians: 0.4,
        };
        let azimuth = facing(&played.rig, &played.models[0]) + AZIMUTH;
        artist.camera = orbit_view(&bounds, azimuth, ELEVATION, viewport);
        artist.ground = Ground::below(&bounds, if artist.bones { bounds.low.y } else { 0.0 });
        Ok(artist)
    }

    /// The row of a sheet.
    pub(super) fn row(&self, label: String, moments: &[usize]) -> Result<SheetRow> {
        let cell = |moment: &usize| {
            let secs = *moment as f32 / self.played.rate_hz;
            Ok(SheetCell::of(self.draw(*moment)?, format!("{secs:.2} s")))
        };
        let cells: Result<Vec<SheetCell>> = moments.iter().map(cell).collect();
        Ok(SheetRow {
            label,
            cells: cells?,
        })
    }

    fn draw(&self, moment: usize) -> Result<Picture> {
        let model = self.influencing_joints(moment);
        let options = RenderOptions {
            ground: Some(self.ground),
            ..RenderOptions::default()
        };
        let skinned = self.skinned(&model);
        let (mesh, look) = (&self.mesh, &self.look);
        let mut picture = render(mesh, &skinned, look, &self.camera, &options)?;
        if self.bones {
            let (rig, camera) = (&self.played.rig, &self.camera);
            let joints = influencing_joints(rig, mesh);
            draw_skeleton(&mut picture, rig, &model, camera, &joints, &[]);
        }
        Ok(picture)
    }

    /// The pose with its hips above the origin.
    fn influencing_joints(&self, moment: usize) -> ModelPose {
        let mut model = self.played.models[moment].clone();
        let hips = hips(&self.played.rig, &model);
        let middle = hips.map_or(Vec3::ZERO, |(left, right)| 0.5 * (left + right));
        let back = Affine3A::from_translation(-Vec3::new(middle.x, 0.0, middle.z));
        for matrix in &mut model.matrices {
            *matrix = back * *matrix;
        }
        model
    }

    fn skinned(&self, model: &ModelPose) -> SkinnedMesh {
        let mut posed = PosedMesh::new(&self.played.rig, &self.mesh);
        posed.model.clone_from(model);
        posed.skinned(&self.mesh.morph_weights)
    }
}

/// Heading of a figure, radians from +Z: perpendicular to the line between its hips.
fn facing(rig: &Rig, model: &ModelPose) -> f32 {
    let Some((left, right)) = hips(rig, model) else {
        return 0.0;
    };
    let forward = (left - right).cross(Vec3::Y);
    Vec2::new(forward.z, forward.x).to_angle()
}

/// The left and the right hip.
fn hips(rig: &Rig, model: &ModelPose) -> Option<(Vec3, Vec3)> {
    let place = |name: &str| rig.articulation().find(name).map(|j| model.position(j));
    place("l_hip").zip(place("r_hip"))
}
