//! Expressions in reverse Polish notation over pins and numbers.

use super::Pins;
use articula_core::Mismatch;
use std::fmt;
use std::str::FromStr;

/// Greatest number of terms of an expression.
const TERMS: usize = 1000;

/// A part of an [`Expression`].
#[derive(Debug, Clone, PartialEq)]
pub enum Term {
    /// A number.
    Number(f64),
    /// The value of a pin.
    Pin(String),
    /// An operation on one or two values before it.
    Operation(Operation),
}

/// An operation of an expression. Conditions are 1 if they hold, else 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Operation(&'static str);

/// Names of the operations, and on how many values they are.
const OPERATIONS: &[(&str, usize)] = &[
    ("+", 2),
    ("-", 2),
    ("*", 2),
    ("/", 2),
    ("min", 2),
    ("max", 2),
    ("floor", 1),
    ("neg", 1),
    ("lt", 2),
    ("le", 2),
    ("gt", 2),
    ("ge", 2),
    ("eq", 2),
    ("and", 2),
    ("or", 2),
    ("not", 1),
];

/// Terms in the order of a stack: values before the operation on them, such as
/// `BANDWIDTH 1000 / floor`. Operations: `+ - * / min max floor neg`, the conditions
/// `lt le gt ge eq`, and `and or not`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Expression(pub Vec<Term>);

impl Operation {
    fn arity(self) -> usize {
        let found = OPERATIONS.iter().find(|row| row.0 == self.0);
        found.map_or(2, |row| row.1)
    }

    fn of(self, a: f64, b: f64) -> f64 {
        let truth = |holds: bool| f64::from(u8::from(holds));
        match self.0 {
            "+" => a + b,
            "-" => a - b,
            "*" => a * b,
            "/" => a / b,
            "min" => a.min(b),
            "max" => a.max(b),
            "floor" => b.floor(),
            "neg" => -b,
            "lt" => truth(a < b),
            "le" => truth(a <= b),
            "gt" => truth(a > b),
            "ge" => truth(a >= b),
            "eq" => truth(a == b),
            "and" => truth(a != 0.0 && b != 0.0),
            "or" => truth(a != 0.0 || b != 0.0),
            _ => truth(b == 0.0),
        }
    }
}

impl Expression {
    /// Names of the pins in it.
    pub(super) fn pins(&self) -> Vec<&str> {
        let pin = |term: &'_ Term| matches!(term, Term::Pin(_));
        let named = self.0.iter().filter(|term| pin(term));
        named
            .filter_map(|term| match term {
                Term::Pin(name) => Some(name.as_str()),
                _ => None,
            })
            .collect()
    }

    /// Checks that every operation has its values, that one value is left, and that there are at
    /// most 1000 terms.
    pub(super) fn check(&self) -> Result<(), Mismatch> {
        let wrong = |what: String| Mismatch::new(format!("expression \"{self}\""), what);
        if self.0.len() > TERMS {
            return Err(wrong(format!(
                "{} terms, the limit is {TERMS}",
                self.0.len()
            )));
        }
        let mut height = 0_usize;
        for term in &self.0 {
            let needed = match term {
                Term::Operation(operation) => operation.arity(),
                Term::Number(number) if !number.is_finite() => {
                    return Err(wrong(format!("{number}, expected finite numbers")));
                }
                Term::Pin(name) if !is_name(name) => {
                    return Err(wrong(format!(
                        "\"{name}\" cannot be the name of a pin in it"
                    )));
                }
                _ => 0,
            };
            let left = height.checked_sub(needed);
            let left = left.ok_or_else(|| wrong("an operation without its values".into()))?;
            height = left + 1;
        }
        match height {
            1 => Ok(()),
            _ => Err(wrong(format!("{height} values are left, expected one"))),
        }
    }

    /// The value for some pins; `None` if one of them is not there.
    ///
    /// # Errors
    /// A [`Mismatch`] if the expression is not sound, or the value is not finite.
    pub fn value(&self, pins: &Pins) -> Result<Option<f64>, Mismatch> {
        self.check()?;
        let mut stack: Vec<f64> = Vec::new();
        for term in &self.0 {
            let value = match term {
                Term::Number(number) => *number,
                Term::Pin(name) => match pins.get(name) {
                    Some(value) => *value,
                    None => return Ok(None),
                },
                Term::Operation(operation) => {
                    // The check has counted the values.
                    let b = stack.pop().unwrap_or_default();
                    let a = match operation.arity() {
                        2 => stack.pop().unwrap_or_default(),
                        _ => 0.0,
                    };
                    operation.of(a, b)
                }
            };
            stack.push(value);
        }
        let value = stack.pop().unwrap_or_default();
        if value.is_finite() {
            return Ok(Some(value));
        }
        let what = format!("is {value}, expected a finite number");
        Err(Mismatch::new(format!("expression \"{self}\""), what))
    }
}

/// Whether a word is read as the name of a pin.
fn is_name(word: &str) -> bool {
    let is_operation = OPERATIONS.iter().any(|row| row.0 == word);
    let is_number = word.parse::<f64>().is_ok_and(f64::is_finite);
    !word.is_empty() && !word.contains(char::is_whitespace) && !is_operation && !is_number
}

impl FromStr for Expression {
    type Err = Mismatch;

    fn from_str(text: &str) -> Result<Self, Mismatch> {
        let term = |word: &str| {
            let operation = OPERATIONS.iter().find(|row| row.0 == word);
            match (operation, word.parse::<f64>()) {
                (Some(row), _) => Term::Operation(Operation(row.0)),
                (None, Ok(number)) if number.is_finite() => Term::Number(number),
                _ => Term::Pin(word.to_owned()),
            }
        };
        let words = text.split_ascii_whitespace().take(TERMS + 1);
        let expression = Self(words.map(term).collect());
        expression.check()?;
        Ok(expression)
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, term) in self.0.iter().enumerate() {
            let space = if number > 0 { " " } else { "" };
            match term {
                Term::Number(value) => write!(f, "{space}{value}")?,
                Term::Pin(name) => write!(f, "{space}{name}")?,
                Term::Operation(operation) => write!(f, "{space}{}", operation.0)?,
            }
        }
        Ok(())
    }
}
