//! Computes the piecewise linear track with the fewest keys that stays within a window around every
//! frame.
//!
//! Source: the tunnel of H. Imai and M. Iri ("Polygonal approximations of a curve", 1988), for
//! several numbers with common key frames; solved forward by dynamic programming with the set of
//! values that each number can still have. `docs/methods/vector.md` 7. Keys need not lie on the
//! data, so the same tolerance needs fewer of them.

use super::keyed_clip::KeyedTrack;

/// Bound of the distance from the target where the window is unbounded, grid steps.
const FAR: f64 = 1e5;
/// Fractions of a grid step reserved for rounding, tried in order; half a step is always enough.
const RESERVES: [f64; 4] = [0.0, 0.15, 0.3, 0.5];

/// Windows that a track has to pass.
pub(super) struct Windows<'a> {
    /// Target values, `width` for each frame; grid steps.
    pub targets: &'a [f64],
    /// Numbers per frame.
    pub width: usize,
    /// Half width of the windows of each frame; infinite where the values are irrelevant.
    pub reach: &'a [f64],
}

impl Windows<'_> {
    fn frames(&self) -> usize {
        self.reach.len()
    }

    fn row(&self, frame: usize) -> &[f64] {
        &self.targets[frame * self.width..(frame + 1) * self.width]
    }

    /// Minimum and maximum value of a number in a frame.
    fn window(&self, frame: usize, number: usize, reserve: f64) -> [f64; 2] {
        let reach = (self.reach[frame] - reserve).max(0.0);
        let middle = self.row(frame)[number];
        if reach.is_finite() {
            [middle - reach, middle + reach]
        } else {
            [middle - FAR, middle + FAR]
        }
    }

    /// Whether a track passes all windows.
    pub(super) fn holds(&self, track: &KeyedTrack) -> bool {
        (0..self.frames()).all(|f| {
            let values = track.at(f as f64);
            let off = |(a, b): (&f64, &f64)| (a - b).abs() <= self.reach[f] + 1e-9;
            values.iter().zip(self.row(f)).all(off)
        })
    }
}

/// Returns the track with the fewest keys that is found; half widths below half a grid step are
/// widened to that.
///
/// O(frames x longest segment x width).
pub(super) fn fewest_keys(windows: &Windows<'_>) -> KeyedTrack {
    let reach: Vec<f64> = windows.reach.iter().map(|r| r.max(0.5)).collect();
    let windows = Windows {
        reach: &reach,
        ..*windows
    };
    for reserve in RESERVES {
        if let Some(track) = still(&windows, reserve).filter(|t| windows.holds(t)) {
            return track;
        }
    }
    for reserve in RESERVES {
        let track = moving(&windows, reserve);
        if let Some(track) = track.filter(|t| windows.holds(t)) {
            return track;
        }
    }
    every_frame(&windows)
}

/// One key, if the windows of every number have a common value.
fn still(windows: &Windows<'_>, reserve: f64) -> Option<KeyedTrack> {
    let common = |number: usize| {
        let all = (0..windows.frames()).map(|f| windows.window(f, number, reserve));
        all.reduce(|[a, b], [c, d]| [a.max(c), b.min(d)])
    };
    let value = |number: usize| {
        let [low, high] = common(number)?;
        (low <= high).then(|| ((low + high) / 2.0).round() as i32)
    };
    let values: Option<Vec<i32>> = (0..windows.width).map(value).collect();
    values.map(KeyedTrack::still)
}

/// A key at every frame: always within the windows.
fn every_frame(windows: &Windows<'_>) -> KeyedTrack {
    KeyedTrack {
        frames: (0..windows.frames() as u32).collect(),
        values: windows.targets.iter().map(|v| v.round() as i32).collect(),
        width: windows.width,
    }
}

/// Best path to a frame as a key.
#[derive(Debug, Clone)]
struct Node {
    keys: usize,
    before: usize,
    /// Values that each number can have there.
    ranges: Vec<[f64; 2]>,
    /// Sum of the lengths of the ranges: of two paths with equally many keys the greater sum wins.
    freedom: f64,
}

fn moving(windows: &Windows<'_>, reserve: f64) -> Option<KeyedTrack> {
    let frames = windows.frames();
    let mut nodes: Vec<Option<Node>> = vec![None; frames];
    nodes[0] = Some(Node {
        keys: 1,
        before: 0,
        ranges: (0..windows.width)
            .map(|n| windows.window(0, n, reserve))
            .collect(),
        freedom: 0.0,
    });
    let mut segment = Segment::default();
    for from in 0..frames - 1 {
        let Some(node) = nodes[from].clone() else {
            continue;
        };
        segment.begin(&node.ranges);
        for (to, known) in nodes.iter_mut().enumerate().skip(from + 1) {
            if !segment.extend(windows, (from, to), reserve) {
                break;
            }
            if known.as_ref().is_some_and(|k| k.keys < node.keys + 1) {
                continue;
            }
            let ranges = segment.ranges((to - from) as f64);
            let freedom = ranges.iter().map(|[a, b]| (b - a).min(4.0 * FAR)).sum();
            let is_worse = |k: &Node| k.keys > node.keys + 1 || k.freedom < freedom;
            if known.as_ref().is_none_or(is_worse) {
                *known = Some(Node {
                    keys: node.keys + 1,
                    before: from,
                    ranges,
                    freedom,
                });
            }
        }
    }
    backward(windows, &nodes, reserve)
}

/// Settles the values from the last key to the first.
fn backward(windows: &Windows<'_>, nodes: &[Option<Node>], reserve: f64) -> Option<KeyedTrack> {
    let mut at = nodes.len() - 1;
    let last = nodes[at].as_ref()?;
    let settle = |[low, high]: [f64; 2], wanted: f64| {
        // In the middle of the range, unless the range is unbounded; on the grid if that is within
        // the range.
        let middle = if high - low > FAR / 2.0 {
            wanted.clamp(low, high)
        } else {
            (low + high) / 2.0
        };
        let on_grid = middle.round();
        if (low..=high).contains(&on_grid) {
            on_grid
        } else {
            middle
        }
    };
    let mut values: Vec<f64> = (0..windows.width)
        .map(|n| settle(last.ranges[n], windows.row(at)[n]))
        .collect();
    let mut keys = vec![(at, values.clone())];
    let mut segment = Segment::default();
    while at > 0 {
        let from = nodes[at].as_ref()?.before;
        segment.begin(&nodes[from].as_ref()?.ranges);
        for to in from + 1..=at {
            segment.extend(windows, (from, to), reserve);
        }
        let length = (at - from) as f64;
        values = (0..windows.width)
            .map(|n| {
                let range = segment.starts_for(n, length, values[n]);
                // Rounding may have left the set slightly.
                let range = range.unwrap_or(nodes[from].as_ref().map_or([0.0; 2], |k| k.ranges[n]));
                settle(range, windows.row(from)[n])
            })
            .collect();
        keys.push((from, values.clone()));
        at = from;
    }
    keys.reverse();
    Some(KeyedTrack {
        frames: keys.iter().map(|(f, _)| *f as u32).collect(),
        values: keys
            .iter()
            .flat_map(|(_, row)| row.iter().map(|v| v.round() as i32))
            .collect(),
        width: windows.width,
    })
}

/// For each number the convex set of start values and slopes that pass the windows so far.
#[derive(Debug, Default)]
struct Segment {
    sets: Vec<Vec<[f64; 2]>>,
    spare: Vec<[f64; 2]>,
}

impl Segment {
    fn begin(&mut self, ranges: &[[f64; 2]]) {
        self.sets.resize_with(ranges.len(), Vec::new);
        for (set, [low, high]) in self.sets.iter_mut().zip(ranges) {
            let steep = 2.0 * FAR;
            set.clear();
            set.extend([
                [*low, -steep],
                [*high, -steep],
                [*high, steep],
                [*low, steep],
            ]);
        }
    }

    /// Adds one more frame; returns false if no line of some number passes it.
    fn extend(&mut self, windows: &Windows<'_>, (from, to): (usize, usize), reserve: f64) -> bool {
        if !windows.reach[to].is_finite() {
            return true;
        }
        let length = (to - from) as f64;
        for number in 0..windows.width {
            let [low, high] = windows.window(to, number, reserve);
            self.cut(number, |[v, s]| v + s * length - low);
            self.cut(number, |[v, s]| high - v - s * length);
            if self.sets[number].is_empty() {
                return false;
            }
        }
        true
    }

    /// Keeps the part of a set where an affine function is not negative.
    fn cut(&mut self, number: usize, side: impl Fn([f64; 2]) -> f64) {
        let set = &mut self.sets[number];
        self.spare.clear();
        for (i, a) in set.iter().enumerate() {
            let b = set[(i + 1) % set.len()];
            let (p, q) = (side(*a), side(b));
            if p >= 0.0 {
                self.spare.push(*a);
            }
            if (p > 0.0 && q < 0.0) || (p < 0.0 && q > 0.0) {
                let share = p / (p - q);
                self.spare
                    .push([a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]);
            }
        }
        std::mem::swap(set, &mut self.spare);
    }

    /// Range of values of each number at the segment's end.
    fn ranges(&self, length: f64) -> Vec<[f64; 2]> {
        let of = |set: &Vec<[f64; 2]>| {
            let ends = set.iter().map(|[v, s]| v + s * length);
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], e| {
                [low.min(e), high.max(e)]
            })
        };
        self.sets.iter().map(of).collect()
    }

    /// Range of start values from which a number can reach a value at the end.
    fn starts_for(&self, number: usize, length: f64, end: f64) -> Option<[f64; 2]> {
        let set = &self.sets[number];
        let off = |[v, s]: [f64; 2]| v + s * length - end;
        let mut range: Option<[f64; 2]> = None;
        let mut take = |v: f64| {
            let [low, high] = range.unwrap_or([v, v]);
            range = Some([low.min(v), high.max(v)]);
        };
        for (i, a) in set.iter().enumerate() {
            let b = set[(i + 1) % set.len()];
            let (p, q) = (off(*a), off(b));
            if p.abs() < 1e-9 {
                take(a[0]);
            }
            if p * q < 0.0 {
                take(a[0] + (b[0] - a[0]) * p / (p - q));
            }
        }
        range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn reduced(targets: &[f64], reach: f64) -> KeyedTrack {
        fewest_keys(&Windows {
            targets,
            width: 1,
            reach: &vec![reach; targets.len()],
        })
    }

    #[test]
    fn a_straight_move_needs_two_keys_and_a_corner_three() {
        let straight: Vec<f64> = (0..20).map(|f| 3.0 * f64::from(f)).collect();
        let track = reduced(&straight, 1.0);
        assert_eq!(track.frames, [0, 19]);
        let corner: Vec<f64> = (0..21).map(|f| f64::from((f - 10i32).abs() * 8)).collect();
        let track = reduced(&corner, 1.0);
        assert_eq!(track.frames.len(), 3);
        assert!((track.frames[1] as i32 - 10).abs() <= 1);
        assert!(reduced(&[5.4; 9], 1.0).is_still());
        assert_eq!(reduced(&[5.4], 0.0).values, [5]);
    }

    #[test]
    fn keys_off_the_data_save_keys() {
        // A zigzag of 1 around a line: through the data every corner is a key.
        let zigzag: Vec<f64> = (0..40)
            .map(|f| 2.0 * f64::from(f) + if f % 2 == 0 { 1.0 } else { -1.0 })
            .collect();
        assert_eq!(reduced(&zigzag, 1.6).frames, [0, 39]);
    }

    #[test]
    fn what_does_not_matter_costs_nothing() {
        let mut targets: Vec<f64> = (0..30).map(f64::from).collect();
        targets[10..20].fill(900.0);
        let mut reach = vec![1.0; 30];
        reach[10..20].fill(f64::INFINITY);
        let windows = Windows {
            targets: &targets,
            width: 1,
            reach: &reach,
        };
        assert_eq!(fewest_keys(&windows).frames, [0, 29]);
    }

    proptest! {
        #[test]
        fn every_window_is_passed_and_no_more_keys_than_frames(
            steps in prop::collection::vec((-9.0f64..9.0, -3.0f64..3.0), 1..60),
            reach in 0.5f64..8.0,
            hidden in prop::collection::vec(0usize..60, 0..20),
        ) {
            let mut at = [0.0, 100.0];
            let targets: Vec<f64> = steps
                .iter()
                .flat_map(|(x, y)| {
                    at = [at[0] + x, at[1] + y];
                    at
                })
                .collect();
            let mut reach = vec![reach; steps.len()];
            for f in hidden {
                if f < reach.len() {
                    reach[f] = f64::INFINITY;
                }
            }
            let windows = Windows { targets: &targets, width: 2, reach: &reach };
            let track = fewest_keys(&windows);
            prop_assert!(windows.holds(&track));
            prop_assert!(track.len() <= steps.len());
            prop_assert!(track.is_still() || track.frames[track.len() - 1] as usize + 1 == steps.len());
            prop_assert!(track.frames.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }
}
