//! Captures with damage, of odd line ends and decimal signs, and with odd times: a bad row costs that
//! row, and what is odd is told.

use crate::cases::case;
use articula_core::source::{Property, RawClip};
use articula_formats::{
    Limits, MotionFile, Parsed, ReadError, ReadOptions, acclaim, bva, bvh, live_link,
};
use proptest::prelude::*;

fn read_bvh(text: &str) -> Result<Parsed<MotionFile>, ReadError> {
    bvh::read(text.as_bytes(), &ReadOptions::default(), &Limits::default())
}

fn base() -> String {
    String::from_utf8(case("b_base.bvh")).unwrap()
}

/// The warnings beside that of the unit, which every BVH file gives.
fn said<T>(read: &Parsed<T>) -> Vec<String> {
    let odd = read.warnings.iter().filter(|w| w.guess.is_none());
    odd.map(|w| format!("{}: {}", w.at, w.what)).collect()
}

fn clip(read: &Parsed<MotionFile>) -> &RawClip {
    &read.value.character.clips[0]
}

/// Number of frames, and the values of the channels in one of them.
fn frame(clip: &RawClip, frame: usize) -> (usize, Vec<f32>) {
    let count = clip.channels[0].times_secs.len();
    let values = clip.channels.iter().flat_map(|channel| {
        let width = channel.values.len() / count;
        channel.values[frame * width..(frame + 1) * width].to_vec()
    });
    (count, values.collect())
}

#[test]
fn decimal_commas_and_lone_carriage_returns_change_nothing() {
    let whole = read_bvh(&base()).unwrap();
    let commas = read_bvh(&base().replace('.', ",")).unwrap();
    assert_eq!(commas.value, whole.value);
    assert_eq!(
        said(&commas),
        ["line 4: the numbers have decimal commas; they are read as decimal points"]
    );
    for line_end in ["\r", "\r\n"] {
        let ended = read_bvh(&base().replace('\n', line_end)).unwrap();
        assert_eq!(ended.value, whole.value);
        assert!(said(&ended).is_empty());
    }
}

#[test]
fn a_last_row_that_was_cut_is_dropped() {
    let text = base();
    let whole = read_bvh(&text).unwrap();
    let last = text.trim_end().rfind('\n').unwrap() + 1;
    let cut = read_bvh(&text[..last + 200]).unwrap();
    let ((all, _), (left, _)) = (frame(clip(&whole), 0), frame(clip(&cut), 0));
    assert_eq!((all, left), (31, 30));
    assert!((clip(&cut).duration_secs - 29.0 * 0.033_333).abs() < 1e-5);
    let told = said(&cut);
    assert!(
        told[0].starts_with("line 160: ") && told[0].contains("66 expected"),
        "{told:?}"
    );
    assert!(told[0].contains("at the end it is left out"));
}

#[test]
fn what_is_not_a_number_is_held() {
    let text = base();
    let lines: Vec<&str> = text.lines().collect();
    let row = lines[132].replacen("-70.000000", "nan", 1);
    assert_ne!(row, lines[132]);
    let held = read_bvh(&text.replacen(lines[132], &row, 1)).unwrap();
    let whole = read_bvh(&text).unwrap();
    // The value is -70 in every frame, so holding it gives the frame that was.
    assert_eq!(clip(&held), clip(&whole));
    assert_eq!(
        said(&held),
        ["line 133: \"nan\" found, a number expected; the value of the row before is held"]
    );
}

#[test]
fn a_frame_time_that_nobody_records_is_told() {
    let of = |time: &str| read_bvh(&base().replace("0.033333", time)).unwrap();
    let read = of("33.333");
    assert_eq!(clip(&read).duration_secs, 30.0 * 33.333);
    let told = said(&read);
    assert!(
        told[0].starts_with("line 129: a frame lasts 33.333 s"),
        "{told:?}"
    );
    assert!(told[0].contains("likely in milliseconds, 30.00 frames per second"));
    for (time, expected) in [
        ("16.667", "60.00 frames per second"),
        ("8.333", "120.00 frames per second"),
        ("40", "25.00 frames per second"),
        ("30", "likely the rate"),
        ("60", "likely the rate"),
    ] {
        assert!(said(&of(time))[0].contains(expected), "{time}");
    }
    for fine in ["0.008333", "0.04", "0.5", "1"] {
        assert!(said(&of(fine)).is_empty(), "{fine}");
    }
}

/// Ways to damage a row of numbers.
fn damaged(row: &str, way: usize, separator: &str) -> String {
    let words: Vec<&str> = row.split(separator).collect();
    match way {
        0 => row[..row.len() / 2].to_owned(),
        1 => words[..words.len() - 1].join(separator),
        2 => format!("{row}{separator}1"),
        3 => "#@!".to_owned(),
        _ => words
            .iter()
            .map(|_| "nan")
            .collect::<Vec<_>>()
            .join(separator),
    }
}

fn values(of: &live_link::LiveLinkFrame) -> (&[f32], &[f32]) {
    (&of.shapes, &of.angles)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn a_bad_row_of_a_bvh_file_costs_that_row(row in 0..31usize, way in 0..5usize) {
        let text = base();
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines[129 + row] = damaged(&lines[129 + row], way, " ");
        let read = read_bvh(&lines.join("\n")).unwrap();
        let whole = read_bvh(&text).unwrap();
        let told = said(&read);
        prop_assert!(told[0].starts_with(&format!("line {}: ", 130 + row)), "{told:?}");
        let is_between = row > 0 && row < 30;
        for i in 0..31usize {
            // The row at an end is gone; one between is as the one before.
            let (to, from) = match row {
                0 => (i.checked_sub(1), i),
                30 => (Some(i).filter(|i| *i < 30), i),
                _ => (Some(i), if i == row { i - 1 } else { i }),
            };
            let Some(to) = to else { continue };
            let (count, found) = frame(clip(&read), to);
            let (_, expected) = frame(clip(&whole), from);
            prop_assert_eq!(count, if is_between { 31 } else { 30 });
            for (a, b) in found.iter().zip(&expected) {
                prop_assert!((a - b).abs() < 1e-6, "frame {}: {} for {}", i, a, b);
            }
        }
    }

    #[test]
    fn a_bad_row_of_a_bva_segment_costs_that_row(row in 0..6usize, way in 0..5usize, of in 0..2usize) {
        let text = |damage: bool| {
            let segment = |s: usize| {
                let rows = (0..6).map(|f| {
                    let row_text = format!("{f} 1{s} 0.5 10 20 30");
                    match damage && (s, f) == (of, row) {
                        true => damaged(&row_text, way, " ") + "\n",
                        false => row_text + "\n",
                    }
                });
                let head = "Frames: 6\nFrame Time: 0.1\nXTRAN YTRAN ZTRAN XROT YROT ZROT\nM M M DEG DEG DEG";
                format!("Segment: s{s}\n{head}\n{}", rows.collect::<String>())
            };
            segment(0) + &segment(1)
        };
        let read = |text: &str| bva::read(text.as_bytes(), &ReadOptions::default(), &Limits::default());
        let found = read(&text(true)).unwrap();
        let told = said(&found);
        let line = 11 * of + 6 + row;
        prop_assert!(told.iter().any(|t| t.starts_with(&format!("line {line}: "))), "{told:?}");
        for channel in &clip(&found).channels {
            let is_short = channel.target == of && row == 5;
            prop_assert_eq!(channel.times_secs.len(), if is_short { 5 } else { 6 });
            if channel.property != Property::Translation {
                continue;
            }
            // X counts the frames.
            for (f, place) in channel.values.chunks_exact(3).enumerate() {
                let held = if row == 0 { 1 } else { row - 1 };
                let expected = if channel.target == of && f == row { held } else { f };
                prop_assert_eq!(place[0], expected as f32);
            }
        }
    }

    #[test]
    fn a_bad_row_of_a_live_link_capture_costs_that_row(row in 0..150usize, way in 0..5usize) {
        let text = String::from_utf8(case("ll_midnight30.csv")).unwrap();
        let whole = live_link::read(text.as_bytes(), &Limits::default()).unwrap().value;
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines[1 + row] = damaged(&lines[1 + row], way, ",");
        let read = live_link::read(lines.join("\n").as_bytes(), &Limits::default()).unwrap();
        prop_assert_eq!(read.warnings.len(), 1);
        let begin = whole.frames[usize::from(row == 0)].secs;
        let left = whole.frames.iter().enumerate().filter(|(i, _)| *i != row);
        prop_assert_eq!(read.value.frames.len(), 149);
        for (found, (_, expected)) in read.value.frames.iter().zip(left) {
            prop_assert!((found.secs - (expected.secs - begin)).abs() < 1e-9);
            prop_assert_eq!(values(found), values(expected));
        }
    }

    #[test]
    fn a_bad_row_of_an_amc_file_costs_that_row(frame in 0..6usize, way in 0..5usize, at in 0..2usize) {
        let asf = ":units\n length 1\n angle deg\n:root\n order TX TY TZ RX RY RZ\n axis XYZ\n \
                   position 0 0 0\n orientation 0 0 0\n:bonedata\n begin\n name thigh\n direction 0 \
                   -1 0\n length 4\n axis 0 0 0 XYZ\n dof rx ry rz\n end\n:hierarchy\n begin\n root \
                   thigh\n end\n";
        let row = |f: usize| [format!("root {f} 1 0 0 0 0"), format!("thigh 0 {f} 0")];
        let text = |damage: bool| {
            let frames = (0..6).map(|f| {
                let mut rows = row(f);
                if damage && f == frame {
                    let (name, rest) = rows[at].split_once(' ').unwrap();
                    rows[at] = format!("{name} {}", damaged(rest, way, " "));
                }
                format!("{}\n{}\n", f + 1, rows.join("\n"))
            });
            ":DEGREES\n".to_owned() + &frames.collect::<String>()
        };
        let read = |text: &str| {
            let options = ReadOptions { scale_to_metres: Some(1.0), ..ReadOptions::default() };
            acclaim::read(asf.as_bytes(), Some(text.as_bytes()), &options, &Limits::default())
        };
        let read_damaged = read(&text(true)).unwrap();
        let told = said(&read_damaged);
        prop_assert!(told[0].starts_with(&format!("amc line {}: ", 3 + 3 * frame + at)), "{told:?}");
        // A last frame without all of its bones is left out.
        let count = if frame == 5 { 5 } else { 6 };
        prop_assert_eq!(told.len(), if frame == 5 { 2 } else { 1 });
        let rate_hz = 120.0;
        let clip = clip(&read_damaged);
        prop_assert!((clip.duration_secs - (count - 1) as f32 / rate_hz).abs() < 1e-6);
        let root = clip.channels.iter().find(|c| c.property == Property::Translation).unwrap();
        for f in (0..count).filter(|f| at == 1 || *f != frame) {
            let time = f as f32 / rate_hz;
            let key = root.times_secs.iter().position(|t| (t - time).abs() < 1e-6).unwrap();
            prop_assert_eq!(root.values[3 * key], f as f32);
        }
    }
}

#[test]
fn a_capture_goes_on_past_midnight() {
    let read = live_link::read(&case("ll_midnight30.csv"), &Limits::default()).unwrap();
    let clip = read.value;
    assert_eq!((clip.rate_hz, clip.frames.len()), (30.0, 150));
    assert!((clip.frames[149].secs - 149.0 / 30.0).abs() < 1e-9);
    assert!(read.warnings.is_empty());
}

#[test]
fn times_in_seconds_are_read_as_seconds() {
    let read = live_link::read(&case("ll_timecode_float.csv"), &Limits::default()).unwrap();
    let clip = read.value;
    assert_eq!((clip.rate_hz, clip.frames.len()), (60.0, 240));
    assert!((clip.frames[239].secs - 3.9833).abs() < 1e-9);
    assert_eq!(read.warnings.len(), 1);
    assert!(read.warnings[0].what.contains("read as seconds"));
}

#[test]
fn a_capture_of_a_spreadsheet_has_semicolons_and_decimal_commas() {
    let text = "Timecode,JawOpen,HeadYaw\n00:00:00:00.500,0.25,-0.5\n00:00:00:01.500,1,0\n";
    let plain = live_link::read(text.as_bytes(), &Limits::default()).unwrap();
    for separator in [";", "\t"] {
        let other = text.replace(',', separator).replace('.', ",");
        // The app's own column keeps its point.
        let other = other
            .replace("00,500", "00.500")
            .replace("01,500", "01.500");
        for line_end in ["\n", "\r\n", "\r"] {
            let other = other.replace('\n', line_end);
            let read = live_link::read(other.as_bytes(), &Limits::default()).unwrap();
            assert_eq!(read.value, plain.value);
        }
    }
}
