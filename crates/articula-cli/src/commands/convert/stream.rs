//! `convert IN OUT.abp`: profile and options of the stream, and the report of its tiers.

use crate::arguments::skin_millimetres;
use crate::fault;
use crate::table::Table;
use articula::Format;
use articula::convert::AbpProfile;
use articula::streams::abp2::TierReport;
use articula_stream::abp2::{Grouping, MotionOptions, UnitOrder};
use clap::{Args, ValueEnum, value_parser};

/// Profile and options of a stream.
#[derive(Debug, Clone, Args)]
pub(super) struct StreamArgs {
    /// Write profile ABP-1, a stream of bones, in place of ABP-2 (.abp only)
    #[arg(long, conflicts_with_all = ["tolerance_mm", "tiers", "group_by", "by_value"])]
    pub(super) abp1: bool,
    /// Greatest error of a motion stream, in millimetres of skin (.abp only) [default: 0.1]
    #[arg(long, value_name = "MM", value_parser = skin_millimetres)]
    tolerance_mm: Option<f64>,
    /// Tiers of a motion stream; leaving out the finest triples the error (.abp only)
    /// [default: 5]
    #[arg(long, value_name = "N", value_parser = value_parser!(u8).range(1..=8))]
    tiers: Option<u8>,
    /// What the joints have in common that are cut from a motion stream together (.abp only)
    /// [default: loa]
    #[arg(long, value_enum)]
    group_by: Option<GroupBy>,
    /// Order the units of a motion stream by the error that they take away for their bytes, for
    /// receivers that get a part (.abp only)
    #[arg(long)]
    by_value: bool,
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
    /// Whether any of the flags is given.
    pub(super) fn asks(&self) -> bool {
        self.flag().is_some()
    }

    /// Refuses flags that have no effect on a file of this format.
    pub(super) fn check(&self, out: Format) -> anyhow::Result<()> {
        match self.flag() {
            Some(flag) if out != Format::Abp => {
                let what = format!("{flag} requires an .abp output, not .{}", out.name());
                Err(fault::usage(what))
            }
            _ => Ok(()),
        }
    }

    /// The options of the library, if any is chosen.
    pub(super) fn profile(&self) -> Option<AbpProfile> {
        if self.abp1 {
            return Some(AbpProfile::Abp1(Default::default()));
        }
        if !self.asks() {
            return None;
        }
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
            order: if self.by_value {
                UnitOrder::Value
            } else {
                UnitOrder::Tier
            },
            ..plain
        }))
    }

    /// The first flag that is given.
    fn flag(&self) -> Option<&'static str> {
        let flags = [
            (self.abp1, "--abp1"),
            (self.tolerance_mm.is_some(), "--tolerance-mm"),
            (self.tiers.is_some(), "--tiers"),
            (self.group_by.is_some(), "--group-by"),
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
