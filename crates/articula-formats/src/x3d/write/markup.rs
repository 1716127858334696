//! XML text: tags and attributes, in single quotes as X3D is commonly written.

use std::fmt::Write as _;

/// A document under construction.
#[derive(Debug, Default)]
pub(super) struct Markup {
    text: String,
    /// Tags that are open.
    open: Vec<&'static str>,
    /// Whether the last tag still accepts attributes.
    in_tag: bool,
}

impl Markup {
    pub(super) fn new() -> Self {
        Self {
            text: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned(),
            ..Self::default()
        }
    }

    /// Opens an element; attributes follow.
    pub(super) fn open(&mut self, tag: &'static str) -> &mut Self {
        self.end_tag();
        self.text.extend(std::iter::repeat_n(' ', self.open.len()));
        self.text.push('<');
        self.text.push_str(tag);
        self.open.push(tag);
        self.in_tag = true;
        self
    }

    /// Closes the last element that was opened.
    pub(super) fn close(&mut self) {
        let Some(tag) = self.open.pop() else { return };
        if self.in_tag {
            self.text.push_str("/>\n");
            self.in_tag = false;
            return;
        }
        self.text.extend(std::iter::repeat_n(' ', self.open.len()));
        let _ = writeln!(self.text, "</{tag}>");
    }

    fn end_tag(&mut self) {
        if self.in_tag {
            self.text.push_str(">\n");
            self.in_tag = false;
        }
    }

    /// Adds an attribute.
    pub(super) fn set(&mut self, name: &str, value: &str) -> &mut Self {
        let _ = write!(self.text, " {name}='");
        for c in value.chars() {
            match c {
                '&' => self.text.push_str("&amp;"),
                '<' => self.text.push_str("&lt;"),
                '>' => self.text.push_str("&gt;"),
                '\'' => self.text.push_str("&apos;"),
                // XML cannot represent most control characters.
                c if c.is_control() => self.text.push(' '),
                c => self.text.push(c),
            }
        }
        self.text.push('\'');
        self
    }

    /// Adds an attribute of numbers, with a comma after each group.
    pub(super) fn numbers<T: Number>(
        &mut self,
        name: &str,
        tuple: usize,
        numbers: impl IntoIterator<Item = T>,
    ) -> &mut Self {
        let _ = write!(self.text, " {name}='");
        for (i, number) in numbers.into_iter().enumerate() {
            if i > 0 {
                let between = if i % tuple == 0 { ", " } else { " " };
                self.text.push_str(between);
            }
            number.put(&mut self.text);
        }
        self.text.push('\'');
        self
    }

    /// Returns the whole text; no element may be open.
    pub(super) fn finish(mut self) -> Vec<u8> {
        while !self.open.is_empty() {
            self.close();
        }
        self.text.into_bytes()
    }
}

/// A number in a list.
pub(super) trait Number {
    fn put(self, text: &mut String);
}

impl Number for f32 {
    /// Writes the shortest text that reads as the same number.
    fn put(self, text: &mut String) {
        put_float(text, &format!("{self:?}"));
    }
}

impl Number for f64 {
    fn put(self, text: &mut String) {
        put_float(text, &format!("{self:?}"));
    }
}

impl Number for i64 {
    fn put(self, text: &mut String) {
        let _ = write!(text, "{self}");
    }
}

fn put_float(text: &mut String, number: &str) {
    let plain = number.strip_suffix(".0").unwrap_or(number);
    text.push_str(if plain == "-0" { "0" } else { plain });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_nest_and_text_is_escaped() {
        let mut markup = Markup::new();
        markup.open("X3D").set("version", "4.0");
        markup.open("a").set("b", "<'&\"\u{7}>");
        markup.close();
        markup
            .open("c")
            .numbers("d", 2, [1.0f32, -0.0, 0.25, 1e-20]);
        markup.numbers("e", 4, [0i64, 1, 2, -1, 3]);
        let text = String::from_utf8(markup.finish()).unwrap();
        let wanted = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<X3D version='4.0'>\n \
            <a b='&lt;&apos;&amp;\" &gt;'/>\n <c d='1 0, 0.25 1e-20' e='0 1 2 -1, 3'/>\n</X3D>\n";
        assert_eq!(text, wanted);
    }
}
