//! The reference human with few triangles, created once for all tests, because its body takes seconds.

use articula_build::{Asset, ClipOptions, character};
use articula_core::source::Character;
use articula_human::{HumanOptions, human};
use std::sync::OnceLock;

/// The source character, with its clips.
pub(crate) fn source() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions::mannequin(3000)).unwrap())
}

/// The runtime character.
pub(crate) fn asset() -> &'static Asset {
    static ASSET: OnceLock<Asset> = OnceLock::new();
    ASSET.get_or_init(|| character(source(), None, &ClipOptions::default()).unwrap())
}
