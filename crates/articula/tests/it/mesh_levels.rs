//! Each region of a body at a mesh level of its own, written as an ordinary GLB and read again.

use crate::crowd::human;
use crate::short::shortened;
use articula::convert::{LossyPart, write};
use articula::{
    CharacterFile, ConvertOptions, Converted, Executor, Format, LevelChoice, MeshLevelOptions,
    MeshView, OpenOptions, PrepareOptions, PreparedMeshLevels, ShownLevelOptions, convert, open,
    prepare,
};
use articula_core::source::Character;
use articula_core::{Mesh, Region, Viewport, Zone, lod_error_metres};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

const LEVELS: u16 = 4;

fn again(bytes: &[u8]) -> CharacterFile {
    let nothing = &mut |_: &str| Err("nothing lies beside it".into());
    open(bytes, "written.glb", &OpenOptions::default(), nothing).unwrap()
}

/// The reference human with four levels in which head, hands and the rest are apart.
fn asset() -> CharacterFile {
    static ASSET: OnceLock<CharacterFile> = OnceLock::new();
    let asset = ASSET.get_or_init(|| {
        let human = shortened(human(), 1.0);
        let options = PrepareOptions {
            mesh_levels: PreparedMeshLevels::New(MeshLevelOptions {
                split: vec![
                    ("face".to_owned(), Zone::from(Region::Face)),
                    ("hands".to_owned(), Zone::from(Region::Hands)),
                ],
                max_error: None,
                ..MeshLevelOptions::levels(usize::from(LEVELS))
            }),
            ..PrepareOptions::default()
        };
        again(&prepare(human, &options, &Executor::default()).unwrap().glb)
    });
    asset.clone()
}

fn shown(level: LevelChoice, view: Option<MeshView>) -> articula::Result<Converted> {
    let options = ConvertOptions {
        mesh: Some(ShownLevelOptions { level, view }),
        ..ConvertOptions::default()
    };
    convert(asset(), Format::Glb, &options, &Executor::default())
}

fn mix(levels: [u16; 3]) -> LevelChoice {
    let names = ["face", "hands", "rest"].map(str::to_owned);
    LevelChoice::Regions(names.into_iter().zip(levels).collect())
}

/// Edges that have a triangle on one side only, by the places that they join. Vertices at the same
/// place with the same weights are one.
fn open_edges(character: &Character) -> BTreeSet<[[u32; 3]; 2]> {
    let mesh = Mesh::new(&character.meshes, character.skeleton.joints.len()).unwrap();
    let place = |v: u32| mesh.positions[v as usize].to_array().map(f32::to_bits);
    let mut uses: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            let [a, b] = [place(t[k]), place(t[(k + 1) % 3])];
            *uses.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    uses.retain(|[a, b], n| *n != 0 && a != b);
    uses.into_keys().collect()
}

#[test]
fn every_allowed_mix_is_closed_and_has_the_triangles_of_its_parts() {
    let stored = asset().into_character();
    let table = stored.mesh_levels.clone().unwrap();
    assert_eq!(
        table.mixable_to,
        usize::from(LEVELS) - 2,
        "all but the coarsest"
    );
    let whole: Vec<Converted> = (0..LEVELS)
        .map(|l| shown(LevelChoice::Whole(l), None).unwrap())
        .collect();
    for (l, made) in whole.iter().enumerate() {
        let report = &made.mesh.as_ref().unwrap().report;
        let row = &table.levels[l];
        assert_eq!(report.triangles as u64, row.triangles);
        assert_eq!(report.vertices as u64, row.vertices);
        assert_eq!(report.vertices_in_asset as u64, row.vertices);
        let rest = report.error_rest_m.unwrap();
        assert!(
            (rest - row.rest.max_metres).abs() < 1e-6,
            "level {l}: {rest}"
        );
        // The poses are chosen by a sample of vertices, whose order differs in the asset.
        let motion = report.error_motion_m.unwrap();
        let expected = row.motion.max_metres;
        assert!(
            (motion - expected).abs() <= 0.1 * expected + 1e-6,
            "level {l}: {motion}"
        );
    }
    let open_at_first = open_edges(&stored);
    let mixable = LEVELS - 1;
    for code in 0..mixable.pow(3) {
        let levels = [
            code / mixable / mixable,
            code / mixable % mixable,
            code % mixable,
        ];
        let made = shown(mix(levels), None).unwrap();
        let report = &made.mesh.as_ref().unwrap().report;
        let of = |l: u16| &whole[usize::from(l)].mesh.as_ref().unwrap().report;
        for (r, level) in levels.iter().enumerate() {
            assert_eq!(report.regions[r].level, *level);
            assert_eq!(report.regions[r].triangles, of(*level).regions[r].triangles);
        }
        let [finest, coarsest] = [*levels.iter().min().unwrap(), *levels.iter().max().unwrap()];
        // Each object needs a prefix of its vertices, up to the finest level of its own regions.
        assert!(report.vertices_in_asset <= of(finest).vertices);
        assert!(report.vertices <= report.vertices_in_asset);
        let error = report.error_rest_m.unwrap();
        let [least, most] = [finest, coarsest].map(|l| of(l).error_rest_m.unwrap());
        assert!(
            least * 0.99 <= error && error <= most * 1.01,
            "{levels:?}: {error} is not between {least} and {most}"
        );
        let read = again(&made.written.bytes);
        assert_eq!(read.warnings(), [], "{levels:?}");
        let open = open_edges(read.character());
        assert!(open.is_subset(&open_at_first), "{levels:?}: a gap opens");
        assert!(read.character().mesh_levels.is_none());
        let primitives = read.character().meshes.iter().flat_map(|m| &m.primitives);
        // A part that vanishes keeps one triangle without area.
        let has_area = |t: &&[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        let drawn = primitives.clone().flat_map(|p| &p.triangles);
        let triangles = drawn.filter(has_area).count();
        assert_eq!(triangles, report.triangles, "{levels:?}");
        for primitive in primitives {
            let used: BTreeSet<u32> = primitive.triangles.iter().flatten().copied().collect();
            assert_eq!(used.len(), primitive.positions.len(), "{levels:?}");
        }
        assert_eq!(read.character().materials, stored.materials);
        assert_eq!(read.character().clips.len(), stored.clips.len());
        let document = read.gltf().unwrap().document.clone();
        assert_eq!(
            document.motion_table(0, "segs"),
            None,
            "made for other vertices"
        );
    }
}

#[test]
fn head_fine_body_coarse_keeps_every_triangle_of_the_head() {
    let made = shown(mix([0, 1, 2]), None).unwrap();
    let report = &made.mesh.unwrap().report;
    let [face, hands, rest] = &report.regions[..] else {
        panic!("{:?}", report.regions);
    };
    assert_eq!(face.triangles, face.triangles_before);
    assert!(face.triangles > 100, "the head, not the eyes alone");
    assert!(hands.triangles < hands.triangles_before);
    assert!(3 * rest.triangles < 2 * rest.triangles_before);
    let named = LevelChoice::Regions(vec![("rest".into(), 1), ("hands".into(), 0)]);
    let made = shown(named, None).unwrap();
    let levels = made.mesh.unwrap().report.regions;
    let levels: Vec<u16> = levels.iter().map(|r| r.level).collect();
    assert_eq!(levels, [1, 0, 1], "rest names all others");
}

#[test]
fn mixes_that_would_tear_are_refused() {
    let refused = |level| shown(level, None).unwrap_err().to_string();
    let line = refused(mix([0, 0, LEVELS - 1]));
    assert!(
        line.contains("region \"rest\"") && line.contains("0 to 2"),
        "{line}"
    );
    assert!(refused(LevelChoice::Whole(9)).contains("the levels are 0 to 3"));
    let line = refused(LevelChoice::Regions(vec![("tail".into(), 1)]));
    assert!(line.contains("face, hands, rest"), "{line}");
    let options = ConvertOptions {
        mesh: Some(ShownLevelOptions::default()),
        ..ConvertOptions::default()
    };
    let line = convert(human(), Format::Glb, &options, &Executor::default()).unwrap_err();
    assert!(line.to_string().contains("no levels"), "{line}");
    let line = convert(asset(), Format::Bvh, &options, &Executor::default()).unwrap_err();
    assert!(
        line.is_argument() && line.to_string().contains(".glb"),
        "{line}"
    );
}

#[test]
fn a_distance_chooses_the_coarsest_level_within_the_tolerance() {
    let table = asset().into_character().mesh_levels.unwrap();
    let viewport = Viewport::default();
    let mut last = 0;
    for distance_m in [0.5, 2.0, 5.0, 15.0, 60.0, 1e4] {
        let view = MeshView {
            distance_m,
            epsilon_px: 1.0,
            viewport,
        };
        let made = shown(LevelChoice::ByError, Some(view)).unwrap();
        let report = &made.mesh.unwrap().report;
        let level = usize::from(report.regions[0].level);
        let px = |l: usize| {
            let motion = &table.levels[l].motion;
            let metres = lod_error_metres(motion.p95_metres, motion.max_metres);
            metres * viewport.height_px / (2.0 * (viewport.fov_y_radians / 2.0).tan() * distance_m)
        };
        assert!(px(level) <= 1.0, "{distance_m} m");
        assert!(level + 1 == table.levels.len() || px(level + 1) > 1.0);
        assert!(level >= last);
        last = level;
        let view = report.view.unwrap();
        let within = view.from_m.is_none_or(|from| from <= distance_m * 1.001);
        assert!(
            within && view.to_m.is_none_or(|to| to >= distance_m),
            "{view:?}"
        );
    }
    assert_eq!(last, table.levels.len() - 1);
}

#[test]
fn x3d_holds_the_finest_level_and_tells_the_others() {
    let asset = asset();
    let told = write(&asset, Format::X3d).unwrap().left_out;
    let coarser = usize::from(LEVELS - 1) * asset.character().meshes.len();
    assert!(told.contains(&LossyPart::MeshLevels(coarser)), "{told:?}");
}
