//! Where the numbers of a context stand in XML.

use super::Context;

/// Where a number of a context stands in XML.
pub(super) struct Leaf {
    pub(super) block: Block,
    pub(super) element: &'static str,
    /// Name of the attribute; the text of the element if empty.
    pub(super) attribute: &'static str,
    pub(super) of: fn(&mut Context) -> &mut Option<f64>,
}

/// Elements around a leaf.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Block {
    Capability,
    Condition,
    Mode,
    Benchmark,
    Graphics,
    Wishes,
    View,
}

const fn leaf(
    block: Block,
    element: &'static str,
    attribute: &'static str,
    of: fn(&mut Context) -> &mut Option<f64>,
) -> Leaf {
    Leaf {
        block,
        element,
        attribute,
        of,
    }
}

/// All numbers, those of one element next to each other.
pub(super) const LEAVES: &[Leaf] = &[
    leaf(
        Block::Capability,
        "NetworkCharacteristic",
        "maxCapacity",
        |c| &mut c.network.max_capacity_bps,
    ),
    leaf(
        Block::Capability,
        "NetworkCharacteristic",
        "minGuaranteed",
        |c| &mut c.network.min_guaranteed_bps,
    ),
    leaf(Block::Condition, "AvailableBandwidth", "minimum", |c| {
        &mut c.network.min_available_bps
    }),
    leaf(Block::Condition, "AvailableBandwidth", "average", |c| {
        &mut c.network.available_bps
    }),
    leaf(Block::Condition, "AvailableBandwidth", "maximum", |c| {
        &mut c.network.max_available_bps
    }),
    leaf(Block::Condition, "Delay", "packetOneWay", |c| {
        &mut c.network.one_way_delay_ms
    }),
    leaf(Block::Condition, "Delay", "packetTwoWay", |c| {
        &mut c.network.two_way_delay_ms
    }),
    leaf(Block::Condition, "Delay", "delayVariation", |c| {
        &mut c.network.delay_variation_ms
    }),
    leaf(Block::Condition, "Error", "packetLossRate", |c| {
        &mut c.network.packet_loss
    }),
    leaf(Block::Condition, "Error", "bitErrorRate", |c| {
        &mut c.network.bit_errors
    }),
    leaf(Block::Mode, "Mode", "refreshRate", |c| {
        &mut c.terminal.refresh_hz
    }),
    leaf(Block::Mode, "Resolution", "horizontal", |c| {
        &mut c.terminal.width_px
    }),
    leaf(Block::Mode, "Resolution", "vertical", |c| {
        &mut c.terminal.height_px
    }),
    leaf(Block::Benchmark, "JointsPerMs", "", |c| {
        &mut c.terminal.joints_per_ms
    }),
    leaf(Block::Benchmark, "FapsPerMs", "", |c| {
        &mut c.terminal.faps_per_ms
    }),
    leaf(Block::Benchmark, "TrianglesPerSecond", "", |c| {
        &mut c.terminal.triangles_per_s
    }),
    leaf(Block::Benchmark, "FrameBudgetMs", "", |c| {
        &mut c.terminal.frame_budget_ms
    }),
    leaf(Block::Benchmark, "MemoryBytes", "", |c| {
        &mut c.terminal.memory_bytes
    }),
    leaf(Block::Graphics, "GeometryEmphasis", "", |c| {
        &mut c.preferences.geometry_emphasis
    }),
    leaf(Block::Graphics, "TextureEmphasis", "", |c| {
        &mut c.preferences.texture_emphasis
    }),
    leaf(Block::Graphics, "AnimationEmphasis", "", |c| {
        &mut c.preferences.animation_emphasis
    }),
    leaf(Block::Wishes, "FrameRate", "", |c| {
        &mut c.preferences.frame_rate_hz
    }),
    leaf(Block::Wishes, "PreferSmooth", "", |c| {
        &mut c.preferences.prefer_smooth
    }),
    leaf(Block::Wishes, "PreferDetail", "", |c| {
        &mut c.preferences.prefer_detail
    }),
    leaf(Block::Wishes, "TolerancePx", "", |c| {
        &mut c.preferences.tolerance_px
    }),
    leaf(Block::View, "ViewDistance", "", |c| &mut c.view.distance_m),
    leaf(Block::View, "FieldOfView", "", |c| &mut c.view.fov_rad),
];
