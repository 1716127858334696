//! What a caller may ask for beyond the context.

use articula_stream::decide::ChoiceRequest;

/// Options of a decision about an item.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AdaptOptions {
    /// Time to transfer the item in seconds (`T_W` of the thesis): with the bandwidth of the context
    /// it gives the bytes that may be sent. Above 0.
    pub wait_secs: f64,
    /// Most bytes to send, whatever the bandwidth.
    pub max_bytes: Option<u64>,
    /// Coarsest tier of motions that may be chosen, and finest; both inclusive.
    pub finest_tier: u32,
    /// Greatest longer side of a texture, in pixels.
    pub max_texture_px: Option<u32>,
    /// Effort of the search for a proof that the choice is best.
    pub effort: u32,
}

impl Default for AdaptOptions {
    /// All that fits in two seconds.
    fn default() -> Self {
        Self {
            wait_secs: 2.0,
            max_bytes: None,
            finest_tier: 0,
            max_texture_px: None,
            effort: ChoiceRequest::EFFORT,
        }
    }
}
