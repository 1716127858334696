//! From a character to an item.

use super::carried::carried;
use super::draft::Draft;
use super::figure::StrippedFigure;
use super::files::{Item, NewFiles};
use super::motion_part::CodedMotion;
use super::name::Names;
use super::options::PackageOptions;
use super::part::ItemPart;
use super::sent::FileEntry;
use super::{face_part, figure, flat, mesh_part, texture_part};
use crate::error::{Context, Error, Result};
use crate::face::FoundFace;
use crate::figure::Figure;
use crate::figure::source::SourceFigure;
use crate::mesh_levels::CodedMeshLevels;
use crate::open::{CharacterFile, choose};
use crate::prepare::with_document;
use crate::work::Executor;
use std::collections::BTreeMap;
use std::path::Path;

/// Takes the item of a stage; an error stops the work.
pub type StageCallback<'a> = &'a mut (dyn FnMut(&Item) -> Result<()> + 'a);

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
    packaged(opened, options, work, None).with_context(|| &name)
}

/// Does the same in stages. `on_stage` gets the item as far as it is made, each time a complete and valid
/// one; the whole is returned.
///
/// The first stage is the base, after a small part of the work: the figure, the coarsest mesh level, the
/// coarsest tier of the first clip, and one small size of each texture. Then come all sizes of textures
/// with the files that are carried whole, all of the first clip, all mesh levels, the other clips, each time
/// as many again, motions of the face, and in the end forms in 2D. A stage has the layers of the one before (of a
/// texture its small size may be left out), and streams of which those of the one before are cuts.
///
/// # Errors
/// Those of [`package`], and those of `on_stage`.
pub fn package_in_stages(
    opened: CharacterFile,
    options: &PackageOptions,
    work: &Executor<'_>,
    on_stage: StageCallback<'_>,
) -> Result<Item> {
    let name = opened.name().to_owned();
    // The caller's error is not one of the file.
    let mut refused = None;
    let mut on_stage = |item: &Item| {
        on_stage(item).map_err(|error| {
            refused = Some(error);
            Error::Cancelled
        })
    };
    let made = packaged(opened, options, work, Some(&mut on_stage));
    match refused {
        Some(error) => Err(error),
        None => made.with_context(|| &name),
    }
}

fn packaged(
    opened: CharacterFile,
    options: &PackageOptions,
    work: &Executor<'_>,
    on_stage: Option<StageCallback<'_>>,
) -> Result<Item> {
    let source = Source::new(opened, options, work)?;
    let figure = &source.figure;
    let mut stages = Stages::new(on_stage);
    let mut motions = Motions::new(figure, &source.clips, options);
    let mut first = motions.next()?;
    let mut draft = Draft::new(source.title.clone(), figure, &source.stripped)?;
    if stages.are_wanted() {
        stages.begin(source.base(draft.clone(), first.as_mut(), options, work)?)?;
    }

    let stripped = &source.stripped;
    let textures = texture_part::parts(figure, stripped, options, &mut draft.files, work)?;
    draft.textures = textures.parts;
    draft.warnings.extend(textures.warnings);
    draft.whole = carried(options, &mut draft.files)?;
    if let Some(first) = first {
        stages.take(&draft)?;
        (draft.motions).push(motions.part(first, &mut draft.files, work)?);
    }
    if let Some(mesh) = &source.mesh {
        stages.take(&draft)?;
        let part = mesh_part::part(figure, &source.clips, mesh, &mut draft.files, work)?;
        draft.mesh.push(part);
        draft.warnings.extend(mesh.warnings.iter().cloned());
    }
    while let Some(coded) = motions.next()? {
        // As many clips again, so that a hundred make few stages.
        if draft.motions.len().is_power_of_two() {
            stages.take(&draft)?;
        }
        (draft.motions).push(motions.part(coded, &mut draft.files, work)?);
    }
    draft.warnings.append(&mut motions.left_out);
    let mut names = Names::default();
    for motion in &options.faces {
        stages.take(&draft)?;
        let wanted = Path::new(&motion.file).file_stem().unwrap_or_default();
        let stem = names.stem("faces", &wanted.to_string_lossy(), "face");
        let named = (stem.as_str(), &options.face);
        let part = face_part::part(figure, motion, named, &mut draft.files, work)?;
        draft.faces.push(part);
    }
    if options.flat && source.mesh.is_some() {
        stages.take(&draft)?;
        let first = source.clips.first().copied();
        let forms = flat::forms(figure, first, options, &mut draft.files, work)?;
        draft.flat = forms.entries;
        draft.warnings.extend(forms.warnings);
    }
    Ok(stages.item(draft))
}

/// What all parts are made from.
struct Source {
    title: String,
    figure: Figure,
    /// The clips to package.
    clips: Vec<usize>,
    /// Mesh levels that are not measured yet; `None` without triangles.
    mesh: Option<CodedMeshLevels>,
    stripped: StrippedFigure,
}

impl Source {
    fn new(opened: CharacterFile, options: &PackageOptions, work: &Executor<'_>) -> Result<Self> {
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
        let face = FoundFace::in_document(&figure, Some(&gltf.document), &[]).ok();
        if let Some(face) = &face {
            gltf.document.set_face(&face.stored());
        }
        let mut mesh = None;
        if !figure.asset.mesh.triangles.is_empty() {
            let source = (&gltf, orders.as_deref());
            let made = mesh_part::coded(&figure, source, face.as_ref(), options, work)?;
            mesh = Some(made);
        }
        let character = figure.opened.character();
        let articulation = figure.opened.articulation();
        let stripped = figure::stripped(character, &character.meshes, gltf, &articulation)?;
        Ok(Self {
            title,
            figure,
            clips,
            mesh,
            stripped,
        })
    }

    /// Adds the least of each part to the figure, with `first` of all clips.
    fn base(
        &self,
        mut draft: Draft,
        first: Option<&mut CodedMotion>,
        options: &PackageOptions,
        work: &Executor<'_>,
    ) -> Result<Draft> {
        let (figure, stripped) = (&self.figure, &self.stripped);
        let shown: Vec<usize> = first.iter().map(|first| first.clip()).collect();
        if let Some(mesh) = &self.mesh {
            let part = mesh_part::base(figure, &shown, mesh, &mut draft.files, work)?;
            draft.mesh.push(part);
        }
        if let Some(first) = first {
            (draft.motions).push(first.base(figure, &mut draft.files, work)?);
        }
        let textures = texture_part::base(figure, stripped, options, &mut draft.files, work)?;
        draft.textures = textures.parts;
        draft.warnings.extend(textures.warnings);
        Ok(draft)
    }
}

/// The stages of the work.
struct Stages<'a> {
    on_stage: Option<StageCallback<'a>>,
    /// The first stage.
    base: Option<Draft>,
    /// How the files of the last stage travel; most of them stay.
    entries: BTreeMap<String, FileEntry>,
}

impl<'a> Stages<'a> {
    fn new(on_stage: Option<StageCallback<'a>>) -> Self {
        Self {
            on_stage,
            base: None,
            entries: BTreeMap::new(),
        }
    }

    fn are_wanted(&self) -> bool {
        self.on_stage.is_some()
    }

    /// Hands over the base.
    fn begin(&mut self, base: Draft) -> Result<()> {
        self.take(&base)?;
        self.base = Some(base);
        Ok(())
    }

    /// Hands over what is made; the base stands for what is not.
    fn take(&mut self, draft: &Draft) -> Result<()> {
        if !self.are_wanted() {
            return Ok(());
        }
        let mut draft = draft.clone();
        if let Some(base) = &self.base {
            draft.fill(base);
        }
        let item = self.item(draft);
        self.entries.clone_from(&item.manifest.files);
        match &mut self.on_stage {
            Some(on_stage) => on_stage(&item),
            None => Ok(()),
        }
    }

    fn item(&self, draft: Draft) -> Item {
        draft.item(self.entries.clone())
    }
}

/// The motions of clips, coded one by one.
struct Motions<'a> {
    figure: &'a Figure,
    options: &'a PackageOptions,
    clips: std::iter::Copied<std::slice::Iter<'a, usize>>,
    names: Names,
    /// A warning for each that is left out.
    left_out: Vec<String>,
}

impl<'a> Motions<'a> {
    fn new(figure: &'a Figure, clips: &'a [usize], options: &'a PackageOptions) -> Self {
        Self {
            figure,
            options,
            clips: clips.iter().copied(),
            names: Names::default(),
            left_out: Vec::new(),
        }
    }

    /// The next clip that can be coded.
    fn next(&mut self) -> Result<Option<CodedMotion>> {
        for clip in self.clips.by_ref() {
            let name = &self.figure.asset.clips[clip].name;
            let stem = self.names.stem("clips", name, "clip");
            let coded = CodedMotion::new(self.figure, clip, (&stem, &self.options.motion));
            match coded.with_context(|| format!("clip \"{name}\"")) {
                Ok(coded) => return Ok(Some(coded)),
                // Nobody asked for this one.
                Err(error) if self.options.clips.is_empty() && !error.is_cancelled() => {
                    (self.left_out).push(format!("{error}; the clip is left out"));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(None)
    }

    fn part(
        &self,
        coded: CodedMotion,
        files: &mut NewFiles,
        work: &Executor<'_>,
    ) -> Result<ItemPart> {
        let name = &self.figure.asset.clips[coded.clip()].name;
        let part = coded.part(self.figure, files, work);
        part.with_context(|| format!("clip \"{name}\""))
    }
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
