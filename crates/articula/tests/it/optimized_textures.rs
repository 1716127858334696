//! Textures of optimised files: smaller, the same to look at, with their alpha; broken ones as they were.

use articula::core::source::Image;
use articula::flat::{Picture, color_difference};
use articula::human::HumanOptions;
use articula::optimize::{OptimizeOptions, Optimized, TextureFormat, TextureOptions, optimize};
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
