//! Takes one character through the library and hashes what comes out of each step, so that platforms
//! can be compared: `cargo xtask test` runs it natively and, built for WebAssembly, in node. The native one writes the
//! asset that it has prepared to a file, if it is given one.
#![allow(
    unsafe_code,
    reason = "exported symbols are the only way for node to call the program"
)]
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "the hashes and the asset are the output of the program"
)]

#[path = "../fnv.rs"]
mod fnv;
mod steps;

use std::cell::RefCell;

fn main() -> std::io::Result<()> {
    let (lines, prepared) = lines();
    print!("{lines}");
    match std::env::args_os().nth(1) {
        Some(file) => std::fs::write(file, prepared),
        None => Ok(()),
    }
}

/// A line of each step, and one of what failed; the prepared asset.
fn lines() -> (String, Vec<u8>) {
    let mut lines = String::new();
    let taken = steps::take(&mut |step, hash| lines.push_str(&format!("{step}: {hash:016x}\n")));
    let prepared = taken.unwrap_or_else(|fault| {
        lines.push_str(&format!("failed: {fault}\n"));
        Vec::new()
    });
    (lines, prepared)
}

thread_local! {
    static SAID: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Keeps what the program prints and returns its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn say() -> usize {
    SAID.replace(lines().0.into_bytes());
    SAID.with_borrow(Vec::len)
}

/// Returns a byte of what was kept.
#[unsafe(no_mangle)]
pub extern "C" fn said(at: usize) -> u32 {
    SAID.with_borrow(|said| said.get(at).map_or(0, |byte| u32::from(*byte)))
}
