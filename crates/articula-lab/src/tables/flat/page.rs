//! The page of the conversion to 2D, and its CSV files.

use super::Found;
use super::portraits::{Row as Portrait, YAWS_DEGREES};
use super::profiles::THESIS;
use super::targets;
use anyhow::Result;
use articula_flat::flatten::FileSize;
use std::fmt::Write as _;

const HEAD: &str = "# Conversion to 2D

Made by `cargo run --release -p articula-lab -- flat`. Pictures of 400 x 400 pixels. Faces
are seen by the camera of docs/methods/vector.md, part 9 (4.5 half heights away); all other cases are
framed as by `articula flatten` and have 600 triangles (the dancing woman 1500; heads have no extra weight
here), fewer than the command takes by itself for most figures. Only triangles that are visible in some frame are counted. Frames are those
of the command's default of 25 a second, adjusted so that the last one falls on the end of the clip.

Errors are measured on the file, read back: corners in pixels; the picture against an 8 x 8 supersampled
one without a painting order, over the character's pixels, at every tenth frame and halfway between
frames (mean / worst). *B/t/f* is bytes per drawn triangle and frame. *x* is the size of the thesis' form
(`path`) of the same clip divided by the size of the file, both as they are, both with gzip and both with
Brotli. That form is written from the cut clip too, which on the face makes it 3 % larger than uncut. Wrong
pixels in the CSV are those of Articula's painting orders, also in the rows of the thesis. The player's picture is drawn from its container with exact
interpolation of colours; its script draws one gradient per triangle, and that loss and the seams of its
canvas are not in the rows.
";

const ORDERS: &str = "
## Pixels painted wrong

Percent of the character's pixels, mean over the frames. *Thesis*: one depth sort, at the first frame. *Constraints*:
one order for the whole clip. *Epochs*: as few orders as keep the wrong pixels within the order tolerance, and the mean number of copies
of a triangle. *Cut*: after cutting triangles that pierce each other, as `flatten` does, and the number of
triangles drawn then.

| case | thesis | depth sort per frame | constraints | epochs (orders, copies) | order per frame | cut (triangles) | fraction of the depth sort |
| --- | --- | --- | --- | --- | --- | --- | --- |
";

const PROFILES: &str = "
| profile | kB raw / gzip / brotli | B/t/f raw / brotli | x raw / gzip / brotli | corner error, px | colour RMSE, levels, mean / worst | SSIM mean / worst | shapes | keys | seconds |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const STILLS: &str = "
## Stills

The first frame. *Thesis*: three gradients per triangle under filters, over a background triangle. *Levels*: colour RMSE
in levels of 0 to 255. *B/t*: bytes per triangle.

| case | triangles | thesis B/t | Gouraud B/t | x | levels | SSIM | exact B/t | levels | flat B/t | levels |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

const PORTRAITS: &str = "
## Portraits

Colour RMSE over the head, in levels of 0 to 255, of the warped portrait at each yaw angle of the head,
against a picture of the turned figure in full quality, under light that turns with it. One view is the
thesis' portrait.

| head | triangles | views | document kB | pictures kB | 0° | 10° | 20° | 30° | 40° |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

/// The whole page.
pub(super) fn page(all: &[Found], portraits: &[Portrait]) -> Result<String> {
    let mut page = HEAD.to_owned();
    page.push_str(&targets::section(all));
    page.push_str(ORDERS);
    for found in all {
        let o = &found.orders;
        writeln!(
            page,
            "| {} | {:.1} | {:.2} | {:.2} | {:.2} ({}, {:.1}) | {:.2} | {:.2} ({}) | {:.2} |",
            found.case.name,
            o.thesis,
            o.depth_sort,
            o.single,
            o.epochs,
            o.count,
            o.copies,
            o.per_frame,
            o.split,
            o.split_triangles,
            o.split / o.depth_sort.max(1e-9)
        )?;
    }
    for found in all {
        profiles(&mut page, found)?;
    }
    stills(&mut page, all)?;
    page.push_str(PORTRAITS);
    for row in portraits {
        let levels = row.rmse_levels.iter().map(|l| format!("{l:.1}"));
        writeln!(
            page,
            "| {} | {} | {} | {:.1} | {:.1} | {} |",
            row.head,
            row.triangles,
            row.views,
            row.document as f64 / 1e3,
            row.pictures as f64 / 1e3,
            levels.collect::<Vec<_>>().join(" | ")
        )?;
    }
    Ok(page)
}

fn profiles(page: &mut String, found: &Found) -> Result<()> {
    let first = found.profiles.first().map(|r| &r.flat);
    let drawn = first.map_or(0, |f| f.triangles_drawn);
    let hidden = match found.hidden.as_slice() {
        [] => "No mesh is hidden.".to_owned(),
        names => format!("Hidden meshes: {}.", names.join(", ")),
    };
    writeln!(
        page,
        "\n## {}\n\n{}, clip {}: {} triangles, {drawn} drawn, {} frames. {hidden}",
        found.case.name, found.case.file, found.case.clip, found.triangles, found.frames
    )?;
    page.push_str(PROFILES);
    let thesis = found.row(THESIS).map(|r| r.flat.sizes);
    let smaller = |of: fn(&FileSize) -> u64, size| {
        thesis.map_or(0.0, |thesis| of(&thesis) as f64 / of(&size) as f64)
    };
    for row in &found.profiles {
        let flat = &row.flat;
        let sizes = flat.sizes;
        let kilo = |bytes: u64| bytes as f64 / 1e3;
        let image = flat.errors.image;
        writeln!(
            page,
            "| {} | {:.1} / {:.1} / {:.1} | {:.2} / {:.2} | {:.1} / {:.1} / {:.1} | {:.3} | {:.1} / {:.1} | {:.4} / {:.4} | {} | {} | {:.1} |",
            row.name,
            kilo(sizes.raw),
            kilo(sizes.gzip),
            kilo(sizes.brotli),
            flat.per_triangle_and_frame(sizes.raw),
            flat.per_triangle_and_frame(sizes.brotli),
            smaller(|s| s.raw, sizes),
            smaller(|s| s.gzip, sizes),
            smaller(|s| s.brotli, sizes),
            flat.errors.position_rmse_px,
            image.rmse_levels,
            image.rmse_levels_max,
            image.ssim,
            image.ssim_min,
            flat.shapes,
            flat.keys,
            row.secs
        )?;
    }
    Ok(())
}

fn stills(page: &mut String, all: &[Found]) -> Result<()> {
    page.push_str(STILLS);
    for found in all {
        let stills = &found.stills;
        let per =
            |flat: &articula_flat::flatten::Flattened| flat.per_triangle_and_frame(flat.sizes.raw);
        let thesis = stills.thesis_bytes as f64 / stills.thesis_triangles.max(1) as f64;
        let image = stills.ours.errors.image;
        writeln!(
            page,
            "| {} | {} | {thesis:.0} | {:.1} | {:.1} | {:.1} | {:.4} | {:.1} | {:.1} | {:.1} | {:.1} |",
            found.case.name,
            stills.ours.triangles_drawn,
            per(&stills.ours),
            thesis / per(&stills.ours),
            image.rmse_levels,
            image.ssim,
            per(&stills.exact),
            stills.exact.errors.image.rmse_levels,
            per(&stills.flat),
            stills.flat.errors.image.rmse_levels
        )?;
    }
    Ok(())
}

/// Every profile of every case as CSV.
pub(super) fn csv(all: &[Found]) -> Result<String> {
    let mut csv = String::from(
        "case,profile,triangles_drawn,frames,raw_bytes,gzip_bytes,brotli_bytes,position_rmse_px,\
         image_rmse_levels,image_rmse_levels_max,ssim,ssim_min,wrong_percent,wrong_percent_depth_sort,\
         shapes,keys,orders\n",
    );
    for found in all {
        for row in &found.profiles {
            let (flat, errors) = (&row.flat, &row.flat.errors);
            writeln!(
                csv,
                "\"{}\",\"{}\",{},{},{},{},{},{:.4},{:.3},{:.3},{:.5},{:.5},{:.3},{:.3},{},{},{}",
                found.case.name,
                row.name,
                flat.triangles_drawn,
                flat.frames,
                flat.sizes.raw,
                flat.sizes.gzip,
                flat.sizes.brotli,
                errors.position_rmse_px,
                errors.image.rmse_levels,
                errors.image.rmse_levels_max,
                errors.image.ssim,
                errors.image.ssim_min,
                errors.wrong_pixels_percent,
                errors.wrong_pixels_percent_depth_sort,
                flat.shapes,
                flat.keys,
                flat.orders
            )?;
        }
    }
    Ok(csv)
}

/// Every portrait as CSV.
pub(super) fn portraits_csv(all: &[Portrait]) -> Result<String> {
    let mut csv = String::from("head,triangles,views,document_bytes,picture_bytes");
    for yaw in YAWS_DEGREES {
        write!(csv, ",rmse_levels_{yaw}_degrees")?;
    }
    csv.push('\n');
    for row in all {
        write!(
            csv,
            "\"{}\",{},{},{},{}",
            row.head, row.triangles, row.views, row.document, row.pictures
        )?;
        for levels in &row.rmse_levels {
            write!(csv, ",{levels:.3}")?;
        }
        csv.push('\n');
    }
    Ok(csv)
}
