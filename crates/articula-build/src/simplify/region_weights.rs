//! Body regions of the skin, and vertex weights by them.

use articula_core::{Mesh, Mismatch, Region, Rig};

/// Returns the region of the skin that each joint of a rig moves: the region of the joint, but the
/// face for the skull base and all joints below it. H-Anim counts the skull base to the spine, and
/// the face has no other joint in many rigs.
pub fn skin_regions(rig: &Rig) -> Vec<Region> {
    let joints = &rig.articulation().joints;
    let mut is_head = vec![false; joints.len()];
    for (j, joint) in joints.iter().enumerate() {
        let above = rig.parent(j).is_some_and(|p| is_head[p]);
        is_head[j] = above || joint.hanim.as_deref() == Some("skullbase");
    }
    let of = |(joint, is_head): (&articula_core::JointArticulation, &bool)| match is_head {
        true => Region::Face,
        false => joint.region,
    };
    joints.iter().zip(&is_head).map(of).collect()
}

/// Returns the region of the skin ([`skin_regions`]) that the joint with the largest weight on each
/// vertex moves.
///
/// # Panics
/// If the mesh belongs to another rig.
pub fn vertex_regions(mesh: &Mesh, rig: &Rig) -> Vec<Region> {
    let regions = skin_regions(rig);
    let region = |v: usize| {
        let mut influences = mesh.influences_of(v);
        let first = influences.next().unwrap_or((0, 0.0));
        let heaviest = influences.fold(first, |best, i| if best.1 >= i.1 { best } else { i });
        regions[heaviest.0]
    };
    (0..mesh.len()).map(region).collect()
}

/// Returns the weight of an error at each vertex, by the region of the skin ([`skin_regions`]) that
/// the joint with the largest weight on it moves: `("hands", 4.0)` makes errors of hands count four
/// times. The weight is 1 in regions that are not listed.
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
    let weight = |region: Region| {
        let at = Region::ALL.iter().position(|known| *known == region);
        at.map_or(1.0, |at| of_region[at])
    };
    Ok(vertex_regions(mesh, rig).into_iter().map(weight).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint_lods::test_figures::{figure, rig};
    use articula_core::source::{Joint, Skeleton};
    use articula_core::{Articulation, Transform};

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
        (
            Mesh::clone(&asset.mesh),
            Rig::new(&skeleton, articulation).unwrap(),
        )
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

    #[test]
    fn the_head_belongs_to_the_face() {
        let plain = rig(&[None, Some(0), Some(1), Some(0)]);
        let mut articulation = plain.articulation().clone();
        articulation.joints[1].hanim = Some("skullbase".into());
        for joint in &mut articulation.joints {
            joint.region = Region::Torso;
        }
        let named = |(j, parent)| Joint {
            name: format!("j{j}"),
            parent,
            rest: Transform::IDENTITY,
            in_skin: true,
        };
        let parents = [(0, None), (1, Some(0)), (2, Some(1)), (3, Some(0))];
        let skeleton = Skeleton {
            joints: parents.map(named).to_vec(),
        };
        let rig = Rig::new(&skeleton, articulation).unwrap();
        let expected = [Region::Torso, Region::Face, Region::Face, Region::Torso];
        assert_eq!(skin_regions(&rig), expected);
    }
}
