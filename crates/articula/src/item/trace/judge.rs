//! The error of what is shown: posed, and compared with the whole character in its full motion.

use super::client::Client;
use super::content::Content;
use super::stage::{Stage, StagedMesh};
use super::timeline::FrameOf;
use crate::clip_streams::{StreamKind, afp2};
use crate::error::{Context, Error, Result};
use crate::item::delivery::is_motion;
use crate::item::files::Item;
use crate::item::part::PartKind;
use articula_build::{DistanceOptions, surface_distances};
use articula_core::{Clip, PosedMesh, Rig, Wrap, sample_morphs};
use articula_stream::abp2::MotionReceiver;
use articula_stream::mesh::Receiver;
use articula_stream::{FaceReadOptions, StreamLimits};
use glam::Vec3;
use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

/// Points of the whole surface whose distances are measured.
const POINTS: usize = 1500;

/// What is shown, as far as its pose depends on it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Look {
    shape: Vec<bool>,
    motion: Vec<bool>,
    shown: FrameOf,
    truth: FrameOf,
}

/// Compares with the whole character. What was measured once is not measured again, whichever policy
/// shows it.
pub(super) struct Judge {
    whole: StagedMesh,
    clips: BTreeMap<usize, Clip>,
    meshes: HashMap<Vec<bool>, Rc<Shown>>,
    errors: HashMap<Look, f64>,
}

/// A mesh as received, and its vertices with those of the whole one.
struct Shown {
    mesh: StagedMesh,
    pairs: Vec<[u32; 2]>,
    /// Whether it is the whole one.
    is_whole: bool,
}

impl Judge {
    /// Decodes all of an item.
    pub(super) fn of(item: &Item, stage: &Stage) -> Result<Self> {
        let limits = StreamLimits::default();
        let mut meshes = Vec::new();
        let mut clips = BTreeMap::new();
        for (index, part) in item.manifest.parts.iter().enumerate() {
            let Some(file) = &part.file else { continue };
            let missing = || Error::unsuited("the item lacks this file");
            let stream = item.file(file).ok_or_else(missing).context(file)?;
            if part.kind == PartKind::Mesh {
                meshes.push(Receiver::read(stream, &limits).context(file)?);
            } else if is_motion(part) {
                let clip = match StreamKind::of(stream) {
                    Some(StreamKind::Afp2) => {
                        let options = FaceReadOptions::default();
                        stage.face(&afp2::read(stream, &options, &limits).context(file)?)?
                    }
                    _ => {
                        let receiver = MotionReceiver::read(stream, stage.rig(), &limits);
                        receiver.context(file)?.clip().context(file)?
                    }
                };
                clips.insert(index, clip);
            }
        }
        Ok(Self {
            whole: stage.mesh(meshes.iter())?,
            clips,
            meshes: HashMap::new(),
            errors: HashMap::new(),
        })
    }

    /// Greatest distance in metres of a point of the skin from where it should be: client, what is shown,
    /// and what should be. A vertex that is shown is compared with itself, and other points with the
    /// nearest of what is shown.
    pub(super) fn error_m(
        &mut self,
        (content, stage): (&Content, &Stage),
        client: &mut Client<'_>,
        (shown, truth): (FrameOf, FrameOf),
        unit: usize,
    ) -> Result<f64> {
        let (part, of) = content.motion_part(shown.motion);
        // Levels of a face fade from one access unit to the next.
        let is_face = of.kind == PartKind::FaceMotion;
        let of_motion =
            |p: usize, u: Option<usize>| p == part && (is_face || u.is_none_or(|u| u == unit));
        let is_mesh = |part: usize, _| content.item.manifest.parts[part].kind == PartKind::Mesh;
        let look = Look {
            shape: content.pieces_there(&client.has, is_mesh),
            motion: content.pieces_there(&client.has, of_motion),
            shown,
            truth,
        };
        if let Some(known) = self.errors.get(&look) {
            return Ok(*known);
        }
        let mesh = match self.meshes.get(&look.shape) {
            Some(mesh) => Rc::clone(mesh),
            None => {
                let mesh = stage.mesh(client.meshes())?;
                let mesh = Rc::new(Shown {
                    pairs: mesh.pairs(&self.whole),
                    is_whole: mesh.mesh == self.whole.mesh,
                    mesh,
                });
                self.meshes.insert(look.shape.clone(), Rc::clone(&mesh));
                mesh
            }
        };
        let (truth_part, _) = content.motion_part(truth.motion);
        let Some(clip) = self.clips.get(&truth_part) else {
            return Err(Error::unsuited("the item has no such motion"));
        };
        let secs = |of: FrameOf| of.frame as f64 / content.timeline.motions[of.motion].rate_hz;
        let right = posed(stage.rig(), &self.whole, clip, secs(truth));
        let is = posed(stage.rig(), &mesh.mesh, client.clip(part)?, secs(shown));
        let error = self.distance(&mesh, &right, &is)?;
        self.errors.insert(look, error);
        Ok(error)
    }

    fn distance(&self, shown: &Shown, right: &[Vec3], is: &[Vec3]) -> Result<f64> {
        if self.whole.mesh.is_empty() {
            // Without a mesh, joints count.
            let apart = right.iter().zip(is).map(|(a, b)| a.distance(*b));
            return Ok(f64::from(apart.fold(0.0, f32::max)));
        }
        let apart = shown
            .pairs
            .iter()
            .map(|[own, whole]| is[*own as usize].distance(right[*whole as usize]));
        let own = f64::from(apart.fold(0.0, f32::max));
        if shown.is_whole {
            return Ok(own);
        }
        let first = right.len() as u32;
        let triangles = shown.mesh.mesh.triangles.iter();
        let triangles: Vec<[u32; 3]> = triangles.map(|t| t.map(|v| v + first)).collect();
        let all = [right, is].concat();
        let options = DistanceOptions {
            vertices: POINTS,
            face_centres: 0,
            ..DistanceOptions::default()
        };
        let original = &self.whole.mesh.triangles;
        let found = surface_distances(original, &[&triangles], &all, &[], &options)?;
        Ok(own.max(f64::from(found[0].rest.max_metres)))
    }
}

/// Vertices of a mesh, or joints without one, at a time of a clip.
fn posed(rig: &Rig, mesh: &StagedMesh, clip: &Clip, secs: f64) -> Vec<Vec3> {
    let mut weights = mesh.mesh.morph_weights.clone();
    sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
    let mut posed = PosedMesh::new(rig, &mesh.mesh);
    posed.pose_at(clip, secs, Wrap::Clamp);
    match mesh.mesh.is_empty() {
        true => (0..rig.len())
            .map(|joint| posed.model.position(joint))
            .collect(),
        false => posed.skinned(&weights).positions,
    }
}
