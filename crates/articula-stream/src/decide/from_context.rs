//! Budget, size on the screen and preferences of a decision, from a context of use.

use super::choice::{Budget, ChoiceRequest};
use super::part::{Part, PartKind, pixels_per_metre};
use super::preference::{LimitSource, Preference, Rule};
use super::ratio::{DeviceBenchmark, NetworkShare};
use crate::description::{Benchmark, Context, Modality};
use articula_core::Libm;
use articula_core::Viewport;

/// What counts where a context says nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Assumptions {
    /// Bandwidth, bits per second.
    pub bits_per_second: f64,
    /// Stretch of content that is decided on, seconds.
    pub window_secs: f64,
    /// Time per frame, nanoseconds.
    pub frame_ns: u64,
    /// Distance of the character, metres.
    pub distance_m: f32,
    /// Picture that shows it.
    pub viewport: Viewport,
}

impl Default for Assumptions {
    /// 500 kbit/s, 2 s, 4 ms, 3 m, 1280 x 720 at 45 degrees.
    fn default() -> Self {
        Self {
            bits_per_second: 500e3,
            window_secs: 2.0,
            frame_ns: 4_000_000,
            distance_m: 3.0,
            viewport: Viewport::default(),
        }
    }
}

impl ChoiceRequest {
    /// The request of a context: bytes of the usable bandwidth within the window, time per frame,
    /// memory of the terminal, size on the screen, and the tolerance as the error that is not seen.
    ///
    /// ```
    /// use articula_stream::decide::{Assumptions, ChoiceRequest};
    /// use articula_stream::description::Context;
    ///
    /// let mut context = Context::default();
    /// context.network.available_bps = Some(64e3);
    /// context.view.distance_m = Some(9.05);
    /// let request = ChoiceRequest::of_context(&context, &Assumptions::default());
    /// assert_eq!(request.budget.bytes, 16_000);
    /// assert!((request.pixels_per_metre - 96.0).abs() < 0.1);
    /// ```
    pub fn of_context(context: &Context, assumed: &Assumptions) -> Self {
        let share = NetworkShare {
            bits_per_second: context
                .network
                .usable_bps()
                .unwrap_or(assumed.bits_per_second),
            window_secs: assumed.window_secs,
            content_bits: 0.0,
        };
        let frame_ns = context.terminal.frame_budget_ms.map(|ms| (ms * 1e6) as u64);
        let (view, terminal) = (&context.view, &context.terminal);
        let or = |told: Option<f64>, assumed: f32| told.map_or(assumed, |told| told as f32);
        let viewport = Viewport {
            width_px: or(terminal.width_px, assumed.viewport.width_px),
            height_px: or(terminal.height_px, assumed.viewport.height_px),
            fov_y_radians: or(view.fov_rad, assumed.viewport.fov_y_radians),
        };
        let distance_m = or(view.distance_m, assumed.distance_m);
        Self {
            budget: Budget {
                bytes: share.bytes_allowed(),
                frame_ns: frame_ns.unwrap_or(assumed.frame_ns),
                memory_bytes: terminal
                    .memory_bytes
                    .map_or(Budget::UNBOUNDED, |bytes| bytes as u64),
            },
            window_secs: assumed.window_secs,
            // An angle of 0 shows a point.
            pixels_per_metre: pixels_per_metre(&viewport, distance_m).clamp(0.0, 1e9),
            enough_px: context.preferences.tolerance_px.unwrap_or(0.0),
            effort: Self::EFFORT,
        }
    }
}

/// Frames per second that are wanted where a context says nothing, and those of the reference machine.
const FPS: f64 = 60.0;
/// Score of the reference machine where a context says nothing: the device's is a percentage of it.
const REFERENCE_SCORE: f64 = 100.0;

impl DeviceBenchmark {
    /// The device of a context by its benchmarks; `None` if none has a score of the device.
    ///
    /// Of several the geometric mean counts, as in 6.1 of the thesis, and the least share. The rate that
    /// is wanted is that of the preferences, else that of the display, else 60 frames per second. A
    /// reference machine of which nothing is told has a score of 100, and reaches the wanted rate.
    ///
    /// ```
    /// use articula_stream::decide::DeviceBenchmark;
    /// use articula_stream::description::{Benchmark, Context};
    ///
    /// let mut context = Context::default();
    /// let score = Some(50.0);
    /// context.terminal.benchmarks = vec![Benchmark { name: "b".into(), score, ..Benchmark::default() }];
    /// assert_eq!(DeviceBenchmark::of_context(&context).unwrap().ratio(), 0.5);
    /// ```
    pub fn of_context(context: &Context) -> Option<Self> {
        let wanted_fps = context.preferences.frame_rate_hz;
        let wanted_fps = wanted_fps.or(context.terminal.refresh_hz).unwrap_or(FPS);
        let known = context.terminal.benchmarks.iter();
        let known: Vec<_> = known.filter(|b| b.score.is_some()).collect();
        if known.is_empty() {
            return None;
        }
        let mean = |of: &dyn Fn(&Benchmark) -> f64| -> f64 {
            let share = 1.0 / known.len() as f64;
            known.iter().map(|b| of(b).libm_powf(share)).product()
        };
        let shares = known.iter().filter_map(|b| b.share);
        Some(Self {
            reference_fps: mean(&|b| b.reference_fps.unwrap_or(wanted_fps)),
            wanted_fps,
            reference_score: mean(&|b| b.reference_score.unwrap_or(REFERENCE_SCORE)),
            device_score: mean(&|b| b.score.unwrap_or(0.0)),
            share: shares.fold(1.0, f64::min),
        })
    }
}

impl Preference {
    /// The preferences of a context. Levels of articulation and of the mesh are limits; regions that
    /// matter or are looked at are wishes, the latter of the view. Of the eight levels of a face the
    /// finest is the limit of its motion.
    pub fn of_context(context: &Context) -> Vec<Self> {
        let (user, view) = (LimitSource::User, LimitSource::View);
        let told = &context.preferences;
        let mut all = Vec::new();
        let mut add = |part, rule: Option<Rule>, source, is_wish| {
            all.extend(rule.map(|rule| Self {
                part,
                rule,
                source,
                is_wish,
            }));
        };
        let (body, face) = (PartKind::BodyMotion, PartKind::FaceMotion);
        let finest_face = told.face_loa.and_then(|levels| levels.into_iter().max());
        let loa = |loa: Option<u8>| loa.map(|loa| Rule::LoaAtMost(loa.into()));
        let regions = |mask: Option<u8>| mask.map(|mask| Rule::RegionsWith(mask.into()));
        add(body, loa(told.body_loa), user, false);
        add(face, loa(finest_face), user, false);
        add(
            PartKind::Mesh,
            told.mesh_level.map(Rule::FinestLevel),
            user,
            false,
        );
        add(body, regions(told.body_regions), user, true);
        add(body, regions(context.view.body_focus), view, true);
        add(face, regions(context.view.face_focus), view, true);
        all
    }
}

/// Weighs parts by the emphasis of a context on shape, pictures and motion; equal emphasis gives 1.
pub fn weigh_parts(parts: &mut [Part], context: &Context) {
    let [geometry, texture, animation] = context.preferences.emphasis();
    for part in parts {
        let share = match part.kind {
            PartKind::Mesh => geometry,
            PartKind::Texture => texture,
            PartKind::BodyMotion | PartKind::FaceMotion => animation,
            PartKind::Other => continue,
        };
        part.weight = 3.0 * share;
    }
}

/// The kind of representation that a context asks for, as in
/// [`DecisionRequest::modality`](super::DecisionRequest).
pub fn wanted_modality(context: &Context) -> Option<&'static str> {
    context.preferences.modality.map(|modality| match modality {
        Modality::Mesh => "3d",
        Modality::Warp => "portrait",
        Modality::Vector => "vector",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::part::PartOption;

    #[test]
    fn a_context_becomes_budget_limits_and_wishes() {
        let mut context = Context::default();
        let silent = ChoiceRequest::of_context(&context, &Assumptions::default());
        assert_eq!(
            (silent.budget.bytes, silent.budget.frame_ns),
            (125_000, 4_000_000)
        );
        assert!(Preference::of_context(&context).is_empty());
        assert_eq!(wanted_modality(&context), None);
        context.network.available_bps = Some(8000.0);
        context.terminal.frame_budget_ms = Some(1.5);
        context.preferences.tolerance_px = Some(2.0);
        context.preferences.body_loa = Some(2);
        context.preferences.face_loa = Some([0, 1, 2, 0, 0, 0, 0, 0]);
        context.preferences.mesh_level = Some(1);
        context.preferences.modality = Some(Modality::Vector);
        context.view.body_focus = Some(0b100);
        let request = ChoiceRequest::of_context(&context, &Assumptions::default());
        assert_eq!(
            (request.budget.bytes, request.budget.frame_ns),
            (2000, 1_500_000)
        );
        assert_eq!(request.enough_px, 2.0);
        let all = Preference::of_context(&context);
        let rules: Vec<(Rule, bool)> = all.iter().map(|p| (p.rule, p.is_wish)).collect();
        let expected = [
            (Rule::LoaAtMost(2), false),
            (Rule::LoaAtMost(2), false),
            (Rule::FinestLevel(1), false),
            (Rule::RegionsWith(0b100), true),
        ];
        assert_eq!(rules, expected);
        assert_eq!(wanted_modality(&context), Some("vector"));
    }

    #[test]
    fn benchmarks_are_averaged_and_what_is_missing_is_assumed() {
        let mut context = Context::default();
        assert_eq!(DeviceBenchmark::of_context(&context), None);
        let of = |score, reference_score| Benchmark {
            name: "b".into(),
            score: Some(score),
            reference_score,
            ..Benchmark::default()
        };
        let ratio = |context: &Context| DeviceBenchmark::of_context(context).map(|d| d.ratio());
        let near = |found: Option<f64>, expected: f64| {
            assert!(
                (found.unwrap() - expected).abs() < 1e-12,
                "{found:?} {expected}"
            );
        };
        // A score without a reference is a percentage of it.
        context.terminal.benchmarks = vec![of(25.0, None)];
        near(ratio(&context), 0.25);
        // A quarter and a ninth: a sixth in the mean.
        context.terminal.benchmarks = vec![of(25.0, None), of(10.0, Some(90.0))];
        near(ratio(&context), 1.0 / 6.0);
        // 50 frames per second there and 25 wanted here, half of the device.
        context.preferences.frame_rate_hz = Some(25.0);
        for benchmark in &mut context.terminal.benchmarks {
            benchmark.reference_fps = Some(50.0);
            benchmark.share = Some(0.5);
        }
        near(ratio(&context), 1.0 / 6.0);
        context.terminal.benchmarks[1].score = Some(0.0);
        near(ratio(&context), 0.0);
    }

    #[test]
    fn emphasis_weighs_and_equal_emphasis_does_not() {
        let part = |kind| Part::new("", kind, vec![PartOption::default()]);
        let kinds = [
            PartKind::Mesh,
            PartKind::Texture,
            PartKind::BodyMotion,
            PartKind::Other,
        ];
        let mut parts = kinds.map(part);
        let mut context = Context::default();
        weigh_parts(&mut parts, &context);
        assert_eq!(parts.clone().map(|p| p.weight), [1.0; 4]);
        context.preferences.geometry_emphasis = Some(0.0);
        context.preferences.texture_emphasis = Some(1.0);
        context.preferences.animation_emphasis = Some(3.0);
        weigh_parts(&mut parts, &context);
        assert_eq!(parts.map(|p| p.weight), [0.0, 0.75, 2.25, 1.0]);
    }
}
