//! Contexts and declarations of items: round trips, what is read of other programs, references.

use crate::annex_b;
use crate::tools::LIMITS;
use articula_mutate::Dice;
use articula_stream::description::{
    Aqos, BANDWIDTH, Benchmark, BsdLink, Context, Did, DidComponent, DidDescriptor, DidItem,
    DidResource, GbsdOptions, LAYERS, Modality, Selection, read_gbsd, write_gbsd,
};
use std::path::Path;

/// A context of random values, each there or not.
fn random_context(dice: &mut Dice) -> Context {
    let mut context = Context::default();
    let mut put = |place: &mut Option<f64>, most: f64| {
        if dice.roll(3) > 0 {
            *place = Some(dice.roll(1 << 30) as f64 / f64::from(1 << 30) * most);
        }
    };
    let (n, t) = (&mut context.network, &mut context.terminal);
    for place in [
        &mut n.max_capacity_bps,
        &mut n.min_guaranteed_bps,
        &mut n.available_bps,
        &mut n.one_way_delay_ms,
        &mut n.two_way_delay_ms,
        &mut n.delay_variation_ms,
        &mut t.width_px,
        &mut t.height_px,
        &mut t.refresh_hz,
        &mut t.joints_per_ms,
        &mut t.faps_per_ms,
        &mut t.triangles_per_s,
        &mut t.frame_budget_ms,
        &mut t.memory_bytes,
        &mut context.preferences.geometry_emphasis,
        &mut context.preferences.texture_emphasis,
        &mut context.preferences.animation_emphasis,
        &mut context.preferences.frame_rate_hz,
        &mut context.preferences.tolerance_px,
        &mut context.view.distance_m,
    ] {
        put(place, 1e7);
    }
    for place in [
        &mut n.packet_loss,
        &mut n.bit_errors,
        &mut context.preferences.prefer_smooth,
        &mut context.preferences.prefer_detail,
        &mut context.view.fov_rad,
    ] {
        put(place, 1.0);
    }
    n.min_available_bps = n.available_bps.map(|rate| rate / 2.0);
    n.max_available_bps = n.available_bps.map(|rate| rate * 1.5);
    let mut whole = |sides: usize| (dice.roll(3) > 0).then(|| dice.roll(sides) as u8);
    context.preferences.body_loa = whole(6);
    context.preferences.body_regions = whole(128);
    context.preferences.mesh_level = whole(9).map(u32::from);
    context.view.body_focus = whole(128);
    context.view.face_focus = whole(256);
    context.preferences.modality = whole(3).map(|m| Modality::ALL[usize::from(m)]);
    context.preferences.face_loa = whole(4).map(|level| [level, 3, 0, 1, 2, 3, 0, level]);
    if let Some(count) = whole(3) {
        context.terminal.codecs = ["abp2", "a<b>&\"c\""][..usize::from(count)]
            .iter()
            .map(|name| (*name).to_owned())
            .collect();
        let of = |name: &&str| Benchmark {
            name: (*name).to_owned(),
            score: Some(f64::from(count) / 3.0),
            share: (count > 1).then_some(0.5),
            ..Benchmark::default()
        };
        let names = ["viewperf", "\"<score>\"&"];
        context.terminal.benchmarks = names[..usize::from(count)].iter().map(of).collect();
    }
    context
}

#[test]
fn contexts_come_back() {
    let mut dice = Dice::new(3);
    for _ in 0..200 {
        let context = random_context(&mut dice);
        context.check().unwrap();
        let text = context.write_xdi();
        assert_eq!(
            Context::read_xdi(text.as_bytes(), &LIMITS).unwrap(),
            context,
            "{text}"
        );
        #[cfg(feature = "json")]
        {
            let text = context.write_json();
            assert_eq!(
                Context::read_json(text.as_bytes(), &LIMITS).unwrap(),
                context,
                "{text}"
            );
        }
    }
    let nothing = Context::default();
    assert_eq!(
        Context::read_xdi(nothing.write_xdi().as_bytes(), &LIMITS).unwrap(),
        nothing
    );
}

#[cfg(feature = "json")]
#[test]
fn contexts_in_json_are_as_documented() {
    let text = r#"{"network": {"available_bps": 64000}, "preferences": {"body_loa": 2, "modality": "2DWarp"}}"#;
    let context = Context::read_json(text.as_bytes(), &LIMITS).unwrap();
    assert_eq!(context.network.available_bps, Some(64000.0));
    assert_eq!(context.preferences.modality, Some(Modality::Warp));
    assert_eq!(
        context.write_json(),
        r#"{"network":{"available_bps":64000.0},"preferences":{"body_loa":2,"modality":"2DWarp"}}"#
    );
    let refused = |text: &str| {
        Context::read_json(text.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
    };
    assert!(refused("{\"network\": {\"bandwidth\": 1}}").contains("bandwidth"));
    assert!(refused("{\"preferences\": {\"body_loa\": 9}}").contains("body_loa"));
    assert!(refused("{\"network\": {\"available_bps\": 1e999}}").contains("context"));
    assert!(refused(&"[".repeat(100_000)).contains("context"));
}

#[test]
fn leaves_are_found_wherever_they_lie() {
    let text = "<DIA xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\
        <Description xsi:type=\"UsageEnvironmentType\"><UsageEnvironmentProperty xsi:type=\"NetworksType\"><Network>\
        <NetworkCharacteristic xsi:type=\"NetworkConditionType\"><AvailableBandwidth average=\"64000\"/>\
        </NetworkCharacteristic></Network></UsageEnvironmentProperty><Unknown><BodyLoA> 3 </BodyLoA></Unknown>\
        </Description></DIA>";
    let context = Context::read_xdi(text.as_bytes(), &LIMITS).unwrap();
    assert_eq!(context.network.usable_bps(), Some(64000.0));
    assert_eq!(context.preferences.body_loa, Some(3));
    let refused = |from: &str, to: &str| {
        let text = text.replace(from, to);
        Context::read_xdi(text.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused("64000", "fast"),
        "line 1: average \"fast\", expected a number"
    );
    assert!(refused("64000", "-1").contains("available_bps"));
    assert!(refused("64000", "1e400").contains("expected a number"));
    assert!(refused(" 3 ", "6").contains("0 to 5"));
    assert!(refused("</Unknown>", "<BodyLoA>2</BodyLoA></Unknown>").contains("told twice"));
    assert!(refused("Description", "Other").contains("expected a Description"));
}

/// The declaration of annex B, with the case that the scan lost.
const ANNEX_B: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<DIDL xmlns=\"urn:mpeg:mpeg21:2002:02-DIDL-NS\" xmlns:dia=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" \
xmlns:dii=\"urn:mpeg:mpeg21:2002:01-DII-NS\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">
<Item><Item id=\"sdp\"><Component><Resource mimeType=\"application/sdp\" ref=\"clock.sdp\"/></Component></Item>
<Item id=\"bifsstream\"><Descriptor><Statement mimeType=\"text/xml\"><dii:RelatedIdentifier>trackID=1\
</dii:RelatedIdentifier></Statement></Descriptor><Component><Resource mimeType=\"application/mp4\" ref=\"clock_1.raw\"/>\
</Component></Item>
<Item id=\"bbastream\"><Descriptor><Statement mimeType=\"text/xml\"><dii:RelatedIdentifier>trackID=110\
</dii:RelatedIdentifier></Statement></Descriptor><Component><Descriptor><Statement mimeType=\"text/xml\"><dia:DIA>\
<dia:Description xsi:type=\"dia:BSDLinkType\"><dia:SteeringDescriptionRef uri=\"boy_aqos.xml\"/>\
<dia:BSDRef uri=\"boy_gbsd.xml\"/><dia:BSDTransformationRef uri=\"boy.xslt\"/><dia:Parameter \
xsi:type=\"dia:IOPinRefType\" name=\"nLayersOut\"><dia:Value>LAYERS_OF_SCALABLE_BBA</dia:Value></dia:Parameter>\
</dia:Description></dia:DIA></Statement></Descriptor><Resource mimeType=\"media/mp4\" ref=\"clock_110.raw\"/>\
</Component></Item></Item></DIDL>";

#[test]
fn the_declaration_of_annex_b_leads_to_a_selection() {
    let did = Did::read(ANNEX_B.as_bytes(), &LIMITS).unwrap();
    let items = &did.items[0].items;
    assert_eq!(
        items[0].components[0].resources[0].mime_type,
        "application/sdp"
    );
    assert_eq!(
        items[1].descriptors,
        [DidDescriptor::RelatedIdentifier("trackID=1".into())]
    );
    let links = did.links();
    let (link, resource) = links[0];
    assert_eq!(links.len(), 1);
    assert_eq!(
        resource.reference.as_ref().unwrap().as_str(),
        "clock_110.raw"
    );
    assert_eq!(link.description.as_str(), "boy_gbsd.xml");
    assert_eq!(link.parameters, [("nLayersOut".into(), LAYERS.into())]);
    let aqos = Aqos::one_to_one(&[8e3, 16e3, 32e3, 64e3]);
    let mut context = Context::default();
    context.network.available_bps = Some(20e3);
    let decided = aqos.decide(&aqos.bind(&context)).unwrap();
    assert_eq!(decided.values[BANDWIDTH], 20e3);
    assert_eq!(
        link.selection(&decided.values).unwrap(),
        Selection::of_loa(1)
    );
    let said = link.selection(&Default::default()).unwrap_err().to_string();
    assert!(
        said.contains("the pin LAYERS_OF_SCALABLE_BBA has no value"),
        "{said}"
    );
}

#[test]
fn declarations_come_back() {
    let did = Did::read(ANNEX_B.as_bytes(), &LIMITS).unwrap();
    let text = did.write().unwrap();
    assert_eq!(Did::read(text.as_bytes(), &LIMITS).unwrap(), did);
    let other = |xml: &str| DidDescriptor::Other {
        mime_type: "text/plain".into(),
        xml: xml.into(),
    };
    let mut made = Did {
        items: vec![DidItem {
            id: Some("a & \"b\"".into()),
            descriptors: vec![
                other("a note"),
                other("<x xmlns=\"urn:x\">1 &lt; 2<y/></x>"),
            ],
            items: vec![DidItem::default()],
            components: vec![DidComponent {
                descriptors: vec![DidDescriptor::BsdLink(BsdLink {
                    steering: None,
                    description: "a/b.xml".parse().unwrap(),
                    transformation: None,
                    parameters: Vec::new(),
                })],
                resources: vec![DidResource {
                    mime_type: "text/plain".into(),
                    reference: None,
                    text: "some <text>".into(),
                }],
            }],
        }],
    };
    let text = made.write().unwrap();
    assert_eq!(Did::read(text.as_bytes(), &LIMITS).unwrap(), made);
    for bad in ["<x>", "</Statement>", "<q:x/>", "&nbsp;"] {
        made.items[0].descriptors[0] = other(bad);
        assert!(made.write().is_err(), "{bad}");
    }
}

#[test]
fn references_that_leave_the_item_are_refused() {
    for (from, to) in [
        ("clock.sdp", "/etc/passwd"),
        ("clock.sdp", "../clock.sdp"),
        ("clock.sdp", "file:clock.sdp"),
        ("boy_gbsd.xml", "http://host/boy.xml"),
        ("boy.xslt", "a/../../boy.xslt"),
        ("boy_aqos.xml", "C:\\boy.xml"),
    ] {
        let text = ANNEX_B.replace(from, to);
        let said = Did::read(text.as_bytes(), &LIMITS).unwrap_err().to_string();
        assert!(
            said.starts_with("line ") && said.contains("reference"),
            "{said}"
        );
    }
    let text = ANNEX_B.replace("<Item id=\"sdp\">", "<Choice/><Item id=\"sdp\">");
    assert!(
        Did::read(text.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
            .contains("<Choice>")
    );
    let text = ANNEX_B.replace("dia:BSDRef", "dia:Other");
    assert!(
        Did::read(text.as_bytes(), &LIMITS)
            .unwrap_err()
            .to_string()
            .contains("without BSDRef")
    );
}

/// Compares a text with a stored one, or renews it.
fn check_golden(name: &str, text: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/descriptions");
    let path = folder.join(name);
    if std::env::var_os("ARTICULA_GOLDEN").is_some_and(|v| v == "renew") {
        std::fs::create_dir_all(folder).unwrap();
        std::fs::write(&path, text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text, "{name}");
}

#[test]
fn documents_are_written_as_stored() {
    let sample = read_gbsd(annex_b::description("g:").as_bytes(), &LIMITS).unwrap();
    let options = GbsdOptions {
        bitstream: Some("sequ.raw".into()),
    };
    check_golden(
        "annex_b.gbsd.xml",
        &write_gbsd(&sample.unit, &options).unwrap(),
    );
    check_golden(
        "annex_b.did.xml",
        &Did::read(ANNEX_B.as_bytes(), &LIMITS)
            .unwrap()
            .write()
            .unwrap(),
    );
    check_golden(
        "annex_b.aqos.xml",
        &Aqos::one_to_one(&[8e3, 16e3, 32e3, 64e3]).write(),
    );
    let mut context = Context::default();
    context.network.available_bps = Some(64e3);
    context.network.two_way_delay_ms = Some(40.5);
    context.terminal.width_px = Some(1280.0);
    context.terminal.height_px = Some(720.0);
    context.terminal.joints_per_ms = Some(900.0);
    context.terminal.codecs = vec!["abp1".into(), "abp2".into()];
    context.preferences.body_loa = Some(2);
    context.preferences.face_loa = Some([3, 2, 2, 1, 1, 0, 0, 0]);
    context.view.distance_m = Some(4.0);
    check_golden("phone.context.xml", &context.write_xdi());
}
