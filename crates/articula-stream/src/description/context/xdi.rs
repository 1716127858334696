//! Contexts from XML (XDI).
//!
//! Form: `docs/formats/context.md`. The schema of the standard nests its elements in ways that
//! differ between editions, so that a reader takes leaves by their names, wherever they lie.

use super::benchmark::check_count;
use super::leaves::LEAVES;
use super::{Benchmark, Context, Modality};
use crate::description::xml::{Document, whole};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;

impl Context {
    /// Reads a context in XML: the usage environment of a `Description`, in which leaves are found by
    /// name. What is not known is left out.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, for XML that cannot be read, a value that is no number
    /// or is outside of its bounds, and a leaf with two values.
    pub fn read_xdi(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        let description = (0..document.elements.len()).find(|e| document.is(*e, "Description"));
        let description = description
            .ok_or_else(|| document.bad(0, "expected a Description with a usage environment"))?;
        let mut context = Self::default();
        for element in description + 1..document.elements[description].end {
            context.take_numbers(&document, element)?;
            context.take_words(&document, element)?;
            context.take_benchmark(&document, element)?;
        }
        context
            .check()
            .map_err(|e| document.bad(description, e.to_string()))?;
        Ok(context)
    }

    fn take_numbers(&mut self, document: &Document<'_>, element: usize) -> Result<(), StreamError> {
        for leaf in LEAVES {
            if !document.is(element, leaf.element) {
                continue;
            }
            let text = match leaf.attribute {
                "" => Some(document.text(element)),
                name => document.value(element, name),
            };
            if let Some(text) = text {
                let what = if leaf.attribute.is_empty() {
                    leaf.element
                } else {
                    leaf.attribute
                };
                let number: Option<f64> = text.trim().parse().ok();
                let number = number.filter(|number| number.is_finite());
                let wrong =
                    || document.bad(element, format!("{what} \"{text}\", expected a number"));
                put(
                    document,
                    element,
                    (leaf.of)(self),
                    number.ok_or_else(wrong)?,
                )?;
            }
        }
        Ok(())
    }

    fn take_benchmark(
        &mut self,
        document: &Document<'_>,
        element: usize,
    ) -> Result<(), StreamError> {
        if !document.is(element, "Benchmark") {
            return Ok(());
        }
        let mut found = Benchmark {
            name: document
                .value(element, "name")
                .unwrap_or_default()
                .to_owned(),
            ..Benchmark::default()
        };
        for (attribute, place) in found.numbers() {
            let Some(text) = document.value(element, attribute) else {
                continue;
            };
            let number: Option<f64> = text.trim().parse().ok();
            let number = number.filter(|number| number.is_finite());
            let wrong = || {
                document.bad(
                    element,
                    format!("{attribute} \"{text}\", expected a number"),
                )
            };
            *place = Some(number.ok_or_else(wrong)?);
        }
        if !self.terminal.benchmarks.contains(&found) {
            self.terminal.benchmarks.push(found);
        }
        check_count(&self.terminal.benchmarks).map_err(|e| document.bad(element, e.to_string()))
    }

    fn take_words(&mut self, document: &Document<'_>, element: usize) -> Result<(), StreamError> {
        let text = document.text(element);
        let name = document.elements[element].name;
        let wrong = |expected: &str| {
            document.bad(element, format!("{name} \"{text}\", expected {expected}"))
        };
        let number = |most: u64| {
            let found = whole(text).filter(|number| *number <= most);
            found.ok_or_else(|| wrong(&format!("0 to {most}")))
        };
        let wishes = &mut self.preferences;
        match name.to_ascii_lowercase().as_str() {
            "bodyloa" => put(document, element, &mut wishes.body_loa, number(5)? as u8),
            "bodyregionmask" => put(
                document,
                element,
                &mut wishes.body_regions,
                number(127)? as u8,
            ),
            "meshlevel" => {
                let level = number(u64::from(u32::MAX))? as u32;
                put(document, element, &mut wishes.mesh_level, level)
            }
            "bodyfocus" => put(
                document,
                element,
                &mut self.view.body_focus,
                number(127)? as u8,
            ),
            "facefocus" => put(
                document,
                element,
                &mut self.view.face_focus,
                number(255)? as u8,
            ),
            "faceloa" => {
                let levels: Vec<u8> = text
                    .split_ascii_whitespace()
                    .filter_map(|word| word.parse().ok().filter(|level| *level <= 3))
                    .collect();
                let all = levels.len() == text.split_ascii_whitespace().count();
                let levels = levels.try_into().ok().filter(|_| all);
                let levels = levels.ok_or_else(|| wrong("eight levels, 0 to 3"))?;
                put(document, element, &mut wishes.face_loa, levels)
            }
            "modality" => {
                let found = Modality::ALL
                    .into_iter()
                    .find(|m| m.name().eq_ignore_ascii_case(text));
                let found = found.ok_or_else(|| wrong("3D, 2DWarp or 2DVector"))?;
                put(document, element, &mut wishes.modality, found)
            }
            "codec" => {
                if !text.is_empty() && !self.terminal.codecs.iter().any(|known| known == text) {
                    self.terminal.codecs.push(text.to_owned());
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

fn put<T: PartialEq>(
    document: &Document<'_>,
    element: usize,
    place: &mut Option<T>,
    value: T,
) -> Result<(), StreamError> {
    if place.as_ref().is_some_and(|known| *known != value) {
        let name = document.elements[element].name;
        return Err(document.bad(element, format!("{name} is told twice, with other values")));
    }
    *place = Some(value);
    Ok(())
}
