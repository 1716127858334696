//! What was saved, as text and JSON.

use crate::parts_table::parts_table;
use crate::table::{Table, counted, warnings};
use articula::optimize::{
    Fit, MeasuredOn, OptimizeReport, PlatformLimits, TextureContents, TextureOptimized,
};
use serde::Serialize;

/// One optimised file.
#[derive(Debug, Serialize)]
pub(super) struct OptimizedFile {
    #[serde(rename = "in")]
    pub(super) input: String,
    pub(super) out: String,
    /// The joints that may move, if they were chosen.
    pub(super) joints: Option<JointsHeld>,
    /// How it was made to fit into limits, if there are any.
    pub(super) fit: Option<Fit>,
    /// The platform whose limits are meant.
    pub(super) platform: Option<PlatformLimits>,
    #[serde(flatten)]
    pub(super) report: OptimizeReport,
    pub(super) warnings: Vec<String>,
}

/// The joints that keep their motion.
#[derive(Debug, Serialize)]
pub(super) struct JointsHeld {
    pub(super) selection: String,
    pub(super) joints: usize,
    pub(super) joints_active: usize,
}

/// Several files.
#[derive(Debug, Serialize)]
pub(super) struct Batch {
    pub(super) files: Vec<OptimizedFile>,
    /// Errors of files that could not be optimised.
    pub(super) failed: Vec<String>,
}

impl OptimizedFile {
    pub(super) fn text(&self) -> String {
        let report = &self.report;
        let mut text = format!("{}: {}\n", self.out, self.saved());
        text += &parts_table(&[("before", report.before), ("after", report.after)]).text();
        text += &self.limits();
        if let Some(held) = &self.joints {
            text += &format!(
                "{}: {} of {} joints move, the others are held\n",
                held.selection, held.joints_active, held.joints
            );
        }
        if let Some(merged) = &report.merged_joints {
            text += &format!(
                "joints of skins: {} -> {}; the others stand at rest, at an error of {:.3} mm beside those below\n",
                merged.joints_in, merged.joints_out, merged.error_mm
            );
        }
        text += &format!(
            "error in motion, measured on the file that was written: {:.3} mm of {:.3} mm allowed\n",
            report.error_mm, report.bound_mm
        );
        text += &measured_on(report.measured_on);
        if report.triangles_out < report.triangles_in {
            text += &format!(
                "triangles: {} -> {}; error of the surface {:.3} mm, of the vertices left {:.3} mm\n",
                report.triangles_in,
                report.triangles_out,
                report.surface_error_mm,
                report.vertex_error_mm
            );
        }
        if !report.clips.is_empty() {
            let mut clips = Table::new(&["clip", "channels", "keys", "error mm"]);
            for clip in &report.clips {
                clips.row([
                    clip.clip.clone(),
                    format!("{}/{}", clip.channels_out, clip.channels_in),
                    format!("{}/{}", clip.keys_out, clip.keys_in),
                    format!("{:.3}", clip.error_mm),
                ]);
            }
            text += &clips.text();
        }
        text += &textures(&report.textures);
        if report.keeps_arrays {
            text += "warning: an extension that is not known may refer to arrays, which stay as they are\n";
        }
        text + &warnings(&self.warnings)
    }

    /// The limits, and the error at which the file is within them.
    fn limits(&self) -> String {
        let mut text = String::new();
        if let Some(platform) = &self.platform {
            let PlatformLimits {
                name,
                about,
                source,
                seen,
                ..
            } = platform;
            text += &format!("{name}: {about} ({source}, {seen})\n");
        }
        let Some(fit) = &self.fit else {
            return text;
        };
        let limits = [
            (fit.limits.max_bytes, self.report.bytes_out, "bytes"),
            (
                fit.limits.max_triangles,
                self.report.triangles_out,
                "triangles",
            ),
            (
                fit.limits.max_textures_px,
                self.longest_px(),
                "pixels of a texture",
            ),
        ];
        for (max, found, what) in limits {
            if let Some(max) = max {
                text += &format!("{found} of {max} {what} allowed\n");
            }
        }
        text + &match fit.too_large_at_mm {
            None => format!(
                "it fits at the error that was asked for, {:.3} mm\n",
                fit.asked_mm
            ),
            Some(mm) => format!(
                "it fits at an error of {:.3} mm, not at {mm:.3} mm; asked for were {:.3} mm\n",
                fit.bound_mm, fit.asked_mm
            ),
        }
    }

    /// The longest side of all textures in pixels.
    fn longest_px(&self) -> usize {
        let sizes = self.report.textures.iter().filter_map(|t| t.size_out);
        let longest = sizes.flatten().max();
        longest.unwrap_or(0) as usize
    }

    /// The bytes before and after.
    fn saved(&self) -> String {
        let (before, after) = (self.report.bytes_in, self.report.bytes_out);
        if self.report.is_kept {
            return format!("{before} bytes, kept as it is: nothing worth an error could be saved");
        }
        let percent = 100.0 * after as f64 / before.max(1) as f64;
        format!("{before} -> {after} bytes ({percent:.1} %)")
    }
}

/// The pictures; those that stay as they are have one size and one type.
fn textures(all: &[TextureOptimized]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let arrow = |before: String, after: String| match before == after {
        true => after,
        false => format!("{before} -> {after}"),
    };
    let size = |size: Option<[u32; 2]>| size.map_or("-".to_owned(), |[w, h]| format!("{w} x {h}"));
    let kind = |of: &str| of.strip_prefix("image/").unwrap_or(of).to_owned();
    let mut table = Table::new(&["picture", "bytes", "format", "size", "difference"]);
    for t in all {
        let difference = match (t.holds, t.delta_e, t.levels) {
            (TextureContents::Numbers, _, Some(levels)) => format!("{levels} levels"),
            (_, Some(delta_e), _) => format!("{delta_e:.2} dE"),
            _ => "-".to_owned(),
        };
        table.row([
            format!("{} {}", t.picture, t.name).trim_end().to_owned(),
            arrow(t.bytes_in.to_string(), t.bytes_out.to_string()),
            arrow(kind(&t.type_in), kind(&t.type_out)),
            arrow(size(t.size_in), size(t.size_out)),
            difference,
        ]);
    }
    table.text()
}

impl Batch {
    pub(super) fn text(&self) -> String {
        let mut table = Table::new(&["file", "before", "after", "%", "error mm", "allowed"]);
        let (mut before, mut after) = (0, 0);
        for file in &self.files {
            let report = &file.report;
            let out = report.bytes_out;
            (before, after) = (before + report.bytes_in, after + out);
            table.row([
                file.out.clone(),
                report.bytes_in.to_string(),
                out.to_string(),
                format!("{:.1}", 100.0 * out as f64 / report.bytes_in.max(1) as f64),
                format!("{:.3}", report.error_mm),
                format!("{:.3}", report.bound_mm),
            ]);
        }
        let files = counted(self.files.len(), "file", "files");
        let mut text = format!("{files}: {before} -> {after} bytes\n{}", table.text());
        for file in &self.files {
            text += &warnings(&file.warnings);
        }
        text
    }
}

/// What was measured of a file without meshes.
fn measured_on(on: MeasuredOn) -> String {
    match on {
        MeasuredOn::Meshes => String::new(),
        MeasuredOn::Joints => {
            "the file has no mesh: the error is that of points around its joints; give --skin for that of a \
             character\n"
                .to_owned()
        }
        MeasuredOn::Skin {
            joints,
            joints_missing: 0,
        } => format!("the error is that of the skin, whose {joints} joints the file has\n"),
        MeasuredOn::Skin {
            joints,
            joints_missing,
        } => format!(
            "warning: the error is that of the skin, of whose {joints} joints the file lacks {joints_missing}: \
             they follow the joints above\n"
        ),
    }
}
