//! The reference human with its colours in a picture.

use crate::error::{Error, Result};
use articula_core::source::{Character, Image};
use articula_flat::Picture;

/// Creates the reference human with a face, with its colours in a PNG of 512 px: blushes, lashes, hair in strands, a
/// shirt with buttons, pockets, laces, and the shade of folds. Shape, blend shapes and clips are those of
/// [`human`](crate::human::human) with as many triangles.
///
/// # Errors
/// [`Error::Unsupported`] if the number of triangles is outside of [`TRIANGLES`](crate::human::TRIANGLES).
pub fn painted_human(triangles: usize) -> Result<Character> {
    let painted = articula_human::painted_human(triangles);
    let painted = painted.map_err(|e| Error::Unsupported(e.to_string()))?;
    let opaque = painted.pixels.iter().map(|[r, g, b]| [*r, *g, *b, 255]);
    let picture = Picture::from_pixels(painted.side, painted.side, opaque.collect())?;
    let image = Image {
        name: "painted".to_owned(),
        mime_type: "image/png".to_owned(),
        bytes: picture.to_small_png()?,
    };
    Ok(Character {
        images: vec![image],
        ..painted.character
    })
}
