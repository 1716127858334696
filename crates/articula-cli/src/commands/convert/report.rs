//! The report of a conversion, for programs and for people.

use super::mesh;
use super::onto;
use super::plan::Job;
use super::reduction::Reduction;
use super::{capture, face_level, hygiene, joint_scheme, stream};
use crate::commands::face_shapes;
use crate::fault::{self, clean};
use crate::files;
use crate::table::{Table, counted};
use articula::clip_streams::abp2::TierReport;
use articula::convert::{ClipEdited, JointSchemeReport, LossyPart, TransferReport};
use articula::face::{CaptureReport, FaceLevelReport, FaceShapes, FaceTableTargets, FaceTransfer};
use articula::{ClipResampling, ShownLevelsReport};
use serde::Serialize;
use std::path::Path;

/// Maximum number of warnings that are printed.
const MAX_LINES: usize = 6;

/// One file that was written.
#[derive(Debug, Default, Serialize)]
pub(super) struct ConvertReport {
    #[serde(rename = "in")]
    pub(super) input: String,
    pub(super) out: String,
    pub(super) format_in: String,
    pub(super) format_out: &'static str,
    pub(super) bytes_in: usize,
    /// Bytes of all written files together.
    pub(super) bytes_out: usize,
    /// Files that were written in addition to `out`.
    pub(super) beside: Vec<String>,
    pub(super) clips: Vec<String>,
    pub(super) onto: Option<Onto>,
    /// Of a face clip that was turned into another format: what it holds, and what is lost.
    pub(super) capture: Option<CaptureReport>,
    /// Blend shapes that were made for the face, if any were asked for.
    pub(super) face_shapes: Option<FaceShapes>,
    /// Face animation table that was made for the face, if it was asked for.
    pub(super) face_table: Option<FaceTableTargets>,
    /// The level of articulation of a FAP file that was written, if one was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) face_level: Option<FaceLevelReport>,
    /// Joints that were merged and inserted, if a joint scheme was asked for.
    pub(super) joint_scheme: Option<JointSchemeReport>,
    /// Edits of each clip; empty if none were asked for.
    pub(super) edits: Vec<ClipEdited>,
    /// Distance of the frames of each written clip from the keys of its file.
    pub(super) resampling: Vec<ClipResampling>,
    pub(super) reduction: Option<Reduction>,
    /// The mesh levels that were written, if any were asked for.
    pub(super) mesh: Option<ShownLevelsReport>,
    /// The tiers of a motion stream that was written, finest first.
    pub(super) tiers: Vec<TierReport>,
    /// Pictures that were written.
    pub(super) written: Vec<String>,
    /// Content that the output format cannot hold.
    pub(super) left_out: Vec<String>,
    pub(super) warnings: Vec<String>,
    /// Motions that were not used, where several go into one file.
    pub(super) failed: Vec<Failure>,
}

/// The character that received the motions, and the result for each.
#[derive(Debug, Serialize)]
pub(super) struct Onto {
    pub(super) character: String,
    /// Number of its previous clips that it kept.
    pub(super) clips_kept: usize,
    /// One report for each file of body motions that was read.
    pub(super) motions: Vec<TransferReport>,
    /// One report for each FAP file that was read.
    pub(super) faces: Vec<FaceTransfer>,
}

/// A folder of files that were written.
#[derive(Debug, Serialize)]
pub(super) struct Batch {
    pub(super) out: String,
    pub(super) files: Vec<ConvertReport>,
    pub(super) failed: Vec<Failure>,
}

/// A file that was not converted.
#[derive(Debug, Serialize)]
pub(super) struct Failure {
    #[serde(rename = "in")]
    pub(super) input: String,
    pub(super) why: String,
}

impl Failure {
    /// The reason is `fault` without the file name in front of it.
    pub(super) fn new(path: &Path, fault: &anyhow::Error) -> Self {
        let input = files::shown(path);
        let why = fault::text(fault);
        let why = why.strip_prefix(&format!("{input}: ")).unwrap_or(&why);
        Self {
            why: clean(why),
            input,
        }
    }
}

/// Describes content that a format cannot hold; `format` is the name of the format.
pub(super) fn left_out(what: &LossyPart, format: &str) -> String {
    match what {
        LossyPart::Meshes(count) => {
            let why = match format {
                "bap" => "BAP holds one clip of a body",
                "bvh" => "BVH holds joints and one clip",
                "abp" | "abpt" | "mp4" => "ABP holds joints and one clip",
                _ => "ASF and AMC hold joints and one clip",
            };
            format!("{} ({why})", counted(*count, "mesh", "meshes"))
        }
        LossyPart::MeshLevels(count) => {
            let levels = counted(*count, "coarser mesh level", "coarser mesh levels");
            format!("{levels} (.{format} holds the finest; .glb holds all)")
        }
        LossyPart::EndSites(count) => {
            let sites = counted(*count, "end site", "end sites");
            format!("{sites} (GLB cannot store them)")
        }
        LossyPart::Clips(count) => {
            let dropped = counted(*count, "clip", "clips");
            format!("{dropped} (a .{format} file holds one; --clip NAME chooses)")
        }
        LossyPart::Rotations {
            joints,
            most,
            max_radians,
        } => format!(
            "rotations of {} by up to {:.1} degrees, largest at {most} (BAP has no parameter for them)",
            counted(*joints, "joint", "joints"),
            max_radians.to_degrees(),
        ),
        LossyPart::StillParameters(count) => {
            format!("{count} of the parameters in its masks (they stay neutral)")
        }
        LossyPart::JointNames(count) => {
            let names = counted(*count, "joint name", "joint names");
            format!("{names} (the joints have those of H-Anim, as .{format} holds no joint map)")
        }
        LossyPart::Note(note) => note.clone(),
        other => format!("{other:?}"),
    }
}

impl ConvertReport {
    /// Reports what was made for the face.
    pub(super) fn put_face(&mut self, made: &face_shapes::MadeFace) {
        self.face_shapes.clone_from(&made.shapes);
        self.face_table.clone_from(&made.table);
    }

    /// An empty report of a job.
    pub(super) fn new(job: &Job, input: String) -> Self {
        Self {
            input,
            out: files::shown(&job.out),
            format_out: job.format.name(),
            ..Self::default()
        }
    }

    /// Formats the report for people, with the map of the joints if `map` is set.
    pub(super) fn text(&self, map: bool) -> String {
        let mut text = format!(
            "{} ({}, {} bytes) -> {} ({}, {} bytes), {}\n",
            clean(&self.input),
            self.format_in,
            self.bytes_in,
            clean(&self.out),
            self.format_out,
            self.bytes_out,
            counted(self.clips.len(), "clip", "clips")
        );
        for beside in &self.beside {
            text.push_str(&format!("also written: {}\n", clean(beside)));
        }
        text.extend(self.face_level.iter().map(face_level::text));
        text.extend(self.onto.iter().map(|onto| onto.text(map)));
        text.extend(self.mesh.iter().map(mesh::text));
        text.extend(self.capture.iter().map(capture::text));
        text.extend(self.face_table.iter().map(face_shapes::table_text));
        text.extend(self.face_shapes.iter().map(face_shapes::text));
        text.extend(self.joint_scheme.iter().map(joint_scheme::text));
        text.extend(self.edits.iter().map(hygiene::text));
        text.extend(self.reduction.iter().map(Reduction::text));
        text.push_str(&stream::text(&self.tiers));
        text.push_str(&lines("picture", &self.written));
        text.push_str(&lines("left out", &self.left_out));
        text.push_str(&lines("warning", &self.warnings));
        text
    }
}

/// Lines of one kind; of many, the first ones and the number of the others.
fn lines(what: &str, all: &[String]) -> String {
    let mut text = String::new();
    for line in &all[..all.len().min(MAX_LINES)] {
        text.push_str(&format!("{what}: {}\n", clean(line)));
    }
    if all.len() > MAX_LINES {
        let more = all.len() - MAX_LINES;
        text.push_str(&format!("{what}: and {more} more (--json lists them)\n"));
    }
    text
}

impl Onto {
    fn text(&self, map: bool) -> String {
        let mut text = format!("onto {}", clean(&self.character));
        if self.clips_kept > 0 {
            let kept = counted(self.clips_kept, "clip", "clips");
            text.push_str(&format!(", which keeps {kept} of its own"));
        }
        text.push('\n');
        let mut table = Table::new(&onto::COLUMNS);
        for motion in &self.motions {
            for clip in &motion.clips {
                table.row(onto::row(motion, clip));
            }
        }
        if !table.is_empty() {
            text.push_str(&table.text());
        }
        let mut faces = Table::new(&onto::FACE_COLUMNS);
        for face in &self.faces {
            faces.row(onto::face_row(face));
        }
        if !faces.is_empty() {
            text.push_str(&faces.text());
        }
        let levels = self.faces.iter().filter_map(|face| face.level.as_ref());
        text.extend(levels.map(face_level::text));
        text.extend(self.faces.iter().map(onto::not_driven));
        let clips = self.motions.iter().flat_map(|motion| &motion.clips);
        text.extend(clips.map(onto::findings));
        let mut last: Option<&TransferReport> = None;
        for motion in &self.motions {
            if !map && last.is_none_or(|other| !onto::is_like(motion, other)) {
                text.push_str(&onto::joints_line(motion));
            }
            last = Some(motion);
        }
        if map {
            text.extend(self.motions.iter().map(onto::map));
        }
        text
    }
}

impl Batch {
    /// One line for each file; irregularities are counted, `--json` lists them.
    pub(super) fn text(&self, map: bool) -> String {
        let mut table = Table::new(&["file", "clips", "bytes", "saved", "left out", "warnings"]);
        for file in &self.files {
            let saved = file.reduction.as_ref().map(Reduction::percent);
            table.row([
                file.out.clone(),
                file.clips.len().to_string(),
                file.bytes_out.to_string(),
                saved.unwrap_or_else(|| "-".into()),
                file.left_out.len().to_string(),
                file.warnings.len().to_string(),
            ]);
        }
        let mut text = format!(
            "{}: {} written",
            clean(&self.out),
            counted(self.files.len(), "file", "files")
        );
        if !self.failed.is_empty() {
            text.push_str(&format!(", {} failed", self.failed.len()));
        }
        text.push('\n');
        if !table.is_empty() {
            text.push_str(&table.text());
        }
        let onto = self.files.iter().filter_map(|file| file.onto.as_ref());
        text.extend(onto.map(|onto| onto.text(map)));
        text
    }
}
