//! The mesh that an encoder describes, in the form that the walk queries.

use super::super::half_edges::{self, NONE};
use super::Corner;
use super::border::{Beyond, Border};
use super::symbols::Symbol;

/// Faces of points, with the state of the traversal.
#[derive(Debug)]
pub(in super::super) struct Truth<'a> {
    faces: &'a [[u32; 3]],
    twins: Vec<u32>,
    rings: half_edges::Rings,
    /// The known point equal to each point, or [`NONE`] if it is new.
    matches: &'a [u32],
    known: Vec<u32>,
    /// The id that the walk gave to each point.
    ids: Vec<u32>,
    is_visited: Vec<bool>,
    /// Half-edge at the first corner of each visited face, in the order of the walk.
    firsts: Vec<u32>,
    /// Half-edge at the first corner of the next face.
    current: u32,
    lowest: u32,
}

impl<'a> Truth<'a> {
    /// Creates the truth for faces over points, each of which is new or one of `known` points.
    pub(in super::super) fn new(faces: &'a [[u32; 3]], matches: &'a [u32], known: usize) -> Self {
        let mut points = vec![NONE; known];
        for (point, &id) in matches.iter().enumerate() {
            if id != NONE {
                points[id as usize] = point as u32;
            }
        }
        Self {
            faces,
            twins: half_edges::twins(faces),
            rings: half_edges::Rings::new(faces, matches.len()),
            matches,
            known: points,
            ids: vec![NONE; matches.len()],
            is_visited: vec![false; faces.len()],
            firsts: Vec::with_capacity(faces.len()),
            current: 0,
            lowest: 0,
        }
    }

    /// The half-edge at the first corner of each face, in the order of the walk.
    pub(in super::super) fn firsts(&self) -> &[u32] {
        &self.firsts
    }

    /// The id of each point.
    pub(in super::super) fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// Chooses the start of the next component: the free known point of the lowest id if it has a
    /// face left, else the first remaining face.
    pub(super) fn start_component(&mut self, lowest: Option<u32>) {
        let point = lowest.map_or(NONE, |known| self.known[known as usize]);
        let leaving = match point {
            NONE => &[],
            point => self.rings.leaving(point),
        };
        let known = |h: &u32| {
            let face = self.faces[*h as usize / 3];
            let count = |p: &&u32| self.matches[**p as usize] != NONE;
            face.iter().filter(count).count()
        };
        let free = leaving
            .iter()
            .filter(|h| !self.is_visited[**h as usize / 3]);
        // The last one of equals; any is valid.
        if let Some(&first) = free.max_by_key(|h| known(h)) {
            self.current = first;
            return;
        }
        while self.is_visited.get(self.lowest as usize) == Some(&true) {
            self.lowest += 1;
        }
        self.current = self.lowest * 3;
    }

    fn point(&self, corner: usize) -> u32 {
        let face = self.faces[self.current as usize / 3];
        face[(self.current as usize + corner) % 3]
    }

    /// A corner of the next face.
    pub(super) fn corner(&self, corner: usize) -> Corner {
        let point = self.point(corner) as usize;
        match self.ids[point] {
            NONE => Corner::Free(self.matches[point]),
            id => Corner::Visited(id),
        }
    }

    /// The known id of the third corner, which is not visited; [`NONE`] if it is new.
    pub(super) fn free_corner(&self) -> u32 {
        self.matches[self.point(2) as usize]
    }

    /// The id of the third corner, which is visited.
    pub(super) fn visited_corner(&self) -> u32 {
        self.ids[self.point(2) as usize]
    }

    /// Stores the id of a corner.
    pub(super) fn name_corner(&mut self, corner: usize, id: u32) {
        let point = self.point(corner) as usize;
        self.ids[point] = id;
    }

    /// Marks the next face as visited.
    pub(super) fn visit(&mut self) {
        self.is_visited[self.current as usize / 3] = true;
        self.firsts.push(self.current);
    }

    /// Converts a half-edge of the walk to one of the truth.
    fn half_edge(&self, walked: u32) -> u32 {
        let first = self.firsts[walked as usize / 3];
        first - first % 3 + (first + walked) % 3
    }

    /// The half-edge opposite of a loop's edge.
    fn twin(&self, border: &Border, entry: u32) -> u32 {
        self.twins[self.half_edge(border.at(entry).half_edge) as usize]
    }

    /// Determines the symbol of a gate and moves on to the face beyond it.
    pub(super) fn symbol(&mut self, border: &mut Border, gate: u32) -> Symbol {
        let beyond = self.twin(border, gate);
        if beyond == NONE || self.is_visited[beyond as usize / 3] {
            return Symbol::Border;
        }
        self.current = beyond;
        let next = border.next(gate);
        let before = border.previous(gate);
        let is_glued = |entry: u32, half_edge: u32| {
            border.at(entry).beyond == Beyond::Open && self.twin(border, entry) == half_edge
        };
        if is_glued(next, half_edges::previous(beyond)) {
            return Symbol::Right;
        }
        if is_glued(before, half_edges::next(beyond)) {
            return Symbol::Left;
        }
        let id = self.ids[self.point(2) as usize];
        if id == NONE {
            return Symbol::New;
        }
        let Some(corner) = border.find(id) else {
            return Symbol::Elsewhere { is_joined: false };
        };
        if let Some(steps) = border.steps(border.next(next), corner, Border::next) {
            return Symbol::Ahead(steps);
        }
        if let Some(steps) = border.steps(before, corner, Border::previous) {
            return Symbol::Behind(steps);
        }
        Symbol::Elsewhere { is_joined: true }
    }
}
