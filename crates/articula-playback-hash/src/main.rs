//! Plays one figure under every controller of the core and in batches, decodes a motion stream, and
//! hashes everything shown, so that platforms can be compared: `cargo xtask test` runs it natively,
//! built for WebAssembly in node, and built for AArch64 under emulation.
#![allow(
    unsafe_code,
    reason = "an exported symbol is the only way for node to call the program"
)]
#![allow(clippy::print_stdout, reason = "the hash is the output of the program")]

mod batch;
mod figure;
mod fnv;
mod stream;

use articula_core::crowd::ClipState;
use articula_core::joint_state::{Ease, LoaRange, TransitionOptions};
use articula_core::playback::{
    ErrorMatrix, FigureModel, FigurePlayer, FigureSkin, FigureViews, FullDetail, LayerMode,
    LoaController, MotionController, MotionLayer, StoredKeys, TableController, ThesisController,
    Threshold,
};
use articula_core::{
    DriftController, DriftOptions, GroupedSkin, JointErrorBounds, JointSet, Mesh, Mismatch,
    SecondMoment,
};
use fnv::Fnv;
use glam::Vec3;
use std::sync::Arc;

/// Display frames of each run.
const FRAMES: usize = 300;

fn main() {
    println!("{:016x}", playback_hash());
}

/// FNV-1a over the bits of all poses, matrices and vertices; 0 if the figure cannot be built.
#[unsafe(no_mangle)]
pub extern "C" fn playback_hash() -> u64 {
    hash().unwrap_or(0)
}

fn hash() -> Result<u64, Mismatch> {
    let rig = Arc::new(figure::rig()?);
    let clips = figure::clips()?;
    let mesh = Arc::new(figure::mesh()?);
    let model = FigureModel::new(rig.clone(), &clips[..])?.with_root_motion(figure::paths()?)?;
    let tables = figure::tables(&clips);
    let keys = clips.iter().zip(tables);
    let keys = keys.map(|(clip, table)| StoredKeys::new(clip, table).map(Some));
    let values = (0..clips[0].frames() * rig.len()).map(|i| (i * 37 % 101) as f32 / 101.0);
    let matrix = ErrorMatrix::new(rig.len(), values.collect())?;
    let bounds = vec![
        JointErrorBounds {
            lever_metres: 0.25,
            speed_metres_per_sec: 2.0,
            share: 0.5,
        };
        rig.len()
    ];
    let drift = DriftController::new(rig.rest_pose(), bounds, DriftOptions::default());
    let moment = SecondMoment::of([(Vec3::Y, 0.5), (Vec3::X, 0.25)]);
    let seeing = drift.clone().with_second_moments(vec![moment; rig.len()]);
    let linear = TransitionOptions {
        secs: 0.15,
        ease: Ease::Linear,
        ..TransitionOptions::default()
    };
    let sets = [rig.len(), 9, 3, 0].map(JointSet::first).to_vec();
    let range = || LoaRange::new(sets.clone(), 0).ok_or_else(|| Mismatch::new("levels", "none"));
    let threshold = Threshold {
        thr_init: 0.2,
        thr_max: 0.8,
        ..Threshold::default()
    };
    let matrices = vec![Some(matrix.into()), None];
    let thesis = ThesisController::new(&rig, matrices, threshold, 2, linear);
    let shares = vec![0.5; rig.len()];
    let stored = TableController::new(keys.collect::<Result<_, _>>()?, shares, 1.0);
    let mut loa = LoaController::new(&rig, range()?, linear, FullDetail::default());
    let mut bounded = LoaController::new(&rig, range()?, linear, drift.clone());
    let mut sum = Fnv::default();
    stream::decode(&mut sum)?;
    batch::evaluate(&rig, &clips, &mut sum)?;
    let stage = Stage {
        model: model.into(),
        groups: GroupedSkin::new(&mesh).into(),
        mesh,
    };
    stage.play(&mut FullDetail::default(), &mut sum)?;
    for mut drift in [drift, seeing] {
        stage.play(&mut drift, &mut sum)?;
    }
    stage.play(&mut { stored }, &mut sum)?;
    stage.play(&mut { thesis }, &mut sum)?;
    for level in [2, 0, 3, 1] {
        loa.request(level);
        stage.play(&mut loa, &mut sum)?;
        bounded.request(level);
        stage.play(&mut bounded, &mut sum)?;
    }
    Ok(sum.finish())
}

/// What every run shares.
struct Stage {
    model: Arc<FigureModel>,
    mesh: Arc<Mesh>,
    groups: Arc<GroupedSkin>,
}

impl Stage {
    /// Plays a controller before views that come and go, and hashes what is shown.
    fn play(&self, control: &mut dyn MotionController, sum: &mut Fnv) -> Result<(), Mismatch> {
        let mut player = FigurePlayer::new(self.model.clone(), &self.mesh.morph_weights);
        let over = ClipState::new(&*self.model, 1).at_speed(0.75);
        let mask = (0..self.model.rig().len())
            .map(|j| (j % 3) as f32 / 2.0)
            .collect();
        let layer = player.add_layer(MotionLayer::new(over.into(), mask, LayerMode::Override)?)?;
        let mut skin = FigureSkin::new(self.mesh.clone(), self.groups.clone());
        for i in 0..FRAMES {
            let way = player.advance(1.0 / 60.0, &mut |_| {});
            sum.floats(&[way.offset.x, way.offset.z, way.yaw_radians]);
            if i % 100 == 50 {
                player.fade_to(ClipState::new(&*self.model, i / 100 % 2), 0.2);
            }
            if let Some(layer) = player.layer_mut(layer) {
                layer.weight = if i / 60 % 2 == 1 { 0.5 } else { 0.0 };
            }
            let views = FigureViews::Parallel {
                pixels_per_metre: 40.0 + (i % 50) as f32 * 8.0,
                distance_metres: 2.0 + (i % 100) as f32 * 0.125,
                directions: &[Vec3::Z, Vec3::X],
            };
            player.control(control, views);
            player.hierarchy();
            skin.skin(player.model_pose(), player.morph_weights());
            player
                .model_pose()
                .matrices
                .iter()
                .for_each(|m| sum.floats(&m.to_cols_array()));
            let positions = &skin.skinned().positions;
            positions.iter().for_each(|p| sum.floats(&p.to_array()));
        }
        Ok(())
    }
}
