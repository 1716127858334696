//! The page of the devices, its CSV file and its plot.

use super::predict::{Judged, by_all, by_chosen};
use super::{APPLICATIONS, Measured, logs, test_names};
use anyhow::Result;
use articula_report::{PlotOptions, Scale, Series, line_plot};
use std::fmt::Write as _;
use std::thread::available_parallelism;

const HEAD: &str = "# Devices

Made by `cargo run --release -p articula-lab -- devices`, after these builds, each of which makes devices:

```sh
cargo build --release -p articula-cli
cargo build -p articula-cli
cargo build --release -p articula-cli --target aarch64-unknown-linux-gnu
cargo xtask web
```

The measurement of the thesis' table 6.5 and figure 6.8: frame rates of tests and of applications on unlike devices, and how well the
tests predict an application. Here all devices are made of one machine: the instruction set by which crowds are posed, two
threads for crowds, a core that is shared with another busy program of the same priority, the program of the
development profile, the program for AArch64 under emulation (qemu-user), whose costs differ most from one kind of work to
another, and the module for web pages in node. The thesis has six machines; a quota of processor time (`cpulimit`)
is not among them: frames fall between its pauses, so their median does not change.

*Tests* are grades of the mannequin ([method](../methods/adaptation.md#8-a-device-that-is-benchmarked)), *applications*
play other characters. Frames per second, each the median of 6 to 15 runs of `articula bench device --grades`.
";

/// The Markdown page.
pub(super) fn page(measured: &[Measured], missing: &[(&str, String)]) -> Result<String> {
    let mut page = HEAD.to_owned();
    let cores = available_parallelism().map_or(1, usize::from);
    writeln!(
        page,
        "\nMeasured on a machine with {cores} {} cores.",
        std::env::consts::ARCH
    )?;
    for (name, why) in missing {
        writeln!(page, "\nNot measured: {name} ({why}).")?;
    }
    rates(&mut page, measured)?;
    if measured.len() > 2 {
        predictions(&mut page, measured)?;
    }
    Ok(page)
}

/// Named rates of every device, the tests first.
fn rows(measured: &[Measured]) -> Vec<(String, Vec<f64>)> {
    let mut rows = Vec::new();
    for (t, name) in test_names().into_iter().enumerate() {
        rows.push((name, measured.iter().map(|m| m.tests[t].fps).collect()));
    }
    rows.push(("geometric mean of the tests".to_owned(), means(measured)));
    for (a, application) in APPLICATIONS.iter().enumerate() {
        let fps = measured.iter().map(|m| m.applications[a].fps).collect();
        rows.push((application.name.to_owned(), fps));
    }
    rows
}

/// The geometric mean of all tests on every device.
fn means(measured: &[Measured]) -> Vec<f64> {
    let mean = |m: &Measured| {
        let sum: f64 = m.tests.iter().map(|rate| rate.fps.ln()).sum();
        (sum / m.tests.len() as f64).exp()
    };
    measured.iter().map(mean).collect()
}

fn rates(page: &mut String, measured: &[Measured]) -> Result<()> {
    writeln!(page, "\n## Frame rates\n\n![Frame rates](devices.svg)\n")?;
    let names: Vec<&str> = measured.iter().map(|m| m.device.name).collect();
    writeln!(page, "| | {} |", names.join(" | "))?;
    writeln!(page, "| --- |{}", " --- |".repeat(names.len()))?;
    for (name, fps) in rows(measured) {
        let cells: Vec<String> = fps.iter().map(|fps| digits(*fps)).collect();
        writeln!(page, "| {name} | {} |", cells.join(" | "))?;
    }
    Ok(())
}

/// A rate with three significant digits.
fn digits(fps: f64) -> String {
    let decimals = (2.0 - fps.log10().floor()).clamp(0.0, 4.0);
    format!("{fps:.*}", decimals as usize)
}

fn predictions(page: &mut String, measured: &[Measured]) -> Result<()> {
    page.push_str(
        "
## Predictions

An application is taken to be as fast as a constant times the geometric mean of some tests. Constant and tests (one to three of
nine) are those with the least squares of the logarithms. Errors are of devices that were left out, of the choice of tests
too: predicted rate divided by the true one, minus 1. *All tests*: the mean of the thesis, with a constant.

| application | by | tests | error, median | error, greatest | on |
| --- | --- | --- | --- | --- | --- |
",
    );
    let names = test_names();
    let count = names.len();
    let tests: Vec<Vec<f64>> = (0..count)
        .map(|t| logs(measured, |m| m.tests[t].fps))
        .collect();
    for (a, application) in APPLICATIONS.iter().enumerate() {
        let rates = logs(measured, |m| m.applications[a].fps);
        let all = by_all(&tests, &rates);
        let chosen = by_chosen(&tests, &rates);
        let of: Vec<&str> = chosen
            .prediction
            .tests
            .iter()
            .map(|t| &*names[*t])
            .collect();
        let of = of.join(", ");
        line(
            page,
            measured,
            application.name,
            ("all tests", "nine", &all),
        )?;
        line(
            page,
            measured,
            application.name,
            ("chosen tests", &of, &chosen),
        )?;
    }
    Ok(())
}

fn line(
    page: &mut String,
    measured: &[Measured],
    name: &str,
    (by, tests, judged): (&str, &str, &Judged),
) -> Result<()> {
    let mut sizes: Vec<f64> = judged.errors.iter().map(|e| e.abs()).collect();
    let by_size = |a: &(usize, &f64), b: &(usize, &f64)| a.1.abs().total_cmp(&b.1.abs());
    let worst = judged.errors.iter().enumerate().max_by(by_size);
    let (at, greatest) = worst.map_or((0, 0.0), |(d, error)| (d, *error));
    let median = crate::measure::median(&mut sizes);
    let device = measured[at].device.name;
    writeln!(
        page,
        "| {name} | {by} | {tests} | {:.1} % | {:+.1} % | {device} |",
        100.0 * median,
        100.0 * greatest
    )?;
    Ok(())
}

/// Every rate.
pub(super) fn csv(measured: &[Measured]) -> Result<String> {
    let mut csv = String::from("device,kind,name,fps,runs\n");
    for m in measured {
        let names = test_names();
        let tests = names.iter().map(String::as_str).zip(&m.tests);
        let of = APPLICATIONS.iter().map(|a| a.name).zip(&m.applications);
        let all = tests.map(|(n, r)| ("test", n, r));
        for (kind, name, rate) in all.chain(of.map(|(n, r)| ("application", n, r))) {
            writeln!(
                csv,
                "{},{kind},\"{name}\",{:.4},{}",
                m.device.name, rate.fps, rate.runs
            )?;
        }
    }
    Ok(csv)
}

/// The mean of the tests and the applications over the devices, as figure 6.8 of the thesis.
pub(super) fn plot(measured: &[Measured]) -> String {
    let line = |(name, fps): (String, Vec<f64>)| Series {
        dashed: !name.starts_with("geometric"),
        points: (1..).map(f64::from).zip(fps).collect(),
        name,
    };
    let shown = rows(measured).into_iter().skip(test_names().len());
    let series: Vec<Series> = shown.map(line).collect();
    let options = PlotOptions {
        title: "Mean of the tests, and applications".into(),
        x_label: "device, in the order of the table".into(),
        y_label: "frames per second".into(),
        y_scale: Scale::Logarithmic,
        ..PlotOptions::default()
    };
    line_plot(&options, &series)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_have_three_digits() {
        for (fps, text) in [
            (0.051_23, "0.0512"),
            (1.234, "1.23"),
            (56.78, "56.8"),
            (12_345.0, "12345"),
        ] {
            assert_eq!(digits(fps), text);
        }
    }
}
