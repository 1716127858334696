//! Damaged rows and values of captures: each costs itself, unless they are half of the file.

use crate::error::{ReadError, Warning};
use crate::words::{no_number, number_up_to, shortened};

/// What is damaged in a capture.
#[derive(Debug, Default)]
pub(crate) struct Damage {
    rows: usize,
    first_row: Option<ReadError>,
    values: usize,
    first_value: Option<(String, String)>,
}

impl Damage {
    /// Notes a row that cannot be used.
    pub(crate) fn row(&mut self, error: ReadError) {
        self.rows += 1;
        self.first_row.get_or_insert(error);
    }

    /// Reads the values of a row; those that are no number of at most this size are noted, with the
    /// position that `at` gives for an index, and become NaN, which [`hold`] replaces.
    ///
    /// # Errors
    /// The error of the first such value, if they are more than half of the row.
    pub(crate) fn values<'w>(
        &mut self,
        at: impl Fn(usize) -> String,
        most: f32,
        words: impl Iterator<Item = &'w str>,
        out: &mut Vec<f32>,
    ) -> Result<(), ReadError> {
        let before = out.len();
        let mut first: Option<(usize, &str)> = None;
        let mut odd = 0;
        for (index, word) in words.enumerate() {
            out.push(number_up_to(most, word).unwrap_or_else(|| {
                odd += 1;
                first.get_or_insert((index, word));
                f32::NAN
            }));
        }
        let Some((index, word)) = first else {
            return Ok(());
        };
        if 2 * odd > out.len() - before {
            out.truncate(before);
            return Err(no_number(at(index), most, word));
        }
        self.values += odd;
        self.first_value
            .get_or_insert_with(|| (at(index), shortened(word)));
        Ok(())
    }

    /// Whether any value was noted.
    pub(crate) fn has_values(&self) -> bool {
        self.values > 0
    }

    /// Warns of what was noted; `rows` is the number of all rows, `fate` what became of the damaged
    /// ones.
    ///
    /// # Errors
    /// The first error, if half of the rows or more are damaged.
    pub(crate) fn told(
        self,
        rows: usize,
        fate: &str,
        mut warn: impl FnMut(Warning),
    ) -> Result<(), ReadError> {
        if let Some((at, word)) = self.first_value {
            let more = more(self.values, "values");
            let what = format!(
                "\"{word}\" found, a number expected{more}; the value of the row before is held"
            );
            warn(Warning::new(at, what));
        }
        let Some(error) = self.first_row else {
            return Ok(());
        };
        let ReadError::Malformed { at, what } = &error else {
            return Err(error);
        };
        if 2 * self.rows >= rows {
            return Err(error);
        }
        let more = more(self.rows, "rows");
        warn(Warning::new(at, format!("{what}{more}; {fate}")));
        Ok(())
    }
}

fn more(count: usize, of: &str) -> String {
    match count.saturating_sub(1) {
        0 => String::new(),
        more => format!(" (and {more} more {of})"),
    }
}

/// Replaces NaN at places of `values`, in their order, by the value before; at the beginning by the
/// first one that is not NaN, or 0.
pub(crate) fn hold(values: &mut [f32], places: impl Iterator<Item = usize> + Clone) {
    let known = |place: usize| Some(values[place]).filter(|v| !v.is_nan());
    let mut last = places.clone().find_map(known).unwrap_or(0.0);
    for place in places {
        match values[place] {
            value if value.is_nan() => values[place] = last,
            value => last = value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_as_before_or_as_the_first() {
        let mut values = [f32::NAN, 7.0, 1.0, f32::NAN, f32::NAN, 8.0];
        hold(&mut values, (0..6).step_by(2));
        hold(&mut values, (1..6).step_by(2));
        assert_eq!(values, [1.0, 7.0, 1.0, 7.0, 1.0, 8.0]);
        let mut unknown = [f32::NAN; 2];
        hold(&mut unknown, 0..2);
        assert_eq!(unknown, [0.0; 2]);
    }

    #[test]
    fn half_of_the_rows_or_of_a_row_are_too_many() {
        let told = |bad: usize, rows: usize| {
            let mut damage = Damage::default();
            (0..bad)
                .for_each(|line| damage.row(ReadError::malformed(format!("line {line}"), "odd")));
            let mut said = Vec::new();
            damage
                .told(rows, "left out", |w| said.push(w.what))
                .map(|()| said)
        };
        assert_eq!(told(0, 0), Ok(vec![]));
        assert_eq!(told(1, 3), Ok(vec!["odd; left out".to_owned()]));
        assert_eq!(
            told(2, 5),
            Ok(vec!["odd (and 1 more rows); left out".to_owned()])
        );
        assert_eq!(told(2, 4), Err(ReadError::malformed("line 0", "odd")));
        let mut values = Vec::new();
        let at = |i: usize| i.to_string();
        let mut damage = Damage::default();
        assert!(
            damage
                .values(at, 9.0, "1 nan".split(' '), &mut values)
                .is_ok()
        );
        assert!(
            damage
                .values(at, 9.0, "1 nan 10".split(' '), &mut values)
                .is_err()
        );
        assert_eq!(values.len(), 2);
    }
}
