//! What a file says of a human beyond joints and meshes: origin and licence, expressions, what is
//! kept but not simulated.

use crate::fault::clean;
use crate::table::{Table, counted};
use articula::Opened;
use articula_core::source;
use serde::Serialize;

/// Most rows of the table of expressions, and most names in a list.
const MOST_ROWS: usize = 100;
const MOST_NAMES: usize = 8;

/// What was found; these fields stand beside those of the other findings.
#[derive(Debug, Serialize)]
pub(super) struct Human {
    /// Format of the human extensions, such as `VRM 1.0`.
    format_version: Option<String>,
    /// Human bones that the file itself names; null if it names none.
    human_bones: Option<usize>,
    credits: Option<Credits>,
    expressions: Vec<Expression>,
    /// What is written again but changes nothing here.
    kept: Vec<Kept>,
    khr_character: Option<KhrCharacter>,
}

#[derive(Debug, Serialize)]
struct Credits {
    title: String,
    version: String,
    authors: Vec<String>,
    contact: String,
    copyright: String,
    references: Vec<String>,
    licence_name: String,
    licence_url: String,
    terms: Vec<Term>,
    generator: String,
}

#[derive(Debug, Serialize)]
struct Term {
    name: String,
    value: String,
}

#[derive(Debug, Serialize)]
struct Expression {
    name: String,
    morphs: Vec<Morph>,
    /// Joints that it turns or moves.
    joints: Vec<String>,
    binary: bool,
    /// Expressions that it weakens.
    masks: Vec<String>,
    /// Bindings to materials and textures, which are not applied.
    bindings_kept: usize,
}

#[derive(Debug, Serialize)]
struct Morph {
    mesh: String,
    target: String,
    weight: f32,
}

#[derive(Debug, Serialize)]
struct Kept {
    what: &'static str,
    count: usize,
}

#[derive(Debug, Serialize)]
struct KhrCharacter {
    rigs: Vec<Rig>,
    reference_poses: Vec<Pose>,
    /// Clips that are responses of expressions.
    expression_clips: Vec<String>,
    /// Sets of expressions that the own ones are mapped to.
    expression_sets: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Rig {
    name: String,
    joints: usize,
}

#[derive(Debug, Serialize)]
struct Pose {
    clip: String,
    kind: String,
}

/// Looks at a file.
pub(super) fn of(opened: &Opened) -> Human {
    let behind = opened.gltf.as_ref();
    let character = &opened.character;
    let kept = behind.map_or(&[][..], |b| &b.kept);
    let expressions = character.expressions.iter();
    Human {
        format_version: behind.and_then(|b| b.version.clone()),
        human_bones: behind.and_then(|b| b.humanoid.as_ref()).map(Vec::len),
        credits: character.credits.as_ref().map(credits),
        expressions: expressions.map(|e| expression(character, e)).collect(),
        kept: kept
            .iter()
            .map(|k| Kept {
                what: k.what,
                count: k.count,
            })
            .collect(),
        khr_character: khr_character(opened),
    }
}

fn credits(found: &source::Credits) -> Credits {
    let term = |(name, value): &(String, String)| Term {
        name: name.clone(),
        value: value.clone(),
    };
    Credits {
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

fn expression(character: &source::Character, found: &source::Expression) -> Expression {
    let morph = |m: &source::MorphBinding| {
        // Meshes may have been left out since the file was read.
        let mesh = character.meshes.get(m.mesh);
        let name = mesh.and_then(|mesh| mesh.morph_names.get(m.target));
        Morph {
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
    Expression {
        name: found.name.clone(),
        morphs: found.morphs.iter().map(morph).collect(),
        joints: found.joints.iter().map(joint).collect(),
        binary: found.is_binary,
        masks: found.masks.iter().map(mask).collect(),
        bindings_kept: found.unapplied,
    }
}

fn khr_character(opened: &Opened) -> Option<KhrCharacter> {
    let found = opened.gltf.as_ref()?.khr_character.as_ref()?;
    let clip = |index: usize| {
        let clip = opened.character.clips.get(index);
        clip.map_or(String::new(), |c| c.name.clone())
    };
    let rigs = found.rigs.iter().map(|r| Rig {
        name: r.rig.clone(),
        joints: r.joints.len(),
    });
    let poses = found.reference_poses.iter().map(|p| Pose {
        clip: clip(p.clip),
        kind: p.kind.clone(),
    });
    let sets = found.expression_sets.iter();
    Some(KhrCharacter {
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

impl Human {
    /// Format, origin and licence.
    pub(super) fn head(&self) -> String {
        let mut text = String::new();
        let version = self.format_version.as_deref().unwrap_or_default();
        let bones = match self.human_bones {
            Some(bones) => format!("{bones} human bones named by the file"),
            None => String::new(),
        };
        line(&mut text, "", &[version, &bones]);
        if let Some(found) = &self.credits {
            line(&mut text, "title: ", &[&found.title, &found.version]);
            line(&mut text, "by: ", &[&named(&found.authors), &found.contact]);
            line(&mut text, "copyright: ", &[&found.copyright]);
            line(
                &mut text,
                "licence: ",
                &[&found.licence_name, &found.licence_url],
            );
            let term = |t: &Term| format!("{} {}", t.name, t.value);
            let terms: Vec<String> = found.terms.iter().map(term).collect();
            line(&mut text, "terms: ", &[&terms.join("; ")]);
            line(&mut text, "after: ", &[&named(&found.references)]);
            line(&mut text, "written by: ", &[&found.generator]);
        }
        text
    }

    /// What the draft extensions say, expressions, and what is kept.
    pub(super) fn body(&self) -> String {
        let mut text = String::new();
        if let Some(khr) = &self.khr_character {
            let rig = |r: &Rig| format!("{} ({} joints)", r.name, r.joints);
            let rigs: Vec<String> = khr.rigs.iter().map(rig).collect();
            let pose = |p: &Pose| format!("{} (clip \"{}\")", p.kind, p.clip);
            let poses: Vec<String> = khr.reference_poses.iter().map(pose).collect();
            text.push('\n');
            line(&mut text, "skeleton mapped to: ", &[&named(&rigs)]);
            line(&mut text, "reference poses: ", &[&named(&poses)]);
            line(
                &mut text,
                "clips of expressions: ",
                &[&named(&khr.expression_clips)],
            );
            line(
                &mut text,
                "expressions mapped to: ",
                &[&named(&khr.expression_sets)],
            );
        }
        if !self.expressions.is_empty() {
            let count = counted(self.expressions.len(), "expression", "expressions");
            text.push_str(&format!("\n{count}\n"));
            text.push_str(&self.expressions_table().text());
            if let Some(more) = self
                .expressions
                .len()
                .checked_sub(MOST_ROWS)
                .filter(|m| *m > 0)
            {
                text.push_str(&format!("  … and {more} more (--json lists all)\n"));
            }
        }
        if !self.kept.is_empty() {
            text.push_str("\nkept, not simulated\n");
            for kept in &self.kept {
                text.push_str(&format!("  {}: {}\n", kept.what, kept.count));
            }
        }
        text
    }

    fn expressions_table(&self) -> Table {
        let headings = [
            "name",
            "morph targets",
            "joints",
            "binary",
            "weakens",
            "kept",
        ];
        let mut table = Table::new(&headings);
        for e in self.expressions.iter().take(MOST_ROWS) {
            let morph = |m: &Morph| match m.weight {
                1.0 => m.target.clone(),
                weight => format!("{} {:.0}%", m.target, 100.0 * weight),
            };
            let morphs: Vec<String> = e.morphs.iter().map(morph).collect();
            let kept = match e.bindings_kept {
                0 => "-".to_owned(),
                count => format!("{count} to materials"),
            };
            table.row([
                e.name.clone(),
                or_dash(named(&morphs)),
                or_dash(named(&e.joints)),
                if e.binary { "yes" } else { "-" }.to_owned(),
                or_dash(named(&e.masks)),
                kept,
            ]);
        }
        table
    }
}

/// A line of what is not empty, nothing if all is.
fn line(text: &mut String, start: &str, parts: &[&str]) {
    let parts: Vec<String> = parts
        .iter()
        .filter(|p| !p.is_empty())
        .map(|p| clean(p))
        .collect();
    if !parts.is_empty() {
        text.push_str(&format!("{start}{}\n", parts.join(", ")));
    }
}

fn named(names: &[String]) -> String {
    let mut list: Vec<&str> = names.iter().map(String::as_str).take(MOST_NAMES).collect();
    let more = format!("… and {} more", names.len().saturating_sub(MOST_NAMES));
    if names.len() > MOST_NAMES {
        list.push(&more);
    }
    list.join(", ")
}

fn or_dash(text: String) -> String {
    if text.is_empty() {
        "-".to_owned()
    } else {
        text
    }
}
