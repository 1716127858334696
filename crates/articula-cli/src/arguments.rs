//! Flags that several commands share, and the parsers of their values.

use articula::core::{Region, Viewport};
use articula::formats::UpAxis;
use articula::formats::mpeg4::fap::AbsentPolicy;
use clap::Args;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A character file and the meshes of it that are used.
#[derive(Debug, Clone, Args)]
pub(crate) struct CharacterArgs {
    /// Character file (.glb, .gltf, .vrm, .vrma, .fbx, .bvh, ...)
    pub(crate) file: PathBuf,
    /// Name of a mesh to leave out (repeatable)
    #[arg(long, value_name = "NAME")]
    pub(crate) hide: Vec<String>,
    /// Name of a mesh to keep, leaving out all others (repeatable)
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    #[command(flatten)]
    pub(crate) names: ReadArgs,
}

impl CharacterArgs {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        [self.file.as_path()].into_iter().chain(self.names.inputs())
    }

    /// Whether some meshes are left out.
    pub(crate) fn leaves_out(&self) -> bool {
        !self.hide.is_empty() || !self.only.is_empty()
    }
}

/// How files are read: joint maps, and what a file does not state.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ReadArgs {
    /// JSON file with your joint map, used instead of all others if it fits (repeatable)
    #[arg(long, value_name = "F.json")]
    pub(crate) joint_map: Vec<PathBuf>,
    /// JSON file with your face map: what morph targets and expressions show, instead of what their
    /// names say
    #[arg(long, value_name = "F.json")]
    pub(crate) face_map: Option<PathBuf>,
    /// What files do not state, instead of a guess: unit-metres=M, the length of one unit; up=y or
    /// up=z, of BVH, ASF and BVA; skeleton=F.asf and amc-rate-hz=HZ, of an AMC motion; absent=hold or
    /// absent=zero, a FAP or BAP parameter in frames whose mask leaves it out; first-frame=skip leaves
    /// out the first frame of each clip, with which captures often show the rest pose
    #[arg(long, value_name = "KEY=VALUE,…", value_parser = read_settings)]
    pub(crate) read: Option<ReadSettings>,
}

/// What files do not state.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct ReadSettings {
    /// Length of one unit of the file in metres.
    pub(crate) unit_metres: Option<f32>,
    /// Axis that points up.
    pub(crate) up: UpAxis,
    /// ASF file with the skeleton of an AMC motion.
    pub(crate) skeleton: Option<PathBuf>,
    /// Frame rate of an AMC motion in hertz.
    pub(crate) amc_rate_hz: Option<f32>,
    /// Value of a FAP or BAP parameter in frames whose mask leaves it out.
    pub(crate) absent: AbsentPolicy,
    /// Whether the first frame of each clip is left out.
    pub(crate) skip_first_frame: bool,
}

fn read_settings(text: &str) -> Result<ReadSettings, String> {
    const UP: &[(&str, UpAxis)] = &[("y", UpAxis::Y), ("z", UpAxis::Z)];
    const ABSENT: &[(&str, AbsentPolicy)] =
        &[("hold", AbsentPolicy::Hold), ("zero", AbsentPolicy::Zero)];
    const FIRST: &[(&str, bool)] = &[("keep", false), ("skip", true)];
    settings(text, |to: &mut ReadSettings, key, value| {
        match key {
            "unit-metres" => to.unit_metres = Some(positive(value)?),
            "up" => to.up = word(value, UP)?,
            "skeleton" => to.skeleton = Some(file(value)?),
            "amc-rate-hz" => to.amc_rate_hz = Some(positive(value)?),
            "absent" => to.absent = word(value, ABSENT)?,
            "first-frame" => to.skip_first_frame = word(value, FIRST)?,
            _ => {
                return Ok(Some(
                    "unit-metres, up, skeleton, amc-rate-hz, absent, first-frame",
                ));
            }
        }
        Ok(None)
    })
}

impl ReadArgs {
    /// The files that tell how others are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let skeleton = self.read.iter().flat_map(|read| &read.skeleton);
        let maps = self.joint_map.iter().chain(&self.face_map);
        maps.chain(skeleton).map(PathBuf::as_path)
    }

    /// Whether a flag is given.
    pub(crate) fn asks(&self) -> bool {
        !self.joint_map.is_empty() || self.face_map.is_some() || self.read.is_some()
    }

    /// What files do not state.
    pub(crate) fn settings(&self) -> ReadSettings {
        self.read.clone().unwrap_or_default()
    }
}

/// The picture in whose pixels errors are measured.
#[derive(Debug, Clone, Args)]
pub(crate) struct ViewArgs {
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub(crate) viewport: (u32, u32),
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value = "45", value_parser = field_of_view)]
    pub(crate) fov_deg: f32,
}

impl ViewArgs {
    /// The viewport of the view.
    pub(crate) fn viewport(&self) -> Viewport {
        Viewport {
            width_px: self.viewport.0 as f32,
            height_px: self.viewport.1 as f32,
            fov_y_radians: self.fov_deg.to_radians(),
        }
    }
}

/// Parses `KEY=VALUE,…`, each key at most once. `set` takes a key and its value; of a key that it does
/// not know, it returns the keys that there are.
pub(crate) fn settings<T: Default>(
    text: &str,
    set: impl Fn(&mut T, &str, &str) -> Result<Option<&'static str>, String>,
) -> Result<T, String> {
    let mut made = T::default();
    let mut given = Vec::new();
    for pair in text.split(',') {
        let (key, value) = pair.split_once('=').unwrap_or((pair, ""));
        let [key, value] = [key.trim(), value.trim()];
        if given.contains(&key) {
            return Err(format!("{key} is given twice"));
        }
        given.push(key);
        let unknown = set(&mut made, key, value).map_err(|what| format!("{key}: {what}"))?;
        if let Some(keys) = unknown {
            return Err(format!("unknown key \"{key}\"; keys are {keys}"));
        }
    }
    Ok(made)
}

/// The meaning of a word among those known.
pub(crate) fn word<T: Copy>(text: &str, known: &[(&str, T)]) -> Result<T, String> {
    let found = known.iter().find(|(word, _)| *word == text);
    found.map(|(_, meaning)| *meaning).ok_or_else(|| {
        let words: Vec<&str> = known.iter().map(|(word, _)| *word).collect();
        format!("expected {}", words.join(" or "))
    })
}

/// Parses the name of a file.
pub(crate) fn file(text: &str) -> Result<PathBuf, String> {
    match text {
        "" => Err("expected a file".into()),
        text => Ok(text.into()),
    }
}

/// Parses the width and height of a picture, 16 to 16384 pixels.
pub(crate) fn size(text: &str) -> Result<(u32, u32), String> {
    let parts = text.split_once(['x', 'X']);
    let number = |t: &str| {
        t.trim()
            .parse::<u32>()
            .ok()
            .filter(|n| (16..=16384).contains(n))
    };
    parts
        .and_then(|(w, h)| Some((number(w)?, number(h)?)))
        .ok_or_else(|| "expected width x height of 16 to 16384 pixels, such as 1280x720".into())
}

/// Parses a finite number for which `holds` is true; `what` says which.
pub(crate) fn number<T: FromStr + Copy + Into<f64>>(
    text: &str,
    holds: impl Fn(f64) -> bool,
    what: &str,
) -> Result<T, String> {
    let number = text.trim().parse::<T>().ok();
    let number = number.filter(|n| (*n).into().is_finite() && holds((*n).into()));
    number.ok_or_else(|| format!("expected {what}"))
}

/// Parses a vertical field of view in degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    number(
        text,
        |n| (1.0..=170.0).contains(&n),
        "an angle of 1 to 170 degrees",
    )
}

/// Parses a finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    number(text, |_| true, "a number")
}

/// Parses a finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    number(text, |n| n > 0.0, "a number above 0")
}

/// Parses a tolerance that a motion stream can state.
pub(crate) fn skin_millimetres(text: &str) -> Result<f64, String> {
    number(
        text,
        |mm| (0.001..=65.535).contains(&mm),
        "millimetres from 0.001 to 65.535",
    )
}

/// Parses a finite number that is not negative.
pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    number(text, |n| n >= 0.0, "a number of 0 or above")
}

/// Parses a region of the body and a factor, such as `face=8`.
pub(crate) fn region_factor(text: &str) -> Result<(String, f32), String> {
    let known = || Region::ALL.map(|r| r.to_string()).join(", ");
    let (name, factor) = text
        .split_once('=')
        .ok_or("expected a form such as face=8")?;
    let region = name
        .parse::<Region>()
        .map_err(|_| format!("expected one of the regions {}", known()))?;
    match factor.parse::<f32>() {
        Ok(x) if x > 0.0 && x <= 1e6 => Ok((region.to_string(), x)),
        _ => Err("expected a factor above 0 and at most 1000000".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_bounded() {
        assert_eq!(size("1280x720"), Ok((1280, 720)));
        for bad in ["", "x", "720", "0x10", "1280x99999", "-1x720", "1e3x720"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        assert!(field_of_view("NaN").is_err() && field_of_view("180").is_err());
        assert!(positive("inf").is_err() && positive("0").is_err() && positive("2").is_ok());
        assert!(not_negative("0").is_ok() && not_negative("-1").is_err());
    }

    #[test]
    fn settings_are_typed_and_told_once() {
        let read = read_settings("unit-metres=0.01, up=z,absent=zero,skeleton=a=b.asf").unwrap();
        let expected = ReadSettings {
            unit_metres: Some(0.01),
            up: UpAxis::Z,
            skeleton: Some("a=b.asf".into()),
            amc_rate_hz: None,
            absent: AbsentPolicy::Zero,
            skip_first_frame: false,
        };
        assert_eq!(read, expected);
        for (bad, mend) in [
            ("", "keys are unit-metres, up, skeleton"),
            ("size=2", "unknown key \"size\""),
            ("up=x", "up: expected y or z"),
            ("up", "up: expected y or z"),
            ("amc-rate-hz=0", "amc-rate-hz: expected a number above 0"),
            ("skeleton=", "expected a file"),
            ("up=y,up=y", "up is given twice"),
        ] {
            let what = read_settings(bad).unwrap_err();
            assert!(what.contains(mend), "{bad}: {what}");
        }
    }
}
