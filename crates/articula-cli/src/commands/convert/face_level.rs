//! `convert --face-level`: FAP clips at levels of articulation.

use super::ConvertArgs;
use crate::{fault, open};
use articula::DataFormat;
use articula::core::face_levels::FaceLevels;
use articula::face::FaceLevelReport;
use articula::formats::mpeg4::fap::FapClip;

/// Parses a level, or a level and those of regions.
pub(super) fn levels(text: &str) -> Result<FaceLevels, String> {
    text.parse().map_err(|wrong| format!("{wrong}"))
}

/// Refuses the flag where no FAP file is named.
pub(super) fn check(args: &ConvertArgs) -> anyhow::Result<()> {
    if args.face_level.is_none() {
        return Ok(());
    }
    for path in args.sources() {
        if path.is_dir() || open::data_format(path)?.is_some_and(DataFormat::has_faps) {
            return Ok(());
        }
    }
    let what = "--face-level applies to FAP files; --loa reduces motions of bodies";
    Err(fault::usage(what))
}

/// A clip as `of_level` leaves it at the level that was asked for, with the report; the clip itself
/// if none was.
pub(super) fn applied(
    clip: FapClip,
    args: &ConvertArgs,
    of_level: fn(&FapClip, &articula::core::face_levels::FapRoles) -> FapClip,
) -> (FapClip, Option<FaceLevelReport>) {
    match &args.face_level {
        None => (clip, None),
        Some(levels) => {
            let report = FaceLevelReport::new(&clip, levels);
            (of_level(&clip, &levels.roles()), Some(report))
        }
    }
}

/// The report for people, on one line.
pub(super) fn text(report: &FaceLevelReport) -> String {
    format!(
        "face level {}: {} of 68 FAPs, {} of the {} that move\n",
        report.level, report.parameters, report.moving_kept, report.moving
    )
}
