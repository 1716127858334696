//! What a shader reads of impostors beside the atlas, as bytes.

use super::plan::ImpostorPlan;

/// Little-endian buffers of a plan, the same in every frame (`docs/formats/impostor.md`).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImpostorBuffers {
    /// Corner x, y in metres, width, height in pixels, metres of a pixel, as f32; columns of the
    /// atlas, directions, rows, as u32: 32 bytes.
    pub cells: Vec<u8>,
    /// Centre of each pose, four f32: x, y, z and 0.
    pub centres: Vec<u8>,
    /// Of each row, four f32: least pitch of the eyes, pitch, both in radians, lean, number of yaws.
    pub rows: Vec<u8>,
}

impl ImpostorBuffers {
    /// Copies the numbers of a plan.
    pub fn new(plan: &ImpostorPlan) -> Self {
        let floats =
            |numbers: &[f32]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
        let cell = &plan.cell;
        let [width, height] = cell.size_px.map(|px| px as f32);
        let [x, y] = cell.corner_m;
        let mut cells = floats(&[x, y, width, height, cell.metres_per_px]);
        for count in [plan.columns(), plan.views.len(), plan.views.rows.len()] {
            cells.extend((count as u32).to_le_bytes());
        }
        let centres = plan.clips.iter().flat_map(|c| &c.centres);
        let rows = plan.views.rows.iter();
        Self {
            cells,
            centres: centres
                .flat_map(|c| floats(&[c.x, c.y, c.z, 0.0]))
                .collect(),
            rows: rows
                .flat_map(|r| floats(&[r.from_radians, r.pitch_radians, r.lean, r.yaws as f32]))
                .collect(),
        }
    }
}
