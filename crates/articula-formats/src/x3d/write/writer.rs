//! The document: head, humanoid, clips, routes.

use super::super::names::{Names, token};
use super::bodies::{Body, BodyTarget, SkinWeights, bodies};
use super::bones::{Bone, Bones, bones};
use super::markup::Markup;
use super::shapes::Shapes;
use super::tracks::{self, Driven, axis_angle};
use crate::error::Warning;
use crate::written::{WriteError, WrittenFile};
use crate::x3d::Site;
use articula_core::Articulation;
use articula_core::source::{Character, Credits, Property};
use glam::{DQuat, Vec3};

/// Address of the published XML schema of X3D 4.0; never requested here.
const SCHEMA: &str = "https://www.web3d.org/specifications/x3d-4.0.xsd";

/// Name of the list of skin points.
const SKIN_POINTS: &str = "skin_points";

/// Writes a character with all its clips, and `sites` as the reader returns them.
///
/// Joints that `articulation` maps get their H-Anim 2 names, others valid names made from their
/// own; the name in the skeleton is the joint's description. At rest every joint is unrotated, as
/// the standard requires, whatever the skeleton's rest rotations; the positions of joints and
/// points and the motions match the source. Meshes that follow one joint become segments, others
/// skin; morph targets become displacers, clips time sensors with interpolators.
///
/// # Errors
/// [`WriteError`] if there is no joint, or the articulation belongs to another skeleton.
pub fn write(
    character: &Character,
    articulation: &Articulation,
    sites: &[Site],
) -> Result<WrittenFile, WriteError> {
    let joints = character.skeleton.joints.len();
    if joints == 0 {
        return Err(WriteError::NoJoint);
    }
    if articulation.joints.len() != joints {
        return Err(WriteError::OtherSkeleton {
            found: articulation.joints.len(),
            expected: joints,
        });
    }
    let mut warnings = Vec::new();
    let mut names = Names::default();
    let bones = bones(character, articulation, &mut names, &mut warnings);
    if bones.list.is_empty() {
        return Err(WriteError::NoJoint);
    }
    if bones.zero.is_binding {
        let what = "the bind pose differs from the rest pose: the figure is written in the bind \
                    pose, and its joints are rotated to the rest pose";
        warnings.push(Warning::new("skeleton", what));
    }
    let (bodies, weights) = bodies(character, &bones, &mut warnings);
    note_losses(character, &mut warnings);
    let mut defs = Names::default();
    defs.give(SKIN_POINTS, SKIN_POINTS);
    let def = |bone: &Bone| defs.give(&format!("hanim_{}", bone.name), "joint");
    let bone_defs = bones.list.iter().map(def).collect();
    let mut document = Document {
        displacer_defs: displacer_defs(character, &bodies, &mut defs),
        hangs: hangs(&bones, &bodies, sites),
        shapes: Shapes::new(character),
        markup: Markup::new(),
        segment_defs: Vec::new(),
        site_defs: Vec::new(),
        character,
        sites,
        names,
        defs,
        bone_defs,
        bones,
        bodies,
        weights,
    };
    document.write();
    Ok(WrittenFile {
        bytes: document.markup.finish(),
        motion: None,
        left_out: warnings.into_iter().map(in_words).collect(),
    })
}

/// Formats a warning with its position.
fn in_words(warning: Warning) -> String {
    format!("{}: {}", warning.at, warning.what)
}

/// Adds warnings for content that X3D cannot represent.
fn note_losses(character: &Character, warnings: &mut Vec<Warning>) {
    let mut note = |count: usize, what: &str| {
        if count > 0 {
            warnings.push(Warning::new("character", format!("{count} {what}")));
        }
    };
    let channels = || character.clips.iter().flat_map(|c| &c.channels);
    let expressions = channels().filter(|c| c.property == Property::Expression);
    note(expressions.count(), "expression channels are left out");
    note(character.expressions.len(), "expressions are left out");
    let primitives = character.meshes.iter().flat_map(|m| &m.primitives);
    let normals = primitives
        .flat_map(|p| &p.morphs)
        .filter(|m| !m.normals.is_empty());
    note(
        normals.count(),
        "morph targets lose their normals: displacers have none",
    );
}

/// Returns a `DEF` for each piece of each morph target of each body.
fn displacer_defs(
    character: &Character,
    bodies: &[Body],
    defs: &mut Names,
) -> Vec<Vec<Vec<String>>> {
    let of_body = |body: &Body| {
        let mesh = &character.meshes[body.mesh];
        let targets = body.targets.iter().zip(&mesh.morph_names);
        let mut of_target = |(target, name): (&BodyTarget, &String)| {
            let wish = match name.is_empty() {
                true => "morph".to_owned(),
                false => format!("{name}_morph"),
            };
            let pieces = target.pieces.iter();
            pieces.map(|_| defs.give(&wish, "morph")).collect()
        };
        targets.map(&mut of_target).collect()
    };
    bodies.iter().map(of_body).collect()
}

struct Document<'c> {
    character: &'c Character,
    sites: &'c [Site],
    bones: Bones,
    bodies: Vec<Body>,
    weights: SkinWeights,
    bone_defs: Vec<String>,
    displacer_defs: Vec<Vec<Vec<String>>>,
    /// Content attached to each bone.
    hangs: Vec<Hangs>,
    segment_defs: Vec<String>,
    site_defs: Vec<String>,
    shapes: Shapes<'c>,
    /// Names of joints, segments and sites.
    names: Names,
    /// Names of nodes.
    defs: Names,
    markup: Markup,
}

/// Content attached to one bone.
#[derive(Debug, Default)]
struct Hangs {
    /// Bodies that follow it alone.
    bodies: Vec<usize>,
    /// Its pieces of morph targets of the skin: body, target, piece.
    pieces: Vec<[usize; 3]>,
    /// Indices of sites.
    sites: Vec<usize>,
}

fn hangs(bones: &Bones, bodies: &[Body], sites: &[Site]) -> Vec<Hangs> {
    let mut hangs: Vec<Hangs> = bones.list.iter().map(|_| Hangs::default()).collect();
    for (index, body) in bodies.iter().enumerate() {
        if let Some(bone) = body.bone {
            hangs[bone].bodies.push(index);
            continue;
        }
        for (slot, target) in body.targets.iter().enumerate() {
            for (piece, (bone, _)) in target.pieces.iter().enumerate() {
                hangs[*bone].pieces.push([index, slot, piece]);
            }
        }
    }
    for (index, site) in sites.iter().enumerate() {
        if let Some(bone) = bones.of_joint.get(site.joint).copied().flatten() {
            hangs[bone].sites.push(index);
        }
    }
    hangs
}

/// Pending step of the traversal of the joint tree.
enum Step {
    Open(usize),
    Close,
}

impl Document<'_> {
    fn write(&mut self) {
        let markup = &mut self.markup;
        markup
            .open("X3D")
            .set("profile", "Immersive")
            .set("version", "4.0");
        markup.set("xmlns:xsd", "http://www.w3.org/2001/XMLSchema-instance");
        markup.set("xsd:noNamespaceSchemaLocation", SCHEMA);
        self.head();
        self.markup.open("Scene");
        self.viewpoint();
        self.humanoid();
        self.clips();
        self.markup.close();
        self.markup.close();
    }

    fn head(&mut self) {
        let markup = &mut self.markup;
        markup.open("head");
        markup
            .open("component")
            .set("name", "HAnim")
            .set("level", "1");
        markup.close();
        let none = Credits::default();
        let credits = self.character.credits.as_ref().unwrap_or(&none);
        let mut metas = vec![
            ("title", credits.title.as_str()),
            ("version", &credits.version),
            ("rights", &credits.copyright),
            ("license", &credits.licence_url),
            ("accessRights", &credits.licence_name),
        ];
        metas.extend(credits.authors.iter().map(|a| ("creator", a.as_str())));
        metas.extend(credits.references.iter().map(|r| ("reference", r.as_str())));
        metas.push(("generator", concat!("articula ", env!("CARGO_PKG_VERSION"))));
        for (name, content) in metas {
            if !content.is_empty() {
                markup
                    .open("meta")
                    .set("name", name)
                    .set("content", content);
                markup.close();
            }
        }
        markup.close();
    }

    /// Writes a camera that shows the whole figure from the front.
    fn viewpoint(&mut self) {
        let points = self.bodies.iter().flat_map(|b| b.points.iter().copied());
        let points = points.chain(self.bones.list.iter().map(|b| b.center));
        let (low, high) = points.fold((Vec3::MAX, Vec3::MIN), |(l, h), p| (l.min(p), h.max(p)));
        let middle = (low + high) / 2.0;
        let size = (high - low).max_element().max(0.1);
        let eye = Vec3::new(middle.x, middle.y, high.z + 1.6 * size);
        self.markup.open("Viewpoint").set("description", "front");
        self.markup.numbers("position", 3, eye.to_array());
        self.markup
            .numbers("centerOfRotation", 3, middle.to_array());
        self.markup.close();
    }

    fn humanoid(&mut self) {
        let given = &self.character.name;
        let name = self.names.give(given, "humanoid");
        let def = self.defs.give(&format!("hanim_{name}"), "humanoid");
        let markup = &mut self.markup;
        markup
            .open("HAnimHumanoid")
            .set("DEF", &def)
            .set("name", &name);
        markup.set("version", "2.0");
        describe(markup, &name, given);
        self.skeleton();
        self.skin();
        for (kind, field, defs) in [
            ("HAnimJoint", "joints", &self.bone_defs),
            ("HAnimSegment", "segments", &self.segment_defs),
            ("HAnimSite", "sites", &self.site_defs),
        ] {
            for def in defs {
                let markup = &mut self.markup;
                markup
                    .open(kind)
                    .set("USE", def)
                    .set("containerField", field);
                markup.close();
            }
        }
        self.markup.close();
    }

    /// Writes the joint tree, depth first.
    fn skeleton(&mut self) {
        let mut children = vec![Vec::new(); self.bones.list.len()];
        let mut steps = Vec::new();
        for (index, bone) in self.bones.list.iter().enumerate().rev() {
            match bone.parent {
                Some(parent) => children[parent].push(index),
                None => steps.push(Step::Open(index)),
            }
        }
        while let Some(step) = steps.pop() {
            match step {
                Step::Close => self.markup.close(),
                Step::Open(bone) => {
                    self.joint(bone);
                    let hangs = std::mem::take(&mut self.hangs[bone]);
                    hangs.pieces.iter().for_each(|piece| self.displacer(*piece));
                    hangs.bodies.iter().for_each(|body| self.segment(*body));
                    hangs.sites.iter().for_each(|site| self.site(bone, *site));
                    steps.push(Step::Close);
                    steps.extend(children[bone].iter().map(|child| Step::Open(*child)));
                }
            }
        }
    }

    fn joint(&mut self, index: usize) {
        let bone = &self.bones.list[index];
        let markup = &mut self.markup;
        markup.open("HAnimJoint").set("DEF", &self.bone_defs[index]);
        markup.set("name", &bone.name);
        describe(markup, &bone.name, &bone.given_name);
        markup.numbers("center", 3, bone.center.to_array());
        let (translation, rotation, scale) = bone.rest();
        if translation.length() > 1e-7 {
            markup.numbers("translation", 3, translation.to_array());
        }
        if rotation.angle_between(DQuat::IDENTITY) > 1e-7 {
            markup.numbers("rotation", 4, axis_angle(rotation));
        }
        if scale.distance(Vec3::ONE) > 1e-6 {
            markup.numbers("scale", 3, scale.to_array());
        }
        if bone.is_stretched {
            let orientation = axis_angle(bone.scale_orientation());
            markup.numbers("scaleOrientation", 4, orientation);
        }
        let weights = &self.weights[index];
        if !weights.is_empty() {
            let points = weights.iter().map(|(point, _)| *point as i64);
            markup.numbers("skinCoordIndex", 8, points);
            let weights = weights.iter().map(|(_, weight)| *weight);
            markup.numbers("skinCoordWeight", 8, weights);
        }
        if bone.parent.is_none() {
            markup.set("containerField", "skeleton");
        }
    }

    /// Writes one piece of a morph target.
    fn displacer(&mut self, [index, slot, piece]: [usize; 3]) {
        let body = &self.bodies[index];
        let mesh = &self.character.meshes[body.mesh];
        let (_, offsets) = &body.targets[slot].pieces[piece];
        let name = token(&mesh.morph_names[slot]);
        let markup = &mut self.markup;
        markup.open("HAnimDisplacer");
        markup.set("DEF", &self.displacer_defs[index][slot][piece]);
        if !name.is_empty() {
            markup.set("name", &name);
        }
        describe(markup, &name, &mesh.morph_names[slot]);
        let weight = mesh.morph_weights.get(slot).copied().unwrap_or(0.0);
        if weight != 0.0 {
            markup.numbers("weight", 1, [weight]);
        }
        let points = offsets.iter().map(|(point, _)| *point as i64);
        markup.numbers("coordIndex", 8, points);
        let offsets = offsets.iter().flat_map(|(_, offset)| offset.to_array());
        markup.numbers("displacements", 3, offsets);
        markup.close();
    }

    /// Writes a mesh that follows one bone alone.
    fn segment(&mut self, index: usize) {
        let given = &self.character.meshes[self.bodies[index].mesh].name;
        let name = self.names.give(given, "segment");
        let def = self.defs.give(&format!("hanim_{name}"), "segment");
        let coord = self.defs.give(&format!("{name}_points"), "points");
        let markup = &mut self.markup;
        markup
            .open("HAnimSegment")
            .set("DEF", &def)
            .set("name", &name);
        describe(markup, &name, given);
        self.segment_defs.push(def);
        for slot in 0..self.bodies[index].targets.len() {
            for piece in 0..self.bodies[index].targets[slot].pieces.len() {
                self.displacer([index, slot, piece]);
            }
        }
        let body = &self.bodies[index];
        points(&mut self.markup, &coord, "coord", [body]);
        self.shapes
            .write(&mut self.markup, &mut self.defs, body, &coord);
        self.markup.close();
    }

    fn site(&mut self, bone: usize, index: usize) {
        let site = &self.sites[index];
        let usual = format!("{}_tip", self.bones.list[bone].name);
        let name = self.names.give(&site.name, &usual);
        let def = self.defs.give(&format!("hanim_{name}"), "site");
        let place = self.bones.zero.matrices[site.joint].transform_point3(site.offset.as_dvec3());
        let markup = &mut self.markup;
        markup.open("HAnimSite").set("DEF", &def).set("name", &name);
        markup.numbers("translation", 3, place.as_vec3().to_array());
        markup.close();
        self.site_defs.push(def);
    }

    /// Writes the points of all skin, and each of its meshes as a group.
    fn skin(&mut self) {
        let skins = self.bodies.iter().filter(|b| b.bone.is_none());
        if skins.clone().all(|b| b.points.is_empty()) {
            return;
        }
        points(&mut self.markup, SKIN_POINTS, "skinCoord", skins);
        for body in self.bodies.iter().filter(|b| b.bone.is_none()) {
            let given = &self.character.meshes[body.mesh].name;
            let def = self.defs.give(given, "skin");
            let markup = &mut self.markup;
            markup
                .open("Group")
                .set("DEF", &def)
                .set("containerField", "skin");
            self.shapes.write(markup, &mut self.defs, body, SKIN_POINTS);
            self.markup.close();
        }
    }

    fn clips(&mut self) {
        let mut routes = Vec::new();
        for (index, clip) in self.character.clips.iter().enumerate() {
            let driven = Driven {
                character: self.character,
                bones: &self.bones,
                bodies: &self.bodies,
                bone_defs: &self.bone_defs,
                displacer_defs: &self.displacer_defs,
            };
            let own = tracks::write(&mut self.markup, &mut self.defs, &driven, clip, index == 0);
            routes.extend(own);
        }
        for route in routes {
            route.write(&mut self.markup);
        }
    }
}

fn points<'b>(
    markup: &mut Markup,
    def: &str,
    field: &str,
    bodies: impl IntoIterator<Item = &'b Body>,
) {
    let points = bodies.into_iter().flat_map(|b| b.points.iter());
    markup.open("Coordinate").set("DEF", def);
    markup.numbers("point", 3, points.flat_map(|p| p.to_array()));
    markup.set("containerField", field);
    markup.close();
}

/// Writes the original name of a node whose name had to be changed.
fn describe(markup: &mut Markup, name: &str, given: &str) {
    if name != given && !given.is_empty() {
        markup.set("description", given);
    }
}
