//! Joint influences on the points of the skin.
//!
//! Source: ISO/IEC 19774-1, 6.3 (`skinCoordIndex`, `skinCoordWeight`).

use super::fields::Reader;
use super::figure::Figure;
use super::scene::NodeId;
use crate::error::ReadError;
use crate::limits::Limits;
use articula_core::source::Primitive;

/// Maximum deviation of a point's weight sum from 1 that is not reported.
const ODD_SUM: f32 = 1e-2;

/// Joint and weight of each point, grouped by point.
#[derive(Debug)]
pub(super) struct Influences {
    of_point: Vec<Vec<(u16, f32)>>,
}

impl Influences {
    /// Collects the influences of all joints; weights are scaled to sum to 1.
    pub(super) fn read(
        reader: &mut Reader<'_>,
        figure: &Figure,
        points: usize,
    ) -> Result<Self, ReadError> {
        let at = reader.scene.at(figure.id);
        // A vertex stores its joint with 16 bits.
        Limits::check(&at, "joints of a skin", figure.joints.len() as u64, 1 << 16)?;
        reader.charge(figure.id, 8 * points)?;
        let mut of_point: Vec<Vec<(u16, f32)>> = vec![Vec::new(); points];
        let mut beyond = 0;
        for (joint, own) in figure.joints.iter().enumerate() {
            let indices = reader.indices(own.id, "skinCoordIndex")?;
            let weights = reader.numbers(own.id, "skinCoordWeight")?;
            if weights.len() != indices.len() {
                let what = format!(
                    "{} skin points and {} weights; missing weights are read as 1",
                    indices.len(),
                    weights.len()
                );
                reader.warn(own.id, what);
            }
            reader.charge(own.id, 4 * indices.len())?;
            for (i, index) in indices.iter().enumerate() {
                let weight = weights.get(i).map_or(1.0, |w| w.max(0.0)) as f32;
                let known = usize::try_from(*index)
                    .ok()
                    .and_then(|p| of_point.get_mut(p));
                let Some(list) = known else {
                    beyond += 1;
                    continue;
                };
                match list.last_mut() {
                    Some((last, sum)) if usize::from(*last) == joint => *sum += weight,
                    _ if weight > 0.0 => list.push((joint as u16, weight)),
                    _ => {}
                }
            }
        }
        if beyond > 0 {
            let what = format!("{beyond} point indices of joints are out of range; left out");
            reader.warn(figure.id, what);
        }
        let mut influences = Self { of_point };
        influences.normalise(reader, figure.id);
        Ok(influences)
    }

    fn normalise(&mut self, reader: &mut Reader<'_>, id: NodeId) {
        let (mut alone, mut odd) = (0, 0);
        for list in &mut self.of_point {
            let sum: f32 = list.iter().map(|(_, weight)| weight).sum();
            if sum < 1e-6 {
                alone += 1;
                *list = vec![(0, 1.0)];
                continue;
            }
            odd += usize::from((sum - 1.0).abs() > ODD_SUM);
            list.iter_mut().for_each(|(_, weight)| *weight /= sum);
        }
        if alone > 0 {
            let what = format!("{alone} skin points have no joint; bound to the root");
            reader.warn(id, what);
        }
        if odd > 0 {
            let what = format!("the weights of {odd} points do not sum to 1; normalised");
            reader.warn(id, what);
        }
    }

    /// Writes the influences of a primitive's vertices; without skin points all follow the first
    /// joint.
    pub(super) fn apply(
        &self,
        reader: &mut Reader<'_>,
        id: NodeId,
        point_of_vertex: Option<&[u32]>,
        primitive: &mut Primitive,
    ) -> Result<(), ReadError> {
        let root = [(0, 1.0)];
        let vertices = primitive.positions.len();
        let of = |vertex: usize| -> &[(u16, f32)] {
            let point = point_of_vertex.map(|points| points[vertex] as usize);
            let list = point.and_then(|p| self.of_point.get(p));
            list.map_or(&root[..], Vec::as_slice)
        };
        let most = (0..vertices).map(|v| of(v).len()).max().unwrap_or(1);
        reader.charge(id, vertices.saturating_mul(2 * most))?;
        for vertex in 0..vertices {
            let list = of(vertex);
            for slot in 0..most {
                let (joint, weight) = list.get(slot).copied().unwrap_or((0, 0.0));
                primitive.joints.push(joint);
                primitive.weights.push(weight);
            }
        }
        primitive.influences = most;
        Ok(())
    }
}
