//! Textures in one picture: every point of the surface shows the colour that it showed.

use articula::core::Transform;
use articula::core::source::{
    Character, Image, Joint, Material, Primitive, RawMesh, Skeleton, Skin, TextureWrap,
};
use articula::flat::Picture;
use articula::glam::{Affine3A, Vec2, Vec3};
use articula::{CharacterFile, Format, OpenOptions, convert, open};

/// A picture in which no two pixels have one colour.
fn picture(width: u32, height: u32, blue: u8) -> Picture {
    let pixel = |i: u32| [(i % width) as u8, (i / width) as u8, blue, 255];
    let pixels = (0..width * height).map(pixel).collect();
    Picture::from_pixels(width, height, pixels).unwrap()
}

/// A square that shows the part of a picture between two corners.
fn square(material: usize, from: Vec2, to: Vec2) -> Primitive {
    Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
        texcoords: vec![from, Vec2::new(to.x, from.y), to, Vec2::new(from.x, to.y)],
        influences: 1,
        joints: vec![0; 4],
        weights: vec![1.0; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: Some(material),
        ..Primitive::default()
    }
}

/// A character that shows pictures by its materials: base colour and emissive one.
fn character(
    pictures: &[Picture],
    materials: &[[Option<usize>; 2]],
    parts: Vec<Primitive>,
) -> CharacterFile {
    let images = pictures.iter().enumerate().map(|(i, picture)| Image {
        name: format!("picture {i}"),
        mime_type: "image/png".into(),
        bytes: picture.to_png().unwrap(),
    });
    let materials = materials.iter().map(|[base, emissive]| Material {
        base_color_image: *base,
        emissive_image: *emissive,
        emissive: Vec3::ONE,
        ..Material::default()
    });
    let character = Character {
        skeleton: Skeleton {
            joints: vec![Joint {
                name: "Hips".into(),
                parent: None,
                rest: Transform::IDENTITY,
                in_skin: true,
            }],
        },
        meshes: vec![RawMesh {
            primitives: parts,
            skin: Skin {
                joints: vec![0],
                inverse_bind: vec![Affine3A::IDENTITY],
            },
            ..RawMesh::default()
        }],
        images: images.collect(),
        materials: materials.collect(),
        ..Character::default()
    };
    written(&CharacterFile::from_character("squares", character))
}

/// A character as it is read from its file.
fn written(file: &CharacterFile) -> CharacterFile {
    let glb = convert::write(file, Format::Glb).unwrap().bytes;
    let beside = &mut |uri: &str| Err(format!("{uri} does not lie beside it"));
    open(&glb, "file.glb", &OpenOptions::default(), beside).unwrap()
}

/// The colours at points of a square, by the nearest pixel of one of its pictures.
fn colors(
    file: &CharacterFile,
    part: usize,
    image: impl Fn(&Material) -> Option<usize>,
) -> Vec<[u8; 4]> {
    let character = file.character();
    let part = &character.meshes[0].primitives[part];
    let material = &character.materials[part.material.unwrap()];
    let picture = &character.images[image(material).unwrap()];
    let picture = Picture::decode(&picture.bytes).unwrap();
    let size = Vec2::new(picture.width() as f32, picture.height() as f32);
    let (from, to) = (part.texcoords[0], part.texcoords[2]);
    // In the middle of 1/16 of the square, where no rounding moves to the next pixel.
    let points = (0..256).map(|i| Vec2::new((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5) / 16.0);
    let colors = points.map(|point| {
        let at = (from + (to - from) * point).rem_euclid(Vec2::ONE) * size;
        picture.get(at.x as u32, at.y as u32).unwrap()
    });
    colors.collect()
}

fn base(material: &Material) -> Option<usize> {
    material.base_color_image
}

#[test]
fn every_point_shows_the_colour_that_it_showed() {
    let pictures = [picture(48, 80, 1), picture(16, 16, 2), picture(32, 8, 3)];
    let parts = vec![
        square(0, Vec2::ZERO, Vec2::ONE),
        square(1, Vec2::new(3.25, -1.0), Vec2::new(3.75, -0.5)),
        square(2, Vec2::new(0.5, 0.0), Vec2::new(1.0, 1.0)),
        square(3, Vec2::new(0.0, 0.25), Vec2::new(1.0, 0.5)),
    ];
    let materials = [0, 1, 2, 0].map(|i| [Some(i), None]);
    let before = character(&pictures, &materials, parts);
    let mut after = before.clone();
    let atlas = after.merge_textures(1024).unwrap();
    assert_eq!(atlas.materials, [0, 1, 2, 3]);
    assert_eq!((atlas.size_px, atlas.pictures), ([128; 2], 1));
    assert!(atlas.left_out.is_empty());
    for after in [written(&after), after] {
        assert_eq!(after.character().images.len(), 1);
        for part in 0..4 {
            assert_eq!(colors(&after, part, base), colors(&before, part, base));
        }
    }
}

#[test]
fn a_texture_of_another_kind_has_the_same_place_in_a_picture_of_its_own() {
    let pictures = [
        picture(32, 32, 1),
        picture(32, 32, 2),
        picture(64, 64, 3),
        picture(16, 16, 4),
    ];
    let whole = |material| square(material, Vec2::ZERO, Vec2::ONE);
    let materials = [[Some(0), Some(1)], [Some(2), Some(3)]];
    let before = character(&pictures, &materials, vec![whole(0), whole(1)]);
    let mut after = before.clone();
    let atlas = after.merge_textures(1024).unwrap();
    assert_eq!((atlas.pictures, after.character().images.len()), (2, 2));
    for part in 0..2 {
        for image in [base, |material: &Material| material.emissive_image] {
            assert_eq!(colors(&after, part, image), colors(&before, part, image));
        }
    }
}

#[test]
fn what_repeats_stays_and_so_does_what_shares_its_picture() {
    let pictures = [picture(32, 32, 1), picture(16, 16, 2), picture(8, 8, 3)];
    let parts = vec![
        square(0, Vec2::ZERO, Vec2::splat(2.0)),
        square(1, Vec2::ZERO, Vec2::ONE),
        square(2, Vec2::ZERO, Vec2::ONE),
        square(3, Vec2::ZERO, Vec2::ONE),
    ];
    let materials = [0, 0, 1, 2].map(|i| [Some(i), None]);
    let before = character(&pictures, &materials, parts);
    let mut after = before.clone();
    let atlas = after.merge_textures(1024).unwrap();
    assert_eq!(atlas.materials, [2, 3]);
    let left: Vec<usize> = atlas.left_out.iter().map(|(m, _)| *m).collect();
    assert_eq!(left, [0, 1]);
    assert_eq!(after.character().images.len(), 2);
    for part in 0..4 {
        assert_eq!(colors(&after, part, base), colors(&before, part, base));
    }
}

#[test]
fn a_small_atlas_holds_smaller_textures() {
    let plain = |gray: u8| Picture::new(256, 256, [gray, gray, gray, 255]).unwrap();
    let whole = |material| square(material, Vec2::ZERO, Vec2::ONE);
    let materials = [0, 1].map(|i| [Some(i), None]);
    let before = character(
        &[plain(50), plain(200)],
        &materials,
        vec![whole(0), whole(1)],
    );
    let mut after = before.clone();
    let atlas = after.merge_textures(64).unwrap();
    assert_eq!(atlas.size_px, [64; 2]);
    for part in 0..2 {
        assert_eq!(colors(&after, part, base), colors(&before, part, base));
    }
}

#[test]
fn without_a_second_texture_nothing_changes() {
    let parts = vec![square(0, Vec2::ZERO, Vec2::ONE)];
    let before = character(&[picture(32, 32, 1)], &[[Some(0), None]], parts);
    let mut after = before.clone();
    assert!(after.merge_textures(1024).unwrap().materials.is_empty());
    assert_eq!(after.character(), before.character());
}

#[test]
fn errors_say_what_to_do_and_change_nothing() {
    let no_document = CharacterFile::from_character("squares", Character::default());
    let error = no_document.clone().merge_textures(1024).unwrap_err();
    assert!(error.to_string().contains("as GLB first"), "{error}");
    let pictures: Vec<Picture> = (0..200).map(|i| picture(8, 8, i)).collect();
    let materials: Vec<[Option<usize>; 2]> = (0..200).map(|i| [Some(i), None]).collect();
    let parts = (0..200).map(|i| square(i, Vec2::ZERO, Vec2::ONE));
    let before = character(&pictures, &materials, parts.collect());
    let mut after = before.clone();
    let error = after.merge_textures(64).unwrap_err();
    assert!(error.to_string().contains("have no room"), "{error}");
    assert_eq!(after.character(), before.character());
}

#[test]
fn what_is_clamped_beyond_its_edge_or_broken_stays() {
    let pictures = [16, 17, 18, 19].map(|size| picture(size, size, 1));
    let whole = |material| square(material, Vec2::ZERO, Vec2::ONE);
    let beyond = |material| square(material, Vec2::ONE, Vec2::splat(2.0));
    let materials = [0, 1, 2, 3].map(|i| [Some(i), None]);
    let parts = vec![whole(0), beyond(1), beyond(2), whole(3)];
    let file = character(&pictures, &materials, parts);
    let left_out = |change: &dyn Fn(&mut Character)| {
        let mut character = file.character().clone();
        change(&mut character);
        let mut changed = written(&CharacterFile::from_character("squares", character));
        let atlas = changed.merge_textures(1024).unwrap();
        let left = atlas.left_out.iter().map(|(m, _)| *m);
        (atlas.materials, left.collect::<Vec<usize>>())
    };
    let none = left_out(&|_| ());
    assert_eq!(none, (vec![0, 1, 2, 3], vec![]));
    let clamped = left_out(&|of| of.materials[1].base_color_wrap = [TextureWrap::Clamp; 2]);
    assert_eq!(clamped, (vec![0, 2, 3], vec![1]));
    let broken = left_out(&|of| of.images[3].bytes.truncate(40));
    assert_eq!(broken, (vec![0, 1, 2], vec![3]));
}
