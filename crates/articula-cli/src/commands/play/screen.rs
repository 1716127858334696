//! Pictures in a terminal: as pixels where it shows them, else two above each other are one character, a half block in two
//! colours.

use super::graphics::Graphics;
use anyhow::Context;
use articula::flat::Picture;
use std::fmt::Write as _;
use std::io::{IsTerminal, Write as _};
use terminal_size::{Height, Width, terminal_size};

/// Most columns and rows that are drawn.
const MOST: (u16, u16) = (160, 60);
/// Rows of a monitor.
const MONITOR_ROWS: u32 = 5;

/// A terminal.
pub(crate) struct Screen {
    columns: u32,
    rows: u32,
    /// Height of the picture that is shown, pixels; 0 without one.
    shown_rows: u32,
    /// Nothing for half blocks.
    graphics: Option<Graphics>,
}

impl Screen {
    /// The terminal of standard output, if it is one.
    pub(crate) fn new() -> Option<Self> {
        if !std::io::stdout().is_terminal() {
            return None;
        }
        let (Width(columns), Height(rows)) = terminal_size()?;
        Some(Self {
            columns: u32::from(columns.clamp(10, MOST.0)),
            rows: u32::from(rows.clamp(12, MOST.1)),
            shown_rows: 0,
            graphics: Graphics::of_environment(|name| std::env::var(name).ok()),
        })
    }

    /// Width and height of a picture that fills it, in pixels, with a monitor below it or one line.
    pub(crate) fn size(&self, has_monitor: bool) -> (u32, u32) {
        let rows = self.picture_rows(has_monitor);
        match &self.graphics {
            Some(graphics) => graphics.size(self.columns, rows),
            None => (self.columns, 2 * rows),
        }
    }

    fn picture_rows(&self, has_monitor: bool) -> u32 {
        self.rows - if has_monitor { MONITOR_ROWS } else { 1 }
    }

    /// Draws a picture over the one before, and lines of text below it.
    pub(crate) fn show(&mut self, picture: &Picture, below: &[String]) -> anyhow::Result<()> {
        let mut text = String::new();
        if self.shown_rows != picture.height() {
            text.push_str("\x1b[2J");
            self.shown_rows = picture.height();
        }
        text.push_str("\x1b[H");
        match &self.graphics {
            Some(graphics) => {
                let rows = self.picture_rows(below.len() > 1);
                text.push_str(&graphics.shown(picture, self.columns, rows)?);
                // Writing to a string cannot fail.
                let _ = write!(text, "\x1b[{};1H", rows + 1);
            }
            None => text.push_str(&blocks(picture)),
        }
        for (number, line) in below.iter().enumerate() {
            if number > 0 {
                text.push_str("\r\n");
            }
            text.extend(line.chars().take(self.columns as usize));
            text.push_str("\x1b[K");
        }
        let mut out = std::io::stdout().lock();
        let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
        written.context("standard output")
    }
}

/// A picture as lines of half blocks; a color is named where it changes.
fn blocks(picture: &Picture) -> String {
    let mut text = String::new();
    for row in 0..picture.height() / 2 {
        let mut last = None;
        for column in 0..picture.width() {
            let of = |y| {
                let [r, g, b, _] = picture.get(column, y).unwrap_or_default();
                (r, g, b)
            };
            let colors = (of(2 * row), of(2 * row + 1));
            if last != Some(colors) {
                let ((r, g, b), (s, h, c)) = colors;
                // Writing to a string cannot fail.
                let _ = write!(text, "\x1b[38;2;{r};{g};{b};48;2;{s};{h};{c}m");
                last = Some(colors);
            }
            text.push('▀');
        }
        text.push_str("\x1b[0m\r\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_rows_of_pixels_are_a_row_of_half_blocks() {
        let (red, blue) = ([255, 0, 0, 255], [0, 0, 255, 255]);
        let pixels = vec![red, red, red, blue, blue, red];
        let picture = Picture::from_pixels(3, 2, pixels).unwrap();
        let colors = |a: &str, b: &str| format!("\x1b[38;2;{a};48;2;{b}m");
        let (red, blue) = ("255;0;0", "0;0;255");
        let wanted = format!("{}▀▀{}▀\x1b[0m\r\n", colors(red, blue), colors(red, red));
        assert_eq!(blocks(&picture), wanted);
    }
}
