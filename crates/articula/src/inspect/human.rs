//! Humanoid data beyond joints and meshes: origin and licence, expressions, and features that are
//! preserved but not simulated.

use crate::open::CharacterFile;
use articula_core::source;
use serde::Serialize;

/// Humanoid data of a file; written as fields of [`Inspection`](super::Inspection).
#[derive(Debug, Serialize)]
pub struct HumanoidInspection {
    /// Version of the humanoid extension, such as `VRM 1.0`.
    pub format_version: Option<String>,
    /// Number of human bones that the file names; null if it names none.
    pub human_bones: Option<usize>,
    /// Origin and licence.
    pub credits: Option<CreditsInspection>,
    /// Named expressions.
    pub expressions: Vec<ExpressionInspection>,
    /// Features that are written back but have no effect here.
    pub kept: Vec<PassThroughItem>,
    /// Contents of the draft glTF extensions for characters.
    pub khr_character: Option<KhrCharacterInspection>,
}

/// Origin and licence, as stored in the file.
#[derive(Debug, Serialize)]
pub struct CreditsInspection {
    /// Title of the work.
    pub title: String,
    /// Version of the work.
    pub version: String,
    /// Names of the authors.
    pub authors: Vec<String>,
    /// Contact of the authors.
    pub contact: String,
    /// Copyright line.
    pub copyright: String,
    /// Works that it is based on.
    pub references: Vec<String>,
    /// Name of the licence.
    pub licence_name: String,
    /// URL of the licence.
    pub licence_url: String,
    /// Further terms of the licence.
    pub terms: Vec<Term>,
    /// Program that wrote the file.
    pub generator: String,
}

/// One term of a licence.
#[derive(Debug, Serialize)]
pub struct Term {
    /// Name of the term.
    pub name: String,
    /// Value of the term.
    pub value: String,
}

/// A named expression of the face or body.
#[derive(Debug, Serialize)]
pub struct ExpressionInspection {
    /// Name of the expression.
    pub name: String,
    /// Morph targets that it drives.
    pub morphs: Vec<MorphInspection>,
    /// Names of the joints that it moves.
    pub joints: Vec<String>,
    /// Whether it has only the states on and off.
    pub binary: bool,
    /// Other expressions that it reduces while it is active.
    pub masks: Vec<String>,
    /// Number of bindings to materials and textures, which are not applied.
    pub bindings_kept: usize,
}

/// A morph target that an expression drives.
#[derive(Debug, Serialize)]
pub struct MorphInspection {
    /// Name of the mesh.
    pub mesh: String,
    /// Name of the target, or its index.
    pub target: String,
    /// Weight at full strength.
    pub weight: f32,
}

/// A feature that is preserved but has no effect here.
#[derive(Debug, Serialize)]
pub struct PassThroughItem {
    /// Name of the feature.
    pub what: &'static str,
    /// Number of occurrences.
    pub count: usize,
}

/// Contents of the draft glTF extensions for characters.
#[derive(Debug, Serialize)]
pub struct KhrCharacterInspection {
    /// Rigs that the skeleton is mapped to.
    pub rigs: Vec<MappedRig>,
    /// Clips that contain a reference pose.
    pub reference_poses: Vec<ReferencePoseClip>,
    /// Names of the clips that define expressions.
    pub expression_clips: Vec<String>,
    /// Names of the expression sets that the file's expressions are mapped to.
    pub expression_sets: Vec<String>,
}

/// A rig that the skeleton is mapped to.
#[derive(Debug, Serialize)]
pub struct MappedRig {
    /// Name of the rig.
    pub name: String,
    /// Number of mapped joints.
    pub joints: usize,
}

/// A clip with a reference pose.
#[derive(Debug, Serialize)]
pub struct ReferencePoseClip {
    /// Name of the clip.
    pub clip: String,
    /// Kind of the pose.
    pub kind: String,
}

/// Summarises the humanoid data of a file.
pub(super) fn of(opened: &CharacterFile) -> HumanoidInspection {
    let behind = opened.gltf();
    let character = opened.character();
    let kept = behind.map_or(&[][..], |b| &b.kept);
    let expressions = character.expressions.iter();
    HumanoidInspection {
        format_version: behind.and_then(|b| b.version.clone()),
        human_bones: behind.and_then(|b| b.humanoid.as_ref()).map(Vec::len),
        credits: character.credits.as_ref().map(credits),
        expressions: expressions.map(|e| expression(character, e)).collect(),
        kept: kept
            .iter()
            .map(|k| PassThroughItem {
                what: k.what,
                count: k.count,
            })
            .collect(),
        khr_character: khr_character(opened),
    }
}

fn credits(found: &source::Credits) -> CreditsInspection {
    let term = |(name, value): &(String, String)| Term {
        name: name.clone(),
        value: value.clone(),
    };
    CreditsInspection {
        title: found.title.clone(),
        version: found.version.clone(),
        authors: found.authors.clone(),
        contact: found.contact.clone(),
        copyright: found.copyright.clone(),
        references: found.references.clone(),
        licence_name: found.licence_name.clone(),
        licence_url: found.licence_url.clone(),
        terms: found.terms.iter().map(term).collect(),
        generator: found.generator.clone(),
    }
}

fn expression(character: &source::Character, found: &source::Expression) -> ExpressionInspection {
    let morph = |m: &source::MorphBinding| {
        // Meshes may have been removed since the file was read.
        let mesh = character.meshes.get(m.mesh);
        let name = mesh.and_then(|mesh| mesh.morph_names.get(m.target));
        MorphInspection {
            mesh: mesh.map_or(String::new(), |mesh| mesh.name.clone()),
            target: match name.map_or("", |n| n.as_str()) {
                "" => format!("#{}", m.target),
                name => name.to_owned(),
            },
            weight: m.weight,
        }
    };
    let joint = |b: &source::JointBinding| character.skeleton.joints[b.joint].name.clone();
    let mask = |m: &source::Mask| character.expressions[m.target].name.clone();
    ExpressionInspection {
        name: found.name.clone(),
        morphs: found.morphs.iter().map(morph).collect(),
        joints: found.joints.iter().map(joint).collect(),
        binary: found.is_binary,
        masks: found.masks.iter().map(mask).collect(),
        bindings_kept: found.unapplied,
    }
}

fn khr_character(opened: &CharacterFile) -> Option<KhrCharacterInspection> {
    let found = opened.gltf()?.khr_character.as_ref()?;
    let clip = |index: usize| {
        let clip = opened.character().clips.get(index);
        clip.map_or(String::new(), |c| c.name.clone())
    };
    let rigs = found.rigs.iter().map(|r| MappedRig {
        name: r.rig.clone(),
        joints: r.joints.len(),
    });
    let poses = found.reference_poses.iter().map(|p| ReferencePoseClip {
        clip: clip(p.clip),
        kind: p.kind.clone(),
    });
    let sets = found.expression_sets.iter();
    Some(KhrCharacterInspection {
        rigs: rigs.collect(),
        reference_poses: poses.collect(),
        expression_clips: found
            .expression_clips
            .iter()
            .map(|(c, _)| clip(*c))
            .collect(),
        expression_sets: sets.map(|s| s.set.clone()).collect(),
    })
}
