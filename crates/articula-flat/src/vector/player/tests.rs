//! Player clips written and read back; malformed containers.

use super::clip::PlayerClip;
use super::container::{MAGIC, VERSION, encode, encode_parts};
use super::decode::decode;
use super::error::PlayerError;
use super::make::PlayerFile;
use super::*;
use crate::item_buffer::Supersampling;
use crate::picture::Picture;
use crate::planar::clip::fixture::{loose, turning_cube};
use crate::planar::reference::reference;
use crate::planar::shading::Shading;
use crate::planar::{Drawn, Epoch, Painting, PlanarClip, PlanarError, PlanarTexture};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use proptest::prelude::*;
use std::io::{Read, Write};

impl PlayerClip {
    /// All frames as a planar clip over its wedges, so that other writers can draw it. Nearness is
    /// unknown and zero everywhere; the order is in [`Self::epochs`]. With flat shading each
    /// triangle has wedges of its own colour.
    pub(crate) fn to_planar(&self) -> PlanarClip {
        let frames = (0..self.frames).map(|f| self.planar_frame(f64::from(f)));
        self.planar(frames.collect())
    }

    /// Visibility of the triangles.
    pub(crate) fn drawn(&self) -> Drawn {
        let mut drawn = Drawn::none(self.frames as usize, self.triangles.len());
        for (t, spans) in self.shown.iter().enumerate() {
            for f in spans.iter().flat_map(Clone::clone) {
                drawn.set(f as usize, t, true);
            }
        }
        drawn
    }
}

fn cube_file(options: &PlayerOptions) -> (PlanarClip, Drawn, Painting, PlayerFile) {
    let cube = turning_cube(24);
    let drawn = Drawn::of(&cube).unwrap();
    let painting = Painting::per_frame(&cube, &drawn).unwrap();
    let file = player(&cube, &drawn, &painting, options).unwrap();
    (cube, drawn, painting, file)
}

/// The turning cube, of whose triangles all but the first two show a picture.
fn textured_cube() -> (PlanarClip, PlayerFile) {
    let mut cube = turning_cube(24);
    let level = |x: u32, y: u32| [(8 * x) as u8, (8 * y) as u8, 90, 255];
    let pixels = (0..32).flat_map(|y| (0..32).map(move |x| level(x, y)));
    let picture = Picture::from_pixels(32, 32, pixels.collect()).unwrap();
    cube.texture = Some(PlanarTexture {
        picture: std::sync::Arc::new(picture),
        // A slanted view of the cube, so that no side is a line.
        places: (0..8u8)
            .map(|v| [v & 1, v >> 1 & 1, v >> 2 & 1].map(f32::from))
            .map(|[x, y, z]| glam::Vec2::new(3.0 + 18.0 * x + 8.0 * z, 2.0 + 18.0 * y + 8.0 * z))
            .collect(),
        shows: (0..12).map(|t| t > 1).collect(),
    });
    let drawn = Drawn::of(&cube).unwrap();
    let painting = Painting::per_frame(&cube, &drawn).unwrap();
    let file = player(&cube, &drawn, &painting, &PlayerOptions::default()).unwrap();
    (cube, file)
}

#[test]
fn a_picture_comes_back_and_is_painted() {
    let (cube, file) = textured_cube();
    assert!(file.text.contains("createPattern"));
    let clip = decode(&file.container).unwrap();
    is_sound(&clip);
    let (again, parts) = encode_parts(&clip);
    assert_eq!((again, parts), (file.container.clone(), file.stats.parts));
    assert!(parts.texture > 0);
    for f in [0, 7, 23] {
        let truth = reference(&cube, f, Supersampling::Four, [255; 4]).unwrap();
        let painted = clip.painted(f as f64);
        painted.check().unwrap();
        let found = reference(&painted, 0, Supersampling::Four, [255; 4]).unwrap();
        let rmse = crate::compare::rmse(&truth, &found).unwrap();
        let plain = PlanarClip {
            texture: None,
            ..cube.clone()
        };
        let plain = reference(&plain, f, Supersampling::Four, [255; 4]).unwrap();
        let without = crate::compare::rmse(&truth, &plain).unwrap();
        assert!(
            rmse < 4.0 && without > 3.0 * rmse,
            "{rmse}, {without} in frame {f}"
        );
    }
    // Flat fills are lit colours, which a picture has none of.
    let drawn = Drawn::of(&cube).unwrap();
    let painting = Painting::per_frame(&cube, &drawn).unwrap();
    let filled = player(&cube, &drawn, &painting, &flat()).unwrap();
    assert!(decode(&filled.container).unwrap().texture.is_none());
}

#[test]
fn what_is_drawn_edge_by_edge_is_near_the_ideal() {
    let plain = cube_file(&PlayerOptions::default());
    for (cube, container) in [(plain.0, plain.3.container), {
        let (cube, file) = textured_cube();
        (cube, file.container)
    }] {
        let clip = decode(&container).unwrap();
        for f in [0, 7, 23] {
            let truth = reference(&cube, f, Supersampling::Four, [255; 4]).unwrap();
            let drawn = on_canvas(&clip, f as f64, [255; 4]).unwrap();
            let rmse = crate::compare::rmse(&truth, &drawn).unwrap();
            assert!(rmse < 6.0, "{rmse} in frame {f}");
        }
    }
}

#[test]
fn a_clip_with_a_broken_picture_is_refused() {
    let (_, file) = textured_cube();
    let body = body_of(&file.container);
    let at = body.windows(4).position(|w| w == b"RIFF").unwrap();
    let mut broken = body.clone();
    broken[at] = b'X';
    assert!(matches!(
        decode(&wrapped(&broken)),
        Err(PlayerError::Picture(_))
    ));
    for length in (0..body.len()).step_by(7) {
        let found = decode(&wrapped(&body[..length]));
        assert_eq!(found, Err(PlayerError::Truncated), "{length}");
    }
    // The flag of a picture without that of Gouraud shading.
    let mut lit = body;
    let flags = 6;
    assert_eq!(lit[flags], 5);
    lit[flags] = 4;
    assert_eq!(
        decode(&wrapped(&lit)),
        Err(PlayerError::Malformed("unknown flag"))
    );
}

fn flat() -> PlayerOptions {
    PlayerOptions {
        shading: Shading::Flat,
        ..PlayerOptions::default()
    }
}

/// A container around bytes that are stored uncompressed.
fn wrapped(body: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new([&MAGIC[..], &[VERSION]].concat(), Compression::fast());
    encoder.write_all(body).unwrap();
    encoder.finish().unwrap()
}

fn body_of(container: &[u8]) -> Vec<u8> {
    let mut body = Vec::new();
    let mut decoder = flate2::read::ZlibDecoder::new(&container[5..]);
    decoder.read_to_end(&mut body).unwrap();
    body
}

#[test]
fn a_clip_comes_back_as_it_was_written() {
    for options in [PlayerOptions::default(), flat()] {
        let (cube, drawn, painting, file) = cube_file(&options);
        let clip = decode(&file.container).unwrap();
        let (again, parts) = encode_parts(&clip);
        assert_eq!(again, file.container);
        assert_eq!(parts, file.stats.parts);
        assert_eq!(decode(&again).unwrap(), clip);
        assert_eq!((clip.frames, clip.points()), (24, 8));
        assert_eq!(clip.epochs.len(), painting.epochs.len());
        assert_eq!(clip.triangles.len(), drawn.ever().len());
        assert_eq!(
            (clip.frames as usize, clip.fps),
            (cube.frames.len(), cube.fps)
        );
        assert_eq!(file.stats.rank, clip.motion.components.len());
    }
}

#[test]
fn places_and_light_are_within_the_tolerance_of_the_source() {
    for (pos_tol_px, col_tol_levels) in [(0.02, 0.1), (0.1, 1.0), (2.0, 10.0)] {
        let options = PlayerOptions {
            pos_tol_px,
            col_tol_levels,
            ..PlayerOptions::default()
        };
        let (cube, _, painting, file) = cube_file(&options);
        let clip = decode(&file.container).unwrap();
        // The cube shares its corners, so each wedge is a vertex, found by its first frame.
        let (mut far, mut dark, mut count) = (0.0, 0.0, 0.0);
        let sources = painting.epochs.iter().flat_map(|e| e.order.iter().copied());
        let mut seen = Vec::new();
        sources.for_each(|t| {
            if !seen.contains(&t) {
                seen.push(t)
            }
        });
        for f in 0..24 {
            let moment = clip.moment(f as f64);
            for (triangle, source) in clip.triangles.iter().zip(&seen) {
                // Corners may have been rotated.
                let places = cube.places(f, *source as usize);
                let first = moment.xy[triangle[0] as usize];
                let nearest = |k: &usize| (first - places[*k]).length();
                let turn = (0..3)
                    .min_by(|a, b| nearest(a).total_cmp(&nearest(b)))
                    .unwrap();
                for (k, wedge) in triangle.iter().enumerate() {
                    let corner = (turn + k) % 3;
                    let vertex = cube.triangles[*source as usize][corner] as usize;
                    far +=
                        f64::from((moment.xy[*wedge as usize] - places[corner]).length_squared());
                    let off = moment.light[*wedge as usize] - cube.frames[f].light[vertex];
                    dark += f64::from(off * 255.0).powi(2);
                    count += 1.0;
                }
            }
        }
        // Corners of more triangles count more often here than in the tolerance.
        assert!(
            (far / count).sqrt() < 1.3 * pos_tol_px,
            "{}",
            (far / count).sqrt()
        );
        assert!((dark / count).sqrt() < 1.3 * col_tol_levels);
        assert!(file.stats.position_rmse_px <= pos_tol_px);
        assert!(file.stats.light_rmse_levels <= col_tol_levels);
    }
}

#[test]
fn a_coarser_tolerance_never_costs_more() {
    let size = |pos_tol_px: f64| {
        let options = PlayerOptions {
            pos_tol_px,
            ..PlayerOptions::default()
        };
        cube_file(&options).3.container.len()
    };
    assert!(size(0.01) > size(0.1) && size(0.1) > size(1.0));
}

#[test]
fn what_the_player_paints_looks_like_the_source() {
    let (cube, _, _, file) = cube_file(&PlayerOptions::default());
    let clip = decode(&file.container).unwrap();
    for f in [0, 7, 23] {
        let truth = reference(&cube, f, Supersampling::Four, [255; 4]).unwrap();
        let painted = clip.painted(f as f64);
        painted.check().unwrap();
        let found = reference(&painted, 0, Supersampling::Four, [255; 4]).unwrap();
        let rmse = crate::compare::rmse(&truth, &found).unwrap();
        assert!(rmse < 3.0, "{rmse} in frame {f}");
    }
}

#[test]
fn where_scripts_do_not_run_the_first_frame_is_shown() {
    let (cube, _, _, file) = cube_file(&PlayerOptions::default());
    let (_, rest) = file.text.split_once("data:image/webp;base64,").unwrap();
    let still = BASE64_STANDARD
        .decode(rest.split('"').next().unwrap())
        .unwrap();
    let still = Picture::decode(&still).unwrap();
    assert_eq!(still.get(0, 0).map(|p| p[3]), Some(0), "no background");
    for background in [[255; 4], [0, 0, 0, 255]] {
        let truth = reference(&cube, 0, Supersampling::Four, background).unwrap();
        let mut found = Picture::new(cube.width, cube.height, background).unwrap();
        found.blit(&still, 0, 0);
        let rmse = crate::compare::rmse(&truth, &found).unwrap();
        assert!(rmse < 5.0, "{rmse} over {background:?}");
    }
    let module = PlayerOptions {
        output: PlayerOutput::Module,
        ..PlayerOptions::default()
    };
    assert!(!cube_file(&module).3.text.contains("data:image"));
}

#[test]
fn other_writers_get_the_same_places_triangles_and_times() {
    for options in [PlayerOptions::default(), flat()] {
        let (_, drawn, _, file) = cube_file(&options);
        let clip = decode(&file.container).unwrap();
        let planar = clip.to_planar();
        planar.check().unwrap();
        assert_eq!(planar.frames.len(), 24);
        let shown = |d: &Drawn, f| {
            (0..12)
                .filter(|t| *t < clip.triangles.len() && d.get(f, *t))
                .count()
        };
        for f in 0..24 {
            let wanted = (0..12).filter(|t| drawn.get(f, *t)).count();
            assert_eq!(shown(&clip.drawn(), f), wanted);
        }
        let moment = clip.moment(3.0);
        let corner = clip.triangles[1][2] as usize;
        assert_eq!(planar.places(3, 1)[2], moment.xy[corner]);
    }
}

#[test]
fn moments_run_straight_and_orders_change_halfway() {
    let (_, _, painting, file) = cube_file(&PlayerOptions::default());
    let clip = decode(&file.container).unwrap();
    let (a, b, middle) = (clip.moment(4.0), clip.moment(5.0), clip.moment(4.25));
    for ((a, b), m) in a.xy.iter().zip(&b.xy).zip(&middle.xy) {
        assert!((*a * 0.75 + *b * 0.25 - *m).length() < 1e-4);
    }
    assert_eq!(clip.moment(-3.0), clip.moment(0.0));
    assert_eq!(clip.moment(99.0), clip.moment(23.0));
    let first = painting.epochs[1].frames.start as f64;
    assert_eq!(clip.order_at(first - 0.51), &clip.epochs[0].order[..]);
    assert_eq!(clip.order_at(first - 0.5), &clip.epochs[1].order[..]);
    assert_eq!(clip.order_at(-1.0), &clip.epochs[0].order[..]);
}

#[test]
fn a_still_clip_has_no_component_and_one_frame_is_enough() {
    let front = [[2.0, 2.0, 0.9], [2.0, 38.0, 0.9], [38.0, 2.0, 0.9]];
    for frames in [1, 3] {
        let clip = loose(&[(front, [10, 20, 30])], frames);
        let drawn = Drawn::of(&clip).unwrap();
        let painting = Painting::single(&clip, &drawn).unwrap();
        let file = player(&clip, &drawn, &painting, &PlayerOptions::default()).unwrap();
        assert_eq!((file.stats.rank, file.stats.triangles), (0, 1));
        let back = decode(&file.container).unwrap();
        assert_eq!(back.colors, [[10, 20, 30]; 3]);
        assert!(back.is_shown_at(0, 0.0) && back.is_shown_at(0, 99.0));
    }
}

#[test]
fn what_does_not_fit_the_clip_is_refused() {
    let (cube, drawn, painting, _) = cube_file(&flat());
    let tried = |painting: &Painting, pos_tol_px| {
        let options = PlayerOptions {
            pos_tol_px,
            ..flat()
        };
        player(&cube, &drawn, painting, &options)
    };
    let epoch = |frames, triangle| Epoch {
        frames,
        order: vec![triangle],
    };
    for epochs in [
        vec![],
        vec![epoch(0..23, 0)],
        vec![epoch(1..24, 0)],
        vec![epoch(0..5, 0), epoch(6..24, 0)],
        vec![epoch(0..24, 99)],
    ] {
        let found = tried(&Painting { epochs }, 0.1);
        assert!(matches!(
            found,
            Err(PlanarError::Mismatch { at: "painting", .. })
        ));
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = tried(&painting, tolerance);
        assert!(matches!(
            found,
            Err(PlanarError::Mismatch {
                at: "pos_tol_px",
                ..
            })
        ));
    }
    let none = Drawn::none(24, 12);
    let found = player(&cube, &none, &painting, &flat());
    assert_eq!(found, Err(PlanarError::NothingVisible));
    let mut far = cube.clone();
    far.frames[2].xy[1].x = 1e9;
    let found = player(&far, &drawn, &painting, &flat());
    assert!(matches!(
        found,
        Err(PlanarError::Mismatch { at: "clip", .. })
    ));
}

#[test]
fn every_cut_is_an_error() {
    let (.., file) = cube_file(&PlayerOptions::default());
    for length in 0..file.container.len() {
        assert!(decode(&file.container[..length]).is_err(), "{length}");
    }
    let body = body_of(&file.container);
    for length in 0..body.len() {
        let found = decode(&wrapped(&body[..length]));
        assert_eq!(found, Err(PlayerError::Truncated), "{length}");
    }
    let longer = decode(&wrapped(&[&body[..], &[0]].concat()));
    assert!(matches!(longer, Err(PlayerError::Malformed(_))));
}

#[test]
fn other_beginnings_are_told_apart() {
    assert_eq!(decode(b""), Err(PlayerError::NotAClip));
    assert_eq!(decode(b"GIF89a"), Err(PlayerError::NotAClip));
    assert_eq!(decode(b"ARTV"), Err(PlayerError::Truncated));
    assert_eq!(decode(b"ARTV\x07rest"), Err(PlayerError::Version(7)));
    assert_eq!(decode(b"ARTV\x01rest"), Err(PlayerError::Compression));
    let bomb = wrapped(&vec![0; decode::MAX_BODY_BYTES + 9]);
    assert!(bomb.len() < 1 << 18);
    assert_eq!(
        decode(&bomb),
        Err(PlayerError::TooLarge(decode::MAX_BODY_BYTES))
    );
    // One pixel, 65535 frames.
    let many = decode(&wrapped(&[1, 1, 0xff, 0xff, 3]));
    assert!(matches!(
        many,
        Err(PlayerError::TooMany { what: "frames", .. })
    ));
}

/// Whatever is decoded can be drawn at any time and encoded again.
fn is_sound(clip: &PlayerClip) {
    for frame in [-1.0, 0.3, f64::from(clip.frames)] {
        let moment = clip.moment(frame);
        assert!(moment.xy.iter().all(|p| !p.is_nan()));
        assert_eq!(moment.light.len(), clip.wedge_points.len());
        clip.painted(frame);
    }
    assert_eq!(decode(&encode(clip)).as_ref(), Ok(clip));
}

proptest! {
    #[test]
    fn changed_bytes_are_read_soundly_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        kind in 0..3usize,
    ) {
        static BODIES: std::sync::OnceLock<[Vec<u8>; 3]> = std::sync::OnceLock::new();
        let bodies = BODIES.get_or_init(|| {
            let [gouraud, flat] = [PlayerOptions::default(), flat()].map(|o| cube_file(&o).3);
            [gouraud, flat, textured_cube().1].map(|file| body_of(&file.container))
        });
        let mut body = bodies[kind].clone();
        for (at, byte) in changes {
            let at = at.index(body.len());
            body[at] = byte;
        }
        if let Ok(clip) = decode(&wrapped(&body)) {
            is_sound(&clip);
        }
    }

    #[test]
    fn any_bytes_are_read_soundly_or_refused(body in prop::collection::vec(any::<u8>(), 0..200)) {
        if let Ok(clip) = decode(&wrapped(&body)) {
            is_sound(&clip);
        }
    }
}

fn two_inputs() -> (LiveSource, Drawn, Painting) {
    let mut shapes = turning_cube(1);
    let neutral = shapes.frames[0].clone();
    let triangle = Drawn::of(&shapes).unwrap().ever()[0];
    let seen = shapes.triangles[triangle as usize][0] as usize;
    for (dx, dl) in [(6.0, 0.0), (0.5, -0.25)] {
        let mut frame = neutral.clone();
        frame.xy[seen].x += dx;
        frame.light.iter_mut().for_each(|l| *l += dl);
        shapes.frames.push(frame);
    }
    let drawn = Drawn::of(&shapes).unwrap();
    let painting = Painting::single(&shapes, &drawn).unwrap();
    let source = LiveSource {
        shapes,
        inputs: vec!["jawOpen".into(), "Ärger".into()],
        weights: vec![vec![0.0, 0.0], vec![1.0, 0.5], vec![0.25, -1.0]],
    };
    (source, drawn, painting)
}

#[test]
fn inputs_add_up_and_the_clip_plays_their_weights() {
    let (source, drawn, painting) = two_inputs();
    let options = PlayerOptions {
        pos_tol_px: 0.02,
        col_tol_levels: 0.2,
        ..PlayerOptions::default()
    };
    let file = live_player(&source, &drawn, &painting, &options).unwrap();
    let clip = decode(&file.container).unwrap();
    is_sound(&clip);
    assert_eq!(clip.inputs, source.inputs);
    assert!(file.text.contains("articulaInputs"));
    let moment = |frame| clip.moment(frame);
    // Each wedge is a vertex of the cube; only one moves.
    let moved = (0..clip.wedge_points.len())
        .find(|w| (moment(1.0).xy[*w] - moment(0.0).xy[*w]).length() > 1.0)
        .unwrap();
    for (frame, x, light) in [(1.0, 6.25, -0.125), (2.0, 1.0, 0.25), (1.5, 3.625, 0.0625)] {
        let (now, then) = (moment(frame), moment(0.0));
        assert!((now.xy[moved].x - then.xy[moved].x - x).abs() < 0.15);
        assert!((now.light[moved] - then.light[moved] - light).abs() < 0.003);
    }
}

#[test]
fn names_and_weights_that_do_not_fit_are_refused() {
    let (source, drawn, painting) = two_inputs();
    let tried =
        |source: &LiveSource| live_player(source, &drawn, &painting, &PlayerOptions::default());
    let mut short = source.clone();
    short.inputs.pop();
    assert!(matches!(
        tried(&short),
        Err(PlanarError::Mismatch { at: "inputs", .. })
    ));
    let mut odd = source.clone();
    odd.weights[1].pop();
    assert!(matches!(
        tried(&odd),
        Err(PlanarError::Mismatch { at: "weights", .. })
    ));
    let mut wild = source.clone();
    wild.weights[1][0] = f32::NAN;
    assert!(matches!(
        tried(&wild),
        Err(PlanarError::Mismatch { at: "weights", .. })
    ));
    let without = LiveSource {
        weights: vec![],
        ..source
    };
    let clip = decode(&tried(&without).unwrap().container).unwrap();
    assert_eq!(clip.frames, 1);
}
