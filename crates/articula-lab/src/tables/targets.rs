//! The targets of a page: limit, measured value, and whether it holds.
//!
//! One form for all pages, so that a missed target is marked in the same way everywhere. Limits are
//! those of the documents; a limit is never adapted to what was measured.

/// An upper or lower limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    AtMost(f64),
    AtLeast(f64),
}

/// A limit and the measured value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Target {
    /// The leading cells of the row: where the target is stated or what it is about, and the
    /// quantity.
    pub(crate) labels: Vec<String>,
    pub(crate) bound: Bound,
    pub(crate) found: f64,
}

impl Target {
    /// A value that must not exceed a limit.
    pub(crate) fn at_most<const N: usize>(labels: [&str; N], most: f64, found: f64) -> Self {
        Self::new(labels, Bound::AtMost(most), found)
    }

    /// A value that must not fall below a limit.
    pub(crate) fn at_least<const N: usize>(labels: [&str; N], least: f64, found: f64) -> Self {
        Self::new(labels, Bound::AtLeast(least), found)
    }

    fn new<const N: usize>(labels: [&str; N], bound: Bound, found: f64) -> Self {
        Self {
            labels: labels.map(str::to_owned).to_vec(),
            bound,
            found,
        }
    }

    /// Whether the value is within the limit; a value that is not a number is not.
    pub(crate) fn holds(&self) -> bool {
        match self.bound {
            Bound::AtMost(most) => self.found <= most,
            Bound::AtLeast(least) => self.found >= least,
        }
    }
}

/// The section "Targets": an introduction, and a table whose leading columns are named by `heads`.
pub(crate) fn section(about: &str, heads: &[&str], targets: &[Target]) -> String {
    let about = about.trim();
    let missed = targets.iter().filter(|t| !t.holds()).count();
    let of = targets.len();
    format!(
        "\n## Targets\n\n{about} {missed} of {of} missed.\n\n{}",
        table(heads, targets)
    )
}

/// The table alone.
pub(crate) fn table(heads: &[&str], targets: &[Target]) -> String {
    let line = |cells: &[&str]| format!("| {} |\n", cells.join(" | "));
    let mut head = heads.to_vec();
    head.extend(["limit", "found", ""]);
    let mut text = line(&head).replace("|  |", "| |");
    text.push_str(&line(&vec!["---"; head.len()]));
    for target in targets {
        let limit = match target.bound {
            Bound::AtMost(most) => format!("≤ {most}"),
            Bound::AtLeast(least) => format!("≥ {least}"),
        };
        let found = format!("{:.3}", target.found);
        let verdict = if target.holds() {
            "holds"
        } else {
            "**missed**"
        };
        let mut cells: Vec<&str> = target.labels.iter().map(String::as_str).collect();
        cells.extend([limit.as_str(), found.as_str(), verdict]);
        text.push_str(&line(&cells));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_beyond_its_limit_is_marked() {
        let targets = [
            Target::at_most(["a", "time, ms"], 2.0, 2.0),
            Target::at_most(["b", "time, ms"], 2.0, 2.001),
            Target::at_least(["c", "gain, %"], 50.0, 49.9),
            Target::at_least(["d", "gain, %"], 50.0, f64::NAN),
        ];
        let verdicts: Vec<bool> = targets.iter().map(Target::holds).collect();
        assert_eq!(verdicts, [true, false, false, false]);
        let text = section("Of this test.", &["what", "quantity"], &targets);
        let expected = "\n## Targets\n\nOf this test. 3 of 4 missed.\n
| what | quantity | limit | found | |
| --- | --- | --- | --- | --- |
| a | time, ms | ≤ 2 | 2.000 | holds |
| b | time, ms | ≤ 2 | 2.001 | **missed** |
| c | gain, % | ≥ 50 | 49.900 | **missed** |
| d | gain, % | ≥ 50 | NaN | **missed** |
";
        assert_eq!(text, expected);
    }
}
