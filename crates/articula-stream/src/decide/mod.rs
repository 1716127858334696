//! Decisions of adaptation: what to send and to show, as pure functions without clock or I/O.
//!
//! Source: thesis 3.2, 3.2.1, 3.2.2 and 7.2.1; `docs/methods/adaptation.md` has the formulas, the proof of
//! the joint choice and the rules of the simulator.
//!
//! - [`NetworkShare`], [`DeviceBenchmark`], [`finest_level`]: the adaptation ratio of the thesis, and
//!   the level that it allows
//! - [`combine`]: one level from the limits of network, device, view and user
//!
//! Levels count from 0, the finest.

mod levels;
mod ratio;

pub use levels::{LevelChoice, LevelLimit, LimitSource, combine};
pub use ratio::{DeviceBenchmark, NetworkShare, finest_level};
