//! The heads that are judged: with their own shapes, and with shapes that were made.

use anyhow::{Context, Result};
use articula::face::{HeadSurface, add_face_shapes};
use articula::{CharacterFile, Figure};
use articula_build::face::{FacePoints, FaceSurface};
use articula_human::HumanOptions;
use std::path::Path;

/// Name and file of the heads.
const FILES: [(&str, &str); 6] = [
    ("ICT-FaceKit", "face/ict_facekit_expressions.glb"),
    ("ICT-FaceKit, 1095 triangles", "glb/ict_head_talk_1095.glb"),
    ("MakeHuman woman", "glb/mh_female_default163_arkit52.glb"),
    ("MakeHuman man", "glb/mh_male_cmu31.glb"),
    ("pab", "glb/pab_arnaud.glb"),
    ("Casual2", "glb/Quaternius_modular_men__Casual2.glb"),
];

/// A head, its own shapes, and those that were made for it without them.
pub(super) struct Head {
    pub(super) name: &'static str,
    pub(super) own: FaceSurface,
    /// Of the head with its own shapes: they show what they can of its points.
    pub(super) points: FacePoints,
    /// The same vertices with the made shapes; why there are none.
    pub(super) made: Result<FaceSurface, String>,
}

impl Head {
    /// All heads of which there is a file, and the reference human.
    pub(super) fn all(data: &Path) -> Result<Vec<Self>> {
        let mut heads = Vec::new();
        for (name, file) in FILES {
            let path = data.join(file);
            if !path.is_file() {
                println!("skipped: made-shapes: {} is missing", path.display());
                continue;
            }
            heads.extend(Self::of(name, &articula::fs::open(&path)?).with_context(|| file)?);
        }
        let human = articula_human::human(&HumanOptions::default())?;
        let human = CharacterFile::from_character("human", human);
        heads.extend(Self::of("reference human", &human)?);
        Ok(heads)
    }

    /// `None` if the figure has no face on which points are found.
    fn of(name: &'static str, opened: &CharacterFile) -> Result<Option<Self>> {
        let own = HeadSurface::of(&Figure::new(opened.clone())?).surface;
        let Ok(points) = FacePoints::find(&own, &[]) else {
            println!("made-shapes: {name} shows no face");
            return Ok(None);
        };
        let mut bare = opened.clone();
        bare.keep_morph_targets(|_| false);
        let made = match add_face_shapes(&mut bare, &[]) {
            Ok(_) => Ok(HeadSurface::of(&Figure::new(bare)?).surface),
            Err(error) => Err(error.to_string()),
        };
        Ok(Some(Self {
            name,
            own,
            points,
            made,
        }))
    }
}
