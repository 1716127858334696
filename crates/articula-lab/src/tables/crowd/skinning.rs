//! Skinning on the CPU: time per vertex by influence count, beside the time of the pose.

use super::frame_order::Access;
use super::{Bench, CrowdTables, Line};
use crate::measure::{Contestant, race};
use anyhow::Result;
use articula_core::{
    GroupedSkin, Mesh, ModelPose, SkinnedMesh, Wrap, local_to_model, palette, sample, skin,
};
use glam::Affine3A;
use std::hint::black_box;

/// Maximum numbers of influences of a vertex.
const INFLUENCES: [usize; 3] = [1, 2, 4];

/// Number of characters: skinning costs as much as sixty poses.
const COUNT: usize = 40;

/// Skinning of vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SkinningMethod {
    /// No skinning.
    PoseAlone,
    Plain,
    /// Grouped by influence count.
    Grouped,
}

/// Adds the section.
pub(super) fn add(bench: &Bench, report: &mut CrowdTables) -> Result<()> {
    let meshes = INFLUENCES.map(|most| strongest(&bench.asset.mesh, most));
    let mut names = vec!["pose and palette alone".to_owned()];
    let mut contestants = vec![follower(bench, &meshes[2], SkinningMethod::PoseAlone)];
    for (way, what) in [
        (SkinningMethod::Plain, "plain"),
        (SkinningMethod::Grouped, "grouped"),
    ] {
        for (most, mesh) in INFLUENCES.iter().zip(&meshes) {
            names.push(format!("with skin, {what}, influences up to {most}"));
            contestants.push(follower(bench, mesh, way));
        }
    }
    let times = Access::Forward.frames(bench, COUNT, 2);
    let timings = race(&mut contestants, &times, bench.rounds());
    let vertices = bench.asset.mesh.len();
    report.heading(
        "Pose with and without skinning",
        &format!(
            "Poses by the plain path; {vertices} vertices, positions and normals, one by one (plain) or grouped by \
             influence count; vertices keep their strongest influences. Microseconds per \
             character and frame."
        ),
    );
    report.head(&["what", "µs", "ns per vertex"]);
    let pose = timings[0];
    for (name, timing) in names.iter().zip(&timings) {
        let vertex = (timing.median_ns - pose.median_ns) / vertices as f64;
        report.row(&[
            name.clone(),
            format!(
                "{:.1} ({:.1})",
                1e-3 * timing.median_ns,
                1e-3 * timing.least_ns
            ),
            if vertex == 0.0 {
                "–".to_owned()
            } else {
                format!("{vertex:.2}")
            },
        ]);
        report.line(&Line {
            section: "skinning",
            who: "ours",
            count: COUNT,
            variant: &name.replace(',', ";"),
            timing: *timing,
            floor_ns: pose.median_ns,
        });
    }
    Ok(())
}

/// A contestant that poses every character, and skins it by a method.
fn follower<'a>(bench: &'a Bench, mesh: &'a Mesh, way: SkinningMethod) -> Contestant<'a> {
    let (rig, clip) = (&bench.asset.rig, bench.clip());
    let all = rig.all();
    let mut local = rig.rest_pose().clone();
    let mut model = ModelPose::new(rig.len());
    let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
    let mut matrix_rows = vec![[[0.0; 4]; 3]; mesh.bindings.len()];
    let grouped = GroupedSkin::new(mesh);
    let mut out = SkinnedMesh::new(mesh);
    let frame = move |secs: &[f32]| {
        for secs in secs {
            sample(clip, f64::from(*secs), Wrap::Clamp, &all, &mut local);
            local_to_model(rig, &local, &mut model);
            palette(mesh, &model, &mut matrices);
            match way {
                SkinningMethod::PoseAlone => {}
                SkinningMethod::Plain => skin(mesh, &matrices, &mesh.morph_weights, &mut out),
                SkinningMethod::Grouped => {
                    GroupedSkin::rows(&matrices, &mut matrix_rows);
                    grouped.skin(grouped.rest(), &matrix_rows, &mut out);
                }
            }
            black_box((&mut matrices, &mut out));
        }
    };
    Contestant {
        name: "ours".to_owned(),
        frame: Box::new(frame),
    }
}

/// The mesh with the strongest influences of each vertex, at most `most`, normalised to sum 1.
fn strongest(mesh: &Mesh, most: usize) -> Mesh {
    let mut reduced = Mesh {
        influences: most,
        binding_indices: Vec::with_capacity(mesh.len() * most),
        weights: Vec::with_capacity(mesh.len() * most),
        ..mesh.clone()
    };
    for vertex in 0..mesh.len() {
        let at = vertex * mesh.influences..(vertex + 1) * mesh.influences;
        let mut pairs: Vec<(f32, u16)> = mesh.weights[at.clone()]
            .iter()
            .copied()
            .zip(mesh.binding_indices[at].iter().copied())
            .collect();
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        pairs.resize(most, (0.0, 0));
        let sum: f32 = pairs.iter().map(|p| p.0).sum();
        let whole = if sum > 0.0 { sum } else { 1.0 };
        reduced.weights.extend(pairs.iter().map(|p| p.0 / whole));
        reduced.binding_indices.extend(pairs.iter().map(|p| p.1));
    }
    reduced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_strongest_influences_stay_and_sum_to_one() {
        let mesh = Mesh {
            positions: vec![glam::Vec3::ZERO; 2],
            influences: 3,
            binding_indices: vec![7, 8, 9, 1, 2, 3],
            weights: vec![0.2, 0.5, 0.3, 1.0, 0.0, 0.0],
            ..Mesh::default()
        };
        let two = strongest(&mesh, 2);
        assert_eq!(two.binding_indices, [8, 9, 1, 2]);
        assert_eq!(two.weights, [0.625, 0.375, 1.0, 0.0]);
        let four = strongest(&mesh, 4);
        assert_eq!(four.weights[..4], [0.5, 0.3, 0.2, 0.0]);
    }
}
