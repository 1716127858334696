//! Tests of key-frame reduction.

use super::super::clip::fixture;
use super::*;
use crate::planar::order::Painting;
use crate::vector::AnimatedSvg;
use crate::vector::smil;

fn unsealed(clip: &PlanarClip) -> Sealed {
    let of = |f| {
        (0..clip.triangles.len())
            .map(|t| clip.places(f, t))
            .collect()
    };
    Sealed {
        corners: (0..clip.frames.len()).map(of).collect(),
    }
}

fn reduced(clip: &PlanarClip, options: &KeyOptions) -> (KeyedClip, KeyStats, Vec<Layer>) {
    let drawn = Drawn::of(clip).unwrap();
    let layers = Painting::single(clip, &drawn).unwrap().layers(&drawn);
    let (keyed, stats) = keyed(clip, &drawn, &layers, &unsealed(clip), options).unwrap();
    keyed.check().unwrap();
    (keyed, stats, layers)
}

#[test]
fn every_drawn_corner_is_within_the_tolerance() {
    let clip = fixture::turning_cube(60);
    for (pos_tol_px, lines) in [
        (0.25, LineUnits::Grid),
        (0.5, LineUnits::Box),
        (2.0, LineUnits::Box),
    ] {
        let options = KeyOptions {
            pos_tol_px,
            lines,
            ..KeyOptions::default()
        };
        let (keyed, stats, layers) = reduced(&clip, &options);
        assert!(
            stats.position_max_px <= f64::from(pos_tol_px) + 1e-6,
            "{stats:?}"
        );
        assert!(stats.color_rmse_levels <= 8.0, "{stats:?}");
        assert!(stats.outline_keys < 12 * 30, "{stats:?}");
        for (shape, layer) in keyed.shapes.iter().zip(&layers) {
            for f in layer.frames.iter().cloned().flatten() {
                assert!(shape.is_shown_at(f as f64));
                let at = shape.outline.at(f as f64);
                let places = clip.places(f, layer.triangle as usize);
                for (i, place) in places.into_iter().enumerate() {
                    let keyed = Vec2::new(at[2 * i] as f32, at[2 * i + 1] as f32) / GRID as f32;
                    let off = (keyed - place).abs().max_element();
                    assert!(off <= pos_tol_px + 1e-4, "frame {f}: {off}");
                }
            }
        }
    }
}

#[test]
fn corners_of_shapes_that_follow_a_motion_are_within_the_tolerance_too() {
    let clip = fixture::turning_cube(40);
    let still = |values: Vec<i32>| KeyedTrack::still(values);
    let turning = KeyedMotion {
        translation: still(vec![2000, 2000]),
        rotation: KeyedTrack {
            frames: vec![0, 39],
            values: vec![0, 4000],
            width: 1,
        },
        skew: still(vec![800]),
        scale: still(vec![12_000, 8000]),
    };
    let drawn = Drawn::of(&clip).unwrap();
    let layers = Painting::single(&clip, &drawn).unwrap().layers(&drawn);
    let options = KeyOptions::default();
    let of_layer = vec![Some(0); layers.len()];
    let along = |motions: &[KeyedMotion]| {
        let sealed = unsealed(&clip);
        let subject = (&clip, &drawn, &layers[..], &sealed);
        let follow = (motions, &of_layer[..]);
        keyed_along(subject, follow, &options, &mut Progress::none())
    };
    let (keyed, stats) = along(std::slice::from_ref(&turning)).unwrap();
    assert!(stats.position_max_px <= 0.5 + 1e-6, "{stats:?}");
    assert!(stats.color_rmse_levels <= 8.0, "{stats:?}");
    // On the picture, by the motion.
    for (shape, layer) in keyed.shapes.iter().zip(&layers) {
        for f in layer.frames.iter().cloned().flatten() {
            let at = shape.outline.at(f as f64);
            let places = clip.places(f, layer.triangle as usize);
            for (i, place) in places.into_iter().enumerate() {
                let point = DVec2::new(at[2 * i], at[2 * i + 1]);
                let shown = turning.at(f as f64).transform_point2(point) / f64::from(GRID);
                let off = (shown - place.as_dvec2()).abs().max_element();
                assert!(off <= 0.5 + 1e-4, "frame {f}: {off}");
            }
        }
    }
    // The file read back shows the same as without a motion.
    let picture = |clip: &KeyedClip| {
        let moving = AnimatedSvg::read(&smil(clip, "").unwrap()).unwrap();
        crate::vector::raster(&moving.at(0.8).unwrap(), [255; 4]).unwrap()
    };
    let (plain, ..) = reduced(&clip, &options);
    let apart = crate::compare::rmse(&picture(&keyed), &picture(&plain)).unwrap();
    assert!(apart < 9.0, "{apart} levels");
    assert!(along(&[]).is_err());
}

#[test]
fn more_tolerance_never_needs_more_bytes_on_a_cube() {
    let clip = fixture::turning_cube(60);
    let length = |pos_tol_px: f32| {
        let options = KeyOptions {
            pos_tol_px,
            shading: Shading::Flat,
            ..KeyOptions::default()
        };
        smil(&reduced(&clip, &options).0, "").unwrap().len()
    };
    let lengths = [0.25, 0.5, 1.0, 2.0].map(length);
    assert!(lengths.is_sorted_by(|a, b| a >= b), "{lengths:?}");
}

#[test]
fn a_triangle_that_slides_needs_two_keys_and_its_light_none() {
    let corners = [[-6.0, 2.0, 0.5], [-6.0, 12.0, 0.5], [4.0, 2.0, 0.5]];
    let mut clip = fixture::loose(&[(corners, [200, 100, 0])], 20);
    for (f, frame) in clip.frames.iter_mut().enumerate() {
        for p in &mut frame.xy {
            p.x += f as f32;
        }
        frame.light = vec![0.4, 0.4, 0.9];
    }
    let (keyed, stats, _) = reduced(&clip, &KeyOptions::default());
    assert_eq!((stats.outline_keys, stats.moving_gradients), (2, 0));
    assert_eq!(keyed.ramps, [[200, 100, 0]]);
    // The light covers the whole width of the box: black at -0.8, full at 1.2.
    let KeyedPaint::Ramp { line, .. } = &keyed.shapes[0].paint else {
        panic!("{keyed:?}");
    };
    let share = |x: f64| {
        let [x1, x2] = [line.values[0], line.values[2]].map(f64::from);
        (x * f64::from(BOX) - x1) / (x2 - x1)
    };
    assert!((share(0.0) - 0.4).abs() < 0.035 && (share(1.0) - 0.9).abs() < 0.035);
}

#[test]
fn edge_cases_are_written_and_read_back() {
    let sound = [[2.0, 2.0, 0.5], [2.0, 30.0, 0.5], [30.0, 2.0, 0.5]];
    let line = [[2.0, 2.0, 0.4], [12.0, 12.0, 0.4], [30.0, 30.0, 0.4]];
    let outside = [[-90.0, -90.0, 0.3], [-90.0, 70.0, 0.3], [70.0, -90.0, 0.3]];
    let of = |frames: usize| {
        let colored = [(outside, [9; 3]), (line, [50; 3]), (sound, [80; 3])];
        fixture::loose(&colored, frames)
    };
    for frames in [1, 2, 13] {
        let mut clip = of(frames);
        for (f, frame) in clip.frames.iter_mut().enumerate() {
            // Nearly uniform light, and a triangle that appears late.
            frame.light[0] = 0.999;
            if 2 * f < frames - 1 {
                frame.xy.swap(6, 7);
            }
        }
        let mut drawn = Drawn::of(&clip).unwrap();
        drawn.set(frames - 1, 1, true);
        // Two epochs share the first triangle.
        let split = frames / 2;
        let spans = |t: usize| drawn.spans(t);
        let first: Vec<_> = std::iter::once(0..split)
            .filter(|s| !s.is_empty())
            .collect();
        let layers = [
            Layer {
                triangle: 0,
                frames: first,
            },
            Layer {
                triangle: 1,
                frames: spans(1),
            },
            Layer {
                triangle: 2,
                frames: spans(2),
            },
            Layer {
                triangle: 0,
                frames: std::iter::once(split..frames).collect(),
            },
        ];
        let (sealed, usual) = (unsealed(&clip), KeyOptions::default());
        let (keyed, stats) = keyed(&clip, &drawn, &layers, &sealed, &usual).unwrap();
        assert!(stats.position_max_px <= 0.5 + 1e-6);
        let text = smil(&keyed, "<&>\u{0}").unwrap();
        let moving = AnimatedSvg::read(&text).unwrap();
        for f in 0..frames {
            let still = moving.at(f as f64 / 25.0).unwrap();
            crate::vector::raster(&still, [255; 4]).unwrap();
        }
    }
}

#[test]
fn regions_are_one_shape_each_and_within_the_tolerance() {
    let mut clip = fixture::turning_cube(30);
    for frame in &mut clip.frames {
        frame.light.fill(0.7);
    }
    let drawn = Drawn::of(&clip).unwrap();
    let layers = Painting::single(&clip, &drawn).unwrap().layers(&drawn);
    let regions = merge(&clip, &drawn, &layers, 4.0).unwrap();
    let sealed = seal_regions(&clip, &regions, UnderlapOptions::default());
    let options = KeyOptions::default();
    let (keyed, stats) = keyed_regions(&clip, &regions, &sealed, &options).unwrap();
    assert_eq!(keyed.shapes.len(), regions.len());
    assert!(stats.position_max_px <= 0.5 + 1e-6, "{stats:?}");
    smil(&keyed, "").unwrap();
    assert!(keyed_regions(&clip, &regions, &sealed[1..], &options).is_err());
    let merging = KeyOptions {
        shading: Shading::Flat,
        merge_levels: Some(4.0),
        ..options
    };
    let (same, ..) = reduced(&clip, &merging);
    assert_eq!(same, keyed);
}

#[test]
fn what_does_not_fit_is_refused() {
    let clip = fixture::turning_cube(4);
    let drawn = Drawn::of(&clip).unwrap();
    let sealed = unsealed(&clip);
    let options = KeyOptions::default();
    let layer = |triangle, from, to| Layer {
        triangle,
        frames: std::iter::once(from..to).collect(),
    };
    for bad in [layer(12, 0, 4), layer(0, 0, 5), layer(0, 2, 2)] {
        assert!(keyed(&clip, &drawn, &[bad], &sealed, &options).is_err());
    }
    let good = [layer(0, 0, 4)];
    assert!(keyed(&clip, &Drawn::none(3, 12), &good, &sealed, &options).is_err());
    let short = Sealed { corners: vec![] };
    assert!(keyed(&clip, &drawn, &good, &short, &options).is_err());
    let mut broken = clip.clone();
    broken.frames[0].xy[0].x = f32::INFINITY;
    assert!(keyed(&broken, &drawn, &good, &sealed, &options).is_err());
}
