//! `articula optimize IN... OUT`: writes characters in fewer bytes, at an error in motion that is measured
//! on what is written.

mod plan;
mod report;
mod textures;

use crate::arguments::{ReadArgs, positive, region_factor};
use crate::console::Console;
use crate::open;
use crate::selection::Chosen;
use crate::{fault, files};
use articula::convert::{AddClipsOptions, JointReduction};
use articula::core::joint_state::PassivePolicy;
use articula::formats::Limits;
use articula::optimize::{
    Compression, ErrorBound, OptimizeLimits, OptimizeOptions, OptimizeReport, PlatformLimits,
    optimize, optimize_to_fit,
};
use articula::{CharacterFile, Format};
use clap::{Args, ValueEnum};
use plan::{Plan, PlannedFile};
use report::{Batch, JointsHeld, OptimizedFile};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use textures::TextureArgs;

/// Arguments of `optimize`.
#[derive(Debug, Args)]
pub(crate) struct OptimizeArgs {
    /// Character files (.glb, .gltf, .vrm, .fbx, .bvh, ...) or folders of them; last the file to write (.glb,
    /// .vrm), or a folder that receives one file for each input
    #[arg(value_name = "IN… OUT", required = true, num_args = 2..)]
    paths: Vec<PathBuf>,
    /// Greatest error in motion of any vertex: pixels of a picture that the figure at rest fills from top to
    /// bottom (1px), or a length (0.5mm)
    #[arg(long, value_name = "1px|0.5mm", default_value = "1px", value_parser = error)]
    error: Given,
    /// Height of that picture in pixels
    #[arg(long, value_name = "N", default_value_t = 720.0, value_parser = positive)]
    height_px: f32,
    /// Extension that holds compressed arrays: ext (EXT_meshopt_compression, which viewers and engines
    /// read), khr (KHR_meshopt_compression, fewer bytes, a release candidate); or no compression, with
    /// positions of skinned meshes as integers (quantize: KHR_mesh_quantization) or with floats (none)
    #[arg(long, value_enum, value_name = "KIND", default_value_t = Kind::Ext)]
    compress: Kind,
    /// Keep all keys, and round their values alone
    #[arg(long)]
    no_keys: bool,
    /// Keep all triangles
    #[arg(long)]
    no_simplify: bool,
    /// What keeps its triangles: regions of the body, materials, meshes, and what morph targets or joints
    /// move, by name
    #[arg(
        long,
        value_name = "NAME,…",
        value_delimiter = ',',
        conflicts_with = "no_simplify"
    )]
    lock: Vec<String>,
    /// Factors by which squared errors of the surface count more in body regions, such as face=8,hands=4
    #[arg(long, value_name = "REGION=X,…", value_delimiter = ',', value_parser = region_factor, conflicts_with = "no_simplify")]
    region_weight: Vec<(String, f32)>,
    /// Joints that may move, such as "loa(Low) + zone(hands)"; all others are held, and errors are those
    /// from the motion that is left
    #[arg(long, value_name = "EXPR")]
    loa: Option<String>,
    /// LoA profile with the joints that may move (JSON), instead of --loa
    #[arg(long, value_name = "F.json", conflicts_with = "loa")]
    loa_profile: Option<PathBuf>,
    /// Greatest size of each file (3MB, 500kB, or bytes); with it, --max-triangles or --fit the error is the
    /// one that was asked for or the least greater one at which the file fits
    #[arg(long, value_name = "SIZE", value_parser = size_bytes)]
    max_bytes: Option<usize>,
    /// Greatest number of triangles
    #[arg(long, value_name = "N", conflicts_with = "no_simplify")]
    max_triangles: Option<usize>,
    /// Greatest number of joints of all skins: those that are missed least are merged into the joints above
    /// them, at an error that is told beside the others
    #[arg(long, value_name = "N")]
    max_joints: Option<usize>,
    /// Longest side of any texture in pixels: larger ones are made smaller, and a file with one that cannot
    /// be is refused
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    max_textures_px: Option<u32>,
    /// Published limits of a platform: vrchat-quest, vrchat-quest-good, vrchat-quest-excellent, cluster,
    /// mona, roblox, second-life
    #[arg(long, value_name = "NAME", conflicts_with = "no_simplify")]
    fit: Option<String>,
    /// Keep texture coordinates and tangents that no material of the file uses
    #[arg(long)]
    keep_attributes: bool,
    /// Write the clips of all inputs into one file, with the skeleton and the meshes of the first
    #[arg(long)]
    together: bool,
    /// Character on whose skin errors are measured of files without meshes, whose joints are found by name;
    /// without it three points around each joint are measured, half a bone away
    #[arg(long, value_name = "FILE")]
    skin: Option<PathBuf>,
    #[command(flatten)]
    textures: TextureArgs,
    /// Seed of the times at which the error is measured, besides key times and their middles
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    names: ReadArgs,
}

/// An error as it is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Given {
    Pixels(f32),
    Metres(f32),
}

impl Given {
    /// The bound, in pixels of a picture of a height that the figure at rest fills.
    pub(super) fn bound(self, height_px: f32) -> ErrorBound {
        match self {
            Self::Metres(metres) => ErrorBound::Metres(metres),
            Self::Pixels(px) => ErrorBound::Pixels { px, height_px },
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Ext,
    Khr,
    Quantize,
    None,
}

/// Parses pixels or a length.
pub(super) fn error(text: &str) -> Result<Given, String> {
    let text = text.trim();
    let units = [
        ("px", None),
        ("mm", Some(1e-3)),
        ("cm", Some(1e-2)),
        ("m", Some(1.0)),
    ];
    let found = units.into_iter().find_map(|(unit, metres)| {
        let number = text.strip_suffix(unit)?;
        Some((positive(number).ok()?, metres))
    });
    match found {
        Some((px, None)) => Ok(Given::Pixels(px)),
        Some((length, Some(metres))) => Ok(Given::Metres((f64::from(length) * metres) as f32)),
        None => Err("expected pixels or a length above 0, such as 1px or 0.5mm".to_owned()),
    }
}

/// Parses a size of a file in bytes.
fn size_bytes(text: &str) -> Result<usize, String> {
    let units = [("MB", 1e6), ("kB", 1e3), ("B", 1.0), ("", 1.0)];
    let found = units.into_iter().find_map(|(unit, bytes)| {
        let number: f32 = positive(text.trim().strip_suffix(unit)?).ok()?;
        Some((f64::from(number) * bytes).round() as usize)
    });
    found.ok_or_else(|| "expected a size such as 3MB, 500kB or 500000".to_owned())
}

/// Optimises and writes.
pub(crate) fn run(args: &OptimizeArgs, console: &Console) -> anyhow::Result<()> {
    args.limits()?;
    let plan = Plan::of(&args.paths, args.together)?;
    let inputs = plan.files.iter().flat_map(|file| &file.inputs);
    let inputs = inputs.chain(&args.loa_profile).chain(&args.skin);
    let made = plan.folder.as_deref().is_none_or(Path::is_dir);
    let outputs = plan.files.iter().filter(|_| made).map(|file| &file.out);
    console.files.plan(
        inputs.map(PathBuf::as_path).chain(args.names.inputs()),
        outputs.map(PathBuf::as_path),
    )?;
    let options = args.options(console)?;
    let mut done = Vec::new();
    let mut faults = Vec::new();
    for file in &plan.files {
        if let Some(folder) = &plan.folder {
            console.files.make_folder(folder)?;
        }
        match args.optimized(file, &options, console) {
            Ok(report) => done.push(report),
            Err(fault) if plan.files.len() == 1 => return Err(fault),
            Err(fault) => faults.push(fault),
        }
    }
    match (&plan.folder, done.pop()) {
        (None, Some(one)) => console.result(&one, OptimizedFile::text)?,
        (_, last) => {
            done.extend(last);
            let batch = Batch {
                files: done,
                failed: faults.iter().map(fault::line).collect(),
            };
            console.result(&batch, Batch::text)?;
        }
    }
    faults.iter().for_each(|fault| console.fault(fault));
    match faults.len() {
        0 => Ok(()),
        failed => anyhow::bail!(
            "{failed} of {} files could not be optimised",
            plan.files.len()
        ),
    }
}

impl OptimizeArgs {
    fn options(&self, console: &Console) -> anyhow::Result<OptimizeOptions> {
        let skin = self.skin.as_ref();
        let skin = skin.map(|skin| open::character(&console.files, skin, &ReadArgs::default()));
        let skin = skin.transpose()?.map(CharacterFile::into_character);
        Ok(OptimizeOptions {
            error: self.error.bound(self.height_px),
            compression: match self.compress {
                Kind::Ext => Compression::Ext,
                Kind::Khr => Compression::Khr,
                Kind::Quantize => Compression::Quantized,
                Kind::None => Compression::None,
            },
            reduce_keys: !self.no_keys,
            simplify: !self.no_simplify,
            locked: self.lock.clone(),
            region_weights: self.region_weight.clone(),
            keep_attributes: self.keep_attributes,
            skin: skin.map(Arc::new),
            textures: self.textures.options(self.height_px),
            seed: self.seed,
        })
    }

    /// The platform whose limits are meant.
    fn platform(&self) -> anyhow::Result<Option<PlatformLimits>> {
        let platform = self.fit.as_deref().map(PlatformLimits::of).transpose();
        platform.map_err(|fault| fault::usage(format!("--{fault}")))
    }

    fn limits(&self) -> anyhow::Result<OptimizeLimits> {
        let own = OptimizeLimits {
            max_bytes: self.max_bytes,
            max_triangles: self.max_triangles,
            max_textures_px: self.max_textures_px.map(|px| px as usize),
            max_joints: self.max_joints,
        };
        let platform = self.platform()?;
        Ok(platform.map_or(own, |platform| own.and(platform.limits)))
    }

    /// Holds the joints that may not move.
    fn held(&self, opened: &mut CharacterFile) -> anyhow::Result<Option<JointsHeld>> {
        let chosen = Chosen::of(self.loa.as_deref(), self.loa_profile.as_deref())?;
        let Some(chosen) = chosen else {
            return Ok(None);
        };
        let reduction = JointReduction {
            moving: chosen.moving.clone(),
            with_ancestors: false,
            passive: PassivePolicy::KeyPose,
        };
        let reduced = reduction
            .apply(opened)
            .map_err(|fault| chosen.placed(fault))?;
        Ok(Some(JointsHeld {
            selection: chosen.named,
            joints: reduced.joints,
            joints_active: reduced.joints_active,
        }))
    }

    /// Opens the inputs of a file, and returns the bytes of all of them.
    fn opened(
        &self,
        file: &PlannedFile,
        console: &Console,
    ) -> anyhow::Result<(CharacterFile, usize)> {
        let open = |input: &PathBuf| open::motion(&console.files, input, &self.names);
        let all: Vec<CharacterFile> = file.inputs.iter().map(open).collect::<Result<_, _>>()?;
        let bytes = all.iter().map(CharacterFile::bytes).sum();
        let mut all = all.into_iter();
        let Some(mut first) = all.next() else {
            return Err(fault::usage("no file to read".to_owned()));
        };
        let others: Vec<CharacterFile> = all.collect();
        let options = AddClipsOptions::default();
        console.work(|work| first.add_clips(&others, &options, work))?;
        Ok((first, bytes))
    }

    /// Writes one file. The source is written where the result would not be smaller.
    fn optimized(
        &self,
        file: &PlannedFile,
        options: &OptimizeOptions,
        console: &Console,
    ) -> anyhow::Result<OptimizedFile> {
        let (mut opened, bytes_in) = self.opened(file, console)?;
        let joints = self.held(&mut opened)?;
        let limits = self.limits()?;
        let (mut made, fit) = match limits.is_none() {
            true => (console.work(|work| optimize(&opened, options, work))?, None),
            false => {
                let (made, fit) =
                    console.work(|work| optimize_to_fit(&opened, options, &limits, work))?;
                (made, Some(fit))
            }
        };
        made.report.bytes_in = bytes_in;
        let alone = match &file.inputs[..] {
            [input] if is_whole(&opened, input) => Some(input),
            _ => None,
        };
        let may_be_kept = joints.is_none() && limits.allow_source(&made.report);
        if let Some(input) = alone.filter(|_| may_be_kept) {
            made = made.or_source(&files::read(input, Limits::default().bytes)?);
        }
        console.files.write(&file.out, &made.glb)?;
        let inputs: Vec<String> = file
            .inputs
            .iter()
            .map(|input| files::shown(input))
            .collect();
        Ok(OptimizedFile {
            input: inputs.join(", "),
            out: files::shown(&file.out),
            joints,
            fit,
            platform: self.platform()?,
            warnings: warnings(&opened, &made.report),
            report: made.report,
        })
    }
}

/// What was repaired in the file, and the pictures that are broken.
fn warnings(opened: &CharacterFile, report: &OptimizeReport) -> Vec<String> {
    let mut all = open::warnings(opened.warnings());
    all.extend(report.textures.iter().filter_map(|t| t.warning.clone()));
    all
}

/// Whether a file is a GLB, which has all of its data in itself.
fn is_whole(opened: &CharacterFile, input: &Path) -> bool {
    let is_glb = matches!(opened.format(), Format::Glb | Format::Vrm);
    is_glb && !matches!(files::extension(input).as_str(), "gltf")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_pixels_or_lengths() {
        assert_eq!(error("1px"), Ok(Given::Pixels(1.0)));
        assert_eq!(error(" 2 m"), Ok(Given::Metres(2.0)));
        assert_eq!(error("5cm"), Ok(Given::Metres(0.05)));
        for bad in ["", "1", "px", "0px", "-1mm", "1in"] {
            assert!(error(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_are_bytes_or_have_a_unit() {
        assert_eq!(size_bytes("3MB"), Ok(3_000_000));
        assert_eq!(size_bytes("1.5 kB"), Ok(1500));
        assert_eq!(size_bytes("700B"), Ok(700));
        assert_eq!(size_bytes("700"), Ok(700));
        for bad in ["", "MB", "0", "-1kB", "3GB"] {
            assert!(size_bytes(bad).is_err(), "{bad}");
        }
    }
}
