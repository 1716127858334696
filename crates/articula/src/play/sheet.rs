//! The character at several distances and frames, beside the reference: which joints move.
//!
//! Source: thesis figures 6.16 and 6.17. Each cell shows the clip as it is, and what the method
//! shows, drawn large; the small figure in the corner has the true size on the screen.

use super::Scene;
use super::methods::Chosen;
use super::rows::Table;
use crate::prepared::Prepared;
use anyhow::Context;
use articula_build::evaluate::{Method, Playback, Stage, play};
use articula_core::articulation::Region;
use articula_core::hierarchy::local_to_model;
use articula_core::pose::{LocalPose, ModelPose};
use articula_core::sample::{Wrap, sample_morphs};
use articula_core::skin::{SkinnedMesh, palette, skin};
use articula_core::view::{Camera, Viewport};
use articula_flat::appearance::Appearance;
use articula_flat::contact_sheet::{Cell, ContactSheet, Row as SheetRow, Tile};
use articula_flat::frame::{Bounds, orbit_view};
use articula_flat::projection::{Projection, Screen};
use articula_flat::render::{RenderOptions, render};
use articula_flat::skeleton::{JointMark, SkeletonOptions, draw_skeleton};
use articula_flat::{Ground, Picture};
use glam::{Affine3A, Vec2, Vec3};

/// How large and how many the pictures of a sheet are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Format {
    /// Width and height of one tile, pixels.
    pub(crate) tile: (u32, u32),
    /// Moments of the clip.
    pub(crate) frames: usize,
}

impl Format {
    /// For a file of its own.
    pub(crate) const LARGE: Self = Self {
        tile: (200, 290),
        frames: 4,
    };
    /// For a page, where it is shown pixel for pixel.
    pub(crate) const SMALL: Self = Self {
        tile: (144, 206),
        frames: 3,
    };
}

/// From where the figure is seen: a little from its left and from above.
const AZIMUTH: f32 = 0.55;
const ELEVATION: f32 = 0.12;
/// Figures higher than this share of a tile have no small copy at true size.
const INSET: f32 = 0.5;

/// One row of a sheet: a method with its parameter, at a distance.
pub(crate) struct Line<'a> {
    pub(crate) label: String,
    pub(crate) chosen: &'a Chosen,
    pub(crate) parameter: f32,
    pub(crate) distance_m: f32,
}

/// Frames to show of a clip: the middles of `count` equal parts.
pub(crate) fn frames_of(frames: usize, count: usize) -> Vec<usize> {
    let count = count.min(frames).max(1);
    let mut all: Vec<usize> = (0..count)
        .map(|i| ((2 * i + 1) * frames / (2 * count)).min(frames - 1))
        .collect();
    all.dedup();
    all
}

/// One line for each distance of a table.
pub(crate) fn lines_by_distance(table: &Table) -> Vec<Line<'_>> {
    let rows = table.rows.iter();
    rows.map(|row| Line {
        label: format!("{} m", row.distance_m),
        chosen: &table.chosen,
        parameter: row.parameter,
        distance_m: row.distance_m,
    })
    .collect()
}

/// One line for each method, all at one of the distances.
pub(crate) fn lines_by_method<'a>(tables: &'a [Table], distance: usize) -> Vec<Line<'a>> {
    let at = |table: &'a Table| {
        let row = table.rows.get(distance)?;
        Some(Line {
            label: table.chosen.label(),
            chosen: &table.chosen,
            parameter: row.parameter,
            distance_m: row.distance_m,
        })
    };
    tables.iter().filter_map(at).collect()
}

/// Draws the sheet of a played clip.
pub(crate) fn played(
    scene: &Scene<'_>,
    lines: &[Line<'_>],
    format: Format,
    title: &str,
    notes: Vec<String>,
) -> anyhow::Result<Picture> {
    let stage = scene.stage();
    let frames = frames_of(stage.truth.len(), format.frames);
    let mut artist = Artist::new(scene.prepared, format.tile);
    artist.frame_clip(&stage, &frames);
    let references: Vec<Picture> = frames
        .iter()
        .map(|f| artist.figure(&stage.truth[*f], artist.morphs(&stage, *f)))
        .collect::<anyhow::Result<_>>()?;
    let mut rows = Vec::new();
    for line in lines {
        let playbacks = play(&stage, &line.chosen.method, line.parameter).1;
        let Some(playback) = playbacks.first() else {
            continue;
        };
        let scale = scene.pixels_per_metre(line.distance_m);
        let mut cells = Vec::new();
        for (frame, reference) in frames.iter().zip(&references) {
            let shown = shown_pose(&stage, playback, *frame);
            let marks = marks(&stage, line.chosen, playback, line.parameter, *frame);
            let morphs = artist.morphs(&stage, *frame);
            let reduced = artist.articulated(&shown, morphs, &marks, scale)?;
            cells.push(cell(
                reference.clone(),
                reduced,
                caption(&stage, playback, *frame),
            ));
        }
        rows.push(SheetRow {
            label: line.label.clone(),
            cells,
        });
    }
    let rate = stage.clip.rate_hz();
    let columns = frames.iter().map(|f| format!("{:.2} s", *f as f32 / rate));
    sheet(title, notes, columns.collect(), rows)
}

/// Draws a character that has no clip: its rest pose, seen from four sides.
pub(crate) fn at_rest(prepared: &Prepared, title: &str) -> anyhow::Result<Picture> {
    let rest = prepared.asset.rig.rest_pose();
    let marks = vec![JointMark::Passive; prepared.asset.rig.len()];
    let mut artist = Artist::new(prepared, Format::LARGE.tile);
    let morphs = prepared.asset.mesh.morph_weights.clone();
    let mut cells = Vec::new();
    for turn in 0..4 {
        artist.azimuth = turn as f32 * std::f32::consts::FRAC_PI_2;
        artist.frame_pose(rest, &morphs);
        let figure = artist.figure(rest, morphs.clone())?;
        let joints = artist.articulated(rest, morphs.clone(), &marks, 0.0)?;
        cells.push(cell(figure, joints, "joints at rest".into()));
    }
    let row = SheetRow {
        label: String::new(),
        cells,
    };
    let columns = ["front", "left", "back", "right"]
        .map(String::from)
        .to_vec();
    let notes = vec!["The file has no clip: this is the rest pose, and nothing moves.".into()];
    sheet(title, notes, columns, vec![row])
}

fn sheet(
    title: &str,
    notes: Vec<String>,
    columns: Vec<String>,
    rows: Vec<SheetRow>,
) -> anyhow::Result<Picture> {
    let sheet = ContactSheet {
        title: title.to_owned(),
        notes,
        columns,
        rows,
        legend: ContactSheet::joint_legend(),
    };
    sheet.draw().context("the contact sheet")
}

fn cell(reference: Picture, reduced: Picture, caption: String) -> Cell {
    let tile = |picture, caption| Tile { picture, caption };
    Cell {
        tiles: vec![tile(reference, "reference".into()), tile(reduced, caption)],
    }
}

fn caption(stage: &Stage<'_>, playback: &Playback, frame: usize) -> String {
    let updated = playback.updated[frame].len();
    format!("{updated} of {} updated", stage.moving.len())
}

fn shown_pose(stage: &Stage<'_>, playback: &Playback, frame: usize) -> LocalPose {
    let mut pose = stage.truth[frame].clone();
    pose.rotations.copy_from_slice(&playback.shown[frame]);
    pose
}

/// What each joint does at a frame: the root always follows the clip.
fn marks(
    stage: &Stage<'_>,
    chosen: &Chosen,
    playback: &Playback,
    parameter: f32,
    frame: usize,
) -> Vec<JointMark> {
    let rig = &stage.asset.rig;
    let level = match &chosen.method {
        Method::Loa(levels) => levels.get(parameter as usize),
        _ => None,
    };
    let mark = |joint: usize| {
        let allowed = level.is_some_and(|l| l.contains(joint));
        if playback.in_transition[frame].contains(joint) {
            JointMark::InTransition
        } else if allowed || joint == rig.root() || playback.updated[frame].contains(joint) {
            JointMark::Active
        } else {
            JointMark::Passive
        }
    };
    (0..rig.len()).map(mark).collect()
}

/// Poses and draws one character; keeps its buffers.
pub(crate) struct Artist<'a> {
    prepared: &'a Prepared,
    look: Appearance,
    skinned: SkinnedMesh,
    model: ModelPose,
    matrices: Vec<Affine3A>,
    size: (u32, u32),
    pub(crate) azimuth: f32,
    bounds: Bounds,
    floor_m: f32,
}

impl<'a> Artist<'a> {
    /// An artist whose pictures have a size in pixels.
    pub(crate) fn new(prepared: &'a Prepared, size: (u32, u32)) -> Self {
        let character = &prepared.loaded.character;
        let (look, _) = Appearance::new(&character.materials, &character.images);
        let asset = &prepared.asset;
        let person = Bounds {
            low: Vec3::new(-0.5, 0.0, -0.5),
            high: Vec3::new(0.5, 1.8, 0.5),
        };
        let mut artist = Self {
            prepared,
            look,
            skinned: SkinnedMesh::new(&asset.mesh),
            model: ModelPose::new(asset.rig.len()),
            matrices: vec![Affine3A::IDENTITY; asset.mesh.bindings.len()],
            size,
            azimuth: AZIMUTH,
            bounds: person,
            floor_m: 0.0,
        };
        artist.frame_pose(asset.rig.rest_pose(), &asset.mesh.morph_weights);
        artist.floor_m = floor(&artist.bounds);
        artist
    }

    /// Frames the camera on some frames of a clip.
    pub(crate) fn frame_clip(&mut self, stage: &Stage<'_>, frames: &[usize]) {
        let boxes: Vec<_> = frames
            .iter()
            .filter_map(|f| {
                let morphs = self.morphs(stage, *f);
                self.pose(&stage.truth[*f], &morphs);
                self.corners()
            })
            .collect();
        self.bounds = Bounds::around(boxes).unwrap_or(self.bounds);
    }

    /// Frames the camera on one pose.
    pub(crate) fn frame_pose(&mut self, pose: &LocalPose, morphs: &[f32]) {
        self.pose(pose, morphs);
        self.bounds = Bounds::around(self.corners()).unwrap_or(self.bounds);
    }

    /// Frames the camera on the face, or on the left hand.
    pub(crate) fn frame_region(&mut self, pose: &LocalPose, region: Region) {
        let morphs = self.prepared.asset.mesh.morph_weights.clone();
        self.pose(pose, &morphs);
        let rig = &self.prepared.asset.rig;
        let of_region = |j: &usize| rig.articulation().joints[*j].region == region;
        let places = rig.skin_joints().iter().filter(of_region);
        let places = places.map(|j| self.model.position(j));
        let is_face = region == Region::Face;
        let left = places.filter(|p| is_face || p.x >= 0.0);
        let around = Vec3::splat(if is_face { 0.1 } else { 0.03 });
        let boxes = left.map(|p| (p - around, p + around));
        self.bounds = Bounds::around(boxes).unwrap_or(self.bounds);
    }

    /// Morph weights at a frame of the stage's clip.
    pub(crate) fn morphs(&self, stage: &Stage<'_>, frame: usize) -> Vec<f32> {
        let mut weights = stage.asset.mesh.morph_weights.clone();
        let secs = frame as f64 / f64::from(stage.clip.rate_hz());
        sample_morphs(stage.clip, secs, Wrap::Clamp, &mut weights);
        weights
    }

    /// The character as it is.
    pub(crate) fn figure(&mut self, pose: &LocalPose, morphs: Vec<f32>) -> anyhow::Result<Picture> {
        self.pose(pose, &morphs);
        let options = RenderOptions {
            ground: Some(self.ground()),
            ..RenderOptions::default()
        };
        self.draw(&self.camera(), &options)
    }

    /// The character with its joints marked, and in a corner as large as on the screen, where a
    /// metre spans `pixels_per_metre`.
    pub(crate) fn articulated(
        &mut self,
        pose: &LocalPose,
        morphs: Vec<f32>,
        marks: &[JointMark],
        pixels_per_metre: f32,
    ) -> anyhow::Result<Picture> {
        let mut picture = self.figure(pose, morphs)?;
        let screen = Screen::new(&self.camera(), Projection::Perspective);
        let rig = &self.prepared.asset.rig;
        let options = SkeletonOptions::default();
        draw_skeleton(&mut picture, rig, &self.model, &screen, marks, &options);
        if let Some(small) = self.true_size(pixels_per_metre)? {
            let x = picture.width() as i32 - small.width() as i32 - 4;
            let y = picture.height() as i32 - small.height() as i32 - 4;
            let frame = [150, 154, 164, 255];
            picture.draw_box(x - 1, y - 1, small.width() + 2, small.height() + 2, frame);
            picture.blit(&small, x, y);
        }
        Ok(picture)
    }

    /// The posed figure at its size on the screen; `None` if that is too large or too small.
    fn true_size(&self, pixels_per_metre: f32) -> anyhow::Result<Option<Picture>> {
        let size = self.bounds.high - self.bounds.low;
        let across = Vec2::new(size.x.max(size.z), size.y) * pixels_per_metre;
        let most = INSET * Vec2::new(self.size.0 as f32, self.size.1 as f32);
        if across.cmpgt(most).any() || across.y < 2.0 || !across.is_finite() {
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

    fn draw(&self, camera: &Camera, options: &RenderOptions) -> anyhow::Result<Picture> {
        let mesh = &self.prepared.asset.mesh;
        render(mesh, &self.skinned, &self.look, camera, options).context("drawing the character")
    }

    fn camera(&self) -> Camera {
        let viewport = Viewport {
            width_px: self.size.0 as f32,
            height_px: self.size.1 as f32,
            // Narrow, so that the figure is not distorted.
            fov_y_radians: 0.4,
        };
        orbit_view(&self.bounds, self.azimuth, ELEVATION, viewport)
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
        let asset = &self.prepared.asset;
        local_to_model(&asset.rig, pose, &mut self.model);
        let root = self.model.position(asset.rig.root());
        let back = Affine3A::from_translation(-Vec3::new(root.x, 0.0, root.z));
        for matrix in &mut self.model.matrices {
            *matrix = back * *matrix;
        }
        palette(&asset.mesh, &self.model, &mut self.matrices);
        skin(&asset.mesh, &self.matrices, morphs, &mut self.skinned);
    }

    fn corners(&self) -> Option<(Vec3, Vec3)> {
        let joints = || {
            let joints = self.prepared.asset.rig.skin_joints().iter();
            let places = joints.map(|j| self.model.position(j));
            places
                .map(|p| (p, p))
                .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
        };
        self.skinned.bounds().or_else(joints)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_over_the_clip() {
        assert_eq!(frames_of(8, 4), [1, 3, 5, 7]);
        assert_eq!(frames_of(1, 4), [0]);
        assert_eq!(frames_of(2, 4), [0, 1]);
        let many = frames_of(721, 4);
        assert!(many.windows(2).all(|w| w[0] < w[1]) && many[3] < 721);
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
}
