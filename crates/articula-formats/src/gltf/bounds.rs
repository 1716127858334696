//! Least and greatest numbers of accessors, which the format wants exact where they are stated.

use super::append::{entries_mut, exact, index, set};
use super::document::Document;
use super::reader::{Notes, Reader};
use crate::limits::Limits;
use serde_json::json;

impl Document {
    /// States anew `min` and `max` of accessors that state them. What cannot be read, or is not
    /// finite, is left as it is; it is told when it is needed.
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
