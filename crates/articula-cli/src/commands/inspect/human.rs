//! Text output for the human-specific data of a file: origin, licence, expressions.

use crate::fault::clean;
use crate::table::{Table, counted};
use articula::inspect::{HumanoidInspection, MappedRig, MorphInspection, ReferencePoseClip, Term};

/// Maximum number of rows of the table of expressions, and of names in a list.
const MAX_ROWS: usize = 100;
const MAX_NAMES: usize = 8;

/// Format, origin and licence.
pub(super) fn head(found: &HumanoidInspection) -> String {
    let mut text = String::new();
    let version = found.format_version.as_deref().unwrap_or_default();
    let bones = match found.human_bones {
        Some(bones) => format!("{bones} human bones named by the file"),
        None => String::new(),
    };
    line(&mut text, "", &[version, &bones]);
    if let Some(credits) = &found.credits {
        line(&mut text, "title: ", &[&credits.title, &credits.version]);
        line(
            &mut text,
            "by: ",
            &[&named(&credits.authors), &credits.contact],
        );
        line(&mut text, "copyright: ", &[&credits.copyright]);
        line(
            &mut text,
            "licence: ",
            &[&credits.licence_name, &credits.licence_url],
        );
        let term = |t: &Term| format!("{} {}", t.name, t.value);
        let terms: Vec<String> = credits.terms.iter().map(term).collect();
        line(&mut text, "terms: ", &[&terms.join("; ")]);
        line(&mut text, "references: ", &[&named(&credits.references)]);
        line(&mut text, "generator: ", &[&credits.generator]);
    }
    text
}

/// Draft extensions, expressions, and data that is kept.
pub(super) fn body(found: &HumanoidInspection) -> String {
    let mut text = String::new();
    if let Some(khr) = &found.khr_character {
        let rig = |r: &MappedRig| format!("{} ({} joints)", r.name, r.joints);
        let rigs: Vec<String> = khr.rigs.iter().map(rig).collect();
        let pose = |p: &ReferencePoseClip| format!("{} (clip \"{}\")", p.kind, p.clip);
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
    if !found.expressions.is_empty() {
        let count = counted(found.expressions.len(), "expression", "expressions");
        text.push_str(&format!("\n{count}\n"));
        text.push_str(&expressions_table(found).text());
        if let Some(more) = found
            .expressions
            .len()
            .checked_sub(MAX_ROWS)
            .filter(|m| *m > 0)
        {
            text.push_str(&format!("  … and {more} more (--json lists all)\n"));
        }
    }
    if !found.kept.is_empty() {
        text.push_str("\nkept in the file, not simulated\n");
        for kept in &found.kept {
            text.push_str(&format!("  {}: {}\n", kept.what, kept.count));
        }
    }
    text
}

fn expressions_table(found: &HumanoidInspection) -> Table {
    let headings = [
        "name",
        "morph targets",
        "joints",
        "binary",
        "overrides",
        "also kept",
    ];
    let mut table = Table::new(&headings);
    for e in found.expressions.iter().take(MAX_ROWS) {
        let morph = |m: &MorphInspection| match m.weight {
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

/// A line of the parts that are not empty; nothing if all are.
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
    let mut list: Vec<&str> = names.iter().map(String::as_str).take(MAX_NAMES).collect();
    let more = format!("… and {} more", names.len().saturating_sub(MAX_NAMES));
    if names.len() > MAX_NAMES {
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
