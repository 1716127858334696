//! Reading any bytes returns a value or an error.
//!
//! The counterpart on stable Rust of the fuzz target `mpeg4`: truncation at every byte and seeded
//! mutations.

use super::texts;
use articula_formats::mpeg4::{bap, epf, fap, fdp};
use articula_formats::{Limits, joint_map};
use articula_mutate::{Edit, Mutations, cut_off};

/// Number of mutations per file.
const TRIES: usize = 3000;

/// Words of the formats, inserted at random.
const WORDS: [&str; 16] = [
    "0",
    "1",
    "-1",
    "2147483648",
    "1e9",
    "NaN",
    "2.1",
    "#",
    "FBM 1",
    "FMT",
    "TC",
    "<fdp>",
    "</fdp>",
    "&amp;",
    "<!DOCTYPE a>",
    "\"",
];

fn reads_fap(bytes: &[u8]) -> bool {
    let Ok(read) = fap::read(bytes, fap::AbsentPolicy::Hold, &Limits::default()) else {
        return false;
    };
    let numbers: Vec<u32> = read.value.frames.iter().map(|f| f.number).collect();
    assert!(numbers.windows(2).all(|w| w[0] < w[1]));
    assert!(read.value.rate_hz.is_normal() && read.value.rate_hz > 0.0);
    fap::write(&read.value);
    true
}

fn reads_bap(bytes: &[u8]) -> bool {
    let Ok(read) = bap::read(bytes, bap::AbsentPolicy::Zero, &Limits::default()) else {
        return false;
    };
    let character = bap::character(&read.value);
    for channel in character.clips.iter().flat_map(|c| &c.channels) {
        assert!(channel.times_secs.windows(2).all(|w| w[0] < w[1]));
        assert!(channel.values.iter().all(|v| v.is_finite()));
    }
    if !character.clips.is_empty() && character.clips[0].duration_secs < 10.0 {
        let map = articula_build::joint_names::map(&character.skeleton, joint_map::builtin(), None);
        bap::sample(&character, &map.articulation, 0, 10.0).unwrap();
    }
    bap::write(&read.value);
    true
}

fn reads_epf(bytes: &[u8]) -> bool {
    epf::read(bytes, &Limits::default()).is_ok()
}

fn reads_fdp(bytes: &[u8]) -> bool {
    fdp::read(bytes, &Limits::default()).is_ok_and(|read| read.value.moved().len() == 68)
}

const MUTATIONS: Mutations<'_> = Mutations {
    edits: &[
        Edit::Truncate,
        Edit::InsertByte,
        Edit::RepeatTail,
        Edit::Word(&WORDS),
        Edit::Delete(12),
    ],
    most: 4,
};

fn check(good: &str, read: impl Fn(&[u8]) -> bool) {
    let good = good.as_bytes();
    for bytes in cut_off(good) {
        read(bytes);
    }
    let good_ones = MUTATIONS.read_of(good, TRIES, read);
    assert!(good_ones < TRIES, "no mutation was noticed");
}

#[test]
fn fap_files() {
    check(&texts::fap(), reads_fap);
}

#[test]
fn bap_files() {
    check(&texts::bap(), reads_bap);
}

#[test]
fn epf_files() {
    check(texts::EPF, reads_epf);
}

#[test]
fn fdp_files() {
    check(texts::FDP, reads_fdp);
}
