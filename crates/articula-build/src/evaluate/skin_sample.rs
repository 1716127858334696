//! The vertices on which errors are measured, posed with the morph targets of the clip.

use crate::character::Asset;
use crate::part_mesh::part_mesh;
use crate::points::draw_vertices;
use crate::simplify::vertex_regions;
use articula_core::{LocalPose, Mesh, PosedMesh, Region, Rig, SkinnedMesh};
use glam::Vec3;
use std::borrow::Cow;

/// Vertices of a mesh; for a character without mesh, its joints.
#[derive(Debug, Clone)]
pub(super) struct SkinSample<'a> {
    mesh: Cow<'a, Mesh>,
}

impl<'a> SkinSample<'a> {
    /// Draws about `count` vertices, from each body region in proportion to its number of vertices
    /// and at least one.
    pub(super) fn draw(asset: &Asset, count: usize, seed: u64) -> Self {
        let regions = vertex_regions(&asset.mesh, &asset.rig);
        let vertices = stratified(&regions, count, seed);
        Self {
            mesh: Cow::Owned(part_mesh(&asset.mesh, &vertices)),
        }
    }

    /// All vertices.
    pub(super) fn whole(asset: &'a Asset) -> Self {
        Self {
            mesh: Cow::Borrowed(&asset.mesh),
        }
    }

    /// Model-space positions under a local pose and weights of all morph targets, if the clip has
    /// any.
    pub(super) fn posed(&self, rig: &Rig, pose: &LocalPose, morphs: Option<&[f32]>) -> Vec<Vec3> {
        let mut posed = PosedMesh::new(rig, &self.mesh);
        posed.pose(pose);
        if self.mesh.is_empty() {
            return (0..rig.len()).map(|j| posed.model.position(j)).collect();
        }
        if let Some(weights) = morphs {
            let mut out = SkinnedMesh::new(&self.mesh);
            posed.skin(weights, &mut out);
            return out.positions;
        }
        let mut out = vec![Vec3::ZERO; self.mesh.len()];
        let all: Vec<u32> = (0..self.mesh.len() as u32).collect();
        posed.points(&all, &mut out);
        out
    }
}

/// Indices of about `count` vertices, ascending.
fn stratified(regions: &[Region], count: usize, seed: u64) -> Vec<u32> {
    let total = regions.len();
    let mut chosen = Vec::with_capacity(count);
    for (r, region) in Region::ALL.iter().enumerate() {
        let own = regions.iter().enumerate().filter(|(_, of)| *of == region);
        let own: Vec<u32> = own.map(|(v, _)| v as u32).collect();
        if own.is_empty() {
            continue;
        }
        let share = (count as f64 * own.len() as f64 / total as f64).round() as usize;
        let drawn = draw_vertices(own.len(), share.max(1), seed.wrapping_add(r as u64));
        chosen.extend(drawn.iter().map(|i| own[*i as usize]));
    }
    chosen.sort_unstable();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_region_is_drawn_in_proportion() {
        let mut regions = vec![Region::Torso; 900];
        regions.extend([Region::Hands; 99]);
        regions.push(Region::Feet);
        let drawn = stratified(&regions, 100, 1);
        let of = |region| {
            drawn
                .iter()
                .filter(|v| regions[**v as usize] == region)
                .count()
        };
        assert_eq!(
            (of(Region::Torso), of(Region::Hands), of(Region::Feet)),
            (90, 10, 1)
        );
        assert!(drawn.is_sorted_by(|a, b| a < b));
        assert_ne!(drawn, stratified(&regions, 100, 2));
        assert_eq!(stratified(&regions, 5000, 1).len(), 1000);
    }
}
