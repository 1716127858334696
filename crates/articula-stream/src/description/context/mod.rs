//! The context of use: what is known of network, device, viewer and view.
//!
//! Source: ISO/IEC 21000-7 (usage environment description, in its XML form XDI), thesis 3.1.1. A
//! context says what is there and what is wanted, never what to send; that is a decision.

mod benchmark;
#[cfg(feature = "json")]
mod json;
mod leaves;
mod xdi;
mod xdi_write;

pub use benchmark::Benchmark;

use super::xml::is_allowed;
use articula_core::Mismatch;

/// What is known of the place where a stream is used. Every number is optional: `None` is unknown,
/// not 0.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Context {
    /// The way from server to client.
    pub network: Network,
    /// The device.
    pub terminal: Terminal,
    /// What the viewer asks for.
    pub preferences: Preferences,
    /// How the character is seen.
    pub view: View,
}

/// Capability and condition of a network, from server to client.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Network {
    /// Bits per second that the link can carry at most.
    pub max_capacity_bps: Option<f64>,
    /// Bits per second that are guaranteed.
    pub min_guaranteed_bps: Option<f64>,
    /// Bits per second that are available now, on average.
    pub available_bps: Option<f64>,
    /// The least of the recent past.
    pub min_available_bps: Option<f64>,
    /// The most of the recent past.
    pub max_available_bps: Option<f64>,
    /// Milliseconds of a packet from server to client.
    pub one_way_delay_ms: Option<f64>,
    /// Milliseconds of a packet to the other side and of its answer.
    pub two_way_delay_ms: Option<f64>,
    /// Variation of the delay in milliseconds.
    pub delay_variation_ms: Option<f64>,
    /// Share of packets that are lost, 0 to 1.
    pub packet_loss: Option<f64>,
    /// Share of bits that are wrong, 0 to 1.
    pub bit_errors: Option<f64>,
}

/// Display, speed and memory of a device.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Terminal {
    /// Width of the display, or of the part that shows the character, in pixels.
    pub width_px: Option<f64>,
    /// Its height in pixels.
    pub height_px: Option<f64>,
    /// Frames per second that the display shows at most.
    pub refresh_hz: Option<f64>,
    /// Joints that the device evaluates per millisecond.
    pub joints_per_ms: Option<f64>,
    /// Face parameters that it applies per millisecond.
    pub faps_per_ms: Option<f64>,
    /// Triangles that it draws per second.
    pub triangles_per_s: Option<f64>,
    /// Milliseconds of each frame that are left for characters.
    pub frame_budget_ms: Option<f64>,
    /// Bytes of memory that are left for characters.
    pub memory_bytes: Option<f64>,
    /// Names of the codecs that it decodes, such as `abp2`; empty if unknown.
    pub codecs: Vec<String>,
    /// Results of benchmarks.
    pub benchmarks: Vec<Benchmark>,
}

/// In what form a character is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "json", derive(serde::Serialize, serde::Deserialize))]
pub enum Modality {
    /// A mesh in three dimensions.
    #[cfg_attr(feature = "json", serde(rename = "3D"))]
    Mesh,
    /// A warped portrait.
    #[cfg_attr(feature = "json", serde(rename = "2DWarp"))]
    Warp,
    /// Vector graphics.
    #[cfg_attr(feature = "json", serde(rename = "2DVector"))]
    Vector,
}

impl Modality {
    /// All forms.
    pub const ALL: [Self; 3] = [Self::Mesh, Self::Warp, Self::Vector];

    /// The name in a context: `3D`, `2DWarp` or `2DVector`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "3D",
            Self::Warp => "2DWarp",
            Self::Vector => "2DVector",
        }
    }
}

/// What a viewer asks for. Preferences never exceed what network and terminal allow.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Preferences {
    /// Weight of the shape, at least 0, relative to the other two.
    pub geometry_emphasis: Option<f64>,
    /// Weight of the pictures on it.
    pub texture_emphasis: Option<f64>,
    /// Weight of its motion.
    pub animation_emphasis: Option<f64>,
    /// Finest level of articulation of the body, 0 (coarsest) to 5.
    pub body_loa: Option<u8>,
    /// Regions of the body that matter: bit `r - 1` is region `r` of H-Anim, 1 to 7, as in
    /// [`articula_core::Zone`].
    pub body_regions: Option<u8>,
    /// Finest level of articulation of each region of the face, 0 (very low) to 3 (high), in the
    /// order of [`articula_core::face_levels::FaceRegion`].
    pub face_loa: Option<[u8; 8]>,
    /// Finest mesh level, 0 is the finest of the character.
    pub mesh_level: Option<u32>,
    /// Form in which the character is shown.
    pub modality: Option<Modality>,
    /// Frames per second.
    pub frame_rate_hz: Option<f64>,
    /// How much even motion matters, 0 to 1.
    pub prefer_smooth: Option<f64>,
    /// How much detail matters, 0 to 1.
    pub prefer_detail: Option<f64>,
    /// Greatest error on the screen, in pixels.
    pub tolerance_px: Option<f64>,
}

/// How a character is seen.
#[derive(Debug, Clone, Default, PartialEq)]
#[cfg_attr(
    feature = "json",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct View {
    /// Metres from the camera to the character.
    pub distance_m: Option<f64>,
    /// Vertical angle of view in radians, below π.
    pub fov_rad: Option<f64>,
    /// Regions of the body that the viewer looks at, as [`Preferences::body_regions`].
    pub body_focus: Option<u8>,
    /// Regions of the face that the viewer looks at: bit `r` is region `r`, 0 to 7, in the order
    /// of [`articula_core::face_levels::FaceRegion`].
    pub face_focus: Option<u8>,
}

impl Network {
    /// Bits per second to reckon with: those available on average, else the least available, else
    /// the guaranteed, else the capacity; never more than the capacity.
    pub fn usable_bps(&self) -> Option<f64> {
        let found = self
            .available_bps
            .or(self.min_available_bps)
            .or(self.min_guaranteed_bps);
        least(found, self.max_capacity_bps)
    }
}

impl Preferences {
    /// Weights of shape, pictures and motion with the sum 1. One that is missing counts as much as
    /// the mean of the others; all are equal if none is given, or all are 0.
    pub fn emphasis(&self) -> [f64; 3] {
        let told = [
            self.geometry_emphasis,
            self.texture_emphasis,
            self.animation_emphasis,
        ];
        let known = told.iter().flatten();
        let mean = known.clone().sum::<f64>() / known.count().max(1) as f64;
        let weights = told.map(|weight| weight.unwrap_or(mean));
        let sum: f64 = weights.iter().sum();
        if sum > 0.0 && sum.is_finite() {
            weights.map(|weight| weight / sum)
        } else {
            [1.0 / 3.0; 3]
        }
    }
}

impl Context {
    /// Combines the contexts of both ends of a connection:
    ///
    /// - bandwidths, display, speeds, times and memory: the smaller number, as both ends bound them;
    /// - delays, losses and errors: the greater number, the more cautious estimate;
    /// - codecs: those of the client that the server has, too; those of the other end if one lists
    ///   none;
    /// - benchmarks: those of the same name together, each end with what it knows;
    /// - preferences and view: those of the client; what it does not tell is that of the server.
    ///
    /// A number that one end does not know is that of the other.
    #[must_use]
    pub fn aggregate(client: &Self, server: &Self) -> Self {
        let ends = (&client.network, &server.network);
        let network = Network {
            max_capacity_bps: least(ends.0.max_capacity_bps, ends.1.max_capacity_bps),
            min_guaranteed_bps: least(ends.0.min_guaranteed_bps, ends.1.min_guaranteed_bps),
            available_bps: least(ends.0.available_bps, ends.1.available_bps),
            min_available_bps: least(ends.0.min_available_bps, ends.1.min_available_bps),
            max_available_bps: least(ends.0.max_available_bps, ends.1.max_available_bps),
            one_way_delay_ms: most(ends.0.one_way_delay_ms, ends.1.one_way_delay_ms),
            two_way_delay_ms: most(ends.0.two_way_delay_ms, ends.1.two_way_delay_ms),
            delay_variation_ms: most(ends.0.delay_variation_ms, ends.1.delay_variation_ms),
            packet_loss: most(ends.0.packet_loss, ends.1.packet_loss),
            bit_errors: most(ends.0.bit_errors, ends.1.bit_errors),
        };
        let ends = (&client.terminal, &server.terminal);
        let terminal = Terminal {
            width_px: least(ends.0.width_px, ends.1.width_px),
            height_px: least(ends.0.height_px, ends.1.height_px),
            refresh_hz: least(ends.0.refresh_hz, ends.1.refresh_hz),
            joints_per_ms: least(ends.0.joints_per_ms, ends.1.joints_per_ms),
            faps_per_ms: least(ends.0.faps_per_ms, ends.1.faps_per_ms),
            triangles_per_s: least(ends.0.triangles_per_s, ends.1.triangles_per_s),
            frame_budget_ms: least(ends.0.frame_budget_ms, ends.1.frame_budget_ms),
            memory_bytes: least(ends.0.memory_bytes, ends.1.memory_bytes),
            codecs: shared(&ends.0.codecs, &ends.1.codecs),
            benchmarks: benchmark::both(&ends.0.benchmarks, &ends.1.benchmarks),
        };
        Self {
            network,
            terminal,
            preferences: preferences(&client.preferences, &server.preferences),
            view: view(&client.view, &server.view),
        }
    }

    /// Checks that numbers are finite and within the bounds of their description.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first value outside of its bounds.
    pub fn check(&self) -> Result<(), Mismatch> {
        let inside = |name: &str, value: Option<f64>, most: f64| match value {
            Some(found) if !(0.0..=most).contains(&found) => {
                let most = if most == f64::MAX {
                    String::from("a finite number from 0 on")
                } else {
                    format!("0 to {most}")
                };
                Err(Mismatch::new(
                    name,
                    format!("found {found}, expected {most}"),
                ))
            }
            _ => Ok(()),
        };
        for (name, value) in self.numbers() {
            inside(name, value, f64::MAX)?;
        }
        for (name, value) in self.shares() {
            inside(name, value, 1.0)?;
        }
        let preferences = &self.preferences;
        let whole = |value: Option<u8>| value.map(f64::from);
        inside("body_loa", whole(preferences.body_loa), 5.0)?;
        inside("body_regions", whole(preferences.body_regions), 127.0)?;
        inside("body_focus", whole(self.view.body_focus), 127.0)?;
        for level in preferences.face_loa.into_iter().flatten() {
            inside("face_loa", whole(Some(level)), 3.0)?;
        }
        inside("fov_rad", self.view.fov_rad, std::f64::consts::PI)?;
        benchmark::check(&self.terminal.benchmarks)?;
        if let Some(name) = self.terminal.codecs.iter().find(|name| !is_word(name)) {
            let what = format!(
                "found \"{name}\", expected names without white space or control characters"
            );
            return Err(Mismatch::new("codecs", what));
        }
        let network = &self.network;
        let rising = [
            network.min_available_bps,
            network.available_bps,
            network.max_available_bps,
        ];
        let known: Vec<f64> = rising.into_iter().flatten().collect();
        if known.is_sorted() {
            return Ok(());
        }
        let what = format!("minimum, average and maximum must rise, found {known:?}");
        Err(Mismatch::new("available_bps", what))
    }

    /// Numbers without an upper bound.
    fn numbers(&self) -> [(&'static str, Option<f64>); 22] {
        let (n, t, p) = (&self.network, &self.terminal, &self.preferences);
        [
            ("max_capacity_bps", n.max_capacity_bps),
            ("min_guaranteed_bps", n.min_guaranteed_bps),
            ("available_bps", n.available_bps),
            ("min_available_bps", n.min_available_bps),
            ("max_available_bps", n.max_available_bps),
            ("one_way_delay_ms", n.one_way_delay_ms),
            ("two_way_delay_ms", n.two_way_delay_ms),
            ("delay_variation_ms", n.delay_variation_ms),
            ("width_px", t.width_px),
            ("height_px", t.height_px),
            ("refresh_hz", t.refresh_hz),
            ("joints_per_ms", t.joints_per_ms),
            ("faps_per_ms", t.faps_per_ms),
            ("triangles_per_s", t.triangles_per_s),
            ("frame_budget_ms", t.frame_budget_ms),
            ("memory_bytes", t.memory_bytes),
            ("geometry_emphasis", p.geometry_emphasis),
            ("texture_emphasis", p.texture_emphasis),
            ("animation_emphasis", p.animation_emphasis),
            ("frame_rate_hz", p.frame_rate_hz),
            ("tolerance_px", p.tolerance_px),
            ("distance_m", self.view.distance_m),
        ]
    }

    fn shares(&self) -> [(&'static str, Option<f64>); 4] {
        [
            ("packet_loss", self.network.packet_loss),
            ("bit_errors", self.network.bit_errors),
            ("prefer_smooth", self.preferences.prefer_smooth),
            ("prefer_detail", self.preferences.prefer_detail),
        ]
    }
}

/// Whether a name has letters and no white space.
fn is_word(name: &str) -> bool {
    let is_letter = |c: char| !c.is_whitespace() && is_allowed(c);
    !name.is_empty() && name.chars().all(is_letter)
}

fn least(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.min(b)),
        _ => a.or(b),
    }
}

fn most(a: Option<f64>, b: Option<f64>) -> Option<f64> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a.max(b)),
        _ => a.or(b),
    }
}

fn shared(client: &[String], server: &[String]) -> Vec<String> {
    match (client, server) {
        ([], other) | (other, []) => other.to_vec(),
        _ => {
            let common = client.iter().filter(|name| server.contains(name));
            common.cloned().collect()
        }
    }
}

fn preferences(client: &Preferences, server: &Preferences) -> Preferences {
    Preferences {
        geometry_emphasis: client.geometry_emphasis.or(server.geometry_emphasis),
        texture_emphasis: client.texture_emphasis.or(server.texture_emphasis),
        animation_emphasis: client.animation_emphasis.or(server.animation_emphasis),
        body_loa: client.body_loa.or(server.body_loa),
        body_regions: client.body_regions.or(server.body_regions),
        face_loa: client.face_loa.or(server.face_loa),
        mesh_level: client.mesh_level.or(server.mesh_level),
        modality: client.modality.or(server.modality),
        frame_rate_hz: client.frame_rate_hz.or(server.frame_rate_hz),
        prefer_smooth: client.prefer_smooth.or(server.prefer_smooth),
        prefer_detail: client.prefer_detail.or(server.prefer_detail),
        tolerance_px: client.tolerance_px.or(server.tolerance_px),
    }
}

fn view(client: &View, server: &View) -> View {
    View {
        distance_m: client.distance_m.or(server.distance_m),
        fov_rad: client.fov_rad.or(server.fov_rad),
        body_focus: client.body_focus.or(server.body_focus),
        face_focus: client.face_focus.or(server.face_focus),
    }
}

#[cfg(test)]
mod tests;
