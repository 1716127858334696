//! Textures of optimised files: smaller, the same to look at, with their alpha; broken ones as they were.

use articula::core::source::{Image, Primitive};
use articula::flat::{Picture, color_difference};
use articula::glam::{Vec2, Vec3};
use articula::human::HumanOptions;
use articula::optimize::{
    OptimizeLimits, OptimizeOptions, Optimized, TextureFormat, TextureOptions, optimize,
    optimize_to_fit,
};
use articula::{CharacterFile, Executor, Format, OpenOptions, convert, open};

/// A smooth picture of 64 x 48, as a PNG that stores each row as it is.
fn smooth(alpha: u8) -> Picture {
    let pixel = |i: u32| {
        let (x, y) = (i % 64, i / 64);
        [(x * 3) as u8, (y * 4) as u8, (x + y) as u8, alpha]
    };
    Picture::from_pixels(64, 48, (0..64 * 48).map(pixel).collect()).unwrap()
}

/// Our human at rest, each of whose first materials shows one of these pictures.
fn human(pictures: &[Vec<u8>]) -> CharacterFile {
    let small = HumanOptions::mannequin(2000);
    let mut character = articula::human::human(&small).unwrap();
    character.clips.clear();
    let material = character.materials[0].clone();
    character.materials = vec![material; pictures.len()];
    for (i, bytes) in pictures.iter().enumerate() {
        character.materials[i].base_color_image = Some(i);
        character.images.push(Image {
            name: format!("picture {i}"),
            mime_type: "image/png".into(),
            bytes: bytes.clone(),
        });
    }
    for primitive in character.meshes.iter_mut().flat_map(|m| &mut m.primitives) {
        primitive.material = Some(0);
    }
    let opened = CharacterFile::from_character("human", character);
    read(&convert::write(&opened, Format::Glb).unwrap().bytes)
}

fn read(bytes: &[u8]) -> CharacterFile {
    let beside = &mut |uri: &str| Err(format!("{uri} does not lie beside it"));
    open(bytes, "file.glb", &OpenOptions::default(), beside).unwrap()
}

fn made(source: &CharacterFile, textures: TextureOptions) -> Optimized {
    let options = OptimizeOptions {
        textures,
        ..OptimizeOptions::default()
    };
    optimize(source, &options, &Executor::default()).unwrap()
}

fn pictures(made: &Optimized) -> Vec<Image> {
    read(&made.glb).into_character().images
}

fn of(format: TextureFormat) -> TextureOptions {
    TextureOptions {
        format,
        ..TextureOptions::default()
    }
}

#[test]
fn every_format_looks_the_same_keeps_alpha_and_needs_no_more_bytes() {
    let wanted = [smooth(255), smooth(100)];
    let files: Vec<Vec<u8>> = wanted.iter().map(|p| p.to_png().unwrap()).collect();
    let source = human(&files);
    for format in [
        TextureFormat::Auto,
        TextureFormat::Webp,
        TextureFormat::Jpeg,
        TextureFormat::Png,
    ] {
        let made = made(&source, of(format));
        assert_eq!(made.report.textures.len(), 2);
        for ((image, row), wanted) in pictures(&made)
            .iter()
            .zip(&made.report.textures)
            .zip(&wanted)
        {
            assert_eq!(image.bytes.len(), row.bytes_out);
            assert!(row.bytes_out <= row.bytes_in, "{row:?}");
            assert_eq!(image.mime_type, row.type_out);
            let shown = Picture::decode(&image.bytes).unwrap();
            let found = color_difference(wanted, &shown).unwrap();
            assert!(found.most <= 2.3 && found.largest <= 4.6, "{found:?}");
            for (a, b) in wanted.pixels().iter().zip(shown.pixels()) {
                assert_eq!(a[3], b[3]);
            }
        }
    }
}

#[test]
fn kept_textures_are_the_same_bytes_and_large_ones_become_smaller() {
    let file = smooth(255).to_png().unwrap();
    let source = human(std::slice::from_ref(&file));
    let kept = made(&source, of(TextureFormat::Keep));
    assert_eq!(pictures(&kept)[0].bytes, file);
    let small = made(
        &source,
        TextureOptions {
            longest_px: Some(32),
            ..of(TextureFormat::Keep)
        },
    );
    let row = &small.report.textures[0];
    assert_eq!(
        (row.size_in, row.size_out),
        (Some([64, 48]), Some([32, 24]))
    );
    let shown = Picture::decode(&pictures(&small)[0].bytes).unwrap();
    assert_eq!((shown.width(), shown.height()), (32, 24));
    assert!(row.type_out == "image/png" && row.bytes_out < row.bytes_in);
}

#[test]
fn a_broken_picture_stays_with_a_warning() {
    let mut broken = smooth(255).to_png().unwrap();
    broken.truncate(60);
    let source = human(&[broken.clone()]);
    let made = made(&source, TextureOptions::default());
    assert_eq!(pictures(&made)[0].bytes, broken);
    let warning = made.report.textures[0].warning.as_deref().unwrap_or("");
    assert!(
        warning.starts_with("images[0]: stays as it is: PNG"),
        "{warning}"
    );
}

#[test]
fn webp_is_named_by_its_extension_and_not_written_where_readers_lack_it() {
    // One colour, of which WebP needs the fewest bytes.
    let flat = Picture::new(64, 64, [200, 30, 90, 255]).unwrap();
    let source = human(&[flat.to_png().unwrap()]);
    let json = |made: &Optimized| {
        let length = u32::from_le_bytes(made.glb[12..16].try_into().unwrap()) as usize;
        let json = serde_json::from_slice(&made.glb[20..20 + length]);
        json.unwrap()
    };
    let auto: serde_json::Value = json(&made(&source, TextureOptions::default()));
    assert_eq!(auto["images"][0]["mimeType"], "image/webp");
    let required = auto["extensionsRequired"].as_array().unwrap();
    assert!(required.contains(&"EXT_texture_webp".into()));
    let texture = &auto["textures"][0];
    assert_eq!(texture["extensions"]["EXT_texture_webp"]["source"], 0);
    let mut document = source.gltf().unwrap().document.clone();
    document.json["extensions"] = serde_json::json!({"VRMC_vrm": {"meta": {"name": "a"}}});
    document.json["extensionsUsed"] = serde_json::json!(["VRMC_vrm"]);
    let vrm = read(&document.write_glb().unwrap());
    let found: serde_json::Value = json(&made(&vrm, TextureOptions::default()));
    assert_eq!(found["images"][0]["mimeType"], "image/png");
}

/// A square of one metre that shows a whole picture and follows one joint.
fn board(picture: &Picture) -> CharacterFile {
    let mut character = human(&[picture.to_png().unwrap()]).into_character();
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(Vec2::from);
    character.meshes.truncate(1);
    character.meshes[0].primitives = vec![Primitive {
        positions: corners.map(|c| c.extend(0.0)).to_vec(),
        normals: vec![Vec3::Z; 4],
        texcoords: corners.to_vec(),
        influences: 1,
        joints: vec![0; 4],
        weights: vec![1.0; 4],
        triangles: vec![[0, 1, 2], [2, 3, 0]],
        material: Some(0),
        ..Primitive::default()
    }];
    character.meshes[0].morph_names.clear();
    character.meshes[0].morph_weights.clear();
    character.expressions.clear();
    let opened = CharacterFile::from_character("board", character);
    read(&convert::write(&opened, Format::Glb).unwrap().bytes)
}

#[test]
fn a_picture_has_as_many_texels_as_the_figure_shows_on_screen() {
    // Noise, so that fewer texels need fewer bytes.
    let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 24) as u8;
    let pixel = |i: u32| [noise(i), noise(i ^ 0x5555), noise(3 * i + 1), 255];
    let large = Picture::from_pixels(256, 192, (0..256 * 192).map(pixel).collect()).unwrap();
    let source = board(&large);
    // 192 rows of texels fill the height; 4 texels are beside 3 rows, and sides are powers of two.
    let wanted = [(10, 16), (40, 64), (90, 128), (160, 256), (1000, 256)];
    for (height_px, longest) in wanted {
        let textures = TextureOptions {
            screen_height_px: Some(height_px),
            ..TextureOptions::default()
        };
        let made = made(&source, textures);
        let shown = Picture::decode(&pictures(&made)[0].bytes).unwrap();
        let size = [shown.width(), shown.height()];
        assert_eq!(size, [longest, longest * 3 / 4], "{height_px}");
        assert_eq!(made.report.textures[0].size_out, Some(size));
    }
}

#[test]
fn a_limit_of_pixels_is_kept_or_the_picture_is_named() {
    let limits = OptimizeLimits {
        max_textures_px: Some(32),
        ..OptimizeLimits::default()
    };
    let fitted = |source: &CharacterFile| {
        optimize_to_fit(
            source,
            &OptimizeOptions::default(),
            &limits,
            &Executor::default(),
        )
    };
    let source = human(&[smooth(255).to_png().unwrap()]);
    let (made, fit) = fitted(&source).unwrap();
    assert_eq!(made.report.textures[0].size_out, Some([32, 24]));
    assert_eq!(fit.too_large_at_mm, None);
    assert!(!limits.allow_source(&made.report));
    let wide = OptimizeLimits {
        max_textures_px: Some(64),
        ..limits
    };
    assert!(wide.allow_source(&made.report));
    let broken = human(&[b"\x89PNG\r\n\x1a\nnothing".to_vec()]);
    let refused = fitted(&broken).unwrap_err().to_string();
    assert!(
        refused.contains("images[0]") && refused.contains("32 px"),
        "{refused}"
    );
}
