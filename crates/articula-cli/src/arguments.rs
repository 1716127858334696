//! Flags that commands share, and how their values are spelled.

use articula_core::Viewport;
use articula_formats::UpAxis;
use articula_formats::mpeg4::fap::Absent;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// A character file and what of it counts.
#[derive(Debug, Clone, Args)]
pub(crate) struct CharacterArgs {
    /// Character file (.glb, .gltf, .vrm, .vrma, .bvh, .bap, ...)
    pub(crate) file: PathBuf,
    /// Leave this mesh out (repeatable)
    #[arg(long, value_name = "NAME")]
    pub(crate) hide: Vec<String>,
    /// Keep only this mesh (repeatable)
    #[arg(long, value_name = "NAME")]
    pub(crate) only: Vec<String>,
    #[command(flatten)]
    pub(crate) names: ReadArgs,
}

impl CharacterArgs {
    /// Whether some of the meshes do not count.
    pub(crate) fn leaves_out(&self) -> bool {
        !self.hide.is_empty() || !self.only.is_empty()
    }
}

/// The axis that points up in a file that does not say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum UpArgument {
    /// As most files have it
    Y,
    /// As some capture systems write it
    Z,
}

/// What a parameter does that a mask leaves out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LeftOut {
    /// It keeps its value, as the standard has it
    Hold,
    /// It is neutral, as the reference encoder takes it
    Zero,
}

/// How a file is understood: its joint names and, where it does not say, its unit and up axis.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct ReadArgs {
    /// Joint map of your own, used before the built-in ones (repeatable)
    #[arg(long, value_name = "F.json")]
    pub(crate) joint_map: Vec<PathBuf>,
    /// BVH, ASF, BVA: metres of one unit [default: told from the figure's height]
    #[arg(long, value_name = "M", value_parser = positive)]
    pub(crate) unit_metres: Option<f32>,
    /// BVH, ASF, BVA: the axis that points up [default: told from where the head is]
    #[arg(long, value_enum, value_name = "AXIS")]
    pub(crate) up: Option<UpArgument>,
    /// AMC: the skeleton of the motion [default: the .asf file beside it that is called alike]
    #[arg(long, value_name = "F.asf")]
    pub(crate) skeleton: Option<PathBuf>,
    /// AMC: frames a second [default: 120, unless the file says it]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) amc_rate_hz: Option<f32>,
    /// FAP, BAP: what a parameter does that a frame's mask leaves out [default: hold]
    #[arg(long, value_enum, value_name = "WHAT")]
    pub(crate) absent: Option<LeftOut>,
}

impl ReadArgs {
    /// The up axis of a file that does not say it.
    pub(crate) fn up(&self) -> UpAxis {
        match self.up {
            None => UpAxis::Auto,
            Some(UpArgument::Y) => UpAxis::Y,
            Some(UpArgument::Z) => UpAxis::Z,
        }
    }

    /// What a parameter does that a mask leaves out.
    pub(crate) fn absent(&self) -> Absent {
        match self.absent {
            None | Some(LeftOut::Hold) => Absent::Hold,
            Some(LeftOut::Zero) => Absent::Zero,
        }
    }
}

/// The picture that pixels are counted in.
#[derive(Debug, Clone, Args)]
pub(crate) struct ViewArgs {
    /// Size of the picture, pixels
    #[arg(long, value_name = "WxH", default_value = "1280x720", value_parser = size)]
    pub(crate) viewport: (u32, u32),
    /// Vertical field of view, degrees
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

/// Width and height of a picture.
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

/// A vertical opening, degrees.
pub(crate) fn field_of_view(text: &str) -> Result<f32, String> {
    let angle = text.parse::<f32>().ok();
    let angle = angle.filter(|a| (1.0..=170.0).contains(a));
    angle.ok_or_else(|| "expected an angle of 1 to 170 degrees".into())
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| n.is_finite());
    number.ok_or_else(|| "expected a number".into())
}

/// A finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok();
    let number = number.filter(|n| n.is_finite() && *n > 0.0);
    number.ok_or_else(|| "expected a number above 0".into())
}

/// A finite number, zero or above.
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
