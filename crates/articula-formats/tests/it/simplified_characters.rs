//! Real characters with fewer triangles: targets are reached, surfaces stay closed in motion.

use crate::real;
use articula_build::ClipOptions;
use articula_build::{Asset, character};
use articula_build::{DistanceOptions, surface_distances};
use articula_build::{ErrorWeighting, Simplified, SimplifyOptions, simplify};
use articula_build::{PoseOptions, poses, positions};
use articula_formats::{Limits, gltf, joint_map};
use glam::Vec3;
use std::collections::BTreeMap;

/// Smooth, hard-edged, with few triangles, and a head with open edges.
const FILES: [&str; 4] = [
    "glb/pab_arnaud.glb",
    "glb/KayKit_Mage.glb",
    "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
    "glb/ict_head_talk_1095.glb",
];

fn asset(name: &str) -> Option<Asset> {
    let bytes = real::bytes(name)?;
    let mut beside = |uri: &str| Err(uri.to_owned());
    let file = gltf::read(&bytes, &Limits::default(), &mut beside)
        .unwrap()
        .value;
    let figure = &file.character;
    let mapping = articula_build::joint_names::map(
        &figure.skeleton,
        joint_map::builtin(),
        file.humanoid.as_deref(),
    );
    let options = ClipOptions::default();
    Some(character(figure, Some(mapping.articulation), &options).unwrap())
}

/// Returns the number of directed edges between classes without an opposite edge.
fn open_edges(found: &Simplified, level: usize) -> usize {
    let mut uses = BTreeMap::<(u32, u32), i32>::new();
    for t in &found.levels[level].triangles {
        let c = t.map(|v| found.position_classes[v as usize]);
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            *uses.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
    }
    uses.values().filter(|n| **n != 0).count()
}

#[test]
fn levels_reach_their_targets_and_tear_nowhere() {
    let mut seen = 0;
    for name in FILES {
        let Some(asset) = asset(name) else { continue };
        seen += 1;
        let few = PoseOptions {
            measuring: 4,
            ..PoseOptions::default()
        };
        let chosen = poses(&asset, &few).unwrap();
        let shaping = positions(&asset, &chosen.shaping);
        let measuring = positions(&asset, &chosen.measuring);
        let options = SimplifyOptions::default();
        let found = simplify(&asset.mesh, &shaping, &options).unwrap();
        let whole = found.levels[0].triangles.len() as f64;
        for (level, share) in found.levels.iter().zip(&options.targets).take(4) {
            let most = share * whole * 1.02 + 2.0;
            let count = level.triangles.len() as f64;
            assert!(count <= most, "{name}: {count} triangles, {most} asked for");
        }
        // An edge is open if and only if the original has an open one there.
        let open = open_edges(&found, 0);
        for level in 1..5 {
            assert!(
                open_edges(&found, level) <= open,
                "{name}: level {level} tears"
            );
        }
        let resting = SimplifyOptions {
            weighting: ErrorWeighting::Rest,
            ..SimplifyOptions::default()
        };
        let resting = simplify(&asset.mesh, &shaping, &resting).unwrap();
        let [moving, resting] = [&found, &resting].map(|s| error(s, &shaping[0], &measuring));
        println!("{name}: {moving} m in motion, {resting} m by the rest pose alone");
        assert!(moving <= resting * 1.25, "{name}: poses make it worse");
    }
    if seen == 0 {
        println!("skipped: no data");
    }
}

/// Returns the maximum distance of the level with a quarter of all triangles, in metres.
fn error(found: &Simplified, rest: &[Vec3], motion: &[Vec<Vec3>]) -> f32 {
    let [quarter, whole] = [2, 0].map(|l| found.levels[l].triangles.as_slice());
    let opts = DistanceOptions::default();
    let distances = surface_distances(whole, &[quarter], rest, motion, &opts).unwrap();
    distances[0].motion.max_metres
}
