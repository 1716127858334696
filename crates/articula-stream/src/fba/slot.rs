//! The coded numbers of a frame, in their order: fields of FAP 1 and 2, low-level parameters.

use super::model::{Adaptive, Model};
use super::quantise;
use super::ranges::{HIGH_MOST, Ranges};
use articula_core::fap_table::LOW_FAP_COUNT;

/// A coded number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Slot {
    /// Number of the parameter.
    pub(super) fap: usize,
    pub(super) field: usize,
}

/// Numbers of FAP 1, then of FAP 2: the field, its greatest value and whether it is quantised.
const HIGH: [(usize, usize, i64, bool); 7] = [
    (1, 0, 14, false),
    (1, 1, 14, false),
    (1, 2, HIGH_MOST, true),
    (2, 0, 6, false),
    (2, 1, HIGH_MOST, true),
    (2, 2, 6, false),
    (2, 3, HIGH_MOST, true),
];

/// How many there are.
pub(super) const COUNT: usize = HIGH.len() + LOW_FAP_COUNT;

/// The coded numbers of a parameter.
pub(super) fn slots(fap: usize) -> impl Iterator<Item = Slot> {
    let fields = match fap {
        1 => 3,
        2 => 4,
        _ => 1,
    };
    (0..fields).map(move |field| Slot { fap, field })
}

impl Slot {
    /// Its place among all.
    pub(super) fn index(self) -> usize {
        match self.fap {
            1 => self.field,
            2 => 3 + self.field,
            fap => HIGH.len() + fap - 3,
        }
    }

    /// Name of the field in errors.
    pub(super) fn name(self) -> String {
        match self.fap {
            1 => ["viseme_select1", "viseme_select2", "viseme_blend"][self.field].into(),
            2 => [
                "expression_select1",
                "expression_intensity1",
                "expression_select2",
                "expression_intensity2",
            ][self.field]
                .into(),
            fap => format!("FAP {fap}"),
        }
    }

    pub(super) fn step(self, quantizer: u8) -> i64 {
        match HIGH.get(self.index()) {
            Some((.., true)) => i64::from(quantizer),
            Some(_) => 0,
            None => quantise::step(self.fap, quantizer),
        }
    }

    /// Greatest value of a field of FAP 1 or 2.
    pub(super) fn most(self) -> Option<i64> {
        HIGH.get(self.index()).map(|(_, _, most, _)| *most)
    }

    /// Least and greatest level.
    pub(super) fn range(self, ranges: &Ranges, is_intra: bool) -> (i64, i64) {
        let Some((_, _, most, is_quantised)) = HIGH.get(self.index()) else {
            return ranges.of(self.fap - 3, is_intra);
        };
        let max = if *is_quantised { ranges.high } else { *most };
        (if is_intra { 0 } else { -max }, max)
    }
}

/// Models of the predicted numbers since the last intra frame.
#[derive(Debug)]
pub(super) struct Models {
    predicted: [Option<Adaptive>; COUNT],
}

impl Models {
    pub(super) fn new() -> Self {
        Self {
            predicted: std::array::from_fn(|_| None),
        }
    }

    /// The model of a number of so many symbols. Those of intra frames are used once, and need no
    /// counts.
    pub(super) fn model(&mut self, slot: Slot, is_intra: bool, symbols: u32) -> Model<'_> {
        if is_intra {
            return Model::Uniform(symbols);
        }
        let model = &mut self.predicted[slot.index()];
        Model::Adaptive(model.get_or_insert_with(|| Adaptive::new(symbols)))
    }
}
