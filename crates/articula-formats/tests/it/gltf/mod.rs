//! Tests of the glTF reader and writer: every feature by a tiny file made in code, every real file,
//! hostile and mutated ones.

mod clustered;
mod compressed;
mod features;
mod files;
mod hostile;
mod joints;
mod khr_character;
mod levels;
mod matrices;
mod mutated;
mod quantized;
mod single_weights;
mod texture_formats;
mod tiny;
mod vertex_classes;
mod vrm;
mod written;
