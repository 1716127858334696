//! Motion streams: bytes at equal error beside other forms, layers and speeds
//! (docs/formats/abp2.md, docs/methods/motion-stream.md).

mod cases;
mod faces;
mod judge;
mod motion;
mod peers;

use super::Run;
use super::targets::{Target, section, table};
use anyhow::{Context, Result};
use articula::Figure;
use cases::{CASES, Case};
use motion::{Form, Motion, ROUNDS, TOLERANCE_METRES, measured};
use peers::Peer;
use std::fmt::Write as _;

/// A clip in all forms.
struct Row {
    name: String,
    trained: bool,
    frames: usize,
    joints: usize,
    motion: Motion,
    keys: [usize; 2],
    meshopt: Peer,
    bvh: Option<Peer>,
    abp1: Option<Peer>,
}

/// Writes the page and its CSV file.
pub(crate) fn write(run: &Run) -> Result<()> {
    let mut rows = Vec::new();
    for case in CASES.iter().filter(|case| !run.small || case.is_small()) {
        let figure = case.open(&run.data)?;
        let mut clips = case.indices(&figure)?;
        if run.small {
            clips.truncate(1);
        }
        for clip in clips {
            let name = &figure.asset.clips[clip].name;
            eprintln!("streams: {}, {name}", case.name);
            let row = row(run, case, &figure, clip);
            rows.push(row.with_context(|| format!("{}: clip {name}", case.name))?);
        }
    }
    let mut page = HEAD.to_owned();
    let mut csv = String::from("kind,clip,form,bytes,error_mm\n");
    sizes(&mut page, &mut csv, &rows)?;
    forms(&mut page, &mut csv, &rows)?;
    tiers(&mut page, &mut csv, &rows)?;
    speeds(&mut page, &rows)?;
    faces::write(run, &mut page, &mut csv)?;
    if let Some(walk) = rows.iter().find(|row| row.name == "pab, walk") {
        let about =
            "The bounds of `docs/methods/motion-stream.md`, part 10, on `pab_arnaud`'s walk.";
        let [must, stretch] = targets(walk);
        page.push_str(&section(about, &["quantity"], &must));
        page.push_str("\nWhat would be better still:\n\n");
        page.push_str(&table(&["quantity"], &stretch));
    }
    run.save("streams", &page, &csv)
}

fn row(run: &Run, case: &Case, figure: &Figure, index: usize) -> Result<Row> {
    let asset = &figure.asset;
    let clip = &asset.clips[index];
    let has_joints = !clip.tracks().rotations.is_empty();
    let tolerance_mm = 1e3 * TOLERANCE_METRES;
    let rounds = if run.small { 1 } else { ROUNDS };
    Ok(Row {
        name: format!("{}, {}", case.name, clip.name),
        trained: case.trained,
        frames: clip.frames(),
        joints: asset.rig.len(),
        motion: measured(asset, clip, case.tiers, rounds)?,
        keys: peers::keys(&figure.opened.character().clips[index])?,
        meshopt: peers::meshoptimizer(asset, clip)?,
        bvh: match case.source_bvh(&run.data)? {
            Some(bytes) => Some(Peer {
                bytes,
                errors: None,
            }),
            None => has_joints.then(|| peers::bvh(figure, index)).transpose()?,
        },
        abp1: has_joints
            .then(|| peers::abp1(figure, index, tolerance_mm))
            .transpose()?,
    })
}

fn sizes(page: &mut String, csv: &mut String, rows: &[Row]) -> Result<()> {
    page.push_str(SIZES);
    for row in rows {
        let (motion, name) = (&row.motion, &row.name);
        let single = motion.single.bytes;
        let tiers = match motion.single_tiers {
            1 => String::new(),
            more => format!(", {more} tiers"),
        };
        let layered = |form: &Form| {
            let (bytes, mm) = (form.bytes, form.errors.frames_mm);
            format!("{bytes} ({:.2}; {mm:.3})", bytes as f64 / single as f64)
        };
        let [by_level, by_region, by_joint] = &motion.layered;
        let share = |part: usize, whole: usize| 100.0 * part as f64 / whole as f64;
        writeln!(
            page,
            "| {name} | {} | {} | {} of {} | {single}{tiers} | {} | {} | {} | {:.3} | {:.3} | {:.0} % | {:.0} % |",
            if row.trained { "trained" } else { "held out" },
            row.frames,
            motion.joints_moving,
            row.joints,
            layered(by_level),
            layered(by_region),
            layered(by_joint),
            motion.single.errors.frames_mm,
            motion.single.errors.between_mm,
            share(motion.level_0[0], by_level.bytes),
            share(motion.level_0[1], by_level.bytes),
        )?;
        let mm = motion.single.errors.frames_mm;
        writeln!(csv, "body,\"{name}\",abp2 single,{single},{mm:.4}")?;
        for (name_of_form, form) in [("abp2 region", by_region), ("abp2 joint", by_joint)] {
            let (bytes, mm) = (form.bytes, form.errors.frames_mm);
            writeln!(csv, "body,\"{name}\",{name_of_form},{bytes},{mm:.4}")?;
        }
    }
    Ok(())
}

fn forms(page: &mut String, csv: &mut String, rows: &[Row]) -> Result<()> {
    page.push_str(FORMS);
    for row in rows {
        let [raw, zipped] = row.keys;
        let judged = |peer: &Option<Peer>| match peer {
            None => "–".to_owned(),
            Some(peer) => match peer.errors {
                None => peer.bytes.to_string(),
                Some(e) => format!("{} ({:.3}, {:.3})", peer.bytes, e.frames_mm, e.between_mm),
            },
        };
        let single = &row.motion.single;
        let ours = Some(Peer {
            bytes: single.bytes,
            errors: Some(single.errors),
        });
        let meshopt = row.meshopt.errors.map_or(0.0, |e| e.frames_mm);
        let with = Peer {
            bytes: row.meshopt.bytes,
            errors: row.meshopt.errors,
        };
        writeln!(
            page,
            "| {} | {raw} | {zipped} | {} | {} | {} | {} |",
            row.name,
            judged(&Some(with)),
            judged(&row.bvh),
            judged(&row.abp1),
            judged(&ours),
        )?;
        writeln!(csv, "body,\"{}\",keys,{raw},0", row.name)?;
        writeln!(csv, "body,\"{}\",keys gzip,{zipped},0", row.name)?;
        writeln!(
            csv,
            "body,{},meshopt gzip,{},{meshopt:.4}",
            row.name, row.meshopt.bytes
        )?;
        for (form, peer) in [("bvh brotli", &row.bvh), ("abp1", &row.abp1)] {
            if let Some(peer) = peer {
                let mm = peer
                    .errors
                    .map_or_else(String::new, |e| format!("{:.4}", e.frames_mm));
                writeln!(csv, "body,\"{}\",{form},{},{mm}", row.name, peer.bytes)?;
            }
        }
    }
    Ok(())
}

fn tiers(page: &mut String, csv: &mut String, rows: &[Row]) -> Result<()> {
    page.push_str(TIERS);
    for row in rows {
        write!(page, "| {} |", row.name)?;
        for (tier, form) in row.motion.tiers.iter().enumerate() {
            write!(page, " {}: {:.2} |", form.bytes, form.errors.frames_mm)?;
            let mm = form.errors.frames_mm;
            writeln!(
                csv,
                "body,\"{}\",tier {tier},{},{mm:.4}",
                row.name, form.bytes
            )?;
        }
        for _ in row.motion.tiers.len()..7 {
            page.push_str(" |");
        }
        page.push('\n');
    }
    Ok(())
}

fn speeds(page: &mut String, rows: &[Row]) -> Result<()> {
    page.push_str(SPEEDS);
    for row in rows {
        let motion = &row.motion;
        if motion.joints_moving == 0 {
            continue;
        }
        let all = row.joints as f64 / motion.joints_moving as f64;
        let speed = |tier: usize| motion.decode_millions.get(tier).copied().unwrap_or(0.0);
        writeln!(
            page,
            "| {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.2} |",
            row.name,
            speed(0),
            speed(3),
            all * speed(0),
            all * speed(3),
            motion.encode_secs,
        )?;
    }
    Ok(())
}

/// Bounds that must hold, and better ones.
fn targets(walk: &Row) -> [Vec<Target>; 2] {
    let motion = &walk.motion;
    let single = motion.single.bytes as f64;
    let layered = motion.layered.each_ref().map(|form| form.bytes as f64);
    let [by_level, by_region, by_joint] = layered.map(|bytes| bytes / single);
    let level_0 = motion
        .level_0
        .map(|bytes| 100.0 * bytes as f64 / layered[0]);
    let mut targets = [Vec::new(), Vec::new()];
    for (what, found, most) in [
        ("bytes, one tier", single, [3000.0, 2400.0]),
        ("by level / one tier", by_level, [1.06, 1.02]),
        ("by level and region / one tier", by_region, [1.10, 1.05]),
        ("by joint / one tier", by_joint, [1.30, 1.10]),
        (
            "level 0, all tiers, % of the file",
            level_0[0],
            [40.0, 30.0],
        ),
        (
            "level 0, coarsest tier, % of the file",
            level_0[1],
            [20.0, 15.0],
        ),
    ] {
        for (targets, most) in targets.iter_mut().zip(most) {
            targets.push(Target::at_most([what], most, found));
        }
    }
    for (tier, what, least) in [
        (0, "decode, all tiers, M joint-frames/s", [2.5, 5.0]),
        (3, "decode, 2.7 mm, M joint-frames/s", [5.0, 10.0]),
    ] {
        let found = motion.decode_millions.get(tier).copied().unwrap_or(0.0);
        for (targets, least) in targets.iter_mut().zip(least) {
            targets.push(Target::at_least([what], least, found));
        }
    }
    let between = motion.single.errors.between_mm;
    let most = 1.5e3 * TOLERANCE_METRES;
    targets[1].push(Target::at_most(["error between frames, mm"], most, between));
    targets
}

const HEAD: &str = "# Motion streams

Made by `cargo run --release -p articula-lab -- streams`. Clips as ABP-2 ([form](../formats/abp2.md),
[method](../methods/motion-stream.md)) within 0.1 mm of skin, beside other forms in the same run. Errors are the greatest over
all vertices (of a figure without a mesh, three points around each joint), in millimetres: at all frames, and in the middle
between frames, where both motions are interpolated as players do. *Trained*: the start contexts of the codec were trained on
this clip, so it is expected to do a little better than others; *held out*: they were not. The clips are a selection: of files
with many, up to four.
";

const SIZES: &str = "
## Sizes

*One tier*: nothing but access units and levels of articulation can be cut; a motion that is too large for one has as few as it
needs, with its errors in *mm* and *between, mm*. The others have five tiers (the fox seven) by level of articulation, level and
region, and joint; in brackets the ratio to the first, and the error in mm. *Level 0*: bytes of the units of root, hips and shoulders at all tiers, and at the coarsest, in the file by level.

| clip | | frames | joints moving | one tier | by level | level and region | joint | mm | between, mm | level 0 | coarsest |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const FORMS: &str = "
## Beside other forms

Bytes, in brackets the errors at frames and between. *Keys*: the animation's times and values in 32-bit floats, as in
the file, and in gzip. *meshoptimizer*: keys at every frame of the runtime clip, which may be denser than the file's,
constant tracks one; rotations in 8 bytes, 16-bit mantissas for translations and scales, filters as documented by
gltfpack and written again here, its own vertex codec, then gzip; its error is not bounded. *BVH*: the source file,
else our text with six decimals, in Brotli at its best (Zstandard is not among our libraries); not judged. *ABP-1*: a
frame for each of the runtime clip, the greatest steps within 0.1 mm, or its least steps (0.0001) where these do not
suffice: they do not depend on how far a joint moves the skin; no morph targets. The dancer's error is that of its
face, and the fox is 155 m long; elsewhere steps add up along a chain of joints, which was not traced further. ozz is
quoted from elsewhere for a walk of pab, not run here: 11.2 KB.

Measured by hand with ACL 2.1.99 on clips that the codec was not trained on and on the walk of pab, at most 0.1 mm of skin, in one run: KayKit
Barbarian Walking_A 4555 bytes, Death_B 12765, 2H_Spin 11239, KayKit Rogue Cheer 7331, pab walk 6444; ABP-2 (version 1)
1319, 4006, 3894, 2541 and 2562. ACL decodes 10 to 12 times faster, and any sample of a clip alone.

| clip | keys | gzip | meshoptimizer | BVH | ABP-1 | ABP-2, one tier |
| --- | --- | --- | --- | --- | --- | --- |
";

const TIERS: &str = "
## Tiers

The form by level, cut to each tier: bytes and greatest error at frames, mm. Tier *k* allows 0.1 · 3^*k* mm.

| clip | tier 0 | 1 | 2 | 3 | 4 | 5 | 6 |
| --- | --- | --- | --- | --- | --- | --- | --- |
";

const SPEEDS: &str = "
## Speed

Millions of joints decoded per second, from bytes to local rotations, translations and scales of every frame, in the
processor time of one thread; five tiers and at 2.7 mm, of joints that move, and with those that rest counted as
players count them. Encoding of the form by level, seconds.

| clip | all tiers | 2.7 mm | with resting joints | 2.7 mm | encode, s |
| --- | --- | --- | --- | --- | --- |
";
