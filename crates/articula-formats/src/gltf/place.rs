//! A JSON value with its path in the document, so that every error can name it.

use crate::error::ReadError;
use serde_json::Value;
use std::fmt;
use std::rc::Rc;

/// Largest object whose members are found by comparing every key, which is faster than a hash.
const FEW_MEMBERS: usize = 16;

/// A value of the document and its path, such as `nodes[3].rotation`.
#[derive(Debug, Clone)]
pub(super) struct Place<'a> {
    value: &'a Value,
    /// `None` for the document itself.
    path: Option<Path<'a>>,
}

/// Position of a value. It becomes text only in an error or a warning, since a document has far
/// more values than either.
#[derive(Debug, Clone)]
struct Path<'a> {
    /// Path of the object that has the member; `None` for the document.
    owner: Option<Rc<Path<'a>>>,
    key: &'a str,
    /// Index of the value if it is an entry of the member.
    index: Option<usize>,
}

impl fmt::Display for Path<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(owner) = &self.owner {
            write!(f, "{owner}.")?;
        }
        f.write_str(self.key)?;
        self.index.map_or(Ok(()), |i| write!(f, "[{i}]"))
    }
}

/// Writes the path.
impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.path.as_ref().map_or(Ok(()), |path| path.fmt(f))
    }
}

impl<'a> Place<'a> {
    /// The document itself; its path is empty.
    pub(super) fn root(value: &'a Value) -> Self {
        Self { value, path: None }
    }

    pub(super) fn value(&self) -> &'a Value {
        self.value
    }

    /// Returns the path as text.
    pub(super) fn at(&self) -> String {
        self.to_string()
    }

    /// Returns the path of a member, whether it exists or not.
    pub(super) fn path(&self, key: &str) -> String {
        match &self.path {
            None => key.to_owned(),
            Some(path) => format!("{path}.{key}"),
        }
    }

    /// Returns the place of a member's value, or of an entry of the member.
    fn child(&self, key: &'a str, index: Option<usize>, value: &'a Value) -> Self {
        let path = Path {
            owner: self.path.clone().map(Rc::new),
            key,
            index,
        };
        let path = Some(path);
        Self { value, path }
    }

    pub(super) fn malformed(&self, what: impl Into<String>) -> ReadError {
        ReadError::malformed(self.at(), what)
    }

    /// Returns the key and the value of a member, even if it is `null`.
    fn member(&self, key: &str) -> Option<(&'a str, &'a Value)> {
        let object = self.value.as_object()?;
        let (key, value) = if object.len() <= FEW_MEMBERS {
            object.iter().find(|(name, _)| *name == key)?
        } else {
            object.get_key_value(key)?
        };
        Some((key, value))
    }

    /// Returns whether a member exists; `null` counts as absent.
    pub(super) fn has(&self, key: &str) -> bool {
        self.member(key).is_some_and(|(_, value)| !value.is_null())
    }

    /// Returns a member; `null` counts as absent.
    pub(super) fn get(&self, key: &str) -> Option<Self> {
        let (key, value) = self.member(key).filter(|(_, v)| !v.is_null())?;
        Some(self.child(key, None, value))
    }

    /// Returns a nested member, if all members along the way exist.
    pub(super) fn dig(&self, keys: &[&str]) -> Option<Self> {
        keys.iter()
            .try_fold(self.clone(), |place, key| place.get(key))
    }

    pub(super) fn require(&self, key: &str) -> Result<Self, ReadError> {
        self.get(key).ok_or_else(|| self.missing(key))
    }

    fn missing(&self, key: &str) -> ReadError {
        self.malformed(format!("\"{key}\" is missing"))
    }

    /// Returns the number of entries of an array member; 0 if it is absent or not an array.
    pub(super) fn count(&self, key: &str) -> usize {
        self.member(key)
            .and_then(|(_, value)| value.as_array())
            .map_or(0, Vec::len)
    }

    /// Returns one entry of an array member.
    pub(super) fn entry(&self, key: &str, index: usize) -> Option<Self> {
        let (key, value) = self.member(key)?;
        let value = value.as_array()?.get(index)?;
        Some(self.child(key, Some(index), value))
    }

    /// Returns the entry of an array member whose index is the member `key` of `owner`.
    pub(super) fn entry_of(
        &self,
        list: &str,
        owner: &Place<'_>,
        key: &str,
    ) -> Result<Self, ReadError> {
        let index = owner.require_index(key, self.count(list))?;
        let entry = self.entry(list, index);
        entry.ok_or_else(|| ReadError::malformed(owner.path(key), "the entry does not exist"))
    }

    /// Returns the entries of an array member; empty if it is absent.
    pub(super) fn entries(&self, key: &str) -> Result<Vec<Self>, ReadError> {
        self.get(key).map_or(Ok(Vec::new()), |list| list.items())
    }

    /// Returns the entries of this array.
    fn items(&self) -> Result<Vec<Self>, ReadError> {
        let Some(list) = self.value.as_array() else {
            return Err(self.malformed("expected an array"));
        };
        let item = |(i, value)| {
            let index = Some(i);
            let path = self.path.clone().map(|path| Path { index, ..path });
            Self { value, path }
        };
        Ok(list.iter().enumerate().map(item).collect())
    }

    /// Returns the members of an object; empty if this is not an object.
    pub(super) fn members(&self) -> Vec<(&'a str, Self)> {
        let Some(object) = self.value.as_object() else {
            return Vec::new();
        };
        let member =
            |(key, value): (&'a String, &'a Value)| (key.as_str(), self.child(key, None, value));
        object.iter().map(member).collect()
    }

    /// Returns a string member, or the empty string.
    pub(super) fn text(&self, key: &str) -> &'a str {
        self.member(key)
            .and_then(|(_, value)| value.as_str())
            .unwrap_or("")
    }

    pub(super) fn is_object(&self) -> bool {
        self.value.is_object()
    }

    pub(super) fn is_true(&self, key: &str) -> bool {
        self.member(key).and_then(|(_, value)| value.as_bool()) == Some(true)
    }

    /// Returns this value as a non-negative integer; `3.0` counts as one.
    pub(super) fn whole(&self) -> Result<u64, ReadError> {
        whole(self.value).ok_or_else(|| {
            self.malformed(format!("expected a whole number, found {}", self.shown()))
        })
    }

    /// Returns an integer member; `None` if it is absent.
    pub(super) fn whole_at(&self, key: &str) -> Result<Option<u64>, ReadError> {
        match self.member(key).and_then(|(_, value)| whole(value)) {
            Some(found) => Ok(Some(found)),
            // The place of the member is made only for an error.
            None => self.get(key).map(|member| member.whole()).transpose(),
        }
    }

    /// Returns an integer member that must exist.
    pub(super) fn require_whole(&self, key: &str) -> Result<u64, ReadError> {
        self.whole_at(key)?.ok_or_else(|| self.missing(key))
    }

    /// Returns an integer member, or `absent`.
    pub(super) fn whole_or(&self, key: &str, absent: u64) -> Result<u64, ReadError> {
        Ok(self.whole_at(key)?.unwrap_or(absent))
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
        let Some(found) = self.whole_at(key)? else {
            return Ok(None);
        };
        match usize::try_from(found).ok().filter(|index| *index < len) {
            Some(index) => Ok(Some(index)),
            None => self.require(key)?.index_below(len).map(Some),
        }
    }

    /// Returns an index member that must exist.
    pub(super) fn require_index(&self, key: &str, len: usize) -> Result<usize, ReadError> {
        self.index(key, len)?.ok_or_else(|| self.missing(key))
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
        let list = member.items()?;
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
    fn paths_of_nested_members() {
        let json = json!({"a": {"b": [{"c": null}, {"c": [[7], 8]}]}});
        let root = Place::root(&json);
        assert_eq!((root.at(), root.path("x")), (String::new(), "x".to_owned()));
        let entries = root.get("a").unwrap().entries("b").unwrap();
        assert_eq!(entries[0].path("c"), "a.b[0].c");
        assert!(!entries[0].has("c") && entries[1].has("c"));
        let (name, member) = entries[1].members().remove(0);
        assert_eq!((name, member.at()), ("c", "a.b[1].c".to_owned()));
        assert_eq!(entries[1].entries("c").unwrap()[1].at(), "a.b[1].c[1]");
    }

    #[test]
    fn members_of_small_and_large_objects() {
        for count in [1, FEW_MEMBERS, FEW_MEMBERS + 1] {
            let members = (0..count).map(|i| (format!("m{i}"), json!(i)));
            let json = Value::Object(members.collect());
            let root = Place::root(&json);
            assert_eq!(root.whole_at("m0"), Ok(Some(0)));
            let last = format!("m{}", count - 1);
            assert_eq!(root.require_whole(&last), Ok(count as u64 - 1));
            assert_eq!(root.whole_at("n"), Ok(None));
            let error = root.require_whole("n").unwrap_err().to_string();
            assert_eq!(error, ": \"n\" is missing");
        }
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
