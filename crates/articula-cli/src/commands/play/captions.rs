//! Captions on the clock of a clip, from a WebVTT file that an item carries.
//!
//! Source: W3C WebVTT. Cues are shown as plain text; the identifier of a cue names the clip to which it belongs,
//! and a cue without one belongs to any.

use articula::client::Client;

/// A caption.
#[derive(Debug, PartialEq)]
struct Cue {
    clip: Option<String>,
    from_secs: f64,
    to_secs: f64,
    text: String,
}

/// The captions of a character.
#[derive(Debug)]
pub(super) struct Captions(Vec<Cue>);

impl Captions {
    /// The captions of the first character of a client, once they have arrived.
    pub(super) fn of(client: &Client) -> Option<Self> {
        let receiver = client.character(0)?.receiver()?;
        let files = receiver.manifest().whole.iter().map(|file| &*file.file);
        let file = files.clone().find(|file| file.ends_with(".vtt"))?;
        let bytes = receiver.file(file)?;
        Some(Self::read(&String::from_utf8_lossy(bytes)).without_pictures(files))
    }

    /// The captions without the names of files, which stand for pictures of a slide-show.
    fn without_pictures<'a>(mut self, files: impl Iterator<Item = &'a str> + Clone) -> Self {
        let is_file = |text: &str| {
            files
                .clone()
                .any(|file| file.rsplit('/').next() == Some(text))
        };
        self.0.retain(|cue| !is_file(&cue.text));
        self
    }

    /// What is said at a time within a clip.
    pub(super) fn at(&self, clip: Option<&str>, secs: f64) -> Option<&str> {
        let is_now = |cue: &&Cue| {
            let is_of = cue.clip.as_deref().is_none_or(|of| Some(of) == clip);
            is_of && (cue.from_secs..cue.to_secs).contains(&secs)
        };
        self.0.iter().find(is_now).map(|cue| cue.text.as_str())
    }

    /// Reads a file; blocks that are no cues are left out.
    fn read(text: &str) -> Self {
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        Self(text.split("\n\n").filter_map(cue).collect())
    }
}

fn cue(block: &str) -> Option<Cue> {
    let lines: Vec<&str> = block.trim_matches('\n').lines().collect();
    let timing = lines.iter().position(|line| line.contains("-->"))?;
    let (from, to) = lines[timing].split_once("-->")?;
    // Settings of the place follow the second time.
    let to = to.split_whitespace().next()?;
    let text: Vec<String> = lines[timing + 1..].iter().map(|line| plain(line)).collect();
    Some(Cue {
        clip: timing.checked_sub(1).map(|id| lines[id].trim().to_owned()),
        from_secs: secs(from.trim())?,
        to_secs: secs(to)?,
        text: text.join(" "),
    })
}

/// A time as hours (which may be missing), minutes and seconds.
fn secs(text: &str) -> Option<f64> {
    text.split(':').try_fold(0.0, |sum, part| {
        let value: f64 = part.parse().ok()?;
        (value >= 0.0 && value.is_finite()).then_some(60.0 * sum + value)
    })
}

/// A line without tags and control characters.
fn plain(line: &str) -> String {
    let mut is_tag = false;
    let keep = |c: &char| {
        let was_tag = is_tag;
        is_tag = (is_tag || *c == '<') && *c != '>';
        !was_tag && !is_tag && !c.is_control()
    };
    line.chars().filter(keep).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_not_said() {
        let captions =
            Captions::read("WEBVTT\n\n00:00 --> 00:01\none.png\n\n00:00 --> 00:01\nSee one.png.\n");
        let captions = captions.without_pictures(["with/one.png"].into_iter());
        assert_eq!(captions.at(None, 0.5), Some("See one.png."));
    }

    #[test]
    fn cues_are_those_of_their_clip_and_time() {
        let captions = Captions::read(
            "WEBVTT - a guide\r\n\r\nNOTE nothing\r\n\r\nwalk\r\n00:00.000 --> 00:01.500 align:left\r\n\
             <v Guide>Follow <b>me</b>.\r\nThis way.\r\n\r\n00:01.000 --> 01:00:02.000\r\nFor any clip.\r\n",
        );
        let at = |clip, secs| captions.at(Some(clip), secs);
        assert_eq!(at("walk", 0.2), Some("Follow me. This way."));
        assert_eq!(at("idle", 0.2), None);
        assert_eq!(at("idle", 3601.9), Some("For any clip."));
        assert_eq!(at("idle", 3602.0), None);
        assert_eq!(captions.at(None, 1.6), Some("For any clip."));
        for wrong in ["", "-->", "a --> b\nc", "1 -->\n", "-1 --> 2\nx\u{1b}[0m"] {
            assert_eq!(Captions::read(wrong).0, [], "{wrong}");
        }
    }
}
