//! Facial animation parameters on portraits: each at three values, the 2D vertices beside the projection
//! of the head that the same table moves in 3D (the thesis' annex C).
//!
//! The head gets a face animation table and a clip that shows one parameter after the other. In 3D
//! the clip is sampled, skinned and projected; in 2D its weights and angles go through the portrait's
//! stored tables.

use super::Run;
use super::targets::{Target, section};
use anyhow::{Context, Result};
use articula::face::{add_face_table, fit_face};
use articula::flatten::FramedHead;
use articula::{CharacterFile, Figure};
use articula_build::face::FapInterval;
use articula_core::fap_table::{FAP_COUNT, LOW_FAP_COUNT, LOW_FAPS, TABLE};
use articula_core::feature_points::PointId;
use articula_core::{Camera, PosedMesh, Progress, Viewport, Wrap, sample, sample_morphs};
use articula_flat::portrait::{Portrait, PortraitOptions, build};
use articula_formats::mpeg4::fap::{FapClip, FapFrame};
use articula_human::HumanOptions;
use glam::{Vec2, Vec3};
use std::fmt::Write as _;

/// Side of the picture in pixels, and triangles of the 2D mesh.
const SIDE_PX: f32 = 400.0;
const TRIANGLES: usize = 1000;
/// Parts of the greatest value at which a parameter is compared.
const PARTS: [f32; 3] = [1.0 / 3.0, 2.0 / 3.0, 1.0];
/// Frames for which a value is held, so that one in their middle shows it alone, and their rate.
const HELD: usize = 4;
const RATE_HZ: f32 = 25.0;
/// Motion and error in pixels below which a parameter is dropped, or exact.
const LEAST_PX: f32 = 0.5;
/// Greatest values of angles, in units of 1e-5 rad: those of eyes are of the blend shapes of gaze, the head
/// nods by 10°, turns by 30° and leans by 20°.
const TURNS: [(usize, i32); 7] = [
    (23, 52_000),
    (24, 52_000),
    (25, 43_000),
    (26, 43_000),
    (48, 17_453),
    (49, 52_360),
    (50, 34_907),
];

/// What a portrait shows of a parameter.
struct Shown {
    fap: usize,
    /// The greatest value.
    value: i32,
    /// Greatest motion in 3D at that value, pixels.
    moved_px: f32,
    /// Greatest error at each part of it, pixels.
    error_px: [f32; 3],
}

/// What was measured of a head.
struct Measured {
    name: &'static str,
    triangles: usize,
    /// Greatest error at rest, pixels.
    rest_px: f32,
    shown: Vec<Shown>,
}

/// Measures the heads and writes the page.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut heads = vec![human()?];
    for (name, file) in [
        ("ICT-FaceKit", "face/ict_facekit_expressions.glb"),
        ("MakeHuman", "glb/mh_female_default163_arkit52.glb"),
    ] {
        let path = run.data.join(file);
        if run.small || !path.is_file() {
            println!("skipped: portrait-parameters: {}", path.display());
            continue;
        }
        heads.push(measured(name, articula::fs::open(&path)?, &[])?);
    }
    run.save("portrait-parameters", &page(&heads), &csv(&heads))
}

/// The reference human, whose feature points are known.
fn human() -> Result<Measured> {
    let character = articula_human::human(&HumanOptions::default())?;
    let points = articula_human::feature_points().into_iter();
    let points: Vec<(PointId, Vec3)> = points.map(|p| (p.point, p.position)).collect();
    let opened = CharacterFile::from_character("human", character);
    measured("reference human", opened, &points)
}

fn measured(
    name: &'static str,
    mut opened: CharacterFile,
    points: &[(PointId, Vec3)],
) -> Result<Measured> {
    add_face_table(&mut opened, points)?;
    let values = values(&opened);
    let fitted = fit_face(&clip(&values), "parameters.fap", &opened)?;
    opened.put_clips(vec![fitted.fitted], false);
    let figure = Figure::new(opened)?;
    let viewport = Viewport {
        width_px: SIDE_PX,
        height_px: SIDE_PX,
        ..Viewport::default()
    };
    let framed = FramedHead::new(&figure, Some(0), TRIANGLES, viewport)?;
    let source = framed.source();
    let portrait = build(&source, &PortraitOptions::default(), &mut Progress::none())?;
    let both = Both {
        figure: &figure,
        camera: source.camera,
        portrait: &portrait,
    };
    let rest = both.in_3d(0);
    let shown = values.iter().enumerate().map(|(index, (fap, value))| {
        let mut shown = Shown {
            fap: *fap,
            value: *value,
            moved_px: 0.0,
            error_px: [0.0; 3],
        };
        for (part, error_px) in shown.error_px.iter_mut().enumerate() {
            let state = 1 + PARTS.len() * index + part;
            let truth = both.in_3d(state);
            *error_px = farthest(&truth, &both.in_2d(state)?);
            shown.moved_px = shown.moved_px.max(farthest(&truth, &rest));
        }
        Ok(shown)
    });
    Ok(Measured {
        name,
        triangles: portrait.counts().triangles,
        rest_px: farthest(&rest, &both.in_2d(0)?),
        shown: shown.collect::<Result<_>>()?,
    })
}

/// The parameters that something of a head shows, with their greatest values.
fn values(opened: &CharacterFile) -> Vec<(usize, i32)> {
    let names = opened
        .character()
        .meshes
        .iter()
        .flat_map(|m| &m.morph_names);
    let parts: Vec<FapInterval> = names.filter_map(|n| FapInterval::parse(n)).collect();
    let greatest = |fap: usize| {
        let own = parts.iter().filter(|part| part.fap == fap).map(|p| p.to);
        let own = own.max_by_key(|to| (to.abs(), *to));
        let turn = TURNS.iter().find(|(turned, _)| *turned == fap).map(|t| t.1);
        own.or(turn)
    };
    LOW_FAPS
        .filter_map(|fap| Some((fap, greatest(fap)?)))
        .collect()
}

/// Rest, then each value at each part, each held for some frames.
fn clip(values: &[(usize, i32)]) -> FapClip {
    let mut states = vec![[0; LOW_FAP_COUNT]];
    for (fap, value) in values {
        for part in PARTS {
            let mut low = [0; LOW_FAP_COUNT];
            low[fap - LOW_FAPS.start()] = (*value as f32 * part).round() as i32;
            states.push(low);
        }
    }
    let held = states
        .iter()
        .flat_map(|low| std::iter::repeat_n(*low, HELD));
    let frames = held.enumerate().map(|(number, low)| FapFrame {
        number: number as u32,
        low,
        ..FapFrame::default()
    });
    FapClip {
        name: "parameters".to_owned(),
        rate_hz: RATE_HZ,
        coded: std::array::from_fn(|fap| fap + 1 >= *LOW_FAPS.start()),
        frames: frames.collect(),
        bridge: None,
    }
}

/// A head in 3D and its portrait.
struct Both<'a> {
    figure: &'a Figure,
    camera: Camera,
    portrait: &'a Portrait,
}

impl Both<'_> {
    /// Time in the middle of a state, seconds.
    fn time(state: usize) -> f64 {
        (HELD * state + HELD / 2) as f64 / f64::from(RATE_HZ)
    }

    /// Where the vertices of the portrait are on the projected figure, pixels.
    fn in_3d(&self, state: usize) -> Vec<Vec2> {
        let asset = &self.figure.asset;
        let (clip, rig) = (&asset.clips[0], &asset.rig);
        let mut local = rig.rest_pose().clone();
        sample(clip, Self::time(state), Wrap::Clamp, &rig.all(), &mut local);
        let mut morphs = asset.mesh.morph_weights.clone();
        sample_morphs(clip, Self::time(state), Wrap::Clamp, &mut morphs);
        let mut posed = PosedMesh::new(rig, &asset.mesh);
        let places = posed.pose(&local).skinned(&morphs).positions;
        let vertices = self.portrait.vertices().iter();
        let project = |v: &u32| self.camera.project(places[*v as usize]).0;
        vertices.map(project).collect()
    }

    /// Where the portrait has them.
    fn in_2d(&self, state: usize) -> Result<Vec<Vec2>> {
        let clip = self.portrait.clips.first().context("no clip")?;
        let (pose, weights) = clip.at(Self::time(state) as f32);
        Ok(self.portrait.places(&pose, &weights)?)
    }
}

fn farthest(a: &[Vec2], b: &[Vec2]) -> f32 {
    let all = a.iter().zip(b).map(|(a, b)| a.distance(*b));
    all.fold(0.0, f32::max)
}

impl Shown {
    fn worst_px(&self) -> f32 {
        self.error_px.iter().copied().fold(0.0, f32::max)
    }

    /// As the thesis' annex C: what is kept as it is, what changes, and what is left out.
    fn state(&self) -> &'static str {
        if self.moved_px < LEAST_PX {
            "dropped"
        } else if self.worst_px() <= LEAST_PX {
            "exact"
        } else {
            "approximated"
        }
    }
}

impl Measured {
    fn of(&self, fap: usize) -> Option<&Shown> {
        self.shown.iter().find(|s| s.fap == fap)
    }

    fn count(&self, state: &str) -> usize {
        let all = 1..=FAP_COUNT;
        all.filter(|fap| state_of(self, *fap) == state).count()
    }

    /// The largest error of a parameter that is not dropped.
    fn worst_px(&self) -> f32 {
        let kept = self.shown.iter().filter(|s| s.state() != "dropped");
        kept.map(Shown::worst_px).fold(0.0, f32::max)
    }
}

/// How a parameter is shown; visemes and expressions are sums of others.
fn state_of(head: &Measured, fap: usize) -> &'static str {
    match head.of(fap) {
        _ if !LOW_FAPS.contains(&fap) => "by others",
        Some(shown) => shown.state(),
        None => "dropped",
    }
}

fn page(heads: &[Measured]) -> String {
    let targets = heads.iter().map(|head| {
        let labels = [
            head.name,
            "largest error of a parameter that moves 0.5 px or more, px",
        ];
        Target::at_most(labels, f64::from(LEAST_PX), f64::from(head.worst_px()))
    });
    let targets: Vec<Target> = targets.collect();
    let mut out = format!(
        "# Facial animation parameters on portraits\n\nBy `articula-lab portrait-parameters`: each of the 68 \
         parameters at a third, two thirds and all of its greatest value, on portraits of {SIDE_PX} pixels: the \
         vertices of the 2D mesh beside the projection of the head that the same face animation table moves in 3D \
         ([portrait](../formats/portrait.md); the thesis' annex C). A parameter is *exact* if no vertex is more than \
         {LEAST_PX} px off, *approximated* if one is, *dropped* if it moves nothing by as much, be it that the head \
         lacks the part; ICT-FaceKit has no joint that turns it in 3D, though its portrait turns. FAP 1 and 2 are shown \
         by the others. Hidden vertices, as of the tongue in a closed mouth, \
         count like all others.\n"
    );
    out += &section(
        "Nothing that moves is off by more than half a pixel.",
        &["head", "quantity"],
        &targets,
    );
    out += "\n## Heads\n\n| head | triangles | error at rest, px | exact | approximated | dropped |\n| --- | --- | --- | --- | --- | --- |\n";
    for head in heads {
        let [exact, approximated, dropped] =
            ["exact", "approximated", "dropped"].map(|s| head.count(s));
        let _ = writeln!(
            out,
            "| {} | {} | {:.2} | {exact} | {approximated} | {dropped} |",
            head.name, head.triangles, head.rest_px
        );
    }
    out += "\n## Parameters\n\nOf each head: the greatest value, how far it moves a vertex, the largest errors at the three values in pixels, and how the parameter is shown.\n\n| FAP | name |";
    let columns = heads.iter().map(|head| format!(" {} |", head.name));
    out.extend(columns);
    out += "\n| --- | --- |";
    out += &" --- |".repeat(heads.len());
    for fap in 1..=FAP_COUNT {
        let _ = write!(out, "\n| {fap} | {} |", TABLE[fap - 1].name);
        for head in heads {
            out += &cell(head, fap);
        }
    }
    out + "\n"
}

fn cell(head: &Measured, fap: usize) -> String {
    let state = state_of(head, fap);
    let Some(shown) = head.of(fap) else {
        return format!(" {state} |");
    };
    let [a, b, c] = shown.error_px;
    let (value, moved) = (shown.value, shown.moved_px);
    format!(" {value}: {moved:.1} px; {a:.2}, {b:.2}, {c:.2}; {state} |")
}

fn csv(heads: &[Measured]) -> String {
    let mut out =
        "head,fap,name,value,moved_px,error_third_px,error_two_thirds_px,error_px,shown\n"
            .to_owned();
    for head in heads {
        for s in &head.shown {
            let [a, b, c] = s.error_px;
            let _ = writeln!(
                out,
                "{},{},{},{},{:.3},{a:.3},{b:.3},{c:.3},{}",
                head.name,
                s.fap,
                TABLE[s.fap - 1].name,
                s.value,
                s.moved_px,
                s.state()
            );
        }
    }
    out
}
