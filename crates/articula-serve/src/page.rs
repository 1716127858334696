//! The page for people: the characters of the folder, and how far each is.

use crate::sessions::SessionReport;
use crate::state::{CharacterState, Progress};

/// HTML of the list; with a studio it names its page.
pub(crate) fn list(
    states: &[(String, CharacterState)],
    sessions: &[SessionReport],
    has_studio: bool,
) -> String {
    let mut rows = String::new();
    let mut is_busy = false;
    for (name, state) in states {
        let progress = match &state.progress {
            Progress::Waiting => "waiting".to_owned(),
            Progress::Packaging => "being packaged".to_owned(),
            Progress::Ready => "ready".to_owned(),
            Progress::Failed(why) => format!("failed: {why}"),
        };
        is_busy |= matches!(state.progress, Progress::Waiting | Progress::Packaging);
        let path = path_of(name);
        let manifest = format!("/v1/characters/{path}/manifest.json");
        let (link, sizes) = match &state.served {
            Some(served) => (
                format!("<a href=\"{}\">manifest</a>", escaped(&manifest)),
                format!(
                    "<td>{}<td>{}",
                    kilobytes(served.bytes),
                    kilobytes(served.sent_bytes)
                ),
            ),
            None => ("-".to_owned(), "<td>-<td>-".to_owned()),
        };
        let row = format!(
            "<tr><td>{}<td>{}{sizes}<td>{link}\n",
            escaped(name),
            escaped(&progress)
        );
        rows.push_str(&row);
    }
    let refresh = match is_busy || !sessions.is_empty() {
        true => "<meta http-equiv=\"refresh\" content=\"2\">",
        false => "",
    };
    let empty = match states.is_empty() {
        true => {
            "<p>The folder has no <code>.glb</code>, <code>.vrm</code> or <code>.fbx</code>; put one there and start the server again, or send one by <code>PUT /v1/characters/NAME</code>.\n"
        }
        false => "",
    };
    let studio = match has_studio {
        true => "<p>The <a href=\"/studio/#stream\">studio</a> shows them while they arrive.\n",
        false => {
            "<p>The studio, which shows them while they arrive, is not in this program. <code>cargo xtask studio</code> builds one with it, on a machine with Node; <code>--studio DIR</code> serves its pages from a folder.\n"
        }
    };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n{refresh}\n<title>Articula</title>\n\
         <style>{STYLE}</style>\n<h1>Characters</h1>\n{empty}<table>\n\
         <tr><th>name<th>state<th>kB<th>kB as sent<th>files\n{rows}</table>\n{studio}{}\
         <p><a href=\"/v1/characters\">As JSON</a>, <a href=\"/v1/sessions\">sessions</a>, \
         <a href=\"/metrics\">metrics</a>\n</html>\n",
        monitor(sessions)
    )
}

/// HTML of the sessions that are open, nothing if there are none.
fn monitor(sessions: &[SessionReport]) -> String {
    if sessions.is_empty() {
        return String::new();
    }
    let mut rows = String::new();
    for session in sessions {
        let mut levels = Vec::new();
        for of in &session.characters {
            let state = if of.is_complete { ", complete" } else { "" };
            levels.push(format!("{} {}/{}{state}", of.name, of.level, of.levels));
        }
        let (sent, shown) = (&session.sent, &session.shown);
        rows.push_str(&format!(
            "<tr><td>{}<td>{}<td>{:.0}<td>{:.0}<td>{}<td>{}<td>{:.0}<td>{:.1}<td>{}\n",
            session.number,
            escaped(&levels.join("; ")),
            sent.secs,
            sent.bandwidth_bps / 1000.0,
            kilobytes(sent.bytes),
            shown.joints,
            shown.fps,
            shown.frame_ms,
            shown.stalls
        ));
    }
    format!(
        "<h2>Sessions</h2>\n<table>\n<tr><th>session<th>levels<th>s<th>kbit/s<th>kB sent<th>joints\
         <th>frames/s<th>ms<th>stalls\n{rows}</table>\n"
    )
}

const STYLE: &str = "body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:60rem;padding:0 1rem;\
color:#1b1f24;background:#fff}table{border-collapse:collapse;width:100%}th,td{text-align:left;padding:.4rem .6rem;\
border-bottom:1px solid #d0d7de}@media(prefers-color-scheme:dark){body{color:#e6edf3;background:#0d1117}\
a{color:#6cb6ff}th,td{border-color:#30363d}}";

fn kilobytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / 1000.0)
}

/// Text in HTML.
fn escaped(text: &str) -> String {
    let mut made = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => made.push_str("&amp;"),
            '<' => made.push_str("&lt;"),
            '>' => made.push_str("&gt;"),
            '"' => made.push_str("&quot;"),
            _ => made.push(c),
        }
    }
    made
}

/// Returns a name as a segment of a path, percent-encoded (RFC 3986).
pub fn path_of(name: &str) -> String {
    let mut made = String::with_capacity(name.len());
    for byte in name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' | b'~' => {
                made.push(byte.into())
            }
            _ => made.push_str(&format!("%{byte:02X}")),
        }
    }
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_text_and_not_markup() {
        let state = CharacterState {
            progress: Progress::Failed("<script>".into()),
            served: None,
        };
        let html = list(&[("a\"<b> ä".to_owned(), state)], &[], false);
        assert!(html.contains("a&quot;&lt;b&gt; ä") && html.contains("failed: &lt;script&gt;"));
        assert!(!html.contains("refresh"));
        assert_eq!(path_of("a b/ä"), "a%20b%2F%C3%A4");
    }
}
