//! Contexts as JSON.
//!
//! Form: `docs/formats/context.md`.

use super::Context;
use crate::error::StreamError;
use crate::limits::{DescriptionLimits, StreamLimits};

impl Context {
    /// Reads a context in JSON: an object with the names of the fields of [`Context`]; those left out
    /// are unknown.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, for text that is no such object, has other fields or
    /// values outside of their bounds, or exceeds the limit of bytes.
    pub fn read_json(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let length = bytes.len() as u64;
        StreamLimits::check("context", "bytes", length, limits.bytes)?;
        let context: Self = serde_json::from_slice(bytes)
            .map_err(|e| StreamError::malformed("context", e.to_string()))?;
        context.check()?;
        Ok(context)
    }

    /// Writes the context in JSON, without what is unknown.
    pub fn write_json(&self) -> String {
        // A structure of numbers and texts cannot fail.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        known(&mut value);
        value.to_string()
    }
}

/// Removes what is unknown or empty.
fn known(value: &mut serde_json::Value) {
    if let serde_json::Value::Array(list) = value {
        list.iter_mut().for_each(known);
    }
    if let serde_json::Value::Object(fields) = value {
        fields.values_mut().for_each(known);
        fields.retain(|_, value| match value {
            serde_json::Value::Null => false,
            serde_json::Value::Object(fields) => !fields.is_empty(),
            serde_json::Value::Array(list) => !list.is_empty(),
            _ => true,
        });
    }
}
