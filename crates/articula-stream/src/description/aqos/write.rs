//! AQoS and universal constraints to XML.

use super::{Aqos, Column, Constraints, Module, Objective};
use crate::description::xml::escape;
use std::fmt::Write;

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <DIA xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" xmlns:mpeg7=\"urn:mpeg:mpeg7:schema:2001\" \
    xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n\
    <DescriptionMetadata><ClassificationSchemeAlias alias=\"AQoS\" \
    href=\"urn:mpeg:mpeg21:2003:01-DIA-AdaptationQoSCS-NS\"/><ClassificationSchemeAlias alias=\"VH\" \
    href=\"urn:articula:vh:1\"/></DescriptionMetadata>\n";

impl Aqos {
    /// Writes the AQoS, and its constraints as universal constraints in the same document, so that
    /// [`Aqos::read`] gives it back.
    pub fn write(&self) -> String {
        let mut out = String::from(HEAD);
        out.push_str("<Description xsi:type=\"AdaptationQoSType\">\n");
        for module in &self.modules {
            write_module(&mut out, module);
        }
        for pin in &self.pins {
            let id = escape(&pin.id);
            let mut inner = String::new();
            // Writing to a text cannot fail.
            if let Some(term) = &pin.semantics {
                let term = escape(term);
                let _ = write!(
                    inner,
                    "<GetValue xsi:type=\"SemanticalDataRefType\" semantics=\"{term}\"/>"
                );
            }
            if !pin.choices.is_empty() {
                let _ = write!(inner, "<Choices>{}</Choices>", list(&pin.choices));
            }
            let _ = match inner.as_str() {
                "" => writeln!(out, "<IOPin id=\"{id}\"/>"),
                inner => writeln!(out, "<IOPin id=\"{id}\">{inner}</IOPin>"),
            };
        }
        out.push_str("</Description>\n");
        if self.constraints != Constraints::default() {
            write_constraints(&mut out, &self.constraints);
        }
        out.push_str("</DIA>\n");
        out
    }
}

impl Constraints {
    /// Writes universal constraints alone, so that [`Constraints::read`] gives them back.
    pub fn write(&self) -> String {
        let mut out = String::from(HEAD);
        write_constraints(&mut out, self);
        out.push_str("</DIA>\n");
        out
    }
}

fn list(values: &[f64]) -> String {
    let words: Vec<String> = values.iter().map(f64::to_string).collect();
    words.join(" ")
}

/// The kind of numbers of a list, in the words of the schema.
fn kind(values: &[f64]) -> &'static str {
    let are_whole = values.iter().all(|value| value.fract() == 0.0);
    if are_whole { "Integer" } else { "Float" }
}

fn write_module(out: &mut String, module: &Module) {
    match module {
        Module::LookUpTable(table) => {
            out.push_str("<Module xsi:type=\"LookUpTableType\">\n");
            for axis in &table.axes {
                let _ = writeln!(
                    out,
                    "<Axis iOPinRef=\"{}\"><AxisValues xsi:type=\"{}VectorType\"><Vector>{}</Vector>\
                     </AxisValues></Axis>",
                    escape(&axis.pin),
                    kind(&axis.values),
                    list(&axis.values)
                );
            }
            let lengths: Vec<String> = table
                .axes
                .iter()
                .map(|axis| axis.values.len().to_string())
                .collect();
            for content in &table.contents {
                let linear = if content.is_linear {
                    " interpolation=\"linear\""
                } else {
                    ""
                };
                let _ = writeln!(
                    out,
                    "<Content iOPinRef=\"{}\"{linear}><ContentValues xsi:type=\"{}MatrixType\" \
                     mpeg7:dim=\"{}\"><Matrix>{}</Matrix></ContentValues></Content>",
                    escape(&content.pin),
                    kind(&content.values),
                    lengths.join(" "),
                    list(&content.values)
                );
            }
        }
        Module::UtilityFunction(utility) => {
            out.push_str("<Module xsi:type=\"UtilityFunctionType\">\n");
            let mut column = |name: &str, column: &Column| {
                let _ = writeln!(
                    out,
                    "<{name} iOPinRef=\"{}\"><Values xsi:type=\"{}VectorType\"><Vector>{}</Vector></Values></{name}>",
                    escape(&column.pin),
                    kind(&column.values),
                    list(&column.values)
                );
            };
            utility
                .constraints
                .iter()
                .for_each(|c| column("Constraint", c));
            utility
                .operators
                .iter()
                .for_each(|c| column("AdaptationOperator", c));
            column("Utility", &utility.utility);
        }
        Module::StackFunction(function) => {
            let _ = writeln!(
                out,
                "<Module xsi:type=\"StackFunctionType\">\n<StackFunction iOPinRef=\"{}\">{}</StackFunction>",
                escape(&function.pin),
                escape(&function.expression.to_string())
            );
        }
    }
    out.push_str("</Module>\n");
}

fn write_constraints(out: &mut String, constraints: &Constraints) {
    out.push_str("<Description xsi:type=\"UCDType\"><AdaptationUnitConstraints>\n");
    for limit in &constraints.limits {
        let limit = limit.to_string();
        let _ = writeln!(out, "<LimitConstraint>{}</LimitConstraint>", escape(&limit));
    }
    let objective = match &constraints.objective {
        None => None,
        Some(Objective::Maximise(best)) => Some(("maximize", best)),
        Some(Objective::Minimise(best)) => Some(("minimize", best)),
    };
    if let Some((optimize, best)) = objective {
        let best = best.to_string();
        let _ = writeln!(
            out,
            "<OptimizationConstraint optimize=\"{optimize}\">{}</OptimizationConstraint>",
            escape(&best)
        );
    }
    out.push_str("</AdaptationUnitConstraints></Description>\n");
}
