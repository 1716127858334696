//! Cost of cutting a stream: by its index, by its description, and by xsltproc.
//!
//! `cargo bench -p articula-stream --no-default-features --bench cut`
#![allow(clippy::disallowed_methods, reason = "xsltproc reads files")]

use articula_stream::description::{
    AdaptMode, GbsdOptions, Holes, Selection, adapt_gbsd, gbsd_to_bin, stylesheet, write_gbsd,
};
use articula_stream::{
    Coding, DescriptionLimits, Field, Meaning, Unit, cut, cut_by_index, read_index, write_index,
};
use divan::counter::BytesCount;
use divan::{Bencher, black_box};
use std::path::PathBuf;
use std::process::Command;

fn main() {
    divan::main();
}

/// A stream of access units with their lengths, each of `units` units of `bytes` bytes at the
/// levels 0 to 5.
fn stream(access_units: usize, units: usize, bytes: usize) -> (Vec<u8>, Unit) {
    let length = 4 + units * bytes;
    let mut stream = vec![0x5a; access_units * length];
    let mut map = Unit::of_bytes("abp2", 0..stream.len());
    for (number, chunk) in stream.chunks_mut(length).enumerate() {
        let start = number * length;
        let value = (units * bytes) as u32;
        chunk[..4].copy_from_slice(&value.to_be_bytes());
        let bits = 8 * start as u64..8 * start as u64 + 32;
        let part = |unit: usize| {
            let from = start + 4 + unit * bytes;
            Unit::of_bytes("unit", from..from + bytes).marked("loa", (unit % 6) as u32)
        };
        let access_unit = Unit {
            fields: vec![Field {
                name: "au_bytes".into(),
                bits,
                value: u64::from(value),
                coding: Coding::BigEndian,
                meaning: Meaning::BytesAfter,
            }],
            children: (0..units).map(part).collect(),
            ..Unit::of_bytes("access_unit", start..start + length)
        };
        map.children
            .push(access_unit.marked("access_unit", number as u32));
    }
    (stream, map)
}

fn half() -> Selection {
    Selection::of_loa(2)
}

/// A stream is cut to half by the records of its index, and its new index written; bytes per second of the
/// whole stream.
#[divan::bench(args = [64, 1024, 16384])]
fn by_index(bencher: Bencher<'_, '_>, unit_bytes: usize) {
    let units = (64 << 20) / 16 / unit_bytes;
    let (stream, map) = stream(16, units, unit_bytes);
    let index = write_index(&map);
    let selection = half();
    bencher
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| {
            let keeps = |unit: &Unit| selection.keeps(unit);
            cut_by_index(&stream, black_box(&index), keeps).expect("a cut")
        });
}

/// The same by the tree of its units: the index is read, the stream cut; no index is written.
#[divan::bench(args = [64, 1024, 16384])]
fn by_tree(bencher: Bencher<'_, '_>, unit_bytes: usize) {
    let units = (64 << 20) / 16 / unit_bytes;
    let (stream, map) = stream(16, units, unit_bytes);
    let index = write_index(&map);
    let selection = half();
    bencher
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| {
            let map = read_index(black_box(&index)).expect("an index");
            cut(&stream, &map, |unit| selection.keeps(unit)).expect("a cut")
        });
}

/// The same, of a map that is in memory.
#[divan::bench(args = [64, 1024, 16384])]
fn by_map(bencher: Bencher<'_, '_>, unit_bytes: usize) {
    let units = (64 << 20) / 16 / unit_bytes;
    let (stream, map) = stream(16, units, unit_bytes);
    let selection = half();
    bencher
        .counter(BytesCount::new(stream.len()))
        .bench_local(|| {
            cut(black_box(&stream), &map, |unit| selection.keeps(unit)).expect("a cut")
        });
}

/// 600 access units of 180 units of 64 bytes: the numbers of a long motion of 90 bones.
fn motion() -> (Vec<u8>, Unit, String) {
    let (stream, map) = stream(600, 180, 64);
    let text = write_gbsd(&map, &GbsdOptions::default()).expect("a description");
    (stream, map, text)
}

#[divan::bench]
fn motion_by_index(bencher: Bencher<'_, '_>) {
    let (stream, map, _) = motion();
    let index = write_index(&map);
    let selection = half();
    bencher.bench_local(|| {
        let keeps = |unit: &Unit| selection.keeps(unit);
        cut_by_index(&stream, black_box(&index), keeps).expect("a cut")
    });
}

#[divan::bench]
fn motion_by_tree(bencher: Bencher<'_, '_>) {
    let (stream, map, _) = motion();
    let index = write_index(&map);
    bencher.bench_local(|| {
        let map = read_index(black_box(&index)).expect("an index");
        cut(&stream, &map, |unit| half().keeps(unit)).expect("a cut")
    });
}

#[divan::bench]
fn motion_by_description(bencher: Bencher<'_, '_>) {
    let (stream, _, text) = motion();
    let limits = DescriptionLimits::default();
    bencher
        .counter(BytesCount::new(text.len()))
        .bench_local(|| {
            let adapted = adapt_gbsd(text.as_bytes(), &half(), AdaptMode::Conformant, &limits);
            let adapted = adapted.expect("a description");
            gbsd_to_bin(adapted.as_bytes(), &stream, Holes::Skip, &limits).expect("a stream")
        });
}

/// Nothing where xsltproc is not installed.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn motion_by_xsltproc(bencher: Bencher<'_, '_>) {
    let (stream, _, text) = motion();
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let (sheet, input) = (folder.join("bench.xslt"), folder.join("bench.xml"));
    let written = std::fs::create_dir_all(&folder)
        .and_then(|()| std::fs::write(&sheet, stylesheet()))
        .and_then(|()| std::fs::write(&input, &text));
    written.expect("files of the bench");
    if Command::new("xsltproc").arg("--version").output().is_err() {
        return;
    }
    let limits = DescriptionLimits::default();
    bencher
        .counter(BytesCount::new(text.len()))
        .bench_local(|| {
            let mut command = Command::new("xsltproc");
            for (name, value) in half().parameters() {
                command.args(["--stringparam", name, &value]);
            }
            let output = command.arg(&sheet).arg(&input).output().expect("xsltproc");
            gbsd_to_bin(&output.stdout, &stream, Holes::Skip, &limits).expect("a stream")
        });
}
