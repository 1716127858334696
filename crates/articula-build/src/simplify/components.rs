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

#[cfg(test)]
mod tests {
    use super::super::SimplifyOptions;
    use super::super::shapes::mesh;
    use super::super::test_surface::TestSurface;
    use super::*;

    /// Two triangles that share a vertex, a small one, and a larger one, in this order but for the
    /// second triangle, which comes last. In the other pose the small one is twice as large.
    fn pieces() -> TestSurface {
        let corners = [
            [0.0, 0.0, 0.0],
            [3.0, 0.0, 0.0],
            [3.0, 4.0, 0.0],
            [9.0, 4.0, 8.0],
            [4.0, 9.0, 8.0],
        ];
        let mut positions: Vec<Vec3> = corners.map(Vec3::from_array).to_vec();
        let small = |p: &Vec3| *p * 0.2 + Vec3::new(20.0, 5.0, 1.0);
        let large = |p: &Vec3| *p * 0.4 - Vec3::new(9.0, 3.0, 2.0);
        let three: Vec<Vec3> = positions[..3].to_vec();
        positions.extend(three.iter().map(small));
        positions.extend(three.iter().map(large));
        let mut pose = positions.clone();
        for p in &mut pose[5..8] {
            *p *= 2.0;
        }
        let triangles = vec![[0, 1, 2], [5, 6, 7], [8, 9, 10], [3, 4, 2]];
        TestSurface::new(mesh(positions, triangles), &[pose])
    }

    #[test]
    fn faces_that_share_a_vertex_are_one_component() {
        let of = pieces();
        let costs = of.costs(&SimplifyOptions::default());
        let components = Components::new(&of.surface, &costs, &[false; 11], 1e9);
        assert_eq!(components.faces(0), [0, 3]);
        assert_eq!(components.faces(1), [1]);
        assert_eq!(components.faces(2), [2]);
        assert_eq!(components.tiny().count(), 3);
    }

    #[test]
    fn removed_faces_are_no_component() {
        let mut of = pieces();
        of.surface.kill(1);
        let costs = of.costs(&SimplifyOptions::default());
        let components = Components::new(&of.surface, &costs, &[false; 11], 1e9);
        assert_eq!(components.faces(0), [0, 3]);
        assert_eq!(components.faces(1), [2]);
        assert_eq!(components.tiny().count(), 2);
    }

    #[test]
    fn a_component_is_as_large_as_in_its_largest_pose() {
        let of = pieces();
        let options = SimplifyOptions {
            vertex_weights: (0..11).map(|v| if v == 6 { 3.0 } else { 1.0 }).collect(),
            ..SimplifyOptions::default()
        };
        let costs = of.costs(&options);
        let sizes = |kept: &[bool; 11], extent: f32| -> Vec<(u32, f64)> {
            Components::new(&of.surface, &costs, kept, extent)
                .tiny()
                .collect()
        };
        // Diagonals: 15.4 m, 0.2 * 5 m in one pose and twice that in the other, and 0.4 * 5 m.
        let found = sizes(&[false; 11], 7.0);
        assert_eq!(found.iter().map(|s| s.0).collect::<Vec<_>>(), [1, 2]);
        assert!((found[0].1 - 3.0 * 4.0).abs() < 1e-4 && (found[1].1 - 4.0).abs() < 1e-4);
        assert!(
            sizes(&[false; 11], 6.6).is_empty(),
            "2 m are more than 0.3 * 6.6 m"
        );
        let mut kept = [false; 11];
        kept[9] = true;
        assert_eq!(
            sizes(&kept, 1e9).iter().map(|s| s.0).collect::<Vec<_>>(),
            [0, 1]
        );
    }
}
