//! Streams of faces: sizes by level of articulation, and two codecs at the same error.

use super::judge::{Sampled, errors};
use crate::tables::Run;
use crate::tables::fap_clips::{CLIPS, SMALL, read};
use anyhow::Result;

use articula::clip_streams::{afp1, afp2};
use articula::face::{expand_face, fit_face};
use articula::{CharacterFile, Figure};
use articula_build::Asset;
use articula_core::face_levels::{FaceLevel, FaceLevels};
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::FaceReadOptions;
use articula_stream::abp2::{Grouping, MotionOptions, encode};
use articula_stream::afp1::Afp1Options;
use articula_stream::afp2::Afp2Options;
use articula_stream::{CutRule, StreamLimits, cut};
use std::fmt::Write as _;

/// Quantisers of AFP-1 that are compared.
const QUANTIZERS: [u8; 3] = [4, 10, 31];

/// Tolerances of AFP-2 between which that of an error is found, and halvings.
const TOLERANCES_METRES: [f64; 2] = [1e-5, 0.02];
const HALVINGS: usize = 9;

/// Head on which errors are measured.
const HEAD_FILE: &str = "face/ict_facekit_expressions.glb";
/// That of a small run.
const SMALL_HEAD_FILE: &str = "glb/ict_head_talk_554.glb";

/// Writes the tables of faces.
pub(super) fn write(run: &Run, page: &mut String, csv: &mut String) -> Result<()> {
    let (file, clips, quantizers) = match run.small {
        true => (SMALL_HEAD_FILE, &SMALL[..], &QUANTIZERS[..1]),
        false => (HEAD_FILE, &CLIPS[..], &QUANTIZERS[..]),
    };
    let path = run.data.join(file);
    if !path.is_file() {
        return Ok(());
    }
    let head = articula::fs::open(&path)?;
    page.push_str(LEVELS);
    let (mut sums, mut sums_of_cuts) = ([0.0; 4], [0.0; 4]);
    let mut codecs = String::new();
    for name in clips {
        let clip = read(run, name)?;
        let truth = shown(&head, name, &clip)?;
        let mut full = 0;
        write!(page, "| {name} | {} |", clip.frames.len())?;
        for (i, level) in FaceLevel::ALL.into_iter().enumerate() {
            let levels = FaceLevels::all(level);
            let options = Afp1Options {
                levels,
                ..Afp1Options::default()
            };
            let bytes = afp1::write(&clip, &options)?;
            let reduced = expand_face(&clip, &levels.roles());
            let mm = apart(&truth, &shown(&head, name, &reduced)?);
            full = if i == 0 { bytes.len() } else { full };
            let percent = 100.0 * bytes.len() as f64 / full as f64;
            sums[i] += percent / clips.len() as f64;
            match i {
                0 => write!(page, " {} |", bytes.len())?,
                _ => write!(page, " {percent:.1} % | {mm:.2} |")?,
            }
            writeln!(
                csv,
                "face,{name},afp1 {},{},{mm:.4}",
                level.name(),
                bytes.len()
            )?;
        }
        page.push('\n');
        let cuts = cuts_by_level(&clip)?;
        for (i, level) in FaceLevel::ALL.into_iter().enumerate() {
            sums_of_cuts[i] += 100.0 * cuts[i] as f64 / cuts[0] as f64 / clips.len() as f64;
            writeln!(csv, "face,{name},afp2 {},{},", level.name(), cuts[i])?;
        }
        for quantizer in quantizers {
            compare(&mut codecs, csv, (&head, &truth), (name, &clip), *quantizer)?;
        }
    }
    let [_, medium, low, very_low] = sums;
    writeln!(
        page,
        "| mean | | | {medium:.1} % | | {low:.1} % | | {very_low:.1} % | |"
    )?;
    let [_, medium, low, very_low] = sums_of_cuts;
    writeln!(
        page,
        "| mean of AFP-2, cut | | | {medium:.1} % | | {low:.1} % | | {very_low:.1} % | |"
    )?;
    page.push_str("| the thesis | | | 77.4 % | | 62.6 % | | 54.4 % | |\n");
    page.push_str(CODECS);
    page.push_str(&codecs);
    Ok(())
}

/// Bytes of a clip as AFP-2 with its defaults, cut to each level, the finest first.
fn cuts_by_level(clip: &FapClip) -> Result<[usize; 4]> {
    let coded = afp2::write(clip, &Afp2Options::default())?;
    let mut bytes = [0; 4];
    for (bytes, loa) in bytes.iter_mut().rev().zip(0..) {
        let rule = CutRule::default().at_most("face_loa", loa);
        *bytes = cut(&coded.bytes, &coded.unit, |unit| rule.keeps(unit))?
            .bytes
            .len();
    }
    Ok(bytes)
}

/// AFP-1 with a quantiser, and at its error AFP-2, and ABP-2 of the same motion of the morph targets.
fn compare(
    rows: &mut String,
    csv: &mut String,
    (head, truth): (&CharacterFile, &Asset),
    (name, clip): (&str, &FapClip),
    quantizer: u8,
) -> Result<()> {
    let options = Afp1Options {
        quantizer,
        ..Afp1Options::default()
    };
    let limits = StreamLimits::default();
    let on_head = |read: &FapClip| -> Result<f64> { Ok(apart(truth, &shown(head, name, read)?)) };
    let bytes = afp1::write(clip, &options)?;
    let mm = on_head(&afp1::read(&bytes, &FaceReadOptions::default(), &limits)?)?;
    let afp2 = |tolerance_metres: f64, tiers: usize| -> Result<(usize, f64)> {
        let options = Afp2Options {
            tolerance_metres,
            tiers,
            ..Afp2Options::default()
        };
        let coded = afp2::write(clip, &options)?;
        let read = afp2::read(&coded.bytes, &FaceReadOptions::default(), &limits)?;
        Ok((coded.bytes.len(), on_head(&read)?))
    };
    let [mut low, mut high] = TOLERANCES_METRES.map(f64::ln);
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if afp2(middle.exp(), 1)?.1 <= mm {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (single, of_single) = afp2(low.exp(), 1)?;
    let (tiers, _) = afp2(low.exp(), Afp2Options::default().tiers)?;
    let options = MotionOptions {
        tolerance_metres: (1e-3 * mm).clamp(1e-6, 0.06),
        tiers: 1,
        grouping: Grouping::Loa,
        ..MotionOptions::default()
    };
    let coded = encode(&truth.rig, &truth.mesh, &truth.clips[0], &options)?;
    let found = 1e3 * coded.errors[0].max_metres;
    let ratio = |part: usize| part as f64 / bytes.len() as f64;
    writeln!(
        rows,
        "| {name} | {quantizer} | {} | {mm:.3} | {single} ({:.2}) | {of_single:.3} | {tiers} ({:.2}) | {} ({:.2}) | {found:.3} |",
        bytes.len(),
        ratio(single),
        ratio(tiers),
        coded.bytes.len(),
        ratio(coded.bytes.len()),
    )?;
    for (form, bytes, mm) in [
        ("afp1", bytes.len(), mm),
        ("afp2", single, of_single),
        ("abp2 of morph weights", coded.bytes.len(), found),
    ] {
        writeln!(
            csv,
            "face,{name},{form} at quantiser {quantizer},{bytes},{mm:.4}"
        )?;
    }
    Ok(())
}

/// What a head shows of a clip.
fn shown(head: &CharacterFile, name: &str, clip: &FapClip) -> Result<Asset> {
    let mut opened = head.clone();
    let fitted = fit_face(clip, name, head)?.fitted;
    opened.put_clips(vec![fitted], false);
    Ok(Figure::new(opened)?.asset)
}

/// Greatest distance of a vertex in millimetres, at frames.
fn apart(a: &Asset, b: &Asset) -> f64 {
    let mut sampled = Sampled::new(b, &b.clips[0]);
    errors(a, &a.clips[0], &mut sampled).frames_mm
}

const LEVELS: &str = "
## Faces by level of articulation

FAP clips as AFP-1 ([form](../formats/afp1.md)): bytes at level high, and at the other levels in percent of these, with the
greatest distance of a vertex of the ICT head from its place at level high, over all frames. Below, the mean of AFP-2
([form](../formats/afp2.md)) with three tiers from 0.1 mm, written at level high and cut. The thesis (6.1) gives the mean
sizes of its own clips, in a codec in which a parameter that is not sent saves its share.

| clip | frames | high, bytes | medium | mm | low | mm | very low | mm |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const CODECS: &str = "
## Face streams at equal error

The same motion of the ICT head three times: the parameters as AFP-1 with a quantiser; the parameters as
[AFP-2](../formats/afp2.md), one tier and three, with the tolerance (found by halving) that gives this head no greater
error; and the weights of the head's 52 morph targets as ABP-2, one tier, with that error as tolerance. In brackets the
part of AFP-1's bytes. A stream of parameters fits any head, one of morph weights its own.

| clip | quantiser | AFP-1, bytes | mm | AFP-2, one tier | mm | three tiers | ABP-2 of weights | mm |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";
