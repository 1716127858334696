//! The FAP files of the data.

use super::Run;
use anyhow::{Context, Result, bail};
use articula::{Data, DataFormat, OpenOptions, open_data};
use articula_formats::mpeg4::fap::FapClip;

/// Names of the files.
pub(super) const CLIPS: [&str; 6] = [
    "xface_joy",
    "xface_anger",
    "xface_beg",
    "xface_disgust",
    "speech_synthetic",
    "expressions_synthetic",
];

/// The file of a small run, which is among those of the repository.
pub(super) const SMALL: [&str; 1] = ["speech_synthetic"];

/// Reads one of them.
pub(super) fn read(run: &Run, name: &str) -> Result<FapClip> {
    let path = run.data.join("fap").join(name).with_extension("fap");
    let bytes = std::fs::read(&path).with_context(|| path.display().to_string())?;
    match open_data(&bytes, name, DataFormat::Fap, &OpenOptions::default())?.data {
        Data::Fap(clip) => Ok(clip),
        _ => bail!("{}: no FAP clip", path.display()),
    }
}
