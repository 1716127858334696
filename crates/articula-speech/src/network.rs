//! The stored network: layers over the frames around one, a frame at a time.

use crate::bands::BANDS;
use crate::normaliser::FEATURES;
use articula_core::Libm;
use articula_core::viseme::VISEME_COUNT;

/// The weights of the product (`docs/methods/speech.md`).
const STORED: &[u8] = include_bytes!("../weights/asp1.bin");
/// First bytes of a file of weights.
const MAGIC: &[u8; 4] = b"ASP1";

/// Layers, each over some frames of the one before it.
#[derive(Debug, Clone, PartialEq)]
pub struct Network {
    /// Mean of the bands in the speech that it was trained with, below the peak.
    pub mean: [f32; BANDS],
    /// The layers, from the features of a frame to the visemes.
    pub layers: Vec<Layer>,
}

/// Sums of the frames at some offsets, cut off at 0 but for the last layer.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Which frames are summed, from the one that is made: -1 is the one before it.
    pub offsets: Vec<i8>,
    /// For each number of the frame at each offset, the weight of each output.
    pub weights: Vec<f32>,
    /// What each output begins with; there are as many as outputs.
    pub bias: Vec<f32>,
}

impl Network {
    /// The network of the product.
    ///
    /// # Panics
    /// Never: a test reads what is stored.
    pub fn stored() -> Self {
        Self::read(STORED).expect("the stored weights are whole")
    }

    /// Reads a file of weights: counts, the mean, and for each layer its shape, offsets, the scales of
    /// its outputs, biases and weights in 8 bits. `None` if the bytes are not such a file.
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut bytes = Bytes(bytes);
        if bytes.take(4)? != MAGIC {
            return None;
        }
        let [bands, classes, count] = [bytes.u16()?, bytes.u16()?, bytes.u16()?];
        let mean = bytes.floats(bands)?.try_into().ok()?;
        let mut width = FEATURES;
        let mut layers = Vec::new();
        for _ in 0..count {
            let layer = Layer::read(&mut bytes, width)?;
            width = layer.bias.len();
            layers.push(layer);
        }
        let whole = bytes.0.is_empty() && width == classes && classes == VISEME_COUNT;
        whole.then_some(Self { mean, layers })
    }

    /// The file of these weights: each in 8 bits, by the greatest of its output.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        for count in [BANDS, VISEME_COUNT, self.layers.len()] {
            bytes.extend((count as u16).to_le_bytes());
        }
        bytes.extend(self.mean.iter().flat_map(|value| value.to_le_bytes()));
        for layer in &self.layers {
            layer.write(&mut bytes);
        }
        bytes
    }
}

impl Layer {
    fn read(bytes: &mut Bytes<'_>, inputs: usize) -> Option<Self> {
        let [rows, outputs] = [bytes.u16()?, bytes.u16()?];
        let count = usize::from(*bytes.take(1)?.first()?);
        let offsets = bytes.take(count)?.iter();
        let offsets: Vec<i8> = offsets.map(|b| b.cast_signed()).collect();
        let scales = bytes.floats(outputs)?;
        let bias = bytes.floats(outputs)?;
        let weights = bytes
            .take(rows * outputs)?
            .iter()
            .zip(scales.iter().cycle());
        let weights = weights.map(|(weight, scale)| f32::from(weight.cast_signed()) * scale);
        (rows == inputs * count && count > 0 && outputs > 0).then(|| Self {
            offsets,
            weights: weights.collect(),
            bias,
        })
    }

    fn write(&self, bytes: &mut Vec<u8>) {
        let outputs = self.bias.len();
        for count in [self.weights.len() / outputs, outputs] {
            bytes.extend((count as u16).to_le_bytes());
        }
        bytes.push(self.offsets.len() as u8);
        bytes.extend(self.offsets.iter().map(|offset| offset.cast_unsigned()));
        let mut scales = vec![f32::MIN_POSITIVE; outputs];
        for row in self.weights.chunks_exact(outputs) {
            for (scale, weight) in scales.iter_mut().zip(row) {
                *scale = scale.max(weight.abs() / 127.0);
            }
        }
        let numbers = scales.iter().chain(&self.bias);
        bytes.extend(numbers.flat_map(|value| value.to_le_bytes()));
        let weights = self.weights.iter().zip(scales.iter().cycle());
        bytes.extend(
            weights.map(|(weight, scale)| ((weight / scale).round() as i8).cast_unsigned()),
        );
    }

    /// Numbers of a frame that comes in.
    fn inputs(&self) -> usize {
        self.weights.len() / self.bias.len() / self.offsets.len()
    }

    /// Frames that must have come beyond the one that is calculated.
    fn ahead(&self) -> i32 {
        self.offsets
            .iter()
            .copied()
            .map(i32::from)
            .fold(0, i32::max)
    }

    fn behind(&self) -> i32 {
        -self
            .offsets
            .iter()
            .copied()
            .map(i32::from)
            .fold(0, i32::min)
    }
}

/// What is left of a file.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    fn u16(&mut self) -> Option<usize> {
        let bytes = self.take(2)?.try_into().ok()?;
        Some(usize::from(u16::from_le_bytes(bytes)))
    }

    fn floats(&mut self, count: usize) -> Option<Vec<f32>> {
        let (values, _) = self.take(4 * count)?.as_chunks::<4>();
        Some(values.iter().map(|b| f32::from_le_bytes(*b)).collect())
    }
}

/// A network that gets frames one after the other.
#[derive(Debug, Clone)]
pub(crate) struct RunningNetwork {
    network: Network,
    rings: Vec<Ring>,
}

/// The last frames that came into a layer.
#[derive(Debug, Clone)]
struct Ring {
    frames: Vec<Vec<f32>>,
    received: usize,
    /// The next frame that goes out.
    next: usize,
}

impl RunningNetwork {
    pub(crate) fn new(network: Network) -> Self {
        let ring = |layer: &Layer| Ring {
            frames: vec![vec![0.0; layer.inputs()]; (layer.ahead() + layer.behind() + 1) as usize],
            received: 0,
            next: 0,
        };
        Self {
            rings: network.layers.iter().map(ring).collect(),
            network,
        }
    }

    /// Takes the features of a frame; gives the probabilities of the one for which enough has come.
    pub(crate) fn push(&mut self, frame: &[f32]) -> Option<[f32; VISEME_COUNT]> {
        self.pass(0, frame.to_vec())
    }

    /// The frames that are still inside, as if the last one went on.
    pub(crate) fn finish(mut self) -> Vec<[f32; VISEME_COUNT]> {
        let mut out = Vec::new();
        for index in 0..self.rings.len() {
            while self.rings[index].next < self.rings[index].received {
                let made = self.outputs(index);
                out.extend(self.pass_on(index, made));
            }
        }
        out
    }

    fn pass(&mut self, index: usize, frame: Vec<f32>) -> Option<[f32; VISEME_COUNT]> {
        let ring = &mut self.rings[index];
        let slot = ring.received % ring.frames.len();
        ring.frames[slot] = frame;
        ring.received += 1;
        let ahead = self.network.layers[index].ahead() as usize;
        if ring.received <= ring.next + ahead {
            return None;
        }
        let made = self.outputs(index);
        self.pass_on(index, made)
    }

    /// Gives what a layer made to the next one, or makes probabilities of it.
    fn pass_on(&mut self, index: usize, mut made: Vec<f32>) -> Option<[f32; VISEME_COUNT]> {
        if index + 1 == self.rings.len() {
            return Some(softmax(&made));
        }
        made.iter_mut().for_each(|value| *value = value.max(0.0));
        self.pass(index + 1, made)
    }

    /// The next frame of a layer. Before the first and after the last frame, these go on.
    fn outputs(&mut self, index: usize) -> Vec<f32> {
        let layer = &self.network.layers[index];
        let ring = &mut self.rings[index];
        let mut out = layer.bias.clone();
        let rows = layer.weights.chunks_exact(layer.bias.len());
        let last = ring.received as i64 - 1;
        let inputs = layer.offsets.iter().flat_map(|offset| {
            let at = (ring.next as i64 + i64::from(*offset)).clamp(0, last);
            &ring.frames[at as usize % ring.frames.len()]
        });
        for (input, row) in inputs.zip(rows) {
            for (out, weight) in out.iter_mut().zip(row) {
                *out += input * weight;
            }
        }
        ring.next += 1;
        out
    }
}

fn softmax(values: &[f32]) -> [f32; VISEME_COUNT] {
    let greatest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut out = [0.0; VISEME_COUNT];
    for (out, value) in out.iter_mut().zip(values) {
        *out = (value - greatest).libm_exp();
    }
    let sum: f32 = out.iter().sum();
    out.map(|value| value / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stored_weights_are_whole_and_a_cut_file_is_none() {
        let network = Network::stored();
        assert_eq!(network.layers.iter().map(|l| l.ahead()).sum::<i32>(), 4);
        for cut in (0..STORED.len()).step_by(101) {
            assert!(Network::read(&STORED[..cut]).is_none(), "cut at {cut}");
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let stored = Network::stored();
        let again = Network::read(&stored.to_bytes()).unwrap();
        assert_eq!(again.mean, stored.mean);
        for (again, stored) in again.layers.iter().zip(&stored.layers) {
            assert_eq!(
                (&again.offsets, &again.bias),
                (&stored.offsets, &stored.bias)
            );
            // The greatest weight of an output is 127 steps: scales round once more.
            let pairs = again.weights.iter().zip(&stored.weights);
            for (again, stored) in pairs {
                assert!(
                    (again - stored).abs() <= 1e-6 * stored.abs(),
                    "{again} {stored}"
                );
            }
        }
    }

    /// A layer that copies the frame at an offset, with a softmax that only looks at classes.
    fn copying(offset: i8) -> RunningNetwork {
        let layer = Layer {
            offsets: vec![offset],
            weights: (0..VISEME_COUNT * VISEME_COUNT)
                .map(|i| f32::from(u8::from(i % (VISEME_COUNT + 1) == 0)))
                .collect(),
            bias: vec![0.0; VISEME_COUNT],
        };
        let last = Layer {
            offsets: vec![0],
            ..layer.clone()
        };
        RunningNetwork::new(Network {
            mean: [0.0; BANDS],
            layers: vec![layer, last],
        })
    }

    #[test]
    fn a_layer_sees_the_frame_at_its_offset_and_ends_go_on() {
        for offset in [-3i8, 0, 2] {
            let mut network = copying(offset);
            let mut out = Vec::new();
            for class in 0..10 {
                let mut frame = [0.0; VISEME_COUNT];
                frame[class] = 9.0;
                out.extend(network.push(&frame));
            }
            assert_eq!(out.len(), 10 - usize::from(offset.max(0).unsigned_abs()));
            out.extend(network.finish());
            let strongest = |frame: &[f32; VISEME_COUNT]| {
                (0..VISEME_COUNT)
                    .max_by(|a, b| frame[*a].total_cmp(&frame[*b]))
                    .unwrap()
            };
            let seen: Vec<usize> = out.iter().map(strongest).collect();
            let expected = (0..10i64).map(|t| (t + i64::from(offset)).clamp(0, 9) as usize);
            assert_eq!(seen, expected.collect::<Vec<_>>(), "offset {offset}");
        }
    }
}
