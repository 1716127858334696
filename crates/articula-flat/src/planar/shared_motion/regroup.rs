//! A painting order in which layers of one motion come one after the other.

use std::collections::{BTreeMap, BTreeSet};

/// Returns an order of all layers in which those with equal labels follow each other as far as that keeps
/// the sequence of both layers of each pair of `fixed`; `order` is the order so far.
///
/// Next comes the longest run after which nothing with its label is left; if there is none, the longest.
pub(super) fn regrouped(
    order: &[usize],
    fixed: &[(usize, usize)],
    labels: &[Option<u32>],
) -> Vec<usize> {
    let mut waiting = Waiting::new(order, fixed, labels);
    let mut regrouped = Vec::with_capacity(order.len());
    while let Some(label) = waiting.next() {
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
    /// Number of layers that wait, by label.
    left: BTreeMap<Option<u32>, usize>,
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
        let mut left = BTreeMap::new();
        for label in labels {
            *left.entry(*label).or_default() += 1;
        }
        Self {
            labels,
            order,
            place,
            after,
            open,
            ready,
            left,
        }
    }

    /// Takes the next layer with a label, if one may come.
    fn take(&mut self, label: Option<u32>) -> Option<usize> {
        let layer = self.order[self.ready.get_mut(&label)?.pop_first()?];
        *self.left.entry(label).or_default() -= 1;
        for then in std::mem::take(&mut self.after[layer]) {
            self.open[then] -= 1;
            if self.open[then] == 0 {
                let ready = self.ready.entry(self.labels[then]).or_default();
                ready.insert(self.place[then]);
            }
        }
        Some(layer)
    }

    /// The label that comes next; `None` if nothing is left.
    fn next(&self) -> Option<Option<u32>> {
        let ready = self.ready.iter().filter(|(_, layers)| !layers.is_empty());
        let runs = ready.map(|(label, _)| {
            let length = Run::new(self).length(*label);
            (*label, (length == self.left[label], length))
        });
        // The first of equal ones.
        let next = runs.reduce(|a, b| if b.1 > a.1 { b } else { a });
        next.map(|(label, _)| label)
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_not_fixed_comes_together() {
        let labels = [0, 1, 0, 1, 0].map(Some);
        let order = [0, 1, 2, 3, 4];
        assert_eq!(regrouped(&order, &[], &labels), [0, 2, 4, 1, 3]);
        // The last of the first label has to follow one of the second.
        assert_eq!(regrouped(&order, &[(3, 4)], &labels), [1, 3, 0, 2, 4]);
        assert_eq!(
            regrouped(&order, &[(0, 1), (3, 4)], &labels),
            [0, 2, 1, 3, 4]
        );
        assert!(regrouped(&[], &[], &[]).is_empty());
    }

    proptest! {
        #[test]
        fn fixed_pairs_keep_their_sequence(
            order in Just((0..20).collect::<Vec<usize>>()).prop_shuffle(),
            fixed in prop::collection::vec((0usize..20, 0usize..20), 0..60),
            labels in prop::collection::vec(prop::option::of(0u32..4), 20),
        ) {
            let fixed: Vec<_> = fixed.into_iter().filter(|(a, b)| a != b).collect();
            let after = regrouped(&order, &fixed, &labels);
            let place = |order: &[usize], l: usize| order.iter().position(|o| *o == l).unwrap();
            for (a, b) in fixed {
                prop_assert_eq!(
                    place(&order, a) < place(&order, b),
                    place(&after, a) < place(&after, b)
                );
            }
            let mut all = after;
            all.sort_unstable();
            prop_assert_eq!(all, (0..20).collect::<Vec<_>>());
        }
    }
}
