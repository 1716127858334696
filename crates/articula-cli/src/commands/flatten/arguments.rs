//! The arguments of `flatten`.

use crate::arguments::{
    CharacterArgs, ReadArgs, field_of_view, finite, not_negative, number, positive, settings, word,
};
use crate::commands::face_shapes::FaceShapeArgs;
use crate::fault;
use clap::{Args, Subcommand, ValueEnum};
use std::path::{Path, PathBuf};

/// Arguments of `flatten`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(after_help = "\
Examples:
  articula flatten knight.glb walk.svg --clip Walking_A
  articula flatten knight.glb turn.svg --clip Walking_A --turn-deg 360 --profile player
  articula flatten head.glb head.json --clip talk --profile lottie --max-bytes 400000
  articula flatten head.glb head.html --motion talk.fap
  articula flatten knight.glb pose.svg --profile thesis --form gouraud --at 0.4
  articula flatten knight.glb knight.png --profile impostor --max-bytes 2000000
  articula flatten knight.glb walk.webp --clip Walking_A
  articula flatten frame walk.svg walk.png --at 0.4
  articula flatten movie walk.svg walk.gif")]
pub(crate) struct FlattenArgs {
    #[command(subcommand)]
    pub(crate) command: Option<FlattenCommand>,
    #[command(flatten)]
    pub(crate) convert: ConvertArgs,
}

/// Subcommands on an SVG that `flatten` wrote.
#[derive(Debug, Subcommand)]
pub(crate) enum FlattenCommand {
    /// Render one frame of an SVG that flatten wrote, as PNG or as a still SVG
    Frame(FrameArgs),
    /// Render an SVG that flatten wrote as GIF, animated WebP or a folder of PNG pictures
    Movie(MovieArgs),
}

/// Arguments of a conversion to 2D.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Character file (.glb, .gltf, .vrm, ...)
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// File to write (.svg; .json for lottie; .html or .json for portrait; .js for a player module;
    /// .png for impostor; .gif or .webp for a movie of smil or flipbook)
    #[arg(required = true)]
    out: Option<PathBuf>,
    /// Name of a mesh to leave out (repeatable)
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Name of a mesh to keep, leaving out all others (repeatable)
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Kind of 2D content [default: lottie if OUT ends in .json, player if in .js, portrait if in
    /// .html, impostor if in .png, else smil]
    #[arg(long, value_enum, value_name = "PROFILE")]
    pub(crate) profile: Option<ProfileName>,
    #[command(flatten)]
    pub(crate) motion: MotionArgs,
    #[command(flatten)]
    pub(crate) shot: ShotArgs,
    #[command(flatten)]
    pub(crate) quality: QualityArgs,
    #[command(flatten)]
    pub(crate) special: SpecialArgs,
    #[command(flatten)]
    pub(crate) shapes: FaceShapeArgs,
    #[command(flatten)]
    pub(crate) names: ReadArgs,
}

/// The motion to show.
#[derive(Debug, Args)]
pub(crate) struct MotionArgs {
    /// Name of the clip to show [default: the first that walks, else runs, else idles, else the first,
    /// portrait the first, impostor all; the rest pose if there is none]
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Motion of the face to show instead of a clip: facial animation parameters (.fap, .afp, .fba), a
    /// capture of Live Link Face (.csv) or a recorded voice (.wav)
    #[arg(long, value_name = "FILE", conflicts_with = "clip")]
    pub(crate) motion: Option<PathBuf>,
    /// Whether a clip that travels is shown on the spot
    #[arg(long, value_enum, value_name = "HOW", default_value_t = RootName::Hold)]
    pub(crate) root: RootName,
    /// Frame rate in hertz; adjusted slightly so that the last frame falls on the end of the clip
    #[arg(long, value_name = "HZ", default_value_t = 25.0, value_parser = positive)]
    pub(crate) fps: f32,
    /// Number of times the clip is played
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) cycles: u32,
    /// Total turn of the character to its left over the motion in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite,
          allow_negative_numbers = true)]
    pub(crate) turn_deg: f32,
    /// Time of a still or of the thesis' Gouraud form, or of the painting order of the thesis' other
    /// forms, in seconds
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) at: f32,
}

/// Treatment of a clip that travels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum RootName {
    /// On the spot, as large as the picture allows
    Hold,
    /// Through the picture, which the whole way fits into
    Travel,
}

/// Camera and picture size.
#[derive(Debug, Args)]
pub(crate) struct ShotArgs {
    /// Size of the picture in pixels: one side or WxH
    #[arg(long, value_name = "PX|WxH", default_value = "400", value_parser = picture_size)]
    pub(crate) size: (u32, u32),
    /// Azimuth of the camera from the character's front, to its left, in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite,
          allow_negative_numbers = true)]
    pub(crate) yaw_deg: f32,
    /// Elevation of the camera in degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = elevation,
          allow_negative_numbers = true)]
    pub(crate) pitch_deg: f32,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value = "25", value_parser = field_of_view)]
    pub(crate) fov_deg: f32,
    /// Approximate number of triangles after removing those that are never visible [default: 600,
    /// player 1500, or up to four times as many if face, hands or body differ visibly; portrait
    /// 1000, or up to 3000 if its front differs by more than 12 levels of 255]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=20_000))]
    pub(crate) triangles: Option<u32>,
}

/// File size and accuracy.
#[derive(Debug, Args)]
pub(crate) struct QualityArgs {
    /// Maximum size of the output in bytes; the best setting that fits is searched; if none fits,
    /// the smallest file is written, with a warning. impostor: of the pixels, four bytes each
    /// [default: 4194304]
    #[arg(long, value_name = "B")]
    pub(crate) max_bytes: Option<u64>,
    /// Accuracy: position-px=PX, the error of a corner [default: 0.5; player 0.1]; colour=LEVELS, the
    /// error of a colour in levels of 0 to 255 [default: 8; player 1]; merge=LEVELS, by which the colours
    /// of neighbouring triangles differ that are joined (flat shading); order-percent=PERCENT of the
    /// character's pixels that one painting order may paint wrongly above the minimum [default: 0.3];
    /// split=off, not to cut triangles that pierce each other, which no painting order shows correctly
    #[arg(long, value_name = "KEY=VALUE,…", value_parser = accuracy)]
    quality: Option<Accuracy>,
    /// Shading of a triangle [default: gouraud]
    #[arg(long, value_enum, value_name = "HOW")]
    pub(crate) shading: Option<ShadingName>,
    /// player: whether triangles show a picture where the colours of their corners do not show their
    /// texture
    #[arg(long, value_enum, value_name = "WHETHER", default_value_t = TextureName::Auto)]
    pub(crate) texture: TextureName,
}

/// Whether triangles show pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TextureName {
    /// Where a texture has detail
    Auto,
    /// Nowhere
    None,
}

/// Accuracy of a file, as far as it is given.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Accuracy {
    pub(crate) position_px: Option<f32>,
    pub(crate) colour_levels: Option<f32>,
    pub(crate) merge_levels: Option<f32>,
    pub(crate) order_percent: Option<f32>,
    /// Whether triangles that pierce each other are not cut.
    pub(crate) keeps_piercing: bool,
}

fn accuracy(text: &str) -> Result<Accuracy, String> {
    settings(text, |to: &mut Accuracy, key, value| {
        match key {
            "position-px" => to.position_px = Some(positive(value)?),
            "colour" => to.colour_levels = Some(positive(value)?),
            "merge" => to.merge_levels = Some(positive(value)?),
            "order-percent" => to.order_percent = Some(not_negative(value)?),
            "split" => to.keeps_piercing = word(value, &[("on", false), ("off", true)])?,
            _ => return Ok(Some("position-px, colour, merge, order-percent, split")),
        }
        Ok(None)
    })
}

impl QualityArgs {
    /// The accuracy, with defaults for what is not given.
    pub(crate) fn accuracy(&self) -> Accuracy {
        self.quality.unwrap_or_default()
    }
}

/// Options of single profiles.
#[derive(Debug, Args)]
pub(crate) struct SpecialArgs {
    /// player: animate by the character's morph targets instead of a clip; portrait: drive it by facial
    /// animation parameters, blend shapes of ARKit and visemes too, by a table made for this face
    #[arg(long)]
    pub(crate) live: bool,
    /// portrait: number of pictures of the head, 1, 3 or 5
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) views: u32,
    /// portrait: picture behind the head; given several times, a slide-show in step with the clip, each from a
    /// second of it (or, without seconds, all for the same time)
    #[arg(long, value_name = "PICTURE[@SECONDS]", value_parser = slide)]
    pub(crate) background: Vec<SlideFile>,
    /// portrait: sound file to play in sync with the mouth
    #[arg(long, value_name = "FILE")]
    pub(crate) audio: Option<PathBuf>,
    /// portrait: leave a head without teeth and tongue as it is, in place of default ones
    #[arg(long)]
    pub(crate) no_default_mouth: bool,
    /// thesis: SVG elements to write
    #[arg(long, value_enum, value_name = "FORM", default_value = "path")]
    pub(crate) form: FormName,
}

/// A picture behind a portrait, and the second of the clip from which it is shown.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SlideFile {
    pub(crate) path: PathBuf,
    pub(crate) from_secs: Option<f64>,
}

/// Kind of 2D content.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProfileName {
    /// One SVG, key-framed, no script: for web pages, <img>, e-mail
    Smil,
    /// One SVG with a group per frame: for short or fast clips, exact in every frame
    Flipbook,
    /// One SVG with a low-rank clip and a small script: smallest file
    Player,
    /// Lottie JSON, for application toolchains
    Lottie,
    /// A face as pictures on a 2D mesh that turns and speaks
    Portrait,
    /// One SVG frame
    Still,
    /// A picture of small views of every pose, and a JSON table beside it, for who is far away
    Impostor,
    /// The simple SVG form of the thesis, for comparison
    Thesis,
}

/// Fill of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShadingName {
    /// One colour
    Flat,
    /// A gradient
    Gouraud,
    /// Three colour channels, which reproduce the colours inside triangles exactly (still)
    Exact,
}

/// SVG elements of the thesis' form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormName {
    /// One polygon per triangle and frame
    Polygon,
    /// One path per triangle with the positions of all frames
    Path,
    /// As polygon, without triangles that are hidden or do not move, as the thesis has it
    OptimisedPolygon,
    /// As path, without triangles that are hidden or do not move
    OptimisedPath,
    /// The frame at --at, with three gradients per triangle
    Gouraud,
}

impl FormName {
    /// Whether triangles that are hidden or do not move are left out.
    pub(crate) fn is_optimised(self) -> bool {
        matches!(self, Self::OptimisedPolygon | Self::OptimisedPath)
    }
}

/// Arguments of `flatten frame`.
#[derive(Debug, Args)]
pub(crate) struct FrameArgs {
    /// SVG that flatten wrote (smil, flipbook or still)
    pub(crate) file: PathBuf,
    /// File to write (.png or .svg)
    pub(crate) out: PathBuf,
    /// Time of the frame in seconds
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) at: f32,
    /// Background colour [default: transparent]
    #[arg(long, value_name = "#RRGGBB", value_parser = color)]
    pub(crate) background: Option<[u8; 4]>,
}

/// Arguments of `flatten movie`.
#[derive(Debug, Args)]
pub(crate) struct MovieArgs {
    /// SVG that flatten wrote (smil or flipbook)
    pub(crate) file: PathBuf,
    /// File to write (.gif or .webp), or a folder for PNG pictures
    pub(crate) out: PathBuf,
    /// Frame rate in hertz
    #[arg(long, value_name = "HZ", default_value_t = 25.0, value_parser = positive)]
    pub(crate) fps: f32,
    /// Background colour [default: white]
    #[arg(long, value_name = "#RRGGBB", value_parser = color)]
    pub(crate) background: Option<[u8; 4]>,
}

impl ConvertArgs {
    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let slides = self.special.background.iter().map(|s| &s.path);
        let special = slides.chain(&self.special.audio);
        let faces = self.motion.motion.iter().chain(self.shapes.input());
        let all = self.file.iter().chain(special).chain(faces);
        all.map(PathBuf::as_path).chain(self.names.inputs())
    }

    /// The file to write.
    pub(crate) fn out(&self) -> &Path {
        self.out.as_deref().unwrap_or(Path::new(""))
    }

    /// Whether the output is a movie, whose frames are drawn from an animated SVG.
    pub(crate) fn is_movie(&self) -> bool {
        ["gif", "webp"].contains(&crate::files::extension(self.out()).as_str())
    }

    /// The character arguments that the other commands use.
    pub(crate) fn character(&self) -> CharacterArgs {
        CharacterArgs {
            // Without a file there was a subcommand, which does not use this.
            file: self.file.clone().unwrap_or_default(),
            hide: self.hide.clone(),
            only: self.only.clone(),
            names: self.names.clone(),
        }
    }

    /// Title of a file whose clip has no name.
    pub(crate) fn title(&self) -> String {
        let file = self.file.as_deref().and_then(Path::file_stem);
        file.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// The profile that was named, or that of the extension of the output.
    pub(crate) fn profile(&self) -> anyhow::Result<ProfileName> {
        let ending = crate::files::extension(self.out());
        let told = match ending.as_str() {
            "svg" | "gif" | "webp" => Some(ProfileName::Smil),
            "json" => Some(ProfileName::Lottie),
            "js" => Some(ProfileName::Player),
            "html" => Some(ProfileName::Portrait),
            "png" => Some(ProfileName::Impostor),
            _ => None,
        };
        let profile = self.profile.or(told);
        let fits: &[&str] = match profile {
            None => &["svg", "json", "html", "js", "png", "gif", "webp"],
            Some(ProfileName::Smil | ProfileName::Flipbook) => &["svg", "gif", "webp"],
            Some(ProfileName::Lottie) => &["json"],
            Some(ProfileName::Portrait) => &["html", "json"],
            Some(ProfileName::Player) => &["svg", "js"],
            Some(ProfileName::Impostor) => &["png"],
            Some(_) => &["svg"],
        };
        if let Some(profile) = profile
            && fits.contains(&ending.as_str())
        {
            return Ok(profile);
        }
        let out = crate::files::shown(self.out());
        let fits = fits.join(" or .");
        Err(fault::usage(format!("{out}: name the file .{fits}")))
    }
}

fn picture_size(text: &str) -> Result<(u32, u32), String> {
    let side = |t: &str| {
        let number = t.trim().parse::<u32>().ok();
        number.filter(|n| (16..=4096).contains(n))
    };
    let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
    side(width)
        .zip(side(height))
        .ok_or_else(|| "expected 16 to 4096 pixels, such as 400 or 320x480".into())
}

fn elevation(text: &str) -> Result<f32, String> {
    number(
        text,
        |a| (-80.0..=80.0).contains(&a),
        "an angle of -80 to 80 degrees",
    )
}

fn color(text: &str) -> Result<[u8; 4], String> {
    let digits = text.strip_prefix('#').unwrap_or(text);
    let number = u32::from_str_radix(digits, 16).ok();
    let is_plain = digits.len() == 6 && digits.bytes().all(|b| b.is_ascii_hexdigit());
    match number.filter(|_| is_plain) {
        Some(n) => Ok([(n >> 16) as u8, (n >> 8) as u8, n as u8, 255]),
        None => Err("expected a colour such as #ffffff".into()),
    }
}

/// A path, which may have an `@` of its own, and the seconds after the last one.
fn slide(text: &str) -> Result<SlideFile, String> {
    let timed = text.rsplit_once('@').and_then(|(path, secs)| {
        let secs: f64 = secs.parse().ok()?;
        (!path.is_empty()).then_some((path, secs))
    });
    let Some((path, secs)) = timed else {
        let path = PathBuf::from(text);
        return Ok(SlideFile {
            path,
            from_secs: None,
        });
    };
    if !(0.0..=86_400.0).contains(&secs) {
        return Err("expected seconds of the clip from 0, as in park.jpg@2.5".into());
    }
    Ok(SlideFile {
        path: path.into(),
        from_secs: Some(secs),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_a_slide_show_begin_at_seconds() {
        let of = |path: &str, from_secs| SlideFile {
            path: path.into(),
            from_secs,
        };
        assert_eq!(slide("a.png"), Ok(of("a.png", None)));
        assert_eq!(slide("a@2x.png"), Ok(of("a@2x.png", None)));
        assert_eq!(slide("a@2x.png@0.5"), Ok(of("a@2x.png", Some(0.5))));
        for wrong in ["a.png@-1", "a.png@inf", "a.png@nan"] {
            assert!(slide(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sizes_and_colours_are_bounded() {
        assert_eq!(picture_size("400"), Ok((400, 400)));
        assert_eq!(picture_size("320x480"), Ok((320, 480)));
        for bad in ["", "15", "4097", "400x", "x", "-4"] {
            assert!(picture_size(bad).is_err(), "{bad}");
        }
        assert_eq!(color("#ff8000"), Ok([255, 128, 0, 255]));
        assert!(color("#ff80").is_err() && color("red").is_err() && color("+12345").is_err());
    }
}
