//! Hand-computed orders, and properties of any order.

use super::graph::first_order;
use super::sift::sift;
use super::*;
use crate::item_buffer::{Faces, ItemBuffer, Supersampling};
use crate::planar::clip::PlanarClip;
use crate::planar::clip::fixture;
use crate::planar::drawn::Drawn;
use crate::planar::drawn::draw_frame;
use proptest::prelude::*;

/// Covers all 40 x 40 pixels of [`fixture::loose`]; nearness at x = 0 and its increase per pixel.
fn wall(nearness: f32, slope: f32) -> ([[f32; 3]; 3], [u8; 3]) {
    let far = nearness + 80.0 * slope;
    let corners = [
        [0.0, 0.0, nearness],
        [0.0, 80.0, nearness],
        [80.0, 0.0, far],
    ];
    (corners, [100; 3])
}

/// Two walls that swap their order after `swap` of `frames` frames; the second begins five columns
/// from the left.
fn swapping(swap: usize, frames: usize) -> PlanarClip {
    let mut clip = fixture::loose(&[wall(0.2, 0.0), wall(0.3, 0.0)], frames);
    for v in 3..6 {
        for frame in &mut clip.frames {
            frame.xy[v].x += 5.0;
        }
    }
    for frame in &mut clip.frames[swap..] {
        frame.nearness[..3].fill(0.9);
    }
    clip
}

fn all_drawn(clip: &PlanarClip) -> Drawn {
    let mut drawn = Drawn::none(clip.frames.len(), clip.triangles.len());
    for f in 0..drawn.frames() {
        (0..drawn.triangles()).for_each(|t| drawn.set(f, t, true));
    }
    drawn
}

#[test]
fn of_two_that_cross_the_one_that_shows_more_is_painted_last() {
    // Equal where 0.2 + x / 80 = 0.5, at x = 24: the first owns 24 columns, the second 16.
    let clip = fixture::loose(&[wall(0.5, 0.0), wall(0.2, 1.0 / 80.0)], 1);
    let drawn = Drawn::of(&clip).unwrap();
    let painting = Painting::single(&clip, &drawn).unwrap();
    assert_eq!(painting.order_at(0), [1, 0]);
    let wrong = wrong_pixels(&clip, &drawn, &painting).unwrap();
    assert_eq!(wrong.per_frame, [(16 * 40 * 4, 40 * 40 * 4)]);
    assert_eq!(wrong.percent_mean(), 40.0);
}

#[test]
fn in_a_cycle_the_lightest_edge_loses() {
    // 1 over 0 in 30 samples, 2 over 1 in 20, 0 over 2 in 10.
    let overlaps = Overlaps::by_hand(&[&[(&[1, 0], 30), (&[2, 1], 20), (&[0, 2], 10)]]);
    let weights = overlaps.sum(&(0..1));
    for far_first in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let mut order = first_order(&overlaps, &weights, &far_first);
        assert_eq!(order, [0, 1, 2]);
        assert_eq!(overlaps.wrong_within(&(0..1), &order), 10);
        sift(&overlaps, &weights, &mut order);
        assert_eq!(order, [0, 1, 2]);
    }
}

#[test]
fn what_lies_behind_a_cycle_stays_behind_it() {
    // A chain 4 under the cycle, 3 above it and 5 between 3 and the cycle.
    let sets: &[(&[u32], u32)] = &[
        (&[1, 0], 30),
        (&[2, 1], 20),
        (&[0, 2], 10),
        (&[0, 4], 1),
        (&[5, 2], 1),
        (&[3, 5], 1),
    ];
    let overlaps = Overlaps::by_hand(&[sets]);
    let order = first_order(&overlaps, &overlaps.sum(&(0..1)), &[3, 5, 0, 1, 2, 4]);
    assert_eq!(order, [4, 0, 1, 2, 5, 3]);
}

#[test]
fn depth_sorts_by_hand() {
    let clip = swapping(2, 4);
    let drawn = all_drawn(&clip);
    let first = Painting::one_depth_sort(&clip, &drawn, 0).unwrap();
    assert_eq!(first.order_at(3), [0, 1]);
    let last = Painting::one_depth_sort(&clip, &drawn, 3).unwrap();
    assert_eq!(last.order_at(0), [1, 0]);
    assert!(Painting::one_depth_sort(&clip, &drawn, 4).is_err());
    let each = Painting::depth_sort_per_frame(&clip, &drawn).unwrap();
    let wrong = |painting: &Painting| wrong_pixels(&clip, &drawn, painting).unwrap();
    assert_eq!(wrong(&each).percent_mean(), 0.0);
    let both = 35 * 40 * 4;
    let expected = [(0, 6400), (0, 6400), (both, 6400), (both, 6400)];
    assert_eq!(wrong(&first).per_frame, expected);
    let foreign = Drawn::none(4, 3);
    assert!(Painting::depth_sort_per_frame(&clip, &foreign).is_err());
    assert!(Overlaps::of(&clip, &foreign).is_err());
}

#[test]
fn two_that_change_places_need_two_epochs_and_one_copy() {
    let clip = swapping(7, 20);
    // The second is drawn also where it is hidden.
    let drawn = all_drawn(&clip);
    let painting = Painting::constraints(&clip, &drawn, &OrderOptions::default()).unwrap();
    let expected = [(0..7, vec![0, 1]), (7..20, vec![1, 0])];
    let found = painting
        .epochs
        .iter()
        .map(|e| (e.frames.clone(), e.order.clone()));
    assert_eq!(found.collect::<Vec<_>>(), expected);
    let wrong = wrong_pixels(&clip, &drawn, &painting).unwrap();
    assert_eq!(wrong.percent_mean(), 0.0);
    assert_eq!(painting.layers(&drawn).len(), 3);
    assert_eq!(painting.mean_copies(&drawn), 1.5);
    let options = OrderOptions {
        max_epochs: 1,
        ..OrderOptions::default()
    };
    let one = Painting::constraints(&clip, &drawn, &options).unwrap();
    assert_eq!(one, Painting::single(&clip, &drawn).unwrap());
    // Thirteen frames agree with the later order.
    assert_eq!(one.order_at(0), [1, 0]);
    let all = OrderOptions {
        order_tol: 1.0,
        ..OrderOptions::default()
    };
    assert_eq!(Painting::constraints(&clip, &drawn, &all).unwrap(), one);
}

#[test]
fn a_short_gap_is_left_empty_where_its_triangle_would_cover_others() {
    let mut clip = swapping(4, 10);
    for frame in &mut clip.frames[7..] {
        frame.nearness[..3].fill(0.2);
    }
    let painted = Painted::of(&clip, &OrderOptions::default()).unwrap();
    assert_eq!(painted.painting.epochs.len(), 1);
    assert_eq!(painted.painting.order_at(5), [0, 1]);
    assert_eq!(painted.drawn.spans(1), [0..4, 7..10]);
    assert_eq!(painted.wrong().share(), 0.0);
    // With the gap drawn, the same order shows it wrong.
    let filled = Drawn::of(&clip).unwrap();
    let wrong = wrong_pixels(&clip, &filled, &painted.painting).unwrap();
    assert_eq!(wrong.per_frame[5], (35 * 40 * 4, 6400));
    assert!((wrong.share() - 3.0 * 35.0 / 400.0).abs() < 1e-9);
    // A farther one that is hidden for as long does no harm below the others.
    let farthest = [[1.0, 9.0, 0.1], [1.0, 20.0, 0.1], [4.0, 20.0, 0.1]];
    let mut calm = fixture::loose(&[(farthest, [1; 3]), wall(0.2, 0.0)], 10);
    for f in [0, 1, 2, 8, 9] {
        (3..6).for_each(|v| calm.frames[f].xy[v].x += 5.0);
    }
    let painted = Painted::of(&calm, &OrderOptions::default()).unwrap();
    assert_eq!(Drawn::seen(&calm).unwrap().spans(0), [0..3, 8..10]);
    assert_eq!(painted.drawn.spans(0), vec![0..10]);
    assert_eq!(painted.wrong().share(), 0.0);
}

#[test]
fn a_turning_cube_is_painted_right() {
    let cube = fixture::turning_cube(24);
    let drawn = Drawn::seen(&cube).unwrap();
    let painting = Painting::constraints(&cube, &drawn, &OrderOptions::default()).unwrap();
    assert_eq!(painting.epochs.len(), 1);
    let wrong = wrong_pixels(&cube, &drawn, &painting).unwrap();
    assert_eq!(wrong.percent_mean(), 0.0);
}

#[test]
fn what_is_seen_but_not_painted_is_wrong_and_so_is_paint_on_nothing() {
    let corners = [[0.0, 0.0, 0.5], [0.0, 4.0, 0.5], [4.0, 0.0, 0.5]];
    let mut back = corners.map(|[x, y, n]| [x + 10.0, y, n]);
    back.swap(1, 2);
    let clip = fixture::loose(&[(corners, [1; 3]), (back, [2; 3])], 1);
    let mut drawn = Drawn::none(1, 2);
    drawn.set(0, 1, true);
    let painting = Painting::single(&clip, &drawn).unwrap();
    // Eight samples a side; those on the long edge belong to its other side: 28 and 36.
    let (object, stray) = (28, 36);
    let wrong = wrong_pixels(&clip, &drawn, &painting).unwrap();
    assert_eq!(wrong.per_frame[0].1, object);
    let total = wrong.per_frame[0].0;
    assert!(
        total == object + stray || total == object + object,
        "{total}"
    );
}

fn any_triangles() -> impl Strategy<Value = Vec<[[f32; 3]; 3]>> {
    let corner = || (0.0f32..40.0, 0.0f32..40.0, 0.1f32..0.9).prop_map(|(x, y, n)| [x, y, n]);
    let corners = || prop::array::uniform3(corner());
    prop::collection::vec(corners(), 1..9)
}

fn loose(triangles: &[[[f32; 3]; 3]], frames: usize) -> PlanarClip {
    let colored: Vec<_> = triangles.iter().map(|t| (*t, [9; 3])).collect();
    fixture::loose(&colored, frames)
}

/// Paints a frame and counts the samples that differ from the item buffer.
fn painted_wrong(clip: &PlanarClip, drawn: &Drawn, painting: &Painting, f: usize) -> u32 {
    let mut buffer = ItemBuffer::new(clip.width, clip.height, Supersampling::Two).unwrap();
    draw_frame(clip, f, &mut buffer);
    let (w, h) = buffer.sample_size();
    let mut painted = vec![None; (w * h) as usize];
    for t in painting.order_at(f) {
        if drawn.get(f, *t as usize) {
            buffer.visit(clip.corners(f, *t as usize), Faces::Both, |x, y| {
                painted[(y * w + x) as usize] = Some(*t);
            });
        }
    }
    let all = (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let wrong = all.filter(|(x, y)| painted[(y * w + x) as usize] != buffer.item(*x, *y));
    wrong.count() as u32
}

/// An order of `count` triangles, sorted by the given keys.
fn shuffled(count: usize, keys: &[u32]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_by_key(|t| keys[*t as usize]);
    order
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The number of wrong samples equals what painting shows.
    #[test]
    fn counts_agree_with_painting(
        triangles in any_triangles(),
        keys in prop::collection::vec(any::<u32>(), 9),
        off in prop::collection::vec(any::<bool>(), 18),
    ) {
        let count = triangles.len();
        let mut clip = loose(&triangles, 2);
        for xy in &mut clip.frames[1].xy {
            xy.x = 40.0 - xy.x;
        }
        let mut drawn = Drawn::none(2, count);
        for f in 0..2 {
            for t in 0..count {
                drawn.set(f, t, !off[f * 9 + t]);
            }
        }
        let painting = Painting {
            epochs: vec![Epoch { frames: 0..2, order: shuffled(count, &keys) }],
        };
        let wrong = wrong_pixels(&clip, &drawn, &painting).unwrap();
        for f in 0..2 {
            prop_assert_eq!(wrong.per_frame[f].0, painted_wrong(&clip, &drawn, &painting, f));
        }
    }

    /// Without a cycle nothing is wrong, for any motion of the triangles.
    #[test]
    fn flat_layers_are_painted_right(triangles in any_triangles(), shift in -9.0f32..9.0) {
        let mut flat = triangles;
        for (t, corners) in flat.iter_mut().enumerate() {
            corners.iter_mut().for_each(|c| c[2] = 0.1 + 0.1 * t as f32);
        }
        let mut clip = loose(&flat, 3);
        for (f, frame) in clip.frames.iter_mut().enumerate() {
            for (v, xy) in frame.xy.iter_mut().enumerate() {
                xy.x += shift * f as f32 * (v / 3 % 3) as f32;
            }
        }
        if let Ok(drawn) = Drawn::seen(&clip) {
            let painting = Painting::single(&clip, &drawn).unwrap();
            let wrong = wrong_pixels(&clip, &drawn, &painting).unwrap();
            prop_assert_eq!(wrong.percent_mean(), 0.0);
            // The same as the order of nearness wherever they touch: a depth sort.
            let sorted = Painting::one_depth_sort(&clip, &drawn, 0).unwrap();
            prop_assert_eq!(wrong_pixels(&clip, &drawn, &sorted).unwrap().percent_mean(), 0.0);
        }
    }

    /// Sifting never makes an order worse, ends in a local optimum, and keeps all triangles.
    #[test]
    fn sifting_ends_in_a_local_optimum(
        triangles in any_triangles(),
        keys in prop::collection::vec(any::<u32>(), 9),
    ) {
        let clip = loose(&triangles, 1);
        let drawn = all_drawn(&clip);
        let overlaps = Overlaps::of(&clip, &drawn).unwrap();
        let before = shuffled(triangles.len(), &keys);
        let mut order = before.clone();
        sift(&overlaps, &overlaps.sum(&(0..1)), &mut order);
        let wrong = |order: &[u32]| overlaps.wrong_within(&(0..1), order);
        let found = wrong(&order);
        prop_assert!(found <= wrong(&before));
        for from in 0..order.len() {
            for to in 0..order.len() {
                let mut other = order.clone();
                let t = other.remove(from);
                other.insert(to, t);
                prop_assert!(found <= wrong(&other), "{} from {} to {}", t, from, to);
            }
        }
        order.sort_unstable();
        prop_assert_eq!(order, shuffled(triangles.len(), &[0; 9]));
    }

    /// In every frame the layers show the epoch's order, and a triangle is never shown twice.
    #[test]
    fn layers_show_every_epochs_order(
        keys in prop::collection::vec(prop::collection::vec(any::<u8>(), 9), 1..6),
        off in prop::collection::vec(prop::bool::weighted(0.3), 9 * 18),
        lengths in prop::collection::vec(1usize..4, 6),
    ) {
        let mut painting = Painting { epochs: vec![] };
        let mut drawn = Drawn::none(lengths[..keys.len()].iter().sum(), 9);
        let mut from = 0;
        for (keys, length) in keys.iter().zip(&lengths) {
            let frames = from..from + length;
            from += length;
            for f in frames.clone() {
                (0..9).for_each(|t| drawn.set(f, t, !off[f * 9 + t]));
            }
            let mut order: Vec<u32> = drawn.within(&frames);
            order.sort_by_key(|t| keys[*t as usize]);
            painting.epochs.push(Epoch { frames, order });
        }
        let layers = painting.layers(&drawn);
        for f in 0..drawn.frames() {
            let is_on = |l: &&Layer| l.frames.iter().any(|s| s.contains(&f));
            let shown: Vec<u32> = layers.iter().filter(is_on).map(|l| l.triangle).collect();
            let order = painting.order_at(f).iter().copied();
            let expected: Vec<u32> = order.filter(|t| drawn.get(f, *t as usize)).collect();
            prop_assert_eq!(shown, expected);
        }
        let spans_are_apart = |l: &Layer| l.frames.windows(2).all(|p| p[0].end < p[1].start);
        prop_assert!(layers.iter().all(spans_are_apart));
        prop_assert!(layers.iter().all(|l| !l.frames.is_empty()));
    }
}
