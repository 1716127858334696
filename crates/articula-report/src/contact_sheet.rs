//! Contact sheets: small pictures in labelled rows and columns, with a legend.

use crate::paint::{TextStyle, draw_box, draw_text};
use crate::skeleton::JointMark;
use articula::flat::{Picture, PictureError, Rgba};
use glam::Vec2;

const PAPER: Rgba = [255, 255, 255, 255];
const INK: Rgba = [28, 30, 36, 255];
const SOFT_INK: Rgba = [92, 97, 108, 255];
const FRAME: Rgba = [214, 217, 224, 255];
/// Margin of the page, pixels.
const MARGIN: u32 = 24;
/// Gap between cells, pixels.
const GAP: u32 = 16;
/// Gap between the tiles of one cell, pixels.
const TILE_GAP: u32 = 4;
/// Gap between lines of text, pixels.
const LEADING: u32 = 6;
/// Maximum width of a row label, pixels; longer ones are shortened.
const ROW_LABEL: u32 = 200;

/// A picture with a line of text below it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SheetTile {
    /// The picture.
    pub picture: Picture,
    /// Caption; may be empty.
    pub caption: String,
}

/// Tiles of one row and column, side by side, such as a reference, the reduced character and their
/// difference.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SheetCell {
    /// The tiles; a cell without tiles is blank.
    pub tiles: Vec<SheetTile>,
}

/// A row of a contact sheet.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SheetRow {
    /// Label of the row.
    pub label: String,
    /// One cell per column; missing ones are blank.
    pub cells: Vec<SheetCell>,
}

/// A page of pictures in rows and columns.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ContactSheet {
    /// Heading.
    pub title: String,
    /// Lines below the heading.
    pub notes: Vec<String>,
    /// Labels of the columns.
    pub columns: Vec<String>,
    /// The rows.
    pub rows: Vec<SheetRow>,
    /// Whether a legend explains the joint marks ([`JointMark`]).
    pub explains_joints: bool,
}

impl ContactSheet {
    /// Draws the page. Columns are as wide and rows as high as their largest cell.
    ///
    /// # Errors
    /// [`PictureError::LimitExceeded`] if the page would be too large.
    pub fn draw(&self) -> Result<Picture, PictureError> {
        let layout = Layout::new(self);
        let mut page = Picture::new(layout.width, layout.height, PAPER)?;
        self.draw_head(&mut page, &layout);
        for (column, label) in self.columns.iter().enumerate() {
            let (x, width) = layout.columns[column];
            let label = TextStyle::Strong.fitted(label, width);
            let indent = (width - TextStyle::Strong.width(&label)) / 2;
            let y = layout.labels;
            draw_text(
                &mut page,
                (x + indent) as i32,
                y as i32,
                &label,
                TextStyle::Strong,
                INK,
            );
        }
        for (row, (y, height)) in self.rows.iter().zip(&layout.rows) {
            let label = TextStyle::Strong.fitted(&row.label, ROW_LABEL);
            let middle = y + height / 2 - TextStyle::Strong.height() / 2;
            draw_text(
                &mut page,
                MARGIN as i32,
                middle as i32,
                &label,
                TextStyle::Strong,
                INK,
            );
            for (cell, (x, width)) in row.cells.iter().zip(&layout.columns) {
                let indent = (width - cell.size().0) / 2;
                cell.draw(&mut page, x + indent, *y);
            }
        }
        Ok(page)
    }

    /// Marks in the legend.
    fn legend(&self) -> &'static [JointMark] {
        if self.explains_joints {
            &JointMark::ALL
        } else {
            &[]
        }
    }

    fn draw_head(&self, page: &mut Picture, layout: &Layout) {
        let room = layout.width - 2 * MARGIN;
        let x = MARGIN as i32;
        let title = TextStyle::Title.fitted(&self.title, room);
        draw_text(page, x, MARGIN as i32, &title, TextStyle::Title, INK);
        let mut y = MARGIN + TextStyle::Title.height() + LEADING;
        for note in &self.notes {
            let note = TextStyle::Body.fitted(note, room);
            draw_text(page, x, y as i32, &note, TextStyle::Body, SOFT_INK);
            y += TextStyle::Body.height() + LEADING;
        }
        let mut x = MARGIN as f32;
        for mark in self.legend() {
            let middle = y as f32 + 0.5 * TextStyle::Body.height() as f32;
            mark.draw(page, Vec2::new(x + 6.0, middle), 6.0);
            let text = mark.name();
            draw_text(page, x as i32 + 18, y as i32, text, TextStyle::Body, INK);
            x += (TextStyle::Body.width(text) + 42) as f32;
        }
    }
}

impl SheetCell {
    /// Returns a cell of one picture.
    pub fn of(picture: Picture, caption: impl Into<String>) -> Self {
        let caption = caption.into();
        Self {
            tiles: vec![SheetTile { picture, caption }],
        }
    }

    fn size(&self) -> (u32, u32) {
        let gaps = TILE_GAP * (self.tiles.len() as u32).saturating_sub(1);
        let width = self.tiles.iter().map(|t| t.picture.width()).sum::<u32>();
        let height = self.tiles.iter().map(SheetTile::height).max().unwrap_or(0);
        (width + gaps, height)
    }

    fn draw(&self, page: &mut Picture, x: u32, y: u32) {
        let mut x = x;
        for tile in &self.tiles {
            tile.draw(page, x, y);
            x += tile.picture.width() + TILE_GAP;
        }
    }
}

impl SheetTile {
    fn height(&self) -> u32 {
        let caption = match self.caption.is_empty() {
            true => 0,
            false => TextStyle::Body.height() + LEADING,
        };
        self.picture.height() + caption
    }

    fn draw(&self, page: &mut Picture, x: u32, y: u32) {
        let (width, height) = (self.picture.width(), self.picture.height());
        let (left, top) = (x as i32, y as i32);
        draw_box(page, left - 1, top - 1, width + 2, height + 2, FRAME);
        draw_box(page, left, top, width, height, PAPER);
        page.blit(&self.picture, left, top);
        let caption = TextStyle::Body.fitted(&self.caption, width);
        let indent = (width - TextStyle::Body.width(&caption).min(width)) / 2;
        let below = top + height as i32 + LEADING as i32 / 2;
        draw_text(
            page,
            left + indent as i32,
            below,
            &caption,
            TextStyle::Body,
            SOFT_INK,
        );
    }
}

/// Positions of all parts of the page.
struct Layout {
    width: u32,
    height: u32,
    /// Top of the column labels.
    labels: u32,
    /// Left edge and width of each column.
    columns: Vec<(u32, u32)>,
    /// Top edge and height of each row.
    rows: Vec<(u32, u32)>,
}

impl Layout {
    fn new(sheet: &ContactSheet) -> Self {
        let label = |row: &SheetRow| TextStyle::Strong.width(&row.label).min(ROW_LABEL);
        let labels_width = sheet.rows.iter().map(label).max().unwrap_or(0);
        let mut x = MARGIN + labels_width + if labels_width > 0 { GAP } else { 0 };
        let cells = sheet.rows.iter().map(|r| r.cells.len()).max().unwrap_or(0);
        let mut columns = Vec::new();
        for column in 0..cells.max(sheet.columns.len()) {
            let in_column = sheet.rows.iter().filter_map(|r| r.cells.get(column));
            let label = sheet.columns.get(column).map_or("", String::as_str);
            // A label may widen a narrow column up to a limit.
            let label = TextStyle::Strong.width(label).min(240);
            let width = in_column.map(|c| c.size().0).max().unwrap_or(0).max(label);
            columns.push((x, width));
            x = x.saturating_add(width + GAP);
        }
        let body = TextStyle::Body.height() + LEADING;
        let mut y = MARGIN + TextStyle::Title.height() + LEADING;
        y += body * sheet.notes.len() as u32;
        y += if sheet.legend().is_empty() { 0 } else { body };
        let labels = y + LEADING;
        if !sheet.columns.is_empty() {
            y = labels + TextStyle::Strong.height();
        }
        y += LEADING + 2;
        let mut rows = Vec::new();
        for row in &sheet.rows {
            let height = row.cells.iter().map(|c| c.size().1).max().unwrap_or(0);
            rows.push((y, height.max(TextStyle::Strong.height())));
            y = y.saturating_add(height.max(TextStyle::Strong.height()) + GAP);
        }
        let right = x.saturating_sub(GAP).saturating_add(MARGIN);
        Self {
            width: right.max(Self::head_width(sheet) + 2 * MARGIN),
            height: y.saturating_sub(GAP).saturating_add(MARGIN),
            labels,
            columns,
            rows,
        }
    }

    /// Width that the heading needs, up to a limit.
    fn head_width(sheet: &ContactSheet) -> u32 {
        let notes = sheet.notes.iter().map(|n| TextStyle::Body.width(n)).max();
        let legend = sheet.legend().iter();
        let legend: u32 = legend.map(|e| TextStyle::Body.width(e.name()) + 42).sum();
        TextStyle::Title
            .width(&sheet.title)
            .max(notes.unwrap_or(0))
            .max(legend)
            .min(1200)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(width: u32, height: u32, color: Rgba) -> SheetTile {
        SheetTile {
            picture: Picture::new(width, height, color).unwrap(),
            caption: String::new(),
        }
    }

    #[test]
    fn every_tile_is_on_the_page_unharmed() {
        let red = |level: u8| [200, level, 0, 255];
        let cell = |level: u8, width| SheetCell {
            tiles: vec![tile(width, 50, red(level)), tile(30, 40, red(level + 1))],
        };
        let sheet = ContactSheet {
            title: "T".into(),
            columns: vec!["a".into(), "b".into()],
            rows: vec![
                SheetRow {
                    label: "first".into(),
                    cells: vec![cell(10, 40), cell(20, 60)],
                },
                SheetRow {
                    label: "second".into(),
                    cells: vec![cell(30, 20)],
                },
            ],
            ..ContactSheet::default()
        };
        let page = sheet.draw().unwrap();
        let count = |color| page.pixels().iter().filter(|p| **p == color).count();
        for (level, area) in [(10, 40 * 50), (20, 60 * 50), (30, 20 * 50)] {
            assert_eq!(count(red(level)), area);
            assert_eq!(count(red(level + 1)), 30 * 40);
        }
        assert_eq!(page.get(0, 0), Some(PAPER));
        assert!(count(INK) > 0, "labels are written");
    }

    #[test]
    fn an_empty_sheet_is_a_small_page_and_a_huge_one_an_error() {
        let page = ContactSheet::default().draw().unwrap();
        assert!(page.width() >= 2 * MARGIN && page.height() >= 2 * MARGIN);
        let wide = SheetCell {
            tiles: vec![tile(16_000, 1, PAPER), tile(16_000, 1, PAPER)],
        };
        let row = SheetRow {
            cells: vec![wide],
            ..SheetRow::default()
        };
        let sheet = ContactSheet {
            rows: vec![row],
            ..ContactSheet::default()
        };
        assert!(sheet.draw().is_err());
    }
}
