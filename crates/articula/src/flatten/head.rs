//! The head of a character with a camera, as source of a portrait.

use super::alternatives::held_vertices;
use super::expressions::expressions;
use super::eyes::Eyes;
use super::inputs::inputs;
use super::judged::RegionWeights;
use super::levels::levels;
use super::mouth::{DefaultMouth, TeethAndTongue};
use crate::error::{Error, Result};
use crate::facing::facing;
use crate::figure::Figure;
use crate::head::{head_joints, head_vertices};
use articula_build::decimate;
use articula_core::{
    Camera, Clip, Mesh, ModelPose, PosedMesh, Region, Rig, Viewport, Wrap, angle_between,
    local_to_model, sample,
};
use articula_flat::flatten::JudgedRegion;
use articula_flat::portrait::{
    Head, PortraitClip, PortraitExpression, PortraitInput, PortraitLevel, PortraitSource,
};
use articula_flat::{Appearance, Bounds, tight_view};
use glam::Vec3;
use std::borrow::Cow;

/// Margin around the head as a fraction of its height: hair above, neck and shoulders below.
const AROUND: f32 = 0.12;
/// A vertex belongs to the hands if its weights of their joints exceed this sum.
const OF_HANDS: f32 = 0.5;
/// Angle up to which a joint is at rest, radians.
const STILL: f32 = 1e-3;

/// A head framed by a camera, ready for making a portrait.
pub struct FramedHead<'a> {
    figure: &'a Figure,
    mesh: Cow<'a, Mesh>,
    appearance: Appearance,
    head: Head,
    expressions: Vec<PortraitExpression>,
    clips: Vec<PortraitClip>,
    camera: Camera,
    /// Where its teeth and its tongue are from.
    pub(super) teeth_and_tongue: TeethAndTongue,
    /// Triangles of its 2D mesh, as indices of the character's vertices and of those of a default mouth, which follow.
    pub triangles: Vec<[u32; 3]>,
}

impl<'a> FramedHead<'a> {
    /// Places the camera in front of the head, and simplifies the visible triangles to about
    /// `triangles`.
    ///
    /// # Errors
    /// An [`Error`] if there is no mesh, no vertex of a head, or neither head joint nor morph
    /// target to drive.
    pub fn new(
        figure: &'a Figure,
        clip: Option<usize>,
        triangles: usize,
        viewport: Viewport,
    ) -> Result<Self> {
        let asset = &figure.asset;
        if asset.mesh.triangles.is_empty() {
            let what = "there is no mesh to show; give a file with a mesh or hide fewer meshes";
            return Err(Error::unsuited(what));
        }
        let character = figure.opened.character();
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        let rest = PosedMesh::new(&asset.rig, &asset.mesh)
            .pose(asset.rig.rest_pose())
            .skinned(&asset.mesh.morph_weights)
            .positions;
        let joints = head_joints(figure);
        let of_head = head_vertices(figure, &joints);
        let shown = rest
            .iter()
            .zip(&of_head)
            .filter(|(_, is)| **is)
            .map(|(p, _)| *p);
        let bounds = Bounds::around(shown.map(|p| (p, p))).ok_or_else(|| {
            Error::unsuited("no vertex of the head has a finite position; check the skin weights")
        })?;
        let mut model = ModelPose::new(asset.rig.len());
        local_to_model(&asset.rig, asset.rig.rest_pose(), &mut model);
        let camera = before(&bounds, facing(&asset.rig, &model), viewport);
        let has_joints = !joints.is_empty();
        let joints = match clip {
            Some(clip) => turned(joints, &asset.clips[clip], &asset.rig),
            None => joints,
        };
        let head = if joints.is_empty() {
            let low = bounds.low.y;
            let middle = bounds.middle();
            let pivot = Vec3::new(middle.x, low + 0.3 * (bounds.high.y - low), middle.z);
            Head::Whole { pivot }
        } else {
            Head::Joints(joints)
        };
        let mut expressions = expressions(figure);
        if expressions.is_empty() && !has_joints {
            let what = "the file has neither a head joint nor a morph target; give a file with a \
                        face";
            return Err(Error::unsuited(what));
        }
        let kept = in_picture(figure, &rest, &camera);
        let triangles = decimate(asset, &kept, clip, triangles, &[])?;
        let eyes = Eyes::of(&figure.opened);
        let sampled = clip.map(|c| {
            let (clip, weights) = (&asset.clips[c], &asset.mesh.morph_weights);
            let mut sampled = PortraitClip::sample(clip, &asset.rig, weights, &head, &expressions);
            let of_eyes = eyes.weights(clip, &asset.rig);
            let frames = sampled.weights.iter_mut().zip(of_eyes);
            frames.for_each(|(frame, eyes)| frame.extend(eyes));
            sampled
        });
        expressions.extend(eyes.expressions());
        Ok(Self {
            figure,
            mesh: Cow::Borrowed(&asset.mesh),
            appearance,
            head,
            expressions,
            clips: sampled.into_iter().collect(),
            camera,
            teeth_and_tongue: TeethAndTongue::LeftOut,
            triangles,
        })
    }

    /// Adds a default inside of the mouth, or says why there is none.
    pub(super) fn with_mouth(mut self, mouth: &Result<DefaultMouth, TeethAndTongue>) -> Self {
        let mouth = match mouth {
            Ok(mouth) => mouth,
            Err(why) => {
                self.teeth_and_tongue = *why;
                return self;
            }
        };
        self.teeth_and_tongue = TeethAndTongue::Default;
        self.mesh = Cow::Owned(mouth.mesh.clone());
        self.triangles.extend(&mouth.triangles);
        self.appearance.materials.push(mouth.material.clone());
        let all = self.expressions.len();
        for added in &mouth.expressions {
            // The head may have the name, of a shape that moves nothing.
            match self.expressions[..all]
                .iter_mut()
                .find(|e| e.name == added.name)
            {
                Some(known) => known.morphs.extend(&added.morphs),
                None => self.expressions.push(added.clone()),
            }
        }
        let frames = self.clips.iter_mut().flat_map(|clip| &mut clip.weights);
        frames.for_each(|weights| weights.resize(self.expressions.len(), 0.0));
        self
    }

    /// Returns what drives the portrait besides its expressions: with a face animation table the blend
    /// shapes of ARKit and the visemes that it lacks.
    pub fn inputs(&self) -> Vec<PortraitInput> {
        inputs(&self.expressions)
    }

    /// What the portrait leaves out at coarser levels of articulation.
    pub(super) fn levels(&self) -> Vec<PortraitLevel> {
        levels(&self.expressions)
    }

    /// Returns the source data of the portrait.
    pub fn source(&self) -> PortraitSource<'_> {
        PortraitSource {
            mesh: &self.mesh,
            rig: &self.figure.asset.rig,
            appearance: &self.appearance,
            triangles: &self.triangles,
            head: self.head.clone(),
            expressions: &self.expressions,
            clips: &self.clips,
            camera: self.camera,
        }
    }
}

/// Region of each vertex: the face is what the head's last joint moves or, in a file without one,
/// what morph targets move; hands are what joints below the wrists move and is not held.
pub(super) fn judged_regions(figure: &Figure) -> Vec<JudgedRegion> {
    let asset = &figure.asset;
    let mut regions = vec![JudgedRegion::Body; asset.mesh.len()];
    let joints = &asset.rig.articulation().joints;
    let is_hand = |joint: usize| joints.get(joint).is_some_and(|j| j.region == Region::Hands);
    for (v, region) in regions.iter_mut().enumerate() {
        let influences = asset.mesh.influences_of(v);
        let of_hands: f32 = influences
            .filter(|(j, _)| is_hand(*j))
            .map(|(_, w)| w)
            .sum();
        if of_hands > OF_HANDS {
            *region = JudgedRegion::Hands;
        }
    }
    // A shield is no hand.
    for v in held_vertices(&asset.rig, &asset.mesh) {
        regions[v] = JudgedRegion::Body;
    }
    let head = head_joints(figure);
    if head.is_empty() {
        for morph in &asset.mesh.morphs {
            for v in &morph.vertices {
                regions[*v as usize] = JudgedRegion::Face;
            }
        }
    } else {
        for (region, of_head) in regions.iter_mut().zip(head_vertices(figure, &head)) {
            if of_head {
                *region = JudgedRegion::Face;
            }
        }
    }
    regions
}

/// Weight of the error at each vertex; `features` are the factors of each.
pub(super) fn vertex_weights(
    regions: &[JudgedRegion],
    features: &[f32],
    weights: RegionWeights,
) -> Vec<f32> {
    let of = |(region, feature): (&JudgedRegion, &f32)| match region {
        JudgedRegion::Face => weights.face * feature,
        JudgedRegion::Hands => weights.hands * feature,
        JudgedRegion::Body => *feature,
    };
    regions.iter().zip(features).map(of).collect()
}

/// The joints that turn the head: the last one alone if a clip turns it and leaves the others at rest, as
/// facial animation parameters do, else all.
fn turned(joints: Vec<usize>, clip: &Clip, rig: &Rig) -> Vec<usize> {
    let (all, rest) = (rig.all(), rig.rest_pose());
    let mut moves = vec![false; joints.len()];
    let mut local = rest.clone();
    for frame in 0..clip.frames() {
        let time = frame as f64 / f64::from(clip.rate_hz());
        sample(clip, time, Wrap::Clamp, &all, &mut local);
        for (moves, joint) in moves.iter_mut().zip(&joints) {
            *moves |= angle_between(local.rotations[*joint], rest.rotations[*joint]) > STILL;
        }
    }
    match (moves.as_slice(), joints.last()) {
        ([others @ .., true], Some(last)) if !others.contains(&true) => vec![*last],
        _ => joints,
    }
}

/// A camera in front of the head, with a margin around it.
fn before(bounds: &Bounds, azimuth_radians: f32, viewport: Viewport) -> Camera {
    let around = Vec3::splat(AROUND * (bounds.high.y - bounds.low.y));
    let wider = Bounds {
        low: bounds.low - around,
        high: bounds.high + around,
    };
    tight_view(wider.corners(), azimuth_radians, 0.0, viewport)
        .unwrap_or_else(|| Camera::looking_at(wider.middle() + Vec3::Z, wider.middle(), viewport))
}

/// Marks the triangles that may be visible in the picture when the head turns.
fn in_picture(figure: &Figure, rest: &[Vec3], camera: &Camera) -> Vec<bool> {
    let viewport = camera.viewport;
    let (width, height) = (viewport.width_px, viewport.height_px);
    let is_near = |v: &u32| {
        let (at, depth) = camera.project(rest[*v as usize]);
        let across = (-0.1 * width..1.1 * width).contains(&at.x);
        depth > 0.0 && across && (-0.1 * height..1.02 * height).contains(&at.y)
    };
    let triangles = &figure.asset.mesh.triangles;
    triangles.iter().map(|t| t.iter().any(is_near)).collect()
}
