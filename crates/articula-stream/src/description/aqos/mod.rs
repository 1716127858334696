//! AQoS: from what is known of a context to the parameters of an adaptation, by tables that the
//! author of a stream gives with it.
//!
//! Form: `docs/formats/aqos.md`. Source: ISO/IEC 21000-7 (AdaptationQoS and universal constraints),
//! thesis 3.1.1 and annex B.

mod evaluate;
mod expression;
mod read;
mod table;
mod write;

use super::context::Context;
use articula_core::Mismatch;
use std::collections::BTreeMap;

pub use evaluate::Decided;
pub use expression::{Expression, Term};
pub use table::{Axis, Content, LookUpTable};

/// Values of pins by their names.
pub type Pins = BTreeMap<String, f64>;

/// A named value: of the context, of a choice, or a result.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct IoPin {
    /// Its name.
    pub id: String,
    /// The term of the context that it takes its value from: the name of a field of a
    /// [`Context`], `usable_bps` or a region of its emphasis, without regard to case, `-` and `_`.
    pub semantics: Option<String>,
    /// Values to choose from, of a pin that is neither told nor a result.
    pub choices: Vec<f64>,
}

/// Values of a pin, one for each point of a utility function.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name of the pin.
    pub pin: String,
    /// A value for each point.
    pub values: Vec<f64>,
}

/// Points of operation: what each needs, sets and is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct UtilityFunction {
    /// What a point needs at most of each input, such as its bit rate.
    pub constraints: Vec<Column>,
    /// What it sets each output to.
    pub operators: Vec<Column>,
    /// What it is worth; its pin is a result, too.
    pub utility: Column,
}

/// A result computed from other pins.
#[derive(Debug, Clone, PartialEq)]
pub struct StackFunction {
    /// Name of the result.
    pub pin: String,
    /// How it is computed.
    pub expression: Expression,
}

/// A step of the decision.
#[derive(Debug, Clone, PartialEq)]
pub enum Module {
    /// Results by a table.
    LookUpTable(LookUpTable),
    /// Results of the best point that fits.
    UtilityFunction(UtilityFunction),
    /// One computed result.
    StackFunction(StackFunction),
}

/// What is best.
#[derive(Debug, Clone, PartialEq)]
pub enum Objective {
    /// The greatest value.
    Maximise(Expression),
    /// The least value.
    Minimise(Expression),
}

/// Universal constraints: what must hold, and what is best.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Constraints {
    /// Conditions that are not 0.
    pub limits: Vec<Expression>,
    /// Chooses among values that keep all limits; without it the first stay.
    pub objective: Option<Objective>,
}

/// How an adaptation follows from the context of use.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Aqos {
    /// Steps, in any order.
    pub modules: Vec<Module>,
    /// All pins.
    pub pins: Vec<IoPin>,
    /// Constraints of the author; those of a user can be added.
    pub constraints: Constraints,
}

/// Names of the pins of annex B of the thesis.
pub const BANDWIDTH: &str = "BANDWIDTH";
/// See [`BANDWIDTH`].
pub const LAYERS: &str = "LAYERS_OF_SCALABLE_BBA";
/// Term of the bandwidth that can be used, in bits per second.
const USABLE: &str = "usable_bps";

impl Aqos {
    /// The table of annex B of the thesis: the level of articulation by the bandwidth, one level for
    /// each of some rising bit rates. Below the first it is level 0.
    pub fn one_to_one(rates_bps: &[f64]) -> Self {
        let table = LookUpTable {
            axes: vec![Axis {
                pin: BANDWIDTH.into(),
                values: rates_bps.to_vec(),
            }],
            contents: vec![Content {
                pin: LAYERS.into(),
                values: (0..rates_bps.len()).map(|level| level as f64).collect(),
                is_linear: false,
            }],
        };
        let pin = |id: &str, semantics: Option<&str>| IoPin {
            id: id.into(),
            semantics: semantics.map(|term| format!(":VH:{term}")),
            choices: Vec::new(),
        };
        Self {
            modules: vec![Module::LookUpTable(table)],
            pins: vec![pin(BANDWIDTH, Some(USABLE)), pin(LAYERS, None)],
            constraints: Constraints::default(),
        }
    }

    /// The values that a context gives to pins: by their semantics, else by their names. Pins of
    /// which it knows nothing are left out.
    pub fn bind(&self, context: &Context) -> Pins {
        let known = context_pins(context);
        let outputs = self.outputs();
        let mut pins = Pins::new();
        for pin in self
            .pins
            .iter()
            .filter(|pin| !outputs.contains(&pin.id.as_str()))
        {
            let term = pin.semantics.as_deref().unwrap_or(&pin.id);
            // The part after the alias.
            let term = term.rsplit(':').next().unwrap_or(term);
            let found = known.iter().find(|(name, _)| same(name, term));
            let found = found.or_else(|| known.iter().find(|(name, _)| same(name, &pin.id)));
            if let Some((_, value)) = found {
                pins.insert(pin.id.clone(), *value);
            }
        }
        pins
    }

    /// Names of the pins that modules set.
    fn outputs(&self) -> Vec<&str> {
        self.modules.iter().flat_map(Module::outputs).collect()
    }

    /// Checks that pins have different names and one module each, that tables and points have as
    /// many values as they need, and that every number is finite.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the pin.
    pub fn check(&self) -> Result<(), Mismatch> {
        let mut names: Vec<&str> = self.pins.iter().map(|pin| pin.id.as_str()).collect();
        names.sort_unstable();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Mismatch::new(twice[0], "two pins of this name"));
        }
        let mut outputs = self.outputs();
        outputs.sort_unstable();
        if let Some(twice) = outputs.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Mismatch::new(twice[0], "set by two modules"));
        }
        let is_known = |name: &&str| names.binary_search(name).is_ok();
        let limits = self
            .constraints
            .limits
            .iter()
            .chain(
                self.constraints
                    .objective
                    .iter()
                    .map(|objective| match objective {
                        Objective::Maximise(expression) | Objective::Minimise(expression) => {
                            expression
                        }
                    }),
            );
        let used = self.modules.iter().flat_map(Module::inputs);
        let used = used.chain(limits.flat_map(Expression::pins));
        let mut used = used.chain(outputs.iter().copied());
        if let Some(unknown) = used.find(|name| !is_known(name)) {
            return Err(Mismatch::new(unknown, "there is no pin of this name"));
        }
        for pin in &self.pins {
            finite(&pin.id, &pin.choices)?;
        }
        self.modules.iter().try_for_each(Module::check)
    }
}

/// Whether two terms are the same, without regard to case, `-` and `_`.
fn same(a: &str, b: &str) -> bool {
    let plain = |text: &str| -> Vec<u8> {
        let bytes = text.bytes().filter(|byte| !b"-_".contains(byte));
        bytes.map(|byte| byte.to_ascii_lowercase()).collect()
    };
    plain(a) == plain(b)
}

/// What is known of a context, by the names of its fields ([`Context`]); besides `usable_bps`, of
/// which `bandwidth` and `available_bandwidth` are other names, and the weights of
/// [`emphasis`](super::Preferences::emphasis).
fn context_pins(context: &Context) -> Vec<(&'static str, f64)> {
    let (n, t, v) = (&context.network, &context.terminal, &context.view);
    let wishes = &context.preferences;
    let usable = n.usable_bps();
    let whole = |value: Option<u8>| value.map(f64::from);
    let [geometry, texture, animation] = wishes.emphasis();
    let all = [
        (USABLE, usable),
        ("bandwidth", usable),
        ("available_bandwidth", usable),
        ("max_capacity_bps", n.max_capacity_bps),
        ("min_guaranteed_bps", n.min_guaranteed_bps),
        ("available_bps", n.available_bps),
        ("min_available_bps", n.min_available_bps),
        ("max_available_bps", n.max_available_bps),
        ("one_way_delay_ms", n.one_way_delay_ms),
        ("two_way_delay_ms", n.two_way_delay_ms),
        ("delay_variation_ms", n.delay_variation_ms),
        ("packet_loss", n.packet_loss),
        ("bit_errors", n.bit_errors),
        ("width_px", t.width_px),
        ("height_px", t.height_px),
        ("refresh_hz", t.refresh_hz),
        ("joints_per_ms", t.joints_per_ms),
        ("faps_per_ms", t.faps_per_ms),
        ("triangles_per_s", t.triangles_per_s),
        ("frame_budget_ms", t.frame_budget_ms),
        ("memory_bytes", t.memory_bytes),
        ("geometry_emphasis", Some(geometry)),
        ("texture_emphasis", Some(texture)),
        ("animation_emphasis", Some(animation)),
        ("body_loa", whole(wishes.body_loa)),
        ("body_regions", whole(wishes.body_regions)),
        ("mesh_level", wishes.mesh_level.map(f64::from)),
        ("frame_rate_hz", wishes.frame_rate_hz),
        ("prefer_smooth", wishes.prefer_smooth),
        ("prefer_detail", wishes.prefer_detail),
        ("tolerance_px", wishes.tolerance_px),
        ("distance_m", v.distance_m),
        ("fov_rad", v.fov_rad),
        ("body_focus", whole(v.body_focus)),
        ("face_focus", whole(v.face_focus)),
    ];
    let known = all
        .into_iter()
        .filter_map(|(name, value)| Some((name, value?)));
    known.collect()
}

impl Module {
    fn outputs(&self) -> Vec<&str> {
        match self {
            Self::LookUpTable(table) => table.contents.iter().map(|c| c.pin.as_str()).collect(),
            Self::UtilityFunction(utility) => {
                let operators = utility.operators.iter().chain([&utility.utility]);
                operators.map(|column| column.pin.as_str()).collect()
            }
            Self::StackFunction(function) => vec![&function.pin],
        }
    }

    fn inputs(&self) -> Vec<&str> {
        match self {
            Self::LookUpTable(table) => table.axes.iter().map(|axis| axis.pin.as_str()).collect(),
            Self::UtilityFunction(utility) => utility
                .constraints
                .iter()
                .map(|column| column.pin.as_str())
                .collect(),
            Self::StackFunction(function) => function.expression.pins(),
        }
    }

    fn check(&self) -> Result<(), Mismatch> {
        match self {
            Self::LookUpTable(table) => table.check(),
            Self::UtilityFunction(utility) => utility.check(),
            Self::StackFunction(function) => function.expression.check(),
        }
    }
}

impl UtilityFunction {
    fn check(&self) -> Result<(), Mismatch> {
        let points = self.utility.values.len();
        if points == 0 {
            return Err(Mismatch::new(self.utility.pin.as_str(), "no points"));
        }
        let all = self.constraints.iter().chain(&self.operators);
        for column in all.chain([&self.utility]) {
            if column.values.len() != points {
                let what = format!("{} values for {points} points", column.values.len());
                return Err(Mismatch::new(column.pin.as_str(), what));
            }
            finite(&column.pin, &column.values)?;
        }
        Ok(())
    }
}

fn finite(pin: &str, values: &[f64]) -> Result<(), Mismatch> {
    match values.iter().find(|value| !value.is_finite()) {
        Some(found) => Err(Mismatch::new(
            pin,
            format!("found {found}, expected finite numbers"),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
