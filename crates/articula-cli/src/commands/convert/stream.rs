//! `convert IN OUT.abp`, `OUT.afp` and `OUT.mp4`: profile and options of the stream, and the report of its tiers.

use crate::arguments::skin_millimetres;
use crate::fault;
use crate::table::Table;
use articula::Format;
use articula::clip_streams::abp2::TierReport;
use articula::convert::{AbpProfile, AfpProfile};
use articula::stream::abp2::{Grouping, MotionOptions, UnitOrder};
use articula::stream::afp2::Afp2Options;
use clap::{Args, ValueEnum, value_parser};

/// Profile and options of a stream.
#[derive(Debug, Clone, Args)]
pub(super) struct StreamArgs {
    /// Write profile ABP-1, a stream of bones, in place of ABP-2 (.abp and .mp4 only)
    #[arg(long, conflicts_with_all = ["tolerance_mm", "tiers", "group_by", "by_value", "with_skeleton"])]
    pub(super) abp1: bool,
    /// Write profile AFP-1, in which parameters can be cut one by one, in place of AFP-2 (.afp
    /// and .mp4 only)
    #[arg(long, conflicts_with_all = ["abp1", "tolerance_mm", "tiers", "group_by", "by_value"])]
    afp1: bool,
    /// Greatest error of a motion stream, in millimetres of skin, or of a face stream, in
    /// millimetres of feature points of an average face (.abp, .afp and .mp4 only) [default: 0.1]
    #[arg(long, value_name = "MM", value_parser = skin_millimetres)]
    tolerance_mm: Option<f64>,
    /// Tiers of a stream; leaving out the finest triples the error (.abp, .afp and .mp4 only)
    /// [default: 5, of a face 3]
    #[arg(long, value_name = "N", value_parser = value_parser!(u8).range(1..=8))]
    tiers: Option<u8>,
    /// What the joints have in common that are cut from a motion stream together (.abp and .mp4
    /// only)
    /// [default: loa]
    #[arg(long, value_enum)]
    group_by: Option<GroupBy>,
    /// Order the units of a stream by the error that they take away for their bytes, for
    /// receivers that get a part (.abp, .afp and .mp4 only)
    #[arg(long)]
    by_value: bool,
    /// Carry the skeleton in a motion stream, so that it opens without --onto, as a character without
    /// meshes (.abp and .mp4 only)
    #[arg(long)]
    with_skeleton: bool,
}

/// What joints of a group have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GroupBy {
    /// Level of articulation
    Loa,
    /// Level of articulation and body region
    Region,
    /// Every joint is a group
    Joint,
}

impl StreamArgs {
    /// Whether a flag is given.
    pub(super) fn asks(&self) -> bool {
        self.afp1 || self.of_bodies().is_some() || self.of_both().is_some()
    }

    /// Refuses flags that have no effect on a file of this format.
    pub(super) fn check(&self, out: Format) -> anyhow::Result<()> {
        if self.afp1 {
            let what = format!("--afp1 requires an .afp output, not .{}", out.name());
            return Err(fault::usage(what));
        }
        let flag = self.of_bodies().or_else(|| self.of_both());
        match flag {
            Some(flag) if !matches!(out, Format::Abp | Format::Mp4) => {
                let what = format!(
                    "{flag} requires an .abp or .mp4 output, not .{}",
                    out.name()
                );
                Err(fault::usage(what))
            }
            _ => Ok(()),
        }
    }

    /// The flag that has no effect on the output of a face clip, if one is given; `is_afp` if that is
    /// a face stream, as such or in an MP4 file.
    pub(super) fn idle_for_a_face(&self, is_afp: bool) -> Option<&'static str> {
        let of_faces = self.of_both().or(self.afp1.then_some("--afp1"));
        self.of_bodies().or(of_faces.filter(|_| !is_afp))
    }

    /// The options of the library, if any is chosen.
    pub(super) fn profile(&self) -> Option<AbpProfile> {
        if self.abp1 {
            return Some(AbpProfile::Abp1(Default::default()));
        }
        self.of_bodies().or_else(|| self.of_both())?;
        let plain = MotionOptions::default();
        Some(AbpProfile::Abp2(MotionOptions {
            tolerance_metres: self
                .tolerance_mm
                .map_or(plain.tolerance_metres, |mm| 1e-3 * mm),
            tiers: self.tiers.map_or(plain.tiers, usize::from),
            grouping: match self.group_by {
                None | Some(GroupBy::Loa) => Grouping::Loa,
                Some(GroupBy::Region) => Grouping::LoaRegion,
                Some(GroupBy::Joint) => Grouping::Joint,
            },
            order: self.order(),
            skeleton: self.with_skeleton,
            ..plain
        }))
    }

    /// Profile and options of a face stream.
    pub(super) fn face_profile(&self) -> AfpProfile {
        if self.afp1 {
            return AfpProfile::Afp1(Default::default());
        }
        let plain = Afp2Options::default();
        AfpProfile::Afp2(Afp2Options {
            tolerance_metres: self
                .tolerance_mm
                .map_or(plain.tolerance_metres, |mm| 1e-3 * mm),
            tiers: self.tiers.map_or(plain.tiers, usize::from),
            order: self.order(),
            ..plain
        })
    }

    fn order(&self) -> UnitOrder {
        if self.by_value {
            UnitOrder::Value
        } else {
            UnitOrder::Tier
        }
    }

    /// The first flag about streams of bodies that is given.
    fn of_bodies(&self) -> Option<&'static str> {
        let group_by = self.group_by.is_some().then_some("--group-by");
        let with_skeleton = self.with_skeleton.then_some("--with-skeleton");
        self.abp1.then_some("--abp1").or(group_by).or(with_skeleton)
    }

    /// The first flag about streams of bodies or faces that is given.
    fn of_both(&self) -> Option<&'static str> {
        let flags = [
            (self.tolerance_mm.is_some(), "--tolerance-mm"),
            (self.tiers.is_some(), "--tiers"),
            (self.by_value, "--by-value"),
        ];
        flags
            .iter()
            .find(|(given, _)| *given)
            .map(|(_, flag)| *flag)
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
