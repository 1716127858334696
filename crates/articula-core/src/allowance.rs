//! Tolerance of a frame: the same for all, or less for near characters.

/// What a [`Budget`](crate::crowd::Budget) allows a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowance {
    /// Tolerated error in pixels; NaN counts as 0.
    pub px: f32,
    /// Tolerated error of near characters, those of which a metre spans [`Self::NEAR_PX_PER_METRE`] or
    /// more, where it is less.
    pub near_px: f32,
    /// Whether options are chosen by processor time alone, however many triangles they draw.
    pub by_processor: bool,
    /// Frames within which it reaches everybody, if it differs from that of the frame before: in each a part of
    /// the crowd takes it over, since to choose all levels again may take as long as a frame. Up to 1: all in this
    /// frame.
    pub frames: u16,
}

impl Allowance {
    /// Pixels that a metre of a near character spans: in a picture of 1080 rows and 45 degrees those
    /// nearer than about 32 m, of 720 rows 21 m.
    pub const NEAR_PX_PER_METRE: f32 = 40.0;

    /// Tolerated error of near characters in pixels: the less of both.
    pub fn px_of_near(self) -> f32 {
        self.px_at(0.0)
    }

    /// A tolerance that is the same for all.
    pub(crate) fn of(px: f32) -> Self {
        Self {
            px,
            near_px: f32::INFINITY,
            by_processor: false,
            frames: 1,
        }
    }

    /// Tolerance in metres where so many metres span a pixel; it rises with these.
    #[inline]
    pub(crate) fn metres(self, metres_per_px: f32) -> f32 {
        metres_per_px * self.px_at(metres_per_px)
    }

    /// Tolerance in pixels where so many metres span a pixel.
    #[inline]
    pub(crate) fn px_at(self, metres_per_px: f32) -> f32 {
        if metres_per_px <= 1.0 / Self::NEAR_PX_PER_METRE && self.near_px < self.px {
            self.near_px
        } else {
            self.px
        }
    }
}
