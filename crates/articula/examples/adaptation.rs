//! Decides what to send of a character for several bandwidths, and plays policies of a player over
//! bandwidth traces: stalls, error, bytes and switches.
//!
//! The parts are made up, with sizes and errors as streams and meshes have them. With a file of lines
//! of seconds and bits per second, that trace is played instead of made ones.
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "an example prints its results, reads a file and measures time"
)]

use articula::stream::decide::{
    Assumptions, BandwidthTrace, BufferBased, ChoiceRequest, Content, DecisionRequest,
    DeviceBenchmark, FixedVersion, Layered, Part, PartKind, PartOption, Policy, Preference,
    RateBased, Representation, Segment, SimulationOptions, ThesisRatio, Versions, choose,
    cut_equally, cut_one, decide, finest_level, simulate, wanted_modality, weigh_parts,
};
use articula::stream::description::Context;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    for kbit in [4.0, 40.0, 120.0, 600.0] {
        decision(kbit)?;
    }
    slower_device();
    time_of_a_choice()?;
    let traces = match std::env::args().nth(1) {
        Some(file) => {
            let trace = BandwidthTrace::read(&std::fs::read_to_string(&file)?)?;
            vec![(file, trace)]
        }
        None => made_traces(),
    };
    play(&traces)
}

fn option(name: &str, bytes: [f64; 2], frame_ns: u64, error_m: f64) -> PartOption {
    PartOption {
        name: name.to_owned(),
        bytes_once: bytes[0] as u64,
        bytes_per_second: bytes[1],
        frame_ns,
        error_m,
        ..Default::default()
    }
}

fn parts() -> Vec<Part> {
    let body = [3.0, 2.0, 1.0, 0.0].map(|tier: f64| {
        let name = format!("tier {tier}");
        option(
            &name,
            [600.0, 3000.0 * 0.55_f64.powf(tier)],
            60_000,
            0.0005 * 3.0_f64.powf(tier),
        )
    });
    let face = [
        ("very low", 250.0, 0.006),
        ("low", 400.0, 0.003),
        ("high", 900.0, 0.0003),
    ];
    let face = face.map(|(name, rate, error)| option(name, [200.0, rate], 20_000, error));
    let mesh = [
        ("1000 triangles", 9e3, 0.012),
        ("4000", 26e3, 0.005),
        ("16000", 80e3, 0.0015),
    ];
    let mesh = mesh.map(|(name, bytes, error)| option(name, [bytes, 0.0], 100_000, error));
    let texture = [
        ("128 pixels", 4e3, 0.008),
        ("512", 38e3, 0.002),
        ("2048", 420e3, 0.0005),
    ];
    let texture = texture.map(|(name, bytes, error)| option(name, [bytes, 0.0], 50_000, error));
    vec![
        Part::new("body motion", PartKind::BodyMotion, body.to_vec()),
        Part::new("face motion", PartKind::FaceMotion, face.to_vec()),
        Part::new("mesh", PartKind::Mesh, mesh.to_vec()),
        Part::new("texture", PartKind::Texture, texture.to_vec()),
    ]
}

/// Prints a decision with its reasons, and what cutting one part alone or all alike would give.
fn decision(kbit: f64) -> Result<(), Box<dyn Error>> {
    let mut context = Context::default();
    context.network.available_bps = Some(kbit * 1e3);
    context.preferences.tolerance_px = Some(0.5);
    let assumed = Assumptions {
        window_secs: 10.0,
        ..Default::default()
    };
    let mut parts = parts();
    weigh_parts(&mut parts, &context);
    let vector = Representation {
        modality: "vector/player".to_owned(),
        bytes: 4_500,
        error_px: 3.0,
        needs: vec!["svg".to_owned()],
    };
    let choice = ChoiceRequest::of_context(&context, &assumed);
    let preferences = Preference::of_context(&context);
    println!("{kbit} kbit/s");
    let decision = decide(&DecisionRequest {
        parts: &parts,
        parts_need: &["webgl".to_owned()],
        choice,
        preferences: &preferences,
        representations: &[vector],
        capabilities: &["webgl".to_owned(), "svg".to_owned()],
        modality: wanted_modality(&context),
        device: DeviceBenchmark::of_context(&context),
    })?;
    print!("{decision}");
    for (which, part) in parts.iter().enumerate() {
        if let Some(cut) = cut_one(&parts, &choice, which)? {
            println!("cutting {} alone: {:.2} px", part.name, cut.error_px);
        }
    }
    if let Some(cut) = cut_equally(&parts, &choice)? {
        println!("cutting all alike: {:.2} px", cut.error_px);
    }
    println!();
    Ok(())
}

/// Prints what a device three times slower than the reference machine can bear.
fn slower_device() {
    let device = DeviceBenchmark {
        reference_fps: 50.0,
        wanted_fps: 25.0,
        reference_score: 90.0,
        device_score: 30.0,
        share: 1.0,
    };
    println!(
        "media ratio {:.2}, device ratio {:.2}, adaptation ratio {:.2}",
        device.media_ratio(),
        device.device_ratio(),
        device.ratio()
    );
    // Cost of each level, as a share of that of the finest.
    let shares = [1.0, 0.7, 0.45, 0.3, 0.2];
    if let Some(level) = finest_level(device.ratio(), &shares) {
        let allowed_ns = device.frame_ns_allowed(1_000_000);
        println!("level {level}, within {allowed_ns} of 1000000 ns a frame");
    }
    println!();
}

/// Prints the time of a choice among 40 options of each of eight parts, and its distance from the
/// bound.
fn time_of_a_choice() -> Result<(), Box<dyn Error>> {
    let part = |p: usize| {
        let options = (0..40).map(|i| {
            let rough = 1.0 + 0.1 * ((i * 7 + p * 3) % 5) as f64;
            let bytes = 300.0 * 1.15_f64.powi(i as i32) * rough;
            let error = 0.05 * 1.12_f64.powi(-(i as i32)) * (1.0 + 0.2 * p as f64);
            option("", [bytes, 0.0], 1000 * (i as u64 + 1), error)
        });
        Part::new(format!("part {p}"), PartKind::Other, options.collect())
    };
    let parts: Vec<Part> = (0..8).map(part).collect();
    let mut request = ChoiceRequest::of_context(&Context::default(), &Assumptions::default());
    let (mut times, mut gap) = (Vec::new(), 0.0_f64);
    for step in 1..=50 {
        request.budget.bytes = 8_000 * step;
        request.budget.frame_ns = 60_000 + 4_000 * step;
        let start = Instant::now();
        let choice = choose(&parts, &request)?;
        times.push(start.elapsed().as_secs_f64() * 1e6);
        gap = choice.map_or(gap, |c| gap.max(c.error_px / c.bound_px - 1.0));
    }
    times.sort_by(f64::total_cmp);
    let (median, most) = (times[25], times[49]);
    println!(
        "8 parts of 40 options: median {median:.0} us, most {most:.0} us, gap {:.3} %",
        100.0 * gap
    );
    println!();
    Ok(())
}

/// Traces by name; those of the tests of the simulator.
fn made_traces() -> Vec<(String, BandwidthTrace)> {
    [
        ("step up", BandwidthTrace::step(60e3, 400e3, 40.0)),
        ("step down", BandwidthTrace::step(400e3, 60e3, 40.0)),
        ("ramp", BandwidthTrace::ramp(40e3, 400e3, 10.0, 110.0)),
        (
            "square wave",
            BandwidthTrace::square(250e3, 60e3, 20.0, 130.0),
        ),
        (
            "nothing for 8 s",
            BandwidthTrace::drop_to_zero(250e3, 50.0, 58.0),
        ),
        ("noise", BandwidthTrace::noisy(3, 150e3, 130.0)),
        ("noise, slow", BandwidthTrace::noisy(11, 60e3, 130.0)),
    ]
    .map(|(name, trace)| (name.to_owned(), trace))
    .to_vec()
}

/// Segments of a second with five layers of 20, 40, 72, 112 and 160 kbit/s, livelier and quieter by
/// 30 %; a version coded alone is 5 % smaller.
fn content(segments: usize) -> Result<Content, Box<dyn Error>> {
    let segment = |i: usize| {
        let lively = 1.0 + 0.3 * (i as f64 * 0.7).sin();
        let sizes = |factor: f64| {
            let all = [2500.0, 5000.0, 9000.0, 14_000.0, 20_000.0];
            all.map(|bytes| (bytes * lively * factor) as u64).to_vec()
        };
        Segment {
            layered_bytes: sizes(1.0),
            version_bytes: sizes(0.95),
            error_px: [40.0, 9.0, 4.0, 1.7, 0.7, 0.25]
                .map(|e| e * lively)
                .to_vec(),
        }
    };
    let frames = vec![0.2e6, 0.3e6, 0.45e6, 0.7e6, 1e6];
    Ok(Content::new(
        1.0,
        (0..segments).map(segment).collect(),
        frames,
    )?)
}

fn policies() -> Vec<Box<dyn Policy>> {
    vec![
        Box::new(Layered::new(usize::MAX, f64::INFINITY)),
        Box::new(ThesisRatio),
        Box::new(RateBased::default()),
        Box::new(BufferBased),
        Box::new(Versions::default()),
        Box::new(FixedVersion { version: 1 }),
        Box::new(FixedVersion { version: 3 }),
        Box::new(FixedVersion { version: 5 }),
    ]
}

fn play(traces: &[(String, BandwidthTrace)]) -> Result<(), Box<dyn Error>> {
    let content = content(120)?;
    println!(
        "| trace | policy | stalls | stalled, s | mean, px | p95, px | kB | wasted | switches/min |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (name, trace) in traces {
        for policy in &mut policies() {
            let options = SimulationOptions::default();
            let p = simulate(&content, trace, policy.as_mut(), &options);
            println!(
                "| {name} | {} | {} | {:.1} | {:.2} | {:.2} | {:.0} | {:.0} | {:.1} |",
                policy.name(),
                p.stalls,
                p.stall_secs,
                p.mean_error_px,
                p.p95_error_px,
                p.bytes as f64 / 1e3,
                p.wasted_bytes as f64 / 1e3,
                p.switches_per_minute(content.segment_secs()),
            );
        }
    }
    Ok(())
}
