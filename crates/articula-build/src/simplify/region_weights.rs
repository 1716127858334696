//! Vertex weights by body region.

use articula_core::{Mesh, Mismatch, Region, Rig};

/// Returns the weight of an error at each vertex, by the region of the joint with the largest
/// weight on it: `("hands", 4.0)` makes errors of hands count four times. The weight is 1 in
/// regions that are not listed.
///
/// # Errors
/// A [`Mismatch`] if a name is not that of a region, a factor is not positive and finite, or the
/// mesh belongs to another rig.
pub fn region_weights(
    mesh: &Mesh,
    rig: &Rig,
    factors: &[(&str, f32)],
) -> Result<Vec<f32>, Mismatch> {
    let mut of_region = [1.0f32; Region::ALL.len()];
    for (name, factor) in factors {
        let Ok(region) = name.parse::<Region>() else {
            let known = Region::ALL.map(|r| r.to_string()).join(", ");
            let what = format!("unknown region \"{name}\"; the regions are {known}");
            return Err(Mismatch::new("factors", what));
        };
        if !(factor.is_finite() && *factor > 0.0) {
            let what = format!("the factor of {name} must be positive and finite, found {factor}");
            return Err(Mismatch::new("factors", what));
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
        let what = format!(
            "joint {} is out of range: the rig has {} joints",
            b.joint,
            joints.len()
        );
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{figure, rig};
    use articula_core::Articulation;
    use articula_core::source::{Joint, Skeleton};

    /// A tube of two joints, the upper one a hand.
    fn hand() -> (Mesh, Rig) {
        let asset = figure(&[None, Some(0)]);
        let plain = rig(&[None, Some(0)]);
        let mut joints = plain.articulation().joints.clone();
        joints[1].region = Region::Hands;
        let named = |(j, parent)| Joint {
            name: format!("j{j}"),
            parent,
            rest: plain.rest_pose().get(j),
            in_skin: true,
        };
        let skeleton = Skeleton {
            joints: [(0, None), (1, Some(0))].map(named).to_vec(),
        };
        let articulation = Articulation {
            profile: String::new(),
            joints,
        };
        (asset.mesh, Rig::new(&skeleton, articulation).unwrap())
    }

    #[test]
    fn the_heaviest_joint_decides() {
        let (mesh, rig) = hand();
        let weights = region_weights(&mesh, &rig, &[("hands", 4.0), ("Hands", 0.5)]).unwrap();
        // Eight vertices for each joint: the last four are on the hand alone; those shared half and
        // half belong to the joint that is listed first.
        assert_eq!(weights[..8], [1.0; 8]);
        assert_eq!(weights[12..], [2.0; 4]);
        assert_eq!(weights[8..12], [2.0; 4]);
    }

    #[test]
    fn an_unknown_region_is_told_with_the_known_ones() {
        let (mesh, rig) = hand();
        let error = region_weights(&mesh, &rig, &[("tail", 2.0)]).unwrap_err();
        let known = "face, arms, torso, pelvis, legs, feet, hands";
        assert_eq!(
            error.what,
            format!("unknown region \"tail\"; the regions are {known}")
        );
        for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(region_weights(&mesh, &rig, &[("face", factor)]).is_err());
        }
    }
}
