//! The page of the demo: plain HTML, readable in light and dark mode and on a phone.

use super::report::{DemoReport, MethodRows};
use articula::MeshLevelRow;
use articula::evaluate::MethodRow;
use articula::flat::escaped;
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
        face(report),
        adaptation(report),
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
            &format!("of joint updates saved {at}"),
            percent(ours.joint_update_gain),
        );
        numbers += &number(
            &format!("error of the skin {at} (p95)"),
            format!("{:.2} px", ours.error_px.p95),
        );
    }
    if let Some(thesis) = row("thesis") {
        numbers += &number(
            "saved by the metric of the thesis",
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
         <p class=\"lead\">Far away, most joints of a moving figure need no update in every \
         frame, because the difference is not visible. Articula chooses the joints to update by \
         one number: the error of the skin in pixels. This page was computed on your machine with \
         {} and its clip <em>{}</em>; every method was calibrated to an \
         error of at most {} pixel.</p>\n<dl class=\"numbers\">\n{numbers}</dl>\n</header>\n",
        escaped(&report.character.name),
        escaped(&report.clip),
        report.target_px
    )
}

fn character(report: &DemoReport) -> String {
    let character = &report.character;
    format!(
        "<section>\n<h2>The character</h2>\n\
         <p>{}: {} joints in skins, {} triangles, {} clips. <a href=\"asset.glb\">asset.glb</a> \
         ({:.0} kB) has its levels of articulation, motion tables and mesh levels, and opens in every \
         glTF viewer.</p>\n{}</section>\n",
        escaped(&character.name),
        character.joints,
        character.triangles,
        report.clips.len(),
        character.bytes as f64 / 1e3,
        picture(
            "character.png",
            "The character from the front, the side and the back, its face and a hand",
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
         <p>Our metric holds a joint while the skin that it moves is within a tolerance of its true \
         position; in metres, the tolerance grows with distance. \
         <span class=\"dot active\"></span>Green joints are updated in the frame shown, \
         <span class=\"dot passive\"></span>red rings are held, \
         <span class=\"dot between\"></span>amber ones are in transition.</p>\n{}{}</section>\n",
        picture(
            "distances.png",
            "The character at five distances and four times, unreduced and with held joints marked",
            "Left of each pair: the unreduced clip. Right: reduced. The small figure has its true size on a screen of 1280 x 720 pixels at a field of view of 45 degrees.",
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
         <p>Each method has one parameter, set as high as the error allows. The error is the \
         distance on the screen between the shown and the true skin: the 95th percentile over \
         frames of the 95th percentile over the skin, for the worst of three viewing directions.</p>\n\
         <dl class=\"methods\">\n{}</dl>\n<div class=\"plots\">\n{}{}</div>\n{}<p class=\"soft\">0 % means that the method meets the \
         error only by updating all joints.</p>\n{}{}</section>\n",
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
            "The character under every method, with held joints marked",
            &format!("Every method at {middle} m."),
        ),
        plot(
            "over-the-clip.svg",
            "Number of joints updated in each frame of the clip, one line for each method",
            "Savings vary over the clip: where the body turns fast, more joints are updated.",
        )
    )
}

/// One line about each method.
fn legend() -> String {
    let methods = [
        (
            "skin-px",
            "our metric: a joint is held until its skin drifts beyond the tolerance; four variants",
        ),
        (
            "thesis",
            "the metric of the thesis: a threshold on how far a joint rotates and moves per frame",
        ),
        (
            "ahn",
            "similar poses of a joint are replaced by one of them",
        ),
        (
            "pc",
            "the whole pose is held while it is near in the space of its principal components",
        ),
        (
            "skip-hold, skip-lerp",
            "only every n-th frame is sampled, then held or interpolated",
        ),
        (
            "loa",
            "a fixed set of joints moves, all others show one pose",
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
        ("cost-by-zone.svg", "Joints per frame by zone of the body"),
        (
            "cost-by-depth.svg",
            "Joints per frame by depth in the hierarchy",
        ),
        (
            "cost-by-complexity.svg",
            "Joints per frame by level of complexity",
        ),
    ];
    let plots = plots.map(|(file, alt)| plot(file, alt, "")).concat();
    format!(
        "<section>\n<h2>Levels of articulation</h2>\n\
         <p>A level of articulation is the set of joints that may move, regardless of the error. The \
         same levels apply at run time, in stored files and in streams, and combine with zones, \
         depths and single joints, as in <code>loa(Low) + zone(hands)</code>.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"Stored animation by level\">\n<table>\n\
         <caption><span>Stored animation of all clips at each level; held joints keep their key pose</span></caption>\n\
         <thead><tr><th scope=\"col\">level</th><th scope=\"col\">joints</th><th scope=\"col\">channels</th>\
         <th scope=\"col\">keys</th><th scope=\"col\">size</th><th scope=\"col\">saved</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>\n</div>\n<div class=\"plots\">\n{plots}</div>\n</section>\n",
        picture(
            "levels.png",
            "The character at seven levels of articulation, with moving joints marked",
            "From all joints to none; held joints show the pose with the smallest maximum angle to all frames.",
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
    let caption =
        "Mesh levels: maximum distance from the original surface, and bytes in the stream";
    let count = found.levels.len();
    let triangles = |level: Option<&MeshLevelRow>| level.map_or(0, |l| l.triangles) as f64;
    let finest = triangles(found.levels.first()).max(1.0);
    let percent = 100.0 * triangles(found.levels.last()) / finest;
    format!(
        "<section>\n<h2>Mesh levels simplified in motion</h2>\n\
         <p>One stored mesh, {count} levels: each is a few ranges of one index list over the first vertices of one \
         vertex list, so changing the level copies nothing. Triangles were removed where the error in poses of the \
         character's own clips is least; the errors were measured in {} other poses. All levels together take \
         {:.1} kB in the stream, the finest alone {:.1} kB, all levels each coded alone {:.1} kB. \
         <a href=\"asset.glb\">asset.glb</a> holds them all, and every viewer shows the finest.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">triangles</th>\
         <th scope=\"col\">vertices</th><th scope=\"col\">error at rest</th><th scope=\"col\">error in motion</th>\
         <th scope=\"col\">size alone</th><th scope=\"col\">size added</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n",
        found.poses_measured,
        found.bytes.clustered as f64 / 1e3,
        found.bytes.finest_alone as f64 / 1e3,
        found.bytes.discrete_sum as f64 / 1e3,
        picture(
            "mesh-levels.png",
            "The character, its face and a hand at every mesh level",
            &format!(
                "From all triangles to {percent:.1} % of them: whole figure in motion, face and left hand."
            ),
        )
    )
}

fn adaptation(report: &DemoReport) -> String {
    let found = &report.adaptation;
    let mut rows = String::new();
    for context in &found.contexts {
        let bandwidth = match context.bandwidth_kbps {
            Some(kbps) => format!("{kbps:.0} kbit/s"),
            None => "any".to_owned(),
        };
        let _ = writeln!(
            rows,
            "<tr><th scope=\"row\">{}</th><td>{bandwidth}</td><td>{} m</td><td>{}</td><td>{:.1} kB</td>\
             <td>{:.2} px</td><td>{}</td></tr>",
            escaped(context.name),
            context.distance_m,
            escaped(&context.modality),
            context.bytes as f64 / 1e3,
            context.error_px,
            escaped(&context.parts.join("; "))
        );
    }
    let caption = "What each context gets within two seconds of transfer";
    format!(
        "<section>\n<h2>One item, four contexts</h2>\n\
         <p>The character as a digital item of {:.1} kB: joints, mesh levels by region, the motion in levels of \
         articulation and tiers, textures at several sizes. Each context gets the combination with the least visible \
         error for its bytes, or no more than it can see; what cannot play it gets a form in 2D.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">context</th>\
         <th scope=\"col\">bandwidth</th><th scope=\"col\">distance</th><th scope=\"col\">form</th>\
         <th scope=\"col\">sent</th><th scope=\"col\">error, at most</th><th scope=\"col\">parts</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n",
        found.bytes as f64 / 1e3,
        picture(
            "adaptation.png",
            "The character as four contexts show it",
            "What is left of the character in each context, all drawn at the same size.",
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
        format!(" {ours:.2} % of its pixels are painted in the wrong order; with a depth sort, {sorted:.2} %.")
    });
    let caption = "The same clip in each format, compared with the form of the thesis";
    format!(
        "<section>\n<h2>The clip without 3D</h2>\n\
         <figure><img src=\"walk.svg\" width=\"360\" height=\"360\" alt=\"The character moves, as an animated SVG\">\
         <figcaption>One self-contained SVG in an &lt;img&gt;: no script, correct occlusion, one gradient per triangle.{wrong}\
         </figcaption></figure>\n\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">file</th>\
         <th scope=\"col\">format</th><th scope=\"col\">size</th><th scope=\"col\">size, brotli</th>\
         <th scope=\"col\">bytes per triangle and frame</th><th scope=\"col\">times smaller than the thesis</th>\
         <th scope=\"col\">RMS colour error, levels of 0 to 255</th><th scope=\"col\">SSIM</th></tr></thead>\n<tbody>\n{rows}</tbody>\n</table>\n</div>\n</section>\n",
    )
}

fn face(report: &DemoReport) -> String {
    let Some(face) = &report.face else {
        return String::new();
    };
    let mut rows = String::new();
    for row in &face.detail.rows {
        let _ = write!(rows, "<tr><th scope=\"row\">{} m</th>", row.distance_m);
        for px in &row.levels_px[1..] {
            let _ = write!(rows, "<td>{px:.2} px</td>");
        }
        let _ = writeln!(
            rows,
            "<td>{}</td><td>{:.2} px</td></tr>",
            row.chosen.len(),
            row.chosen_px
        );
    }
    let caption = "Error of the levels, and the fewest parameters within 1 px";
    format!(
        "<section>\n<h2>The face</h2>\n\
         <p>Facial animation parameters of MPEG-4 move {}. {} parameters move in this clip; far away, few of them \
         can be seen.</p>\n{}\
         <div class=\"table\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\">\n<table>\n\
         <caption><span>{caption}</span></caption>\n<thead><tr><th scope=\"col\">distance</th>\
         <th scope=\"col\">medium</th><th scope=\"col\">low</th><th scope=\"col\">very low</th>\
         <th scope=\"col\">parameters</th><th scope=\"col\">their error</th></tr></thead>\n\
         <tbody>\n{rows}</tbody>\n</table>\n</div>\n\
         <p class=\"soft\"><a href=\"face.glb\">face.glb</a> plays the clip.</p>\n</section>\n",
        face.driven_by,
        face.faps_moving,
        picture(
            "face.png",
            "The face at moments of a clip: a smile, an open mouth, closed eyes, raised and lowered brows",
            "Moments of a clip of facial animation parameters.",
        )
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
         <p>{} copies of the character on a square, {} of them in view. The farther away, the fewer joints are \
         computed: the others move with their parents, and the skin is bound to the remaining joints. Each \
         character has the coarsest level with an error of at most {} pixel. The error is measured for each \
         character against the full joint set at the same time (95th percentile over the skin).</p>\n{}{}{}</section>\n",
        crowd.characters,
        crowd.visible,
        crowd.epsilon_px,
        picture(
            "crowd.png",
            "A square full of people, each in the colour of its level",
            "Each character in the colour of its level; the legend has the number of characters per level.",
        ),
        table(
            "Time per frame and character on one thread, bytes written per frame, and error of the skin",
            head(&["variant", "time", "written", "error p95", "error max"]),
            &ways
        ),
        table(
            "The levels in use",
            head(&[
                "joints",
                "characters",
                "maximum error",
                "measured error p95"
            ]),
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
         not: sampling and all matrices of one figure took {full:.0} ns per frame with all joints and \
         {none:.0} ns with none, measured in this run with the scalar code. So holding joints saves \
         samples but little time by itself; levels are therefore also merged and poses cached.</p>\n</section>\n"
    )
}

fn footer(report: &DemoReport) -> String {
    format!(
        "<footer>\n<p>Articula {}. All numbers: <a href=\"report.json\">report.json</a>.</p>\n</footer>\n",
        escaped(report.version)
    )
}

/// A table of updates saved by distance, one line for each name.
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

/// A large picture that scrolls horizontally in narrow windows.
fn picture(file: &str, alt: &str, caption: &str) -> String {
    let alt = escaped(alt);
    format!(
        "<figure>\n<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{alt}\">\
         <a href=\"{file}\"><img src=\"{file}\" alt=\"{alt}\" loading=\"lazy\"></a></div>\n\
         <figcaption>{}</figcaption>\n</figure>\n",
        escaped(caption)
    )
}

/// A plot; its own title describes it, `caption` explains it.
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
