//! A walk as a stream, its description after MPEG-21, and what a client with little bandwidth gets:
//! by the description, and by the map, which gives the same bytes.

use articula::clip_streams::abp1;
use articula::stream::description::{
    AdaptMode, Aqos, BsdLink, Context, Did, DidComponent, DidDescriptor, DidItem, DidResource,
    GbsdOptions, Holes, LAYERS, adapt_gbsd, gbsd_to_bin, read_gbsd, stylesheet, write_gbsd,
};
use articula::stream::{DescriptionLimits, StreamLimits, cut};
use articula::{Result, fs, reference_human};

fn main() -> Result<()> {
    let mut words = std::env::args().skip(1);
    let kbps: f64 = words
        .next()
        .and_then(|word| word.parse().ok())
        .unwrap_or(100.0);
    let opened = words.next().map_or_else(reference_human, fs::open)?;
    let limits = DescriptionLimits::default();

    // The author: the stream, its description, a table of its levels, and the item that ties them.
    let stream = abp1::write(
        opened.character(),
        &opened.articulation(),
        0,
        &Default::default(),
    )?;
    let map = articula::stream::abp1::unit(&stream, &StreamLimits::default())?;
    let options = GbsdOptions {
        bitstream: Some("walk.abp".into()),
    };
    let description = write_gbsd(&map, &options)?;
    let aqos = Aqos::one_to_one(&[0.0, 50e3, 100e3, 200e3, 400e3, 800e3]).write();
    let link = BsdLink {
        steering: Some("aqos.xml".parse()?),
        description: "walk.xml".parse()?,
        transformation: Some("adapt.xslt".parse()?),
        parameters: vec![("nLayersOut".into(), LAYERS.into())],
    };
    let component = DidComponent {
        descriptors: vec![DidDescriptor::BsdLink(link)],
        resources: vec![DidResource {
            mime_type: "application/octet-stream".into(),
            reference: Some("walk.abp".parse()?),
            text: String::new(),
        }],
    };
    let item = DidItem {
        components: vec![component],
        ..DidItem::default()
    };
    let declaration = Did { items: vec![item] }.write()?;
    eprintln!(
        "stream {} bytes, description {}, table {}, declaration {}, stylesheet {}",
        stream.len(),
        description.len(),
        aqos.len(),
        declaration.len(),
        stylesheet().len()
    );

    // The server: reads what the author has written, and the context of a client.
    let mut context = Context::default();
    context.network.available_bps = Some(1000.0 * kbps);
    let context = Context::read_xdi(context.write_xdi().as_bytes(), &limits)?;
    let context = Context::aggregate(&context, &Context::default());
    let did = Did::read(declaration.as_bytes(), &limits)?;
    let aqos = Aqos::read(aqos.as_bytes(), &limits)?;
    let decided = aqos.decide(&aqos.bind(&context))?;
    for reason in &decided.reasons {
        eprintln!("{reason}");
    }
    for (link, _) in did.links() {
        let selection = link.selection(&decided.values)?;
        let adapted = adapt_gbsd(
            description.as_bytes(),
            &selection,
            AdaptMode::Conformant,
            &limits,
        )?;
        let by_description = gbsd_to_bin(adapted.as_bytes(), &stream, Holes::Skip, &limits)?;
        let map = read_gbsd(description.as_bytes(), &limits)?.unit;
        let by_map = cut(&stream, &map, |unit| selection.keeps(unit))?;
        assert_eq!(
            by_description, by_map.bytes,
            "both ways give the same bytes"
        );
        eprintln!("{kbps} kbit/s: {} bytes", by_description.len());
    }
    Ok(())
}
