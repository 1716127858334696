//! From a character to an item.

use super::files::{Item, NewFiles};
use super::flat::Forms;
use super::manifest::{FORMAT, FigureEntry, Manifest, VERSION, WholeFile};
use super::name::Names;
use super::options::PackageOptions;
use super::part::ItemPart;
use super::{face_part, figure, flat, mesh_part, motion_part, texture_part};
use crate::error::{Context, Error, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::figure::source::SourceFigure;
use crate::open::{CharacterFile, choose};
use crate::prepare::with_document;
use crate::work::Executor;
use articula_flat::Bounds;
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the figure's file.
pub(super) const FIGURE: &str = "figure.glb";

/// Packages a character as a digital item: a figure without geometry, mesh levels by region, clips
/// and face motions by level, region and tier, textures at several sizes, forms in 2D, and a manifest
/// with the bytes and measured errors of all of them.
///
/// The output does not depend on threads or order.
///
/// # Errors
/// An [`Error`] that names the file and the cause: no joint, a clip or name that does not exist, a
/// motion of a face on a character without one, motion that cannot be coded;
/// [`Error::Cancelled`].
pub fn package(
    opened: CharacterFile,
    options: &PackageOptions,
    work: &Executor<'_>,
) -> Result<Item> {
    let name = opened.name().to_owned();
    packaged(opened, options, work).with_context(|| &name)
}

fn packaged(opened: CharacterFile, options: &PackageOptions, work: &Executor<'_>) -> Result<Item> {
    let title = Path::new(opened.name()).file_stem().unwrap_or_default();
    let title = title.to_string_lossy().into_owned();
    let opened = with_document(opened)?;
    let SourceFigure {
        figure,
        gltf,
        orders,
        ..
    } = Figure::computed(opened)?.into_source();
    let Some(mut gltf) = gltf else {
        // It was just put there.
        return Err(Error::unsuited("the character has no document"));
    };
    let clips = chosen_clips(&figure, &options.clips)?;
    let mut files = NewFiles::default();
    let mut parts = Vec::new();
    let mut warnings = Vec::new();

    let face = FoundFace::in_document(&figure, Some(&gltf.document), &[]).ok();
    if let Some(face) = &face {
        gltf.document.set_face(&face.stored());
    }
    let has_mesh = !figure.asset.mesh.triangles.is_empty();
    if has_mesh {
        let source = (&gltf, orders.as_deref());
        let made = mesh_part::coded(&figure, source, face.as_ref(), options, work)?;
        warnings.extend(made.warnings.iter().cloned());
        parts.push(mesh_part::part(&figure, &clips, made, &mut files, work)?);
    }
    let character = figure.opened.character();
    let articulation = figure.opened.articulation();
    let stripped = figure::stripped(character, &character.meshes, gltf, &articulation)?;
    warnings.extend(stripped.left_out.iter().cloned());

    let (motions, left_out) = motions(&figure, &clips, options, &mut files, work)?;
    parts.extend(motions);
    warnings.extend(left_out);
    let mut names = Names::default();
    for motion in &options.faces {
        let wanted = Path::new(&motion.file).file_stem().unwrap_or_default();
        let stem = names.stem("faces", &wanted.to_string_lossy(), "face");
        let named = (stem.as_str(), &options.face);
        parts.push(face_part::part(&figure, motion, named, &mut files, work)?);
    }
    let textures = texture_part::parts(&figure, &stripped, options, &mut files, work)?;
    parts.extend(textures.parts);
    warnings.extend(textures.warnings);
    let whole = carried(options, &mut files)?;
    let entry = FigureEntry {
        file: FIGURE.to_owned(),
        joints: figure.asset.rig.len() as u64,
        vertices: figure.asset.mesh.len() as u64,
        triangles: figure.asset.mesh.triangles.len() as u64,
        morph_targets: figure.asset.mesh.morph_weights.len() as u64,
        size_m: size(&figure),
        bytes: files.put(FIGURE, stripped.glb)?,
    };
    let forms = match options.flat && has_mesh {
        true => flat::forms(&figure, clips.first().copied(), options, &mut files, work)?,
        false => Forms::default(),
    };
    warnings.extend(forms.warnings);
    let mut manifest = Manifest {
        format: FORMAT.to_owned(),
        version: VERSION,
        generator: concat!("articula ", env!("CARGO_PKG_VERSION")).to_owned(),
        name: title,
        figure: entry,
        parts,
        flat: forms.entries,
        whole,
        files: BTreeMap::new(),
        warnings,
    };
    manifest.round_errors();
    Ok(Item::new(manifest, files.0))
}

/// The motions of these clips, and a warning for each that is left out.
fn motions(
    figure: &Figure,
    clips: &[usize],
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<(Vec<ItemPart>, Vec<String>)> {
    let (mut parts, mut left_out) = (Vec::with_capacity(clips.len()), Vec::new());
    let mut names = Names::default();
    for clip in clips {
        let of_clip = &figure.asset.clips[*clip].name;
        let stem = names.stem("clips", of_clip, "clip");
        let part = motion_part::part(figure, *clip, (&stem, &options.motion), files, work);
        match part.with_context(|| format!("clip \"{of_clip}\"")) {
            Ok(part) => parts.push(part),
            // Nobody asked for this one.
            Err(error) if options.clips.is_empty() && !error.is_cancelled() => {
                left_out.push(format!("{error}; the clip is left out"));
            }
            Err(error) => return Err(error),
        }
    }
    Ok((parts, left_out))
}

/// The clips of these names; all without names.
fn chosen_clips(figure: &Figure, wanted: &[String]) -> Result<Vec<usize>> {
    let names = figure.asset.clips.iter().map(|clip| clip.name.as_str());
    if wanted.is_empty() {
        return Ok((0..figure.asset.clips.len()).collect());
    }
    let mut chosen: Vec<usize> = wanted
        .iter()
        .map(|name| choose("clip", name, names.clone()))
        .collect::<Result<_>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// Adds the files that are carried whole.
fn carried(options: &PackageOptions, files: &mut NewFiles) -> Result<Vec<WholeFile>> {
    let mut names = Names::default();
    let mut whole = Vec::with_capacity(options.with.len());
    for given in &options.with {
        let path = Path::new(&given.name);
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let extension = extension.to_lowercase();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let stem = names.stem(&extension, &stem, "file");
        let is_plain =
            !extension.is_empty() && extension.chars().all(|c| c.is_ascii_alphanumeric());
        let file = match is_plain {
            true => format!("with/{stem}.{extension}"),
            false => format!("with/{stem}"),
        };
        whole.push(WholeFile {
            bytes: files.put(&file, given.bytes.clone())?,
            file,
            mime: mime(&extension).to_owned(),
        });
    }
    Ok(whole)
}

/// Media type of an extension.
fn mime(extension: &str) -> &'static str {
    match extension {
        "mp3" => "audio/mpeg",
        "ogg" | "oga" | "opus" => "audio/ogg",
        "wav" => "audio/wav",
        "m4a" | "aac" => "audio/aac",
        "flac" => "audio/flac",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "svg" => "image/svg+xml",
        "mp4" => "video/mp4",
        "webm" => "video/webm",
        "json" => "application/json",
        "txt" => "text/plain",
        _ => "application/octet-stream",
    }
}

/// Longest side of the bounding box of the mesh at rest, or of the joints without one.
fn size(figure: &Figure) -> f64 {
    let asset = &figure.asset;
    let mut posed = articula_core::PosedMesh::new(&asset.rig, &asset.mesh);
    posed.pose(asset.rig.rest_pose());
    let skinned = posed.skinned(&asset.mesh.morph_weights);
    let joints = (0..asset.rig.len()).map(|joint| posed.model.position(joint));
    let points = skinned.positions.iter().copied();
    let bounds = match skinned.positions.is_empty() {
        true => Bounds::around(joints.map(|p| (p, p))),
        false => Bounds::around(points.map(|p| (p, p))),
    };
    bounds.map_or(0.0, |b| f64::from((b.high - b.low).max_element()))
}
