//! Pictures of a face with each of its morph targets, and at moments of a clip.

use crate::artist::{appearance, facing_radians};
use crate::shape_sheet::{FaceShape, shape_sheet};
use articula::core::{Wrap, sample, sample_morphs};
use articula::face::{HeadSurface, face_layout};
use articula::flat::{Bounds, Picture, PictureError};
use articula::{Error, Figure};
use glam::Vec3;
use std::path::Path;

/// Draws the face of a figure with each of its morph targets; those of one name in several meshes move
/// together. `None` if it has none.
///
/// # Errors
/// As [`clip_sheet`].
pub fn morph_target_sheet(figure: &Figure) -> articula::Result<Option<Picture>> {
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
        return Ok(None);
    }
    drawn(figure, &shapes, "morph targets").map(Some)
}

/// Draws the face of a figure at so many moments of a clip, evenly over its duration, or at each of its
/// frames if they are fewer.
///
/// # Errors
/// [`Error::Unsupported`] if no vertex has a finite position, or a picture error if the page would be too
/// large.
///
/// # Panics
/// If the figure has no such clip.
pub fn clip_sheet(figure: &Figure, clip: usize, most: usize) -> articula::Result<Picture> {
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
fn drawn(figure: &Figure, shapes: &[FaceShape], what: &str) -> articula::Result<Picture> {
    let bounds = framed(figure);
    let bounds = bounds.ok_or_else(|| {
        let what = "no vertex has a finite position";
        Error::Unsupported(what.to_owned())
    })?;
    let file = Path::new(figure.opened.name());
    let file = file.file_name().unwrap_or(file.as_os_str());
    let title = format!("{what} of {}", file.display());
    let sheet: Result<Picture, PictureError> = shape_sheet(
        (&figure.asset.rig, &figure.asset.mesh),
        &appearance(figure),
        (&bounds, facing_radians(figure)),
        shapes,
        &title,
    );
    Ok(sheet?)
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
