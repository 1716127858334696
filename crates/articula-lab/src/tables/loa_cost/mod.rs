//! Cost of levels of articulation in bytes and time: zones, depths and levels of complexity, over the
//! frames of a clip and by the number of figures.
//!
//! Source: thesis 6.3.1, its cost formulas, and figures 6.14 and 6.15. One module measures, one
//! writes the page. All times are processor time of one thread.

mod measure;
mod page;

use super::Run;
use crate::measure::median;
use anyhow::{Context, Result};
use articula::Figure;
use articula_build::{clip_size, hold_joints_in_clip};
use articula_core::joint_state::PassivePolicy;
use articula_core::{Clip, Complexity, JointSet, Region, Rig, Zone, loa};
use measure::{Counts, Stage, StageNs};

/// A character and one of its clips.
#[derive(Clone, Copy)]
struct Subject {
    name: &'static str,
    file: &'static str,
    clip: &'static str,
}

/// The subjects; the first is that of a small run, of the plots over the frames and of the crowd. A
/// long dance is the motion of the thesis.
const SUBJECTS: [Subject; 3] = [
    Subject {
        name: "pab",
        file: "glb/pab_arnaud.glb",
        clip: "atlas",
    },
    Subject {
        name: "dancer",
        file: "glb/mh_female_dance.glb",
        clip: "dance",
    },
    Subject {
        name: "KayKit Knight",
        file: "glb/KayKit_Knight.glb",
        clip: "Walking_A",
    },
];

/// The clip of the first subject in a small run.
const SMALL_CLIP: &str = "walk";

/// Numbers of figures shown at the same time.
const FIGURES: [usize; 6] = [1, 2, 5, 10, 20, 50];

/// Repetitions, of which the median counts.
const ROUNDS: usize = 9;

/// The ways to select joints, in the order of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Selector {
    Complexity,
    Zone,
    Depth,
}

impl Selector {
    const ALL: [Self; 3] = [Self::Complexity, Self::Zone, Self::Depth];

    fn name(self) -> &'static str {
        match self {
            Self::Complexity => "complexity",
            Self::Zone => "zone",
            Self::Depth => "depth",
        }
    }

    /// Names and joints of its levels. The first selects nothing.
    fn levels(self, rig: &Rig) -> Vec<(String, JointSet)> {
        match self {
            Self::Complexity => Complexity::ALL
                .map(|c| (c.to_string(), loa::complexity(rig, c)))
                .to_vec(),
            Self::Zone => {
                let regions = Region::ALL.map(|r| (r.to_string(), Zone::from(r)));
                let composites = [
                    ("upper", Zone::UPPER),
                    ("lower", Zone::LOWER),
                    ("all", Zone::ALL),
                ];
                let composites = composites.map(|(name, zone)| (name.to_owned(), zone));
                let zones = regions.into_iter().chain(composites);
                let zones = zones.map(|(name, zone)| (name, loa::zone(rig, zone)));
                std::iter::once(("none".to_owned(), JointSet::EMPTY))
                    .chain(zones)
                    .collect()
            }
            Self::Depth => {
                let deepest = rig.skin_joints().iter().map(|j| rig.depth(j)).max();
                let depths = 0..=deepest.unwrap_or(0) as u32 + 1;
                depths
                    .map(|k| (k.to_string(), loa::depth(rig, k)))
                    .collect()
            }
        }
    }
}

/// What one level costs.
struct Level {
    selector: Selector,
    name: String,
    /// Joints of the level that belong to the skin.
    joints: usize,
    /// Bytes of the animation in which only the level's joints move.
    bytes: usize,
    counts: Counts,
    /// Median times of each frame after the first.
    frames: Vec<StageNs>,
}

impl Level {
    /// Mean time of a frame.
    fn ns(&self) -> StageNs {
        StageNs::mean(&self.frames)
    }
}

/// Everything about one subject.
struct Found {
    subject: Subject,
    joints: usize,
    vertices: usize,
    frames: usize,
    rate_hz: f32,
    levels: Vec<Level>,
}

impl Found {
    fn of(&self, selector: Selector) -> impl Iterator<Item = &Level> {
        self.levels.iter().filter(move |l| l.selector == selector)
    }
}

/// Times of a level with a number of figures.
struct Figures {
    level: String,
    /// Median time of a frame of all figures, by the index of [`FIGURES`].
    frame_ns: Vec<StageNs>,
}

/// Mean over the levels of a selector of what a joint adds in each frame, with the least and the
/// greatest: the cost formulas of the thesis, in which the run without joints is subtracted.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PerJoint {
    mean: f64,
    least: f64,
    most: f64,
    /// Slope of the straight line through the levels with joints, by least squares: what a further
    /// joint adds once others move. Not a number if all have as many joints.
    slope: f64,
}

impl PerJoint {
    /// From the cost of a frame and the number of joints of each level; levels without joints give
    /// the cost that is subtracted. `None` without any other level.
    fn fit(levels: &[(usize, f64)]) -> Option<Self> {
        let idle = levels.iter().find(|l| l.0 == 0).map_or(0.0, |l| l.1);
        let points: Vec<(f64, f64)> = levels
            .iter()
            .filter(|l| l.0 > 0)
            .map(|(joints, cost)| (*joints as f64, cost - idle))
            .collect();
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| {
            points.iter().map(of).sum::<f64>() / points.len() as f64
        };
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        let spread = mean(&|p| (p.0 - x) * (p.0 - x));
        let each = || points.iter().map(|(joints, cost)| cost / joints);
        (!points.is_empty()).then(|| Self {
            mean: mean(&|p| p.1 / p.0),
            least: each().fold(f64::INFINITY, f64::min),
            most: each().fold(f64::NEG_INFINITY, f64::max),
            slope: mean(&|p| (p.0 - x) * (p.1 - y)) / spread,
        })
    }
}

/// Runs the table and writes it.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut subjects = SUBJECTS.to_vec();
    let mut rounds = ROUNDS;
    if run.small {
        subjects.truncate(1);
        subjects[0].clip = SMALL_CLIP;
        rounds = 1;
    }
    let mut all = Vec::new();
    let mut crowd = Vec::new();
    for subject in subjects {
        let figure = Figure::new(articula::fs::open(run.data.join(subject.file))?)?;
        let clips = &figure.asset.clips;
        let at = clips.iter().position(|c| c.name == subject.clip);
        let at = at.with_context(|| format!("{}: no clip {}", subject.file, subject.clip))?;
        let clip = clips[at].at_key_rate();
        all.push(found(subject, &figure, (at, &clip), rounds));
        if crowd.is_empty() {
            crowd = figures(&figure, &clip, run.small, rounds);
        }
    }
    run.save("loa-cost", &page::page(&all, &crowd)?, &page::csv(&all)?)?;
    run.save_csv("loa-cost-frames", &page::frames_csv(&all)?)?;
    run.save_csv("loa-cost-figures", &page::figures_csv(&crowd)?)?;
    for (name, svg) in page::plots(&all, &crowd) {
        run.save_text(name, "svg", &svg)?;
    }
    Ok(())
}

/// Measures every level of one subject. The levels take turns in each round.
fn found(subject: Subject, figure: &Figure, (at, clip): (usize, &Clip), rounds: usize) -> Found {
    let (rig, mesh) = (&figure.asset.rig, &figure.asset.mesh);
    let source = &figure.opened.character().clips[at];
    let stage = Stage::new(&figure.asset, clip);
    let selected: Vec<(Selector, String, JointSet)> = Selector::ALL
        .into_iter()
        .flat_map(|s| s.levels(rig).into_iter().map(move |(n, set)| (s, n, set)))
        .collect();
    let mut passes = vec![Vec::new(); selected.len()];
    let mut counts = vec![Counts::default(); selected.len()];
    for _ in 0..rounds {
        for (l, (_, _, set)) in selected.iter().enumerate() {
            let (times, counted) = stage.pass(set, 1);
            passes[l].push(times);
            counts[l] = counted;
        }
    }
    let level = |((selector, name, set), (passes, counts)): (_, (Vec<Vec<StageNs>>, Counts))| {
        let held = hold_joints_in_clip(rig, source, &set, PassivePolicy::HoldLast);
        Level {
            selector,
            name,
            joints: set.intersection(rig.skin_joints()).len(),
            bytes: clip_size(&held).bytes,
            counts,
            frames: medians(&passes),
        }
    };
    let measured = passes.into_iter().zip(counts);
    Found {
        subject,
        joints: rig.skin_joints().len(),
        vertices: mesh.len(),
        frames: clip.frames(),
        rate_hz: clip.rate_hz(),
        levels: selected.into_iter().zip(measured).map(level).collect(),
    }
}

/// Measures the levels of complexity with several figures.
fn figures(figure: &Figure, clip: &Clip, is_small: bool, rounds: usize) -> Vec<Figures> {
    let stage = Stage::new(&figure.asset, clip);
    let counts = if is_small { &FIGURES[..2] } else { &FIGURES };
    let levels = Selector::Complexity.levels(&figure.asset.rig);
    let mut passes = vec![vec![Vec::new(); counts.len()]; levels.len()];
    for _ in 0..rounds {
        for ((_, set), passes) in levels.iter().zip(&mut passes) {
            for (count, passes) in counts.iter().zip(passes) {
                passes.push(stage.pass(set, *count).0);
            }
        }
    }
    let of = |((name, _), passes): ((String, _), Vec<Vec<Vec<StageNs>>>)| Figures {
        level: name,
        frame_ns: passes.iter().map(|p| StageNs::mean(&medians(p))).collect(),
    };
    levels.into_iter().zip(passes).map(of).collect()
}

/// The median over passes of each frame, for each stage.
fn medians(passes: &[Vec<StageNs>]) -> Vec<StageNs> {
    let frames = passes.first().map_or(0, Vec::len);
    let of = |frame: usize, stage: fn(&StageNs) -> f64| {
        let mut ns: Vec<f64> = passes.iter().map(|p| stage(&p[frame])).collect();
        median(&mut ns)
    };
    let frame = |f: usize| StageNs {
        transforms: of(f, |ns| ns.transforms),
        skinning: of(f, |ns| ns.skinning),
    };
    (0..frames).map(frame).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cost_per_joint_by_hand() {
        // 7 without joints; 2 and 4 for each joint of the others, and 30 for 5 joints more.
        let fit = PerJoint::fit(&[(0, 7.0), (5, 17.0), (10, 47.0)]).unwrap();
        assert_eq!((fit.mean, fit.least, fit.most), (3.0, 2.0, 4.0));
        assert!((fit.slope - 6.0).abs() < 1e-12);
        assert_eq!(PerJoint::fit(&[(0, 7.0)]), None);
    }

    #[test]
    fn medians_are_those_of_each_frame_and_stage() {
        let ns = |transforms, skinning| StageNs {
            transforms,
            skinning,
        };
        let passes = [
            vec![ns(1.0, 30.0), ns(5.0, 5.0)],
            vec![ns(2.0, 10.0), ns(6.0, 5.0)],
            vec![ns(9.0, 20.0), ns(4.0, 8.0)],
        ];
        assert_eq!(medians(&passes), [ns(2.0, 20.0), ns(5.0, 5.0)]);
        assert_eq!(StageNs::mean(&medians(&passes)), ns(3.5, 12.5));
    }
}
