//! What a track of visemes shows of the phones that were spoken.

use super::corpus::shapes;
use articula_speech::training::Segment;
use articula_speech::{VISEME_COUNT, Viseme, VisemeFrame};

/// How far the mouth is open in each viseme, as a share of "a": the jaw of the tables of blend shapes.
pub(super) const OPEN: [f32; VISEME_COUNT] = [
    0.0, 0.0, 0.05, 0.32, 0.29, 0.39, 0.35, 0.29, 0.29, 0.3, 1.0, 0.53, 0.37, 0.74, 0.37,
];
/// The groups that one sees apart: silence, lips that touch, lip and teeth, tongue, open, spread, round.
const GROUPS: [u8; VISEME_COUNT] = [0, 1, 2, 3, 3, 3, 3, 3, 3, 3, 4, 4, 5, 6, 6];
/// Weight from which lips touch, and teeth the lip.
const CONTACTS: [f32; 2] = [0.5, 0.4];
/// Vowels of this many seconds and more must not be closed in their middle half.
const LONG_VOWEL_SECS: f32 = 0.06;
/// Frames by which a track may be later or earlier at its best lag.
const LAGS: std::ops::RangeInclusive<isize> = -15..=25;

/// Counts over recordings.
#[derive(Debug, Clone, Default)]
pub(super) struct Score {
    /// For each recording what is shown and what is wanted, frame by frame.
    visemes: Vec<Vec<[Viseme; 2]>>,
    /// Phones of p, b and m, and of f and v, and those that are made.
    lips: [usize; 2],
    teeth: [usize; 2],
    /// Long vowels, and those that are closed.
    vowels: [usize; 2],
    /// For each recording how far the mouth is open, shown and wanted, frame by frame.
    open: Vec<Vec<[f32; 2]>>,
}

impl Score {
    pub(super) fn add(&mut self, frames: &[VisemeFrame], segments: &[Segment]) {
        let wanted = shapes(segments, frames.len());
        let both = frames.iter().map(VisemeFrame::strongest).zip(&wanted);
        self.visemes
            .push(both.map(|(shown, wanted)| [shown, *wanted]).collect());
        segments
            .iter()
            .for_each(|segment| self.contact(frames, segment));
        let opening = |w: &[f32; VISEME_COUNT]| w.iter().zip(OPEN).map(|(w, o)| w * o).sum();
        let shown: Vec<f32> = frames.iter().map(|f| opening(&f.weights)).collect();
        let wanted: Vec<f32> = wanted.iter().map(|v| OPEN[v.number()]).collect();
        let pairs = smooth(&shown).into_iter().zip(smooth(&wanted));
        self.open.push(pairs.map(|(a, b)| [a, b]).collect());
    }

    fn contact(&mut self, frames: &[VisemeFrame], segment: &Segment) {
        let at = |secs: f32| ((secs * 100.0).max(0.0) as usize).min(frames.len());
        let end = |secs: f32| ((secs * 100.0).max(0.0).ceil() as usize).min(frames.len());
        let (start, stop) = (segment.start_secs, segment.end_secs);
        let greatest = |from: usize, to: usize, of: &dyn Fn(&[f32; VISEME_COUNT]) -> f32| {
            let frames = frames.get(from..to).unwrap_or_default();
            frames.iter().map(|f| of(&f.weights)).fold(0.0, f32::max)
        };
        let near = (at(start - 0.02), end(stop + 0.02));
        let closed = |w: &[f32; VISEME_COUNT]| w[0] + w[1];
        match segment.viseme {
            Viseme::Pp => count(
                &mut self.lips,
                greatest(near.0, near.1, &closed) >= CONTACTS[0],
            ),
            Viseme::Ff => count(
                &mut self.teeth,
                greatest(near.0, near.1, &|w| w[2]) >= CONTACTS[1],
            ),
            vowel if vowel >= Viseme::Aa && stop - start >= LONG_VOWEL_SECS => {
                let quarter = (stop - start) / 4.0;
                let middle = greatest(at(start + quarter), end(stop - quarter), &closed);
                count(&mut self.vowels, middle >= CONTACTS[0]);
            }
            _ => {}
        }
    }

    /// Share of the frames of speech that show the right viseme.
    pub(super) fn right(&self) -> f32 {
        self.right_of(0, |viseme| viseme.number())
    }

    /// The same, each frame beside what was wanted as much earlier as the track lags.
    pub(super) fn right_without_lag(&self) -> f32 {
        let (_, lag_ms) = self.opening();
        self.right_of((lag_ms / 10.0) as isize, |viseme| viseme.number())
    }

    /// Share of the frames of speech that show one of the right group.
    pub(super) fn right_group(&self) -> f32 {
        self.right_of(0, |viseme| usize::from(GROUPS[viseme.number()]))
    }

    fn right_of(&self, lag: isize, class: impl Fn(Viseme) -> usize) -> f32 {
        let mut counts = [0; 2];
        for frames in &self.visemes {
            for (at, [_, wanted]) in frames.iter().enumerate() {
                let shown = at.checked_add_signed(lag).and_then(|at| frames.get(at));
                if *wanted != Viseme::Silence {
                    let right = shown.is_some_and(|[shown, _]| class(*shown) == class(*wanted));
                    count(&mut counts, right);
                }
            }
        }
        share(counts)
    }

    /// Share of p, b and m at which lips touch.
    pub(super) fn lips(&self) -> f32 {
        share(self.lips)
    }

    /// Share of f and v at which teeth touch the lip.
    pub(super) fn teeth(&self) -> f32 {
        share(self.teeth)
    }

    /// Share of long vowels that are closed.
    pub(super) fn closed_vowels(&self) -> f32 {
        share(self.vowels)
    }

    /// The correlation of the openings at the lag of each recording where it is best, its mean over
    /// recordings, and the median of the lags in milliseconds.
    pub(super) fn opening(&self) -> (f32, f32) {
        let best = self.open.iter().filter_map(|pairs| {
            let at = LAGS.map(|lag| (correlation(pairs, lag), lag));
            at.max_by(|a, b| a.0.total_cmp(&b.0))
        });
        let best: Vec<(f32, isize)> = best.collect();
        let mut lags: Vec<isize> = best.iter().map(|(_, lag)| *lag).collect();
        lags.sort_unstable();
        let mean = best.iter().map(|(r, _)| r).sum::<f32>() / best.len().max(1) as f32;
        (
            mean,
            10.0 * lags.get(lags.len() / 2).copied().unwrap_or(0) as f32,
        )
    }
}

fn count(of: &mut [usize; 2], made: bool) {
    of[0] += 1;
    of[1] += usize::from(made);
}

fn share([of, made]: [usize; 2]) -> f32 {
    made as f32 / of.max(1) as f32
}

/// Pearson's correlation of what is shown with what was wanted `lag` frames earlier.
fn correlation(pairs: &[[f32; 2]], lag: isize) -> f32 {
    let skip = |by: isize| usize::try_from(by).unwrap_or(0);
    let shown = pairs.iter().skip(skip(lag)).map(|p| p[0]);
    let wanted = pairs.iter().skip(skip(-lag)).map(|p| p[1]);
    let both: Vec<(f32, f32)> = shown.zip(wanted).collect();
    let n = both.len().max(1) as f32;
    let mean = (
        both.iter().map(|b| b.0).sum::<f32>() / n,
        both.iter().map(|b| b.1).sum::<f32>() / n,
    );
    let sum = |of: &dyn Fn(f32, f32) -> f32| -> f32 {
        both.iter().map(|(a, b)| of(a - mean.0, b - mean.1)).sum()
    };
    let spread = sum(&|a, _| a * a) * sum(&|_, b| b * b);
    if spread > 0.0 {
        sum(&|a, b| a * b) / spread.sqrt()
    } else {
        0.0
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn spoken() -> Vec<Segment> {
        let shapes = [
            Viseme::Silence,
            Viseme::Pp,
            Viseme::Aa,
            Viseme::Ff,
            Viseme::O,
            Viseme::Silence,
        ];
        let segment = |(index, viseme): (usize, &Viseme)| Segment {
            start_secs: index as f32 * 0.1,
            end_secs: (index + 1) as f32 * 0.1,
            viseme: *viseme,
        };
        shapes.iter().enumerate().map(segment).collect()
    }

    /// A track that shows phones, later by some frames.
    fn shown(later: usize) -> Vec<VisemeFrame> {
        let wanted = shapes(&spoken(), 60);
        let frame = |at: usize| VisemeFrame {
            weights: std::array::from_fn(|v| {
                let wanted = wanted[at.saturating_sub(later)].number();
                f32::from(u8::from(v == wanted))
            }),
            level_db: 0.0,
        };
        (0..60).map(frame).collect()
    }

    #[test]
    fn a_track_that_shows_all_has_the_best_score_and_one_that_is_late_its_lag() {
        let mut score = Score::default();
        score.add(&shown(0), &spoken());
        let shares = [
            score.right(),
            score.right_group(),
            score.lips(),
            score.teeth(),
            score.closed_vowels(),
        ];
        assert_eq!(shares, [1.0, 1.0, 1.0, 1.0, 0.0]);
        let mut late = Score::default();
        late.add(&shown(4), &spoken());
        assert_eq!(late.opening().1, 40.0);
        assert!(late.opening().0 > 0.999 && late.right() < 0.7);
        assert!(
            late.right_without_lag() > 0.95,
            "{}",
            late.right_without_lag()
        );
    }

    #[test]
    fn a_mouth_that_stays_closed_closes_its_vowels() {
        let mut score = Score::default();
        let closed = VisemeFrame {
            weights: std::array::from_fn(|v| f32::from(u8::from(v == 0))),
            level_db: 0.0,
        };
        score.add(&[closed; 60], &spoken());
        let shares = [
            score.right(),
            score.lips(),
            score.teeth(),
            score.closed_vowels(),
        ];
        assert_eq!(shares, [0.0, 1.0, 0.0, 1.0]);
    }
}
