//! The report of `flatten` for people, and what the file lacks.

use crate::fault::clean;
use articula::Figure;
use articula::flatten::{
    AlternativeMeshes, FACE_DELTA_E, FlatTexture, FlattenReport, LocalDifference, REST_DELTA_E,
};

/// Share of stray pixels, percent of the figure's, above which a file is warned about.
const STRAY_PERCENT: f64 = 0.02;

/// A line about what is shown of the motion, if it is not a clip as it is.
pub(super) fn motion(figure: &Figure, clip: Option<usize>, is_held: bool) -> String {
    match clip {
        Some(clip) if is_held => {
            let name = clean(&figure.asset.clips[clip].name);
            format!("clip \"{name}\" travels and is shown on the spot; --root travel shows its way\n")
        }
        Some(_) => String::new(),
        None => "rest pose: the file has no clip; `articula convert MOTION OUT.glb --onto FILE` adds one\n"
            .to_owned(),
    }
}

/// A line about the picture that triangles show, if there is one.
fn texture(report: &FlattenReport) -> String {
    let line = |texture: &FlatTexture| {
        format!(
            "texture: {} triangles show a picture of {} x {} px, {:.1} kB\n",
            texture.triangles,
            texture.size_px.0,
            texture.size_px.1,
            texture.bytes as f64 / 1e3,
        )
    };
    report.texture.as_ref().map(line).unwrap_or_default()
}

/// Formats the report for people.
pub(super) fn text(report: &FlattenReport) -> String {
    let FlattenReport { bytes, error, .. } = report;
    let mut text = format!(
        "{}: {}, {} x {} px, {} frames, {:.2} s\n\
             {:.1} kB ({:.1} gzip, {:.1} brotli): {:.2} bytes a triangle and frame ({:.2} brotli)\n\
             {} triangles, {} after cutting piercing ones; {} shapes, {} keys, {} painting orders\n",
        report.out,
        report.profile,
        report.size_px.0,
        report.size_px.1,
        report.frames,
        report.duration_secs,
        bytes.raw as f64 / 1e3,
        bytes.gzip as f64 / 1e3,
        bytes.brotli as f64 / 1e3,
        report.bytes_per_triangle_and_frame.raw,
        report.bytes_per_triangle_and_frame.brotli,
        report.triangles,
        report.triangles_drawn,
        report.shapes,
        report.keys,
        report.orders,
    );
    text.push_str(&texture(report));
    text.push_str(&format!(
            "error: position {:.2} px, colour {:.1} levels of 0 to 255 (max {:.1}), SSIM {:.4} (min {:.4}) at {} frames; \
             pixels painted in the wrong order {:.2} % (depth sort {:.2} %)\n",
            error.position_rmse_px,
            error.image_rmse_levels,
            error.image_rmse_levels_max,
            error.ssim,
            error.ssim_min,
            error.moments,
            error.wrong_pixels_percent,
            error.wrong_pixels_percent_depth_sort,
        ));
    if let Some(stray) = error.stray_pixels_percent {
        text.push_str(&format!(
            "pixels outside the silhouette or in a foreign colour, at 2x: {stray:.3} % (bound {STRAY_PERCENT})\n"
        ));
    }
    if let Some(local) = &error.local {
        let of = |name: &str, worst: &Option<LocalDifference>, bound: f64| {
            let worst = worst.as_ref()?;
            Some(format!("{name} {} (bound {bound})", difference(worst)))
        };
        let face = of("face", &local.face, FACE_DELTA_E);
        let rest = of("rest", &local.rest, REST_DELTA_E);
        let both: Vec<String> = face.into_iter().chain(rest).collect();
        text.push_str(&format!("largest local difference: {}\n", both.join("; ")));
    }
    if let Some(choice) = &report.triangle_choice {
        text.push_str(&format!(
            "triangle count chosen from {} tried: {}; weight of the face {}, of the hands {}\n",
            choice.tried.len(),
            choice.count.unwrap_or(report.triangles),
            choice.face_weight,
            choice.hands_weight,
        ));
    }
    if !report.tried.is_empty() {
        let s = &report.settings;
        let merge = s.merge_levels.map(|m| format!(", merged {m} levels"));
        text.push_str(&format!(
            "best of {} settings: {}, {} px, {} levels{}\n",
            report.tried.len(),
            s.shading,
            s.pos_tol_px,
            s.col_tol_levels,
            merge.unwrap_or_default(),
        ));
    }
    for warning in &report.warnings {
        text.push_str(&format!("warning: {warning}\n"));
    }
    text
}
/// Returns what the file lacks, each with what to change.
pub(crate) fn warnings(report: &FlattenReport) -> Vec<String> {
    let mut all = Vec::new();
    if let Some((over, most)) = report.bytes_over.zip(report.max_bytes) {
        all.push(format!(
            "the smallest file has {} bytes, {over} more than --max-bytes {most}; give fewer \
             --triangles, a lower --fps or --profile player",
            report.bytes.raw,
        ));
    }
    for detail in &report.dropped_detail {
        // More triangles have more colours, but a texture's edges lie within them.
        let mend = match (report.profile.as_str(), report.settings.shading) {
            ("player", "flat") => "leave out --shading flat, with which no texture is shown",
            ("player", _) => "leave out --texture none",
            _ => "--profile player shows textures, and --profile portrait those of a face",
        };
        all.push(format!(
            "texture detail of the {} was dropped (mesh {}): its colours differ by {}; {mend}",
            detail.worst.region,
            clean(&detail.mesh),
            difference(&detail.worst),
        ));
    }
    let stray = report.error.stray_pixels_percent;
    if let Some(stray) = stray.filter(|stray| *stray > STRAY_PERCENT) {
        all.push(format!(
            "{stray:.3} % of the figure's pixels lie outside its silhouette or have a foreign colour at \
             2x; give fewer --triangles, a lower --quality position-px or a larger --size"
        ));
    }
    // The form of the thesis is a baseline, not to be improved.
    let local = report.error.local.as_ref();
    let Some(local) = local.filter(|_| report.profile != "thesis") else {
        return all;
    };
    for (worst, bound) in [(&local.face, FACE_DELTA_E), (&local.rest, REST_DELTA_E)] {
        if let Some(worst) = worst.as_ref().filter(|worst| worst.delta_e > bound) {
            all.push(format!(
                "visible local difference from the character, {}: {}; give more --triangles, a lower \
                 --quality order-percent or --profile flipbook",
                worst.region,
                difference(worst),
            ));
        }
    }
    all
}

fn difference(worst: &LocalDifference) -> String {
    format!(
        "{:.1} CIELAB units at pixel ({}, {}) of frame {}",
        worst.delta_e, worst.x, worst.y, worst.frame
    )
}

/// Tells of meshes in one place, and how to show one of them.
pub(super) fn choice(choice: &AlternativeMeshes) -> String {
    let hide = choice
        .meshes
        .iter()
        .skip(1)
        .map(|name| format!("--hide {name:?}"));
    format!(
        "{} meshes are in one place on joint {:?} and may be for choice: show one alone, as by {}",
        choice.meshes.len(),
        choice.joint,
        hide.collect::<Vec<_>>().join(" "),
    )
}
