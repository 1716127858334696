//! The reference human with its colours in a picture, as a file.

use articula::core::source::RawMesh;
use articula::flat::Picture;
use articula::formats::gltf::Document;
use articula::{CharacterFile, OpenOptions, open, painted_human};

#[test]
fn the_file_shows_the_picture_that_was_painted() {
    let character = painted_human(2_000).unwrap();
    let glb = Document::from_character(&character).unwrap();
    let glb = glb.write_glb().unwrap();
    let nothing = &mut |_: &str| Err("there are no other files".into());
    let file: CharacterFile = open(&glb, "human.glb", &OpenOptions::default(), nothing).unwrap();
    let [image] = &file.character().images[..] else {
        panic!("{} images", file.character().images.len());
    };
    let picture = Picture::decode(&image.bytes).unwrap();
    let painted = articula::human::painted_human(2_000).unwrap();
    assert_eq!(picture.width(), painted.side);
    let opaque = painted.pixels.iter().map(|[r, g, b]| [*r, *g, *b, 255]);
    assert!(picture.pixels().iter().copied().eq(opaque));
    let read = &file.character().meshes;
    let parts = |meshes: &[RawMesh]| {
        meshes
            .iter()
            .map(|m| m.primitives.len())
            .collect::<Vec<_>>()
    };
    assert_eq!(parts(read), parts(&painted.character.meshes));
    for (mesh, same) in read.iter().zip(&painted.character.meshes) {
        for (part, same) in mesh.primitives.iter().zip(&same.primitives) {
            assert_eq!(part.texcoords, same.texcoords);
            let material = &file.character().materials[part.material.unwrap()];
            assert_eq!(material.base_color_image, Some(0));
        }
    }
}

#[test]
fn a_number_of_triangles_that_is_not_supported_is_told() {
    let told = painted_human(70_001).unwrap_err().to_string();
    assert!(told.contains("2000 to 70000"), "{told}");
}
