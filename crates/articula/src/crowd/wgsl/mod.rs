//! Shaders that skin the characters of a crowd, in WGSL, to be put in front of a renderer's own.
//!
//! They read the buffers of `docs/formats/crowd-buffers.md`, version 2, and declare no entry point. A
//! renderer concatenates one of them and its own source, in which it calls
//!
//! - `articula_skin(instance, entries, weights)`: the matrix of a vertex, as three rows
//!   (`ArticulaRows`), for four influences; `articula_add` joins those of more
//! - `articula_point(rows, position)`, `articula_normal(rows, normal)`: the skinned vertex in model
//!   space
//! - `articula_world(articula_character(instance))`: the world transform of the character, as rows
//!
//! | group 1 | buffer, as read-only storage |
//! | --- | --- |
//! | binding 0 | palettes; for records and stepped draws the cached ones |
//! | binding 1 | draws, records, or stepped draws |
//! | binding 2 | world transforms |
//!
//! Stepped draws are drawn by the shader for draws, with their own buffers bound.
//!
//! `instance` counts the draws or records of the whole frame: draw each group with its first index as
//! `first_instance`. All names begin with `articula_` or `Articula`. Forms of halves are unpacked by
//! `unpack2x16float`, which WebGPU has and WebGL lacks.
//!
//! ```
//! use articula::crowd::{PaletteForm, wgsl};
//!
//! let vertex = r"
//!     @group(0) @binding(0) var<uniform> clip_from_world: mat4x4<f32>;
//!
//!     @vertex
//!     fn vertex(
//!         @builtin(instance_index) instance: u32,
//!         @location(0) position: vec3<f32>,
//!         @location(3) entries: vec4<u32>,
//!         @location(4) weights: vec4<f32>,
//!     ) -> @builtin(position) vec4<f32> {
//!         let skin = articula_skin(instance, entries, weights);
//!         let world = articula_world(articula_character(instance));
//!         let place = articula_point(world, articula_point(skin, position));
//!         return clip_from_world * vec4<f32>(place, 1.0);
//!     }";
//! let shader = format!("{}{vertex}", wgsl::draws(PaletteForm::HalfMatrix));
//! assert!(shader.contains("unpack2x16float"));
//! ```

use articula_core::PaletteForm;

macro_rules! module {
    ($($part:literal),+) => {
        concat!(include_str!("rows.wgsl"), $(include_str!($part)),+)
    };
}

/// Draws with palettes of [`PaletteForm::Matrix`].
pub const DRAWS_MATRIX: &str = module!("matrix.wgsl", "draws.wgsl");
/// Draws with palettes of [`PaletteForm::HalfMatrix`].
pub const DRAWS_HALF: &str = module!("halves.wgsl", "half.wgsl", "draws.wgsl");
/// Draws with palettes of [`PaletteForm::Rigid`].
pub const DRAWS_RIGID: &str = module!("rigid.wgsl", "draws.wgsl");
/// Draws with palettes of [`PaletteForm::HalfRigid`].
pub const DRAWS_HALF_RIGID: &str = module!("halves.wgsl", "half_rigid.wgsl", "draws.wgsl");
/// Blend records of cached palettes of [`PaletteForm::Matrix`].
pub const RECORDS_MATRIX: &str = module!("matrix.wgsl", "records.wgsl");
/// Blend records of cached palettes of [`PaletteForm::HalfMatrix`].
pub const RECORDS_HALF: &str = module!("halves.wgsl", "half.wgsl", "records.wgsl");

/// Returns the shader for draws with palettes of a form, and for stepped draws with cached ones.
pub fn draws(form: PaletteForm) -> &'static str {
    match form {
        PaletteForm::Matrix => DRAWS_MATRIX,
        PaletteForm::HalfMatrix => DRAWS_HALF,
        PaletteForm::Rigid => DRAWS_RIGID,
        PaletteForm::HalfRigid => DRAWS_HALF_RIGID,
    }
}

/// Returns the shader for blend records with cached palettes of a form; `None` for forms that are not
/// cached.
pub fn records(form: PaletteForm) -> Option<&'static str> {
    match form {
        PaletteForm::Matrix => Some(RECORDS_MATRIX),
        PaletteForm::HalfMatrix => Some(RECORDS_HALF),
        PaletteForm::Rigid | PaletteForm::HalfRigid => None,
    }
}
