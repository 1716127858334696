//! Pictures of an atlas.

use super::cells::Cells;
use super::packed::{GUTTER, Places};
use crate::error::Result;
use articula_flat::{Averaging, Picture};
use std::collections::{BTreeMap, BTreeSet};

/// Width and height of each cell: those of its largest picture.
pub(super) fn sizes(cells: &Cells) -> Vec<[u32; 2]> {
    let largest = |pictures: &BTreeMap<usize, String>| {
        let all = pictures.keys().map(|i| &cells.decoded[i]);
        all.fold([1, 1], |[width, height], of| {
            [width.max(of.width()), height.max(of.height())]
        })
    };
    cells
        .cells
        .iter()
        .map(|cell| largest(&cell.pictures))
        .collect()
}

/// A picture file for each kind of texture, with the pictures that it stands for.
pub(super) fn pictures(
    cells: &Cells,
    places: &Places,
    averaging: &dyn Fn(usize) -> Averaging,
) -> Result<Vec<(BTreeSet<usize>, Vec<u8>)>> {
    let mut kinds: BTreeMap<&str, BTreeSet<usize>> = BTreeMap::new();
    for (picture, kind) in cells.cells.iter().flat_map(|cell| &cell.pictures) {
        kinds.entry(kind).or_default().insert(*picture);
    }
    let drawn = kinds.into_iter().map(|(kind, pictures)| {
        let side = places.side_px;
        let mut atlas = Picture::new(side, side, [0, 0, 0, 255])?;
        for (cell, place) in cells.cells.iter().zip(&places.rectangles) {
            let of_kind = cell.pictures.iter().find(|(_, of)| of.as_str() == kind);
            if let Some((i, _)) = of_kind {
                let [left, top, width, height] = *place;
                let small = cells.decoded[i].resized((width, height), averaging(*i))?;
                let framed = framed(&small, [width, height])?;
                atlas.put(&framed, left - GUTTER, top - GUTTER);
            }
        }
        Ok((pictures, atlas.to_small_png()?))
    });
    drawn.collect()
}

/// A picture at a size, with a gutter that repeats its border.
fn framed(picture: &Picture, [width, height]: [u32; 2]) -> Result<Picture> {
    let source = |of: u32, size: u32, own: u32| {
        let within = of.saturating_sub(GUTTER).min(size - 1);
        (u64::from(within) * u64::from(own) / u64::from(size)) as u32
    };
    let rows = (0..height + 2 * GUTTER).flat_map(|y| {
        let y = source(y, height, picture.height());
        let columns = (0..width + 2 * GUTTER).map(move |x| source(x, width, picture.width()));
        columns.map(move |x| picture.get(x, y).unwrap_or_default())
    });
    let (framed_width, framed_height) = (width + 2 * GUTTER, height + 2 * GUTTER);
    Ok(Picture::from_pixels(
        framed_width,
        framed_height,
        rows.collect(),
    )?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn borders_are_repeated_around_a_picture() {
        let [a, b] = [[255, 0, 0, 255], [0, 255, 0, 255]];
        let picture = Picture::from_pixels(2, 1, vec![a, b]).unwrap();
        let framed = framed(&picture, [4, 2]).unwrap();
        assert_eq!([framed.width(), framed.height()], [8, 6]);
        let line = [a, a, a, a, b, b, b, b];
        assert_eq!(framed.pixels(), line.repeat(6));
    }
}
