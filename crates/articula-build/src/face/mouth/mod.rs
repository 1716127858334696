//! Motions of the lower face, measured on heads with blend shapes of their own, for heads without any.
//!
//! - `chart`: where a vertex is around the mouth, alike on all heads
//! - `depths`: how far vertices are behind the foremost skin
//! - `laid_on`: parts on the skin, such as lips of their own
//! - `motion`: the motion of one blend shape over the chart
//! - `measure`: the motion that a head shows
//! - `motions`: the motions of all blend shapes, and their file
//!
//! Method and sources: `docs/methods/faces.md`.

mod chart;
mod depths;
mod laid_on;
mod measure;
mod motion;
mod motions;

pub use chart::MouthChart;
pub use motions::{BrokenMotions, MouthMotions};
