//! One clip beside many versions of it.

use super::posed::PosedVertices;
use super::skin::Skin;
use super::{greatest_vertex_error, times};
use articula_core::Mesh;
use articula_core::source::{Property, RawClip};
use glam::{Affine3A, Vec3A};
use std::collections::BTreeMap;

/// What rounding adds to a distance at most, of the longest position.
const ROUNDING: f32 = 1e-5;

/// A clip of a character, beside which versions of it are measured on a mesh that is stored otherwise.
///
/// The error of a version is that of [`greatest_vertex_error`], found without posing every vertex at every time: a
/// vertex is no farther than the stored mesh is in the clip itself, and than the matrices of its joints carry the
/// corners of a box around their vertices from where the clip has them. The farther of these are posed.
///
/// Source: ours; `docs/methods/optimize.md`.
#[derive(Debug, Clone)]
pub struct ReferenceClip<'a> {
    clip: &'a RawClip,
    wanted: PosedVertices<'a>,
    shown: PosedVertices<'a>,
    seed: u64,
    /// `None` where vertices move by themselves, so that no box bounds them.
    bounds: Option<Bounds>,
}

#[derive(Debug, Clone)]
struct Bounds {
    groups: Vec<Group>,
    times_secs: Vec<f32>,
    /// Vertices of the source and as they are stored.
    wanted: Skin,
    shown: Skin,
    /// Palettes of each time in turn, of the source and of the stored mesh.
    wanted_palettes: Vec<Affine3A>,
    shown_palettes: Vec<Affine3A>,
    /// Errors of the stored mesh in the clip itself, of each group at each time in turn.
    rounding: Vec<f32>,
    slack: f32,
}

/// Vertices that follow one joint most.
#[derive(Debug, Clone, Default)]
struct Group {
    vertices: Vec<u32>,
    /// Of each binding that moves one of them.
    boxes: Vec<(usize, Box3)>,
    /// Greatest sum of the weights of a vertex.
    weight: f32,
}

#[derive(Debug, Clone, Copy)]
struct Box3 {
    low: Vec3A,
    high: Vec3A,
}

impl<'a> ReferenceClip<'a> {
    /// Poses the clip on a character, and on its mesh as it is stored, whose vertices have the same order. Times are
    /// those of [`greatest_vertex_error`].
    pub fn new(
        wanted: &PosedVertices<'a>,
        shown: &PosedVertices<'a>,
        clip: &'a RawClip,
        seed: u64,
    ) -> Self {
        let (mut wanted, mut shown) = (wanted.clone(), shown.clone());
        let is_bounded = !moves_vertices(clip) && !wanted.mesh.is_empty();
        let bounds = is_bounded.then(|| Bounds::new((&mut wanted, &mut shown), clip, seed));
        Self {
            clip,
            wanted,
            shown,
            seed,
            bounds,
        }
    }

    /// The same clip beside versions of it on the mesh of the source, which need not pose it again.
    pub fn on_source(&self) -> Self {
        let bounds = self.bounds.as_ref();
        Self {
            clip: self.clip,
            wanted: self.wanted.clone(),
            shown: self.wanted.clone(),
            seed: self.seed,
            bounds: bounds.map(Bounds::on_source),
        }
    }

    /// The clip as the source has it.
    pub fn clip(&self) -> &'a RawClip {
        self.clip
    }

    /// About how many bytes one needs.
    pub fn bytes(wanted: &PosedVertices<'_>, shown: &PosedVertices<'_>, clip: &RawClip) -> usize {
        let matrices = wanted.mesh.bindings.len() + shown.mesh.bindings.len();
        let points = |mesh: &Mesh| mesh.len() * (size_of::<Vec3A>() + 4 + 8 * mesh.influences);
        times(clip, 0).len() * matrices * size_of::<Affine3A>()
            + points(&wanted.mesh)
            + points(&shown.mesh)
    }

    /// Greatest error of the stored mesh in the clip itself, in metres.
    pub fn rounding(&self) -> f32 {
        match &self.bounds {
            Some(bounds) => bounds.rounding.iter().copied().fold(0.0, f32::max),
            None => self.of_all_vertices(self.clip),
        }
    }

    /// Greatest distance of any vertex in metres, where a version of the clip moves the stored mesh.
    pub fn greatest_error(&self, version: &RawClip) -> f32 {
        match &self.bounds {
            Some(bounds) if !moves_vertices(version) => {
                bounds.greatest_error(&mut self.shown.clone(), version)
            }
            _ => self.of_all_vertices(version),
        }
    }

    fn of_all_vertices(&self, version: &RawClip) -> f32 {
        let (mut wanted, mut shown) = (self.wanted.clone(), self.shown.clone());
        let wanted = (&mut wanted, Some(self.clip));
        greatest_vertex_error(wanted, (&mut shown, Some(version)), self.seed)
    }
}

fn moves_vertices(clip: &RawClip) -> bool {
    clip.channels
        .iter()
        .any(|channel| channel.property == Property::Weights)
}

impl Bounds {
    fn new(
        (from, to): (&mut PosedVertices<'_>, &mut PosedVertices<'_>),
        clip: &RawClip,
        seed: u64,
    ) -> Self {
        let (wanted, shown) = (from.blended(), to.blended());
        let wanted = Skin::new(&from.mesh, &wanted);
        let shown = Skin::new(&to.mesh, &shown);
        let lengths = wanted.points().iter().map(|p| p.length_squared());
        let longest = lengths.fold(0.0, f32::max);
        let mut bounds = Self {
            groups: groups(&shown),
            times_secs: times(clip, seed),
            wanted,
            shown,
            wanted_palettes: Vec::new(),
            shown_palettes: Vec::new(),
            rounding: Vec::new(),
            slack: ROUNDING * longest.sqrt(),
        };
        let mut sampler = from.sampler(clip);
        for secs in bounds.times_secs.clone() {
            let palette = from.palette_at(&mut sampler, secs);
            bounds.wanted_palettes.extend_from_slice(palette);
            let palette = to.palette_as(from, clip);
            bounds.shown_palettes.extend_from_slice(palette);
            for group in &bounds.groups {
                let squared = bounds.squared_error(&group.vertices, [&from.palette, &to.palette]);
                bounds.rounding.push(squared.sqrt());
            }
        }
        bounds
    }

    fn on_source(&self) -> Self {
        let groups = groups(&self.wanted);
        Self {
            rounding: vec![0.0; groups.len() * self.times_secs.len()],
            groups,
            times_secs: self.times_secs.clone(),
            wanted: self.wanted.clone(),
            shown: self.wanted.clone(),
            wanted_palettes: self.wanted_palettes.clone(),
            shown_palettes: self.wanted_palettes.clone(),
            slack: self.slack,
        }
    }

    fn greatest_error(&self, shown: &mut PosedVertices<'_>, version: &RawClip) -> f32 {
        let count = shown.mesh.bindings.len();
        let mut palettes = Vec::with_capacity(self.shown_palettes.len());
        let mut most = Vec::with_capacity(self.rounding.len());
        let mut sampler = shown.sampler(version);
        for (time, secs) in self.times_secs.iter().enumerate() {
            let palette = shown.palette_at(&mut sampler, *secs);
            let reference = &self.shown_palettes[time * count..][..count];
            for (g, group) in self.groups.iter().enumerate() {
                let rounding = self.rounding[time * self.groups.len() + g];
                most.push((rounding + group.moved(palette, reference), time, g));
            }
            palettes.extend_from_slice(palette);
        }
        let of_wanted = self.wanted_palettes.len() / self.times_secs.len();
        let error = |(_, time, g): &(f32, usize, usize)| {
            let from = &self.wanted_palettes[time * of_wanted..][..of_wanted];
            let to = &palettes[time * count..][..count];
            self.squared_error(&self.groups[*g].vertices, [from, to])
        };
        let may_exceed = |of: &(f32, usize, usize), worst: f32| (of.0 + self.slack).powi(2) > worst;
        // One that is far leaves few that may be farther.
        let first = most.iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let mut worst = first.map_or(0.0, error);
        most.retain(|of| may_exceed(of, worst));
        most.sort_by(|a, b| b.0.total_cmp(&a.0));
        for of in most {
            if !may_exceed(&of, worst) {
                break;
            }
            worst = worst.max(error(&of));
        }
        worst.sqrt()
    }

    /// Greatest squared distance of some vertices between both meshes, each with a palette.
    fn squared_error(&self, vertices: &[u32], [from, to]: [&[Affine3A]; 2]) -> f32 {
        let squares = vertices.iter().map(|v| {
            let v = *v as usize;
            let wanted = self.wanted.at(v, from);
            wanted.distance_squared(self.shown.at(v, to))
        });
        squares.fold(0.0, f32::max)
    }
}

/// The vertices of a mesh by the binding that they follow most.
fn groups(skin: &Skin) -> Vec<Group> {
    let mut groups: BTreeMap<u16, Group> = BTreeMap::new();
    for (v, point) in skin.points().iter().enumerate() {
        let influences = skin.influences(v);
        let most = influences.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        let group = groups.entry(most.map_or(0, |most| most.0)).or_default();
        group.vertices.push(v as u32);
        group.weight = group.weight.max(influences.iter().map(|(_, w)| w).sum());
        for (binding, _) in influences {
            group.include(usize::from(*binding), *point);
        }
    }
    groups.into_values().collect()
}

impl Group {
    fn include(&mut self, binding: usize, point: Vec3A) {
        match self.boxes.iter_mut().find(|(b, _)| *b == binding) {
            Some((_, found)) => {
                found.low = found.low.min(point);
                found.high = found.high.max(point);
            }
            None => {
                let found = Box3 {
                    low: point,
                    high: point,
                };
                self.boxes.push((binding, found));
            }
        }
    }

    /// How far any of the vertices is at most between two palettes.
    fn moved(&self, palette: &[Affine3A], reference: &[Affine3A]) -> f32 {
        let far = |(binding, of): &(usize, Box3)| {
            of.farthest_squared(&palette[*binding], &reference[*binding])
        };
        let squared = self.boxes.iter().map(far).fold(0.0, f32::max);
        self.weight * squared.sqrt()
    }
}

impl Box3 {
    /// The greatest squared distance of a point of the box between two transforms: that of a corner, since it is convex.
    fn farthest_squared(&self, a: &Affine3A, b: &Affine3A) -> f32 {
        let axes = a.matrix3 - b.matrix3;
        let size = self.high - self.low;
        let low = axes * self.low + (a.translation - b.translation);
        let [x, y, z] = [
            size.x * axes.x_axis,
            size.y * axes.y_axis,
            size.z * axes.z_axis,
        ];
        let face = [low, low + x, low + y, low + x + y];
        let squares = face.iter().map(|corner| {
            let opposite = *corner + z;
            corner.length_squared().max(opposite.length_squared())
        });
        squares.fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::Transform;
    use articula_core::source::{
        Channel, Character, Interpolation, Joint, Primitive, RawMesh, Skeleton, Skin,
    };
    use glam::{Quat, Vec3};
    use proptest::prelude::*;

    const JOINTS: usize = 3;

    fn skeleton() -> Skeleton {
        let joints = (0..JOINTS).map(|j| Joint {
            name: format!("joint {j}"),
            parent: j.checked_sub(1),
            rest: Transform::from_translation(Vec3::Y * 0.4),
            in_skin: true,
        });
        Skeleton {
            joints: joints.collect(),
        }
    }

    /// Vertices of two joints each, and their places moved by rounding.
    fn character(points: &[(Vec3, usize, f32)], step: f32) -> Character {
        let round = |at: f32| {
            if step > 0.0 {
                (at / step).round() * step
            } else {
                at
            }
        };
        let positions = points.iter().map(|(p, ..)| p.to_array().map(round).into());
        let joints = points
            .iter()
            .flat_map(|(_, j, _)| [*j as u16, (*j as u16 + 1) % 3]);
        let weights = points.iter().map(|(.., w)| round(*w));
        let primitive = Primitive {
            positions: positions.collect(),
            normals: vec![Vec3::Z; points.len()],
            influences: 2,
            joints: joints.collect(),
            weights: weights.flat_map(|w| [w, 1.0 - w]).collect(),
            triangles: vec![[0, 1, 2]],
            ..Primitive::default()
        };
        let bind = |j: usize| Affine3A::from_translation(Vec3::Y * -0.4 * (j + 1) as f32);
        Character {
            skeleton: skeleton(),
            meshes: vec![RawMesh {
                name: "tube".into(),
                skin: Skin {
                    joints: (0..JOINTS).collect(),
                    inverse_bind: (0..JOINTS).map(bind).collect(),
                },
                primitives: vec![primitive],
                ..RawMesh::default()
            }],
            ..Character::default()
        }
    }

    fn clip(turns: &[[f32; 3]]) -> RawClip {
        let channel = |j: usize| Channel {
            target: j,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: (0..turns.len()).map(|k| k as f32).collect(),
            values: turns
                .iter()
                .flat_map(|turn| {
                    let axis = [Vec3::X, Vec3::Z, Vec3::Y][j];
                    Quat::from_axis_angle(axis, turn[j]).to_array()
                })
                .collect(),
        };
        RawClip {
            name: "turns".into(),
            duration_secs: (turns.len() - 1) as f32,
            channels: (0..JOINTS).map(channel).collect(),
        }
    }

    fn points() -> impl Strategy<Value = Vec<(Vec3, usize, f32)>> {
        let point = (prop::array::uniform3(-1.0f32..1.0), 0..JOINTS, 0.0f32..1.0);
        proptest::collection::vec(point.prop_map(|(p, j, w)| (p.into(), j, w)), 3..40)
    }

    proptest! {
        #[test]
        fn the_error_is_that_of_all_vertices_at_all_times(
            points in points(),
            turns in proptest::collection::vec(prop::array::uniform3(-2.0f32..2.0), 2..6),
            off in prop::array::uniform3(-0.1f32..0.1),
            step in prop_oneof![Just(0.0f32), 0.001f32..0.1],
            seed in 0u64..9,
        ) {
            let (source, stored) = (character(&points, 0.0), character(&points, step));
            let [wanted, shown] = [&source, &stored].map(|c| PosedVertices::new(c).unwrap());
            let others: Vec<[f32; 3]> = turns
                .iter()
                .map(|turn| std::array::from_fn(|i| turn[i] + off[i]))
                .collect();
            let clip_of_source = clip(&turns);
            let reference = ReferenceClip::new(&wanted, &shown, &clip_of_source, seed);
            for version in [clip(&others), clip_of_source.clone()] {
                let expected = greatest_vertex_error(
                    (&mut wanted.clone(), Some(&clip_of_source)),
                    (&mut shown.clone(), Some(&version)),
                    seed,
                );
                prop_assert_eq!(reference.greatest_error(&version), expected);
                let on_source = greatest_vertex_error(
                    (&mut wanted.clone(), Some(&clip_of_source)),
                    (&mut wanted.clone(), Some(&version)),
                    seed,
                );
                prop_assert_eq!(reference.on_source().greatest_error(&version), on_source);
            }
        }
    }
}
