//! Line and bar plots as SVG text, for report pages with a light background.
//!
//! Not written with a plotting crate: positions keep their fractions, a logarithmic axis is
//! labelled at the measured values, and lines can be dashed. Series differ in colour, marker and
//! dash, so no plot relies on colour alone. Palette: Okabe and Ito 2008, without its yellow, which
//! lacks contrast on white.

mod axis;
mod stack;

pub use stack::{Plot, stacked};

use axis::{Axis, Spacing};
use std::fmt::Write;

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 430.0;
const LEFT: f64 = 72.0;
const RIGHT: f64 = 24.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 58.0;
const LEGEND_ROW: f64 = 20.0;
/// Mean width of a letter at 13 pixels, for the layout of the legend.
const LETTER: f64 = 7.1;
/// Maximum length of a name in a legend, letters; longer ones are shortened.
const LONGEST_NAME: usize = 40;
const PALETTE: [&str; 7] = [
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000",
];

/// Title, labels and axes of a plot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlotOptions {
    /// Heading.
    pub title: String,
    /// Label of the x axis, with its unit.
    pub x_label: String,
    /// Label of the y axis, with its unit.
    pub y_label: String,
    /// Scale of the x axis; bar plots ignore it.
    pub x: Scale,
    /// Scale of the y axis, which begins at zero if it is linear; bar plots ignore it.
    pub y_scale: Scale,
    /// Format of y values.
    pub y: ValueFormat,
    /// A y value to mark with a labelled line, such as a target.
    pub target: Option<(f64, String)>,
}

/// Scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Scale {
    /// Linear.
    #[default]
    Linear,
    /// Logarithmic; of an x axis the points' own values are labelled. Points at or below zero are
    /// left out.
    Logarithmic,
}

impl Scale {
    fn spacing(self) -> Spacing {
        match self {
            Self::Linear => Spacing::Linear,
            Self::Logarithmic => Spacing::Logarithmic,
        }
    }

    /// The label of an axis, which says so where equal steps are equal factors.
    fn named(self, label: &str) -> String {
        match self {
            Self::Linear => label.to_owned(),
            Self::Logarithmic => format!("{label}, geometric scale"),
        }
    }
}

/// Number format of the values of a plot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ValueFormat {
    /// Plain numbers.
    #[default]
    Plain,
    /// Fractions, as percentages.
    Percent,
}

/// A named line of points.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Name in the legend.
    pub name: String,
    /// Points in the order in which they are joined. A point that is not finite interrupts the
    /// line.
    pub points: Vec<(f64, f64)>,
    /// Whether the line is dashed.
    pub dashed: bool,
}

/// A named set of bars, one per category.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BarSeries {
    /// Name in the legend.
    pub name: String,
    /// One value per category; a value that is not finite has no bar.
    pub values: Vec<f64>,
}

/// Returns a line plot as SVG text. Points have markers while a series has at most forty of them.
pub fn line_plot(options: &PlotOptions, series: &[Series]) -> String {
    let finite = |p: &(f64, f64)| {
        let is_shown = |scale: Scale, v: f64| v.is_finite() && (scale == Scale::Linear || v > 0.0);
        is_shown(options.x, p.0) && is_shown(options.y_scale, p.1)
    };
    let all: Vec<(f64, f64)> = series
        .iter()
        .flat_map(|s| s.points.iter().copied().filter(finite))
        .collect();
    let x = Axis::through(all.iter().map(|p| p.0), options.x.spacing());
    let y = match options.y_scale {
        Scale::Linear => vertical(options, all.iter().map(|p| p.1)),
        Scale::Logarithmic => {
            let target = options.target.iter().map(|(value, _)| *value);
            let target = target.filter(|v| v.is_finite() && *v > 0.0);
            Axis::through(all.iter().map(|p| p.1).chain(target), Spacing::Logarithmic)
        }
    };
    let names: Vec<&str> = series.iter().map(|s| s.name.as_str()).collect();
    let mut plot = Canvas::new(options, &names, y);
    plot.grid(options);
    for (value, label) in x.ticks(all.iter().map(|p| p.0)) {
        plot.x_tick(plot.x_at(&x, value), &label);
    }
    for (i, line) in series.iter().enumerate() {
        let points: Vec<Option<(f64, f64)>> = line
            .points
            .iter()
            .map(|p| finite(p).then(|| (plot.x_at(&x, p.0), plot.y_at(p.1))))
            .collect();
        plot.line(i, line, &points);
    }
    plot.finish(options, [options.x, options.y_scale])
}

/// Returns a bar plot as SVG text, with bars from zero, side by side in each category.
pub fn bar_plot(options: &PlotOptions, categories: &[String], series: &[BarSeries]) -> String {
    let values = series.iter().flat_map(|s| s.values.iter().copied());
    let y = vertical(options, values.filter(|v| v.is_finite()));
    let names: Vec<&str> = series.iter().map(|s| s.name.as_str()).collect();
    let mut plot = Canvas::new(options, &names, y);
    plot.grid(options);
    let slot = (WIDTH - LEFT - RIGHT) / categories.len().max(1) as f64;
    let bar = 0.76 * slot / series.len().max(1) as f64;
    for (c, category) in categories.iter().enumerate() {
        let left = LEFT + slot * c as f64;
        let room = (slot / LETTER) as usize;
        plot.x_tick(left + 0.5 * slot, &shortened(category, room.max(3)));
        for (i, set) in series.iter().enumerate() {
            let value = set.values.get(c).copied().filter(|v| v.is_finite());
            if let Some(value) = value {
                let x = left + 0.12 * slot + bar * i as f64;
                let hint = format!("{}, {category}: {}", set.name, written(options.y, value));
                plot.bar(i, (x, bar), value, &hint);
            }
        }
    }
    plot.finish(options, [Scale::Linear; 2])
}

/// The y axis: from zero (or the least value below it) to the greatest value or target.
fn vertical(options: &PlotOptions, values: impl Iterator<Item = f64>) -> Axis {
    let target = options.target.iter().map(|(value, _)| *value);
    let target = target.filter(|v| v.is_finite());
    Axis::through(values.chain(target).chain([0.0]), Spacing::Linear)
}

/// A plot under construction.
struct Canvas {
    svg: String,
    top: f64,
    height: f64,
    y: Axis,
}

impl Canvas {
    fn new(options: &PlotOptions, names: &[&str], y: Axis) -> Self {
        let legend = Legend::new(names);
        let top = TOP + LEGEND_ROW * legend.rows as f64;
        let height = HEIGHT + LEGEND_ROW * legend.rows as f64;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
             width=\"{WIDTH}\" height=\"{height}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"13\" fill=\"#1c1e24\">\n"
        );
        let title = escaped(&options.title);
        let _ = write!(
            svg,
            "<title>{title}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
             <text x=\"{LEFT}\" y=\"28\" font-size=\"17\" font-weight=\"bold\">{title}</text>\n"
        );
        legend.draw(&mut svg);
        Self {
            svg,
            top,
            height,
            y,
        }
    }

    fn bottom(&self) -> f64 {
        self.height - BOTTOM
    }

    fn x_at(&self, axis: &Axis, value: f64) -> f64 {
        LEFT + (WIDTH - LEFT - RIGHT) * axis.share(value)
    }

    fn y_at(&self, value: f64) -> f64 {
        self.bottom() - (self.bottom() - self.top) * self.y.share(value)
    }

    fn grid(&mut self, options: &PlotOptions) {
        let right = WIDTH - RIGHT;
        let scale = match options.y {
            ValueFormat::Plain => 1.0,
            ValueFormat::Percent => 100.0,
        };
        for value in self.y.grid_values() {
            let y = self.y_at(value);
            let color = if value == 0.0 { "#8a8f99" } else { "#e3e6eb" };
            let unit = if options.y == ValueFormat::Percent {
                " %"
            } else {
                ""
            };
            let label = self.y.label(value, scale);
            let _ = write!(
                self.svg,
                "<path d=\"M{LEFT} {y:.2}H{right}\" stroke=\"{color}\"/>\n\
                 <text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"end\">{label}{unit}</text>\n",
                LEFT - 8.0,
                y + 4.5,
            );
        }
    }

    fn x_tick(&mut self, x: f64, label: &str) {
        let (bottom, label) = (self.bottom(), escaped(label));
        let _ = write!(
            self.svg,
            "<path d=\"M{x:.2} {bottom:.2}v5\" stroke=\"#8a8f99\"/>\n\
             <text x=\"{x:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{label}</text>\n",
            bottom + 20.0,
        );
    }

    fn line(&mut self, index: usize, series: &Series, points: &[Option<(f64, f64)>]) {
        let mut path = String::new();
        let mut pen_is_down = false;
        for point in points {
            if let Some((x, y)) = point {
                let verb = if pen_is_down { 'L' } else { 'M' };
                let _ = write!(path, "{verb}{x:.2} {y:.2}");
            }
            pen_is_down = point.is_some();
        }
        let color = color(index);
        let dash = dash(series.dashed);
        let _ = writeln!(
            self.svg,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\" \
             stroke-linejoin=\"round\"{dash}><title>{}</title></path>",
            escaped(&series.name),
        );
        if points.len() <= 40 {
            for (x, y) in points.iter().flatten() {
                marker(&mut self.svg, index, *x, *y);
            }
        }
    }

    fn bar(&mut self, index: usize, (x, width): (f64, f64), value: f64, hint: &str) {
        let (zero, end) = (self.y_at(0.0), self.y_at(value));
        let _ = writeln!(
            self.svg,
            "<rect x=\"{x:.2}\" y=\"{:.2}\" width=\"{width:.2}\" height=\"{:.2}\" \
             fill=\"{}\" stroke=\"#fff\"><title>{}</title></rect>",
            zero.min(end),
            (zero - end).abs(),
            color(index),
            escaped(hint),
        );
    }

    /// A dotted line at the target, over the data so that its label stays readable.
    fn target(&mut self, options: &PlotOptions) {
        let target = options.target.as_ref();
        if let Some((value, label)) = target.filter(|(v, _)| self.y.share(*v).is_finite()) {
            let (y, right) = (self.y_at(*value), WIDTH - RIGHT);
            let label = escaped(label);
            let _ = write!(
                self.svg,
                "<path d=\"M{LEFT} {y:.2}H{right}\" stroke=\"#5c616c\" stroke-dasharray=\"2 3\"/>\n\
                 <text x=\"{right}\" y=\"{:.2}\" text-anchor=\"end\" fill=\"#5c616c\" \
                 stroke=\"#fff\" stroke-width=\"4\" paint-order=\"stroke\">{label}</text>\n",
                y - 5.0,
            );
        }
    }

    /// Labels the axes, with their scales, and ends the text.
    fn finish(mut self, options: &PlotOptions, [x, y]: [Scale; 2]) -> String {
        self.target(options);
        let middle = 0.5 * (self.top + self.bottom());
        let _ = write!(
            self.svg,
            "<text x=\"{:.2}\" y=\"{:.2}\" text-anchor=\"middle\">{}</text>\n\
             <text transform=\"translate(18 {middle:.2}) rotate(-90)\" \
             text-anchor=\"middle\">{}</text>\n</svg>\n",
            0.5 * (LEFT + WIDTH - RIGHT),
            self.height - 14.0,
            escaped(&x.named(&options.x_label)),
            escaped(&y.named(&options.y_label)),
        );
        self.svg
    }
}

/// Names of the series in rows above the plot; none for a single unnamed series.
struct Legend {
    entries: Vec<(f64, usize, String)>,
    rows: usize,
}

impl Legend {
    fn new(names: &[&str]) -> Self {
        let mut entries = Vec::new();
        let (mut x, mut row) = (LEFT, 0);
        for name in names.iter().filter(|_| names.iter().any(|n| !n.is_empty())) {
            let name = shortened(name, LONGEST_NAME);
            let width = 44.0 + LETTER * name.chars().count() as f64;
            if x + width > WIDTH - RIGHT && x > LEFT {
                (x, row) = (LEFT, row + 1);
            }
            entries.push((x, row, name));
            x += width;
        }
        let rows = if entries.is_empty() { 0 } else { row + 1 };
        Self { entries, rows }
    }

    fn draw(&self, svg: &mut String) {
        for (i, (x, row, name)) in self.entries.iter().enumerate() {
            let y = TOP + LEGEND_ROW * *row as f64 - 2.0;
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.2} {y:.2}h22\" stroke=\"{}\" stroke-width=\"2\"/>",
                color(i),
            );
            marker(svg, i, x + 11.0, y);
            let _ = writeln!(
                svg,
                "<text x=\"{:.2}\" y=\"{:.2}\">{}</text>",
                x + 28.0,
                y + 4.5,
                escaped(name),
            );
        }
    }
}

/// Marker of a series: disc, square, diamond or triangle in turn.
fn marker(svg: &mut String, index: usize, x: f64, y: f64) {
    let shape = match index % 4 {
        0 => "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0",
        1 => "m-3.5-3.5h7v7h-7z",
        2 => "m0-5l5 5-5 5-5-5z",
        _ => "m0-5l4.8 8.5h-9.6z",
    };
    let color = color(index);
    let _ = writeln!(
        svg,
        "<path d=\"M{x:.2} {y:.2}{shape}\" fill=\"{color}\" stroke=\"#fff\"/>"
    );
}

fn color(index: usize) -> &'static str {
    PALETTE[index % PALETTE.len()]
}

fn dash(dashed: bool) -> &'static str {
    if dashed {
        " stroke-dasharray=\"7 5\""
    } else {
        ""
    }
}

fn written(values: ValueFormat, value: f64) -> String {
    match values {
        ValueFormat::Plain => format!("{value:.3}"),
        ValueFormat::Percent => format!("{:.1} %", value * 100.0),
    }
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most.saturating_sub(1)).collect();
    kept + "\u{2026}"
}

/// Text escaped for one line of markup.
fn escaped(text: &str) -> String {
    let line = text.replace(['\t', '\n', '\r'], " ");
    articula::flat::escaped(&line).replace('\'', "&#39;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(title: &str) -> PlotOptions {
        PlotOptions {
            title: title.into(),
            ..PlotOptions::default()
        }
    }

    /// Text content of an element that begins with `head`.
    fn data_path(svg: &str) -> &str {
        let at = svg.find("fill=\"none\"").unwrap();
        let start = svg[..at].rfind("d=\"").unwrap() + 3;
        &svg[start..at - 2]
    }

    #[test]
    fn points_land_where_the_axes_say() {
        let series = Series {
            points: vec![(0.0, 0.0), (5.0, 0.5), (f64::NAN, 1.0), (10.0, 1.0)],
            ..Series::default()
        };
        let svg = line_plot(&options("t"), &[series]);
        // The data area is 72..736 by 372..52; the x axis runs from 0 to 10, y from 0 to 1.
        assert_eq!(data_path(&svg), "M72.00 372.00L404.00 212.00M736.00 52.00");
    }

    #[test]
    fn bars_stand_on_zero_in_both_directions() {
        let set = BarSeries {
            name: "a".into(),
            values: vec![1.0, -1.0, f64::INFINITY],
        };
        let svg = bar_plot(&options("t"), &["x".into(), "y".into(), "z".into()], &[set]);
        assert_eq!(svg.matches("<rect x=").count(), 2);
        assert_eq!(svg.matches("height=\"160.00\"").count(), 2);
    }

    #[test]
    fn text_from_files_cannot_break_out() {
        let evil = "</title><script>alert('x')</script>&\u{0}\"";
        let series = Series {
            name: evil.into(),
            points: vec![(1.0, 1.0)],
            ..Series::default()
        };
        let bars = BarSeries {
            name: evil.into(),
            values: vec![1.0],
        };
        let named = PlotOptions {
            x_label: evil.into(),
            y_label: evil.into(),
            target: Some((1.0, evil.into())),
            ..options(evil)
        };
        for svg in [
            line_plot(&named, &[series]),
            bar_plot(&named, &[evil.into()], &[bars]),
        ] {
            assert!(!svg.contains("<script") && !svg.contains('\u{0}'));
            let bare = |rest: &str| !rest.starts_with(['a', 'l', 'g', 'q', '#']);
            assert!(!svg.split('&').skip(1).any(bare), "a bare ampersand");
            assert_eq!(
                svg.matches("</title>").count(),
                svg.matches("<title>").count()
            );
        }
    }

    #[test]
    fn odd_input_gives_finite_places() {
        let point = |p| Series {
            points: vec![p],
            ..Series::default()
        };
        let odd = [
            point((f64::NAN, 1.0)),
            point((-1.0, f64::INFINITY)),
            point((0.0, 0.0)),
        ];
        let logarithmic = PlotOptions {
            x: Scale::Logarithmic,
            ..options("odd")
        };
        let both = PlotOptions {
            y_scale: Scale::Logarithmic,
            target: Some((0.0, "zero".into())),
            ..logarithmic.clone()
        };
        for svg in [
            line_plot(&logarithmic, &odd),
            line_plot(&both, &odd),
            line_plot(&both, &[point((2.0, 3.0)), point((4.0, 0.0))]),
            line_plot(&options("none"), &[]),
            line_plot(&options("huge"), &[point((1e300, -1e300))]),
            bar_plot(&options("none"), &[], &[]),
        ] {
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
