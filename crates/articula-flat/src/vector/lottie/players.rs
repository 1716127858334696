//! Lottie documents in other programs: the specification's schema, lottie-web and dotlottie-web.
//!
//! A cube turns in front of a white background. The reference is the raster of its projected clip;
//! the document has a key per frame, so positions are linear in between, as in the reference.
#![allow(
    clippy::unwrap_used,
    reason = "a test may fail loudly, and so may its helpers"
)]

#[path = "../../../../articula-cli/tests/it/judges/mod.rs"]
mod judges;
#[path = "../../../../articula-formats/tests/it/real/mod.rs"]
mod real;

use super::lottie;
use crate::compare::{rmse, ssim};
use crate::item_buffer::Supersampling;
use crate::picture::Picture;
use crate::planar::keyed_clip::{GRID, KeyedClip, KeyedPaint, KeyedShape, KeyedTrack, LineUnits};
use crate::planar::keyed_motion::KeyedMotion;
use crate::planar::shading::{Shading, flat_color};
use crate::planar::{PlanarClip, PlanarFrame, PlanarMaterial, reference};
use crate::vector::smil::smil;
use glam::{DVec2, Mat3, Vec2, Vec3};
use judges::browser::{self, Item, Seen, shots};
use std::sync::OnceLock;

const SIDE: u32 = 200;
const FRAMES: usize = 9;
const FPS: f32 = 12.5;
const COLORS: [[u8; 3]; 2] = [[220, 120, 60], [40, 160, 250]];
const NAME: &str = "<cube> & \"turn\"";

/// Corners of the cube's twelve triangles, counter-clockwise from outside.
fn triangles() -> Vec<[u32; 3]> {
    let quads = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    quads.into_iter().flat_map(halves).collect()
}

/// The cube in a frame, vertex light from above and the front.
fn cube_at(frame: usize) -> PlanarFrame {
    let turn = Mat3::from_rotation_x(0.5) * Mat3::from_rotation_y(0.3 + frame as f32 * 0.11);
    let mut out = PlanarFrame::default();
    for i in 0..8 {
        let side = |bit: u32| if i >> bit & 1 == 0 { -0.5 } else { 0.5 };
        let place = turn * Vec3::new(side(0), side(1), side(2));
        let depth = 4.0 - place.z;
        let scale = 360.0 / depth;
        out.xy
            .push(Vec2::new(100.0 + scale * place.x, 100.0 - scale * place.y));
        out.nearness.push(1.0 / depth);
        out.light.push(0.55 + 0.3 * place.z + 0.25 * place.y);
    }
    out
}

/// The clip with whole frames at even indices and their mean between them.
fn cube() -> PlanarClip {
    let whole: Vec<PlanarFrame> = (0..FRAMES).map(cube_at).collect();
    let mean = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a + b) / 2.0).collect();
    let between = |pair: &[PlanarFrame]| PlanarFrame {
        xy: (0..8)
            .map(|v| (pair[0].xy[v] + pair[1].xy[v]) / 2.0)
            .collect(),
        nearness: mean(&pair[0].nearness, &pair[1].nearness),
        light: mean(&pair[0].light, &pair[1].light),
    };
    let mut frames = vec![whole[0].clone()];
    for pair in whole.windows(2) {
        frames.extend([between(pair), pair[1].clone()]);
    }
    let triangles = triangles();
    let surfaces = COLORS.map(|albedo| PlanarMaterial {
        name: String::new(),
        albedo: Some(albedo),
    });
    // One side of each opposite pair has the second colour; corners are shared, so the vertices are
    // doubled.
    let surface: Vec<u16> = (0..12).map(|t| (t / 2 % 2) as u16).collect();
    let corner = |t: usize, v: u32| v + 8 * u32::from(surface[t]);
    let doubled = |frame: PlanarFrame| PlanarFrame {
        xy: frame.xy.repeat(2),
        nearness: frame.nearness.repeat(2),
        light: frame.light.repeat(2),
    };
    PlanarClip {
        width: SIDE,
        height: SIDE,
        fps: 2.0 * FPS,
        frames: frames.into_iter().map(doubled).collect(),
        triangles: (0..12)
            .map(|t| triangles[t].map(|v| corner(t, v)))
            .collect(),
        surface,
        part: vec![0; 12],
        surfaces: surfaces.to_vec(),
        albedo: COLORS
            .iter()
            .flat_map(|c| vec![c.map(f32::from); 8])
            .collect(),
        texture: None,
    }
}

fn on_grid(value: f32) -> i32 {
    (value * GRID as f32).round() as i32
}

/// Line from where the light would be 0 to where it would be 1.
fn line(places: [Vec2; 3], light: [f32; 3]) -> [i32; 4] {
    let [a, b, c] = places;
    let (ab, ac) = (b - a, c - a);
    let (db, dc) = (light[1] - light[0], light[2] - light[0]);
    let slope = Vec2::new(db * ac.y - dc * ab.y, dc * ab.x - db * ac.x) / ab.perp_dot(ac);
    let way = slope / slope.length_squared();
    let from = a - way * light[0];
    [from.x, from.y, from.x + way.x, from.y + way.y].map(on_grid)
}

/// A key at each whole frame; faces turned away are hidden.
fn keyed(clip: &PlanarClip, shading: Shading) -> KeyedClip {
    let whole = |i: usize| 2 * i;
    let keys: Vec<u32> = (0..FRAMES as u32).collect();
    let shape = |t: usize| {
        let places = |i: usize| clip.places(whole(i), t);
        let light = |i: usize| clip.triangles[t].map(|v| clip.frames[whole(i)].light[v as usize]);
        // y points down, so a counter-clockwise triangle has negative area.
        let is_front = |i: &usize| {
            let [a, b, c] = places(*i);
            (b - a).perp_dot(c - a) < 0.0
        };
        let fronts: Vec<usize> = (0..FRAMES).filter(is_front).collect();
        let (first, last) = (*fronts.first()?, *fronts.last()?);
        assert_eq!(fronts.len(), last + 1 - first, "a side comes and goes once");
        let track = |values: Vec<i32>, width| KeyedTrack {
            frames: keys.clone(),
            values,
            width,
        };
        let points = |i: usize| places(i).map(|p| [on_grid(p.x), on_grid(p.y)]);
        let outline = (0..FRAMES).flat_map(|i| points(i).as_flattened().to_vec());
        let lines = (0..FRAMES).flat_map(|i| line(places(i), light(i)));
        let end = 2 * (FRAMES as u32 - 1) + 1;
        let shown = (2 * first as u32).saturating_sub(1)..(2 * last as u32 + 1).min(end);
        Some(KeyedShape {
            motion: None,
            outline: track(outline.collect(), 6),
            further_outlines: vec![],
            paint: match shading {
                Shading::Flat => {
                    KeyedPaint::Flat(flat_color(clip, t, fronts.into_iter().map(whole)))
                }
                Shading::Gouraud => KeyedPaint::Ramp {
                    ramp: clip.surface[t].into(),
                    line: track(lines.collect(), 4),
                },
            },
            shown: vec![shown],
        })
    };
    KeyedClip {
        width: clip.width,
        height: clip.height,
        fps: FPS,
        frames: FRAMES as u32,
        ramps: COLORS.to_vec(),
        motions: vec![],
        lines: LineUnits::Grid,
        shapes: (0..clip.triangles.len()).filter_map(shape).collect(),
    }
}

/// A document to be shown at the given frames.
fn item(kind: &'static str, text: &str, frames: &[f64]) -> Item {
    Item {
        kind,
        file: browser::write("cube", text.as_bytes()),
        size: [SIDE; 2],
        times_secs: frames.iter().map(|f| f / f64::from(FPS)).collect(),
        plays: false,
    }
}

#[test]
fn what_is_written_keeps_to_the_schema() {
    if !judges::judges_are_here() || !real::data_is_here() {
        return;
    }
    let [clip, flat] = [Shading::Gouraud, Shading::Flat].map(|s| keyed(&cube(), s));
    let none = KeyedClip {
        shapes: vec![],
        frames: 1,
        ..clip.clone()
    };
    let along = along(&clip);
    let mut texts: Vec<String> = [&clip, &flat, &none, &along]
        .map(|clip| lottie(clip, NAME).unwrap())
        .into();
    let goods = texts.len();
    // A missing or malformed member is detected, so the schema is the right one.
    for (good, bad) in [
        (r#""t":1,"g""#, r#""g""#),
        (r#""c":true,"i""#, r#""c":true,"j""#),
    ] {
        assert!(texts[0].contains(good));
        texts.push(texts[0].replacen(good, bad, 1));
    }
    let schema = real::data_folder().join("fixtures/lottie_spec/schema");
    let files = texts
        .iter()
        .map(|text| browser::write("schema.json", text.as_bytes()));
    let words = std::iter::once(schema).chain(files);
    let words: Vec<String> = words.map(|w| w.to_string_lossy().into_owned()).collect();
    // All in one go: to compile the schema takes most of the time.
    let (verdicts, all_good) = judges::ask("lottie_schema.mjs", &words);
    assert!(!all_good, "{verdicts}");
    let verdicts: Vec<serde_json::Value> = serde_json::from_str(&verdicts).unwrap();
    assert_eq!(verdicts.len(), texts.len());
    for (i, verdict) in verdicts.iter().enumerate() {
        let is_good = verdict["faults"].as_array().unwrap().is_empty();
        assert_eq!(is_good, i < goods, "{verdict}");
    }
}

/// Frames at which the players show the cube. dotlottie-web shows nothing later than one frame before
/// the end.
const MOMENTS: [f64; 6] = [0.0, 0.5, 3.0, 3.5, 6.5, 7.5];

/// The same clip with shapes that follow a motion, in its coordinates.
fn along(clip: &KeyedClip) -> KeyedClip {
    let last = FRAMES as u32 - 1;
    let moving = |from: &[i32], to: &[i32]| KeyedTrack {
        frames: vec![0, last],
        values: [from, to].concat(),
        width: from.len(),
    };
    let motion = KeyedMotion {
        translation: moving(&[3000, 4200], &[4600, 3600]),
        rotation: moving(&[-900], &[2400]),
        skew: moving(&[1500], &[-1200]),
        scale: moving(&[12_500, 8000], &[8200, 11_000]),
    };
    let moved = |track: &KeyedTrack| {
        let mut values = Vec::new();
        for (key, frame) in track.frames.iter().enumerate() {
            let to_shape = motion.at(f64::from(*frame)).inverse();
            for place in track.key(key).chunks_exact(2) {
                let place = DVec2::new(f64::from(place[0]), f64::from(place[1]));
                values.extend(to_shape.transform_point2(place).to_array());
            }
        }
        KeyedTrack {
            values: values.into_iter().map(|v| v.round() as i32).collect(),
            ..track.clone()
        }
    };
    let shape = |shape: &KeyedShape| {
        let KeyedPaint::Ramp { ramp, line } = &shape.paint else {
            panic!("a cube of ramps");
        };
        KeyedShape {
            motion: Some(0),
            outline: moved(&shape.outline),
            paint: KeyedPaint::Ramp {
                ramp: *ramp,
                line: moved(line),
            },
            ..shape.clone()
        }
    };
    KeyedClip {
        shapes: clip.shapes.iter().map(shape).collect(),
        motions: vec![motion.clone()],
        ..clip.clone()
    }
}

/// Documents of the cube with gradients as SVG and in both players, of the flat cube, of the cube with
/// shapes that follow a motion and of a ring in both players.
fn documents() -> Vec<Item> {
    let cube = cube();
    let gouraud = keyed(&cube, Shading::Gouraud);
    let flat = keyed(&cube, Shading::Flat);
    let of = |clip: &KeyedClip| lottie(clip, NAME).unwrap();
    let (text, flat_text, ring_text) = (of(&gouraud), of(&flat), of(&ring(flat)));
    let svg = smil(&gouraud, NAME).unwrap();
    let mut items = vec![
        item("smil", &svg, &MOMENTS),
        item("lottie", &text, &MOMENTS),
        item("dotlottie", &text, &MOMENTS[..5]),
    ];
    let both = |text: &str, frame| ["lottie", "dotlottie"].map(|kind| item(kind, text, &[frame]));
    items.extend(both(&flat_text, 2.5));
    let along = along(&gouraud);
    items.push(item("smil", &smil(&along, NAME).unwrap(), &[3.0]));
    items.extend(both(&of(&along), 3.0));
    items.extend(both(&ring_text, 0.0));
    items
}

/// What Chromium shows of the [`documents`], which is started once, because that takes most of the
/// time; `None` if it is missing.
fn shown() -> Option<&'static [Seen]> {
    static SHOWN: OnceLock<Option<Vec<Seen>>> = OnceLock::new();
    let take = || {
        let items = documents();
        let seen = shots(&items)?;
        assert_eq!(seen.len(), items.len());
        Some(seen)
    };
    SHOWN.get_or_init(take).as_deref()
}

/// Difference of two pictures, exceeded by only a fraction of the pixels.
fn quantile_of_differences(a: &Picture, b: &Picture, share: f64) -> u8 {
    let furthest = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).map(|i| a[i].abs_diff(b[i])).max();
    let pairs = a.pixels().iter().zip(b.pixels());
    let mut all: Vec<u8> = pairs.filter_map(furthest).collect();
    all.sort_unstable();
    all[((1.0 - share) * (all.len() - 1) as f64) as usize]
}

/// Positions and colours are correct; the differences are cracks between triangles, which this
/// cube's outlines do not cover, and anti-aliasing.
#[test]
fn players_show_the_cube_at_whole_frames_and_between_them() {
    let cube = cube();
    let Some([drawn, lottie, dotlottie, ..]) = shown() else {
        return;
    };
    for (kind, player) in [("lottie", lottie), ("dotlottie", dotlottie)] {
        for (i, picture) in player.pictures.iter().enumerate() {
            let at = format!("{kind} at frame {}", MOMENTS[i]);
            let moment = (MOMENTS[i] * 2.0) as usize;
            let truth = reference(&cube, moment, Supersampling::Eight, [255; 4]).unwrap();
            let apart = rmse(&truth, picture).unwrap();
            assert!(apart <= 4.5, "{at}: {apart} levels");
            let inside = quantile_of_differences(&truth, picture, 0.05);
            assert!(inside <= 3, "{at}: {inside} levels");
            // The same clip as SVG has the same cracks; only anti-aliasing differs.
            let other = &drawn.pictures[i];
            let from_svg = rmse(other, picture).unwrap();
            assert!(from_svg <= 2.5, "{at}: {from_svg} levels from the SVG");
            let [mine, others] = [picture, other].map(|p| ssim(&truth, p).unwrap());
            assert!(mine >= others - 0.002, "{at}: {mine}, {others}");
        }
    }
}

/// Without gradients a triangle has one colour, which leaves an error of about 8 levels.
#[test]
fn players_show_the_flat_cube() {
    let cube = cube();
    let Some([_, _, _, lottie, dotlottie, ..]) = shown() else {
        return;
    };
    let [a, b] = [lottie, dotlottie].map(|seen| &seen.pictures[0]);
    assert!(quantile_of_differences(a, b, 0.05) <= 1);
    let truth = reference(&cube, 5, Supersampling::Eight, [255; 4]).unwrap();
    for picture in [a, b] {
        let apart = rmse(&truth, picture).unwrap();
        assert!((4.5..10.0).contains(&apart), "{apart} levels");
    }
}

/// Rotation, skew, scale and translation are composed as in SVG: a wrong sign or sequence moves the cube
/// by many pixels.
#[test]
fn players_show_shapes_that_follow_a_motion() {
    let Some([drawn, _, _, _, _, along, lottie, dotlottie, ..]) = shown() else {
        return;
    };
    // Frame 3; corners are off by half a grid step, which moves the cracks.
    let [plain, along] = [&drawn.pictures[2], &along.pictures[0]];
    let apart = rmse(plain, along).unwrap();
    assert!(apart <= 6.0, "{apart} levels");
    for (kind, seen) in [("lottie", lottie), ("dotlottie", dotlottie)] {
        let apart = rmse(along, &seen.pictures[0]).unwrap();
        assert!(apart <= 2.5, "{kind}: {apart} levels from the SVG");
    }
}

/// A clip of one shape, an outline inside another with the opposite winding.
fn ring(clip: KeyedClip) -> KeyedClip {
    let ring = KeyedShape {
        motion: None,
        outline: KeyedTrack::still(vec![
            0, 0, 800, 0, 800, 800, 0, 800, 200, 200, 200, 600, 600, 600, 600, 200,
        ]),
        further_outlines: vec![4],
        paint: KeyedPaint::Flat([51, 102, 204]),
        shown: std::iter::once(0..3).collect(),
    };
    KeyedClip {
        frames: 2,
        shapes: vec![ring],
        ..clip
    }
}

/// An outline inside another with the opposite winding is a hole.
#[test]
fn players_leave_holes_open() {
    let Some([.., lottie, dotlottie]) = shown() else {
        return;
    };
    for (kind, seen) in [("lottie", lottie), ("dotlottie", dotlottie)] {
        let pixel = |x, y| seen.pictures[0].get(x, y);
        let found = [pixel(25, 100), pixel(100, 100), pixel(100, 175)];
        let (blue, white) = ([51, 102, 204, 255], [255; 4]);
        assert_eq!(found, [Some(blue), Some(white), Some(blue)], "{kind}");
    }
}
