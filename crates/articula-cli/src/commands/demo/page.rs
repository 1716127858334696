//! The page of the demo: plain HTML beside its files, readable in light, dark and on a phone.

use super::report::{DemoReport, MethodRows};
use articula::evaluate::MethodRow;
use articula_flat::escaped;
use std::fmt::Write;

const STYLE: &str = include_str!("page.css");

/// The whole page. Every number in it is one of the report.
pub(super) fn of(report: &DemoReport) -> String {
    let sections = [
        header(report),
        "<main>\n".into(),
        character(report),
        distances(report),
        methods(report),
        levels(report),
        mesh_levels(report),
        flat(report),
        crowd(report),
        more(report),
        "</main>\n".into(),
    ];
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>Articula: a virtual human at the detail you can see</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n{}{}</body>\n</html>\n",
        sections.concat(),
        footer(report)
    )
}

fn header(report: &DemoReport) -> String {
    let row = |label: &str| report.middle(label);
    let number =
        |name: &str, value: String| format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n");
    let mut numbers = String::new();
    if let Some(ours) = row("skin-px hold") {
        let at = format!("at {} m", ours.distance_m);
        numbers += &number(
            &format!("of the joint updates saved {at}"),
            percent(ours.joint_update_gain),
        );
        numbers += &number(
            &format!("how far the skin is then off, {at} (p95)"),
            format!("{:.2} px", ours.error_px.p95),
        );
    }
    if let Some(thesis) = row("thesis") {
        numbers += &number(
            "saved there by the thesis metric, which Articula grew from",
            percent(thesis.joint_update_gain),
        );
    }
    if let Some(level) = report.levels.iter().find(|l| l.name == "Low") {
        numbers += &number(
            "of the stored animation saved at level Low",
            percent(level.saved as f32),
        );
    }
    format!(
        "<header>\n<h1>A virtual human at the detail you can see</h1>\n\
         <p class=\"lead\">Far away, most joints of a moving figure need not be updated in every \
         frame: nobody can see the difference. Articula decides which, by one number: how many \
         pixels the skin is off. This page was just computed on your machine with the embedded \
         reference human and its clip <em>{}</em>; every method was tuned to err by at most \
         {} pixel.</p>\n<dl class=\"numbers\">\n{numbers}</dl>\n</header>\n",
        escaped(&report.clip),
        report.target_px
    )
}

fn character(report: &DemoReport) -> String {
    let human = &report.human;
    format!(
        "<section>\n<h2>The reference human</h2>\n\
         <p>{} joints of the H-Anim standard, {} triangles, {} clips, {:.0} kB, made from \
         formulas alone: <a href=\"human.glb\">human.glb</a> opens in every glTF viewer, and so does \
         <a href=\"asset.glb\">asset.glb</a>, the same with its levels of articulation and motion tables.</p>\n{}</section>\n",
        human.joints,
        human.triangles,
        report.clips.len(),
        human.bytes as f64 / 1e3,
        picture(
            "character.png",
            "The reference human from the front, the side and the back, its face and a hand",
            "The rest pose, its face and its left hand.",
        )
    )
}

fn distances(report: &DemoReport) -> String {
    let limit = report.target_px;
    let clips: Vec<(&str, &[MethodRow])> = report
        .clips
        .iter()
        .map(|c| (c.clip.as_str(), c.rows.as_slice()))
        .collect();
    format!(
        "<section>\n<h2>Motion under level of detail</h2>\n\
         <p>Our metric holds a joint as long as the skin that hangs on it drifts by less than the \
         tolerance from where it should be, and the tolerance grows with distance. \
         <span class=\"dot active\"></span>green joints are updated in the frame shown, \
         <span class=\"dot passive\"></span>red rings are held, \
         <span class=\"dot between\"></span>amber ones are in transition.</p>\n{}{}</section>\n",
        picture(
            "distances.png",
            "The walking human at five distances and four moments, as it is and with held joints marked",
            "Left of each pair: the clip as it is. Right: what is shown. The small figure has its true size on a screen of 1280 x 720 pixels at 45 degrees.",
        ),
        table(
            &format!(
                "Joint updates saved by our metric (hold) on each clip, at most {limit} px of p95 error"
            ),
            "clip",
            &clips,
        )
    )
}

fn methods(report: &DemoReport) -> String {
    let rows: Vec<(&str, &[MethodRow])> = report
        .methods
        .iter()
        .map(|m: &MethodRows| (m.label.as_str(), m.rows.as_slice()))
        .collect();
    let middle = report.middle("skin-px hold").map_or(0.0, |r| r.distance_m);
    format!(
        "<section>\n<h2>Every method at the same error</h2>\n\
         <p>Calibrate, then compare: each method has one parameter; it is set as high as the error \
         allows. Error is the distance on the screen between the shown and the true skin: the 95th \
         percentile over frames of the 95th over the skin, from the worst of three sides.</p>\n\
         <dl class=\"methods\">\n{}</dl>\n<div class=\"plots\">\n{}{}</div>\n{}<p class=\"soft\">0 % means: the method meets the \
         error only by updating every joint.</p>\n{}{}</section>\n",
        legend(),
        plot(
            "gain.svg",
            "Joint updates saved over distance, one line for each method",
            ""
        ),
        plot(
            "error.svg",
            "Error in pixels over distance, one line for each method",
            ""
        ),
        table(
            &format!(
                "Joint updates saved on clip {}, of {} moving joints",
                report.clip, report.joints_moving
            ),
            "method",
            &rows,
        ),
        picture(
            "methods.png",
            "The walking human under every method, with held joints marked",
            &format!("Every method at {middle} m."),
        ),
        plot(
            "over-the-clip.svg",
            "Number of joints updated in each frame of the clip, one line for each method",
            "Savings are not spread evenly: where the body turns fast, more joints must follow.",
        )
    )
}

/// What each method does, in one line.
fn legend() -> String {
    let methods = [
        (
            "skin-px",
            "ours: a joint waits until its skin drifts too far; four forms of it",
        ),
        (
            "thesis",
            "the metric that Articula grew from: a threshold on how much a joint turns and moves",
        ),
        ("ahn", "similar poses of a joint are shown as one"),
        (
            "skip-hold, skip-lerp",
            "every n-th frame alone; held, or blended between",
        ),
        (
            "loa",
            "a fixed set of joints moves, the others show one pose",
        ),
    ];
    let line = |(name, what)| format!("<div><dt>{name}</dt><dd>{what}</dd></div>\n");
    methods.map(line).concat()
}

fn levels(report: &DemoReport) -> String {
    let mut rows = String::new();
    for level in &report.levels {
        let _ = writeln!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{:.1} kB</td><td>{}</td></tr>",
            level.name,
            level.joints,
            level.stored.channels,
            level.stored.keys,
            level.stored.animation_bytes as f64 / 1e3,
            percent(level.saved as f32)
        );
    }
    let plots = [
        ("cost-by-zone.svg", "Joints a frame by zone of the body"),
        (
            "cost-by-depth.svg",
            "Joints a frame by depth in the hierarchy",
        ),
        (
            "cost-by-complexity.svg",
            "Joints a frame by level of complexity",
        ),
    ];
    let plots = plots.map(|(file, alt)| plot(file, alt, "")).concat();
    format!(
        "<section>\n<h2>Levels of articulation</h2>\n\
         <p>A level says which joints may move at all, whatever the error. The same scale serves \
         the run time, stored files and streams; zones, depths and single joints combine with it, \
         as in <code>loa(Low) + zone(hands)</code>.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"Stored animation by level\">\n<table>\n\
         <caption><span>The stored animation of all clips under each level; held joints keep their key pose</span></caption>\n\
         <thead><tr><th scope=\"col\">level</th><th scope=\"col\">joints</th><th scope=\"col\">channels</th>\
         <th scope=\"col\">keys</th><th scope=\"col\">size</th><th scope=\"col\">saved</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>\n</div>\n<div class=\"plots\">\n{plots}</div>\n</section>\n",
        picture(
            "levels.png",
            "The walking human at seven levels of articulation, moving joints marked",
            "From every joint to none; held joints show the pose that is nearest to all frames.",
        )
    )
}

fn mesh_levels(report: &DemoReport) -> String {
    let found = &report.mesh_levels;
    let mut rows = String::new();
    for level in &found.levels {
        let mm = |metres: Option<f32>| metres.map_or("-".into(), |m| format!("{:.1} mm", 1e3 * m));
        let _ = writeln!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{:.1} kB</td><td>{:.1} kB</td></tr>",
            level.triangles,
            level.vertices,
            mm(level.error_rest_m),
            mm(level.error_motion_m),
            level.bytes_direct as f64 / 1e3,
            level.bytes_added as f64 / 1e3
        );
    }
    let caption = "The levels: greatest distance of the original surface, and bytes on the wire";
    format!(
        "<section>\n<h2>Mesh levels that know how they will move</h2>\n\
         <p>One stored mesh, five levels: each is a few ranges of one index list over the first vertices of one \
         vertex list, so changing the level copies nothing. Triangles went where the figure loses least in \
         the poses of its own clips; the errors are those in {} other poses. All five levels together take \
         {:.1} kB on the wire, the finest alone {:.1} kB, each sent on its own {:.1} kB. \
         <a href=\"asset.glb\">asset.glb</a> holds them all, and every viewer shows the finest.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">triangles</th>\
         <th scope=\"col\">vertices</th><th scope=\"col\">off at rest</th><th scope=\"col\">in motion</th>\
         <th scope=\"col\">alone</th><th scope=\"col\">added</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n",
        found.poses_measured,
        found.bytes.clustered as f64 / 1e3,
        found.bytes.finest_alone as f64 / 1e3,
        found.bytes.discrete_sum as f64 / 1e3,
        picture(
            "mesh-levels.png",
            "The walking human, its face and a hand at five mesh levels",
            "From all triangles to 1.5 % of them: in motion, the face and the left hand.",
        )
    )
}

fn flat(report: &DemoReport) -> String {
    let naive = report.flat.first().map_or(0, |r| r.bytes.raw);
    let mut rows = String::new();
    for flat in &report.flat {
        let file = escaped(&flat.out);
        let shading = flat.settings.shading;
        let _ = writeln!(
            rows,
            "<tr><th scope=\"row\"><a href=\"{file}\">{file}</a></th><td>{}, {shading}</td><td>{:.1} kB</td>\
             <td>{:.1} kB</td><td>{:.2}</td><td>{:.1}</td><td>{:.1}</td><td>{:.4}</td></tr>",
            flat.profile,
            flat.bytes.raw as f64 / 1e3,
            flat.bytes.brotli as f64 / 1e3,
            flat.bytes_per_triangle_and_frame.raw,
            naive as f64 / flat.bytes.raw.max(1) as f64,
            flat.error.image_rmse_levels,
            flat.error.ssim,
        );
    }
    let wrong = report.flat.get(1).map_or(String::new(), |r| {
        let (ours, sorted) = (
            r.error.wrong_pixels_percent,
            r.error.wrong_pixels_percent_depth_sort,
        );
        format!(" Painted in a wrong order are {ours:.2} % of its pixels, sorted by depth {sorted:.2} %.")
    });
    let caption = "The same walk in each form, beside the thesis' own";
    format!(
        "<section>\n<h2>The walk without 3D</h2>\n\
         <figure><img src=\"walk.svg\" width=\"360\" height=\"360\" alt=\"The human walks, as an animated SVG\">\
         <figcaption>One self-contained SVG in an &lt;img&gt;: no script, right occlusion, one gradient a triangle.{wrong}\
         </figcaption></figure>\n\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">file</th>\
         <th scope=\"col\">form</th><th scope=\"col\">size</th><th scope=\"col\">by brotli</th>\
         <th scope=\"col\">bytes a triangle and frame</th><th scope=\"col\">times smaller</th>\
         <th scope=\"col\">levels off</th><th scope=\"col\">SSIM</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n",
    )
}

fn crowd(report: &DemoReport) -> String {
    let crowd = &report.crowd;
    let mut ways = String::new();
    for way in &crowd.ways {
        let _ = writeln!(
            ways,
            "<tr><th scope=\"row\">{}</th><td>{:.0} ns</td><td>{:.2} MB</td><td>{:.2} px</td><td>{:.2} px</td></tr>",
            escaped(way.label),
            way.ns_per_character,
            way.written_mb,
            way.error_px_p95,
            way.error_px_max
        );
    }
    let mut levels = String::new();
    for level in &crowd.levels {
        let measured = level.error_px.map_or(0.0, |e| e.p95);
        let _ = writeln!(
            levels,
            "<tr><th scope=\"row\">{}</th><td>{:.0}</td><td>{:.1} mm</td><td>{measured:.2} px</td></tr>",
            level.joints, level.characters, level.error_mm
        );
    }
    let head = |names: &[&str]| -> String {
        let cell = |n: &&str| format!("<th scope=\"col\">{n}</th>");
        names.iter().map(cell).collect()
    };
    let table = |caption: &str, head: String, rows: &str| {
        format!(
            "<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
             <caption><span>{caption}</span></caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n"
        )
    };
    format!(
        "<section>\n<h2>A crowd</h2>\n\
         <p>{} of the same human on a square, {} of them in view. The farther away, the fewer joints are \
         computed: the others move with their parents, and the skin is put onto what is left. Each gets the \
         coarsest level whose skin is off by at most {} pixel. The error is measured against every joint \
         of the same moment, character by character (95th percentile over the skin).</p>\n{}{}{}</section>\n",
        crowd.characters,
        crowd.visible,
        crowd.epsilon_px,
        picture(
            "crowd.png",
            "A square full of people, each in the colour of the level that it is shown at",
            "Everyone in the colour of the level; the corner counts them.",
        ),
        table(
            "What a frame costs for each character on one thread, what it writes, and how far the skin is off",
            head(&["way", "time", "written", "p95", "max"]),
            &ways
        ),
        table(
            "The levels that are shown",
            head(&["joints", "characters", "off at most", "measured p95"]),
            &levels
        )
    )
}

fn more(report: &DemoReport) -> String {
    let fastest = report
        .costs
        .complexities
        .iter()
        .map(|c| c.measured_ns_per_frame);
    let full = report
        .costs
        .complexities
        .last()
        .map_or(0.0, |c| c.measured_ns_per_frame);
    let none = fastest.fold(f64::INFINITY, f64::min);
    format!(
        "<section>\n<h2>On your own character</h2>\n<pre><code>articula inspect hero.glb\n\
         articula lod hero.glb --calibrate 1 --method all --contact-sheet sheet.png --plot plots/\n\
         articula crowd hero.glb --picture crowd.png\n\
         articula convert hero.glb small.glb --loa \"loa(Low) + zone(hands)\"</code></pre>\n\
         <p class=\"soft\">Counts on this page are exact and the same on every machine. Times are \
         not: sampling and all matrices of one figure took {full:.0} ns a frame with every joint and \
         {none:.0} ns with none, by the clock of this run and the plain code. So holding joints saves \
         samples, but by itself little time: that is why levels are also merged and shared.</p>\n</section>\n"
    )
}

fn footer(report: &DemoReport) -> String {
    format!(
        "<footer>\n<p>Articula {}. All numbers: <a href=\"report.json\">report.json</a>.</p>\n</footer>\n",
        escaped(report.version)
    )
}

/// Gain by distance, one line for each name.
fn table(caption: &str, what: &str, lines: &[(&str, &[MethodRow])]) -> String {
    let mut head = format!("<th scope=\"col\">{what}</th>");
    for row in lines.first().map_or(&[][..], |l| l.1) {
        let _ = write!(head, "<th scope=\"col\">{} m</th>", row.distance_m);
    }
    let mut body = String::new();
    for (name, rows) in lines {
        let _ = write!(body, "<tr><th scope=\"row\">{}</th>", escaped(name));
        for row in *rows {
            let missed = row.meets_target == Some(false);
            let class = if missed { " class=\"missed\"" } else { "" };
            let mark = if missed { " (misses)" } else { "" };
            let _ = write!(
                body,
                "<td{class} title=\"p95 error {:.2} px\">{}{mark}</td>",
                row.error_px.p95,
                percent(row.joint_update_gain)
            );
        }
        body.push_str("</tr>\n");
    }
    let label = escaped(caption);
    format!(
        "<div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\">\n<table>\n\
         <caption><span>{label}</span></caption>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody>\n</table>\n</div>\n"
    )
}

/// A large picture that scrolls sideways where the window is narrow.
fn picture(file: &str, alt: &str, caption: &str) -> String {
    let alt = escaped(alt);
    format!(
        "<figure>\n<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{alt}\">\
         <a href=\"{file}\"><img src=\"{file}\" alt=\"{alt}\" loading=\"lazy\"></a></div>\n\
         <figcaption>{}</figcaption>\n</figure>\n",
        escaped(caption)
    )
}

/// A plot; its own title says what it shows, `caption` what to see in it.
fn plot(file: &str, alt: &str, caption: &str) -> String {
    let alt = escaped(alt);
    let caption = if caption.is_empty() {
        String::new()
    } else {
        format!("\n<figcaption>{}</figcaption>", escaped(caption))
    };
    format!(
        "<figure>\n<div class=\"wide small\" tabindex=\"0\" role=\"region\" \
         aria-label=\"{alt}\"><a href=\"{file}\"><img src=\"{file}\" alt=\"{alt}\"></a></div>{caption}\n</figure>\n"
    )
}

fn percent(share: f32) -> String {
    format!("{:.1} %", 100.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_from_files_cannot_become_markup() {
        assert_eq!(escaped("<b a=\"1\">&"), "&lt;b a=&quot;1&quot;&gt;&amp;");
        assert!(table("a<b", "x", &[]).contains("a&lt;b"));
    }
}
