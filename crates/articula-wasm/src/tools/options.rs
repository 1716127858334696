//! Options of long operations, from JSON.

use crate::error::{Fault, Result};
use articula::convert::{AddClipsOptions, ConvertOptions};
use articula::flat::flatten::{Profile, Quality, Settings};
use articula::flat::vector::player::PlayerOutput;
use articula::flatten::{
    LEAST_TRIANGLES, LEAST_TRIANGLES_OF_PLAYER, Shot, TriangleCount, shown_clip,
};
use articula::item::PackageOptions;
use articula::{Figure, MeshLevelOptions, PrepareOptions};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Most mesh levels that may be asked for.
const MOST_LEVELS: usize = 16;

/// Reads options; none are the default.
pub(super) fn read<T: DeserializeOwned + Default>(json: Option<&str>) -> Result<T> {
    match json {
        None | Some("") => Ok(T::default()),
        Some(json) => {
            serde_json::from_str(json).map_err(|error| Fault::argument(format!("options: {error}")))
        }
    }
}

fn mesh_levels(count: usize) -> Result<usize> {
    if (1..=MOST_LEVELS).contains(&count) {
        return Ok(count);
    }
    let what = format!("options: meshLevels must be 1 to {MOST_LEVELS}, found {count}");
    Err(Fault::argument(what))
}

/// Options of `prepare`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Prepare {
    mesh_levels: Option<usize>,
}

impl Prepare {
    pub(super) fn options(self) -> Result<PrepareOptions> {
        let levels = self.mesh_levels.map(mesh_levels).transpose()?;
        Ok(PrepareOptions {
            mesh_levels: levels.map(MeshLevelOptions::levels),
            ..PrepareOptions::default()
        })
    }
}

/// Options of `convert`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct Convert {
    clip: Option<String>,
}

impl Convert {
    pub(super) fn options(self) -> ConvertOptions {
        ConvertOptions {
            clip: self.clip,
            ..ConvertOptions::default()
        }
    }
}

/// Options of `addClips`.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "camelCase")]
pub(super) struct AddClips {
    clip: Option<String>,
    keep_own: Option<bool>,
    prefix: String,
}

impl AddClips {
    pub(super) fn options(self) -> AddClipsOptions {
        let usual = AddClipsOptions::default();
        AddClipsOptions {
            clip: self.clip,
            keep_own: self.keep_own.unwrap_or(usual.keep_own),
            prefix: self.prefix,
            ..usual
        }
    }
}

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
}

impl Flatten {
    /// The clip and its camera.
    pub(super) fn shot(&self, figure: &Figure) -> articula::Result<Shot> {
        let least = match self.form {
            Form::Player => LEAST_TRIANGLES_OF_PLAYER,
            Form::Svg | Form::Lottie => LEAST_TRIANGLES,
        };
        Ok(Shot {
            clip: match self.clip.as_deref() {
                Some(name) => figure.clip(Some(name))?,
                None => shown_clip(figure),
            },
            yaw_deg: self.yaw_deg,
            triangles: match self.triangles {
                Some(count) => TriangleCount::About(count),
                None => TriangleCount::Judged { least },
            },
            ..Shot::default()
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
