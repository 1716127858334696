//! The picture of a player clip: which triangles show it, and where.
//!
//! Source: `docs/formats/artv.md`, *texture*; `docs/methods/vector.md` 8.3.

use super::error::PlayerError;
use super::stream::{Reader, Writer};
use crate::picture::Picture;
use crate::planar::PlanarTexture;
use glam::Vec2;
use std::sync::Arc;

/// Steps of a texture coordinate per pixel of the picture.
pub(super) const STEPS_PER_PIXEL: f32 = 4.0;
/// Maximum absolute texture coordinate, in steps.
const MAX_PLACE: i32 = 1 << 18;

/// The picture that triangles of a player file show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShownTexture {
    /// Number of triangles that show it.
    pub triangles: usize,
    /// Width and height, pixels.
    pub size_px: (u32, u32),
    /// Size of the picture, bytes.
    pub bytes: u64,
}

/// A picture, and the places in it that wedges show.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlayerTexture {
    /// The picture as a file.
    pub(super) file: Vec<u8>,
    /// The decoded picture.
    pub(super) picture: Arc<Picture>,
    /// Whether each triangle shows the picture; others are filled by their colours.
    pub(super) shows: Vec<bool>,
    /// Texture coordinate of each wedge, quarters of a pixel of the picture from its top left; zero
    /// for wedges of no triangle that shows it.
    pub(super) places: Vec<[i32; 2]>,
}

impl PlayerTexture {
    /// Decodes a picture and rounds the texture coordinates, which are in pixels of it.
    ///
    /// # Errors
    /// The message of the decoder.
    pub(super) fn new(
        file: Vec<u8>,
        shows: Vec<bool>,
        places_px: impl Iterator<Item = Vec2>,
    ) -> Result<Self, PlayerError> {
        let whole = |at: f32| {
            let steps = (at * STEPS_PER_PIXEL).round();
            steps.clamp(-MAX_PLACE as f32, MAX_PLACE as f32) as i32
        };
        Ok(Self {
            picture: decoded(&file)?,
            file,
            shows,
            places: places_px.map(|at| [whole(at.x), whole(at.y)]).collect(),
        })
    }

    /// Texture coordinates of the wedges in pixels, with the picture.
    pub(super) fn planar(&self) -> PlanarTexture {
        let pixels = |steps: i32| steps as f32 / STEPS_PER_PIXEL;
        let places = self.places.iter();
        PlanarTexture {
            picture: self.picture.clone(),
            shows: self.shows.clone(),
            places: places
                .map(|[x, y]| Vec2::new(pixels(*x), pixels(*y)))
                .collect(),
        }
    }

    pub(super) fn write(&self, to: &mut Writer, triangles: &[[u32; 3]], parents: &[u32]) {
        for run in runs(&self.shows) {
            to.unsigned(run);
        }
        let has_place = wedges_shown(&self.shows, triangles, parents.len());
        for wedge in (0..parents.len()).filter(|w| has_place[*w]) {
            let guess = guess(&self.places, &has_place, parents, wedge);
            for (place, guess) in self.places[wedge].into_iter().zip(guess) {
                to.signed(place - guess);
            }
        }
        to.unsigned(self.file.len() as u32);
        to.0.extend_from_slice(&self.file);
    }

    pub(super) fn read(
        from: &mut Reader<'_>,
        triangles: &[[u32; 3]],
        parents: &[u32],
    ) -> Result<Self, PlayerError> {
        let shows = shown(from, triangles.len())?;
        let has_place = wedges_shown(&shows, triangles, parents.len());
        let mut places = vec![[0; 2]; parents.len()];
        for wedge in (0..parents.len()).filter(|w| has_place[*w]) {
            let guess = guess(&places, &has_place, parents, wedge);
            for axis in 0..2 {
                let place = i64::from(guess[axis]) + i64::from(from.signed()?);
                if place.abs() > i64::from(MAX_PLACE) {
                    let what = "a texture coordinate is out of range";
                    return Err(PlayerError::Malformed(what));
                }
                places[wedge][axis] = place as i32;
            }
        }
        let length = from.unsigned()? as usize;
        let file = from.take(length)?.to_vec();
        Ok(Self {
            picture: decoded(&file)?,
            file,
            shows,
            places,
        })
    }
}

/// The parent's coordinate, which is known; without one that has a coordinate, zero.
fn guess(places: &[[i32; 2]], has_place: &[bool], parents: &[u32], wedge: usize) -> [i32; 2] {
    let parent = parents[wedge] as usize;
    if parent < wedge && has_place[parent] {
        places[parent]
    } else {
        [0; 2]
    }
}

/// Lengths of alternating runs, of triangles without and with the picture; the first may be 0.
fn runs(shows: &[bool]) -> Vec<u32> {
    let mut runs = vec![0];
    for shows in shows {
        let is_shown = runs.len() % 2 == 0;
        if *shows != is_shown {
            runs.push(0);
        }
        if let Some(last) = runs.last_mut() {
            *last += 1;
        }
    }
    runs
}

fn shown(from: &mut Reader<'_>, count: usize) -> Result<Vec<bool>, PlayerError> {
    let mut shows = Vec::with_capacity(count);
    let mut is_shown = false;
    while shows.len() < count {
        let run = from.unsigned()? as usize;
        if run > count - shows.len() || (run == 0 && (is_shown || !shows.is_empty())) {
            return Err(PlayerError::Malformed(
                "the runs of triangles with the picture do not fit",
            ));
        }
        shows.extend(std::iter::repeat_n(is_shown, run));
        is_shown = !is_shown;
    }
    Ok(shows)
}

/// Whether each wedge is a corner of a triangle that shows the picture.
fn wedges_shown(shows: &[bool], triangles: &[[u32; 3]], wedges: usize) -> Vec<bool> {
    let mut of = vec![false; wedges];
    let shown = triangles.iter().zip(shows).filter(|(_, shows)| **shows);
    for wedge in shown.flat_map(|(t, _)| t) {
        of[*wedge as usize] = true;
    }
    of
}

fn decoded(file: &[u8]) -> Result<Arc<Picture>, PlayerError> {
    let picture = Picture::decode(file).map_err(|e| PlayerError::Picture(e.to_string()))?;
    Ok(Arc::new(picture))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_alternate_and_begin_without_the_picture() {
        assert_eq!(runs(&[true, true, false]), [0, 2, 1]);
        assert_eq!(runs(&[false, true]), [1, 1]);
        assert_eq!(runs(&[false; 3]), [3]);
        for shows in [
            &[true, true, false][..],
            &[false, true],
            &[false; 3],
            &[true],
        ] {
            let mut to = Writer::default();
            runs(shows).into_iter().for_each(|run| to.unsigned(run));
            let mut from = Reader::new(&to.0);
            assert_eq!(shown(&mut from, shows.len()).unwrap(), shows);
            assert!(from.is_at_end());
        }
        for bad in [&[4][..], &[1, 0, 2], &[0, 0, 3], &[1, 3]] {
            assert!(shown(&mut Reader::new(bad), 3).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn coordinates_follow_the_corner_named_before() {
        let picture = Picture::new(8, 8, [9, 9, 9, 255]).unwrap();
        let file = picture.to_png().unwrap();
        // Wedges 0 to 2 show the picture, 3 belongs to a plain triangle, 4 comes after it.
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 3, 4]];
        let parents = [0, 0, 1, 2, 3];
        let at = [[1.0, 1.0], [3.0, 1.25], [3.0, 5.0], [0.0, 0.0], [7.0, 7.0]];
        let places = at.into_iter().map(Vec2::from_array);
        let texture = PlayerTexture::new(file.clone(), vec![true, false, false], places);
        let mut texture = texture.unwrap();
        texture.places[4] = [0; 2];
        let mut to = Writer::default();
        texture.write(&mut to, &triangles, &parents);
        // Runs 0, 1, 2; then (4, 4), (8, 1), (0, 15) as zigzag numbers.
        assert_eq!(to.0[..9], [0, 1, 2, 8, 8, 16, 2, 0, 30]);
        let found = PlayerTexture::read(&mut Reader::new(&to.0), &triangles, &parents);
        assert_eq!(found.as_ref(), Ok(&texture));
        assert_eq!(texture.planar().places[1], Vec2::new(3.0, 1.25));
        let cut = &to.0[..to.0.len() - 1];
        let cut = PlayerTexture::read(&mut Reader::new(cut), &triangles, &parents);
        assert_eq!(cut, Err(PlayerError::Truncated));
        let broken = PlayerTexture::new(vec![1, 2, 3], vec![], std::iter::empty());
        assert!(matches!(broken, Err(PlayerError::Picture(_))));
    }
}
