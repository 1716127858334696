//! `convert IN OUT.abp`, `OUT.afp` and `OUT.mp4`: profile and options of the stream, and the report of its tiers.

use crate::arguments::{settings, skin_millimetres, word};
use crate::fault;
use crate::table::Table;
use articula::Format;
use articula::clip_streams::abp2::TierReport;
use articula::convert::{AbpProfile, AfpProfile};
use articula::stream::abp2::{Grouping, MotionOptions, UnitOrder};
use articula::stream::afp2::Afp2Options;
use clap::Args;

/// Profile and options of a stream.
#[derive(Debug, Clone, Args)]
pub(super) struct StreamArgs {
    /// How .abp, .afp and .mp4 files are coded: tolerance-mm=MM, the greatest error in millimetres of
    /// skin, or of feature points of an average face [default: 0.1]; tiers=N, of which leaving out the
    /// finest triples the error [default: 5, of a face 3]; group-by=loa, region or joint, what joints
    /// have in common that are cut together; order=tier or value, value for receivers that get a part;
    /// skeleton=yes, so that the file opens without --onto, as a character without meshes;
    /// profile=abp1 or afp1, a stream of bones, or of parameters that can be cut one by one
    #[arg(long, value_name = "KEY=VALUE,…", value_parser = stream_settings)]
    stream: Option<StreamSettings>,
}

/// Profile and options of a stream, as far as they are given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct StreamSettings {
    first: Option<FirstProfile>,
    tolerance_mm: Option<f64>,
    tiers: Option<usize>,
    grouping: Option<Grouping>,
    order: Option<UnitOrder>,
    skeleton: Option<bool>,
}

/// The first profile of streams, in place of the second.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FirstProfile {
    Abp1,
    Afp1,
}

fn stream_settings(text: &str) -> Result<StreamSettings, String> {
    const GROUPS: &[(&str, Grouping)] = &[
        ("loa", Grouping::Loa),
        ("region", Grouping::LoaRegion),
        ("joint", Grouping::Joint),
    ];
    const ORDERS: &[(&str, UnitOrder)] = &[("tier", UnitOrder::Tier), ("value", UnitOrder::Value)];
    const PROFILES: &[(&str, FirstProfile)] =
        &[("abp1", FirstProfile::Abp1), ("afp1", FirstProfile::Afp1)];
    let tiers = |text: &str| {
        let count = text.parse::<usize>().ok().filter(|n| (1..=8).contains(n));
        count.ok_or_else(|| "expected a whole number from 1 to 8".to_owned())
    };
    let read = settings(text, |to: &mut StreamSettings, key, value| {
        match key {
            "tolerance-mm" => to.tolerance_mm = Some(skin_millimetres(value)?),
            "tiers" => to.tiers = Some(tiers(value)?),
            "group-by" => to.grouping = Some(word(value, GROUPS)?),
            "order" => to.order = Some(word(value, ORDERS)?),
            "skeleton" => to.skeleton = Some(word(value, &[("yes", true), ("no", false)])?),
            "profile" => to.first = Some(word(value, PROFILES)?),
            _ => {
                return Ok(Some(
                    "tolerance-mm, tiers, group-by, order, skeleton, profile",
                ));
            }
        }
        Ok(None)
    })?;
    match read.first {
        Some(_) if text.contains(',') => Err("profile=abp1 and profile=afp1 stand alone".into()),
        _ => Ok(read),
    }
}

impl StreamArgs {
    /// Whether the flag is given.
    pub(super) fn asks(&self) -> bool {
        self.stream.is_some()
    }

    /// Refuses settings that have no effect on a file of this format.
    pub(super) fn check(&self, out: Format) -> anyhow::Result<()> {
        let Some(given) = self.stream else {
            return Ok(());
        };
        let (setting, expected) = match given.first {
            Some(FirstProfile::Afp1) => (" profile=afp1", "an .afp"),
            _ if matches!(out, Format::Abp | Format::Mp4) => return Ok(()),
            _ => ("", "an .abp, .afp or .mp4"),
        };
        let what = format!(
            "--stream{setting} requires {expected} output, not .{}",
            out.name()
        );
        Err(fault::usage(what))
    }

    /// The setting that has no effect on the output of a face clip, if one is given; `is_afp` if that
    /// is a face stream, as such or in an MP4 file.
    pub(super) fn idle_for_a_face(&self, is_afp: bool) -> Option<&'static str> {
        let given = self.stream?;
        if given.first == Some(FirstProfile::Abp1) {
            return Some("--stream profile=abp1");
        }
        let grouped = given.grouping.map(|_| "--stream group-by");
        let skeleton = given.skeleton.map(|_| "--stream skeleton");
        grouped
            .or(skeleton)
            .or_else(|| (!is_afp).then_some("--stream"))
    }

    /// The options of the library, if any is chosen.
    pub(super) fn profile(&self) -> Option<AbpProfile> {
        let given = self.stream?;
        let plain = MotionOptions::default();
        Some(match given.first {
            Some(FirstProfile::Afp1) => return None,
            Some(FirstProfile::Abp1) => AbpProfile::Abp1(Default::default()),
            None => AbpProfile::Abp2(MotionOptions {
                tolerance_metres: given.tolerance_metres().unwrap_or(plain.tolerance_metres),
                tiers: given.tiers.unwrap_or(plain.tiers),
                grouping: given.grouping.unwrap_or(plain.grouping),
                order: given.order.unwrap_or(plain.order),
                skeleton: given.skeleton.unwrap_or(plain.skeleton),
                ..plain
            }),
        })
    }

    /// Profile and options of a face stream.
    pub(super) fn face_profile(&self) -> AfpProfile {
        let given = self.stream.unwrap_or_default();
        if given.first.is_some() {
            return AfpProfile::Afp1(Default::default());
        }
        let plain = Afp2Options::default();
        AfpProfile::Afp2(Afp2Options {
            tolerance_metres: given.tolerance_metres().unwrap_or(plain.tolerance_metres),
            tiers: given.tiers.unwrap_or(plain.tiers),
            order: given.order.unwrap_or(plain.order),
            ..plain
        })
    }
}

impl StreamSettings {
    fn tolerance_metres(&self) -> Option<f64> {
        self.tolerance_mm.map(|mm| 1e-3 * mm)
    }
}

/// Table of what a cut to each tier leaves.
pub(super) fn text(tiers: &[TierReport]) -> String {
    if tiers.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&[
        "tier",
        "bytes",
        "tolerance mm",
        "max error mm",
        "mean error mm",
    ]);
    for tier in tiers {
        table.row([
            tier.tier.to_string(),
            tier.bytes.to_string(),
            format!("{:.1}", tier.tolerance_mm),
            format!("{:.3}", tier.error_mm_max),
            format!("{:.4}", tier.error_mm_mean),
        ]);
    }
    table.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_profile_has_no_settings() {
        let read = stream_settings("tiers=3,order=value").unwrap();
        assert_eq!((read.tiers, read.order), (Some(3), Some(UnitOrder::Value)));
        for bad in [
            "tiers=0",
            "tiers=9",
            "order=size",
            "profile=abp1,tiers=2",
            "tolerance-mm=0",
        ] {
            assert!(stream_settings(bad).is_err(), "{bad}");
        }
    }
}
