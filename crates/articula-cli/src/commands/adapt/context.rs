//! The context of use as flags.

use crate::arguments::{number, settings};
use crate::commands::device_score::{DeviceScore, device_score};
use crate::files;
use anyhow::Context as _;
use articula::core::{Region, Zone};
use articula::stream::DescriptionLimits;
use articula::stream::description::{Context, Modality};
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// Form in which the character is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ModalityArgument {
    /// A mesh
    #[value(name = "3d")]
    Mesh,
    /// A warped portrait
    Portrait,
    /// Vector graphics
    Vector,
}

/// The context: what network, device, viewer and view are like. What is not given is unknown.
#[derive(Debug, Clone, Args)]
pub(crate) struct ContextArgs {
    /// Context of use, as XDI (.xml) or JSON; flags replace what it says (repeatable: client first,
    /// then server)
    #[arg(long, value_name = "F.xml|F.json")]
    context: Vec<PathBuf>,
    /// Bandwidth in kilobits (1000 bits) per second
    #[arg(long, value_name = "KBPS", value_parser = at_least_0)]
    bandwidth_kbps: Option<f64>,
    /// Distance of the camera from the character in metres
    #[arg(long, value_name = "M", value_parser = above_0)]
    distance_m: Option<f64>,
    /// Size of the picture in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    viewport: Option<(u32, u32)>,
    /// Vertical field of view in degrees [default: 45]
    #[arg(long, value_name = "DEG", value_parser = crate::arguments::field_of_view)]
    fov_deg: Option<f32>,
    /// Error in pixels that is not seen [default: 1 with --distance-m, else 0]
    #[arg(long, value_name = "PX", value_parser = at_least_0)]
    tolerance_px: Option<f64>,
    /// Finest level of articulation of the body, 0 (coarsest) to 5
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(0..=5))]
    loa: Option<u8>,
    /// Regions of the body whose motion is kept: face, arms, torso, pelvis, legs, feet, hands, upper,
    /// lower, face-shoulders
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    zones: Vec<Zone>,
    /// Report of articula bench device, or the score of the device in a benchmark, in percent of a reference
    /// machine that shows all of the item at the wanted rate: less is sent that takes less time per frame
    #[arg(long, value_name = "N|F.json", value_parser = device_score)]
    device_score: Option<DeviceScore>,
    /// Form in which the character is shown [default: 3d where possible]
    #[arg(long, value_enum, value_name = "FORM")]
    modality: Option<ModalityArgument>,
}

/// The finest parts that are sent.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FinestParts {
    /// Finest tier of motions; 0 is the finest.
    pub(crate) tier: u32,
    /// Most pixels on the longer side of a texture.
    pub(crate) texture_px: Option<u32>,
    face_loa: Option<u8>,
    mesh_level: Option<u32>,
}

/// Parses the finest parts that are sent.
pub(super) fn limits(text: &str) -> Result<FinestParts, String> {
    let whole = |text: &str| {
        text.parse()
            .map_err(|_| "expected a whole number".to_owned())
    };
    let face_loa = |text: &str| {
        let level = text.parse().ok().filter(|level| *level <= 3);
        level.ok_or_else(|| "expected 0 (very low) to 3 (high)".to_owned())
    };
    settings(text, |to: &mut FinestParts, key, value| {
        match key {
            "tier" => to.tier = whole(value)?,
            "texture" => to.texture_px = Some(whole(value)?),
            "face-loa" => to.face_loa = Some(face_loa(value)?),
            "mesh-level" => to.mesh_level = Some(whole(value)?),
            _ => return Ok(Some("tier, texture, face-loa, mesh-level")),
        }
        Ok(None)
    })
}

impl ContextArgs {
    /// The files of contexts and of the device.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        let report = self.device_score.iter().filter_map(DeviceScore::file);
        self.context.iter().map(PathBuf::as_path).chain(report)
    }

    /// The context of all files, aggregated, with what flags tell.
    pub(crate) fn context(&self, finest: &FinestParts) -> anyhow::Result<Context> {
        let mut context = Context::default();
        for path in &self.context {
            context = Context::aggregate(&context, &read(path)?);
        }
        self.add_to(&mut context, finest);
        if let Some(score) = &self.device_score {
            score.add_to(&mut context)?;
        }
        Ok(context)
    }

    /// Sets what flags tell.
    fn add_to(&self, context: &mut Context, finest: &FinestParts) {
        let set = |to: &mut Option<f64>, from: Option<f64>| *to = from.or(*to);
        let network = &mut context.network;
        set(
            &mut network.available_bps,
            self.bandwidth_kbps.map(|k| 1e3 * k),
        );
        let terminal = &mut context.terminal;
        if let Some((width, height)) = self.viewport {
            terminal.width_px = Some(width.into());
            terminal.height_px = Some(height.into());
        }
        let view = &mut context.view;
        set(&mut view.distance_m, self.distance_m);
        set(
            &mut view.fov_rad,
            self.fov_deg.map(|deg| f64::from(deg).to_radians()),
        );
        let wanted = &mut context.preferences;
        set(&mut wanted.tolerance_px, self.tolerance_px);
        wanted.body_loa = self.loa.or(wanted.body_loa);
        wanted.face_loa = finest.face_loa.map(|loa| [loa; 8]).or(wanted.face_loa);
        wanted.mesh_level = finest.mesh_level.or(wanted.mesh_level);
        if !self.zones.is_empty() {
            wanted.body_regions = Some(mask(&self.zones));
        }
        let modality = self.modality.map(|modality| match modality {
            ModalityArgument::Mesh => Modality::Mesh,
            ModalityArgument::Portrait => Modality::Warp,
            ModalityArgument::Vector => Modality::Vector,
        });
        wanted.modality = modality.or(wanted.modality);
    }
}

/// Reads a context, as XML by its first character, else as JSON.
fn read(path: &Path) -> anyhow::Result<Context> {
    let limits = DescriptionLimits::default();
    let bytes = files::read(path, limits.bytes)?;
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let read = match first {
        Some(b'{') => Context::read_json(&bytes, &limits),
        _ => Context::read_xdi(&bytes, &limits),
    };
    read.with_context(|| files::shown(path))
}

/// The regions of some zones: bit `n - 1` is region `n`.
fn mask(zones: &[Zone]) -> u8 {
    let has = |region: Region| zones.iter().any(|zone| zone.contains(region));
    let regions = Region::ALL.into_iter().enumerate();
    let bits = regions
        .filter(|(_, region)| has(*region))
        .map(|(bit, _)| 1 << bit);
    bits.fold(0, |mask, bit: u8| mask | bit)
}

/// Parses a number above 0.
pub(super) fn above_0(text: &str) -> Result<f64, String> {
    number(text, |n| n > 0.0, "a number above 0")
}

/// Parses a number from 0 on.
fn at_least_0(text: &str) -> Result<f64, String> {
    number(text, |n| n >= 0.0, "a number from 0 on")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zones_become_the_masks_of_the_thesis() {
        let of =
            |names: &[&str]| mask(&names.iter().map(|n| n.parse().unwrap()).collect::<Vec<_>>());
        assert_eq!(of(&["upper"]), 71);
        assert_eq!(of(&["lower"]), 56);
        assert_eq!(of(&["face", "hands"]), 65);
        assert_eq!(of(&["all"]), 127);
    }
}
