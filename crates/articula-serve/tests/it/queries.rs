//! What is made of a character by query: files as one GLB, and cuts.

use crate::client::{Answer, Server, options};
use crate::{judges, real};
use articula::core::source::Image;
use articula::formats::Limits;
use articula::item::{
    AdaptOptions, AdaptedItem, Item, ItemLayer, Manifest, MeshLevelEntry, adapt, decide,
};
use articula::optimize::{Compression, OptimizeOptions, TextureFormat, TextureOptions, optimize};
use articula::stream::description::Context;
use articula::{CharacterFile, Executor, OpenOptions, open};

/// Waits until all of a character is made.
pub(crate) fn ready(server: &Server, name: &str) -> Manifest {
    let path = format!("/v1/characters/{name}/manifest.json");
    let mut tag = String::new();
    loop {
        let answer = server.get(&format!("{path}?wait=60"), &[("If-None-Match", &tag)]);
        answer.header("etag").clone_into(&mut tag);
        if answer.header("articula-state") == "ready" {
            let manifest = server.get(&path, &[]);
            return serde_json::from_slice(&manifest.body).unwrap();
        }
    }
}

fn opened(glb: &[u8]) -> CharacterFile {
    let mut nothing = |_: &str| Err("nothing".to_owned());
    open(glb, "made.glb", &OpenOptions::default(), &mut nothing).unwrap()
}

fn triangles(file: &CharacterFile) -> usize {
    let primitives = file.character().meshes.iter().flat_map(|m| &m.primitives);
    primitives.map(|p| p.triangles.len()).sum()
}

/// Number of channels of the first clip whose values change.
fn moved(file: &CharacterFile) -> usize {
    let channels = file.character().clips[0].channels.iter();
    let changes = |c: &&articula::core::source::Channel| {
        let width = c.values.len() / c.times_secs.len();
        c.values.chunks(width).any(|row| row != &c.values[..width])
    };
    channels.filter(changes).count()
}

fn morphs(file: &CharacterFile) -> Vec<&str> {
    let names = file.character().meshes.iter().flat_map(|m| &m.morph_names);
    names.map(String::as_str).collect()
}

pub(crate) fn counter(server: &Server, name: &str) -> u64 {
    let text = String::from_utf8(server.get("/metrics", &[]).body).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix(name));
    line.unwrap().trim().parse().unwrap()
}

fn refused(answer: &Answer, status: u16) -> String {
    assert_eq!(answer.status, status);
    answer.json()["error"].as_str().unwrap().to_owned()
}

#[test]
fn a_character_is_one_glb_of_what_a_query_asks_for() {
    let (Some(man), Some(head), Some(robot)) = (
        real::bytes("glb/CesiumMan.glb"),
        real::bytes("glb/ict_head_talk_554.glb"),
        real::bytes("vrm/debug_robot.vrm"),
    ) else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("man.glb"), man).unwrap();
    std::fs::write(folder.path().join("head.glb"), head).unwrap();
    std::fs::write(folder.path().join("robot.vrm"), robot).unwrap();
    let mut options = options();
    options.package.mesh_levels = 3;
    let server = Server::start(folder.path(), &options);
    let manifest = ready(&server, "man");
    ready(&server, "head");
    ready(&server, "robot");
    let mut made = Files(&server, Vec::new());

    // Two clients that ask at the same time get one file, which is made once.
    let whole = std::thread::scope(|scope| {
        let both = [(); 2].map(|()| scope.spawn(|| server.get("/v1/characters/man.glb", &[])));
        let [first, second] = both.map(|thread| thread.join().unwrap());
        assert_eq!((first.status, &first.body), (200, &second.body));
        first
    });
    assert_eq!(counter(&server, "articula_made_total"), 1);
    let again = server.get(
        "/v1/characters/man.glb",
        &[("If-None-Match", whole.header("etag"))],
    );
    assert_eq!(
        (again.status, again.header("etag")),
        (304, whole.header("etag"))
    );
    let whole = opened(&whole.body);
    levels_and_motions(&mut made, &manifest, &whole);
    morph_targets(&mut made);
    texture_atlas(&mut made);
    compression(&mut made);
    valid(&made.1);

    cut(&server, &manifest);
    wrong(&server, levels(&manifest).last().unwrap().level);
    drop(server);
    options.read_only = true;
    let server = Server::start(folder.path(), &options);
    assert_eq!(server.get("/v1/characters/man.glb?lod=2", &[]).status, 200);
    let other = server.get("/v1/characters/man.glb?lod=1", &[]);
    assert!(refused(&other, 403).contains("read-only"));
    drop(server);
    // As many are kept as may be.
    (options.read_only, options.most_made) = (false, 1);
    let server = Server::start(folder.path(), &options);
    assert_eq!(server.get("/v1/characters/man.glb?lod=2", &[]).status, 200);
    let other = server.get("/v1/characters/man.glb?lod=1", &[]);
    assert!(refused(&other, 507).contains("queries"));
}

/// The files that a server makes.
struct Files<'a>(&'a Server, Vec<Vec<u8>>);

impl Files<'_> {
    fn get(&mut self, query: &str) -> CharacterFile {
        let answer = self.0.get(&format!("/v1/characters/{query}"), &[]);
        assert_eq!(answer.status, 200, "{query}: {answer:?}");
        assert_eq!(answer.header("content-type"), "model/gltf-binary");
        let file = opened(&answer.body);
        self.1.push(answer.body);
        file
    }
}

fn levels(manifest: &Manifest) -> &[MeshLevelEntry] {
    let mut parts = manifest.parts.iter();
    &parts.find(|part| !part.levels.is_empty()).unwrap().levels
}

fn levels_and_motions(made: &mut Files<'_>, manifest: &Manifest, whole: &CharacterFile) {
    let levels = levels(manifest);
    let count = |file: &CharacterFile| triangles(file) as u64;
    assert_eq!(count(whole), levels[0].triangles);
    assert_eq!(whole.character().clips.len(), 1);
    let low = made.get("man.glb?lod=2");
    // The finest of a quarter of the triangles, or the coarsest.
    let quarter = |level: &&MeshLevelEntry| 4 * level.triangles <= levels[0].triangles;
    let right = levels.iter().find(quarter).or(levels.last()).unwrap();
    assert!(right.level > 0 && count(&low) == right.triangles);
    assert_eq!(count(&made.get("man.glb?mesh=1")), levels[1].triangles);
    let still = made.get("man.glb?clip=none");
    assert!(still.character().clips.is_empty());
    let name = &whole.character().clips[0].name;
    let few = made.get(&format!(
        "man.glb?clip={name}&loa=0&lod=0&textureSizeLimit=256"
    ));
    assert!(count(&few) == count(whole) && moved(&few) < moved(whole));
    // Its picture is the largest of the item that the limit allows.
    let sizes = manifest.parts.iter().flat_map(|part| &part.layers);
    let side = |layer: &&ItemLayer| layer.size_px.map_or(0, |[w, h]| w.max(h));
    let fits = sizes.filter(|layer| (1..=256).contains(&side(layer)));
    let picture = fits.max_by_key(side).unwrap().file.as_ref().unwrap();
    let picture = made
        .0
        .get(&format!("/v1/characters/man/{picture}"), &[])
        .body;
    let has = |glb: &[u8]| glb.windows(picture.len()).any(|bytes| bytes == picture);
    let glb = |which: usize| made.1.iter().nth_back(which).unwrap();
    assert!(has(glb(0)) && !has(glb(1)));
    // Without the channel of base colours a picture is a pixel of its mean colour, and all else is there.
    let plain = made.get("man.glb?textureChannels=none");
    let is_pixel = |image: &Image| image.bytes.get(16..24) == Some(&[0, 0, 0, 1, 0, 0, 0, 1][..]);
    assert!(!plain.character().images.is_empty());
    assert!(plain.character().images.iter().all(is_pixel));
    assert!(!whole.character().images.iter().all(is_pixel));
    assert_eq!(
        (count(&plain), plain.character().clips.len()),
        (count(whole), 1)
    );
    for [one, other] in [
        ["?textureChannels=none", "?textureChannels=normal,occlusion"],
        ["", "?textureChannels=baseColor,normal"],
    ] {
        for query in [one, other] {
            made.get(&format!("man.glb{query}"));
        }
        let [other, one] = [0, 1].map(|which| made.1.iter().nth_back(which).unwrap());
        assert!(one == other);
    }
    // A quality is what it stands for, unless that is asked for too.
    for [one, other] in [
        ["quality=low", "lod=2&textureSizeLimit=256"],
        ["mesh=0&quality=medium", "mesh=0&textureSizeLimit=512"],
        [
            "lod=0&quality=low&textureSizeLimit=512",
            "lod=0&textureSizeLimit=512",
        ],
    ] {
        made.get(&format!("man.glb?{one}"));
        made.get(&format!("man.glb?{other}"));
        let [other, one] = [0, 1].map(|which| made.1.iter().nth_back(which).unwrap());
        assert!(one == other);
    }
}

fn morph_targets(made: &mut Files<'_>) {
    let all = made.get("head.glb");
    let names = morphs(&all);
    assert!(names.contains(&"jawOpen") && names.len() > 10, "{names:?}");
    let two = made.get("head.glb?morphTargets=eyeBlink_L,jawOpen");
    assert_eq!(morphs(&two).len(), 2);
    assert!(morphs(&two).contains(&"eyeBlink_L"));
    let none = made.get("head.glb?morphTargets=none");
    assert!(morphs(&none).is_empty() && triangles(&none) == triangles(&all));
    let arkit = made.get("head.glb?morphTargets=ARKit");
    assert!(
        morphs(&arkit).contains(&"eyeBlink_L"),
        "under another spelling"
    );
}

fn texture_atlas(made: &mut Files<'_>) {
    let plain = made.get("robot.glb?textureAtlas=none");
    let merged = made.get("robot.glb?textureAtlas=256");
    let materials = |file: &CharacterFile| file.character().materials.len();
    let images = |file: &CharacterFile| file.character().images.len();
    assert_eq!(materials(&merged), materials(&plain));
    assert!(images(&plain) == 3 && images(&merged) < 3);
    let name = |image: &Image| image.name == "atlas";
    assert!(merged.character().images.iter().any(name));
}

fn compression(made: &mut Files<'_>) {
    let plain = made.get("man.glb?mesh=0");
    let plain_bytes = made.1.last().unwrap().clone();
    for (word, compression) in [
        ("ext", Compression::Ext),
        ("khr", Compression::Khr),
        ("quantize", Compression::Quantized),
    ] {
        let small = made.get(&format!("man.glb?compression={word}&mesh=0"));
        let options = OptimizeOptions {
            compression,
            simplify: false,
            textures: TextureOptions {
                format: TextureFormat::Keep,
                ..TextureOptions::default()
            },
            ..OptimizeOptions::default()
        };
        let expected = optimize(&plain, &options, &Executor::default()).unwrap();
        let bytes = made.1.last().unwrap();
        assert!(*bytes == expected.glb, "{word}");
        assert!(bytes.len() < plain_bytes.len(), "{word}");
        assert_eq!(triangles(&small), triangles(&plain));
    }
    made.get("man.glb?compression=none&mesh=0");
    assert_eq!(*made.1.last().unwrap(), plain_bytes);
}

/// Compares a cut with what `adapt` makes of the item, whose files a client has.
fn cut(server: &Server, manifest: &Manifest) {
    let object = |hash: &str| server.get(&format!("/v1/o/{hash}"), &[]).body;
    let whole = server.get("/v1/characters/man/manifest.json", &[]).body;
    let mut file = |name: &str| {
        let entry = manifest.files.get(name).ok_or("an index")?;
        Ok(object(&entry.hash))
    };
    let item = Item::open(&whole, &Limits::default(), &mut file).unwrap();
    let mut context = Context::default();
    context.preferences.body_loa = Some(1);
    context.preferences.mesh_level = Some(1);
    let options = AdaptOptions {
        finest_tier: 2,
        max_texture_px: Some(256),
        ..AdaptOptions::default()
    };
    let decided = decide(&item, &context, &options).unwrap();
    let Ok(AdaptedItem::Layers(right)) = adapt(&item, &decided.cut.unwrap()) else {
        panic!("no layers");
    };
    let path = "/v1/characters/man/cut?loa=1&mesh=1&texture=256&tier=2";
    let made = server.get(path, &[]);
    assert_eq!(made.status, 200);
    let files = right.files();
    assert!(made.body == files.last().unwrap().1 && made.body != whole);
    let of: Manifest = serde_json::from_slice(&made.body).unwrap();
    let is_new = |name: &&String| of.files[*name].hash != manifest.files[*name].hash;
    assert!(
        of.files.keys().any(|name| is_new(&name)),
        "streams were cut"
    );
    for (name, entry) in &of.files {
        assert!(right.file(name) == Some(&object(&entry.hash)), "{name}");
    }
    let other = server.get(
        "/v1/characters/man/cut?tier=2&loa=1&mesh=1&texture=0256",
        &[],
    );
    let canonical = path.rsplit('/').next().unwrap();
    assert_eq!((other.status, other.header("location")), (308, canonical));
    let answer = server.get("/v1/characters/man/cut?tier=9", &[]);
    assert!(refused(&answer, 400).contains("tier: found 9, expected a whole number from 0 to "));
}

/// Queries that are wrong, or written in another way than the canonical one.
fn wrong(server: &Server, coarsest: u32) {
    let mesh = format!("mesh: found 9, expected a whole number from 0 to {coarsest}");
    let made = counter(server, "articula_made_total");
    for (query, told) in [
        (
            "size=3",
            "clip, compression, loa, lod, mesh, morphTargets, quality, textureAtlas, textureChannels, textureSizeLimit",
        ),
        ("lod=1&lod=1", "lod: given twice"),
        ("lod=3", "lod: found 3, expected a whole number from 0 to 2"),
        (
            "compression=zip",
            "compression: found \"zip\", expected one of ext, khr, quantize, none",
        ),
        ("textureSizeLimit=128", "from 256 to 1024"),
        (
            "textureAtlas=one",
            "textureAtlas: found one, expected none or a whole number from 64 to 4096",
        ),
        ("quality=best", "high, medium, low"),
        ("loa=6", "loa: found 6, expected a whole number from 0 to 5"),
        ("mesh=9", &mesh),
        ("lod=1&mesh=1", "leave one of them out"),
        ("clip=fly", "clip: found \"fly\", expected one of "),
        ("morphTargets=none,jawOpen", "none stands alone"),
        ("textureChannels=none,baseColor", "none stands alone"),
        (
            "textureChannels=roughness",
            "textureChannels: found \"roughness\", expected one of ",
        ),
        ("morphTargets=", "morphTargets: a name is empty"),
        (
            "morphTargets=smile",
            "morphTargets: found \"smile\", expected one of none, ARKit",
        ),
    ] {
        let answer = server.get(&format!("/v1/characters/man.glb?{query}"), &[]);
        let why = refused(&answer, 400);
        assert!(why.contains(told), "{query}: {why}");
    }
    for (query, canonical) in [
        (
            "textureSizeLimit=0512&lod=01",
            "man.glb?lod=1&textureSizeLimit=512",
        ),
        ("morphTargets=b%2ca", "man.glb?morphTargets=a,b"),
        ("&", "man.glb?"),
    ] {
        let answer = server.get(&format!("/v1/characters/man.glb?{query}"), &[]);
        assert_eq!((answer.status, answer.header("location")), (308, canonical));
    }
    assert_eq!(
        server.get("/v1/characters/nobody.glb?lod=1", &[]).status,
        404
    );
    assert_eq!(server.get("/v1/characters/nobody/cut", &[]).status, 404);
    assert_eq!(
        counter(server, "articula_made_total"),
        made,
        "nothing was made"
    );
}

/// Lets the Khronos validator judge files.
fn valid(files: &[Vec<u8>]) {
    if !judges::judges_are_here() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for (number, bytes) in files.iter().enumerate() {
        let path = folder.path().join(format!("{number}.glb"));
        std::fs::write(&path, bytes).unwrap();
        paths.push(path.to_str().unwrap().to_owned());
    }
    let (said, is_valid) = judges::ask("validate.mjs", &paths);
    assert!(is_valid, "{said}");
}

#[test]
fn before_all_of_a_character_is_made_queries_are_told_to_come_later() {
    let folder = tempfile::tempdir().unwrap();
    // Nothing packages it.
    let options = articula_serve::ServeOptions {
        packaging: 0,
        ..options()
    };
    let server = Server::start(folder.path(), &options);
    let put = server.request("PUT", "/v1/characters/man", &[], b"glTF and no more");
    assert_eq!(put.status, 202);
    for path in ["man.glb?lod=1", "man/cut?loa=1"] {
        let answer = server.get(&format!("/v1/characters/{path}"), &[]);
        assert_eq!(
            (answer.status, answer.header("retry-after")),
            (503, "1"),
            "{path}"
        );
    }
}
