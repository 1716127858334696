//! Where the character is posed: its joints, its meshes as received, and motions of its face.

use crate::error::{Context, Error, Result};
use crate::face::fit_face;
use crate::item::assemble::assemble;
use crate::item::decoded_mesh::decoded;
use crate::item::files::Item;
use crate::item::part::PartKind;
use crate::item::shown::ShownFigure;
use crate::open::{CharacterFile, OpenOptions};
use articula_build::{ClipOptions, sampled_clip};
use articula_core::source::{Character, RawMesh};
use articula_core::{Clip, Mesh, Rig};
use articula_formats::gltf::placeholder;
use articula_formats::mpeg4::fap::FapClip;
use articula_stream::StreamLimits;
use articula_stream::mesh::Receiver;
use std::collections::BTreeMap;

/// The character of an item without its streams.
pub(super) struct Stage {
    figure: Character,
    rig: Rig,
    /// The whole character, if the item has motions of the face, and its mesh.
    face: Option<(CharacterFile, Mesh)>,
}

/// A region of a primitive, with its first vertex and its number of vertices in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct ObjectOf {
    mesh: usize,
    primitive: usize,
    region: u32,
}

/// Meshes in the form that is skinned.
pub(super) struct StagedMesh {
    pub(super) mesh: Mesh,
    /// The vertices of each object that its triangles use, counted from its first one, which comes with
    /// them.
    objects: BTreeMap<ObjectOf, (u32, Vec<u32>)>,
}

impl StagedMesh {
    /// Pairs of a vertex of this mesh and the same one of a finer one: vertices of a level are the first
    /// of each finer one.
    pub(super) fn pairs(&self, finer: &Self) -> Vec<[u32; 2]> {
        let mut pairs = Vec::new();
        for (object, (first, used)) in &self.objects {
            if let Some((of_finer, _)) = finer.objects.get(object) {
                pairs.extend(used.iter().map(|v| [first + v, of_finer + v]));
            }
        }
        pairs
    }
}

impl Stage {
    /// Reads the figure of an item.
    pub(super) fn of(item: &Item) -> Result<Self> {
        let options = OpenOptions::default();
        let manifest = &item.manifest;
        let file = &manifest.figure.file;
        let missing = || Error::unsuited("the item lacks this file");
        let glb = item.file(file).ok_or_else(missing).context(file)?;
        let ShownFigure { character, rig, .. } = ShownFigure::read(glb, manifest, &options)?;
        let parts = &item.manifest.parts;
        let has_faces = parts.iter().any(|part| part.kind == PartKind::FaceMotion);
        let face = match has_faces {
            true => {
                let whole = assemble(item, &options)?;
                let mesh = Mesh::new(&whole.character().meshes, rig.len())?;
                Some((whole, mesh))
            }
            false => None,
        };
        Ok(Self {
            figure: character,
            rig,
            face,
        })
    }

    pub(super) fn rig(&self) -> &Rig {
        &self.rig
    }

    /// A motion of the face as a clip of this character.
    pub(super) fn face(&self, motion: &FapClip) -> Result<Clip> {
        let Some((whole, mesh)) = &self.face else {
            return Err(Error::unsuited("the item has no motion of a face"));
        };
        let fitted = fit_face(motion, &motion.name, whole)?.fitted;
        let character = whole.character();
        Ok(sampled_clip(
            character,
            &fitted.clip,
            mesh,
            &ClipOptions::default(),
        )?)
    }

    /// The meshes that receivers have, each at the finest level that is there.
    pub(super) fn mesh<'a>(
        &self,
        receivers: impl Iterator<Item = &'a Receiver>,
    ) -> Result<StagedMesh> {
        let source = &self.figure.meshes;
        let mut primitives = BTreeMap::new();
        let mut shown = Vec::new();
        for receiver in receivers {
            let made = decoded(receiver, source, &StreamLimits::default())?;
            primitives.extend(made.primitives);
            shown.extend(made.objects);
        }
        let whole = |m: usize, mesh: &RawMesh| RawMesh {
            primitives: (0..mesh.primitives.len())
                .map(|p| {
                    let there = primitives.get(&(m, p)).cloned();
                    there.unwrap_or_else(|| placeholder(&mesh.primitives[p]))
                })
                .collect(),
            levels: Vec::new(),
            clustered: Vec::new(),
            ..mesh.clone()
        };
        let meshes: Vec<RawMesh> = source
            .iter()
            .enumerate()
            .map(|(m, r)| whole(m, r))
            .collect();
        let mesh = Mesh::new(&meshes, self.rig.len())?;
        let mut objects = BTreeMap::new();
        for object in &shown {
            let of_mesh = mesh.parts.iter().filter(|part| part.mesh == object.mesh);
            let Some(part) = of_mesh.clone().nth(object.primitive) else {
                continue;
            };
            let finest = object.at_level(object.finest).flatten();
            let mut used: Vec<u32> = finest.map(|v| v - object.first_vertex).collect();
            used.sort_unstable();
            used.dedup();
            let key = ObjectOf {
                mesh: object.mesh,
                primitive: object.primitive,
                region: object.region,
            };
            let first = part.vertices.start as u32 + object.first_vertex;
            objects.insert(key, (first, used));
        }
        Ok(StagedMesh { mesh, objects })
    }
}
