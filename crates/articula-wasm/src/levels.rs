//! Levels of articulation of an opened character: which joints an expression or a profile selects.

use crate::asset::Asset;
use crate::error::{Fault, Result, index};
use articula::build::{moving_joints, whole_clip_size};
use articula::core::JointSet;
use articula::core::loa::LoaExpression;
use articula::formats::Limits;
use articula::formats::loa_profile;
use wasm_bindgen::prelude::*;

#[wasm_bindgen]
impl Asset {
    /// Joints that an expression selects, such as "loa(Low) + zone(hands) - joint(r_wrist)".
    ///
    /// Throws an error that names the column, or the joint that the file does not have.
    #[wasm_bindgen(js_name = jointsOfExpression)]
    pub fn joints_of_expression(&self, expression: &str) -> Result<Vec<u32>> {
        let parsed: LoaExpression = expression.parse().map_err(argument)?;
        let joints = parsed.joints(&self.figure().asset.rig);
        Ok(indices(&joints.map_err(argument)?))
    }

    /// Joints that a LoA profile selects: JSON with depth, complexity, H-Anim level, zones and joints, and how they
    /// combine (`docs/formats/loa-profile.md`).
    ///
    /// Throws an error that names the line or the member, or the joint that the file does not have.
    #[wasm_bindgen(js_name = jointsOfProfile)]
    pub fn joints_of_profile(&self, profile: &str) -> Result<Vec<u32>> {
        let read = loa_profile::read(profile.as_bytes(), &Limits::default());
        let read = read.map_err(|error| Fault::argument(format!("profile: {error}")))?;
        let joints = read.selection.joints(&self.figure().asset.rig);
        Ok(indices(&joints.map_err(argument)?))
    }

    /// Level of articulation of each joint, 0 (in all levels but none) to 5 (only in the finest).
    #[wasm_bindgen(getter, js_name = jointLevels)]
    pub fn joint_levels(&self) -> Vec<u8> {
        let joints = &self.figure().asset.rig.articulation().joints;
        joints.iter().map(|joint| joint.level).collect()
    }

    /// Name of the body region of each joint, as zones are named.
    #[wasm_bindgen(getter, js_name = jointRegions)]
    pub fn joint_regions(&self) -> Vec<String> {
        let joints = &self.figure().asset.rig.articulation().joints;
        joints.iter().map(|j| j.region.to_string()).collect()
    }

    /// Joints whose rotation a clip changes.
    ///
    /// Throws if there is no such clip.
    #[wasm_bindgen(js_name = clipJoints)]
    pub fn clip_joints(&self, clip: usize) -> Result<Vec<u32>> {
        let asset = &self.figure().asset;
        let clip = index("clip", clip, asset.clips.len())?;
        Ok(indices(&moving_joints(asset, &asset.clips[clip])))
    }

    /// Bytes of the key times and values of each clip of the file, as 32-bit floats.
    #[wasm_bindgen(getter, js_name = clipBytes)]
    pub fn clip_bytes(&self) -> Vec<u32> {
        let clips = self.figure().opened.character().clips.iter();
        clips
            .map(|clip| whole_clip_size(clip).bytes as u32)
            .collect()
    }
}

fn indices(joints: &JointSet) -> Vec<u32> {
    joints.iter().map(|joint| joint as u32).collect()
}

fn argument(error: impl std::fmt::Display) -> Fault {
    Fault::argument(error.to_string())
}
