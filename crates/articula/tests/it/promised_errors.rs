//! A judge of promises: contexts by chance decide what is sent of an item, and no point of the skin is
//! farther from its place than the decision says. Poses are the core's, distances plain code.

use crate::real;
use crate::short::shortened;
use articula::item::{
    AdaptOptions, AdaptedItem, Item, ItemDecision, PackageOptions, PartKind, adapt, assemble,
    decide, decide_by_table, package,
};
use articula::{Executor, Figure, OpenOptions, fs};
use articula_core::{Clip, Mesh, PosedMesh, Rig, Wrap, sample_morphs};
use articula_mutate::Dice;
use articula_stream::decide::{Bound, Outcome, PartKind as ChoiceKind};
use articula_stream::description::{Aqos, Context};
use glam::DVec3;
use std::sync::OnceLock;

/// Slack on errors of meshes, which are measured on some poses, not on these frames.
const SLACK: f64 = 1.1;
/// Points of the skin that are judged.
const POINTS: usize = 120;
/// Frames of a clip that are judged.
const FRAMES: usize = 4;

fn made(name: &str, clips: &[&str]) -> Option<(Figure, Item)> {
    let opened = shortened(fs::open(real::file(name)?).unwrap(), 0.5);
    let options = PackageOptions {
        clips: clips.iter().map(|clip| (*clip).to_owned()).collect(),
        mesh_levels: 3,
        texture_distances_m: vec![3.0],
        flat: false,
        ..PackageOptions::default()
    };
    let item = package(opened.clone(), &options, &Executor::default()).unwrap();
    Some((Figure::new(opened).unwrap(), item))
}

/// A robot with two clips; `None` without the file.
pub(crate) fn robot() -> Option<&'static (Figure, Item)> {
    static MADE: OnceLock<Option<(Figure, Item)>> = OnceLock::new();
    let clips = ["Robot_Walking", "Robot_Jump"];
    MADE.get_or_init(|| made("glb/RobotExpressive.glb", &clips))
        .as_ref()
}

/// A man with a texture.
pub(crate) fn man() -> Option<&'static (Figure, Item)> {
    static MADE: OnceLock<Option<(Figure, Item)>> = OnceLock::new();
    MADE.get_or_init(|| made("glb/CesiumMan.glb", &[])).as_ref()
}

/// Points of a mesh in a clip at a time.
fn posed(rig: &Rig, mesh: &Mesh, clip: &Clip, secs: f64) -> Vec<DVec3> {
    let mut posed = PosedMesh::new(rig, mesh);
    let mut weights = mesh.morph_weights.clone();
    sample_morphs(clip, secs, Wrap::Clamp, &mut weights);
    let skinned = posed.pose_at(clip, secs, Wrap::Clamp).skinned(&weights);
    skinned.positions.iter().map(|p| p.as_dvec3()).collect()
}

/// Distance of a point from a triangle: the least of those from its plane, where the foot is inside,
/// and from its sides.
fn from_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let side = |from: DVec3, to: DVec3| {
        let way = to - from;
        let t = (p - from).dot(way) / way.length_squared().max(1e-300);
        p.distance(from + t.clamp(0.0, 1.0) * way)
    };
    let sides = side(a, b).min(side(b, c)).min(side(c, a));
    let normal = (b - a).cross(c - a);
    let inside = |from: DVec3, to: DVec3| normal.dot((to - from).cross(p - from)) >= 0.0;
    match inside(a, b) && inside(b, c) && inside(c, a) && normal.length_squared() > 0.0 {
        true => ((p - a).dot(normal) / normal.length()).abs().min(sides),
        false => sides,
    }
}

/// A character, and what is shown of it.
pub(crate) struct Judged<'a> {
    original: &'a Figure,
    shown: Figure,
}

impl<'a> Judged<'a> {
    pub(crate) fn new(original: &'a Figure, item: &Item) -> Self {
        let shown = assemble(item, &OpenOptions::default()).unwrap();
        Self {
            original,
            shown: Figure::new(shown).unwrap(),
        }
    }

    /// Greatest distance of points of the true skin from the shown one, at a time of a clip.
    pub(crate) fn shown_m(&self, clip: &str, secs: f64) -> f64 {
        let (a, b) = (&self.original.asset, &self.shown.asset);
        let find = |clips: &[Clip]| clips.iter().position(|c| c.name == clip).unwrap();
        let right = posed(&a.rig, &a.mesh, &a.clips[find(&a.clips)], secs);
        let is = posed(&b.rig, &b.mesh, &b.clips[find(&b.clips)], secs);
        let used = a.mesh.triangles.iter().flatten();
        let every = a.mesh.triangles.len() * 3 / POINTS;
        let distances = used.step_by(every.max(1)).map(|vertex| {
            let point = right[*vertex as usize];
            let corners = b.mesh.triangles.iter().map(|t| t.map(|v| is[v as usize]));
            let near = corners.map(|triangle| from_triangle(point, triangle));
            near.fold(f64::INFINITY, f64::min)
        });
        distances.fold(0.0, f64::max)
    }
}

/// The same over all clips that are sent.
fn shown_m(original: &Figure, item: &Item) -> f64 {
    let judged = Judged::new(original, item);
    let mut most = 0.0_f64;
    for clip in &judged.shown.asset.clips {
        let clips = original.asset.clips.iter();
        let truth = clips.clone().find(|truth| truth.name == clip.name).unwrap();
        for frame in 0..FRAMES {
            let secs = f64::from(truth.duration_secs()) * frame as f64 / (FRAMES - 1) as f64;
            most = most.max(judged.shown_m(&clip.name, secs));
        }
    }
    most
}

/// The promise of a decision in metres, without that of textures, which move nothing.
fn promised_m(decided: &ItemDecision) -> f64 {
    let parts = decided.decision.parts.iter();
    let shape = parts.filter(|part| part.kind != ChoiceKind::Texture);
    let px: f64 = shape.map(|part| part.error_px).sum();
    px / decided.decision.request.pixels_per_metre
}

fn sent(item: &Item, decided: &ItemDecision) -> Option<Item> {
    match adapt(item, decided.cut.as_ref()?).unwrap() {
        AdaptedItem::Layers(item) => Some(item),
        AdaptedItem::Flat { .. } => None,
    }
}

/// A context by chance: how far, which zones and levels, how many bytes and how much memory.
fn by_chance(item: &Item, dice: &mut Dice) -> (Context, AdaptOptions) {
    let mut context = Context::default();
    let unit = |dice: &mut Dice| dice.roll(1 << 20) as f64 / f64::from(1 << 20);
    context.view.distance_m = Some(1.0 + 20.0 * unit(dice));
    if dice.roll(2) == 0 {
        context.preferences.body_regions = Some(1 + dice.roll(127) as u8);
    }
    if dice.roll(3) == 0 {
        context.preferences.body_loa = Some(dice.roll(6) as u8);
    }
    if dice.roll(3) == 0 {
        context.terminal.memory_bytes = Some(1e6 * unit(dice));
    }
    let options = AdaptOptions {
        max_bytes: Some((item.sent_bytes() as f64 * (0.2 + unit(dice))) as u64),
        ..AdaptOptions::default()
    };
    (context, options)
}

/// Judges decisions of so many contexts about an item; returns how many sent something, and how near to
/// its promise the worst came.
fn judge(original: &Figure, item: &Item, contexts: usize) -> (usize, f64) {
    let mut dice = Dice::new(20_44);
    let (mut judged, mut nearest) = (0, 0.0_f64);
    for case in 0..contexts {
        let (context, options) = by_chance(item, &mut dice);
        let motions = item.manifest.parts.iter();
        let names: Vec<String> = motions
            .filter(|part| part.kind == PartKind::BodyMotion && dice.roll(3) > 0)
            .map(|part| part.name.clone())
            .collect();
        let item = item.with_clips(&names).unwrap();
        let decided = decide(&item, &context, &options).unwrap();
        let Some(adapted) = sent(&item, &decided) else {
            continue;
        };
        let (found, promised) = (shown_m(original, &adapted), promised_m(&decided));
        assert!(
            found <= SLACK * promised + 1e-4,
            "{} {case}: {found} m, promised {promised} m\n{}",
            item.manifest.name,
            decided.decision
        );
        assert!(adapted.sent_bytes() <= options.max_bytes.unwrap());
        nearest = nearest.max(found / (promised + 1e-4));
        judged += 1;
    }
    (judged, nearest)
}

#[test]
fn no_point_of_the_skin_is_farther_off_than_promised() {
    let made = [robot(), man()].into_iter().flatten();
    let judged: usize = made.map(|(figure, item)| judge(figure, item, 12).0).sum();
    assert!(robot().is_none() || judged >= 8, "{judged}");
}

/// The same over twelve characters, in as many contexts for each as `ARTICULA_JUDGED_CONTEXTS` says; a
/// single one otherwise, of a single character.
#[test]
fn promises_of_many_characters_hold() {
    const CHARACTERS: [&str; 12] = [
        "glb/RiggedFigure.glb",
        "glb/KayKit_Knight.glb",
        "glb/KayKit_Mage.glb",
        "glb/RobotExpressive.glb",
        "glb/CesiumMan.glb",
        "glb/Fox.glb",
        "glb/pab_arnaud.glb",
        "glb/mannequiny.glb",
        "glb/Quaternius_single_knight_pack__KnightCharacter.glb",
        "glb/mh_female_dance.glb",
        "glb/Quaternius_cyberpunk_pack__Character.glb",
        "glb/ict_head_talk_554.glb",
    ];
    let asked = std::env::var("ARTICULA_JUDGED_CONTEXTS");
    let asked: Option<usize> = asked.ok().map(|count| count.parse().unwrap());
    let (contexts, characters) = match asked {
        Some(count) => (count, &CHARACTERS[..]),
        None => (1, &CHARACTERS[..1]),
    };
    for name in characters {
        let Some(path) = real::file(name) else {
            continue;
        };
        let clips = fs::open(path).unwrap().into_character().clips;
        let first: Vec<&str> = clips.iter().take(2).map(|c| c.name.as_str()).collect();
        let Some((original, item)) = made(name, &first) else {
            continue;
        };
        let (judged, nearest) = judge(&original, &item, contexts);
        if asked.is_some() {
            println!("{name}: {judged} of {contexts} judged, at most {nearest:.3} of the promise");
        }
    }
}

#[test]
fn zones_that_are_cut_count_and_are_named() {
    let Some((original, item)) = robot() else {
        return;
    };
    let mut context = Context::default();
    // Face, arms, torso and hands.
    context.preferences.body_regions = Some(71);
    let options = AdaptOptions::default();
    let decided = decide(item, &context, &options).unwrap();
    let adapted = sent(item, &decided).unwrap();
    let lost = decided
        .decision
        .parts
        .iter()
        .find(|p| p.kind == ChoiceKind::Other);
    let lost = lost.unwrap();
    assert!(lost.name == "without pelvis, legs", "{}", lost.name);
    let found = shown_m(original, &adapted);
    let promised = promised_m(&decided);
    let others = promised - lost.error_px / decided.decision.request.pixels_per_metre;
    assert!(
        found > 10.0 * others,
        "the zones are most of the error: {found}, {others}"
    );
    assert!(found <= promised, "{found} {promised}");
    // An item that was cut still tells what it lacks.
    let again = decide(&adapted, &Context::default(), &options).unwrap();
    assert!((promised_m(&again) - promised).abs() < 1e-9);
    // Bytes are not spent on what the viewer leaves out.
    context.view.distance_m = Some(30.0);
    let far = decide(item, &context, &options).unwrap();
    assert!(far.decision.bytes < decided.decision.bytes);
}

#[test]
fn a_table_sends_one_size_of_each_texture_within_the_bytes() {
    let Some((_, item)) = man() else { return };
    let options = AdaptOptions::default();
    let table = articula::item::aqos(item, &Context::default(), &options).unwrap();
    let all = Aqos::one_to_one(&[0.0]);
    let mut kept = 0;
    for step in 0..14 {
        let mut context = Context::default();
        let bps = 60e3 * 1.5_f64.powi(step);
        context.network.available_bps = Some(bps);
        let allowed = (bps * options.wait_secs / 8.0) as u64;
        let fits = decide(item, &context, &options).unwrap().cut.is_some();
        for table in [&table, &all] {
            let (decided, cut) = decide_by_table(item, table, &context, &options).unwrap();
            let AdaptedItem::Layers(adapted) = adapt(item, &cut).unwrap() else {
                panic!("there is no form in 2D");
            };
            let parts = adapted.manifest.parts.iter();
            let mut sizes = parts.filter(|p| p.kind == PartKind::Texture);
            assert!(sizes.all(|texture| texture.layers.len() == 1));
            if fits {
                assert!(
                    adapted.sent_bytes() <= allowed,
                    "{} of {allowed}",
                    adapted.sent_bytes()
                );
                kept += 1;
            } else {
                let last = decided.reasons.last().unwrap();
                assert!(last.contains("nothing fits; the least"), "{last}");
            }
        }
    }
    assert!(kept > 10, "{kept}");
}

#[test]
fn memory_is_a_bound() {
    let Some((_, item)) = man() else { return };
    let with = |bytes: f64| {
        let mut context = Context::default();
        context.terminal.memory_bytes = Some(bytes);
        decide(item, &context, &AdaptOptions::default()).unwrap()
    };
    let memory = |decided: &ItemDecision| match &decided.decision.outcome {
        Outcome::Parts(choice) => choice.memory_bytes,
        other => panic!("{other:?}"),
    };
    let ample = with(1e12);
    let full = memory(&ample);
    // A texture of 1024 x 1024 with its halves takes 5.6 MB.
    assert!(full > 5_600_000, "{full}");
    let mut error = ample.decision.error_px;
    for share in [0.9, 0.5, 0.2, 0.12] {
        let decided = with(share * full as f64);
        assert!(memory(&decided) as f64 <= share * full as f64);
        assert!(decided.decision.error_px >= error);
        error = decided.decision.error_px;
        assert!(decided.decision.bounds.contains(&Bound::Memory));
    }
    let nothing = with(1000.0);
    assert_eq!(nothing.decision.outcome, Outcome::Nothing);
    assert_eq!(
        (nothing.least_bytes, &*nothing.decision.bounds),
        (None, &[Bound::Memory][..])
    );
}

#[test]
fn nothing_fits_tells_the_least_that_would() {
    let Some((_, item)) = man() else { return };
    let mut context = Context::default();
    context.network.available_bps = Some(16e3);
    let nothing = decide(item, &context, &AdaptOptions::default()).unwrap();
    let least = nothing.least_bytes.unwrap();
    assert_eq!(nothing.least_secs, Some(least as f64 / 2000.0));
    let with = |max_bytes: u64| {
        let options = AdaptOptions {
            max_bytes: Some(max_bytes),
            ..AdaptOptions::default()
        };
        let decided = decide(item, &Context::default(), &options).unwrap();
        Some(adapt(item, &decided.cut?).unwrap().sent_bytes())
    };
    assert_eq!(with(least), Some(least));
    assert_eq!(with(least - 1), None);
}

#[test]
fn clips_that_are_not_named_are_not_sent() {
    let Some((_, item)) = robot() else { return };
    let one = item.with_clips(&["Robot_Jump".to_owned()]).unwrap();
    let motions = |item: &Item| {
        let parts = item.manifest.parts.iter();
        parts.filter(|p| p.kind == PartKind::BodyMotion).count()
    };
    assert_eq!((motions(item), motions(&one)), (2, 1));
    assert!(one.bytes() < item.bytes());
    assert!(one.file("clips/Robot_Walking.abp").is_none());
    let decided = decide(&one, &Context::default(), &AdaptOptions::default()).unwrap();
    let adapted = sent(&one, &decided).unwrap();
    let shown = assemble(&adapted, &OpenOptions::default()).unwrap();
    assert_eq!(shown.character().clips.len(), 1);
    assert_eq!(item.with_clips(&[]).unwrap(), *item);
    let why = item.with_clips(&["fly".to_owned()]).unwrap_err();
    assert!(
        why.is_argument() && why.to_string().contains("Robot_Jump"),
        "{why}"
    );
}
