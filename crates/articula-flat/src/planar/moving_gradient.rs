//! Gradient lines with few keys, with the error measured in levels at the corners.
//!
//! Source: `docs/methods/vector.md` 7. A constant line is tried first (least squares, reweighted
//! towards the worst frames). A moving line begins with a key at both ends; the values of its keys
//! are fitted to all frames at once (Gauss-Newton with Levenberg damping), keys are added where the
//! error between two is worst until none is above the tolerance, and keys that are not needed are
//! removed. Keys need not lie on the data, and the fit may slide a line along its bands of equal
//! colour, which changes only its numbers.

use super::keyed_clip::KeyedTrack;

/// Rounds of fitting after each change of keys.
const ROUNDS: usize = 4;
/// Damping of a fit, relative to the weight of one corner.
const DAMPING: f64 = 1e-3;
/// Maximum absolute coordinate of a line, in its own steps.
const FARTHEST: f64 = 200_000.0;

/// Corners of a frame with the target fraction along the ramp at each.
pub(super) type Corners = [([f64; 2], f64); 3];

/// Targets of a gradient line.
pub(super) struct Wanted<'a> {
    /// Corners of each frame, in steps of the line's units, and the tolerance of the fraction;
    /// `None` where the frame is irrelevant.
    pub frames: Vec<Option<(Corners, f64)>>,
    /// Fraction that corresponds to one level.
    pub level: f64,
    /// Steps to which numbers may be rounded, coarse ones first; the last is 1.
    pub steps: &'a [i32],
}

/// A frame, or half-way to the next, with its corners and the tolerance of the fraction.
type Moment = (f64, Corners, f64);

/// Numbers of a line: x1, y1, x2, y2.
type Line = [f64; 4];

/// Returns a track of the line with few keys. Where the tolerance would need too many, as on
/// slivers whose light turns over, it is widened in steps. `None` if `most` times it is not enough, unless
/// that is more than the last step.
pub(super) fn few_keys(wanted: &Wanted<'_>, most: f64) -> Option<KeyedTrack> {
    let constant = wanted.constant();
    for slack in SLACKS {
        // Coarse numbers have a shorter text.
        for step in wanted.steps {
            let still = KeyedTrack::still(constant.map(|v| rounded(v, *step)).to_vec());
            if wanted.holds(&still, slack) {
                return Some(still);
            }
        }
        if let Some(track) = wanted.cheapest(constant, slack) {
            return Some(track);
        }
        if most <= slack {
            return None;
        }
    }
    // None may be within the tolerance. The frames' own lines may turn over between two frames, which is worse than a
    // line that is never right; what is fitted to these moments too is between both.
    let still = KeyedTrack::still(constant.map(|v| rounded(v, 1)).to_vec());
    let mut every = wanted.every_frame(constant);
    let own = every.track(1);
    let moments: Vec<Moment> = wanted.moments().collect();
    for _ in 0..FITS_OF_ALL {
        wanted.fit(&mut every, [true; 4], &moments);
    }
    let better = |a, b| {
        if wanted.harm(&b) < wanted.harm(&a) {
            b
        } else {
            a
        }
    };
    Some(better(better(still, own), every.track(1)))
}

/// Number of fits of a line that has a key at every frame.
const FITS_OF_ALL: usize = 4;

/// Factors of the tolerance, tried in order.
pub(super) const SLACKS: [f64; 4] = [1.0, 1.6, 2.5, 4.0];

/// The nearest multiple of a step.
fn rounded(value: f64, step: i32) -> i32 {
    let step = f64::from(step);
    ((value / step).round() * step) as i32
}

/// Cost of an animation element without its keys, in keys.
const KEYS_AN_ANIMATION: usize = 8;

impl Wanted<'_> {
    /// Error of a track at the corners of a frame, in fractions; `None` if the frame is irrelevant.
    pub(super) fn off(&self, frame: usize, track: &KeyedTrack) -> Option<[f64; 3]> {
        let (corners, _) = self.frames[frame].as_ref()?;
        let line = line_of(&track.at(frame as f64));
        Some(corners.map(|corner| off(&line, &corner)))
    }

    /// The moving track with the least cost, unless it has too many keys.
    fn cheapest(&self, constant: Line, slack: f64) -> Option<KeyedTrack> {
        // Two numbers are enough for light that grows or fades uniformly, at half the cost.
        let mut best: Option<(usize, KeyedTrack)> = None;
        let most = self.active().count() / 4 + 3;
        for free in [
            [true, false, true, false],
            [false, true, false, true],
            [true; 4],
        ] {
            let count = free.iter().filter(|f| **f).count();
            let cheaper =
                |(cost, _): &(usize, KeyedTrack)| (cost / count).saturating_sub(KEYS_AN_ANIMATION);
            let enough = best.as_ref().map_or(most, cheaper).min(most);
            if let Some(track) = self.moving(constant, free, (enough, slack)) {
                let cost = (track.len() + KEYS_AN_ANIMATION) * count;
                if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                    best = Some((cost, track));
                }
            }
        }
        best.map(|(_, track)| track)
    }

    fn active(&self) -> impl Iterator<Item = (usize, &Corners, f64)> {
        self.frames
            .iter()
            .enumerate()
            .filter_map(|(f, frame)| frame.as_ref().map(|(c, tol)| (f, c, *tol)))
    }

    /// Times that are checked: frames, and halfway between them, where a line that turns over would
    /// paint arbitrary colours.
    fn moments(&self) -> impl Iterator<Item = Moment> {
        let frame = |f: usize| self.frames.get(f).copied().flatten();
        let halfway = move |f: usize| {
            let ((a, tol), (b, next)) = (frame(f)?, frame(f + 1)?);
            let mean = |i: usize| {
                let place = |n: usize| (a[i].0[n] + b[i].0[n]) / 2.0;
                ([place(0), place(1)], (a[i].1 + b[i].1) / 2.0)
            };
            Some((f as f64 + 0.5, std::array::from_fn(mean), tol.max(next)))
        };
        (0..self.frames.len()).flat_map(move |f| {
            let now = frame(f).map(|(corners, tol)| (f as f64, corners, tol));
            [now, halfway(f)].into_iter().flatten()
        })
    }

    /// Sum of the fourth powers of all errors: one large error counts more than many small ones.
    fn harm(&self, track: &KeyedTrack) -> f64 {
        let over = self.moments().map(|(at, corners, tol)| {
            let line = line_of(&track.at(at));
            (error(&line, &corners) / tol).powi(4)
        });
        over.sum()
    }

    /// Greatest error, relative to the tolerance.
    fn excess(&self, track: &KeyedTrack) -> f64 {
        let over = self.moments().map(|(at, corners, tol)| {
            let line = line_of(&track.at(at));
            error(&line, &corners) / tol
        });
        over.fold(0.0, f64::max)
    }

    /// Whether all times are within the tolerance.
    fn holds(&self, track: &KeyedTrack, slack: f64) -> bool {
        self.excess(track) <= slack + 1e-9
    }

    /// Worst frame of each interval between keys that exceeds the tolerance.
    fn worst_of_runs(&self, track: &KeyedTrack, slack: f64) -> Vec<usize> {
        let mut worst: Vec<(usize, usize, f64)> = Vec::new();
        for (at, corners, tol) in self.moments() {
            let run = track.frames.partition_point(|k| f64::from(*k) <= at);
            let line = line_of(&track.at(at));
            let f = at as usize;
            let over = error(&line, &corners) / (tol * slack);
            if over <= 1.0 + 1e-9 {
                continue;
            }
            match worst.last_mut() {
                Some(last) if last.0 == run && last.2 >= over => {}
                Some(last) if last.0 == run => *last = (run, f, over),
                _ => worst.push((run, f, over)),
            }
        }
        worst.into_iter().map(|(_, f, _)| f).collect()
    }

    /// One line fitted to all frames.
    fn constant(&self) -> Line {
        let mut weights = vec![1.0; self.frames.len()];
        let places = self.active().flat_map(|(_, corners, _)| corners);
        let region = Region::of(places.map(|(place, _)| *place));
        let mut affine = [0.0; 3];
        for _ in 0..ROUNDS {
            let mut system = Banded::new(3, 3);
            for (f, corners, tol) in self.active() {
                region.add(&mut system, corners, weights[f] / (tol * tol));
            }
            affine = solve_affine(system);
            for (f, corners, tol) in self.active() {
                let off = |(place, share): &([f64; 2], f64)| {
                    let row = region.row(*place);
                    (affine.iter().zip(row).map(|(a, b)| a * b).sum::<f64>() - share).abs()
                };
                let worst = corners.iter().map(off).fold(0.0, f64::max) / tol;
                weights[f] *= worst.clamp(0.05, 20.0);
            }
        }
        region.line(affine, self.level)
    }

    /// Line fitted to one frame; `None` if the frame is irrelevant.
    fn own(&self, frame: usize) -> Option<Line> {
        let (corners, _) = self.frames[frame].as_ref()?;
        let region = Region::of(corners.iter().map(|c| c.0));
        let mut system = Banded::new(3, 3);
        region.add(&mut system, corners, 1.0);
        Some(region.line(solve_affine(system), self.level))
    }

    /// A key at every frame, each with the frame's own line.
    fn every_frame(&self, start: Line) -> Keys {
        let mut last = start;
        let own = |f| {
            last = self.own(f).unwrap_or(last);
            last
        };
        Keys {
            frames: (0..self.frames.len()).collect(),
            lines: (0..self.frames.len()).map(own).collect(),
        }
    }

    /// A moving line of which only some numbers move, with at most `enough` keys.
    fn moving(
        &self,
        start: Line,
        free: [bool; 4],
        (enough, slack): (usize, f64),
    ) -> Option<KeyedTrack> {
        let last = self.frames.len().checked_sub(1).filter(|l| *l > 0)?;
        let is_whole = free == [true; 4];
        let frames = self.active();
        let frames: Vec<Moment> = frames.map(|(f, c, tol)| (f as f64, *c, tol)).collect();
        let mut active = self.active().map(|(f, ..)| f);
        let ends = [active.next()?, active.last().unwrap_or(last)];
        let own = |f: usize| self.own(f).filter(|_| is_whole);
        let mut keys = Keys {
            frames: vec![0, last],
            lines: ends.map(|f| own(f).unwrap_or(start)).to_vec(),
        };
        loop {
            self.fit(&mut keys, free, &frames);
            let worst = self.worst_of_runs(&keys.track(1), slack);
            if worst.is_empty() {
                break;
            }
            if keys.frames.len() >= enough.min(last) {
                return None;
            }
            for frame in worst {
                keys.insert_near(frame, own);
            }
        }
        // Inner keys, first to last; removes those that are not needed.
        let mut k = 1;
        while k + 1 < keys.frames.len() {
            let mut fewer = keys.clone();
            fewer.frames.remove(k);
            fewer.lines.remove(k);
            self.fit(&mut fewer, free, &frames);
            if self.holds(&fewer.track(1), slack) {
                keys = fewer;
            } else {
                k += 1;
            }
        }
        let coarse = self.steps.iter().map(|step| keys.track(*step));
        let fine = |track: &KeyedTrack| self.holds(track, slack);
        coarse.into_iter().find(fine)
    }

    /// Fits the lines of all keys to some moments.
    fn fit(&self, keys: &mut Keys, free: [bool; 4], moments: &[Moment]) {
        let numbers: Vec<usize> = (0..4).filter(|i| free[*i]).collect();
        let n = numbers.len();
        let size = n * keys.frames.len();
        let mut weights = vec![1.0; moments.len()];
        for _ in 0..ROUNDS {
            let mut system = Banded::new(size, 2 * n);
            for ((at, corners, tol), weight_of) in moments.iter().zip(&mut weights) {
                let (k, share) = keys.place(*at);
                let line = keys.at(*at);
                let weight = *weight_of / (tol * tol) * self.level * self.level;
                let mut worst: f64 = 0.0;
                for (place, wanted) in corners {
                    let (shown, slopes) = share_and_slopes(&line, *place);
                    let off = wanted - shown;
                    worst = worst.max(off.abs() / tol);
                    let mut row = [0.0; 8];
                    for (i, number) in numbers.iter().enumerate() {
                        row[i] = slopes[*number] * (1.0 - share);
                        row[n + i] = slopes[*number] * share;
                    }
                    let used = if k + 1 < keys.frames.len() { 2 * n } else { n };
                    system.add(k * n, &row[..used], off, weight);
                }
                *weight_of = (*weight_of * worst.clamp(0.2, 5.0)).clamp(1e-3, 1e3);
            }
            let step = system.solve(DAMPING);
            let before = cost(keys, moments, &weights);
            let moved = STRIDES.iter().map(|stride| {
                let mut moved = keys.clone();
                for (i, change) in step.iter().enumerate() {
                    let number = &mut moved.lines[i / n][numbers[i % n]];
                    *number = (*number + stride * change).clamp(-FARTHEST, FARTHEST);
                }
                moved
            });
            let better = moved
                .into_iter()
                .find(|m| cost(m, moments, &weights) < before);
            let Some(better) = better else {
                return;
            };
            *keys = better;
        }
    }
}

/// Cost that a fit minimises.
fn cost(keys: &Keys, moments: &[Moment], weights: &[f64]) -> f64 {
    let of = |((at, corners, tol), weight): (&Moment, &f64)| {
        let line = keys.at(*at);
        let off = |(place, wanted): &([f64; 2], f64)| {
            let (share, _) = share_and_slopes(&line, *place);
            (share - wanted) * (share - wanted)
        };
        weight / (tol * tol) * corners.iter().map(off).sum::<f64>()
    };
    moments.iter().zip(weights).map(of).sum()
}

/// Step lengths that are tried, since the problem is only locally linear.
const STRIDES: [f64; 3] = [1.0, 0.4, 0.1];

/// Keys that are being fitted.
#[derive(Debug, Clone)]
struct Keys {
    frames: Vec<usize>,
    lines: Vec<Line>,
}

impl Keys {
    /// Index of the key before a time in frames, and the fraction from it to the next.
    fn place(&self, at: f64) -> (usize, f64) {
        let after = self.frames.partition_point(|f| *f as f64 <= at);
        let k = after.saturating_sub(1);
        if after == self.frames.len() {
            return (k, 0.0);
        }
        let (from, to) = (self.frames[k], self.frames[after]);
        (k, (at - from as f64) / (to - from) as f64)
    }

    fn at(&self, at: f64) -> Line {
        let (k, share) = self.place(at);
        let (a, b) = (self.lines[k], self.lines[(k + 1).min(self.lines.len() - 1)]);
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * share)
    }

    /// Adds a key at a frame, or at the nearest frame without one.
    fn insert_near(&mut self, frame: usize, own: impl Fn(usize) -> Option<Line>) {
        let last = self.frames[self.frames.len() - 1];
        let is_free = |f: &usize| self.frames.binary_search(f).is_err();
        let near = (0..=last).filter(is_free).min_by_key(|f| f.abs_diff(frame));
        let Some(frame) = near else {
            return;
        };
        let line = own(frame).unwrap_or(self.at(frame as f64));
        let at = self.frames.partition_point(|f| *f < frame);
        self.frames.insert(at, frame);
        self.lines.insert(at, line);
    }

    fn track(&self, step: i32) -> KeyedTrack {
        KeyedTrack {
            frames: self.frames.iter().map(|f| *f as u32).collect(),
            values: self
                .lines
                .iter()
                .flat_map(|line| line.map(|v| rounded(v, step)))
                .collect(),
            width: 4,
        }
    }
}

fn line_of(values: &[f64]) -> Line {
    std::array::from_fn(|i| values[i])
}

/// Fraction that a line has at a position, not clamped, and its derivatives by the line's numbers.
fn share_and_slopes([x1, y1, x2, y2]: &Line, [x, y]: [f64; 2]) -> (f64, Line) {
    let (dx, dy) = (x2 - x1, y2 - y1);
    let length = (dx * dx + dy * dy).max(1e-6);
    let (px, py) = (x - x1, y - y1);
    let share = (px * dx + py * dy) / length;
    // Quotient rule, for the start and for the end.
    let by_end = |p: f64, d: f64| (p - 2.0 * share * d) / length;
    let by_start = |p: f64, d: f64| (-d - p + 2.0 * share * d) / length;
    let slopes = [
        by_start(px, dx),
        by_start(py, dy),
        by_end(px, dx),
        by_end(py, dy),
    ];
    (share, slopes)
}

/// Error of the fraction at a corner, clamped as players do.
fn off(line: &Line, (place, wanted): &([f64; 2], f64)) -> f64 {
    let (share, _) = share_and_slopes(line, *place);
    (share.clamp(0.0, 1.0) - wanted).abs()
}

/// Greatest error at the corners.
fn error(line: &Line, corners: &Corners) -> f64 {
    corners
        .iter()
        .map(|corner| off(line, corner))
        .fold(0.0, f64::max)
}

/// Centre and extent of a set of corners.
///
/// Affine fractions are solved relative to their region, where the equations are well conditioned.
struct Region {
    middle: [f64; 2],
    extent: f64,
}

impl Region {
    fn of(places: impl Iterator<Item = [f64; 2]>) -> Self {
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
        for place in places {
            count += 1.0;
            for i in 0..2 {
                sum[i] += place[i];
                low[i] = low[i].min(place[i]);
                high[i] = high[i].max(place[i]);
            }
        }
        Self {
            middle: sum.map(|s| s / f64::max(count, 1.0)),
            extent: (high[0] - low[0]).hypot(high[1] - low[1]).max(1.0),
        }
    }

    fn row(&self, place: [f64; 2]) -> [f64; 3] {
        let of = |i: usize| (place[i] - self.middle[i]) / self.extent;
        [of(0), of(1), 1.0]
    }

    /// Adds a frame's corners to the equations of an affine fraction.
    fn add(&self, system: &mut Banded, corners: &Corners, weight: f64) {
        for (place, share) in corners {
            system.add(0, &self.row(*place), *share, weight);
        }
    }

    /// Converts an affine fraction (slope, slope, value at the centre) to a line near the centre; a
    /// slope of less than one level over the region is raised to that.
    fn line(&self, [x, y, value]: [f64; 3], level: f64) -> Line {
        let steep = x.hypot(y);
        let direction = if steep > 0.0 {
            [x / steep, y / steep]
        } else {
            [1.0, 0.0]
        };
        let steep = steep.max(level) / self.extent;
        let at = |share: f64, i: usize| {
            let place = self.middle[i] + direction[i] * (share - value) / steep;
            place.clamp(-FARTHEST, FARTHEST)
        };
        [at(0.0, 0), at(0.0, 1), at(1.0, 0), at(1.0, 1)]
    }
}

/// Slope, slope and value at the origin; damped, so that collinear positions do no harm.
fn solve_affine(system: Banded) -> [f64; 3] {
    let x = system.solve(1e-9);
    [x[0], x[1], x[2]]
}

/// Normal equations with a banded matrix.
struct Banded {
    size: usize,
    band: usize,
    /// Row i holds columns i + 1 - band to i.
    rows: Vec<f64>,
    right: Vec<f64>,
}

impl Banded {
    fn new(size: usize, band: usize) -> Self {
        Self {
            size,
            band,
            rows: vec![0.0; size * band],
            right: vec![0.0; size],
        }
    }

    fn get(&self, i: usize, j: usize) -> f64 {
        self.rows[i * self.band + self.band - 1 + j - i]
    }

    fn set(&mut self, i: usize, j: usize, value: f64) {
        self.rows[i * self.band + self.band - 1 + j - i] = value;
    }

    /// Adds a weighted equation `row * x = off`, whose first unknown is `first`.
    fn add(&mut self, first: usize, row: &[f64], off: f64, weight: f64) {
        for (i, a) in row.iter().enumerate() {
            for (j, b) in row.iter().enumerate().take(i + 1) {
                let (i, j) = (first + i, first + j);
                self.set(i, j, self.get(i, j) + weight * a * b);
            }
            self.right[first + i] += weight * a * off;
        }
    }

    /// Solves by Cholesky factorisation within the band; the diagonal is first increased by the
    /// fraction `damping`.
    fn solve(mut self, damping: f64) -> Vec<f64> {
        let greatest = (0..self.size).map(|i| self.get(i, i)).fold(0.0, f64::max);
        let least = (greatest * damping * 1e-6).max(1e-15);
        let from = |i: usize, band: usize| (i + 1).saturating_sub(band);
        for i in 0..self.size {
            for j in from(i, self.band)..=i {
                let mut sum = self.get(i, j);
                if i == j {
                    sum += sum * damping + least;
                }
                for k in from(i, self.band).max(from(j, self.band))..j {
                    sum -= self.get(i, k) * self.get(j, k);
                }
                let value = if i == j {
                    sum.max(1e-30).sqrt()
                } else {
                    sum / self.get(j, j)
                };
                self.set(i, j, value);
            }
        }
        let mut x = self.right.clone();
        for i in 0..self.size {
            for k in from(i, self.band)..i {
                x[i] -= self.get(i, k) * x[k];
            }
            x[i] /= self.get(i, i);
        }
        for i in (0..self.size).rev() {
            for k in i + 1..(i + self.band).min(self.size) {
                x[i] -= self.get(k, i) * x[k];
            }
            x[i] /= self.get(i, i);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [[f64; 2]; 3] = [[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]];

    fn wanted(frames: Vec<Option<[f64; 3]>>) -> Wanted<'static> {
        let of = |shares: [f64; 3]| {
            let corners = std::array::from_fn(|i| (PLACES[i], shares[i]));
            (corners, 4.0 / 255.0)
        };
        Wanted {
            frames: frames.into_iter().map(|f| f.map(of)).collect(),
            level: 1.0 / 255.0,
            steps: &[10, 1],
        }
    }

    #[test]
    fn even_light_by_hand() {
        // From 0.2 at x = 0 to 0.7 at x = 100: black at -40, full at 160.
        let line = few_keys(&wanted(vec![Some([0.2, 0.7, 0.2]); 5]), f64::INFINITY).unwrap();
        assert!(line.is_still());
        let [x1, y1, x2, y2] = line.values[..] else {
            panic!("{line:?}");
        };
        assert_eq!((x1, x2, y1), (-40, 160, y2));
    }

    #[test]
    fn slopes_of_shares_are_those_of_small_steps() {
        let line = [3.0, -7.0, 60.0, 40.0];
        let place = [21.0, 9.0];
        let (share, slopes) = share_and_slopes(&line, place);
        for (i, slope) in slopes.into_iter().enumerate() {
            let mut moved = line;
            moved[i] += 1e-4;
            let expected = (share_and_slopes(&moved, place).0 - share) / 1e-4;
            assert!((slope - expected).abs() < 1e-5, "{i}: {slope} {expected}");
        }
    }

    #[test]
    fn banded_equations_are_solved() {
        // (2 1 0; 1 2 1; 0 1 2) x = (4 8 8) has the solution (1 2 3).
        let mut system = Banded::new(3, 2);
        for i in 0..3 {
            system.set(i, i, 2.0);
        }
        system.set(1, 0, 1.0);
        system.set(2, 1, 1.0);
        system.right = vec![4.0, 8.0, 8.0];
        let x = system.solve(0.0);
        assert!((x[0] - 1.0).abs() + (x[1] - 2.0).abs() + (x[2] - 3.0).abs() < 1e-9);
    }

    #[test]
    fn growing_light_needs_few_keys_and_stays_within_the_tolerance() {
        let frames: Vec<Option<[f64; 3]>> = (0..60)
            .map(|f| {
                let t = f64::from(f) / 59.0;
                let hidden = (20..30).contains(&f);
                (!hidden).then_some([0.2 + 0.4 * t, 0.5 + 0.4 * t, 0.3 + 0.4 * t])
            })
            .collect();
        let wanted = wanted(frames);
        let line = few_keys(&wanted, f64::INFINITY).unwrap();
        assert!(!line.is_still() && line.len() <= 4, "{line:?}");
        assert!(wanted.holds(&line, 1.0));
        // Only two of the four numbers move.
        let moves = |i: usize| (0..line.len()).any(|k| line.key(k)[i] != line.key(0)[i]);
        assert_eq!((0..4).filter(|i| moves(*i)).count(), 2);
    }

    #[test]
    fn no_light_and_no_frame_are_lines_too() {
        for frames in [
            vec![],
            vec![None; 4],
            vec![Some([0.5; 3])],
            vec![Some([0.0; 3]); 9],
        ] {
            let wanted = wanted(frames);
            let line = few_keys(&wanted, f64::INFINITY).unwrap();
            assert!(line.is_still() && line.width == 4);
            assert!(wanted.holds(&line, 1.0));
        }
    }

    #[test]
    fn light_that_turns_over_is_not_wrong_between_frames() {
        // A weak slope changes its sign between frames.
        let frames = (0..20).map(|f| {
            let slope = if f < 10 { 0.03 } else { -0.03 };
            Some([0.7 - slope, 0.7 + slope, 0.7])
        });
        let wanted = wanted(frames.collect());
        let line = few_keys(&wanted, f64::INFINITY).unwrap();
        assert!(
            wanted.excess(&line) <= 4.0,
            "{line:?}: {}",
            wanted.excess(&line)
        );
    }

    #[test]
    fn light_that_turns_fast_is_shown_better_than_by_one_line_or_by_those_of_the_frames() {
        let frames = (0..12).map(|f| {
            let turn = 2.0 * f64::from(f);
            let share = |x: f64, y: f64| 0.5 + 0.3 * (turn.cos() * x + turn.sin() * y);
            Some([share(-0.5, -0.5), share(0.5, -0.5), share(-0.5, 0.5)])
        });
        let wanted = wanted(frames.collect());
        let constant = wanted.constant();
        let still = KeyedTrack::still(constant.map(|v| rounded(v, 1)).to_vec());
        let own = wanted.every_frame(constant).track(1);
        let harm = |track| wanted.harm(track);
        let found = few_keys(&wanted, f64::INFINITY).unwrap();
        assert_eq!(found.len(), 12);
        assert!(harm(&found) < 0.5 * harm(&still).min(harm(&own)));
    }

    #[test]
    fn corners_on_one_line_and_wild_light_end() {
        let mut wild = wanted(
            (0..40)
                .map(|f| Some([(f * 37 % 11) as f64 / 10.0, (f * 53 % 7) as f64 / 6.0, 0.5]))
                .collect(),
        );
        assert_eq!(few_keys(&wild, f64::INFINITY).unwrap().width, 4);
        for (corners, _) in wild.frames.iter_mut().flatten() {
            corners[2].0 = [50.0, 0.0];
            corners[1].0 = [0.0, 0.0];
        }
        assert_eq!(few_keys(&wild, f64::INFINITY).unwrap().width, 4);
    }
}
