//! What a crowd gives a renderer to draw is every visible character once, and shows the plain pose of
//! each within the tolerance, whatever the source.

use crate::crowd_impostors::asset_with_impostors;
use articula::crowd::{
    CacheUse, Camera, CrowdAsset, CrowdPlayer, InstancedDraw, Instances, PaletteSlice, Viewport,
};
use articula_core::{CachedRows, PosedMesh, SkinnedMesh, Wrap, percentile, skin};
use glam::{Affine3A, Mat3, Vec3, Vec4};

/// Rows of a 3x4 matrix as a transform.
fn matrix(rows: &[[f32; 4]]) -> Affine3A {
    let [x, y, z] = [rows[0], rows[1], rows[2]].map(Vec4::from);
    let linear = Mat3::from_cols(x.truncate(), y.truncate(), z.truncate()).transpose();
    Affine3A::from_mat3_translation(linear, Vec3::new(x.w, y.w, z.w))
}

fn palette(rows: &[[f32; 4]], first: u32, count: usize) -> Vec<[f32; 4]> {
    rows[3 * first as usize..][..3 * count].to_vec()
}

/// Skinning matrices of an instance, as a renderer reads them.
fn matrices(
    crowd: &CrowdPlayer,
    draw: &InstancedDraw<'_>,
    instance: usize,
    eye: Vec3,
) -> Vec<Affine3A> {
    let PaletteSlice::Float(written) = crowd.palettes() else {
        panic!("the form is that of 32-bit floats");
    };
    let cache = crowd.asset().model().parts().cache.as_ref().unwrap();
    let CachedRows::Float(cached) = cache.rows() else {
        panic!("the form is that of 32-bit floats");
    };
    let rows = match draw.instances {
        Instances::Palettes(of) => palette(written, of[instance].first_matrix, draw.matrices),
        Instances::Steps(of) => palette(cached, of[instance].first_matrix, draw.matrices),
        Instances::Records(of) => {
            let record = of[instance];
            let before = palette(cached, record.before, draw.matrices);
            let after = palette(cached, record.after, draw.matrices);
            let pairs = before.into_iter().zip(after);
            let mix = |(a, b): ([f32; 4], [f32; 4])| Vec4::from(a).lerp(b.into(), record.blend);
            pairs.map(|pair| mix(pair).to_array()).collect()
        }
        Instances::Impostors(of) => {
            let mut flat = Vec::new();
            crowd.impostor_matrices(of[instance], eye, &mut flat);
            return flat;
        }
    };
    rows.chunks_exact(3).map(matrix).collect()
}

/// Errors in pixels at the vertices of an instance, against the clip sampled by the plain path.
fn errors_px(
    crowd: &CrowdPlayer,
    draw: &InstancedDraw<'_>,
    (instance, character): (usize, usize),
    eye: Vec3,
) -> Vec<f32> {
    let full = crowd.asset().full();
    let mesh = draw.mesh.unwrap_or(&full.mesh);
    let targets = mesh.morph_weights.len();
    let set = draw.morph_sets.clone().nth(instance);
    let weights = set.map_or(&mesh.morph_weights[..], |set| {
        &crowd.morph_weights()[set * targets..][..targets]
    });
    let mut shown = SkinnedMesh::new(mesh);
    skin(
        mesh,
        &matrices(crowd, draw, instance, eye),
        weights,
        &mut shown,
    );
    let state = *crowd.crowd().state(character).clip_state();
    let mut posed = PosedMesh::new(&full.rig, &full.mesh);
    posed.pose_at(
        &full.clips[state.clip()],
        f64::from(state.secs()),
        Wrap::Clamp,
    );
    let truth = posed.skinned(&full.mesh.morph_weights);
    assert_eq!(shown.positions.len(), truth.positions.len());
    let world = crowd.world_from_model(character);
    let density = crowd.crowd().cull_result(character).pixels_per_metre;
    let pairs = shown.positions.iter().zip(&truth.positions);
    let error = |(a, b): (&Vec3, &Vec3)| {
        let (a, b) = (world.transform_point3(*a), world.transform_point3(*b));
        (a - b).reject_from((b - eye).normalize()).length() * density
    };
    pairs.map(error).collect()
}

fn placed(asset: &CrowdAsset, cache: CacheUse) -> CrowdPlayer {
    let mut crowd = CrowdPlayer::new(asset, 72).unwrap();
    crowd.cache = cache;
    for i in 0..72 {
        let z = match i {
            0..8 => -4.0,
            8..40 => -12.0 - 6.0 * i as f32,
            _ => -900.0 - 4.0 * i as f32,
        };
        crowd.place(i, Vec3::new((i % 8) as f32 - 4.0, 0.0, z), 0.9 * i as f32);
        crowd.play(i, i % asset.clips().len(), 0.07 * i as f32);
    }
    crowd
}

#[test]
fn every_source_shows_the_plain_pose_within_the_tolerance() {
    let asset = asset_with_impostors();
    let eye = Vec3::new(0.0, 1.5, 4.0);
    let camera = Camera::looking_at(eye, Vec3::NEG_Z * 300.0, Viewport::default());
    // The GPU blends at every level, since levels share palettes; the CPU writes what it blends.
    for (cache, expected) in [
        (CacheUse::Cpu, &["impostor", "palette", "step"][..]),
        (CacheUse::Gpu, &["impostor", "record"]),
    ] {
        let mut crowd = placed(asset, cache);
        let mut sources = Vec::new();
        for _ in 0..3 {
            let report = crowd.frame(0.09, &camera);
            let mut drawn = [false; 72];
            for draw in crowd.draws() {
                sources.push(match draw.instances {
                    Instances::Palettes(_) => "palette",
                    Instances::Records(_) => "record",
                    Instances::Steps(_) => "step",
                    Instances::Impostors(_) => "impostor",
                });
                assert!(draw.instances.len() > 0);
                assert!(draw.morph_sets.len() <= draw.instances.len());
                for (instance, character) in draw.instances.characters().enumerate() {
                    assert!(!std::mem::replace(&mut drawn[character], true));
                    let found = errors_px(&crowd, &draw, (instance, character), eye);
                    let worst = found.iter().copied().fold(0.0, f32::max);
                    let mut found: Vec<f64> = found.into_iter().map(f64::from).collect();
                    let p95 = percentile(&mut found, 0.95);
                    let of = (sources.last(), draw.level, character);
                    assert!(p95 <= 1.05 && worst <= 2.1, "{of:?}: {p95} and {worst} px");
                }
            }
            let drawn = drawn.iter().filter(|d| **d).count();
            assert!(drawn == report.visible && drawn > 60, "{drawn}");
        }
        sources.sort_unstable();
        sources.dedup();
        assert_eq!(sources, expected);
    }
}
