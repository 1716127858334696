//! `lod FILE --face F.fap`: the face of a character beside its body, under one error.

use super::LodArgs;
use crate::fault::{self, clean};
use crate::table::Table;
use crate::{files, open};
use articula::evaluate::MethodTable;
use articula::face::{FaceWithBody, face_with_body};
use articula::{Data, Figure};
use std::path::Path;

/// Chooses the parameters of the face at the distances of the body's rows.
pub(super) fn measured(
    args: &LodArgs,
    path: &Path,
    figure: &Figure,
    tables: &[MethodTable],
) -> anyhow::Result<FaceWithBody> {
    let name = files::shown(path);
    let [table] = tables else {
        let what = "a face is measured beside one method; name it with --method";
        return Err(fault::usage(format!("--face {name}: {what}")));
    };
    let Some(format) = open::data_format(path)?.filter(|f| f.has_faps()) else {
        let what = "expected a .fap, .afp or .fba file; convert writes captures as .fap";
        return Err(fault::usage(format!("--face {name}: {what}")));
    };
    let Data::Fap(clip) = open::face_motion(path, format, &args.character.names)?.data else {
        anyhow::bail!("{name}: {}", format.advice());
    };
    let body = table.rows.iter().map(|row| {
        let error = row.face_px.unwrap_or(row.error_px);
        [row.distance_m, error.worst_vertex]
    });
    let body: Vec<[f32; 2]> = body.collect();
    let tolerance_px = args.calibrate.unwrap_or(1.0);
    let viewport = args.view.viewport();
    Ok(face_with_body(
        &clip,
        &name,
        figure,
        &body,
        tolerance_px,
        viewport,
    )?)
}

/// Formats the face for people.
pub(super) fn text(face: &FaceWithBody) -> String {
    let confidence = match face.confidence {
        Some(confidence) => format!("feature points {:.0} % sure", 100.0 * confidence),
        None => "no feature points found".to_owned(),
    };
    let mut text = format!(
        "\nface {}: {} FAPs move, {confidence}; body and face together within {} px\n",
        clean(&face.file),
        face.moving,
        face.tolerance_px
    );
    let mut table = Table::new(&["distance", "body px", "FAPs", "face px", "both px"]);
    for row in &face.rows {
        let missed = if row.meets_target { "" } else { " !" };
        table.row([
            format!("{} m", row.distance_m),
            format!("{:.2}", row.body_px),
            row.parameters.len().to_string(),
            format!("{:.2}", row.face_px),
            format!("{:.2}{missed}", row.both_px),
        ]);
    }
    text.push_str(&table.text());
    if !face.not_driven.is_empty() {
        let faps = face.not_driven.iter();
        let faps: Vec<String> = faps.map(|n| format!("{} {}", n.fap, n.name)).collect();
        text.push_str(&format!("not driven: FAP {}\n", faps.join(", ")));
    }
    text
}
