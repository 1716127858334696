//! Parts of scene files that say which characters there are and from where they are seen: the cast and
//! the views.
//!
//! The format is described in `docs/formats/scene.md`.

use crate::camera_path::{Key, checked, ensure};
use crate::error::{Context, Error, Result};
use crate::open::choose;
use articula_build::SceneView;
use articula_core::{Clip, Viewport};
use serde::{Deserialize, Serialize};

/// Maximum number of views of a scene.
pub const MAX_VIEWS: usize = 8;

/// Maximum number of different characters in a scene.
pub const MAX_CHARACTERS: usize = 256;

/// One of the different characters of a scene: what scene files call it, and its clips.
#[derive(Debug, Clone, Copy)]
pub struct CharacterEntry<'a> {
    /// Its name in scene files.
    pub name: &'a str,
    /// Its file as a scene file names it, relative to the folder of that; `None` to leave it out.
    pub file: Option<&'a str>,
    /// Its clips, in the order of the crowd's.
    pub clips: &'a [Clip],
}

/// A character of the cast as written in files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CastFile {
    pub(super) name: String,
    pub(super) file: String,
}

impl CastFile {
    /// The entry of a character; `None` without a file.
    pub(super) fn of(member: &CharacterEntry<'_>) -> Option<Self> {
        Some(Self {
            name: member.name.to_owned(),
            file: member.file?.to_owned(),
        })
    }
}

/// Checks that every character has a name of its own.
pub(super) fn check_cast(cast: &[CastFile]) -> Result<()> {
    ensure(cast.len() <= MAX_CHARACTERS, || {
        format!(
            "characters: {} entries; give at most {MAX_CHARACTERS}",
            cast.len()
        )
    })?;
    for (i, character) in cast.iter().enumerate() {
        let named = !character.name.is_empty() && !character.file.is_empty();
        ensure(named, || format!("characters[{i}]: give a name and a file"))?;
        let before = cast[..i].iter().position(|c| c.name == character.name);
        ensure(before.is_none(), || {
            format!("characters[{i}]: \"{}\" is named twice", character.name)
        })?;
    }
    Ok(())
}

/// Index of a member's character in a cast. It need not be named where there is only one.
pub(super) fn cast_of(name: Option<&str>, cast: &[CharacterEntry<'_>]) -> Result<usize> {
    if let (None, [_]) = (name, cast) {
        return Ok(0);
    }
    let names = || cast.iter().map(|c| c.name);
    let Some(name) = name else {
        let names: Vec<_> = names().map(|n| format!("\"{n}\"")).collect();
        let names = names.join(", ");
        return Err(Error::unsuited(format!("character: give one of {names}")));
    };
    // A wrong name in a file is not an argument error.
    choose("character", name, names()).map_err(|e| Error::unsuited(e.to_string()))
}

/// A view as written in files.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ViewFile {
    #[serde(default = "usual_viewport")]
    pub(super) viewport: [u32; 2],
    #[serde(default = "usual_fov_deg")]
    pub(super) fov_deg: f32,
    pub(super) camera: Vec<Key>,
    #[serde(default)]
    pub(super) camera_loops: bool,
}

pub(super) fn usual_viewport() -> [u32; 2] {
    [1920, 1080]
}

pub(super) fn usual_fov_deg() -> f32 {
    45.0
}

impl ViewFile {
    /// This view, whose fields stand in the scene itself, and the others.
    pub(super) fn with_others(&self, others: &[Self], display_hz: f64) -> Result<Vec<SceneView>> {
        let count = 1 + others.len();
        ensure(count <= MAX_VIEWS, || {
            let most = MAX_VIEWS - 1;
            format!("views: {} more; give at most {most}", count - 1)
        })?;
        let mut views = vec![self.read(display_hz)?];
        for (i, view) in others.iter().enumerate() {
            let read = view.read(display_hz);
            views.push(read.with_context(|| format!("views[{i}]"))?);
        }
        Ok(views)
    }

    fn read(&self, display_hz: f64) -> Result<SceneView> {
        let sides = self.viewport.iter().all(|s| (16..=16384).contains(s));
        ensure(sides, || {
            "viewport: give 16 to 16384 pixels per side".to_owned()
        })?;
        let opening = (1.0..=170.0).contains(&self.fov_deg);
        ensure(opening, || "fov_deg: give 1 to 170 degrees".to_owned())?;
        let camera = checked(&self.camera, display_hz).context("camera")?;
        let starts = camera[0].secs;
        ensure(starts == 0.0, || {
            format!("camera[0].t: {starts}; the path must begin at 0 s")
        })?;
        Ok(SceneView {
            viewport: Viewport {
                width_px: self.viewport[0] as f32,
                height_px: self.viewport[1] as f32,
                fov_y_radians: self.fov_deg.to_radians(),
            },
            camera,
            camera_loops: self.camera_loops,
        })
    }

    /// The entry of a view.
    pub(super) fn of(view: &SceneView) -> Self {
        Self {
            viewport: [
                view.viewport.width_px as u32,
                view.viewport.height_px as u32,
            ],
            fov_deg: view.viewport.fov_y_radians.to_degrees(),
            camera: view.camera.iter().map(Key::from).collect(),
            camera_loops: view.camera_loops,
        }
    }
}
