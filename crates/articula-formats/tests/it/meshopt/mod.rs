//! Tests of the meshopt decoder: the vectors of its makers, and mutations.

mod mutated;
mod vectors;
