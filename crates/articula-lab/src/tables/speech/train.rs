//! Trains the network of the recogniser.

use super::super::random::Random;
use super::augment::{CLIP_SECS, changed};
use super::corpus::{Clip, shapes};
use articula_speech::VISEME_COUNT;
use articula_speech::training::{BANDS, FEATURES, Layer, Network, features, log_bands};
use ndarray::{Array1, Array2, Axis, s};
use rayon::prelude::*;

/// Frames of a clip that are taken.
const FRAMES: usize = (CLIP_SECS * 100.0) as usize;
/// Clips of a step.
const BATCH: usize = 16;
/// Frames that each layer looks at, as offsets from its own.
const OFFSETS: [&[i8]; 4] = [&[-2, -1, 0, 1, 2], &[-4, -2, 0, 2], &[-9, -6, -3, 0], &[0]];
/// Rate of learning, and the steps over which it comes up; it goes down as a cosine.
const RATE: (f32, usize) = (3e-3, 50);
/// What the wrong classes are wanted to have together.
const SMOOTHING: f32 = 0.06;
/// Weight of the frames of p, b and m: missed contacts are seen first.
const CONTACT: f32 = 1.6;
/// Level below the loudest so far above which a frame counts as speech, in nepers of power.
const SPEECH: f32 = -5.0;
/// Adam (Kingma and Ba 2015): how fast both means follow, and what keeps the quotient finite.
const ADAM: (f32, f32, f32) = (0.1, 0.001, 1e-8);

/// What a training hears: the mean of its speech, and its clips.
pub(super) struct Lessons {
    mean: [f32; BANDS],
    heard: Vec<Heard>,
}

/// How long and how wide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plan {
    pub(super) width: usize,
    pub(super) steps: usize,
    pub(super) seed: u64,
}

/// A clip as the network hears it, and the number of the wanted class of each frame.
struct Heard {
    features: Array2<f32>,
    classes: Vec<usize>,
}

/// Clips, each of them changed at random a number of times.
pub(super) fn prepared(clips: &[(Vec<Clip>, usize)], seed: u64) -> Lessons {
    let clips: Vec<&Clip> = clips
        .iter()
        .flat_map(|(clips, copies)| clips.iter().flat_map(|c| (0..*copies).map(move |_| c)))
        .collect();
    let bands: Vec<(Vec<[f32; BANDS]>, Vec<usize>)> = clips
        .par_iter()
        .enumerate()
        .map(|(index, clip)| {
            let (samples, segments) = changed(clip, &mut Random(seed << 40 | index as u64));
            let mut logs = log_bands(&samples);
            logs.truncate(FRAMES);
            let classes = shapes(&segments, logs.len());
            let classes = classes.into_iter().map(|viseme| viseme.number());
            (logs, classes.collect())
        })
        .collect();
    let mean = mean_of_speech(bands.iter().map(|(logs, _)| logs.as_slice()));
    let heard = bands.into_par_iter().map(|(logs, classes)| {
        let numbers = features(&logs, mean);
        let features = Array2::from_shape_fn((numbers.len(), FEATURES), |(t, i)| numbers[t][i]);
        Heard { features, classes }
    });
    Lessons {
        mean,
        heard: heard.collect(),
    }
}

/// The mean of the bands below the loudest frame so far, over the frames of speech.
fn mean_of_speech<'a>(clips: impl Iterator<Item = &'a [[f32; BANDS]]>) -> [f32; BANDS] {
    let (mut sum, mut count) = ([0.0f64; BANDS], 0.0f64);
    for clip in clips {
        let mut peak = f32::NEG_INFINITY;
        for logs in clip {
            let level = (logs.iter().map(|l| l.exp()).sum::<f32>() / BANDS as f32 + 1e-8).ln();
            peak = peak.max(level);
            if level - peak > SPEECH {
                count += 1.0;
                sum.iter_mut()
                    .zip(logs)
                    .for_each(|(s, l)| *s += f64::from(l - peak));
            }
        }
    }
    sum.map(|s| (s / count.max(1.0)) as f32)
}

/// Weight of the frames of each class: rare ones weigh more.
fn class_weights(heard: &[Heard]) -> [f32; VISEME_COUNT] {
    let mut counts = [0usize; VISEME_COUNT];
    heard
        .iter()
        .flat_map(|h| &h.classes)
        .for_each(|class| counts[*class] += 1);
    let all: usize = counts.iter().sum();
    let mut weights = counts.map(|count| {
        let share = (count as f32 / all.max(1) as f32).max(1e-3);
        (1.0 / VISEME_COUNT as f32 / share).powf(0.3)
    });
    weights[articula_speech::Viseme::Pp.number()] *= CONTACT;
    weights
}

/// A layer while it is trained, with both means of its gradient.
struct Trained {
    offsets: &'static [i8],
    weights: [Array2<f32>; 3],
    bias: [Array1<f32>; 3],
}

type Gradient = (Array2<f32>, Array1<f32>);

/// Trains a network, and tells its last loss; `progress` gets each step and the loss so far.
pub(super) fn fit(lessons: &Lessons, plan: Plan, progress: impl Fn(usize, f32)) -> (Network, f32) {
    let heard = &lessons.heard;
    let mut random = Random(plan.seed);
    let weights = class_weights(heard);
    let mut layers = initial(&mut random, plan.width);
    let (mut order, mut loss) = (Vec::new(), 0.0);
    for step in 0..plan.steps {
        if order.len() < BATCH {
            order.extend(shuffled(&mut random, heard.len()));
        }
        let taken: Vec<(&Heard, Option<(usize, usize)>)> = order
            .drain(..BATCH.min(order.len()))
            .enumerate()
            .map(|(index, clip)| (&heard[clip], masked(&mut random, index)))
            .collect();
        let parts: Vec<(Vec<Gradient>, f32, f32)> = taken
            .par_iter()
            .map(|(clip, mask)| gradients(&layers, clip, *mask, &weights))
            .collect();
        let whole: f32 = parts.iter().map(|(.., weight)| weight).sum();
        let now = parts.iter().map(|(_, loss, _)| loss).sum::<f32>() / whole;
        loss = if step == 0 {
            now
        } else {
            0.99 * loss + 0.01 * now
        };
        let done = step as f32 / plan.steps as f32;
        let warm = ((step + 1) as f32 / RATE.1 as f32).min(1.0);
        let rate = RATE.0 * warm * (0.5 + 0.5 * (std::f32::consts::PI * done).cos());
        learn(&mut layers, &parts, whole, rate, step + 1);
        progress(step + 1, loss);
    }
    let network = Network {
        mean: lessons.mean,
        layers: layers.into_iter().map(stored).collect(),
    };
    (network, loss)
}

/// In half of the clips up to three neighbouring bands are hidden (Park et al. 2019, SpecAugment).
fn masked(random: &mut Random, index: usize) -> Option<(usize, usize)> {
    let (first, count) = (random.within(0, BANDS - 4), random.within(0, 3));
    (index < BATCH / 2).then_some((first, count))
}

fn shuffled(random: &mut Random, count: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for at in (1..count).rev() {
        order.swap(at, random.within(0, at));
    }
    order
}

/// Normal weights of the deviation of He et al. (2015); those of the last layer are smaller.
fn initial(random: &mut Random, width: usize) -> Vec<Trained> {
    let mut inputs = FEATURES;
    let mut layers = Vec::new();
    for (index, offsets) in OFFSETS.into_iter().enumerate() {
        let is_last = index + 1 == OFFSETS.len();
        let outputs = if is_last { VISEME_COUNT } else { width };
        let rows = inputs * offsets.len();
        let deviation = (2.0 / rows as f32).sqrt() * if is_last { 0.3 } else { 1.0 };
        let shape = (rows, outputs);
        layers.push(Trained {
            offsets,
            weights: [
                Array2::from_shape_fn(shape, |_| deviation * random.normal()),
                Array2::zeros(shape),
                Array2::zeros(shape),
            ],
            bias: std::array::from_fn(|_| Array1::zeros(outputs)),
        });
        inputs = outputs;
    }
    layers
}

/// Frames at the offsets, side by side. Before the first and after the last frame, these go on.
fn gathered(frames: &Array2<f32>, offsets: &[i8]) -> Array2<f32> {
    let (count, width) = frames.dim();
    let mut out = Array2::zeros((count, width * offsets.len()));
    for (at, offset) in offsets.iter().enumerate() {
        let mut part = out.slice_mut(s![.., at * width..(at + 1) * width]);
        for (t, mut row) in part.axis_iter_mut(Axis(0)).enumerate() {
            row.assign(&frames.row(shifted(t, *offset, count)));
        }
    }
    out
}

/// The transpose of [`gathered`]: what each frame gives is summed.
fn scattered(gathered: &Array2<f32>, offsets: &[i8]) -> Array2<f32> {
    let (count, width) = (gathered.nrows(), gathered.ncols() / offsets.len());
    let mut out = Array2::zeros((count, width));
    for (at, offset) in offsets.iter().enumerate() {
        let part = gathered.slice(s![.., at * width..(at + 1) * width]);
        for (t, row) in part.axis_iter(Axis(0)).enumerate() {
            let mut to = out.row_mut(shifted(t, *offset, count));
            to += &row;
        }
    }
    out
}

fn shifted(frame: usize, offset: i8, count: usize) -> usize {
    (frame as isize + isize::from(offset)).clamp(0, count as isize - 1) as usize
}

/// The gradient of the weighted cross entropy of a clip's frames, this sum, and that of the weights.
fn gradients(
    layers: &[Trained],
    clip: &Heard,
    mask: Option<(usize, usize)>,
    weights: &[f32; VISEME_COUNT],
) -> (Vec<Gradient>, f32, f32) {
    let mut frames = clip.features.clone();
    if let Some((first, count)) = mask {
        frames.slice_mut(s![.., first..first + count]).fill(0.0);
    }
    let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
    for layer in layers {
        let input = gathered(&frames, layer.offsets);
        let output = input.dot(&layer.weights[0]) + &layer.bias[0];
        frames = output.mapv(|value| value.max(0.0));
        inputs.push(input);
        outputs.push(output);
    }
    let mut down = outputs.pop().unwrap_or_default();
    let (mut loss, mut whole) = (0.0, 0.0);
    for (mut row, class) in down.axis_iter_mut(Axis(0)).zip(&clip.classes) {
        let greatest = row.fold(f32::NEG_INFINITY, |a, b| a.max(*b));
        row.mapv_inplace(|value| (value - greatest).exp());
        let sum = row.sum();
        let weight = weights[*class];
        loss -= weight * (row[*class] / sum + 1e-9).ln();
        whole += weight;
        row.mapv_inplace(|value| weight * (value / sum - SMOOTHING / VISEME_COUNT as f32));
        row[*class] -= weight * (1.0 - SMOOTHING);
    }
    let mut gradients = Vec::new();
    for (index, layer) in layers.iter().enumerate().rev() {
        let input = &inputs[index];
        gradients.push((input.t().dot(&down), down.sum_axis(Axis(0))));
        if index > 0 {
            down = scattered(&down.dot(&layer.weights[0].t()), layer.offsets);
            down.zip_mut_with(&outputs[index - 1], |down, output| {
                if *output <= 0.0 {
                    *down = 0.0;
                }
            });
        }
    }
    gradients.reverse();
    (gradients, loss, whole)
}

/// A step of Adam along the sum of the gradients of the clips.
fn learn(
    layers: &mut [Trained],
    parts: &[(Vec<Gradient>, f32, f32)],
    whole: f32,
    rate: f32,
    step: usize,
) {
    let rest = |share: f32| 1.0 - (1.0 - share).powi(i32::try_from(step).unwrap_or(i32::MAX));
    let (first, second) = (rest(ADAM.0), rest(ADAM.1));
    let moved = |value: &mut f32, m: &mut f32, v: &mut f32, gradient: f32| {
        let gradient = (gradient / whole).clamp(-1.0, 1.0);
        *m += ADAM.0 * (gradient - *m);
        *v += ADAM.1 * (gradient * gradient - *v);
        *value -= rate * (*m / first) / ((*v / second).sqrt() + ADAM.2);
    };
    for (index, layer) in layers.iter_mut().enumerate() {
        let mut weights = Array2::zeros(layer.weights[0].raw_dim());
        let mut bias = Array1::zeros(layer.bias[0].raw_dim());
        for (gradients, ..) in parts {
            weights += &gradients[index].0;
            bias += &gradients[index].1;
        }
        let [value, m, v] = &mut layer.weights;
        ndarray::Zip::from(value)
            .and(m)
            .and(v)
            .and(&weights)
            .for_each(|w, m, v, g| moved(w, m, v, *g));
        let [value, m, v] = &mut layer.bias;
        ndarray::Zip::from(value)
            .and(m)
            .and(v)
            .and(&bias)
            .for_each(|w, m, v, g| moved(w, m, v, *g));
    }
}

fn stored(layer: Trained) -> Layer {
    let ([weights, ..], [bias, ..]) = (layer.weights, layer.bias);
    Layer {
        offsets: layer.offsets.to_vec(),
        weights: weights.iter().copied().collect(),
        bias: bias.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(random: &mut Random, count: usize, width: usize) -> Array2<f32> {
        Array2::from_shape_fn((count, width), |_| random.normal())
    }

    #[test]
    fn scattering_is_the_transpose_of_gathering() {
        let mut random = Random(7);
        let (a, b) = (frames(&mut random, 12, 3), frames(&mut random, 12, 9));
        let offsets = [-4, 0, 2];
        let dot = |a: &Array2<f32>, b: &Array2<f32>| (a * b).sum();
        let (left, right) = (
            dot(&gathered(&a, &offsets), &b),
            dot(&a, &scattered(&b, &offsets)),
        );
        assert!((left - right).abs() < 1e-4, "{left} {right}");
    }

    /// Frames whose class is the sign of one band six frames before.
    fn toy(random: &mut Random) -> Heard {
        let features = frames(random, 60, FEATURES);
        let class = |t: usize| 3 + 4 * usize::from(features[(t.saturating_sub(6), 5)] > 0.0);
        let classes = (0..60).map(class).collect();
        Heard { features, classes }
    }

    #[test]
    fn gradients_are_those_of_the_loss() {
        let mut random = Random(11);
        let clip = toy(&mut random);
        let mut layers = initial(&mut random, 8);
        let weights = std::array::from_fn(|class| 1.0 + class as f32 / 10.0);
        let (gradients, ..) = gradients(&layers, &clip, None, &weights);
        // The loss that the gradient is of has wrong classes in it too; the one that is told has not.
        let loss = |layers: &[Trained]| {
            let mut frames = clip.features.clone();
            for layer in layers {
                let out = gathered(&frames, layer.offsets).dot(&layer.weights[0]) + &layer.bias[0];
                frames = if layer.bias[0].len() == VISEME_COUNT {
                    out
                } else {
                    out.mapv(|v| v.max(0.0))
                };
            }
            let mut sum = 0.0;
            for (row, class) in frames.axis_iter(Axis(0)).zip(&clip.classes) {
                let log_sum = row.mapv(f64::from).mapv(f64::exp).sum().ln();
                for (other, value) in row.iter().enumerate() {
                    let own = if other == *class {
                        1.0 - SMOOTHING
                    } else {
                        0.0
                    };
                    let wanted = f64::from(own + SMOOTHING / VISEME_COUNT as f32);
                    sum += f64::from(weights[*class]) * wanted * (log_sum - f64::from(*value));
                }
            }
            sum
        };
        for (layer, at) in [(0, (30, 2)), (1, (5, 6)), (2, (17, 1)), (3, (4, 7))] {
            const STEP: f32 = 1e-3;
            let before = layers[layer].weights[0][at];
            let mut at_value = |value: f32| {
                layers[layer].weights[0][at] = value;
                loss(&layers)
            };
            let slope = (at_value(before + STEP) - at_value(before - STEP)) / f64::from(2.0 * STEP);
            at_value(before);
            let found = f64::from(gradients[layer].0[at]);
            assert!(
                (slope - found).abs() < 0.02 * slope.abs().max(0.5),
                "{layer}: {slope} {found}"
            );
        }
    }

    #[test]
    fn a_network_learns_what_came_before() {
        let mut random = Random(3);
        let heard = (0..32).map(|_| toy(&mut random)).collect();
        let lessons = Lessons {
            mean: [0.0; BANDS],
            heard,
        };
        let plan = Plan {
            width: 12,
            steps: 400,
            seed: 5,
        };
        let first = std::cell::Cell::new(None);
        let (network, loss) = fit(&lessons, plan, |_, loss| {
            first.set(first.get().or(Some(loss)));
        });
        let first = first.get().unwrap();
        // Two classes at random have a loss of 0.69; of fifteen that nothing is known of it is 2.7.
        assert!(first > 2.0 && loss < 0.5, "{first} {loss}");
        assert_eq!(
            Network::read(&network.to_bytes()).unwrap().layers.len(),
            OFFSETS.len()
        );
    }
}
