//! The targets of the mesh levels, and the measured values.

use super::Found;
use super::QUARTER;
use anyhow::Result;
use std::fmt::Write as _;

/// A value of each character with an upper bound.
struct Target {
    what: &'static str,
    /// Whether the bound applies to the median instead of the worst.
    median: bool,
    bound: f64,
    values: Vec<(&'static str, f64)>,
}

impl Found {
    /// All of Articula's chunks to Draco's finest level.
    pub(super) fn to_draco(&self) -> Option<f64> {
        let finest = self.sizes.levels.last()?.draco?;
        Some(self.sizes.whole() as f64 / finest as f64)
    }

    /// All of Articula's chunks to all levels of Draco.
    pub(super) fn to_draco_levels(&self) -> Option<f64> {
        let levels: Option<Vec<usize>> = self.sizes.levels.iter().map(|l| l.draco).collect();
        Some(self.sizes.whole() as f64 / levels?.iter().sum::<usize>() as f64)
    }

    /// All of Articula's chunks to meshoptimizer's finest level.
    pub(super) fn to_meshopt(&self) -> Option<f64> {
        Some(self.sizes.whole() as f64 / self.sizes.levels.last()?.meshopt as f64)
    }

    /// All of Articula's chunks to its finest level alone.
    pub(super) fn to_own(&self) -> Option<f64> {
        Some(self.sizes.whole() as f64 / self.sizes.levels.last()?.direct as f64)
    }

    /// Articula's level alone to the same level of Draco, at the worst level.
    fn direct_to_draco(&self) -> Option<f64> {
        let levels = self.sizes.levels.iter();
        let ratios: Option<Vec<f64>> = levels
            .map(|l| Some(l.direct as f64 / l.draco? as f64))
            .collect();
        Some(ratios?.into_iter().fold(0.0, f64::max))
    }

    /// The finest level alone to the same of Draco.
    fn finest_to_draco(&self) -> Option<f64> {
        let finest = self.sizes.levels.last()?;
        Some(finest.direct as f64 / finest.draco? as f64)
    }

    /// Articula's written form to all levels uncoded in buffers.
    fn store_to_sum(&self) -> Option<f64> {
        let plain: usize = self.sizes.levels.iter().map(|l| l.plain).sum();
        Some(self.sizes.store as f64 / plain as f64)
    }

    /// Ranges of the finer levels to those of the thesis.
    fn ranges_to_thesis(&self) -> Option<f64> {
        let finer = self.sizes.levels.iter().enumerate().skip(1);
        finer
            .map(|(l, level)| level.ranges as f64 / (3 * l + 1) as f64)
            .reduce(f64::max)
    }

    /// Seconds for simplifying, rounding and coding 100,000 triangles.
    fn seconds_of_100k(&self) -> Option<f64> {
        let finest = self.sizes.levels.last()?.triangles;
        let seconds = self.sizes.seconds;
        let all = self.simplify_secs + seconds.rounding + seconds.encoding;
        (finest >= 100_000).then(|| all * 1e5 / finest as f64)
    }
}

fn targets(all: &[Found]) -> Vec<Target> {
    let target = |what, bound, of: &dyn Fn(&Found) -> Option<f64>| Target {
        what,
        median: false,
        bound,
        values: all.iter().filter_map(|f| Some((f.name, of(f)?))).collect(),
    };
    let error = |f: &Found| f.ratio(QUARTER).map(f64::from);
    vec![
        Target {
            median: true,
            ..target(
                "maximum error in motion at 25 % / meshopt, median",
                0.6,
                &error,
            )
        },
        target("the same, worst", 1.0, &error),
        target("TRANSPORT whole / Draco's finest", 1.2, &Found::to_draco),
        target(
            "TRANSPORT whole / meshopt's finest",
            0.7,
            &Found::to_meshopt,
        ),
        target(
            "TRANSPORT whole / five levels of Draco",
            0.55,
            &Found::to_draco_levels,
        ),
        target("TRANSPORT whole / own finest", 1.45, &Found::to_own),
        target(
            "direct / Draco of that level, worst level",
            1.05,
            &Found::direct_to_draco,
        ),
        target("finest level direct / Draco", 1.05, &Found::finest_to_draco),
        target("STORE / sum of levels", 1.0, &Found::store_to_sum),
        target(
            "ranges / (3i + 1), above level 0",
            1.0,
            &Found::ranges_to_thesis,
        ),
        target(
            "seconds to simplify, round and code 100,000 triangles",
            5.0,
            &Found::seconds_of_100k,
        ),
    ]
}

/// The table of targets.
pub(super) fn write(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(
        "
## Targets

Every target applies to every character, except the median. *Held*: the number of characters that meet it.

| target | at most | median | worst | character | held | |
| --- | --- | --- | --- | --- | --- | --- |
",
    );
    for mut target in targets(all) {
        target.values.sort_by(|a, b| a.1.total_cmp(&b.1));
        let Some(&(who, worst)) = target.values.last() else {
            continue;
        };
        let median = median(&target.values);
        let judged = if target.median { median } else { worst };
        let held = target.values.iter().filter(|v| v.1 <= target.bound).count();
        writeln!(
            page,
            "| {} | {} | {median:.2} | {worst:.2} | {who} | {held} of {} | {} |",
            target.what,
            target.bound,
            target.values.len(),
            if judged <= target.bound {
                "yes"
            } else {
                "**no**"
            }
        )?;
    }
    Ok(())
}

/// Median of sorted values.
fn median(sorted: &[(&str, f64)]) -> f64 {
    let (low, high) = (sorted.len().saturating_sub(1) / 2, sorted.len() / 2);
    let at = |i: usize| sorted.get(i).map_or(f64::NAN, |v| v.1);
    0.5 * (at(low) + at(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_by_hand() {
        let of = |values: &[f64]| median(&values.iter().map(|v| ("", *v)).collect::<Vec<_>>());
        assert_eq!(of(&[1.0, 2.0, 9.0]), 2.0);
        assert_eq!(of(&[1.0, 2.0, 4.0, 9.0]), 3.0);
        assert!(of(&[]).is_nan());
    }
}
