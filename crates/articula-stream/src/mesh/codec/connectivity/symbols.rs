//! Position of a face relative to its gate, as binary decisions.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (a): new, right, left, border, the rest;
//! contexts are the last symbols, the visited faces of nearby corners, and the prediction from the
//! coarser level.

use super::super::contexts::Contexts;
use super::super::matching::Hint;
use super::super::mixing::{Weights, decide};
use super::super::number::Natural;
use crate::range_coder::{Bit, Coder};

/// Third corner of the face beyond a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Symbol {
    /// A point not visited yet.
    New,
    /// The corner after the gate; its edge is joined.
    Right,
    /// The corner before the gate; its edge is joined.
    Left,
    /// There is no face.
    Border,
    /// A number of steps after the corner after the gate.
    Ahead(u32),
    /// A number of steps before the corner before the gate.
    Behind(u32),
    /// Any visited point, possibly joined with a loop that contains it.
    Elsewhere {
        /// Whether it is joined.
        is_joined: bool,
    },
}

/// Coding context of a gate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Context {
    pub(super) hint: usize,
    /// Number of visited faces at the ends of the gate, at the corner after and at the one before.
    pub(super) visits: [u8; 4],
    /// Whether the edges after and before may be joined.
    pub(super) is_open: [bool; 2],
}

/// Models of symbols.
#[derive(Debug)]
pub(super) struct Symbols {
    /// Models of four kinds of context for each of the first four decisions.
    decisions: Vec<[Contexts<Bit, BLOCK>; KINDS]>,
    weights: Vec<Vec<Weights<KINDS>>>,
    rare: [Bit; 3],
    steps: [Natural; 2],
    /// The last symbols, three bits each.
    last: usize,
}

const KINDS: usize = 5;
/// Number of contexts of each kind.
const SIZE: usize = 1 << 14;
/// Number of contexts allocated at once: those that differ in the last parts of a context.
const BLOCK: usize = 64;

impl Default for Symbols {
    fn default() -> Self {
        let decision = || std::array::from_fn(|_| Contexts::new(SIZE));
        Self {
            decisions: (0..4).map(|_| decision()).collect(),
            weights: vec![vec![Weights::default(); Hint::COUNT]; 4],
            rare: [Bit::default(); 3],
            steps: Default::default(),
            last: 0,
        }
    }
}

impl Symbols {
    pub(super) fn code(
        &mut self,
        coder: &mut impl Coder,
        context: &Context,
        symbol: Symbol,
    ) -> Symbol {
        let found = self.code_symbol(coder, context, symbol);
        let code = match found {
            Symbol::New => 0,
            Symbol::Right => 1,
            Symbol::Left => 2,
            Symbol::Border => 3,
            _ => 4,
        };
        self.last = self.last << 3 | code;
        found
    }

    fn code_symbol(&mut self, coder: &mut impl Coder, context: &Context, symbol: Symbol) -> Symbol {
        if self.decide(coder, 0, context, symbol == Symbol::New) {
            return Symbol::New;
        }
        if context.is_open[0] && self.decide(coder, 1, context, symbol == Symbol::Right) {
            return Symbol::Right;
        }
        if context.is_open[1] && self.decide(coder, 2, context, symbol == Symbol::Left) {
            return Symbol::Left;
        }
        if self.decide(coder, 3, context, symbol == Symbol::Border) {
            return Symbol::Border;
        }
        let is_elsewhere = matches!(symbol, Symbol::Elsewhere { .. });
        if coder.bit(&mut self.rare[0], is_elsewhere) {
            let is_joined = symbol == Symbol::Elsewhere { is_joined: true };
            let is_joined = coder.bit(&mut self.rare[1], is_joined);
            return Symbol::Elsewhere { is_joined };
        }
        let (is_behind, steps) = match symbol {
            Symbol::Behind(steps) => (true, steps),
            Symbol::Ahead(steps) => (false, steps),
            _ => (false, 0),
        };
        if coder.bit(&mut self.rare[2], is_behind) {
            Symbol::Behind(self.steps[1].code(coder, steps))
        } else {
            Symbol::Ahead(self.steps[0].code(coder, steps))
        }
    }

    fn decide(
        &mut self,
        coder: &mut impl Coder,
        decision: usize,
        context: &Context,
        bit: bool,
    ) -> bool {
        let [a, b, after, before] = context.visits.map(usize::from);
        let open = usize::from(context.is_open[0]) * 2 + usize::from(context.is_open[1]);
        let last = self.last;
        let hint = context.hint;
        let at: [usize; KINDS] = [
            (last & 0x1ff) * 10 + b.min(9),
            ((b.min(9) * 10 + after.min(9)) * 4 + open) * 10 + a.min(9),
            (hint * 10 + b.min(9)) * 10 + after.min(9),
            (hint * 64 + (last & 0x3f)) * 4 + open,
            ((a.min(9) * 10 + before.min(9)) * 10 + b.min(9)) * 4 + open,
        ];
        let mut i = 0;
        let models = self.decisions[decision].each_mut().map(|kind| {
            i += 1;
            kind.model(at[i - 1])
        });
        decide(coder, models, &mut self.weights[decision][hint], bit)
    }
}
