//! A crowd with all that a frame needs: transforms, clip states, palettes, scratch memory.
//!
//! A thin layer over the core's [`Crowd`], which stays accessible.

use super::asset::CrowdAsset;
use super::cached_draws::{CachedDraws, PoseSource};
use super::frame_parts::{FramePart, Parts};
use super::options::PaletteMatrices;
use super::palettes::{PaletteSlice, Palettes};
use super::share::Rest;
use crate::error::{Error, Result};
use articula_core::LibmQuat;
use articula_core::batch::Scratch;
use articula_core::crowd::{
    Budget, CacheUse, ClipState, Crowd, CrowdEvent, CrowdModel, CrowdReport, CrowdSection, Culling,
    Detail, Draw, DrawKind, Frame, ImpostorDraw, Moved,
};
use articula_core::visibility::View;
use articula_core::{BlendRecord, Camera, Mesh, SkinnedMesh, skin};
use glam::{Affine3A, Quat, Vec3};

/// Maximum size of palettes in bytes.
const MAX_BYTES: u64 = 16 << 30;

/// A crowd of one character, updated and posed frame by frame. It allocates on creation and not in
/// a frame.
///
/// A frame is one call of [`frame`](Self::frame), or its two halves: [`plan`](Self::plan), then the
/// [`parts`](Self::parts) that the caller's threads may evaluate.
#[derive(Debug)]
pub struct CrowdPlayer {
    /// How levels are chosen; by default the cheapest within an error of one pixel.
    pub detail: Detail,
    /// Processor that blends cached poses, where that is cheapest; the CPU by default.
    pub cache: CacheUse,
    asset: CrowdAsset,
    crowd: Crowd,
    palettes: Palettes,
    /// Space for the morph target weights of all characters.
    morph_weights: Vec<f32>,
    cached: CachedDraws,
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
    /// Uniform scale of each character; empty while all are 1.
    scales: Vec<f32>,
    /// Importance of each character; empty while all are 1.
    importance: Vec<f32>,
    moved: MovedList,
    scratches: Vec<Scratch>,
}

/// Characters that were placed since the last frame.
#[derive(Debug)]
struct MovedList {
    characters: Vec<u32>,
    /// More than the list holds.
    is_full: bool,
}

impl MovedList {
    /// A list for a quarter of a crowd; with more, a pass over all costs no more.
    fn new(characters: usize) -> Self {
        Self {
            characters: Vec::with_capacity(characters / 4),
            is_full: true,
        }
    }

    fn add(&mut self, character: usize) {
        if self.characters.len() < self.characters.capacity() {
            self.characters.push(character as u32);
        } else {
            self.is_full = true;
        }
    }

    fn clear(&mut self) {
        self.characters.clear();
        self.is_full = false;
    }

    fn get(&self) -> Moved<'_> {
        match self.is_full {
            true => Moved::All,
            false => Moved::These(&self.characters),
        }
    }
}

impl CrowdPlayer {
    /// Creates a crowd at the origin, in the first frame of the first clip, with space for the
    /// full-detail palettes of all characters.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the palettes would take more than 16 GiB.
    pub fn new(asset: &CrowdAsset, characters: usize) -> Result<Self> {
        let model = asset.model();
        Ok(Self {
            detail: Detail::Tolerance { px: 1.0 },
            cache: CacheUse::default(),
            palettes: Palettes::new(model.parts().form, room(model, characters)?),
            morph_weights: vec![0.0; characters * targets(model)],
            crowd: Crowd::new(model, characters),
            cached: CachedDraws::new(model, characters),
            positions: vec![Vec3::ZERO; characters],
            rotations: vec![Quat::IDENTITY; characters],
            scales: Vec::new(),
            importance: Vec::new(),
            moved: MovedList::new(characters),
            scratches: vec![model.evaluator().scratch()],
            asset: asset.clone(),
        })
    }

    /// Replaces the asset between two frames, such as one made [at once](CrowdAsset::at_once) by the prepared
    /// one: transforms, importance, clips, their times and fades stay, and the next frame chooses among
    /// the new levels. It tells the level of each character in view as if it appeared. Allocates what
    /// [`new`](Self::new) does.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the asset has other clips, or as of [`new`](Self::new); the crowd is then as
    /// before.
    pub fn set_asset(&mut self, asset: &CrowdAsset) -> Result<()> {
        let told = |asset: &CrowdAsset| {
            let clips = asset.clips().iter();
            let clips: Vec<_> = clips.map(|c| (c.name.clone(), c.duration_secs())).collect();
            (clips, asset.full().rig.len())
        };
        if told(&self.asset) != told(asset) {
            let what = "the asset is of another character, or has other clips than the crowd's; prepare the same figure with the same clips";
            return Err(Error::unsuited(what));
        }
        let mut next = Self::new(asset, self.positions.len())?;
        for character in 0..self.positions.len() {
            next.crowd.play(character, self.crowd.state(character));
        }
        (next.detail, next.cache) = (self.detail, self.cache);
        next.positions = std::mem::take(&mut self.positions);
        next.rotations = std::mem::take(&mut self.rotations);
        next.scales = std::mem::take(&mut self.scales);
        next.importance = std::mem::take(&mut self.importance);
        *self = next;
        Ok(())
    }

    /// Returns the asset that the crowd was made from.
    pub fn asset(&self) -> &CrowdAsset {
        &self.asset
    }

    /// Returns the core crowd: levels, clocks, root motion, attachments, records.
    pub fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// Returns the core crowd for changes: clip speeds, blends.
    pub fn crowd_mut(&mut self) -> &mut Crowd {
        &mut self.crowd
    }

    /// Returns the world positions of the characters, in metres.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Returns the world rotations of the characters.
    pub fn rotations(&self) -> &[Quat] {
        &self.rotations
    }

    /// Sets a character's position in metres and its rotation about +Y; at 0 it faces as in its
    /// file.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn place(&mut self, character: usize, position: impl Into<Vec3>, yaw_radians: f32) {
        self.set_transform(character, position, Quat::libm_rotation_y(yaw_radians));
    }

    /// Sets a character's position and rotation: glam's types, or arrays `[x, y, z]` and, for a unit
    /// quaternion, `[x, y, z, w]`.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn set_transform(
        &mut self,
        character: usize,
        position: impl Into<Vec3>,
        rotation: impl Into<Quat>,
    ) {
        self.positions[character] = position.into();
        self.rotations[character] = rotation.into();
        self.moved.add(character);
    }

    /// Sets a character's uniform scale: 0.5 for a child, 3 for a giant. Crowds of which all have the
    /// scale 1, as at first, are planned fastest. The first call allocates.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn set_scale(&mut self, character: usize, scale: f32) {
        self.scales.resize(self.positions.len(), 1.0);
        self.scales[character] = scale;
        self.moved.add(character);
    }

    /// Returns the uniform scale of a character.
    pub fn scale(&self, character: usize) -> f32 {
        self.scales.get(character).copied().unwrap_or(1.0)
    }

    /// Sets the importance of a character: 1 is neutral, 2 halves its tolerance, 0.5 doubles it. It is
    /// clamped to 1/64 and 64. Crowds of which all have the importance 1, as at first, are planned
    /// fastest. The first call allocates.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn set_importance(&mut self, character: usize, importance: f32) {
        self.importance.resize(self.positions.len(), 1.0);
        self.importance[character] = importance;
    }

    /// Returns the importance of a character.
    pub fn importance(&self, character: usize) -> f32 {
        self.importance.get(character).copied().unwrap_or(1.0)
    }

    /// Plays a clip in a loop, starting at a time in seconds, which is wrapped.
    ///
    /// # Panics
    /// If there is no such character or clip.
    pub fn play(&mut self, character: usize, clip: usize, secs: f32) {
        let clips = &self.asset.model().parts().clips;
        let state = ClipState::new(clips, clip).at_secs(clips, secs);
        self.crowd.play(character, state.into());
    }

    /// Cross-fades a character to the start of a clip within `fade_secs` seconds.
    ///
    /// # Panics
    /// If there is no such character or clip.
    pub fn fade_to(&mut self, character: usize, clip: usize, fade_secs: f32) {
        let state = ClipState::new(&self.asset.model().parts().clips, clip);
        self.crowd.fade_to(character, state, fade_secs);
    }

    /// Adds the planned frame to a budget, whose [`Budget::detail`] it was planned with.
    pub fn add_to(&mut self, budget: &mut Budget) {
        budget.add(&mut self.crowd, self.asset.model());
    }

    /// Runs one frame for one camera on the calling thread.
    pub fn frame(&mut self, dt_secs: f32, camera: &Camera) -> CrowdReport {
        let views = [View::of(camera)];
        let report = self.plan(dt_secs, Culling::Views(&views), &mut |_| ());
        self.evaluate();
        report
    }

    /// First half of a frame: advances every clock, reports events and changes of level, culls
    /// against the views and chooses a level for each character.
    pub fn plan(
        &mut self,
        dt_secs: f32,
        culling: Culling<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> CrowdReport {
        self.plan_by(dt_secs, culling, |crowd, model, frame| {
            crowd.tick(model, frame, tell)
        })
    }

    /// [`plan`](Self::plan) on several threads: `run` applies the given function to each of the given
    /// sections, in any order and on any threads. The frame is that of `plan`.
    ///
    /// ```
    /// # use articula::crowd::{CrowdPlayer, CrowdReport, Culling};
    /// # fn on_threads(crowd: &mut CrowdPlayer, culling: Culling<'_>) -> CrowdReport {
    /// crowd.plan_on(1.0 / 60.0, culling, &mut |_| (), |sections, tick| {
    ///     let (left, right) = sections.split_at_mut(sections.len() / 2);
    ///     std::thread::scope(|threads| {
    ///         threads.spawn(|| left.iter_mut().for_each(tick));
    ///         right.iter_mut().for_each(tick);
    ///     });
    /// })
    /// # }
    /// ```
    pub fn plan_on(
        &mut self,
        dt_secs: f32,
        culling: Culling<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
        run: impl FnOnce(&mut [CrowdSection], &(dyn Fn(&mut CrowdSection) + Sync)),
    ) -> CrowdReport {
        self.plan_by(dt_secs, culling, |crowd, model, frame| {
            crowd.tick_on(model, frame, tell, run)
        })
    }

    fn plan_by(
        &mut self,
        dt_secs: f32,
        culling: Culling<'_>,
        tick: impl FnOnce(&mut Crowd, &CrowdModel, &Frame<'_>) -> CrowdReport,
    ) -> CrowdReport {
        let frame = Frame {
            dt_secs,
            positions: &self.positions,
            rotations: &self.rotations,
            moved: self.moved.get(),
            scales: &self.scales,
            cull_margin_metres: &[],
            importance: &self.importance,
            culling,
            detail: self.detail,
            cache: self.cache,
        };
        let report = tick(&mut self.crowd, self.asset.model(), &frame);
        self.moved.clear();
        report
    }

    /// Second half of a frame: writes all palettes, records and morph target weights on the calling
    /// thread.
    pub fn evaluate(&mut self) {
        self.parts(1).for_each(|mut part| part.evaluate());
    }

    /// Splits the second half of a frame into at most `count` independent parts of about equal
    /// cost. The bytes that they write do not depend on order or thread.
    ///
    /// Allocates scratch memory if `count` is greater than in any earlier call.
    ///
    /// ```
    /// # fn on_threads(crowd: &mut articula::crowd::CrowdPlayer) {
    /// std::thread::scope(|threads| {
    ///     for mut part in crowd.parts(4) {
    ///         threads.spawn(move || part.evaluate());
    ///     }
    /// });
    /// # }
    /// ```
    pub fn parts(&mut self, count: usize) -> impl Iterator<Item = FramePart<'_>> {
        let (model, count) = (self.asset.model(), count.max(1));
        while self.scratches.len() < count {
            self.scratches.push(model.evaluator().scratch());
        }
        Parts {
            model,
            rows: Some(self.palettes.first(self.crowd.draw_list().matrices)),
            weights: Rest::of(&mut self.morph_weights),
            targets: targets(model),
            cached: self.cached.rest(),
            crowd: &self.crowd,
            scratches: self.scratches[..count].iter_mut(),
            first: 0,
            count,
        }
    }

    /// Returns the palettes of this frame, one after the other.
    pub fn palettes(&self) -> PaletteSlice<'_> {
        self.palettes.written(self.crowd.draw_list().matrices)
    }

    /// Returns the palettes of this frame as 3x4 matrices, row by row, which any version of any math crate
    /// can read; `None` unless the form is [`PaletteForm::Matrix`](articula_core::PaletteForm::Matrix).
    pub fn matrices(&self) -> Option<&[[f32; 12]]> {
        self.palettes.matrices(self.crowd.draw_list().matrices)
    }

    /// Returns the blend records of this frame: those of [`DrawKind::Record`].
    pub fn records(&self) -> &[BlendRecord] {
        self.cached.records(self.crowd.draw_list())
    }

    /// Returns the draws of the characters that show a cached palette as it is, [`DrawKind::Step`]:
    /// their matrices are those of [`PoseCache::rows`](articula_core::PoseCache::rows).
    pub fn stepped(&self) -> &[Draw] {
        self.cached.steps(self.crowd.draw_list())
    }

    /// Returns the draws of the characters that are shown by impostors, [`DrawKind::Impostor`].
    pub fn impostors(&self) -> &[ImpostorDraw] {
        self.cached.impostors(self.crowd.draw_list())
    }

    /// Returns what this frame has written of the characters without palettes of their own, for a hash.
    pub(super) fn cached_words(&self) -> impl Iterator<Item = u64> {
        self.cached.words(self.crowd.draw_list())
    }

    /// Writes the matrices by which the full mesh ([`CrowdAsset::full`]) shows the points that an
    /// impostor shows to an eye: skinned in its pose and moved along the direction of its picture onto its
    /// plane. Nothing is written without impostors.
    pub fn impostor_matrices(&self, draw: ImpostorDraw, eye: Vec3, out: &mut Vec<Affine3A>) {
        let Some(impostors) = self.asset.own_impostors() else {
            return;
        };
        let model = self.world_from_model(draw.character as usize).inverse();
        let eye = model.transform_point3(eye);
        impostors.matrices(self.asset.full(), draw.pose as usize, eye, out);
    }

    /// Returns the morph target weights of this frame, a set for each character that shows morph
    /// targets; [`InstancedDraw::morph_sets`](super::InstancedDraw::morph_sets) says whose.
    /// Targets that a character leaves out have their default weights. Empty if no clip moves any.
    pub fn morph_weights(&self) -> &[f32] {
        let targets = targets(self.asset.model());
        &self.morph_weights[..self.crowd.draw_list().morph_sets() * targets]
    }

    /// Returns the morph target weights that a character is shown with: its set, or the mesh's
    /// default weights. O(characters).
    pub fn morph_weights_of(&self, character: usize) -> &[f32] {
        let list = self.crowd.draw_list();
        let mut owners = DrawKind::ALL.into_iter().flat_map(|kind| {
            let characters = list.characters(kind);
            &characters[..list.with_morphs(kind)]
        });
        let targets = targets(self.asset.model());
        match owners.position(|c| *c as usize == character) {
            Some(set) => &self.morph_weights[set * targets..][..targets],
            None => &self.asset.full().mesh.morph_weights,
        }
    }

    /// Returns the transform of a character from model to world space.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn world_from_model(&self, character: usize) -> Affine3A {
        let (rotation, position) = (self.rotations[character], self.positions[character]);
        let scale = Vec3::splat(self.scale(character));
        Affine3A::from_scale_rotation_translation(scale, rotation, position)
    }

    /// Returns the mesh of a character's level with its morphed and skinned vertices and normals in
    /// model space, or `None` if the character is not shown. O(characters), and allocates: for tests and
    /// for renderers without a GPU.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn skinned(&self, character: usize) -> Option<(&Mesh, SkinnedMesh)> {
        let level = self.crowd.level(character)?;
        let source = self.source(character)?;
        let mesh = self.asset.mesh(level);
        let mut matrices = Vec::new();
        self.skin_matrices(level, &source, &mut matrices);
        let mut skinned = SkinnedMesh::new(mesh);
        let weights = self.morph_weights_of(character);
        skin(mesh, &matrices, weights, &mut skinned);
        Some((mesh, skinned))
    }

    /// Returns the pose source of each character; `None` for those that are not shown.
    pub fn sources(&self) -> Vec<Option<PoseSource>> {
        let mut sources = vec![None; self.positions.len()];
        for (character, source) in self.shown_sources() {
            sources[character as usize] = Some(source);
        }
        sources
    }

    fn source(&self, character: usize) -> Option<PoseSource> {
        let mut shown = self.shown_sources();
        let found = shown.find(|(c, _)| *c as usize == character);
        found.map(|(_, source)| source)
    }

    fn shown_sources(&self) -> impl Iterator<Item = (u32, PoseSource)> {
        let list = self.crowd.draw_list();
        let written = |d: &Draw| (d.character, PoseSource::Written(d.first_matrix as usize));
        let written = list.draws.iter().map(written);
        written.chain(self.cached.sources(list))
    }

    /// Writes the skinning matrices of a level's mesh for a pose source, independent of kind and
    /// form of the palettes.
    ///
    /// # Panics
    /// If there is no such level, or the source is from another frame.
    pub fn skin_matrices(&self, level: usize, source: &PoseSource, out: &mut Vec<Affine3A>) {
        let blended;
        let (palettes, first) = match source {
            PoseSource::Written(first) => (&self.palettes, *first),
            PoseSource::Record(record) => {
                blended = self.blended(level, *record);
                (&blended, 0)
            }
            PoseSource::Stepped(first) => {
                blended = self.blended(level, BlendRecord::of_key(*first));
                (&blended, 0)
            }
        };
        out.clear();
        let bindings = self.asset.mesh(level).bindings.iter().enumerate();
        out.extend(bindings.map(|(b, binding)| match self.asset.matrices() {
            PaletteMatrices::Skin => palettes.matrix(first + b),
            PaletteMatrices::Joints => {
                let place = self.asset.joint_lods().place(usize::from(binding.joint));
                palettes.matrix(first + place) * binding.inverse_bind
            }
        }));
    }

    /// Blends a record as a vertex shader does.
    fn blended(&self, level: usize, record: BlendRecord) -> Palettes {
        let model = self.asset.model();
        let matrices = model.parts().palette.len(level);
        let mut palettes = Palettes::new(model.parts().form, matrices);
        if let Some(cache) = model.parts().cache.as_ref() {
            cache.blend(
                level,
                &[record],
                model.parts().backend,
                palettes.first(matrices),
            );
        }
        palettes
    }
}

/// Number of morph target weights of a character; 0 if no level shows them.
fn targets(model: &CrowdModel) -> usize {
    let morphs = model.parts().morphs.as_ref();
    morphs.filter(|m| m.levels() > 0).map_or(0, |m| m.targets())
}

/// Number of matrices that a frame may need: all characters in full detail.
fn room(model: &CrowdModel, characters: usize) -> Result<usize> {
    let matrices = characters.saturating_mul(model.parts().palette.len(0));
    let weights = characters.saturating_mul(targets(model) * size_of::<f32>());
    let bytes = matrices.saturating_mul(model.parts().form.bytes());
    let bytes = bytes.saturating_add(weights);
    // What a machine of 32 bits can address is less.
    let limit = MAX_BYTES.min(isize::MAX as u64);
    if bytes as u64 > limit {
        return Err(Error::unsuited(format!(
            "{characters} characters: {:.1} GB of palettes, the limit is {:.1}; lower the count or choose a smaller form",
            bytes as f64 / 1e9,
            limit as f64 / 1e9
        )));
    }
    Ok(matrices)
}
