//! What the user wants of mesh levels.

use anyhow::Context;
use articula_build::MeshLevelOptions;
use articula_build::{SimplifyOptions, Weighting, region_weights};
use articula_core::{Mesh, Part, Region, Rig, Zone};
use clap::{Args, ValueEnum};
use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::{fault, files};

/// Shares of the triangles of five levels, percent; other numbers of levels run along them.
const FIVE_LEVELS: [f64; 5] = [100.0, 50.0, 25.0, 10.0, 1.5];
/// How much heavier errors are near joints in the thesis' weighting.
const JOINT_STRENGTH: f32 = 4.0;

/// Most levels, as `--levels` has it.
const MOST_LEVELS: usize = 16;
/// Most bytes of a list of locked vertices.
const LOCK_BYTES: u64 = 1 << 26;

const HEADING: &str = "Mesh levels";

/// Which mesh levels are made, and how they are written.
#[derive(Debug, Clone, Args)]
pub(crate) struct MeshLevelArgs {
    /// Make so many mesh levels, from all triangles to 1.5 % of them
    #[arg(long, value_name = "N", help_heading = HEADING, value_parser = clap::value_parser!(u16).range(1..=16))]
    levels: Option<u16>,
    /// Triangles of each level in percent, finest first
    #[arg(long, value_name = "100,50,…", help_heading = HEADING, value_delimiter = ',', value_parser = percent)]
    targets: Vec<f64>,
    /// How much errors of a body region count, such as face=8,hands=4
    #[arg(long, value_name = "REGION=X,…", help_heading = HEADING, value_delimiter = ',', value_parser = region_factor)]
    region_weight: Vec<(String, f32)>,
    /// Zones that may be shown at a level of their own, such as upper; the rest is one more
    #[arg(long, value_name = "ZONE,…", help_heading = HEADING, value_delimiter = ',', value_parser = zone)]
    split: Vec<(String, Zone)>,
    /// Which errors count: of all poses (without it), of the rest pose, or at rest and more near joints
    #[arg(long, value_enum, help_heading = HEADING)]
    weighting: Option<Counted>,
    /// Vertices that no level removes: a JSON file {"mesh name": [vertex, …], …}
    #[arg(long, value_name = "FILE.json", help_heading = HEADING)]
    lock: Option<PathBuf>,
    /// Write the coarser levels as MSFT_lod nodes too, for engines that know those
    #[arg(long, help_heading = HEADING)]
    pub(super) msft_lod: bool,
    /// Write the levels as a stream of chunks beside the asset
    #[arg(long, value_name = "FILE.ams", help_heading = HEADING)]
    pub(crate) mesh_stream: Option<PathBuf>,
}

/// Which errors count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Counted {
    /// Those of poses of the character's own clips, summed.
    Poses,
    /// Those at rest.
    Rest,
    /// Those at rest, more near joints (the thesis' weighting).
    Joint,
}

impl MeshLevelArgs {
    /// Five levels, and nothing else asked for.
    pub(crate) fn five() -> Self {
        Self {
            levels: Some(FIVE_LEVELS.len() as u16),
            targets: Vec::new(),
            region_weight: Vec::new(),
            split: Vec::new(),
            weighting: None,
            lock: None,
            msft_lod: false,
            mesh_stream: None,
        }
    }

    /// Whether any level is wanted; options without a level are wrong usage.
    pub(crate) fn wanted(&self) -> anyhow::Result<Option<Vec<f64>>> {
        let has_twice = |i: usize| self.split[..i].iter().any(|z| z.1 == self.split[i].1);
        if let Some(i) = (0..self.split.len()).find(|i| has_twice(*i)) {
            let what = format!("--split: {} stands twice", self.split[i].0);
            return Err(fault::usage(what));
        }
        let targets = match (self.levels, self.targets.as_slice()) {
            (None, []) => {
                let alone = [
                    (!self.region_weight.is_empty(), "--region-weight"),
                    (!self.split.is_empty(), "--split"),
                    (self.weighting.is_some(), "--weighting"),
                    (self.lock.is_some(), "--lock"),
                    (self.msft_lod, "--msft-lod"),
                    (self.mesh_stream.is_some(), "--mesh-stream"),
                ];
                if let Some((_, flag)) = alone.iter().find(|(is_set, _)| *is_set) {
                    let what = format!("{flag} needs mesh levels; add --levels 5");
                    return Err(fault::usage(what));
                }
                return Ok(None);
            }
            (Some(levels), []) => default_targets(usize::from(levels)),
            (levels, given) => {
                if let Some(levels) = levels.filter(|l| usize::from(*l) != given.len()) {
                    let what = format!("--levels {levels} with {} --targets", given.len());
                    return Err(fault::usage(what));
                }
                if given.len() > MOST_LEVELS {
                    let what = format!("--targets: {} levels, at most {MOST_LEVELS}", given.len());
                    return Err(fault::usage(what));
                }
                let falls = given.windows(2).all(|w| w[0] > w[1]);
                if given[0] != 100.0 || !falls {
                    let what = "--targets: percentages that fall from 100 are needed";
                    return Err(fault::usage(what));
                }
                given.to_vec()
            }
        };
        Ok(Some(targets.iter().map(|p| p / 100.0).collect()))
    }

    /// The options of these levels for a character. `classes` tells vertices apart that look alike
    /// in all that a [`Mesh`] holds.
    pub(crate) fn options(
        &self,
        targets: Vec<f64>,
        (mesh, rig): (&Mesh, &Rig),
        classes: Vec<u32>,
    ) -> anyhow::Result<MeshLevelOptions> {
        let factors = self.region_weight.iter().map(|(r, x)| (r.as_str(), *x));
        let factors: Vec<(&str, f32)> = factors.collect();
        let vertex_weights = match factors.is_empty() {
            true => Vec::new(),
            false => region_weights(mesh, rig, &factors).context("--region-weight")?,
        };
        let simplify = SimplifyOptions {
            targets,
            weighting: match self.weighting {
                None | Some(Counted::Poses) => Weighting::PoseSummed,
                Some(Counted::Rest) => Weighting::Rest,
                Some(Counted::Joint) => Weighting::Joint {
                    strength: JOINT_STRENGTH,
                },
            },
            vertex_weights,
            locked: self.locked(mesh)?,
            regions: self.regions(mesh, rig),
            wedges: classes,
            ..SimplifyOptions::default()
        };
        Ok(MeshLevelOptions {
            simplify,
            ..MeshLevelOptions::default()
        })
    }

    /// Which zone each vertex belongs to: the first that has its heaviest joint.
    fn regions(&self, mesh: &Mesh, rig: &Rig) -> Vec<u8> {
        if self.split.is_empty() {
            return Vec::new();
        }
        let joints = &rig.articulation().joints;
        let zone_of = |joint: usize| {
            let region = joints.get(joint).map(|j| j.region);
            let has = |(_, zone): &(String, Zone)| region.is_some_and(|r| zone.contains(r));
            self.split.iter().position(has).unwrap_or(self.split.len()) as u8
        };
        let heaviest = |v| {
            let all = mesh.influences_of(v);
            all.reduce(|a, b| if b.1 > a.1 { b } else { a })
        };
        let region = |v| heaviest(v).map_or(self.split.len() as u8, |(joint, _)| zone_of(joint));
        (0..mesh.len()).map(region).collect()
    }

    /// Names of the zones that may have levels of their own.
    pub(super) fn region_names(&self) -> Vec<String> {
        if self.split.is_empty() {
            return Vec::new();
        }
        let names = self.split.iter().map(|(name, _)| name.clone());
        names.chain(["rest".to_owned()]).collect()
    }

    fn locked(&self, mesh: &Mesh) -> anyhow::Result<Vec<u32>> {
        let Some(path) = &self.lock else {
            return Ok(Vec::new());
        };
        let bytes = files::read(path, LOCK_BYTES)?;
        let form = "{\"mesh name\": [vertex, …], …}";
        let lists: BTreeMap<String, Vec<u32>> = serde_json::from_slice(&bytes)
            .with_context(|| format!("{}: the form is {form}", files::shown(path)))?;
        let mut locked = Vec::new();
        for (name, vertices) in lists {
            let parts: Vec<&Part> = mesh.parts.iter().filter(|p| p.name == name).collect();
            let Some(first) = parts.first() else {
                let mut names: Vec<&str> = mesh.parts.iter().map(|p| p.name.as_str()).collect();
                names.dedup();
                let what = format!("no mesh \"{name}\"; there are {}", names.join(", "));
                anyhow::bail!("{}: {what}", files::shown(path));
            };
            if parts.iter().any(|p| p.mesh != first.mesh) {
                let what = format!("several meshes are called \"{name}\"; give them other names");
                anyhow::bail!("{}: {what}", files::shown(path));
            }
            // Parts of one mesh follow each other: its vertices are numbered through them.
            let of_mesh: Vec<u32> = parts
                .iter()
                .flat_map(|p| p.vertices.clone())
                .map(|v| v as u32)
                .collect();
            for v in vertices {
                let Some(vertex) = of_mesh.get(v as usize) else {
                    let what = format!("{name}: vertex {v} of {}", of_mesh.len());
                    anyhow::bail!("{}: {what}", files::shown(path));
                };
                locked.push(*vertex);
            }
        }
        Ok(locked)
    }
}

/// Percentages of `levels` levels: those of five, or what lies between them.
fn default_targets(levels: usize) -> Vec<f64> {
    let last = FIVE_LEVELS.len() - 1;
    let at = |i: usize| {
        let x = (i * last) as f64 / (levels.max(2) - 1) as f64;
        let below = (x as usize).min(last - 1);
        let (a, b) = (FIVE_LEVELS[below], FIVE_LEVELS[below + 1]);
        let between = a * (b / a).powf(x - below as f64);
        (between * 100.0).round() / 100.0
    };
    (0..levels).map(at).collect()
}

fn percent(text: &str) -> Result<f64, String> {
    match text.trim().trim_end_matches('%').parse::<f64>() {
        Ok(p) if p > 0.0 && p <= 100.0 => Ok(p),
        _ => Err("a percentage above 0, at most 100".into()),
    }
}

fn region_factor(text: &str) -> Result<(String, f32), String> {
    let known = || Region::ALL.map(Region::name).join(", ");
    let (name, factor) = text.split_once('=').ok_or("the form is face=8")?;
    let region = Region::from_name(name).ok_or_else(|| format!("regions are {}", known()))?;
    match factor.parse::<f32>() {
        Ok(x) if x > 0.0 && x <= 1e6 => Ok((region.name().to_owned(), x)),
        _ => Err("a factor above 0, at most 1000000".into()),
    }
}

fn zone(text: &str) -> Result<(String, Zone), String> {
    let named = Zone::from_name(text).map(|zone| (text.to_owned(), zone));
    named.ok_or_else(|| {
        let regions = Region::ALL.map(Region::name).join(", ");
        format!("zones are upper, lower, face-shoulders and the regions {regions}")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_numbers_of_levels_run_along_the_five() {
        assert_eq!(default_targets(5), FIVE_LEVELS);
        assert_eq!(default_targets(1), [100.0]);
        assert_eq!(default_targets(2), [100.0, 1.5]);
        // Half way along: index 1 of 4 at three levels is 2 of 4.
        assert_eq!(default_targets(3), [100.0, 25.0, 1.5]);
        let nine = default_targets(9);
        // Between 100 and 50: their geometric mean.
        assert_eq!(nine[1], 70.71);
        assert!(nine.windows(2).all(|w| w[0] > w[1]));
    }
}
