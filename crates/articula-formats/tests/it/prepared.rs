//! Parts of a prepared asset: they come back, and any other bytes are an error.

use articula_core::crowd::{RootDelta, RootTrajectory};
use articula_core::source::{Channel, Interpolation, Property, RawClip};
use articula_core::{
    Articulation, Binding, Bound, CachedKeys, CachedSteps, Clip, ClipBounds, ClipLodErrors,
    FigureLevel, JointArticulation, JointLods, LevelSkin, LevelSkins, LodErrors, Mesh,
    MotionBounds, PaletteMap, Region, Rig, Sphere, Track, Tracks, Transform,
};
use articula_formats::prepared::{
    CACHE_KEYS_VERSION, CacheKeys, ClipsInPlace, JointLevels, PairedLevels, SourceOrder,
    read_cache_keys, read_clips, read_clips_in_place, read_joint_levels, read_level_skins,
    read_motion_bounds, read_paired_levels, read_source_orders, restore_order, write_cache_keys,
    write_clips, write_clips_in_place, write_joint_levels, write_level_skins, write_motion_bounds,
    write_paired_levels, write_source_orders,
};
use articula_formats::{Limits, ReadError};
use articula_mutate::{Edit, Mutations};
use glam::{Affine3A, Quat, Vec3};
use proptest::prelude::*;

/// Number of mutations of each part.
const TRIES: usize = 2000;

fn limits() -> Limits {
    Limits::default()
}

fn track<T>(target: u16, step: bool, values: Vec<T>) -> Track<T> {
    Track {
        target,
        step,
        values,
    }
}

fn turns(frames: usize, radians: f32) -> Vec<Quat> {
    let turn = |i: usize| Quat::from_rotation_y(radians * i as f32);
    (0..frames).map(turn).collect()
}

/// A clip of three joints with tracks of every kind.
fn clip(name: &str, frames: usize) -> Clip {
    let places = (0..frames).map(|i| Vec3::new(i as f32, 1.0, -0.5));
    let tracks = Tracks {
        translations: vec![
            track(0, false, places.collect()),
            track(1, false, vec![Vec3::X; frames]),
        ],
        rotations: vec![
            track(0, false, turns(frames, 0.2)),
            track(2, true, turns(frames, 0.4)),
            track(1, false, turns(1, 0.3)),
        ],
        scales: vec![track(2, false, vec![Vec3::splat(2.0)])],
        morphs: vec![track(
            5,
            false,
            (0..frames).map(|i| i as f32 / 9.0).collect(),
        )],
    };
    let clip = Clip::new(name, 25.0, frames, 3, tracks).unwrap();
    clip.with_frames_per_key(2)
}

/// A source whose keys are the rotations of joint 0 in [`clip`], with other signs.
fn source(frames: usize) -> RawClip {
    let keys = turns(frames, 0.2).into_iter().enumerate();
    let keys = keys.map(|(i, q)| if i == 3 { -q } else { q });
    RawClip {
        name: "walk".into(),
        duration_secs: (frames - 1) as f32 / 25.0,
        channels: vec![Channel {
            target: 0,
            property: Property::Rotation,
            interpolation: Interpolation::Linear,
            times_secs: (0..frames).map(|i| i as f32 / 25.0).collect(),
            values: keys.flat_map(|q| q.to_array()).collect(),
        }],
    }
}

fn in_place(clips: &[Clip]) -> ClipsInPlace {
    let mut tracks = clips[0].tracks().clone();
    tracks.translations[0].values.fill(Vec3::Y);
    let still = Clip::new("walk", 25.0, clips[0].frames(), 3, tracks).unwrap();
    let place = |i: usize| RootDelta {
        offset: Vec3::Z * i as f32,
        yaw_radians: 0.1 * i as f32,
    };
    let places = (0..clips[0].frames()).map(place).collect();
    ClipsInPlace {
        travelling: vec![
            Some((
                still.with_frames_per_key(2),
                RootTrajectory::new(25.0, places).unwrap(),
            )),
            None,
        ],
        warnings: vec!["the root motion of clip \"über\" is not extracted".into()],
    }
}

/// Three joints in a chain.
fn rig() -> Rig {
    let joint = |i: usize| articula_core::source::Joint {
        name: format!("j{i}"),
        parent: i.checked_sub(1),
        rest: Transform::from_translation(Vec3::Y * i as f32),
        in_skin: true,
    };
    let skeleton = articula_core::source::Skeleton {
        joints: (0..3).map(joint).collect(),
    };
    let entry = JointArticulation {
        hanim: None,
        level: 0,
        region: Region::Torso,
    };
    let articulation = Articulation {
        profile: String::new(),
        joints: vec![entry; 3],
    };
    Rig::new(&skeleton, articulation).unwrap()
}

fn lods(rig: &Rig) -> JointLods {
    JointLods::new(rig, vec![0, 1, 2], vec![3, 2, 1], rig.rest_pose()).unwrap()
}

fn errors(levels: usize) -> LodErrors {
    let rising = |step: f32| (0..levels).map(|l| step * l as f32).collect();
    LodErrors {
        clips: vec![ClipLodErrors {
            levels_metres: rising(0.001),
            worst_metres: rising(0.004),
            speed_metres_per_sec: 1.5,
            seam_metres: 0.25,
        }],
    }
}

/// Four vertices on three joints, two of them on two.
fn mesh(rig: &Rig) -> Mesh {
    let binding = |joint: u16| Binding {
        joint,
        inverse_bind: Affine3A::from_translation(-Vec3::Y * f32::from(joint)),
    };
    assert_eq!(rig.len(), 3);
    Mesh {
        positions: (0..4).map(|v| Vec3::Y * v as f32).collect(),
        normals: vec![Vec3::Z; 4],
        influences: 2,
        binding_indices: vec![2, 2, 2, 1, 1, 0, 0, 0],
        weights: vec![1.0, 0.0, 0.5, 0.5, 0.75, 0.25, 1.0, 0.0],
        // Another order than that of the levels.
        bindings: vec![binding(2), binding(1), binding(0)],
        ..Mesh::default()
    }
}

/// The skin of every level: merged joints hang on their parents.
fn skins(mesh: &Mesh, lods: &JointLods) -> LevelSkins {
    let mut bindings: Vec<Binding> = mesh.bindings.clone();
    bindings.reverse();
    let level =
        |palette: usize, influences, binding_indices: Vec<u16>, weights: Vec<f32>| LevelSkin {
            positions: mesh
                .positions
                .iter()
                .map(|p| *p + Vec3::X * (3 - palette) as f32)
                .collect(),
            normals: mesh.normals.clone(),
            influences,
            binding_indices,
            weights,
            morphs: Vec::new(),
            palette,
        };
    let placed: Vec<(u16, Affine3A)> = bindings.iter().map(|b| (b.joint, b.inverse_bind)).collect();
    LevelSkins {
        palette: PaletteMap::skin(lods, &placed).unwrap(),
        bindings,
        levels: vec![
            level(3, 2, vec![0, 0, 0, 1, 1, 2, 2, 2], mesh.weights.clone()),
            level(
                2,
                2,
                vec![0, 0, 0, 1, 1, 1, 1, 1],
                vec![1.0, 0.0, 0.5, 0.5, 1.0, 0.0, 1.0, 0.0],
            ),
            level(1, 1, vec![0; 4], vec![1.0; 4]),
        ],
    }
}

fn bounds() -> MotionBounds {
    let second = |k: usize| Bound {
        sphere: Sphere {
            centre: Vec3::X * k as f32,
            radius: 1.0,
        },
        least: Vec3::splat(-1.0),
        greatest: Vec3::splat(1.0 + k as f32),
    };
    let seconds = (0..ClipBounds::count(2.5)).map(second).collect();
    MotionBounds {
        clips: vec![ClipBounds::new(2.5, seconds, Sphere::default()).unwrap()],
        reach_metres: 1.25,
    }
}

fn orders() -> Vec<SourceOrder> {
    vec![
        SourceOrder {
            vertices: vec![2, 0, 3, 1],
            triangles: vec![[3, 0, 1], [1, 2, 3]],
        },
        SourceOrder::default(),
    ]
}

fn cache_keys() -> CacheKeys {
    let keys = CachedKeys {
        times_secs: vec![0.0, 0.5, 1.75],
        first_matrix: 300,
        error_metres: 0.001,
    };
    let steps = CachedSteps {
        count: 200,
        first_matrix: 309,
        error_metres: 0.25,
        blend_error_metres: Some(0.125),
    };
    let unblended = CachedSteps {
        blend_error_metres: None,
        ..steps
    };
    CacheKeys {
        keys: vec![vec![None, Some(keys.clone())], vec![Some(keys), None]],
        steps: vec![vec![None, Some(steps)], vec![None, Some(unblended)]],
    }
}

fn paired() -> PairedLevels {
    let level = |joints: usize| FigureLevel {
        joint_level: 3 - joints,
        mesh_level: 0,
        joints,
        triangles: 100 * joints,
        vertices: 60 * joints,
        influences: 2,
        cost: joints as f32,
    };
    PairedLevels {
        levels: vec![level(3), level(1)],
        errors: errors(2),
    }
}

#[test]
fn every_part_comes_back() {
    let (rig, clips) = (rig(), [clip("walk", 7), clip("sit", 4)]);
    let (lods, mesh) = (lods(&rig), mesh(&rig));
    let sources = [source(7)];
    let bytes = write_clips(&clips, &sources);
    assert_eq!(read_clips(&bytes, &sources, &limits()).unwrap(), clips);
    let alone = write_clips(&clips, &[]);
    // Seven quaternions are those of the source.
    assert_eq!(alone.len() - bytes.len(), 7 * 16);
    assert!(
        read_clips(&bytes, &[], &limits()).is_err(),
        "the source is missing"
    );

    let placed = in_place(&clips);
    let bytes = write_clips_in_place(&placed, &clips);
    assert_eq!(
        read_clips_in_place(&bytes, &clips, &limits()).unwrap(),
        placed
    );
    assert!(bytes.len() < write_clips_in_place(&placed, &[]).len());

    let levels = JointLevels {
        joint_lods: lods.clone(),
        errors: errors(3),
    };
    let bytes = write_joint_levels(&levels);
    assert_eq!(read_joint_levels(&bytes, &rig, &limits()).unwrap(), levels);

    let skins = skins(&mesh, &lods);
    let bytes = write_level_skins(&skins, &mesh);
    assert_eq!(
        read_level_skins(&bytes, &mesh, &lods, &limits()).unwrap(),
        skins
    );

    let bytes = write_motion_bounds(&bounds());
    assert_eq!(read_motion_bounds(&bytes, &limits()).unwrap(), bounds());
    let bytes = write_paired_levels(&paired());
    assert_eq!(read_paired_levels(&bytes, &limits()).unwrap(), paired());
    let CacheKeys { keys, steps } = cache_keys();
    let bytes = write_cache_keys(&keys, &steps);
    let read = |bytes: &[u8], version| read_cache_keys(bytes, version, &limits()).unwrap();
    assert_eq!(read(&bytes, CACHE_KEYS_VERSION), cache_keys());
    let bytes = write_source_orders(&orders());
    assert_eq!(read_source_orders(&bytes, &limits()).unwrap(), orders());
}

/// Version 1 of the part had no steps: a clip, a level, two keys.
#[test]
fn cache_keys_of_version_1_have_no_steps() {
    let mut bytes = vec![1, 1, 2, 0xac, 0x02];
    for number in [0.125f32, 0.0, 1.5] {
        bytes.extend(number.to_le_bytes());
    }
    let keys = CachedKeys {
        times_secs: vec![0.0, 1.5],
        first_matrix: 300,
        error_metres: 0.125,
    };
    let expected = CacheKeys {
        keys: vec![vec![Some(keys)]],
        steps: vec![vec![None]],
    };
    assert_eq!(read_cache_keys(&bytes, 1, &limits()).unwrap(), expected);
    assert!(read_cache_keys(&bytes, CACHE_KEYS_VERSION, &limits()).is_err());
}

/// Versions 2 and 3 had no errors of blends: a clip, a level, no keys, 200 palettes.
#[test]
fn cache_keys_of_versions_2_and_3_have_no_errors_of_blends() {
    let mut bytes = vec![1, 1, 0, 0xc8, 0x01, 0xac, 0x02];
    bytes.extend(0.25f32.to_le_bytes());
    let steps = CachedSteps {
        count: 200,
        first_matrix: 300,
        error_metres: 0.25,
        blend_error_metres: None,
    };
    let expected = CacheKeys {
        keys: vec![vec![None]],
        steps: vec![vec![Some(steps)]],
    };
    for version in [2, 3] {
        assert_eq!(
            read_cache_keys(&bytes, version, &limits()).unwrap(),
            expected
        );
    }
    assert!(read_cache_keys(&bytes, CACHE_KEYS_VERSION, &limits()).is_err());
}

/// Checks that a part that is cut short is an error, and that mutations of it never panic.
fn endure<T>(bytes: &[u8], read: impl Fn(&[u8]) -> Result<T, ReadError>) {
    for end in 0..bytes.len() {
        assert!(
            read(&bytes[..end]).is_err(),
            "cut at {end} of {}",
            bytes.len()
        );
    }
    let mut longer = bytes.to_vec();
    longer.push(0);
    assert!(read(&longer).is_err(), "a byte too many");
    let mutations = Mutations {
        edits: &[Edit::FlipBit, Edit::Delete(4), Edit::SetByte],
        most: 3,
    };
    let good = mutations.read_of(bytes, TRIES, |bytes| read(bytes).is_ok());
    assert!(good < TRIES, "no mutant was refused");
}

#[test]
fn other_bytes_are_errors_and_never_a_panic() {
    let (rig, clips) = (rig(), [clip("walk", 7), clip("sit", 4)]);
    let (lods, mesh, sources) = (lods(&rig), mesh(&rig), [source(7)]);
    endure(&write_clips(&clips, &sources), |b| {
        read_clips(b, &sources, &limits())
    });
    endure(&write_clips_in_place(&in_place(&clips), &clips), |b| {
        read_clips_in_place(b, &clips, &limits())
    });
    let levels = JointLevels {
        joint_lods: lods.clone(),
        errors: errors(3),
    };
    endure(&write_joint_levels(&levels), |b| {
        read_joint_levels(b, &rig, &limits())
    });
    let skins = write_level_skins(&skins(&mesh, &lods), &mesh);
    endure(&skins, |b| read_level_skins(b, &mesh, &lods, &limits()));
    endure(&write_motion_bounds(&bounds()), |b| {
        read_motion_bounds(b, &limits())
    });
    endure(&write_paired_levels(&paired()), |b| {
        read_paired_levels(b, &limits())
    });
    let CacheKeys { keys, steps } = cache_keys();
    endure(&write_cache_keys(&keys, &steps), |b| {
        read_cache_keys(b, CACHE_KEYS_VERSION, &limits())
    });
    endure(&write_source_orders(&orders()), |b| {
        read_source_orders(b, &limits())
    });
}

#[test]
fn a_small_part_cannot_ask_for_much_memory() {
    let few = Limits {
        elements: 1000,
        ..limits()
    };
    // A constant track of a million frames takes one value in the file.
    let long = Clip::new(
        "long",
        30.0,
        1 << 20,
        1,
        Tracks {
            scales: vec![track(0, false, vec![Vec3::ONE; 1 << 20])],
            ..Tracks::default()
        },
    );
    let bytes = write_clips(&[long.unwrap()], &[]);
    assert!(bytes.len() < 64);
    let why = read_clips(&bytes, &[], &few).unwrap_err().to_string();
    assert!(why.contains("limit"), "{why}");
}

proptest! {
    #[test]
    fn any_order_is_restored(keys in prop::collection::vec(any::<u32>(), 1..40)) {
        // The ranks of random keys are a permutation.
        let mut order: Vec<u32> = (0..keys.len() as u32).collect();
        order.sort_by_key(|i| (keys[*i as usize], *i));
        let place = |v: u32| Vec3::X * v as f32;
        let source = articula_core::source::Primitive {
            positions: (0..keys.len() as u32).map(place).collect(),
            influences: 1,
            joints: (0..keys.len() as u16).collect(),
            weights: vec![1.0; keys.len()],
            triangles: vec![[0, 0, (keys.len() - 1) as u32]],
            ..articula_core::source::Primitive::default()
        };
        let stored = articula_core::source::Primitive {
            positions: order.iter().map(|v| place(*v)).collect(),
            joints: order.iter().map(|v| *v as u16).collect(),
            triangles: Vec::new(),
            ..source.clone()
        };
        let orders = vec![SourceOrder { vertices: order, triangles: source.triangles.clone() }];
        let bytes = write_source_orders(&orders);
        prop_assert_eq!(&read_source_orders(&bytes, &limits()).unwrap(), &orders);
        let mesh = articula_core::source::RawMesh {
            primitives: vec![stored],
            ..articula_core::source::RawMesh::default()
        };
        let restored = restore_order(&[mesh], &orders).unwrap();
        prop_assert_eq!(&restored[0].primitives[0], &source);
    }
}

#[test]
fn an_order_of_another_mesh_is_refused() {
    let mesh = |vertices: usize| articula_core::source::RawMesh {
        primitives: vec![articula_core::source::Primitive {
            positions: vec![Vec3::ZERO; vertices],
            influences: 1,
            ..articula_core::source::Primitive::default()
        }],
        ..articula_core::source::RawMesh::default()
    };
    let order = |vertices: &[u32], triangles: &[[u32; 3]]| {
        vec![SourceOrder {
            vertices: vertices.to_vec(),
            triangles: triangles.to_vec(),
        }]
    };
    let at =
        |vertices, order: &[SourceOrder]| restore_order(&[mesh(vertices)], order).unwrap_err().at;
    assert_eq!(at(3, &[]), "orders");
    assert_eq!(
        at(3, &order(&[0, 1], &[])),
        "meshes[0].primitives[0].vertices"
    );
    assert_eq!(
        at(2, &order(&[0, 0], &[])),
        "meshes[0].primitives[0].vertices"
    );
    assert_eq!(
        at(2, &order(&[0, 2], &[])),
        "meshes[0].primitives[0].vertices"
    );
    assert_eq!(
        at(2, &order(&[1, 0], &[[0, 1, 2]])),
        "meshes[0].primitives[0].triangles[0]"
    );
    assert!(restore_order(&[mesh(2)], &order(&[1, 0], &[[0, 1, 1]])).is_ok());
}
