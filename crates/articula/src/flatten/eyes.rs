//! Eyes that joints turn, as expressions of a portrait: FAP 23 to 26, each to both sides.

use crate::face::{Turn, turns};
use crate::open::CharacterFile;
use articula_build::face::{FapInterval, FapValues};
use articula_core::{Clip, Rig, Wrap, sample};
use articula_flat::portrait::{JointTurn, PortraitExpression};

/// Ends of yaw and pitch, units of 1e-5 rad: those of the blend shapes `eyeLookOut` and `eyeLookDown`.
const YAW: i32 = 52_000;
const PITCH: i32 = 43_000;

/// The eye joints of a character.
pub(super) struct Eyes {
    turns: Vec<Turn>,
    /// For each expression the joint that it turns, and its part of a parameter.
    parts: Vec<(usize, FapInterval)>,
}

impl Eyes {
    pub(super) fn of(character: &CharacterFile) -> Self {
        let mut turns = turns(character, true);
        turns.retain(|turn| turn.has(23) || turn.has(24));
        let mut parts = Vec::new();
        for (eye, turn) in turns.iter().enumerate() {
            for (fap, end) in turn.faps().into_iter().flatten().zip([PITCH, YAW]) {
                let to = |to| FapInterval { fap, from: 0, to };
                parts.extend([end, -end].map(|end| (eye, to(end))));
            }
        }
        Self { turns, parts }
    }

    /// An expression for each part, named by it.
    pub(super) fn expressions(&self) -> Vec<PortraitExpression> {
        let expression = |(eye, part): &(usize, FapInterval)| {
            let turn = &self.turns[*eye];
            PortraitExpression {
                name: part.to_string(),
                morphs: Vec::new(),
                joints: vec![JointTurn {
                    joint: turn.joint(),
                    rotation: turn.rotation(&FapValues::alone(part.fap, part.to as f32)),
                }],
            }
        };
        self.parts.iter().map(expression).collect()
    }

    /// The weights of the expressions in each frame of a clip.
    pub(super) fn weights(&self, clip: &Clip, rig: &Rig) -> Vec<Vec<f32>> {
        let all = rig.all();
        let mut local = rig.rest_pose().clone();
        let frame = |frame: usize| {
            local.copy_from(rig.rest_pose());
            let time = frame as f64 / f64::from(clip.rate_hz());
            sample(clip, time, Wrap::Clamp, &all, &mut local);
            let mut values = FapValues::default();
            for turn in &self.turns {
                turn.read(local.rotations[turn.joint()], &mut values);
            }
            let weight =
                |(_, part): &(usize, FapInterval)| (values.get(part.fap) / part.to as f32).max(0.0);
            self.parts.iter().map(weight).collect()
        };
        (0..clip.frames()).map(frame).collect()
    }
}
