//! The result of `inspect` as text tables.

use super::{access_units, face, human, joint_levels, mesh_levels, mp4};
use crate::fault::clean;
use crate::parts_table::parts_table;
use crate::table::Table;
use articula::inspect::{
    ClipInspection, DoubtfulJoint, Extent, Inspection, SkeletonInspection, WarningInspection,
};

/// Maximum number of rows of a table of clips or meshes, and of names in a list.
const MAX_ROWS: usize = 100;
const MAX_NAMES: usize = 24;
/// Maximum number of lines about doubtful joints.
const MAX_DOUBTS: usize = 12;

/// Formats all tables; with `map` every joint is listed.
pub(super) fn of(found: &Inspection, map: bool) -> String {
    let mut text = head(found);
    text.push_str(&parts(found));
    for skeleton in &found.skeletons {
        text.push_str(&skeleton_text(skeleton));
    }
    if let Some(face) = &found.face {
        text.push_str(&format!("\nface: {} morph targets\n", face.morphs));
        text.push_str(&face::drives(face));
    }
    text.push_str(&human::body(&found.human));
    section(&mut text, "clips", clips(found), found.clips.len());
    section(&mut text, "meshes", meshes(found), found.meshes.len());
    if let Some(levels) = &found.mesh_levels {
        let count = levels.levels.len();
        section(&mut text, "mesh levels", mesh_levels::table(levels), count);
        if !levels.regions.is_empty() {
            let names: Vec<String> = levels.regions.iter().map(|r| clean(r)).collect();
            text.push_str(&format!(
                "  separate levels possible for {} from level 0 to {}\n",
                names.join(", "),
                levels.mixable_to
            ));
        }
    }
    if let Some(layout) = &found.face_layout {
        text.push_str(&face::text(layout));
    }
    if let Some(stream) = &found.stream {
        text.push_str(&access_units::text(stream, "bones"));
    }
    text.push_str(&mp4::text(&found.tracks));
    if let Some(levels) = &found.joint_levels {
        text.push_str(&joint_levels::text(levels));
    }
    if map {
        text.push_str("\njoints\n");
        text.push_str(&joints(found).text());
    }
    for written in &found.written {
        text.push_str(&format!("\nwritten: {}\n", clean(written)));
    }
    text.push_str(&warnings_text(&found.warnings));
    text
}

/// The warnings, one line each.
pub(super) fn warnings_text(warnings: &[WarningInspection]) -> String {
    if warnings.is_empty() {
        return String::new();
    }
    let mut text = format!("\n{}\n", counted(warnings.len(), "warnings"));
    for w in warnings {
        text.push_str(&format!("  {}: {}\n", clean(&w.at), clean(&w.what)));
    }
    text
}

/// The first line: file, format, size and title.
pub(super) fn head_line(file: &str, format: &str, bytes: usize, name: &str) -> String {
    let mut text = format!("{}: {format}, {}", clean(file), size(bytes));
    if !name.is_empty() {
        text.push_str(&format!(", \"{}\"", clean(name)));
    }
    text.push('\n');
    text
}

fn head(found: &Inspection) -> String {
    let mut text = head_line(&found.file, found.format, found.bytes, &found.name);
    text.push_str(&human::head(&found.human));
    if let (Some(height), Some(bounds)) = (found.height_m, &found.bounds) {
        let what = if found.bounds_of_joints {
            "joints"
        } else {
            "skin"
        };
        text.push_str(&format!(
            "height at rest {height:.3} m ({what}, {})\n",
            corners(bounds)
        ));
    }
    let stored = if found.articulation_stored {
        "; levels and regions are stored in the file"
    } else {
        ""
    };
    text.push_str(&format!(
        "{}, {}{stored}\n",
        counted(found.materials, "materials"),
        counted(found.images, "images")
    ));
    text
}

/// Where the bytes are, and what a lighter file would save.
fn parts(found: &Inspection) -> String {
    let (stored, lighter) = (found.parts, found.optimized.as_ref());
    let stored = stored.map(|parts| ("stored", parts));
    let saved = lighter.map(|report| ("optimised", report.after));
    let columns: Vec<_> = stored.into_iter().chain(saved).collect();
    let mut text = String::new();
    if !columns.is_empty() {
        text = format!("\n{}", parts_table(&columns).text());
    }
    if let Some(report) = lighter {
        text += &format!(
            "`optimize` would write {} bytes of {}, with an error in motion of {:.3} mm\n",
            report.bytes_out, report.bytes_in, report.error_mm
        );
    }
    text
}

fn skeleton_text(skeleton: &SkeletonInspection) -> String {
    let profile = match skeleton.profile.as_str() {
        "" if skeleton.mapped > 0 => "as stored in the file".to_owned(),
        "" => "no joint map matches".to_owned(),
        name => format!("joint map {}", clean(name)),
    };
    let mut text = format!(
        "\nskeleton \"{}\": {} joints, {} mapped to H-Anim ({profile})\n",
        clean(&skeleton.root),
        skeleton.joints,
        skeleton.mapped
    );
    let levels: Vec<String> = skeleton.levels.iter().map(ToString::to_string).collect();
    text.push_str(&format!(
        "  joints up to level 0…5: {}\n",
        levels.join(" / ")
    ));
    let regions: Vec<String> = skeleton
        .regions
        .iter()
        .map(|(name, n)| format!("{name} {n}"))
        .collect();
    text.push_str(&format!("  regions: {}\n", regions.join(", ")));
    if skeleton.mapped > 0 && !skeleton.missing.is_empty() {
        text.push_str(&format!(
            "  joints of the standard missing in this rig: {}\n",
            list(skeleton.missing.iter().copied())
        ));
    }
    if !skeleton.unmapped.is_empty() {
        let names = skeleton.unmapped.iter().map(|u| u.joint.as_str());
        text.push_str(&format!(
            "  {} without a counterpart in the standard: {}\n",
            skeleton.unmapped.len(),
            list(names)
        ));
    }
    text.push_str(&doubtful(&skeleton.doubtful));
    text
}

/// The joints whose mapping is doubtful, one line each.
fn doubtful(joints: &[DoubtfulJoint]) -> String {
    if joints.is_empty() {
        return String::new();
    }
    let mut text = format!(
        "  {} (--write joint-map=F.json writes a joint map to edit)\n",
        counted(joints.len(), "doubts about joints")
    );
    for doubt in joints.iter().take(MAX_DOUBTS) {
        text.push_str(&format!(
            "    \"{}\" as {}, {} confidence: {}\n",
            clean(&doubt.joint),
            doubt.hanim,
            doubt.confidence,
            doubt.why
        ));
    }
    if joints.len() > MAX_DOUBTS {
        let more = joints.len() - MAX_DOUBTS;
        text.push_str(&format!("    … and {more} more (--json lists all)\n"));
    }
    text
}

fn clips(found: &Inspection) -> Table {
    let stored = |c: &ClipInspection| c.motion_tables.filter(|t| t.any());
    let any = found.clips.iter().any(|c| stored(c).is_some());
    let headings = [
        "name",
        "length",
        "fps",
        "frames",
        "joints moving",
        "joints keyed",
        "morphs moving",
        "keys",
        "height",
    ];
    let tables = any.then_some("segs / posekeys / stream");
    let face = found.clips.iter().any(|c| c.expressions_keyed > 0);
    let expressions = face.then_some("expressions");
    let headings = headings.into_iter().chain(expressions).chain(tables);
    let headings: Vec<&str> = headings.collect();
    let mut table = Table::new(&headings);
    for clip in found.clips.iter().take(MAX_ROWS) {
        let height = clip.bounds.map(|b| format!("{:.2} m", b.size().y));
        let mut cells = vec![
            clip.name.clone(),
            format!("{:.2} s", clip.duration_secs),
            trimmed(clip.fps),
            clip.frames.to_string(),
            clip.joints_animated.to_string(),
            clip.joints_keyed.to_string(),
            clip.morphs_animated.to_string(),
            clip.keys.to_string(),
            height.unwrap_or("-".into()),
        ];
        if face {
            cells.push(clip.expressions_keyed.to_string());
        }
        if any {
            let bytes =
                stored(clip).map(|t| format!("{} / {} / {} bytes", t.segs, t.posekeys, t.compact));
            cells.push(bytes.unwrap_or("-".into()));
        }
        table.row(cells);
    }
    table
}

fn meshes(found: &Inspection) -> Table {
    let any = found.meshes.iter().any(|m| !m.levels.is_empty());
    let headings = [
        "name",
        "vertices",
        "triangles",
        "influences",
        "morph targets",
    ];
    let levels = any.then_some("coarser levels: triangles (minimum screen coverage)");
    let headings: Vec<&str> = headings.into_iter().chain(levels).collect();
    let mut table = Table::new(&headings);
    for mesh in found.meshes.iter().take(MAX_ROWS) {
        let mut cells = vec![
            mesh.name.clone(),
            mesh.vertices.to_string(),
            shared(mesh.triangles, mesh.screen_coverage),
            mesh.influences_max.to_string(),
            mesh.morph_targets.to_string(),
        ];
        if any {
            let levels = mesh.levels.iter().take(MAX_NAMES);
            let levels: Vec<String> = levels
                .map(|level| shared(level.triangles, level.screen_coverage))
                .collect();
            cells.push(levels.join(", "));
        }
        table.row(cells);
    }
    table
}

/// Triangles, and the minimum screen coverage that they are made for.
fn shared(triangles: usize, screen_coverage: Option<f32>) -> String {
    match screen_coverage {
        Some(share) => format!("{triangles} ({share})"),
        None => triangles.to_string(),
    }
}

fn joints(found: &Inspection) -> Table {
    let mut table = Table::new(&["joint", "parent", "H-Anim", "level", "region"]);
    for joint in &found.map {
        let parent = joint.parent.map_or("", |p| found.map[p].name.as_str());
        let hanim = joint.hanim.clone().unwrap_or_else(|| {
            let why = if joint.in_skin { "-" } else { "(no joint)" };
            why.into()
        });
        table.row([
            joint.name.clone(),
            parent.to_owned(),
            hanim,
            joint.level.to_string(),
            joint.region.to_owned(),
        ]);
    }
    table
}

fn section(text: &mut String, what: &str, table: Table, count: usize) {
    if table.is_empty() {
        text.push_str(&format!("\nno {what}\n"));
        return;
    }
    text.push_str(&format!("\n{}\n", counted(count, what)));
    text.push_str(&table.text());
    if count > MAX_ROWS {
        text.push_str(&format!(
            "  … and {} more (--json lists all)\n",
            count - MAX_ROWS
        ));
    }
}

/// A count with its noun, which is given in the plural.
fn counted(count: usize, what: &str) -> String {
    let one = match what {
        "meshes" => "mesh",
        "doubts about joints" => "doubt about joints",
        other => other.trim_end_matches('s'),
    };
    format!("{count} {}", if count == 1 { one } else { what })
}

fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let named = |n: &'a str| {
        if n.is_empty() {
            "(no name)".into()
        } else {
            clean(n)
        }
    };
    let mut names: Vec<String> = names.map(named).collect();
    // In rigs without joint names the list would only repeat itself.
    names.dedup();
    let count = names.len();
    if count > MAX_NAMES {
        names.truncate(MAX_NAMES);
        names.push(format!("… and {} more", count - MAX_NAMES));
    }
    names.join(", ")
}

fn corners(extent: &Extent) -> String {
    let [x, y, z] = extent.min_m;
    let [u, v, w] = extent.max_m;
    format!("x {x:.2} … {u:.2}, y {y:.2} … {v:.2}, z {z:.2} … {w:.2}")
}

fn size(bytes: usize) -> String {
    match bytes {
        0..1_000 => format!("{bytes} bytes"),
        1_000..1_000_000 => format!("{:.1} kB", bytes as f64 / 1e3),
        _ => format!("{:.2} MB", bytes as f64 / 1e6),
    }
}

fn trimmed(value: f32) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}
