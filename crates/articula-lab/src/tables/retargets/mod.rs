//! Quality of retargeted motions of every kind of file on every kind of character, in numbers and
//! pictures.

mod cases;
mod measure;
mod sheet;
mod variants;

use super::Run;
use super::targets::{self, Target};
use anyhow::{Context, Result};
use articula::CharacterFile;
use articula_build::retarget::{RetargetQuality, RetargetReport, RotationOrigin};
use articula_report::ContactSheet;
use cases::{CASES, Case};
use measure::Played;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Result of one case.
struct Row {
    case: Case,
    source: CharacterFile,
    target: CharacterFile,
    /// The motion before and after retargeting.
    before: Played,
    after: Played,
    /// Size of the target over that of the source.
    scale: f32,
    /// `None` where joints were matched by their names.
    report: Option<RetargetReport>,
    /// Number of joints that follow, share and keep their rest pose, and of those left out.
    joints: [usize; 4],
    seen: VisibleQuality,
}

/// Quality measured from the poses alone.
struct VisibleQuality {
    contacts: usize,
    /// Slide of the resting toes in millimetres, of the source scaled to the target's size and of
    /// the target.
    slide_source_mm: Option<f32>,
    slide_mm: Option<f32>,
    /// Maximum angular speeds, degrees per second.
    fastest_source: (String, f32),
    fastest: (String, f32),
    knees_wrong_share: f32,
}

impl Row {
    fn new(data: &Path, case: Case) -> Result<Self> {
        let source = cases::source(data, &case)?;
        let target = cases::target(data, &case)?;
        let (source, target) = case.variant.apply(source, target);
        let clip = source.character().clips.first().context("no clip")?;
        let made = cases::retargeted(&source, &target)?;
        let report = made.fit.retargeted;
        let (scale, joints) = match (&report, &made.fit.by_name) {
            (Some(report), _) => (report.scale, counts(report)),
            (None, Some(found)) => {
                let held = found.sources.len() - found.followed;
                (found.scale, [found.followed, 0, held, found.dropped.len()])
            }
            (None, None) => anyhow::bail!("not retargeted"),
        };
        let before = Played::of(&source, clip)?;
        let after = Played::new(&target, &made.clip, before.rate_hz)?;
        let contacts = before.contacts(&after);
        let seen = VisibleQuality {
            contacts: contacts.len(),
            slide_source_mm: before.slide_mm(&contacts).map(|mm| scale * mm),
            slide_mm: after.slide_mm(&contacts),
            fastest_source: before.fastest(),
            fastest: after.fastest(),
            knees_wrong_share: after.knees_wrong_share(),
        };
        Ok(Self {
            case,
            source,
            target,
            before,
            after,
            scale,
            report,
            joints,
            seen,
        })
    }

    /// Quality by the report; zeros where joints were matched by their names.
    fn quality(&self) -> RetargetQuality {
        let report = self.report.as_ref();
        report.map_or_else(RetargetQuality::default, |report| report.quality)
    }
}

fn counts(report: &RetargetReport) -> [usize; 4] {
    let count = |wanted: fn(&RotationOrigin) -> bool| {
        report.joints.iter().filter(|j| wanted(&j.origin)).count()
    };
    [
        count(|o| matches!(o, RotationOrigin::Mapped { .. })),
        count(|o| matches!(o, RotationOrigin::Shared { .. })),
        count(|o| *o == RotationOrigin::Held),
        report.dropped.len(),
    ]
}

fn rows(run: &Run) -> Result<Vec<Row>> {
    let cases: Vec<Case> = CASES
        .into_iter()
        .filter(|c| !run.small || (c.small && c.is_in(&run.data)))
        .collect();
    let row = |case: &Case| {
        let place = || format!("{} onto {}", case.motion, case.onto);
        Row::new(&run.data, *case).with_context(place)
    };
    cases.par_iter().map(row).collect()
}

/// Pictures to draw.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Pictures {
    /// Folder for a sheet of each case.
    #[arg(long)]
    sheets: Option<PathBuf>,
    /// File for the picture of the page.
    #[arg(long)]
    picture: Option<PathBuf>,
}

/// Runs the table and writes it, and the pictures that are asked for.
pub(crate) fn write(run: &Run, pictures: &Pictures) -> Result<()> {
    let rows = rows(run)?;
    run.save("retargets", &page(&rows)?, &csv(&rows)?)?;
    if let Some(folder) = &pictures.sheets {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        for (i, row) in rows.iter().enumerate() {
            let name = format!("{:02} {} onto {}", i + 1, row.case.motion, row.case.onto);
            let name = name.replace(' ', "-").to_lowercase() + ".png";
            draw(&[row], &folder.join(name))?;
        }
    }
    if let Some(path) = &pictures.picture {
        let shown: Vec<&Row> = rows.iter().filter(|r| r.case.shown).collect();
        draw(&shown, path)?;
    }
    Ok(())
}

fn draw(rows: &[&Row], path: &Path) -> Result<()> {
    let png = sheet_of(rows)?.draw()?.to_png()?;
    std::fs::write(path, png).with_context(|| path.display().to_string())?;
    println!("{}", path.display());
    Ok(())
}

/// Sheet of each motion above its result.
fn sheet_of(rows: &[&Row]) -> Result<ContactSheet> {
    let mut lines = Vec::new();
    for row in rows {
        let moments =
            articula_report::evenly_spaced_frames(row.before.models.len(), sheet::MOMENTS);
        for (label, actor, played) in [
            (row.case.motion, &row.source, &row.before),
            (row.case.onto, &row.target, &row.after),
        ] {
            let artist = sheet::Artist::new(actor, played, &moments)?;
            lines.push(artist.row(label.to_owned(), &moments)?);
        }
    }
    Ok(ContactSheet {
        title: "Motions and their retargeted results".into(),
        rows: lines,
        ..ContactSheet::default()
    })
}

/// Mean slide of planted feet, millimetres.
const SLIDE_MM: f64 = 20.0;
/// Depth of a sole below the floor, millimetres.
const BELOW_FLOOR_MM: f64 = 5.0;
/// Percent of frames in which a hinge bends in the wrong direction.
const WRONG_HINGES_PERCENT: f64 = 0.5;
/// Maximum angular speed in the result: times that of the source, plus degrees per second. Pinning a
/// foot may speed up a knee by up to 5 rad/s; a flip of half a turn within a frame is 1,800 degrees
/// per second at the 10 Hz of the slowest motion here.
const SPEED: (f64, f64) = (1.3, 5.0 * 180.0 / std::f64::consts::PI);

/// A quantity with its limit and its value in a row.
type Quantity<'a> = (&'a str, f64, &'a dyn Fn(&Row) -> Option<f64>);

/// Every limit, with the row that is farthest from it in the right direction or beyond it.
fn bounds(rows: &[Row]) -> Vec<Target> {
    let of = |row: &Row| row.quality();
    let speed = |row: &Row| {
        let (after, before) = (row.seen.fastest.1, row.seen.fastest_source.1);
        f64::from(after) / (SPEED.0 * f64::from(before) + SPEED.1)
    };
    let percent = |share: f32| Some(100.0 * f64::from(share));
    let quantities: [Quantity<'_>; 6] = [
        ("slide, mm", SLIDE_MM, &|r| {
            Some(1e3 * f64::from(of(r).slide.mean_metres))
        }),
        ("toe slide, mm", SLIDE_MM, &|r| {
            r.seen.slide_mm.map(f64::from)
        }),
        ("below floor, mm", BELOW_FLOOR_MM, &|r| {
            Some(1e3 * f64::from(of(r).below_floor_metres))
        }),
        ("max speed / (1.3 × the source's + 286°/s)", 1.0, &|r| {
            Some(speed(r))
        }),
        ("wrong hinges, %", WRONG_HINGES_PERCENT, &|r| {
            percent(of(r).hinge_wrong_share)
        }),
        (
            "knees bent forward, from the poses alone, %",
            WRONG_HINGES_PERCENT,
            &|r| percent(r.seen.knees_wrong_share),
        ),
    ];
    let target = |(what, most, value): &Quantity<'_>| {
        let found = rows.iter().filter_map(|r| Some((value(r)?, r)));
        let (worst, row) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let case = format!("{} onto {}", row.case.motion, row.case.onto);
        Some(Target::at_most([what, case.as_str()], *most, worst))
    };
    quantities.iter().filter_map(target).collect()
}

fn page(rows: &[Row]) -> Result<String> {
    let mut page = String::from(HEAD);
    page.push_str(&targets::section(
        TARGETS,
        &["quantity", "worst case"],
        &bounds(rows),
    ));
    page.push_str(COLUMNS);
    for row in rows {
        let (q, seen) = (row.quality(), &row.seen);
        let [mapped, shared, held, _] = row.joints;
        let mm = |metres: f32| format!("{:.1}", 1000.0 * metres + 0.0);
        let own = seen
            .slide_mm
            .map_or_else(|| "-".to_owned(), |mm| format!("{mm:.1}"));
        let slides = match q.slide.contacts {
            0 => ["-", "-"].map(str::to_owned),
            _ => [mm(q.slide_before.mean_metres), mm(q.slide.mean_metres)],
        };
        writeln!(
            page,
            "| {} | {} | {} | {:.2} | {} / {} / {} | {} | {} | {own} | {} | {} | {:.1} | {:.1} | {:.0} ({:.0}) | {:.2} |",
            row.case.motion,
            row.case.onto,
            row.after.models.len(),
            row.scale,
            mapped,
            shared,
            held,
            slides[0],
            slides[1],
            mm(q.below_floor_before_metres),
            mm(q.below_floor_metres),
            100.0 * q.hands.mean,
            100.0 * q.feet.mean,
            seen.fastest.1,
            seen.fastest_source.1,
            100.0 * q.hinge_wrong_share.max(seen.knees_wrong_share),
        )?;
    }
    page.push_str(TAIL);
    Ok(page)
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut csv = String::from(
        "motion,onto,frames,rate_hz,scale,mapped,shared,held,dropped,contacts,slide_before_mm,slide_mm,slide_max_mm,slide_source_mm,contacts_seen,slide_seen_mm,slide_seen_source_mm,below_floor_before_mm,below_floor_mm,hands_mean,hands_max,feet_mean,feet_max,head_mean,head_max,fastest,fastest_deg_per_s,fastest_source,fastest_source_deg_per_s,hinge_wrong_share,knees_wrong_share_seen\n",
    );
    for row in rows {
        let (q, seen) = (row.quality(), &row.seen);
        let [mapped, shared, held, dropped] = row.joints;
        let mm = |metres: f32| format!("{:.3}", 1000.0 * metres + 0.0);
        let opt = |mm: Option<f32>| mm.map_or_else(String::new, |mm| format!("{mm:.3}"));
        let ends = [q.hands, q.feet, q.head].map(|e| format!("{:.4},{:.4}", e.mean, e.max));
        writeln!(
            csv,
            "{},{},{},{},{:.4},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{:.1},{},{:.1},{:.5},{:.5}",
            row.case.motion,
            row.case.onto,
            row.after.models.len(),
            row.after.rate_hz,
            row.scale,
            mapped,
            shared,
            held,
            dropped,
            q.slide.contacts,
            mm(q.slide_before.mean_metres),
            mm(q.slide.mean_metres),
            mm(q.slide.max_metres),
            mm(q.slide_source.mean_metres),
            seen.contacts,
            opt(seen.slide_mm),
            opt(seen.slide_source_mm),
            mm(q.below_floor_before_metres),
            mm(q.below_floor_metres),
            ends.join(","),
            seen.fastest.0,
            seen.fastest.1,
            seen.fastest_source.0,
            seen.fastest_source.1,
            q.hinge_wrong_share,
            seen.knees_wrong_share,
        )?;
    }
    Ok(csv)
}

const HEAD: &str = "# Retargets: every kind of motion on every kind of character

Made by `cargo run --release -p articula-lab -- retargets` (`--sheets DIR` draws each motion above
the result). Feet are pinned; all other options are those of `convert --onto`.

![Four motions, each above the character that it was retargeted onto](../pictures/retargets.png)

Motions: CMU Graphics Lab (mocap.cs.cmu.edu; created with funding from NSF EIA-0196217) and FAIR1 of
Animated Drawings (MIT). Characters: Knight by KayKit and man by Quaternius (CC0), Godette by
SirRichard94 and Lyuma (CC-BY 3.0), the reference human of Articula.
";

const TARGETS: &str =
    "The bounds of docs/retargeting.md hold for every motion; each row names the worst.";

const COLUMNS: &str = "
## Every motion

| motion | onto | frames | scale | joints mapped / shared / held | slide raw, mm | slide, mm | toe slide, mm | below floor raw, mm | below floor, mm | hand error, % | foot error, % | max speed, deg/s | wrong hinges, % |
| --- | --- | ---: | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |
";

const TAIL: &str = "
*Scale* is the size of the character over that of the source, by the legs. *Slide* is the mean over the
contacts of heels and toes of the maximum distance of a planted point from its first position, with
joint rotations only (raw) and in the result; a dash where no foot is planted (motions in place). *Toe
slide* measures the same from the poses alone: contacts are frames in which the source's toe joint is
slow, low and close to its first position, the distance is that of the target's toe joint, which rolls
slightly over the pinned point. *Below floor* is the maximum depth of a sole below the floor. *Hand
error* and *foot error* are the mean distances of wrists and ankles from those of the source, relative
to shoulder and hip, in lengths of the limb. *Max speed* is the maximum angular speed of a joint
relative to its parent (in brackets: of the source's joints). *Wrong hinges* is the fraction of frames
in which a knee bends forward or an elbow backward.
";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data;

    /// Planted feet slide by at most 20 mm in the mean, no limb flips, knees and elbows bend in the
    /// right direction. Slide, speed and knees are also measured from the poses alone.
    #[test]
    fn every_retarget_holds_its_bounds() {
        let Some(data) = data::folder(None, false).unwrap() else {
            println!("skipped: no data");
            return;
        };
        let run = Run {
            data,
            out: PathBuf::new(),
            small: false,
        };
        let rows = rows(&run).unwrap();
        for target in bounds(&rows) {
            assert!(target.holds(), "{target:?}");
        }
        let rests = |row: &&Row| row.seen.contacts > 0 && row.quality().slide.contacts > 0;
        let resting = rows.iter().filter(rests).count();
        assert!(
            resting >= 9,
            "feet rest in {resting} of {} only",
            rows.len()
        );
    }
}
