//! The procedural human in front of a camera, for tests.

use super::bake::{BakeOptions, Lighting, Turntable};
use super::subject::PlanarSubject;
use crate::appearance::Appearance;
use crate::frame::{Bounds, orbit_view};
use crate::projection::Projection;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_core::Viewport;
use articula_human::{HumanOptions, human};
use glam::Vec3;
use std::sync::OnceLock;

/// A small human, and a camera that sees all of it in 200 x 200 pixels.
#[derive(Clone)]
pub(crate) struct Figure {
    pub(crate) asset: Asset,
    pub(crate) appearance: Appearance,
    pub(crate) options: BakeOptions,
}

impl Figure {
    /// The whole human, at rest.
    pub(crate) fn subject(&self) -> PlanarSubject<'_> {
        let mesh = &self.asset.mesh;
        PlanarSubject {
            rig: &self.asset.rig,
            mesh,
            triangles: &mesh.triangles,
            appearance: &self.appearance,
            clip: None,
            morph_weights: &mesh.morph_weights,
        }
    }
}

/// A figure of the caller's own; the human is created once, because its body takes seconds.
pub(crate) fn figure() -> Figure {
    static FIGURE: OnceLock<Figure> = OnceLock::new();
    FIGURE.get_or_init(made).clone()
}

fn made() -> Figure {
    let source = human(&HumanOptions::mannequin(2000)).unwrap();
    let (appearance, _) = Appearance::new(&source.materials, &source.images);
    let asset = character(&source, None, &ClipOptions::default()).unwrap();
    let bounds = Bounds {
        low: Vec3::new(-0.9, 0.0, -0.5),
        high: Vec3::new(0.9, 2.0, 0.5),
    };
    let viewport = Viewport {
        width_px: 200.0,
        height_px: 200.0,
        ..Viewport::default()
    };
    let options = BakeOptions {
        camera: orbit_view(&bounds, 0.0, 0.0, viewport),
        projection: Projection::Perspective,
        lighting: Lighting::default(),
        fps: 25.0,
        turn: Turntable::default(),
    };
    Figure {
        asset,
        appearance,
        options,
    }
}
