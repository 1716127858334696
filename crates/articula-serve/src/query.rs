//! Queries in one canonical form, so that what is equal has one address.
//!
//! Form: names in alphabetical order, each at most once; whole numbers without sign and leading zeros; lists in
//! alphabetical order without repetition.

use crate::page::path_of;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

/// What a query has wrong, as its client is told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Refusal(pub(crate) String);

/// The parameters of a query. Each read of one puts it in the canonical form.
#[derive(Debug, Clone)]
pub(crate) struct Parameters(BTreeMap<String, String>);

impl Parameters {
    /// Takes the pairs of a query.
    ///
    /// # Errors
    /// A [`Refusal`] that tells the known names, for another one or one that comes twice.
    pub(crate) fn new(pairs: Vec<(String, String)>, known: &[&str]) -> Result<Self, Refusal> {
        let mut all = BTreeMap::new();
        for (name, value) in pairs {
            if !known.contains(&name.as_str()) {
                let known = known.join(", ");
                let name = shortened(&name);
                return Err(Refusal(format!(
                    "{name}: unknown parameter; known are {known}"
                )));
            }
            if all.insert(name.clone(), value).is_some() {
                return Err(Refusal(format!("{name}: given twice; give it once")));
            }
        }
        Ok(Self(all))
    }

    /// A whole number; `None` if it is not given.
    pub(crate) fn number(
        &mut self,
        name: &str,
        allowed: RangeInclusive<u32>,
    ) -> Result<Option<u32>, Refusal> {
        self.whole_number(name, allowed, "")
    }

    /// The same; `or` is what else its refusal tells that it may be.
    fn whole_number(
        &mut self,
        name: &str,
        allowed: RangeInclusive<u32>,
        or: &str,
    ) -> Result<Option<u32>, Refusal> {
        let Some(value) = self.0.get_mut(name) else {
            return Ok(None);
        };
        let is_plain = !value.is_empty() && value.bytes().all(|byte| byte.is_ascii_digit());
        let number = value
            .parse()
            .ok()
            .filter(|n| is_plain && allowed.contains(n));
        let Some(number) = number else {
            let (least, most) = (allowed.start(), allowed.end());
            let found = shortened(value);
            return Err(Refusal(format!(
                "{name}: found {found}, expected {or}a whole number from {least} to {most}"
            )));
        };
        *value = number.to_string();
        Ok(Some(number))
    }

    /// A whole number, or a word for none; `None` for this too, and if it is not given.
    pub(crate) fn number_or(
        &mut self,
        none: &str,
        name: &str,
        allowed: RangeInclusive<u32>,
    ) -> Result<Option<u32>, Refusal> {
        if self.0.get(name).is_some_and(|value| value == none) {
            return Ok(None);
        }
        self.whole_number(name, allowed, &format!("{none} or "))
    }

    /// One of some names; `None` if it is not given.
    pub(crate) fn word(&self, name: &str, allowed: &[&str]) -> Result<Option<String>, Refusal> {
        let Some(value) = self.0.get(name) else {
            return Ok(None);
        };
        match allowed.contains(&value.as_str()) {
            true => Ok(Some(value.clone())),
            false => Err(unknown_word(name, value, allowed)),
        }
    }

    /// A list of names, separated by `,`; `None` if it is not given.
    pub(crate) fn words(&mut self, name: &str) -> Result<Option<BTreeSet<String>>, Refusal> {
        let Some(value) = self.0.get_mut(name) else {
            return Ok(None);
        };
        let words: BTreeSet<String> = value.split(',').map(str::to_owned).collect();
        if words.contains("") {
            let what = format!("{name}: a name is empty, expected names separated by \",\"");
            return Err(Refusal(what));
        }
        *value = words.iter().cloned().collect::<Vec<_>>().join(",");
        Ok(Some(words))
    }

    /// Whether a parameter is given.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// The query in its canonical form.
    pub(crate) fn canonical(&self) -> String {
        let value = |value: &String| value.split(',').map(path_of).collect::<Vec<_>>().join(",");
        let pairs = self.0.iter();
        let pairs: Vec<String> = pairs.map(|(n, v)| format!("{n}={}", value(v))).collect();
        pairs.join("&")
    }
}

/// The refusal of a name that is not among those allowed.
pub(crate) fn unknown_word(name: &str, found: &str, allowed: &[&str]) -> Refusal {
    let (found, allowed) = (shortened(found), allowed.join(", "));
    Refusal(format!(
        "{name}: found \"{found}\", expected one of {allowed}"
    ))
}

/// What a client sent, for an error line.
fn shortened(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).take(100).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(pairs: &[(&str, &str)]) -> Result<Parameters, Refusal> {
        let pairs = pairs
            .iter()
            .map(|(n, v)| ((*n).to_owned(), (*v).to_owned()));
        Parameters::new(pairs.collect(), &["lod", "clip", "targets"])
    }

    #[test]
    fn equal_queries_have_one_form() {
        let forms = [
            [("lod", "1"), ("clip", "walk fast"), ("targets", "b,a")],
            [("targets", "a,b,a"), ("lod", "001"), ("clip", "walk fast")],
        ];
        for form in forms {
            let mut query = of(&form).unwrap();
            assert_eq!(query.number("lod", 0..=2), Ok(Some(1)));
            let clip = query.word("clip", &["walk", "walk fast"]);
            assert_eq!(clip, Ok(Some("walk fast".to_owned())));
            let targets = query.words("targets").unwrap().unwrap();
            assert_eq!(targets.into_iter().collect::<Vec<_>>(), ["a", "b"]);
            assert_eq!(query.canonical(), "clip=walk%20fast&lod=1&targets=a,b");
        }
        assert_eq!(of(&[]).unwrap().canonical(), "");
    }

    #[test]
    fn a_refusal_names_the_parameter_and_what_is_allowed() {
        let refused = |made: Result<_, Refusal>| made.map(drop).unwrap_err().0;
        let unknown = refused(of(&[("size", "1")]));
        assert!(unknown.contains("size") && unknown.contains("lod, clip, targets"));
        assert!(refused(of(&[("lod", "1"), ("lod", "1")])).contains("lod: given twice"));
        for wrong in ["3", "-1", "+1", "", "1.0", "a", "99999999999"] {
            let made = of(&[("lod", wrong)]).unwrap().number("lod", 0..=2);
            let why = made.unwrap_err().0;
            assert!(
                why.starts_with("lod: ") && why.contains("from 0 to 2"),
                "{why}"
            );
        }
        let word = of(&[("clip", "fly")]).unwrap().word("clip", &["walk"]);
        assert_eq!(
            word.unwrap_err().0,
            "clip: found \"fly\", expected one of walk"
        );
        let words = of(&[("targets", "a,,b")]).unwrap().words("targets");
        assert!(words.unwrap_err().0.starts_with("targets: "));
        let long = of(&[(&"x".repeat(5000), "")]).unwrap_err().0;
        assert!(long.len() < 200);
    }
}
