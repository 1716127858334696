//! Connected components of a surface, such as buttons: small ones may be removed as a whole.

use super::cost::Costs;
use super::topology::Surface;
use glam::Vec3;

/// Diagonal, relative to the extent of the mesh, above which a component is never removed: a leg or
/// a torso keeps a closed form of a few triangles. A lower value leaves too few triangles for the
/// large components of faces with eyes and teeth.
const TINY: f32 = 0.3;

/// Components connected by position classes.
#[derive(Debug, Default)]
pub(super) struct Components {
    /// Faces, component by component.
    faces: Vec<u32>,
    /// Start of each component in `faces`, and the end.
    starts: Vec<u32>,
    /// Maximum squared diagonal over all poses, times the largest weight of the vertices.
    sizes: Vec<f64>,
}

impl Components {
    /// Finds the components of a surface. One with a class of `kept` is never removed.
    pub(super) fn new(surface: &Surface, costs: &Costs, kept: &[bool], extent: f32) -> Self {
        let (of_face, count) = labels(surface, kept.len());
        let mut components = Self {
            starts: vec![0; count + 1],
            sizes: vec![f64::INFINITY; count],
            ..Self::default()
        };
        for label in of_face.iter().flatten() {
            components.starts[*label as usize + 1] += 1;
        }
        for c in 0..count {
            components.starts[c + 1] += components.starts[c];
        }
        let mut next = components.starts.clone();
        components.faces = vec![0; components.starts[count] as usize];
        for (face, label) in of_face.iter().enumerate() {
            if let Some(label) = label {
                let at = &mut next[*label as usize];
                components.faces[*at as usize] = face as u32;
                *at += 1;
            }
        }
        for c in 0..count {
            components.sizes[c] = components.size(c, surface, costs, kept, extent);
        }
        components
    }

    /// Faces of a component, including removed ones.
    pub(super) fn faces(&self, component: u32) -> &[u32] {
        let at = component as usize;
        &self.faces[self.starts[at] as usize..self.starts[at + 1] as usize]
    }

    /// Components that may be removed, with their squared sizes.
    pub(super) fn tiny(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        let sizes = self.sizes.iter().enumerate();
        sizes
            .filter(|(_, size)| size.is_finite())
            .map(|(c, size)| (c as u32, *size))
    }

    fn size(
        &self,
        component: usize,
        surface: &Surface,
        costs: &Costs,
        kept: &[bool],
        extent: f32,
    ) -> f64 {
        let faces = self.faces(component as u32);
        let classes = || faces.iter().flat_map(|f| surface.faces[*f as usize]);
        if classes().any(|c| kept[c as usize]) {
            return f64::INFINITY;
        }
        let factor = classes().map(|c| costs.factor(c)).fold(0.0, f32::max);
        let mut most = 0.0f32;
        for pose in 0..costs.poses() {
            let points = classes().map(|c| costs.points(c)[pose]);
            let all = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            let (lo, hi) = points.fold(all, |(lo, hi), p| (lo.min(p), hi.max(p)));
            most = most.max((hi - lo).length());
        }
        if most > TINY * extent {
            return f64::INFINITY;
        }
        f64::from(most) * f64::from(most) * f64::from(factor)
    }
}

/// Component of each live face, numbered in the order of first faces, and the number of components.
fn labels(surface: &Surface, classes: usize) -> (Vec<Option<u32>>, usize) {
    let mut parent: Vec<u32> = (0..classes as u32).collect();
    for (f, [a, b, c]) in surface.faces.iter().enumerate() {
        if surface.is_alive(f) {
            for other in [*b, *c] {
                let (i, j) = (root(&mut parent, *a), root(&mut parent, other));
                parent[i.max(j) as usize] = i.min(j);
            }
        }
    }
    let mut numbers = vec![u32::MAX; classes];
    let mut count = 0;
    let mut label = |(f, face): (usize, &[u32; 3])| {
        if !surface.is_alive(f) {
            return None;
        }
        let number = &mut numbers[root(&mut parent, face[0]) as usize];
        if *number == u32::MAX {
            *number = count;
            count += 1;
        }
        Some(*number)
    };
    let of_face = surface.faces.iter().enumerate().map(&mut label).collect();
    (of_face, count as usize)
}

fn root(parent: &mut [u32], mut v: u32) -> u32 {
    while parent[v as usize] != v {
        parent[v as usize] = parent[parent[v as usize] as usize];
        v = parent[v as usize];
    }
    v
}
