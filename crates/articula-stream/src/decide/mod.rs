//! Decisions of adaptation: what to send and to show, as pure functions without clock or I/O.
//!
//! Source: thesis 3.2, 3.2.1, 3.2.2 and 7.2.1; `docs/methods/adaptation.md` has the formulas, the proof of
//! the joint choice and the rules of the simulator.
//!
//! - [`NetworkShare`], [`DeviceBenchmark`], [`finest_level`]: the adaptation ratio of the thesis, and
//!   the level that it allows
//! - [`choose`]: the joint choice, one option for each of the [`Part`]s, with the least visible error
//!   for bytes and time
//! - [`decide()`]: the whole decision, with [`Preference`]s, the fall to another [`Representation`], and
//!   its reasons; [`Assumptions`], [`weigh_parts`] and [`wanted_modality`] take its input from a
//!   [`Context`](crate::description::Context)
//! - [`ThroughputEstimator`], [`LayerSwitch`], [`FrameTimeSwitch`]: what changes over time, as state machines on the caller's clock
//! - [`simulate()`]: plays content over a bandwidth trace under a [`Policy`]
//!
//! Levels count from 0, the finest.

mod bandwidth_trace;
mod choice;
mod decision;
#[cfg(test)]
mod decision_tests;
mod device;
mod explanation;
mod from_context;
mod part;
mod preference;
mod ratio;
mod representation;
mod simulate;
mod switching;
mod throughput;

pub use bandwidth_trace::BandwidthTrace;
pub use choice::{
    Budget, Choice, ChoiceRequest, choose, choose_exhaustively, cut_equally, cut_one,
};
pub use decision::{Bound, Decision, DecisionRequest, NextStep, Outcome, PartDecision};
pub use device::decide;
pub use from_context::{Assumptions, wanted_modality, weigh_parts};
pub use part::{MAX_OPTIONS, Part, PartKind, PartOption, pixels_per_metre};
pub use preference::{LimitSource, Preference, Rule};
pub use ratio::{DeviceBenchmark, NetworkShare, finest_level};
pub use representation::Representation;
pub use simulate::{
    Action, BufferBased, Content, Delivery, FixedVersion, Layered, Playback, PlayerView, Policy,
    RateBased, Request, Segment, Shown, SimulationOptions, ThesisRatio, Versions, simulate,
};
pub use switching::{FrameTimeSwitch, LayerSwitch, SwitchRule};
pub use throughput::{ThroughputEstimator, ThroughputOptions, Transfer};
