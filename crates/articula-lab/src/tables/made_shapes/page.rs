//! The page: the targets, and a table for each head.

use super::heads::Head;
use super::measured::Row;
use crate::tables::targets::{Target, section};
use std::fmt::Write as _;

/// Greatest opening that a blink may leave, and contour error of the shapes of the lips, mm.
const GAP: f64 = 0.3;
const CONTOUR: f64 = 2.0;
const LIPS: [&str; 5] = [
    "jawOpen",
    "mouthSmileLeft",
    "mouthSmileRight",
    "mouthPucker",
    "mouthFunnel",
];

pub(super) fn page(heads: &[(Head, Vec<Row>)]) -> String {
    let mut page = "# Made blend shapes\n\nBy `articula-lab made-shapes`: the morph targets of heads are taken away and blend shapes are \
                    made by `add_face_shapes` (`convert --face-shapes`, [faces](../methods/faces.md)); then both are compared \
                    at equal amplitude, the largest displacement of a vertex that is seen from outside; eyeballs that the own shape leaves at rest do not count, as ICT-FaceKit turns them by other means. `mouthClose` is looked at together with `jawOpen`, as it is meant: alone it takes the lips through each other. The motions of the lower face are those of other heads: \
                    those of MakeHuman are made by ICT-FaceKit, those of ICT-FaceKit by MakeHuman, all others by both, as the program has them. Lengths in millimetres of the \
                    head in its real size. \
                    Errors are over the seen vertices that either shape moves by more than 5 % of the largest displacement: mean and \
                    95th percentile. Contours of lips (inner and outer) and lids (both rims) are chains of vertices; their error is the \
                    mean distance from the one contour to the other, both ways. The gap is the tallest place between the lids at which, seen \
                    from the front, an eyeball is before the lids (the skin, and sheets on the ball that are parts of their own) or, without eyeballs, what is seen inside of the socket at rest is seen still, by the own / the made shape. Flips are triangles that face another way than at rest and than the triangles around them, crossings are pairs of the skin's \
                    triangles that go through each other and do not at rest: by the own shape / by the made one and not the own. \
                    – is what the head does not have.\n"
        .to_owned();
    page.push_str(&section("", &["head", "quantity"], &targets(heads)));
    for (head, rows) in heads {
        let _ = write!(page, "\n## {}\n\n", head.name);
        match &head.made {
            Err(why) => {
                let _ = writeln!(page, "No shapes are made: {why}");
            }
            Ok(_) => page.push_str(&table(rows)),
        }
        for refused in head.refused.chunk_by(|a, b| a.why == b.why) {
            let names: Vec<&str> = refused.iter().map(|r| r.shape).collect();
            let _ = writeln!(
                page,
                "\nNot made: {}: {}.",
                names.join(", "),
                refused[0].why
            );
        }
    }
    page
}

fn targets(heads: &[(Head, Vec<Row>)]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (head, rows) in heads {
        let worst = |of: &dyn Fn(&Row) -> Option<f32>| {
            let all = rows.iter().filter_map(of);
            all.reduce(f32::max).map(f64::from)
        };
        let gap = worst(&|r| r.gaps?[1]);
        targets.extend(gap.map(|gap| {
            Target::at_most(
                [head.name, "largest gap that a made blink leaves, mm"],
                GAP,
                gap,
            )
        }));
        for shape in LIPS {
            let contour = worst(&|r| r.lips.filter(|_| r.shape == shape));
            let what = format!("{shape}: contour of the lips, mm");
            targets
                .extend(contour.map(|found| Target::at_most([head.name, &what], CONTOUR, found)));
        }
        if head.made.is_ok() {
            let sum = |of: fn(&Row) -> usize| rows.iter().map(of).sum::<usize>() as f64;
            targets.extend([
                Target::at_most([head.name, "flips, all shapes"], 0.0, sum(|r| r.flips[1])),
                Target::at_most(
                    [head.name, "crossings, all shapes"],
                    0.0,
                    sum(|r| r.crossings[1]),
                ),
            ]);
        }
    }
    targets
}

fn table(rows: &[Row]) -> String {
    let mut text = "| shape | own | made | error | 95 % | lips | lids | gap | flips | crossings |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n".to_owned();
    for row in rows {
        let _ = writeln!(text, "| {} |", cells(row, "–", " / ").join(" | "));
    }
    text
}

/// The cells of a row, with what stands for a missing value and between two values.
fn cells(row: &Row, none: &str, between: &str) -> Vec<String> {
    let mm = |value: Option<f32>, digits: usize| {
        value.map_or(none.to_owned(), |v| format!("{v:.digits$}"))
    };
    let [gap_own, gap_made] = row.gaps.unwrap_or_default();
    let gap = match row.gaps {
        Some(_) => [mm(gap_own, 1), mm(gap_made, 1)].join(between),
        None => String::new(),
    };
    let pair = |[own, made]: [usize; 2]| format!("{own}{between}{made}");
    vec![
        row.shape.to_owned(),
        mm(row.own, 1),
        mm(Some(row.made), 1),
        mm(row.errors.map(|e| e[0]), 2),
        mm(row.errors.map(|e| e[1]), 2),
        mm(row.lips, 2),
        mm(row.lids, 2),
        gap,
        pair(row.flips),
        pair(row.crossings),
    ]
}

pub(super) fn csv(heads: &[(Head, Vec<Row>)]) -> String {
    let mut csv = "head,shape,own_mm,made_mm,error_mm,error_p95_mm,lips_mm,lids_mm,gap_own_made_mm,flips_own_made,crossings_own_made\n".to_owned();
    for (head, rows) in heads {
        for row in rows {
            let name = head.name.replace(',', "");
            let _ = writeln!(csv, "{name},{}", cells(row, "", " ").join(","));
        }
    }
    csv
}
