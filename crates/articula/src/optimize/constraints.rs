//! What simplification may not touch, and how much errors count where.

use super::source::Source;
use super::{OptimizeOptions, Prepared};
use crate::error::{Context, Error, Result};
use articula_build::{SimplifyOptions, region_weights, vertex_regions};
use articula_core::source::Character;
use articula_core::{Articulation, Mesh, Region, Rig};

/// The constraints of a character's mesh.
pub(super) fn constraints(
    prepared: &Prepared,
    mesh: &Mesh,
    options: &OptimizeOptions,
) -> Result<SimplifyOptions> {
    let source = &prepared.source;
    let character = &source.character;
    let joints = character.skeleton.joints.len();
    let articulation = match prepared.articulation.joints.len() == joints {
        true => prepared.articulation.clone(),
        false => Articulation::unmapped(joints),
    };
    let rig = Rig::new(&character.skeleton, articulation)?;
    let factors = options.region_weights.iter();
    let factors: Vec<(&str, f32)> = factors.map(|(r, x)| (r.as_str(), *x)).collect();
    let (wedges, mut locked) = of_document(source, mesh)?;
    for name in &options.locked {
        locked.extend(named(name, character, mesh, &rig)?);
    }
    Ok(SimplifyOptions {
        wedges,
        locked,
        vertex_weights: match factors.is_empty() {
            true => Vec::new(),
            false => region_weights(mesh, &rig, &factors).context("region weights")?,
        },
        ..SimplifyOptions::default()
    })
}

/// For each vertex the first that is equal in all that the document has, and the vertices of parts whose
/// triangles cannot be replaced.
fn of_document(source: &Source, mesh: &Mesh) -> Result<(Vec<u32>, Vec<u32>)> {
    let document = &source.file.document;
    let (mut wedges, mut locked) = (Vec::with_capacity(mesh.len()), Vec::new());
    for (m, node) in source.file.node_of_mesh.iter().enumerate() {
        let is_replaceable = document.replaceable_parts(*node)?;
        let parts = mesh.parts.iter().filter(|part| part.mesh == m);
        for (p, part) in parts.enumerate() {
            let first = part.vertices.start as u32;
            let classes = document.vertex_classes(*node, p)?;
            wedges.extend(classes.into_iter().map(|class| first + class));
            if is_replaceable.get(p) != Some(&true) {
                locked.extend(part.vertices.clone().map(|v| v as u32));
            }
        }
    }
    Ok((wedges, locked))
}

/// The vertices of all that has a name: a region, material, mesh, morph target or joint.
fn named(name: &str, character: &Character, mesh: &Mesh, rig: &Rig) -> Result<Vec<u32>> {
    let mut is_named = vec![false; mesh.len()];
    let mut is_known = false;
    if let Ok(region) = name.parse::<Region>() {
        let regions = vertex_regions(mesh, rig);
        is_known |= regions.contains(&region);
        for (is_named, of_vertex) in is_named.iter_mut().zip(&regions) {
            *is_named |= *of_vertex == region;
        }
    }
    for part in &mesh.parts {
        let material = part.material.and_then(|m| character.materials.get(m));
        if part.name == name || material.is_some_and(|m| m.name == name) {
            is_known = true;
            is_named[part.vertices.clone()].fill(true);
        }
    }
    for (source, first) in character.meshes.iter().zip(&mesh.morph_slots) {
        let named = source.morph_names.iter().enumerate();
        for (target, _) in named.filter(|(_, morph)| *morph == name) {
            is_known = true;
            let slot = first + target;
            let morphs = mesh.morphs.iter();
            for morph in morphs.filter(|morph| usize::from(morph.slot) == slot) {
                morph
                    .vertices
                    .iter()
                    .for_each(|v| is_named[*v as usize] = true);
            }
        }
    }
    let joint = character
        .skeleton
        .joints
        .iter()
        .position(|j| j.name == name);
    if let Some(joint) = joint {
        is_known = true;
        for (v, is_named) in is_named.iter_mut().enumerate() {
            *is_named |= mesh.influences_of(v).any(|(of, _)| of == joint);
        }
    }
    if !is_known {
        return Err(unknown(name, character));
    }
    let all = (0..mesh.len() as u32).zip(is_named);
    Ok(all.filter(|(_, named)| *named).map(|(v, _)| v).collect())
}

fn unknown(name: &str, character: &Character) -> Error {
    let listed = |names: Vec<&str>| match names.is_empty() {
        true => "none".to_owned(),
        false => names.join(", "),
    };
    let materials = character.materials.iter().map(|m| m.name.as_str());
    let meshes = character.meshes.iter().map(|m| m.name.as_str());
    let what = format!(
        "lock: nothing shown is called \"{name}\"; regions: {}; materials: {}; meshes: {}; else a morph target or a joint",
        Region::ALL.map(|r| r.to_string()).join(", "),
        listed(materials.filter(|n| !n.is_empty()).collect()),
        listed(meshes.filter(|n| !n.is_empty()).collect()),
    );
    Error::argument(what)
}
