//! The moving picture of the readme: its size, and that a browser plays it without script.

use crate::judges::browser::{Item, is_here, shots};
use articula::flat::flatten::FileSize;
use articula::flat::masked_rmse;
use articula::flat::vector::{AnimatedSvg, raster};
use std::path::Path;

const SIZE: [u32; 2] = [300, 460];
const WHITE: [u8; 4] = [255; 4];

#[test]
fn the_picture_of_the_readme_is_small_and_plays_in_an_img() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join("docs/pictures/walk.svg").canonicalize().unwrap();
    let text = std::fs::read_to_string(&file).unwrap();
    let size = FileSize::of(text.as_bytes()).unwrap();
    assert!(size.gzip < 150_000, "{} bytes", size.gzip);
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    let stated = format!("({} kB\nwith gzip", (size.gzip as f64 / 1e3).round());
    assert!(readme.contains(&stated), "the readme does not say {stated}");
    assert!(
        !text.contains("<script") && !text.contains(" on"),
        "a script"
    );
    if !is_here() {
        return;
    }
    let times = [0.0, 0.8];
    let item = Item {
        kind: "smil-img",
        file,
        size: SIZE,
        times_secs: times.to_vec(),
        plays: true,
    };
    let seen = &shots(&[item]).unwrap()[0];
    assert!(seen.plays, "an <img> does not play it");
    let moving = AnimatedSvg::read(&text).unwrap();
    let mask = vec![true; (SIZE[0] * SIZE[1]) as usize];
    for (time, picture) in times.iter().zip(&seen.pictures) {
        let own = raster(&moving.at(*time).unwrap(), WHITE).unwrap();
        let off = masked_rmse(picture, &own, &mask).unwrap();
        assert!(
            off < 2.0,
            "Chromium and resvg differ by {off} levels at {time} s"
        );
    }
}
