//! BSDLink: ties a resource to its description, its AQoS and the transformation, and names the
//! parameters that the decision sets.
//!
//! Form: `docs/formats/did.md`. Source: ISO/IEC 21000-7 (BSDLink), annex B of the thesis.

use super::aqos::Pins;
use super::gbsd::Selection;
use super::item_path::ItemPath;
use super::xml::{Document, escape};
use crate::error::StreamError;
use articula_core::Mismatch;
use std::fmt::Write;

/// A link from a resource to what adapts it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BsdLink {
    /// The AQoS, by which the parameters are decided.
    pub steering: Option<ItemPath>,
    /// The gBSD of the resource.
    pub description: ItemPath,
    /// The stylesheet that transforms the gBSD.
    pub transformation: Option<ItemPath>,
    /// Parameters of the transformation: name, and name of the pin of the AQoS that sets it.
    pub parameters: Vec<(String, String)>,
}

impl BsdLink {
    /// What to keep of the resource by the values of pins. Whole numbers alone can be passed on.
    ///
    /// # Errors
    /// A [`Mismatch`] that names the parameter, for a pin without a value, and a parameter or value
    /// that a [`Selection`] does not have.
    pub fn selection(&self, values: &Pins) -> Result<Selection, Mismatch> {
        let mut selection = Selection::default();
        for (name, pin) in &self.parameters {
            let value = values.get(pin).ok_or_else(|| {
                Mismatch::new(name.as_str(), format!("the pin {pin} has no value"))
            })?;
            // Eight digits, of which the first may be 0.
            let width = if name == "faceLevels" { 8 } else { 0 };
            selection.set(name, &format!("{value:0width$}"))?;
        }
        Ok(selection)
    }

    /// Reads the link in an element: the `Description`.
    pub(super) fn read(document: &Document<'_>, element: usize) -> Result<Self, StreamError> {
        let reference = |name: &str| {
            let Some(found) = document.child(element, name) else {
                return Ok(None);
            };
            let uri = document.value(found, "uri").unwrap_or_default();
            let path: Result<ItemPath, Mismatch> = uri.parse();
            path.map(Some)
                .map_err(|e| document.bad(found, e.to_string()))
        };
        let description = reference("BSDRef")?
            .ok_or_else(|| document.bad(element, "a BSDLink without BSDRef"))?;
        let parameters = document
            .children(element)
            .filter(|c| document.is(*c, "Parameter"));
        let parameters = parameters.map(|parameter| {
            let name = document.value(parameter, "name").unwrap_or_default();
            let value = document.child(parameter, "Value");
            let pin = value.map_or("", |value| document.text(value));
            if name.is_empty() || pin.is_empty() {
                let what = "expected a Parameter with a name and the name of a pin";
                return Err(document.bad(parameter, what));
            }
            Ok((name.to_owned(), pin.to_owned()))
        });
        let parameters = parameters.collect::<Result<_, StreamError>>()?;
        Ok(Self {
            steering: reference("SteeringDescriptionRef")?,
            description,
            transformation: reference("BSDTransformationRef")?,
            parameters,
        })
    }

    /// Writes the link with the prefix `dia`.
    pub(super) fn write(&self, out: &mut String) {
        out.push_str("<dia:DIA><dia:Description xsi:type=\"dia:BSDLinkType\">\n");
        let mut reference = |name: &str, path: Option<&ItemPath>| {
            if let Some(path) = path {
                // Writing to a text cannot fail.
                let _ = writeln!(out, "<dia:{name} uri=\"{}\"/>", escape(path.as_str()));
            }
        };
        reference("SteeringDescriptionRef", self.steering.as_ref());
        reference("BSDRef", Some(&self.description));
        reference("BSDTransformationRef", self.transformation.as_ref());
        for (name, pin) in &self.parameters {
            let _ = writeln!(
                out,
                "<dia:Parameter xsi:type=\"dia:IOPinRefType\" name=\"{}\"><dia:Value>{}</dia:Value></dia:Parameter>",
                escape(name),
                escape(pin)
            );
        }
        out.push_str("</dia:Description></dia:DIA>");
    }
}
