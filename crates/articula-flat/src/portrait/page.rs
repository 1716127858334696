//! An HTML page that shows a portrait, with player, document and pictures in one file.

use super::document::{PLAYER, PictureFormat, encoded};
use super::error::PortraitError;
use super::model::Portrait;
use crate::markup::escaped;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A file embedded in a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EmbeddedFile {
    /// Media type, such as `image/png` or `audio/mpeg`.
    pub media_type: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// A picture of a slide-show behind a portrait.
#[derive(Debug, Clone, PartialEq)]
pub struct Slide {
    /// Time in the clip from which it is shown, seconds.
    pub from_secs: f64,
    /// PNG, JPEG or WebP.
    pub picture: EmbeddedFile,
}

/// Options of the HTML page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PageOptions {
    /// Title of the page.
    pub title: String,
    /// Pictures behind the portrait, the earliest first; the last that has begun is shown, and none before
    /// the first.
    pub background: Vec<Slide>,
    /// Sound that the clip is synchronised to.
    pub audio: Option<EmbeddedFile>,
    /// Whether the page has its title as a heading, a canvas as large as fits, on which a drag turns the
    /// head, and buttons and sliders for the head and all expressions. Without them it is the canvas alone,
    /// in the size of the portrait.
    pub controls: bool,
}

/// Returns an HTML page that plays the first clip, or sweeps the head from side to side without
/// one.
///
/// `window.articulaSeek(seconds)` shows a time, `window.articulaFrames` counts painted frames, and messages
/// of the window around it drive the face (`docs/formats/portrait.md`).
///
/// # Errors
/// As [`Portrait::to_files`].
pub fn page(portrait: &Portrait, options: &PageOptions) -> Result<String, PortraitError> {
    let mut out = String::from("<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n");
    let _ = writeln!(out, "<title>{}</title>", escaped(&options.title));
    let _ = write!(
        out,
        "<meta name=\"viewport\" content=\"width=device-width\">\n{POLICY}<style>\n{STYLE}</style>\n"
    );
    if options.controls {
        let title = escaped(&options.title);
        let _ = writeln!(out, "<body class=\"controlled\">\n<h1>{title}</h1>\n<main>");
    }
    let (width, height) = portrait.size;
    let _ = writeln!(
        out,
        "<canvas id=\"portrait\" width=\"{width}\" height=\"{height}\" role=\"img\" aria-label={}></canvas>",
        attribute(&options.title),
    );
    if let Some(audio) = &options.audio {
        let _ = writeln!(
            out,
            "<audio id=\"audio\" controls src={}></audio>",
            uri(audio)
        );
    }
    if options.controls {
        out.push_str("<div id=\"controls\"></div>\n</main>\n");
    }
    let _ = write!(
        out,
        "<script>\n{PLAYER}</script>\n<script>\n\"use strict\";\n"
    );
    let format = PictureFormat::default();
    // Names are the only text in the document, and they are escaped for scripts.
    let _ = writeln!(
        out,
        "const json = {};",
        portrait.to_json(format)?.trim_end()
    );
    let mut pictures = Vec::new();
    for view in &portrait.views {
        pictures.push(uri(&EmbeddedFile {
            media_type: format.media_type().to_owned(),
            bytes: encoded(&view.picture, format)?,
        }));
    }
    let _ = writeln!(out, "const pictures = [{}];", pictures.join(","));
    let _ = writeln!(out, "const behind = {};", behind(&options.background));
    out.push_str(SCRIPT);
    out.push_str("</script>\n</html>\n");
    Ok(out)
}

/// The pictures behind the portrait, for scripts.
fn behind(slides: &[Slide]) -> String {
    let slide = |s: &Slide| {
        format!(
            "{{\"from\":{},\"picture\":{}}}",
            s.from_secs,
            uri(&s.picture)
        )
    };
    match slides {
        [] => "null".to_owned(),
        _ => format!(
            "[{}]",
            slides.iter().map(slide).collect::<Vec<_>>().join(",")
        ),
    }
}

/// The file as a data URI in quotation marks, valid in scripts and in attributes.
fn uri(file: &EmbeddedFile) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "/+-.;=".contains(c);
    let media_type: String = file.media_type.chars().filter(|c| plain(*c)).collect();
    format!(
        "\"data:{media_type};base64,{}\"",
        STANDARD.encode(&file.bytes)
    )
}

fn attribute(text: &str) -> String {
    format!("\"{}\"", escaped(text))
}

/// Nothing is loaded from elsewhere, and nothing is sent.
const POLICY: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
     media-src data:; script-src 'unsafe-inline'; style-src 'unsafe-inline'\">\n";

const STYLE: &str = include_str!("page.css");

const SCRIPT: &str = include_str!("page.js");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::markup::quoted;

    #[test]
    fn the_style_is_of_pages_with_controls_alone() {
        let plain = ["body { margin: 0;", "canvas { display: block; }"];
        let rules = STYLE
            .lines()
            .filter(|l| l.contains('{') && !l.starts_with(' '));
        for rule in rules.filter(|l| !l.starts_with("@media")) {
            let is_plain = plain.iter().any(|p| rule.starts_with(p));
            let is_ours = rule.starts_with(".controlled") || rule.starts_with("#controls");
            assert!(is_plain || is_ours, "{rule}");
        }
        assert!(!STYLE.contains('<') && !SCRIPT.contains("</"));
    }

    #[test]
    fn names_cannot_leave_their_place() {
        assert_eq!(attribute("a<b>&\"c\""), "\"a&lt;b&gt;&amp;&quot;c&quot;\"");
        assert_eq!(
            quoted("</script>\"\\\n"),
            "\"\\u003c/script\\u003e\\\"\\\\\\u000a\""
        );
        let file = EmbeddedFile {
            media_type: "image/png\"><script>".to_owned(),
            bytes: vec![0, 1, 2],
        };
        assert_eq!(uri(&file), "\"data:image/pngscript;base64,AAEC\"");
    }
}
