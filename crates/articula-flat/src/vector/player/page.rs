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
pub(super) fn script(clip: &PlayerClip) -> String {
    let parts = [!clip.inputs.is_empty(), clip.texture.is_some()];
    script_for(clip.shading, parts)
}

/// The script for a shading, with inputs and with a picture.
fn script_for(shading: Shading, [is_live, has_texture]: [bool; 2]) -> String {
    let is_gouraud = shading == Shading::Gouraud;
    let mut script = String::new();
    let mut is_wanted = true;
    for line in SCRIPT.lines().map(str::trim) {
        match line.strip_prefix("//") {
            Some("+gouraud") => is_wanted = is_gouraud,
            Some("+flat") => is_wanted = !is_gouraud,
            Some("+live") => is_wanted = is_live,
            Some("+clip") => is_wanted = !is_live,
            Some("+texture") => is_wanted = has_texture,
            Some("+untextured") => is_wanted = !has_texture,
            Some("+plain") => is_wanted = is_gouraud && !has_texture,
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
    let script = script(clip);
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
        for (shading, live, texture) in [
            (Shading::Gouraud, false, false),
            (Shading::Gouraud, true, false),
            (Shading::Flat, false, false),
            (Shading::Flat, true, false),
            (Shading::Gouraud, false, true),
            (Shading::Gouraud, true, true),
        ] {
            let script = script_for(shading, [live, texture]);
            let most = if texture { 3600 } else { 2500 };
            assert!(script.len() < most, "{} bytes", script.len());
            assert_eq!(script.contains("createPattern"), texture);
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
