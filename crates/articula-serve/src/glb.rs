//! A character as one GLB, by a query like those of services for avatars.

use crate::answer::Answer;
use crate::catalogue::Catalogue;
use crate::cut::{LOA, Pairs, Wanted, clips, coarsest, elsewhere, pairs_of};
use crate::database::variants::GLB;
use crate::made::{NotMade, made, whole};
use crate::objects::{Coding, ObjectName, Objects};
use crate::query::{Parameters, Refusal, unknown_word};
use crate::reply::{CHANGING, stored};
use articula::build::face::arkit_name;
use articula::item::{Item, Manifest, PartKind, assemble, compressed};
use articula::optimize::{Compression, OptimizeOptions, TextureFormat, TextureOptions, optimize};
use articula::{CharacterFile, Error, Executor, Format, OpenOptions, convert, open};
use axum::http::HeaderMap;
use axum::response::{IntoResponse, Response};
use std::borrow::Cow;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Levels of detail: high, medium, low.
const LOD: RangeInclusive<u32> = 0..=2;
/// Longer sides of textures in pixels.
const TEXTURE_PX: RangeInclusive<u32> = 256..=1024;
/// Names of a level of detail with a size of textures, the finest first.
const QUALITIES: [&str; 3] = ["high", "medium", "low"];
/// Sides of a texture atlas in pixels.
const ATLAS_PX: RangeInclusive<u32> = 64..=4096;
/// How arrays are compressed, by the words of `articula optimize --compress`.
const COMPRESSIONS: [(&str, Compression); 3] = [
    ("ext", Compression::Ext),
    ("khr", Compression::Khr),
    ("quantize", Compression::Quantized),
];
/// Nothing of a kind.
const NONE: &str = "none";
/// The morph targets that have names of ARKit.
const ARKIT: &str = "ARKit";
/// The channel of textures that items have, and all that a query may name, as glTF calls them.
const BASE_COLOR: &str = "baseColor";
const CHANNELS: [&str; 6] = [
    NONE,
    BASE_COLOR,
    "emissive",
    "metallicRoughness",
    "normal",
    "occlusion",
];
/// The parameters of a query.
const PARAMETERS: [&str; 10] = [
    "clip",
    "compression",
    "loa",
    "lod",
    "mesh",
    "morphTargets",
    "quality",
    "textureAtlas",
    "textureChannels",
    "textureSizeLimit",
];

/// Answers with a character by the name of its file: its own with `.glb` behind it.
pub(crate) async fn answer(
    catalogue: &Catalogue,
    file: &str,
    pairs: Pairs,
    raw: Option<String>,
    request: &HeaderMap,
) -> Response {
    let answered = async {
        let served = whole(catalogue, file.strip_suffix(".glb").unwrap_or(file))?;
        let mut query = Parameters::new(pairs_of(pairs)?, &PARAMETERS)?;
        let wanted = WantedGlb::new(&mut query, &served.manifest)?;
        let canonical = query.canonical();
        if let Some(elsewhere) = elsewhere(raw, file, &canonical) {
            return Ok(elsewhere);
        }
        let open = catalogue.options().open.clone();
        let make = Box::new(move |item: &Item, objects: &_| wanted.stored(item, &open, objects));
        let name = made(catalogue, served, (GLB, &canonical), make).await?;
        let answer = Answer {
            name: &name,
            media_type: "model/gltf-binary",
            cache_control: CHANGING,
        };
        Ok(stored(catalogue, &answer, request).await)
    };
    answered.await.unwrap_or_else(NotMade::into_response)
}

/// What a GLB has.
#[derive(Debug)]
struct WantedGlb {
    cut: Wanted,
    is_still: bool,
    is_without_textures: bool,
    /// Longest side of one picture for the textures of all materials.
    atlas_px: Option<u32>,
    /// How arrays are rounded and compressed, if they are.
    compression: Option<Compression>,
    /// Names of morph targets, and groups of them; all without.
    morphs: Option<BTreeSet<String>>,
}

impl WantedGlb {
    fn new(query: &mut Parameters, of: &Manifest) -> Result<Self, Refusal> {
        let named = clips(of).into_iter().chain([NONE]).collect::<Vec<_>>();
        let clip = query.word("clip", &named)?;
        let words: Vec<&str> = COMPRESSIONS.iter().map(|(word, _)| *word).collect();
        let compression = query.word("compression", &[&words[..], &[NONE]].concat())?;
        let compression = compression.and_then(|word| {
            let known = COMPRESSIONS.into_iter().find(|(known, _)| *known == word);
            known.map(|(_, compression)| compression)
        });
        let loa = query.number("loa", LOA)?;
        let lod = query.number("lod", LOD)?;
        if lod.is_some() && query.has("mesh") {
            let what = "mesh: lod chooses the mesh level too; leave one of them out";
            return Err(Refusal(what.to_owned()));
        }
        let mesh = query.number("mesh", 0..=coarsest(of, "level"))?;
        let quality = query.word("quality", &QUALITIES)?;
        let quality =
            quality.and_then(|name| (0..).zip(QUALITIES).find(|(_, known)| *known == name));
        let quality = quality.map(|(lod, _)| lod);
        let morphs = query.words("morphTargets")?;
        if morphs.as_ref().is_some_and(is_mixed) {
            let what = "morphTargets: none stands alone; expected none, ARKit or names";
            return Err(Refusal(what.to_owned()));
        }
        let channels = query.words("textureChannels")?;
        if let Some(channels) = &channels {
            check_channels(channels)?;
        }
        let has_textures = channels.is_none_or(|channels| channels.contains(BASE_COLOR));
        let texture_px = query.number("textureSizeLimit", TEXTURE_PX)?;
        let atlas_px = query.number_or(NONE, "textureAtlas", ATLAS_PX)?;
        // What is asked for by itself counts.
        let lod = lod.or(quality);
        let is_still = clip.as_deref() == Some(NONE);
        Ok(Self {
            cut: Wanted {
                clip: clip.filter(|_| !is_still),
                loa,
                tier: None,
                mesh: mesh.or_else(|| Some(mesh_level(of, lod?))),
                texture_px: texture_px.or_else(|| Some(TEXTURE_PX.end() >> quality?)),
            },
            is_still,
            is_without_textures: !has_textures,
            atlas_px,
            compression,
            morphs,
        })
    }

    /// Makes the file and stores it.
    fn stored(
        &self,
        item: &Item,
        open: &OpenOptions,
        objects: &Objects,
    ) -> Result<ObjectName, NotMade> {
        let glb = self.written(item, open)?;
        let name = ObjectName::of(&glb);
        objects.put(&name, Coding::Identity, &glb)?;
        // Another query may have made the same.
        if objects.get(&name, Coding::Brotli)?.is_none()
            && let Some(short) = compressed("figure.glb", &glb)
        {
            objects.put(&name, Coding::Brotli, &short)?;
        }
        Ok(name)
    }

    fn written(&self, item: &Item, open: &OpenOptions) -> Result<Vec<u8>, NotMade> {
        let is_left_out = |kind| match kind {
            PartKind::BodyMotion | PartKind::FaceMotion => self.is_still,
            PartKind::Texture => self.is_without_textures,
            PartKind::Mesh => false,
        };
        let mut item = Cow::Borrowed(item);
        if item
            .manifest
            .parts
            .iter()
            .any(|part| is_left_out(part.kind))
        {
            let parts = &mut item.to_mut().manifest.parts;
            parts.retain(|part| !is_left_out(part.kind));
        }
        let adapted = self.cut.adapted(&item)?;
        let mut opened = assemble(&adapted, open)?;
        if let Some(morphs) = &self.morphs {
            keep_morphs(&mut opened, morphs)?;
        }
        if let Some(longest_px) = self.atlas_px {
            // A larger one has room.
            let refused = |e: Error| match e {
                Error::Unsupported(what) => NotMade::from(Refusal(format!("textureAtlas: {what}"))),
                other => NotMade::from(other),
            };
            opened.merge_textures(longest_px).map_err(refused)?;
        }
        let glb = convert::write(&opened, Format::Glb)?.bytes;
        match self.compression {
            Some(compression) => Ok(compact(glb, compression, open)?),
            None => Ok(glb),
        }
    }
}

/// The file with fewer keys and with rounded arrays in a compression, where that is smaller.
fn compact(
    glb: Vec<u8>,
    compression: Compression,
    options: &OpenOptions,
) -> Result<Vec<u8>, Error> {
    let beside = &mut |uri: &str| Err(format!("{uri}: not in the file"));
    let opened = open(&glb, "figure.glb", options, beside)?;
    let options = OptimizeOptions {
        compression,
        // Levels of the mesh and sizes of textures are chosen by other parameters.
        simplify: false,
        textures: TextureOptions {
            format: TextureFormat::Keep,
            ..TextureOptions::default()
        },
        ..OptimizeOptions::default()
    };
    let optimized = optimize(&opened, &options, &Executor::default())?;
    Ok(optimized.or_source(&glb).glb)
}

/// Whether a list says at once that there is nothing and something.
fn is_mixed(words: &BTreeSet<String>) -> bool {
    words.contains(NONE) && words.len() > 1
}

fn check_channels(wanted: &BTreeSet<String>) -> Result<(), Refusal> {
    if let Some(other) = wanted
        .iter()
        .find(|name| !CHANNELS.contains(&name.as_str()))
    {
        return Err(unknown_word("textureChannels", other, &CHANNELS));
    }
    if is_mixed(wanted) {
        let what = "textureChannels: none stands alone; expected none or channels";
        return Err(Refusal(what.to_owned()));
    }
    Ok(())
}

/// The mesh level of a level of detail: the finest that has at most half the triangles of level 0, of the lowest
/// a quarter; the coarsest if none has so few.
fn mesh_level(of: &Manifest, lod: u32) -> u32 {
    let triangles = |level: u32| -> u64 {
        let levels = of.parts.iter().flat_map(|part| &part.levels);
        let same = levels.filter(|entry| entry.level == level);
        same.map(|entry| entry.triangles).sum()
    };
    let most = triangles(0) >> lod;
    let coarsest = coarsest(of, "level");
    let mut levels = 0..=coarsest;
    levels
        .find(|level| triangles(*level) <= most)
        .unwrap_or(coarsest)
}

/// Keeps morph targets by their names.
fn keep_morphs(opened: &mut CharacterFile, wanted: &BTreeSet<String>) -> Result<(), Refusal> {
    let meshes = opened.character().meshes.iter();
    let named: BTreeSet<&str> = meshes
        .flat_map(|mesh| mesh.morph_names.iter().map(String::as_str))
        .collect();
    let known: Vec<&str> = [NONE, ARKIT].into_iter().chain(named).collect();
    if let Some(other) = wanted.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(unknown_word("morphTargets", other, &known));
    }
    let has_arkit = wanted.contains(ARKIT);
    let is_arkit = |name: &str| has_arkit && arkit_name(name).is_some();
    opened.keep_morph_targets(|name| wanted.contains(name) || is_arkit(name));
    Ok(())
}
