//! Choice of one LOD option for each character, with the least total error within a cost budget.
//!
//! Source: `docs/methods/motion-lod.md` part 7. Input: cost and error of the options of each
//! character, its weight and its size on screen. Output: the chosen option of each character, and
//! the characters whose option changed.
//!
//! - [`LodOption`]: cost and error of a kind of character at one level of detail;
//!   [`BudgetAllocator::add_options`] keeps those on the lower hull
//! - [`BudgetAllocator`]: the choice for all characters, repaired from frame to frame
//! - [`CostModel`]: the cost of an option, learned from times that the caller measured
//!
//! ```
//! use articula_core::budget::{BudgetAllocator, LodOption, BudgetPolicy, LodRequest};
//!
//! // Two options of a character: coarse with an error of 50 mm, or all joints.
//! let lod_options = [(40.0, 0.050), (200.0, 0.0)]
//!     .map(|(cost, error_metres)| LodOption { cost, error_metres });
//! let mut budget = BudgetAllocator::new(2, BudgetPolicy::default());
//! let option_set = budget.add_options(&lod_options)?;
//!
//! // The first is near, the second far; the budget allows one of them all joints.
//! let request = |pixels_per_metre| {
//!     let weight = pixels_per_metre;
//!     LodRequest { option_set, weight, pixels_per_metre }
//! };
//! budget.request(0, request(200.0));
//! budget.request(1, request(10.0));
//! let report = budget.solve(250.0);
//! assert_eq!(report.used, 240.0);
//! assert_eq!([budget.choice(0), budget.choice(1)], [Some(1), Some(0)]);
//! for change in budget.changes() {
//!     println!("{}: {:?} -> {:?}", change.character, change.from, change.to);
//! }
//! # Ok::<(), articula_core::Mismatch>(())
//! ```

mod character_entry;
mod cost_model;
mod frontier;
mod knapsack;
mod lod_options;
mod report;

pub use character_entry::{BudgetPolicy, LodRequest};
pub use cost_model::{CostModel, Workload};
pub use knapsack::BudgetAllocator;
pub use lod_options::{LodOption, LodOptionSetId};
pub use report::{AllocationReport, OptionChange};
