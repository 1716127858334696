//! Contexts to XML (XDI).
//!
//! Form: `docs/formats/context.md`.

use super::leaves::{Block, LEAVES};
use super::{Context, Modality};
use crate::description::xml::escape;
use std::fmt::Write;

impl Context {
    /// Writes the context in XML, so that [`Context::read_xdi`] gives it back.
    pub fn write_xdi(&self) -> String {
        let mut out = String::from(HEAD);
        let mut writer = Writer {
            context: self.clone(),
            out: &mut out,
        };
        writer.property("Networks", "Network", |w| {
            w.block(
                "NetworkCharacteristic",
                "NetworkCapability",
                Block::Capability,
            );
            w.around("NetworkCharacteristic", "NetworkCondition", |w| {
                w.leaves(Block::Condition)
            });
        });
        writer.property("Terminals", "Terminal", |w| {
            w.around("TerminalCapability", "Displays", |w| w.display());
            w.around("TerminalCapability", "vh:Benchmark", |w| {
                w.leaves(Block::Benchmark);
                for codec in w.context.terminal.codecs.clone() {
                    w.leaf("Codec", &codec);
                }
                w.benchmarks();
            });
        });
        writer.property("Users", "User", |w| {
            w.around(
                "UserCharacteristic",
                "GraphicsPresentationPreferences",
                |w| {
                    w.leaves(Block::Graphics);
                },
            );
            w.around("UserCharacteristic", "vh:Preferences", |w| w.wishes());
            w.around("UserCharacteristic", "vh:View", |w| {
                w.leaves(Block::View);
                w.optional("BodyFocus", w.context.view.body_focus);
                w.optional("FaceFocus", w.context.view.face_focus);
            });
        });
        out.push_str("</Description>\n</DIA>\n");
        out
    }
}

const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
    <DIA xmlns=\"urn:mpeg:mpeg21:2003:01-DIA-NS\" xmlns:vh=\"urn:articula:vh:1\" \
    xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n\
    <Description xsi:type=\"UsageEnvironmentType\">\n";

struct Writer<'a> {
    context: Context,
    out: &'a mut String,
}

impl Writer<'_> {
    fn property(&mut self, kind: &str, name: &str, inner: impl FnOnce(&mut Self)) {
        let start = format!("<UsageEnvironmentProperty xsi:type=\"{kind}Type\"><{name}>\n");
        let end = format!("</{name}></UsageEnvironmentProperty>\n");
        self.between(&start, &end, inner);
    }

    fn around(&mut self, name: &str, kind: &str, inner: impl FnOnce(&mut Self)) {
        let start = format!("<{name} xsi:type=\"{kind}Type\">");
        self.between(&start, &format!("</{name}>\n"), inner);
    }

    /// Writes an element if it has content.
    fn between(&mut self, start: &str, end: &str, inner: impl FnOnce(&mut Self)) {
        let before = self.out.len();
        self.out.push_str(start);
        let empty = self.out.len();
        inner(self);
        if self.out.len() == empty {
            self.out.truncate(before);
        } else {
            self.out.push_str(end);
        }
    }

    /// Attributes of an element that has all leaves of a block.
    fn attributes(&mut self, element: &str) -> String {
        let mut out = String::new();
        for leaf in LEAVES.iter().filter(|leaf| leaf.element == element) {
            if let Some(value) = *(leaf.of)(&mut self.context) {
                // Writing to a text cannot fail.
                let _ = write!(out, " {}=\"{value}\"", leaf.attribute);
            }
        }
        out
    }

    fn block(&mut self, name: &str, kind: &str, block: Block) {
        let attributes = self.attributes(name);
        if !attributes.is_empty() && LEAVES.iter().any(|leaf| leaf.block == block) {
            let _ = writeln!(self.out, "<{name} xsi:type=\"{kind}Type\"{attributes}/>");
        }
    }

    fn display(&mut self) {
        let (mode, resolution) = (self.attributes("Mode"), self.attributes("Resolution"));
        if mode.is_empty() && resolution.is_empty() {
            return;
        }
        let inner = if resolution.is_empty() {
            String::new()
        } else {
            format!("<Resolution{resolution}/>")
        };
        let _ = write!(
            self.out,
            "<Display><DisplayCapability xsi:type=\"DisplayCapabilityType\"><Mode{mode}>{inner}</Mode>\
             </DisplayCapability></Display>"
        );
    }

    fn leaves(&mut self, block: Block) {
        let mut last = "";
        for leaf in LEAVES.iter().filter(|leaf| leaf.block == block) {
            if leaf.attribute.is_empty() {
                if let Some(value) = *(leaf.of)(&mut self.context) {
                    self.leaf(leaf.element, &value.to_string());
                }
            } else if leaf.element != last {
                last = leaf.element;
                let attributes = self.attributes(leaf.element);
                if !attributes.is_empty() {
                    let _ = write!(self.out, "<{}{attributes}/>", leaf.element);
                }
            }
        }
    }

    fn leaf(&mut self, name: &str, value: &str) {
        let _ = write!(self.out, "<vh:{name}>{}</vh:{name}>", escape(value));
    }

    fn optional(&mut self, name: &str, value: Option<impl ToString>) {
        if let Some(value) = value {
            self.leaf(name, &value.to_string());
        }
    }

    fn benchmarks(&mut self) {
        for mut benchmark in self.context.terminal.benchmarks.clone() {
            let _ = write!(
                self.out,
                "<vh:Benchmark name=\"{}\"",
                escape(&benchmark.name)
            );
            for (attribute, value) in benchmark.numbers() {
                if let Some(value) = value {
                    let _ = write!(self.out, " {attribute}=\"{value}\"");
                }
            }
            self.out.push_str("/>");
        }
    }

    fn wishes(&mut self) {
        self.leaves(Block::Wishes);
        let wishes = self.context.preferences.clone();
        self.optional("BodyLoA", wishes.body_loa);
        self.optional("BodyRegionMask", wishes.body_regions);
        let levels = wishes
            .face_loa
            .map(|levels| levels.map(|level| level.to_string()).join(" "));
        self.optional("FaceLoA", levels);
        self.optional("MeshLevel", wishes.mesh_level);
        self.optional("Modality", wishes.modality.map(Modality::name));
    }
}
