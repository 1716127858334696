//! The time column of a capture.
//!
//! The app writes time codes, `HH:MM:SS:FF.sub`. Scripts that convert captures also write times of
//! day with a fraction, and plain numbers of frames, seconds, milliseconds or smaller units.

/// Rates of the app and of cinema and television, ascending; the last one is the default.
const RATES_HZ: [f64; 6] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0];
/// Rate of the app.
const APP_HZ: f64 = RATES_HZ[RATES_HZ.len() - 1];
/// Greatest distance of a measured rate from one of them, as a fraction.
const NEAR: f64 = 0.02;
const DAY_SECS: f64 = 86400.0;

/// A value of the time column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Time {
    /// Whole seconds of the day, and frames within the second.
    Code { secs: f64, frames: f64 },
    /// Seconds of the day.
    Clock(f64),
    /// A plain number.
    Number(f64),
}

impl Time {
    pub(super) fn of(word: &str) -> Option<Self> {
        let parts: Vec<&str> = word.split([':', ';']).collect();
        let part = |i: usize, most: u32| {
            let value = parts[i].parse::<u32>().ok().filter(|value| *value < most);
            value.map(f64::from)
        };
        let fraction = |i: usize, most: f64| {
            let value = parts[i].parse::<f64>().ok();
            value.filter(|f| (0.0..most).contains(f))
        };
        let whole = || Some(3600.0 * part(0, 24)? + 60.0 * part(1, 60)?);
        match parts.len() {
            1 => Some(Self::Number(fraction(0, 1e18)?)),
            3 => Some(Self::Clock(whole()? + fraction(2, 60.0)?)),
            4 => Some(Self::Code {
                secs: whole()? + part(2, 60)?,
                frames: fraction(3, APP_HZ)?,
            }),
            _ => None,
        }
    }

    /// Whether two values are of one kind.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        std::mem::discriminant(self) == std::mem::discriminant(other)
    }

    fn whole_secs(&self) -> f64 {
        match self {
            Self::Code { secs, .. } | Self::Clock(secs) => *secs,
            Self::Number(_) => 0.0,
        }
    }
}

/// Times of the rows.
pub(super) struct Times {
    /// Rows per second.
    pub(super) rate_hz: f64,
    /// Seconds since the first row.
    pub(super) secs: Vec<f64>,
    /// What a column of numbers was read as, if that had to be inferred.
    pub(super) read_as: Option<&'static str>,
}

/// Returns the times of rows, all of one kind.
///
/// # Errors
/// A description of numbers that are of no known unit.
pub(super) fn times(column: &[Time]) -> Result<Times, String> {
    let days = days(column);
    let Some(first) = column.first() else {
        return Ok(Times {
            rate_hz: APP_HZ,
            secs: Vec::new(),
            read_as: None,
        });
    };
    let (rate_hz, unit_secs, read_as) = match first {
        Time::Code { .. } => (rate_of_codes(column, &days), 1.0, None),
        Time::Clock(_) => {
            let step = median_step(
                column
                    .iter()
                    .zip(&days)
                    .map(|(t, day)| t.whole_secs() + day),
            );
            (rate_near(step), 1.0, None)
        }
        Time::Number(_) => unit_of_numbers(column)?,
    };
    let secs_of = |(time, day): (&Time, &f64)| match time {
        Time::Code { secs, frames } => secs + day + frames / rate_hz,
        Time::Clock(secs) => secs + day,
        Time::Number(number) => number * unit_secs,
    };
    let secs: Vec<f64> = column.iter().zip(&days).map(secs_of).collect();
    Ok(Times {
        rate_hz,
        secs: secs.iter().map(|s| s - secs[0]).collect(),
        read_as,
    })
}

/// The rows that ascend in time: as many as possible, so that one wrong time costs one row, and of
/// equally many those of the least duration.
///
/// Source: longest increasing subsequence by patience sorting (Fredman 1975); O(n log n).
pub(super) fn ascending(secs: &[f64]) -> Vec<bool> {
    // The rows at which the longest ascending sequence has a length; later ones are never later in time.
    let mut by_length: Vec<Vec<usize>> = Vec::new();
    let mut lowest: Vec<f64> = Vec::new();
    for (row, time) in secs.iter().enumerate() {
        let length = lowest.partition_point(|end| end < time);
        if length == lowest.len() {
            by_length.push(Vec::new());
            lowest.push(*time);
        }
        by_length[length].push(row);
        lowest[length] = *time;
    }
    let mut kept = vec![false; secs.len()];
    let mut next: Option<usize> = None;
    for (rows, lowest) in by_length.iter().zip(&lowest).rev() {
        // The latest time before the next row; of equal times the first row.
        let is_late = |row: &usize| match next {
            Some(next) => secs[*row] >= secs[next],
            None => secs[*row] > *lowest,
        };
        let row = rows[rows.partition_point(is_late)];
        kept[row] = true;
        next = Some(row);
    }
    kept
}

/// Seconds to add to each row for the midnights before it: where the time of day falls by more than
/// half a day, and back where it rises so.
fn days(column: &[Time]) -> Vec<f64> {
    let mut day = 0.0;
    let mut before = column.first().map_or(0.0, Time::whole_secs);
    let of = |time: &Time| {
        let secs = time.whole_secs();
        if secs < before - DAY_SECS / 2.0 {
            day += DAY_SECS;
        } else if secs > before + DAY_SECS / 2.0 {
            day -= DAY_SECS;
        }
        before = secs;
        day
    };
    column.iter().map(of).collect()
}

/// The rate at which time codes count frames: the lowest that the numbers of frames allow, if a whole
/// second was counted; if not, that of the app.
fn rate_of_codes(column: &[Time], days: &[f64]) -> f64 {
    let secs = |i: usize| column[i].whole_secs() + days[i];
    if secs(column.len() - 1) - secs(0) < 2.0 {
        return APP_HZ;
    }
    let frames = column.iter().map(|time| match time {
        Time::Code { frames, .. } => *frames,
        _ => 0.0,
    });
    let most = frames.fold(0.0, f64::max);
    let known = RATES_HZ.into_iter().find(|rate| most < *rate);
    known.unwrap_or(APP_HZ)
}

/// Rate, seconds for each unit, and name of the unit of plain numbers, by their most common step.
fn unit_of_numbers(column: &[Time]) -> Result<(f64, f64, Option<&'static str>), String> {
    let numbers = column.iter().map(|time| match time {
        Time::Number(number) => *number,
        _ => 0.0,
    });
    let step = median_step(numbers);
    // Frames may be left out; other steps are those of 20 to 125 rows a second.
    let (unit_secs, read_as) = match step {
        0.008..0.5 => (1.0, "seconds"),
        0.5..8.0 => return Ok((APP_HZ, APP_HZ.recip(), None)),
        8.0..50.0 => (1e-3, "milliseconds"),
        8e3..5e4 => (1e-6, "microseconds"),
        8e6..5e7 => (1e-9, "nanoseconds"),
        step if step <= 0.0 => return Ok((APP_HZ, APP_HZ.recip(), None)),
        _ => {
            return Err(format!(
                "the times ascend by {step} a row, which is no rate in frames, seconds or \
                 milliseconds; expected time codes such as 14:03:27:12.345"
            ));
        }
    };
    Ok((rate_near(step * unit_secs), unit_secs, Some(read_as)))
}

/// The known rate of rows with this step in seconds, else its reciprocal.
fn rate_near(step_secs: f64) -> f64 {
    let rate = step_secs.recip();
    if !(0.01..1e4).contains(&rate) {
        return APP_HZ;
    }
    let near = |known: &f64| (rate - known).abs() <= NEAR * known;
    RATES_HZ.into_iter().find(near).unwrap_or(rate)
}

/// The median of the steps between values; 0 without any.
fn median_step(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let next = values.clone().skip(1);
    let mut steps: Vec<f64> = values.zip(next).map(|(a, b)| b - a).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(words: &[String]) -> Times {
        let column: Vec<Time> = words.iter().map(|w| Time::of(w).unwrap()).collect();
        times(&column).unwrap()
    }

    proptest! {
        #[test]
        fn every_kind_of_column_gives_the_same_times(
            rate in prop::sample::select(&RATES_HZ[..]), start in 0..86_400u32, kind in 0..6usize,
        ) {
            let count = 3 * rate as usize;
            let word = |i: usize| {
                let at = f64::from(start) + i as f64 / rate;
                let (whole, part) = (at.floor(), at.fract());
                let day = whole as u32 % 86_400;
                let (h, m, s) = (day / 3600, day / 60 % 60, day % 60);
                match kind {
                    0 => format!("{h:02}:{m:02}:{s:02}:{:02}.000", i % rate as usize),
                    1 => format!("{h:02}:{m:02}:{:09.6}", f64::from(s) + part),
                    2 => format!("{at:.4}"),
                    3 => format!("{:.1}", at * 1e3),
                    4 => format!("{:.0}", at * 1e6),
                    _ => format!("{:.0}", at * 1e9),
                }
            };
            let words: Vec<String> = (0..count).map(word).collect();
            let found = of(&words);
            prop_assert_eq!(found.rate_hz, rate);
            prop_assert_eq!(found.read_as.is_some(), kind > 1);
            for (i, secs) in found.secs.iter().enumerate() {
                prop_assert!((secs - i as f64 / rate).abs() < 2e-4, "{i}: {secs}");
            }
        }
    }

    proptest! {
        #[test]
        fn as_many_rows_as_possible_ascend(times in prop::collection::vec(0..12u8, 0..24)) {
            let secs: Vec<f64> = times.iter().map(|t| f64::from(*t)).collect();
            let kept = ascending(&secs);
            let rows: Vec<f64> = secs.iter().zip(&kept).filter(|(_, kept)| **kept).map(|(t, _)| *t).collect();
            prop_assert!(rows.windows(2).all(|pair| pair[0] < pair[1]), "{rows:?}");
            // The plain dynamic programme over all pairs.
            let mut longest = vec![1; secs.len()];
            for row in 0..secs.len() {
                let before = (0..row).filter(|other| secs[*other] < secs[row]);
                longest[row] = 1 + before.map(|other| longest[other]).max().unwrap_or(0);
            }
            prop_assert_eq!(rows.len(), longest.into_iter().max().unwrap_or(0));
        }
    }

    #[test]
    fn numbers_of_frames_count_at_the_rate_of_the_app() {
        let found = of(&["100".to_owned(), "106".to_owned()]);
        assert!((found.secs[1] - 0.1).abs() < 1e-12 && found.read_as.is_none());
        let column = [Time::Number(0.0), Time::Number(700.0)];
        assert!(
            times(&column)
                .err()
                .unwrap()
                .contains("ascend by 700 a row")
        );
        assert_eq!(times(&[]).unwrap().rate_hz, APP_HZ);
    }
}
