//! Small files of the kinds that other programs write: skins over a part, loose rigs, materials.

#[path = "../../../articula-formats/tests/it/cases.rs"]
mod cases;

use articula::convert::{FitFindingKind, TransferReport, fit_clips};
use articula::flatten::{FramedCharacter, Shot, TriangleCount, surfaces_shown_otherwise};
use articula::formats::Warning;
use articula::{AddClipsOptions, CharacterFile, Executor, Figure, OpenOptions, open};
use articula_core::Viewport;
use articula_core::source::{Image, Material};
use articula_flat::Picture;
use cases::case;
use glam::{Vec3, Vec4};

fn opened_bytes(bytes: &[u8], name: &str) -> CharacterFile {
    let mut beside = |uri: &str| Err(format!("{uri}: nothing is beside"));
    open(bytes, name, &OpenOptions::default(), &mut beside).unwrap()
}

fn opened(name: &str) -> CharacterFile {
    opened_bytes(&case(name), name)
}

fn said(file: &CharacterFile) -> Vec<&str> {
    file.warnings()
        .iter()
        .map(|w: &Warning| w.what.as_str())
        .collect()
}

fn mapped(file: &CharacterFile) -> usize {
    file.mapping().articulation.mapped()
}

#[test]
fn a_skin_over_the_head_takes_the_body_that_moves_and_is_retargeted() {
    let source = opened("head_only_skin.glb");
    assert_eq!(mapped(&source), 21);
    let target = opened("rigt_cc.glb");
    let fitted = fit_clips(&source, &target, &AddClipsOptions::default()).unwrap();
    let report = fitted[0].fit.retargeted.as_ref().unwrap();
    assert!(report.not_driven.is_empty(), "{:?}", report.not_driven);
}

#[test]
fn a_loose_rig_is_a_whole_human_of_its_height() {
    let source = opened("rigify_loose.glb");
    assert_eq!(said(&source), [""; 0]);
    let target = opened("base.glb");
    let fitted = fit_clips(&source, &target, &AddClipsOptions::default()).unwrap();
    let report = TransferReport::new(&source, &target, &fitted).unwrap();
    let findings = report.clips.iter().flat_map(|clip| &clip.findings);
    let held = findings.filter(|f| f.kind == FitFindingKind::NotDriven);
    assert_eq!(held.count(), 0);
}

#[test]
fn a_clean_figure_has_no_warning() {
    for name in ["base.glb", "tex_webp_required.glb", "matrix_nodes.glb"] {
        assert_eq!(said(&opened(name)), [""; 0], "{name}");
    }
}

/// sRGB levels of the vertices that a still picture shows, with their light.
fn shown(figure: &Figure) -> Vec<[f32; 3]> {
    let shot = Shot {
        still_at: Some(0.0),
        viewport: Viewport {
            width_px: 200.0,
            height_px: 200.0,
            fov_y_radians: 0.5,
        },
        triangles: TriangleCount::All,
        ..Shot::default()
    };
    let framed = FramedCharacter::new(figure, shot, &Executor::default()).unwrap();
    let clip = framed.clip().unwrap();
    let drawn = clip.triangles.iter().flatten();
    let lit = |v: &u32| {
        let v = *v as usize;
        clip.albedo[v].map(|level| level * clip.frames[0].light[v])
    };
    drawn.map(lit).collect()
}

fn is_red([r, g, b]: &[f32; 3]) -> bool {
    *r > 100.0 && *g < 50.0 && *b < 50.0
}

#[test]
fn a_transparent_card_shows_nothing() {
    let figure = Figure::new(opened("card_blend_a0.glb")).unwrap();
    let colors = shown(&figure);
    assert!(!colors.is_empty() && !colors.iter().any(is_red));
    assert_eq!(surfaces_shown_otherwise(&figure), [""; 0]);
}

#[test]
fn a_black_surface_that_glows_green_is_green() {
    let figure = Figure::new(opened("mat_emissive_only.glb")).unwrap();
    let colors = shown(&figure);
    assert!(
        colors
            .iter()
            .all(|[r, g, b]| *g > 200.0 && *r < 30.0 && *b < 30.0)
    );
    assert_eq!(surfaces_shown_otherwise(&figure), [""; 0]);
}

/// The figure of `base.glb` in one material, whose base colour picture has one texel.
fn painted(material: Material, texel: [u8; 4]) -> Figure {
    let mut character = opened("base.glb").into_character();
    let picture = Picture::from_pixels(1, 1, vec![texel]).unwrap();
    character.images = vec![Image {
        bytes: picture.to_png().unwrap(),
        ..Image::default()
    }];
    character.materials = vec![Material {
        base_color_image: Some(0),
        ..material
    }];
    for mesh in &mut character.meshes {
        for part in &mut mesh.primitives {
            part.material = Some(0);
            part.texcoords = vec![glam::Vec2::splat(0.5); part.positions.len()];
        }
    }
    Figure::new(CharacterFile::from_character("painted", character)).unwrap()
}

#[test]
fn every_mode_of_alpha_shows_what_is_opaque_and_tells_of_the_rest() {
    let red = |alpha| [255, 0, 0, alpha];
    let of = |blends, alpha_cutoff| Material {
        blends,
        alpha_cutoff,
        double_sided: true,
        ..Material::default()
    };
    for (material, alpha, is_shown, is_told) in [
        (of(false, 0.0), 0, true, false),
        (of(false, 0.5), 0, false, false),
        (of(false, 0.5), 255, true, false),
        (of(false, 0.2), 100, true, false),
        (of(true, 0.5), 0, false, false),
        (of(true, 0.5), 64, false, true),
        (of(true, 0.5), 192, true, true),
        (of(true, 0.5), 255, true, false),
    ] {
        let figure = painted(material.clone(), red(alpha));
        let case = format!("{} {} {alpha}", material.blends, material.alpha_cutoff);
        assert_eq!(shown(&figure).iter().any(is_red), is_shown, "{case}");
        assert_eq!(
            surfaces_shown_otherwise(&figure).len(),
            usize::from(is_told),
            "{case}"
        );
    }
}

#[test]
fn light_of_its_own_does_not_depend_on_the_light_that_falls() {
    let spread = |colors: &[[f32; 3]]| {
        let reds = || colors.iter().map(|c| c[0]);
        reds().fold(f32::MIN, f32::max) - reds().fold(f32::MAX, f32::min)
    };
    let lit = shown(&painted(Material::default(), [255; 4]));
    assert!(spread(&lit) > 50.0);
    let unlit = Material {
        unlit: true,
        ..Material::default()
    };
    let glowing = Material {
        base_color: Vec4::new(0.0, 0.0, 0.0, 1.0),
        emissive: Vec3::splat(4.0),
        ..Material::default()
    };
    for material in [unlit, glowing] {
        let colors = shown(&painted(material, [255; 4]));
        assert!(spread(&colors) < 1.0 && colors[0][0] > 250.0);
    }
    let both = Material {
        emissive: Vec3::splat(0.5),
        ..Material::default()
    };
    assert_eq!(surfaces_shown_otherwise(&painted(both, [255; 4])).len(), 1);
}

#[test]
fn pictures_of_unknown_formats_are_told_once() {
    let mut glb = articula::formats::gltf::read(
        &case("tex_webp_required.glb"),
        &articula::formats::Limits::default(),
        &mut |uri: &str| Err(uri.to_owned()),
    )
    .unwrap()
    .value
    .document;
    let ktx = b"\xabKTX 20\xbb\r\n\x1a\n";
    glb.set_pictures(&[(0, ktx)]).unwrap();
    let file = opened_bytes(&glb.write_glb().unwrap(), "ktx.glb");
    let told = said(&file);
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("image/ktx2"));
    assert_eq!(file.character().images[0].bytes, ktx);
    let figure = Figure::new(file).unwrap();
    assert!(!shown(&figure).is_empty(), "drawn in its plain colour");
    assert_eq!(surfaces_shown_otherwise(&figure), [""; 0]);
}
