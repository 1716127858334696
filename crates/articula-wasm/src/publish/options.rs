//! Options of 2D output and packages.

use crate::error::Result;
use crate::long_options::mesh_levels;
use articula::Figure;
use articula::core::Viewport;
use articula::flat::flatten::{Profile, Quality, Settings};
use articula::flat::vector::player::PlayerOutput;
use articula::flatten::{
    LEAST_TRIANGLES, LEAST_TRIANGLES_OF_PLAYER, Shot, TriangleCount, shown_clip,
};
use articula::item::PackageOptions;
use serde::Deserialize;

/// Options of `package`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Package {
    mesh_levels: Option<usize>,
    clips: Vec<String>,
    flat: Option<bool>,
}

impl Package {
    pub(super) fn options(self) -> Result<PackageOptions> {
        let usual = PackageOptions::default();
        Ok(PackageOptions {
            mesh_levels: mesh_levels(self.mesh_levels.unwrap_or(usual.mesh_levels))?,
            clips: self.clips,
            flat: self.flat.unwrap_or(usual.flat),
            ..usual
        })
    }
}

/// Form of a moving picture.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Form {
    #[default]
    Svg,
    Player,
    Lottie,
}

/// Options of `flatten`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Flatten {
    form: Form,
    clip: Option<String>,
    yaw_deg: f32,
    triangles: Option<usize>,
    max_bytes: Option<u64>,
    camera: Option<Camera>,
}

/// A camera that stands where it is told to.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
struct Camera {
    eye: [f32; 3],
    target: [f32; 3],
    fov_deg: f32,
}

impl Flatten {
    /// Whether a clip that travels stays where it is: before a camera that stands where it is told to, it goes.
    pub(super) fn is_in_place(&self) -> bool {
        self.camera.is_none()
    }

    /// The clip and its camera.
    pub(super) fn shot(&self, figure: &Figure) -> articula::Result<Shot> {
        let least = match self.form {
            Form::Player => LEAST_TRIANGLES_OF_PLAYER,
            Form::Svg | Form::Lottie => LEAST_TRIANGLES,
        };
        let usual = Shot::default();
        let fov_deg = self.camera.map(|camera| camera.fov_deg);
        let fov = fov_deg.map_or(usual.viewport.fov_y_radians, f32::to_radians);
        Ok(Shot {
            seen_from: self.camera.map(|c| (c.eye.into(), c.target.into())),
            viewport: Viewport {
                fov_y_radians: fov.clamp(0.01, 3.0),
                ..usual.viewport
            },
            clip: match self.clip.as_deref() {
                Some(name) => figure.clip(Some(name))?,
                None => shown_clip(figure),
            },
            yaw_deg: self.yaw_deg,
            triangles: match self.triangles {
                Some(count) => TriangleCount::About(count),
                None => TriangleCount::Judged { least },
            },
            ..usual
        })
    }

    /// What is written, under a title.
    pub(super) fn settings(&self, name: &str) -> Settings {
        let profile = match self.form {
            Form::Svg => Profile::Smil,
            Form::Player => Profile::Player(PlayerOutput::Module),
            Form::Lottie => Profile::Lottie,
        };
        Settings {
            profile,
            quality: Quality::of(profile),
            name: name.to_owned(),
            max_bytes: self.max_bytes,
        }
    }
}
