//! Pictures of a face with each of its morph targets, and at moments of a clip.

use crate::fault;
use anyhow::Context;
use articula::core::{ModelPose, Wrap, local_to_model, sample, sample_morphs};
use articula::face::{HeadSurface, face_layout};
use articula::flat::{Appearance, Bounds, Picture};
use articula::{Figure, facing};
use articula_report::{FaceShape, shape_sheet};
use glam::Vec3;

/// Draws the morph targets of the figure; those of one name in several meshes move together.
pub(crate) fn targets(figure: &Figure) -> anyhow::Result<Picture> {
    let asset = &figure.asset;
    let rest = FaceShape {
        label: "at rest".to_owned(),
        pose: asset.rig.rest_pose().clone(),
        weights: vec![0.0; asset.mesh.morph_weights.len()],
    };
    let mut shapes = vec![rest.clone()];
    let meshes = &figure.opened.character().meshes;
    for (mesh, first) in meshes.iter().zip(&asset.mesh.morph_slots) {
        for (target, name) in mesh.morph_names.iter().enumerate() {
            let known = shapes[1..].iter().position(|shape| shape.label == *name);
            let index = known.map_or(shapes.len(), |index| index + 1);
            if index == shapes.len() {
                shapes.push(FaceShape {
                    label: name.clone(),
                    ..rest.clone()
                });
            }
            shapes[index].weights[first + target] = 1.0;
        }
    }
    if shapes.len() == 1 {
        let what = "--write shape-sheet: the file has no morph target to draw";
        return Err(fault::usage(what));
    }
    drawn(figure, &shapes, "morph targets")
}

/// Draws the face at so many moments of a clip, evenly over its duration.
pub(crate) fn moments(figure: &Figure, clip: usize, most: usize) -> anyhow::Result<Picture> {
    let asset = &figure.asset;
    let clip = &asset.clips[clip];
    let count = most.min(clip.frames().max(1));
    let moment = |index: usize| {
        let secs = f64::from(clip.duration_secs()) * index as f64 / (count.max(2) - 1) as f64;
        let mut shape = FaceShape {
            label: format!("{secs:.2} s"),
            pose: asset.rig.rest_pose().clone(),
            weights: asset.mesh.morph_weights.clone(),
        };
        sample(clip, secs, Wrap::Clamp, &asset.rig.all(), &mut shape.pose);
        sample_morphs(clip, secs, Wrap::Clamp, &mut shape.weights);
        shape
    };
    let shapes: Vec<FaceShape> = (0..count).map(moment).collect();
    drawn(figure, &shapes, &format!("clip \"{}\"", clip.name))
}

/// Draws the face in some shapes.
fn drawn(figure: &Figure, shapes: &[FaceShape], what: &str) -> anyhow::Result<Picture> {
    let asset = &figure.asset;
    let bounds = framed(figure).context("no vertex has a finite position")?;
    let character = figure.opened.character();
    let (look, _) = Appearance::new(&character.materials, &character.images);
    let title = format!("{what} of {}", figure.opened.name());
    let mut rest = ModelPose::new(asset.rig.len());
    local_to_model(&asset.rig, asset.rig.rest_pose(), &mut rest);
    let framed = (&bounds, facing(&asset.rig, &rest));
    Ok(shape_sheet(
        (&asset.rig, &asset.mesh),
        &look,
        framed,
        shapes,
        &title,
    )?)
}

/// The part of a figure that is drawn: its feature points but those on the skull, the part that blend
/// shapes move, or its head.
fn framed(figure: &Figure) -> Option<Bounds> {
    if let Ok(layout) = face_layout(figure, &[])
        && !layout.units.iter().any(|unit| unit.doubtful)
    {
        let points = layout.points.iter().filter(|p| p.point.0 != 11);
        let places = points.map(|p| Vec3::from(p.place_m));
        return Bounds::around(places.map(|p| (p, p)));
    }
    let head = HeadSurface::of(figure);
    let moved = head.surface.shapes.iter().flat_map(|(_, offsets)| {
        let moving = offsets
            .iter()
            .enumerate()
            .filter(|(_, o)| o.length() > 1e-3);
        moving.map(|(v, _)| v)
    });
    let place = |v: usize| head.model_from_head * head.surface.positions[v];
    let all = 0..head.surface.positions.len();
    let bounds = Bounds::around(moved.map(|v| (place(v), place(v))));
    bounds.or_else(|| Bounds::around(all.map(|v| (place(v), place(v)))))
}
