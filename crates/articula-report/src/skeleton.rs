//! Joints of a character over its faded body, marked as active, passive or in transition.
//!
//! Source: thesis figures 5.1, 6.16 and 6.17: active joints green, passive ones red, joints in
//! transition amber. Differs: passive joints are hollow rings, so that the marks differ without
//! colour.

use crate::paint::{draw_disc, draw_line, draw_ring};
use articula::core::{Camera, JointSet, Mesh, ModelPose, Rig};
use articula::flat::{Picture, Projection, Rgba, Screen};
use glam::Vec2;

/// State of a joint as it is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointMark {
    /// The joint follows the clip.
    Active,
    /// The joint is held.
    Passive,
    /// The joint changes between active and passive.
    InTransition,
}

impl JointMark {
    /// All marks, in the order of legends.
    pub(crate) const ALL: [Self; 3] = [Self::Active, Self::InTransition, Self::Passive];

    /// Colour of the disc and the bones.
    pub(crate) fn color(self) -> Rgba {
        match self {
            Self::Active => [22, 138, 66, 255],
            Self::Passive => [200, 38, 38, 255],
            Self::InTransition => [224, 142, 0, 255],
        }
    }

    /// Name in legends.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Active => "active",
            Self::Passive => "passive",
            Self::InTransition => "in transition",
        }
    }

    /// Draws the mark: a disc, or a ring for a passive joint.
    pub(crate) fn draw(self, picture: &mut Picture, at: Vec2, radius: f32) {
        const PAPER: Rgba = [255, 255, 255, 235];
        draw_disc(picture, at, radius + 0.8, PAPER);
        match self {
            Self::Passive => {
                draw_ring(picture, at, radius, (0.45 * radius).max(1.2), self.color());
            }
            Self::Active | Self::InTransition => draw_disc(picture, at, radius, self.color()),
        }
    }
}

/// Radius of a joint's disc, metres; clamped to 2 to 7 pixels.
const JOINT_RADIUS_M: f32 = 0.02;
/// Blend of the picture below towards white, 0 to 1.
const FADE: f32 = 0.62;

/// Joints and style of a drawn skeleton.
struct SkeletonOptions {
    joint_radius_m: f32,
    fade: f32,
    /// Joints that are drawn.
    joints: JointSet,
}

/// Returns the skin joints that influence a vertex, themselves or through a descendant; all skin
/// joints if no vertex is influenced.
pub fn influencing_joints(rig: &Rig, mesh: &Mesh) -> JointSet {
    let weighted = mesh.binding_indices.iter().zip(&mesh.weights);
    let weighted = weighted.filter(|(_, weight)| **weight > 0.0);
    let mut carrying: JointSet = weighted
        .map(|(binding, _)| usize::from(mesh.bindings[usize::from(*binding)].joint))
        .collect();
    for joint in (0..rig.len()).rev().filter(|j| rig.parent(*j).is_some()) {
        if carrying.contains(joint) {
            carrying.extend(rig.parent(joint));
        }
    }
    let influencing_joints = carrying.intersection(rig.skin_joints());
    if influencing_joints.is_empty() {
        *rig.skin_joints()
    } else {
        influencing_joints
    }
}

/// Draws joints of a character over its picture from `camera`.
///
/// `marks` has one entry per joint of the rig; joints beyond its end are active. A bone has the
/// colour of its parent joint. Joints behind the camera are left out. Authoring rigs contain
/// control joints that no vertex follows: see [`influencing_joints`].
pub fn draw_skeleton(
    picture: &mut Picture,
    rig: &Rig,
    pose: &ModelPose,
    camera: &Camera,
    joints: &JointSet,
    marks: &[JointMark],
) {
    let options = SkeletonOptions {
        joint_radius_m: JOINT_RADIUS_M,
        fade: FADE,
        joints: *joints,
    };
    let screen = Screen::new(camera, Projection::Perspective);
    draw(picture, (rig, pose), &screen, marks, &options);
}

fn draw(
    picture: &mut Picture,
    (rig, pose): (&Rig, &ModelPose),
    screen: &Screen,
    marks: &[JointMark],
    options: &SkeletonOptions,
) {
    for y in 0..picture.height() as i32 {
        for x in 0..picture.width() as i32 {
            picture.blend(x, y, [255; 4], options.fade);
        }
    }
    let joints = placed(rig, pose, screen, options);
    let mark = |joint: usize| marks.get(joint).copied().unwrap_or(JointMark::Active);
    for end in &joints {
        let Some(start) = end
            .parent
            .and_then(|p| joints.iter().find(|j| j.joint == p))
        else {
            continue;
        };
        let (wide, thin) = (0.62 * end.radius, 0.22 * end.radius.max(2.0));
        let halo = [255, 255, 255, 200];
        let (from, to) = (start.at, end.at);
        draw_line(picture, (from, wide + 0.8), (to, thin + 0.8), halo);
        draw_line(picture, (from, wide), (to, thin), mark(start.joint).color());
    }
    for joint in &joints {
        mark(joint.joint).draw(picture, joint.at, joint.radius);
    }
}

struct Placed {
    joint: usize,
    parent: Option<usize>,
    at: Vec2,
    radius: f32,
    depth: f32,
}

/// The skin joints in view, the farthest first.
fn placed(rig: &Rig, pose: &ModelPose, screen: &Screen, options: &SkeletonOptions) -> Vec<Placed> {
    let mut joints = Vec::new();
    let drawn = options.joints;
    for joint in drawn.iter() {
        let position = pose.position(joint);
        let Some(at) = screen.place(position).filter(|p| p.is_finite()) else {
            continue;
        };
        let parent = drawn_parent(rig, &drawn, joint);
        let scale = screen.pixels_per_metre_at(position);
        let radius = (options.joint_radius_m * scale).clamp(2.0, 7.0);
        // Fingers are closer together than full discs allow.
        let bone = parent.map_or(f32::INFINITY, |p| {
            pose.position(p).distance(position) * scale
        });
        joints.push(Placed {
            joint,
            parent,
            at,
            radius: radius.min((0.3 * bone).max(1.2)),
            depth: screen.camera().view(position).z,
        });
    }
    joints.sort_by(|a, b| b.depth.total_cmp(&a.depth).then(a.joint.cmp(&b.joint)));
    joints
}

/// Nearest ancestor that is drawn.
fn drawn_parent(rig: &Rig, drawn: &JointSet, joint: usize) -> Option<usize> {
    let mut at = rig.parent(joint);
    while let Some(j) = at.filter(|j| !drawn.contains(*j)) {
        at = rig.parent(j);
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula::core::source::{Joint, Skeleton};
    use articula::core::{
        Articulation, JointArticulation, Region, Transform, Viewport, local_to_model,
    };
    use glam::Vec3;

    /// Three skin joints one above the other with a plain node between the upper two.
    fn tower() -> (Rig, ModelPose) {
        let joint = |parent, in_skin| Joint {
            name: String::new(),
            parent,
            rest: Transform::from_translation(Vec3::Y * 0.5),
            in_skin,
        };
        let skeleton = Skeleton {
            joints: vec![
                joint(None, true),
                joint(Some(0), true),
                joint(Some(1), false),
                joint(Some(2), true),
            ],
        };
        let level = JointArticulation {
            hanim: None,
            level: 0,
            region: Region::Torso,
        };
        let articulation = Articulation {
            profile: String::new(),
            joints: vec![level; 4],
        };
        let rig = Rig::new(&skeleton, articulation).unwrap();
        let mut pose = ModelPose::new(4);
        local_to_model(&rig, rig.rest_pose(), &mut pose);
        (rig, pose)
    }

    fn drawn(marks: &[JointMark]) -> (Picture, Screen) {
        let viewport = Viewport {
            width_px: 200.0,
            height_px: 300.0,
            ..Viewport::default()
        };
        let camera = Camera::looking_at(Vec3::new(0.0, 1.25, 3.0), Vec3::Y * 1.25, viewport);
        let screen = Screen::new(&camera, Projection::Perspective);
        let (rig, pose) = tower();
        let mut picture = Picture::new(200, 300, [0, 0, 0, 255]).unwrap();
        let options = SkeletonOptions {
            joint_radius_m: 0.05,
            fade: 1.0,
            joints: *rig.skin_joints(),
        };
        draw(&mut picture, (&rig, &pose), &screen, marks, &options);
        (picture, screen)
    }

    #[test]
    fn only_what_a_vertex_follows_is_drawn() {
        use articula::core::source;
        let (rig, _) = tower();
        let mesh = |joint: u16| {
            let skin = source::Skin {
                joints: (0..rig.len()).collect(),
                inverse_bind: vec![glam::Affine3A::IDENTITY; rig.len()],
            };
            let primitive = source::Primitive {
                positions: vec![Vec3::ZERO],
                influences: 1,
                joints: vec![joint],
                weights: vec![1.0],
                ..source::Primitive::default()
            };
            let mesh = source::RawMesh {
                skin,
                primitives: vec![primitive],
                ..source::RawMesh::default()
            };
            Mesh::new(&[mesh], rig.len()).unwrap()
        };
        let last = (0..rig.len())
            .rev()
            .find(|j| rig.skin_joints().contains(*j))
            .unwrap();
        let above = influencing_joints(&rig, &mesh(rig.root() as u16));
        assert_eq!(above.iter().collect::<Vec<_>>(), [rig.root()]);
        assert!(
            influencing_joints(&rig, &mesh(last as u16)).contains(rig.root()),
            "what leads there too"
        );
        assert_eq!(
            influencing_joints(&rig, &Mesh::default()),
            *rig.skin_joints()
        );
    }

    #[test]
    fn joints_show_their_mark_and_bones_that_of_the_joint_above() {
        use JointMark::{Active, InTransition, Passive};
        let (picture, screen) = drawn(&[Active, InTransition, Active, Passive]);
        let at = |height: f32| {
            let place = screen.place(Vec3::Y * height).unwrap();
            picture.get(place.x as u32, place.y as u32).unwrap()
        };
        assert_eq!(at(0.5), Active.color());
        assert_eq!(at(0.75), Active.color(), "the lower bone");
        assert_eq!(at(1.0), InTransition.color());
        assert_eq!(at(1.5), InTransition.color(), "the bone runs past the node");
        let hollow = at(2.0);
        assert!(hollow[0] > 230 && hollow[1] > 200, "a ring: {hollow:?}");
        assert_eq!(picture.get(2, 2), Some([255; 4]), "faded");
    }

    #[test]
    fn joints_without_a_mark_are_active() {
        let (picture, _) = drawn(&[]);
        let passive = JointMark::Passive.color();
        assert!(picture.pixels().iter().all(|p| *p != passive));
    }
}
