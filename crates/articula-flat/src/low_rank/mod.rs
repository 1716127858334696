//! Truncated singular value decomposition: a table of numbers as a few components.
//!
//! Both forms are subspace iterations over the same orthonormalisation. `tall` is for tables of
//! which every row is a frame: it takes the mean row out and grows its block until what is left
//! is small enough. `wide` is for few rows that are very long: it works on their Gram matrix.
//!
//! - `jacobi`: eigenvectors of the small symmetric matrix inside
//! - `quantised`: components in whole numbers, with the error that this costs
//! - `orthonormal`: Gram and Schmidt

mod jacobi;
mod orthonormal;
pub(crate) mod quantised;
mod tall;
mod wide;

pub(crate) use orthonormal::dot;
pub(crate) use tall::{Component, LowRank, Table, decompose};
pub(crate) use wide::modes;
