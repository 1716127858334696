//! The reference human, built once for all tests, because its body takes seconds.

use articula_build::{Asset, ClipOptions, character};
use articula_core::source::Character;
use articula_human::{HumanOptions, human};
use std::sync::OnceLock;

/// The source character, of 2,000 triangles.
pub(crate) fn of_2000() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions::mannequin(2000)).unwrap())
}

/// The runtime character, of 2,000 triangles.
pub(crate) fn asset_of_2000() -> &'static Asset {
    static HUMAN: OnceLock<Asset> = OnceLock::new();
    HUMAN.get_or_init(|| character(of_2000(), None, &ClipOptions::default()).unwrap())
}

/// The runtime character, of 4,000 triangles.
pub(crate) fn asset_of_4000() -> &'static Asset {
    static HUMAN: OnceLock<Asset> = OnceLock::new();
    HUMAN.get_or_init(|| {
        let source = human(&HumanOptions::mannequin(4000)).unwrap();
        character(&source, None, &ClipOptions::default()).unwrap()
    })
}
