//! Textures of an item: each picture at several sizes, with the error of each in the same render. The
//! smallest is the mean colour, the pixel that the figure has of it.
//!
//! Definition of the errors: `docs/metrics.md`.

use super::figure::{StrippedFigure, averaging, pixel};
use super::files::NewFiles;
use super::name::Names;
use super::options::PackageOptions;
use super::part::{ItemLayer, ItemPart, PIXEL, PartKind, TextureView};
use crate::error::Result;
use crate::facing::facing;
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::source::Image;
use articula_core::{Camera, PosedMesh, SkinnedMesh, Viewport};
use articula_flat::{
    Appearance, Averaging, Bounds, Picture, Projection, RenderOptions, equal_shift, render,
};
use glam::{Vec2, Vec3};

/// Longest side of a picture that is rendered, in pixels; nearer views are of lower resolution.
const LONGEST_PX: f32 = 2048.0;
/// Free space around the figure in pixels.
const MARGIN_PX: f32 = 4.0;

/// A picture of the character, and the files of its sizes.
struct Sizes {
    image: usize,
    picture: Picture,
    /// Files with width and height, the smallest first: the one that the figure holds.
    files: Vec<(Vec<u8>, [u32; 2])>,
}

impl Sizes {
    /// The sizes of a picture, the largest first, with the pixel of its mean colour.
    fn new(
        image: usize,
        picture: Picture,
        mut files: Vec<(Vec<u8>, [u32; 2])>,
        averaging: Averaging,
    ) -> Result<Self> {
        files.retain(|(_, size)| *size != PIXEL);
        files.push((pixel(&picture, averaging)?, PIXEL));
        files.reverse();
        Ok(Self {
            image,
            picture,
            files,
        })
    }
}

/// Textures, and which could not be made.
#[derive(Debug, Default)]
pub(super) struct Textures {
    pub(super) parts: Vec<ItemPart>,
    pub(super) warnings: Vec<String>,
}

/// Adds the textures that the figure does not hold.
pub(super) fn parts(
    figure: &Figure,
    stripped: &StrippedFigure,
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Textures> {
    let scene = Scene::new(figure, options, &options.texture_distances_m)?;
    made(&scene, stripped, (options, sizes), files, work)
}

/// Adds each of these textures at one small size, compared at the nearest distance, where its error is
/// greatest.
pub(super) fn base(
    figure: &Figure,
    stripped: &StrippedFigure,
    options: &PackageOptions,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Textures> {
    let distances = options.texture_distances_m.iter().copied();
    let nearest: Vec<f32> = distances.min_by(f32::total_cmp).into_iter().collect();
    let scene = Scene::new(figure, options, &nearest)?;
    made(&scene, stripped, (options, smallest), files, work)
}

/// Reduces a picture: its index, itself, whether it holds colours, and options.
type Reduce = fn(usize, &Image, bool, &PackageOptions) -> Result<Sizes>;

fn made(
    scene: &Scene<'_>,
    stripped: &StrippedFigure,
    (options, reduce): (&PackageOptions, Reduce),
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<Textures> {
    let character = scene.figure.opened.character();
    let images = character.images.iter().enumerate();
    let images = images.filter(|(i, _)| stripped.is_replaced.get(*i) == Some(&true));
    let images: Vec<(usize, &Image)> = images.collect();
    let holds_colors = |i: usize| stripped.holds_colors.get(i) != Some(&false);
    let sized = work.map("reducing textures", images, |(i, image)| {
        Ok((i, reduce(i, image, holds_colors(i), options)))
    })?;
    let mut names = Names::default();
    let mut textures = Textures::default();
    for (image, sizes) in sized {
        let name = &character.images[image].name;
        let stem = names.stem("textures", name, &format!("picture-{image}"));
        match sizes {
            Ok(sizes) => textures.parts.push(part(scene, sizes, &stem, files, work)?),
            Err(error) => {
                let what = format!("picture {image}: one pixel stands for it: {error}");
                textures.warnings.push(what);
            }
        }
    }
    Ok(textures)
}

/// The original of a picture, and halves of it as PNG. A size that needs no fewer bytes than a larger
/// one is left out.
fn sizes(
    image: usize,
    original: &Image,
    holds_colors: bool,
    options: &PackageOptions,
) -> Result<Sizes> {
    let picture = Picture::decode(&original.bytes)?;
    let mut files = vec![(original.bytes.clone(), [picture.width(), picture.height()])];
    for (width, height) in halves(&picture, options) {
        let reduced = picture.resized((width, height), averaging(holds_colors))?;
        let bytes = reduced.to_small_png()?;
        if files
            .last()
            .is_some_and(|(larger, _)| bytes.len() < larger.len())
        {
            files.push((bytes, [width, height]));
        }
    }
    Sizes::new(image, picture, files, averaging(holds_colors))
}

/// The smallest size, or the original if that needs fewer bytes, and the mean colour.
fn smallest(
    image: usize,
    original: &Image,
    holds_colors: bool,
    options: &PackageOptions,
) -> Result<Sizes> {
    let picture = Picture::decode(&original.bytes)?;
    let mut file = (original.bytes.clone(), [picture.width(), picture.height()]);
    if let Some((width, height)) = halves(&picture, options).last() {
        let reduced = picture.resized((width, height), averaging(holds_colors))?;
        let bytes = reduced.to_small_png()?;
        if bytes.len() < file.0.len() {
            file = (bytes, [width, height]);
        }
    }
    Sizes::new(image, picture, vec![file], averaging(holds_colors))
}

/// Sizes of half the width and height of the one before, from a picture on.
fn halves(picture: &Picture, options: &PackageOptions) -> impl Iterator<Item = (u32, u32)> {
    let least = options.least_texture_px.max(1);
    let half = move |(width, height): &(u32, u32)| {
        let is_large = (*width).max(*height) / 2 >= least;
        is_large.then(|| ((width / 2).max(1), (height / 2).max(1)))
    };
    std::iter::successors(half(&(picture.width(), picture.height())), half)
}

fn part(
    scene: &Scene<'_>,
    sizes: Sizes,
    stem: &str,
    files: &mut NewFiles,
    work: &Executor<'_>,
) -> Result<ItemPart> {
    let texel_m = scene.texel_metres(sizes.image);
    let is_shown = scene.appearance.has_texture(sizes.image);
    let original = sizes.picture;
    let jobs: Vec<(usize, usize)> = (0..sizes.files.len())
        .flat_map(|size| (0..scene.views.len()).map(move |view| (size, view)))
        .filter(|_| is_shown)
        .collect();
    let pictures: Vec<Picture> = sizes
        .files
        .iter()
        .map(|(bytes, _)| Picture::decode(bytes))
        .collect::<Result<_, _>>()?;
    let views = work.map("comparing textures", jobs, |(size, view)| {
        let reduced = &pictures[size];
        let is_original = reduced == &original;
        let found = match is_original {
            true => TextureView {
                rms_levels: 0.0,
                error_px: 0.0,
                ..scene.views[view].entry()
            },
            false => scene.compared(view, sizes.image, reduced)?,
        };
        Ok((size, found))
    })?;
    let mut layers = Vec::with_capacity(sizes.files.len());
    for (size, (bytes, [width, height])) in sizes.files.into_iter().enumerate() {
        let extension = match bytes.first() {
            Some(0x89) => "png",
            Some(0xff) => "jpg",
            _ => "webp",
        };
        let longer = width.max(height);
        let is_in_figure = [width, height] == PIXEL;
        let file = (!is_in_figure).then(|| format!("textures/{stem}-{longer}.{extension}"));
        // A texel of the whole texture, at this size.
        let scale = f64::from(original.width()) / f64::from(width);
        let texel_m = texel_m.map(|texel| texel * scale);
        let mut of_size: Vec<TextureView> = views
            .iter()
            .filter(|(of, _)| *of == size)
            .map(|(_, view)| view.clone())
            .collect();
        for view in &mut of_size {
            view.texel_px = texel_m.map(|texel| texel * view.px_per_metre);
        }
        let errors = of_size.iter().map(|view| view.error_px / view.px_per_metre);
        layers.push(ItemLayer {
            name: format!("{width} x {height}"),
            bytes: match &file {
                Some(file) => files.put(file, bytes)?,
                None => 0,
            },
            error_m: errors.fold(0.0, f64::max),
            file,
            size_px: Some([width, height]),
            texel_m,
            views: of_size,
            ..ItemLayer::default()
        });
    }
    Ok(ItemPart {
        bytes: layers.iter().map(|layer| layer.bytes).sum(),
        image: Some(sizes.image),
        layers,
        ..ItemPart::new(stem, PartKind::Texture)
    })
}

/// One distance: the camera and the picture with all original textures.
struct View {
    distance_m: f32,
    /// Pixels per metre there, of the viewport.
    px_per_metre: f32,
    camera: Camera,
    options: RenderOptions,
    /// Pixels per metre of the picture over those of the viewport; at most 1.
    scale: f32,
    original: Picture,
}

impl View {
    fn entry(&self) -> TextureView {
        TextureView {
            distance_m: f64::from(self.distance_m),
            px_per_metre: f64::from(self.px_per_metre),
            rms_levels: 0.0,
            error_px: 0.0,
            texel_px: None,
        }
    }
}

/// The character at rest, seen from its front at several distances.
struct Scene<'a> {
    figure: &'a Figure,
    appearance: Appearance,
    skinned: SkinnedMesh,
    views: Vec<View>,
}

impl<'a> Scene<'a> {
    fn new(figure: &'a Figure, options: &PackageOptions, distances_m: &[f32]) -> Result<Self> {
        let asset = &figure.asset;
        let character = figure.opened.character();
        let (appearance, _) = Appearance::new(&character.materials, &character.images);
        let mut posed = PosedMesh::new(&asset.rig, &asset.mesh);
        posed.pose(asset.rig.rest_pose());
        let turn = facing(&asset.rig, &posed.model);
        let skinned = posed.skinned(&asset.mesh.morph_weights);
        let used = asset.mesh.triangles.iter().flatten();
        let points = used.map(|v| skinned.positions[*v as usize]);
        let bounds = Bounds::around(points.map(|p| (p, p)));
        let mut scene = Self {
            figure,
            appearance,
            skinned,
            views: Vec::new(),
        };
        let Some(bounds) = bounds else {
            return Ok(scene);
        };
        for distance_m in distances_m {
            let view = scene.view(&bounds, turn, *distance_m, &options.viewport)?;
            scene.views.push(view);
        }
        Ok(scene)
    }

    /// Weak perspective: the scale at the distance, for the whole figure.
    fn view(
        &self,
        bounds: &Bounds,
        turn: f32,
        distance_m: f32,
        viewport: &Viewport,
    ) -> Result<View> {
        let px_per_metre = viewport.pixels_per_metre(distance_m);
        let size = bounds.high - bounds.low;
        let wide = Vec2::new(size.x, size.z).length().max(1e-3);
        let tall = size.y.max(1e-3);
        let limit = (LONGEST_PX - 2.0 * MARGIN_PX) / wide.max(tall);
        let shown = px_per_metre.min(limit);
        let side = |metres: f32| (metres * shown + 2.0 * MARGIN_PX).ceil();
        let viewport = Viewport {
            width_px: side(wide),
            height_px: side(tall),
            ..*viewport
        };
        let toward = Vec3::new(turn.sin(), 0.0, turn.cos());
        let camera = Camera::looking_at(
            bounds.middle() + toward * distance_m,
            bounds.middle(),
            viewport,
        );
        let options = RenderOptions {
            background: [0; 4],
            projection: Projection::Parallel {
                pixels_per_metre: shown,
            },
            ..RenderOptions::default()
        };
        let mesh = &self.figure.asset.mesh;
        let original = render(mesh, &self.skinned, &self.appearance, &camera, &options)?;
        Ok(View {
            distance_m,
            px_per_metre,
            camera,
            options,
            scale: shown / px_per_metre,
            original,
        })
    }

    /// The difference that a reduced texture makes in a view.
    fn compared(&self, view: usize, image: usize, reduced: &Picture) -> Result<TextureView> {
        let view = &self.views[view];
        let appearance = self.appearance.with_texture(image, reduced.clone());
        let mesh = &self.figure.asset.mesh;
        let shown = render(
            mesh,
            &self.skinned,
            &appearance,
            &view.camera,
            &view.options,
        )?;
        let found = equal_shift(&view.original, &shown)?;
        Ok(TextureView {
            rms_levels: found.rms_levels,
            error_px: found.shift_px / f64::from(view.scale),
            ..view.entry()
        })
    }

    /// Side of a texel of a picture on the skin in metres: the median by area over the triangles that
    /// show it.
    fn texel_metres(&self, image: usize) -> Option<f64> {
        let mesh = &self.figure.asset.mesh;
        let character = self.figure.opened.character();
        let picture = Picture::decode(&character.images.get(image)?.bytes).ok()?;
        let texels = f64::from(picture.width()) * f64::from(picture.height());
        let mut found: Vec<(f64, f64)> = Vec::new();
        for part in &mesh.parts {
            let material = part.material.and_then(|m| character.materials.get(m));
            if material.and_then(|m| m.base_color_image) != Some(image) {
                continue;
            }
            for t in &mesh.triangles[part.triangles.clone()] {
                let [a, b, c] = t.map(|v| self.skinned.positions[v as usize]);
                let area = f64::from(0.5 * (b - a).cross(c - a).length());
                let [u, v, w] = t.map(|v| mesh.texcoords[v as usize]);
                let covered = f64::from(0.5 * (v - u).perp_dot(w - u).abs()) * texels;
                let side = (area / covered).sqrt();
                if side.is_finite() && area > 0.0 {
                    found.push((side, area));
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = 0.5 * found.iter().map(|f| f.1).sum::<f64>();
        let mut sum = 0.0;
        let middle = found.iter().find(|(_, area)| {
            sum += area;
            sum >= half
        });
        middle.map(|(side, _)| *side)
    }
}
