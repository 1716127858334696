//! The steps: open, prepare, open what was prepared, play a figure and a crowd, flatten, package and
//! adapt; and hear a voice.

use crate::fnv::Fnv;
use articula::build::clip_edit::trim;
use articula::core::{Mismatch, palette};
use articula::crowd::{
    CrowdAsset, CrowdOptions, CrowdPlayer, PaletteHash, RootMotionPolicy, figure_model,
};
use articula::flat::flatten::{PrepareClipOptions, Profile, Quality, Settings};
use articula::flatten::{FramedCharacter, Shot, TriangleCount, flatten};
use articula::glam::{Affine3A, Mat4, Vec3};
use articula::item::{AdaptOptions, AdaptedItem, Item, PackageOptions, adapt, decide, package};
use articula::playback::{FigureModel, FigurePlayer, FigureSkin, FigureViews, FullDetail};
use articula::speech::{Sound, VisemeTrack};
use articula::stream::description::Context;
use articula::{
    Camera, CharacterFile, Executor, Figure, GroupedSkin, MeshLevelOptions, OpenOptions,
    PrepareOptions, PreparedMeshLevels, Viewport, open, prepare,
};
use std::error::Error;

const FILE: &[u8] =
    include_bytes!("../../../../assets/glb/Quaternius_single_knight_pack__KnightCharacter.glb");

const VOICE: &[u8] = include_bytes!("../../../../assets/speech/librivox_austen_0880.wav");

/// A clip that moves every joint, and how much of it is taken.
const CLIP: usize = 8;
const SECS: f32 = 0.25;

const FRAMES: usize = 12;

type Found<T> = Result<T, Box<dyn Error>>;

/// Takes the steps in order and tells the name and the hash of each; returns the prepared asset.
pub(crate) fn take(tell: &mut dyn FnMut(&str, u64)) -> Found<Vec<u8>> {
    let work = Executor::default();
    let opened = cut(opened(FILE, "knight.glb")?)?;
    tell("open", asset(&Figure::new(opened.clone())?));
    let options = PrepareOptions {
        mesh_levels: PreparedMeshLevels::New(MeshLevelOptions::levels(2)),
        ..PrepareOptions::default()
    };
    let prepared = prepare(opened.clone(), &options, &work)?.glb;
    tell("prepare", of_bytes([&prepared[..]]));
    let figure = Figure::new(opened_whole(&prepared, &opened)?)?;
    tell("open prepared", asset(&figure));
    tell("figure", play(&figure)?);
    tell("palettes of the figure", figure_palettes(&figure)?);
    let (crowd, palettes) = crowd(&figure, &work)?;
    tell("crowd", crowd);
    tell("palettes of the crowd", palettes);
    tell("flatten", flat(&figure, &work)?);
    let item = packaged(opened, &work)?;
    tell("package", of_item(&item));
    tell("adapt", of_item(&adapted(&item)?));
    tell("speech", heard()?);
    Ok(prepared)
}

/// The visemes of a recording.
fn heard() -> Found<u64> {
    let mut sum = Fnv::default();
    for frame in VisemeTrack::recognised(&Sound::from_wav(VOICE)?).frames {
        sum.floats(&frame.weights);
        sum.floats(&[frame.level_db]);
    }
    Ok(sum.finish())
}

fn opened(bytes: &[u8], name: &str) -> Found<CharacterFile> {
    let mut alone = |_: &str| Err("it has no other files".into());
    Ok(open(bytes, name, &OpenOptions::default(), &mut alone)?)
}

/// One clip, cut short: what is compared shows in few frames.
fn cut(mut file: CharacterFile) -> Found<CharacterFile> {
    file.select_clips(&[CLIP]);
    for clip in file.clips_mut() {
        *clip = trim(clip, 0.0..=SECS)?;
    }
    Ok(file)
}

/// Opens a prepared asset, whose data must be taken as it is: nothing is said of it that was not
/// said of its source.
fn opened_whole(bytes: &[u8], source: &CharacterFile) -> Found<CharacterFile> {
    let file = opened(bytes, "prepared.glb")?;
    let known = |what: &str| source.warnings().iter().any(|known| known.what == what);
    match file.warnings().iter().find(|new| !known(&new.what)) {
        Some(new) => Err(format!("the prepared asset: {}", new.what).into()),
        None => Ok(file),
    }
}

fn of_bytes<'a>(all: impl IntoIterator<Item = &'a [u8]>) -> u64 {
    let mut sum = Fnv::default();
    all.into_iter().for_each(|bytes| sum.bytes(bytes));
    sum.finish()
}

fn asset(figure: &Figure) -> u64 {
    let asset = &figure.asset;
    let mut sum = Fnv::default();
    let rest = asset.rig.rest_pose();
    let turns = rest.rotations.iter();
    turns.for_each(|turn| sum.floats(&turn.to_array()));
    let ways = rest.translations.iter();
    ways.for_each(|way| sum.floats(&way.to_array()));
    for clip in &asset.clips {
        let tracks = clip.tracks();
        let turns = tracks.rotations.iter().flat_map(|track| &track.values);
        turns.for_each(|turn| sum.floats(&turn.to_array()));
        let ways = tracks.translations.iter().flat_map(|track| &track.values);
        ways.for_each(|way| sum.floats(&way.to_array()));
    }
    let places = asset.mesh.positions.iter();
    places.for_each(|place| sum.floats(&place.to_array()));
    sum.finish()
}

fn play(figure: &Figure) -> Result<u64, Mismatch> {
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let model = FigureModel::new(rig.clone(), &figure.asset.clips[..])?;
    let mut player = FigurePlayer::new(model, &mesh.morph_weights);
    let mut skin = FigureSkin::new(mesh.clone(), GroupedSkin::new(mesh));
    let mut sum = Fnv::default();
    let camera = Camera::looking_at(4.0 * Vec3::Z, Vec3::Y, Viewport::default());
    for _ in 0..FRAMES {
        player.advance(1.0 / 60.0, &mut |_| {});
        player.control(&mut FullDetail::default(), FigureViews::Cameras(&[camera]));
        player.hierarchy();
        skin.skin(player.model_pose(), player.morph_weights());
        let matrices = player.model_pose().matrices.iter();
        matrices.for_each(|m| sum.floats(&m.to_cols_array()));
        let positions = skin.skinned().positions.iter();
        positions.for_each(|p| sum.floats(&p.to_array()));
    }
    Ok(sum.finish())
}

/// Palettes as a renderer reads them, three rows of four numbers a matrix: what modules for web pages show too.
fn figure_palettes(figure: &Figure) -> Found<u64> {
    let mesh = &figure.asset.mesh;
    let model = figure_model(figure, RootMotionPolicy::AsAuthored)?;
    let mut player = FigurePlayer::new(model, &mesh.morph_weights);
    let mut matrices = vec![Affine3A::IDENTITY; mesh.bindings.len()];
    let mut sum = Fnv::default();
    let camera = Camera::looking_at(4.0 * Vec3::Z, Vec3::Y, Viewport::default());
    for _ in 0..FRAMES {
        player.advance(1.0 / 60.0, &mut |_| {});
        player.control(&mut FullDetail::default(), FigureViews::Cameras(&[camera]));
        player.hierarchy();
        palette(mesh, player.model_pose(), &mut matrices);
        for matrix in &matrices {
            let rows = Mat4::from(*matrix).transpose().to_cols_array();
            sum.floats(&rows[..12]);
        }
    }
    Ok(sum.finish())
}

/// Hashes of the frames of a crowd, and of the palettes and draws that a renderer reads of them.
fn crowd(figure: &Figure, work: &Executor<'_>) -> Found<(u64, u64)> {
    let asset = CrowdAsset::new(figure, &CrowdOptions::default(), work)?;
    if let Some(warning) = asset.warnings().first() {
        return Err(format!("the crowd: {warning}").into());
    }
    let mut crowd = CrowdPlayer::new(&asset, 60)?;
    for i in 0..60 {
        let place = Vec3::new((i % 6) as f32, 0.0, (i / 6) as f32);
        crowd.place(i, 2.0 * place, 0.0);
        crowd.play(i, 0, 0.037 * i as f32);
    }
    let eye = Vec3::new(6.0, 1.7, -6.0);
    let camera = Camera::looking_at(eye, eye + Vec3::Z, Viewport::default());
    let (mut sum, mut read) = (PaletteHash::default(), Fnv::default());
    for _ in 0..FRAMES {
        crowd.frame(1.0 / 60.0, &camera);
        sum.add(&crowd);
        read.bytes(crowd.palettes().bytes());
        for draw in crowd
            .crowd()
            .draw_list()
            .draws
            .iter()
            .chain(crowd.stepped())
        {
            read.bytes(&draw.character.to_le_bytes());
            read.bytes(&draw.first_matrix.to_le_bytes());
        }
    }
    Ok((u64::from_str_radix(&sum.text(), 16)?, read.finish()))
}

fn flat(figure: &Figure, work: &Executor<'_>) -> Found<u64> {
    let shot = Shot {
        clip: Some(0),
        fps: 10.0,
        yaw_deg: 30.0,
        pitch_deg: 10.0,
        viewport: Viewport::default(),
        triangles: TriangleCount::About(60),
        ..Shot::default()
    };
    let framed = FramedCharacter::new(figure, shot, work)?;
    let settings = Settings {
        profile: Profile::Smil,
        quality: Quality::of(Profile::Smil),
        name: "knight".to_owned(),
        max_bytes: None,
    };
    let made = flatten(&framed, PrepareClipOptions::default(), &settings, work)?;
    Ok(of_bytes([&made.bytes[..]]))
}

fn packaged(opened: CharacterFile, work: &Executor<'_>) -> Found<Item> {
    let options = PackageOptions {
        mesh_levels: 2,
        split: Vec::new(),
        flat: false,
        ..PackageOptions::default()
    };
    Ok(package(opened, &options, work)?)
}

fn of_item(item: &Item) -> u64 {
    let files = item.files();
    of_bytes(
        files
            .iter()
            .flat_map(|(name, bytes)| [name.as_bytes(), bytes]),
    )
}

/// What is chosen of the item where nothing limits it.
fn adapted(item: &Item) -> Found<Item> {
    let decision = decide(item, &Context::default(), &AdaptOptions::default())?;
    let cut = decision.cut.as_ref().ok_or("nothing is chosen")?;
    match adapt(item, cut)? {
        AdaptedItem::Layers(item) => Ok(item),
        AdaptedItem::Flat { .. } => Err("the item fell to a picture".into()),
    }
}
