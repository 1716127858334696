//! The command-line program: what it prints, writes and refuses, and how other programs (three.js,
//! validators, players, a browser) read its files.
//!
//! One test program, since linking one is faster than linking many.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a test may panic, opens and writes files, and says what it skips"
)]

mod acclaim;
mod adaptation;
mod assets;
mod bounded_files;
mod browser;
mod bva;
mod captures;
mod clips;
mod compressed_oracle;
#[path = "../../../articula-serve/tests/it/connection.rs"]
mod connection;
mod conversion;
mod crowd;
mod devices;
mod face_maps;
mod face_shapes;
mod faces;
mod fba_oracle;
mod fbx;
mod flatten;
mod flatten_browser;
mod flatten_faces;
mod flatten_judged;
mod folders;
mod guides;
mod hostile;
mod items;
mod joint_levels;
mod joint_maps;
mod joint_schemes;
mod judges;
mod kept_files;
mod killed_server;
mod levels_oracle;
mod live_portraits;
mod mesh_levels;
mod meshopt_oracle;
mod mp4;
mod mpeg4;
mod network;
mod optimized;
mod oracle;
mod playing;
mod pose_cache_files;
mod program;
mod readme;
#[path = "../../../articula-formats/tests/it/real/mod.rs"]
mod real;
mod real_files;
mod resampling_oracle;
mod retargeting;
mod serving;
mod sizes;
mod skinned_files;
mod soak;
mod speak;
mod streams;
#[path = "../../../articula-formats/tests/it/thinned/mod.rs"]
mod thinned;
mod usage;
mod vrm;
mod x3d_oracle;

// The judges serve the tests of other crates too, which have it from elsewhere.
use articula::flat::Picture;
