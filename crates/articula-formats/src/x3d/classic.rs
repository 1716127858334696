//! The classic encoding of X3D and VRML97: `Type { field value }`.
//!
//! The parser does not need field types: a value is a list in brackets, a string, a sequence of
//! numbers, or nodes. Prototype declarations are skipped; an instance keeps the name of its
//! prototype, which for H-Anim 1.1 and 2001 identifies the node type (`Joint`, `Segment`).
//!
//! Source: VRML97 (ISO/IEC 14772-1), 5.2 and annex A; ISO/IEC 19776-2 (X3D classic).

use super::scene::{Builder, NodeId, declares_fields, standard_kind};
use crate::error::ReadError;
use crate::limits::Limits;
use std::borrow::Cow;

/// Reads a whole file.
pub(super) fn parse<'a, 'l>(
    text: &'a str,
    limits: &'l Limits,
) -> Result<Builder<'a, 'l>, ReadError> {
    let mut parser = Parser {
        builder: Builder::new(text, limits),
        text,
        at: 0,
    };
    parser.header()?;
    while parser.peek() != Token::End {
        parser.statement(None, 1)?;
    }
    Ok(parser.builder)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Token<'a> {
    /// A name, a number or `TRUE`.
    Word(&'a str),
    /// Text between quotation marks, with its escapes.
    Text(&'a str),
    /// One of `{ } [ ]`.
    Mark(char),
    End,
}

#[derive(Debug)]
struct Parser<'a, 'l> {
    builder: Builder<'a, 'l>,
    text: &'a str,
    at: usize,
}

impl<'a, 'l> Parser<'a, 'l> {
    fn header(&mut self) -> Result<(), ReadError> {
        let first = self.text.lines().next().unwrap_or("");
        let mut words = first.split_whitespace();
        match (words.next(), words.next()) {
            (Some("#VRML"), Some(version)) if version.starts_with("V1") => {
                Err(ReadError::Unsupported {
                    at: "line 1".to_owned(),
                    what: "VRML 1.0".to_owned(),
                    mend: "save it as VRML 2.0 (VRML97) or X3D".to_owned(),
                })
            }
            (Some("#VRML" | "#X3D"), Some(version)) => {
                self.builder.version(version);
                Ok(())
            }
            _ => {
                let what = "the first line is not \"#X3D V3.3 utf8\" or \"#VRML V2.0 utf8\"";
                Err(self.builder.malformed(0, what))
            }
        }
    }

    /// Parses a node or a statement; `parent` and its field are the destination of a node.
    fn statement(
        &mut self,
        parent: Option<(NodeId, &'a str)>,
        depth: usize,
    ) -> Result<(), ReadError> {
        let offset = self.skip_blank();
        let Token::Word(word) = self.next()? else {
            return Err(self.expected(offset, "a node or a statement"));
        };
        match word {
            "PROFILE" => self.next().map(drop),
            "COMPONENT" | "EXPORT" => {
                self.next()?;
                self.skip_word("AS")
            }
            "META" => {
                if let (Token::Text(name), Token::Text(content)) = (self.next()?, self.next()?) {
                    self.builder.meta(&unescaped(name), &unescaped(content));
                }
                Ok(())
            }
            "UNIT" => {
                let (category, _name, factor) = (self.word()?, self.word()?, self.word()?);
                self.builder.unit(category, factor, offset);
                Ok(())
            }
            "IMPORT" => {
                self.next()?;
                self.left_out("IMPORT", offset);
                self.skip_word("AS")
            }
            "PROTO" => {
                self.word()?;
                self.skip_value()?;
                self.skip_value()
            }
            "EXTERNPROTO" => {
                self.word()?;
                self.skip_value()?;
                self.skip_value()
            }
            "ROUTE" => self.route(offset),
            "NULL" => Ok(()),
            "USE" => {
                let name = self.word()?;
                if let Some(id) = self.builder.used(name, offset) {
                    self.attach(parent, id);
                }
                Ok(())
            }
            "DEF" => {
                let (name, kind) = (self.word()?, self.word()?);
                self.node(kind, name, parent, depth)
            }
            kind => self.node(kind, "", parent, depth),
        }
    }

    fn attach(&mut self, parent: Option<(NodeId, &'a str)>, id: NodeId) {
        let field = parent.map_or("", |(_, field)| field);
        self.builder
            .attach(parent.map(|p| p.0), Cow::Borrowed(field), id);
    }

    fn node(
        &mut self,
        kind: &'a str,
        def: &'a str,
        parent: Option<(NodeId, &'a str)>,
        depth: usize,
    ) -> Result<(), ReadError> {
        let offset = self.at;
        self.builder.check_depth(depth, offset)?;
        if declares_fields(kind) {
            return self.skip_value();
        }
        if kind == "Inline" {
            self.left_out(kind, offset);
        }
        if self.next()? != Token::Mark('{') {
            return Err(self.expected(offset, &format!("{{ after {kind}")));
        }
        let id = self.builder.open(standard_kind(kind), offset)?;
        self.builder.scene.nodes[id].def = Cow::Borrowed(def);
        loop {
            let start = self.skip_blank();
            match self.next()? {
                Token::Mark('}') => break,
                Token::Word("ROUTE") => self.route(start)?,
                Token::Word("PROTO" | "EXTERNPROTO") => {
                    self.at = start;
                    self.statement(None, depth + 1)?;
                }
                Token::Word(field) => self.value(id, field, depth)?,
                _ => return Err(self.expected(start, &format!("a field of {kind} or }}"))),
            }
        }
        self.attach(parent, id);
        self.builder.close(id);
        Ok(())
    }

    /// Parses the value of a field of any type.
    fn value(&mut self, id: NodeId, field: &'a str, depth: usize) -> Result<(), ReadError> {
        let field = match field {
            // H-Anim 1.1 and 2001.
            "humanoidBody" => "skeleton",
            other => other,
        };
        let start = self.skip_blank();
        let text = match self.next()? {
            Token::Text(text) => unescaped(text),
            Token::Mark('[') => match self.peek() {
                Token::Word(word) if !is_value(word) => {
                    while self.peek() != Token::Mark(']') {
                        self.statement(Some((id, field)), depth + 1)?;
                    }
                    return self.next().map(drop);
                }
                _ => Cow::Borrowed(self.list(start)?),
            },
            Token::Word("IS") => return self.next().map(drop),
            Token::Word(word) if is_value(word) => {
                while matches!(self.peek(), Token::Word(word) if is_number(word)) {
                    self.next()?;
                }
                Cow::Borrowed(&self.text[start..self.at])
            }
            Token::Word(_) => {
                self.at = start;
                return self.statement(Some((id, field)), depth + 1);
            }
            _ => return Err(self.expected(start, &format!("a value of {field}"))),
        };
        let texts = &mut self.builder.scene.nodes[id].texts;
        texts.push((Cow::Borrowed(field), text));
        Ok(())
    }

    /// Returns the text of a list whose opening bracket was already consumed.
    fn list(&mut self, start: usize) -> Result<&'a str, ReadError> {
        let first = self.at;
        loop {
            let end = self.skip_blank();
            match self.next()? {
                Token::Mark(']') => return Ok(&self.text[first..end]),
                Token::Word(_) | Token::Text(_) => {}
                _ => return Err(self.expected(start, "] at the end of a list")),
            }
        }
    }

    fn route(&mut self, offset: usize) -> Result<(), ReadError> {
        let (from, to_word, to) = (self.word()?, self.word()?, self.word()?);
        match (from.rsplit_once('.'), to.rsplit_once('.')) {
            (Some(from), Some(to)) if to_word == "TO" => {
                self.builder.route(from, to, offset);
                Ok(())
            }
            _ => Err(self.expected(offset, "ROUTE node.field TO node.field")),
        }
    }

    fn left_out(&mut self, what: &str, offset: usize) {
        let what = format!("{what} is not read; its content is left out");
        self.builder.warn(offset, what);
    }

    /// Skips `AS name`, if present.
    fn skip_word(&mut self, word: &str) -> Result<(), ReadError> {
        if self.peek() == Token::Word(word) {
            self.next()?;
            self.next()?;
        }
        Ok(())
    }

    /// Skips a string, or everything from a bracket to its counterpart.
    fn skip_value(&mut self) -> Result<(), ReadError> {
        let start = self.skip_blank();
        let mut open = 0u64;
        loop {
            match self.next()? {
                Token::Mark('{' | '[') => open += 1,
                Token::Mark(_) if open > 0 => open -= 1,
                Token::Mark(_) | Token::End => return Err(self.expected(start, "a value")),
                _ => {}
            }
            if open == 0 {
                return Ok(());
            }
        }
    }

    fn word(&mut self) -> Result<&'a str, ReadError> {
        let start = self.skip_blank();
        match self.next()? {
            Token::Word(word) => Ok(word),
            _ => Err(self.expected(start, "a name")),
        }
    }

    fn peek(&mut self) -> Token<'a> {
        let before = self.at;
        let token = self.next().unwrap_or(Token::End);
        self.at = before;
        token
    }

    fn next(&mut self) -> Result<Token<'a>, ReadError> {
        let start = self.skip_blank();
        let rest = &self.text[start..];
        let Some(first) = rest.chars().next() else {
            return Ok(Token::End);
        };
        match first {
            '{' | '}' | '[' | ']' => {
                self.at += 1;
                Ok(Token::Mark(first))
            }
            '"' => {
                let Some(length) = quoted(&rest[1..]) else {
                    let what = "the string has no closing quotation mark";
                    return Err(self.builder.malformed(start, what));
                };
                self.at += length + 2;
                Ok(Token::Text(&rest[1..=length]))
            }
            _ => {
                let ends = |c: char| is_blank(c) || matches!(c, '{' | '}' | '[' | ']' | '"' | '#');
                let length = rest.find(ends).unwrap_or(rest.len());
                self.at += length;
                Ok(Token::Word(&rest[..length]))
            }
        }
    }

    /// Skips blanks and comments; returns the new position.
    fn skip_blank(&mut self) -> usize {
        loop {
            let rest = &self.text[self.at..];
            let blank = rest.len() - rest.trim_start_matches(is_blank).len();
            self.at += blank;
            if !self.text[self.at..].starts_with('#') {
                return self.at;
            }
            let rest = &self.text[self.at..];
            self.at += rest.find(['\n', '\r']).unwrap_or(rest.len());
        }
    }

    fn expected(&mut self, start: usize, what: &str) -> ReadError {
        self.at = start;
        let found = match self.next() {
            Ok(Token::Word(word)) => format!("\"{}\"", super::scene::shortened(word)),
            Ok(Token::Text(_)) => "a string".to_owned(),
            Ok(Token::Mark(mark)) => format!("\"{mark}\""),
            Ok(Token::End) => "the end of the file".to_owned(),
            Err(error) => return error,
        };
        let what = format!("found {found}, expected {what}");
        self.builder.malformed(start, what)
    }
}

/// Commas are blanks.
fn is_blank(c: char) -> bool {
    c.is_whitespace() || c == ','
}

fn is_number(word: &str) -> bool {
    let digits = word.trim_start_matches(['-', '+', '.']);
    digits.starts_with(|c: char| c.is_ascii_digit())
}

/// Returns whether a word is a value, not the type of a node.
fn is_value(word: &str) -> bool {
    is_number(word) || matches!(word, "TRUE" | "FALSE" | "true" | "false")
}

/// Returns the length of a string whose opening quotation mark was consumed.
fn quoted(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let mut at = 0;
    loop {
        at += bytes[at..].iter().position(|b| matches!(b, b'"' | b'\\'))?;
        if bytes[at] == b'"' {
            return Some(at);
        }
        // A character after a backslash cannot end the string.
        at += 2;
        if at > bytes.len() {
            return None;
        }
    }
}

fn unescaped(text: &str) -> Cow<'_, str> {
    if !text.contains('\\') {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        plain.extend(if c == '\\' { chars.next() } else { Some(c) });
    }
    Cow::Owned(plain)
}
