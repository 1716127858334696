//! What the device is, as the operating system tells.

use articula::core::Backend;
use articula::device::{DeviceDescription, FirstGuess, calibrate};
use articula_report::nanoseconds;
use std::hint::black_box;
use std::process::Command;

/// How often the calibration is timed.
const CALIBRATIONS: usize = 5;
/// Most characters of a model.
const MOST_CHARACTERS: usize = 100;

/// Describes this device, with the instruction set and the number of threads that pose a crowd.
pub(super) fn description(backend: Backend, threads: usize) -> DeviceDescription {
    DeviceDescription {
        cpu: cpu(),
        cores: cores(),
        os: std::env::consts::OS.to_owned(),
        arch: std::env::consts::ARCH.to_owned(),
        program: env!("CARGO_PKG_VERSION").to_owned(),
        backend: backend.to_string(),
        threads,
    }
}

/// Times the calibration, for crowds that are posed by a number of threads.
pub(super) fn first_guess(threads: usize) -> FirstGuess {
    let times = (0..CALIBRATIONS).map(|_| {
        nanoseconds(&mut || {
            black_box(calibrate());
        })
    });
    FirstGuess {
        calibration_secs: 1e-9 * times.fold(f64::INFINITY, f64::min),
        cores: cores(),
        threads,
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The model of the processor; its architecture where nothing tells it.
fn cpu() -> String {
    let told = match std::env::consts::OS {
        "macos" => said("sysctl", &["-n", "machdep.cpu.brand_string"]),
        "windows" => std::env::var("PROCESSOR_IDENTIFIER").ok(),
        _ => std::fs::read_to_string("/proc/cpuinfo")
            .ok()
            .and_then(|text| model(&text)),
    };
    let plain = |text: String| -> String {
        let words: Vec<&str> = text.split_whitespace().collect();
        words.join(" ").chars().take(MOST_CHARACTERS).collect()
    };
    let told = told.map(plain).filter(|text| !text.is_empty());
    told.unwrap_or_else(|| std::env::consts::ARCH.to_owned())
}

/// The model in `/proc/cpuinfo`: x86 calls it a name, some others hardware.
fn model(text: &str) -> Option<String> {
    let named = |name: &str| {
        let lines = text.lines().filter_map(|line| line.split_once(':'));
        let mut of_name = lines.filter(|(key, _)| key.trim() == name);
        of_name.next().map(|(_, value)| value.trim().to_owned())
    };
    ["model name", "Hardware", "Model", "cpu"]
        .into_iter()
        .find_map(named)
}

fn said(program: &str, words: &[&str]) -> Option<String> {
    let output = Command::new(program).args(words).output().ok()?;
    String::from_utf8(output.stdout).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_are_found_under_each_name() {
        let x86 = "processor\t: 0\nvendor_id\t: AuthenticAMD\nmodel name\t: AMD EPYC  7763\n";
        assert_eq!(model(x86).as_deref(), Some("AMD EPYC  7763"));
        let pi = "processor\t: 0\nBogoMIPS\t: 108.00\n\nModel\t\t: Raspberry Pi 4 Model B\n";
        assert_eq!(model(pi).as_deref(), Some("Raspberry Pi 4 Model B"));
        assert_eq!(model("nothing"), None);
        assert!(!cpu().is_empty() && cores() > 0);
    }
}
