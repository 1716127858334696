//! The pass of [`super::cull`] over bodies laid out in tiles of eight, for crowds.
//!
//! The results are kept as masks and as metres per pixel, so that a tolerance in pixels becomes one
//! in metres by a product. [`BoxSight`] is the result for all bodies of a box at once.

use super::cull::{CullResult, Visibility};
use super::density::{MIN_DEPTH_METRES, PixelDensity};
use super::view::{FARTHEST_METRES, View};
use crate::allowance::Allowance;
use crate::simd::{Backend, Kernel, LANES, Lanes, Tile, dispatch};
use crate::sphere::Sphere;
use glam::Vec3;

/// World-space bounds of bodies, eight to a tile: centres in metres and radii. A body whose bound is
/// not finite has NaN everywhere.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spheres<'a> {
    /// Index of the first tile among those of the occlusion of the views.
    pub(crate) first_tile: usize,
    pub(crate) x: &'a [Tile],
    pub(crate) y: &'a [Tile],
    pub(crate) z: &'a [Tile],
    pub(crate) radius: &'a [Tile],
}

/// Tolerances of the bodies, and the range in which each keeps its level.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bands<'a> {
    /// Tolerance in pixels, and that of bodies near enough.
    pub(crate) allowance: Allowance,
    /// Least tolerance in metres, included, and the greatest, excluded.
    pub(crate) least: &'a [Tile],
    pub(crate) most: &'a [Tile],
}

/// What is seen of the bodies of each tile, one bit for each body.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sight {
    /// Metres of the least displacement of a visible body that spans a pixel, the least over views;
    /// unspecified for others.
    pub(crate) metres_per_px: Vec<Tile>,
    pub(crate) visible: Vec<u8>,
    /// Visible, or inside the cull margin, or wholly occluded.
    pub(crate) near: Vec<u8>,
    /// Visible, and outside of its band.
    pub(crate) leaves: Vec<u8>,
}

impl Sight {
    /// Nothing is seen of so many tiles.
    pub(crate) fn new(tiles: usize) -> Self {
        Self {
            metres_per_px: vec![Tile::ZERO; tiles],
            visible: vec![0; tiles],
            near: vec![0; tiles],
            leaves: vec![0; tiles],
        }
    }

    /// All of `count` bodies are visible, at an unlimited number of pixels per metre, as far as they
    /// are in the given tiles.
    pub(crate) fn see_all(&mut self, tiles: &[u32], count: usize) {
        for tile in tiles.iter().map(|t| *t as usize) {
            let lanes = (count - tile * LANES).min(LANES);
            let all = u8::MAX >> (LANES - lanes);
            self.metres_per_px[tile] = Tile::ZERO;
            self.visible[tile] = all;
            self.near[tile] = all;
            self.leaves[tile] = all;
        }
    }
}

/// Looks at the bodies of the given tiles through all views. `margins` has the distance that each
/// body may move until the next test, or is empty. O(tiles x views); does not allocate.
pub(crate) fn look(
    backend: Backend,
    views: &[View<'_>],
    (spheres, margins): (Spheres<'_>, &[f32]),
    bands: Bands<'_>,
    tiles: &[u32],
    sight: &mut Sight,
) {
    let kernel = Look {
        views,
        spheres,
        margins,
        bands,
        tiles,
        sight,
    };
    dispatch(backend, kernel);
}

struct Look<'a> {
    views: &'a [View<'a>],
    spheres: Spheres<'a>,
    margins: &'a [f32],
    bands: Bands<'a>,
    tiles: &'a [u32],
    sight: &'a mut Sight,
}

impl Kernel for Look<'_> {
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let allowance = self.bands.allowance;
        let px = L::splat(allowance.px);
        let near_px = L::splat(allowance.px_of_near());
        let near_metres = L::splat(1.0 / Allowance::NEAR_PX_PER_METRE);
        for tile in self.tiles {
            let t = *tile as usize;
            let centre = [&self.spheres.x[t], &self.spheres.y[t], &self.spheres.z[t]];
            let radius = L::load(&self.spheres.radius[t].0);
            let margin = L::load(&margins_of(self.margins, t).0);
            let mut seen = L::splat(f32::INFINITY);
            let (mut visible, mut near) = (0, 0);
            for view in self.views {
                let found = through::<L>(view, centre, radius, margin);
                let occluded = occluded_of(view.occluded, self.spheres.first_tile + t);
                if occluded == 0 {
                    seen = seen.min(found.metres_per_px);
                    visible |= L::bits(found.visible);
                } else {
                    let mut tile = Tile::ZERO;
                    found.metres_per_px.store(&mut tile);
                    let lanes = tile.0.iter_mut().enumerate();
                    let hidden = lanes.filter(|(lane, _)| occluded >> lane & 1 == 1);
                    hidden.for_each(|(_, metres)| *metres = f32::INFINITY);
                    seen = seen.min(L::load(&tile.0));
                    visible |= L::bits(found.visible) & !occluded;
                }
                near |= L::bits(found.near);
            }
            seen.store(&mut self.sight.metres_per_px[t]);
            let is_near = seen.at_most(near_metres);
            let tolerance = seen.mul(L::select(is_near, near_px, px));
            let stays = L::both(
                L::load(&self.bands.least[t].0).at_most(tolerance),
                tolerance.less(L::load(&self.bands.most[t].0)),
            );
            self.sight.visible[t] = visible;
            self.sight.near[t] = near;
            self.sight.leaves[t] = visible & !L::bits(stays);
        }
    }
}

/// What one view sees of the bodies of a tile.
struct Through<L: Lanes> {
    /// Infinite where nothing is visible.
    metres_per_px: L,
    visible: L::Mask,
    near: L::Mask,
}

#[inline(always)]
fn through<L: Lanes>(view: &View<'_>, [x, y, z]: [&Tile; 3], radius: L, margin: L) -> Through<L> {
    let f = &view.frustum;
    let x = L::load(&x.0).sub(L::splat(f.eye.x));
    let y = L::load(&y.0).sub(L::splat(f.eye.y));
    let z = L::load(&z.0).sub(L::splat(f.eye.z));
    let depth = dot(f.forward, x, y, z);
    let [a, b, c, d] = f.sides;
    let a = dot(a.truncate(), x, y, z).add(L::splat(a.w));
    let b = dot(b.truncate(), x, y, z).add(L::splat(b.w));
    let c = dot(c.truncate(), x, y, z).add(L::splat(c.w));
    let d = dot(d.truncate(), x, y, z).add(L::splat(d.w));
    let begins = depth.sub(L::splat(f.near_metres));
    let ends = begins.min(L::splat(f.far_metres).sub(depth));
    // How far the centre is inside, negative outside.
    let inside = a.min(b).min(c.min(d)).min(ends);
    let extra = margin.add(L::splat(view.cull_margin_metres));
    // The sum of the three components is at least the distance, and cheaper.
    let distance = x.abs().add(y.abs()).add(z.abs()).add(extra);
    let reach = radius
        .add(extra)
        .add(L::splat(view.cull_margin_radians).mul(distance));
    let zero = L::splat(0.0);
    // NaN is not equal to itself, and no least or greatest number hides it then.
    let is_number = depth.at_most(depth);
    let visible = L::both(is_number, zero.at_most(inside.add(radius)));
    let near = L::both(is_number, zero.at_most(inside.add(reach)));
    let metres_per_px = match view.density {
        // Most tiles of a large crowd are wholly outside.
        _ if L::bits(visible) == 0 => L::splat(f32::INFINITY),
        PixelDensity::Perspective {
            at_one_metre,
            corner_cosine,
        } => {
            let nearest = depth.sub(radius).max(L::splat(MIN_DEPTH_METRES));
            let [fx, fy, fz] = f.forward.to_array().map(L::splat);
            let (x, y, z) = (
                x.sub(fx.mul(depth)),
                y.sub(fy.mul(depth)),
                z.sub(fz.mul(depth)),
            );
            let aside = x.mul(x).add(y.mul(y)).add(z.mul(z)).sqrt().add(radius);
            let along = nearest.mul(nearest).add(aside.mul(aside)).sqrt();
            let cosine = nearest.div(along).max(L::splat(corner_cosine));
            nearest.mul(L::splat(1.0 / at_one_metre)).mul(cosine)
        }
        PixelDensity::Everywhere(pixels) => L::splat(1.0 / pixels),
    };
    Through {
        metres_per_px: L::select(visible, metres_per_px, L::splat(f32::INFINITY)),
        visible,
        near,
    }
}

#[inline(always)]
fn dot<L: Lanes>(normal: Vec3, x: L, y: L, z: L) -> L {
    let [a, b, c] = [normal.x, normal.y, normal.z].map(L::splat);
    a.mul(x).add(b.mul(y)).add(c.mul(z))
}

/// Cull margins of a tile; NaN and negative ones count as 0.
#[inline(always)]
fn margins_of(margins: &[f32], tile: usize) -> Tile {
    let mut of_tile = Tile::ZERO;
    if !margins.is_empty() {
        let margins = margins.iter().skip(tile * LANES);
        for (to, margin) in of_tile.0.iter_mut().zip(margins) {
            *to = match *margin > 0.0 {
                true => margin.min(FARTHEST_METRES),
                false => 0.0,
            };
        }
    }
    of_tile
}

/// Wholly occluded bodies of a tile, one bit each.
#[inline(always)]
fn occluded_of(occluded: &[f32], tile: usize) -> u8 {
    let occluded = occluded.iter().skip(tile * LANES).take(LANES).enumerate();
    occluded.fold(0, |bits, (lane, share)| {
        bits | u8::from(*share >= 1.0) << lane
    })
}

/// What is seen of the bodies inside of a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BoxSight {
    /// No view sees any, and none is inside a cull margin.
    Nothing,
    /// Some may be visible.
    Some,
    /// All are visible, with these least and greatest metres per pixel.
    All([f32; 2]),
}

/// What all views together see of the bodies whose bounds lie within a box, without occlusion and
/// without margins of the bodies.
pub(crate) fn look_at_box(views: &[View<'_>], least: Vec3, greatest: Vec3) -> BoxSight {
    let mut sight = BoxSight::Nothing;
    for view in views {
        sight = match (sight, view.sees_box(least, greatest)) {
            (BoxSight::Some, _) | (_, BoxSight::Some) => BoxSight::Some,
            (one, BoxSight::Nothing) | (BoxSight::Nothing, one) => one,
            (BoxSight::All(a), BoxSight::All(b)) => BoxSight::All([a[0].min(b[0]), a[1].min(b[1])]),
        };
    }
    sight
}

impl View<'_> {
    fn sees_box(&self, least: Vec3, greatest: Vec3) -> BoxSight {
        let f = &self.frustum;
        let centre = 0.5 * (least + greatest) - f.eye;
        let half = 0.5 * (greatest - least);
        let sum = |v: Vec3| v.x + v.y + v.z;
        let far = sum(centre.abs()) + sum(half);
        // More than rounding changes in any of the sums below and in those of a body.
        let rounding = 1e-5 * (far + f.eye.abs().max_element() + 1.0);
        let extra = self.cull_margin_metres;
        let reach = extra + self.cull_margin_radians * (far + extra) * 1.001 + rounding;
        let depth = f.forward.dot(centre);
        let depth_half = f.forward.abs().dot(half);
        let ends = [depth - f.near_metres, f.far_metres - depth].map(|d| (d, depth_half));
        let sides = f.sides.map(|side| {
            let normal = side.truncate();
            (normal.dot(centre) + side.w, normal.abs().dot(half))
        });
        let mut all = true;
        for (middle, half) in sides.into_iter().chain(ends) {
            if middle + half + reach < 0.0 {
                return BoxSight::Nothing;
            }
            // NaN is not inside either.
            all &= middle - half - rounding > 0.0;
        }
        if !all {
            return BoxSight::Some;
        }
        let [nearest, farthest] = [depth - depth_half - rounding, depth + depth_half + rounding];
        // A bound in the box reaches no farther aside than the box, and no less than its middle less
        // the half of its extent.
        let across = f
            .forward
            .to_array()
            .map(|along| (1.0 - along * along).max(0.0).sqrt());
        let extent = half.dot(across.into()).min(half.length()) + rounding;
        let aside = (centre - f.forward * depth).length();
        let metres = |depth, aside| self.density.metres_per_px(depth, aside);
        BoxSight::All([
            metres(nearest, aside + extent) * 0.999_99,
            metres(farthest, (aside - extent).max(0.0)) * 1.000_01,
        ])
    }

    /// The view without what it cannot see for walls.
    pub(crate) fn unoccluded(&self) -> View<'static> {
        View {
            frustum: self.frustum,
            density: self.density,
            cull_margin_metres: self.cull_margin_metres,
            cull_margin_radians: self.cull_margin_radians,
            occluded: &[],
        }
    }

    /// Whether any body may be occluded.
    pub(crate) fn has_occlusion(&self) -> bool {
        !self.occluded.is_empty()
    }
}

/// The plain version of [`look`] for one body without a margin and without occlusion.
pub(crate) fn look_at_one(views: &[View<'_>], bound: Sphere) -> CullResult {
    let mut result = CullResult::default();
    for view in views {
        let f = &view.frustum;
        let at = bound.centre - f.eye;
        let along = |n: Vec3| n.x * at.x + n.y * at.y + n.z * at.z;
        let depth = along(f.forward);
        let ends = (depth - f.near_metres).min(f.far_metres - depth);
        let sides = f.sides.map(|side| along(side.truncate()) + side.w);
        let inside = sides.into_iter().fold(ends, f32::min);
        let extra = view.cull_margin_metres;
        let distance = at.x.abs() + at.y.abs() + at.z.abs() + extra;
        let reach = bound.radius + extra + view.cull_margin_radians * distance;
        let visibility = if depth.is_nan() || bound.radius.is_nan() {
            Visibility::Hidden
        } else if inside + bound.radius >= 0.0 {
            Visibility::Visible
        } else if inside + reach >= 0.0 {
            Visibility::Margin
        } else {
            Visibility::Hidden
        };
        let size = if visibility == Visibility::Visible {
            bound.radius
        } else {
            reach
        };
        let aside = at - f.forward * depth;
        let aside = aside.x * aside.x + aside.y * aside.y + aside.z * aside.z;
        let pixels_per_metre = view.density.at(depth - size, aside.sqrt() + size);
        if visibility > result.visibility {
            result = CullResult {
                pixels_per_metre,
                visibility,
            };
        } else if visibility == result.visibility && visibility != Visibility::Hidden {
            result.pixels_per_metre = result.pixels_per_metre.max(pixels_per_metre);
        }
    }
    result
}
