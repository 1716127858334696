//! Contact sheets and plots of evaluated methods, drawn by `articula_report`.

use super::motion_plots::{CostBy, cost_plot};
use articula::core::{ModelPose, local_to_model};
use articula::evaluate::{Cost, Costs, EvaluatedClip, MethodRow, MethodTable};
use articula::flat::{Appearance, Picture, PictureError};
use articula::{Figure, facing};
use articula_report::{Artist, MotionLine, Plot, Series, motion_sheet};

/// Width and height of a tile of a separate contact sheet, pixels.
pub(crate) const LARGE: (u32, u32) = (200, 290);

/// An artist that draws pictures of this size in pixels.
pub(crate) fn artist(figure: &Figure, size: (u32, u32)) -> Artist<'_> {
    let character = figure.opened.character();
    let (look, _) = Appearance::new(&character.materials, &character.images);
    let asset = &figure.asset;
    let mut rest = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
    let facing = facing(&asset.rig, &rest);
    Artist::new(&asset.rig, &asset.mesh, look, facing, size)
}

/// One line of a contact sheet for each distance of a table.
pub(crate) fn lines_by_distance(table: &MethodTable) -> Vec<MotionLine<'_>> {
    let line = |row: &MethodRow| line(table, format!("{} m", row.distance_m), row);
    table.rows.iter().map(line).collect()
}

/// One line of a contact sheet for each method, all at the same distance.
pub(crate) fn lines_by_method(tables: &[MethodTable], distance: usize) -> Vec<MotionLine<'_>> {
    let rows = tables
        .iter()
        .filter_map(|t| Some((t, t.rows.get(distance)?)));
    rows.map(|(t, row)| line(t, t.method.label(), row))
        .collect()
}

fn line<'a>(table: &'a MethodTable, label: String, row: &MethodRow) -> MotionLine<'a> {
    MotionLine {
        label,
        method: &table.method.method,
        parameter: row.parameter,
        distance_m: row.distance_m,
    }
}

/// A contact sheet of three frames at the size of a page.
pub(crate) fn small_sheet(
    scene: &EvaluatedClip<'_>,
    lines: &[MotionLine<'_>],
    title: &str,
) -> Result<Picture, PictureError> {
    let mut artist = artist(scene.figure, (144, 206));
    motion_sheet(&scene.stage(), &mut artist, lines, 3, title, Vec::new())
}

/// A value of every row over distance; `skin-px` is drawn solid, the baselines dashed.
pub(crate) fn series(tables: &[MethodTable], value: impl Fn(&MethodRow) -> f32) -> Vec<Series> {
    let point = |r: &MethodRow| (f64::from(r.distance_m), f64::from(value(r)));
    let line = |table: &MethodTable| Series {
        name: table.method.label(),
        points: table.rows.iter().map(point).collect(),
        dashed: table.method.method.name() != "skin-px",
    };
    tables.iter().map(line).collect()
}

/// Costs by zone, depth and level of complexity.
pub(crate) fn cost_plots(costs: &Costs, heading: &str) -> Vec<Plot> {
    let plot = |(by, costs): (CostBy, &Vec<Cost>)| {
        let names: Vec<String> = costs.iter().map(|c| c.name.clone()).collect();
        let all = |of: fn(&Cost) -> f32| costs.iter().map(|c| f64::from(of(c))).collect();
        let values = [
            all(|c| c.joints as f32),
            all(|c| c.joints_sampled),
            all(|c| c.fk_joints),
        ];
        cost_plot(by, &names, values, heading)
    };
    [
        (CostBy::Zone, &costs.zones),
        (CostBy::Depth, &costs.depths),
        (CostBy::Complexity, &costs.complexities),
    ]
    .map(plot)
    .into()
}
