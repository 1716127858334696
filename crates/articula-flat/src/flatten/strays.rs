//! Stray pixels of a written file: those drawn outside of the figure's silhouette, or in a colour
//! that none of the triangles around them has.
//!
//! Source: `docs/methods/vector.md` 9. Sealed edges reach beyond their triangles; where a corner
//! sticks out it shows as a thorn, which neither a mean error nor similarity notices. The file is
//! compared with its own triangles, not sealed and painted in its own order, so that neither
//! simplification nor a wrong order counts.

use super::source_frames::BACKGROUND;
use crate::compare::same_size;
use crate::item_buffer::Supersampling;
use crate::picture::{Picture, Rgba};
use crate::planar::reference::reference_with_mask;
use crate::planar::{PlanarClip, PlanarError, PlanarFrame};

/// Enlargement of the compared pictures: thorns are seen on dense displays.
pub(super) const FACTOR: u32 = 2;
/// Difference from all colours around a pixel above which it is stray, levels.
const OFF: u8 = 32;
/// Maximum side of the enlarged pictures, pixels.
const MOST_PX: u32 = 2048;

/// Numbers of stray pixels and of the figure's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Strays {
    stray: usize,
    figure: usize,
}

impl Strays {
    /// Whether pictures of a clip are small enough to be compared.
    pub(super) fn are_counted(clip: &PlanarClip) -> bool {
        FACTOR * clip.width.max(clip.height) <= MOST_PX
    }

    /// Counts those of an enlarged picture of a frame, in which some triangles are drawn back to front.
    ///
    /// O(pixels).
    ///
    /// # Errors
    /// [`PlanarError::Picture`] if the picture has another size.
    pub(super) fn count(
        clip: &PlanarClip,
        (frame, order): (usize, &[u32]),
        shown: &Picture,
        tolerance_px: f32,
    ) -> Result<Self, PlanarError> {
        let clip = unsealed(clip, frame, order);
        let (own, mask) = reference_with_mask(&clip, 0, Supersampling::Two, BACKGROUND)?;
        same_size(&own, shown)?;
        let figure = mask.iter().filter(|m| **m).count();
        // Edges may be off by half a pixel, and by the tolerance of positions.
        let reach = (FACTOR as f32 * tolerance_px.clamp(0.0, 8.0))
            .ceil()
            .max(1.0);
        let ranges = Ranges::of(&own, reach as usize);
        let pairs = shown
            .pixels()
            .iter()
            .zip(ranges.low.iter().zip(&ranges.high));
        let is_stray = |(shown, (low, high)): &(&Rgba, (&Rgba, &Rgba))| {
            (0..3).any(|k| {
                shown[k] > high[k].saturating_add(OFF) || shown[k] < low[k].saturating_sub(OFF)
            })
        };
        Ok(Self {
            stray: pairs.filter(is_stray).count(),
            figure,
        })
    }

    /// Adds those of another picture.
    pub(super) fn add(&mut self, other: Self) {
        self.stray += other.stray;
        self.figure += other.figure;
    }

    /// Stray pixels, percent of the figure's.
    pub(super) fn percent(self) -> f64 {
        100.0 * self.stray as f64 / self.figure.max(1) as f64
    }
}

/// The triangles of an order, enlarged; the later, the nearer.
fn unsealed(clip: &PlanarClip, frame: usize, order: &[u32]) -> PlanarClip {
    let mut out = PlanarClip {
        width: FACTOR * clip.width,
        height: FACTOR * clip.height,
        fps: clip.fps,
        frames: vec![PlanarFrame::default()],
        triangles: Vec::with_capacity(order.len()),
        surface: vec![0; order.len()],
        part: vec![0; order.len()],
        surfaces: clip.surfaces.clone(),
        albedo: Vec::with_capacity(3 * order.len()),
        texture: None,
    };
    let (from, to) = (&clip.frames[frame], &mut out.frames[0]);
    for (rank, t) in order.iter().enumerate() {
        let first = out.albedo.len() as u32;
        for v in clip.triangles[*t as usize].map(|v| v as usize) {
            to.xy.push(FACTOR as f32 * from.xy[v]);
            to.light.push(from.light[v]);
            to.nearness
                .push((rank + 1) as f32 / (order.len() + 1) as f32);
            out.albedo.push(clip.albedo[v]);
        }
        out.triangles.push([first, first + 1, first + 2]);
    }
    out
}

/// Least and greatest levels within some pixels of each pixel.
struct Ranges {
    low: Vec<Rgba>,
    high: Vec<Rgba>,
}

impl Ranges {
    /// Along rows, then along columns.
    fn of(picture: &Picture, reach: usize) -> Self {
        let (width, height) = (picture.width() as usize, picture.height() as usize);
        let low = |a: Rgba, b: Rgba| std::array::from_fn(|k| a[k].min(b[k]));
        let high = |a: Rgba, b: Rgba| std::array::from_fn(|k| a[k].max(b[k]));
        let both = |pixels: &[Rgba], fold: &dyn Fn(Rgba, Rgba) -> Rgba| {
            let mut across = pixels.to_vec();
            for (at, out) in across.iter_mut().enumerate() {
                let (x, row) = (at % width, at - at % width);
                for i in x.saturating_sub(reach)..=(x + reach).min(width - 1) {
                    *out = fold(*out, pixels[row + i]);
                }
            }
            let mut down = across.clone();
            for (at, out) in down.iter_mut().enumerate() {
                let (x, y) = (at % width, at / width);
                for j in y.saturating_sub(reach)..=(y + reach).min(height - 1) {
                    *out = fold(*out, across[j * width + x]);
                }
            }
            down
        };
        Self {
            low: both(picture.pixels(), &low),
            high: both(picture.pixels(), &high),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flatten::{PrepareClipOptions, PreparedClip};
    use crate::planar::clip::fixture;
    use articula_core::Progress;

    #[test]
    fn what_lies_outside_or_has_a_foreign_colour_is_counted_and_a_shifted_edge_is_not() {
        let cube = fixture::turning_cube(2);
        let options = PrepareClipOptions::default();
        let prepared = PreparedClip::new(cube, &options, &mut Progress::none()).unwrap();
        let order = prepared.order_at(0);
        let clip = unsealed(&prepared.clip, 0, &order);
        let (own, mask) = reference_with_mask(&clip, 0, Supersampling::Two, BACKGROUND).unwrap();
        let count =
            |shown: &Picture| Strays::count(&prepared.clip, (0, &order), shown, 0.35).unwrap();
        assert_eq!(count(&own).stray, 0);
        assert_eq!(count(&own).figure, mask.iter().filter(|m| **m).count());
        let mut thorn = own.clone();
        (0..5).for_each(|x| thorn.set(2 + x, 3, [60, 100, 45, 255]));
        (0..3).for_each(|x| thorn.set(99 + x, 100, [255, 0, 255, 255]));
        assert_eq!(count(&thorn).stray, 8);
        let mut shifted = own.clone();
        for (x, y) in (1..200).flat_map(|x| (0..200).map(move |y| (x, y))) {
            shifted.set(x, y, own.get(x - 1, y).unwrap());
        }
        assert_eq!(count(&shifted).stray, 0);
        assert!(
            Strays::count(
                &prepared.clip,
                (0, &order),
                &Picture::new(9, 9, BACKGROUND).unwrap(),
                0.0
            )
            .is_err()
        );
        let mut all = count(&thorn);
        all.add(count(&own));
        assert!((all.percent() - 100.0 * 8.0 / (2 * count(&own).figure) as f64).abs() < 1e-9);
    }
}
