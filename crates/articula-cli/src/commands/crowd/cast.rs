//! The characters of a crowd: files of the command line, or those that a scene file names.

use crate::arguments::{CharacterArgs, ReadArgs};
use crate::console::Console;
use crate::{fault, files, open};
use anyhow::Context;
use articula::core::Clip;
use articula::crowd::{
    CharacterEntry, CrowdAsset, CrowdOptions, CrowdPlayer, Culling, JointLodMethod, MAX_CHARACTERS,
    ParsedScene,
};
use articula::{CharacterFile, Figure};
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Triangles of a character from which on mesh levels are missed.
const MANY_TRIANGLES: usize = 1000;

/// Maximum size of a scene file in bytes.
const MAX_SCENE_BYTES: u64 = 512 << 20;

/// The characters of a crowd.
#[derive(Debug, Clone, Args)]
pub(super) struct CastArgs {
    /// Character files (.glb, .gltf, .vrm, .vrma, .fbx, .bvh, ...), if the scene file names none; a
    /// scene file calls them by their names without the ending
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Name of a mesh to leave out (repeatable)
    #[arg(long, value_name = "NAME")]
    hide: Vec<String>,
    /// Name of a mesh to keep, leaving out all others (repeatable)
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    #[command(flatten)]
    names: ReadArgs,
}

/// A character: its name in scene files, and its file.
#[derive(Debug, Clone)]
pub(super) struct CastFile {
    pub(super) name: String,
    pub(super) path: PathBuf,
}

/// A character that is prepared.
#[derive(Debug)]
pub(super) struct CastAsset {
    pub(super) file: CastFile,
    /// What the file holds: materials and textures, for pictures.
    pub(super) opened: CharacterFile,
    pub(super) asset: CrowdAsset,
    /// Time from opening the file to a first frame without preparation, milliseconds.
    pub(super) first_frame_ms: f64,
    pub(super) warnings: Vec<String>,
}

impl CastArgs {
    /// The characters of a run, by their files or by the scene file.
    pub(super) fn of(&self, scene: Option<&NamedScene>) -> anyhow::Result<Vec<CastFile>> {
        let named = scene.map_or(Vec::new(), NamedScene::characters);
        if named.is_empty() && self.files.is_empty() {
            let what = "no character: name a file, or a scene file that names its characters";
            return Err(fault::usage(what));
        }
        if !named.is_empty() && !self.files.is_empty() {
            let mend = "leave the files of the command line out";
            return Err(fault::usage(format!(
                "the scene file names its characters; {mend}"
            )));
        }
        if self.files.len() > MAX_CHARACTERS {
            let count = self.files.len();
            let what = format!("{count} different characters, at most {MAX_CHARACTERS}");
            return Err(fault::usage(what));
        }
        if !named.is_empty() {
            return Ok(named);
        }
        let mut cast: Vec<CastFile> = Vec::new();
        for path in &self.files {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let mut name = stem.clone().into_owned();
            let mut number = 2;
            while cast.iter().any(|c| c.name == name) {
                name = format!("{stem}-{number}");
                number += 1;
            }
            let path = path.clone();
            cast.push(CastFile { name, path });
        }
        Ok(cast)
    }

    /// The files that describe how the characters are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.names.inputs()
    }

    /// Opens and prepares a character; `options` is given its clips.
    pub(super) fn open(
        &self,
        file: CastFile,
        options: &dyn Fn(&[Clip]) -> anyhow::Result<CrowdOptions>,
        console: &Console,
    ) -> anyhow::Result<CastAsset> {
        let args = CharacterArgs {
            file: file.path.clone(),
            hide: self.hide.clone(),
            only: self.only.clone(),
            names: self.names.clone(),
        };
        let start = Instant::now();
        let figure = open::figure(&console.files, &args)?;
        let mut warnings = open::warnings(figure.opened.warnings());
        let options = options(&figure.asset.clips)?;
        let mut crowd = shown_at_once(&figure, &options)?;
        let first_frame_ms = start.elapsed().as_secs_f64() * 1e3;
        let asset = console.work(|work| CrowdAsset::new(&figure, &options, work))?;
        crowd.set_asset(&asset)?;
        warnings.extend_from_slice(asset.warnings());
        warnings.extend(missed_gains(&asset, &options));
        Ok(CastAsset {
            file,
            opened: figure.opened,
            asset,
            first_frame_ms,
            warnings,
        })
    }
}

/// A crowd of one that is shown before it is prepared.
fn shown_at_once(figure: &Figure, options: &CrowdOptions) -> anyhow::Result<CrowdPlayer> {
    let mut crowd = CrowdPlayer::new(&CrowdAsset::at_once(figure, options)?, 1)?;
    crowd.plan(0.0, Culling::Off, &mut |_| ());
    crowd.evaluate();
    Ok(crowd)
}

/// Why a character does not profit from what makes crowds cheap.
fn missed_gains(asset: &CrowdAsset, options: &CrowdOptions) -> Vec<String> {
    let mut found = Vec::new();
    let chooses = options.pose_cache && options.joints == JointLodMethod::Merged;
    let names: Vec<&str> = asset.uncached_clips().map(|c| c.name.as_str()).collect();
    if let Some(first) = names.first().filter(|_| chooses && asset.has_mesh()) {
        let others = match names.len() {
            1 => String::new(),
            count => format!(" and {} others", count - 1),
        };
        found.push(format!(
            "clip \"{first}\"{others}: all poses are evaluated, since the clip jumps between two frames or its poses exceed --cache-bytes {}",
            options.cache_bytes
        ));
    }
    let is_plain = options.mesh_levels.is_none() && !asset.has_mesh_lods();
    if chooses && is_plain && asset.full().mesh.triangles.len() > MANY_TRIANGLES {
        found.push(
            "every level draws all triangles, since the asset has no mesh levels; build it without --levels 1, or give --mesh-levels"
                .to_owned(),
        );
    }
    found
}

/// What scene files know of a cast. Each character has its file, relative to `folder`, if several are
/// played.
pub(super) fn members<'a>(
    cast: &'a [CastAsset],
    relative: &'a [Option<String>],
) -> Vec<CharacterEntry<'a>> {
    let each = cast.iter().zip(relative);
    let member = each.map(|(character, file)| CharacterEntry {
        name: &character.file.name,
        file: file.as_deref(),
        clips: character.asset.clips(),
    });
    member.collect()
}

/// The files of a cast as a scene file in a folder names them; none of a cast of one.
pub(super) fn relative(cast: &[CastAsset], scene: &Path) -> anyhow::Result<Vec<Option<String>>> {
    if let [_] = cast {
        return Ok(vec![None]);
    }
    let absolute = |path: &Path| std::path::absolute(path).with_context(|| files::shown(path));
    let folder = absolute(scene)?;
    let folder = folder.parent().unwrap_or(Path::new(""));
    let relative = cast.iter().map(|character| {
        let path = absolute(&character.file.path)?;
        let path = path.strip_prefix(folder).unwrap_or(&path);
        let text = path.to_str().context("the name of the file is not UTF-8");
        let text = text.with_context(|| files::shown(path))?;
        // Scene files use the separators of URLs on every system.
        Ok(Some(text.replace(std::path::MAIN_SEPARATOR, "/")))
    });
    relative.collect()
}

/// A scene file that was read.
#[derive(Debug)]
pub(super) struct NamedScene {
    path: PathBuf,
    pub(super) parsed: ParsedScene,
}

impl NamedScene {
    pub(super) fn read(path: &Path) -> anyhow::Result<Self> {
        let bytes = files::read(path, MAX_SCENE_BYTES)?;
        let parsed = ParsedScene::parse(&bytes)
            .map_err(|e| match e {
                // Not JSON, or not a scene; an error inside a scene is reported as it is.
                articula::Error::Read(e) => {
                    anyhow::anyhow!("{e}; --save-scene writes an example")
                }
                other => other.into(),
            })
            .with_context(|| files::shown(path))?;
        let path = path.to_owned();
        Ok(Self { path, parsed })
    }

    /// The characters that it names, with their files.
    fn characters(&self) -> Vec<CastFile> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let named = self.parsed.characters().map(|(name, file)| CastFile {
            name: name.to_owned(),
            path: folder.join(file),
        });
        named.collect()
    }
}
