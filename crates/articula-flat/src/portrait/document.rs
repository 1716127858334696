//! A portrait as files: one JSON document and one picture per view.
//!
//! The format is described in `docs/formats/portrait.md`. Arrays of numbers are base 64,
//! little-endian.

use super::error::{PortraitError, refuse};
use super::pose_grid::{ExpressionTable, Quantised};
use super::roll::Roll;
use super::views::View;
use super::{Portrait, PortraitClip, PortraitInput, PortraitLevel};
use crate::error::PictureError;
use crate::markup::quoted;
use crate::picture::Picture;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// Steps per unit of a weight in a clip; weights range from -8 to 8.
const WEIGHT_STEPS: f32 = 4096.0;
/// Steps per degree in a clip.
const ANGLE_STEPS: f32 = 100.0;

/// Source of the player, a script for browsers.
pub(super) const PLAYER: &str = include_str!("player.js");

/// Lossless format of the view pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PictureFormat {
    /// Lossless WebP, which is smaller.
    #[default]
    WebP,
    /// PNG.
    Png,
}

impl PictureFormat {
    /// File name extension.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::WebP => "webp",
            Self::Png => "png",
        }
    }

    /// Media type.
    pub(crate) fn media_type(self) -> &'static str {
        match self {
            Self::WebP => "image/webp",
            Self::Png => "image/png",
        }
    }
}

impl Portrait {
    /// Returns all files by name: `portrait.json`, a picture for each view, and the player.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if a number is not finite, [`PortraitError::Picture`] if a
    /// picture cannot be encoded.
    pub fn to_files(&self, format: PictureFormat) -> Result<Vec<(String, Vec<u8>)>, PortraitError> {
        let mut files = vec![(
            "portrait.json".to_owned(),
            self.to_json(format)?.into_bytes(),
        )];
        let names = self.picture_names(format);
        for (name, view) in names.into_iter().zip(&self.views) {
            files.push((name, encoded(&view.picture, format)?));
        }
        files.push(("player.js".to_owned(), PLAYER.as_bytes().to_vec()));
        Ok(files)
    }

    fn picture_names(&self, format: PictureFormat) -> Vec<String> {
        let name = |i: usize| format!("view{i}.{}", format.extension());
        (0..self.views.len()).map(name).collect()
    }

    /// Returns the JSON document.
    ///
    /// # Errors
    /// [`PortraitError::Mismatch`] if a number is not finite.
    pub(crate) fn to_json(&self, format: PictureFormat) -> Result<String, PortraitError> {
        let mut out = String::from("{\n\"format\":\"articula-portrait\",\"version\":1,\n");
        let (width, height) = self.size;
        let Roll {
            tilts,
            depths,
            blends,
            pivot,
        } = &self.roll;
        let (x, y) = (number(pivot.x)?, number(pivot.y)?);
        let _ = write!(
            out,
            "\"size\":[{width},{height}],\"pivot\":[{x},{y}],\n\"vertices\":{},\n\
             \"triangles\":{},\n\"tilts\":{},\"depths\":{},\"blends\":{blends},\n",
            numbers(self.mesh.vertices.iter().map(|v| v.to_le_bytes())),
            shorts(self.mesh.triangles.iter().flatten()),
            numbers(tilts.iter().map(|t| [*t])),
            numbers(depths.iter().map(|d| d.to_le_bytes())),
        );
        let views = self.views.iter().zip(&self.layers.of_view);
        let views = views.zip(self.picture_names(format));
        let views = views.map(|((view, layers), name)| view_json(view, layers, &name));
        let _ = writeln!(out, "\"views\":{},", list(views)?);
        let _ = writeln!(out, "\"grid\":{},", self.grid_json()?);
        let expressions = self.grid.expressions.iter().map(expression_json);
        let _ = writeln!(out, "\"expressions\":{},", list(expressions)?);
        let sectors = self.sectors.iter().map(|s| {
            let from = number(s.from_yaw_degrees)?;
            let order = shorts(s.order.iter());
            Ok(format!("{{\"from\":{from},\"order\":{order}}}"))
        });
        let _ = writeln!(out, "\"sectors\":{},", list(sectors)?);
        let clips = self.clips.iter().map(clip_json);
        let _ = write!(out, "\"clips\":{}", list(clips)?);
        if !self.inputs.is_empty() {
            let inputs: Result<Vec<String>, _> = self.inputs.iter().map(input_json).collect();
            let _ = write!(out, ",\n\"inputs\":{{{}}}", inputs?.join(","));
        }
        if !self.levels.is_empty() {
            let levels: Vec<String> = self.levels.iter().map(level_json).collect();
            let _ = write!(out, ",\n\"levels\":{{{}}}", levels.join(",\n"));
        }
        out.push_str("\n}\n");
        Ok(out)
    }

    fn grid_json(&self) -> Result<String, PortraitError> {
        if let Some(i) = self.grid.coefficients.iter().position(|c| !c.is_finite()) {
            return Err(refuse(format!("grid.coefficients[{i}]"), "must be finite"));
        }
        let rest = self.grid.rest.iter().map(|mode: &Quantised<i16>| {
            let steps = numbers(mode.steps.iter().map(|s| s.to_le_bytes()));
            Ok(format!(
                "{{\"scale\":{},\"steps\":{steps}}}",
                number(mode.scale)?
            ))
        });
        Ok(format!(
            "{{\"yaw\":{},\"pitch\":{},\n\"coefficients\":{},\n\"rest\":{}}}",
            floats(&self.grid.yaw_degrees)?,
            floats(&self.grid.pitch_degrees)?,
            numbers(self.grid.coefficients.iter().map(|c| c.to_le_bytes())),
            list(rest)?,
        ))
    }
}

fn view_json(view: &View, layers: &[u8], name: &str) -> Result<String, PortraitError> {
    let shifts: Vec<String> = view
        .shifts
        .iter()
        .map(|[x, y]| format!("[{x},{y}]"))
        .collect();
    Ok(format!(
        "{{\"yaw\":{},\"pitch\":{},\"picture\":{},\"width\":{},\"height\":{},\"shifts\":[{}],\"layers\":{}}}",
        number(view.pose.yaw_degrees)?,
        number(view.pose.pitch_degrees)?,
        quoted(name),
        view.picture.width(),
        view.picture.height(),
        shifts.join(","),
        numbers(layers.iter().map(|l| [*l])),
    ))
}

fn expression_json(table: &ExpressionTable) -> Result<String, PortraitError> {
    let scales: Vec<f32> = table.modes.iter().map(|m| m.scale).collect();
    let steps = table.modes.iter().flat_map(|m| &m.steps);
    Ok(format!(
        "{{\"name\":{},\"vertices\":{},\"scales\":{},\"steps\":{}}}",
        quoted(&table.name),
        shorts(table.vertices.iter()),
        floats(&scales)?,
        numbers(steps.map(|s| s.to_le_bytes())),
    ))
}

fn clip_json(clip: &PortraitClip) -> Result<String, PortraitError> {
    let step = |value: f32, steps: f32| (value * steps).round() as i16;
    let angles = clip.poses.iter().flat_map(|p| {
        [p.yaw_degrees, p.pitch_degrees, p.roll_degrees].map(|a| step(a, ANGLE_STEPS))
    });
    let count = clip.weights.first().map_or(0, Vec::len);
    let moves = |e: &usize| {
        clip.weights
            .iter()
            .any(|frame| step(frame[*e], WEIGHT_STEPS) != 0)
    };
    let driven: Vec<usize> = (0..count).filter(moves).collect();
    let weights = clip.weights.iter().flat_map(|frame| {
        let of = |e: &usize| step(frame[*e], WEIGHT_STEPS);
        driven.iter().map(of)
    });
    let names: Vec<String> = driven.iter().map(usize::to_string).collect();
    Ok(format!(
        "{{\"name\":{},\"rate\":{},\"frames\":{},\"poses\":{},\"driven\":[{}],\"weights\":{}}}",
        quoted(&clip.name),
        number(clip.rate_hz)?,
        clip.poses.len(),
        numbers(angles.map(i16::to_le_bytes)),
        names.join(","),
        numbers(weights.map(i16::to_le_bytes)),
    ))
}

fn input_json(input: &PortraitInput) -> Result<String, PortraitError> {
    let pair = |(fap, value): &(u8, f32)| Ok(format!("[{fap},{}]", number(*value)?));
    let faps = list(input.faps.iter().map(pair))?;
    Ok(format!("{}:{faps}", quoted(&input.name)))
}

fn level_json(level: &PortraitLevel) -> String {
    let faps: Vec<String> = level.faps.iter().map(u8::to_string).collect();
    let role = |role: &Option<u16>| role.map_or_else(|| "-1".to_owned(), |of| of.to_string());
    let expressions: Vec<String> = level.expressions.iter().map(role).collect();
    format!(
        "{}:{{\"faps\":[{}],\"expressions\":[{}]}}",
        quoted(&level.name),
        faps.join(","),
        expressions.join(",")
    )
}

/// Encodes a picture.
pub(crate) fn encoded(picture: &Picture, format: PictureFormat) -> Result<Vec<u8>, PictureError> {
    if format == PictureFormat::Png {
        return picture.to_png();
    }
    let mut bytes = Vec::new();
    let pixels: Vec<u8> = picture.pixels().iter().flatten().copied().collect();
    image_webp::WebPEncoder::new(&mut bytes)
        .encode(
            &pixels,
            picture.width(),
            picture.height(),
            image_webp::ColorType::Rgba8,
        )
        .map_err(|e| PictureError::Unsupported {
            what: format!("this picture as WebP ({e})"),
            mend: "write PNG".to_owned(),
        })?;
    Ok(bytes)
}

/// Formats a number as JSON.
fn number(value: f32) -> Result<String, PortraitError> {
    if value.is_finite() {
        return Ok(value.to_string());
    }
    Err(refuse(
        "portrait",
        format!("values must be finite, found {value}"),
    ))
}

fn floats(values: &[f32]) -> Result<String, PortraitError> {
    list(values.iter().map(|v| number(*v)))
}

fn list(
    items: impl Iterator<Item = Result<String, PortraitError>>,
) -> Result<String, PortraitError> {
    Ok(format!(
        "[{}]",
        items.collect::<Result<Vec<_>, _>>()?.join(",")
    ))
}

/// Encodes bytes in base 64, in quotation marks.
fn numbers<const N: usize>(values: impl Iterator<Item = [u8; N]>) -> String {
    let bytes: Vec<u8> = values.flatten().collect();
    format!("\"{}\"", STANDARD.encode(bytes))
}

/// Encodes indices with 16 bits; the numbers of vertices and triangles are limited to that.
fn shorts<'a>(values: impl Iterator<Item = &'a u32>) -> String {
    numbers(values.map(|v| (*v as u16).to_le_bytes()))
}
