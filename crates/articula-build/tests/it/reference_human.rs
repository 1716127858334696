//! The reference human, made once for all tests: its body takes seconds.

use articula_build::{Asset, ClipOptions, character};
use articula_core::source::Character;
use articula_human::{HumanOptions, human};
use std::sync::OnceLock;

/// Of 2,000 triangles, as it is written.
pub(crate) fn of_2000() -> &'static Character {
    static HUMAN: OnceLock<Character> = OnceLock::new();
    HUMAN.get_or_init(|| human(&HumanOptions { triangles: 2000 }).unwrap())
}

/// Of 2,000 triangles, as it plays.
pub(crate) fn asset_of_2000() -> &'static Asset {
    static HUMAN: OnceLock<Asset> = OnceLock::new();
    HUMAN.get_or_init(|| character(of_2000(), None, &ClipOptions::default()).unwrap())
}

/// Of 4,000 triangles, as it plays.
pub(crate) fn asset_of_4000() -> &'static Asset {
    static HUMAN: OnceLock<Asset> = OnceLock::new();
    HUMAN.get_or_init(|| {
        let source = human(&HumanOptions { triangles: 4000 }).unwrap();
        character(&source, None, &ClipOptions::default()).unwrap()
    })
}
