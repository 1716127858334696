//! Reads the player's container `ARTV`.
//!
//! Source: `docs/formats/artv.md`. No input causes a panic, a hang or unbounded memory: the
//! uncompressed size is bounded, and each stored number takes at least one byte of it.

use super::clip::{PlayerClip, PlayerEpoch};
use super::container::{GOURAUD, INPUTS, MAGIC, TEXTURE, VERSION};
use super::error::PlayerError;
use super::stream::Reader;
use super::texture::PlayerTexture;
use super::topology::{parents, wedge_parents};
use crate::low_rank::quantised::{MAX_STEPS, Quantised, QuantisedComponent};
use crate::planar::clip::{MAX_FRAMES, MAX_TRIANGLES};
use crate::planar::shading::Shading;
use std::io::Read;
use std::ops::Range;

/// Maximum uncompressed size of a container, bytes.
pub(super) const MAX_BODY_BYTES: usize = 32 << 20;
/// Maximum number of components of a clip.
pub(super) const MAX_COMPONENTS: usize = 4096;
/// Maximum width and height, pixels.
pub(super) const MAX_SIDE: usize = 1 << 15;
/// Maximum frame rate.
const MAX_FPS: f64 = 1e4;

/// Contents of the header.
struct Header {
    frames: u32,
    triangles: usize,
    epochs: usize,
    components: usize,
    flags: u32,
}

/// Decodes a container.
///
/// # Errors
/// The violation, as a [`PlayerError`].
pub fn decode(bytes: &[u8]) -> Result<PlayerClip, PlayerError> {
    let rest = bytes.strip_prefix(&MAGIC).ok_or(PlayerError::NotAClip)?;
    let (version, packed) = rest.split_first().ok_or(PlayerError::Truncated)?;
    if *version != VERSION {
        return Err(PlayerError::Version(*version));
    }
    body(&unpacked(packed)?)
}

fn unpacked(packed: &[u8]) -> Result<Vec<u8>, PlayerError> {
    let mut body = Vec::new();
    let mut decoder = flate2::read::ZlibDecoder::new(packed).take(MAX_BODY_BYTES as u64 + 1);
    let done = decoder.read_to_end(&mut body);
    done.map_err(|_| PlayerError::Compression)?;
    if body.len() > MAX_BODY_BYTES {
        return Err(PlayerError::TooLarge(MAX_BODY_BYTES));
    }
    Ok(body)
}

fn body(bytes: &[u8]) -> Result<PlayerClip, PlayerError> {
    let from = &mut Reader::new(bytes);
    let width = from.count("pixels in width", 1, MAX_SIDE)? as u32;
    let height = from.count("pixels in height", 1, MAX_SIDE)? as u32;
    let header = Header {
        frames: from.count("frames", 1, MAX_FRAMES)? as u32,
        triangles: from.count("triangles", 1, MAX_TRIANGLES)?,
        epochs: from.count("painting orders", 1, MAX_FRAMES)?,
        components: from.count("components", 0, MAX_COMPONENTS)?,
        flags: from.unsigned()?,
    };
    let has_texture = header.flags & TEXTURE != 0;
    // Colours of flat triangles are lit, a picture is not.
    if header.flags & !(GOURAUD | INPUTS | TEXTURE) != 0
        || (has_texture && header.flags & GOURAUD == 0)
    {
        return Err(PlayerError::Malformed("unknown flag"));
    }
    let fps = positive(from.real()?, MAX_FPS)? as f32;
    let step = positive(from.real()?, f64::from(1 << 24))?;
    let light_weight = positive(from.real()?, f64::from(1 << 24))?;
    let shading = if header.flags & GOURAUD == 0 {
        Shading::Flat
    } else {
        Shading::Gouraud
    };
    let (triangles, wedge_points) = corners(from, header.triangles)?;
    let colored = match shading {
        Shading::Flat => triangles.len(),
        Shading::Gouraud => wedge_points.len(),
    };
    let colors = colors(from, colored)?;
    let shown = (0..header.triangles)
        .map(|_| spans(from, header.frames))
        .collect::<Result<_, _>>()?;
    let epochs = epochs(from, &header)?;
    let parents = parents(&triangles, &wedge_points, shading == Shading::Gouraud);
    let mean = column(from, &parents, true)?;
    let components = components(from, &header, &parents)?;
    let mut inputs = Vec::new();
    if header.flags & INPUTS != 0 {
        for _ in 0..header.components {
            inputs.push(name(from)?);
        }
    }
    let texture = match has_texture {
        true => Some(PlayerTexture::read(
            from,
            &triangles,
            &wedge_parents(&triangles),
        )?),
        false => None,
    };
    if !from.is_at_end() {
        return Err(PlayerError::Malformed("unexpected bytes after the end"));
    }
    let motion = Quantised {
        step,
        mean,
        components,
    };
    Ok(PlayerClip {
        width,
        height,
        fps,
        frames: header.frames,
        shading,
        light_weight,
        triangles,
        wedge_points,
        colors,
        shown,
        epochs,
        motion,
        inputs,
        texture,
    })
}

fn positive(value: f64, most: f64) -> Result<f64, PlayerError> {
    if value > 0.0 && value <= most {
        Ok(value)
    } else {
        Err(PlayerError::Malformed("a unit or rate is out of range"))
    }
}

/// Wedges of triangles, and points of wedges.
type Corners = (Vec<[u32; 3]>, Vec<u32>);

fn corners(from: &mut Reader<'_>, count: usize) -> Result<Corners, PlayerError> {
    const BACK: PlayerError = PlayerError::Malformed("a corner refers back before the first");
    let mut triangles = Vec::new();
    let mut wedge_points: Vec<u32> = Vec::new();
    let mut points = 0u32;
    for _ in 0..count {
        let mut corners = [0; 3];
        for corner in &mut corners {
            let known = wedge_points.len() as u32;
            *corner = known.checked_sub(from.unsigned()?).ok_or(BACK)?;
            if *corner == known {
                let point = points.checked_sub(from.unsigned()?).ok_or(BACK)?;
                points += u32::from(point == points);
                wedge_points.push(point);
            }
        }
        triangles.push(corners);
    }
    Ok((triangles, wedge_points))
}

fn colors(from: &mut Reader<'_>, count: usize) -> Result<Vec<[u8; 3]>, PlayerError> {
    let mut known: Vec<[u8; 3]> = Vec::new();
    let mut colors = Vec::new();
    for _ in 0..count {
        let back = from.unsigned()? as usize;
        if back == 0 {
            let levels = from.take(3)?;
            known.push([levels[0], levels[1], levels[2]]);
        }
        // A new colour has just become the last known one.
        let at = known.len().checked_sub(back.max(1));
        let at = at.ok_or(PlayerError::Malformed(
            "a colour refers back before the first",
        ))?;
        colors.push(known[at]);
    }
    Ok(colors)
}

fn spans(from: &mut Reader<'_>, frames: u32) -> Result<Vec<Range<u32>>, PlayerError> {
    let count = from.unsigned()?;
    let mut turns: Vec<u32> = Vec::new();
    for i in 0..count {
        let step = from.unsigned()?;
        let turn = turns.last().copied().unwrap_or(0) + step;
        if turn >= frames || (i > 0 && step == 0) {
            return Err(PlayerError::Malformed("the spans do not rise"));
        }
        turns.push(turn);
    }
    let pairs = turns.chunks(2);
    Ok(pairs
        .map(|pair| pair[0]..pair.get(1).copied().unwrap_or(frames))
        .collect())
}

fn epochs(from: &mut Reader<'_>, header: &Header) -> Result<Vec<PlayerEpoch>, PlayerError> {
    let mut epochs: Vec<PlayerEpoch> = Vec::new();
    for e in 0..header.epochs {
        let step = from.unsigned()?;
        let first_frame = epochs.last().map_or(0, |last| last.first_frame) + step;
        if first_frame >= header.frames || (step == 0) != (e == 0) {
            return Err(PlayerError::Malformed(
                "the frames of the painting orders do not rise",
            ));
        }
        let count = from.count("triangles in a painting order", 0, header.triangles)?;
        let mut is_named = vec![false; header.triangles];
        let mut order = Vec::new();
        let mut next = 0;
        for _ in 0..count {
            let triangle = i64::from(next) + i64::from(from.signed()?);
            let named = usize::try_from(triangle).ok();
            match named.and_then(|t| is_named.get_mut(t)) {
                Some(named) if !*named => *named = true,
                _ => {
                    return Err(PlayerError::Malformed(
                        "a painting order names a triangle twice or out of range",
                    ));
                }
            }
            order.push(triangle as u32);
            next = triangle as i32 + 1;
        }
        epochs.push(PlayerEpoch { first_frame, order });
    }
    Ok(epochs)
}

fn within(value: i64) -> Result<i32, PlayerError> {
    if value.abs() <= i64::from(MAX_STEPS) {
        Ok(value as i32)
    } else {
        Err(PlayerError::Malformed("a value is out of range"))
    }
}

fn column(
    from: &mut Reader<'_>,
    parents: &[u32],
    is_guessed: bool,
) -> Result<Vec<i32>, PlayerError> {
    let mut values: Vec<i32> = Vec::new();
    for parent in parents {
        // A column without a parent names itself, which is not decoded yet.
        let parent = values.get(*parent as usize).filter(|_| is_guessed);
        let guess = parent.copied().unwrap_or(0);
        values.push(within(i64::from(guess) + i64::from(from.signed()?))?);
    }
    Ok(values)
}

fn flag(from: &mut Reader<'_>) -> Result<bool, PlayerError> {
    match from.unsigned()? {
        0 => Ok(false),
        1 => Ok(true),
        _ => Err(PlayerError::Malformed("a flag is neither 0 nor 1")),
    }
}

fn components(
    from: &mut Reader<'_>,
    header: &Header,
    parents: &[u32],
) -> Result<Vec<QuantisedComponent>, PlayerError> {
    let mut components = Vec::new();
    for _ in 0..header.components {
        let scale = from.real()?;
        if scale > f64::from(1 << 24) {
            return Err(PlayerError::Malformed("a unit or rate is out of range"));
        }
        let is_guessed = flag(from)?;
        components.push(QuantisedComponent {
            scale,
            basis: column(from, parents, is_guessed)?,
            coefficients: Vec::new(),
        });
    }
    for component in &mut components {
        let is_second = flag(from)?;
        let (mut value, mut change) = (0i64, 0i64);
        for _ in 0..header.frames {
            let read = i64::from(from.signed()?);
            change = if is_second { change + read } else { read };
            value += change;
            component.coefficients.push(within(value)?);
        }
    }
    Ok(components)
}

fn name(from: &mut Reader<'_>) -> Result<String, PlayerError> {
    const NO_TEXT: PlayerError = PlayerError::Malformed("a name is not valid UTF-16");
    let length = from.count("characters in a name", 0, 1 << 10)?;
    let mut units = Vec::new();
    for _ in 0..length {
        units.push(u16::try_from(from.unsigned()?).map_err(|_| NO_TEXT)?);
    }
    String::from_utf16(&units).map_err(|_| NO_TEXT)
}
