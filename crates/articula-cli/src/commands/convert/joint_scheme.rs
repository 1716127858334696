//! `convert --joint-scheme`: the joints of H-Anim or of the thesis, and the report of the change.

use crate::fault::clean;
use articula::build::JointScheme;
use articula::convert::JointSchemeReport;
use clap::ValueEnum;

/// Set of joints that a body has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum SchemeName {
    /// The standard's: with subtalars, without thumb0
    Hanim,
    /// Those that the regions of the thesis count: with thumb0, without subtalars
    Thesis,
}

impl SchemeName {
    pub(super) fn of_library(self) -> JointScheme {
        match self {
            Self::Hanim => JointScheme::Hanim,
            Self::Thesis => JointScheme::Thesis,
        }
    }
}

/// Formats the report for people.
pub(super) fn text(report: &JointSchemeReport) -> String {
    let mut text = format!("joint scheme {}: {} joints", report.scheme, report.joints);
    if report.merged.is_empty() && report.inserted.is_empty() {
        text.push_str(", none to merge or to insert\n");
        return text;
    }
    text.push_str(&format!(
        "; kept joints within {:.3} mm, skin within {:.3} mm of their places\n",
        1e3 * report.joints_m,
        1e3 * report.skin_m
    ));
    for merged in &report.merged {
        let [joint, into] = [&merged.joint, &merged.into].map(|name| clean(name));
        text.push_str(&format!("  {joint} merged into {into}\n"));
    }
    for inserted in &report.inserted {
        let names = [&inserted.joint, &inserted.parent, &inserted.child];
        let [joint, parent, child] = names.map(|name| clean(name));
        text.push_str(&format!(
            "  {joint} inserted between {parent} and {child}\n"
        ));
    }
    text
}
