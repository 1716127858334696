//! The input of all benches: the reference human, so that no file is needed.

use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_core::Clip;
use articula_human::{HumanOptions, human};
use std::sync::LazyLock;

/// The reference human at 12,000 triangles, with its clips.
pub(crate) fn asset() -> &'static Asset {
    static ASSET: LazyLock<Asset> = LazyLock::new(|| {
        let source = human(&HumanOptions::mannequin(12_000)).expect("12,000 triangles are allowed");
        character(&source, None, &ClipOptions::default()).expect("the human is a character")
    });
    &ASSET
}

/// The walk, and distinct times within it in random order.
pub(crate) fn walk(count: usize) -> (&'static Clip, Vec<f32>) {
    let clip = asset().clips.iter().find(|c| c.name == "walk");
    let clip = clip.expect("the human walks");
    let phase = |i: usize| (i as f32 * 0.618_034).fract();
    let times = (0..count).map(|i| phase(i) * clip.duration_secs());
    (clip, times.collect())
}
