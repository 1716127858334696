//! Aligned text tables: text columns to the left, number columns to the right.

use crate::fault::clean;

/// Maximum width of a cell in characters; longer text is cut in the middle.
const WIDEST: usize = 44;

/// A measured length in millimetres, or a dash where there is none.
pub(crate) fn millimetres(metres: Option<f32>) -> String {
    metres.map_or("-".to_owned(), |m| format!("{:.2} mm", 1e3 * m))
}

/// Rows of text below a line of headings.
#[derive(Debug, Clone)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub(crate) fn new(headings: &[&str]) -> Self {
        Self {
            rows: vec![headings.iter().map(|h| (*h).to_owned()).collect()],
        }
    }

    /// Adds one row; it should have one cell per heading.
    pub(crate) fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) {
        let cells = cells.into_iter().map(|c| shortened(&clean(&c.into())));
        self.rows.push(cells.collect());
    }

    /// Whether the table has no row below the headings.
    pub(crate) fn is_empty(&self) -> bool {
        self.rows.len() < 2
    }

    /// Formats the table, indented by two spaces, without trailing blanks.
    pub(crate) fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let cell = |row: &'_ Vec<String>, c: usize| row.get(c).cloned().unwrap_or_default();
        let width = |c: usize| self.rows.iter().map(|r| length(&cell(r, c))).max();
        let widths: Vec<usize> = (0..columns).map(|c| width(c).unwrap_or(0)).collect();
        let numbers: Vec<bool> = (0..columns)
            .map(|c| self.rows[1..].iter().all(|r| is_number(&cell(r, c))))
            .collect();
        let mut text = String::new();
        for row in &self.rows {
            let mut line = String::from(" ");
            for c in 0..columns {
                let value = cell(row, c);
                let blanks = " ".repeat(widths[c] - length(&value));
                line.push(' ');
                if numbers[c] {
                    line.push_str(&blanks);
                }
                line.push_str(&value);
                if !numbers[c] {
                    line.push_str(&blanks);
                }
                line.push(' ');
            }
            text.push_str(line.trim_end());
            text.push('\n');
        }
        text
    }
}

/// A count with its noun in the singular or plural.
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

fn length(text: &str) -> usize {
    text.chars().count()
}

fn is_number(cell: &str) -> bool {
    let digits = cell.trim_end_matches(['%', 's', 'm', ' ']);
    cell.is_empty() || cell == "-" || digits.replace('/', "").parse::<f64>().is_ok()
}

/// Warnings, one on each line.
pub(crate) fn warnings(all: &[String]) -> String {
    let line = |warning: &String| format!("warning: {}\n", clean(warning));
    all.iter().map(line).collect()
}

fn shortened(text: &str) -> String {
    let count = length(text);
    if count <= WIDEST {
        return text.to_owned();
    }
    let half = (WIDEST - 1) / 2;
    let head: String = text.chars().take(half).collect();
    let tail: String = text.chars().skip(count - half).collect();
    format!("{head}…{tail}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_left_and_numbers_right() {
        let mut table = Table::new(&["clip", "frames"]);
        table.row(["walk", "7"]);
        table.row(["a", "120"]);
        assert_eq!(
            table.text(),
            "  clip  frames\n  walk       7\n  a        120\n"
        );
    }

    #[test]
    fn long_and_hostile_names_stay_in_their_cell() {
        let mut table = Table::new(&["name"]);
        table.row([format!("{}\n\u{1b}[2J", "x".repeat(100))]);
        let text = table.text();
        assert_eq!(text.lines().count(), 2);
        assert!(text.lines().all(|l| l.chars().count() <= WIDEST + 2));
        assert!(!text.contains('\u{1b}'));
    }
}
