//! Recordings of people that the network was not trained with, against phones that another program
//! (pocketsphinx 5.1.1) found in them, given their text.

use articula_speech::{
    Sound, TimedPhone, VISEME_COUNT, Viseme, VisemeTrack, align, read_phone_times,
};
use std::path::PathBuf;

/// How far the mouth is open in each viseme, as a share of "a": the jaw of the tables of blend shapes.
const OPEN: [f32; VISEME_COUNT] = [
    0.0, 0.0, 0.05, 0.32, 0.29, 0.39, 0.35, 0.29, 0.29, 0.3, 1.0, 0.53, 0.37, 0.74, 0.37,
];

struct Recording {
    sound: Sound,
    phones: Vec<TimedPhone>,
}

#[allow(
    clippy::disallowed_methods,
    reason = "tests read the files of the repository"
)]
fn recordings() -> Vec<Recording> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/speech"));
    let read = |name: String| std::fs::read(folder.join(name)).unwrap();
    let recording = |number: &str| Recording {
        sound: Sound::from_wav(&read(format!("librivox_austen_{number}.wav"))).unwrap(),
        phones: read_phone_times(&read(format!("librivox_austen_{number}.lab"))).unwrap(),
    };
    ["0870", "0880", "0890", "0930"].map(recording).into()
}

/// What a track shows of the phones of recordings.
#[derive(Debug, Default)]
struct Score {
    frames: usize,
    right: usize,
    /// Phones of p, b and m, and of f and v, and those that are made.
    lips: [usize; 2],
    teeth: [usize; 2],
    /// Vowels of 60 ms and more, and those whose middle half is closed.
    vowels: [usize; 2],
    /// How far the mouth is open, shown and wanted.
    open: Vec<[f32; 2]>,
}

impl Score {
    fn add(&mut self, track: &VisemeTrack, recording: &Recording) {
        let count = track.frames.len();
        let frame = |secs: f32| ((secs * 100.0) as usize).min(count - 1);
        for phone in &recording.phones {
            let viseme = shape_of(&phone.symbol);
            let (start, end) = (frame(phone.start_secs), frame(phone.end_secs).max(1));
            let shown = |from: usize, to: usize, of: &dyn Fn(&[f32; VISEME_COUNT]) -> f32| {
                let frames = &track.frames[from.min(to)..=to.min(count - 1)];
                frames.iter().map(|f| of(&f.weights)).fold(0.0, f32::max)
            };
            let closed = |w: &[f32; VISEME_COUNT]| w[0] + w[1];
            match viseme {
                Some(Viseme::Pp) => {
                    self.lips[0] += 1;
                    let made = shown(start.saturating_sub(2), end + 1, &closed) >= 0.5;
                    self.lips[1] += usize::from(made);
                }
                Some(Viseme::Ff) => {
                    self.teeth[0] += 1;
                    let made = shown(start.saturating_sub(2), end + 1, &|w| w[2]) >= 0.4;
                    self.teeth[1] += usize::from(made);
                }
                Some(vowel) if vowel >= Viseme::Aa && phone.end_secs - phone.start_secs >= 0.06 => {
                    let quarter = (end - start) / 4;
                    self.vowels[0] += 1;
                    let false_one = shown(start + quarter, end - quarter - 1, &closed) >= 0.5;
                    self.vowels[1] += usize::from(false_one);
                }
                _ => {}
            }
            for frame in &track.frames[start..end] {
                let is_speech = viseme.is_some_and(|v| v != Viseme::Silence);
                self.frames += usize::from(is_speech);
                self.right += usize::from(is_speech && Some(frame.strongest()) == viseme);
            }
        }
        let opening = |w: &[f32; VISEME_COUNT]| w.iter().zip(OPEN).map(|(w, o)| w * o).sum();
        let shown: Vec<f32> = track.frames.iter().map(|f| opening(&f.weights)).collect();
        let wanted = wanted_openings(&recording.phones, count);
        let pairs = smooth(&shown).into_iter().zip(smooth(&wanted));
        self.open.extend(pairs.map(|(a, b)| [a, b]));
    }

    /// Pearson's correlation of the openings.
    fn correlation(&self) -> f32 {
        let n = self.open.len() as f32;
        let mean = |side: usize| self.open.iter().map(|o| o[side]).sum::<f32>() / n;
        let (a, b) = (mean(0), mean(1));
        let sum = |f: &dyn Fn(f32, f32) -> f32| -> f32 {
            self.open.iter().map(|o| f(o[0] - a, o[1] - b)).sum()
        };
        sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
    }
}

/// How far the mouth is to be open in each frame: phone by phone, those that glide in two steps of 60
/// and 40 %.
fn wanted_openings(phones: &[TimedPhone], count: usize) -> Vec<f32> {
    const GLIDES: [(&str, [Viseme; 2]); 5] = [
        ("AW", [Viseme::Aa, Viseme::U]),
        ("AY", [Viseme::Aa, Viseme::I]),
        ("EY", [Viseme::E, Viseme::I]),
        ("OW", [Viseme::O, Viseme::U]),
        ("OY", [Viseme::O, Viseme::I]),
    ];
    let mut wanted = vec![0.0; count];
    let mut next = Viseme::E;
    // From the end on: an h has the shape of what follows.
    for phone in phones.iter().rev() {
        let glide = GLIDES.iter().find(|(symbol, _)| *symbol == phone.symbol);
        let shapes = match (glide, shape_of(&phone.symbol)) {
            (Some((_, shapes)), _) => *shapes,
            (None, shape) => [shape.unwrap_or(next); 2],
        };
        let turn = phone.start_secs + 0.6 * (phone.end_secs - phone.start_secs);
        for (frame, wanted) in wanted.iter_mut().enumerate() {
            let secs = (frame as f32 + 0.5) / 100.0;
            if (phone.start_secs..phone.end_secs).contains(&secs) {
                *wanted = OPEN[shapes[usize::from(secs >= turn)].number()];
            }
        }
        next = shapes[0];
    }
    wanted
}

/// The mean over 70 ms, the middle weighing most: a mouth does not step.
fn smooth(values: &[f32]) -> Vec<f32> {
    const WEIGHTS: [f32; 7] = [0.146, 0.5, 0.854, 1.0, 0.854, 0.5, 0.146];
    let at = |index: usize, shift: usize| {
        let index = (index + shift).saturating_sub(3).min(values.len() - 1);
        WEIGHTS[shift] / 4.0 * values[index]
    };
    let mean = |index| (0..WEIGHTS.len()).map(|shift| at(index, shift)).sum();
    (0..values.len()).map(mean).collect()
}

/// The shape of a phone of one sound; of those that glide there is no single one.
fn shape_of(symbol: &str) -> Option<Viseme> {
    const SHAPES: [(&str, Viseme); 15] = [
        ("SIL", Viseme::Silence),
        ("P B M", Viseme::Pp),
        ("F V", Viseme::Ff),
        ("TH DH", Viseme::Th),
        ("T D DX", Viseme::Dd),
        ("K G NG", Viseme::Kk),
        ("CH JH SH ZH", Viseme::Ch),
        ("S Z", Viseme::Ss),
        ("N L", Viseme::Nn),
        ("R ER", Viseme::Rr),
        ("AA AE AH", Viseme::Aa),
        ("EH", Viseme::E),
        ("IH IY Y", Viseme::I),
        ("AO", Viseme::O),
        ("UH UW W", Viseme::U),
    ];
    let symbol = if symbol.is_empty() { "SIL" } else { symbol };
    let row = SHAPES
        .iter()
        .find(|(s, _)| s.split(' ').any(|s| s == symbol));
    row.map(|(_, viseme)| *viseme)
}

#[test]
fn voices_are_heard_as_well_as_is_told() {
    let mut score = Score::default();
    for recording in recordings() {
        score.add(&VisemeTrack::recognised(&recording.sound), &recording);
    }
    let share = |[of, made]: [usize; 2]| made as f32 / of as f32;
    let right = share([score.frames, score.right]);
    println!(
        "{:.0} % of frames, p b m {:?}, f v {:?}, vowels closed {:?}, opening r {:.2}",
        100.0 * right,
        score.lips,
        score.teeth,
        score.vowels,
        score.correlation()
    );
    assert!(right >= 0.55, "{right}");
    assert!(share(score.lips) >= 0.85, "{:?}", score.lips);
    assert!(share(score.teeth) >= 0.55, "{:?}", score.teeth);
    assert!(share(score.vowels) <= 0.05, "{:?}", score.vowels);
    assert!(score.correlation() >= 0.7, "{}", score.correlation());
}

#[test]
fn phones_that_are_known_are_made_and_their_times_are_found() {
    let (mut score, mut off_secs) = (Score::default(), Vec::new());
    for recording in recordings() {
        let track = VisemeTrack::of_phones(&recording.phones, &recording.sound);
        score.add(&track, &recording);
        let symbols: Vec<String> = recording.phones.iter().map(|p| p.symbol.clone()).collect();
        let heard = VisemeTrack::recognised(&recording.sound);
        let found = align(&heard, &symbols).unwrap();
        let spoken = |phones: &[TimedPhone]| -> Vec<TimedPhone> {
            phones
                .iter()
                .filter(|p| !p.symbol.is_empty())
                .cloned()
                .collect()
        };
        let (found, wanted) = (spoken(&found), spoken(&recording.phones));
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(&wanted) {
            assert_eq!(found.symbol, wanted.symbol);
            off_secs.push((found.start_secs - wanted.start_secs).abs());
        }
    }
    assert_eq!(score.lips[0], score.lips[1]);
    assert_eq!(score.teeth[0], score.teeth[1]);
    off_secs.sort_by(f32::total_cmp);
    let (median, late) = (
        off_secs[off_secs.len() / 2],
        off_secs[off_secs.len() * 9 / 10],
    );
    println!(
        "begins of phones are off by {median:.3} s in the median, 9 of 10 by {late:.3} s at most"
    );
    assert!(median <= 0.03 && late <= 0.09, "{median} {late}");
}

#[test]
fn gain_and_rate_change_little() {
    for recording in recordings().into_iter().take(1) {
        let plain = VisemeTrack::recognised(&recording.sound);
        let soft: Vec<f32> = recording.sound.samples.iter().map(|s| s * 0.25).collect();
        let soft = VisemeTrack::recognised(&Sound::new(&soft, 16_000));
        let same = plain.frames.iter().zip(&soft.frames);
        let same = same.filter(|(a, b)| a.strongest() == b.strongest()).count();
        assert!(
            same * 100 >= plain.frames.len() * 90,
            "{same} of {}",
            plain.frames.len()
        );
    }
}
