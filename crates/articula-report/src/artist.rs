//! Poses and renders one character: lit, with joint marks, and at its size on the screen.

use crate::paint::draw_box;
use crate::skeleton::{JointMark, draw_skeleton, influencing_joints};
use articula::Figure;
use articula::core::{
    Camera, JointArticulation, LocalPose, Mesh, ModelPose, PosedMesh, Region, Rig, SkinnedMesh,
    Viewport, local_to_model, percentile,
};
use articula::flat::{
    Appearance, Bounds, Ground, Picture, PictureError, Projection, RenderOptions, orbit_view,
    render,
};
use glam::{Affine3A, Vec2, Vec3};

/// Half the height of a head, metres.
const HEAD_METRES: f32 = 0.14;

/// Default azimuth of the camera: a little from the figure's left.
const AZIMUTH: f32 = 0.55;
const ELEVATION: f32 = 0.12;
/// Maximum height of the inset at screen size, as a fraction of the tile.
const INSET: f32 = 0.36;
/// Size of the view relative to the figure.
const FREE: f32 = 1.12;

/// Materials of a figure, with its textures.
pub(crate) fn appearance(figure: &Figure) -> Appearance {
    let character = figure.opened.character();
    Appearance::new(&character.materials, &character.images).0
}

/// Direction in which a figure faces at rest, from +Z to its left.
pub(crate) fn facing_radians(figure: &Figure) -> f32 {
    let rig = &figure.asset.rig;
    let mut rest = ModelPose::new(rig.len());
    local_to_model(rig, rig.rest_pose(), &mut rest);
    articula::facing(rig, &rest)
}

/// Poses and renders one character; reuses its buffers.
pub struct Artist<'a> {
    rig: &'a Rig,
    mesh: &'a Mesh,
    look: Appearance,
    skinned: SkinnedMesh,
    posed: PosedMesh<'a>,
    size: (u32, u32),
    /// Azimuth of the camera, radians from the figure's facing direction to its left.
    pub azimuth: f32,
    /// Position of a fixed camera; without one the camera orbits the figure.
    pub eye: Option<Vec3>,
    bounds: Bounds,
    /// Points that must be in view.
    cloud: Vec<Vec3>,
    floor_m: f32,
    /// Facing direction of the figure at rest, radians from +Z.
    facing: f32,
}

impl<'a> Artist<'a> {
    /// Returns an artist that draws a figure in pictures of a size in pixels.
    pub fn of_figure(figure: &'a Figure, size: (u32, u32)) -> Self {
        let asset = &figure.asset;
        let (look, facing_radians) = (appearance(figure), facing_radians(figure));
        Self::new(&asset.rig, &asset.mesh, look, facing_radians, size)
    }

    /// `facing_radians` is the direction in which the figure faces at rest, from +Z to its left.
    pub(crate) fn new(
        rig: &'a Rig,
        mesh: &'a Mesh,
        look: Appearance,
        facing_radians: f32,
        size: (u32, u32),
    ) -> Self {
        let person = Bounds {
            low: Vec3::new(-0.5, 0.0, -0.5),
            high: Vec3::new(0.5, 1.8, 0.5),
        };
        let mut artist = Self {
            rig,
            mesh,
            look,
            skinned: SkinnedMesh::new(mesh),
            posed: PosedMesh::new(rig, mesh),
            size,
            azimuth: AZIMUTH,
            eye: None,
            bounds: person,
            cloud: person.corners().to_vec(),
            floor_m: 0.0,
            facing: facing_radians,
        };
        artist.frame_pose(rig.rest_pose(), &mesh.morph_weights);
        artist.floor_m = floor(&artist.bounds);
        artist
    }

    /// Frames the camera on several poses, each with its morph weights.
    pub(crate) fn frame_poses(&mut self, poses: &[(&LocalPose, Vec<f32>)]) {
        let mut cloud = Vec::new();
        for (pose, morphs) in poses {
            self.pose(pose, morphs);
            cloud.extend(self.points());
        }
        self.frame(cloud);
    }

    /// Frames the camera on one pose.
    pub fn frame_pose(&mut self, pose: &LocalPose, morphs: &[f32]) {
        self.pose(pose, morphs);
        let cloud = self.points();
        self.frame(cloud);
    }

    /// Frames the camera on points; keeps the previous framing if there are none.
    fn frame(&mut self, mut cloud: Vec<Vec3>) {
        cloud.retain(|p| p.is_finite());
        if let Some(bounds) = Bounds::around(cloud.iter().map(|p| (*p, *p))) {
            self.bounds = bounds;
            self.cloud = cloud;
        }
    }

    /// Frames the camera on the face or on the left hand; on the head where a rig has no joints in
    /// the face.
    pub fn frame_region(&mut self, pose: &LocalPose, region: Region) {
        let morphs = self.mesh.morph_weights.clone();
        self.pose(pose, &morphs);
        let rig = self.rig;
        let of_region = |j: &usize| rig.articulation().joints[*j].region == region;
        let places = rig.skin_joints().iter().filter(of_region);
        let places = places.map(|j| self.posed.model.position(j));
        let is_face = region == Region::Face;
        let left = places.filter(|p| is_face || p.x >= 0.0);
        let around = Vec3::splat(if is_face { 0.075 } else { 0.03 });
        let boxes = left.map(|p| (p - around, p + around));
        let head = || {
            let joints = &rig.articulation().joints;
            let skull = |j: &JointArticulation| j.hanim.as_deref() == Some("skullbase");
            let base = self.posed.model.position(joints.iter().position(skull)?);
            // The joint lies at the top of the neck.
            let centre = base + HEAD_METRES * Vec3::Y;
            let around = Vec3::splat(HEAD_METRES);
            Bounds::around([(centre - around, centre + around)])
        };
        let bounds = Bounds::around(boxes).or_else(|| head().filter(|_| is_face));
        if let Some(bounds) = bounds {
            self.frame(bounds.corners().to_vec());
        }
    }

    /// Renders the character.
    ///
    /// # Errors
    /// [`PictureError`] if the picture size is too large.
    pub fn figure(&mut self, pose: &LocalPose, morphs: Vec<f32>) -> Result<Picture, PictureError> {
        self.pose(pose, &morphs);
        if self.eye.is_some() {
            // Along a camera path every picture is framed separately.
            let cloud = self.points();
            self.frame(cloud);
        }
        let options = RenderOptions {
            ground: Some(self.ground()),
            ..RenderOptions::default()
        };
        self.draw(&self.camera(), &options)
    }

    /// Renders the character; without a mesh its skeleton with all joints active.
    ///
    /// # Errors
    /// [`PictureError`] if the picture size is too large.
    pub(crate) fn reference(
        &mut self,
        pose: &LocalPose,
        morphs: Vec<f32>,
    ) -> Result<Picture, PictureError> {
        if self.mesh.is_empty() {
            return self.articulated(pose, morphs, &[], 0.0);
        }
        self.figure(pose, morphs)
    }

    /// How far two poses are apart as the camera sees them: the 95th percentile over the vertices of the
    /// skin, or over the joints without one, in metres.
    pub(crate) fn displacement_m(
        &mut self,
        (truth, shown): (&LocalPose, &LocalPose),
        morphs: &[f32],
    ) -> f32 {
        self.pose(truth, morphs);
        let there = self.points();
        self.pose(shown, morphs);
        let forward = self.camera().forward();
        let apart = self.points().into_iter().zip(there).map(|(a, b)| a - b);
        let mut across: Vec<f32> = apart.map(|d| d.reject_from(forward).length()).collect();
        percentile(&mut across, 0.95)
    }

    /// Renders the character with joint marks, and an inset at its size on the screen, where one
    /// metre spans `pixels_per_metre`.
    ///
    /// # Errors
    /// [`PictureError`] if the picture size is too large.
    pub(crate) fn articulated(
        &mut self,
        pose: &LocalPose,
        morphs: Vec<f32>,
        marks: &[JointMark],
        pixels_per_metre: f32,
    ) -> Result<Picture, PictureError> {
        let mut picture = self.figure(pose, morphs)?;
        let camera = self.camera();
        let joints = influencing_joints(self.rig, self.mesh);
        let (rig, model) = (self.rig, &self.posed.model);
        draw_skeleton(&mut picture, rig, model, &camera, &joints, marks);
        if let Some(small) = self.true_size(pixels_per_metre)? {
            let x = picture.width() as i32 - small.width() as i32 - 4;
            let y = picture.height() as i32 - small.height() as i32 - 4;
            let frame = [150, 154, 164, 255];
            let (width, height) = (small.width() + 2, small.height() + 2);
            draw_box(&mut picture, x - 1, y - 1, width, height, frame);
            picture.blit(&small, x, y);
        }
        Ok(picture)
    }

    /// Renders the character at its size on the screen, where one metre spans `pixels_per_metre`; what is
    /// larger than the picture is cut off.
    ///
    /// # Errors
    /// [`PictureError`] if the picture size is too large.
    pub(crate) fn at_scale(
        &mut self,
        pose: &LocalPose,
        morphs: &[f32],
        pixels_per_metre: f32,
    ) -> Result<Picture, PictureError> {
        self.pose(pose, morphs);
        let options = RenderOptions {
            projection: Projection::Parallel { pixels_per_metre },
            ..RenderOptions::default()
        };
        self.draw(&self.camera(), &options)
    }

    /// The posed figure at its size on the screen; `None` if that is too large or too small.
    fn true_size(&self, pixels_per_metre: f32) -> Result<Option<Picture>, PictureError> {
        let size = self.bounds.high - self.bounds.low;
        let across = Vec2::new(size.x.max(size.z), size.y) * pixels_per_metre;
        let most = INSET * Vec2::new(self.size.0 as f32, self.size.1 as f32);
        let unseen = self.mesh.is_empty();
        if unseen || across.cmpgt(most).any() || across.y < 2.0 || !across.is_finite() {
            return Ok(None);
        }
        let (width, height) = (across.x.ceil() + 6.0, across.y.ceil() + 6.0);
        let viewport = Viewport {
            width_px: width,
            height_px: height,
            ..Viewport::default()
        };
        let camera = Camera {
            viewport,
            ..self.camera()
        };
        let options = RenderOptions {
            projection: Projection::Parallel { pixels_per_metre },
            ..RenderOptions::default()
        };
        self.draw(&camera, &options).map(Some)
    }

    fn draw(&self, camera: &Camera, options: &RenderOptions) -> Result<Picture, PictureError> {
        render(self.mesh, &self.skinned, &self.look, camera, options)
    }

    fn camera(&self) -> Camera {
        let viewport = Viewport {
            width_px: self.size.0 as f32,
            height_px: self.size.1 as f32,
            // A narrow angle, so that the figure is not distorted.
            fov_y_radians: 0.4,
        };
        if let Some(eye) = self.eye {
            return looking_from(eye, &self.bounds, viewport);
        }
        let toward = Vec2::from_angle(self.facing + self.azimuth);
        let toward = Vec3::new(toward.y, ELEVATION.tan(), toward.x).normalize();
        looking_along(-toward, &self.cloud, viewport)
    }

    fn ground(&self) -> Ground {
        let middle = self.bounds.middle();
        let size = self.bounds.high - self.bounds.low;
        Ground {
            height_m: self.floor_m,
            middle: Vec2::new(middle.x, middle.z),
            radius_m: 1.3 * size.max_element().max(0.1),
        }
    }

    /// Skins a pose with its root above the origin: the camera follows.
    fn pose(&mut self, pose: &LocalPose, morphs: &[f32]) {
        self.posed.pose(pose);
        let root = self.posed.model.position(self.rig.root());
        let follow = if self.eye.is_some() { 0.0 } else { -1.0 };
        let back = Affine3A::from_translation(follow * Vec3::new(root.x, 0.0, root.z));
        for matrix in &mut self.posed.model.matrices {
            *matrix = back * *matrix;
        }
        self.posed.skin(morphs, &mut self.skinned);
    }

    /// Visible points of the pose: its skin, or its joints without a skin.
    fn points(&self) -> Vec<Vec3> {
        if !self.skinned.positions.is_empty() {
            return self.skinned.positions.clone();
        }
        let joints = self.rig.skin_joints().iter();
        joints.map(|j| self.posed.model.position(j)).collect()
    }
}

/// Closest camera of a direction that sees all points.
fn looking_along(forward: Vec3, cloud: &[Vec3], viewport: Viewport) -> Camera {
    let aimed = Camera::looking_at(-forward, Vec3::ZERO, viewport);
    let in_view = |p: &Vec3| aimed.orientation.conjugate() * *p;
    let low = cloud.iter().map(in_view).fold(Vec3::MAX, Vec3::min);
    let high = cloud.iter().map(in_view).fold(Vec3::MIN, Vec3::max);
    let middle = 0.5 * (low + high);
    let tall = (0.5 * viewport.fov_y_radians).tan();
    let wide = tall * viewport.width_px / viewport.height_px;
    let needed = |p: Vec3| {
        let from_axis = (p - middle).abs();
        p.z - middle.z + FREE * (from_axis.x / wide).max(from_axis.y / tall)
    };
    let distance = cloud.iter().map(|p| needed(in_view(p))).fold(0.1, f32::max);
    Camera {
        eye: aimed.orientation * (middle + Vec3::Z * distance),
        ..aimed
    }
}

/// A camera at a fixed position with the field of view that the bounds need.
fn looking_from(eye: Vec3, bounds: &Bounds, viewport: Viewport) -> Camera {
    let aimed = Camera::looking_at(eye, bounds.middle(), viewport);
    let aspect = viewport.width_px / viewport.height_px;
    let slopes = bounds.corners().map(|corner| {
        let p = aimed.view(corner);
        (p.y.abs()).max(p.x.abs() / aspect) / p.z.max(0.1)
    });
    let slope = slopes.into_iter().fold(1e-3, f32::max);
    Camera {
        viewport: Viewport {
            fov_y_radians: 2.0 * (1.12 * slope).atan().min(1.4),
            ..viewport
        },
        ..aimed
    }
}

/// Height of the floor: that of the file's origin, unless the figure at rest stands elsewhere.
fn floor(rest: &Bounds) -> f32 {
    let height = (rest.high.y - rest.low.y).max(1e-3);
    if rest.low.y.abs() < 0.05 * height {
        0.0
    } else {
        rest.low.y
    }
}

/// Vertical field of view of close-ups, radians.
const CLOSE_UP_FOV_Y_RADIANS: f32 = 0.4;

/// Renders the part of a skinned mesh inside a box, from an azimuth and elevation in radians
/// ([`orbit_view`]), without a ground.
///
/// # Errors
/// [`PictureError::LimitExceeded`] if the picture is too large, [`PictureError::Mismatch`] if
/// `skinned` belongs to another mesh.
pub fn close_up(
    mesh: &Mesh,
    skinned: &SkinnedMesh,
    look: &Appearance,
    bounds: &Bounds,
    (azimuth_radians, elevation_radians): (f32, f32),
    (width_px, height_px): (u32, u32),
) -> Result<Picture, PictureError> {
    let viewport = Viewport {
        width_px: width_px as f32,
        height_px: height_px as f32,
        fov_y_radians: CLOSE_UP_FOV_Y_RADIANS,
    };
    let camera = orbit_view(bounds, azimuth_radians, elevation_radians, viewport);
    render(mesh, skinned, look, &camera, &RenderOptions::default())
}

/// Returns `count` frames spread evenly over a clip, each the middle of an equal part, without
/// duplicates.
pub fn evenly_spaced_frames(frames: usize, count: usize) -> Vec<usize> {
    let count = count.min(frames).max(1);
    let mut all: Vec<usize> = (0..count)
        .map(|i| ((2 * i + 1) * frames / (2 * count)).min(frames.saturating_sub(1)))
        .collect();
    all.dedup();
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula::core::source::{Joint, Skeleton};
    use articula::core::{Articulation, Transform};

    #[test]
    fn every_point_is_in_the_picture_and_one_is_near_its_edge() {
        let cloud = [
            Vec3::new(-0.4, 0.0, 0.1),
            Vec3::new(0.9, 1.2, -0.3),
            Vec3::new(0.1, 1.8, 0.0),
        ];
        for step in 0..20 {
            let turn = Vec2::from_angle(step as f32 * 0.3);
            let forward = -Vec3::new(turn.x, 0.2, turn.y).normalize();
            let camera = looking_along(forward, &cloud, Viewport::default());
            let mut most = 0.0f32;
            for point in cloud {
                let (at, depth) = camera.project(point);
                assert!(depth > 0.0);
                let off = (at.x / 640.0 - 1.0).abs().max((at.y / 360.0 - 1.0).abs());
                most = most.max(off);
            }
            // The nearest point that decides fills 1 / 1.12 of the half picture.
            assert!((most - 1.0 / FREE).abs() < 0.02, "{most} at step {step}");
        }
    }

    #[test]
    fn the_floor_is_the_origin_if_the_feet_are_near_it() {
        let bounds = |low: f32, high: f32| Bounds {
            low: Vec3::new(0.0, low, 0.0),
            high: Vec3::new(0.0, high, 0.0),
        };
        assert_eq!(floor(&bounds(-0.03, 1.8)), 0.0);
        assert_eq!(floor(&bounds(-0.9, 0.9)), -0.9);
    }

    #[test]
    fn poses_are_apart_as_the_camera_sees_it() {
        let root = Joint {
            name: "root".into(),
            parent: None,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![JointArticulation {
                hanim: None,
                level: 0,
                region: Region::Torso,
            }],
        };
        let skeleton = Skeleton { joints: vec![root] };
        let rig = Rig::new(&skeleton, articulation).unwrap();
        let mesh = Mesh::default();
        let mut artist = Artist::new(&rig, &mesh, Appearance::default(), 0.0, (90, 160));
        artist.azimuth = 0.0;
        // The root is kept in place but for its height, which a level camera sees whole.
        let level = rig.rest_pose().clone();
        let mut raised = level.clone();
        raised.translations[0].y += 0.5;
        let apart = artist.displacement_m((&level, &raised), &[]);
        assert!((apart - 0.5 * ELEVATION.cos()).abs() < 1e-3, "{apart}");
        assert_eq!(artist.displacement_m((&level, &level), &[]), 0.0);
    }

    #[test]
    fn frames_are_spread_over_the_clip() {
        assert_eq!(evenly_spaced_frames(8, 4), [1, 3, 5, 7]);
        assert_eq!(evenly_spaced_frames(1, 4), [0]);
        assert_eq!(evenly_spaced_frames(2, 4), [0, 1]);
        let many = evenly_spaced_frames(721, 4);
        assert!(many.windows(2).all(|w| w[0] < w[1]) && many[3] < 721);
    }
}
