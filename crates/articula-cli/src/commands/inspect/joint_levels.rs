//! The joint levels of a file as text.

use crate::table::{Table, counted};
use articula::inspect::JointLevelsInspection;

/// The table of levels and what its numbers are.
pub(super) fn text(found: &JointLevelsInspection) -> String {
    let mut table = Table::new(&["level", "joints", "matrices", "influences", "error mm", ""]);
    for level in &found.levels {
        table.row([
            level.level.to_string(),
            level.joints.to_string(),
            level.matrices.to_string(),
            level.influences.to_string(),
            format!("{:.2}", 1e3 * level.error_m),
            (if level.far { "far" } else { "" }).to_owned(),
        ]);
    }
    let clips = found.levels.first().map_or(0, |l| l.clips.len());
    let on = if found.on_bones {
        "points on the bones"
    } else {
        "the skin"
    };
    let far = if found.levels.iter().any(|l| l.far) {
        "; far levels keep joints without their ancestors, on a rig of their own"
    } else {
        ""
    };
    format!(
        "\njoint levels\n{}errors of {on}: the maximum over {}{far}\n",
        table.text(),
        counted(clips, "clip", "clips"),
    )
}
