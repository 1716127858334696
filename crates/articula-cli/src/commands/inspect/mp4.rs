//! Tracks of an MP4 file.

use crate::fault::clean;
use crate::table::Table;
use articula::inspect::TrackInspection;

/// Formats the table of tracks; nothing if there are none.
pub(super) fn text(tracks: &[TrackInspection]) -> String {
    if tracks.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&[
        "track",
        "stream",
        "samples",
        "seconds",
        "bytes",
        "head bytes",
    ]);
    for track in tracks {
        table.row([
            track.track.to_string(),
            track
                .profile
                .map_or_else(|| clean(&track.form), str::to_owned),
            track.samples.to_string(),
            format!("{:.3}", track.duration_secs),
            track.bytes.to_string(),
            track.bytes_head.to_string(),
        ]);
    }
    format!("\ntracks\n{}", table.text())
}
