//! Mesh simplification for animated characters: chained levels over the original vertices.
//!
//! Half-edge collapses, cheapest first: a vertex moves onto a neighbour, so no new position is made
//! and the vertices of a level are a subset of those of every finer level. The cost of a collapse
//! is the quadric error summed over poses plus the maximum distance, over all poses, of removed
//! vertices. Collapses act on position classes over all parts of a character, and attributes are
//! kept by wedges. Vertices that morph targets move weigh more.
//!
//! Source: Garland and Heckbert (1997) for quadrics; Mohr and Gleicher, *Deformation Sensitive
//! Decimation* (2003), and DeCoro and Rusinkiewicz, *Pose-independent Simplification of Articulated
//! Meshes* (2005), for their sum over poses; thesis 3.1.2 for levels of one mesh and the weight of
//! joints; `docs/methods/clustered-mesh.md` parts 5, 6 and 9.

mod classes;
mod collapse;
mod components;
mod cost;
mod levels;
mod quadric;
mod region_weights;
mod removed_vertices;
mod ring;
#[cfg(test)]
#[path = "../../tests/it/simplify/shapes.rs"]
mod shapes;
#[cfg(test)]
mod test_surface;
mod topology;
mod wedges;

pub(crate) use classes::extent;
pub use region_weights::{region_weights, skin_regions, vertex_regions};

use articula_core::{Libm, Mesh, Mismatch};
use glam::Vec3;
use std::collections::BTreeSet;
use std::ops::Range;

/// Selects the poses whose errors count, and the weights of the errors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ErrorWeighting {
    /// Sum of the errors over all poses.
    #[default]
    PoseSummed,
    /// Error in the rest pose only.
    Rest,
    /// Error in the rest pose, weighted more near joints (the thesis' level of animation): the
    /// factor is 1 + `strength` (1 - largest skin weight of the vertex).
    Joint {
        /// Additional weight at a vertex without a dominant joint.
        strength: f32,
    },
}

/// Options of [`simplify`].
#[derive(Debug, Clone, PartialEq)]
pub struct SimplifyOptions {
    /// Fractions of the triangle count, finest first; the first is 1. Two triangles for each locked
    /// vertex come on top of the fraction of all others.
    pub targets: Vec<f64>,
    /// Number of levels that are noted between two targets beyond the second, evenly spread on a
    /// logarithmic scale. They change no other level.
    pub between: usize,
    /// Poses whose errors count.
    pub weighting: ErrorWeighting,
    /// Weight of an error at each vertex; all 1 if empty.
    pub vertex_weights: Vec<f32>,
    /// How far something other than the mesh's own morph targets moves each vertex, such as a face
    /// animation table, relative to the vertex that it moves furthest: 0 to 1. Weighs as much as a
    /// morph target would. Empty if there is nothing.
    pub extents: Vec<f32>,
    /// Vertices that are never removed, such as facial feature points.
    pub locked: Vec<u32>,
    /// Region of each vertex, or empty. Vertices between regions are removed in the last step only.
    pub regions: Vec<u8>,
    /// Class of each vertex by attributes that [`Mesh`] does not hold (tangents, further texture
    /// coordinates), or empty. Vertices of different classes are never merged into one wedge.
    pub wedges: Vec<u32>,
    /// Whether the mesh is one half of a mirrored surface that continues beyond its open border. No
    /// inner edge is then made between two vertices of the border, since four faces would meet
    /// there in the whole surface.
    pub mirrored: bool,
    /// Whether the distance of removed vertices from the remaining surface counts in addition to
    /// the quadrics. Without it, simplification is less accurate and about three times as fast:
    /// enough for the first reduction of a surface that is far finer than needed.
    pub measured: bool,
    /// Where to stop, whatever the targets are. Needs [`Self::measured`].
    pub limit: Option<SimplifyLimit>,
}

impl Default for SimplifyOptions {
    /// Five levels: 100, 50, 25, 10 and 1.5 % of the triangles, with the errors of all poses.
    fn default() -> Self {
        Self {
            targets: vec![1.0, 0.5, 0.25, 0.1, 0.015],
            between: 0,
            weighting: ErrorWeighting::PoseSummed,
            vertex_weights: Vec::new(),
            extents: Vec::new(),
            locked: Vec::new(),
            regions: Vec::new(),
            wedges: Vec::new(),
            mirrored: false,
            measured: true,
            limit: None,
        }
    }
}

/// How far a surface may be changed: no collapse goes beyond it, and no component is removed as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimplifyLimit {
    /// Greatest distance of a removed vertex, in any pose, from the faces that replaced those around it,
    /// in metres. Its square counts times the weight of the vertex.
    pub metres: f32,
    /// Greatest cost of a collapse, relative to the square of that distance. Costs are means over poses and
    /// over planes, some of them far away: 1 to 4 is usual.
    pub cost: f64,
}

/// The triangles of one level.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LevelTriangles {
    /// Triangles over the vertices of the original mesh, part by part.
    pub triangles: Vec<[u32; 3]>,
    /// Range of triangles of each part.
    pub parts: Vec<Range<usize>>,
}

/// A mesh at several levels of detail.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Simplified {
    /// Levels, from the original to the coarsest.
    ///
    /// Level 0 is the original without duplicate triangles (same corners, orientation and part) and
    /// without those that use a vertex twice; of vertices that are equal in all attributes it uses
    /// the first.
    pub levels: Vec<LevelTriangles>,
    /// Levels between them, finest first, as far as they were reached.
    pub between: Vec<LevelTriangles>,
    /// Position class of each vertex: vertices of one class stay together in all poses, even where
    /// their skins differ.
    pub position_classes: Vec<u32>,
}

/// Simplifies a mesh to all levels. `poses` are the positions of all vertices in one common space,
/// the rest pose first.
///
/// A level has more triangles than its target where no further collapse is allowed. Vertices
/// without a finite position in some pose are kept. Deterministic. O(n log n) for n triangles,
/// times poses.
///
/// # Errors
/// A [`Mismatch`] if there is no pose, a length differs from that of the mesh, an index is out of
/// range or the targets do not fall strictly from 1.
pub fn simplify(
    mesh: &Mesh,
    poses: &[Vec<Vec3>],
    options: &SimplifyOptions,
) -> Result<Simplified, Mismatch> {
    check(mesh, poses, options)?;
    let used = match options.weighting {
        ErrorWeighting::PoseSummed => poses,
        ErrorWeighting::Rest | ErrorWeighting::Joint { .. } => &poses[..1],
    };
    let classes = classes::Classes::new(mesh, poses, &options.wedges);
    let sources = levels::faces(mesh, &classes);
    let mut simplifier = collapse::Simplifier::new(mesh, used, options, &classes, &sources);
    let whole = sources.triangles.len();
    // Two triangles for each locked vertex, as a closed surface has, are not up for removal: a level
    // that had to keep them within its share would have few left for everything else.
    let class = |v: &u32| classes.of_vertex[*v as usize];
    let locked: BTreeSet<u32> = options.locked.iter().map(class).collect();
    let held = match options.limit {
        None => whole.min(2 * locked.len()),
        Some(_) => 0,
    };
    let target = |share: f64| held + (share * (whole - held) as f64).round() as usize;
    let mut found = vec![sources.level()];
    let mut between = Vec::new();
    for (step, shares) in options.targets.windows(2).enumerate() {
        let (finer, share) = (shares[0], shares[1]);
        let count = if step == 0 { 0 } else { options.between };
        let part = |k: usize| k as f64 / (count + 1) as f64;
        let on_the_way = (1..=count).map(|k| target(finer * (share / finer).libm_powf(part(k))));
        let mut notes = levels::Notes::new(&sources, on_the_way);
        simplifier.open_seams(step + 2 == options.targets.len());
        simplifier.run(target(share), &mut notes);
        between.append(&mut notes.levels);
        found.push(simplifier.level(&sources));
    }
    Ok(Simplified {
        levels: found,
        between,
        position_classes: classes.of_vertex,
    })
}

fn check(mesh: &Mesh, poses: &[Vec<Vec3>], options: &SimplifyOptions) -> Result<(), Mismatch> {
    let count = mesh.len();
    if poses.is_empty() {
        return Err(Mismatch::new(
            "poses",
            "must not be empty: the rest pose is required",
        ));
    }
    for (p, pose) in poses.iter().enumerate() {
        of_mesh(&format!("poses[{p}]"), pose.len(), count)?;
    }
    of_mesh("mesh.normals", mesh.normals.len(), count)?;
    of_mesh("mesh.texcoords", mesh.texcoords.len(), count)?;
    of_mesh("mesh.colors", mesh.colors.len(), count)?;
    let influences = count * mesh.influences;
    of_mesh("mesh.weights", mesh.weights.len(), influences)?;
    of_mesh(
        "mesh.binding_indices",
        mesh.binding_indices.len(),
        influences,
    )?;
    let optional = [
        ("vertex_weights", options.vertex_weights.len()),
        ("extents", options.extents.len()),
        ("regions", options.regions.len()),
        ("wedges", options.wedges.len()),
    ];
    for (at, length) in optional.iter().filter(|(_, length)| *length > 0) {
        of_mesh(at, *length, count)?;
    }
    let outside = |v: &u32| *v as usize >= count;
    if let Some(v) = options.locked.iter().find(|v| outside(v)) {
        return Err(Mismatch::new(
            "locked",
            format!("vertex {v} is out of range: the mesh has {count} vertices"),
        ));
    }
    if let Some(t) = mesh.triangles.iter().position(|t| t.iter().any(outside)) {
        let what = format!(
            "{:?} names a vertex out of range: the mesh has {count} vertices",
            mesh.triangles[t]
        );
        return Err(Mismatch::new(format!("mesh.triangles[{t}]"), what));
    }
    check_nested(mesh, count)?;
    let falls = options
        .targets
        .windows(2)
        .all(|w| w[0] > w[1] && w[1] >= 0.0);
    if options.targets.first() != Some(&1.0) || !falls {
        let what = format!(
            "{:?} must begin at 1, fall strictly and stay at least 0",
            options.targets
        );
        return Err(Mismatch::new("targets", what));
    }
    Ok(())
}

/// Checks that parts, bindings and morph targets are valid for the mesh.
fn check_nested(mesh: &Mesh, count: usize) -> Result<(), Mismatch> {
    let bindings = mesh.bindings.len();
    if let Some(b) = mesh
        .binding_indices
        .iter()
        .find(|b| usize::from(**b) >= bindings)
    {
        let what = format!("binding {b} is out of range: the mesh has {bindings} bindings");
        return Err(Mismatch::new("mesh.binding_indices", what));
    }
    for (m, morph) in mesh.morphs.iter().enumerate() {
        let at = format!("mesh.morphs[{m}]");
        of_mesh(&at, morph.positions.len(), morph.vertices.len())?;
        of_mesh(&at, morph.normals.len(), morph.vertices.len())?;
        if let Some(v) = morph.vertices.iter().find(|v| **v as usize >= count) {
            return Err(Mismatch::new(
                at,
                format!("vertex {v} is out of range: the mesh has {count} vertices"),
            ));
        }
    }
    let mut triangles = 0;
    for (p, part) in mesh.parts.iter().enumerate() {
        let inside = part.vertices.start <= part.vertices.end && part.vertices.end <= count;
        if !inside || part.triangles.start != triangles || part.triangles.end < triangles {
            let what = format!("{:?}, {:?}", part.vertices, part.triangles);
            return Err(Mismatch::new(format!("mesh.parts[{p}]"), what));
        }
        triangles = part.triangles.end;
    }
    of_mesh("mesh.parts", triangles, mesh.triangles.len())
}

fn of_mesh(at: &str, found: usize, expected: usize) -> Result<(), Mismatch> {
    if found == expected {
        return Ok(());
    }
    let what = format!("{found} values, expected {expected}");
    Err(Mismatch::new(at, what))
}
