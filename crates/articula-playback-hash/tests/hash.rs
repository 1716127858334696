//! The program, as the checks of other platforms call it.
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test may panic and calls the program"
)]

use std::process::Command;

fn hash() -> String {
    let ran = Command::new(env!("CARGO_BIN_EXE_articula-playback-hash"))
        .output()
        .unwrap();
    assert!(ran.status.success());
    String::from_utf8(ran.stdout).unwrap()
}

#[test]
fn a_playback_has_the_same_hash_every_time() {
    let first = hash();
    assert_eq!(first.trim().len(), 16, "{first}");
    // What the program prints where the figure cannot be built.
    assert_ne!(u64::from_str_radix(first.trim(), 16), Ok(0));
    assert_eq!(hash(), first);
}
