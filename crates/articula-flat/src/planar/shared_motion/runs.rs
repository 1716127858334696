//! The motions of a sequence of layers that take the fewest bytes.

use super::cost::{Costs, least, motion};

/// Motion of each layer, by layer, for the sequence in which they are painted: each run of layers with
/// one motion costs a group. Solved by dynamic programming (Viterbi).
pub(super) fn cheapest(costs: &Costs, order: &[usize]) -> Vec<Option<u32>> {
    let groups = costs.groups();
    let mut sums = vec![0.0f32; groups.len()];
    let mut before: Vec<Vec<u16>> = Vec::with_capacity(order.len());
    for (i, layer) in order.iter().enumerate() {
        let from = least(&sums);
        let mut choice = vec![from as u16; groups.len()];
        let mut next = Vec::with_capacity(groups.len());
        for (m, group) in groups.iter().enumerate() {
            let begun = sums[from] + group;
            let is_begun = i == 0 || begun < sums[m];
            if !is_begun {
                choice[m] = m as u16;
            }
            next.push(if is_begun { begun } else { sums[m] } + costs.row(*layer)[m]);
        }
        before.push(choice);
        sums = next;
    }
    let mut at = least(&sums);
    let mut motions = vec![None; order.len()];
    for (layer, choice) in order.iter().zip(&before).rev() {
        motions[*layer] = motion(at);
        at = usize::from(choice[at]);
    }
    motions
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Bytes of layers in sequence with some motions.
    fn sum(costs: &Costs, motions: &[usize]) -> f32 {
        let begins = |i: usize| i == 0 || motions[i] != motions[i - 1];
        let of = |i: usize| {
            let group = if begins(i) {
                costs.groups()[motions[i]]
            } else {
                0.0
            };
            group + costs.row(i)[motions[i]]
        };
        (0..motions.len()).map(of).sum()
    }

    #[test]
    fn one_that_suits_badly_stays_in_the_run_that_it_would_break() {
        let rows = vec![vec![9.0, 1.0], vec![3.0, 5.0], vec![9.0, 1.0]];
        let costs = |group: f32| Costs::from_rows(rows.clone(), vec![0.0, group]);
        let order = [0, 1, 2];
        assert_eq!(cheapest(&costs(1.0), &order), [Some(0), None, Some(0)]);
        assert_eq!(cheapest(&costs(4.0), &order), [Some(0); 3]);
        assert_eq!(cheapest(&costs(30.0), &order), [None; 3]);
        // By layer, not by sequence.
        assert_eq!(cheapest(&costs(4.0), &[1, 0, 2]), [Some(0), None, Some(0)]);
    }

    proptest! {
        #[test]
        fn nothing_takes_fewer_bytes(
            rows in prop::collection::vec(prop::collection::vec(0u8..20, 3), 1..6),
            groups in prop::collection::vec(0u8..20, 2),
        ) {
            let number = |row: &Vec<u8>| row.iter().copied().map(f32::from).collect();
            let groups = std::iter::once(0.0).chain(groups.into_iter().map(f32::from));
            let count = rows.len();
            let costs = Costs::from_rows(rows.iter().map(number).collect(), groups.collect());
            let order: Vec<usize> = (0..count).collect();
            let found = cheapest(&costs, &order);
            let found: Vec<usize> = found.iter().map(|m| m.map_or(0, |m| m as usize + 1)).collect();
            let all = (0..3usize.pow(count as u32)).map(|n| {
                let motions: Vec<usize> = (0..count as u32).map(|i| n / 3usize.pow(i) % 3).collect();
                sum(&costs, &motions)
            });
            prop_assert_eq!(sum(&costs, &found), all.fold(f32::INFINITY, f32::min));
        }
    }
}
