//! Joint indices and weights of vertices, repaired so that weights sum to 1.
//!
//! Source: glTF 2.0, 3.7.3.3. Real files often violate its rules (Khronos' CesiumMan has 210
//! vertices whose weights do not sum to 1), so weights are repaired, never an error.

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;

/// Maximum deviation of a sum from 1 that is not reported; smaller ones are rounding of stored
/// weights.
const TOLERANCE: f32 = 1e-3;

/// Influences per vertex, joint indices and weights.
type Influences = (usize, Vec<u16>, Vec<f32>);

/// Reads all sets of a primitive; without a skin, every vertex follows joint 0.
pub(super) fn read(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    count: usize,
    joint_count: Option<usize>,
) -> Result<Influences, ReadError> {
    let Some(joint_count) = joint_count else {
        return rigid(reader, attributes, count);
    };
    let sets = (0..)
        .take_while(|n| attributes.get(&format!("JOINTS_{n}")).is_some())
        .take_while(|n| attributes.get(&format!("WEIGHTS_{n}")).is_some())
        .count();
    if sets == 0 {
        reader.warn(
            attributes,
            "the skinned primitive has no joints and weights; bound to the first joint of the skin",
        );
        return rigid(reader, attributes, count);
    }
    let influences = sets * 4;
    reader.charge(attributes, (count * influences) as u64)?;
    let mut joints = vec![0u16; count * influences];
    let mut weights = vec![0.0f32; count * influences];
    for set in 0..sets {
        let (j, w) = read_set(reader, attributes, set, count)?;
        for v in 0..count {
            let to = v * influences + set * 4;
            joints[to..to + 4].copy_from_slice(&j[v * 4..][..4]);
            weights[to..to + 4].copy_from_slice(&w[v * 4..][..4]);
        }
    }
    mend_weights(reader, attributes, influences, &mut weights);
    check_joints(attributes, joint_count, &mut joints, &weights)?;
    bind_loose(reader, attributes, influences, (&mut joints, &mut weights));
    Ok((influences, joints, weights))
}

fn rigid(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    count: usize,
) -> Result<Influences, ReadError> {
    reader.charge(attributes, count as u64 * 2)?;
    Ok((1, vec![0; count], vec![1.0; count]))
}

fn read_set(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    set: usize,
    count: usize,
) -> Result<(Vec<u16>, Vec<f32>), ReadError> {
    let index = attributes.require(&format!("JOINTS_{set}"))?;
    let accessor = reader.accessor(&index)?;
    accessor.expect_type(&["VEC4"])?;
    accessor.expect_count(count, "vertices")?;
    let wide = reader.integers(&accessor)?;
    // Joint indices have at most 16 bits; a larger one is outside of any skin.
    let joints = wide.iter().map(|&j| u16::try_from(j).unwrap_or(u16::MAX));
    let joints = joints.collect();
    let index = attributes.require(&format!("WEIGHTS_{set}"))?;
    let accessor = reader.accessor(&index)?;
    accessor.expect_type(&["VEC4"])?;
    accessor.expect_count(count, "vertices")?;
    Ok((joints, reader.floats_as_they_are(&accessor)?))
}

/// Clamps negative and non-finite weights to 0 and scales each vertex to a sum of 1.
fn mend_weights(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    influences: usize,
    weights: &mut [f32],
) {
    let mut clamped = 0;
    let mut off = 0;
    for vertex in weights.chunks_exact_mut(influences) {
        for weight in vertex.iter_mut().filter(|w| !(w.is_finite() && **w >= 0.0)) {
            *weight = 0.0;
            clamped += 1;
        }
        // In double precision no sum of finite weights overflows.
        let sum: f64 = vertex.iter().map(|&w| f64::from(w)).sum();
        // A sum of 1 up to rounding is left as it is, so that files round-trip exactly.
        if sum <= 0.0 || (sum - 1.0).abs() <= 1e-6 {
            continue;
        }
        off += usize::from((sum - 1.0).abs() > f64::from(TOLERANCE));
        vertex
            .iter_mut()
            .for_each(|w| *w = (f64::from(*w) / sum) as f32);
    }
    if clamped > 0 {
        let what = format!("{clamped} weights are negative or NaN; read as 0");
        reader.warn(attributes, what);
    }
    if off > 0 {
        let all = weights.len() / influences;
        let what = format!("the weights of {off} of {all} vertices do not sum to 1; normalised");
        reader.warn(attributes, what);
    }
}

/// Sets joint indices of weight 0 to 0, since exporters leave arbitrary values there, and returns
/// an error for others outside of the skin.
fn check_joints(
    attributes: &Place<'_>,
    joint_count: usize,
    joints: &mut [u16],
    weights: &[f32],
) -> Result<(), ReadError> {
    for (joint, weight) in joints.iter_mut().zip(weights) {
        if *weight == 0.0 {
            *joint = 0;
        } else if usize::from(*joint) >= joint_count {
            let what = format!(
                "joint {joint} of a vertex is out of range: the skin has {joint_count} joints"
            );
            return Err(attributes.malformed(what));
        }
    }
    Ok(())
}

/// Binds vertices without weights to the first joint of the skin.
fn bind_loose(
    reader: &mut Reader<'_>,
    attributes: &Place<'_>,
    influences: usize,
    (joints, weights): (&mut [u16], &mut [f32]),
) {
    let mut loose = 0;
    let vertices = joints
        .chunks_exact_mut(influences)
        .zip(weights.chunks_exact_mut(influences));
    for (joints, weights) in vertices {
        if weights.iter().all(|w| *w == 0.0) {
            joints[0] = 0;
            weights[0] = 1.0;
            loose += 1;
        }
    }
    if loose > 0 {
        let what = format!("{loose} vertices have no weight; bound to the first joint");
        reader.warn(attributes, what);
    }
}
