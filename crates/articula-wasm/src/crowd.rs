//! Many characters of one asset.

use crate::asset::Asset;
use crate::crowd_options::crowd_options;
use crate::error::{Fault, Result, index};
use crate::geometry::Geometry;
use crate::matrix_rows::{IDENTITY, Rows, rows};
use crate::picking;
use crate::view::cameras;
use articula::Executor;
use articula::build::USUAL_ROLES;
use articula::core::LibmQuat;
use articula::crowd::{
    Allowance, Budget, CacheUse, CrowdAsset, CrowdEvent, CrowdPlayer, Culling, Detail, DrawKind,
    View,
};
use articula::glam::{Quat, Vec3};
use wasm_bindgen::prelude::*;

/// Nanoseconds of planning for a character, next to those by which the library counts evaluation.
const PLAN_NS: f64 = 10.0;

/// Bytes of a character beside its palette: places, clocks, keys, lists of draws.
const STATE_BYTES: usize = 512;

/// Numbers of a group of draws.
const GROUP: usize = 6;

/// Many characters of one asset, each at the level of detail that its distance needs.
///
/// After `frame`, the methods that end in `At` are byte offsets into the memory of the module, and the getters beside
/// them are numbers of elements. Make views anew after every call into the module, since its memory may have grown.
/// A frame allocates nothing that outlives it once there were as many views before.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Crowd {
    file: String,
    pub(crate) player: CrowdPlayer,
    views: Vec<View<'static>>,
    budget: Option<Budget>,
    /// Nominal nanoseconds of planning and evaluating the last frame.
    nominal_ns: [f64; 2],
    pub(crate) transforms: Vec<Rows>,
    pub(crate) groups: Vec<[u32; GROUP]>,
    hears: bool,
    events: Vec<f64>,
}

#[wasm_bindgen]
impl Crowd {
    /// A crowd at the origin that plays the first clip. `options` is JSON: `{clips?: string[], events?: {[clip: string]: {secs:
    /// number, id: number}[]}, impostors?: object, meshLevels?: number, poseCache?: boolean, rootMotion?: "in-place" | "as-authored" |
    /// "extracted"}`; without it all clips in place, without events, the mesh levels of the asset, and cached
    /// poses. `impostors` is the table of `docs/formats/impostor.md`: who is far enough away is shown by its pictures.
    ///
    /// Throws for options that are not these, mesh levels of a file that stores none, a clip that the file lacks, an event outside of its clip or impostors of another file, and more
    /// characters than memory holds.
    #[wasm_bindgen(constructor)]
    pub fn new(asset: &Asset, count: usize, options: Option<String>) -> Result<Crowd> {
        let figure = asset.figure();
        let file = figure.opened.name().to_owned();
        let options = crowd_options(options.as_deref(), figure)?;
        let thrown = |error| Fault::of_file(&error, &file);
        let asset = CrowdAsset::new(figure, &options, &Executor::default()).map_err(thrown)?;
        check_memory(&asset, count)?;
        let player = CrowdPlayer::new(&asset, count).map_err(thrown)?;
        Ok(Self {
            views: Vec::new(),
            budget: None,
            nominal_ns: [0.0; 2],
            transforms: vec![IDENTITY; count],
            groups: Vec::with_capacity(asset.levels() * DrawKind::ALL.len()),
            hears: false,
            events: Vec::new(),
            player,
            file,
        })
    }

    /// Number of characters.
    #[wasm_bindgen(getter)]
    pub fn count(&self) -> usize {
        self.transforms.len()
    }

    /// Number of levels; 0 is the finest.
    #[wasm_bindgen(getter)]
    pub fn levels(&self) -> usize {
        self.player.asset().levels()
    }

    /// Names of its clips.
    #[wasm_bindgen(getter)]
    pub fn clips(&self) -> Vec<String> {
        let clips = self.player.asset().clips().iter();
        clips.map(|clip| clip.name.clone()).collect()
    }

    /// What was odd about its preparation, a line each.
    #[wasm_bindgen(getter)]
    pub fn warnings(&self) -> Vec<String> {
        self.player.asset().warnings().to_vec()
    }

    /// The mesh of a level. Palettes of all levels have their matrices in one order, of which coarser ones have the
    /// first.
    ///
    /// Throws if there is no such level.
    pub fn mesh(&self, level: usize) -> Result<Geometry> {
        let asset = self.player.asset();
        let level = index("level", level, asset.levels())?;
        Ok(Geometry::of_level(asset.clone(), level))
    }

    /// Sets the position of a character in metres and its turn about +Y in radians.
    ///
    /// Throws if there is no such character.
    pub fn place(&mut self, i: usize, x: f32, y: f32, z: f32, yaw: f32) -> Result<()> {
        self.put(i, Vec3::new(x, y, z), Quat::libm_rotation_y(yaw))
    }

    /// Sets position and rotation, a unit quaternion, of a character.
    ///
    /// Throws if there is no such character.
    #[wasm_bindgen(js_name = setTransform)]
    #[expect(
        clippy::too_many_arguments,
        reason = "numbers cross the border without memory of their own"
    )]
    pub fn set_transform(
        &mut self,
        i: usize,
        x: f32,
        y: f32,
        z: f32,
        qx: f32,
        qy: f32,
        qz: f32,
        qw: f32,
    ) -> Result<()> {
        self.put(i, Vec3::new(x, y, z), Quat::from_xyzw(qx, qy, qz, qw))
    }

    /// Sets the scale of a character.
    ///
    /// Throws if there is no such character.
    #[wasm_bindgen(js_name = setScale)]
    pub fn set_scale(&mut self, i: usize, scale: f32) -> Result<()> {
        let i = self.character(i)?;
        self.player.set_scale(i, scale);
        self.transforms[i] = rows(&self.player.world_from_model(i));
        Ok(())
    }

    /// Sets the importance of a character: 1 is neutral, 2 halves its tolerance.
    ///
    /// Throws if there is no such character.
    #[wasm_bindgen(js_name = setImportance)]
    pub fn set_importance(&mut self, i: usize, importance: f32) -> Result<()> {
        let i = self.character(i)?;
        self.player.set_importance(i, importance);
        Ok(())
    }

    /// Roles that scenes have, with their importance, as JSON: `{"main": 4, …}`.
    #[wasm_bindgen(js_name = usualRoles)]
    pub fn usual_roles() -> String {
        let roles = USUAL_ROLES.map(|(name, importance)| (name.to_owned(), importance.into()));
        serde_json::Value::Object(roles.into_iter().collect()).to_string()
    }

    /// Has a character play a clip in a loop from a time in seconds.
    ///
    /// Throws if there is no such character or clip.
    pub fn play(&mut self, i: usize, clip: usize, secs: f32) -> Result<()> {
        let (i, clip) = (self.character(i)?, self.clip(clip)?);
        self.player.play(i, clip, secs);
        Ok(())
    }

    /// Has a character cross-fade to the start of a clip within `fadeSecs` seconds.
    ///
    /// Throws if there is no such character or clip.
    #[wasm_bindgen(js_name = fadeTo)]
    pub fn fade_to(
        &mut self,
        i: usize,
        clip: usize,
        #[wasm_bindgen(js_name = fadeSecs)] fade_secs: f32,
    ) -> Result<()> {
        let (i, clip) = (self.character(i)?, self.clip(clip)?);
        self.player.fade_to(i, clip, fade_secs);
        Ok(())
    }

    /// Shows all joints of every visible character.
    #[wasm_bindgen(js_name = setFull)]
    pub fn set_full(&mut self) {
        self.budget = None;
        self.player.detail = Detail::Full;
    }

    /// Shows each character by the cheapest level whose error is at most so many pixels; 1 at first.
    #[wasm_bindgen(js_name = setTolerance)]
    pub fn set_tolerance(&mut self, px: f32) {
        self.budget = None;
        self.tolerate(px);
    }

    /// Shows every visible character at one level, at most the coarsest.
    #[wasm_bindgen(js_name = setLevel)]
    pub fn set_level(&mut self, level: usize) {
        self.budget = None;
        self.player.detail = Detail::Level(level);
    }

    /// Chooses the tolerance by a time for each frame in milliseconds, from what `observe` is told: one pixel where
    /// that fits, else what does, but no more than two for near characters.
    #[wasm_bindgen(js_name = setBudget)]
    pub fn set_budget(&mut self, ms: f64) {
        let budget = Budget::new(1e6 * ms, 1.0);
        self.player.detail = budget.detail();
        self.budget = Some(budget);
    }

    /// Tells what the last frame took, in milliseconds. Without a budget it has no effect.
    pub fn observe(&mut self, ms: f64) {
        let Some(budget) = &mut self.budget else {
            return;
        };
        let [plan, evaluate] = self.nominal_ns;
        let ns = 1e6 * ms / (plan + evaluate);
        budget.observe(ns * plan, ns * evaluate);
        self.player.detail = budget.detail();
    }

    /// Tolerance of the next frame in pixels; 0 where it does not decide.
    #[wasm_bindgen(getter, js_name = tolerancePx)]
    pub fn tolerance_px(&self) -> f32 {
        match self.player.detail {
            Detail::Tolerance { px } => px,
            Detail::Within(allowance) => allowance.px,
            Detail::Full | Detail::Level(_) => 0.0,
        }
    }

    /// Which processor blends cached poses: "none", "cpu" (as at first: palettes and steps), or "gpu" (records, also where a
    /// coarser mesh with a palette of its own would have fewer triangles).
    ///
    /// Throws for another word.
    #[wasm_bindgen(js_name = usePoseCache)]
    pub fn use_pose_cache(&mut self, processor: &str) -> Result<()> {
        self.player.cache = match processor {
            "none" => CacheUse::Never,
            "cpu" => CacheUse::Cpu,
            "gpu" => CacheUse::Gpu,
            _ => {
                return Err(Fault::argument(format!(
                    "pose cache: \"{processor}\"; known are \"none\", \"cpu\" and \"gpu\""
                )));
            }
        };
        let is_tolerated = matches!(
            self.player.detail,
            Detail::Tolerance { .. } | Detail::Within(_)
        );
        if is_tolerated && self.budget.is_none() {
            self.tolerate(self.tolerance_px());
        }
        Ok(())
    }

    /// Whether events of clips are kept for `events`.
    #[wasm_bindgen(js_name = setEvents)]
    pub fn set_events(&mut self, on: bool) {
        self.hears = on;
        self.events.clear();
    }

    /// Advances by seconds, plans and evaluates for views of ten numbers each: position x y z, rotation x y z w of a
    /// camera that looks along its -Z, width and height in pixels, vertical field of view in radians. Without a view
    /// all characters are seen from nearby. Returns the number of visible characters.
    ///
    /// Throws if the numbers are not whole views.
    pub fn frame(
        &mut self,
        #[wasm_bindgen(js_name = dtSecs)] dt_secs: f32,
        views: &[f32],
    ) -> Result<usize> {
        self.views.clear();
        self.views
            .extend(cameras(views)?.map(|camera| View::of(&camera)));
        let culling = match &self.views[..] {
            [] => Culling::Off,
            views => Culling::Views(views),
        };
        let (hears, events) = (self.hears, &mut self.events);
        events.clear();
        let report = self.player.plan(dt_secs, culling, &mut |event| {
            if let (
                true,
                CrowdEvent::Clip {
                    character,
                    clip,
                    id,
                    weight,
                },
            ) = (hears, event)
            {
                events.extend([
                    character as f64,
                    clip as f64,
                    f64::from(id),
                    f64::from(weight),
                ]);
            }
        });
        if let Some(budget) = &mut self.budget {
            // A frame whose time was never told is forgotten.
            budget.observe(0.0, 0.0);
            self.player.add_to(budget);
        }
        self.player.evaluate();
        self.nominal_ns = [
            PLAN_NS * self.transforms.len() as f64,
            report.work.cost_ns(),
        ];
        self.write_groups();
        Ok(report.visible)
    }

    /// Events of clips that the last frame passed, four numbers each: character, clip, identifier, weight of the clip.
    #[wasm_bindgen(getter)]
    pub fn events(&self) -> Vec<f64> {
        self.events.clone()
    }

    /// Level at which a character is shown; -1 if it is not.
    ///
    /// Throws if there is no such character.
    pub fn level(&self, i: usize) -> Result<i32> {
        let level = self.player.crowd().level(self.character(i)?);
        Ok(level.map_or(-1, |level| level as i32))
    }

    /// First character that a ray meets, by the boxes around its clips, and the distance in metres; `undefined` if
    /// it meets none.
    #[expect(
        clippy::too_many_arguments,
        reason = "numbers cross the border without memory of their own"
    )]
    pub fn pick(&self, ox: f32, oy: f32, oz: f32, dx: f32, dy: f32, dz: f32) -> Option<Vec<f64>> {
        let (origin, direction) = (Vec3::new(ox, oy, oz), Vec3::new(dx, dy, dz));
        let (character, metres) = picking::first(&self.player, origin, direction)?;
        Some(vec![character as f64, f64::from(metres)])
    }

    /// Motion of a character in the last frame, with "extracted" root motion: x, y, z in its own space, metres, and
    /// its turn about +Y, radians.
    ///
    /// Throws if there is no such character.
    #[wasm_bindgen(js_name = rootDelta)]
    pub fn root_delta(&self, i: usize) -> Result<Vec<f32>> {
        let delta = self.moved_by(self.character(i)?);
        let [x, y, z] = delta.offset.to_array();
        Ok(vec![x, y, z, delta.yaw_radians])
    }

    /// Moves all characters by their motion in the last frame.
    pub fn travel(&mut self) -> Result<()> {
        for i in 0..self.count() {
            let delta = self.moved_by(i);
            if delta == Default::default() {
                continue;
            }
            let (position, rotation) = (self.player.positions()[i], self.player.rotations()[i]);
            let offset = rotation * (self.player.scale(i) * delta.offset);
            let turned = rotation * Quat::libm_rotation_y(delta.yaw_radians);
            self.put(i, position + offset, turned.normalize())?;
        }
        Ok(())
    }

    /// Name of the file.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.file.clone()
    }
}

impl Crowd {
    fn moved_by(&self, character: usize) -> articula::core::crowd::RootDelta {
        let model = self.player.asset().model();
        self.player.crowd().root_delta(model, character)
    }

    fn character(&self, i: usize) -> Result<usize> {
        index("character", i, self.transforms.len())
    }

    fn clip(&self, clip: usize) -> Result<usize> {
        index("clip", clip, self.player.asset().clips().len())
    }

    /// Chooses options within a tolerance. Where the GPU blends, whatever it can blend: a palette of a coarser mesh would
    /// have fewer triangles, but a hundred times the bytes.
    fn tolerate(&mut self, px: f32) {
        self.player.detail = match self.player.cache {
            CacheUse::Gpu => Detail::Within(Allowance {
                px,
                near_px: f32::INFINITY,
                by_processor: true,
                frames: 1,
            }),
            CacheUse::Cpu | CacheUse::Never => Detail::Tolerance { px },
        };
    }

    fn put(&mut self, i: usize, position: Vec3, rotation: Quat) -> Result<()> {
        let i = self.character(i)?;
        self.player.set_transform(i, position, rotation);
        self.transforms[i] = rows(&self.player.world_from_model(i));
        Ok(())
    }

    fn write_groups(&mut self) {
        let groups = &self.player.crowd().draw_list().groups;
        let written = groups.iter().zip(self.player.draws()).map(|(group, draw)| {
            let [first, count] = [group.range.start, group.range.len()];
            let [set, sets] = [draw.morph_sets.start, draw.morph_sets.len()];
            let [kind, level] = [group.kind as usize, group.level];
            [kind, level, first, count, set, sets].map(|n| n as u32)
        });
        self.groups.clear();
        self.groups.extend(written);
    }
}

/// Refuses a crowd that memory does not hold, which else would end the module.
fn check_memory(asset: &CrowdAsset, count: usize) -> Result<()> {
    let matrices = asset.level(0).matrices * size_of::<Rows>();
    let morphs = asset.full().mesh.morph_weights.len() * size_of::<f32>();
    let bytes = count.saturating_mul(matrices + morphs + STATE_BYTES);
    let mut room = Vec::<u8>::new();
    room.try_reserve_exact(bytes).map_err(|_| {
        Fault::too_large(format!(
            "{count} characters need {:.1} GB, more than memory holds; lower the count",
            bytes as f64 / 1e9
        ))
    })
}
