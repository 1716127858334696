//! The page of lighter files, and its CSV file.

use super::contest::{Contest, Entrant, Kind};
use crate::tables::targets::{self, Target};
use anyhow::Result;
use std::fmt::Write as _;

const HEAD: &str = "# Lighter files

Made by `cargo run --release -p articula-lab -- optimize` with the peers of `oracle/peers` (`npm ci` in `oracle` and there):
gltfpack 1.3 at five settings and glTF-Transform 4.5 at two, in `oracle/peers/files.mjs`. Pictures stay as they are, and their
bytes are left out of every number but those of the first column.

One judge, three.js in node (`oracle/peers/errors.mjs`), measures all files: 3000 vertices of the source, drawn at random, are
followed through all clips at 400 or more random times, which are not those of any optimiser; in a file without clips through
every morph target at its full weight. Peers reorder, weld and join vertices, so each is followed by the vertex of the file that
is nearest at rest; where several are about as near, by the one that errs least. The error is the greatest of all, in millimetres,
and in pixels of a picture of 720 lines that the figure at rest fills.

*Smallest peer*: of all settings, the file with the fewest bytes whose error is at most 2 px; with more, its motion is broken.
Ours is asked for the error of that file, and for 1 px at most, by its own measure, which follows every vertex. `KHR` is
KHR_meshopt_compression beside all peers, `EXT` is EXT_meshopt_compression beside those that do not need KHR. *Brotli*: the
ratio of the same two files after brotli at quality 11. Ratios below 1 are for ours. A peer loses what it does not know, such
as VRM; ours keeps it.

Libraries are files of clips without a mesh. Judge and optimiser pose the vertices of a character whose joints have the same names; a
file that has lost them moves nothing. *JSON* is the document of ours for the KHR ratio. A moving channel needs some 170 bytes of it for itself, its
sampler and the accessor of its values, whatever its keys need.

*Babylon.js* is the greatest distance between a vertex of ours in Babylon.js and the same vertex in three.js, at rest, in three random
poses of every clip and at the full weight of every morph target (`oracle/peers/babylon.mjs`).

With fewer triangles vertices cannot be followed, so another judge (`oracle/peers/surfaces.mjs`, three.js and three-mesh-bvh) shows
both files in 20 or more seeded random poses and takes the greatest distance of up to 3000 vertices of either from the surface
of the other. The peers are asked for a part of the triangles (`-si`, `simplify`), where gltfpack may stop before it is reached; those within 5 px
count, and ours is asked for the error of the smallest.
";

const TARGETS: &str = "Bytes over those of the smallest peer, with KHR_meshopt_compression.";

const CHARACTERS: &str = "\n## Characters\n";
const LIBRARIES: &str = "\n## Libraries of clips\n";
const FEWER: &str = "
## Fewer triangles

| file | part asked of peers | smallest peer | kB | error px | ours kB | error px | ratio | brotli | Babylon.js mm |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const ROWS: &str = "
| file | source kB | smallest peer | kB | error px | ours kB | error px | KHR ratio | brotli | \
smallest EXT peer | kB | error px | ours kB | error px | EXT ratio | brotli | JSON kB | Babylon.js mm |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const BROKEN: &str = "
## Peers that do not count

Files whose error is above 2 px, or 5 px with fewer triangles, and settings that write none.

| character | peer | kB | error mm | error px |
| --- | --- | --- | --- | --- |
";

/// The Markdown page.
pub(super) fn page(all: &[Contest]) -> Result<String> {
    let mut page = String::from(HEAD);
    let targets = all_targets(all);
    if !targets.is_empty() {
        page.push_str(&targets::section(TARGETS, &["files", "quantity"], &targets));
    }
    let sections = [
        (CHARACTERS, of_kind(all, is_whole)),
        (LIBRARIES, of_kind(all, is_clips)),
    ];
    for (head, contests) in sections {
        if !contests.is_empty() {
            page.push_str(head);
            rows(&contests, &mut page)?;
        }
    }
    let fewer = of_kind(all, is_fewer);
    if !fewer.is_empty() {
        rows_of_fewer(&fewer, &mut page)?;
    }
    page.push_str(BROKEN);
    for contest in all {
        for peer in contest.peers.iter().filter(|peer| !contest.is_fair(peer)) {
            let (kb, mm) = (kilobytes(peer.file_bytes), two(peer.error_mm()));
            let px = two(peer.error_px());
            writeln!(
                page,
                "| {} | {} | {kb} | {mm} | {px} |",
                contest.name,
                name(peer)
            )?;
        }
        for (who, why) in &contest.faults {
            let why = why.replace('|', " ");
            writeln!(page, "| {} | {who}: {why} | – | – | – |", contest.name)?;
        }
    }
    Ok(page)
}

fn rows(contests: &[&Contest], page: &mut String) -> Result<()> {
    page.push_str(ROWS);
    for contest in contests {
        let mut cells = vec![contest.name.to_owned(), kilobytes(contest.source_bytes)];
        for ours in [true, false].map(|khr| contest.ours.iter().find(|ours| ours.is_khr == khr)) {
            let peer = ours.and_then(|ours| contest.smallest(ours.is_khr));
            cells.push(peer.map_or("–".into(), name));
            for file in [peer, ours] {
                let bytes = file.map(|file| file.bytes().unwrap_or(file.file_bytes));
                cells.push(bytes.map_or("–".into(), kilobytes));
                cells.push(two(file.and_then(Entrant::error_px)));
            }
            cells.push(three(ours.and_then(|ours| contest.ratio(ours))));
            cells.push(three(ours.and_then(|ours| contest.brotli_ratio(ours))));
        }
        let ours = contest.ours.iter().find(|ours| ours.is_khr);
        let json = ours.and_then(|ours| ours.judged.as_ref()).map(|j| j.json);
        cells.push(json.map_or("–".into(), kilobytes));
        cells.push(apart(contest));
        writeln!(page, "| {} |", cells.join(" | "))?;
    }
    Ok(())
}

fn rows_of_fewer(contests: &[&Contest], page: &mut String) -> Result<()> {
    page.push_str(FEWER);
    for contest in contests {
        let Kind::Fewer(part) = contest.kind else {
            continue;
        };
        let (ours, peer) = (contest.ours.first(), contest.smallest(true));
        let mut cells = vec![contest.name.to_owned(), part.to_owned()];
        cells.push(peer.map_or("–".into(), name));
        for file in [peer, ours] {
            cells.push(file.and_then(Entrant::bytes).map_or("–".into(), kilobytes));
            cells.push(two(file.and_then(Entrant::error_px)));
        }
        cells.push(three(ours.and_then(|ours| contest.ratio(ours))));
        cells.push(three(ours.and_then(|ours| contest.brotli_ratio(ours))));
        cells.push(apart(contest));
        writeln!(page, "| {} |", cells.join(" | "))?;
    }
    Ok(())
}

/// The greatest distance between Babylon.js and three.js in millimetres, of all files of ours; why there is none
/// otherwise.
fn apart(contest: &Contest) -> String {
    let shown = || contest.ours.iter().filter_map(|ours| ours.shown.as_ref());
    if let Some(fault) = shown().find_map(|shown| shown.fault.as_ref()) {
        return fault.replace('|', " ");
    }
    let apart = shown().filter_map(|shown| shown.apart_mm);
    two(apart.reduce(f64::max))
}

fn is_whole(kind: &Kind) -> bool {
    *kind == Kind::Whole
}

fn is_clips(kind: &Kind) -> bool {
    matches!(kind, Kind::Clips(_))
}

fn is_fewer(kind: &Kind) -> bool {
    matches!(kind, Kind::Fewer(_))
}

fn of_kind(all: &[Contest], is_kind: impl Fn(&Kind) -> bool) -> Vec<&Contest> {
    all.iter().filter(|c| is_kind(&c.kind)).collect()
}

fn all_targets(all: &[Contest]) -> Vec<Target> {
    let ours = |contest: &'_ Contest| contest.ours.iter().find(|ours| ours.is_khr).cloned();
    let ratio = |contest: &Contest| contest.ratio(&ours(contest)?);
    let brotli = |contest: &Contest| contest.brotli_ratio(&ours(contest)?);
    let characters = of_kind(all, is_whole);
    let of = |contests: &[&Contest]| -> Vec<f64> {
        let contests = contests.iter();
        contests.filter_map(|contest| ratio(contest)).collect()
    };
    let ratios = of(&characters);
    let [of_libraries, of_fewer] = [is_clips, is_fewer].map(|is| of(&of_kind(all, is)));
    let brotlis: Vec<f64> = characters.iter().filter_map(|c| brotli(c)).collect();
    // An error above what was asked, by the judge, which does not measure what the optimiser did.
    let over = |file: &Entrant| Some(file.error_mm()? / file.asked_mm?);
    let overs = all.iter().flat_map(|contest| &contest.ours);
    let over = overs.clone().filter_map(over).fold(0.0, f64::max);
    let apart = overs.filter_map(|file| Some(file.apart_mm()? / file.asked_mm?));
    // The greatest in this order is that of a file that cannot be read, which is not a number and misses.
    let apart = apart.max_by(f64::total_cmp).unwrap_or(0.0);
    let mut targets = Vec::new();
    if let Some(worst) = ratios.iter().copied().reduce(f64::max) {
        targets.extend([
            Target::at_most(["every character", "largest ratio"], 1.0, worst),
            Target::at_most(["characters", "median ratio"], 0.85, median(ratios)),
            Target::at_most(
                ["characters", "median ratio after brotli"],
                1.0,
                median(brotlis),
            ),
        ]);
    }
    if let Some(worst) = of_libraries.into_iter().reduce(f64::max) {
        let labels = ["every library of clips", "largest ratio"];
        targets.push(Target::at_most(labels, 0.6, worst));
    }
    if !of_fewer.is_empty() {
        let labels = ["characters with fewer triangles", "median ratio"];
        targets.push(Target::at_most(labels, 0.88, median(of_fewer)));
    }
    if !targets.is_empty() {
        let labels = ["all", "judged error over the error asked for"];
        targets.push(Target::at_most(labels, 1.0, over));
        let labels = ["all", "distance in Babylon.js over the error asked for"];
        targets.push(Target::at_most(labels, 1.0, apart));
    }
    let knight = characters.into_iter().find(|c| c.name == "KayKit Knight");
    if let Some(ratio) = knight.and_then(ratio) {
        let labels = ["KayKit Knight", "ratio"];
        targets.push(Target::at_most(labels, 0.75, ratio));
    }
    targets
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let middle = numbers.len() / 2;
    match numbers.len() % 2 {
        0 => 0.5 * (numbers[middle - 1] + numbers[middle]),
        _ => numbers[middle],
    }
}

fn name(file: &Entrant) -> String {
    format!("{} `{}`", file.who, file.setting)
}

fn kilobytes(bytes: usize) -> String {
    format!("{:.1}", 1e-3 * bytes as f64)
}

fn two(number: Option<f64>) -> String {
    number.map_or("–".into(), |n| format!("{n:.2}"))
}

fn three(number: Option<f64>) -> String {
    number.map_or("–".into(), |n| format!("{n:.3}"))
}

/// Every file of every contestant.
pub(super) fn csv(all: &[Contest]) -> Result<String> {
    let mut csv = String::from(
        "character,part_asked,contestant,setting,file_bytes,bytes_without_pictures,brotli,error_mm,error_px,asked_mm\n",
    );
    for contest in all {
        for file in contest.peers.iter().chain(&contest.ours) {
            let number = |n: Option<f64>| n.map_or(String::new(), |n| format!("{n:.4}"));
            let whole = |n: Option<usize>| n.map_or(String::new(), |n| n.to_string());
            writeln!(
                csv,
                "\"{}\",{},{},{},{},{},{},{},{},{}",
                contest.name,
                contest.kind.part().unwrap_or_default(),
                file.who,
                file.setting,
                file.file_bytes,
                whole(file.bytes()),
                whole(file.brotli()),
                number(file.error_mm()),
                number(file.error_px()),
                number(file.asked_mm)
            )?;
        }
    }
    Ok(csv)
}

#[cfg(test)]
mod tests {
    use super::super::contest::tests::contest;
    use super::*;

    #[test]
    fn rows_compare_at_equal_error_and_broken_motion_is_told() {
        let all = [contest()];
        let page = page(&all).unwrap();
        let row = page.lines().find(|l| l.starts_with("| a figure")).unwrap();
        assert!(
            row.starts_with(
                "| a figure | 1.0 | peer `-cz -af 0` | 0.2 | 1.50 | 0.1 | 0.90 | 0.750"
            ),
            "{row}"
        );
        assert!(page.contains("| a figure | peer `-cz` | 0.1 | 90.00 | 90.00 |"));
        assert!(page.contains("| characters | median ratio | ≤ 0.85 | 0.750 | holds |"));
        let csv = csv(&all).unwrap();
        assert_eq!(csv.lines().count(), 6);
        assert!(csv.lines().all(|row| row.split(',').count() == 10), "{csv}");
    }

    #[test]
    fn medians_of_odd_and_even_lists() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
    }
}
