//! Culls bodies against views and computes their size on screen, in one pass over a crowd.
//!
//! Source: `docs/methods/motion-lod.md` part 5, and 4.3 for several cameras. Input: the frustums of
//! the views and the bounds of the bodies. Output: a [`Visibility`] and pixels per metre for each
//! body, from which level and budget are chosen.
//!
//! Shadow maps, mirrors and further cameras are views like the first. There is no memory of earlier
//! frames, so a cut of the camera is no special case.
//!
//! Bodies are processed in groups of four with `glam`'s vectors, in blocks that stay in the L1
//! cache for any number of views.

use super::density::{MIN_DEPTH_METRES, PixelDensity};
use super::view::{FARTHEST_METRES, View};
use super::world_bounds::{LANES, columns, filled};
use crate::Mismatch;
use crate::sphere::Sphere;
use glam::{Vec3, Vec4};

/// Culling result of a body: hidden, in the cull margin or occluded, or visible.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(u8)]
pub enum Visibility {
    /// Not visible in any view before the next test: only clock, events and root motion need to
    /// run.
    #[default]
    Hidden,
    /// Inside the cull margin: not visible, but it may be before the next test; or wholly occluded.
    Margin,
    /// Its bound meets the frustum of a view.
    Visible,
}

/// Result of culling one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CullResult {
    /// Maximum number of pixels that a displacement of one metre spans, over the views that see the
    /// body (or have it inside their cull margin) and over all points of its bound (of its bound
    /// inflated by the margin, for [`Visibility::Margin`]). Finite; 0 for a hidden body.
    pub pixels_per_metre: f32,
    /// Visibility of the body.
    pub visibility: Visibility,
}

/// The bodies of a crowd; one entry of each slice for each body.
#[derive(Debug, Clone, Copy)]
pub struct Bodies<'a> {
    bounds: &'a [Sphere],
    cull_margin_metres: &'a [f32],
}

impl<'a> Bodies<'a> {
    /// Combines the slices.
    ///
    /// - `bounds`: in world space, each containing its body from now until the next test. They
    ///   change when a root moves or the clip advances, which need not be in every frame;
    ///   [`Sphere::carried`] computes one.
    /// - `cull_margin_metres`: distance that root motion may move the bound until then: the path of
    ///   the root plus the arc of the bound's centre about it. NaN counts as 0.
    ///
    /// # Errors
    /// A [`Mismatch`] if the lengths differ.
    pub fn new(bounds: &'a [Sphere], cull_margin_metres: &'a [f32]) -> Result<Self, Mismatch> {
        if cull_margin_metres.len() != bounds.len() {
            let what = format!(
                "{} entries for {} bodies",
                cull_margin_metres.len(),
                bounds.len()
            );
            return Err(Mismatch::new("cull_margin_metres", what));
        }
        Ok(Self {
            bounds,
            cull_margin_metres,
        })
    }

    /// Number of bodies.
    pub(crate) fn len(&self) -> usize {
        self.bounds.len()
    }
}

/// Culls every body against every view.
///
/// A body is visible if any view sees it, and hidden if its bound is not finite. O(bodies x views);
/// does not allocate.
///
/// # Panics
/// If `out` does not have one entry for each body.
pub fn cull(views: &[View<'_>], bodies: Bodies<'_>, out: &mut [CullResult]) {
    assert_eq!(out.len(), bodies.len(), "expected one result for each body");
    for (b, out) in out.chunks_mut(BLOCK).enumerate() {
        let first = b * BLOCK;
        let mut block = Block::new();
        let part = first..first + out.len();
        block.place(
            &bodies.bounds[part.clone()],
            &bodies.cull_margin_metres[part],
        );
        for view in views {
            block.look(view, view.occluded.get(first..).unwrap_or_default());
        }
        block.tell(out);
    }
}

const GROUPS: usize = 16;
const BLOCK: usize = LANES * GROUPS;

/// World-space bounds of some bodies in groups of four, and their pixels per metre so far, 0 where
/// no view saw them.
struct Block {
    groups: usize,
    x: [Vec4; GROUPS],
    y: [Vec4; GROUPS],
    z: [Vec4; GROUPS],
    radius: [Vec4; GROUPS],
    margin: [Vec4; GROUPS],
    visible: [Vec4; GROUPS],
    near: [Vec4; GROUPS],
}

impl Block {
    fn new() -> Self {
        let zero = [Vec4::ZERO; GROUPS];
        Self {
            groups: 0,
            x: zero,
            y: zero,
            z: zero,
            radius: zero,
            margin: zero,
            visible: zero,
            near: zero,
        }
    }

    /// Loads at most [`BLOCK`] bodies.
    fn place(&mut self, bounds: &[Sphere], margins: &[f32]) {
        let (bounds, last_bounds) = bounds.as_chunks();
        let (margins, last_margins) = margins.as_chunks();
        for (group, (bounds, margins)) in bounds.iter().zip(margins).enumerate() {
            self.place_four(group, *bounds, *margins);
        }
        self.groups = bounds.len();
        if !last_bounds.is_empty() {
            let nothing = Sphere {
                centre: Vec3::NAN,
                radius: 0.0,
            };
            let bounds = filled(last_bounds, nothing);
            self.place_four(self.groups, bounds, filled(last_margins, 0.0));
            self.groups += 1;
        }
    }

    #[inline]
    fn place_four(&mut self, group: usize, bounds: [Sphere; LANES], margins: [f32; LANES]) {
        let [x, y, z, radius] = columns(bounds.map(|s| s.centre.extend(s.radius)));
        let is_radius = radius.cmpge(Vec4::ZERO) & radius.cmple(Vec4::splat(f32::MAX));
        let margin = Vec4::from_array(margins);
        let margin = Vec4::select(margin.cmpgt(Vec4::ZERO), margin, Vec4::ZERO);
        self.x[group] = x;
        self.y[group] = y;
        self.z[group] = z;
        self.radius[group] = Vec4::select(is_radius, radius, Vec4::NAN);
        self.margin[group] = margin.min(Vec4::splat(FARTHEST_METRES));
    }

    /// Adds the results of one view.
    fn look(&mut self, view: &View<'_>, occluded: &[f32]) {
        let f = &view.frustum;
        let eye = splats(f.eye);
        let forward = splats(f.forward);
        let sides = f.sides.map(|s| (splats(s.truncate()), Vec4::splat(s.w)));
        let [begin, end] = [f.near_metres, f.far_metres].map(Vec4::splat);
        let zero = Vec4::ZERO;
        for g in 0..self.groups {
            let [x, y, z] = [self.x[g] - eye[0], self.y[g] - eye[1], self.z[g] - eye[2]];
            let dot = |n: &[Vec4; 3]| n[0] * x + n[1] * y + n[2] * z;
            let depth = dot(&forward);
            let [a, b, c, d] = sides.map(|(normal, offset)| dot(&normal) + offset);
            let ends = (depth - begin).min(end - depth);
            // How far the centre is inside, negative outside; infinite positions are infinitely far
            // outside, and NaN has no depth.
            let inside = a.min(b).min(c.min(d)).min(ends);
            let radius = self.radius[g];
            let mut reach = radius + self.margin[g] + view.cull_margin_metres;
            if view.cull_margin_radians > 0.0 {
                // The sum of the three components is at least the distance, and cheaper.
                let distance = x.abs() + y.abs() + z.abs() + (reach - radius);
                reach += view.cull_margin_radians * distance;
            }
            let is_number = depth.cmpeq(depth);
            let near = is_number & (inside + reach).cmpge(zero);
            let mut visible = is_number & (inside + radius).cmpge(zero);
            if !occluded.is_empty() {
                let occluded = occluded.get(g * LANES..).unwrap_or_default();
                let occluded = Vec4::from_array(filled(occluded, 0.0));
                visible &= !occluded.cmpge(Vec4::ONE);
            }
            let density = match view.density {
                PixelDensity::Everywhere(pixels) => Vec4::splat(pixels),
                PixelDensity::Perspective {
                    at_one_metre,
                    corner_cosine,
                } => {
                    let size = Vec4::select(visible, radius, reach);
                    let nearest = (depth - size).max(Vec4::splat(MIN_DEPTH_METRES));
                    let [x, y, z] = [
                        x - depth * forward[0],
                        y - depth * forward[1],
                        z - depth * forward[2],
                    ];
                    let aside = root(x * x + y * y + z * z) + size;
                    let cosine = nearest / root(nearest * nearest + aside * aside);
                    let cosine = cosine.max(Vec4::splat(corner_cosine));
                    let density = Vec4::splat(at_one_metre) / (nearest * cosine);
                    // Above zero at any depth, since 0 means not seen.
                    density.max(Vec4::splat(f32::MIN_POSITIVE))
                }
            };
            self.visible[g] = self.visible[g].max(Vec4::select(visible, density, zero));
            self.near[g] = self.near[g].max(Vec4::select(near, density, zero));
        }
    }

    fn tell(&self, out: &mut [CullResult]) {
        let (fours, last) = out.as_chunks_mut();
        for (g, four) in fours.iter_mut().enumerate() {
            *four = self.emit_four(g);
        }
        last.copy_from_slice(&self.emit_four(fours.len() % GROUPS)[..last.len()]);
    }

    #[inline]
    fn emit_four(&self, group: usize) -> [CullResult; LANES] {
        const FOUND: [Visibility; 4] = [
            Visibility::Hidden,
            Visibility::Margin,
            Visibility::Visible,
            Visibility::Visible,
        ];
        let visible = self.visible[group].cmpgt(Vec4::ZERO);
        let density = Vec4::select(visible, self.visible[group], self.near[group]);
        let [visible, near] = [visible, density.cmpgt(Vec4::ZERO)].map(|mask| mask.bitmask());
        let density = density.to_array();
        // No branch: visibility in a crowd follows no pattern.
        std::array::from_fn(|lane| CullResult {
            pixels_per_metre: density[lane],
            visibility: FOUND[(2 * (visible >> lane & 1) + (near >> lane & 1)) as usize],
        })
    }
}

#[inline]
fn splats(v: Vec3) -> [Vec4; 3] {
    [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)]
}

#[inline]
fn root(v: Vec4) -> Vec4 {
    Vec4::from_array(v.to_array().map(f32::sqrt))
}

#[cfg(test)]
mod tests {
    use super::super::density::PixelDensity;
    use super::super::frustum::Tangents;
    use super::*;
    use crate::view::{Camera, Viewport};
    use glam::{Quat, Vec2};
    use proptest::prelude::*;

    /// Bounds and cull margins of some bodies.
    #[derive(Debug, Clone, Default)]
    struct Crowd {
        bounds: Vec<Sphere>,
        margins: Vec<f32>,
    }

    const BALL: Sphere = Sphere {
        centre: Vec3::ZERO,
        radius: 1.0,
    };

    impl Crowd {
        /// Unit spheres with their cull margins.
        fn of(rows: &[(Vec3, f32)]) -> Self {
            let mut crowd = Self::default();
            for (centre, margin) in rows {
                crowd.push(
                    Sphere {
                        centre: *centre,
                        ..BALL
                    },
                    *margin,
                );
            }
            crowd
        }

        fn push(&mut self, bound: Sphere, margin: f32) {
            self.bounds.push(bound);
            self.margins.push(margin);
        }

        fn seen(&self, views: &[View<'_>]) -> Vec<CullResult> {
            let mut out = vec![CullResult::default(); self.bounds.len()];
            cull(
                views,
                Bodies::new(&self.bounds, &self.margins).unwrap(),
                &mut out,
            );
            out
        }

        fn visibilities(&self, views: &[View<'_>]) -> Vec<Visibility> {
            self.seen(views).iter().map(|s| s.visibility).collect()
        }
    }

    fn camera() -> Camera {
        Camera::looking_at(Vec3::ZERO, Vec3::NEG_Z, Viewport::default())
    }

    #[test]
    fn lengths_must_agree() {
        assert_eq!(
            Bodies::new(&[BALL], &[]).unwrap_err().at,
            "cull_margin_metres"
        );
    }

    #[test]
    fn five_bodies_by_hand() {
        use Visibility::{Hidden, Margin, Visible};
        let crowd = Crowd::of(&[
            (Vec3::NEG_Z * 11.0, 0.0),
            (Vec3::Z * 3.0, 1.9),
            (Vec3::Z * 3.0, 2.1),
            (Vec3::Z * 0.5, 0.0),
            (Vec3::NEG_Z * 1e4, 0.0),
        ]);
        let view = View::of(&camera());
        let seen = crowd.seen(&[view]);
        let found: Vec<_> = seen.iter().map(|s| s.visibility).collect();
        assert_eq!(found, [Visible, Hidden, Margin, Visible, Visible]);
        let viewport = Viewport::default();
        // At a depth of 10 m, and 1 m aside.
        let near = viewport.pixels_per_metre(10.0) * 101f32.sqrt() / 10.0;
        assert!((seen[0].pixels_per_metre - near).abs() < 1e-3 * near);
        assert_eq!(seen[1].pixels_per_metre, 0.0);
        // A camera inside a body counts as at the minimum depth from it, which reaches beyond the
        // corner of the picture, whose tangents are 0.41421 and 16:9 of it.
        let corner = (1.0f32 + 0.171_57 + 0.542_25).sqrt();
        let inside = viewport.pixels_per_metre(MIN_DEPTH_METRES) * corner;
        assert!((seen[3].pixels_per_metre - inside).abs() < 1e-3 * inside);
    }

    #[test]
    fn the_nearest_of_several_views_counts_and_shadows_are_views() {
        let crowd = Crowd::of(&[(Vec3::NEG_Z * 11.0, 0.0), (Vec3::X * 50.0, 0.0)]);
        let eye = View::of(&camera());
        let mut close = camera();
        close.eye = Vec3::NEG_Z * 5.0;
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let sun = View::parallel(Vec3::Y * 100.0, down, Vec2::splat(60.0), 20.0);
        let near = Viewport::default().pixels_per_metre(5.0) * 26f32.sqrt() / 5.0;
        for views in [[eye, View::of(&close), sun], [sun, View::of(&close), eye]] {
            let seen = crowd.seen(&views);
            assert!((seen[0].pixels_per_metre - near).abs() < 1e-3 * near);
            // Only its shadow falls into view, at the shadow map's own density.
            let shadow = CullResult {
                pixels_per_metre: 20.0,
                visibility: Visibility::Visible,
            };
            assert_eq!(seen[1], shadow);
        }
        assert_eq!(crowd.visibilities(&[]), [Visibility::Hidden; 2]);
    }

    #[test]
    fn both_eyes_of_a_headset_see() {
        // A body far to the left is seen by the left eye alone.
        let eye = |side: f32, left, right| {
            let tangents = Tangents {
                left,
                right,
                down: 1.0,
                up: 1.0,
            };
            View::off_axis(Vec3::X * side, Quat::IDENTITY, tangents, 1000.0)
        };
        let eyes = [eye(-0.03, 1.3, 0.9), eye(0.03, 0.9, 1.3)];
        let crowd = Crowd::of(&[(Vec3::new(-110.0, 0.0, -100.0), 0.0)]);
        assert_eq!(crowd.visibilities(&eyes), [Visibility::Visible]);
        assert_eq!(crowd.visibilities(&eyes[1..]), [Visibility::Hidden]);
        // At a depth of 99 m and up to 110.97 m aside.
        let secant = (1.0 + 110.97f32 * 110.97 / (99.0 * 99.0)).sqrt();
        assert!((crowd.seen(&eyes)[0].pixels_per_metre - secant * 1000.0 / 99.0).abs() < 1e-3);
    }

    #[test]
    fn what_a_view_cannot_see_for_walls_is_near() {
        use Visibility::{Margin, Visible};
        let ahead = Vec3::NEG_Z * 9.0;
        let crowd = Crowd::of(&[(ahead, 0.0); 6]);
        let occluded = [0.0, 1.0, 0.999, 2.0, f32::NAN];
        let view = View::of(&camera()).with_occluded(&occluded);
        let expected = [Visible, Margin, Visible, Margin, Visible, Visible];
        assert_eq!(crowd.visibilities(&[view]), expected);
        let mirror = View::of(&camera());
        assert_eq!(crowd.visibilities(&[view, mirror]), [Visible; 6]);
    }

    #[test]
    fn a_camera_that_moves_or_turns_wakes_what_it_may_see() {
        use Visibility::{Hidden, Margin};
        // Straight to the right, 10 m away: the right side of the picture is 53.6 degrees off
        // (its tangent is 0.736), so the centre must come 0.936 rad nearer, the ball less.
        let crowd = Crowd::of(&[(Vec3::X * 10.0, 0.0)]);
        let view = View::of(&camera());
        assert_eq!(crowd.visibilities(&[view]), [Hidden]);
        assert_eq!(
            crowd.visibilities(&[view.with_cull_margin(0.0, 0.6)]),
            [Hidden]
        );
        assert_eq!(
            crowd.visibilities(&[view.with_cull_margin(0.0, 0.9)]),
            [Margin]
        );
        assert_eq!(
            crowd.visibilities(&[view.with_cull_margin(7.2, 0.0)]),
            [Margin]
        );
        assert_eq!(
            crowd.visibilities(&[view.with_cull_margin(f32::NAN, f32::NAN)]),
            [Hidden]
        );
        assert_eq!(
            crowd.visibilities(&[view.with_cull_margin(0.0, f32::INFINITY)]),
            [Margin]
        );
    }

    #[test]
    fn what_is_no_number_is_hidden() {
        let mut crowd = Crowd::default();
        let ahead = Vec3::NEG_Z * 5.0;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let all = Vec3::splat(bad);
            for at in [all, ahead.with_x(bad), ahead.with_y(bad), ahead.with_z(bad)] {
                crowd.push(Sphere { centre: at, ..BALL }, 1.0);
            }
            crowd.push(
                Sphere {
                    centre: ahead,
                    radius: bad,
                },
                1.0,
            );
        }
        crowd.push(
            Sphere {
                centre: ahead,
                radius: -1.0,
            },
            1.0,
        );
        let mut sideways = camera();
        for orientation in [
            Quat::IDENTITY,
            Quat::from_rotation_y(1.0),
            Quat::from_rotation_y(-1.57),
        ] {
            sideways.orientation = orientation;
            let view = View::of(&sideways);
            assert!(
                crowd
                    .seen(&[view])
                    .iter()
                    .all(|s| *s == CullResult::default()),
                "{:?}",
                crowd.seen(&[view])
            );
        }
        // A NaN margin adds nothing, but a visible body stays visible.
        let odd = Crowd::of(&[
            (ahead, f32::NAN),
            (-ahead, f32::NAN),
            (-ahead, f32::INFINITY),
        ]);
        use Visibility::{Hidden, Margin, Visible};
        let view = View::of(&camera());
        assert_eq!(odd.visibilities(&[view]), [Visible, Hidden, Margin]);
        assert!(odd.seen(&[view])[2].pixels_per_metre.is_finite());
        let nothing = View::new(view.frustum, PixelDensity::Everywhere(f32::NAN));
        assert_eq!(odd.visibilities(&[nothing]), [Hidden; 3]);
    }

    #[test]
    fn a_view_may_begin_and_end_at_a_depth() {
        use Visibility::{Hidden, Visible};
        let crowd = Crowd::of(&[
            (Vec3::NEG_Z * 3.0, 0.0),
            (Vec3::NEG_Z * 9.0, 0.0),
            (Vec3::Z * 3.0, 0.0),
        ]);
        let view = View::of(&camera());
        let seen = |depths| crowd.visibilities(&[view.with_depth_range(depths)]);
        assert_eq!(seen(0.0..7.0), [Visible, Hidden, Hidden]);
        assert_eq!(seen(5.0..9.0), [Hidden, Visible, Hidden]);
        let sun = View::parallel(Vec3::ZERO, Quat::IDENTITY, Vec2::ONE, 20.0);
        assert_eq!(crowd.visibilities(&[sun]), [Visible, Visible, Hidden]);
        let behind = sun.with_depth_range(-5.0..7.0);
        assert_eq!(crowd.visibilities(&[behind]), [Visible, Hidden, Visible]);
    }

    fn vector(size: f32) -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-size..size).prop_map(Vec3::from)
    }

    fn turn() -> impl Strategy<Value = Quat> {
        vector(3.0).prop_map(Quat::from_scaled_axis)
    }

    proptest! {
        /// Compares the pass in groups of four with one body and one view at a time.
        #[test]
        fn agrees_with_the_plain_test(
            rows in prop::collection::vec((vector(30.0), 0.0f32..3.0, 0.0f32..4.0), 0..150),
            eyes in prop::collection::vec((vector(30.0), turn()), 1..4),
        ) {
            let mut crowd = Crowd::default();
            for (centre, radius, margin) in &rows {
                crowd.push(Sphere { centre: *centre, radius: *radius }, *margin);
            }
            let viewport = Viewport::default();
            let cameras: Vec<Camera> = eyes.iter().map(|(eye, orientation)| Camera { eye: *eye, orientation: *orientation, viewport }).collect();
            let views: Vec<View<'_>> = cameras.iter().map(View::of).collect();
            for (b, seen) in crowd.seen(&views).iter().enumerate() {
                let bound = crowd.bounds[b];
                // Rounding may decide within this much of an edge.
                let most = 1e-4;
                let meets = |extra: f32| -> f32 {
                    views.iter().filter(|v| v.frustum.meets(bound.centre, bound.radius + extra))
                        .map(|v| {
                            let size = bound.radius + extra.max(0.0);
                            v.density.at(v.frustum.depth(bound.centre) - size, v.frustum.aside(bound.centre) + size)
                        })
                        .fold(0.0, f32::max)
                };
                let between = |low: f32, found: f32, high: f32| low * 0.999 <= found && found <= high * 1.001;
                match seen.visibility {
                    Visibility::Visible => prop_assert!(between(meets(-most), seen.pixels_per_metre, meets(most))),
                    Visibility::Margin => {
                        prop_assert_eq!(meets(-most), 0.0);
                        let margin = rows[b].2;
                        prop_assert!(between(meets(margin - most), seen.pixels_per_metre, meets(margin + most)));
                    }
                    Visibility::Hidden => prop_assert_eq!(meets(rows[b].2 - most), 0.0),
                }
            }
        }
    }
}
