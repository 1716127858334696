//! Screen-space error of a crowd: pixels between the true and the shown skin.
//!
//! The reference is computed by the plain path (sample, cross-fade, hierarchy, skin) at the
//! character's clock time. The shown skin is computed from the written palette on the mesh of the
//! level; on a coarser mesh a vertex is compared with its corresponding surface point. Where clips
//! move morph targets, the reference shows them at all distances, and the shown skin with the
//! weights that were written. Definition: `docs/metrics.md`, with the true camera instead of a weak
//! perspective.

use super::asset::CrowdAsset;
use super::cached_draws::PoseSource;
use super::mesh_lods::Watch;
use super::player::CrowdPlayer;
use articula_build::vertex_regions;
use articula_core::crowd::{CharacterState, ClipState, ImpostorDraw};
use articula_core::percentile;
use articula_core::visibility::{Bodies, CullResult, MIN_DEPTH_METRES, View, Visibility, cull};
use articula_core::{
    Camera, LocalPose, PosedMesh, Region, SkinnedMesh, Sphere, Wrap, blend, sample, sample_morphs,
    skin, skin_points,
};
use glam::{Affine3A, Vec2, Vec3};
use serde::Serialize;

/// Distance within which all visible characters are measured, in metres.
pub const NEAR_METRES: f32 = 20.0;

/// Number of visible characters sampled in each measured frame.
const DRAWN: usize = 64;

/// Maximum number of vertices compared per character: all of most characters.
const MAX_VERTICES: usize = 20_000;

/// The parts of the body that are reported apart, in the order of the fields of [`PartsError`].
const PARTS: [Region; 3] = [Region::Hands, Region::Face, Region::Feet];

/// LOD error of one character in one frame, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CharacterError {
    /// Index of the character.
    pub character: usize,
    /// Level of the character; the number of levels if it is shown by an impostor.
    pub level: usize,
    /// Distance from the nearest camera that sees it to the character's origin, in metres.
    pub distance_m: f32,
    /// 95th percentile over vertices, in pixels.
    pub p95_px: f64,
    /// Maximum over vertices, in pixels.
    pub worst_px: f64,
    /// Maximum over the vertices of hands, head and feet in the picture, in pixels; `None` if none
    /// is.
    pub parts_px: [Option<f64>; 3],
    /// Whether the character belongs to the even sample; if not, it was measured because it is
    /// near.
    pub is_sampled: bool,
}

/// LOD errors of the measured characters in one frame.
#[derive(Debug, Clone)]
pub struct ErrorSample {
    /// Time of the scene, in seconds.
    pub secs: f64,
    /// Errors of the measured characters.
    pub characters: Vec<CharacterError>,
}

/// Maximum error of a vertex of each part of the body, over all measured characters and frames, in
/// pixels; `None` if the part has no skin or is never in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PartsError {
    /// Below the wrists.
    pub hands: Option<f64>,
    /// The head, with the face.
    pub face: Option<f64>,
    /// Below the ankles.
    pub feet: Option<f64>,
}

/// Errors over all measured frames, in pixels; the error of a character is its 95th percentile over
/// vertices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ErrorSummary {
    /// 95th percentile over the sampled characters and frames.
    pub p95: f64,
    /// Maximum over all measured characters.
    pub max: f64,
    /// Maximum over characters nearer than 20 m.
    pub near_max: f64,
    /// Maximum over all vertices.
    pub worst_vertex: f64,
    /// The same for small parts of the body.
    pub parts: PartsError,
    /// Number of sampled characters over all frames.
    pub drawn: usize,
    /// Number of near characters over all frames.
    pub near: usize,
}

impl ErrorSummary {
    /// Summarises samples.
    pub fn of(samples: &[ErrorSample]) -> Self {
        let all = || samples.iter().flat_map(|l| &l.characters);
        let near = || all().filter(|c| c.distance_m < NEAR_METRES);
        let part = |p: usize| all().filter_map(move |c| c.parts_px[p]).reduce(f64::max);
        let [hands, face, feet] = std::array::from_fn(part);
        let mut drawn: Vec<f64> = all().filter(|c| c.is_sampled).map(|c| c.p95_px).collect();
        Self {
            p95: percentile(&mut drawn, 0.95),
            max: all().map(|c| c.p95_px).fold(0.0, f64::max),
            near_max: near().map(|c| c.p95_px).fold(0.0, f64::max),
            worst_vertex: all().map(|c| c.worst_px).fold(0.0, f64::max),
            parts: PartsError { hands, face, feet },
            drawn: drawn.len(),
            near: near().count(),
        }
    }
}

/// A camera by which errors are measured, and the occluded fraction of each character in its picture;
/// missing ones count as 0.
#[derive(Debug, Clone, Copy)]
pub struct ErrorView<'a> {
    /// The camera.
    pub camera: Camera,
    /// Occluded fraction of each character of the crowd.
    pub occluded: &'a [f32],
}

impl ErrorView<'_> {
    fn hides(&self, character: usize) -> bool {
        self.occluded.get(character).is_some_and(|o| *o >= 1.0)
    }
}

impl From<Camera> for ErrorView<'_> {
    fn from(camera: Camera) -> Self {
        let occluded = &[];
        Self { camera, occluded }
    }
}

/// Compares a crowd with its full-detail reference, in pixels: all near characters and an even
/// sample of the others.
#[derive(Debug)]
pub struct ErrorMeter {
    asset: CrowdAsset,
    seed: u64,
    looks: u64,
    vertices: Vec<u32>,
    /// Part of the body of each vertex, as an index into [`PARTS`].
    parts: Vec<Option<usize>>,
    /// Points that are compared on each level.
    watches: Vec<Watch>,
    pose: LocalPose,
    other: LocalPose,
    /// Whether a clip moves morph targets.
    is_morphed: bool,
    matrices: Vec<Affine3A>,
    truth: Vec<Vec3>,
    shown: Vec<Vec3>,
}

impl ErrorMeter {
    /// Creates a meter; `seed` selects the vertices that are compared.
    pub fn new(asset: &CrowdAsset, seed: u64) -> Self {
        let rig = &asset.full().rig;
        let vertices = every(asset.full().mesh.len(), MAX_VERTICES, seed);
        let vertices: Vec<u32> = vertices.into_iter().map(|v| v as u32).collect();
        let watch = |level| match asset.mesh_lods() {
            Some(lods) => lods.watch(asset.full(), level, asset.mesh(level), &vertices),
            None => Watch::plain(&vertices),
        };
        let watches = (0..asset.levels()).map(watch).collect();
        let room = vec![Vec3::ZERO; vertices.len()];
        let regions = vertex_regions(&asset.full().mesh, rig);
        let part = |v: &u32| PARTS.iter().position(|part| *part == regions[*v as usize]);
        let parts = match asset.has_mesh() {
            true => vertices.iter().map(part).collect(),
            false => vec![None; vertices.len()],
        };
        Self {
            asset: asset.clone(),
            seed,
            looks: 0,
            vertices,
            parts,
            watches,
            pose: rig.rest_pose().clone(),
            other: rig.rest_pose().clone(),
            is_morphed: asset.model().parts().morphs.is_some(),
            matrices: Vec::new(),
            truth: room.clone(),
            shown: room,
        }
    }

    /// Measures a frame whose palettes were just written, seen by some cameras, the greatest error of
    /// these for each vertex, where the character is not wholly hidden; `secs` is only
    /// stored. Each call samples different characters.
    ///
    /// # Panics
    /// If the crowd was made from another asset.
    pub fn measure(
        &mut self,
        player: &CrowdPlayer,
        secs: f64,
        views: &[ErrorView<'_>],
    ) -> ErrorSample {
        let visible = visible(player, views);
        // A new sample for each call.
        let seed = self.seed.wrapping_add(self.looks.wrapping_mul(0x9e37_79b9));
        self.looks += 1;
        let mut is_sampled = vec![false; visible.len()];
        for at in every(visible.len(), DRAWN, seed) {
            is_sampled[at] = true;
        }
        let sources = player.sources();
        let mut impostors = vec![None; sources.len()];
        for draw in player.impostors() {
            impostors[draw.character as usize] = Some(*draw);
        }
        let mut characters = Vec::new();
        for (&(character, distance_m), is_sampled) in visible.iter().zip(is_sampled) {
            if !is_sampled && distance_m >= NEAR_METRES {
                continue;
            }
            let open = views.iter().filter(|view| !view.hides(character));
            let open: Vec<&Camera> = open.map(|sight| &sight.camera).collect();
            let (level, pixels) = if let Some(draw) = impostors[character] {
                let pixels = self.of_impostor(player, draw, &open);
                (self.asset.levels(), pixels)
            } else {
                let level = player.crowd().level(character);
                let (Some(level), Some(source)) = (level, &sources[character]) else {
                    continue;
                };
                (
                    level,
                    self.of_pose(player, (character, level, source), &open),
                )
            };
            let found = self.parts.iter().copied().zip(pixels);
            let found = found.filter_map(|(part, px)| Some((part, px?))).collect();
            characters.push(error_of(character, level, distance_m, found, is_sampled));
        }
        ErrorSample { secs, characters }
    }

    /// Pixels at each vertex of a character that is shown by an impostor, which turns to each camera.
    fn of_impostor(
        &mut self,
        player: &CrowdPlayer,
        draw: ImpostorDraw,
        cameras: &[&Camera],
    ) -> Vec<Option<f64>> {
        let character = draw.character as usize;
        self.pose_truth(player, character);
        let world = player.world_from_model(character);
        self.shown.resize(self.vertices.len(), Vec3::ZERO);
        let mut most: Vec<Option<f64>> = vec![None; self.vertices.len()];
        for camera in cameras {
            player.impostor_matrices(draw, camera.eye, &mut self.matrices);
            let full = &self.asset.full().mesh;
            skin_points(full, &self.matrices, &self.vertices, &mut self.shown);
            for (most, px) in most.iter_mut().zip(self.errors_px(&[camera], &world)) {
                *most = most.iter().copied().chain(px).reduce(f64::max);
            }
        }
        most
    }

    /// Pixels at each vertex of a character that is shown by a mesh and a pose.
    fn of_pose(
        &mut self,
        player: &CrowdPlayer,
        (character, level, source): (usize, usize, &PoseSource),
        cameras: &[&Camera],
    ) -> Vec<Option<f64>> {
        self.pose_truth(player, character);
        player.skin_matrices(level, source, &mut self.matrices);
        let mesh = self.asset.mesh(level);
        let watch = &self.watches[level];
        self.shown.resize(watch.vertices.len(), Vec3::ZERO);
        let weights = player.morph_weights_of(character);
        if self.is_morphed {
            let mut skinned = SkinnedMesh::new(mesh);
            skin(mesh, &self.matrices, weights, &mut skinned);
            pick(&skinned, &watch.vertices, &mut self.shown);
        } else {
            skin_points(mesh, &self.matrices, &watch.vertices, &mut self.shown);
        }
        watch.place(&mut self.shown);
        self.errors_px(cameras, &player.world_from_model(character))
    }

    /// Computes the reference skin of a character.
    fn pose_truth(&mut self, player: &CrowdPlayer, character: usize) {
        let player = player.crowd().state(character);
        self.sample(player.clip_state(), Which::Pose);
        if let Some(next) = player.next() {
            self.sample(next, Which::Other);
            let all = self.asset.full().rig.all();
            blend(&mut self.pose, &self.other, player.fade(), &all);
        }
        let full = self.asset.full();
        let mut posed = PosedMesh::new(&full.rig, &full.mesh);
        posed.pose(&self.pose);
        if self.is_morphed {
            let weights = self.true_weights(&player);
            pick(&posed.skinned(&weights), &self.vertices, &mut self.truth);
        } else {
            posed.points(&self.vertices, &mut self.truth);
        }
    }

    /// Morph target weights of the full character.
    fn true_weights(&self, player: &CharacterState) -> Vec<f32> {
        let full = self.asset.full();
        let one = |clip_state: &ClipState| {
            let mut weights = full.mesh.morph_weights.clone();
            let secs = f64::from(clip_state.secs());
            let clip = &full.clips[clip_state.clip()];
            sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
            weights
        };
        let mut weights = one(player.clip_state());
        if let Some(next) = player.next() {
            for (weight, to) in weights.iter_mut().zip(one(next)) {
                *weight += (to - *weight) * player.fade();
            }
        }
        weights
    }

    fn sample(&mut self, clip_state: &ClipState, which: Which) {
        let asset = self.asset.full();
        let pose = match which {
            Which::Pose => &mut self.pose,
            Which::Other => &mut self.other,
        };
        pose.clone_from(asset.rig.rest_pose());
        let clip = &asset.clips[clip_state.clip()];
        // The clock is already wrapped; the end of the clip is its last frame, not the first.
        let secs = f64::from(clip_state.secs());
        sample(clip, secs, Wrap::Clamp, &asset.rig.all(), pose);
    }

    /// Pixels between both skins at each vertex, the most of all pictures that it is in, in either skin;
    /// `None` if it is in none.
    fn errors_px(&self, cameras: &[&Camera], world: &Affine3A) -> Vec<Option<f64>> {
        let pairs = self.truth.iter().zip(&self.shown);
        let pixels = pairs.map(|(truth, shown)| {
            let ends = [truth, shown].map(|p| world.transform_point3(*p));
            let each = cameras.iter().filter_map(|camera| apart_px(camera, ends));
            each.reduce(f64::max)
        });
        pixels.collect()
    }
}

/// Pixels between two points in a picture; `None` if neither is in it.
fn apart_px(camera: &Camera, [truth, shown]: [Vec3; 2]) -> Option<f64> {
    let (width, height) = (camera.viewport.width_px, camera.viewport.height_px);
    let is_shown = |at: Vec2| (0.0..=width).contains(&at.x) && (0.0..=height).contains(&at.y);
    let (truth, depth) = camera.project(truth);
    let (shown, other) = camera.project(shown);
    let is_ahead = depth.min(other) >= MIN_DEPTH_METRES;
    let is_seen = is_ahead && (is_shown(truth) || is_shown(shown));
    is_seen.then(|| f64::from(truth.distance(shown)))
}

/// Error of a character from the pixels of its vertices, each with its part of the body.
fn error_of(
    character: usize,
    level: usize,
    distance_m: f32,
    found: Vec<(Option<usize>, f64)>,
    is_sampled: bool,
) -> CharacterError {
    let mut parts_px = [None; PARTS.len()];
    for (part, px) in found.iter().filter_map(|(part, px)| Some(((*part)?, *px))) {
        parts_px[part] = Some(parts_px[part].map_or(px, |most: f64| most.max(px)));
    }
    let mut errors: Vec<f64> = found.into_iter().map(|(_, px)| px).collect();
    CharacterError {
        character,
        level,
        distance_m,
        p95_px: percentile(&mut errors, 0.95),
        worst_px: percentile(&mut errors, 1.0),
        parts_px,
        is_sampled,
    }
}

/// Takes the positions of some vertices.
fn pick(skinned: &SkinnedMesh, vertices: &[u32], out: &mut [Vec3]) {
    for (point, v) in out.iter_mut().zip(vertices) {
        *point = skinned.positions[*v as usize];
    }
}

#[derive(Clone, Copy)]
enum Which {
    Pose,
    Other,
}

/// Characters that are shown and inside the view of a camera, with their distances from the nearest that
/// sees them.
fn visible(player: &CrowdPlayer, views: &[ErrorView<'_>]) -> Vec<(usize, f32)> {
    let (crowd, bounds) = (player.crowd(), &player.asset().model().parts().bounds);
    let places = player
        .positions()
        .iter()
        .zip(player.rotations())
        .enumerate();
    let spheres: Vec<Sphere> = places
        .map(|(character, (position, rotation))| {
            let scale = player.scale(character);
            let player = crowd.state(character);
            let from = player.clip_state().clip();
            let bound = match player.next() {
                Some(next) => bounds.blended(from, next.clip()),
                None => bounds.clips[from].whole().sphere,
            };
            bound.carried(*position, *rotation, scale)
        })
        .collect();
    let margins = vec![0.0; spheres.len()];
    let mut seen = vec![CullResult::default(); spheres.len()];
    let mut nearest = vec![f32::INFINITY; spheres.len()];
    for ErrorView { camera, occluded } in views {
        if let Ok(bodies) = Bodies::new(&spheres, &margins) {
            let view = View::of(camera).with_occluded(occluded);
            cull(&[view], bodies, &mut seen);
        }
        let each = nearest.iter_mut().zip(&seen).zip(player.positions());
        for ((nearest, _), at) in each.filter(|((_, s), _)| s.visibility == Visibility::Visible) {
            *nearest = nearest.min(camera.eye.distance(*at));
        }
    }
    let nearest = nearest.into_iter().enumerate();
    nearest
        .filter(|(character, metres)| metres.is_finite() && crowd.level(*character).is_some())
        .collect()
}

/// At most `count` of `total` indices, evenly spaced from a seeded start.
fn every(total: usize, count: usize, seed: u64) -> Vec<usize> {
    if total <= count {
        return (0..total).collect();
    }
    // Multiplied by the golden ratio of 2^64, the high bits are well mixed.
    let start = (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize;
    let mut chosen: Vec<usize> = (0..count)
        .map(|i| (i * total / count + start) % total)
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_draw_is_even_and_moves_with_the_seed() {
        assert_eq!(every(3, 5, 1), [0, 1, 2]);
        let drawn = every(1000, 10, 1);
        assert_eq!(drawn.len(), 10);
        assert!(drawn.windows(2).all(|w| w[1] - w[0] == 100));
        assert_ne!(drawn, every(1000, 10, 2));
        assert_eq!(every(7, 6, 99).len(), 6);
        assert!(every(0, 4, 1).is_empty());
    }

    #[test]
    fn near_ones_count_for_the_maximum_and_not_for_the_percentile() {
        let one = |distance_m, p95_px, is_sampled| CharacterError {
            character: 0,
            level: 0,
            distance_m,
            p95_px,
            worst_px: 2.0 * p95_px,
            parts_px: [Some(p95_px), None, None],
            is_sampled,
        };
        let look = ErrorSample {
            secs: 0.0,
            characters: vec![
                one(100.0, 0.5, true),
                one(100.0, 0.5, true),
                one(5.0, 3.0, false),
            ],
        };
        let found = ErrorSummary::of(&[look]);
        assert_eq!((found.p95, found.max, found.near_max), (0.5, 3.0, 3.0));
        assert_eq!(found.worst_vertex, 6.0);
        assert_eq!((found.parts.hands, found.parts.face), (Some(3.0), None));
        assert_eq!((found.drawn, found.near), (2, 1));
    }
}
