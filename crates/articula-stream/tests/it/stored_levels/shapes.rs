//! Meshes made by whole-number arithmetic, the same on every platform: a figure with all kinds of
//! values, and faces without any order.

use articula_stream::mesh::{Layout, QuantisedMesh};
use std::collections::{BTreeMap, BTreeSet};

/// A point with all its values.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Point {
    position: [i32; 3],
    skin: Vec<(u16, u8)>,
    morphs: Vec<[i32; 3]>,
}

/// A wedge with all its values.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Wedge {
    point: Point,
    normal: [i32; 2],
    texcoord: [i32; 2],
    color: [u8; 4],
    turns: Vec<[i32; 3]>,
}

/// Wedges without repetition, and the faces of each level, finest first.
#[derive(Debug, Default)]
pub(super) struct Shape {
    wedges: Vec<Wedge>,
    ids: BTreeMap<Wedge, u32>,
    levels: Vec<Vec<[u32; 3]>>,
}

/// SplitMix64 of some numbers, below `end`.
fn noise(seed: &[i32], end: u32) -> u32 {
    let mut state = 0u64;
    for &x in seed {
        state = (state ^ x as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ state >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        state ^= state >> 31;
    }
    (state >> 16) as u32 % end
}

/// [`noise`] from `-reach` to `reach`.
fn jitter(seed: &[i32], reach: i32) -> i32 {
    noise(seed, 2 * reach as u32 + 1) as i32 - reach
}

/// Octahedral position of a vector.
fn octahedral(v: [i32; 3], bits: u8) -> [i32; 2] {
    let half = (1 << (bits - 1)) - 1;
    let sum = v.iter().map(|x| x.abs()).sum::<i32>().max(1);
    let sign = |a: i32| if a < 0 { -1 } else { 1 };
    let (x, y) = if v[2] >= 0 {
        (v[0], v[1])
    } else {
        let [x, y, _] = v;
        ((sum - y.abs()) * sign(x), (sum - x.abs()) * sign(y))
    };
    [x, y].map(|n| half + (i64::from(n) * i64::from(half) / i64::from(sum)) as i32)
}

/// Sorts a skin as the codec demands, without zero weights.
fn sorted(mut skin: Vec<(u16, u8)>) -> Vec<(u16, u8)> {
    skin.retain(|i| i.1 > 0);
    skin.sort_by_key(|i| (std::cmp::Reverse(i.1), i.0));
    skin
}

impl Shape {
    fn add(&mut self, wedge: Wedge) -> u32 {
        let next = self.wedges.len() as u32;
        *self.ids.entry(wedge).or_insert_with_key(|wedge| {
            self.wedges.push(wedge.clone());
            next
        })
    }

    /// A lump of six charts with `side` * `side` quads each: a sphere that is cut off flat, with
    /// holes, hard edges, checks of colour, a fin on an edge of two faces, and a part of its own.
    pub(super) fn lump(side: i32, layout: &Layout) -> Self {
        let mut shape = Self::default();
        let mut faces = Vec::new();
        for chart in 0..6 {
            for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
                if chart == 2 && noise(&[i, j, 1], 24) == 0 {
                    continue;
                }
                let at = |di, dj| wedge_at(side, layout, [chart, i, j, di, dj]);
                let corners = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)];
                let [a, b, c, d] = corners.map(|w| shape.add(w));
                if noise(&[i, j, chart], 3) == 0 {
                    faces.extend([[a, b, d], [b, c, d]]);
                } else {
                    faces.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        let moved = |wedge: &Wedge, by: i32| {
            let mut wedge = wedge.clone();
            wedge.point.position = wedge.point.position.map(|x| x / 2 + by);
            wedge
        };
        let [a, b, _] = faces[7];
        let tip = shape.add(moved(&shape.wedges[a as usize], 9));
        faces.push([b, a, tip]);
        let part = [10, 11, 12, 13].map(|w| shape.add(moved(&shape.wedges[w], 3)));
        faces.extend([
            [part[0], part[1], part[2]],
            [part[0], part[2], part[3]],
            [part[1], part[0], part[3]],
        ]);
        shape.levels.push(faces);
        shape
    }

    /// Faces of random wedges of few random points, with values up to their limits. Each level is
    /// drawn anew from the same wedges.
    pub(super) fn scattered(faces: i32, layout: &Layout) -> Self {
        let mut shape = Self::default();
        let within = |seed: &[i32], bits: u8| noise(seed, 1 << bits) as i32;
        let any = |of: i32, p: i32, end: u32| noise(&[of, p], end) as i32;
        let point = |p: i32| Point {
            position: [0, 1, 2].map(|d| within(&[p, d], layout.position_bits)),
            skin: {
                let joints: BTreeSet<i32> = (0..any(2, p, 9))
                    .map(|k| noise(&[p, k, 3], layout.joints.into()) as i32)
                    .collect();
                let mut left = 255;
                let mut skin: Vec<(u16, u8)> = Vec::new();
                for joint in joints {
                    let weight = any(4, joint + p, left + 1);
                    skin.push((joint as u16, weight as u8));
                    left -= weight as u32;
                }
                skin.push((layout.joints - 1, 0));
                skin.dedup_by_key(|i| i.0);
                let last = skin.len() - 1;
                skin[last].1 += left as u8;
                sorted(skin)
            },
            morphs: (0i32..)
                .zip(&layout.morphs)
                .map(|(m, _)| match any(5, p + 90 * m, 3) {
                    0 => [0; 3],
                    1 => [3, 4, 5].map(|d| jitter(&[p, m, d], 30)),
                    _ => [3, 4, 5].map(|d| jitter(&[p, m, d], 1 << 24)),
                })
                .collect(),
        };
        let points: Vec<Point> = (0..20).map(point).collect();
        for level in 0..3 {
            let face = |f: i32| {
                [0, 1, 2].map(|k| {
                    let p = any(7 + level, 3 * f + k, 20);
                    // The first points have very many wedges.
                    let w = any(11, 3 * f + k, if p < 2 { 40 } else { 3 });
                    Wedge {
                        point: points[p as usize].clone(),
                        normal: [0, 1].map(|d| within(&[p, w, d], layout.normal_bits)),
                        texcoord: [2, 3].map(|d| within(&[p, w / 2, d], layout.texcoord_bits)),
                        color: [4, 5, 6, 7].map(|d| within(&[p, w / 2, d], 8) as u8),
                        turns: (0i32..)
                            .zip(&layout.morphs)
                            .map(|(m, _)| [0, 1, 2].map(|d| jitter(&[w, m, d], 1023)))
                            .collect(),
                    }
                })
            };
            let faces = (0..faces >> level).map(|f| face(f).map(|w| shape.add(w)));
            let faces: Vec<[u32; 3]> = faces.collect();
            shape.levels.push(shape.distinct(faces));
        }
        shape
    }

    fn point(&self, wedge: u32) -> &Point {
        &self.wedges[wedge as usize].point
    }

    /// The faces of three points each, without repetition.
    fn distinct(&self, faces: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        let mut seen = BTreeSet::new();
        let mut faces = faces;
        faces.retain(|face| {
            let [a, b, c] = face.map(|w| self.point(w));
            let mut turned = *face;
            let least = (0..3).min_by_key(|&k| face[k]).unwrap();
            turned.rotate_left(least);
            a != b && b != c && c != a && seen.insert(turned)
        });
        faces
    }

    /// Adds a coarser level: points are merged with a neighbour, at most one around each face.
    pub(super) fn coarsen(&mut self, seed: i32) {
        let mut faces = self.levels.last().cloned().unwrap_or_default();
        let mut is_done: BTreeSet<Point> = BTreeSet::new();
        let mut edges: Vec<[u32; 2]> = faces.iter().map(|f| [f[0], f[1]]).collect();
        edges.sort_by_key(|e| noise(&[e[0] as i32, e[1] as i32, seed], 1 << 30));
        for [from, to] in edges {
            let (from, to) = (self.point(from).clone(), self.point(to).clone());
            let has = |f: &[u32; 3], p: &Point| f.iter().any(|&w| self.point(w) == p);
            let around: Vec<[u32; 3]> = faces.iter().copied().filter(|f| has(f, &from)).collect();
            if around
                .as_flattened()
                .iter()
                .any(|&w| is_done.contains(self.point(w)))
            {
                continue;
            }
            let wedge = |f: &[u32; 3], p: &Point| f.iter().copied().find(|&w| self.point(w) == p);
            let both = around.iter().filter(|f| has(f, &to));
            // The wedge of `to` that replaces each wedge of `from`.
            let pairs: BTreeSet<[u32; 2]> = both
                .filter_map(|f| Some([wedge(f, &from)?, wedge(f, &to)?]))
                .collect();
            let map: BTreeMap<u32, u32> = pairs.iter().map(|p| (p[0], p[1])).collect();
            let is_mapped = |f: &[u32; 3]| wedge(f, &from).is_some_and(|w| map.contains_key(&w));
            if map.len() != pairs.len() || !around.iter().all(is_mapped) {
                continue;
            }
            is_done.extend(around.as_flattened().iter().map(|&w| self.point(w).clone()));
            for w in faces.as_flattened_mut() {
                *w = map.get(w).copied().unwrap_or(*w);
            }
            faces = self.distinct(faces);
        }
        self.levels.push(faces);
    }

    /// The levels in the form of the codec, finest first.
    pub(super) fn meshes(&self, layout: &Layout) -> Vec<QuantisedMesh> {
        let of_level = |faces: &Vec<[u32; 3]>| self.mesh(layout, faces);
        self.levels.iter().map(of_level).collect()
    }

    fn mesh(&self, layout: &Layout, faces: &[[u32; 3]]) -> QuantisedMesh {
        let mut mesh = QuantisedMesh {
            morphs: vec![Vec::new(); layout.morphs.len()],
            morph_normals: vec![Vec::new(); layout.morphs.len()],
            ..QuantisedMesh::default()
        };
        let mut points: BTreeMap<Point, u32> = BTreeMap::new();
        let mut wedges: BTreeMap<Wedge, u32> = BTreeMap::new();
        for face in faces {
            let face = face.map(|w| {
                let wedge = self.wedges[w as usize].limited(layout);
                let count = points.len() as u32;
                let point = *points.entry(wedge.point.clone()).or_insert(count);
                if point == count {
                    mesh.positions.push(wedge.point.position);
                    if layout.joints > 0 {
                        mesh.skins.push(wedge.point.skin.clone());
                    }
                    for (list, offset) in mesh.morphs.iter_mut().zip(&wedge.point.morphs) {
                        list.push(*offset);
                    }
                }
                let count = wedges.len() as u32;
                let id = *wedges.entry(wedge.clone()).or_insert(count);
                if id == count {
                    mesh.wedge_points.push(point);
                    mesh.normals
                        .extend((layout.normal_bits > 0).then_some(wedge.normal));
                    let texcoord = (layout.texcoord_bits > 0).then_some(wedge.texcoord);
                    mesh.texcoords.extend(texcoord);
                    mesh.colors.extend(layout.has_colors.then_some(wedge.color));
                    for ((list, turn), morph) in mesh
                        .morph_normals
                        .iter_mut()
                        .zip(&wedge.turns)
                        .zip(&layout.morphs)
                    {
                        list.extend(morph.has_normals.then_some(*turn));
                    }
                }
                id
            });
            mesh.faces.push(face);
        }
        mesh
    }
}

impl Wedge {
    /// This wedge with the kinds of values of a layout only.
    fn limited(&self, layout: &Layout) -> Self {
        let mut out = self.clone();
        if layout.joints == 0 {
            out.point.skin.clear();
        }
        out.point.morphs.truncate(layout.morphs.len());
        if layout.normal_bits == 0 {
            out.normal = [0; 2];
        }
        if layout.texcoord_bits == 0 {
            out.texcoord = [0; 2];
        }
        if !layout.has_colors {
            out.color = [0; 4];
        }
        out.turns.truncate(layout.morphs.len());
        for (turn, morph) in out.turns.iter_mut().zip(&layout.morphs) {
            if !morph.has_normals {
                *turn = [0; 3];
            }
        }
        out
    }
}

/// The corner (`i`, `j`) of a chart of [`Shape::lump`], on a cube and on a sphere.
fn spherical(side: i32, radius: i32, [chart, i, j]: [i32; 3]) -> [[i32; 3]; 2] {
    let (axis, sign) = (chart as usize / 2, 1 - chart % 2 * 2);
    let mut cube = [0; 3];
    cube[axis] = sign * side;
    cube[(axis + 1) % 3] = 2 * i - side;
    cube[(axis + 2) % 3] = (2 * j - side) * sign;
    let square = cube.iter().map(|x| (x * x) as u64 * 10_000).sum::<u64>();
    let length = square.isqrt() as i64;
    let out = cube.map(|x| (i64::from(x) * 100 * i64::from(radius) / length) as i32);
    [cube, out]
}

/// Noise of a corner of the cube.
fn shaken([x, y, z]: [i32; 3], kind: i32, reach: i32) -> i32 {
    jitter(&[x, y, z, kind], reach)
}

/// A skin of six joints along Y; one in six points has a third joint.
fn skin_at(cube: [i32; 3], height: i32, radius: i32) -> Vec<(u16, u8)> {
    let height = (height + radius + 20).clamp(0, 2 * radius);
    let along = (i64::from(height) * 5 * 255 / i64::from(2 * radius)) as i32;
    let bone = (along / 255).min(4) as u16;
    let share = (along - i32::from(bone) * 255).min(255) as u8;
    let mut skin = vec![(bone, 255 - share), (bone + 1, share)];
    if noise(&[cube[0], cube[1], cube[2], 7], 6) == 0 {
        let third = skin[0].1 / 4;
        skin[0].1 -= third;
        skin.push(((bone + 3) % 6, third));
    }
    sorted(skin)
}

/// Of a part of the points, of scattered points, and of one corner of the cube.
fn morphs_at(side: i32, cube: [i32; 3], at: [i32; 3], radius: i32) -> Vec<[i32; 3]> {
    let shake = |d: i32| shaken(cube, d, 1 + radius / 300);
    let lifted = (at[1] - radius / 2).max(0);
    let is_odd = noise(&[cube[0], cube[1], cube[2], 8], 12) == 0;
    let either = |is: bool, offset| if is { offset } else { [0; 3] };
    let up = [
        lifted / 8 * at[0].signum(),
        lifted / 2,
        shake(3) * lifted.signum(),
    ];
    vec![
        up,
        either(is_odd, [5, 6, 7].map(|d| shake(d) * 7)),
        either(cube == [side; 3], [1, -1, 300]),
    ]
}

/// The wedge of a corner of quad (`i`, `j`) of a chart of [`Shape::lump`].
fn wedge_at(side: i32, layout: &Layout, [chart, i, j, di, dj]: [i32; 5]) -> Wedge {
    let radius = (1 << (layout.position_bits - 1)) - 40;
    let place = |i: i32, j: i32| spherical(side, radius, [chart, i, j]);
    let [cube, around] = place(i + di, j + dj);
    let cut = radius * 3 / 4;
    let is_flat = |at: [i32; 3]| at[0] >= cut;
    let shake = |d: i32| shaken(cube, d, 1 + radius / 300);
    let mut at = [0, 1, 2].map(|d| around[d] + shake(d as i32));
    if is_flat(around) {
        at[0] = cut;
    }
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| place(i + a, j + b)[1]);
    let normal = if corners.iter().all(|c| is_flat(*c)) {
        [1, 0, 0]
    } else if chart == 3 {
        // Facets of two by two quads.
        place(i / 2 * 2 + 1, j / 2 * 2 + 1)[1]
    } else {
        let [x, y, z] = cube;
        [0, 1, 2].map(|d| around[d] + jitter(&[x, y, z, 9, d as i32], radius / 90))
    };
    let width = ((1 << layout.texcoord_bits) - 1) / 3;
    let along = |n: i32| n * (width - 9) / side;
    let u = if chart % 2 == 0 {
        i + di
    } else {
        side - i - di
    };
    let off = |d: i32| jitter(&[cube[0], cube[1], cube[2], chart, d], 2) + 3;
    let texcoord = [
        chart % 3 * width + along(u) + off(10),
        chart / 3 * width + along(j + dj) + off(11),
    ];
    let is_dark = chart == 1 && (i / 3 + j / 2) % 2 == 0;
    let bright = |d: usize| (128 + i64::from(at[d]) * 100 / i64::from(radius)) as u8;
    let bright = [bright(0), bright(1), 90, if chart == 1 { 200 } else { 255 }];
    let either = |is: bool, turn| if is { turn } else { [0; 3] };
    Wedge {
        point: Point {
            position: at.map(|x| x + radius + 20),
            skin: skin_at(cube, at[1], radius),
            morphs: morphs_at(side, cube, at, radius),
        },
        normal: octahedral(normal, layout.normal_bits.max(2)),
        texcoord,
        color: if is_dark { [20, 30, 40, 255] } else { bright },
        turns: vec![
            either(at[1] > radius / 2, [shake(12) + 40, -30, along(i) % 50]),
            [0; 3],
            either(cube == [side; 3], [127, 0, -20]),
        ],
    }
}
