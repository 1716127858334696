//! Frequencies of symbols, by which they are coded.

/// Total at which frequencies are halved.
const MOST: u32 = 16383;

/// Frequencies of the symbols from 0, all 1 at first. They are kept as sums (a Fenwick tree), so
/// that finding and counting a symbol take a logarithmic time, also in a hostile stream.
#[derive(Debug, Clone)]
pub(super) struct Adaptive {
    counts: Vec<u32>,
    sums: Vec<u32>,
    total: u32,
}

/// What a symbol is coded by.
#[derive(Debug)]
pub(super) enum Model<'a> {
    /// So many symbols, equally frequent.
    Uniform(u32),
    /// Frequencies that adapt.
    Adaptive(&'a mut Adaptive),
}

impl Adaptive {
    pub(super) fn new(symbols: u32) -> Self {
        let mut model = Self {
            counts: vec![1; symbols as usize],
            sums: Vec::new(),
            total: 0,
        };
        model.sum();
        model
    }

    fn sum(&mut self) {
        self.sums.clear();
        self.sums.extend(&self.counts);
        for i in 1..=self.sums.len() {
            let parent = i + lowest_bit(i);
            if parent <= self.sums.len() {
                self.sums[parent - 1] += self.sums[i - 1];
            }
        }
        self.total = self.counts.iter().sum();
    }

    /// Sum of the frequencies before a symbol.
    fn before(&self, symbol: u32) -> u32 {
        let (mut i, mut sum) = (symbol as usize, 0);
        while i > 0 {
            sum += self.sums[i - 1];
            i -= lowest_bit(i);
        }
        sum
    }

    /// The symbol in whose share a number below the total lies.
    fn find(&self, number: u32) -> u32 {
        let (mut at, mut left) = (0, number);
        let mut step = self.sums.len().next_power_of_two();
        while step > 0 {
            if let Some(sum) = self.sums.get(at + step - 1).filter(|sum| **sum <= left) {
                left -= sum;
                at += step;
            }
            step /= 2;
        }
        at as u32
    }

    fn count(&mut self, symbol: u32) {
        if self.total == MOST {
            self.counts.iter_mut().for_each(|f| *f = f.div_ceil(2));
            self.sum();
        }
        self.counts[symbol as usize] += 1;
        self.total += 1;
        let mut i = symbol as usize + 1;
        while i <= self.sums.len() {
            self.sums[i - 1] += 1;
            i += lowest_bit(i);
        }
    }
}

fn lowest_bit(i: usize) -> usize {
    i & i.wrapping_neg()
}

impl Model<'_> {
    /// Sum of all frequencies.
    pub(super) fn total(&self) -> u32 {
        match self {
            Self::Uniform(symbols) => *symbols,
            Self::Adaptive(model) => model.total,
        }
    }

    /// Sums of the frequencies from a symbol on, and of those after it.
    pub(super) fn share(&self, symbol: u32) -> (u32, u32) {
        match self {
            Self::Uniform(symbols) => (symbols - symbol, symbols - symbol - 1),
            Self::Adaptive(model) => {
                let from = model.total - model.before(symbol);
                (from, from - model.counts[symbol as usize])
            }
        }
    }

    /// The symbol whose share has a number, counted from the last symbol.
    pub(super) fn find(&self, number: u32) -> u32 {
        let number = self.total() - 1 - number;
        match self {
            Self::Uniform(_) => number,
            Self::Adaptive(model) => model.find(number),
        }
    }

    /// Counts a symbol that was coded.
    pub(super) fn count(&mut self, symbol: u32) {
        if let Self::Adaptive(model) = self {
            model.count(symbol);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_mutate::Dice;

    #[test]
    fn sums_are_those_of_a_plain_list() {
        for symbols in [1u32, 2, 3, 127, 128, 721, 3721] {
            let mut model = Adaptive::new(symbols);
            let mut plain = vec![1u32; symbols as usize];
            let mut dice = Dice::new(u64::from(symbols));
            for round in 0..17_000 {
                let symbol = dice.roll(symbols as usize).min(dice.roll(symbols as usize)) as u32;
                if plain.iter().sum::<u32>() == 16383 {
                    plain.iter_mut().for_each(|f| *f = f.div_ceil(2));
                }
                plain[symbol as usize] += 1;
                let mut model = Model::Adaptive(&mut model);
                model.count(symbol);
                if round % 997 == 0 || round > 16_990 {
                    let from = plain[symbol as usize..].iter().sum();
                    let after = plain[symbol as usize + 1..].iter().sum();
                    assert_eq!(model.share(symbol), (from, after));
                    assert_eq!((model.find(after), model.find(from - 1)), (symbol, symbol));
                }
            }
        }
    }
}
