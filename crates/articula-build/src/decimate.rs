//! Decimation to one coarser triangle list, for one clip and the triangles that are visible in it.
//!
//! Source: `docs/methods/vector.md` parts 1 and 3. A conversion to 2D shows a character from known
//! cameras, so triangles that are never visible are removed first, and the rest is simplified
//! ([`crate::simplify`]) over the poses of the converted clip.

use crate::character::Asset;
use crate::poses::{PoseOptions, poses, positions};
use crate::simplify::{SimplifyOptions, simplify};
use articula_core::{Mesh, Mismatch};

/// Simplifies the triangles flagged in `keep` to about `triangles`; returns all of them if there
/// are no more than that.
///
/// Poses are taken from the clip with index `clip` only. `vertex_weights` is the weight of an error
/// at each vertex; all 1 if empty. The returned triangles index the asset's vertices, part by part.
///
/// # Errors
/// A [`Mismatch`] if `keep` does not have one value per triangle, or the clip does not exist.
pub fn decimate(
    asset: &Asset,
    keep: &[bool],
    clip: Option<usize>,
    triangles: usize,
    vertex_weights: &[f32],
) -> Result<Vec<[u32; 3]>, Mismatch> {
    let found = keep.len();
    let expected = asset.mesh.triangles.len();
    if found != expected {
        let what = format!("{found} values, the mesh has {expected} triangles");
        return Err(Mismatch::new("keep", what));
    }
    let mesh = kept(&asset.mesh, keep);
    if mesh.triangles.len() <= triangles {
        return Ok(mesh.triangles);
    }
    let clips = match clip {
        None => Vec::new(),
        Some(c) => {
            let clip = asset.clips.get(c);
            let missing = || {
                Mismatch::new(
                    "clip",
                    format!(
                        "clip {c} is out of range: the character has {} clips",
                        asset.clips.len()
                    ),
                )
            };
            vec![clip.cloned().ok_or_else(missing)?]
        }
    };
    let share = triangles as f64 / mesh.triangles.len() as f64;
    let shown = Asset {
        rig: asset.rig.clone(),
        mesh: mesh.into(),
        clips,
    };
    let shaping = poses(&shown, &PoseOptions::default())?.shaping;
    let options = SimplifyOptions {
        targets: vec![1.0, share],
        vertex_weights: vertex_weights.to_vec(),
        ..SimplifyOptions::default()
    };
    let simplified = simplify(&shown.mesh, &positions(&shown, &shaping), &options)?;
    Ok(simplified
        .levels
        .into_iter()
        .next_back()
        .map_or_else(Vec::new, |level| level.triangles))
}

/// The mesh with the kept triangles only.
fn kept(mesh: &Mesh, keep: &[bool]) -> Mesh {
    let mut out = mesh.clone();
    out.triangles.clear();
    for part in &mut out.parts {
        let first = out.triangles.len();
        let chosen = part.triangles.clone().filter(|t| keep[*t]);
        out.triangles.extend(chosen.map(|t| mesh.triangles[t]));
        part.triangles = first..out.triangles.len();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::small_human::small_human;

    #[test]
    fn reaches_the_count_and_uses_what_is_kept_alone() {
        let asset = small_human();
        let low = |t: &[u32; 3]| t.iter().all(|v| asset.mesh.positions[*v as usize].y < 1.2);
        let keep: Vec<bool> = asset.mesh.triangles.iter().map(low).collect();
        let count = keep.iter().filter(|k| **k).count();
        let all = decimate(asset, &keep, Some(0), usize::MAX, &[]).unwrap();
        assert_eq!(all.len(), count);
        let fewer = decimate(asset, &keep, Some(0), count / 3, &[]).unwrap();
        assert!(
            fewer.len() <= count / 3 && fewer.len() > count / 4,
            "{}",
            fewer.len()
        );
        assert!(fewer.iter().all(low));
    }

    #[test]
    fn refuses_what_does_not_fit() {
        let asset = small_human();
        assert!(decimate(asset, &[true], None, 10, &[]).is_err());
        let keep = vec![true; asset.mesh.triangles.len()];
        assert!(decimate(asset, &keep, Some(99), 10, &[]).is_err());
    }
}
