//! `articula flatten FILE OUT`: converts an animated character to 2D and reports size and error.

mod arguments;
mod face;
mod frame;
mod impostor;
mod moving;
mod portrait;
pub(crate) mod report;

pub(crate) use arguments::FlattenArgs;

use crate::console::Console;
use crate::open;
use crate::{fault, files};
use anyhow::Context;
use arguments::{
    ConvertArgs, FlattenCommand, FormName, ProfileName, RootName, ShadingName, TextureName,
};
use articula::Figure;
use articula::core::Viewport;
use articula::flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};
use articula::flat::planar::OrderOptions;
use articula::flat::planar::Shading;
use articula::flat::planar::SplitOptions;
use articula::flat::vector::player::PlayerOutput;
use articula::flat::vector::{AnimatedSvg, ThesisForm, ThesisSvgOptions};
use articula::flatten::{
    BytesPerTriangle, FlatBytes, FlattenReport, FramedCharacter, LEAST_TRIANGLES,
    LEAST_TRIANGLES_OF_PLAYER, Shot, TriangleCount, alternative_meshes, flatten_driven,
    flatten_within, shown_clip, surfaces_shown_otherwise,
};

/// Converts, or runs a subcommand.
pub(crate) fn run(args: &FlattenArgs, console: &Console) -> anyhow::Result<()> {
    match &args.command {
        Some(FlattenCommand::Frame(args)) => frame::run(args, console),
        Some(FlattenCommand::Movie(args)) => moving::run(args, console),
        None => convert(&args.convert, console),
    }
}

fn convert(args: &ConvertArgs, console: &Console) -> anyhow::Result<()> {
    let profile = args.profile()?;
    args.check(profile)?;
    if profile == ProfileName::Impostor {
        return impostor::run(args, console);
    }
    console.files.plan(args.inputs(), [args.out()])?;
    if profile == ProfileName::Portrait {
        return portrait::run(args, console);
    }
    let mut opened = open::kept(&console.files, &args.character())?;
    let given = face::give(args, &mut opened, console)?;
    let (ways, faults) = match args.motion.root {
        RootName::Hold => opened.put_in_place(),
        RootName::Travel => Default::default(),
    };
    let figure = Figure::new(opened)?;
    let clip = match given.clip(args) {
        Some(name) => figure.clip(Some(name))?,
        None => shown_clip(&figure),
    };
    let is_held = clip.is_some_and(|clip| ways.get(clip).is_some_and(Option::is_some));
    let shot = args.shot(profile, clip);
    let framed = console.work(|work| FramedCharacter::new(&figure, shot, work))?;
    let settings = args.settings(profile, &framed)?;
    let options = args.prepare_options();
    let (framed, flat) = if args.special.live {
        let flat = console.work(|work| flatten_driven(&framed, options, &settings, work))?;
        (framed, flat)
    } else {
        console.work(|work| flatten_within(framed, &options, &settings, work))?
    };
    let out = files::shown(args.out());
    let mut report = FlattenReport::new(out, &flat, &framed, settings.max_bytes);
    if args.is_movie() {
        write_movie(args, &flat.bytes, &mut report, console)?;
    } else {
        console.files.write(args.out(), &flat.bytes)?;
    }
    report.warnings = report::warnings(&report);
    report
        .warnings
        .extend(open::warnings(figure.opened.warnings()));
    report.warnings.extend(surfaces_shown_otherwise(&figure));
    let asset = &figure.asset;
    let choices = alternative_meshes(&asset.rig, &asset.mesh);
    report.warnings.extend(choices.iter().map(report::choice));
    report.warnings.extend(faults);
    report.warnings.extend(given.warnings.iter().cloned());
    let motion = report::motion(&figure, clip, is_held) + &given.text();
    let report = given.with(report);
    console.result(&report, |told| report::text(&told.report) + &motion)
}

/// Writes the pictures of an animated SVG as a movie, and reports its size.
fn write_movie(
    args: &ConvertArgs,
    svg: &[u8],
    report: &mut FlattenReport,
    console: &Console,
) -> anyhow::Result<()> {
    let place = || files::shown(args.out());
    let moving = AnimatedSvg::read(&String::from_utf8_lossy(svg)).with_context(place)?;
    let pictures = moving::pictures(&moving, report.fps, [255; 4], &place(), console)?;
    let ending = files::extension(args.out());
    let bytes = moving::encoded(&ending, &pictures).with_context(place)?;
    let bytes = bytes.unwrap_or_default();
    console.files.write(args.out(), &bytes)?;
    // A movie is compressed already.
    let raw = bytes.len() as u64;
    let per = raw as f64 / (report.triangles_drawn * report.frames).max(1) as f64;
    report.bytes = FlatBytes {
        raw,
        gzip: raw,
        brotli: raw,
    };
    report.bytes_per_triangle_and_frame = BytesPerTriangle {
        raw: per,
        brotli: per,
    };
    report.representation.modality = format!("movie/{ending}");
    report.representation.bytes = raw;
    report.representation.needs = vec![];
    Ok(())
}

impl ConvertArgs {
    fn check(&self, profile: ProfileName) -> anyhow::Result<()> {
        use ProfileName as P;
        let (motion, shot) = (&self.motion, &self.shot);
        let (quality, special) = (&self.quality, &self.special);
        let keyed = [P::Smil, P::Flipbook, P::Lottie];
        let moving = [P::Smil, P::Flipbook, P::Lottie, P::Player, P::Thesis];
        let accuracy = quality.accuracy();
        let is_exact = quality.shading == Some(ShadingName::Exact);
        let ours = [P::Smil, P::Flipbook, P::Lottie, P::Player, P::Still];
        let vector = [moving.as_slice(), &[P::Still]].concat();
        let turned = motion.turn_deg != 0.0 || motion.cycles != 1;
        let travels = motion.root == RootName::Travel;
        let ours_and_impostor = [ours.as_slice(), &[P::Impostor]].concat();
        let sized = shot.size != (400, 400);
        let framed = [vector.as_slice(), &[P::Portrait]].concat();
        let aside = shot.yaw_deg != 0.0 || shot.pitch_deg != 0.0;
        // Whether each flag is given, its name, and the profiles that use it.
        for (is_given, flag, profiles) in [
            (is_exact, "--shading exact", &[P::Still][..]),
            (special.live, "--live", &[P::Player, P::Portrait]),
            (motion.motion.is_some(), "--motion", &framed),
            (self.shapes.asks(), "--face-shapes", &framed),
            (
                !special.background.is_empty(),
                "--background",
                &[P::Portrait],
            ),
            (special.audio.is_some(), "--audio", &[P::Portrait]),
            (special.views != 3, "--views", &[P::Portrait]),
            (special.form != FormName::Path, "--form", &[P::Thesis]),
            (motion.at != 0.0, "--at", &[P::Still, P::Thesis]),
            (turned, "--turn-deg or --cycles", &moving),
            (travels, "--root", &vector),
            (aside, "--yaw-deg or --pitch-deg", &vector),
            (
                quality.max_bytes.is_some(),
                "--max-bytes",
                &ours_and_impostor,
            ),
            (sized, "--size", &framed),
            (shot.triangles.is_some(), "--triangles", &framed),
            (
                accuracy.position_px.is_some(),
                "--quality position-px",
                &framed,
            ),
            (accuracy.colour_levels.is_some(), "--quality colour", &ours),
            (quality.shading.is_some(), "--shading", &ours),
            (accuracy.merge_levels.is_some(), "--quality merge", &keyed),
            (
                quality.texture != TextureName::Auto,
                "--texture",
                &[P::Player],
            ),
        ] {
            if is_given && !profiles.contains(&profile) {
                let what = "does not apply to this profile; see --help";
                return Err(fault::usage(format!("{flag} {what}")));
            }
        }
        if self.is_movie() && quality.max_bytes.is_some() {
            let what = "--max-bytes does not apply to a movie; lower --fps or --size";
            return Err(fault::usage(what));
        }
        if special.live && (turned || quality.max_bytes.is_some()) {
            let what =
                "--live plays the clip as it is; leave out --turn-deg, --cycles, --max-bytes";
            return Err(fault::usage(what));
        }
        if accuracy.merge_levels.is_some() && quality.shading != Some(ShadingName::Flat) {
            return Err(fault::usage("--quality merge needs --shading flat"));
        }
        Ok(())
    }

    fn shot(&self, profile: ProfileName, clip: Option<usize>) -> Shot {
        let least = match profile {
            ProfileName::Player => LEAST_TRIANGLES_OF_PLAYER,
            _ => LEAST_TRIANGLES,
        };
        let triangles = match self.shot.triangles {
            Some(count) => TriangleCount::About(count as usize),
            None => TriangleCount::Judged { least },
        };
        let is_gouraud_form =
            profile == ProfileName::Thesis && self.special.form == FormName::Gouraud;
        let is_still = profile == ProfileName::Still || is_gouraud_form;
        Shot {
            clip,
            still_at: is_still.then_some(self.motion.at),
            cycles: self.motion.cycles,
            fps: self.motion.fps,
            yaw_deg: self.shot.yaw_deg,
            pitch_deg: self.shot.pitch_deg,
            turn_deg: self.motion.turn_deg,
            seen_from: None,
            viewport: Viewport {
                width_px: self.shot.size.0 as f32,
                height_px: self.shot.size.1 as f32,
                fov_y_radians: self.shot.fov_deg.to_radians(),
            },
            triangles,
            shows_textures: profile == ProfileName::Player
                && self.quality.texture == TextureName::Auto
                && self.quality.shading != Some(ShadingName::Flat),
        }
    }

    fn prepare_options(&self) -> PrepareClipOptions {
        let accuracy = self.quality.accuracy();
        PrepareClipOptions {
            order: OrderOptions {
                order_tol: f64::from(accuracy.order_percent.unwrap_or(0.3)) / 100.0,
                ..OrderOptions::default()
            },
            split: (!accuracy.keeps_piercing).then(SplitOptions::default),
        }
    }

    fn settings(
        &self,
        profile: ProfileName,
        framed: &FramedCharacter<'_>,
    ) -> anyhow::Result<Settings> {
        let clip = framed.subject().clip;
        let clip_secs = clip.map_or(0.0, |c| f64::from(c.duration_secs()));
        let length = clip_secs * f64::from(self.motion.cycles);
        let at = f64::from(self.motion.at);
        if at > length {
            let what = format!("--at {at}: the motion ends at {length:.3} s");
            return Err(fault::usage(what));
        }
        let is_module = files::extension(self.out()) == "js";
        let profile = match profile {
            ProfileName::Smil | ProfileName::Portrait | ProfileName::Impostor => Profile::Smil,
            ProfileName::Flipbook => Profile::Flipbook,
            ProfileName::Player if is_module => Profile::Player(PlayerOutput::Module),
            ProfileName::Player => Profile::Player(PlayerOutput::Svg),
            ProfileName::Lottie => Profile::Lottie,
            ProfileName::Still => Profile::Still {
                frame: 0,
                exact: self.quality.shading == Some(ShadingName::Exact),
            },
            ProfileName::Thesis => Profile::Thesis(ThesisSvgOptions {
                form: match self.special.form {
                    FormName::Polygon | FormName::OptimisedPolygon => ThesisForm::Polygon,
                    FormName::Path | FormName::OptimisedPath => ThesisForm::Path,
                    FormName::Gouraud => ThesisForm::GouraudStill { frame: 0 },
                },
                optimise_hidden: self.special.form.is_optimised(),
                optimise_static: self.special.form.is_optimised(),
                neutral_frame: match self.special.form {
                    FormName::Gouraud => 0,
                    _ => (at * f64::from(framed.options.fps)).round() as usize,
                },
            }),
        };
        let mut quality = Quality::of(profile);
        let accuracy = self.quality.accuracy();
        quality.pos_tol_px = accuracy.position_px.unwrap_or(quality.pos_tol_px);
        quality.col_tol_levels = accuracy.colour_levels.unwrap_or(quality.col_tol_levels);
        quality.merge_levels = accuracy.merge_levels;
        if let Some(shading) = self.quality.shading {
            quality.shading = match shading {
                ShadingName::Flat => Shading::Flat,
                ShadingName::Gouraud | ShadingName::Exact => Shading::Gouraud,
            };
        }
        let name = clip.map(|c| c.name.clone());
        // The title is published with the file, so it must not contain the path of the source.
        let name = name.unwrap_or_else(|| self.title());
        Ok(Settings {
            profile,
            quality,
            name,
            max_bytes: self.quality.max_bytes,
        })
    }
}
