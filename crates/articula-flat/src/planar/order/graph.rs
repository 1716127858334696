//! First order: the constraints as a weighted graph, its strongly connected components in
//! topological order, and a greedy order inside each component.
//!
//! Source: `docs/methods/vector.md` 4, steps 1 to 3; components after Tarjan 1972, least incoming
//! weight first after Eades, Lin and Smyth 1993. Inside a component, vertices without outgoing
//! weight go to the end, without a new search for components.

use super::overlap::Overlaps;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// Orders triangles for sets that count `weights` samples each. `far_first` contains all of them
/// and decides where constraints do not.
pub(super) fn first_order(
    overlaps: &Overlaps,
    weights: &[(u32, u64)],
    far_first: &[u32],
) -> Vec<u32> {
    let graph = Graph::new(overlaps, weights, far_first);
    let component = graph.components();
    let mut order = Vec::with_capacity(far_first.len());
    for members in graph.in_turn(&component) {
        if members.len() == 1 {
            order.extend(members);
        } else {
            order.extend(graph.least_incoming(&members, &component));
        }
    }
    order.into_iter().map(|v| far_first[v as usize]).collect()
}

/// Constraint graph: an edge to each triangle that has to be painted later, weighted by samples.
/// Vertices are positions in the far-to-near order.
struct Graph {
    edges: Vec<Vec<(u32, u64)>>,
}

impl Graph {
    fn new(overlaps: &Overlaps, weights: &[(u32, u64)], far_first: &[u32]) -> Self {
        let count = far_first.iter().max().map_or(0, |t| *t as usize + 1);
        let mut rank = vec![0; count];
        for (r, t) in far_first.iter().enumerate() {
            rank[*t as usize] = r as u32;
        }
        let mut edges = vec![Vec::new(); far_first.len()];
        for (set, weight) in weights {
            let members = overlaps.members(*set as usize);
            let owner = rank[members[0] as usize];
            for t in &members[1..] {
                edges[rank[*t as usize] as usize].push((owner, *weight));
            }
        }
        for list in &mut edges {
            list.sort_unstable();
            list.dedup_by(|next, kept| {
                let is_same = next.0 == kept.0;
                if is_same {
                    kept.1 += next.1;
                }
                is_same
            });
        }
        Self { edges }
    }

    /// Index of the strongly connected component of each vertex.
    fn components(&self) -> Vec<u32> {
        let count = self.edges.len();
        let mut search = Search {
            index: vec![NONE; count],
            low: vec![0; count],
            component: vec![NONE; count],
            stack: Vec::new(),
            found: 0,
            next: 0,
        };
        // Vertices on the current path, with the next edge of each.
        let mut path: Vec<(u32, usize)> = Vec::new();
        for root in 0..count as u32 {
            if search.index[root as usize] != NONE {
                continue;
            }
            search.enter(root);
            path.push((root, 0));
            while let Some((v, edge)) = path.last_mut() {
                let vertex = *v;
                if let Some((to, _)) = self.edges[vertex as usize].get(*edge) {
                    *edge += 1;
                    if search.index[*to as usize] == NONE {
                        search.enter(*to);
                        path.push((*to, 0));
                    } else if search.component[*to as usize] == NONE {
                        search.lower(vertex, search.index[*to as usize]);
                    }
                    continue;
                }
                path.pop();
                search.leave(vertex);
                if let Some((parent, _)) = path.last() {
                    search.lower(*parent, search.low[vertex as usize]);
                }
            }
        }
        search.component
    }

    /// Components in topological order; among those that may come next, the one with the farthest
    /// vertex first.
    fn in_turn(&self, component: &[u32]) -> Vec<Vec<u32>> {
        let count = component.iter().max().map_or(0, |c| *c as usize + 1);
        let mut members = vec![Vec::new(); count];
        let mut waits_for = vec![0usize; count];
        for (v, c) in component.iter().enumerate() {
            members[*c as usize].push(v as u32);
            for (to, _) in &self.edges[v] {
                let other = component[*to as usize];
                waits_for[other as usize] += usize::from(other != *c);
            }
        }
        let first = |c: usize| Reverse((members[c][0], c));
        let free = (0..count).filter(|c| waits_for[*c] == 0);
        let mut free: BinaryHeap<_> = free.map(first).collect();
        let mut turn = Vec::with_capacity(count);
        while let Some(Reverse((_, c))) = free.pop() {
            turn.push(c);
            for (to, _) in members[c].iter().flat_map(|v| &self.edges[*v as usize]) {
                let other = component[*to as usize] as usize;
                if other != c {
                    waits_for[other] -= 1;
                    if waits_for[other] == 0 {
                        free.push(first(other));
                    }
                }
            }
        }
        turn.into_iter()
            .map(|c| std::mem::take(&mut members[c]))
            .collect()
    }

    /// Orders one component: a vertex without incoming weight comes next, one without outgoing
    /// weight goes to the end, otherwise the one with the least incoming weight from the remaining
    /// vertices comes next.
    fn least_incoming(&self, members: &[u32], component: &[u32]) -> Vec<u32> {
        let local = |v: &u32| members.binary_search(v).ok();
        let inside = component[members[0] as usize];
        let mut before = vec![Vec::new(); members.len()];
        let mut after = vec![Vec::new(); members.len()];
        for (from, v) in members.iter().enumerate() {
            for (to, weight) in &self.edges[*v as usize] {
                if component[*to as usize] == inside
                    && let Some(to) = local(to)
                {
                    after[from].push((to, *weight));
                    before[to].push((from, *weight));
                }
            }
        }
        let total = |edges: &Vec<(usize, u64)>| edges.iter().map(|(_, w)| *w).sum::<u64>();
        let mut incoming: Vec<u64> = before.iter().map(total).collect();
        let mut outgoing: Vec<u64> = after.iter().map(total).collect();
        let of = |weights: &[u64]| (0..members.len()).map(|v| (weights[v], v)).collect();
        let mut by_incoming: BTreeSet<(u64, usize)> = of(&incoming);
        let mut by_outgoing: BTreeSet<(u64, Reverse<usize>)> = (0..members.len())
            .map(|v| (outgoing[v], Reverse(v)))
            .collect();
        let (mut front, mut back) = (Vec::new(), Vec::new());
        while let (Some((least, v)), Some((waiting, Reverse(last)))) =
            (by_incoming.first().copied(), by_outgoing.first().copied())
        {
            let goes_last = least > 0 && waiting == 0;
            let v = if goes_last { last } else { v };
            if goes_last { &mut back } else { &mut front }.push(members[v]);
            by_incoming.remove(&(incoming[v], v));
            by_outgoing.remove(&(outgoing[v], Reverse(v)));
            for (to, weight) in &after[v] {
                if by_incoming.remove(&(incoming[*to], *to)) {
                    incoming[*to] -= weight;
                    by_incoming.insert((incoming[*to], *to));
                }
            }
            for (from, weight) in &before[v] {
                if by_outgoing.remove(&(outgoing[*from], Reverse(*from))) {
                    outgoing[*from] -= weight;
                    by_outgoing.insert((outgoing[*from], Reverse(*from)));
                }
            }
        }
        front.extend(back.into_iter().rev());
        front
    }
}

const NONE: u32 = u32::MAX;

/// State of Tarjan's search for components.
struct Search {
    index: Vec<u32>,
    low: Vec<u32>,
    component: Vec<u32>,
    stack: Vec<u32>,
    found: u32,
    next: u32,
}

impl Search {
    fn enter(&mut self, vertex: u32) {
        self.index[vertex as usize] = self.next;
        self.low[vertex as usize] = self.next;
        self.next += 1;
        self.stack.push(vertex);
    }

    fn lower(&mut self, vertex: u32, to: u32) {
        let low = &mut self.low[vertex as usize];
        *low = (*low).min(to);
    }

    /// Closes a component if `vertex` is its root.
    fn leave(&mut self, vertex: u32) {
        if self.low[vertex as usize] != self.index[vertex as usize] {
            return;
        }
        while let Some(v) = self.stack.pop() {
            self.component[v as usize] = self.found;
            if v == vertex {
                break;
            }
        }
        self.found += 1;
    }
}
