//! Weights of vertices by the region of the body that moves them most.

use articula_core::Mismatch;
use articula_core::articulation::Region;
use articula_core::mesh::Mesh;
use articula_core::rig::Rig;

/// How much an error at each vertex counts, by the region of the joint that weighs most on it:
/// `("hands", 4.0)` makes errors of hands count four times. Regions that are not named count 1.
///
/// # Errors
/// A [`Mismatch`] if there is no region of a name, a factor is not a positive number or the mesh
/// is of another rig.
pub fn region_weights(
    mesh: &Mesh,
    rig: &Rig,
    factors: &[(&str, f32)],
) -> Result<Vec<f32>, Mismatch> {
    let mut of_region = [1.0f32; Region::ALL.len()];
    for (name, factor) in factors {
        let Some(region) = Region::from_name(name) else {
            let known = Region::ALL.map(Region::name).join(", ");
            let what = format!("\"{name}\" is none of {known}");
            return Err(Mismatch::new("region", what));
        };
        if !(factor.is_finite() && *factor > 0.0) {
            let what = format!("{factor} for {name} is not above 0");
            return Err(Mismatch::new("region", what));
        }
        let at = Region::ALL.iter().position(|r| *r == region);
        if let Some(at) = at {
            of_region[at] *= factor;
        }
    }
    let joints = &rig.articulation().joints;
    if let Some(b) = mesh
        .bindings
        .iter()
        .find(|b| usize::from(b.joint) >= joints.len())
    {
        let what = format!("joint {} of {}", b.joint, joints.len());
        return Err(Mismatch::new("mesh.bindings", what));
    }
    let weight = |v: usize| {
        let heaviest =
            mesh.influences_of(v)
                .fold(None, |best: Option<(usize, f32)>, i| match best {
                    Some(b) if b.1 >= i.1 => Some(b),
                    _ => Some(i),
                });
        let region = heaviest.map(|(joint, _)| joints[joint].region);
        let at = region.and_then(|r| Region::ALL.iter().position(|known| *known == r));
        at.map_or(1.0, |at| of_region[at])
    };
    Ok((0..mesh.len()).map(weight).collect())
}
