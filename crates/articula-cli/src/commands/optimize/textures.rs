//! Arguments for textures.

use articula::optimize::{TextureFormat, TextureOptions};
use clap::{Args, ValueEnum};

#[derive(Debug, Args)]
pub(super) struct TextureArgs {
    /// Longest side of textures in pixels; larger ones are made smaller. auto: as many texels as a figure of
    /// --height-px can show [default: sizes stay]
    #[arg(long, value_name = "N|auto|keep", value_parser = size)]
    texture_size: Option<Size>,
    /// Format of textures: auto (the smallest of PNG, JPEG and WebP at which no difference is seen; no WebP
    /// in VRM files nor with --compress none), webp, jpeg (PNG with alpha), png, keep
    #[arg(long, value_enum, value_name = "KIND", default_value_t = Kind::Auto)]
    texture_format: Kind,
    /// Quality of lossy textures, 1 to 100, whatever they then look like [default: the least at which no
    /// difference is seen]
    #[arg(long, value_name = "Q", value_parser = clap::value_parser!(u8).range(1..=100))]
    texture_quality: Option<u8>,
}

/// The longest side, what is seen of it, or all sizes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Size {
    Keep,
    Auto,
    Longest(u32),
}

fn size(text: &str) -> Result<Size, String> {
    match text.trim() {
        "keep" => Ok(Size::Keep),
        "auto" => Ok(Size::Auto),
        number => match number.parse() {
            Ok(longest) if longest > 0 => Ok(Size::Longest(longest)),
            _ => Err("expected a number of pixels above 0, auto or keep".to_owned()),
        },
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Auto,
    Webp,
    Jpeg,
    Png,
    Keep,
}

impl TextureArgs {
    /// The options for a figure that is shown with a height in pixels.
    pub(super) fn options(&self, height_px: f32) -> TextureOptions {
        TextureOptions {
            longest_px: match self.texture_size {
                Some(Size::Longest(longest)) => Some(longest),
                Some(Size::Keep | Size::Auto) | None => None,
            },
            screen_height_px: match self.texture_size {
                Some(Size::Auto) => Some(height_px.ceil() as u32),
                _ => None,
            },
            format: match self.texture_format {
                Kind::Auto => TextureFormat::Auto,
                Kind::Webp => TextureFormat::Webp,
                Kind::Jpeg => TextureFormat::Jpeg,
                Kind::Png => TextureFormat::Png,
                Kind::Keep => TextureFormat::Keep,
            },
            quality: self.texture_quality,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_pixels_above_zero() {
        assert_eq!(size("512"), Ok(Size::Longest(512)));
        assert_eq!(size("keep"), Ok(Size::Keep));
        assert_eq!(size("auto"), Ok(Size::Auto));
        for bad in ["", "0", "-1", "1.5", "all"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }
}
