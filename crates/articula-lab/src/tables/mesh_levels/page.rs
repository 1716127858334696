//! The page of the mesh levels, and its CSV files.

use super::contestants::Contestant;
use super::errors::{LINES_PX, Row};
use super::{Found, SHARES, targets};
use anyhow::Result;
use articula_build::SkinPoseSource;
use std::fmt::Write as _;

const HEAD: &str = "# Mesh levels

Made by `cargo run --release -p articula-lab -- mesh-levels`. Five levels of each character: 100, 50,
25, 10 and 1.5 % of its triangles.

![A man in a suit at four levels in a pose not used for simplification: whole, hand, head and armpit; below, levels of meshoptimizer](../pictures/mesh-levels.png)

Character by Quaternius, CC0; `--picture FILE` draws it, `--sheets FOLDER` all of them.
";

const ERRORS: &str = "
## Distance of a level from the original

Millimetres for a figure of 1.8 m (a head alone: 0.25 m) between the original surface and the
level, in both directions, at rest and in poses **not** used for simplification: the maximum, the 99th
percentile and the mean over vertices and face centres. *px*: the maximum in motion in a picture where
the figure fills 1080 lines. Poses are of the character's own clips; *bends* are random ones within joint
limits for a character without clips, *morphs* its morph targets for one without a skeleton.

*meshopt* is `meshopt::simplify` on the whole character at rest, with equal vertices joined first, for
the number of triangles of Articula's level, from the original each time, without a bound on the error.
It keeps seams and borders of materials; † marks levels for which it could not come within 2 % of the
number of triangles and was run again with its option to cross seams (`Permissive`), after which
textures and materials may be those of another triangle. Articula crosses seams too where nothing else is
left, never between materials, at a cost by the change of attributes. *With normals* is meshoptimizer by
`simplify_with_attributes`, normals with weight one half. *Ratio*: Articula to meshopt, maximum in motion.
";

/// The whole page.
pub(super) fn page(all: &[Found]) -> Result<String> {
    let mut page = HEAD.to_owned();
    targets::write(&mut page, all)?;
    page.push_str(ERRORS);
    errors(&mut page, all)?;
    weightings(&mut page, all)?;
    sizes(&mut page, all)?;
    Ok(page)
}

impl Found {
    pub(super) fn row(&self, who: Contestant, level: usize) -> Option<&Row> {
        let mut rows = self.errors.iter();
        rows.find(|r| r.who == who && r.level == level)
    }

    /// Ratio of Articula's to meshoptimizer's maximum distance in motion.
    pub(super) fn ratio(&self, level: usize) -> Option<f32> {
        let of = |who| self.row(who, level).map(|r| r.motion.max);
        Some(of(Contestant::Ours)? / of(Contestant::Meshopt)?)
    }

    fn poses(&self) -> String {
        let kind = match self.source {
            SkinPoseSource::Clips => "of clips",
            SkinPoseSource::Bends => "bends",
            SkinPoseSource::Morphs => "morphs",
            SkinPoseSource::Rest => "none",
        };
        format!("{} {kind}", self.poses)
    }
}

fn errors(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(
        "
| character | level | triangles | vertices | rest max / p99 / mean | motion max / p99 / mean | px | meshopt triangles | motion max / p99 / mean | with normals max | ratio |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
",
    );
    for found in all {
        for level in (0..SHARES.len() - 1).rev() {
            let row = |who| found.row(who, level);
            let (Some(ours), Some(peer), Some(normals)) = (
                row(Contestant::Ours),
                row(Contestant::Meshopt),
                row(Contestant::MeshoptNormals),
            ) else {
                continue;
            };
            let name = if level + 2 == SHARES.len() {
                format!("{} ({})", found.name, found.poses())
            } else {
                String::new()
            };
            let three = |m: &super::errors::Millimetres| {
                format!("{:.1} / {:.2} / {:.3}", m.max, m.p99, m.mean)
            };
            let crossed = |r: &Row| if r.crossed_seams { "†" } else { "" };
            writeln!(
                page,
                "| {name} | {} | {} | {} | {} | {} | {:.1} | {}{} | {} | {:.1}{} | {:.2} |",
                SHARES[level],
                ours.triangles,
                ours.vertices,
                three(&ours.rest),
                three(&ours.motion),
                1e-3 * ours.motion.max / found.height_metres * LINES_PX,
                peer.triangles,
                crossed(peer),
                three(&peer.motion),
                normals.motion.max,
                crossed(normals),
                found.ratio(level).unwrap_or(f32::NAN),
            )?;
        }
    }
    Ok(())
}

fn weightings(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(
        "
## Order of collapses

Maximum distance in motion, then the mean, at 50 / 25 / 10 / 1.5 %; all on the same poses, which were not
used for simplification. *Joint weight* is the thesis' level of animation on the rest pose: the error
times 1 + 4 (1 - largest skin weight).

| character | poses summed | rest pose only | rest pose and joint weight |
| --- | --- | --- | --- |
",
    );
    for found in all {
        let cell = |who| {
            let list = |of: &dyn Fn(&Row) -> String| {
                let levels = (0..SHARES.len() - 1).rev();
                let texts: Vec<String> = levels.filter_map(|l| found.row(who, l)).map(of).collect();
                texts.join(" / ")
            };
            format!(
                "{}; {}",
                list(&|r| format!("{:.1}", r.motion.max)),
                list(&|r| format!("{:.2}", r.motion.mean))
            )
        };
        writeln!(
            page,
            "| {} | {} | {} | {} |",
            found.name,
            cell(Contestant::Ours),
            cell(Contestant::Rest),
            cell(Contestant::Joint)
        )?;
    }
    Ok(())
}

fn sizes(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(BYTES);
    for found in all {
        let sizes = &found.sizes;
        let sum: usize = sizes.levels.iter().map(|l| l.plain).sum();
        for (l, level) in sizes.levels.iter().enumerate().rev() {
            let top = l + 1 == sizes.levels.len();
            let store = format!(
                "{} / {sum} = {:.2}",
                sizes.store,
                sizes.store as f64 / sum as f64
            );
            let direct = level.draco.map(|d| level.direct as f64 / d as f64);
            writeln!(
                page,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} ({}) | {} |",
                if top { found.name } else { "" },
                SHARES[l],
                level.triangles,
                level.vertices,
                level.direct,
                level.chunk,
                level.draco.map_or("–".into(), |d| d.to_string()),
                direct.map_or("–".into(), |r| format!("{r:.2}")),
                level.meshopt,
                level.plain,
                level.ranges,
                3 * l + 1,
                if top { store } else { String::new() }
            )?;
        }
    }
    wholes(page, all)?;
    progressive(page, all)
}

const BYTES: &str = "
## Bytes

Of Articula's level meshes, all parts of a character, with the same quantised values for every codec:
position 14 bits on one grid per mesh, normal 10, texture coordinates 12, weights 8 bits; without morph
targets, which neither other codec supports. *Direct*: Articula, the level alone; *chunk*: Articula, the
addition of the level to the next coarser one. *Draco*: npm `draco3dgltf`, edgebreaker, speed 0, its best
setting; *meshopt*: vertices of up to 24 bytes in the vertex codec and indices in the index codec, both
in the order of its functions. *Plain*: those vertices and 16-bit indices (32 where needed) uncoded in a
buffer; *STORE* holds all levels that way. *Ranges*: the number of ranges that show the level from STORE,
including that of the vertices; the thesis has 3i + 1 for its level i (0 the coarsest), counted the same
way.

| character | level | triangles | vertices | direct | chunk | Draco | direct / Draco | meshopt | plain | ranges (3i + 1) | STORE / sum of plain |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

fn wholes(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(
        "
All levels in one stream (TRANSPORT, the sum of the chunks) compared with the alternatives, and the
processor time of one thread: for coding the minimum of three rounds, for the rest one (*round* with morph
targets and without), with the triangles of all levels per second. Times of one run are comparable. *With
morph targets*: Articula, all levels and the finest alone.

| character | whole | / Draco's finest | / five of Draco | / meshopt's finest | / own finest | with morph targets | simplify | round | encode | decode |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
",
    );
    for found in all {
        let sizes = &found.sizes;
        let whole = sizes.whole();
        let triangles: usize = sizes.levels.iter().map(|l| l.triangles).sum();
        let plain: usize = sizes.levels.iter().map(|l| l.plain).sum();
        let ratio = |of: Option<f64>| of.map_or("–".into(), |r| format!("{r:.2}"));
        let speed = |secs: f64| {
            format!(
                "{:.0} ms, {:.2} million, {:.0} MB/s",
                1e3 * secs,
                1e-6 * triangles as f64 / secs,
                1e-6 * plain as f64 / secs
            )
        };
        writeln!(
            page,
            "| {} | {whole} | {} | {} | {} | {} | {} | {:.0} ms | {:.0} ms | {} | {} |",
            found.name,
            ratio(found.to_draco()),
            ratio(found.to_draco_levels()),
            ratio(found.to_meshopt()),
            ratio(found.to_own()),
            sizes
                .with_morphs
                .map_or(String::new(), |(whole, finest)| format!(
                    "{whole} / {finest}"
                )),
            1e3 * found.simplify_secs,
            1e3 * sizes.seconds.rounding,
            speed(sizes.seconds.encoding),
            speed(sizes.seconds.decoding),
        )?;
    }
    Ok(())
}

/// The thesis' table 6.1, with operations.
fn progressive(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(PROGRESSIVE);
    for found in all {
        let sizes = &found.sizes;
        let ends = [sizes.levels.first(), sizes.levels.last()];
        let [Some(coarsest), Some(finest)] = ends else {
            continue;
        };
        let plain: usize = sizes.levels.iter().map(|l| l.plain).sum();
        let direct: usize = sizes.levels.iter().map(|l| l.direct).sum();
        let finer_first = sizes.levels.windows(2).rev();
        let splits: Vec<String> = finer_first
            .map(|pair| (pair[1].points - pair[0].points).to_string())
            .collect();
        let ranges: Vec<String> = sizes
            .levels
            .iter()
            .rev()
            .map(|l| l.ranges.to_string())
            .collect();
        writeln!(
            page,
            "| {} | {} / {} | {} / {} | {} / {} | {plain} / {direct} | {} | {} ({}) |",
            found.name,
            finest.plain,
            finest.direct,
            sizes.store,
            sizes.whole(),
            sizes.progressive.plain,
            sizes.progressive.coded,
            ranges.join(", "),
            splits.join(", "),
            finest.points - coarsest.points,
        )?;
    }
    Ok(())
}

const PROGRESSIVE: &str = "
## Beside a progressive mesh

The thesis' table 6.1 for these levels: bytes uncoded / coded, without morph targets. *Clustered* is STORE
/ TRANSPORT, *discrete* every level by itself (plain / direct). The *progressive mesh* (Hoppe 1996) is the
coarsest level and one vertex split for each position that the next coarser level does not have: uncoded
with 6 bytes for a split and the plain bytes of the vertices that it adds; coded not less than the finest
level alone and the bits by which Hoppe names the vertex and the edges of a split (log2 of the vertices so
far, and 5), which assumes that the attributes cost no more in that order. *Operations* to show a level: for
clustered levels the ranges of the level (100, 50, 25, 10, 1.5 %), whatever was shown before; for the
progressive mesh the splits from the next coarser level to each finer one (to 100, 50, 25, 10 %), in
brackets from the coarsest to the finest.

| character | finest alone | clustered | progressive mesh | discrete | clustered: ranges | progressive mesh: splits (all) |
| --- | --- | --- | --- | --- | --- | --- |
";

/// One line for each character, simplifier and level.
pub(super) fn errors_csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "character,who,level,triangles,vertices,crossed_seams,rest_max_mm,rest_p99_mm,rest_mean_mm,motion_max_mm,motion_p99_mm,motion_mean_mm\n",
    );
    for found in all {
        for row in &found.errors {
            writeln!(
                csv,
                "{},{},{},{},{},{},{:.3},{:.3},{:.4},{:.3},{:.3},{:.4}",
                found.name.replace(',', ";"),
                row.who.name().replace(',', ";"),
                SHARES.len() - 1 - row.level,
                row.triangles,
                row.vertices,
                row.crossed_seams,
                row.rest.max,
                row.rest.p99,
                row.rest.mean,
                row.motion.max,
                row.motion.p99,
                row.motion.mean,
            )?;
        }
    }
    Ok(csv)
}

/// One line for each character and level.
pub(super) fn bytes_csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "character,level,triangles,vertices,positions,direct,chunk,draco,meshopt,plain,ranges,store,progressive_plain,progressive_coded,draco_kinds\n",
    );
    for found in all {
        let kinds: Vec<String> = found
            .sizes
            .draco_kinds
            .iter()
            .map(|(kind, bytes)| format!("{kind} {bytes}"))
            .collect();
        for (l, level) in found.sizes.levels.iter().enumerate() {
            let number = found.sizes.levels.len() - 1 - l;
            let top = number == 0;
            let of_whole = |bytes: usize| {
                if top {
                    bytes.to_string()
                } else {
                    String::new()
                }
            };
            writeln!(
                csv,
                "{},{number},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                found.name.replace(',', ";"),
                level.triangles,
                level.vertices,
                level.points,
                level.direct,
                level.chunk,
                level.draco.map_or(String::new(), |d| d.to_string()),
                level.meshopt,
                level.plain,
                level.ranges,
                of_whole(found.sizes.store),
                of_whole(found.sizes.progressive.plain),
                of_whole(found.sizes.progressive.coded),
                if top { kinds.join(" ") } else { String::new() },
            )?;
        }
    }
    Ok(csv)
}
