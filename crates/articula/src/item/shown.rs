//! The figure of an item with what is decoded of its parts, as a character.

use super::figure;
use super::manifest::Manifest;
use crate::clip_streams::abp2::raw_clip;
use crate::error::{Context, Result};
use crate::face::fit_face;
use crate::open::{CharacterFile, GltfSource, OpenOptions, open};
use articula_core::source::{Character, Primitive, RawClip};
use articula_core::{Articulation, Clip, Rig};
use articula_formats::gltf::MeshGeometry;
use articula_formats::mpeg4::fap::FapClip;
use std::collections::BTreeMap;

/// What is decoded of the parts of an item.
#[derive(Debug, Default)]
pub(super) struct Shown<'a> {
    /// Primitives by mesh and number.
    pub(super) primitives: BTreeMap<(usize, usize), Primitive>,
    /// Files of pictures by their index.
    pub(super) pictures: Vec<(usize, &'a [u8])>,
    /// Motions of the body.
    pub(super) clips: Vec<Clip>,
    /// Motions of the face with the names of their files.
    pub(super) faces: Vec<(&'a str, FapClip)>,
}

/// The figure of an item.
pub(super) struct ShownFigure {
    pub(super) character: Character,
    pub(super) rig: Rig,
    gltf: GltfSource,
    /// Name of its file.
    file: String,
    /// Name of the item.
    name: String,
}

impl ShownFigure {
    /// Reads the figure's file.
    pub(super) fn read(glb: &[u8], manifest: &Manifest, options: &OpenOptions) -> Result<Self> {
        let file = &manifest.figure.file;
        let (character, gltf) = figure::read(glb, &options.limits).context(file)?;
        let articulation = articulation(&character, &manifest.name, glb, options)?;
        Ok(Self {
            rig: Rig::new(&character.skeleton, articulation)?,
            character,
            gltf,
            file: file.clone(),
            name: manifest.name.clone(),
        })
    }

    /// The character. What is not shown stays as the figure has it: a mesh without triangles, a picture
    /// of one pixel.
    pub(super) fn with(
        mut self,
        shown: &Shown<'_>,
        options: &OpenOptions,
    ) -> Result<CharacterFile> {
        let (character, document) = (&self.character, &mut self.gltf.document);
        let parts = |m: usize| -> Vec<&Primitive> {
            let own = character.meshes[m].primitives.iter().enumerate();
            // A coarse level may have nothing of a primitive: it stays as it is in the figure.
            let shown = |p| {
                let made = shown.primitives.get(&(m, p));
                made.filter(|made| !made.triangles.is_empty())
            };
            own.map(|(p, own)| shown(p).unwrap_or(own)).collect()
        };
        let meshes = (0..character.meshes.len()).filter(|m| {
            let first = shown.primitives.range((*m, 0)..).next();
            first.is_some_and(|((mesh, _), _)| mesh == m)
        });
        let geometry: Vec<MeshGeometry<'_>> = meshes
            .map(|m| MeshGeometry {
                node: self.gltf.node_of_mesh[m],
                parts: parts(m),
            })
            .collect();
        document.set_geometry(&geometry).context(&self.file)?;
        document.set_pictures(&shown.pictures).context("textures")?;
        let clips = shown.clips.iter();
        let clips: Vec<RawClip> = clips
            .map(|clip| raw_clip(clip, &character.meshes))
            .collect();
        document
            .replace_clips(&clips, &self.gltf.node_of_joint, &self.gltf.node_of_mesh)
            .context(&self.file)?;
        let glb = document.write_glb().context(&self.file)?;
        let mut nothing = |_: &str| Err("a figure holds all its data".to_owned());
        let name = format!("{}.glb", self.name);
        let mut opened = open(&glb, &name, options, &mut nothing)?;
        let mut fitted = Vec::new();
        for (name, clip) in &shown.faces {
            fitted.push(fit_face(clip, name, &opened).context(*name)?.fitted);
        }
        if !fitted.is_empty() {
            opened.put_clips(fitted, true);
        }
        Ok(opened)
    }
}

/// Articulation of the figure, as stored or recognised by its joints.
fn articulation(
    character: &Character,
    name: &str,
    glb: &[u8],
    options: &OpenOptions,
) -> Result<Articulation> {
    if let Some(stored) = &character.articulation {
        return Ok(stored.clone());
    }
    let mut nothing = |_: &str| Err("a figure holds all its data".to_owned());
    let opened = open(glb, &format!("{name}.glb"), options, &mut nothing)?;
    Ok(opened.articulation())
}
