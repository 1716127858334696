//! The heads that are judged: with their own shapes, and with shapes that were made.

use anyhow::{Context, Result};
use articula::face::{HeadSurface, RefusedShape, add_face_shapes_by};
use articula::{CharacterFile, Figure};
use articula_build::face::{FacePoints, FaceSurface, MouthMotions};
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

/// Those whose shapes the motions of the lower face are measured on, and the heads that are judged by the others: made
/// of the same one.
const MEASURED: [(&str, &str); 2] = [("ICT-FaceKit", "ICT"), ("MakeHuman woman", "MakeHuman")];

/// A head, its own shapes, and those that were made for it without them.
pub(super) struct Head {
    pub(super) name: &'static str,
    pub(super) own: FaceSurface,
    /// Of the head with its own shapes: they show what they can of its points.
    pub(super) points: FacePoints,
    /// The same vertices with the made shapes; why there are none.
    pub(super) made: Result<FaceSurface, String>,
    /// Shapes that were not made, and why.
    pub(super) refused: Vec<RefusedShape>,
}

impl Head {
    /// All heads whose name contains some text and of which there is a file, and the reference human.
    pub(super) fn all(data: &Path, named: &str) -> Result<Vec<Self>> {
        let motions = motions(data)?;
        let mut heads = Vec::new();
        for (name, file) in FILES.into_iter().filter(|(name, _)| name.contains(named)) {
            if let Some(opened) = open(data, file)? {
                let made = Self::of(name, &opened, &without(&motions, name));
                heads.extend(made.with_context(|| file)?);
            }
        }
        let name = "reference human";
        if name.contains(named) {
            let human = articula_human::human(&HumanOptions::default())?;
            let human = CharacterFile::from_character("human", human);
            heads.extend(Self::of(name, &human, &without(&motions, name))?);
        }
        Ok(heads)
    }

    /// `None` if the figure has no face on which points are found.
    fn of(
        name: &'static str,
        opened: &CharacterFile,
        motions: &MouthMotions,
    ) -> Result<Option<Self>> {
        let own = HeadSurface::of(&Figure::new(opened.clone())?).surface;
        let Ok(points) = FacePoints::find(&own, &[]) else {
            println!("made-shapes: {name} shows no face");
            return Ok(None);
        };
        let mut bare = opened.clone();
        bare.keep_morph_targets(|_| false);
        let mut refused = Vec::new();
        let made = match add_face_shapes_by(&mut bare, &[], motions) {
            Ok(shapes) => {
                refused = shapes.refused;
                Ok(HeadSurface::of(&Figure::new(bare)?).surface)
            }
            Err(error) => Err(error.to_string()),
        };
        Ok(Some(Self {
            name,
            own,
            points,
            made,
            refused,
        }))
    }
}

fn open(data: &Path, file: &str) -> Result<Option<CharacterFile>> {
    let path = data.join(file);
    if !path.is_file() {
        println!("skipped: made-shapes: {} is missing", path.display());
        return Ok(None);
    }
    Ok(Some(articula::fs::open(&path)?))
}

/// Number of heads that motions of the lower face are measured on.
pub(super) const COUNT: usize = MEASURED.len();

/// What the heads show that motions of the lower face are measured on, with the text that names of the same head contain.
pub(super) fn motions(data: &Path) -> Result<Vec<(&'static str, MouthMotions)>> {
    let mut all = Vec::new();
    for (name, same) in MEASURED {
        let file = FILES.into_iter().find(|(n, _)| *n == name);
        let Some(opened) = file
            .map(|(_, file)| open(data, file))
            .transpose()?
            .flatten()
        else {
            continue;
        };
        let own = HeadSurface::of(&Figure::new(opened)?).surface;
        let points = FacePoints::find(&own, &[])?;
        let motions = MouthMotions::measured(&own, &points).context("points in a plane")?;
        all.push((same, motions));
    }
    Ok(all)
}

/// The mean of the heads that are not the one of a name.
fn without(motions: &[(&str, MouthMotions)], name: &str) -> MouthMotions {
    let others = motions.iter().filter(|(same, _)| !name.contains(same));
    MouthMotions::mean(&others.map(|(_, m)| m.clone()).collect::<Vec<_>>())
}
