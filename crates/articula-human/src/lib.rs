//! The reference human: a procedural mannequin on the 89 joints of H-Anim.
//!
//! A substitute wherever no character is available: 89 joints with names, levels and regions, four
//! meshes with 2,000 to 70,000 triangles in all, and the clips `idle`, `walk` and `wave`.
//!
//! ```
//! use articula_human::{HumanOptions, human};
//!
//! let character = human(&HumanOptions { triangles: 2_000 })?;
//! assert_eq!(character.skeleton.joints.len(), 89);
//! assert_eq!(character.clips.len(), 3);
//! # Ok::<(), articula_human::HumanError>(())
//! ```
//!
//! The body is one signed distance field. It is polygonised finely, simplified to the requested
//! triangle count, skinned by position and animated by formulas: options → field → surfaces →
//! weights → character. The same options give the same bytes.
//!
//! Not included: textures, an animated face, and files. Simplification is that of `articula-build`.

mod body;
mod field;
mod foot;
mod gait;
mod gestures;
mod hand;
mod head;
mod leg;
mod motion;
mod pieces;
mod polygonise;
mod skeleton;
mod suit;
mod thin;
mod weights;

use articula_core::source::{Character, Material, Primitive, RawMesh, Skin};
use body::Body;
use glam::{Affine3A, Vec3, Vec4};
use pieces::Pieces;
use polygonise::Surface;
use std::ops::RangeInclusive;
use weights::{INFLUENCES, Weigher};

/// Supported triangle counts of [`human`].
pub const TRIANGLES: RangeInclusive<usize> = 2_000..=70_000;

/// Options of [`human`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HumanOptions {
    /// Number of triangles of all meshes together, within [`TRIANGLES`]; met to 5 %.
    pub triangles: usize,
}

impl Default for HumanOptions {
    fn default() -> Self {
        Self { triangles: 12_000 }
    }
}

/// Error of [`human`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HumanError {
    /// The triangle count is outside of [`TRIANGLES`].
    #[error("{found} triangles were requested; choose {} to {} triangles", TRIANGLES.start(), TRIANGLES.end())]
    Triangles {
        /// The requested count.
        found: usize,
    },
}

/// Creates the reference human: skin, lips, brows and eyes, with the looping clips `idle`, `walk`
/// and `wave`.
///
/// It is 1.75 m tall, stands on y = 0, faces +Z and has its left side at +X, with the arms hanging;
/// all rest rotations are the identity. The meshes are symmetric about x = 0.
///
/// # Errors
/// [`HumanError::Triangles`] if the count is outside of [`TRIANGLES`].
pub fn human(options: &HumanOptions) -> Result<Character, HumanError> {
    if !TRIANGLES.contains(&options.triangles) {
        return Err(HumanError::Triangles {
            found: options.triangles,
        });
    }
    let body = Body::new();
    let pieces = Pieces::new(&body, options.triangles);
    Ok(Character {
        name: "Reference human".to_owned(),
        skeleton: skeleton::skeleton(),
        articulation: Some(skeleton::articulation()),
        meshes: meshes(&body, &pieces),
        clips: vec![gestures::idle(), gait::walk(), gestures::wave()],
        materials: materials(),
        ..Character::default()
    })
}

/// Names and linear colours of the materials; primitives refer to them by index.
const MATERIALS: [(&str, [f32; 3]); 7] = [
    ("skin", [0.74, 0.62, 0.47]),
    ("lips", [0.6, 0.43, 0.32]),
    ("brows", [0.3, 0.2, 0.12]),
    ("sclera", [0.82, 0.79, 0.74]),
    ("iris", [0.13, 0.1, 0.07]),
    ("pupil", [0.01, 0.01, 0.01]),
    ("suit", [0.4, 0.34, 0.29]),
];

fn materials() -> Vec<Material> {
    let material = |(name, color): &(&str, [f32; 3])| Material {
        name: (*name).to_owned(),
        base_color: Vec4::from((Vec3::from(*color), 1.0)),
        ..Material::default()
    };
    MATERIALS.iter().map(material).collect()
}

fn meshes(body: &Body, pieces: &Pieces) -> Vec<RawMesh> {
    let skull = skeleton::joint("skullbase") as u16;
    let eyes = [
        skeleton::joint("l_eyeball_joint"),
        skeleton::joint("r_eyeball_joint"),
    ];
    let eye = |p: Vec3| eyes[usize::from(p.x < 0.0)] as u16;
    let eye_normal = |p: Vec3| {
        let center = Vec3::new(
            skeleton::EYE.x.copysign(p.x),
            skeleton::EYE.y,
            skeleton::EYE.z,
        );
        (p - center).normalize()
    };
    let iris = |i: usize| rigid(&pieces.eyes[i], 3 + i, eye_normal, eye);
    let brow = head::brow(&body.head);
    let lips = head::lips(&body.head);
    vec![
        mesh(
            "skin",
            two_tones(&skin(body, &pieces.skin), &pieces.skin.tones),
        ),
        mesh(
            "lips",
            vec![rigid(&pieces.lips, 1, |p| lips.normal(p), |_| skull)],
        ),
        mesh(
            "brows",
            vec![rigid(&pieces.brows, 2, |p| brow.normal(p), |_| skull)],
        ),
        mesh("eyes", (0..3).map(iris).collect()),
    ]
}

/// A mesh in model space, bound to all joints.
fn mesh(name: &str, primitives: Vec<Primitive>) -> RawMesh {
    let centers = skeleton::centers();
    RawMesh {
        name: name.to_owned(),
        skin: Skin {
            joints: (0..centers.len()).collect(),
            inverse_bind: centers
                .iter()
                .map(|c| Affine3A::from_translation(-*c))
                .collect(),
        },
        primitives,
        ..RawMesh::default()
    }
}

fn skin(body: &Body, surface: &Surface) -> Primitive {
    let weigher = Weigher::new(body);
    let influences: Vec<_> = surface.positions.iter().map(|p| weigher.at(*p)).collect();
    Primitive {
        positions: surface.positions.clone(),
        normals: normals(surface, |p| body.normal(p)),
        influences: INFLUENCES,
        joints: influences.iter().flatten().map(|(j, _)| *j).collect(),
        weights: influences.iter().flatten().map(|(_, w)| *w).collect(),
        triangles: surface.triangles.clone(),
        material: Some(0),
        ..Primitive::default()
    }
}

/// The skin in two primitives with the same vertices along their border: bare, then suit.
fn two_tones(skin: &Primitive, tones: &[bool]) -> Vec<Primitive> {
    let of = |tone: bool| -> Vec<[u32; 3]> {
        let pairs = skin.triangles.iter().zip(tones);
        pairs
            .filter(|(_, t)| **t == tone)
            .map(|(t, _)| *t)
            .collect()
    };
    vec![part(skin, &of(false), 0), part(skin, &of(true), 6)]
}

/// A primitive of some triangles of another, with the vertices that they use.
fn part(whole: &Primitive, triangles: &[[u32; 3]], material: usize) -> Primitive {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut place = vec![0; whole.positions.len()];
    for (i, v) in used.iter().enumerate() {
        place[*v as usize] = i as u32;
    }
    let per_vertex = |v: &u32| *v as usize * INFLUENCES..(*v as usize + 1) * INFLUENCES;
    Primitive {
        positions: used.iter().map(|v| whole.positions[*v as usize]).collect(),
        normals: used.iter().map(|v| whole.normals[*v as usize]).collect(),
        influences: INFLUENCES,
        joints: used
            .iter()
            .flat_map(|v| &whole.joints[per_vertex(v)])
            .copied()
            .collect(),
        weights: used
            .iter()
            .flat_map(|v| &whole.weights[per_vertex(v)])
            .copied()
            .collect(),
        triangles: triangles
            .iter()
            .map(|t| t.map(|v| place[v as usize]))
            .collect(),
        material: Some(material),
        ..Primitive::default()
    }
}

/// Mean of the field's gradient and the triangles' own normals: where a coarse surface cuts across
/// a fold of the field, the gradient alone would shade it dark.
fn normals(surface: &Surface, field: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    let positions = &surface.positions;
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for t in &surface.triangles {
        let corner = |i: usize| positions[t[i % 3] as usize];
        for i in 0..3 {
            let (a, b) = (corner(i + 1) - corner(i), corner(i + 2) - corner(i));
            sums[t[i] as usize] += a.cross(b).normalize_or_zero() * a.angle_between(b);
        }
    }
    let blended = positions.iter().zip(sums).map(|(p, sum)| {
        let smooth = field(*p);
        let mirrored = Vec3::new(if p.x == 0.0 { 0.0 } else { 1.0 }, 1.0, 1.0);
        let normal = (smooth + sum.normalize_or_zero()) * mirrored;
        normal.try_normalize().unwrap_or(smooth)
    });
    blended.collect()
}

/// A surface bound rigidly to one joint per vertex.
fn rigid(
    surface: &Surface,
    material: usize,
    normal: impl Fn(Vec3) -> Vec3,
    joint: impl Fn(Vec3) -> u16,
) -> Primitive {
    let positions = surface.positions.clone();
    Primitive {
        normals: normals(surface, normal),
        influences: 1,
        joints: positions.iter().map(|p| joint(*p)).collect(),
        weights: vec![1.0; positions.len()],
        triangles: surface.triangles.clone(),
        material: Some(material),
        positions,
        ..Primitive::default()
    }
}
