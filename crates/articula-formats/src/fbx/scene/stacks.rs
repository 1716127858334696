//! Takes: what moves, when, and the scene at one moment.

use super::faults::read_error;
use super::{Local, Scene};
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::source::JUMP_SECS;
use fbx_rs::{AnimationBinding, Interpolation};

/// Properties that place a node; the animation of any other does not move one.
const PLACING: [&[u8]; 12] = [
    b"Lcl Translation",
    b"Lcl Rotation",
    b"Lcl Scaling",
    b"PreRotation",
    b"PostRotation",
    b"RotationOffset",
    b"RotationPivot",
    b"ScalingOffset",
    b"ScalingPivot",
    b"GeometricTranslation",
    b"GeometricRotation",
    b"GeometricScaling",
];

/// Maximum number of animated properties of all takes, and of their keys, however many share them.
const MAX_BINDINGS: u64 = 1 << 22;
const MAX_KEYS: u64 = 1 << 26;

/// A take of the file.
pub(in crate::fbx) struct Stack {
    pub(in crate::fbx) name: String,
    pub(in crate::fbx) begin: f64,
    pub(in crate::fbx) end: f64,
    /// First and last key of what moves nodes and blend shapes; `None` without one.
    pub(in crate::fbx) keys: Option<(f64, f64)>,
    pub(in crate::fbx) key_count: usize,
    /// Whether a curve goes on before its first or behind its last key.
    pub(in crate::fbx) goes_on: bool,
    /// Times just before changes at once, rising.
    pub(in crate::fbx) jumps: Vec<f64>,
    /// Work of evaluating one moment, in nodes at rest.
    pub(in crate::fbx) work: usize,
    /// Numbers of the nodes that it moves, rising; none in files without numbers.
    pub(in crate::fbx) moved: Vec<i64>,
    pub(in crate::fbx) moves_shapes: bool,
}

/// The scene at one moment.
pub(in crate::fbx) struct Moment(fbx_rs::EvaluatedScene);

impl Moment {
    pub(in crate::fbx) fn local(&self, node: usize) -> Local {
        Local::of(&self.0.nodes[node].local_transform)
    }

    /// Amount of a channel of blend shapes; 1 is 100 %.
    pub(in crate::fbx) fn amount(&self, channel: usize) -> f64 {
        self.0.blend_weights[channel]
    }
}

impl Scene {
    /// The takes, in the order of the file.
    ///
    /// # Errors
    /// [`ReadError::LimitExceeded`] if takes share so many properties or keys that looking at them takes long.
    pub(in crate::fbx) fn stacks(&self) -> Result<Vec<Stack>, ReadError> {
        let stacks = || self.file.animation_stacks().iter();
        let layers = stacks().flat_map(|stack| &stack.layers);
        let layers = layers.map(|&at| &self.file.animation_layers()[at]);
        let bindings: usize = layers.clone().map(|layer| layer.bindings.len()).sum();
        let which = "animated properties of all takes";
        Limits::check("takes", which, bindings as u64, MAX_BINDINGS)?;
        let values = layers.flat_map(|layer| &layer.bindings).map(|b| b.value);
        let curves = values.flat_map(|at| self.file.animation_values()[at].curves);
        let lengths =
            curves.map(|at| at.map_or(0, |at| self.file.animation_curves()[at].keys.len()));
        let keys: usize = lengths.sum();
        Limits::check("takes", "keys of all takes", keys as u64, MAX_KEYS)?;
        Ok(stacks().map(|stack| self.stack(stack)).collect())
    }

    fn stack(&self, stack: &fbx_rs::AnimationStack) -> Stack {
        let layers = || {
            let layers = stack.layers.iter();
            layers.map(|&at| &self.file.animation_layers()[at])
        };
        let bindings: Vec<&AnimationBinding> = layers().flat_map(|l| &l.bindings).collect();
        let mut made = Stack {
            name: stack.name.clone(),
            begin: stack.time_begin,
            end: stack.time_end,
            keys: None,
            key_count: 0,
            goes_on: false,
            jumps: Vec::new(),
            work: self.nodes.len() + bindings.len() * (1 + stack.layers.len() / 8),
            moved: Vec::new(),
            moves_shapes: false,
        };
        for binding in bindings {
            let is_shape = binding.property == b"DeformPercent";
            let is_place = PLACING.contains(&&binding.property[..]);
            if !is_shape && !is_place && binding.property != b"Weight" {
                continue;
            }
            let value = &self.file.animation_values()[binding.value];
            let curves = value.curves.iter().flatten();
            for curve in curves.map(|&at| &self.file.animation_curves()[at]) {
                made.add(curve);
                made.moves_shapes |= is_shape && !curve.keys.is_empty();
            }
            if is_place && binding.source_id != 0 {
                made.moved.push(binding.source_id);
            }
        }
        made.moved.sort_unstable();
        made.moved.dedup();
        made.jumps.sort_by(f64::total_cmp);
        made.jumps.dedup();
        made
    }

    /// Evaluates a take.
    pub(in crate::fbx) fn moment(&self, stack: usize, secs: f64) -> Result<Moment, ReadError> {
        let bounds = fbx_rs::Limits::default();
        let made = self.file.evaluate(Some(stack), secs);
        made.map(Moment)
            .map_err(|error| read_error(error, "animation", &bounds))
    }
}

impl Stack {
    fn add(&mut self, curve: &fbx_rs::AnimationCurve) {
        let times = curve.keys.iter().map(|k| k.time).filter(|t| t.is_finite());
        for time in times {
            let (first, last) = self.keys.get_or_insert((time, time));
            (*first, *last) = (first.min(time), last.max(time));
        }
        self.key_count += curve.keys.len();
        let ends = [curve.pre_extrapolation, curve.post_extrapolation];
        self.goes_on |= ends
            .iter()
            .any(|end| end.mode != fbx_rs::ExtrapolationMode::Constant);
        for pair in curve.keys.windows(2) {
            if pair[0].value != pair[1].value {
                match pair[0].interpolation {
                    Interpolation::ConstantPrevious => {
                        self.jumps.push(pair[1].time - f64::from(JUMP_SECS));
                    }
                    Interpolation::ConstantNext => self.jumps.push(pair[0].time),
                    _ => {}
                }
            }
        }
    }
}
