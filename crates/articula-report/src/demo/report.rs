//! The results of the demo: `report.json`, and the numbers of the page.

use super::adaptation::Adapted;
use super::crowd::Crowd;
use super::face::Face;
use super::mesh_levels::MeshLevels;
use articula::Figure;
use articula::convert::{AnimationSize, hold_joints};
use articula::core::joint_state::PassivePolicy;
use articula::core::loa;
use articula::core::source;
use articula::core::{Complexity, Rig};
use articula::evaluate::{Costs, MethodRow, MethodTable};
use articula::flatten::FlattenReport;
use serde::Serialize;

/// Index of the distance in pictures of all methods: 9.05 m.
pub(super) const MIDDLE: usize = 2;

/// All results of one run of the demo.
#[derive(Debug, Serialize)]
pub struct DemoReport {
    pub(super) version: &'static str,
    pub(super) page: String,
    pub(super) character: Character,
    pub(super) clip: String,
    pub(super) target_px: f32,
    pub(super) joints_moving: usize,
    pub(super) frames: usize,
    /// Every method at every distance, on one clip.
    pub(super) methods: Vec<MethodRows>,
    /// `skin-px` on every clip.
    pub(super) clips: Vec<ClipRows>,
    /// The stored animation at each level of articulation.
    pub(super) levels: Vec<Level>,
    pub(super) costs: Costs,
    pub(super) crowd: Crowd,
    pub(super) mesh_levels: MeshLevels,
    /// The walk as 2D content, the thesis' form first.
    pub flat: Vec<FlattenReport>,
    /// The face moved by facial animation parameters; `None` for a character whose face cannot be.
    pub(super) face: Option<Face>,
    /// One item in four contexts.
    pub(super) adaptation: Adapted,
}

/// The character.
#[derive(Debug, Serialize)]
pub(super) struct Character {
    /// File name, or what it is.
    pub(super) name: String,
    pub(super) joints: usize,
    pub(super) triangles: usize,
    pub(super) vertices: usize,
    pub(super) bytes: usize,
}

/// One method over distance.
#[derive(Debug, Serialize)]
pub(super) struct MethodRows {
    pub(super) label: String,
    pub(super) rows: Vec<MethodRow>,
}

/// One clip over distance.
#[derive(Debug, Serialize)]
pub(super) struct ClipRows {
    pub(super) clip: String,
    pub(super) rows: Vec<MethodRow>,
}

/// One level of articulation of all clips, with passive joints in their key pose.
#[derive(Debug, Serialize)]
pub(super) struct Level {
    pub(super) name: String,
    pub(super) joints: usize,
    pub(super) stored: AnimationSize,
    /// Saved fraction of the animation's bytes, 0 to 1.
    pub(super) saved: f64,
}

impl Character {
    /// What the page says of a figure.
    pub(super) fn new(name: String, figure: &Figure) -> Self {
        let asset = &figure.asset;
        Self {
            name,
            joints: asset.rig.skin_joints().len(),
            triangles: asset.mesh.triangles.len(),
            vertices: asset.mesh.len(),
            bytes: figure.opened.bytes(),
        }
    }
}

impl MethodRows {
    pub(super) fn new(table: &MethodTable) -> Self {
        Self {
            label: table.method.label(),
            rows: table.rows.clone(),
        }
    }
}

impl Level {
    /// The stored animation of some clips at a level.
    pub(super) fn new(level: Complexity, rig: &Rig, clips: &[source::RawClip]) -> Self {
        let active = loa::complexity(rig, level);
        let held = hold_joints(rig, clips, &active, PassivePolicy::KeyPose);
        Self {
            name: level.to_string(),
            joints: active.intersection(rig.skin_joints()).len(),
            stored: held.after,
            saved: held.saved(),
        }
    }
}

impl DemoReport {
    /// The row of a method at the distance shown in pictures of all methods.
    pub(super) fn middle(&self, label: &str) -> Option<&MethodRow> {
        let method = self.methods.iter().find(|m| m.label == label)?;
        method.rows.get(MIDDLE)
    }

    /// Formats the headline for people, and the path of the page.
    pub fn text(&self) -> String {
        let mut text = String::new();
        if let (Some(ours), Some(thesis)) = (self.middle("skin-px hold"), self.middle("thesis")) {
            text = format!(
                "clip {} at {} m within {} px: {:.0}% of the joint updates saved (thesis metric: {:.0}%)\n",
                self.clip,
                ours.distance_m,
                self.target_px,
                100.0 * ours.joint_update_gain,
                100.0 * thesis.joint_update_gain
            );
        }
        text.push_str(&format!("{}\n", self.page));
        text
    }
}
