//! Tests of the X3D reader and writer: every feature by a small file, every real file, round trips,
//! hostile and mutated files.

mod compare;
mod features;
mod hostile;
mod mutated;
mod written;
