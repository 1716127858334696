//! The page and the CSV file.

use super::Row;
use anyhow::Result;
use articula_flat::impostor::ImpostorTrial;
use std::fmt::Write as _;

const HEAD: &str = "# Impostors and far levels

Made by `cargo run --release -p articula-lab -- impostors`. Ways to show a far character with an error of at most one
pixel at a height on the screen: levels on the character's own rig with coarse meshes (*near*), levels on a rig of their own
(*far*), and impostors. *Evaluated*: palettes are computed and written in every frame. *Cached*: the nearest cached palette is
drawn as it is. *ns*: processor time of a frame (clocks, culling, choice, evaluation) for each of 2048 characters in view;
an impostor is listed as a cached pose is, and has its time. *Written*: bytes for each character and frame. *Resident*: bytes that
all characters share, cached palettes of the levels shown or pixels at four bytes each. *Error*: of level or impostor, the
maximum over those shown, without that of a cached pose. Far levels: the error is that of the joints alone, vertices are those of
the coarsest mesh level. *Level eyes*: impostors for eyes from 10 degrees below to 20 degrees above the horizon of a character; *all
eyes*: from anywhere. Rows of more than 64 MiB are left out.

Far levels are not played: a cached pose of a near level takes as few bytes and a tenth of the time of an evaluated far level, and
both have the same vertices; what a far level saves, matrices of cached palettes, is a small part of the memory. Impostors are
played where they are a few pixels high: there they replace hundreds of vertices by four for the same bytes and time, in a few
megabytes. Above about ten pixels they need tens of megabytes and more, for a motion of few clips, and do not pay.
";

pub(super) fn page(rows: &[Row], trials: &[(String, f32, ImpostorTrial)]) -> Result<String> {
    let mut page = String::from(HEAD);
    page.push_str(
        "
## At one pixel

| character | height, px | way | error, px | joints | ns | written | resident, kB | vertices | triangles |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
",
    );
    for row in rows {
        writeln!(
            page,
            "| {} | {} | {} | {:.2} | {} | {:.0} | {:.0} | {:.0} | {:.0} | {:.0} |",
            row.character,
            row.height_px,
            row.way,
            row.error_px,
            row.joints,
            row.ns,
            row.bytes,
            row.resident as f64 / 1e3,
            row.vertices,
            row.triangles
        )?;
    }
    page.push_str(
        "
## Error against bytes

The least bytes of impostors of all clips for an error, with directions, poses and size of a picture.

| character | error, % of the height | kB | directions | poses | px |
| --- | --- | --- | --- | --- | --- |
",
    );
    for (name, height_m, trial) in trials {
        writeln!(
            page,
            "| {name} | {:.0} | {:.0} | {} | {} | {} x {} |",
            1e2 * trial.error_m / height_m,
            trial.bytes as f64 / 1e3,
            trial.views,
            trial.poses,
            trial.size_px[0],
            trial.size_px[1]
        )?;
    }
    Ok(page)
}

pub(super) fn csv(rows: &[Row]) -> Result<String> {
    let mut csv = String::from(
        "character,height_px,way,error_px,joints,ns,written_bytes,resident_bytes,vertices,triangles\n",
    );
    for row in rows {
        writeln!(
            csv,
            "{},{},{},{:.3},{},{:.1},{:.1},{},{:.1},{:.1}",
            row.character,
            row.height_px,
            row.way,
            row.error_px,
            row.joints,
            row.ns,
            row.bytes,
            row.resident,
            row.vertices,
            row.triangles
        )?;
    }
    Ok(csv)
}
