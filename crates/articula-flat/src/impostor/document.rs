//! The table of impostors as JSON. Format: `docs/formats/impostor.md`.

use super::plan::{ImpostorClip, ImpostorPlan};
use super::views::ViewRow;
use crate::markup::quoted;
use std::fmt::Write as _;

/// Version of the format.
const VERSION: u32 = 1;

impl ImpostorPlan {
    /// The table; `picture` is the name of the atlas beside it.
    pub fn to_json(&self, picture: &str) -> String {
        let cell = &self.cell;
        let mut out = format!(
            "{{\n\"format\":\"articula-impostor\",\"version\":{VERSION},\n\"picture\":{},\n",
            quoted(picture)
        );
        let _ = writeln!(
            out,
            "\"cell\":{{\"size_px\":[{},{}],\"metres_per_px\":{},\"corner_m\":{},\
             \"columns\":{}}},",
            cell.size_px[0],
            cell.size_px[1],
            cell.metres_per_px,
            list(cell.corner_m),
            self.columns(),
        );
        let rows: Vec<String> = self.views.rows.iter().map(row_json).collect();
        let _ = writeln!(
            out,
            "\"rows\":[\n{}\n],\"to_deg\":{},",
            rows.join(",\n"),
            self.views.to_radians.to_degrees()
        );
        let clips: Vec<String> = self.clips.iter().map(clip_json).collect();
        let _ = write!(out, "\"clips\":[\n{}\n]\n}}\n", clips.join(",\n"));
        out
    }
}

fn row_json(row: &ViewRow) -> String {
    format!(
        "{{\"from_deg\":{},\"pitch_deg\":{},\"lean\":{},\"yaws\":{}}}",
        row.from_radians.to_degrees(),
        row.pitch_radians.to_degrees(),
        row.lean,
        row.yaws
    )
}

fn clip_json(clip: &ImpostorClip) -> String {
    format!(
        "{{\"name\":{},\"duration_secs\":{},\"error_m\":{},\"first_pose\":{},\"from_secs\":{},\
         \"pose_secs\":{},\"centres_m\":{}}}",
        quoted(&clip.name),
        clip.duration_secs,
        clip.error_m,
        clip.first_pose,
        list(clip.from_secs.iter().copied()),
        list(clip.pose_secs.iter().copied()),
        list(clip.centres.iter().flat_map(|c| c.to_array())),
    )
}

/// Numbers as a JSON list; all numbers of a plan are finite.
fn list(values: impl IntoIterator<Item = f32>) -> String {
    let values: Vec<String> = values.into_iter().map(|v| v.to_string()).collect();
    format!("[{}]", values.join(","))
}
