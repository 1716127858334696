//! Streams of faces: sizes by level of articulation, and two codecs at the same error.

use super::judge::{Sampled, errors};
use crate::tables::Run;
use crate::tables::fap_clips::{CLIPS, read};
use anyhow::Result;
use articula::convert::write_faps;
use articula::face::{expand_face, fit_face};
use articula::streams::afp1;
use articula::{CharacterFile, DataFormat, Figure};
use articula_build::Asset;
use articula_core::face_levels::{FaceLevel, FaceLevels};
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::StreamLimits;
use articula_stream::abp2::{Grouping, MotionOptions, encode};
use articula_stream::afp1::{Afp1Options, Afp1ReadOptions};
use std::fmt::Write as _;

/// Quantisers of AFP-1 that are compared.
const QUANTIZERS: [u8; 3] = [4, 10, 31];

/// Head on which errors are measured.
const HEAD_FILE: &str = "face/ict_facekit_expressions.glb";

/// Writes the tables of faces.
pub(super) fn write(run: &Run, page: &mut String, csv: &mut String) -> Result<()> {
    let path = run.data.join(HEAD_FILE);
    if !path.is_file() {
        return Ok(());
    }
    let head = articula::fs::open(&path)?;
    let clips = &CLIPS[..if run.small { 1 } else { CLIPS.len() }];
    page.push_str(LEVELS);
    let mut sums = [0.0; 4];
    let mut codecs = String::new();
    for name in clips {
        let clip = read(run, name)?;
        let truth = shown(&head, name, &clip)?;
        let mut full = 0;
        write!(page, "| {name} | {} |", clip.frames.len())?;
        for (i, level) in FaceLevel::ALL.into_iter().enumerate() {
            let levels = FaceLevels::all(level);
            let bytes = write_faps(&clip, DataFormat::Afp, Some(&levels))?.bytes;
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
        for quantizer in QUANTIZERS {
            compare(&mut codecs, (&head, &truth), (name, &clip), quantizer)?;
        }
    }
    let [_, medium, low, very_low] = sums;
    writeln!(
        page,
        "| mean | | | {medium:.1} % | | {low:.1} % | | {very_low:.1} % | |"
    )?;
    page.push_str("| the thesis | | | 77.4 % | | 62.6 % | | 54.4 % | |\n");
    page.push_str(CODECS);
    page.push_str(&codecs);
    Ok(())
}

/// AFP-1 with a quantiser, and ABP-2 of the same motion of the morph targets at its error.
fn compare(
    rows: &mut String,
    (head, truth): (&CharacterFile, &Asset),
    (name, clip): (&str, &FapClip),
    quantizer: u8,
) -> Result<()> {
    let options = Afp1Options {
        quantizer,
        ..Afp1Options::default()
    };
    let bytes = afp1::write(clip, &options)?;
    let read = afp1::read(
        &bytes,
        &Afp1ReadOptions::default(),
        &StreamLimits::default(),
    )?;
    let mm = apart(truth, &shown(head, name, &read)?);
    let options = MotionOptions {
        tolerance_metres: (1e-3 * mm).clamp(1e-6, 0.06),
        tiers: 1,
        grouping: Grouping::Loa,
        ..MotionOptions::default()
    };
    let coded = encode(&truth.rig, &truth.mesh, &truth.clips[0], &options)?;
    let found = 1e3 * coded.errors[0].max_metres;
    writeln!(
        rows,
        "| {name} | {quantizer} | {} | {mm:.3} | {} | {found:.3} | {:.2} |",
        bytes.len(),
        coded.bytes.len(),
        coded.bytes.len() as f64 / bytes.len() as f64
    )?;
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
greatest distance of a vertex of the ICT head from its place at level high, over all frames. The thesis (6.1) gives the mean
sizes of its own clips, in a codec in which a parameter that is not sent saves its share.

| clip | frames | high, bytes | medium | mm | low | mm | very low | mm |
| --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const CODECS: &str = "
## AFP-1 and ABP-2 for faces

The same motion of the ICT head twice: the parameters as AFP-1 with a quantiser, and the weights of the head's 52 morph
targets as ABP-2, one tier, with the error that AFP-1 has on this head as tolerance. A stream of parameters fits any head,
one of morph weights its own.

| clip | quantiser | AFP-1, bytes | mm | ABP-2, bytes | mm | ABP-2 / AFP-1 |
| --- | --- | --- | --- | --- | --- | --- |
";
