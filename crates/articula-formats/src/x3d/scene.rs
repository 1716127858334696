//! The node tree that both encodings are parsed into.
//!
//! A node keeps the text of its fields, which `fields` converts on demand. `USE` references a node
//! a second time, so the tree is a graph without cycles: a name can be used only after its node has
//! ended.
//!
//! Source: ISO/IEC 19775-1 (X3D), 4.4; VRML97 (ISO/IEC 14772-1), 4.4 to 4.7.

use crate::error::ReadError;
use crate::limits::Limits;
use crate::notes::Notes;
use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::HashMap;

/// Index of a node in [`Scene::nodes`].
pub(super) type NodeId = usize;

/// Maximum number of `META` statements; further ones are left out.
const MAX_METAS: usize = 256;

/// One node as in the file.
#[derive(Debug)]
pub(super) struct Node<'a> {
    /// Type, such as `HAnimJoint`.
    pub(super) kind: Cow<'a, str>,
    /// Name given by `DEF`; may be empty.
    pub(super) def: Cow<'a, str>,
    /// Byte offset of its start in the text.
    offset: usize,
    /// Fields that hold no node, as text.
    pub(super) texts: Vec<(Cow<'a, str>, Cow<'a, str>)>,
    /// Nodes in fields, in the order of the file.
    pub(super) children: Vec<(Cow<'a, str>, NodeId)>,
}

impl Node<'_> {
    /// Returns the text of a field, if present; of two, the last.
    pub(super) fn text(&self, field: &str) -> Option<&str> {
        let given = self.texts.iter().rev().find(|(name, _)| name == field);
        given.map(|(_, text)| text.as_ref())
    }

    /// Returns the nodes in a field.
    pub(super) fn nodes<'n>(&'n self, field: &'n str) -> impl Iterator<Item = NodeId> + 'n {
        let of_field = move |(name, id): &'n (Cow<'_, str>, NodeId)| (name == field).then_some(*id);
        self.children.iter().filter_map(of_field)
    }
}

/// An event path from a field of one node to a field of another.
#[derive(Debug, Clone)]
pub(super) struct Route {
    pub(super) from: NodeId,
    pub(super) from_field: String,
    pub(super) to: NodeId,
    pub(super) to_field: String,
}

/// A file as parsed from either encoding.
#[derive(Debug)]
pub(super) struct X3dScene<'a> {
    text: &'a str,
    pub(super) nodes: Vec<Node<'a>>,
    /// Nodes without parent.
    pub(super) roots: Vec<NodeId>,
    pub(super) routes: Vec<Route>,
    /// `META` statements of the head: name and content.
    pub(super) metas: Vec<(String, String)>,
    /// Major version of the standard; 2 for VRML97.
    pub(super) version: u32,
    /// Metres per length unit.
    pub(super) metres: f64,
    /// Radians per angle unit.
    pub(super) radians: f64,
    line_starts: OnceCell<Vec<usize>>,
}

impl X3dScene<'_> {
    /// Returns a node's position for warnings and errors.
    pub(super) fn at(&self, id: NodeId) -> String {
        let node = &self.nodes[id];
        let line = self.line(node.offset);
        match node.def.as_ref() {
            "" => format!("line {line}, {}", node.kind),
            def => format!("line {line}, {} {}", node.kind, shortened(def)),
        }
    }

    /// Returns the line of a byte of the text, from 1.
    fn line(&self, offset: usize) -> usize {
        let starts = self.line_starts.get_or_init(|| {
            let ends = self.text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
            ends.map(|(i, _)| i + 1).collect()
        });
        starts.partition_point(|start| *start <= offset) + 1
    }
}

/// Bounds the length of a name, which is unlimited in a file.
pub(super) fn shortened(name: &str) -> &str {
    let end = name.char_indices().nth(60).map_or(name.len(), |(i, _)| i);
    &name[..end]
}

/// A scene under construction.
#[derive(Debug)]
pub(super) struct Builder<'a, 'l> {
    pub(super) scene: X3dScene<'a>,
    pub(super) notes: Notes,
    pub(super) limits: &'l Limits,
    names: HashMap<Cow<'a, str>, NodeId>,
}

impl<'a, 'l> Builder<'a, 'l> {
    pub(super) fn new(text: &'a str, limits: &'l Limits) -> Self {
        Self {
            scene: X3dScene {
                text,
                nodes: Vec::new(),
                roots: Vec::new(),
                routes: Vec::new(),
                metas: Vec::new(),
                version: 3,
                metres: 1.0,
                radians: 1.0,
                line_starts: OnceCell::new(),
            },
            notes: Notes::default(),
            limits,
            names: HashMap::new(),
        }
    }

    /// Returns a byte's position for errors.
    pub(super) fn line(&self, offset: usize) -> String {
        format!("line {}", self.scene.line(offset))
    }

    pub(super) fn malformed(&self, offset: usize, what: impl Into<String>) -> ReadError {
        ReadError::malformed(self.line(offset), what)
    }

    pub(super) fn warn(&mut self, offset: usize, what: impl Into<String>) {
        let at = self.line(offset);
        self.notes.add(at, what);
    }

    /// Adds a node without fields.
    pub(super) fn open(
        &mut self,
        kind: impl Into<Cow<'a, str>>,
        offset: usize,
    ) -> Result<NodeId, ReadError> {
        let id = self.scene.nodes.len();
        if id as u64 >= self.limits.nodes {
            let at = self.line(offset);
            Limits::check(&at, "nodes", id as u64 + 1, self.limits.nodes)?;
        }
        self.scene.nodes.push(Node {
            kind: kind.into(),
            def: Cow::Borrowed(""),
            offset,
            texts: Vec::new(),
            children: Vec::new(),
        });
        Ok(id)
    }

    /// Returns an error if the nesting is too deep.
    pub(super) fn check_depth(&self, depth: usize, offset: usize) -> Result<(), ReadError> {
        if depth as u64 > self.limits.depth {
            let at = self.line(offset);
            Limits::check(&at, "levels of nesting", depth as u64, self.limits.depth)?;
        }
        Ok(())
    }

    /// Attaches a node to a field of its parent, or adds it as a root.
    pub(super) fn attach(&mut self, parent: Option<NodeId>, field: Cow<'a, str>, id: NodeId) {
        match parent {
            Some(parent) => self.scene.nodes[parent].children.push((field, id)),
            None => self.scene.roots.push(id),
        }
    }

    /// Ends a node; from now on its name can be used.
    pub(super) fn close(&mut self, id: NodeId) {
        let def = &self.scene.nodes[id].def;
        if !def.is_empty() {
            self.names.insert(def.clone(), id);
        }
    }

    /// Returns the node of a name; warns if none is defined yet.
    pub(super) fn used(&mut self, name: &str, offset: usize) -> Option<NodeId> {
        let found = self.names.get(name).copied();
        if found.is_none() {
            let name = shortened(name);
            self.warn(
                offset,
                format!("no node before this one has the name \"{name}\""),
            );
        }
        found
    }

    /// Adds a route between two named nodes.
    pub(super) fn route(&mut self, from: (&str, &str), to: (&str, &str), offset: usize) {
        let ends = (self.used(from.0, offset), self.used(to.0, offset));
        if let (Some(from_node), Some(to_node)) = ends {
            self.scene.routes.push(Route {
                from: from_node,
                from_field: from.1.to_owned(),
                to: to_node,
                to_field: to.1.to_owned(),
            });
        }
    }

    /// Reads a `UNIT` statement.
    pub(super) fn unit(&mut self, category: &str, factor: &str, offset: usize) {
        let factor: f64 = factor.parse().unwrap_or(0.0);
        let good = factor.is_finite() && (1e-9..=1e9).contains(&factor);
        match category {
            "length" if good => self.scene.metres = factor,
            "angle" if good => self.scene.radians = factor,
            "length" | "angle" => {
                self.warn(
                    offset,
                    format!("the {category} unit has no positive factor; left out"),
                );
            }
            _ => {}
        }
    }

    /// Reads a `META` statement.
    pub(super) fn meta(&mut self, name: &str, content: &str) {
        if self.scene.metas.len() < MAX_METAS {
            let meta = (shortened(name).to_owned(), content.to_owned());
            self.scene.metas.push(meta);
        }
    }

    /// Reads the version of a header, such as `4.0` or `V3.3`.
    pub(super) fn version(&mut self, text: &str) {
        let digits = text.trim_start_matches(['V', 'v']);
        let major = digits.split('.').next().unwrap_or("");
        self.scene.version = major.parse().unwrap_or(self.scene.version);
    }
}

/// Returns the standard name of a node type: H-Anim 1.1 and 2001 declared prototypes without
/// prefix.
pub(super) fn standard_kind(name: &str) -> Cow<'_, str> {
    match name {
        "Humanoid" => Cow::Borrowed("HAnimHumanoid"),
        "Joint" => Cow::Borrowed("HAnimJoint"),
        "Segment" => Cow::Borrowed("HAnimSegment"),
        "Site" => Cow::Borrowed("HAnimSite"),
        "Displacer" => Cow::Borrowed("HAnimDisplacer"),
        other => Cow::Borrowed(other),
    }
}

/// Returns whether the body of a node declares fields, so that it cannot be parsed without their
/// types. Such bodies contain nothing of use here.
pub(super) fn declares_fields(kind: &str) -> bool {
    matches!(
        kind,
        "Script" | "ComposedShader" | "PackagedShader" | "ProgramShader" | "ShaderProgram"
    )
}
