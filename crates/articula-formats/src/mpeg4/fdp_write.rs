//! Writing of FDP files.

use super::fdp::{FdpFile, FeaturePoint};
use articula_core::LibmQuat;
use quick_xml::escape::escape;
use std::fmt::Write as _;

/// Maximum number of vertices on a line.
const ON_A_LINE: usize = 24;

/// Writes an FDP file, version 0.2, with a line for each element.
pub fn write(file: &FdpFile) -> Vec<u8> {
    let mut text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n<xfdp>\n".to_owned();
    head(&mut text, file);
    text.push_str("  <source>\n");
    for source in &file.sources {
        let (alias, category) = (escape(&source.alias), escape(&source.category));
        let _ = writeln!(
            text,
            "    <entity alias=\"{alias}\" category=\"{category}\">"
        );
        for mesh in &source.meshes {
            let (name, format) = (escape(mesh), escape(mesh.rsplit('.').next().unwrap_or("")));
            let _ = writeln!(text, "      <mesh file=\"{name}\" format=\"{format}\"/>");
        }
        for (item, submesh) in &source.parts {
            let (item, submesh) = (escape(item), escape(submesh));
            let _ = writeln!(text, "      <bind item=\"{item}\" submesh=\"{submesh}\"/>");
        }
        text.push_str("    </entity>\n");
    }
    text.push_str("  </source>\n");
    for found in &file.points {
        point(&mut text, found);
    }
    text.push_str("</xfdp>\n");
    text.into_bytes()
}

fn head(text: &mut String, file: &FdpFile) {
    let units = file.fapu;
    let at = file.translation;
    let (axis, angle) = file.rotation.libm_to_axis_angle();
    let _ = writeln!(
        text,
        "  <head>\n    <file version=\"{}\"/>",
        super::fdp::VERSION
    );
    let _ = writeln!(
        text,
        "    <fapu ENS0=\"{}\" ES0=\"{}\" IRISD0=\"{}\" MNS0=\"{}\" MW0=\"{}\"/>",
        units.ens0, units.es0, units.irisd0, units.mns0, units.mw0
    );
    let _ = writeln!(
        text,
        "    <translation x=\"{}\" y=\"{}\" z=\"{}\"/>",
        at.x, at.y, at.z
    );
    let _ = writeln!(
        text,
        "    <rotation axis_angle=\"{angle}\" axis_x=\"{}\" axis_y=\"{}\" axis_z=\"{}\"/>\n  </head>",
        axis.x, axis.y, axis.z
    );
}

fn point(text: &mut String, point: &FeaturePoint) {
    let (group, number) = point.point;
    let mesh = escape(&point.mesh);
    let vertex = point.vertex;
    let _ = writeln!(
        text,
        "  <fdp affects=\"{mesh}\" index=\"{vertex}\" name=\"{group}.{number}\">"
    );
    if !point.zone.is_empty() {
        let lines = point.zone.chunks(ON_A_LINE).map(|some| {
            let words: Vec<String> = some.iter().map(u32::to_string).collect();
            words.join(" ")
        });
        let lines: Vec<String> = lines.collect();
        let _ = writeln!(text, "    <indices>{}</indices>", lines.join("\n      "));
    }
    for influence in &point.influences {
        let (fap, kind, weight) = (influence.fap - 1, escape(&influence.kind), influence.weight);
        let _ = writeln!(
            text,
            "    <influence fap=\"{fap}\" type=\"{kind}\" weight=\"{weight}\"/>"
        );
    }
    text.push_str("  </fdp>\n");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::mpeg4::fdp::{FapInfluence, Fapu, MeshSource, read};
    use glam::{Quat, Vec3};
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn files_come_back(
            names in prop::collection::vec("[a-z<>&\"' é]{1,8}", 5),
            zone in prop::collection::vec(0..9000_u32, 0..60),
            faps in prop::collection::vec((1..=68_usize, -2.0..2.0_f32), 0..4),
            place in prop::array::uniform3(-3.0..3.0_f32),
        ) {
            let name = |i: usize| names[i].clone();
            let influence = |(fap, weight): &(usize, f32)| FapInfluence { fap: *fap, kind: name(0), weight: *weight };
            let file = FdpFile {
                fapu: Fapu { irisd0: 0.0083, es0: 0.0623, ens0: 0.048, mns0: 0.0212, mw0: 0.0507 },
                translation: Vec3::from(place),
                rotation: Quat::from_rotation_y(0.5),
                sources: vec![MeshSource {
                    alias: name(1),
                    category: name(2),
                    meshes: vec![name(3)],
                    parts: vec![("LeftEye".to_owned(), name(4))],
                }],
                points: vec![FeaturePoint {
                    point: (2, 10),
                    mesh: name(3),
                    vertex: 77,
                    influences: faps.iter().map(influence).collect(),
                    zone,
                }],
            };
            let back = read(&write(&file), &Limits::default()).unwrap();
            prop_assert!(back.warnings.is_empty());
            prop_assert!(back.value.rotation.dot(file.rotation) > 0.999_99);
            prop_assert_eq!(FdpFile { rotation: file.rotation, ..back.value }, file);
        }
    }
}
