//! Items adapted to contexts: within the bytes, within the stated error, and the same bytes by unit
//! indices and by descriptions.

use crate::real;
use crate::short::shortened;
use articula::item::{
    AdaptOptions, AdaptedItem, Item, ItemCut, PackageOptions, PartKind, adapt,
    adapt_by_description, aqos, assemble, decide, decide_by_table, documents, package,
};
use articula::{Executor, Figure, OpenOptions, fs};
use articula_build::{DistanceOptions, surface_distances};
use articula_core::{Clip, Mesh, PosedMesh, Rig, Wrap};
use articula_stream::DescriptionLimits;
use articula_stream::decide::Outcome;
use articula_stream::description::{
    AdaptMode, Aqos, Context, Did, Selection, adapt_gbsd, read_gbsd,
};
use glam::Vec3;
use std::sync::OnceLock;

/// Slack on errors of meshes, which are measured on some poses, not on these frames.
const SLACK: f64 = 1.1;

/// A walking character and its item, with forms in 2D; `None` without the file.
fn walking() -> Option<&'static (Figure, Item)> {
    static MADE: OnceLock<Option<(Figure, Item)>> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let path = real::file("glb/RobotExpressive.glb")?;
        let opened = shortened(fs::open(path).unwrap(), 0.5);
        let options = PackageOptions {
            clips: vec!["Robot_Walking".to_owned()],
            mesh_levels: 4,
            texture_distances_m: vec![3.0],
            flat_px: 80,
            ..PackageOptions::default()
        };
        let item = package(opened.clone(), &options, &Executor::default()).unwrap();
        Some((Figure::new(opened).unwrap(), item))
    });
    made.as_ref()
}

fn at(bits_per_second: f64) -> Context {
    let mut context = Context::default();
    context.network.available_bps = Some(bits_per_second);
    context
}

fn layers(adapted: AdaptedItem) -> Item {
    match adapted {
        AdaptedItem::Layers(item) => item,
        AdaptedItem::Flat { entry, .. } => panic!("fell to {}", entry.modality),
    }
}

/// Vertices of a mesh in a clip at a frame.
fn shown(rig: &Rig, mesh: &Mesh, clip: &Clip, frame: usize) -> Vec<Vec3> {
    let secs = frame as f64 / f64::from(clip.rate_hz());
    let mut posed = PosedMesh::new(rig, mesh);
    posed.pose_at(clip, secs, Wrap::Clamp);
    posed.skinned(&mesh.morph_weights).positions
}

/// Greatest distance of the original surface from that of an item, both moving.
fn distance(original: &Figure, item: &Item) -> f64 {
    let other = Figure::new(assemble(item, &OpenOptions::default()).unwrap()).unwrap();
    let name = &other.asset.clips[0].name;
    let truth = original.asset.clips.iter().find(|clip| clip.name == *name);
    let truth = truth.unwrap();
    let first = original.asset.mesh.len() as u32;
    let coarse = other.asset.mesh.triangles.iter();
    let coarse: Vec<[u32; 3]> = coarse.map(|t| t.map(|v| v + first)).collect();
    let mut most = 0.0_f64;
    for frame in (0..truth.frames()).step_by(5) {
        let (a, b) = (&original.asset, &other.asset);
        let mut all = shown(&a.rig, &a.mesh, truth, frame);
        all.extend(shown(&b.rig, &b.mesh, &b.clips[0], frame));
        let opts = DistanceOptions::default();
        let found = surface_distances(&a.mesh.triangles, &[&coarse], &all, &[], &opts).unwrap();
        most = most.max(f64::from(found[0].rest.max_metres));
    }
    most
}

#[test]
fn every_budget_is_kept_and_the_stated_error_bounds_what_is_shown() {
    let Some((original, item)) = walking() else {
        return;
    };
    let options = AdaptOptions::default();
    let whole = item.sent_bytes_of_layers() as f64;
    let mut errors = Vec::new();
    for share in [2.0, 0.97, 0.94, 0.9, 0.86] {
        // The window is two seconds.
        let decision = decide(item, &at(8.0 * whole * share / 2.0), &options).unwrap();
        if !matches!(decision.decision.outcome, Outcome::Parts(_)) {
            continue;
        }
        let adapted = layers(adapt(item, decision.cut.as_ref().unwrap()).unwrap());
        let allowed = whole * share;
        assert!(
            adapted.sent_bytes() as f64 <= allowed,
            "{} of {allowed}",
            adapted.sent_bytes()
        );
        assert_eq!(
            adapted.sent_bytes(),
            decision.decision.bytes + decision.bytes_always
        );
        // Textures have no place here: of the others the error is one of metres.
        let metres: f64 = decision.decision.error_px / decision.decision.request.pixels_per_metre;
        let found = distance(original, &adapted);
        assert!(
            found <= SLACK * metres + 1e-4,
            "share {share}: {found} m, stated {metres}"
        );
        errors.push(decision.decision.error_px);
        // The decision holds for what it made.
        let again = decide(&adapted, &at(8.0 * allowed / 2.0), &options).unwrap();
        assert_eq!(
            adapt(&adapted, again.cut.as_ref().unwrap())
                .unwrap()
                .sent_bytes(),
            adapted.sent_bytes()
        );
    }
    assert!(errors.len() >= 3, "{errors:?}");
    assert!(
        errors.is_sorted() && errors[0] < errors[errors.len() - 1],
        "{errors:?}"
    );
}

#[test]
fn indices_and_descriptions_cut_to_the_same_bytes() {
    let Some((_, item)) = walking() else {
        return;
    };
    let limits = DescriptionLimits::default();
    let mut cuts = 0;
    for (bytes, loa, regions) in [
        (None, None, None),
        (None, Some(2), Some(71)),
        (Some(0.8), None, None),
        (Some(0.5), None, None),
        (Some(0.4), Some(3), None),
    ] {
        let mut context = Context::default();
        context.preferences.body_loa = loa;
        context.preferences.body_regions = regions;
        let options = AdaptOptions {
            max_bytes: bytes.map(|share| (share * item.sent_bytes_of_layers() as f64) as u64),
            ..AdaptOptions::default()
        };
        let decision = decide(item, &context, &options).unwrap();
        let Some(cut @ ItemCut::Layers { .. }) = &decision.cut else {
            continue;
        };
        let native = layers(adapt(item, cut).unwrap());
        let described = adapt_by_description(item, cut, &mut |description, parameters| {
            let mut selection = Selection::default();
            for (name, value) in parameters {
                selection.set(name, value).map_err(|e| e.to_string())?;
            }
            let mode = AdaptMode::Conformant;
            adapt_gbsd(description.as_bytes(), &selection, mode, &limits).map_err(|e| e.to_string())
        });
        assert_eq!(layers(described.unwrap()), native);
        cuts += 1;
    }
    assert!(cuts >= 3);
    let failed = adapt_by_description(
        item,
        decide(item, &Context::default(), &AdaptOptions::default())
            .unwrap()
            .cut
            .as_ref()
            .unwrap(),
        &mut |_, _| Err("no processor".into()),
    );
    assert!(failed.unwrap_err().to_string().contains("no processor"));
}

#[test]
fn regions_that_are_not_wanted_are_left_out_of_motions() {
    let Some((_, item)) = walking() else {
        return;
    };
    let mut context = Context::default();
    // Pelvis, legs and feet.
    context.preferences.body_regions = Some(56);
    let decision = decide(item, &context, &AdaptOptions::default()).unwrap();
    let lower = layers(adapt(item, decision.cut.as_ref().unwrap()).unwrap());
    let part = lower
        .manifest
        .parts
        .iter()
        .find(|p| p.kind == PartKind::BodyMotion)
        .unwrap();
    assert!(!part.regions.is_empty());
    assert!(
        part.regions
            .iter()
            .all(|region| (4..=6).contains(&region.number))
    );
    let mut regions = Vec::new();
    lower
        .unit_tree(part)
        .unwrap()
        .visit(&mut |unit| regions.extend(unit.marker("region")));
    assert!(!regions.is_empty() && regions.iter().all(|r| (4..=6).contains(r)));
    assert!(assemble(&lower, &OpenOptions::default()).is_ok());
}

#[test]
fn tables_decide_as_the_thesis_does() {
    let Some((_, item)) = walking() else {
        return;
    };
    let limits = DescriptionLimits::default();
    let written = aqos(item, &Context::default(), &AdaptOptions::default())
        .unwrap()
        .write();
    let table = Aqos::read(written.as_bytes(), &limits).unwrap();
    let bytes = |rate: f64, table: &Aqos| {
        let (_, cut) = decide_by_table(item, table, &at(rate), &AdaptOptions::default()).unwrap();
        adapt(item, &cut).unwrap().sent_bytes()
    };
    let sizes = [30e3, 200e3, 10e6, 1e9].map(|rate| bytes(rate, &table));
    assert!(sizes.is_sorted() && sizes[0] < sizes[3], "{sizes:?}");
    assert_eq!(sizes[3], item.sent_bytes_of_layers());
    // One level for each bandwidth, as in annex B.
    let thesis = Aqos::one_to_one(&[0.0, 100e3, 200e3, 400e3]);
    let options = AdaptOptions {
        wait_secs: 100.0,
        ..AdaptOptions::default()
    };
    let (decided, cut) = decide_by_table(item, &thesis, &at(250e3), &options).unwrap();
    assert!(
        decided
            .reasons
            .iter()
            .any(|reason| reason.contains("LAYERS_OF_SCALABLE_BBA"))
    );
    let adapted = layers(adapt(item, &cut).unwrap());
    let part = adapted
        .manifest
        .parts
        .iter()
        .find(|p| p.kind == PartKind::BodyMotion)
        .unwrap();
    assert!(part.layers.iter().all(|layer| layer.keep["loa"] <= 2));
    let refused = decide_by_table(item, &thesis, &Context::default(), &options).unwrap_err();
    assert!(refused.to_string().contains("BANDWIDTH"), "{refused}");
}

#[test]
fn what_is_too_little_for_3d_gets_a_form_in_2d_or_an_error() {
    let Some((_, item)) = walking() else {
        return;
    };
    let least = item
        .manifest
        .flat
        .iter()
        .map(|form| item.manifest.sent_bytes(&form.file))
        .min()
        .unwrap();
    let options = |bytes| AdaptOptions {
        max_bytes: Some(bytes),
        ..AdaptOptions::default()
    };
    let decision = decide(item, &Context::default(), &options(least)).unwrap();
    if least < item.manifest.sent_bytes(&item.manifest.figure.file) {
        let adapted = adapt(item, decision.cut.as_ref().unwrap()).unwrap();
        let AdaptedItem::Flat {
            files, sent_bytes, ..
        } = adapted
        else {
            panic!("expected a form in 2D");
        };
        assert_eq!((sent_bytes, files.len()), (least, 1));
    }
    let nothing = decide(item, &Context::default(), &options(10)).unwrap();
    assert_eq!(
        (nothing.cut, nothing.decision.outcome),
        (None, Outcome::Nothing)
    );
    let mut wrong = Context::default();
    wrong.network.available_bps = Some(f64::NAN);
    assert!(decide(item, &wrong, &AdaptOptions::default()).is_err());
}

#[test]
fn documents_describe_every_stream_and_lead_back_to_it() {
    let Some((_, item)) = walking() else {
        return;
    };
    let limits = DescriptionLimits::default();
    let made = documents(item).unwrap();
    let named = |name: &str| &made.iter().find(|(n, _)| n == name).unwrap().1;
    let did = Did::read(named("did.xml"), &limits).unwrap();
    let streams: Vec<&str> = item
        .manifest
        .parts
        .iter()
        .filter_map(|p| p.file.as_deref())
        .collect();
    let links = did.links();
    assert_eq!(links.len(), streams.len());
    for (link, resource) in links {
        let file = resource.reference.as_ref().unwrap().as_str();
        assert!(streams.contains(&file));
        let gbsd = read_gbsd(named(link.description.as_str()), &limits).unwrap();
        let part = item
            .manifest
            .parts
            .iter()
            .find(|p| p.file.as_deref() == Some(file))
            .unwrap();
        assert_eq!(gbsd.unit, item.unit_tree(part).unwrap(), "{file}");
        let values = Aqos::read(named("aqos.xml"), &limits).unwrap();
        let values = values.decide(&values.bind(&at(1e6))).unwrap().values;
        assert!(link.selection(&values).is_ok());
    }
}
