//! A motion of one figure put onto another.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod bodies;
mod feet;
mod figure;
mod hostile;
mod rest_poses;
