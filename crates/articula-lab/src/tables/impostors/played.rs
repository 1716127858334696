//! A crowd whose characters all have the same size on the screen: time, bytes and vertices of each.

use super::{Row, Subject};
use crate::measure::median;
use anyhow::Result;
use articula::crowd::{CacheUse, Camera, CrowdAsset, CrowdPlayer, Culling, Detail, DrawKind, View};
use articula_report::thread_ns;
use glam::Vec3;
use std::f32::consts::TAU;

/// Characters of the crowd.
const CHARACTERS: usize = 2048;
/// Frames that are not counted, and those that are.
const WARM_UP: usize = 10;
const FRAMES: usize = 60;
const STEP_SECS: f32 = 1.0 / 60.0;

/// What a crowd took, for each character and frame.
pub(super) struct Played {
    pub(super) ns: f64,
    pub(super) bytes: f64,
    pub(super) vertices: f64,
    pub(super) triangles: f64,
    /// Coarsest level that was shown, and the greatest error of a level in its character's clip,
    /// without that of the source, metres.
    pub(super) coarsest: usize,
    pub(super) error_m: f32,
    joints: usize,
    resident: usize,
}

/// Plays a crowd at a distance at which a tolerance in metres is one pixel.
pub(super) fn played(asset: &CrowdAsset, tolerance_m: f32, cache: CacheUse) -> Result<Played> {
    let mut player = CrowdPlayer::new(asset, CHARACTERS)?;
    player.cache = cache;
    player.detail = Detail::Tolerance { px: 1.0 };
    let distance = 1000.0;
    let mut camera = Camera::looking_at(
        Vec3::Z * distance,
        Vec3::ZERO,
        articula::Viewport::default(),
    );
    // A narrow field of view: all stand at one depth, and none is far off the axis.
    let half = tolerance_m * 0.5 * camera.viewport.height_px;
    camera.viewport.fov_y_radians = 2.0 * (half / distance).atan();
    let clips = asset.clips();
    for i in 0..CHARACTERS {
        let share = (i as f32 * 0.618_034).fract();
        let clip = i % clips.len();
        player.place(
            i,
            Vec3::new(0.2 * half * (share - 0.5), -1.0, 0.0),
            TAU * share,
        );
        player.play(i, clip, share * clips[clip].duration_secs());
    }
    let views = [View::of(&camera)];
    let mut times = Vec::with_capacity(FRAMES);
    let (mut vertices, mut triangles, mut bytes) = (0.0, 0.0, 0.0);
    let (mut levels, mut error_m) = (Vec::new(), 0.0f32);
    for frame in 0..WARM_UP + FRAMES {
        let start = thread_ns();
        player.plan(STEP_SECS, Culling::Views(&views), &mut |_| ());
        player.evaluate();
        let ns = thread_ns() - start;
        if frame < WARM_UP {
            continue;
        }
        times.push(ns as f64 / CHARACTERS as f64);
        let list = player.crowd().draw_list();
        bytes += (48 * list.matrices
            + 8 * (list.draws.len() + list.characters(DrawKind::Step).len())
            + 16 * list.characters(DrawKind::Record).len()) as f64;
        for character in 0..CHARACTERS {
            if let Some(level) = player.crowd().level(character) {
                let clip = player.crowd().state(character).clip_state().clip();
                error_m = asset.model().error_metres(clip, clip, level).max(error_m);
                vertices += asset.level(level).vertices as f64;
                triangles += asset.level(level).triangles as f64;
                levels.push(level);
            }
        }
    }
    levels.sort_unstable();
    levels.dedup();
    let shown = (CHARACTERS * FRAMES) as f64;
    let coarsest = levels.last().copied().unwrap_or(0);
    let least = levels.first().copied().unwrap_or(0);
    Ok(Played {
        ns: median(&mut times),
        bytes: bytes / shown,
        vertices: vertices / shown,
        triangles: triangles / shown,
        error_m,
        coarsest,
        joints: asset.level(least).joints,
        resident: match cache {
            CacheUse::Never => 0,
            _ => levels.iter().map(|l| cached_bytes(asset, *l)).sum(),
        },
    })
}

/// Bytes of the cached palettes of a level.
fn cached_bytes(asset: &CrowdAsset, level: usize) -> usize {
    let Some(cache) = asset.model().parts().cache.as_ref() else {
        return 0;
    };
    let keys = |clip| {
        cache
            .times_secs(clip, level)
            .map_or(0, |times| times.count())
    };
    let keys: usize = (0..asset.clips().len()).map(keys).sum();
    48 * keys * cache.matrices(level)
}

impl Played {
    pub(super) fn row(&self, subject: &Subject, height_px: f32, way: &'static str) -> Row {
        Row {
            character: subject.name.clone(),
            height_px,
            way,
            error_px: self.error_m * height_px / subject.height_m,
            joints: self.joints,
            ns: self.ns,
            bytes: self.bytes,
            resident: self.resident,
            vertices: self.vertices,
            triangles: self.triangles,
        }
    }
}
