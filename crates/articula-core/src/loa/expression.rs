//! The expression language of joint sets, such as `loa(Low) + zone(hands) - joint(r_wrist)`.
//!
//! Source: `docs/methods/motion-lod.md` part 1.2. The thesis has no counterpart.
//!
//! ```text
//! expr := term (('+' | '&' | '-') term)*      left-associative
//! term := 'depth(' int ')' | 'loa(' name ')' | 'hanim(' 0 to 3 ')'
//!       | 'zone(' name ('|' name)* ')' | 'joint(' name ')' | '(' expr ')'
//! ```

use super::selection;
use crate::articulation::{Complexity, Zone};
use crate::joint_set::JointSet;
use crate::rig::Rig;
use std::str::FromStr;

/// Maximum nesting depth of parentheses.
const MAX_NESTING: usize = 64;

/// Maximum number of terms; an operator's left side nests, so this bounds the depth of the tree.
const MAX_TERMS: usize = 1000;

/// A parsed expression that selects joints, not yet resolved against a rig.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LoaExpression {
    /// Joints of smaller depth.
    Depth(u32),
    /// Joints of a level of articulation.
    Loa(Complexity),
    /// Joints of an official H-Anim level, at most [`selection::MAX_HANIM_LEVEL`].
    Hanim(u8),
    /// Joints of some regions.
    Zone(Zone),
    /// One joint, by its name in the rig or its H-Anim name.
    Joint(String),
    /// Union.
    Plus(Box<Self>, Box<Self>),
    /// Intersection.
    And(Box<Self>, Box<Self>),
    /// Difference.
    Minus(Box<Self>, Box<Self>),
}

/// A syntax error in an expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoaExpressionError {
    /// Column, counted in characters from 1.
    pub column: usize,
    /// What was found and what was expected.
    pub what: String,
}

impl std::fmt::Display for LoaExpressionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "column {}: {}", self.column, self.what)
    }
}

impl std::error::Error for LoaExpressionError {}

/// Parses an expression. White space between words is not significant; an error gives the column,
/// what was found there and what was expected.
impl FromStr for LoaExpression {
    type Err = LoaExpressionError;

    fn from_str(text: &str) -> Result<Self, LoaExpressionError> {
        let mut parser = Parser {
            text,
            at: 0,
            terms: 0,
        };
        let expression = parser.expression(0)?;
        match parser.peek() {
            None => Ok(expression),
            Some(c) => Err(parser.error(format!("found '{c}', expected '+', '&', '-' or the end"))),
        }
    }
}

impl LoaExpression {
    /// Returns the selected joints of a rig.
    ///
    /// # Errors
    /// [`selection::UnknownJoint`] if the expression names a joint that the rig does not have.
    pub fn joints(&self, rig: &Rig) -> Result<JointSet, selection::UnknownJoint> {
        Ok(match self {
            Self::Depth(k) => selection::depth(rig, *k),
            Self::Loa(c) => selection::complexity(rig, *c),
            Self::Hanim(l) => selection::hanim(rig, *l),
            Self::Zone(z) => selection::zone(rig, *z),
            Self::Joint(name) => JointSet::from_iter([selection::joint(rig, name)?]),
            Self::Plus(a, b) => a.joints(rig)?.union(&b.joints(rig)?),
            Self::And(a, b) => a.joints(rig)?.intersection(&b.joints(rig)?),
            Self::Minus(a, b) => a.joints(rig)?.difference(&b.joints(rig)?),
        })
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    terms: usize,
}

impl Parser<'_> {
    fn error(&self, what: impl Into<String>) -> LoaExpressionError {
        LoaExpressionError {
            column: self.text[..self.at].chars().count() + 1,
            what: what.into(),
        }
    }

    fn peek(&mut self) -> Option<char> {
        let rest = self.text[self.at..].trim_start();
        self.at = self.text.len() - rest.len();
        rest.chars().next()
    }

    fn expect(&mut self, wanted: char) -> Result<(), LoaExpressionError> {
        match self.peek() {
            Some(c) if c == wanted => {
                self.at += c.len_utf8();
                Ok(())
            }
            Some(c) => Err(self.error(format!("found '{c}', expected '{wanted}'"))),
            None => Err(self.error(format!("found the end, expected '{wanted}'"))),
        }
    }

    fn expression(&mut self, nesting: usize) -> Result<LoaExpression, LoaExpressionError> {
        let mut left = self.term(nesting)?;
        while let Some(operator @ ('+' | '&' | '-')) = self.peek() {
            self.at += 1;
            let operands = (Box::new(left), Box::new(self.term(nesting)?));
            left = match operator {
                '+' => LoaExpression::Plus(operands.0, operands.1),
                '&' => LoaExpression::And(operands.0, operands.1),
                _ => LoaExpression::Minus(operands.0, operands.1),
            };
        }
        Ok(left)
    }

    fn term(&mut self, nesting: usize) -> Result<LoaExpression, LoaExpressionError> {
        if nesting > MAX_NESTING {
            return Err(self.error(format!("more than {MAX_NESTING} nested parentheses")));
        }
        self.terms += 1;
        if self.terms > MAX_TERMS {
            return Err(self.error(format!("more than {MAX_TERMS} terms")));
        }
        if self.peek() == Some('(') {
            self.at += 1;
            let inner = self.expression(nesting + 1)?;
            self.expect(')')?;
            return Ok(inner);
        }
        let start = self.at;
        let word = self.word(|c| c.is_ascii_alphabetic());
        let selector = word.to_ascii_lowercase();
        if !matches!(
            selector.as_str(),
            "depth" | "loa" | "hanim" | "zone" | "joint"
        ) {
            self.at = start;
            let found = if word.is_empty() {
                self.peek().map_or("the end".into(), |c| format!("'{c}'"))
            } else {
                format!("\"{word}\"")
            };
            return Err(self.error(format!(
                "found {found}, expected depth(…), loa(…), hanim(…), zone(…), joint(…) or a \
                 parenthesis"
            )));
        }
        self.expect('(')?;
        self.peek();
        let at = self.at;
        // Joint names of real files contain almost any character, so only ')' ends an argument.
        let argument = self.word(|c| c != ')').trim().to_owned();
        self.expect(')')?;
        argument_of(&selector, &argument).map_err(|what| LoaExpressionError {
            column: self.text[..at].chars().count() + 1,
            what,
        })
    }

    fn word(&mut self, belongs: impl Fn(char) -> bool) -> String {
        self.peek();
        let rest = &self.text[self.at..];
        let end = rest.find(|c| !belongs(c)).unwrap_or(rest.len());
        self.at += end;
        rest[..end].to_owned()
    }
}

fn argument_of(selector: &str, argument: &str) -> Result<LoaExpression, String> {
    match selector {
        "depth" => argument.parse().map(LoaExpression::Depth).map_err(|_| {
            format!("\"{argument}\" is not a depth; expected a whole number such as 3")
        }),
        "loa" => argument.parse().map(LoaExpression::Loa).map_err(|_| {
            let names = Complexity::ALL.map(|c| c.to_string()).join(", ");
            format!("\"{argument}\" is not a level; expected one of {names}")
        }),
        "hanim" => argument
            .parse()
            .ok()
            .filter(|level| *level <= selection::MAX_HANIM_LEVEL)
            .map(LoaExpression::Hanim)
            .ok_or_else(|| format!("\"{argument}\" is not an H-Anim level; expected 0, 1, 2 or 3")),
        "zone" => argument
            .split('|')
            .map(|name| {
                name.trim().parse::<Zone>().map_err(|_| {
                    format!(
                        "\"{}\" is not a zone; expected face, arms, torso, pelvis, legs, feet, \
                         hands, upper, lower, face-shoulders or all",
                        name.trim()
                    )
                })
            })
            .try_fold(Zone::default(), |all, zone| zone.map(|z| all | z))
            .map(LoaExpression::Zone),
        _ if argument.is_empty() => Err("expected a joint name".into()),
        _ => Ok(LoaExpression::Joint(argument.to_owned())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use LoaExpression::{Depth, Joint, Loa, Minus, Plus};

    #[test]
    fn operators_are_left_associative() {
        let parsed = "depth(2)+ loa(low) - joint(l_hip)"
            .parse::<LoaExpression>()
            .unwrap();
        let sum = Plus(Box::new(Depth(2)), Box::new(Loa(Complexity::Low)));
        assert_eq!(
            parsed,
            Minus(Box::new(sum), Box::new(Joint("l_hip".into())))
        );
        let nested = "depth(2) & (zone(torso | legs) - joint(a b.c|d))"
            .parse::<LoaExpression>()
            .unwrap();
        assert!(matches!(nested, LoaExpression::And(_, _)));
    }

    #[test]
    fn errors_name_the_column_and_the_mend() {
        let of = |text: &str| text.parse::<LoaExpression>().unwrap_err();
        assert_eq!(of("").column, 1);
        assert_eq!(of("loa(Low) zone(arms)").column, 10);
        assert!(of("loa(Lots)").what.contains("VeryLow"));
        assert_eq!(of("loa(Lots)").column, 5);
        assert!(of("depth(-1)").what.contains("whole number"));
        assert!(of("zone(tail)").what.contains("pelvis"));
        assert!(of("hanim(4)").what.contains("0, 1, 2 or 3"));
        assert!(of("joint()").what.contains("name"));
        assert!(of("(depth(1)").what.contains("expected ')'"));
        assert!(of("depth(1) +").what.contains("the end"));
        assert!(of("größe(1)").what.contains("expected depth"));
        assert!(of(&"(".repeat(100_000)).what.contains("nested"));
        let endless = format!("loa(Low){}", " + depth(1)".repeat(100_000));
        assert!(of(&endless).what.contains("1000 terms"));
    }
}
