//! `articula bench`: how much a device can play.
//!
//! - `device`: plays graded content and reports
//! - `hardware`: what the device is
//! - `report`: the result as JSON, as text and as a plot
//! - `send`: puts the result to a server

mod device;
mod hardware;
mod report;
mod send;

use crate::console::Console;
use clap::{Args, Subcommand};

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub(crate) struct BenchArgs {
    #[command(subcommand)]
    what: Benchmark,
}

/// What is benchmarked.
#[derive(Debug, Subcommand)]
enum Benchmark {
    /// Play graded content of the reference human until it is certain what this device can show at 25 and
    /// 60 frames per second
    Device(device::DeviceArgs),
}

/// Runs the benchmark.
pub(crate) fn run(args: &BenchArgs, console: &Console) -> anyhow::Result<()> {
    match &args.what {
        Benchmark::Device(args) => device::run(args, console),
    }
}
