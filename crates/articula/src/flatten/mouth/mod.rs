//! A default inside of the mouth for portraits of heads without teeth and tongue.
//!
//! - `own`: whether a head has something in its mouth
//! - `shape`: teeth, tongue and the dark behind them, placed by the feature points
//! - `motion`: how they move with the morph targets of the face
//!
//! Method: `docs/methods/vector.md` part 10.

mod motion;
mod own;
mod shape;

use super::expressions::expressions;
use crate::face::FoundFace;
use crate::figure::Figure;
use articula_build::face::FapInterval;
use articula_core::fap_table::{FapDirection, TABLE};
use articula_core::source::Material;
use articula_core::{Mesh, Part, PosedMesh};
use articula_flat::portrait::PortraitExpression;
use glam::Vec3;
use motion::FaceMotion;
use own::{Inside, bag, inside};
use serde::Serialize;
use shape::{MouthShape, shade_of_bag};

/// Least distance by which an expression parts the lips, by the height of the face.
const OPENS: f32 = 0.03;
/// How far the tongue goes out, by the height of the face, and the share of the expression that opens the mouth widest
/// with which it does. It stays behind the lips, as there is one painting order for all expressions.
const TONGUE_OUT: Vec3 = Vec3::new(0.0, 0.07, 0.2);
const OPENED_FOR_TONGUE: f32 = 0.4;
/// Parameters of the tongue that a head with a table gets, and the value at which their expressions end.
const TONGUE_FAPS: [usize; 4] = [43, 44, 45, 46];
const TONGUE_END: i32 = 500;
/// Name of the parts in the mesh.
const NAME: &str = "default mouth";

/// Where the teeth and the tongue of a portrait are from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TeethAndTongue {
    /// The head has its own.
    Own,
    /// A wall of skin is close behind the lips, which would hide them.
    Walled,
    /// The head has none, so it was given default ones.
    Default,
    /// No expression opens the mouth.
    Closed,
    /// No feature points of a face are found, by which they could be placed.
    NoFace,
    /// Default ones were not asked for.
    LeftOut,
}

impl TeethAndTongue {
    /// Returns a line for people; none where nothing was added or missed.
    pub fn line(self) -> Option<&'static str> {
        match self {
            Self::Default => Some("teeth and tongue: default, the head has none"),
            Self::Own | Self::Walled | Self::Closed | Self::NoFace | Self::LeftOut => None,
        }
    }
}

/// The mesh of a figure with a default inside of its mouth.
pub(super) struct DefaultMouth {
    /// The figure's mesh with further vertices, triangles and offsets of its morph targets.
    pub(super) mesh: Mesh,
    /// Further triangles of the 2D mesh.
    pub(super) triangles: Vec<[u32; 3]>,
    /// The material of the further triangles, which follows those of the figure.
    pub(super) material: Material,
    /// Further expressions.
    pub(super) expressions: Vec<PortraitExpression>,
}

impl DefaultMouth {
    /// That of a head without teeth and tongue whose mouth opens; otherwise why there is none.
    pub(super) fn of(figure: &Figure) -> Result<Self, TeethAndTongue> {
        let all = expressions(figure);
        if all.is_empty() {
            return Err(TeethAndTongue::Closed);
        }
        let face = FoundFace::of(figure, &[]).map_err(|_| TeethAndTongue::NoFace)?;
        let motion = FaceMotion::new(figure, &face).ok_or(TeethAndTongue::NoFace)?;
        let parted = |e: &PortraitExpression| {
            let moved = e.morphs.iter().map(|(slot, w)| *w * motion.parted(*slot));
            moved.sum::<f32>()
        };
        let widest = all
            .iter()
            .max_by(|a, b| parted(a).total_cmp(&parted(b)))
            .filter(|e| parted(e) > OPENS * face.points.height())
            .ok_or(TeethAndTongue::Closed)?;
        let is_hollow = match seen_inside(figure, &face, &motion, widest) {
            None => return Err(TeethAndTongue::NoFace),
            Some(Inside::Own) => return Err(TeethAndTongue::Own),
            Some(Inside::Wall) => return Err(TeethAndTongue::Walled),
            Some(Inside::Bag) => false,
            Some(Inside::Hole) => true,
        };
        let shape = MouthShape::new(&face.points, is_hollow).ok_or(TeethAndTongue::NoFace)?;
        let mut mouth = Self::added(figure, &motion, &shape, &all, widest);
        if !is_hollow {
            mouth.darken_bag(&face);
        }
        Ok(mouth)
    }

    /// Gives skin that goes on inside of the mouth the colours that it has there.
    fn darken_bag(&mut self, face: &FoundFace) {
        let head = &face.head;
        for (vertex, depth) in bag(&head.surface, &face.points).into_iter().flatten() {
            let color = &mut self.mesh.colors[head.vertices[vertex as usize] as usize];
            *color *= shade_of_bag(depth).extend(1.0);
        }
    }

    fn added(
        figure: &Figure,
        motion: &FaceMotion<'_>,
        shape: &MouthShape,
        all: &[PortraitExpression],
        widest: &PortraitExpression,
    ) -> Self {
        let mut mesh = Mesh::clone(&figure.asset.mesh);
        let first = mesh.len() as u32;
        motion.append(shape, &mut mesh);
        let moved = |t: &[u32; 3]| t.map(|v| v + first);
        let part = Part {
            name: NAME.to_owned(),
            mesh: mesh.morph_slots.len(),
            material: Some(figure.opened.character().materials.len()),
            draw_material: None,
            vertices: first as usize..mesh.len(),
            triangles: mesh.triangles.len()..mesh.triangles.len() + shape.fine.len(),
        };
        mesh.parts.push(part);
        mesh.triangles.extend(shape.fine.iter().map(moved));
        let mut mouth = Self {
            triangles: shape.coarse.iter().map(moved).collect(),
            mesh,
            material: Material {
                name: NAME.to_owned(),
                ..Material::default()
            },
            expressions: Vec::new(),
        };
        mouth.add_tongue(motion, shape, all, widest);
        mouth
    }

    /// Lets the tongue move: with a table by its parameters, otherwise by `tongueOut`, which the head may have without
    /// a tongue.
    fn add_tongue(
        &mut self,
        motion: &FaceMotion<'_>,
        shape: &MouthShape,
        all: &[PortraitExpression],
        widest: &PortraitExpression,
    ) {
        let parts = || all.iter().filter_map(|e| FapInterval::parse(&e.name));
        if parts().any(|part| !(23..=26).contains(&part.fap)) {
            for fap in TONGUE_FAPS {
                if parts().any(|part| part.fap == fap) {
                    continue;
                }
                let Some(moved) = moved_by(fap, motion) else {
                    continue;
                };
                let is_of_body = fap == 46;
                let slot =
                    motion.append_tongue(shape, usize::from(is_of_body), moved, &mut self.mesh);
                let interval = FapInterval {
                    fap,
                    from: 0,
                    to: TONGUE_END,
                };
                let named = slot.map(|s| PortraitExpression::of_morph(interval.to_string(), s));
                self.expressions.extend(named);
            }
            return;
        }
        let out = TONGUE_OUT * motion.height();
        let Some(slot) = motion.append_tongue(shape, 0, out, &mut self.mesh) else {
            return;
        };
        // It goes out through an open mouth.
        let opened = widest.morphs.iter();
        let opened = opened.map(|(slot, weight)| (*slot, OPENED_FOR_TONGUE * weight));
        self.expressions.push(PortraitExpression {
            name: "tongueOut".to_owned(),
            morphs: std::iter::once((slot, 1.0)).chain(opened).collect(),
            joints: Vec::new(),
        });
    }
}

/// What is seen while the expression that opens the mouth widest is shown.
fn seen_inside(
    figure: &Figure,
    face: &FoundFace,
    motion: &FaceMotion<'_>,
    widest: &PortraitExpression,
) -> Option<Inside> {
    let asset = &figure.asset;
    let mut weights = vec![0.0; asset.mesh.morph_weights.len()];
    for (slot, weight) in &widest.morphs {
        weights[usize::from(*slot)] += weight;
    }
    let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
    let places = posed
        .pose(asset.rig.rest_pose())
        .skinned(&weights)
        .positions;
    let head = &face.head;
    let to_head = head.model_from_head.inverse();
    let opened = head.vertices.iter();
    let opened: Vec<Vec3> = opened.map(|v| to_head * places[*v as usize]).collect();
    inside(&head.surface, &face.points, &opened, motion.lips())
}

/// The displacement of the tongue by a parameter at the end of its expression, metres.
fn moved_by(fap: usize, motion: &FaceMotion<'_>) -> Option<Vec3> {
    let action = TABLE[fap - 1].action?;
    let along = match action.direction {
        FapDirection::Left => Vec3::X,
        FapDirection::Right => -Vec3::X,
        FapDirection::Up => Vec3::Y,
        FapDirection::Down => -Vec3::Y,
        FapDirection::Forward => Vec3::Z,
        FapDirection::Growth | FapDirection::Curl => return None,
    };
    Some(motion.unit(action.unit) * TONGUE_END as f32 / 1024.0 * along)
}
