//! `lod talk.fap --onto HEAD`: a FAP clip at levels of articulation, over distance.

use super::LodArgs;
use crate::arguments::ReadArgs;
use crate::console::Console;
use crate::fault::{self, clean};
use crate::table::{Table, warnings};
use crate::{files, open};
use articula::convert::{AfpProfile, write_faps};
use articula::core::face_levels::FapRoles;
use articula::core::fap_table::FAP_COUNT;
use articula::face::{
    FACE_DISTANCES_M, FaceDetailOptions, FaceDetailReport, face_detail, reduce_face,
};
use articula::{Data, DataFormat, Figure};
use serde::Serialize;
use std::path::Path;

/// Flags of bodies, which do not apply to faces.
pub(super) const BODY_ALONE: [&str; 12] = [
    "face",
    "method",
    "loa",
    "loa_profile",
    "parameter",
    "camera_path",
    "schedule",
    "plot",
    "contact_sheet",
    "passive",
    "protect_contacts",
    "clip",
];

/// Report of a FAP clip on a head.
#[derive(Debug, Serialize)]
struct FaceLodReport {
    #[serde(flatten)]
    detail: FaceDetailReport,
    tolerance_px: f32,
    viewport_px: [f32; 2],
    fov_deg: f32,
    /// Files with the chosen parameters.
    written: Vec<String>,
    warnings: Vec<String>,
}

/// Measures the clip and prints the report.
pub(super) fn run(args: &LodArgs, head: &Path, console: &Console) -> anyhow::Result<()> {
    let path = &args.character.file;
    let name = files::shown(path);
    let has_faps = |path: &Path| files::data_format(path).filter(|f| f.has_faps());
    let Some(format) = open::data_format(path)?.filter(|f| f.has_faps()) else {
        return Err(fault::usage(format!(
            "{name}: --onto measures a .fap file or .afp stream on a head, or an .abp stream on its character; leave it out for the clip of a character"
        )));
    };
    args.check_distances()?;
    if let Some(out) = args.fap() {
        let out_name = files::shown(out);
        if has_faps(out).is_none() {
            let what = format!("--write fap={out_name}: name a .fap or .afp file");
            return Err(fault::usage(what));
        }
        if args.distances.len() != 1 {
            let what = format!(
                "--write fap={out_name}: give the distance that it is for, such as --distances 3.5"
            );
            return Err(fault::usage(what));
        }
    }
    let inputs = args.character.inputs().chain([head]);
    console.files.plan(inputs, args.fap())?;
    let names: &ReadArgs = &args.character.names;
    let read = open::data(path, format, names)?;
    let Data::Fap(clip) = read.data else {
        anyhow::bail!("{name}: {}", format.advice());
    };
    let mut opened = open::character(&console.files, head, names)?;
    opened.keep_meshes(&args.character.only, &args.character.hide)?;
    let figure = Figure::new(opened)?;
    let options = FaceDetailOptions {
        distances_m: args.distances_or(&FACE_DISTANCES_M).to_vec(),
        tolerance_px: args.calibrate.unwrap_or(1.0),
        viewport: args.view.viewport(),
    };
    let detail = console.work(|work| face_detail(&clip, &name, &figure, &options, work))?;
    let mut written = Vec::new();
    if let (Some(out), [row]) = (args.fap(), &detail.rows[..]) {
        let mut keeps = [false; FAP_COUNT];
        // Visemes and expressions count as the low-level parameters that they amount to.
        let high = [1, 2].into_iter().filter(|_| !row.chosen.is_empty());
        row.chosen
            .iter()
            .copied()
            .chain(high)
            .for_each(|fap| keeps[fap - 1] = true);
        let chosen = reduce_face(&clip, &FapRoles::keeping(&keeps));
        let format = has_faps(out).unwrap_or(DataFormat::Fap);
        let bytes = write_faps(&chosen, format, &AfpProfile::default())?.bytes;
        console.files.write(out, &bytes)?;
        written.push(files::shown(out));
    }
    let placed = |place: &str, warnings: Vec<String>| {
        let place = place.to_owned();
        let placed = warnings.into_iter().map(move |w| format!("{place}: {w}"));
        placed.collect::<Vec<String>>()
    };
    let mut warnings = placed(&name, open::warnings(&read.warnings));
    let of_head = open::warnings(figure.opened.warnings());
    warnings.extend(placed(figure.opened.name(), of_head));
    let report = FaceLodReport {
        tolerance_px: options.tolerance_px,
        viewport_px: [options.viewport.width_px, options.viewport.height_px],
        fov_deg: args.view.fov_deg,
        detail,
        written,
        warnings,
    };
    console.result(&report, FaceLodReport::text)
}

impl FaceLodReport {
    /// Formats the report for people.
    fn text(&self) -> String {
        let detail = &self.detail;
        let moving = detail.levels.first().map_or(0, |high| high.parameters);
        let mut text = format!(
            "{} on {}: {} frames at {} Hz, {moving} FAPs move; {} vertices, {} controls; {} x {} px, {} degrees\n\n",
            clean(&detail.file),
            clean(&detail.head),
            detail.frames,
            detail.rate_hz,
            detail.vertices,
            detail.controls,
            self.viewport_px[0],
            self.viewport_px[1],
            self.fov_deg,
        );
        let mut levels = Table::new(&["level", "FAPs", "max error mm"]);
        for level in &detail.levels {
            levels.row([
                level.level.to_owned(),
                level.parameters.to_string(),
                format!("{:.2}", level.error_mm),
            ]);
        }
        text.push_str(&levels.text());
        text.push_str(&format!(
            "\nmax error in px at each distance; coarsest levels of regions and least FAPs within {} px\n",
            self.tolerance_px
        ));
        let mut rows = Table::new(&[
            "distance",
            "medium px",
            "low px",
            "very low px",
            "regions FAPs",
            "regions px",
            "chosen FAPs",
            "chosen px",
        ]);
        for row in &detail.rows {
            let px = |px: f32| format!("{px:.2}");
            let mut cells = vec![format!("{} m", row.distance_m)];
            cells.extend(row.levels_px[1..].iter().map(|error| px(*error)));
            cells.extend([row.regions_parameters.to_string(), px(row.regions_px)]);
            cells.extend([row.chosen.len().to_string(), px(row.chosen_px)]);
            rows.row(cells);
        }
        text.push_str(&rows.text());
        text.push_str("\nlevels of regions\n");
        let regions: Vec<&str> = detail
            .rows
            .first()
            .map_or(Vec::new(), |row| row.regions.keys().copied().collect());
        let mut table = Table::new(&[&["distance"], &regions[..]].concat());
        for row in &detail.rows {
            let distance = format!("{} m", row.distance_m);
            let names = row.regions.values().map(|name| (*name).to_owned());
            table.row(std::iter::once(distance).chain(names));
        }
        text.push_str(&table.text());
        for path in &self.written {
            text.push_str(&format!("chosen FAPs: {}\n", clean(path)));
        }
        text.push_str(&warnings(&self.warnings));
        text
    }
}
