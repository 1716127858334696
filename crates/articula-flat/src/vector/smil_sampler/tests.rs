//! Tests of reading animated SVG files.

use super::*;
use articula_mutate::{Edit, Mutations};

const HEAD: &str = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 40 40">"#;

fn file(body: &str) -> String {
    format!("{HEAD}{body}</svg>")
}

fn animate(rest: &str) -> String {
    file(&format!(
        r#"<path d="m1 1 2 2 3 0"><animate attributeName="d" dur="2s" repeatCount="indefinite" {rest}/></path>"#
    ))
}

fn moved(rest: &str) -> String {
    file(&format!(
        r#"<g transform="scale(9)"><animateTransform attributeName="transform" dur="2s" repeatCount="indefinite" {rest}/></g>"#
    ))
}

#[test]
fn transforms_are_added_in_sequence() {
    let second = r#"<animateTransform attributeName="transform" type="rotate" additive="sum" dur="2" repeatCount="indefinite" values="90;0"/>"#;
    let text =
        moved(r#"type="translate" values="0 0;8-4""#).replace("</g>", &format!("{second}</g>"));
    let svg = AnimatedSvg::read(&text).unwrap();
    assert_eq!(
        svg.at(0.5).unwrap(),
        file(r#"<g transform="translate(2-1)rotate(67.5)"/>"#)
    );
}

#[test]
fn moments_by_hand() {
    let text = animate(r#"values="m0 0l8 0-8 8z;m4-4l8 0-8 8z;m4 0l8 0-8 8z" keyTimes="0;.5;1""#);
    let svg = AnimatedSvg::read(&text).unwrap();
    assert_eq!(svg.duration_secs, 2.0);
    let path = |secs| {
        let still = svg.at(secs).unwrap();
        assert!(
            still.starts_with(HEAD) && still.ends_with("</svg>"),
            "{still}"
        );
        still[HEAD.len()..still.len() - 6].to_owned()
    };
    assert_eq!(path(0.0), r#"<path d="m0 0l8 0-8 8z"/>"#);
    assert_eq!(path(0.25), r#"<path d="m1-1l8 0-8 8z"/>"#);
    assert_eq!(path(1.0), r#"<path d="m4-4l8 0-8 8z"/>"#);
    assert_eq!(path(1.5), r#"<path d="m4-2l8 0-8 8z"/>"#);
    // The end equals the beginning of the next repetition.
    assert_eq!(path(2.0), path(0.0));
    assert_eq!(path(4.25), path(0.25));
    assert!(svg.at(-1.0).is_err() && svg.at(f64::NAN).is_err());
}

#[test]
fn colours_are_mixed_by_channel() {
    let of = |values: &str| {
        let animate = format!(
            r#"<animate attributeName="fill" dur="2s" repeatCount="indefinite" values="{values}"/>"#
        );
        AnimatedSvg::read(&file(&format!(r#"<path d="m1 1">{animate}</path>"#)))
    };
    let svg = of("#f00;#0a0B0c").unwrap();
    let fill = |secs| {
        svg.at(secs)
            .unwrap()
            .split('"')
            .nth_back(1)
            .unwrap()
            .to_owned()
    };
    assert_eq!([fill(0.0), fill(1.0)], ["#f00", "#850606"]);
    for wrong in [
        "red;#000",
        "#00;#000",
        "#+1f;#000",
        "#0000;#000",
        "#äb;#000",
    ] {
        assert!(of(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn of_two_keys_at_one_time_the_later_holds_from_then_on() {
    let text = animate(r#"values="m0 0;m8 0;m0 9;m0 0" keyTimes="0;.5;.5;1""#);
    let svg = AnimatedSvg::read(&text).unwrap();
    assert!(svg.at(0.999).unwrap().contains(r#"d="m7.992 0""#));
    assert!(svg.at(1.0).unwrap().contains(r#"d="m0 9""#));
}

#[test]
fn held_values_and_names_come_through() {
    let text = file(
        r#"<title>a &amp; "b"</title><g display="none"><animate attributeName="display" dur="1" repeatCount="indefinite" calcMode="discrete" values="none;inline" keyTimes="0;.5"/><path fill="url(#1)" d="m0 0 1 0 0 1"/></g>"#,
    );
    let svg = AnimatedSvg::read(&text).unwrap();
    assert_eq!(
        svg.at(0.4).unwrap(),
        file(
            r#"<title>a &amp; &quot;b&quot;</title><g display="none"><path fill="url(#1)" d="m0 0 1 0 0 1"/></g>"#
        )
    );
    assert!(svg.at(0.5).unwrap().contains(r#"<g display="inline">"#));
}

#[test]
fn what_is_not_ours_is_refused_by_name() {
    let bad = [
        ("", "XML"),
        ("<svg/>", "element svg"),
        ("<a xmlns='http://www.w3.org/2000/svg'/>", "not <svg>"),
        (
            "<!DOCTYPE svg [<!ENTITY a 'aaaaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><svg>&b;</svg>",
            "XML",
        ),
        (&file("<script>alert(1)</script>"), "script"),
        (&file("<path onclick='f()'/>"), "onclick"),
        (&file("words"), "text"),
        (&file(&"<g>".repeat(40).to_string()), "XML"),
        (
            &file(&format!("{}{}", "<g>".repeat(40), "</g>".repeat(40))),
            "nesting",
        ),
        (&animate(r#"values="""#), "values"),
        (&animate(r#"values="m0 0;m0 0 1 1""#), "different"),
        (&animate(r#"values="m0 0 1""#), "values"),
        (&animate(r#"values="0 0""#), "values"),
        (&animate(r#"values="m0 0a1 1 0 0 0 1 1""#), "values"),
        (&animate(r#"values="m1e9 0""#), "values"),
        (&animate(r#"values="m0 é""#), "values"),
        (&animate(r#"values="m0 0;m1 1" keyTimes="0""#), "keyTimes"),
        (
            &animate(r#"values="m0 0;m1 1" keyTimes="0;.5""#),
            "keyTimes",
        ),
        (
            &animate(r#"values="m0 0;m1 1;m1 1" keyTimes="0;2;1""#),
            "keyTimes",
        ),
        (
            &animate(r#"values="m0 0;m1 1;m1 1" keyTimes="0;NaN;1""#),
            "keyTimes",
        ),
        (&animate(r#"values="m0 0" begin="1s""#), "begin"),
        (&animate(r#"values="m0 0" calcMode="spline""#), "spline"),
        (&animate(r#"values="m0 0" additive="sum""#), "additive"),
        (&moved(r#"type="matrix" values="1""#), "another type"),
        (&moved(r#"values="1""#), "another type"),
        (&moved(r#"type="rotate" values="1 2 3""#), "values"),
        (&moved(r#"type="rotate" values="1 2;3 4""#), "values"),
        (
            &moved(r#"type="scale" values="1;2" additive="sum""#),
            "first",
        ),
        (&moved(r#"type="scale" values="1;1 2""#), "different"),
        (
            &moved(r#"type="scale" values="1;2" additive="much""#),
            "additive",
        ),
        (
            &moved(r#"type="scale" values="1;2" calcMode="discrete""#),
            "discrete",
        ),
    ];
    for (text, word) in bad {
        let error = AnimatedSvg::read(text).unwrap_err().to_string();
        assert!(error.contains(word), "{text}: {error}");
    }
    for dur in ["0", "-1", "nan", "", "1h"] {
        let text = animate(r#"values="m0 0""#).replace("2s", dur);
        assert!(AnimatedSvg::read(&text).is_err(), "{dur}");
    }
}

#[test]
fn mutated_files_never_panic() {
    let text = animate(r#"values="m0 0l8 0-8 8z;m4-4l8 0-8 8z;m4 0l8 0-8 8z" keyTimes="0;.5;1""#);
    let text = text.replace(
        "</svg>",
        r##"<linearGradient id="1" href="#0" x2="9"><animate attributeName="x1" dur="2" repeatCount="indefinite" values="1;-2.5"/></linearGradient></svg>"##,
    );
    const SPARE: &[u8] = b"<>/\"'&;=. -0123456789mlz\xe9d!";
    let mutations = Mutations {
        edits: &[
            Edit::SetOf(SPARE),
            Edit::RemoveByte,
            Edit::InsertOf(SPARE),
            Edit::TruncateEnd,
        ],
        most: 3,
    };
    let read = mutations.read_of(text.as_bytes(), 20_000, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        let Ok(svg) = AnimatedSvg::read(&text) else {
            return false;
        };
        for secs in [0.0, 0.3, 1e300] {
            // What was parsed can be sampled and parsed again.
            AnimatedSvg::read(&svg.at(secs).unwrap()).unwrap();
        }
        true
    });
    assert!(read > 100, "{read}");
}
