//! The face apart in the errors of clips: a head alone has one by its blend shapes, a body by its
//! head joint, other morph targets make none.

use crate::real::file;
use crate::short::shortened;
use articula::Figure;
use articula::evaluate::{EvaluatedClip, ParameterChoice, rows};
use articula_build::evaluate::{EvaluationSetup, Method, MethodOptions};

#[test]
fn a_head_without_joints_has_a_face() {
    for (name, has_face) in [
        ("glb/ict_head_talk_554.glb", true),
        ("glb/ict_head_talk_1095.glb", true),
        ("glb/AnimatedMorphCube.glb", false),
        ("glb/mh_female_dance.glb", true),
    ] {
        let Some(path) = file(name) else { continue };
        let figure = Figure::new(shortened(articula::fs::open(path).unwrap(), 1.0)).unwrap();
        let evaluated = EvaluatedClip {
            figure: &figure,
            clip: 0,
            setup: EvaluationSetup::default(),
            options: MethodOptions::default(),
        };
        let stage = evaluated.stage();
        let found = rows(&stage, &Method::SkipHold, &[2.0], ParameterChoice::Usual);
        let skin = found[0].skin_px;
        assert_eq!(skin.face.is_some(), has_face, "{name}: {skin:?}");
        if let Some(face) = skin.face {
            assert!(face.frames.p95 <= face.worst_vertex, "{name}: {face:?}");
            assert!(face.worst_vertex <= skin.worst_vertex, "{name}: {face:?}");
        }
    }
}
