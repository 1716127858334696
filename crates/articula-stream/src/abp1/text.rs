//! The ASCII twin of a file, for tests and for people.
//!
//! Form: `docs/formats/abp1.md`, part 7.

use super::clip::{Abp1Clip, Bone, BoneTracks, MAX_BONES, TrackKind};
use crate::error::StreamError;
use crate::frame_rate::FrameRate;
use crate::limits::StreamLimits;
use articula_core::Mismatch;
use std::fmt::Write;

const VERSION: &str = "1";
/// Letters of the kinds, in their order.
const LETTERS: [char; TrackKind::ALL.len()] = ['T', 'R', 'S', 'O', 'C'];
/// Words of a bone's line before its name.
const BONE_WORDS: usize = 8;

/// Writes a clip as text, with the shortest decimals that are read back as the same values.
///
/// # Errors
/// A [`Mismatch`] if the clip contradicts itself ([`Abp1Clip::check`]) or a name has a line end.
pub fn write_text(clip: &Abp1Clip) -> Result<String, Mismatch> {
    clip.check()?;
    let names = clip.bones.iter().map(|bone| &bone.name);
    for name in names.chain([&clip.name]) {
        if name.contains(['\n', '\r']) || name.trim() != name {
            let what = "a name with a line end, or with blanks around it, cannot be written";
            return Err(Mismatch::new(format!("{name:?}"), what));
        }
    }
    let mut out = format!("abpt {VERSION}\n");
    // Writing to a string cannot fail.
    let _ = writeln!(out, "name {}", clip.name);
    let _ = writeln!(out, "frame_rate {}", clip.rate.hz());
    let _ = writeln!(out, "frames {}", clip.frames);
    let _ = writeln!(out, "bones {}", clip.bones.len());
    for (b, (bone, tracks)) in clip.bones.iter().zip(&clip.tracks).enumerate() {
        let kinds = LETTERS.iter().zip(&tracks.0);
        let mut kinds: String = kinds
            .filter(|(_, t)| t.is_some())
            .map(|(l, _)| *l)
            .collect();
        if kinds.is_empty() {
            kinds.push('-');
        }
        let parent = bone.parent.map_or("-".into(), |p| p.to_string());
        let [x, y, z] = bone.center;
        let (loa, region) = (bone.loa, bone.region);
        let line = format!(
            "{b} {kinds} {parent} {x} {y} {z} {loa} {region} {}",
            bone.name
        );
        out.push_str(line.trim_end());
        out.push('\n');
    }
    for frame in 0..clip.frames {
        let _ = writeln!(out, "frame {frame}");
        for (b, tracks) in clip.tracks.iter().enumerate() {
            if tracks.0.iter().all(Option::is_none) {
                continue;
            }
            let _ = write!(out, "{b}");
            for value in tracks.0.iter().flatten().flat_map(|track| track[frame]) {
                let _ = write!(out, " {value}");
            }
            out.push('\n');
        }
    }
    Ok(out)
}

/// Reads a clip from text.
///
/// # Errors
/// [`StreamError::Malformed`] that names the line, [`StreamError::LimitExceeded`].
pub fn read_text(bytes: &[u8], limits: &StreamLimits) -> Result<Abp1Clip, StreamError> {
    StreamLimits::check("line 1", "bytes", bytes.len() as u64, limits.bytes)?;
    let text = std::str::from_utf8(bytes).map_err(|e| {
        let before = &bytes[..e.valid_up_to()];
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        StreamError::malformed(format!("line {line}"), "expected UTF-8")
    })?;
    let mut lines = Lines {
        lines: text.lines(),
        number: 0,
    };
    if lines.value("abpt")? != VERSION {
        return Err(lines.bad(format!("expected version {VERSION}")));
    }
    let name = lines.value("name")?.to_owned();
    let hz = lines.value("frame_rate")?;
    let rate = hz.parse().ok().and_then(FrameRate::nearest);
    let rate = rate.ok_or_else(|| lines.bad(format!("a frame rate of {hz}")))?;
    let frames: usize = lines.number_of("frames")?;
    let count: usize = lines.number_of("bones")?;
    if count > MAX_BONES {
        return Err(lines.bad(format!("{count} bones, at most {MAX_BONES} are allowed")));
    }
    let (mut bones, mut tracks) = (Vec::new(), Vec::new());
    for b in 0..count {
        let line = lines.next()?;
        let (bone, kinds) = bone(&lines, line, b)?;
        bones.push(bone);
        tracks.push(kinds);
    }
    let mut clip = Abp1Clip {
        name,
        bones,
        rate,
        frames,
        tracks,
    };
    for frame in 0..frames {
        read_frame(&mut lines, frame, &mut clip.tracks)?;
    }
    lines.end()?;
    Ok(clip)
}

/// Lines with contents, and the number of the current one.
struct Lines<'a> {
    lines: std::str::Lines<'a>,
    number: usize,
}

impl<'a> Lines<'a> {
    fn bad(&self, what: impl Into<String>) -> StreamError {
        StreamError::malformed(format!("line {}", self.number), what)
    }

    /// The next line that is neither blank nor a comment, without blanks around it.
    fn found(&mut self) -> Option<&'a str> {
        for line in self.lines.by_ref() {
            self.number += 1;
            let line = line.trim();
            if !line.is_empty() && !line.starts_with('#') {
                return Some(line);
            }
        }
        None
    }

    fn next(&mut self) -> Result<&'a str, StreamError> {
        let found = self.found();
        found.ok_or_else(|| self.bad("unexpected end of the text after this line"))
    }

    /// The rest of the next line after a key.
    fn value(&mut self, key: &str) -> Result<&'a str, StreamError> {
        let line = self.next()?;
        let rest = line.strip_prefix(key);
        let rest = rest.filter(|rest| rest.is_empty() || rest.starts_with(char::is_whitespace));
        let rest = rest.ok_or_else(|| self.bad(format!("found \"{line}\", expected \"{key}\"")))?;
        Ok(rest.trim())
    }

    fn number_of(&mut self, key: &str) -> Result<usize, StreamError> {
        let found = self.value(key)?;
        let number = found.parse();
        number.map_err(|_| self.bad(format!("found \"{found}\", expected a number")))
    }

    fn end(&mut self) -> Result<(), StreamError> {
        match self.found() {
            None => Ok(()),
            Some(line) => Err(self.bad(format!("found \"{line}\" after the last frame"))),
        }
    }
}

/// Parses the line of bone `b`, and gives it an empty track of each kind that it lists.
fn bone(lines: &Lines<'_>, line: &str, b: usize) -> Result<(Bone, BoneTracks), StreamError> {
    let mut rest = line;
    let mut words = [""; BONE_WORDS];
    for word in &mut words {
        let (found, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        *word = found;
        rest = after.trim_start();
    }
    let [id, kinds, parent, x, y, z, loa, region] = words;
    let bad = |what: &str, found: &str| lines.bad(format!("found \"{found}\", expected {what}"));
    let byte = |text: &str| text.parse().map_err(|_| bad("a number below 256", text));
    let metres = |text: &str| {
        let value = text.parse().ok().filter(|v: &f32| v.is_finite());
        value.ok_or_else(|| bad("a finite number", text))
    };
    if id.parse() != Ok(b) {
        return Err(bad(&format!("bone {b}"), id));
    }
    let mut tracks = BoneTracks::default();
    for letter in kinds.chars().filter(|_| kinds != "-") {
        let kind = LETTERS.iter().position(|l| *l == letter);
        let kind = kind.ok_or_else(|| bad("letters of TRSOC, or -", kinds))?;
        tracks.0[kind] = Some(Vec::new());
    }
    let parent = match parent {
        "-" => None,
        number => {
            let number = number.parse().ok().filter(|p| usize::from(*p) < b);
            Some(number.ok_or_else(|| bad("a bone before this one, or -", parent))?)
        }
    };
    let bone = Bone {
        name: rest.to_owned(),
        parent,
        center: [metres(x)?, metres(y)?, metres(z)?],
        loa: byte(loa)?,
        region: byte(region)?,
    };
    Ok((bone, tracks))
}

fn read_frame(
    lines: &mut Lines<'_>,
    frame: usize,
    tracks: &mut [BoneTracks],
) -> Result<(), StreamError> {
    let found = lines.number_of("frame")?;
    if found != frame {
        return Err(lines.bad(format!("frame {found}, expected {frame}")));
    }
    for (b, tracks) in tracks.iter_mut().enumerate() {
        if tracks.0.iter().all(Option::is_none) {
            continue;
        }
        let line = lines.next()?;
        let mut words = line.split_whitespace();
        if words.next().map(str::parse) != Some(Ok(b)) {
            return Err(lines.bad(format!("found \"{line}\", expected values of bone {b}")));
        }
        for track in tracks.0.iter_mut().flatten() {
            let mut value = [0.0; 3];
            for value in &mut value {
                let word = words.next().unwrap_or("the end of the line");
                let found = word.parse().ok().filter(|v: &f32| v.is_finite());
                let expected = || lines.bad(format!("found \"{word}\", expected a finite number"));
                *value = found.ok_or_else(expected)?;
            }
            track.push(value);
        }
        if words.next().is_some() {
            return Err(lines.bad(format!("too many values of bone {b}")));
        }
    }
    Ok(())
}
