//! The context of use as flags.

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
    /// Milliseconds of each frame that are left for the character
    #[arg(long, value_name = "MS", value_parser = at_least_0)]
    frame_ms: Option<f64>,
    /// Joints that the device evaluates in a millisecond
    #[arg(long, value_name = "N", value_parser = above_0)]
    joints_per_ms: Option<f64>,
    /// Triangles that the device draws in a second
    #[arg(long, value_name = "N", value_parser = above_0)]
    triangles_per_s: Option<f64>,
    /// Finest level of articulation of the body, 0 (coarsest) to 5
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(0..=5))]
    loa: Option<u8>,
    /// Regions of the body whose motion is kept: face, arms, torso, pelvis, legs, feet, hands, upper,
    /// lower, face-shoulders
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    zones: Vec<Zone>,
    /// Finest level of articulation of the face, 0 (very low) to 3 (high)
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(0..=3))]
    face_loa: Option<u8>,
    /// Finest mesh level; 0 is the finest
    #[arg(long, value_name = "L")]
    mesh_level: Option<u32>,
    /// Form in which the character is shown [default: 3d where possible]
    #[arg(long, value_enum, value_name = "FORM")]
    modality: Option<ModalityArgument>,
}

impl ContextArgs {
    /// The files of contexts.
    pub(crate) fn files(&self) -> impl Iterator<Item = &Path> {
        self.context.iter().map(PathBuf::as_path)
    }

    /// The context of all files, aggregated, with what flags tell.
    pub(crate) fn context(&self) -> anyhow::Result<Context> {
        let mut context = Context::default();
        for path in self.files() {
            context = Context::aggregate(&context, &read(path)?);
        }
        self.add_to(&mut context);
        Ok(context)
    }

    /// Sets what flags tell.
    fn add_to(&self, context: &mut Context) {
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
        set(&mut terminal.frame_budget_ms, self.frame_ms);
        set(&mut terminal.joints_per_ms, self.joints_per_ms);
        set(&mut terminal.triangles_per_s, self.triangles_per_s);
        let view = &mut context.view;
        set(&mut view.distance_m, self.distance_m);
        set(
            &mut view.fov_rad,
            self.fov_deg.map(|deg| f64::from(deg).to_radians()),
        );
        let wanted = &mut context.preferences;
        set(&mut wanted.tolerance_px, self.tolerance_px);
        wanted.body_loa = self.loa.or(wanted.body_loa);
        wanted.face_loa = self.face_loa.map(|loa| [loa; 8]).or(wanted.face_loa);
        wanted.mesh_level = self.mesh_level.or(wanted.mesh_level);
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

fn number(text: &str, holds: impl Fn(f64) -> bool, what: &str) -> Result<f64, String> {
    let parsed = text.parse::<f64>().ok();
    let allowed = parsed.filter(|n| n.is_finite() && holds(*n));
    allowed.ok_or_else(|| format!("expected {what}"))
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
