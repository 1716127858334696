//! A crowd with all that a frame needs: places, what everyone plays, palettes, scratch memory.
//!
//! A thin hull around core's [`Crowd`], which stays reachable.

use super::asset::CrowdAsset;
use super::budget::FrameBudget;
use super::options::PaletteMatrices;
use super::palettes::{PaletteSlice, Palettes, split};
use crate::error::{Error, Result};
use articula_core::batch::Scratch;
use articula_core::budget::{BudgetPolicy, CostModel};
use articula_core::crowd::{
    CacheUse, ClipState, Crowd, CrowdEvent, CrowdModel, CrowdReport, Culling, Detail, Draw, Frame,
};
use articula_core::visibility::View;
use articula_core::{BlendRecord, Camera, Mesh, PaletteRows, SkinnedMesh, skin};
use glam::{Affine3A, Quat, Vec3};
use std::ops::Range;

/// Most bytes of palettes: what a program may ask for at once.
const MAX_BYTES: usize = 16 << 30;

/// A crowd of one character that is played frame by frame. Allocates when it is made, and nothing
/// in a frame.
///
/// A frame is [`frame`](Self::frame), or its two halves: [`plan`](Self::plan), and the
/// [`parts`](Self::parts) that the caller's threads may evaluate.
#[derive(Debug)]
pub struct CrowdPlayer {
    /// How much detail everyone gets: an error of at most one pixel unless it is set otherwise.
    pub detail: Detail,
    /// Whether characters may share poses where their tolerance allows it; `false` at first.
    pub share: bool,
    /// Who blends cached poses; nobody at first.
    pub cache: CacheUse,
    asset: CrowdAsset,
    crowd: Crowd,
    palettes: Palettes,
    positions: Vec<Vec3>,
    rotations: Vec<Quat>,
    scratches: Vec<Scratch>,
}

/// Characters of one level: one instanced draw for each part of the mesh.
#[derive(Debug, Clone, Copy)]
pub struct CrowdGroup<'a> {
    /// The level; 0 is full detail.
    pub level: usize,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Who is drawn, and where each palette begins in [`CrowdPlayer::palettes`]; several may
    /// share one.
    pub draws: &'a [Draw],
    /// Matrices of one palette.
    pub matrices: usize,
}

/// From where a character is shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PoseSource {
    /// From the palettes of the frame: index of its first matrix.
    Written(usize),
    /// From the pose cache, by the GPU.
    Record(BlendRecord),
}

impl CrowdPlayer {
    /// A crowd at the origin in the first frame of the first clip, with palettes for everyone in
    /// full detail.
    ///
    /// # Errors
    /// [`Error::Unsuited`] if the palettes would take more than 16 GiB.
    pub fn new(asset: &CrowdAsset, characters: usize) -> Result<Self> {
        let model = asset.model();
        Ok(Self {
            detail: Detail::Tolerance { px: 1.0 },
            share: false,
            cache: CacheUse::Never,
            palettes: Palettes::new(model.parts().form, room(model, characters)?),
            crowd: Crowd::new(model, characters),
            positions: vec![Vec3::ZERO; characters],
            rotations: vec![Quat::IDENTITY; characters],
            scratches: vec![model.evaluator().scratch()],
            asset: asset.clone(),
        })
    }

    /// The character that it was made of.
    pub fn asset(&self) -> &CrowdAsset {
        &self.asset
    }

    /// The crowd of the core: levels, clocks, root steps, sockets, records.
    pub fn crowd(&self) -> &Crowd {
        &self.crowd
    }

    /// The same to be changed: clips at other speeds, blends, budgets.
    pub fn crowd_mut(&mut self) -> &mut Crowd {
        &mut self.crowd
    }

    /// Where each root is in the world, metres.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// How each is turned.
    pub fn rotations(&self) -> &[Quat] {
        &self.rotations
    }

    /// Puts a character somewhere, metres, turned about +Y; at 0 it faces as in its file.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn place(&mut self, character: usize, position: Vec3, yaw_radians: f32) {
        self.place_turned(character, position, Quat::from_rotation_y(yaw_radians));
    }

    /// The same with any rotation.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn place_turned(&mut self, character: usize, position: Vec3, rotation: Quat) {
        self.positions[character] = position;
        self.rotations[character] = rotation;
    }

    /// Lets a character play a clip in a loop, from a time in seconds on, which is wrapped.
    ///
    /// # Panics
    /// If there is no such character or clip.
    pub fn play(&mut self, character: usize, clip: usize, secs: f32) {
        let clips = &self.asset.model().parts().clips;
        let state = ClipState::new(clips, clip).at_secs(clips, secs);
        self.crowd.play(character, state.into());
    }

    /// Lets a character fade to a clip's beginning in so many seconds.
    ///
    /// # Panics
    /// If there is no such character or clip.
    pub fn fade_to(&mut self, character: usize, clip: usize, fade_secs: f32) {
        let state = ClipState::new(&self.asset.model().parts().clips, clip);
        self.crowd.fade_to(character, state, fade_secs);
    }

    /// Plays under a budget from now on: the least visible error, and errors above `cap_px` are
    /// mended first. Everyone is posed in every frame. What a frame may spend is then told by
    /// [`allow`](Self::allow).
    ///
    /// # Errors
    /// [`Error::Mismatch`] if the cap is no number of pixels.
    pub fn set_budget(&mut self, cap_px: f32) -> Result<()> {
        let policy = BudgetPolicy {
            cap_px,
            // Everyone is posed in every frame, so nobody waits.
            patience_frames: 0,
            ..BudgetPolicy::default()
        };
        let (model, costs) = (self.asset.model(), CostModel::default());
        self.crowd.set_budget(model, policy, &costs)?;
        self.detail = Detail::Budget { cost: 0.0 };
        Ok(())
    }

    /// What the next frames may spend.
    pub fn allow(&mut self, allowance: &FrameBudget) {
        allowance.apply(&mut self.crowd, self.asset.model());
        self.detail = Detail::Budget {
            cost: allowance.cost_ns,
        };
    }

    /// One frame before one camera, on this thread.
    pub fn frame(&mut self, dt_secs: f32, camera: &Camera) -> CrowdReport {
        let views = [View::of(camera)];
        let report = self.plan(dt_secs, Culling::Views(&views), &mut |_| ());
        self.evaluate();
        report
    }

    /// The first half of a frame: advances every clock, tells events and changes of level, culls
    /// against the views and chooses a level for each character.
    pub fn plan(
        &mut self,
        dt_secs: f32,
        culling: Culling<'_>,
        tell: &mut dyn FnMut(CrowdEvent),
    ) -> CrowdReport {
        let frame = Frame {
            dt_secs,
            positions: &self.positions,
            rotations: &self.rotations,
            scales: &[],
            cull_margin_metres: &[],
            importance: &[],
            culling,
            detail: self.detail,
            share: self.share,
            cache: self.cache,
        };
        self.crowd.tick(self.asset.model(), &frame, tell)
    }

    /// The second half of a frame: writes all palettes, on this thread.
    pub fn evaluate(&mut self) {
        self.parts(1).for_each(|mut part| part.evaluate());
    }

    /// The second half of a frame in at most so many independent parts of about equal cost: the
    /// bytes that they write do not depend on the order or the threads that they run on.
    ///
    /// Scratch memory for more parts than ever before is allocated here.
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
            rows: Some(self.palettes.first(self.crowd.drawn().matrices)),
            crowd: &self.crowd,
            scratches: self.scratches[..count].iter_mut(),
            first: 0,
            count,
        }
    }

    /// Who is drawn, by level.
    pub fn groups(&self) -> impl Iterator<Item = CrowdGroup<'_>> {
        self.crowd.drawn().groups.iter().map(|group| CrowdGroup {
            level: group.level,
            mesh: self.asset.mesh(group.level),
            draws: &self.crowd.drawn().draws[group.draws.clone()],
            matrices: group.matrices,
        })
    }

    /// The palettes of this frame, one after the other.
    pub fn palettes(&self) -> PaletteSlice<'_> {
        self.palettes.written(self.crowd.drawn().matrices)
    }

    /// The place of a character as a matrix.
    ///
    /// # Panics
    /// If there is no such character.
    pub fn world_from_model(&self, character: usize) -> Affine3A {
        let (rotation, position) = (self.rotations[character], self.positions[character]);
        Affine3A::from_rotation_translation(rotation, position)
    }

    /// Vertices and normals of a character in model space as this frame shows it, with the mesh
    /// of its level; `None` if it is not shown. O(characters) and allocates: for tests and for
    /// renderers without a GPU.
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
        skin(mesh, &matrices, &mesh.morph_weights, &mut skinned);
        Some((mesh, skinned))
    }

    /// From where each character is shown; `None` for those who are not.
    pub fn sources(&self) -> Vec<Option<PoseSource>> {
        let mut sources = vec![None; self.positions.len()];
        for draw in &self.crowd.drawn().draws {
            let first = draw.first_matrix as usize;
            sources[draw.character as usize] = Some(PoseSource::Written(first));
        }
        for record in &self.crowd.drawn().records {
            sources[record.character as usize] = Some(PoseSource::Record(*record));
        }
        sources
    }

    fn source(&self, character: usize) -> Option<PoseSource> {
        let mut draws = self.crowd.drawn().draws.iter();
        let mut records = self.crowd.drawn().records.iter();
        let draw = draws.find(|d| d.character as usize == character);
        let written = draw.map(|d| PoseSource::Written(d.first_matrix as usize));
        let mut record = || records.find(|r| r.character as usize == character);
        written.or_else(|| Some(PoseSource::Record(*record()?)))
    }

    /// The matrices of the bindings of a level's mesh as a character shows them, whatever
    /// matrices and form the palettes have.
    ///
    /// # Panics
    /// If there is no such level, or the source is of another frame.
    pub fn skin_matrices(&self, level: usize, source: &PoseSource, out: &mut Vec<Affine3A>) {
        let blended;
        let (palettes, first) = match source {
            PoseSource::Written(first) => (&self.palettes, *first),
            PoseSource::Record(record) => {
                blended = self.blended(level, *record);
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

    /// What a vertex shader makes of a record.
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

/// A part of a frame's evaluation, which needs nothing of the others.
#[derive(Debug)]
pub struct FramePart<'a> {
    crowd: &'a Crowd,
    model: &'a CrowdModel,
    batches: Range<usize>,
    rows: PaletteRows<'a>,
    scratch: &'a mut Scratch,
}

impl FramePart<'_> {
    /// Writes its palettes; does not allocate.
    pub fn evaluate(&mut self) {
        let rows = match &mut self.rows {
            PaletteRows::Float(rows) => PaletteRows::Float(rows),
            PaletteRows::Half(rows) => PaletteRows::Half(rows),
        };
        self.crowd
            .evaluate(self.model, self.batches.clone(), rows, self.scratch);
    }
}

/// Cuts a frame into one part for each scratch at most.
struct Parts<'a> {
    crowd: &'a Crowd,
    model: &'a CrowdModel,
    rows: Option<PaletteRows<'a>>,
    scratches: std::slice::IterMut<'a, Scratch>,
    first: usize,
    count: usize,
}

impl<'a> Iterator for Parts<'a> {
    type Item = FramePart<'a>;

    fn next(&mut self) -> Option<FramePart<'a>> {
        let scratch = self.scratches.next()?;
        let mut batches = self.crowd.share_of_batches(self.first, self.count);
        if self.scratches.len() == 0 {
            batches.end = self.crowd.drawn().batches;
        }
        if batches.is_empty() {
            return None;
        }
        self.first = batches.end;
        let matrices = self.crowd.matrices_of(batches.clone()).len();
        let rows = matrices * self.model.parts().form.rows();
        let (rows, rest) = split(self.rows.take()?, rows);
        self.rows = Some(rest);
        Some(FramePart {
            crowd: self.crowd,
            model: self.model,
            batches,
            rows,
            scratch,
        })
    }
}

/// Matrices that a frame may need: everyone in full detail.
fn room(model: &CrowdModel, characters: usize) -> Result<usize> {
    let matrices = characters.saturating_mul(model.parts().palette.len(0));
    let bytes = matrices.saturating_mul(model.parts().form.bytes());
    if bytes > MAX_BYTES {
        return Err(Error::unsuited(format!(
            "{characters} characters: {:.1} GB of palettes, the limit is {:.1}; lower the count or choose a smaller form",
            bytes as f64 / 1e9,
            MAX_BYTES as f64 / 1e9
        )));
    }
    Ok(matrices)
}
