//! Promises of the meshopt decoder: the vectors of its makers, and whatever the bytes.

mod mutated;
mod vectors;
