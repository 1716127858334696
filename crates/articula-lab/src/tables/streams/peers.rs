//! The same clip in other forms: keys of glTF, meshoptimizer, BVH, ABP-1.

use super::judge::{Errors, Sampled, Shown, at_rest, errors};
use anyhow::{Context, Result, ensure};
use articula::Figure;
use articula::clip_streams::abp1;
use articula::convert::write;
use articula::{Format, OpenOptions};
use articula_build::clip_edit::resample_keys;
use articula_build::{Asset, whole_clip_size};
use articula_core::source::{Character, RawClip, evaluate};
use articula_core::{Clip, LocalPose, ModelPose, Tracks};
use articula_stream::abp1::Abp1Options;
use glam::{Affine3A, Quat, Vec3};
use std::io::Write as _;

/// Bits of a component of a rotation and of a mantissa.
const BITS: i32 = 16;

/// A form of a clip.
pub(super) struct Peer {
    pub(super) bytes: usize,
    /// `None` if it was not judged.
    pub(super) errors: Option<Errors>,
}

/// The keys as in the file, 32-bit floats; and the same in gzip.
pub(super) fn keys(clip: &RawClip) -> Result<[usize; 2]> {
    let mut bytes = Vec::new();
    let mut last: &[f32] = &[];
    for channel in &clip.channels {
        if channel.times_secs != last {
            bytes.extend(channel.times_secs.iter().flat_map(|t| t.to_le_bytes()));
            last = &channel.times_secs;
        }
        bytes.extend(channel.values.iter().flat_map(|v| v.to_le_bytes()));
    }
    // Equal times count once, wherever they are.
    Ok([whole_clip_size(clip).bytes, gzip(&bytes)?])
}

fn gzip(bytes: &[u8]) -> Result<usize> {
    let mut coder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    coder.write_all(bytes)?;
    Ok(coder.finish()?.len())
}

/// Keys at every frame as gltfpack stores them: rotations in 8 bytes by the largest component,
/// translations and scales with 16-bit mantissas and a common exponent, weights in 16 bits; vertex
/// codec, then gzip. Constant tracks have one key.
pub(super) fn meshoptimizer(asset: &Asset, clip: &Clip) -> Result<Peer> {
    let tracks = clip.tracks();
    let mut shown = Tracks::default();
    let mut coded = Vec::new();
    let mut rotations: Vec<[i16; 4]> = Vec::new();
    for track in &tracks.rotations {
        let mut track = track.clone();
        if track.values.iter().all(|q| *q == track.values[0]) {
            track.values.truncate(1);
        }
        for value in &mut track.values {
            let packed = packed(*value);
            rotations.push(packed);
            *value = unpacked(packed);
        }
        shown.rotations.push(track);
    }
    coded.extend(meshopt::encode_vertex_buffer(&rotations)?);
    for (from, to) in [
        (&tracks.translations, &mut shown.translations),
        (&tracks.scales, &mut shown.scales),
    ] {
        let mut vectors: Vec<[i32; 3]> = Vec::new();
        for track in from {
            let mut track = track.clone();
            if track.values.iter().all(|v| *v == track.values[0]) {
                track.values.truncate(1);
            }
            for value in &mut track.values {
                let (packed, back) = rounded(*value);
                vectors.push(packed);
                *value = back;
            }
            to.push(track);
        }
        coded.extend(meshopt::encode_vertex_buffer(&vectors)?);
    }
    let mut weights: Vec<[u16; 2]> = Vec::new();
    for track in &tracks.morphs {
        let mut track = track.clone();
        for value in &mut track.values {
            let packed = (value.clamp(0.0, 1.0) * 65535.0).round() as u16;
            weights.push([packed, 0]);
            *value = f32::from(packed) / 65535.0;
        }
        shown.morphs.push(track);
    }
    coded.extend(meshopt::encode_vertex_buffer(&weights)?);
    let shown = Clip::new(
        &clip.name,
        clip.rate_hz(),
        clip.frames(),
        clip.joints(),
        shown,
    )?;
    let mut sampled = Sampled::new(asset, &shown);
    Ok(Peer {
        bytes: gzip(&coded)?,
        errors: Some(errors(asset, clip, &mut sampled)),
    })
}

/// The three smallest components, and the index of the largest in the low bits of the fourth.
fn packed(q: Quat) -> [i16; 4] {
    let c = q.normalize().to_array();
    let largest = (0..4).max_by(|a, b| c[*a].abs().total_cmp(&c[*b].abs()));
    let largest = largest.unwrap_or(3);
    let most = ((1 << (BITS - 1)) - 1) as f32;
    let scale = c[largest].signum() * std::f32::consts::SQRT_2 * most;
    let at = |i: usize| (c[(largest + i) & 3] * scale).round() as i16;
    [at(1), at(2), at(3), (most as i16 & !3) | largest as i16]
}

fn unpacked(packed: [i16; 4]) -> Quat {
    let most = ((1 << (BITS - 1)) - 1) as f32;
    let largest = (packed[3] & 3) as usize;
    let [x, y, z] = [0, 1, 2].map(|i| f32::from(packed[i]) / (std::f32::consts::SQRT_2 * most));
    let mut c = [0.0; 4];
    c[largest] = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
    for (i, value) in [x, y, z].into_iter().enumerate() {
        c[(largest + 1 + i) & 3] = value;
    }
    Quat::from_array(c)
}

/// A vector with a common exponent, as whole numbers and as values.
fn rounded(v: Vec3) -> ([i32; 3], Vec3) {
    let most = v.abs().max_element().max(f32::MIN_POSITIVE);
    let exponent = (most.log2().floor() as i32 + 2 - BITS).clamp(-100, 100);
    let size = 2_f32.powi(exponent);
    let mantissas = v.to_array().map(|x| (x / size).round() as i32);
    let back = Vec3::from(mantissas.map(|m| m as f32)) * size;
    (
        mantissas.map(|m| (exponent << 24) | (m & 0x00ff_ffff)),
        back,
    )
}

/// Size in Brotli.
pub(super) fn brotli(bytes: &[u8]) -> Result<usize> {
    let mut packed = Vec::new();
    let params = brotli::enc::BrotliEncoderParams::default();
    brotli::BrotliCompress(&mut &*bytes, &mut packed, &params)?;
    Ok(packed.len())
}

/// A BVH file as we write it, in Brotli.
pub(super) fn bvh(figure: &Figure, clip: usize) -> Result<Peer> {
    let mut alone = figure.opened.clone();
    alone.select_clips(&[clip]);
    let text = write(&alone, Format::Bvh)?.bytes;
    Ok(Peer {
        bytes: brotli(&text)?,
        errors: None,
    })
}

/// ABP-1 with the greatest steps whose error at frames is within the tolerance, or the least steps.
pub(super) fn abp1(figure: &Figure, clip: usize, tolerance_mm: f64) -> Result<Peer> {
    let mut best = abp1_with(figure, clip, 1)?;
    for quantizer in [2, 3, 4, 6, 8, 12, 16] {
        let next = abp1_with(figure, clip, quantizer)?;
        if next.errors.is_none_or(|e| e.frames_mm > tolerance_mm) {
            break;
        }
        best = next;
    }
    Ok(best)
}

fn abp1_with(figure: &Figure, clip: usize, quantizer: u8) -> Result<Peer> {
    // At the rate of the runtime clip, which may be above that of the keys.
    let mut opened = figure.opened.clone();
    let rate_hz = figure.asset.clips[clip].rate_hz();
    let keys = resample_keys(&opened.character().clips[clip], rate_hz)?;
    opened.clips_mut()[clip] = keys;
    let options = Abp1Options {
        quantizer,
        ..Abp1Options::default()
    };
    let bytes = abp1::write(opened.character(), &opened.articulation(), clip, &options)?;
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    let read = articula::open(&bytes, "a.abp", &OpenOptions::default(), nothing)?;
    let asset = &figure.asset;
    let joints = read.character().skeleton.joints.len();
    ensure!(joints == asset.rig.len(), "{joints} joints");
    let mut turned = Turned {
        at_rest: at_rest(asset),
        other: read.character().skeleton.model_rest(),
        character: read.character(),
        clip: read.character().clips.first().context("no clip")?,
    };
    Ok(Peer {
        bytes: bytes.len(),
        errors: Some(errors(asset, &asset.clips[clip], &mut turned)),
    })
}

/// A motion of the same joints with other axes at rest.
struct Turned<'a> {
    at_rest: Vec<Affine3A>,
    other: Vec<Affine3A>,
    character: &'a Character,
    clip: &'a RawClip,
}

impl Shown for Turned<'_> {
    fn pose(&mut self, secs: f64, model: &mut ModelPose, _: &mut [f32]) {
        let skeleton = &self.character.skeleton;
        let mut local: LocalPose = skeleton.joints.iter().map(|j| j.rest).collect();
        evaluate::pose(self.clip, skeleton, secs as f32, &mut local);
        let mut shown: Vec<Affine3A> = Vec::with_capacity(skeleton.joints.len());
        for (j, joint) in skeleton.joints.iter().enumerate() {
            let above = joint.parent.map_or(Affine3A::IDENTITY, |p| shown[p]);
            shown.push(above * local.get(j).to_affine());
        }
        let moved = shown.iter().zip(&self.other).zip(&self.at_rest);
        let matrices = moved.map(|((now, other), own)| *now * other.inverse() * *own);
        model.matrices = matrices.collect();
    }
}
