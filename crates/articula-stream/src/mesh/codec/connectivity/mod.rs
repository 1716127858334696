//! Connectivity of a level: the points of each face, and which of them are new.
//!
//! Source: `docs/methods/clustered-mesh.md` part 8.1 (a); S. Gumhold and W. Strasser, "Real time
//! compression of triangle mesh connectivity", 1998 (cut-border machine). Differs: known points are
//! matched during the traversal ([`super::matching`]), so that the coarser level predicts the next
//! symbol; a visited corner that is in no loop within reach is coded by its point id, which covers
//! handles, points of several fans and edges of more than two faces. In the order of the walk:
//!
//! - `truth`: the mesh that an encoder describes
//! - `border`: the loops around the visited faces
//! - `symbols`: position of each face relative to its gate

mod border;
mod symbols;
mod truth;

use super::half_edges::{self, NONE};
use super::matching::{Coarse, Gate, Matching, SEEDS};
use crate::range_coder::{Bit, Coder};
use border::{Beyond, Border};
use symbols::{Symbol, Symbols};
pub(super) use truth::Truth;

/// Faces of points, in the order of the walk. New points have the ids after the known ones.
#[derive(Debug, Default)]
pub(super) struct Walked {
    pub(super) faces: Vec<[u32; 3]>,
    /// Number of new points.
    pub(super) new_points: usize,
}

/// Description of an error in the input of a decoder.
pub(super) type Fault = &'static str;

/// Walks a level of `count` faces; an encoder describes the truth, a decoder rebuilds it.
pub(super) fn walk<C: Coder>(
    coder: &mut C,
    coarse: &Coarse<'_>,
    truth: Option<&mut Truth<'_>>,
    count: usize,
) -> Result<Walked, Fault> {
    let mut walk = Walk {
        coder,
        truth,
        matching: Matching::new(coarse),
        border: Border::default(),
        symbols: Symbols::default(),
        seeds: Seeds::default(),
        twins: Vec::new(),
        visits: vec![0; coarse.points()],
        walked: Walked::default(),
        count,
    };
    while walk.walked.faces.len() < count {
        let gate = walk.start_component()?;
        walk.visit_component(gate)?;
    }
    Ok(walk.walked)
}

struct Walk<'a, 't, C> {
    coder: &'a mut C,
    truth: Option<&'a mut Truth<'t>>,
    matching: Matching<'a>,
    border: Border,
    symbols: Symbols,
    seeds: Seeds,
    /// Opposite half-edges of visited faces, as far as they are joined.
    twins: Vec<u32>,
    /// Number of visited faces of each point.
    visits: Vec<u8>,
    walked: Walked,
    count: usize,
}

/// Models of the first corners of components.
#[derive(Debug, Default)]
struct Seeds {
    is_visited: [Bit; 3],
    known: [Bit; 2],
}

/// A corner: a visited point, the id of a free known point, or a new point.
#[derive(Debug, Clone, Copy)]
pub(super) enum Corner {
    Visited(u32),
    Free(u32),
}

impl<C: Coder> Walk<'_, '_, C> {
    fn start_component(&mut self) -> Result<u32, Fault> {
        let lowest = self.matching.lowest();
        if let Some(truth) = &mut self.truth {
            truth.start_component(lowest);
        }
        let mut points = [NONE; 3];
        for k in 0..3 {
            let corner = self.truth.as_ref().map(|t| t.corner(k));
            let visited = match corner {
                Some(Corner::Visited(point)) => point,
                _ => NONE,
            };
            let wanted = match corner {
                Some(Corner::Free(point)) => point,
                _ => NONE,
            };
            let total = self.matching.points();
            let is_visited = &mut self.seeds.is_visited[k];
            points[k] = if total > 0 && self.coder.bit(is_visited, visited != NONE) {
                self.code_visited(visited)?
            } else {
                let found = if k == 0 {
                    let models = &mut self.seeds.known;
                    self.matching.code_first(self.coder, models, wanted)
                } else {
                    let gate = seed_gate(points, k, |p| self.matching.is_known(p));
                    let hint = self.matching.hint(&gate, NONE, NONE);
                    self.matching.code(self.coder, &gate, hint, [0; 2], wanted)
                };
                let found = found.ok_or("a point is matched twice or out of range")?;
                self.note_point(found);
                found
            };
            if let Some(truth) = &mut self.truth {
                truth.name_corner(k, points[k]);
            }
        }
        let face = self.push_face(points)?;
        let entries: [u32; 3] =
            std::array::from_fn(|k| self.border.add(points[k], face * 3 + k as u32));
        for k in 0..3 {
            self.border.link(entries[k], entries[(k + 1) % 3]);
        }
        Ok(entries[0])
    }

    /// Codes a visited point by its id.
    fn code_visited(&mut self, visited: u32) -> Result<u32, Fault> {
        let total = self.matching.points() as u32;
        let point = self.coder.raw(32 - total.leading_zeros(), visited);
        if point >= total || !self.matching.is_visited(point) {
            return Err("a corner names a point that was not visited");
        }
        Ok(point)
    }

    /// Registers a newly found point.
    fn note_point(&mut self, point: u32) {
        if !self.matching.is_known(point) {
            self.visits.push(0);
            self.walked.new_points += 1;
        }
    }

    fn push_face(&mut self, points: [u32; 3]) -> Result<u32, Fault> {
        let [a, b, c] = points;
        if a == b || b == c || c == a {
            return Err("a face names a point twice");
        }
        if self.coder.is_exhausted() {
            return Err("unexpected end of the bytes");
        }
        for point in points {
            let visits = &mut self.visits[point as usize];
            *visits = visits.saturating_add(1);
        }
        let face = self.walked.faces.len() as u32;
        self.walked.faces.push(points);
        self.twins.extend([NONE; 3]);
        if let Some(truth) = &mut self.truth {
            truth.visit();
        }
        Ok(face)
    }

    fn visit_component(&mut self, first: u32) -> Result<(), Fault> {
        let mut stack = vec![first];
        while let Some(mut gate) = stack.pop() {
            while self.walked.faces.len() < self.count {
                match self.border.at(gate).beyond {
                    Beyond::Gone => break,
                    Beyond::Border | Beyond::Borders => {
                        let next = self.border.next(gate);
                        if self.border.at(next).beyond != Beyond::Open {
                            break;
                        }
                        gate = next;
                    }
                    Beyond::Open => match self.pass(gate, &mut stack)? {
                        Some(next) => gate = next,
                        None => break,
                    },
                }
            }
        }
        Ok(())
    }

    /// Visits the face beyond a gate. Returns the next gate of the same loop.
    fn pass(&mut self, gate: u32, stack: &mut Vec<u32>) -> Result<Option<u32>, Fault> {
        let around = self.around(gate);
        let next = self.border.next(gate);
        let after = self.border.next(next);
        let before = self.border.previous(gate);
        let corners = [self.border.at(after).point, self.border.at(before).point];
        let hint = self.matching.hint(&around, corners[0], corners[1]);
        let wanted = match &mut self.truth {
            Some(truth) => truth.symbol(&mut self.border, gate),
            None => Symbol::New,
        };
        let is_open = [next, before].map(|e| self.border.at(e).beyond == Beyond::Open);
        let visits = [around.a, around.b, corners[0], corners[1]].map(|p| self.visits[p as usize]);
        let context = symbols::Context {
            hint: hint.context(),
            visits,
            is_open,
        };
        let symbol = self.symbols.code(self.coder, &context, wanted);
        match symbol {
            Symbol::New => {
                let wanted = self.truth.as_ref().map_or(NONE, |t| t.free_corner());
                let valences = [visits[1], visits[2]];
                let point = self
                    .matching
                    .code(self.coder, &around, hint, valences, wanted)
                    .ok_or("a point is matched twice or out of range")?;
                self.note_point(point);
                self.add_face(gate, point, None)
            }
            Symbol::Right => {
                let face = self.glue(gate, corners[0])?;
                self.set_twins(face + 2, self.border.at(next).half_edge);
                self.border.remove(next);
                self.border.at_mut(gate).half_edge = face + 1;
                Ok(self.unless_closed(gate))
            }
            Symbol::Left => {
                let face = self.glue(gate, corners[1])?;
                self.set_twins(face + 1, self.border.at(before).half_edge);
                self.border.remove(gate);
                self.border.at_mut(before).half_edge = face + 2;
                Ok(self.unless_closed(before))
            }
            Symbol::Border => Ok(self.border.set_border(gate)),
            Symbol::Ahead(steps) => {
                let corner = self.follow(after, steps, Border::next);
                stack.push(gate);
                self.add_face(gate, self.border.at(corner).point, Some(corner))
            }
            Symbol::Behind(steps) => {
                let corner = self.follow(before, steps, Border::previous);
                stack.push(gate);
                self.add_face(gate, self.border.at(corner).point, Some(corner))
            }
            Symbol::Elsewhere { is_joined } => {
                let visited = self.truth.as_ref().map_or(NONE, |t| t.visited_corner());
                let point = self.code_visited(visited)?;
                let corner = self.border.find(point).filter(|_| is_joined);
                stack.push(gate);
                self.add_face(gate, point, corner)
            }
        }
    }

    fn follow(&self, from: u32, steps: u32, step: impl Fn(&Border, u32) -> u32) -> u32 {
        (0..steps.min(border::REACH)).fold(from, |at, _| step(&self.border, at))
    }

    /// Adds a face beyond a gate; its half-edges run b-a, a-point, point-b.
    fn glue(&mut self, gate: u32, point: u32) -> Result<u32, Fault> {
        let a = self.border.at(gate).point;
        let b = self.border.at(self.border.next(gate)).point;
        let face = self.push_face([b, a, point])? * 3;
        self.set_twins(face, self.border.at(gate).half_edge);
        if let Some(truth) = &mut self.truth {
            truth.name_corner(2, point);
        }
        Ok(face)
    }

    /// Adds a face whose last corner joins the loop, spliced with an existing entry.
    fn add_face(
        &mut self,
        gate: u32,
        point: u32,
        corner: Option<u32>,
    ) -> Result<Option<u32>, Fault> {
        let face = self.glue(gate, point)?;
        self.border.at_mut(gate).half_edge = face + 1;
        let entry = self.border.add(point, face + 2);
        let next = self.border.next(gate);
        self.border.link(entry, next);
        match corner {
            None => {
                self.border.link(gate, entry);
                Ok(Some(entry))
            }
            Some(corner) => {
                let before = self.border.previous(corner);
                self.border.link(before, entry);
                self.border.link(gate, corner);
                self.unless_closed(gate);
                Ok(self.unless_closed(entry))
            }
        }
    }

    fn unless_closed(&mut self, entry: u32) -> Option<u32> {
        if !self.border.is_closed(entry) {
            return Some(entry);
        }
        self.border.close(entry);
        None
    }

    fn set_twins(&mut self, half_edge: u32, twin: u32) {
        self.twins[half_edge as usize] = twin;
        self.twins[twin as usize] = half_edge;
    }

    /// Collects the surroundings of a gate.
    fn around(&self, gate: u32) -> Gate {
        let half_edge = self.border.at(gate).half_edge;
        let faces = &self.walked.faces;
        let (a, b) = (
            half_edges::start(faces, half_edge),
            half_edges::end(faces, half_edge),
        );
        let is_known = |p: u32| self.matching.is_known(p);
        let seeds = if is_known(a) || is_known(b) {
            [NONE; SEEDS]
        } else {
            self.known_nearby(half_edge)
        };
        Gate {
            seeds,
            a: half_edges::start(faces, half_edge),
            b: half_edges::end(faces, half_edge),
            o: half_edges::apex(faces, half_edge),
            about_b: self.first_known(half_edge, half_edges::next, half_edges::start),
            about_a: self.first_known(half_edge, half_edges::previous, half_edges::end),
        }
    }

    /// Known points of visited faces near a half-edge, the nearest first.
    fn known_nearby(&self, half_edge: u32) -> [u32; SEEDS] {
        let mut seeds = [NONE; SEEDS];
        if self.matching.coarse.points() == 0 {
            return seeds;
        }
        let mut found = 0;
        let mut faces = vec![half_edge / 3];
        let mut at = 0;
        while at < faces.len() && at < FACES_REACH {
            let face = faces[at];
            at += 1;
            for k in 0..3 {
                let point = self.walked.faces[face as usize][k];
                if self.matching.is_known(point) && !seeds.contains(&point) {
                    seeds[found] = point;
                    found += 1;
                    if found == SEEDS {
                        return seeds;
                    }
                }
                let twin = self.twins[face as usize * 3 + k];
                if twin != NONE && !faces.contains(&(twin / 3)) {
                    faces.push(twin / 3);
                }
            }
        }
        seeds
    }

    /// The first known neighbour in a fan of visited faces, and the number of steps to it.
    fn first_known(
        &self,
        first: u32,
        turn: impl Fn(u32) -> u32,
        neighbour: impl Fn(&[[u32; 3]], u32) -> u32,
    ) -> Option<(u32, u8)> {
        if self.matching.coarse.points() == 0 {
            return None;
        }
        let faces = &self.walked.faces;
        let mut half_edge = first;
        for steps in 0..FAN_REACH {
            let point = neighbour(faces, half_edge);
            if self.matching.is_known(point) {
                return Some((point, steps));
            }
            // The other edge of the face at the same end; its far end comes next.
            let other = turn(half_edge);
            let far = half_edges::apex(faces, half_edge);
            if self.matching.is_known(far) {
                return Some((far, steps + 1));
            }
            half_edge = self.twins[other as usize];
            if half_edge == NONE || half_edge == first {
                return None;
            }
        }
        None
    }
}

/// Maximum number of faces near a gate that are searched for known points.
const FACES_REACH: usize = 40;

/// Maximum number of faces of a fan that are searched for a known point.
const FAN_REACH: u8 = 12;

/// Surroundings of the first face of a component before its corner `k`, 1 or 2.
fn seed_gate(points: [u32; 3], k: usize, is_known: impl Fn(u32) -> bool) -> Gate {
    let known = |p: u32| is_known(p).then_some((p, 0));
    let mut gate = Gate {
        a: points[k - 1],
        b: points[0],
        o: NONE,
        seeds: [NONE; SEEDS],
        about_a: None,
        about_b: None,
    };
    if k == 2 {
        gate.about_b = known(points[1]);
        gate.about_a = known(points[0]);
    }
    gate
}
