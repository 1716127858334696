//! Any bytes as a character that is made lighter: an error, or a file that is read again, with an error in motion
//! within the bound.
#![no_main]

use articula::optimize::{ErrorBound, OptimizeOptions, optimize};
use articula::{Executor, OpenOptions, open};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut options = OpenOptions::default();
    options.limits.bytes = 1 << 18;
    options.limits.elements = 1 << 16;
    options.limits.nodes = 1 << 8;
    let alone = &mut |_: &str| Err("nothing".to_owned());
    let Ok(opened) = open(bytes, "file.glb", &options, alone) else {
        return;
    };
    let wanted = OptimizeOptions {
        error: ErrorBound::Metres(1e-3),
        ..OptimizeOptions::default()
    };
    if let Ok(made) = optimize(&opened, &wanted, &Executor::default()) {
        assert!(made.report.error_mm <= made.report.bound_mm, "{:?}", made.report);
        open(&made.glb, "made.glb", &OpenOptions::default(), alone).expect("what is written can be read");
    }
});
