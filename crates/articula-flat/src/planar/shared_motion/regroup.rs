//! A painting order in which layers of one motion come one after the other.

use std::collections::{BTreeMap, BTreeSet};

/// Returns an order of all layers in which those with equal labels follow each other as far as that keeps
/// the sequence of both layers of each pair of `fixed`; `order` is the order so far.
///
/// The label that allows the longest run comes next.
pub(super) fn regrouped(
    order: &[usize],
    fixed: &[(usize, usize)],
    labels: &[Option<u32>],
) -> Vec<usize> {
    let mut waiting = Waiting::new(order, fixed, labels);
    let mut regrouped = Vec::with_capacity(order.len());
    while let Some(label) = waiting.longest() {
        while let Some(layer) = waiting.take(label) {
            regrouped.push(layer);
        }
    }
    regrouped
}

/// Layers that are still to be painted.
#[derive(Debug, Clone)]
struct Waiting<'a> {
    labels: &'a [Option<u32>],
    order: &'a [usize],
    place: Vec<usize>,
    /// Layers that come after each layer.
    after: Vec<Vec<usize>>,
    /// Number of layers that have to come before.
    open: Vec<u32>,
    /// Places of layers that may come next, by label.
    ready: BTreeMap<Option<u32>, BTreeSet<usize>>,
}

impl<'a> Waiting<'a> {
    fn new(order: &'a [usize], fixed: &[(usize, usize)], labels: &'a [Option<u32>]) -> Self {
        let count = labels.len();
        let mut place = vec![0; count];
        for (at, layer) in order.iter().enumerate() {
            place[*layer] = at;
        }
        let (mut after, mut open) = (vec![Vec::new(); count], vec![0; count]);
        for (a, b) in fixed {
            let (first, then) = if place[*a] < place[*b] {
                (*a, *b)
            } else {
                (*b, *a)
            };
            after[first].push(then);
            open[then] += 1;
        }
        let mut ready: BTreeMap<Option<u32>, BTreeSet<usize>> = BTreeMap::new();
        for layer in order.iter().filter(|l| open[**l] == 0) {
            ready
                .entry(labels[*layer])
                .or_default()
                .insert(place[*layer]);
        }
        Self {
            labels,
            order,
            place,
            after,
            open,
            ready,
        }
    }

    /// Takes the next layer with a label, if one may come.
    fn take(&mut self, label: Option<u32>) -> Option<usize> {
        let layer = self.order[self.ready.get_mut(&label)?.pop_first()?];
        for then in std::mem::take(&mut self.after[layer]) {
            self.open[then] -= 1;
            if self.open[then] == 0 {
                let ready = self.ready.entry(self.labels[then]).or_default();
                ready.insert(self.place[then]);
            }
        }
        Some(layer)
    }

    /// The label with the longest run; `None` if nothing is left.
    fn longest(&self) -> Option<Option<u32>> {
        let ready = self.ready.iter().filter(|(_, layers)| !layers.is_empty());
        let length = |label: &Option<u32>| {
            let mut run = Run::new(self);
            run.length(*label)
        };
        let runs = ready.map(|(label, _)| (*label, length(label)));
        let longer =
            |a: (Option<u32>, usize), b: (Option<u32>, usize)| if b.1 > a.1 { b } else { a };
        runs.reduce(longer).map(|(label, _)| label)
    }
}

/// A run that is tried.
struct Run<'a, 'b> {
    waiting: &'b Waiting<'a>,
    /// Number of layers before, of layers that the run frees of some.
    open: BTreeMap<usize, u32>,
}

impl<'a, 'b> Run<'a, 'b> {
    fn new(waiting: &'b Waiting<'a>) -> Self {
        Self {
            waiting,
            open: BTreeMap::new(),
        }
    }

    fn length(&mut self, label: Option<u32>) -> usize {
        let waiting = self.waiting;
        let places = waiting.ready.get(&label).into_iter().flatten();
        let mut next: Vec<usize> = places.map(|p| waiting.order[*p]).collect();
        let mut length = 0;
        while let Some(layer) = next.pop() {
            length += 1;
            for then in &waiting.after[layer] {
                let open = self.open.entry(*then).or_insert(waiting.open[*then]);
                *open -= 1;
                if *open == 0 && waiting.labels[*then] == label {
                    next.push(*then);
                }
            }
        }
        length
    }
}
