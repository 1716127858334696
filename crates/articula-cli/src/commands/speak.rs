//! `articula speak VOICE.wav OUT`: a voice as the motion of a face.

use super::phones;
use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::{fault, files, open};
use anyhow::Context;
use articula::convert::{AfpProfile, ConvertOptions, write_data, write_faps};
use articula::face::FaceTransfer;
use articula::speech::{
    Sound, SpeechOptions, TimedPhone, Viseme, VisemeTrack, fit_speech, read_phone_times,
    speech_to_capture, speech_to_faps,
};
use articula::{Data, DataFormat, Format};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Largest recording and file of phones that are read.
const MAX_SOUND_BYTES: u64 = 1 << 30;
const MAX_TEXT_BYTES: u64 = 16 << 20;

/// Arguments of `speak`.
#[derive(Debug, Args)]
pub(crate) struct SpeakArgs {
    /// Recording of one voice (.wav)
    voice: PathBuf,
    /// File to write: a character that speaks (.glb, .vrm, with --onto), or the motion of a face alone
    /// (.fap, .afp, .csv of Live Link Face)
    out: PathBuf,
    /// Character whose face speaks: with blend shapes of ARKit, visemes, VRM vowels, a face animation
    /// table or joints; `convert --face-shapes` makes shapes for a face without
    #[arg(long, value_name = "HEAD")]
    onto: Option<PathBuf>,
    /// What is said; its phones are found in the recording, which is surer than listening alone
    /// (needs espeak-ng)
    #[arg(long, value_name = "TEXT", conflicts_with = "phones")]
    text: Option<String>,
    /// Language of --text, as espeak-ng names it
    #[arg(long, value_name = "VOICE", default_value = "en-us", requires = "text")]
    language: String,
    /// When each phone is spoken: a TextGrid, or lines of begin, end and phone
    #[arg(long, value_name = "FILE")]
    phones: Option<PathBuf>,
    /// Frames a second, 10 to 240
    #[arg(long, value_name = "HZ", default_value_t = SpeechOptions::default().rate_hz, value_parser = rate)]
    rate_hz: f32,
    /// Seed of blinks, brows and head
    #[arg(long, value_name = "N", default_value_t = SpeechOptions::default().seed)]
    seed: u64,
    /// Move the mouth alone: no blinks, brows and turns of the head
    #[arg(long)]
    mouth_only: bool,
    /// .fap, .afp: write the mouth as visemes (FAP 1), in fewer bytes
    #[arg(long)]
    visemes: bool,
    /// Keep the clips that the character has, beside the new one
    #[arg(long)]
    keep_clips: bool,
    #[command(flatten)]
    names: ReadArgs,
}

/// What was written.
#[derive(Debug, Serialize)]
struct Spoken {
    voice: String,
    out: String,
    duration_secs: f32,
    frames: usize,
    rate_hz: f32,
    /// Where the visemes come from: `sound`, `text` or `phones`.
    from: &'static str,
    /// Phones and pauses, if they are known.
    phones: usize,
    /// Share of the time of each viseme that is heard, percent.
    visemes_percent: Vec<(&'static str, f32)>,
    /// Times at which lips meet for p, b and m.
    closures: usize,
    bytes: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    face: Option<FaceTransfer>,
    warnings: Vec<String>,
}

fn rate(text: &str) -> Result<f32, String> {
    let rate: f32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (10.0..=240.0).contains(&rate) {
        return Ok(rate);
    }
    Err("expected 10 to 240".to_owned())
}

/// Reads the voice and writes what was asked for.
pub(crate) fn run(args: &SpeakArgs, console: &Console) -> anyhow::Result<()> {
    let target = target(args)?;
    let inputs = [&args.voice]
        .into_iter()
        .chain(&args.onto)
        .chain(&args.phones);
    let inputs = inputs.map(PathBuf::as_path).chain(args.names.inputs());
    console.files.plan(inputs, [args.out.as_path()])?;
    let place = files::shown(&args.voice);
    let sound = recording(&args.voice)?;
    let (track, phones) = heard(args, &sound, console)?;
    let options = SpeechOptions {
        rate_hz: args.rate_hz,
        gestures: !args.mouth_only,
        seed: args.seed,
        as_visemes: args.visemes,
    };
    let mut report = Spoken::of(args, &track, phones.as_deref());
    let stem = args.voice.file_stem().unwrap_or_default().to_string_lossy();
    let bytes = match target {
        Target::Character(format) => {
            on_character(args, format, &track, &options, &mut report, console)?
        }
        Target::Face(DataFormat::Csv) => {
            write_data(&Data::LiveLink(speech_to_capture(&track, &options)))?.bytes
        }
        Target::Face(format) => {
            let clip = speech_to_faps(&track, &stem, &options);
            write_faps(&clip, format, &AfpProfile::default())
                .with_context(|| place.clone())?
                .bytes
        }
    };
    report.bytes = bytes.len();
    console.files.write(&args.out, &bytes)?;
    console.result(&report, Spoken::text)
}

/// What is written.
enum Target {
    Character(Format),
    Face(DataFormat),
}

fn target(args: &SpeakArgs) -> anyhow::Result<Target> {
    let place = files::shown(&args.out);
    let usage = |what: &str| Err(fault::usage(format!("{place}: {what}")));
    let of_face = files::data_format(&args.out).filter(|f| f.animates_a_face());
    match (of_face, files::format(&args.out), &args.onto) {
        (Some(_), _, Some(_)) => usage("a face without a character is written without --onto"),
        (Some(format), _, None) => Ok(Target::Face(format)),
        (None, Some(format @ (Format::Glb | Format::Vrm)), Some(_)) => {
            Ok(Target::Character(format))
        }
        (None, Some(Format::Glb | Format::Vrm), None) => {
            usage("give the character that speaks: --onto HEAD.glb")
        }
        _ => usage("a voice is written as .glb or .vrm with --onto, or as .fap, .afp or .csv"),
    }
}

/// The visemes of the recording, and its phones if they are known.
fn heard(
    args: &SpeakArgs,
    sound: &Sound,
    console: &Console,
) -> anyhow::Result<(VisemeTrack, Option<Vec<TimedPhone>>)> {
    if let Some(path) = &args.phones {
        let bytes = files::read(path, MAX_TEXT_BYTES)?;
        let phones = read_phone_times(&bytes).with_context(|| files::shown(path))?;
        return Ok((VisemeTrack::of_phones(&phones, sound), Some(phones)));
    }
    let track = recognised(sound, console);
    let Some(text) = &args.text else {
        return Ok((track, None));
    };
    let symbols = phones::of_text(text, &args.language)?;
    let phones = articula::speech::align(&track, &symbols).context("--text")?;
    Ok((VisemeTrack::of_phones(&phones, sound), Some(phones)))
}

/// Reads a recording.
pub(super) fn recording(path: &Path) -> anyhow::Result<Sound> {
    let bytes = files::read(path, MAX_SOUND_BYTES)?;
    Sound::from_wav(&bytes).with_context(|| files::shown(path))
}

/// The visemes that are heard in a recording.
pub(super) fn recognised(sound: &Sound, console: &Console) -> VisemeTrack {
    let bar = console.progress("listening", 1);
    let track = VisemeTrack::recognised(sound);
    bar.finish_and_clear();
    track
}

/// The character with the new clip, as a file.
fn on_character(
    args: &SpeakArgs,
    format: Format,
    track: &VisemeTrack,
    options: &SpeechOptions,
    report: &mut Spoken,
    console: &Console,
) -> anyhow::Result<Vec<u8>> {
    let head = args.onto.as_deref().unwrap_or(Path::new(""));
    let mut opened = open::character(&console.files, head, &args.names)?;
    report.warnings = open::warnings(opened.warnings());
    let voice = files::shown(&args.voice);
    let fitted = fit_speech(track, &voice, &opened, options)?;
    report.face = Some(fitted.report);
    opened.put_clips(vec![fitted.fitted], args.keep_clips);
    let made =
        console.work(|work| articula::convert(opened, format, &ConvertOptions::default(), work))?;
    Ok(made.written.bytes)
}

impl Spoken {
    fn of(args: &SpeakArgs, track: &VisemeTrack, phones: Option<&[TimedPhone]>) -> Self {
        let frames = track.frames.len();
        let strongest: Vec<Viseme> = track.frames.iter().map(|f| f.strongest()).collect();
        let share = |viseme: &Viseme| {
            let count = strongest.iter().filter(|s| *s == viseme).count();
            100.0 * count as f32 / frames.max(1) as f32
        };
        let heard = Viseme::ALL.iter().map(|v| (v.name(), share(v)));
        let closed = |viseme: &Viseme| *viseme == Viseme::Pp;
        let closures = strongest
            .windows(2)
            .filter(|w| closed(&w[1]) && !closed(&w[0]));
        Self {
            voice: files::shown(&args.voice),
            out: files::shown(&args.out),
            duration_secs: track.duration_secs(),
            frames: (track.duration_secs() * args.rate_hz.round()) as usize + 1,
            rate_hz: args.rate_hz.round(),
            from: match (&args.text, &args.phones) {
                (Some(_), _) => "text",
                (_, Some(_)) => "phones",
                _ => "sound",
            },
            phones: phones.map_or(0, <[TimedPhone]>::len),
            visemes_percent: heard.filter(|(_, percent)| *percent > 0.0).collect(),
            closures: closures.count() + usize::from(strongest.first().is_some_and(closed)),
            bytes: 0,
            face: None,
            warnings: Vec::new(),
        }
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}: {:.2} s, {} frames at {} Hz from {}",
            self.out, self.duration_secs, self.frames, self.rate_hz, self.from
        );
        if self.phones > 0 {
            text.push_str(&format!(" ({} phones and pauses)", self.phones));
        }
        text.push_str(&format!("; {:.1} kB\n", self.bytes as f64 / 1e3));
        let mut visemes: Vec<_> = self.visemes_percent.iter().collect();
        visemes.sort_by(|a, b| b.1.total_cmp(&a.1));
        let visemes = visemes
            .iter()
            .map(|(name, percent)| format!("{name} {percent:.0} %"));
        let visemes: Vec<String> = visemes.collect();
        text.push_str(&format!(
            "  visemes: {}; lips meet {} times\n",
            visemes.join(", "),
            self.closures
        ));
        if let Some(face) = &self.face {
            text.push_str(&format!(
                "  face: {} of {} controls move, {} joints turn\n",
                face.controls_moved,
                face.controls,
                face.joints.len()
            ));
            if !face.not_driven.is_empty() {
                let faps = face.not_driven.iter().map(|n| n.name);
                let faps: Vec<&str> = faps.collect();
                text.push_str(&format!("  not driven: {}\n", faps.join(", ")));
            }
        }
        for warning in &self.warnings {
            text.push_str(&format!("  warning: {warning}\n"));
        }
        text
    }
}
