//! What a face clip keeps and loses as a capture or as parameters, for people.

use articula::face::{CaptureReport, GENERIC_BRIDGE};

/// Maximum number of blend shapes that are listed.
const MAX_SHAPES: usize = 8;
/// Loss of a blend shape in percent from which it is listed.
const LISTED: f32 = 1.0;

/// Formats what was lost.
pub(super) fn text(report: &CaptureReport) -> String {
    let mut text = format!(
        "{} frames at {} Hz; {} blend shapes and {} parameters move; {}\n",
        report.frames,
        report.rate_hz,
        report.shapes_moving,
        report.faps_moving,
        if report.columns == GENERIC_BRIDGE {
            "generic columns".to_owned()
        } else {
            format!("columns {} of this face", report.columns)
        }
    );
    let lost = report.shapes.iter().filter(|s| s.mean_percent >= LISTED);
    let worst: Vec<String> = lost
        .take(MAX_SHAPES)
        .map(|s| {
            format!(
                "{} {:.1} % (max {:.0})",
                s.name, s.mean_percent, s.max_percent
            )
        })
        .collect();
    if !worst.is_empty() {
        text.push_str(&format!(
            "  turned back into blend shapes, most is lost of {}\n",
            worst.join(", ")
        ));
    }
    if !report.not_shown.is_empty() {
        let faps: Vec<String> = report.not_shown.iter().map(usize::to_string).collect();
        text.push_str(&format!("  no blend shape shows FAP {}\n", faps.join(", ")));
    }
    text
}
