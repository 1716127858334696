//! The error of one frame of a live playback, as a camera sees it.

use crate::figure::Figure;
use articula_build::draw_vertices;
use articula_core::playback::FigurePlayer;
use articula_core::{Camera, Mesh, PosedMesh, percentile, sample};
use glam::Vec3;
use serde::Serialize;

/// Number of vertices that are measured, and the seed by which they are drawn.
const POINTS: usize = 700;
const SEED: u64 = 1;

/// Minimum depth of a vertex in front of the camera for its error to be measured.
const NEAR_METRES: f32 = 0.05;

/// Distances in pixels between what a player shows and what its clip moves with all joints.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ShownError {
    /// 95th percentile over the vertices.
    pub p95_px: f32,
    /// Maximum over the vertices.
    pub worst_px: f32,
}

/// Measures [`ShownError`]s of players of one figure on a sample of its vertices; on its joints, if
/// it has no mesh.
#[derive(Debug, Clone)]
pub struct ShownErrorMeter {
    vertices: Vec<u32>,
}

impl ShownErrorMeter {
    /// Draws the vertices.
    pub fn new(mesh: &Mesh) -> Self {
        Self {
            vertices: draw_vertices(mesh.len(), POINTS, SEED),
        }
    }

    /// Measures the frame of the last [`FigurePlayer::hierarchy`]. The truth is the base clip at its time:
    /// layers, cross-fades and edits of the pose count as errors. Allocates.
    pub fn measure(&self, figure: &Figure, player: &FigurePlayer, camera: &Camera) -> ShownError {
        let Some(base) = player.state() else {
            return ShownError::default();
        };
        let (rig, mesh) = (&*figure.asset.rig, &*figure.asset.mesh);
        let played = base.clip_state();
        let clip = &player.model().clips()[played.clip()];
        let mut truth = rig.rest_pose().clone();
        let secs = f64::from(played.secs());
        sample(clip, secs, played.wrap(), &rig.all(), &mut truth);
        let mut posed = PosedMesh::new(rig, mesh);
        posed.pose(&truth);
        let wanted = self.points(&mut posed);
        posed.model.clone_from(player.model_pose());
        let shown = self.points(&mut posed);
        let pairs = shown.iter().zip(&wanted);
        let distances = pairs.filter_map(|(shown, wanted)| {
            let ((s, sz), (w, wz)) = (camera.project(*shown), camera.project(*wanted));
            (sz > NEAR_METRES && wz > NEAR_METRES).then(|| s.distance(w))
        });
        let mut distances: Vec<f32> = distances.collect();
        ShownError {
            p95_px: percentile(&mut distances, 0.95),
            worst_px: distances.into_iter().fold(0.0, f32::max),
        }
    }

    fn points(&self, posed: &mut PosedMesh<'_>) -> Vec<Vec3> {
        if self.vertices.is_empty() {
            return (0..posed.model.matrices.len())
                .map(|joint| posed.model.position(joint))
                .collect();
        }
        let mut points = vec![Vec3::ZERO; self.vertices.len()];
        posed.points(&self.vertices, &mut points);
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowd::{RootMotionPolicy, figure_model};
    use crate::open::reference_mannequin;
    use articula_core::joint_state::{LoaRange, TransitionOptions};
    use articula_core::playback::{FigureViews, FullDetail, LoaController};
    use articula_core::{JointSet, Viewport};

    #[test]
    fn all_joints_have_no_error_and_held_ones_shrink_with_the_distance() {
        let figure = Figure::new(reference_mannequin().unwrap()).unwrap();
        let rig = &figure.asset.rig;
        let meter = ShownErrorMeter::new(&figure.asset.mesh);
        let camera = |z| Camera::looking_at(Vec3::new(0.0, 1.0, z), Vec3::Y, Viewport::default());
        let (near, far) = (camera(4.0), camera(40.0));
        let measured = |joints: JointSet| {
            let model = figure_model(&figure, RootMotionPolicy::OnTheSpot).unwrap();
            let mut player = FigurePlayer::new(model, &figure.asset.mesh.morph_weights);
            let (range, options) = (LoaRange::named(rig, 0), TransitionOptions::default());
            let mut control = LoaController::new(rig, range, options, FullDetail::default());
            control.articulate(joints);
            for _ in 0..30 {
                player.advance(1.0 / 30.0, &mut |_| {});
                player.control(&mut control, FigureViews::Cameras(&[near]));
                player.hierarchy();
            }
            [near, far].map(|camera| meter.measure(&figure, &player, &camera))
        };
        assert_eq!(measured(rig.all()), [ShownError::default(); 2]);
        let [close, away] = measured(JointSet::EMPTY);
        assert!(
            close.worst_px >= close.p95_px && close.p95_px > 1.0,
            "{close:?}"
        );
        // Ten times as far, a displacement spans about a tenth of the pixels.
        assert!(
            (5.0..20.0).contains(&(close.p95_px / away.p95_px)),
            "{close:?} {away:?}"
        );
    }
}
