//! Options of mesh levels as those of the builder, for one character.

use super::{KeptFace, MeshLevelOptions};
use crate::error::{Context, Error, Result};
use articula_build::MeshLevelOptions as BuildOptions;
use articula_build::{DistanceOptions, SimplifyOptions, region_weights, skin_regions};
use articula_core::{Mesh, Part, Rig, Zone};

impl MeshLevelOptions {
    /// Converts to the builder's options for one character. `classes` distinguishes vertices whose
    /// attributes in a [`Mesh`] are equal.
    pub(super) fn of(
        &self,
        mesh: &Mesh,
        rig: &Rig,
        classes: Vec<u32>,
        face: Option<&KeptFace>,
    ) -> Result<BuildOptions> {
        let factors = self.region_weights.iter().map(|(r, x)| (r.as_str(), *x));
        let factors: Vec<(&str, f32)> = factors.collect();
        let vertex_weights = match factors.is_empty() {
            true => Vec::new(),
            false => region_weights(mesh, rig, &factors).context("region weights")?,
        };
        let mut locked = self.locked(mesh)?;
        locked.extend(face.iter().flat_map(|face| &face.vertices));
        let simplify = SimplifyOptions {
            targets: self.targets.clone(),
            weighting: self.weighting,
            vertex_weights,
            extents: face.map_or_else(Vec::new, |face| face.extents.clone()),
            locked,
            regions: self.regions(mesh, rig),
            wedges: classes,
            ..SimplifyOptions::default()
        };
        Ok(BuildOptions {
            simplify,
            max_error: self.max_error,
            halvings: self.halvings,
            distance: DistanceOptions {
                full_every: self.full_every,
                ..DistanceOptions::default()
            },
            ..BuildOptions::default()
        })
    }

    /// Zone of each vertex: the first that contains the region of the skin that the joint with the
    /// greatest weight moves.
    fn regions(&self, mesh: &Mesh, rig: &Rig) -> Vec<u8> {
        if self.split.is_empty() {
            return Vec::new();
        }
        let of_joint = skin_regions(rig);
        let zone_of = |joint: usize| {
            let region = of_joint.get(joint);
            let has = |(_, zone): &(String, Zone)| region.is_some_and(|r| zone.contains(*r));
            self.split.iter().position(has).unwrap_or(self.split.len()) as u8
        };
        let heaviest = |v| {
            let all = mesh.influences_of(v);
            all.reduce(|a, b| if b.1 > a.1 { b } else { a })
        };
        let region = |v| heaviest(v).map_or(self.split.len() as u8, |(joint, _)| zone_of(joint));
        (0..mesh.len()).map(region).collect()
    }

    fn locked(&self, mesh: &Mesh) -> Result<Vec<u32>> {
        let mut locked = Vec::new();
        for (name, vertices) in &self.locked {
            let parts: Vec<&Part> = mesh.parts.iter().filter(|p| p.name == *name).collect();
            let Some(first) = parts.first() else {
                let mut names: Vec<&str> = mesh.parts.iter().map(|p| p.name.as_str()).collect();
                names.dedup();
                let what = format!(
                    "there is no mesh \"{name}\"; the meshes are {}",
                    names.join(", ")
                );
                return Err(Error::LockedVertices(what));
            };
            if parts.iter().any(|p| p.mesh != first.mesh) {
                let what = format!("several meshes have the name \"{name}\"; rename them");
                return Err(Error::LockedVertices(what));
            }
            // Parts of one mesh are consecutive, and vertices are numbered across them.
            let of_mesh: Vec<u32> = parts
                .iter()
                .flat_map(|p| p.vertices.clone())
                .map(|v| v as u32)
                .collect();
            for v in vertices {
                let Some(vertex) = of_mesh.get(*v as usize) else {
                    let what = format!(
                        "{name}: vertex {v} is out of range: the mesh has {} vertices",
                        of_mesh.len()
                    );
                    return Err(Error::LockedVertices(what));
                };
                locked.push(*vertex);
            }
        }
        Ok(locked)
    }
}
