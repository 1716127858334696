//! Comparison of two characters by joints and skinned corners at any time.

use articula_core::LocalPose;
use articula_core::source::{Character, Property, RawClip, RawMesh, evaluate};
use glam::{DAffine3, DMat3, DVec3};

/// Returns model matrices of all joints at a time of a clip; without one, at rest.
pub(crate) fn globals(
    character: &Character,
    clip: Option<&RawClip>,
    time_secs: f32,
) -> Vec<DAffine3> {
    let joints = &character.skeleton.joints;
    let mut pose = LocalPose {
        translations: joints.iter().map(|j| j.rest.translation).collect(),
        rotations: joints.iter().map(|j| j.rest.rotation).collect(),
        scales: joints.iter().map(|j| j.rest.scale).collect(),
    };
    if let Some(clip) = clip {
        evaluate::pose(clip, &character.skeleton, time_secs, &mut pose);
    }
    let mut all: Vec<DAffine3> = Vec::new();
    for (index, joint) in joints.iter().enumerate() {
        let local = DAffine3::from_scale_rotation_translation(
            pose.scales[index].as_dvec3(),
            pose.rotations[index].as_dquat().normalize(),
            pose.translations[index].as_dvec3(),
        );
        all.push(joint.parent.map_or(local, |p| all[p] * local));
    }
    all
}

/// Returns the weights of a mesh's morph targets at a time.
fn weights(character: &Character, mesh: usize, clip: Option<&RawClip>, time_secs: f32) -> Vec<f32> {
    let mut weights = character.meshes[mesh].morph_weights.clone();
    let channels = clip.iter().flat_map(|c| &c.channels);
    for channel in channels {
        if channel.property == Property::Weights && channel.target == mesh {
            evaluate::channel(channel, time_secs, &mut weights);
        }
    }
    weights
}

fn affine(m: &glam::Affine3A) -> DAffine3 {
    let axes = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
    let [x, y, z] = axes.map(|a| a.as_dvec3());
    DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), m.translation.as_dvec3())
}

/// Returns the positions of a mesh's triangle corners, triangle by triangle; triangles that use a
/// vertex twice are left out.
pub(crate) fn corners(
    character: &Character,
    mesh: usize,
    clip: Option<&RawClip>,
    time_secs: f32,
) -> Vec<DVec3> {
    let globals = globals(character, clip, time_secs);
    let weights = weights(character, mesh, clip, time_secs);
    let mesh: &RawMesh = &character.meshes[mesh];
    let binds = mesh.skin.joints.iter().zip(&mesh.skin.inverse_bind);
    let palette: Vec<DAffine3> = binds.map(|(j, bind)| globals[*j] * affine(bind)).collect();
    let mut corners = Vec::new();
    for primitive in &mesh.primitives {
        let place = |vertex: usize| {
            let mut point = primitive.positions[vertex].as_dvec3();
            for (morph, weight) in primitive.morphs.iter().zip(&weights) {
                point += morph.positions[vertex].as_dvec3() * f64::from(*weight);
            }
            let range = vertex * primitive.influences..(vertex + 1) * primitive.influences;
            let pairs = primitive.joints[range.clone()]
                .iter()
                .zip(&primitive.weights[range]);
            let moved = pairs.map(|(joint, weight)| {
                palette[usize::from(*joint)].transform_point3(point) * f64::from(*weight)
            });
            moved.sum::<DVec3>()
        };
        let places: Vec<DVec3> = (0..primitive.positions.len()).map(place).collect();
        for [a, b, c] in &primitive.triangles {
            if a != b && b != c && c != a {
                corners.extend([*a, *b, *c].map(|v| places[v as usize]));
            }
        }
    }
    corners
}

/// Returns the maximum distance between corresponding points.
pub(crate) fn farthest(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len(), "as many points on both sides");
    let distances = a.iter().zip(b).map(|(a, b)| a.distance(*b));
    distances.fold(0.0, f64::max)
}

/// Returns the diagonal of the bounding box of points.
pub(crate) fn extent(points: &[DVec3]) -> f64 {
    let low = points.iter().fold(DVec3::MAX, |l, p| l.min(*p));
    let high = points.iter().fold(DVec3::MIN, |h, p| h.max(*p));
    (high - low).length()
}
