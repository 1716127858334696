//! Declared minima and maxima of accessors, which the format requires to be exact.

use super::append::{entries_mut, exact, index, set};
use super::document::Document;
use super::reader::{Notes, Reader};
use crate::limits::Limits;
use serde_json::json;

impl Document {
    /// Recomputes the declared `min` and `max` of accessors that have them. Accessors that cannot
    /// be read, or are not finite, stay unchanged; the error is reported when they are used.
    pub(super) fn state_bounds(&mut self, accessors: &[usize], limits: &Limits) {
        let mut reader = Reader::new(self, limits, Notes::default());
        let mut found = Vec::new();
        for &i in accessors {
            let place = reader.root.entry("accessors", i);
            let bounds = place.and_then(|place| reader.bounds(&place).ok());
            found.extend(bounds.map(|bounds| (i, bounds)));
        }
        for (i, (least, greatest)) in found {
            let accessor = &mut entries_mut(&mut self.json, "accessors")[i];
            let is_float = index(accessor, "componentType") == Some(5126);
            for (key, bound) in [("min", least), ("max", greatest)] {
                if accessor.get(key).is_none() || bound.iter().any(|x| !x.is_finite()) {
                    continue;
                }
                let stated = if is_float {
                    exact(&bound)
                } else {
                    bound.iter().map(|x| json!(*x as i64)).collect()
                };
                set(accessor, key, stated);
            }
        }
    }
}
