//! The decision: modules in the order in which they depend on each other, for each combination of
//! choices; the best that keeps all limits.

use super::{Aqos, Module, Objective, Pins, UtilityFunction};
use articula_core::Mismatch;

/// Greatest number of combinations of choices.
const COMBINATIONS: usize = 100_000;

/// What was decided, and why.
#[derive(Debug, Clone, PartialEq)]
pub struct Decided {
    /// The values of all pins.
    pub values: Pins,
    /// One sentence for each step, in order.
    pub reasons: Vec<String>,
}

impl Aqos {
    /// Decides by the values of some pins. All combinations of the choices of pins that are neither
    /// given nor results are tried; of those that keep all limits, the one with the best objective
    /// stays, the first of equal ones.
    ///
    /// # Errors
    /// A [`Mismatch`] for a description that contradicts itself ([`Aqos::check`]), a given value that
    /// is not finite or is a result, a pin that nothing gives a value, more than 100,000
    /// combinations, and limits that no combination keeps.
    pub fn decide(&self, given: &Pins) -> Result<Decided, Mismatch> {
        self.check()?;
        let outputs = self.outputs();
        for (name, value) in given {
            super::finite(name, &[*value])?;
            if outputs.contains(&name.as_str()) {
                return Err(Mismatch::new(
                    name.as_str(),
                    "is a result and cannot be given",
                ));
            }
        }
        let is_free = |id: &str| !given.contains_key(id) && !outputs.contains(&id);
        let free: Vec<_> = self
            .pins
            .iter()
            .filter(|pin| is_free(&pin.id) && !pin.choices.is_empty())
            .collect();
        let combinations = free
            .iter()
            .try_fold(1_usize, |all, pin| all.checked_mul(pin.choices.len()));
        let combinations = combinations
            .filter(|all| *all <= COMBINATIONS)
            .ok_or_else(|| {
                let what = format!("more than {COMBINATIONS} combinations of choices");
                Mismatch::new("AQoS", what)
            })?;
        let mut best: Option<(f64, Decided)> = None;
        let mut refused = None;
        for combination in 0..combinations {
            let (mut values, mut reasons) = (given.clone(), Vec::new());
            let mut rest = combination;
            // The last choice runs fastest.
            for pin in free.iter().rev() {
                let value = pin.choices[rest % pin.choices.len()];
                rest /= pin.choices.len();
                reasons.push(format!(
                    "{} = {value}: one of {} choices",
                    pin.id,
                    pin.choices.len()
                ));
                values.insert(pin.id.clone(), value);
            }
            reasons.reverse();
            let found = self.combination(&mut values, &mut reasons);
            match found {
                Err(wrong) if combinations > 1 => drop(refused.get_or_insert(wrong)),
                Err(wrong) => return Err(wrong),
                Ok(worth) => {
                    let is_better = best.as_ref().is_none_or(|(most, _)| worth > *most);
                    if is_better {
                        best = Some((worth, Decided { values, reasons }));
                    }
                }
            }
        }
        let none = || Mismatch::new("AQoS", "nothing to decide");
        let (_, decided) = best.ok_or_else(|| refused.unwrap_or_else(none))?;
        Ok(decided)
    }

    /// Evaluates all modules, checks the limits and returns the worth.
    fn combination(&self, values: &mut Pins, reasons: &mut Vec<String>) -> Result<f64, Mismatch> {
        let mut waiting: Vec<&Module> = self.modules.iter().collect();
        while !waiting.is_empty() {
            let mut later = Vec::new();
            for module in &waiting {
                let has_inputs = module
                    .inputs()
                    .iter()
                    .all(|name| values.contains_key(*name));
                if has_inputs {
                    module.evaluate(values, reasons)?;
                } else {
                    later.push(*module);
                }
            }
            if later.len() == waiting.len() {
                let inputs = waiting.iter().flat_map(|module| module.inputs());
                let missing = inputs.into_iter().find(|name| !values.contains_key(*name));
                let what = "has no value: the context does not tell it, and no module can set it";
                return Err(Mismatch::new(missing.unwrap_or("AQoS"), what));
            }
            waiting = later;
        }
        let no_value = |text: String| Mismatch::new(text, "names a pin without a value");
        for limit in &self.constraints.limits {
            let value = limit
                .value(values)?
                .ok_or_else(|| no_value(limit.to_string()))?;
            if value == 0.0 {
                return Err(Mismatch::new("limit", format!("\"{limit}\" does not hold")));
            }
            reasons.push(format!("\"{limit}\" holds"));
        }
        let (expression, sign) = match &self.constraints.objective {
            None => return Ok(0.0),
            Some(Objective::Maximise(expression)) => (expression, 1.0),
            Some(Objective::Minimise(expression)) => (expression, -1.0),
        };
        let value = expression
            .value(values)?
            .ok_or_else(|| no_value(expression.to_string()))?;
        let kind = if sign > 0.0 { "greatest" } else { "least" };
        reasons.push(format!(
            "\"{expression}\" = {value}, the {kind} that keeps all limits"
        ));
        Ok(sign * value)
    }
}

impl Module {
    fn evaluate(&self, values: &mut Pins, reasons: &mut Vec<String>) -> Result<(), Mismatch> {
        match self {
            Self::LookUpTable(table) => {
                let of = |name: &String| values.get(name).copied().unwrap_or_default();
                let point: Vec<f64> = table.axes.iter().map(|axis| of(&axis.pin)).collect();
                let inputs: Vec<String> = table
                    .axes
                    .iter()
                    .zip(&point)
                    .map(|(axis, value)| format!("{} = {value}", axis.pin))
                    .collect();
                for content in &table.contents {
                    let value = table.value(content, &point);
                    let how = if content.is_linear {
                        "interpolated"
                    } else {
                        "looked up"
                    };
                    reasons.push(format!(
                        "{} = {value}: {how} at {}",
                        content.pin,
                        inputs.join(", ")
                    ));
                    values.insert(content.pin.clone(), value);
                }
                Ok(())
            }
            Self::UtilityFunction(utility) => utility.evaluate(values, reasons),
            Self::StackFunction(function) => {
                let expression = &function.expression;
                // The inputs are there.
                let value = expression.value(values)?.unwrap_or_default();
                reasons.push(format!("{} = {value}: \"{expression}\"", function.pin));
                values.insert(function.pin.clone(), value);
                Ok(())
            }
        }
    }
}

impl UtilityFunction {
    fn evaluate(&self, values: &mut Pins, reasons: &mut Vec<String>) -> Result<(), Mismatch> {
        let fits = |point: usize| {
            let mut needs = self.constraints.iter();
            needs.all(|column| {
                values
                    .get(&column.pin)
                    .is_some_and(|v| column.values[point] <= *v)
            })
        };
        // Of equal worth, the least of what comes first among the constraints.
        let need = |point: usize| {
            self.constraints
                .first()
                .map_or(0.0, |column| column.values[point])
        };
        let mut best: Option<usize> = None;
        for point in (0..self.utility.values.len()).filter(|point| fits(*point)) {
            let worth = |point: usize| self.utility.values[point];
            let is_better = best.is_none_or(|best| {
                worth(point) > worth(best)
                    || worth(point) == worth(best) && need(point) < need(best)
            });
            if is_better {
                best = Some(point);
            }
        }
        let point = best.ok_or_else(|| {
            let what = "no point needs as little as there is";
            Mismatch::new(self.utility.pin.as_str(), what)
        })?;
        let needs: Vec<String> = self
            .constraints
            .iter()
            .map(|column| format!("{} >= {}", column.pin, column.values[point]))
            .collect();
        for column in self.operators.iter().chain([&self.utility]) {
            values.insert(column.pin.clone(), column.values[point]);
            reasons.push(format!(
                "{} = {}: point {point} is worth most of those that fit ({})",
                column.pin,
                column.values[point],
                needs.join(", ")
            ));
        }
        Ok(())
    }
}
