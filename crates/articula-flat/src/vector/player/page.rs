//! Text of a player file: the script, without the parts that the file does not need, and the clip.
//!
//! Source: `docs/methods/vector.md` 8.3. An SVG carries its canvas in a `foreignObject`; in a web
//! page it plays inline, in an `<object>` or in an `<iframe>`. In an `<img>`, where scripts do not run,
//! and in editors and viewers, it shows its first frame, a picture that the script removes.

use super::clip::PlayerClip;
use super::first_frame::first_frame;
use crate::error::PictureError;
use crate::planar::shading::Shading;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;

/// The script with its comments and indentation.
const SCRIPT: &str = include_str!("player.js");

/// Kind of file that contains the script player and its clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlayerOutput {
    /// An SVG that plays where scripts run, and elsewhere shows its first frame.
    #[default]
    Svg,
    /// A JavaScript module that exports `data` and `mount(canvas, data, element)`, which returns a
    /// promise.
    Module,
}

/// Minified script for a clip.
pub(super) fn script(shading: Shading, is_live: bool) -> String {
    let mut script = String::new();
    let mut is_wanted = true;
    for line in SCRIPT.lines().map(str::trim) {
        match line.strip_prefix("//") {
            Some("+gouraud") => is_wanted = shading == Shading::Gouraud,
            Some("+flat") => is_wanted = shading == Shading::Flat,
            Some("+live") => is_wanted = is_live,
            Some("+clip") => is_wanted = !is_live,
            Some("-") => is_wanted = true,
            Some(_) => {}
            None if is_wanted => script.push_str(line),
            None => {}
        }
    }
    script
}

/// Text of the file of a clip with the given container.
///
/// # Errors
/// [`PictureError`] if the first frame cannot be drawn.
pub(super) fn page(
    clip: &PlayerClip,
    container: &[u8],
    output: PlayerOutput,
) -> Result<String, PictureError> {
    let script = script(clip.shading, !clip.inputs.is_empty());
    let data = BASE64_STANDARD.encode(container);
    let (w, h) = (clip.width, clip.height);
    Ok(match output {
        PlayerOutput::Svg => {
            let still = BASE64_STANDARD.encode(first_frame(clip)?);
            format!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" width="{w}" height="{h}" viewBox="0 0 {w} {h}"><image width="{w}" height="{h}" href="data:image/webp;base64,{still}"/><foreignObject width="{w}" height="{h}"><canvas xmlns="http://www.w3.org/1999/xhtml" style="width:100%;height:100%"></canvas></foreignObject><script><![CDATA[{{let e=document.currentScript.parentNode;({script})(e.querySelector("canvas"),"{data}",e).then(()=>e.querySelector("image").remove())}}]]></script></svg>"#
            )
        }
        PlayerOutput::Module => {
            format!(r#"export const data="{data}",mount=(c,d=data,e=c)=>({script})(c,d,e)"#)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_small_and_stand_on_one_line() {
        for (shading, live) in [
            (Shading::Gouraud, false),
            (Shading::Gouraud, true),
            (Shading::Flat, false),
            (Shading::Flat, true),
        ] {
            let script = script(shading, live);
            assert!(script.len() < 2500, "{} bytes", script.len());
            // CDATA must not end early, and a comment must not swallow the rest.
            for bad in ["]]>", "//", "\n", "</"] {
                assert!(!script.contains(bad), "{bad}");
            }
            assert_eq!(script.contains("articulaInputs"), live);
            assert_eq!(script.contains("Gradient"), shading == Shading::Gouraud);
        }
    }

    #[test]
    fn lines_end_where_no_line_end_is_needed() {
        let code = |l: &&str| !l.is_empty() && !l.starts_with("//");
        for line in SCRIPT.lines().map(str::trim).filter(code) {
            let last = line.chars().last().unwrap();
            let ends = ";,({}=:".contains(last);
            // Lists continue with a dot or a comma.
            let goes_on = SCRIPT.contains(&format!("{line}\n."))
                || line.ends_with(')')
                || line.ends_with(']');
            assert!(ends || goes_on, "{line}");
        }
    }
}
