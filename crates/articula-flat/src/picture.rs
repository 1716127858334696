//! RGBA pictures: 8-bit sRGB colours with straight alpha.

use crate::error::PictureError;
use crate::item_buffer::MAX_SIDE;

/// Red, green, blue and alpha, each 0 to 255, in sRGB.
pub type Rgba = [u8; 4];

/// A picture of RGBA pixels, row by row from the top left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<Rgba>,
}

impl Picture {
    /// Returns a picture of one colour.
    ///
    /// # Errors
    /// [`PictureError::LimitExceeded`] if a side is longer than 16,384 pixels.
    pub fn new(width: u32, height: u32, color: Rgba) -> Result<Self, PictureError> {
        if width > MAX_SIDE || height > MAX_SIDE {
            return Err(PictureError::LimitExceeded {
                width,
                height,
                samples: 1,
                limit: "16384 pixels per side",
            });
        }
        Ok(Self {
            width,
            height,
            pixels: vec![color; width as usize * height as usize],
        })
    }

    /// Returns a picture of existing pixels, row by row.
    ///
    /// # Errors
    /// [`PictureError::Mismatch`] if the number of pixels is not `width * height`, and
    /// [`PictureError::LimitExceeded`] as for [`Self::new`].
    pub fn from_pixels(width: u32, height: u32, pixels: Vec<Rgba>) -> Result<Self, PictureError> {
        let expected = u64::from(width) * u64::from(height);
        if pixels.len() as u64 != expected {
            return Err(PictureError::Mismatch {
                at: "pixels",
                what: format!("{} pixels, expected {width} x {height}", pixels.len()),
            });
        }
        let mut picture = Self::new(width, 0, [0; 4])?;
        Self::new(0, height, [0; 4])?;
        picture.height = height;
        picture.pixels = pixels;
        Ok(picture)
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns all pixels, row by row.
    pub fn pixels(&self) -> &[Rgba] {
        &self.pixels
    }

    /// Returns all pixels, mutable.
    pub(crate) fn pixels_mut(&mut self) -> &mut [Rgba] {
        &mut self.pixels
    }

    /// Returns one pixel; `None` outside the picture.
    pub fn get(&self, x: u32, y: u32) -> Option<Rgba> {
        (x < self.width && y < self.height)
            .then(|| self.pixels[y as usize * self.width as usize + x as usize])
    }

    /// Sets one pixel; does nothing outside the picture.
    pub(crate) fn set(&mut self, x: u32, y: u32, color: Rgba) {
        if x < self.width && y < self.height {
            self.pixels[y as usize * self.width as usize + x as usize] = color;
        }
    }

    /// Composites a colour over one pixel, weighted by its alpha times `coverage` (0 to 1). Does
    /// nothing outside the picture.
    pub fn blend(&mut self, x: i32, y: i32, color: Rgba, coverage: f32) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
            return;
        };
        if let Some(below) = self.get(x, y) {
            self.set(x, y, over(below, color, coverage));
        }
    }

    /// Returns the part that begins at `(x, y)`, clipped to this picture.
    #[must_use]
    pub(crate) fn crop(&self, x: u32, y: u32, width: u32, height: u32) -> Self {
        let (x, y) = (x.min(self.width), y.min(self.height));
        let width = width.min(self.width - x);
        let height = height.min(self.height - y);
        let row = |row: u32| {
            let first = (y + row) as usize * self.width as usize + x as usize;
            &self.pixels[first..first + width as usize]
        };
        Self {
            width,
            height,
            pixels: (0..height).flat_map(row).copied().collect(),
        }
    }

    /// Composites another picture over this one, its top left at `(x, y)`; parts outside are
    /// clipped.
    pub fn blit(&mut self, other: &Self, x: i32, y: i32) {
        for (row, line) in (0..).zip(other.pixels.chunks(other.width.max(1) as usize)) {
            for (column, color) in (0..).zip(line) {
                self.blend(x + column, y + row, *color, 1.0);
            }
        }
    }

    /// Copies another picture into this one, its top left at `(x, y)`; parts outside are clipped.
    pub fn put(&mut self, other: &Self, x: u32, y: u32) {
        let width = other.width.min(self.width.saturating_sub(x)) as usize;
        let rows = other.pixels.chunks_exact(other.width.max(1) as usize);
        let own = self.pixels.chunks_exact_mut(self.width.max(1) as usize);
        for (row, line) in own.skip(y as usize).zip(rows) {
            row[x as usize..x as usize + width].copy_from_slice(&line[..width]);
        }
    }

    /// Returns a smaller picture in which each pixel is the mean of `factor * factor` pixels,
    /// averaged in linear light. Rows and columns that do not fill a block are dropped.
    #[must_use]
    pub(crate) fn downsample(&self, factor: u32) -> Self {
        let factor = factor.max(1);
        let (width, height) = (self.width / factor, self.height / factor);
        let table = linear_table();
        let block = |x: u32, y: u32| {
            let mut sum = [0.0f32; 4];
            for j in 0..factor {
                let first = (y * factor + j) as usize * self.width as usize;
                let first = first + (x * factor) as usize;
                for pixel in &self.pixels[first..first + factor as usize] {
                    add_linear(&mut sum, *pixel, table);
                }
            }
            mean_of(sum, factor * factor)
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        Self {
            width,
            height,
            pixels: places.map(|(x, y)| block(x, y)).collect(),
        }
    }
}

/// Composites `above` over `below`, blended in sRGB as browsers do.
pub(crate) fn over(below: Rgba, above: Rgba, coverage: f32) -> Rgba {
    let a = f32::from(above[3]) / 255.0 * coverage.clamp(0.0, 1.0);
    let b = f32::from(below[3]) / 255.0 * (1.0 - a);
    let alpha = a + b;
    if alpha <= 0.0 {
        return [0; 4];
    }
    let mix = |i: usize| {
        let value = (f32::from(above[i]) * a + f32::from(below[i]) * b) / alpha;
        value.round() as u8
    };
    [mix(0), mix(1), mix(2), (alpha * 255.0).round() as u8]
}

/// Returns the linear light (0 to 1) of all 256 sRGB bytes.
///
/// Source: IEC 61966-2-1.
pub fn linear_table() -> &'static [f32; 256] {
    static TABLE: std::sync::OnceLock<[f32; 256]> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| std::array::from_fn(|byte| linear_of(byte as f32 / 255.0)))
}

/// Returns the sRGB byte of a linear light value; values outside 0 to 1 are clamped.
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    // Exact rounding without a power: starts at the smallest byte of a bucket of square roots
    // (about as curved as sRGB), then steps over the few thresholds inside the bucket.
    static TABLES: std::sync::OnceLock<SrgbTables> = std::sync::OnceLock::new();
    let tables = TABLES.get_or_init(SrgbTables::new);
    let value = linear.clamp(0.0, 1.0);
    let mut byte = tables.least[(value.sqrt() * BUCKETS) as usize];
    while value >= tables.threshold[usize::from(byte)] {
        byte += 1;
    }
    byte
}

/// Number of buckets of square roots between 0 and 1.
const BUCKETS: f32 = 512.0;

struct SrgbTables {
    /// Linear light at which the next byte begins; infinite for the last one.
    threshold: [f32; 256],
    /// Smallest byte of each bucket.
    least: [u8; BUCKETS as usize + 1],
}

impl SrgbTables {
    fn new() -> Self {
        let mut threshold = std::array::from_fn(|byte| linear_of((byte as f32 + 0.5) / 255.0));
        threshold[255] = f32::INFINITY;
        let least = std::array::from_fn(|bucket| {
            // A little below the bucket, so that a rounded square root cannot start too high.
            let root = (bucket as f32 - 0.01) / BUCKETS;
            threshold.partition_point(|t| *t <= root * root.max(0.0)) as u8
        });
        Self { threshold, least }
    }
}

/// Linear light of an sRGB value between 0 and 1.
fn linear_of(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn add_linear(sum: &mut [f32; 4], pixel: Rgba, table: &[f32; 256]) {
    let alpha = f32::from(pixel[3]) / 255.0;
    for (total, byte) in sum.iter_mut().zip(&pixel[..3]) {
        *total += table[usize::from(*byte)] * alpha;
    }
    sum[3] += alpha;
}

fn mean_of(sum: [f32; 4], count: u32) -> Rgba {
    if sum[3] <= 0.0 {
        return [0; 4];
    }
    let color = |i: usize| srgb_byte(sum[i] / sum[3]);
    let alpha = sum[3] / count as f32;
    [color(0), color(1), color(2), (alpha * 255.0).round() as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLACK: Rgba = [0, 0, 0, 255];
    const WHITE: Rgba = [255; 4];

    #[test]
    fn srgb_goes_there_and_back() {
        for byte in 0..=255u8 {
            assert_eq!(srgb_byte(linear_table()[usize::from(byte)]), byte);
        }
        // Half the light is byte 188: 1.055 * 0.5^(1/2.4) - 0.055 = 0.7354.
        assert_eq!(srgb_byte(0.5), 188);
        for i in 0..=10_000 {
            let linear = i as f32 / 10_000.0;
            let encoded = if linear <= 0.003_130_8 {
                linear * 12.92
            } else {
                1.055 * linear.powf(1.0 / 2.4) - 0.055
            };
            let off = f32::from(srgb_byte(linear)) - 255.0 * encoded;
            assert!(off.abs() <= 0.501, "{linear}: off by {off}");
        }
        assert_eq!(
            (srgb_byte(-1.0), srgb_byte(2.0), srgb_byte(f32::NAN)),
            (0, 255, 0)
        );
    }

    #[test]
    fn downsampling_averages_light_and_ignores_the_transparent() {
        let two = Picture::from_pixels(2, 2, vec![WHITE, BLACK, BLACK, WHITE]).unwrap();
        assert_eq!(two.downsample(2).pixels(), [[188, 188, 188, 255]]);
        let large = (0..36).map(|i| two.pixels()[i / 18 * 2 + i % 6 / 3]);
        let large = Picture::from_pixels(6, 6, large.collect()).unwrap();
        assert_eq!(large.downsample(3), two);
        let clear = [255, 0, 0, 0];
        let half = Picture::from_pixels(2, 1, vec![clear, clear]).unwrap();
        assert_eq!(half.downsample(2).pixels().len(), 0);
        let edge = Picture::from_pixels(2, 2, vec![clear, WHITE, clear, WHITE]).unwrap();
        assert_eq!(edge.downsample(2).pixels(), [[255, 255, 255, 128]]);
    }

    #[test]
    fn blends_crops_and_blits_inside_the_frame_only() {
        assert_eq!(over(WHITE, [0, 0, 0, 255], 0.5), [128, 128, 128, 255]);
        assert_eq!(over([0; 4], [9, 8, 7, 255], 1.0), [9, 8, 7, 255]);
        let mut picture = Picture::new(4, 3, WHITE).unwrap();
        picture.blit(&Picture::new(2, 2, BLACK).unwrap(), 3, -1);
        assert_eq!(picture.get(3, 0), Some(BLACK));
        assert_eq!(picture.get(3, 1), Some(WHITE));
        let corner = picture.crop(3, 0, 9, 9);
        assert_eq!((corner.width(), corner.height()), (1, 3));
        assert_eq!(corner.pixels(), [BLACK, WHITE, WHITE]);
        assert!(Picture::new(1, 20_000, WHITE).is_err());
        assert!(Picture::from_pixels(2, 2, vec![WHITE]).is_err());
    }
}
