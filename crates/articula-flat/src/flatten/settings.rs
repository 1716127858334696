//! Output profiles and their tolerances.

use crate::planar::shading::Shading;
use crate::vector::player::PlayerOutput;
use crate::vector::thesis::ThesisSvgOptions;
use std::fmt;

/// Output format of a 2D conversion: a kind of SVG, a JavaScript module or Lottie JSON.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Profile {
    /// One key-framed SVG without script.
    Smil,
    /// One SVG with a group for each frame.
    Flipbook,
    /// One SVG or JavaScript module with a low-rank clip and a small script.
    Player(PlayerOutput),
    /// Lottie JSON.
    Lottie,
    /// One frame as SVG.
    Still {
        /// Index of the frame.
        frame: usize,
        /// Whether red, green and blue are painted separately, which is exact inside the character.
        exact: bool,
    },
    /// The SVG of the thesis, as a baseline.
    Thesis(ThesisSvgOptions),
}

impl fmt::Display for Profile {
    /// Writes the name used on the command line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Smil => "smil",
            Self::Flipbook => "flipbook",
            Self::Player(_) => "player",
            Self::Lottie => "lottie",
            Self::Still { .. } => "still",
            Self::Thesis(_) => "thesis",
        })
    }
}

impl Profile {
    /// Features that a client must support to show the file.
    pub(crate) fn needs(self) -> Vec<&'static str> {
        match self {
            Self::Smil | Self::Flipbook | Self::Thesis(_) => vec!["svg", "smil"],
            Self::Player(PlayerOutput::Svg) => vec!["svg", "script", "canvas"],
            Self::Player(PlayerOutput::Module) => vec!["script", "canvas"],
            Self::Lottie => vec!["lottie"],
            Self::Still { exact: true, .. } => vec!["svg", "mix-blend-mode"],
            Self::Still { exact: false, .. } => vec!["svg"],
        }
    }
}

/// A tolerance that has no effect.
const ANY: f32 = 16.0;

/// Shading of a 2D file, and its tolerances in position and colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Shading of the triangles.
    pub shading: Shading,
    /// Position tolerance of a corner, pixels.
    pub pos_tol_px: f32,
    /// Colour tolerance, levels.
    pub col_tol_levels: f32,
    /// Neighbours whose colours differ by at most this many levels become one shape (flat shading).
    pub merge_levels: Option<f32>,
}

impl Quality {
    /// Returns the default of a profile: half a pixel and 8 levels, for the player 0.1 pixels and
    /// one level.
    pub fn of(profile: Profile) -> Self {
        let is_player = matches!(profile, Profile::Player(_));
        Self {
            shading: match profile {
                Profile::Thesis(options) if !options.form.is_gouraud() => Shading::Flat,
                _ => Shading::Gouraud,
            },
            pos_tol_px: if is_player { 0.1 } else { 0.5 },
            col_tol_levels: if is_player { 1.0 } else { 8.0 },
            merge_levels: None,
        }
    }

    /// The last of the quality steps of a profile, with the fewest bytes; what is usual where it has none.
    pub fn coarsest(profile: Profile) -> Self {
        let last = Self::steps(profile).pop();
        last.unwrap_or_else(|| Self::of(profile))
    }

    /// Quality steps that a byte budget is searched on (`docs/methods/vector.md` 9). Within one
    /// kind of filling, each step is coarser than the one before; empty for profiles without
    /// settings.
    pub(crate) fn steps(profile: Profile) -> Vec<Self> {
        let step = |shading, pos_tol_px, col_tol_levels, merge_levels| Self {
            shading,
            pos_tol_px,
            col_tol_levels,
            merge_levels,
        };
        let (gouraud, flat) = (Shading::Gouraud, Shading::Flat);
        match profile {
            Profile::Player(_) => vec![
                step(gouraud, 0.05, 0.5, None),
                step(gouraud, 0.1, 1.0, None),
                step(gouraud, 0.2, 2.0, None),
                step(gouraud, 0.4, 4.0, None),
                step(gouraud, 0.8, 8.0, None),
                step(flat, 0.4, 4.0, None),
                step(flat, 0.8, 8.0, None),
                step(flat, 1.6, 16.0, None),
            ],
            // Every frame has its own corners, so tolerances change nothing.
            Profile::Flipbook => vec![
                step(flat, ANY, ANY, None),
                step(flat, ANY, ANY, Some(7.0)),
                step(flat, ANY, ANY, Some(14.0)),
                step(flat, ANY, ANY, Some(28.0)),
            ],
            Profile::Still { .. } => vec![step(flat, ANY, ANY, None)],
            Profile::Thesis(_) => Vec::new(),
            _ => vec![
                step(gouraud, 0.25, 4.0, None),
                step(gouraud, 0.5, 8.0, None),
                step(gouraud, 1.0, 12.0, None),
                step(gouraud, 2.0, 20.0, None),
                step(flat, 0.25, 8.0, None),
                step(flat, 0.5, 8.0, None),
                step(flat, 1.0, 8.0, None),
                step(flat, 0.5, 8.0, Some(14.0)),
                step(flat, 1.0, 8.0, Some(14.0)),
                step(flat, 2.0, 8.0, Some(14.0)),
                step(flat, 2.0, 8.0, Some(28.0)),
                step(flat, 4.0, 8.0, Some(28.0)),
            ],
        }
    }
}

/// Settings for converting a clip to one 2D file: format, quality and maximum size.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Output format.
    pub profile: Profile,
    /// Tolerances; with a budget, the finest that may be chosen.
    pub quality: Quality,
    /// Title of the file.
    pub name: String,
    /// Maximum size of the file, bytes; `None` for no limit.
    pub max_bytes: Option<u64>,
}
