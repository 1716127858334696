//! Contexts as XML (XDI) and as JSON.
//!
//! Form: `docs/formats/context.md`. The schema of the standard nests its elements in ways that
//! differ between editions, so that a reader takes leaves by their names, wherever they lie.

use super::{Context, Modality};
use crate::description::xml::{Document, escape, whole};
use crate::error::StreamError;
use crate::limits::DescriptionLimits;
use std::fmt::Write;

/// Where a number of a context stands in XML.
struct Leaf {
    block: Block,
    element: &'static str,
    /// Name of the attribute; the text of the element if empty.
    attribute: &'static str,
    of: fn(&mut Context) -> &mut Option<f64>,
}

/// Elements around a leaf.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Block {
    Capability,
    Condition,
    Mode,
    Benchmark,
    Graphics,
    Wishes,
    View,
}

const fn leaf(
    block: Block,
    element: &'static str,
    attribute: &'static str,
    of: fn(&mut Context) -> &mut Option<f64>,
) -> Leaf {
    Leaf {
        block,
        element,
        attribute,
        of,
    }
}

/// All numbers, those of one element next to each other.
const LEAVES: &[Leaf] = &[
    leaf(
        Block::Capability,
        "NetworkCharacteristic",
        "maxCapacity",
        |c| &mut c.network.max_capacity_bps,
    ),
    leaf(
        Block::Capability,
        "NetworkCharacteristic",
        "minGuaranteed",
        |c| &mut c.network.min_guaranteed_bps,
    ),
    leaf(Block::Condition, "AvailableBandwidth", "minimum", |c| {
        &mut c.network.min_available_bps
    }),
    leaf(Block::Condition, "AvailableBandwidth", "average", |c| {
        &mut c.network.available_bps
    }),
    leaf(Block::Condition, "AvailableBandwidth", "maximum", |c| {
        &mut c.network.max_available_bps
    }),
    leaf(Block::Condition, "Delay", "packetOneWay", |c| {
        &mut c.network.one_way_delay_ms
    }),
    leaf(Block::Condition, "Delay", "packetTwoWay", |c| {
        &mut c.network.two_way_delay_ms
    }),
    leaf(Block::Condition, "Delay", "delayVariation", |c| {
        &mut c.network.delay_variation_ms
    }),
    leaf(Block::Condition, "Error", "packetLossRate", |c| {
        &mut c.network.packet_loss
    }),
    leaf(Block::Condition, "Error", "bitErrorRate", |c| {
        &mut c.network.bit_errors
    }),
    leaf(Block::Mode, "Mode", "refreshRate", |c| {
        &mut c.terminal.refresh_hz
    }),
    leaf(Block::Mode, "Resolution", "horizontal", |c| {
        &mut c.terminal.width_px
    }),
    leaf(Block::Mode, "Resolution", "vertical", |c| {
        &mut c.terminal.height_px
    }),
    leaf(Block::Benchmark, "JointsPerMs", "", |c| {
        &mut c.terminal.joints_per_ms
    }),
    leaf(Block::Benchmark, "FapsPerMs", "", |c| {
        &mut c.terminal.faps_per_ms
    }),
    leaf(Block::Benchmark, "TrianglesPerSecond", "", |c| {
        &mut c.terminal.triangles_per_s
    }),
    leaf(Block::Benchmark, "FrameBudgetMs", "", |c| {
        &mut c.terminal.frame_budget_ms
    }),
    leaf(Block::Benchmark, "MemoryBytes", "", |c| {
        &mut c.terminal.memory_bytes
    }),
    leaf(Block::Graphics, "GeometryEmphasis", "", |c| {
        &mut c.preferences.geometry_emphasis
    }),
    leaf(Block::Graphics, "TextureEmphasis", "", |c| {
        &mut c.preferences.texture_emphasis
    }),
    leaf(Block::Graphics, "AnimationEmphasis", "", |c| {
        &mut c.preferences.animation_emphasis
    }),
    leaf(Block::Wishes, "FrameRate", "", |c| {
        &mut c.preferences.frame_rate_hz
    }),
    leaf(Block::Wishes, "PreferSmooth", "", |c| {
        &mut c.preferences.prefer_smooth
    }),
    leaf(Block::Wishes, "PreferDetail", "", |c| {
        &mut c.preferences.prefer_detail
    }),
    leaf(Block::Wishes, "TolerancePx", "", |c| {
        &mut c.preferences.tolerance_px
    }),
    leaf(Block::View, "ViewDistance", "", |c| &mut c.view.distance_m),
    leaf(Block::View, "FieldOfView", "", |c| &mut c.view.fov_rad),
];

impl Context {
    /// Reads a context in XML: the usage environment of a `Description`, in which leaves are found by
    /// name. What is not known is left out.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, for XML that cannot be read, a value that is no number
    /// or is outside of its bounds, and a leaf with two values.
    pub fn read_xdi(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let document = Document::parse(bytes, limits)?;
        let description = (0..document.elements.len()).find(|e| document.is(*e, "Description"));
        let description = description
            .ok_or_else(|| document.bad(0, "expected a Description with a usage environment"))?;
        let mut context = Self::default();
        for element in description + 1..document.elements[description].end {
            context.take_numbers(&document, element)?;
            context.take_words(&document, element)?;
        }
        context
            .check()
            .map_err(|e| document.bad(description, e.to_string()))?;
        Ok(context)
    }

    fn take_numbers(&mut self, document: &Document<'_>, element: usize) -> Result<(), StreamError> {
        for leaf in LEAVES {
            if !document.is(element, leaf.element) {
                continue;
            }
            let text = match leaf.attribute {
                "" => Some(document.text(element)),
                name => document.value(element, name),
            };
            if let Some(text) = text {
                let what = if leaf.attribute.is_empty() {
                    leaf.element
                } else {
                    leaf.attribute
                };
                let number: Option<f64> = text.trim().parse().ok();
                let number = number.filter(|number| number.is_finite());
                let wrong =
                    || document.bad(element, format!("{what} \"{text}\", expected a number"));
                put(
                    document,
                    element,
                    (leaf.of)(self),
                    number.ok_or_else(wrong)?,
                )?;
            }
        }
        Ok(())
    }

    fn take_words(&mut self, document: &Document<'_>, element: usize) -> Result<(), StreamError> {
        let text = document.text(element);
        let name = document.elements[element].name;
        let wrong = |expected: &str| {
            document.bad(element, format!("{name} \"{text}\", expected {expected}"))
        };
        let number = |most: u64| {
            let found = whole(text).filter(|number| *number <= most);
            found.ok_or_else(|| wrong(&format!("0 to {most}")))
        };
        let wishes = &mut self.preferences;
        match name.to_ascii_lowercase().as_str() {
            "bodyloa" => put(document, element, &mut wishes.body_loa, number(5)? as u8),
            "bodyregionmask" => put(
                document,
                element,
                &mut wishes.body_regions,
                number(127)? as u8,
            ),
            "meshlevel" => {
                let level = number(u64::from(u32::MAX))? as u32;
                put(document, element, &mut wishes.mesh_level, level)
            }
            "bodyfocus" => put(
                document,
                element,
                &mut self.view.body_focus,
                number(127)? as u8,
            ),
            "facefocus" => put(
                document,
                element,
                &mut self.view.face_focus,
                number(255)? as u8,
            ),
            "faceloa" => {
                let levels: Vec<u8> = text
                    .split_ascii_whitespace()
                    .filter_map(|word| word.parse().ok().filter(|level| *level <= 3))
                    .collect();
                let all = levels.len() == text.split_ascii_whitespace().count();
                let levels = levels.try_into().ok().filter(|_| all);
                let levels = levels.ok_or_else(|| wrong("eight levels, 0 to 3"))?;
                put(document, element, &mut wishes.face_loa, levels)
            }
            "modality" => {
                let found = Modality::ALL
                    .into_iter()
                    .find(|m| m.name().eq_ignore_ascii_case(text));
                let found = found.ok_or_else(|| wrong("3D, 2DWarp or 2DVector"))?;
                put(document, element, &mut wishes.modality, found)
            }
            "codec" => {
                if !text.is_empty() && !self.terminal.codecs.iter().any(|known| known == text) {
                    self.terminal.codecs.push(text.to_owned());
                }
                Ok(())
            }
            _ => Ok(()),
        }
    }

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

fn put<T: PartialEq>(
    document: &Document<'_>,
    element: usize,
    place: &mut Option<T>,
    value: T,
) -> Result<(), StreamError> {
    if place.as_ref().is_some_and(|known| *known != value) {
        let name = document.elements[element].name;
        return Err(document.bad(element, format!("{name} is told twice, with other values")));
    }
    *place = Some(value);
    Ok(())
}

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

#[cfg(feature = "json")]
impl Context {
    /// Reads a context in JSON: an object with the names of the fields of [`Context`]; those left out
    /// are unknown.
    ///
    /// # Errors
    /// A [`StreamError`] that names the line, for text that is no such object, has other fields or
    /// values outside of their bounds, or exceeds the limit of bytes.
    pub fn read_json(bytes: &[u8], limits: &DescriptionLimits) -> Result<Self, StreamError> {
        let length = bytes.len() as u64;
        crate::limits::StreamLimits::check("context", "bytes", length, limits.bytes)?;
        let context: Self = serde_json::from_slice(bytes)
            .map_err(|e| StreamError::malformed("context", e.to_string()))?;
        context.check()?;
        Ok(context)
    }

    /// Writes the context in JSON, without what is unknown.
    pub fn write_json(&self) -> String {
        // A structure of numbers and texts cannot fail.
        let mut value = serde_json::to_value(self).unwrap_or_default();
        known(&mut value);
        value.to_string()
    }
}

/// Removes what is unknown or empty.
#[cfg(feature = "json")]
fn known(value: &mut serde_json::Value) {
    if let serde_json::Value::Object(fields) = value {
        fields.values_mut().for_each(known);
        fields.retain(|_, value| match value {
            serde_json::Value::Null => false,
            serde_json::Value::Object(fields) => !fields.is_empty(),
            serde_json::Value::Array(list) => !list.is_empty(),
            _ => true,
        });
    }
}
