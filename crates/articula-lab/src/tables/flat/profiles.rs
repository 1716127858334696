//! Size and error of every profile, read back from the files.

use anyhow::{Context, Result};
use articula::flatten::FramedCharacter;
use articula_core::Progress;
use articula_flat::flatten::{
    Flattened, PrepareClipOptions, PreparedClip, Profile, Quality, ReferenceFrames, Settings,
    flatten, sampled_frames,
};
use articula_flat::planar::PlanarClip;
use articula_flat::planar::Shading;
use articula_flat::vector::player::PlayerOutput;
use articula_flat::vector::{ThesisForm, ThesisSvgOptions, thesis};
use articula_report::thread_ns;
use std::path::Path;

/// A profile with its settings.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) flat: Flattened,
    /// Seconds of one thread for writing and measuring it.
    pub(super) secs: f64,
}

/// Stills of the first frame.
pub(super) struct Stills {
    pub(super) ours: Flattened,
    pub(super) exact: Flattened,
    pub(super) flat: Flattened,
    /// Bytes of the thesis' form, and the number of triangles in it.
    pub(super) thesis_bytes: usize,
    pub(super) thesis_triangles: usize,
}

/// Maximum number of frames for which a flip-book is written.
const FLIPBOOK_FRAMES: usize = 60;

/// Names of the rows to which acceptance bounds apply.
pub(super) const THESIS: &str = "thesis, path";
pub(super) const FLAT: &str = "smil flat 0.5 px";
pub(super) const GOURAUD: &str = "smil gouraud 0.5 px, 8 levels";
pub(super) const PLAYER: &str = "player gouraud";
pub(super) const PLAYER_COARSE: &str = "player gouraud 0.2 px, 2 levels";

fn settings() -> Vec<(&'static str, Profile, Quality)> {
    let quality = |shading, pos_tol_px, col_tol_levels, merge_levels| Quality {
        shading,
        pos_tol_px,
        col_tol_levels,
        merge_levels,
    };
    let (flat, gouraud) = (Shading::Flat, Shading::Gouraud);
    let naive = |form, optimised| {
        Profile::Thesis(ThesisSvgOptions {
            form,
            optimise_hidden: optimised,
            optimise_static: optimised,
            ..ThesisSvgOptions::default()
        })
    };
    let player = Profile::Player(PlayerOutput::Svg);
    let of_flat = quality(flat, 0.5, 8.0, None);
    vec![
        (
            "thesis, polygon",
            naive(ThesisForm::Polygon, false),
            of_flat,
        ),
        (THESIS, naive(ThesisForm::Path, false), of_flat),
        (
            "thesis, path, optimised",
            naive(ThesisForm::Path, true),
            of_flat,
        ),
        (
            "smil flat 0.25 px",
            Profile::Smil,
            quality(flat, 0.25, 8.0, None),
        ),
        (FLAT, Profile::Smil, of_flat),
        (
            "smil flat 1 px",
            Profile::Smil,
            quality(flat, 1.0, 8.0, None),
        ),
        (
            "smil flat 0.5 px, merged 14",
            Profile::Smil,
            quality(flat, 0.5, 8.0, Some(14.0)),
        ),
        (
            "smil gouraud 0.25 px, 4 levels",
            Profile::Smil,
            quality(gouraud, 0.25, 4.0, None),
        ),
        (GOURAUD, Profile::Smil, quality(gouraud, 0.5, 8.0, None)),
        (
            "lottie gouraud 0.5 px, 8 levels",
            Profile::Lottie,
            quality(gouraud, 0.5, 8.0, None),
        ),
        (
            "flipbook gouraud",
            Profile::Flipbook,
            quality(gouraud, 0.25, 4.0, None),
        ),
        ("player flat", player, quality(flat, 0.1, 1.0, None)),
        (PLAYER, player, quality(gouraud, 0.1, 1.0, None)),
        (PLAYER_COARSE, player, quality(gouraud, 0.2, 2.0, None)),
    ]
}

/// Every profile of a case; the files are written to a folder if one is given.
pub(super) fn rows(
    framed: &FramedCharacter<'_>,
    prepared: &PreparedClip,
    is_small: bool,
    files: Option<&Path>,
) -> Result<Vec<Row>> {
    let frames = sampled_frames(framed.frame_times_secs.len());
    let truth = ReferenceFrames::new(&framed.at_frames(&frames)?, &frames)?;
    let mut rows = Vec::new();
    for (name, profile, quality) in settings() {
        let is_long = framed.frame_times_secs.len() > FLIPBOOK_FRAMES;
        let is_needed = [THESIS, FLAT, GOURAUD, PLAYER].contains(&name);
        if (profile == Profile::Flipbook && is_long) || (is_small && !is_needed) {
            continue;
        }
        let start = thread_ns();
        let settings = Settings {
            profile,
            quality,
            name: name.into(),
            max_bytes: None,
        };
        let flat = flatten(prepared, &settings, &truth, &mut Progress::none())?;
        let secs = 1e-9 * (thread_ns() - start) as f64;
        if let Some(folder) = files {
            let ending = if profile == Profile::Lottie {
                "json"
            } else {
                "svg"
            };
            let path = folder
                .join(name.replace([' ', ','], "_"))
                .with_extension(ending);
            std::fs::create_dir_all(folder)?;
            std::fs::write(&path, &flat.bytes).with_context(|| path.display().to_string())?;
        }
        rows.push(Row { name, flat, secs });
    }
    Ok(rows)
}

/// Stills of the first frame, each in its best setting.
pub(super) fn stills(framed: &FramedCharacter<'_>, clip: &PlanarClip) -> Result<Stills> {
    let mut first = clip.clone();
    first.frames.truncate(1);
    let truth = ReferenceFrames::new(&framed.at_frames(&[0.0])?, &[0.0])?;
    let prepared = PreparedClip::new(
        first.clone(),
        &PrepareClipOptions::default(),
        &mut Progress::none(),
    )?;
    let still = |exact, shading| {
        let profile = Profile::Still { frame: 0, exact };
        let settings = Settings {
            profile,
            quality: Quality {
                shading,
                ..Quality::of(profile)
            },
            name: String::new(),
            max_bytes: None,
        };
        flatten(&prepared, &settings, &truth, &mut Progress::none())
    };
    let naive = ThesisSvgOptions {
        form: ThesisForm::GouraudStill { frame: 0 },
        ..ThesisSvgOptions::default()
    };
    let naive = thesis(&first, &naive)?;
    Ok(Stills {
        ours: still(false, Shading::Gouraud)?,
        exact: still(true, Shading::Gouraud)?,
        flat: still(false, Shading::Flat)?,
        thesis_bytes: naive.text.len(),
        thesis_triangles: naive.triangles,
    })
}

impl super::Found {
    /// The row of a profile.
    pub(super) fn row(&self, name: &str) -> Option<&Row> {
        self.profiles.iter().find(|r| r.name == name)
    }
}
