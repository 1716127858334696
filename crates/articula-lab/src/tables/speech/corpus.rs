//! Synthetic speech with the exact times of its phones: espeak-ng, in many voices and languages, and flite.

use super::super::random::Random;
use super::text::sentence;
use anyhow::{Context, Result, bail, ensure};
use articula_speech::training::{Segment, segments};
use articula_speech::{Sound, TimedPhone, Viseme, phones_of_ipa};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Speaks by the library of espeak-ng, which tells times to the sample; its program does not.
const ESPEAK: &str = include_str!("espeak.py");
/// Sound below this is the closure of a stop, in full scale.
const CLOSED: f32 = 0.002;
/// Longest closure that is taken from the phone before a stop, and from a pause, in seconds.
const CLOSURES_SECS: [f32; 2] = [0.15, 0.06];
/// Clips that one process speaks.
const CHUNK: usize = 40;

/// Languages of the training; those named more than once are taken more often.
#[rustfmt::skip]
const LANGUAGES: [&str; 29] = [
    "en-us", "en-us", "en-us", "en-us", "en-us", "en", "en", "en", "en-gb-scotland", "en-gb-x-rp", "en-029", "de",
    "de", "fr", "es", "es", "it", "pt-br", "nl", "pl", "sv", "fi", "cs", "hu", "ro", "da", "tr", "nb", "ca",
];
/// Voices of the training; the empty one is the language's own.
#[rustfmt::skip]
const VOICES: [&str; 47] = [
    "", "", "m1", "m2", "m3", "m4", "m5", "m6", "m7", "f1", "f2", "f3", "f4", "f5", "klatt", "klatt2", "klatt3",
    "klatt4", "klatt6", "adam", "Alex", "Andy", "Annie", "belinda", "david", "edward", "Gene", "Lee", "linda",
    "Mario", "max", "Michael", "Mike", "paul", "quincy", "rob", "robert", "steph", "steph2", "anika", "grandma",
    "norbert", "shelby", "travis", "victor", "whisper", "croak",
];
/// Voices that no training hears.
const OTHER_VOICES: [&str; 9] = [
    "Andrea", "benjamin", "Denis", "Marco", "zac", "steph3", "sandro", "grandpa", "ed",
];
const ENGLISH: [&str; 2] = ["en-us", "en"];

/// What a training hears.
pub(super) const TRAINING: Synthesiser = Synthesiser::Espeak {
    languages: &LANGUAGES,
    voices: &VOICES,
};
/// The same of flite, whose voices are made of recordings of people.
pub(super) const FLITE_TRAINING: Synthesiser = Synthesiser::Flite {
    voices: &["rms", "awb", "kal16"],
};
pub(super) const NEW_TEXT: Synthesiser = Synthesiser::Espeak {
    languages: &ENGLISH,
    voices: &VOICES,
};
pub(super) const NEW_VOICES: Synthesiser = Synthesiser::Espeak {
    languages: &ENGLISH,
    voices: &OTHER_VOICES,
};
pub(super) const NEW_LANGUAGES: Synthesiser = Synthesiser::Espeak {
    languages: &["ru", "pt", "el", "hr", "sk"],
    voices: &OTHER_VOICES,
};
pub(super) const NEW_FLITE: Synthesiser = Synthesiser::Flite { voices: &["slt"] };

/// A spoken sentence.
pub(super) struct Clip {
    pub(super) sound: Sound,
    pub(super) segments: Vec<Segment>,
    /// Its phones, in the IPA.
    pub(super) phones: Vec<TimedPhone>,
}

/// What speaks.
#[derive(Clone, Copy)]
pub(super) enum Synthesiser {
    Espeak {
        languages: &'static [&'static str],
        voices: &'static [&'static str],
    },
    Flite {
        voices: &'static [&'static str],
    },
}

/// Clips by a seed, the same ones on any number of threads. Every tenth chunk is told, since thousands take
/// minutes.
pub(super) fn spoken(by: Synthesiser, count: usize, seed: u64) -> Result<Vec<Clip>> {
    let chunks: Vec<usize> = (0..count).step_by(CHUNK).collect();
    let done = AtomicUsize::new(0);
    let chunks = chunks.par_iter().map(|first| {
        let mut random = Random(seed << 32 | *first as u64);
        let of_chunk = CHUNK.min(count - first);
        let clips = match by {
            Synthesiser::Espeak { languages, voices } => {
                espeak(&mut random, of_chunk, languages, voices)?
            }
            Synthesiser::Flite { voices } => flite(&mut random, of_chunk, voices)?,
        };
        let chunk = done.fetch_add(1, Ordering::Relaxed) + 1;
        if chunk.is_multiple_of(10) {
            eprintln!("{} of {count} sentences spoken", CHUNK * chunk);
        }
        Ok(clips)
    });
    let chunks: Vec<Vec<Clip>> = chunks.collect::<Result<_>>()?;
    Ok(chunks.into_iter().flatten().collect())
}

/// What is not installed of what the corpora need; `None` if all is.
pub(super) fn missing() -> Option<String> {
    let runs = |program: &str, words: &[&str]| {
        let output = Command::new(program).args(words).output();
        output.is_ok_and(|output| output.status.success())
    };
    let espeak = ["-c", "import ctypes; ctypes.CDLL('libespeak-ng.so.1')"];
    if !runs("python3", &espeak) {
        return Some("python3 with the library of espeak-ng".into());
    }
    (!runs("flite", &["-lv"])).then(|| "flite".into())
}

/// What speaks, with its version, for the note beside weights.
pub(super) fn versions() -> Vec<String> {
    let programs = [
        ("espeak-ng", "text-to-speech: "),
        ("flite", "version: flite-"),
    ];
    let version = |(program, before): (&str, &str)| {
        let output = Command::new(program).arg("--version").output().ok()?;
        let printed = String::from_utf8_lossy(&output.stdout).into_owned();
        let (_, version) = printed.split_once(before)?;
        Some(format!("{program} {}", version.split_whitespace().next()?))
    };
    programs.into_iter().filter_map(version).collect()
}

#[derive(Serialize)]
struct Request {
    voice: String,
    rate: usize,
    pitch: usize,
    range: usize,
    text: String,
}

#[derive(Deserialize)]
struct Answer {
    rate_hz: u32,
    samples: usize,
    phones: Vec<(i64, String)>,
}

fn espeak(
    random: &mut Random,
    count: usize,
    languages: &[&str],
    voices: &[&str],
) -> Result<Vec<Clip>> {
    let mut speaker = Espeak::start()?;
    let mut clips = Vec::new();
    while clips.len() < count {
        let (language, voice) = (*random.one(languages), *random.one(voices));
        let plus = if voice.is_empty() { "" } else { "+" };
        let words = random.within(5, 12);
        let request = Request {
            voice: format!("{language}{plus}{voice}"),
            rate: random.within(110, 240),
            pitch: random.within(15, 85),
            range: random.within(20, 90),
            text: sentence(random, words),
        };
        let clip = speaker.say(&request)?;
        ensure!(clip.is_some(), "espeak-ng has no voice {}", request.voice);
        clips.extend(clip.filter(|clip| clip.sound.duration_secs() >= 1.0));
    }
    Ok(clips)
}

/// A process that speaks.
struct Espeak {
    child: Child,
    answers: BufReader<ChildStdout>,
}

impl Drop for Espeak {
    fn drop(&mut self) {
        drop(self.child.stdin.take());
        // It ends with its input; how, changes nothing any more.
        let _ = self.child.wait();
    }
}

impl Espeak {
    fn start() -> Result<Self> {
        let mut child = Command::new("python3")
            .args(["-c", ESPEAK])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .context("python3")?;
        let answers = child.stdout.take().context("python3 has no output")?;
        Ok(Self {
            child,
            answers: BufReader::new(answers),
        })
    }

    /// The clip of a text; `None` if there is no such voice.
    fn say(&mut self, request: &Request) -> Result<Option<Clip>> {
        let input = self.child.stdin.as_mut().context("python3 has no input")?;
        serde_json::to_writer(&mut *input, request)?;
        input.write_all(b"\n")?;
        input.flush()?;
        let mut head = String::new();
        if self.answers.read_line(&mut head)? == 0 {
            bail!("python3 with the library of espeak-ng ended early");
        }
        let answer: Answer = serde_json::from_str(&head)?;
        let mut bytes = vec![0; 2 * answer.samples];
        self.answers.read_exact(&mut bytes)?;
        let (samples, _) = bytes.as_chunks::<2>();
        let samples = samples
            .iter()
            .map(|b| f32::from(i16::from_le_bytes(*b)) / 32_768.0);
        let samples: Vec<f32> = samples.collect();
        if samples.is_empty() {
            return Ok(None);
        }
        let mut phones = timed(&answer, samples.len());
        close_stops(&mut phones, &samples, answer.rate_hz);
        Ok(Some(Clip {
            sound: Sound::new(&samples, answer.rate_hz),
            segments: segments(&phones),
            phones,
        }))
    }
}

/// The phones with their ends; marks that are no sounds belong to the phone before them.
fn timed(answer: &Answer, samples: usize) -> Vec<TimedPhone> {
    let secs = |sample: i64| sample as f32 / answer.rate_hz as f32;
    let ends = answer.phones.iter().skip(1).map(|(sample, _)| *sample);
    let mut phones: Vec<TimedPhone> = Vec::new();
    for ((start, symbol), end) in answer.phones.iter().zip(ends.chain([samples as i64])) {
        let symbol = symbol.trim_start_matches(['_', ':', '!', '|', 'ˈ', 'ˌ']);
        let is_sound = symbol.is_empty() || phones_of_ipa(symbol).is_some();
        match phones.last_mut() {
            Some(last) if !is_sound => last.end_secs = secs(end),
            _ if end > *start => phones.push(TimedPhone {
                start_secs: secs(*start),
                end_secs: secs(end),
                symbol: symbol.to_owned(),
            }),
            _ => {}
        }
    }
    phones
}

/// Gives stops their closures, which espeak-ng counts to what is before them.
fn close_stops(phones: &mut [TimedPhone], samples: &[f32], rate_hz: u32) {
    for at in 1..phones.len() {
        if !phones[at]
            .symbol
            .starts_with(['p', 't', 'k', 'b', 'd', 'ɡ', 'q', 'c', 'ʈ', 'ɖ'])
        {
            continue;
        }
        let before = &phones[at - 1];
        let [start, end] = [before.start_secs, before.end_secs];
        let closure = if before.symbol.is_empty() {
            CLOSURES_SECS[1].min((end - start) / 2.0)
        } else {
            let index = |secs: f32| ((secs * rate_hz as f32) as usize).min(samples.len());
            let sound = &samples[index(start)..index(end)];
            let silent = sound.iter().rev().take_while(|s| s.abs() <= CLOSED).count();
            let whole = silent == sound.len();
            if whole {
                0.0
            } else {
                (silent as f32 / rate_hz as f32).min(CLOSURES_SECS[0])
            }
        };
        phones[at - 1].end_secs -= closure;
        phones[at].start_secs -= closure;
    }
}

fn flite(random: &mut Random, count: usize, voices: &[&str]) -> Result<Vec<Clip>> {
    let folder = tempfile::tempdir()?;
    let wav = folder.path().join("spoken.wav");
    let mut clips = Vec::new();
    for _ in 0..count {
        let words = random.within(6, 12);
        let stretch = 0.8 + 0.5 * random.unit();
        let output = Command::new("flite")
            .args(["-voice", *random.one(voices), "-psdur"])
            .args(["--setf", &format!("duration_stretch={stretch:.2}")])
            .args(["-t", &sentence(random, words), "-o"])
            .arg(&wav)
            .output()
            .context("flite")?;
        let sound = Sound::from_wav(&std::fs::read(&wav)?)?;
        let phones = ends(&String::from_utf8_lossy(&output.stdout))?;
        clips.push(Clip {
            sound,
            segments: segments(&phones),
            phones,
        });
    }
    Ok(clips)
}

/// Phones from what flite prints: `hh:0.212 ax:0.261`, each with its end in seconds.
fn ends(printed: &str) -> Result<Vec<TimedPhone>> {
    let mut start_secs = 0.0;
    let mut phones = Vec::new();
    for word in printed.split_whitespace() {
        let (symbol, end) = word
            .split_once(':')
            .with_context(|| format!("flite: {word}"))?;
        let end_secs: f32 = end.parse()?;
        let is_pause = ["pau", "h#", "brth"].contains(&symbol);
        if end_secs > start_secs {
            phones.push(TimedPhone {
                start_secs,
                end_secs,
                symbol: if is_pause {
                    String::new()
                } else {
                    symbol.to_owned()
                },
            });
        }
        start_secs = end_secs;
    }
    Ok(phones)
}

/// The shape of each of a number of frames, by what is said in its middle.
pub(super) fn shapes(segments: &[Segment], frames: usize) -> Vec<Viseme> {
    let mut shapes = vec![Viseme::Silence; frames];
    let at = |secs: f32| ((secs * 100.0 - 0.5).ceil().max(0.0) as usize).min(frames);
    for segment in segments {
        shapes[at(segment.start_secs)..at(segment.end_secs)].fill(segment.viseme);
    }
    shapes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phone(start_secs: f32, end_secs: f32, symbol: &str) -> TimedPhone {
        TimedPhone {
            start_secs,
            end_secs,
            symbol: symbol.into(),
        }
    }

    #[test]
    fn ends_of_flite_are_phones() {
        let phones = ends("pau:0.119 hh:0.212 ax:0.261 pau:1.5").unwrap();
        assert_eq!(phones[1], phone(0.119, 0.212, "hh"));
        assert_eq!((phones.len(), phones[3].symbol.as_str()), (4, ""));
        assert!(ends("a line of another program").is_err());
    }

    #[test]
    fn marks_belong_to_the_phone_before_and_stops_have_their_closures() {
        let marked = [(0, "ˈa"), (400, "ː"), (500, "p"), (540, "")];
        let answer = Answer {
            rate_hz: 1_000,
            samples: 600,
            phones: marked.map(|(at, symbol)| (at, symbol.to_owned())).to_vec(),
        };
        let mut phones = timed(&answer, 600);
        assert_eq!(
            phones,
            [
                phone(0.0, 0.5, "a"),
                phone(0.5, 0.54, "p"),
                phone(0.54, 0.6, "")
            ]
        );
        // The last 80 ms before the p are silent.
        let samples: Vec<f32> = (0..600).map(|n| if n < 420 { 0.3 } else { 0.0 }).collect();
        close_stops(&mut phones, &samples, 1_000);
        assert!((phones[0].end_secs - 0.42).abs() < 1e-5, "{phones:?}");
        assert_eq!(phones[1].start_secs, phones[0].end_secs);
    }

    #[test]
    fn a_frame_has_the_shape_of_its_middle() {
        let segment = |start_secs, end_secs, viseme| Segment {
            start_secs,
            end_secs,
            viseme,
        };
        let segments = [
            segment(0.0, 0.014, Viseme::Pp),
            segment(0.014, 0.026, Viseme::Aa),
        ];
        let shapes = shapes(&segments, 4);
        assert_eq!(
            shapes,
            [Viseme::Pp, Viseme::Aa, Viseme::Aa, Viseme::Silence]
        );
    }
}
