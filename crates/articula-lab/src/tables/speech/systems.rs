//! What hears a voice: this library in its two ways, loudness alone, and peers.

use super::corpus::Clip;
use super::peers::{self, Peer};
use super::recordings::Set;
use super::score::Score;
use anyhow::Result;
use articula_speech::training::Network;
use articula_speech::{Recogniser, VISEME_COUNT, Viseme, VisemeFrame, VisemeTrack};

pub(super) const SOUND: &str = "sound";

pub(super) struct System {
    pub(super) name: &'static str,
    kind: Kind,
}

enum Kind {
    Network(Box<Network>),
    Phones,
    Loudness,
    Peer(Peer),
}

/// Those of this library and loudness.
pub(super) fn own(network: Network) -> Vec<System> {
    let system = |name, kind| System { name, kind };
    vec![
        system(SOUND, Kind::Network(Box::new(network))),
        system("phones", Kind::Phones),
        system("loudness", Kind::Loudness),
    ]
}

/// Peers, as far as they can run; `profile` is speech of which wLipSync makes what it goes by.
pub(super) fn peers(profile: &[Clip]) -> Result<Vec<System>> {
    if !peers::are_there()? {
        println!("skipped: {}", peers::MISSING);
        return Ok(Vec::new());
    }
    let peer = |name, profile| {
        let kind = Kind::Peer(Peer::new(name, profile)?);
        Ok(System { name, kind })
    };
    let mut systems = vec![peer("headaudio", &[])];
    if !profile.is_empty() {
        systems.push(peer("wlipsync", profile));
    }
    systems.into_iter().collect()
}

impl System {
    pub(super) fn score(&self, set: &Set) -> Result<Score> {
        let tracks: Vec<Vec<VisemeFrame>> = match &self.kind {
            Kind::Peer(peer) => peer.tracks(&set.clips)?,
            Kind::Network(network) => set.clips.iter().map(|clip| heard(network, clip)).collect(),
            Kind::Phones => {
                let track = |clip: &Clip| VisemeTrack::of_phones(&clip.phones, &clip.sound).frames;
                set.clips.iter().map(track).collect()
            }
            Kind::Loudness => set.clips.iter().map(by_loudness).collect(),
        };
        let mut score = Score::default();
        for (track, clip) in tracks.iter().zip(&set.clips) {
            score.add(track, &clip.segments);
        }
        Ok(score)
    }
}

fn heard(network: &Network, clip: &Clip) -> Vec<VisemeFrame> {
    let mut recogniser = Recogniser::with_network(network.clone());
    let mut frames = recogniser.push(&clip.sound.samples);
    frames.extend(recogniser.finish());
    frames
}

/// A jaw that is open by the level below the running peak: 0 dB is "a", -24 dB closed.
fn by_loudness(clip: &Clip) -> Vec<VisemeFrame> {
    let frames = VisemeTrack::recognised(&clip.sound).frames;
    let frame = |frame: &VisemeFrame| {
        let open = (1.0 + frame.level_db / 24.0).clamp(0.0, 1.0);
        let mut weights = [0.0; VISEME_COUNT];
        weights[Viseme::Silence.number()] = 1.0 - open;
        weights[Viseme::Aa.number()] = open;
        VisemeFrame { weights, ..*frame }
    };
    frames.iter().map(frame).collect()
}
