//! AQoS and universal constraints from XML.

use super::{
    Aqos, Axis, Column, Constraints, Content, Expression, IoPin, LookUpTable, Module, Objective,
    StackFunction, UtilityFunction,
};
use crate::description::xml::Document;
use crate::error::StreamError;
use crate::limits::DescriptionLimits;

impl Aqos {
    /// Reads an AQoS, with the universal constraints of the same document if it has some.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line or the pin, for XML that cannot be read, a module that
    /// is not known, and what [`Aqos::check`] refuses.
    pub fn read(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        let description = of_kind(&document, "AdaptationQoSType")
            .ok_or_else(|| document.bad(0, "expected a Description of type AdaptationQoSType"))?;
        let mut aqos = Self::default();
        for element in document.children(description) {
            if document.is(element, "Module") {
                aqos.modules.push(module(&document, element)?);
            } else if document.is(element, "IOPin") {
                aqos.pins.push(pin(&document, element)?);
            }
        }
        if let Some(description) = of_kind(&document, "UCDType") {
            aqos.constraints = constraints(&document, description)?;
        }
        aqos.check()
            .map_err(|e| document.bad(description, e.to_string()))?;
        Ok(aqos)
    }
}

impl Constraints {
    /// Reads universal constraints (UCD) alone, such as those of a user.
    ///
    /// # Errors
    /// As [`Aqos::read`].
    pub fn read(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        let description = of_kind(&document, "UCDType")
            .ok_or_else(|| document.bad(0, "expected a Description of type UCDType"))?;
        constraints(&document, description)
    }
}

fn of_kind(document: &Document<'_>, kind: &str) -> Option<usize> {
    let mut all = 0..document.elements.len();
    all.find(|element| {
        let found = document.kind(*element);
        document.is(*element, "Description") && found.is_some_and(|k| k.eq_ignore_ascii_case(kind))
    })
}

fn pin(document: &Document<'_>, element: usize) -> Result<IoPin, StreamError> {
    let id = document.value(element, "id").unwrap_or_default();
    if id.is_empty() {
        return Err(document.bad(element, "an IOPin without an id"));
    }
    let value = document.child(element, "GetValue");
    let semantics = value.and_then(|value| document.value(value, "semantics"));
    let choices = document.child(element, "Choices");
    Ok(IoPin {
        id: id.to_owned(),
        semantics: semantics.map(|term| term.trim().to_owned()),
        choices: choices.map_or(Ok(Vec::new()), |choices| numbers(document, choices))?,
    })
}

fn numbers(document: &Document<'_>, element: usize) -> Result<Vec<f64>, StreamError> {
    let words = document.text(element).split_ascii_whitespace();
    let number = |word: &str| {
        let found: Option<f64> = word.parse().ok();
        let found = found.filter(|number| number.is_finite());
        found.ok_or_else(|| document.bad(element, format!("\"{word}\", expected a number")))
    };
    words.map(number).collect()
}

fn reference(document: &Document<'_>, element: usize) -> Result<String, StreamError> {
    let found = document.value(element, "iOPinRef").map(str::trim);
    let found = found.filter(|name| !name.is_empty());
    found.map(str::to_owned).ok_or_else(|| {
        let name = document.elements[element].name;
        document.bad(element, format!("{name} without iOPinRef"))
    })
}

/// The numbers of the first element with a name at any depth of another.
fn inside(document: &Document<'_>, of: usize, name: &str) -> Result<Vec<f64>, StreamError> {
    let mut all = of + 1..document.elements[of].end;
    let found = all.find(|element| document.is(*element, name));
    let found = found.ok_or_else(|| {
        let of_name = document.elements[of].name;
        document.bad(of, format!("{of_name} without {name}"))
    })?;
    numbers(document, found)
}

fn module(document: &Document<'_>, element: usize) -> Result<Module, StreamError> {
    let kind = document.kind(element).unwrap_or_default();
    let children = |name: &'static str| {
        document
            .children(element)
            .filter(move |c| document.is(*c, name))
    };
    match kind.to_ascii_lowercase().as_str() {
        "lookuptabletype" => {
            let axes = children("Axis").map(|axis| {
                Ok(Axis {
                    pin: reference(document, axis)?,
                    values: inside(document, axis, "Vector")?,
                })
            });
            let axes = axes.collect::<Result<Vec<_>, StreamError>>()?;
            let contents = children("Content").map(|element| content(document, element, &axes));
            let contents = contents.collect::<Result<_, StreamError>>()?;
            Ok(Module::LookUpTable(LookUpTable { axes, contents }))
        }
        "utilityfunctiontype" => {
            let column = |element: usize| {
                Ok(Column {
                    pin: reference(document, element)?,
                    values: inside(document, element, "Vector")?,
                })
            };
            let columns = |name| {
                children(name)
                    .map(column)
                    .collect::<Result<Vec<_>, StreamError>>()
            };
            let utility = columns("Utility")?.into_iter().next();
            Ok(Module::UtilityFunction(UtilityFunction {
                constraints: columns("Constraint")?,
                operators: columns("AdaptationOperator")?,
                utility: utility
                    .ok_or_else(|| document.bad(element, "a utility function without Utility"))?,
            }))
        }
        "stackfunctiontype" => {
            let function = children("StackFunction").next();
            let function =
                function.ok_or_else(|| document.bad(element, "a module without StackFunction"))?;
            Ok(Module::StackFunction(StackFunction {
                pin: reference(document, function)?,
                expression: expression(document, function)?,
            }))
        }
        _ => {
            let what = "expected LookUpTableType, UtilityFunctionType or StackFunctionType";
            Err(document.bad(element, format!("a Module of type \"{kind}\", {what}")))
        }
    }
}

fn content(document: &Document<'_>, element: usize, axes: &[Axis]) -> Result<Content, StreamError> {
    let interpolation = document.value(element, "interpolation").unwrap_or("floor");
    let is_linear = match interpolation.trim().to_ascii_lowercase().as_str() {
        "linear" => true,
        "floor" => false,
        other => {
            let what = format!("interpolation \"{other}\", expected floor or linear");
            return Err(document.bad(element, what));
        }
    };
    let values = document.child(element, "ContentValues");
    let told = values.and_then(|values| {
        let mut attributes = document.attributes(values).iter();
        attributes.find(|attribute| attribute.name.eq_ignore_ascii_case("dim"))
    });
    let lengths: Vec<String> = axes
        .iter()
        .map(|axis| axis.values.len().to_string())
        .collect();
    if let Some(told) = told
        && !told
            .value
            .split_ascii_whitespace()
            .eq(lengths.iter().map(String::as_str))
    {
        let what = format!(
            "dim \"{}\", but the axes have {}",
            told.value,
            lengths.join(" ")
        );
        return Err(document.bad(element, what));
    }
    Ok(Content {
        pin: reference(document, element)?,
        values: inside(document, element, "Matrix")?,
        is_linear,
    })
}

fn expression(document: &Document<'_>, element: usize) -> Result<Expression, StreamError> {
    let found = document.text(element).parse();
    found.map_err(|e: articula_core::Mismatch| document.bad(element, e.to_string()))
}

fn constraints(document: &Document<'_>, description: usize) -> Result<Constraints, StreamError> {
    let mut found = Constraints::default();
    for element in description + 1..document.elements[description].end {
        if document.is(element, "LimitConstraint") {
            found.limits.push(expression(document, element)?);
        } else if document.is(element, "OptimizationConstraint") {
            if found.objective.is_some() {
                return Err(document.bad(element, "a second objective, expected one"));
            }
            let best = expression(document, element)?;
            let optimize = document.value(element, "optimize").unwrap_or("maximize");
            found.objective = Some(match optimize.trim().to_ascii_lowercase().as_str() {
                "maximize" => Objective::Maximise(best),
                "minimize" => Objective::Minimise(best),
                other => {
                    let what = format!("optimize \"{other}\", expected maximize or minimize");
                    return Err(document.bad(element, what));
                }
            });
        }
    }
    Ok(found)
}
