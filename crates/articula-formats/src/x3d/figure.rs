//! Extraction of one humanoid from a scene: its joints, attached shapes, and sites.
//!
//! Source: ISO/IEC 19774-1 (H-Anim), 6.2 to 6.5; ISO/IEC 19775-1, clause 26.

use super::fields::Reader;
use super::placement::Placement;
use super::scene::NodeId;
use crate::error::ReadError;
use glam::{DAffine3, DVec3};
use std::collections::HashSet;

/// A humanoid as placed in the scene.
#[derive(Debug)]
pub(super) struct Figure {
    pub(super) id: NodeId,
    /// World-from-humanoid matrix, in metres.
    pub(super) world: DAffine3,
    /// Parents before children.
    pub(super) joints: Vec<FigureJoint>,
    /// Shapes rigidly attached to joints, in the order of the file.
    pub(super) parts: Vec<Part>,
    pub(super) sites: Vec<FigureSite>,
}

/// A joint as in the file.
#[derive(Debug)]
pub(super) struct FigureJoint {
    pub(super) id: NodeId,
    pub(super) name: String,
    pub(super) parent: Option<usize>,
    /// Product of the transforms between the parent and this joint; usually the identity.
    pub(super) above: DAffine3,
    /// The joint's own fields.
    pub(super) stored: Placement,
}

/// Shapes that follow one joint: a segment, or shapes attached to a joint directly.
#[derive(Debug)]
pub(super) struct Part {
    pub(super) joint: usize,
    /// The segment, or the joint.
    pub(super) id: NodeId,
    pub(super) shapes: Vec<PlacedShape>,
}

/// A shape, and its transform in the space of the joint (or the humanoid, for skin).
#[derive(Debug, Clone, Copy)]
pub(super) struct PlacedShape {
    pub(super) id: NodeId,
    pub(super) place: DAffine3,
}

/// Shapes of the skin in one group.
#[derive(Debug)]
pub(super) struct SkinGroup {
    /// Name of the group; may be empty.
    pub(super) name: String,
    pub(super) shapes: Vec<PlacedShape>,
}

/// A named position on a joint.
#[derive(Debug)]
pub(super) struct FigureSite {
    pub(super) joint: usize,
    pub(super) name: String,
    /// Position in the space of the joint.
    pub(super) position: DVec3,
}

/// Finds the first humanoid of a scene and reads its structure.
pub(super) fn find(reader: &mut Reader<'_>) -> Result<Figure, ReadError> {
    let mut search = Search::default();
    let unit = DAffine3::from_scale(DVec3::splat(reader.scene.metres));
    for &root in &reader.scene.roots {
        search.walk(reader, root, unit, 1)?;
    }
    if search.shapes > 0 {
        let what = format!("{} shapes outside the humanoid are left out", search.shapes);
        reader.notes.add("scene", what);
    }
    for &(other, _) in search.humanoids.iter().skip(1) {
        reader.warn(
            other,
            "the scene has several humanoids; only the first is read",
        );
    }
    let Some(&(id, above)) = search.humanoids.first() else {
        return Err(ReadError::Unsupported {
            at: "scene".to_owned(),
            what: "an X3D scene without an HAnimHumanoid".to_owned(),
            mend: "give a file with an H-Anim figure".to_owned(),
        });
    };
    let own = Placement::read(reader, id)?;
    let mut figure = Figure {
        id,
        world: above * own.matrix(),
        joints: Vec::new(),
        parts: Vec::new(),
        sites: Vec::new(),
    };
    let mut seen = HashSet::new();
    for root in skeleton_roots(reader, id) {
        let here = Here {
            joint: None,
            place: DAffine3::IDENTITY,
            part: None,
        };
        figure.walk(reader, root, here, 1, &mut seen)?;
    }
    if figure.joints.is_empty() {
        return Err(reader.malformed(id, "the humanoid has no joint in its field \"skeleton\""));
    }
    Ok(figure)
}

/// Returns the root joints. Some files put the joints into the children of the humanoid.
fn skeleton_roots(reader: &Reader<'_>, id: NodeId) -> Vec<NodeId> {
    let skeleton = reader.nodes(id, "skeleton");
    if skeleton.iter().any(|&n| reader.kind(n) == "HAnimJoint") {
        return skeleton;
    }
    let joints = reader.nodes(id, "children").into_iter();
    let joints = joints.filter(|&n| reader.kind(n) == "HAnimJoint");
    skeleton.into_iter().chain(joints).collect()
}

/// Humanoids of a scene, each with the matrix of its ancestors.
#[derive(Debug, Default)]
struct Search {
    humanoids: Vec<(NodeId, DAffine3)>,
    /// Number of shapes outside of any humanoid.
    shapes: usize,
}

impl Search {
    fn walk(
        &mut self,
        reader: &mut Reader<'_>,
        id: NodeId,
        place: DAffine3,
        depth: usize,
    ) -> Result<(), ReadError> {
        reader.visit(id, depth)?;
        match reader.kind(id) {
            "HAnimHumanoid" => {
                if !self.humanoids.iter().any(|(known, _)| *known == id) {
                    self.humanoids.push((id, place));
                }
                return Ok(());
            }
            "Shape" => self.shapes += 1,
            _ => {}
        }
        let place = place * matrix(reader, id)?;
        for child in shown_children(reader, id)? {
            self.walk(reader, child, place, depth + 1)?;
        }
        Ok(())
    }
}

/// Returns the matrix of a grouping node; usually the identity.
fn matrix(reader: &mut Reader<'_>, id: NodeId) -> Result<DAffine3, ReadError> {
    match reader.kind(id) {
        "Transform" | "HAnimSite" => Ok(Placement::read(reader, id)?.matrix()),
        _ => Ok(DAffine3::IDENTITY),
    }
}

/// Returns the visible children of a grouping node: the choice of a switch, the finest level of
/// detail.
fn shown_children(reader: &mut Reader<'_>, id: NodeId) -> Result<Vec<NodeId>, ReadError> {
    let of = |reader: &Reader<'_>, fields: [&str; 2]| {
        let lists = fields.map(|field| reader.nodes(id, field));
        lists.concat()
    };
    Ok(match reader.kind(id) {
        "Switch" => {
            let choice = reader.indices(id, "whichChoice")?;
            let choice = choice.first().copied().unwrap_or(-1);
            let all = of(reader, ["children", "choice"]);
            let chosen = usize::try_from(choice).ok().and_then(|i| all.get(i));
            chosen.copied().into_iter().collect()
        }
        "LOD" => {
            let mut all = of(reader, ["children", "level"]);
            all.truncate(1);
            all
        }
        _ => reader.nodes(id, "children"),
    })
}

/// Position of a traversal of the skeleton.
#[derive(Debug, Clone, Copy)]
struct Here {
    joint: Option<usize>,
    /// Matrix from the space of the joint.
    place: DAffine3,
    part: Option<usize>,
}

impl Figure {
    fn walk(
        &mut self,
        reader: &mut Reader<'_>,
        id: NodeId,
        here: Here,
        depth: usize,
        seen: &mut HashSet<NodeId>,
    ) -> Result<(), ReadError> {
        reader.visit(id, depth)?;
        let mut here = here;
        match reader.kind(id) {
            "HAnimJoint" if !seen.insert(id) => {
                reader.warn(id, "the joint has two parents; only the first is used");
                return Ok(());
            }
            "HAnimJoint" => {
                self.joints.push(FigureJoint {
                    id,
                    name: reader.spelled_name(id),
                    parent: here.joint,
                    above: here.place,
                    stored: Placement::read(reader, id)?,
                });
                here = Here {
                    joint: Some(self.joints.len() - 1),
                    place: DAffine3::IDENTITY,
                    part: None,
                };
            }
            "HAnimSegment" => here.part = self.part(reader, id, here),
            "HAnimSite" => {
                here.place *= Placement::read(reader, id)?.matrix();
                if let Some(joint) = here.joint {
                    self.sites.push(FigureSite {
                        joint,
                        name: reader.name(id),
                        position: here.place.translation,
                    });
                }
            }
            "Shape" if !reader.flag(id, "visible", true) => return Ok(()),
            "Shape" => {
                if here.part.is_none() {
                    here.part = self.part(reader, id, here);
                }
                if let Some(part) = here.part {
                    let place = here.place;
                    self.parts[part].shapes.push(PlacedShape { id, place });
                }
                return Ok(());
            }
            _ => here.place *= matrix(reader, id)?,
        }
        for child in shown_children(reader, id)? {
            self.walk(reader, child, here, depth + 1, seen)?;
        }
        Ok(())
    }

    /// Adds a part to the current joint of the traversal.
    fn part(&mut self, reader: &mut Reader<'_>, id: NodeId, here: Here) -> Option<usize> {
        let Some(joint) = here.joint else {
            reader.warn(id, "is attached to no joint; left out");
            return None;
        };
        let id = match reader.kind(id) {
            "HAnimSegment" => id,
            _ => self.joints[joint].id,
        };
        // Consecutive shapes without a segment share a part.
        if self.parts.last().is_none_or(|last| last.id != id) {
            self.parts.push(Part {
                joint,
                id,
                shapes: Vec::new(),
            });
        }
        Some(self.parts.len() - 1)
    }

    /// Returns the shapes of the skin by group; shapes without a group form one.
    pub(super) fn skin(&self, reader: &mut Reader<'_>) -> Result<Vec<SkinGroup>, ReadError> {
        let mut groups: Vec<SkinGroup> = Vec::new();
        for id in reader.nodes(self.id, "skin") {
            let mut shapes = Vec::new();
            collect_shapes(reader, id, DAffine3::IDENTITY, 1, &mut shapes)?;
            let is_group = reader.kind(id) != "Shape";
            let name = if is_group {
                reader.name(id)
            } else {
                String::new()
            };
            match groups
                .last_mut()
                .filter(|last| last.name.is_empty() && name.is_empty())
            {
                Some(last) => last.shapes.extend(shapes),
                None => groups.push(SkinGroup { name, shapes }),
            }
        }
        Ok(groups)
    }
}

fn collect_shapes(
    reader: &mut Reader<'_>,
    id: NodeId,
    place: DAffine3,
    depth: usize,
    found: &mut Vec<PlacedShape>,
) -> Result<(), ReadError> {
    reader.visit(id, depth)?;
    if reader.kind(id) == "Shape" {
        if !reader.flag(id, "visible", true) {
            return Ok(());
        }
        found.push(PlacedShape { id, place });
        return Ok(());
    }
    let place = place * matrix(reader, id)?;
    for child in shown_children(reader, id)? {
        collect_shapes(reader, child, place, depth + 1, found)?;
    }
    Ok(())
}
