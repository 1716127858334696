//! Flags that several commands share, and the parsers of their values.

use articula::core::Viewport;
use articula::formats::UpAxis;
use articula::formats::mpeg4::fap::AbsentPolicy;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// A character file and the meshes of it that are used.
#[derive(Debug, Clone, Args)]
pub(crate) struct CharacterArgs {
    /// Character file (.glb, .gltf, .vrm, .vrma, .bvh, .bap, ...)
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

/// Up axis of a file that does not state it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum UpArgument {
    /// +Y, as in most files
    Y,
    /// +Z, as in some capture systems
    Z,
}

/// Value of a FAP or BAP parameter in frames whose mask leaves it out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LeftOut {
    /// Its last value, as in the standard
    Hold,
    /// Zero, the neutral value, as in the reference encoder
    Zero,
}

/// How a file is read: joint maps and, where the file does not state them, its unit and up axis.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ReadArgs {
    /// JSON file with your joint map, used instead of all others if it fits (repeatable)
    #[arg(long, value_name = "F.json")]
    pub(crate) joint_map: Vec<PathBuf>,
    /// Length of one file unit in metres [default: estimated from the figure's size for BVH, ASF
    /// and BVA, 1 for all others]
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) unit_metres: Option<f32>,
    /// Axis that points up, for BVH, ASF and BVA [default: detected from the position of the head]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub(crate) up: Option<UpArgument>,
    /// ASF file with the skeleton of an AMC motion [default: the .asf file with the same name in
    /// the same folder]
    #[arg(long, value_name = "F.asf")]
    pub(crate) skeleton: Option<PathBuf>,
    /// Frame rate of an AMC motion in hertz [default: as stated in the file, else 120]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) amc_rate_hz: Option<f32>,
    /// Value of a FAP or BAP parameter in frames whose mask leaves it out [default: hold]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) absent: Option<LeftOut>,
    /// Leave out the first frame of each clip of a motion; captures often begin with one of the rest
    /// pose
    #[arg(long)]
    pub(crate) skip_first_frame: bool,
}

impl ReadArgs {
    /// The files that tell how others are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let all = self.joint_map.iter().chain(&self.skeleton);
        all.map(PathBuf::as_path)
    }

    /// Whether a flag is given.
    pub(crate) fn asks(&self) -> bool {
        self.inputs().next().is_some()
            || self.unit_metres.is_some()
            || self.up.is_some()
            || self.amc_rate_hz.is_some()
            || self.absent.is_some()
            || self.skip_first_frame
    }

    /// Up axis of a file that does not state it.
    pub(crate) fn up(&self) -> UpAxis {
        match self.up {
            None => UpAxis::Auto,
            Some(UpArgument::Y) => UpAxis::Y,
            Some(UpArgument::Z) => UpAxis::Z,
        }
    }

    /// Value of a parameter in frames whose mask leaves it out.
    pub(crate) fn absent(&self) -> AbsentPolicy {
        match self.absent {
            None | Some(LeftOut::Hold) => AbsentPolicy::Hold,
            Some(LeftOut::Zero) => AbsentPolicy::Zero,
        }
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

/// Parses a vertical field of view in degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    let angle = text.parse::<f32>().ok();
    let angle = angle.filter(|a| (1.0..=170.0).contains(a));
    angle.ok_or_else(|| "expected an angle of 1 to 170 degrees".into())
}

/// Parses a finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| n.is_finite());
    number.ok_or_else(|| "expected a number".into())
}

/// Parses a finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| "expected a number above 0".into())
}

/// Parses a tolerance that a motion stream can state.
pub(crate) fn skin_millimetres(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok();
    let number = number.filter(|mm| (0.001..=65.535).contains(mm));
    number.ok_or_else(|| "expected millimetres from 0.001 to 65.535".into())
}

/// Parses a finite number that is not negative.
pub(crate) fn not_negative(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| n.is_finite() && *n >= 0.0);
    number.ok_or_else(|| "expected a number of 0 or above".into())
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
}
