//! Which bodies are seen, which soon may be, and how large: one pass over a crowd.
//!
//! Source: `spec/motion-lod.md` part 5, and 4.3 for several cameras. Takes the frustums of the
//! views and where the bodies are; gives, for the level and the budget that come next, a
//! [`Visibility`] and pixels per metre.
//!
//! Shadow maps, mirrors and second cameras are views like the first. Only what is seen now
//! counts: there is no memory, so a cut of the camera needs nothing special.
//!
//! Bodies are taken by fours through `glam`'s vectors, in blocks that stay in the nearest cache
//! however many views there are.

use crate::Mismatch;
use crate::frustum::Frustum;
use crate::sphere::Sphere;
use crate::view::Camera;
use glam::{Mat4, Quat, Vec3, Vec4};

/// Depth below which nothing is taken to come closer, so that a camera inside a body still gets
/// finite pixels per metre.
pub const LEAST_DEPTH_METRES: f32 = 0.1;

/// Whether a body is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
#[repr(u8)]
pub enum Visibility {
    /// No view can see it before it is looked for again: nothing but its clock need run.
    #[default]
    Hidden,
    /// Not seen, but it may be before it is looked for again: out of view, or wholly occluded.
    Near,
    /// Its bound meets the frustum of a view.
    Visible,
}

/// What the views see of one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// The most that one metre of it spans, over the views that see it (or that it is near to),
    /// at the nearest depth of its bound (of its wake-ahead bound, where it is [`Visibility::Near`]).
    /// Finite; 0 for a hidden body.
    pub pixels_per_metre: f32,
    /// Whether it is seen.
    pub visibility: Visibility,
}

/// Pixels that one metre spans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PixelDensity {
    /// So many at a depth of one metre, falling with depth: perspective.
    AtOneMetre(f32),
    /// So many at any depth: parallel projection.
    Everywhere(f32),
}

impl PixelDensity {
    /// Pixels per metre at a depth; depths below [`LEAST_DEPTH_METRES`] count as that.
    pub fn at(self, depth_metres: f32) -> f32 {
        match self {
            Self::AtOneMetre(pixels) => pixels / depth_metres.max(LEAST_DEPTH_METRES),
            Self::Everywhere(pixels) => pixels,
        }
    }
}

/// One view of the world: a camera, an eye of a headset, a mirror, a shadow map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View<'a> {
    frustum: Frustum,
    density: PixelDensity,
    wake_metres: f32,
    wake_radians: f32,
    occluded: &'a [f32],
}

impl<'a> View<'a> {
    /// A view by its frustum and its own pixels per metre. Where these are no positive number it
    /// sees nothing.
    pub fn new(frustum: Frustum, density: PixelDensity) -> Self {
        let (PixelDensity::AtOneMetre(pixels) | PixelDensity::Everywhere(pixels)) = density;
        let is_number = pixels > 0.0 && pixels <= f32::MAX * LEAST_DEPTH_METRES;
        Self {
            frustum: if is_number { frustum } else { Frustum::NOTHING },
            density,
            wake_metres: 0.0,
            wake_radians: 0.0,
            occluded: &[],
        }
    }

    /// The view of a perspective camera.
    pub fn of(camera: &Camera) -> Self {
        let density = PixelDensity::AtOneMetre(camera.viewport.pixels_per_metre(1.0));
        Self::new(Frustum::of(camera), density)
    }

    /// The same view of a camera that may move by so much and turn by so much until it looks
    /// again: bodies that this could bring into view are [`Visibility::Near`].
    #[must_use]
    pub fn moving(self, wake_metres: f32, wake_radians: f32) -> Self {
        Self {
            wake_metres: at_most(wake_metres, FARTHEST_METRES),
            // No turn takes a point farther than to the other side of the eye.
            wake_radians: at_most(wake_radians, 2.0),
            ..self
        }
    }

    /// The same view with the part of each body, 0 to 1, that other things hide from it, in the
    /// order of the bodies. From 1 on the body is not seen but [`Visibility::Near`]. Missing ones
    /// and such that are no number count as 0.
    #[must_use]
    pub fn with_occluded(self, occluded: &'a [f32]) -> Self {
        Self { occluded, ..self }
    }

    /// How long it takes at least until one metre of a body, by its bound in the world, may span
    /// more than `limit` pixels. 0 if it already does or the limit is no number; infinite if it
    /// cannot (as at [`LEAST_DEPTH_METRES`]) or while this view does not see the bound: that it
    /// comes into view is told by [`see`].
    pub fn secs_until_denser(&self, bound: Sphere, limit: f32, closing: Closing) -> f32 {
        if !self.frustum.meets(bound.centre, bound.radius) {
            return f32::INFINITY;
        }
        let pixels = match self.density {
            PixelDensity::AtOneMetre(pixels) if limit < self.density.at(0.0) => pixels,
            density => {
                let never = density.at(0.0) <= limit;
                return if never { f32::INFINITY } else { 0.0 };
            }
        };
        let slack = self.frustum.depth(bound.centre) - bound.radius - pixels / limit;
        if slack.is_nan() || slack <= 0.0 {
            return 0.0;
        }
        // Depth falls no faster than v + w (d + v t), with the distance d of the bound's centre:
        // the first time at which v t + w (d t + v t^2 / 2) is the slack.
        let (v, w) = (closing.metres_per_sec, closing.radians_per_sec);
        let linear = v + w * bound.centre.distance(self.frustum.eye);
        let secs = 2.0 * slack / (linear + (linear * linear + 2.0 * w * v * slack).sqrt());
        if secs.is_nan() { 0.0 } else { secs }
    }

    /// The space that it sees.
    pub fn frustum(&self) -> &Frustum {
        &self.frustum
    }

    /// Its pixels per metre by depth.
    pub fn density(&self) -> PixelDensity {
        self.density
    }
}

/// Bounds on how fast a camera and a body may come closer to each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Closing {
    /// Speed of the camera and speed of the body's root, added.
    pub metres_per_sec: f32,
    /// How fast the camera turns.
    pub radians_per_sec: f32,
}

/// Where the bodies of a crowd are; one entry of each slice for each body.
#[derive(Debug, Clone, Copy)]
pub struct Bodies<'a> {
    positions: &'a [Vec3],
    rotations: &'a [Quat],
    scales: &'a [f32],
    bounds: &'a [Sphere],
    wake_metres: &'a [f32],
}

impl<'a> Bodies<'a> {
    /// Puts the slices together.
    ///
    /// - `positions`: of the roots in the world, metres
    /// - `rotations`: world from model, unit
    /// - `scales`: uniform; a negative one mirrors
    /// - `bounds`: in model space, each holding its body from now until it is looked for again
    /// - `wake_metres`: how far root motion may carry the bound meanwhile; speed bound times
    ///   wake horizon. NaN counts as 0.
    ///
    /// # Errors
    /// A [`Mismatch`] if the lengths differ.
    pub fn new(
        positions: &'a [Vec3],
        rotations: &'a [Quat],
        scales: &'a [f32],
        bounds: &'a [Sphere],
        wake_metres: &'a [f32],
    ) -> Result<Self, Mismatch> {
        for (at, found) in [
            ("rotations", rotations.len()),
            ("scales", scales.len()),
            ("bounds", bounds.len()),
            ("wake_metres", wake_metres.len()),
        ] {
            if found != positions.len() {
                let what = format!("{found} entries for {} bodies", positions.len());
                return Err(Mismatch::new(at, what));
            }
        }
        Ok(Self {
            positions,
            rotations,
            scales,
            bounds,
            wake_metres,
        })
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// The bound of one body in the world.
    pub fn bound(&self, body: usize) -> Sphere {
        let bound = self.bounds[body];
        bound.carried(
            self.positions[body],
            self.rotations[body],
            self.scales[body],
        )
    }
}

/// How far root motion may carry a bound in `horizon_secs`: the way of the root and the arc of
/// the bound's centre about it. Times the scale of the body, if its motion is scaled too.
pub fn wake_metres(
    bound: Sphere,
    speed_metres_per_sec: f32,
    turn_radians_per_sec: f32,
    horizon_secs: f32,
) -> f32 {
    (speed_metres_per_sec + turn_radians_per_sec * bound.centre.length()) * horizon_secs
}

/// How long it takes at least until a body's pixels per metre may have grown by the factor
/// `1 + growth`, over the views that see its bound in the world: until then what was judged by
/// `seen` holds within that factor. 0 for a body that was not visible.
///
/// Source: `spec/motion-lod.md` 4.5, last paragraph.
pub fn secs_until_grown(
    views: &[View<'_>],
    bound: Sphere,
    seen: Seen,
    growth: f32,
    closing: Closing,
) -> f32 {
    if seen.visibility != Visibility::Visible {
        return 0.0;
    }
    let limit = seen.pixels_per_metre * (1.0 + growth);
    views
        .iter()
        .map(|view| view.secs_until_denser(bound, limit, closing))
        .fold(f32::INFINITY, f32::min)
}

/// Looks for every body in every view.
///
/// A body whose place, bound or scale is no finite number is hidden. O(bodies x views); does
/// not allocate.
///
/// # Panics
/// If `out` has not one entry for each body.
pub fn see(views: &[View<'_>], bodies: Bodies<'_>, out: &mut [Seen]) {
    assert_eq!(out.len(), bodies.len(), "one answer for each body");
    for (b, out) in out.chunks_mut(BLOCK).enumerate() {
        let first = b * BLOCK;
        let mut block = Block::new();
        let groups = out.len().div_ceil(LANES);
        for group in 0..groups {
            block.place(group, bodies, first + group * LANES);
        }
        for view in views {
            block.look(groups, view, first);
        }
        block.tell(out);
    }
}

/// What an infinite way counts as, so that no turn of 0 multiplies it to no number.
const FARTHEST_METRES: f32 = 1e18;

const LANES: usize = 4;
const GROUPS: usize = 16;
const BLOCK: usize = LANES * GROUPS;

/// World bounds of some bodies, by fours, and what was found of them so far: 0 pixels per metre
/// where no view saw them.
struct Block {
    x: [Vec4; GROUPS],
    y: [Vec4; GROUPS],
    z: [Vec4; GROUPS],
    radius: [Vec4; GROUPS],
    wake: [Vec4; GROUPS],
    visible: [Vec4; GROUPS],
    near: [Vec4; GROUPS],
}

impl Block {
    fn new() -> Self {
        let zero = [Vec4::ZERO; GROUPS];
        Self {
            x: zero,
            y: zero,
            z: zero,
            radius: zero,
            wake: zero,
            visible: zero,
            near: zero,
        }
    }

    /// Carries the bounds of the four bodies from `at` on into the world.
    #[inline]
    fn place(&mut self, group: usize, bodies: Bodies<'_>, at: usize) {
        let position = four(bodies.positions, at, Vec3::NAN).map(|p| p.extend(0.0));
        let position = columns(position);
        let rotation = columns(four(bodies.rotations, at, Quat::IDENTITY).map(Vec4::from));
        let bound = four(bodies.bounds, at, Sphere::default());
        let bound = columns(bound.map(|s| s.centre.extend(s.radius)));
        let scale = Vec4::from_array(four(bodies.scales, at, 0.0));
        let wake = Vec4::from_array(four(bodies.wake_metres, at, 0.0));

        // q c q* = c + w t + v x t with t = 2 v x c.
        let [qx, qy, qz, qw] = rotation;
        let [cx, cy, cz] = [bound[0] * scale, bound[1] * scale, bound[2] * scale];
        let tx = 2.0 * (qy * cz - qz * cy);
        let ty = 2.0 * (qz * cx - qx * cz);
        let tz = 2.0 * (qx * cy - qy * cx);
        self.x[group] = position[0] + (cx + qw * tx + (qy * tz - qz * ty));
        self.y[group] = position[1] + (cy + qw * ty + (qz * tx - qx * tz));
        self.z[group] = position[2] + (cz + qw * tz + (qx * ty - qy * tx));
        self.radius[group] = bound[3] * scale.abs();
        self.wake[group] = or_zero(wake).min(Vec4::splat(FARTHEST_METRES));
    }

    /// Adds what one view sees.
    #[inline]
    fn look(&mut self, groups: usize, view: &View<'_>, first: usize) {
        let f = &view.frustum;
        let eye = splats(f.eye);
        let forward = splats(f.forward);
        let sides = f.sides.map(|s| (splats(s.truncate()), Vec4::splat(s.w)));
        let [near, far] = [f.near_metres, f.far_metres].map(Vec4::splat);
        let greatest = Vec4::splat(f32::MAX);
        let least_depth = Vec4::splat(LEAST_DEPTH_METRES);
        let (pixels, flat) = match view.density {
            PixelDensity::AtOneMetre(pixels) => (Vec4::splat(pixels), false),
            PixelDensity::Everywhere(pixels) => (Vec4::splat(pixels), true),
        };
        let density = |depth: Vec4| {
            // The greatest depth keeps a far body's density above zero.
            let depth = depth.max(least_depth);
            if flat { pixels } else { pixels / depth }.max(Vec4::splat(f32::MIN_POSITIVE))
        };
        for g in 0..groups {
            let [x, y, z] = [self.x[g] - eye[0], self.y[g] - eye[1], self.z[g] - eye[2]];
            let dot = |n: &[Vec4; 3]| n[0] * x + n[1] * y + n[2] * z;
            let depth = dot(&forward);
            let side = sides.map(|(normal, offset)| dot(&normal) + offset);
            let side = side[0].min(side[1]).min(side[2].min(side[3]));
            let radius = self.radius[g];
            // What is no number passes no comparison, and an infinite place has no finite depth.
            let real =
                depth.abs().cmple(greatest) & radius.cmple(greatest) & radius.cmpge(Vec4::ZERO);
            let meets =
                |r: Vec4| real & side.cmpge(-r) & (depth + r).cmpge(near) & (depth - r).cmple(far);
            let mut seen = meets(radius);
            if let Some(occluded) = view.occluded.get(first + g * LANES..) {
                let occluded = Vec4::from_array(four(occluded, 0, 0.0));
                seen &= !occluded.cmpge(Vec4::ONE);
            }
            // The sum of three sides is at least the distance, and cheaper.
            let moved = self.wake[g] + view.wake_metres;
            let turned = view.wake_radians * (x.abs() + y.abs() + z.abs() + moved);
            let reach = radius + moved + turned;
            let zero = Vec4::ZERO;
            let visible = Vec4::select(seen, density(depth - radius), zero);
            let near = Vec4::select(meets(reach), density(depth - reach), zero);
            self.visible[g] = self.visible[g].max(visible);
            self.near[g] = self.near[g].max(near);
        }
    }

    #[inline]
    fn tell(&self, out: &mut [Seen]) {
        for (g, out) in out.chunks_mut(LANES).enumerate() {
            let visible = self.visible[g].to_array();
            let near = self.near[g].to_array();
            for (lane, out) in out.iter_mut().enumerate() {
                let (visibility, pixels_per_metre) = if visible[lane] > 0.0 {
                    (Visibility::Visible, visible[lane])
                } else if near[lane] > 0.0 {
                    (Visibility::Near, near[lane])
                } else {
                    (Visibility::Hidden, 0.0)
                };
                *out = Seen {
                    pixels_per_metre,
                    visibility,
                };
            }
        }
    }
}

/// Four values from `at` on, filled up behind the end.
#[inline]
fn four<T: Copy>(values: &[T], at: usize, filler: T) -> [T; LANES] {
    match values.get(at..at + LANES) {
        Some(v) => [v[0], v[1], v[2], v[3]],
        None => std::array::from_fn(|lane| values.get(at + lane).copied().unwrap_or(filler)),
    }
}

/// Four rows as four columns.
#[inline]
fn columns([a, b, c, d]: [Vec4; 4]) -> [Vec4; 4] {
    let m = Mat4::from_cols(a, b, c, d).transpose();
    [m.x_axis, m.y_axis, m.z_axis, m.w_axis]
}

#[inline]
fn splats(v: Vec3) -> [Vec4; 3] {
    [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)]
}

/// From 0 to `most`; 0 of what is no number.
fn at_most(value: f32, most: f32) -> f32 {
    if value > 0.0 { value.min(most) } else { 0.0 }
}

/// Lanes above zero; the others, and such that are no number, become 0.
#[inline]
fn or_zero(v: Vec4) -> Vec4 {
    Vec4::select(v.cmpgt(Vec4::ZERO), v, Vec4::ZERO)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::Viewport;

    /// Bodies as their owner keeps them.
    #[derive(Debug, Clone, Default)]
    struct Crowd {
        positions: Vec<Vec3>,
        rotations: Vec<Quat>,
        scales: Vec<f32>,
        bounds: Vec<Sphere>,
        wakes: Vec<f32>,
    }

    const BALL: Sphere = Sphere {
        centre: Vec3::ZERO,
        radius: 1.0,
    };

    impl Crowd {
        /// Unit balls that may move so far.
        fn of(rows: &[(Vec3, f32)]) -> Self {
            let mut crowd = Self::default();
            for (position, wake) in rows {
                crowd.push(*position, Quat::IDENTITY, 1.0, BALL, *wake);
            }
            crowd
        }

        fn push(&mut self, at: Vec3, rotation: Quat, scale: f32, bound: Sphere, wake: f32) {
            self.positions.push(at);
            self.rotations.push(rotation);
            self.scales.push(scale);
            self.bounds.push(bound);
            self.wakes.push(wake);
        }

        fn bodies(&self) -> Bodies<'_> {
            Bodies::new(
                &self.positions,
                &self.rotations,
                &self.scales,
                &self.bounds,
                &self.wakes,
            )
            .unwrap()
        }

        fn seen(&self, views: &[View<'_>]) -> Vec<Seen> {
            let mut out = vec![Seen::default(); self.positions.len()];
            see(views, self.bodies(), &mut out);
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
        let crowd = Crowd::of(&[(Vec3::ZERO, 0.0)]);
        let (p, r, s, b) = (
            &crowd.positions,
            &crowd.rotations,
            &crowd.scales,
            &crowd.bounds,
        );
        assert_eq!(
            Bodies::new(p, &[], s, b, &[0.0]).unwrap_err().at,
            "rotations"
        );
        assert_eq!(Bodies::new(p, r, &[], b, &[0.0]).unwrap_err().at, "scales");
        assert_eq!(Bodies::new(p, r, s, &[], &[0.0]).unwrap_err().at, "bounds");
        assert_eq!(Bodies::new(p, r, s, b, &[]).unwrap_err().at, "wake_metres");
    }

    #[test]
    fn five_bodies_by_hand() {
        use Visibility::{Hidden, Near, Visible};
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
        assert_eq!(found, [Visible, Hidden, Near, Visible, Visible]);
        let viewport = Viewport::default();
        let near = viewport.pixels_per_metre(10.0);
        assert!((seen[0].pixels_per_metre - near).abs() < 1e-3 * near);
        assert_eq!(seen[1].pixels_per_metre, 0.0);
        // A camera inside a body stands at the least depth from it.
        let inside = viewport.pixels_per_metre(LEAST_DEPTH_METRES);
        assert!((seen[3].pixels_per_metre - inside).abs() < 1e-3 * inside);
    }

    #[test]
    fn the_nearest_of_several_views_counts_and_shadows_are_views() {
        let crowd = Crowd::of(&[(Vec3::NEG_Z * 11.0, 0.0), (Vec3::X * 50.0, 0.0)]);
        let eye = View::of(&camera());
        let mut close = camera();
        close.eye = Vec3::NEG_Z * 5.0;
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let sun = Frustum::orthographic(Vec3::Y * 100.0, down, 60.0, 60.0);
        let sun = View::new(sun, PixelDensity::Everywhere(20.0));
        let near = Viewport::default().pixels_per_metre(5.0);
        for views in [[eye, View::of(&close), sun], [sun, View::of(&close), eye]] {
            let seen = crowd.seen(&views);
            assert!((seen[0].pixels_per_metre - near).abs() < 1e-3 * near);
            // Only its shadow falls into view, at the shadow map's own density.
            let shadow = Seen {
                pixels_per_metre: 20.0,
                visibility: Visibility::Visible,
            };
            assert_eq!(seen[1], shadow);
        }
        assert_eq!(crowd.visibilities(&[]), [Visibility::Hidden; 2]);
    }

    #[test]
    fn both_eyes_of_a_headset_see() {
        // What is far to the left is seen by the left eye alone.
        let eye = |side: f32, left, right| {
            let tangents = crate::frustum::Tangents {
                left,
                right,
                down: 1.0,
                up: 1.0,
            };
            let frustum = Frustum::perspective(Vec3::X * side, Quat::IDENTITY, tangents);
            View::new(frustum, PixelDensity::AtOneMetre(1000.0))
        };
        let eyes = [eye(-0.03, 1.3, 0.9), eye(0.03, 0.9, 1.3)];
        let crowd = Crowd::of(&[(Vec3::new(-110.0, 0.0, -100.0), 0.0)]);
        assert_eq!(crowd.visibilities(&eyes), [Visibility::Visible]);
        assert_eq!(crowd.visibilities(&eyes[1..]), [Visibility::Hidden]);
        assert!((crowd.seen(&eyes)[0].pixels_per_metre - 1000.0 / 99.0).abs() < 1e-3);
    }

    #[test]
    fn what_a_view_cannot_see_for_walls_is_near() {
        use Visibility::{Near, Visible};
        let ahead = Vec3::NEG_Z * 9.0;
        let crowd = Crowd::of(&[(ahead, 0.0); 6]);
        let occluded = [0.0, 1.0, 0.999, 2.0, f32::NAN];
        let view = View::of(&camera()).with_occluded(&occluded);
        let expected = [Visible, Near, Visible, Near, Visible, Visible];
        assert_eq!(crowd.visibilities(&[view]), expected);
        let mirror = View::of(&camera());
        assert_eq!(crowd.visibilities(&[view, mirror]), [Visible; 6]);
    }

    #[test]
    fn a_camera_that_moves_or_turns_wakes_what_it_may_see() {
        use Visibility::{Hidden, Near};
        // Straight to the right, 10 m away: the right side of the picture is 53.6 degrees off
        // (its tangent is 0.736), so the centre must come 0.936 rad nearer, the ball less.
        let crowd = Crowd::of(&[(Vec3::X * 10.0, 0.0)]);
        let view = View::of(&camera());
        assert_eq!(crowd.visibilities(&[view]), [Hidden]);
        assert_eq!(crowd.visibilities(&[view.moving(0.0, 0.6)]), [Hidden]);
        assert_eq!(crowd.visibilities(&[view.moving(0.0, 0.9)]), [Near]);
        assert_eq!(crowd.visibilities(&[view.moving(7.2, 0.0)]), [Near]);
        assert_eq!(
            crowd.visibilities(&[view.moving(f32::NAN, f32::NAN)]),
            [Hidden]
        );
        assert_eq!(
            crowd.visibilities(&[view.moving(0.0, f32::INFINITY)]),
            [Near]
        );
    }

    #[test]
    fn what_is_no_number_is_hidden() {
        let mut crowd = Crowd::default();
        let ahead = Vec3::NEG_Z * 5.0;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                crowd.push(
                    Vec3::select(axis.cmpgt(Vec3::ZERO), Vec3::splat(bad), ahead),
                    Quat::IDENTITY,
                    1.0,
                    BALL,
                    1.0,
                );
            }
            crowd.push(ahead, Quat::from_xyzw(bad, 0.0, 0.0, 1.0), 1.0, BALL, 1.0);
            crowd.push(ahead, Quat::IDENTITY, bad, BALL, 1.0);
            let bound = |centre, radius| Sphere { centre, radius };
            crowd.push(ahead, Quat::IDENTITY, 1.0, bound(Vec3::ZERO, bad), 1.0);
            crowd.push(
                ahead,
                Quat::IDENTITY,
                1.0,
                bound(Vec3::splat(bad), 1.0),
                1.0,
            );
        }
        crowd.push(
            ahead,
            Quat::IDENTITY,
            1.0,
            Sphere {
                centre: Vec3::ZERO,
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
                crowd.seen(&[view]).iter().all(|s| *s == Seen::default()),
                "{:?}",
                crowd.seen(&[view])
            );
        }
        // A way that is no number wakes nothing, but what is seen is seen.
        let odd = Crowd::of(&[
            (ahead, f32::NAN),
            (-ahead, f32::NAN),
            (-ahead, f32::INFINITY),
        ]);
        use Visibility::{Hidden, Near, Visible};
        let view = View::of(&camera());
        assert_eq!(odd.visibilities(&[view]), [Visible, Hidden, Near]);
        assert!(odd.seen(&[view])[2].pixels_per_metre.is_finite());
        let nothing = View::new(*view.frustum(), PixelDensity::AtOneMetre(f32::NAN));
        assert_eq!(odd.visibilities(&[nothing]), [Hidden; 3]);
    }

    #[test]
    fn how_long_a_dolly_takes_by_hand() {
        // 10 m to the bound; a quarter denser at 8 m; 5 m/s take 0.4 s for the 2 m.
        let crowd = Crowd::of(&[(Vec3::NEG_Z * 11.0, 0.0)]);
        let views = [View::of(&camera())];
        let (bound, seen) = (crowd.bodies().bound(0), crowd.seen(&views)[0]);
        let secs = |metres_per_sec, radians_per_sec, growth| {
            let closing = Closing {
                metres_per_sec,
                radians_per_sec,
            };
            secs_until_grown(&views, bound, seen, growth, closing)
        };
        assert!((secs(5.0, 0.0, 0.25) - 0.4).abs() < 1e-4);
        // Turning alone: 11 m away, 2 m of depth are lost after 2 / 11 rad at the earliest.
        assert!((secs(0.0, 1.0, 0.25) - 2.0 / 11.0).abs() < 1e-4);
        assert_eq!(secs(0.0, 0.0, 0.25), f32::INFINITY);
        assert_eq!(secs(5.0, 0.0, 1e9), f32::INFINITY, "beyond the least depth");
        assert_eq!(secs(5.0, 0.0, f32::NAN), 0.0);
        assert_eq!(secs(f32::NAN, 0.0, 0.25), 0.0);
        assert_eq!(secs(5.0, 0.0, -0.5), 0.0);
        let hidden = Seen::default();
        assert_eq!(
            secs_until_grown(&views, bound, hidden, 0.25, Closing::default()),
            0.0
        );
    }
}
