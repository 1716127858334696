//! Blend shapes that are made for a head, by heads whose answers are known.

use articula::face::{HeadSurface, add_face_shapes_by};
use articula::glam::Vec3;
use articula::{CharacterFile, Figure};
use articula_build::face::{FacePoints, FaceSurface, MouthMotions};
use articula_human::HumanOptions;

fn human() -> CharacterFile {
    let human = articula_human::human(&HumanOptions::default()).unwrap();
    CharacterFile::from_character("human", human)
}

fn surface(opened: CharacterFile) -> FaceSurface {
    HeadSurface::of(&Figure::new(opened).unwrap()).surface
}

fn shape<'a>(surface: &'a FaceSurface, name: &str) -> &'a [Vec3] {
    let found = surface.shapes.iter().find(|(shape, _)| *shape == name);
    &found.unwrap().1
}

/// The vertices of the skin that a shape moves by more than a tenth of its largest displacement, with that.
fn moved(own: &[Vec3], points: &FacePoints) -> (Vec<usize>, f32) {
    let mut skin: Vec<usize> = points
        .skin()
        .iter()
        .flatten()
        .map(|v| *v as usize)
        .collect();
    skin.sort_unstable();
    skin.dedup();
    let most = skin.iter().map(|v| own[*v].length()).fold(0.0, f32::max);
    skin.retain(|v| own[*v].length() > 0.1 * most);
    (skin, most)
}

#[test]
fn a_head_gets_back_the_motions_that_it_showed() {
    let own = surface(human());
    let points = FacePoints::find(&own, &[]).unwrap();
    let motions = MouthMotions::measured(&own, &points).unwrap();
    let mut opened = human();
    opened.keep_morph_targets(|_| false);
    add_face_shapes_by(&mut opened, &[], &motions).unwrap();
    let made = surface(opened);
    for name in [
        "jawOpen",
        "mouthSmileLeft",
        "mouthSmileRight",
        "mouthPucker",
        "mouthFunnel",
    ] {
        let (own, made) = (shape(&own, name), shape(&made, name));
        let (skin, most) = moved(own, &points);
        let error =
            skin.iter().map(|v| own[*v].distance(made[*v])).sum::<f32>() / skin.len() as f32;
        // The chart has 5 mm between its nodes; what rests would have an error of about a half.
        assert!(error < 0.15 * most, "{name}: {error} of {most}");
    }
}

#[test]
fn without_motions_the_rules_of_parameters_hold() {
    let none = MouthMotions::mean(&[]);
    let mut by_rules = human();
    by_rules.keep_morph_targets(|_| false);
    let mut stored = by_rules.clone();
    let all = add_face_shapes_by(&mut by_rules, &[], &none).unwrap().made;
    // Both ways make the same shapes; those of eyes and brows are alike.
    assert_eq!(
        all,
        add_face_shapes_by(&mut stored, &[], &MouthMotions::stored())
            .unwrap()
            .made
    );
    let [rules, measured] = [by_rules, stored].map(surface);
    assert_eq!(
        shape(&rules, "eyeWideLeft"),
        shape(&measured, "eyeWideLeft")
    );
    assert_ne!(shape(&rules, "jawOpen"), shape(&measured, "jawOpen"));
}
