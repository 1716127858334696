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
