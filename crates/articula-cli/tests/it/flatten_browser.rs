//! Rendering of converted files in browsers and players, compared with the picture without a
//! painting order: the procedural human walks and turns.

use crate::judges::browser::{Item, is_here, shots, write};
use crate::program;
use articula::build::ClipOptions;
use articula::build::character;
use articula::build::decimate;
use articula::core::Progress;
use articula::core::Viewport;
use articula::flat::Appearance;
use articula::flat::Picture;
use articula::flat::Projection;
use articula::flat::Supersampling;
use articula::flat::flatten::{
    PrepareClipOptions, PreparedClip, Profile, Quality, ReferenceFrames, Settings, flatten,
};
use articula::flat::planar::Shading;
use articula::flat::planar::reference;
use articula::flat::planar::{
    BakeOptions, Lighting, PlanarClip, PlanarSubject, PlanarTexture, Turntable, bake,
};
use articula::flat::vector::AnimatedSvg;
use articula::flat::vector::player::PlayerOutput;
use articula::flat::vector::raster;
use articula::flat::{masked_rmse, ssim};
use articula::formats::{Limits, gltf};
use std::sync::OnceLock;

const SIDE: u32 = 240;
const FRAMES: usize = 31;
const WHITE: [u8; 4] = [255; 4];

/// Times in frames, whole and fractional; none at which a shape is switched, nor the last frame,
/// which is the first one of the next cycle.
const MOMENTS: [f64; 4] = [0.0, 5.25, 15.0, 25.75];

/// The walking human: prepared for writing, and its true pictures at the times.
struct Film {
    prepared: PreparedClip,
    fps: f64,
    truth: ReferenceFrames,
    /// Picture and mask at each time.
    pictures: Vec<(Picture, Vec<bool>)>,
}

fn film() -> &'static Film {
    static FILM: OnceLock<Film> = OnceLock::new();
    FILM.get_or_init(|| filmed(|_| None))
}

/// The walking human in stripes.
fn striped_film() -> &'static Film {
    static FILM: OnceLock<Film> = OnceLock::new();
    FILM.get_or_init(|| filmed(|clip| Some(striped(clip))))
}

/// A picture of waves that run over the first frame as on a curtain; each fifth triangle keeps its
/// colours.
fn striped(clip: &PlanarClip) -> PlanarTexture {
    const SIDE_PX: u32 = 128;
    let wave = |x: u32, y: u32| {
        let level = |at: u32, length: f32| {
            let phase = at as f32 / length * std::f32::consts::TAU;
            (140.0 + 90.0 * phase.sin()) as u8
        };
        [level(x, 16.0), level(y, 24.0), 120, 255]
    };
    let pixels = (0..SIDE_PX).flat_map(|y| (0..SIDE_PX).map(move |x| wave(x, y)));
    let picture = Picture::from_pixels(SIDE_PX, SIDE_PX, pixels.collect()).unwrap();
    let scale = SIDE_PX as f32 / SIDE as f32;
    PlanarTexture {
        picture: std::sync::Arc::new(picture),
        places: clip.frames[0].xy.iter().map(|xy| *xy * scale).collect(),
        shows: (0..clip.triangles.len())
            .map(|t| !t.is_multiple_of(5))
            .collect(),
    }
}

/// The walking human with the picture that `texture` returns for it.
fn filmed(texture: impl Fn(&PlanarClip) -> Option<PlanarTexture>) -> Film {
    let bytes = std::fs::read(program::human()).unwrap();
    let mut alone = |uri: &str| Err(format!("{uri} is not needed"));
    let file = gltf::read(&bytes, &Limits::default(), &mut alone).unwrap();
    let source = file.value.character;
    let (appearance, _) = Appearance::new(&source.materials, &source.images);
    let asset = character(&source, None, &ClipOptions::default()).unwrap();
    let walk = asset.clips.iter().position(|c| c.name == "walk").unwrap();
    let length = f64::from(asset.clips[walk].duration_secs());
    let fps = (FRAMES - 1) as f64 / length;
    let moments: Vec<f64> = (0..FRAMES).map(|f| f as f64 / fps).collect();
    let turn = Turntable {
        axis: (0.0, 0.0),
        radians_per_sec: (1.2 / length) as f32,
    };
    let keep = vec![true; asset.mesh.triangles.len()];
    let triangles = decimate(&asset, &keep, Some(walk), 500, &[]).unwrap();
    let subject = PlanarSubject {
        rig: &asset.rig,
        mesh: &asset.mesh,
        triangles: &triangles,
        appearance: &appearance,
        clip: Some(&asset.clips[walk]),
        morph_weights: &asset.mesh.morph_weights,
    };
    let viewport = Viewport {
        width_px: SIDE as f32,
        height_px: SIDE as f32,
        ..Viewport::default()
    };
    let camera = subject
        .camera(&moments, &turn, (-0.4, 0.0), viewport)
        .unwrap();
    let options = BakeOptions {
        camera,
        projection: Projection::Perspective,
        lighting: Lighting::default(),
        fps: fps as f32,
        turn,
    };
    let mut clip = bake(&subject, &moments, &options).unwrap();
    clip.texture = texture(&clip);
    let looks: Vec<f64> = MOMENTS.iter().map(|m| m / fps).collect();
    let mut truth = bake(&subject, &looks, &options).unwrap();
    truth.texture = clip.texture.clone();
    let picture = |m| {
        let picture = reference(&truth, m, Supersampling::Eight, WHITE).unwrap();
        // Over nothing, a pixel is opaque where it shows the character at least in part.
        let alone = reference(&truth, m, Supersampling::Eight, [0; 4]).unwrap();
        let mask = alone.pixels().iter().map(|p| p[3] > 0).collect();
        (picture, mask)
    };
    let prepared =
        PreparedClip::new(clip, &PrepareClipOptions::default(), &mut Progress::none()).unwrap();
    Film {
        prepared,
        fps,
        pictures: (0..MOMENTS.len()).map(picture).collect(),
        truth: ReferenceFrames::new(&truth, &MOMENTS).unwrap(),
    }
}

/// The file of a profile.
fn file_of(profile: Profile, shading: Shading) -> Vec<u8> {
    file_of_film(film(), profile, shading)
}

fn file_of_film(film: &Film, profile: Profile, shading: Shading) -> Vec<u8> {
    let settings = Settings {
        profile,
        quality: Quality {
            shading,
            ..Quality::of(profile)
        },
        name: "walk & <turn>".into(),
        max_bytes: None,
    };
    flatten(
        &film.prepared,
        &settings,
        &film.truth,
        &mut Progress::none(),
    )
    .unwrap()
    .bytes
}

fn item(kind: &'static str, name: &str, bytes: &[u8]) -> Item {
    Item {
        kind,
        file: write(name, bytes),
        size: [SIDE, SIDE],
        times_secs: MOMENTS.iter().map(|m| m / film().fps).collect(),
        plays: matches!(kind, "smil-img" | "player"),
    }
}

/// Compares pictures with the reference: maximum colour error over the character, and minimum
/// similarity. The figure is small, so its outline has a large weight: the same files drawn by
/// resvg have the same error (the first test compares the two).
fn assert_near(what: &str, pictures: &[Picture], levels: f64, alike: f64) {
    assert_near_film(film(), what, pictures, (levels, alike));
}

fn assert_near_film(film: &Film, what: &str, pictures: &[Picture], (levels, alike): (f64, f64)) {
    assert_eq!(pictures.len(), MOMENTS.len());
    for (m, picture) in pictures.iter().enumerate() {
        let (truth, mask) = &film.pictures[m];
        let off = masked_rmse(picture, truth, mask).unwrap();
        let near = ssim(picture, truth).unwrap();
        let at = MOMENTS[m];
        assert!(off <= levels, "{what}: {off} levels at frame {at}");
        assert!(near >= alike, "{what}: SSIM {near} at frame {at}");
    }
}

#[test]
fn chromium_plays_svg_as_the_sampler_says_and_near_the_truth() {
    if !is_here() {
        return;
    }
    let shadings = [Shading::Flat, Shading::Gouraud];
    let files = shadings.map(|shading| file_of(Profile::Smil, shading));
    let kinds = ["smil", "smil-img"];
    let items = files
        .iter()
        .flat_map(|bytes| kinds.map(|kind| item(kind, "walk.svg", bytes)));
    let items: Vec<Item> = items.collect();
    // All in one browser, since starting it takes longer than some pictures.
    let all = shots(&items).unwrap();
    for ((shading, bytes), seen) in shadings.iter().zip(&files).zip(all.chunks(2)) {
        assert!(seen[1].plays, "an <img> plays it without help");
        let moving = AnimatedSvg::read(std::str::from_utf8(bytes).unwrap()).unwrap();
        for (m, time) in items[0].times_secs.iter().enumerate() {
            let own = raster(&moving.at(*time).unwrap(), WHITE).unwrap();
            let mask = vec![true; (SIDE * SIDE) as usize];
            for seen in seen {
                let off = masked_rmse(&seen.pictures[m], &own, &mask).unwrap();
                assert!(
                    off < 2.0,
                    "Chromium and resvg are {off} levels apart at {time} s"
                );
            }
        }
        let (levels, alike) = match shading {
            Shading::Flat => (32.0, 0.9),
            Shading::Gouraud => (18.0, 0.97),
        };
        assert_near("smil", &seen[0].pictures, levels, alike);
        assert_near("smil in an <img>", &seen[1].pictures, levels, alike);
    }
}

#[test]
fn chromium_plays_the_flip_book() {
    if !is_here() {
        return;
    }
    let bytes = file_of(Profile::Flipbook, Shading::Gouraud);
    let mut item = item("smil-img", "book.svg", &bytes);
    // Nothing is interpolated: whole frames only.
    let whole = |m: &f64| m.fract() == 0.0;
    let fps = film().fps;
    item.times_secs = MOMENTS
        .iter()
        .filter(|m| whole(m))
        .map(|m| m / fps)
        .collect();
    let seen = shots(&[item]).unwrap();
    let mut pictures = seen[0].pictures.iter();
    for (m, at) in MOMENTS.iter().enumerate().filter(|(_, m)| whole(m)) {
        let truth = &film().pictures[m].0;
        let near = ssim(pictures.next().unwrap(), truth).unwrap();
        assert!(near > 0.97, "SSIM {near} at frame {at}");
    }
}

#[test]
fn the_player_plays_near_the_truth() {
    if !is_here() {
        return;
    }
    let bytes = file_of(Profile::Player(PlayerOutput::Svg), Shading::Gouraud);
    let seen = shots(&[item("player", "walk.svg", &bytes)]).unwrap();
    assert!(seen[0].plays);
    assert_near("player", &seen[0].pictures, 18.0, 0.97);
}

#[test]
fn the_player_shows_pictures_near_the_truth() {
    if !is_here() {
        return;
    }
    let film = striped_film();
    let profile = Profile::Player(PlayerOutput::Svg);
    let bytes = file_of_film(film, profile, Shading::Gouraud);
    let seen = shots(&[item("player", "striped.svg", &bytes)]).unwrap();
    assert!(seen[0].plays);
    // Waves of 16 pixels of the picture are 30 of the screen.
    assert_near_film(film, "textured player", &seen[0].pictures, (18.0, 0.96));
    let plain = shots(&[item(
        "player",
        "plain.svg",
        &file_of(profile, Shading::Gouraud),
    )]);
    let (truth, mask) = &film.pictures[0];
    let without = masked_rmse(&plain.unwrap()[0].pictures[0], truth, mask).unwrap();
    assert!(without > 36.0, "{without} levels without the picture");
}

#[test]
fn lottie_players_play_near_the_truth() {
    if !is_here() {
        return;
    }
    let bytes = file_of(Profile::Lottie, Shading::Gouraud);
    let items = [
        item("lottie", "walk.json", &bytes),
        item("dotlottie", "walk.json", &bytes),
    ];
    let seen = shots(&items).unwrap();
    assert_near("lottie-web", &seen[0].pictures, 18.0, 0.97);
    assert_near("dotlottie-web", &seen[1].pictures, 18.0, 0.97);
}
