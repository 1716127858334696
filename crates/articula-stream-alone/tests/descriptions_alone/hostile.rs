//! Documents made to harm: one clear error, soon, whatever reads them.

use crate::annex_b;
use crate::tools::LIMITS;
use articula_mutate::{Edit, Mutations, cut_off};
use articula_stream::DescriptionLimits;
use articula_stream::description::{
    AdaptMode, Aqos, Benchmark, Constraints, Context, Did, Holes, Selection, adapt_gbsd,
    gbsd_to_bin, read_gbsd, write_gbsd,
};

/// Limits that the long documents below exceed by far.
const FEW_NODES: DescriptionLimits = DescriptionLimits {
    bytes: 1 << 24,
    nodes: 1 << 12,
};

/// Every reader of XML: whether it accepts, or what it says.
fn readers(bytes: &[u8], limits: &DescriptionLimits) -> Vec<Result<(), String>> {
    let text = |e: articula_stream::StreamError| e.to_string();
    let selection = Selection::of_loa(1);
    let stream = [0x55; 4961];
    let literal = AdaptMode::AnnexBLiteral;
    vec![
        read_gbsd(bytes, limits).map(drop).map_err(text),
        gbsd_to_bin(bytes, &stream, Holes::Skip, limits)
            .map(drop)
            .map_err(text),
        adapt_gbsd(bytes, &selection, AdaptMode::Conformant, limits)
            .map(drop)
            .map_err(text),
        adapt_gbsd(bytes, &selection, literal, limits)
            .map(drop)
            .map_err(text),
        Did::read(bytes, limits).map(drop).map_err(text),
        Aqos::read(bytes, limits).map(drop).map_err(text),
        Constraints::read(bytes, limits).map(drop).map_err(text),
        Context::read_xdi(bytes, limits).map(drop).map_err(text),
    ]
}

#[test]
fn hostile_documents_are_refused_soon_in_one_line() {
    let nested = (0..60).fold(
        String::from("<!DOCTYPE a [<!ENTITY e0 \"x\">"),
        |text, i| {
            format!(
                "{text}<!ENTITY e{} \"{}\">",
                i + 1,
                format!("&e{i};").repeat(9)
            )
        },
    );
    let wide: String = (0..100_000).map(|i| format!(" a{i}=\"\"")).collect();
    let scopes: String = (0..60)
        .map(|i| format!("<a xmlns:p{i}=\"x\" xmlns:q{i}=\"y\">"))
        .collect();
    let documents: Vec<(&str, Vec<u8>)> = vec![
        ("nested entities", format!("{nested}]><a>&e60;</a>").into()),
        (
            "an external entity",
            "<!DOCTYPE a [<!ENTITY x SYSTEM \"file:///etc/passwd\">]><a>&x;</a>".into(),
        ),
        (
            "an external subset",
            "<!DOCTYPE a SYSTEM \"http://host/a.dtd\"><a/>".into(),
        ),
        ("an entity in an attribute", "<a b=\"&x;\"/>".into()),
        ("deep elements", "<a>".repeat(1 << 20).into()),
        ("many attributes", format!("<a{wide}/>").into()),
        ("many namespaces", scopes.into()),
        (
            "a huge attribute",
            [b"<a b=\"", "x".repeat(1 << 22).as_bytes()].concat(),
        ),
        (
            "a huge comment",
            [b"<a><!--", "-".repeat(1 << 22).as_bytes()].concat(),
        ),
        (
            "a truncated document",
            "<DIA><Description><gBSDUnit start=\"0\"".into(),
        ),
        (
            "UTF-16",
            "<a/>".encode_utf16().flat_map(u16::to_le_bytes).collect(),
        ),
        (
            "another encoding",
            "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><a/>".into(),
        ),
        ("no UTF-8", b"<a b=\"\xc3\x28\"/>".to_vec()),
        ("nothing", Vec::new()),
        ("no XML", vec![0; 1000]),
        ("many elements", "<a/>".repeat(1 << 20).into()),
        (
            "many elements in one",
            ["<a>", &"<b/>".repeat(1 << 19)].concat().into(),
        ),
    ];
    for (what, bytes) in documents {
        let used = allocation_counter::measure(|| {
            for result in readers(&bytes, &FEW_NODES) {
                let said = result.expect_err(what);
                assert!(
                    said.lines().count() == 1 && said.len() < 400,
                    "{what}: {said}"
                );
            }
        });
        // The cost follows the limit, not the document: eight readers, and the names and values of an
        // element in buffers that grow.
        let most = 8 * FEW_NODES.nodes * 512;
        assert!(
            used.bytes_total <= most,
            "{what} allocates {} bytes",
            used.bytes_total
        );
    }
}

#[test]
fn hostile_addresses_are_refused() {
    let text = annex_b::description("");
    let huge = "18446744073709551615";
    for (what, from, to) in [
        (
            "beyond the stream",
            "start=\"39656\" length=\"32\"",
            "start=\"39656\" length=\"40\"",
        ),
        ("negative", "start=\"110\"", "start=\"-110\""),
        ("overflowing", "start=\"110\"", huge),
        ("overlapping", "start=\"110\"", "start=\"100\""),
        ("a value that does not fit", ">35<", ">1024<"),
        ("a value that is none", ">35<", ">many<"),
        (
            "another width",
            "xsi:type=\"b10\">35",
            "xsi:type=\"b11\">35",
        ),
        (
            "a type that is none",
            "xsi:type=\"b10\">35",
            "xsi:type=\"b0\">35",
        ),
        (
            "padding of another value",
            "xsi:type=\"b2\">2",
            "xsi:type=\"b2\">1",
        ),
    ] {
        let to = if to == huge {
            format!("start=\"{huge}\"")
        } else {
            to.to_owned()
        };
        let changed = text.replacen(from, &to, 1);
        assert_ne!(changed, text, "{what}");
        let results = readers(changed.as_bytes(), &LIMITS);
        // The map or the stream: a map may be beyond the stream, padding is what it is.
        assert!(results[0].is_err() || results[1].is_err(), "{what}");
    }
}

#[test]
fn no_mutation_of_a_description_panics() {
    let text = annex_b::description("g:");
    let short: String = text
        .lines()
        .enumerate()
        .filter(|(i, _)| *i < 20 || *i > 70)
        .map(|(_, line)| format!("{line}\n"))
        .collect();
    let map = read_gbsd(short.as_bytes(), &LIMITS).unwrap().unit;
    let own = write_gbsd(&map, &Default::default()).unwrap();
    let documents = [
        short,
        own,
        Aqos::one_to_one(&[1.0, 2.0, 4.0]).write(),
        context().write_xdi(),
    ];
    for document in documents {
        let mutations = Mutations {
            edits: &[
                Edit::FlipBit,
                Edit::Delete(7),
                Edit::Word(&[
                    "-1",
                    "18446744073709551615",
                    "L:",
                    "\"",
                    "<",
                    "</",
                    "/>",
                    "&#0;",
                    "b64",
                    "none",
                    " ",
                ]),
            ],
            most: 3,
        };
        mutations.read_of(document.as_bytes(), 600, |bytes| {
            // What is read is sound.
            if let Ok(found) = read_gbsd(bytes, &LIMITS) {
                found.unit.check().unwrap();
            }
            readers(bytes, &LIMITS).iter().any(Result::is_ok)
        });
        for bytes in cut_off(document.as_bytes()).step_by(13) {
            for said in readers(bytes, &LIMITS).into_iter().filter_map(Result::err) {
                assert_eq!(said.lines().count(), 1);
            }
        }
    }
}

fn context() -> Context {
    let mut context = Context::default();
    context.network.available_bps = Some(1e5);
    context.terminal.codecs = vec!["abp1".into()];
    context.terminal.joints_per_ms = Some(40.0);
    context.terminal.benchmarks = vec![Benchmark {
        name: "b".into(),
        score: Some(3.0),
        ..Benchmark::default()
    }];
    context.preferences.face_loa = Some([1; 8]);
    context.view.distance_m = Some(2.5);
    context
}
