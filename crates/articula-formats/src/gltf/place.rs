//! A JSON value with its path in the document, so that every error can name it.

use crate::error::ReadError;
use serde_json::Value;

/// A value of the document and its path, such as `nodes[3].rotation`.
#[derive(Debug, Clone)]
pub(super) struct Place<'a> {
    value: &'a Value,
    at: String,
}

impl<'a> Place<'a> {
    /// The document itself; its path is empty.
    pub(super) fn root(value: &'a Value) -> Self {
        let at = String::new();
        Self { value, at }
    }

    pub(super) fn value(&self) -> &'a Value {
        self.value
    }

    pub(super) fn at(&self) -> &str {
        &self.at
    }

    /// Returns the path of a member, whether it exists or not.
    pub(super) fn path(&self, key: &str) -> String {
        if self.at.is_empty() {
            return key.to_owned();
        }
        format!("{}.{key}", self.at)
    }

    pub(super) fn malformed(&self, what: impl Into<String>) -> ReadError {
        ReadError::malformed(self.at.as_str(), what)
    }

    /// Returns a member; `null` counts as absent.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        let value = self.value.get(key).filter(|v| !v.is_null())?;
        let at = self.path(key);
        Some(Self { value, at })
    }

    /// Returns a nested member, if all members along the way exist.
    pub(super) fn dig(&self, keys: &[&str]) -> Option<Self> {
        keys.iter()
            .try_fold(self.clone(), |place, key| place.get(key))
    }

    pub(super) fn require(&self, key: &str) -> Result<Self, ReadError> {
        self.get(key)
            .ok_or_else(|| self.malformed(format!("\"{key}\" is missing")))
    }

    /// Returns the number of entries of an array member; 0 if it is absent or not an array.
    pub(super) fn count(&self, key: &str) -> usize {
        self.value
            .get(key)
            .and_then(Value::as_array)
            .map_or(0, Vec::len)
    }

    /// Returns one entry of an array member.
    pub(super) fn entry(&self, key: &str, index: usize) -> Option<Self> {
        let value = self.value.get(key)?.as_array()?.get(index)?;
        let at = format!("{}[{index}]", self.path(key));
        Some(Self { value, at })
    }

    /// Returns the entries of an array member; empty if it is absent.
    pub(super) fn entries(&self, key: &str) -> Result<Vec<Self>, ReadError> {
        let Some(member) = self.get(key) else {
            return Ok(Vec::new());
        };
        let Some(list) = member.value.as_array() else {
            return Err(member.malformed("expected an array"));
        };
        let entry = |(i, value)| Self {
            value,
            at: format!("{}[{i}]", member.at),
        };
        Ok(list.iter().enumerate().map(entry).collect())
    }

    /// Returns the members of an object; empty if this is not an object.
    pub(super) fn members(&self) -> Vec<(&'a str, Self)> {
        let Some(object) = self.value.as_object() else {
            return Vec::new();
        };
        let member = |(key, value): (&'a String, &'a Value)| {
            let at = self.path(key);
            (key.as_str(), Self { value, at })
        };
        object.iter().map(member).collect()
    }

    /// Returns a string member, or the empty string.
    pub(super) fn text(&self, key: &str) -> &'a str {
        self.value.get(key).and_then(Value::as_str).unwrap_or("")
    }

    pub(super) fn is_object(&self) -> bool {
        self.value.is_object()
    }

    pub(super) fn is_true(&self, key: &str) -> bool {
        self.value.get(key).and_then(Value::as_bool) == Some(true)
    }

    /// Returns this value as a non-negative integer; `3.0` counts as one.
    pub(super) fn whole(&self) -> Result<u64, ReadError> {
        whole(self.value).ok_or_else(|| {
            self.malformed(format!("expected a whole number, found {}", self.shown()))
        })
    }

    /// Returns an integer member.
    pub(super) fn whole_or(&self, key: &str, absent: u64) -> Result<u64, ReadError> {
        self.get(key).map_or(Ok(absent), |member| member.whole())
    }

    /// Returns this value as an index into a list of `len` entries.
    pub(super) fn index_below(&self, len: usize) -> Result<usize, ReadError> {
        let found = self.whole()?;
        usize::try_from(found)
            .ok()
            .filter(|index| *index < len)
            .ok_or_else(|| {
                self.malformed(format!("index {found} is out of range: there are {len}"))
            })
    }

    /// Returns an index member.
    pub(super) fn index(&self, key: &str, len: usize) -> Result<Option<usize>, ReadError> {
        self.get(key)
            .map(|member| member.index_below(len))
            .transpose()
    }

    /// Returns this value as a finite number.
    pub(super) fn float(&self) -> Result<f32, ReadError> {
        self.value
            .as_f64()
            .map(|x| x as f32)
            .filter(|x| x.is_finite())
            .ok_or_else(|| {
                self.malformed(format!("expected a finite number, found {}", self.shown()))
            })
    }

    /// Returns an array member of exactly `N` finite numbers.
    pub(super) fn floats<const N: usize>(&self, key: &str) -> Result<Option<[f32; N]>, ReadError> {
        let Some(member) = self.get(key) else {
            return Ok(None);
        };
        let list = self.entries(key)?;
        if list.len() != N {
            return Err(member.malformed(format!("expected {N} numbers, found {}", list.len())));
        }
        let mut out = [0.0; N];
        for (value, place) in out.iter_mut().zip(&list) {
            *value = place.float()?;
        }
        Ok(Some(out))
    }

    /// Returns the value, shortened, for an error message.
    fn shown(&self) -> String {
        match self.value {
            Value::Object(_) => "an object".to_owned(),
            Value::Array(_) => "an array".to_owned(),
            other => other.to_string().chars().take(40).collect(),
        }
    }
}

/// Returns a non-negative integer, written as integer or float.
pub(super) fn whole(value: &Value) -> Option<u64> {
    let spelled_as_float = || {
        let x = value.as_f64()?;
        // Beyond 2^53 a float no longer identifies one integer.
        (x >= 0.0 && x.fract() == 0.0 && x < 9.0e15).then_some(x as u64)
    };
    value.as_u64().or_else(spelled_as_float)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn errors_name_the_path() {
        let json = json!({"nodes": [{}, {"mesh": 7, "scale": [1, "x", 1]}]});
        let node = Place::root(&json).entry("nodes", 1).unwrap();
        let error = node.index("mesh", 2).unwrap_err();
        assert_eq!(
            error.to_string(),
            "nodes[1].mesh: index 7 is out of range: there are 2"
        );
        let error = node.floats::<3>("scale").unwrap_err();
        assert_eq!(
            error.to_string(),
            "nodes[1].scale[1]: expected a finite number, found \"x\""
        );
        assert_eq!(node.index("skin", 2), Ok(None));
    }

    #[test]
    fn whole_numbers_in_either_spelling() {
        assert_eq!(whole(&json!(3)), Some(3));
        assert_eq!(whole(&json!(3.0)), Some(3));
        assert_eq!(whole(&json!(3.5)), None);
        assert_eq!(whole(&json!(-1)), None);
        assert_eq!(whole(&json!(1e300)), None);
    }
}
