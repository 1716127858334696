//! Plots with file names, and several plots in one SVG.

/// A plot with the name of its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plot {
    /// File name without folder.
    pub name: &'static str,
    /// SVG text from [`crate::line_plot`] or [`crate::bar_plot`].
    pub svg: String,
}

/// Returns several plots below each other as one SVG.
pub fn stacked(plots: &[Plot]) -> String {
    let size = |svg: &str, what: &str| {
        let rest = svg.split_once(&format!(" {what}=\""))?.1;
        rest.split_once('"')?.0.parse::<f64>().ok()
    };
    let mut inner = String::new();
    let (mut width, mut height) = (0.0f64, 0.0f64);
    for plot in plots {
        let nested = plot
            .svg
            .replacen("<svg ", &format!("<svg y=\"{height}\" "), 1);
        inner.push_str(&nested);
        width = width.max(size(&plot.svg, "width").unwrap_or(0.0));
        height += size(&plot.svg, "height").unwrap_or(0.0);
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">\n{inner}</svg>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PlotOptions, line_plot};

    #[test]
    fn stacked_plots_stand_below_each_other() {
        let plot = || Plot {
            name: "p.svg",
            svg: line_plot(&PlotOptions::default(), &[]),
        };
        let one = stacked(&[plot()]);
        let two = stacked(&[plot(), plot()]);
        let height = |svg: &str| -> f64 {
            let rest = svg.split_once(" height=\"").unwrap().1;
            rest.split_once('"').unwrap().0.parse().unwrap()
        };
        assert!((height(&two) - 2.0 * height(&one)).abs() < 1e-9);
        assert_eq!(two.matches("<svg ").count(), 3);
        assert!(two.contains(&format!("y=\"{}\"", height(&one))));
    }
}
