//! The character with fewer keys, triangles and bytes of pictures, before it is prepared: what is prepared then belongs to
//! what is written.

use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::open;
use articula::CharacterFile;
use articula::optimize::{Compression, ErrorBound, OptimizeOptions, optimize};
use serde::Serialize;

/// What was left out, and the error of that.
#[derive(Debug, Serialize)]
pub(super) struct OptimizedFirst {
    /// Bytes without what is prepared.
    bytes: usize,
    triangles_in: usize,
    triangles_out: usize,
    error_mm: f32,
    bound_mm: f32,
}

impl OptimizedFirst {
    pub(super) fn text(&self) -> String {
        format!(
            "optimised first: {} bytes without the prepared data, triangles {} -> {}, error in motion {:.3} mm of {:.3} mm allowed\n",
            self.bytes, self.triangles_in, self.triangles_out, self.error_mm, self.bound_mm
        )
    }
}

/// The character within an error. Positions stay floats in the unit of the mesh, since mesh levels are made of them.
pub(super) fn optimized(
    opened: &CharacterFile,
    error: ErrorBound,
    (seed, names): (u64, &ReadArgs),
    console: &Console,
) -> anyhow::Result<(CharacterFile, OptimizedFirst)> {
    let options = OptimizeOptions {
        error,
        compression: Compression::None,
        seed,
        ..OptimizeOptions::default()
    };
    let made = console.work(|work| optimize(opened, &options, work))?;
    let mut again = open::again(&made.glb, opened.name(), names)?;
    let told: Vec<_> = opened.warnings().to_vec();
    *again.warnings_mut() = told;
    let first = OptimizedFirst {
        bytes: made.glb.len(),
        triangles_in: made.report.triangles_in,
        triangles_out: made.report.triangles_out,
        error_mm: made.report.error_mm,
        bound_mm: made.report.bound_mm,
    };
    Ok((again, first))
}
