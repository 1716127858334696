//! `convert --trim --loop --root-motion --rate --reduce-keys`: the flags that clean clips, and the
//! report of what they did.

use crate::{arguments, fault};
use anyhow::Context;
use articula::Format;
use articula::convert::{
    ClipEdited, ClipEdits, ClipPart, CloseOptions, KeysReduced, Looped, ReduceOptions,
    RootMotionEdited, RootMotionMode, RootMotionOptions, Timelines,
};
use clap::Args;

/// Cleaning of clips.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct HygieneArgs {
    /// Keep an interval of each clip, in seconds: 1.5..3, ..3 or 2..
    #[arg(long, value_name = "FROM..TO", value_parser = part)]
    trim: Option<ClipPart>,
    /// Keep the part of each clip that loops best, and close its seam, blended over SECS at either end
    /// [default: half of the loop]
    #[arg(long = "loop", value_name = "SECS", num_args = 0..=1, require_equals = true,
          value_parser = arguments::positive)]
    looped: Option<Option<f32>>,
    /// Handling of the root motion (horizontal motion and heading of the hips): keep, which reports
    /// it; extract, to a joint above them; or in-place, which removes it; with :SECS, sway shorter than
    /// that is left to the hips
    #[arg(long, value_name = "MODE[:SECS]", value_parser = root_motion)]
    root_motion: Option<RootMotionOptions>,
    /// Resample every channel at this rate, in hertz
    #[arg(long, value_name = "HZ", value_parser = arguments::positive)]
    rate: Option<f32>,
    /// Drop keys while no joint and no skin moves by more than this distance: 0.001, 1mm or 0.1cm; with
    /// ,drop-rest also channels that stay at the rest pose
    #[arg(long, value_name = "METRES[,drop-rest]", value_parser = reduction)]
    reduce_keys: Option<ReduceOptions>,
}

impl HygieneArgs {
    /// The edits that the flags ask for.
    pub(super) fn edits(&self) -> ClipEdits {
        ClipEdits {
            trim: self.trim,
            close_loop: self.looped.map(|window_secs| CloseOptions { window_secs }),
            root_motion: self.root_motion,
            rate_hz: self.rate,
            reduce_keys: self.reduce_keys,
        }
    }

    /// Refuses edits that the output format cannot represent.
    pub(super) fn check(&self, out: Format) -> anyhow::Result<()> {
        let flag = match self.reduce_keys {
            Some(_) if out.holds_one_clip() => "--reduce-keys",
            _ => "--root-motion extract",
        };
        self.edits().check(out).context(flag)
    }

    /// Whether any edit is asked for.
    pub(super) fn asks(&self) -> bool {
        self.edits().asks()
    }
}

fn named(name: &str) -> String {
    if name.is_empty() {
        "without a name".into()
    } else {
        format!("\"{}\"", fault::clean(name))
    }
}

/// Formats the edits of a clip for people: one line for the clip and one for each edit.
pub(super) fn text(edited: &ClipEdited) -> String {
    let mut text = format!("clip \"{}\"\n", fault::clean(&edited.clip));
    if let Some(t) = &edited.trim {
        text.push_str(&format!(
            "  trimmed to {:.3} .. {:.3} s: {:.3} s long\n",
            t.from_secs, t.to_secs, t.duration_secs
        ));
    }
    if let Some(looped) = &edited.looped {
        text.push_str(&of_loop(looped));
    }
    if let Some(root) = &edited.root_motion {
        text.push_str(&of_root_motion(root));
    }
    if let Some(r) = &edited.rate {
        text.push_str(&format!(
            "  keyed at {} Hz: {} -> {} keys\n",
            r.rate_hz, r.keys_before, r.keys_after
        ));
    }
    if let Some(keys) = &edited.reduce_keys {
        text.push_str(&of_keys(keys));
    }
    text
}

fn of_loop(looped: &Looped) -> String {
    let Some(p) = &looped.part else {
        return "  no loop: the clip is too short or moves too little\n".into();
    };
    let part = format!(
        "{:.3} .. {:.3} s, {:.3} s long, seam {:.1} mm, score {:.3}",
        p.start_secs,
        p.end_secs,
        p.period_secs,
        1e3 * p.seam_m,
        p.score
    );
    match &looped.closed {
        Some(c) => format!(
            "  {}: {part}; closing moved joints by up to {:.1} mm; one cycle travels {:.3} m and turns {:.1} degrees\n",
            if looped.is_whole {
                "already a loop"
            } else {
                "loop found"
            },
            1e3 * c.moved_m,
            c.travel_m,
            c.turn_deg,
        ),
        None => format!(
            "  no loop, clip unchanged: the best part ({part}) scores below {}\n",
            looped.min_score
        ),
    }
}

fn of_root_motion(root: &RootMotionEdited) -> String {
    let hips = named(&root.hips);
    let off = format!(
        "every joint within {:.3} mm of the source",
        1e3 * root.worst_m
    );
    let what = match (root.mode, &root.carrier) {
        (RootMotionMode::Keep, _) => "kept".to_owned(),
        (RootMotionMode::Extract, Some(carrier)) => {
            format!("moved to the joint {}, {off}", named(carrier))
        }
        (RootMotionMode::Extract, None) => "unchanged, since no joint above the hips can carry it (--json prints the trajectory, in-place removes it)".to_owned(),
        (RootMotionMode::InPlace, _) => format!("removed; with it added back, {off}"),
    };
    format!(
        "  root motion of the hips {hips}: {:.3} m displacement, {:.3} m path length, {:.1} degrees; {what}\n",
        root.travel_m, root.path_m, root.turn_deg,
    )
}

fn of_keys(keys: &KeysReduced) -> String {
    let (before, after) = (keys.animation_bytes_before, keys.animation_bytes_after);
    format!(
        "  keys reduced: {} -> {} keys, {} -> {} channels, {before} -> {after} bytes ({:.1}% saved); \
         nothing moved by more than {:.3} mm (verified at {} times)\n",
        keys.keys_before,
        keys.keys_after,
        keys.channels_before,
        keys.channels_after,
        100.0 * (1.0 - after as f64 / before.max(1) as f64),
        1e3 * keys.worst_m,
        keys.times_verified,
    )
}

/// Parses `FROM..TO`, either end open.
fn part(text: &str) -> Result<ClipPart, String> {
    let wrong = || "expected seconds as FROM..TO, ..TO or FROM.., FROM before TO".to_owned();
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let number = |t: &str| match t.trim() {
        "" => Ok(None),
        t => arguments::not_negative(t).map(Some).map_err(|_| wrong()),
    };
    let (from_secs, to_secs) = (number(from)?, number(to)?);
    match (from_secs, to_secs) {
        (None, None) => Err(wrong()),
        (from, Some(to)) if from.unwrap_or(0.0) >= to => Err(wrong()),
        _ => Ok(ClipPart { from_secs, to_secs }),
    }
}

/// Parses `MODE` or `MODE:SECS`.
fn root_motion(text: &str) -> Result<RootMotionOptions, String> {
    const MODES: &[(&str, RootMotionMode)] = &[
        ("keep", RootMotionMode::Keep),
        ("extract", RootMotionMode::Extract),
        ("in-place", RootMotionMode::InPlace),
    ];
    let (mode, secs) = text.split_once(':').unzip();
    Ok(RootMotionOptions {
        mode: arguments::word(mode.unwrap_or(text), MODES)?,
        smooth_secs: secs.map_or(Ok(0.0), arguments::positive)?,
        ..RootMotionOptions::default()
    })
}

/// Parses `METRES` or `METRES,drop-rest`.
fn reduction(text: &str) -> Result<ReduceOptions, String> {
    let (bound, more) = text.split_once(',').unzip();
    Ok(ReduceOptions {
        bound_metres: metres(bound.unwrap_or(text))?,
        drop_rest: more.map_or(Ok(false), |m| {
            arguments::word(m.trim(), &[("drop-rest", true)])
        })?,
        timelines: Timelines::Own,
    })
}

/// Parses a length in metres, or with the unit m, cm or mm.
fn metres(text: &str) -> Result<f32, String> {
    let text = text.trim();
    let (number, unit) = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)]
        .iter()
        .find_map(|(name, unit)| Some((text.strip_suffix(name)?, *unit)))
        .unwrap_or((text, 1.0));
    let metres = number
        .trim_end()
        .parse::<f64>()
        .ok()
        .map(|n| (n * unit) as f32);
    let metres = metres.filter(|m| m.is_finite() && *m > 0.0);
    metres.ok_or_else(|| "expected a length above 0, such as 0.001, 1mm or 0.1cm".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_units() {
        assert_eq!(metres("0.001"), Ok(0.001));
        assert_eq!(metres("1mm"), Ok(0.001));
        assert_eq!(metres("0.1 cm"), Ok(0.001));
        assert_eq!(metres("2m"), Ok(2.0));
        for bad in ["", "mm", "0", "-1mm", "1km", "NaN", "inf", "1e99m"] {
            assert!(metres(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn edits_take_their_numbers_along() {
        let smooth = root_motion("in-place:0.5").unwrap();
        assert_eq!(
            (smooth.mode, smooth.smooth_secs),
            (RootMotionMode::InPlace, 0.5)
        );
        assert_eq!(root_motion("keep").unwrap().smooth_secs, 0.0);
        for bad in ["", "away", "keep:", "keep:0", ":1"] {
            assert!(root_motion(bad).is_err(), "{bad}");
        }
        let dropped = reduction("1mm, drop-rest").unwrap();
        assert_eq!((dropped.bound_metres, dropped.drop_rest), (0.001, true));
        assert!(reduction("1mm,").is_err() && reduction("1mm,rest").is_err());
        assert!(!reduction("1mm").unwrap().drop_rest);
    }

    #[test]
    fn parts_may_be_open() {
        let of = |from_secs, to_secs| Ok(ClipPart { from_secs, to_secs });
        assert_eq!(part("1.5..3"), of(Some(1.5), Some(3.0)));
        assert_eq!(part("..3"), of(None, Some(3.0)));
        assert_eq!(part("2.."), of(Some(2.0), None));
        for bad in ["", "..", "3", "3..3", "3..1", "-1..2", "a..b", "1..NaN"] {
            assert!(part(bad).is_err(), "{bad}");
        }
    }
}
