//! The arguments of `flatten`.

use crate::arguments::{CharacterArgs, ReadArgs, field_of_view, finite, not_negative, positive};
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
  articula flatten frame walk.svg walk.png --at 0.4
  articula flatten movie walk.svg walk.gif")]
pub(crate) struct FlattenArgs {
    #[command(subcommand)]
    pub(crate) command: Option<FlattenCommand>,
    #[command(flatten)]
    pub(crate) convert: ConvertArgs,
}

/// What else can be done with a converted file.
#[derive(Debug, Subcommand)]
pub(crate) enum FlattenCommand {
    /// Render one moment of an SVG that flatten wrote, as PNG or as still SVG
    Frame(FrameArgs),
    /// Render an SVG that flatten wrote as GIF, as animated WebP or as a folder of PNG pictures
    Movie(MovieArgs),
}

/// Arguments of the conversion.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    /// Character file (.glb, .gltf, .vrm, ...)
    #[arg(required = true)]
    file: Option<PathBuf>,
    /// File to write (.svg; .json for lottie; .html or .json for portrait; .js for a player module)
    #[arg(required = true)]
    out: Option<PathBuf>,
    /// Leave this mesh out (repeatable)
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Keep only this mesh (repeatable)
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Joint map of your own, used before the built-in ones (repeatable)
    #[arg(long, value_name = "F.json")]
    joint_map: Vec<PathBuf>,
    /// What to write [default: smil; lottie if OUT ends in .json, player if in .js, portrait if
    /// in .html]
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
}

/// Which motion is shown.
#[derive(Debug, Args)]
pub(crate) struct MotionArgs {
    /// Which clip to show [default: the first; the rest pose if there is none]
    #[arg(long, value_name = "NAME")]
    pub(crate) clip: Option<String>,
    /// Frames a second; a little more or less, so that the last frame falls on the clip's end
    #[arg(long, value_name = "HZ", default_value_t = 25.0, value_parser = positive)]
    pub(crate) fps: f32,
    /// How often the clip is played, one after the other
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) cycles: u32,
    /// Turn the character to its left, so far in all
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite,
          allow_negative_numbers = true)]
    pub(crate) turn_deg: f32,
    /// Moment of a still, seconds; of the thesis' painting order
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) at: f32,
}

/// From where it is shown.
#[derive(Debug, Args)]
pub(crate) struct ShotArgs {
    /// Size of the picture, pixels: one side or WxH
    #[arg(long, value_name = "PX|WxH", default_value = "400", value_parser = picture_size)]
    pub(crate) size: (u32, u32),
    /// Where the camera stands about the character's front, degrees to its left
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = finite,
          allow_negative_numbers = true)]
    pub(crate) yaw_deg: f32,
    /// How high it stands, degrees
    #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = elevation,
          allow_negative_numbers = true)]
    pub(crate) pitch_deg: f32,
    /// Vertical field of view, degrees
    #[arg(long, value_name = "DEG", default_value = "25", value_parser = field_of_view)]
    pub(crate) fov_deg: f32,
    /// Triangles that are shown, about; what is never seen is left out before [default: 600;
    /// player 1500, portrait 1000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=20_000))]
    pub(crate) triangles: Option<u32>,
}

/// How large, and how near to the truth.
#[derive(Debug, Args)]
pub(crate) struct QualityArgs {
    /// Largest file; the best setting that fits is searched
    #[arg(long, value_name = "B")]
    pub(crate) max_bytes: Option<u64>,
    /// How far a corner may lie off, pixels [default: 0.35; player 0.1]
    #[arg(long, value_name = "PX", value_parser = positive)]
    pub(crate) pos_tol: Option<f32>,
    /// How far a colour may lie off, levels of 255 [default: 6; player 1]
    #[arg(long, value_name = "LEVELS", value_parser = positive)]
    pub(crate) col_tol: Option<f32>,
    /// One colour a triangle, or a gradient [default: gouraud]
    #[arg(long, value_enum, value_name = "HOW")]
    pub(crate) shading: Option<ShadingName>,
    /// Join neighbouring triangles whose colours are within so many levels (flat shading)
    #[arg(long, value_name = "LEVELS", value_parser = positive)]
    pub(crate) merge: Option<f32>,
    /// Wrongly painted pixels that one painting order may have more than the best, percent of
    /// the character's
    #[arg(long, value_name = "PERCENT", default_value_t = 0.3, value_parser = not_negative)]
    pub(crate) order_tol: f32,
    /// Cut triangles that pierce each other, which no painting order shows right
    #[arg(long, value_enum, value_name = "ON|OFF", default_value = "on", num_args = 0..=1,
          default_missing_value = "on")]
    pub(crate) split: Switch,
}

/// What belongs to one profile.
#[derive(Debug, Args)]
pub(crate) struct SpecialArgs {
    /// still: three colour channels, exact inside
    #[arg(long)]
    pub(crate) exact: bool,
    /// player: driven by the character's morph targets instead of a clip
    #[arg(long)]
    pub(crate) live: bool,
    /// portrait: pictures of the head, 1, 3 or 5
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub(crate) views: u32,
    /// portrait: a picture behind the head
    #[arg(long, value_name = "PICTURE")]
    pub(crate) background: Option<PathBuf>,
    /// portrait: sound that the mouth follows
    #[arg(long, value_name = "FILE")]
    pub(crate) audio: Option<PathBuf>,
    /// thesis: elements that are written
    #[arg(long, value_enum, value_name = "FORM", default_value = "path")]
    pub(crate) form: FormName,
    /// thesis: leave out what is hidden or does not move, as it does
    #[arg(long)]
    pub(crate) optimise: bool,
}

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ProfileName {
    /// One SVG, key-framed, no script: pages, <img>, mail
    Smil,
    /// One SVG with a group a frame: short or violent clips, exactness
    Flipbook,
    /// One SVG with a low-rank clip and a small script: the smallest file
    Player,
    /// Lottie JSON, for app toolchains
    Lottie,
    /// A face as pictures on a 2D mesh that turns and speaks
    Portrait,
    /// One SVG frame
    Still,
    /// The naive SVG of the origin, to be measured against
    Thesis,
}

/// Whether something is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Switch {
    /// It is
    On,
    /// It is not
    Off,
}

/// How a triangle is filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShadingName {
    /// One colour
    Flat,
    /// A gradient
    Gouraud,
}

/// Elements of the thesis' SVG.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormName {
    /// A polygon a triangle and frame
    Polygon,
    /// A path a triangle with the positions of every frame
    Path,
}

/// Arguments of `flatten frame`.
#[derive(Debug, Args)]
pub(crate) struct FrameArgs {
    /// SVG that flatten wrote (smil, flipbook or still)
    pub(crate) file: PathBuf,
    /// File to write (.png or .svg)
    pub(crate) out: PathBuf,
    /// The moment, seconds
    #[arg(long, value_name = "SECS", default_value_t = 0.0, value_parser = not_negative)]
    pub(crate) at: f32,
    /// Colour behind the character [default: none]
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
    /// Frames a second
    #[arg(long, value_name = "HZ", default_value_t = 25.0, value_parser = positive)]
    pub(crate) fps: f32,
    /// Colour behind the character [default: white]
    #[arg(long, value_name = "#RRGGBB", value_parser = color)]
    pub(crate) background: Option<[u8; 4]>,
}

impl ConvertArgs {
    /// The file to write.
    pub(crate) fn out(&self) -> &Path {
        self.out.as_deref().unwrap_or(Path::new(""))
    }

    /// The file and what of it counts, as the other commands have it.
    pub(crate) fn character(&self) -> CharacterArgs {
        CharacterArgs {
            // Without one it was a subcommand, which does not ask.
            file: self.file.clone().unwrap_or_default(),
            hide: self.hide.clone(),
            only: self.only.clone(),
            names: ReadArgs {
                joint_map: self.joint_map.clone(),
                ..ReadArgs::default()
            },
        }
    }

    /// What a file is called that has no clip's name.
    pub(crate) fn title(&self) -> String {
        let file = self.file.as_deref().and_then(Path::file_stem);
        file.unwrap_or_default().to_string_lossy().into_owned()
    }

    /// What is written: what was said, or what the file's name says.
    pub(crate) fn profile(&self) -> anyhow::Result<ProfileName> {
        let ending = self
            .out()
            .extension()
            .unwrap_or_default()
            .to_ascii_lowercase();
        let ending = ending.to_string_lossy();
        let told = match ending.as_ref() {
            "json" => ProfileName::Lottie,
            "js" => ProfileName::Player,
            "html" => ProfileName::Portrait,
            _ => ProfileName::Smil,
        };
        let profile = self.profile.unwrap_or(told);
        let fits: &[&str] = match profile {
            ProfileName::Lottie => &["json"],
            ProfileName::Portrait => &["html", "json"],
            ProfileName::Player => &["svg", "js"],
            _ => &["svg"],
        };
        if fits.contains(&ending.as_ref()) {
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
    let angle = text.parse::<f32>().ok();
    let angle = angle.filter(|a| (-80.0..=80.0).contains(a));
    angle.ok_or_else(|| "expected an angle of -80 to 80 degrees".into())
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

#[cfg(test)]
mod tests {
    use super::*;

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
