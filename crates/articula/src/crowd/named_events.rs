//! Events of clips, by the names of the clips.

use crate::error::{Context, Error, Result};
use crate::open::choose;
use articula_core::Clip;
use articula_core::crowd::ClipEvent;

/// Returns the events of each clip, for a player of one figure
/// ([`FigureModel::with_events`](articula_core::playback::FigureModel::with_events)).
///
/// # Errors
/// An [`Error`] that names the clip: none has the name, or a time is outside of it.
pub fn events_by_clip(
    events: &[(String, ClipEvent)],
    clips: &[Clip],
) -> Result<Vec<Vec<ClipEvent>>> {
    let mut made = vec![Vec::new(); clips.len()];
    for (name, event) in events {
        let clip = choose("clip", name, clips.iter().map(|clip| clip.name.as_str()))?;
        let secs = clips[clip].duration_secs();
        if !(0.0..=secs).contains(&event.secs) {
            let what = format!(
                "an event at {} s is outside of the clip (0 to {secs} s)",
                event.secs
            );
            return Err(Error::argument(what)).with_context(|| name.clone());
        }
        made[clip].push(*event);
    }
    Ok(made)
}
