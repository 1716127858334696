//! Takes one character through the library and hashes what comes out of each step, so that platforms
//! can be compared: `cargo xtask test` runs it natively and, built for WebAssembly, in node.
#![allow(
    unsafe_code,
    reason = "exported symbols are the only way for node to call the program"
)]
#![allow(
    clippy::print_stdout,
    reason = "the hashes are the output of the program"
)]

#[path = "../fnv.rs"]
mod fnv;
mod steps;

use std::cell::RefCell;

fn main() {
    print!("{}", lines());
}

/// A line of each step, and one of what failed.
fn lines() -> String {
    let mut lines = String::new();
    let taken = steps::take(&mut |step, hash| lines.push_str(&format!("{step}: {hash:016x}\n")));
    if let Err(fault) = taken {
        lines.push_str(&format!("failed: {fault}\n"));
    }
    lines
}

thread_local! {
    static SAID: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Keeps what the program prints and returns its length in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn say() -> usize {
    SAID.replace(lines().into_bytes());
    SAID.with_borrow(Vec::len)
}

/// Returns a byte of what was kept.
#[unsafe(no_mangle)]
pub extern "C" fn said(at: usize) -> u32 {
    SAID.with_borrow(|said| said.get(at).map_or(0, |byte| u32::from(*byte)))
}
