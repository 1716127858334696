//! Recordings of people that the network was not trained with, against phones that another program
//! (pocketsphinx 5.1.1) found in them, given their text. How well they are heard is judged by `articula-lab speech`.

use articula_speech::{Sound, TimedPhone, VisemeTrack, align, read_phone_times};
use std::path::PathBuf;

struct Recording {
    sound: Sound,
    phones: Vec<TimedPhone>,
}

#[allow(
    clippy::disallowed_methods,
    reason = "tests read the files of the repository"
)]
fn recordings() -> Vec<Recording> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../assets/speech"));
    let read = |name: String| std::fs::read(folder.join(name)).unwrap();
    let recording = |number: &str| Recording {
        sound: Sound::from_wav(&read(format!("librivox_austen_{number}.wav"))).unwrap(),
        phones: read_phone_times(&read(format!("librivox_austen_{number}.lab"))).unwrap(),
    };
    ["0870", "0880", "0890", "0930"].map(recording).into()
}

#[test]
fn times_of_known_phones_are_found() {
    let mut off_secs = Vec::new();
    for recording in recordings() {
        let symbols: Vec<String> = recording.phones.iter().map(|p| p.symbol.clone()).collect();
        let heard = VisemeTrack::recognised(&recording.sound);
        let found = align(&heard, &symbols).unwrap();
        let spoken = |phones: &[TimedPhone]| -> Vec<TimedPhone> {
            phones
                .iter()
                .filter(|p| !p.symbol.is_empty())
                .cloned()
                .collect()
        };
        let (found, wanted) = (spoken(&found), spoken(&recording.phones));
        assert_eq!(found.len(), wanted.len());
        for (found, wanted) in found.iter().zip(&wanted) {
            assert_eq!(found.symbol, wanted.symbol);
            off_secs.push((found.start_secs - wanted.start_secs).abs());
        }
    }
    off_secs.sort_by(f32::total_cmp);
    let (median, late) = (
        off_secs[off_secs.len() / 2],
        off_secs[off_secs.len() * 9 / 10],
    );
    println!(
        "begins of phones are off by {median:.3} s in the median, 9 of 10 by {late:.3} s at most"
    );
    assert!(median <= 0.03 && late <= 0.09, "{median} {late}");
}

#[test]
fn gain_and_rate_change_little() {
    for recording in recordings().into_iter().take(1) {
        let plain = VisemeTrack::recognised(&recording.sound);
        let soft: Vec<f32> = recording.sound.samples.iter().map(|s| s * 0.25).collect();
        let soft = VisemeTrack::recognised(&Sound::new(&soft, 16_000));
        let same = plain.frames.iter().zip(&soft.frames);
        let same = same.filter(|(a, b)| a.strongest() == b.strongest()).count();
        assert!(
            same * 100 >= plain.frames.len() * 90,
            "{same} of {}",
            plain.frames.len()
        );
    }
}
