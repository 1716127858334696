//! Truncated singular value decomposition: a matrix as a few components.
//!
//! Both forms are subspace iterations with the same orthonormalisation. `tall` takes matrices with
//! one row per frame: it subtracts the mean row and grows its block until the residual is small
//! enough. `wide` takes few rows that are very long and works on their Gram matrix.
//!
//! - `jacobi`: eigenvectors of the small symmetric matrix inside
//! - `quantised`: components as integers, within an error
//! - `orthonormal`: Gram-Schmidt

mod jacobi;
mod orthonormal;
pub(crate) mod quantised;
mod tall;
mod wide;

pub(crate) use tall::{Component, LowRank, Table, decompose};
pub(crate) use wide::modes;
