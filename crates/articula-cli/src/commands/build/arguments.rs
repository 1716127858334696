//! The flags of `build` for mesh levels.

use anyhow::Context;
use articula::build::ErrorWeighting;
use articula::core::{Region, Zone};
use articula::{MeshLevelOptions, PreparedMeshLevels};
use clap::{Args, ValueEnum};
use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::arguments::region_factor;
use crate::{fault, files};

/// Factor by which the thesis' weighting increases errors near joints.
const JOINT_STRENGTH: f32 = 4.0;

/// Maximum number of levels, as for `--levels`.
const MAX_LEVELS: usize = 16;
/// Maximum size of a list of locked vertices in bytes.
const LOCK_BYTES: u64 = 1 << 26;

const HEADING: &str = "Mesh levels";

/// Mesh levels to make, and how to write them.
#[derive(Debug, Clone, Args)]
pub(crate) struct MeshLevelArgs {
    /// Maximum number of mesh levels, from all triangles down to 1.5 % of them; levels with an error
    /// in motion above 5 % of the size of the figure are left out; 1 for none [default: those of crowds,
    /// at most 12 down to 40 triangles, if the file has none]
    #[arg(long, value_name = "N", help_heading = HEADING, value_parser = clap::value_parser!(u16).range(1..=16))]
    levels: Option<u16>,
    /// Triangles of each level in percent, finest first; made whatever their errors are
    #[arg(long, value_name = "100,50,…", help_heading = HEADING, value_delimiter = ',', value_parser = percent)]
    targets: Vec<f64>,
    /// Factors by which errors in body regions count more, such as face=8,hands=4
    #[arg(long, value_name = "REGION=X,…", help_heading = HEADING, value_delimiter = ',', value_parser = region_factor)]
    region_weight: Vec<(String, f32)>,
    /// Zones that can be shown at separate levels, such as face,hands; the rest is one more zone
    #[arg(long, value_name = "ZONE,…", help_heading = HEADING, value_delimiter = ',', value_parser = zone)]
    split: Vec<(String, Zone)>,
    /// Errors to minimise [default: poses]
    #[arg(long, value_enum, help_heading = HEADING)]
    weighting: Option<Counted>,
    /// JSON file with vertices that no level removes: {"mesh name": [vertex, …], …}
    #[arg(long, value_name = "FILE.json", help_heading = HEADING)]
    pub(super) lock: Option<PathBuf>,
    /// Let levels remove feature points of the face, and count errors there as elsewhere
    #[arg(long, help_heading = HEADING)]
    free_face: bool,
    /// Also write the coarser levels as MSFT_lod nodes, for engines that support them
    #[arg(long, help_heading = HEADING)]
    msft_lod: bool,
    /// Also write the levels as a progressive stream to this file
    #[arg(long, value_name = "FILE.ams", help_heading = HEADING)]
    pub(super) mesh_stream: Option<PathBuf>,
}

/// Errors that simplification minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Counted {
    /// Sum over poses of the character's clips.
    Poses,
    /// In the rest pose.
    Rest,
    /// In the rest pose, more near joints (the thesis' weighting).
    Joint,
}

impl MeshLevelArgs {
    /// What is asked for; options of levels without any are a usage error.
    pub(super) fn wanted(&self) -> anyhow::Result<PreparedMeshLevels> {
        let has_twice = |i: usize| self.split[..i].iter().any(|z| z.1 == self.split[i].1);
        if let Some(i) = (0..self.split.len()).find(|i| has_twice(*i)) {
            let what = format!("--split: {} is given twice", self.split[i].0);
            return Err(fault::usage(what));
        }
        let targets = match (self.levels, self.targets.as_slice()) {
            (None | Some(1), []) => {
                let alone = [
                    (!self.region_weight.is_empty(), "--region-weight"),
                    (!self.split.is_empty(), "--split"),
                    (self.weighting.is_some(), "--weighting"),
                    (self.lock.is_some(), "--lock"),
                    (self.free_face, "--free-face"),
                    (self.msft_lod, "--msft-lod"),
                    (self.mesh_stream.is_some(), "--mesh-stream"),
                ];
                if let Some((_, flag)) = alone.iter().find(|(is_set, _)| *is_set) {
                    let what = format!("{flag} needs mesh levels; add --levels 5");
                    return Err(fault::usage(what));
                }
                return Ok(match self.levels {
                    None => PreparedMeshLevels::ForCrowds,
                    Some(_) => PreparedMeshLevels::OfFile,
                });
            }
            (Some(levels), []) => MeshLevelOptions::levels(usize::from(levels)).targets,
            (levels, given) => {
                if let Some(levels) = levels.filter(|l| usize::from(*l) != given.len()) {
                    let what = format!("--levels {levels} with {} --targets", given.len());
                    return Err(fault::usage(what));
                }
                if given.len() > MAX_LEVELS {
                    let what = format!("--targets: {} levels, at most {MAX_LEVELS}", given.len());
                    return Err(fault::usage(what));
                }
                let falls = given.windows(2).all(|w| w[0] > w[1]);
                if given[0] != 100.0 || !falls {
                    let what = "--targets: expected percentages that start at 100 and decrease";
                    return Err(fault::usage(what));
                }
                given.iter().map(|p| p / 100.0).collect()
            }
        };
        let base = MeshLevelOptions::levels(targets.len());
        Ok(PreparedMeshLevels::New(MeshLevelOptions {
            targets,
            // Levels that are named one by one are made whatever their errors are.
            max_error: base.max_error.filter(|_| self.targets.is_empty()),
            region_weights: self.region_weight.clone(),
            split: self.split.clone(),
            weighting: match self.weighting {
                None | Some(Counted::Poses) => ErrorWeighting::PoseSummed,
                Some(Counted::Rest) => ErrorWeighting::Rest,
                Some(Counted::Joint) => ErrorWeighting::Joint {
                    strength: JOINT_STRENGTH,
                },
            },
            locked: self.locked()?,
            keep_face: !self.free_face,
            msft_lod: self.msft_lod,
            ..base
        }))
    }

    fn locked(&self) -> anyhow::Result<BTreeMap<String, Vec<u32>>> {
        let Some(path) = &self.lock else {
            return Ok(BTreeMap::new());
        };
        let bytes = files::read(path, LOCK_BYTES)?;
        let form = "{\"mesh name\": [vertex, …], …}";
        serde_json::from_slice(&bytes)
            .with_context(|| format!("{}: the expected form is {form}", files::shown(path)))
    }
}

fn percent(text: &str) -> Result<f64, String> {
    match text.trim().trim_end_matches('%').parse::<f64>() {
        Ok(p) if p > 0.0 && p <= 100.0 => Ok(p),
        _ => Err("expected a percentage above 0 and at most 100".into()),
    }
}

fn zone(text: &str) -> Result<(String, Zone), String> {
    let named = text.parse().map(|zone| (text.to_owned(), zone));
    named.map_err(|_| {
        let regions = Region::ALL.map(|r| r.to_string()).join(", ");
        format!("expected upper, lower, face-shoulders or one of the regions {regions}")
    })
}
