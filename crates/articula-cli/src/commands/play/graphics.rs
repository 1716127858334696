//! Terminals that show pixels.

use super::{kitty, sixel};
use articula::flat::Picture;

/// Most pixels of a picture, which software draws 20 times a second; with the protocol of kitty the terminal enlarges it.
const MOST_PIXELS: u32 = 480 * 640;
/// Width and height of a cell where the terminal does not tell.
const CELL_PX: (u32, u32) = (8, 16);
/// Values of `TERM` and of `TERM_PROGRAM` of terminals with the graphics protocol of kitty.
const KITTY: ([&str; 2], [&str; 2]) = (["xterm-kitty", "xterm-ghostty"], ["ghostty", "WezTerm"]);
/// Those of terminals with Sixel.
const SIXEL: ([&str; 5], [&str; 3]) = (
    ["foot", "foot-extra", "mlterm", "contour", "yaft-256color"],
    ["mintty", "iTerm.app", "contour"],
);

/// How pixels are sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Protocol {
    Kitty,
    Sixel,
}

/// A terminal that shows pixels.
pub(super) struct Graphics {
    protocol: Protocol,
    /// Width and height of a cell in pixels.
    cell_px: (u32, u32),
}

impl Graphics {
    /// What the terminal of the environment shows; `variable` returns variables of it.
    pub(super) fn of_environment(variable: impl Fn(&str) -> Option<String>) -> Option<Self> {
        let is = |name: &str, wanted: &[&str]| {
            variable(name).is_some_and(|value| wanted.contains(&value.as_str()))
        };
        // A terminal within another one passes no pictures on.
        if variable("TMUX").is_some() || variable("STY").is_some() {
            return None;
        }
        let protocol = if is("TERM", &KITTY.0) || is("TERM_PROGRAM", &KITTY.1) {
            Protocol::Kitty
        } else if is("TERM", &SIXEL.0) || is("TERM_PROGRAM", &SIXEL.1) {
            Protocol::Sixel
        } else {
            return None;
        };
        Some(Self {
            protocol,
            cell_px: cell_px(),
        })
    }

    /// Width and height of a picture that fills some columns and rows.
    pub(super) fn size(&self, columns: u32, rows: u32) -> (u32, u32) {
        let (width, height) = (columns * self.cell_px.0, rows * self.cell_px.1);
        let scale = (f64::from(MOST_PIXELS) / (f64::from(width) * f64::from(height)))
            .sqrt()
            .min(1.0);
        let scaled = |pixels: u32| ((f64::from(pixels) * scale) as u32).max(2);
        (scaled(width), scaled(height))
    }

    /// A picture over some columns and rows, from the cursor on, which stays. It takes the place of the one before.
    pub(super) fn shown(
        &self,
        picture: &Picture,
        columns: u32,
        rows: u32,
    ) -> anyhow::Result<String> {
        match self.protocol {
            Protocol::Kitty => kitty::shown(picture, columns, rows),
            Protocol::Sixel => Ok(sixel::shown(picture)),
        }
    }
}

#[cfg(unix)]
fn cell_px() -> (u32, u32) {
    let Ok(size) = rustix::termios::tcgetwinsize(std::io::stdout()) else {
        return CELL_PX;
    };
    let of = |pixels: u16, cells: u16| {
        u32::from(pixels)
            .checked_div(u32::from(cells))
            .filter(|px| *px > 0)
    };
    of(size.ws_xpixel, size.ws_col)
        .zip(of(size.ws_ypixel, size.ws_row))
        .unwrap_or(CELL_PX)
}

#[cfg(not(unix))]
fn cell_px() -> (u32, u32) {
    CELL_PX
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(variables: &[(&str, &str)]) -> Option<Graphics> {
        Graphics::of_environment(|name| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        })
    }

    #[test]
    fn terminals_that_show_pixels_are_known_by_their_names() {
        let protocol = |variables: &[(&str, &str)]| of(variables).map(|graphics| graphics.protocol);
        let in_xterm =
            |program: &str| protocol(&[("TERM", "xterm-256color"), ("TERM_PROGRAM", program)]);
        assert_eq!(protocol(&[("TERM", "xterm-kitty")]), Some(Protocol::Kitty));
        assert_eq!(protocol(&[("TERM", "foot")]), Some(Protocol::Sixel));
        assert_eq!(in_xterm("WezTerm"), Some(Protocol::Kitty));
        assert_eq!(in_xterm("mintty"), Some(Protocol::Sixel));
        assert_eq!(in_xterm("Apple_Terminal"), None);
        assert_eq!(
            protocol(&[("TERM", "xterm-kitty"), ("TMUX", "a,1,0")]),
            None
        );
        assert_eq!(protocol(&[]), None);
    }

    #[test]
    fn a_picture_fills_its_cells_up_to_a_number_of_pixels() {
        let graphics = Graphics {
            protocol: Protocol::Kitty,
            cell_px: (10, 20),
        };
        assert_eq!(graphics.size(20, 10), (200, 200));
        let (width, height) = graphics.size(160, 55);
        assert!(width * height <= MOST_PIXELS && width * height > MOST_PIXELS * 99 / 100);
    }
}
