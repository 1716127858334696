//! The interpolating wavelet over the frames of an access unit, in whole numbers.
//!
//! Form: `docs/formats/abp2.md`, part 5. Source: the lifting scheme of W. Sweldens, 1996, with the
//! four-tap interpolation of G. Deslauriers and S. Dubuc, 1989.

use super::contexts::Class;

/// Most frames of an access unit.
pub(super) const MOST_FRAMES: usize = 512;

/// Where a value lies in the coded order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    /// Frame.
    pub(super) frame: u32,
    /// Scaling band or a detail band.
    pub(super) class: Class,
    /// Number of its band: binary logarithm of the stride of its frames.
    pub(super) band: u8,
    /// Places in the coded order of the one and the two before in its band, and of its parent in the
    /// next coarser detail band; [`Self::NONE`] if there is none.
    pub(super) before: u32,
    pub(super) second: u32,
    pub(super) parent: u32,
}

impl Place {
    pub(super) const NONE: u32 = u32::MAX;
}

/// Returns the stride of the scaling band of `frames` frames.
pub(super) fn coarsest(frames: usize) -> usize {
    let mut stride = 1;
    while 2 * stride < frames {
        stride *= 2;
    }
    stride
}

/// Returns the coded order of `frames` frames: the scaling band, then detail bands from coarse to
/// fine.
pub(super) fn order(frames: usize) -> Vec<Place> {
    let h = coarsest(frames);
    let mut places = Vec::with_capacity(frames);
    let mut at = vec![Place::NONE; frames];
    let mut band = |positions: &mut dyn Iterator<Item = usize>, stride: usize, class: Class| {
        let (mut before, mut second) = (Place::NONE, Place::NONE);
        for frame in positions {
            let odd = |f: usize| {
                class == 1 && 2 * stride < h && f < frames && !f.is_multiple_of(4 * stride)
            };
            let (left, right) = (frame.wrapping_sub(stride), frame + stride);
            let parent = match [left, right] {
                [left, _] if odd(left) => at[left],
                [_, right] if odd(right) => at[right],
                _ => Place::NONE,
            };
            let place = places.len() as u32;
            at[frame] = place;
            places.push(Place {
                frame: frame as u32,
                class,
                band: stride.ilog2() as u8,
                before,
                second,
                parent,
            });
            (second, before) = (before, place);
        }
    };
    band(&mut (0..frames).step_by(h), h, 0);
    let mut stride = h / 2;
    while stride > 0 {
        band(&mut (stride..frames).step_by(2 * stride), stride, 1);
        stride /= 2;
    }
    places
}

/// Samples of a power of 2 apart, mirrored at the ends.
#[derive(Clone, Copy)]
struct Grid {
    stride: usize,
    /// Index of the last sample.
    last: usize,
}

impl Grid {
    fn new(frames: usize, stride: usize) -> Self {
        Self {
            stride,
            last: (frames - 1) >> stride.trailing_zeros(),
        }
    }

    /// Frame of sample `i`.
    #[inline]
    fn frame(self, i: usize) -> usize {
        i * self.stride
    }

    /// Value of the samples `apart` before and after `i`, at most three; sum of both.
    #[inline]
    fn beside(self, x: &[i64], i: usize, apart: usize) -> i64 {
        let mirrored = |i: i64| {
            let period = (2 * self.last as i64).max(1);
            let i = i.rem_euclid(period);
            x[self.frame(i.min(period - i) as usize)]
        };
        let before = match i.checked_sub(apart) {
            Some(before) => x[self.frame(before)],
            None => mirrored(i as i64 - apart as i64),
        };
        let after = if i + apart <= self.last {
            x[self.frame(i + apart)]
        } else {
            mirrored((i + apart) as i64)
        };
        before + after
    }

    /// What the neighbours of an odd sample predict for it.
    #[inline]
    fn prediction(self, x: &[i64], i: usize) -> i64 {
        (9 * self.beside(x, i, 1) - self.beside(x, i, 3) + 8) >> 4
    }

    /// What the details beside an even sample add to it.
    #[inline]
    fn update(self, x: &[i64], i: usize) -> i64 {
        (self.beside(x, i, 1) + 2) >> 2
    }

    /// The odd samples, which have details.
    fn odd(self) -> impl Iterator<Item = usize> {
        (1..=self.last).step_by(2)
    }

    /// The even samples.
    fn even(self) -> impl Iterator<Item = usize> {
        (0..=self.last).step_by(2)
    }
}

/// Replaces frames by coefficients, each at the place of its frame.
pub(super) fn forward(x: &mut [i64], updates: bool) {
    let h = coarsest(x.len());
    let mut stride = 1;
    while stride < h {
        let grid = Grid::new(x.len(), stride);
        for i in grid.odd() {
            x[grid.frame(i)] -= grid.prediction(x, i);
        }
        for i in grid.even().filter(|_| updates) {
            x[grid.frame(i)] += grid.update(x, i);
        }
        stride *= 2;
    }
}

/// Replaces coefficients by frames.
pub(super) fn inverse(x: &mut [i64], updates: bool) {
    let mut stride = coarsest(x.len()) / 2;
    while stride > 0 {
        let grid = Grid::new(x.len(), stride);
        for i in grid.even().filter(|_| updates) {
            x[grid.frame(i)] -= grid.update(x, i);
        }
        for i in grid.odd() {
            x[grid.frame(i)] += grid.prediction(x, i);
        }
        stride /= 2;
    }
}

/// Closed loop without updates: calls `code` for each frame from coarse to fine with the frame's
/// true value less what decoded neighbours predict; it returns the decoded difference. `x` holds
/// true values before, decoded ones after.
pub(super) fn closed_loop(x: &mut [i64], mut code: impl FnMut(usize, i64) -> i64) {
    let h = coarsest(x.len());
    for frame in (0..x.len()).step_by(h) {
        x[frame] = code(frame, x[frame]);
    }
    let mut stride = h / 2;
    while stride > 0 {
        let grid = Grid::new(x.len(), stride);
        for i in grid.odd() {
            let predicted = grid.prediction(x, i);
            let frame = grid.frame(i);
            x[frame] = predicted + code(frame, x[frame] - predicted);
        }
        stride /= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn five_frames_by_hand() {
        let mut x = [0, 41943, 83886, 104_858, 83886];
        forward(&mut x, true);
        assert_eq!(x, [23593, 5243, 41942, 15729, 112_722]);
        inverse(&mut x, true);
        assert_eq!(x, [0, 41943, 83886, 104_858, 83886]);
        let frames: Vec<u32> = order(5).iter().map(|place| place.frame).collect();
        assert_eq!(frames, [0, 4, 2, 1, 3]);
    }

    #[test]
    fn places_know_their_neighbours() {
        let places = order(12);
        // h = 8: 0 8 | 4 | 2 6 10 | 1 3 5 7 9 11
        let of = |frame: u32| places.iter().find(|p| p.frame == frame).unwrap();
        let frame = |place: u32| places.get(place as usize).map(|p| p.frame);
        assert_eq!((of(8).class, frame(of(8).before)), (0, Some(0)));
        assert_eq!(of(4).parent, Place::NONE);
        // 2 lies beside 0 and 4, 10 beside 8 and 12: 12 is outside.
        assert_eq!(frame(of(2).parent), Some(4));
        assert_eq!(frame(of(6).parent), Some(4));
        assert_eq!(of(10).parent, Place::NONE);
        assert_eq!(frame(of(11).parent), Some(10));
        assert_eq!(
            (frame(of(5).before), frame(of(5).second)),
            (Some(3), Some(1))
        );
        assert_eq!((of(5).band, of(6).band, of(8).band), (0, 1, 3));
    }

    proptest! {
        #[test]
        fn frames_come_back(
            x in prop::collection::vec(-(1i64 << 30)..1 << 30, 2..130),
            updates: bool,
        ) {
            let mut y = x.clone();
            forward(&mut y, updates);
            inverse(&mut y, updates);
            prop_assert_eq!(&x, &y);
            let mut places: Vec<u32> = order(x.len()).iter().map(|place| place.frame).collect();
            places.sort_unstable();
            prop_assert_eq!(places, (0..x.len() as u32).collect::<Vec<_>>());
        }

        #[test]
        fn a_closed_loop_errs_by_its_rounding_alone(
            x in prop::collection::vec(-100_000i64..100_000, 2..70),
            step in 1i64..500,
        ) {
            let mut decoded = x.clone();
            let mut coded = vec![0; x.len()];
            closed_loop(&mut decoded, |frame, difference| {
                coded[frame] = (difference as f64 / step as f64).round() as i64 * step;
                coded[frame]
            });
            prop_assert!(x.iter().zip(&decoded).all(|(a, b)| (a - b).abs() <= step / 2 + 1));
            inverse(&mut coded, false);
            prop_assert_eq!(coded, decoded);
        }
    }
}
