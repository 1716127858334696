//! Other programs that transform descriptions and write streams from them: xsltproc, and a script
//! in node.

use articula_stream::description::{
    AdaptMode, Holes, Selection, adapt_gbsd, gbsd_to_bin, read_gbsd, stylesheet,
};
use articula_stream::{DescriptionLimits, cut};
use quick_xml::events::Event;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

pub(crate) const LIMITS: DescriptionLimits = DescriptionLimits {
    bytes: 1 << 24,
    nodes: 1 << 18,
};

fn is_required() -> bool {
    std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1")
}

/// Whether xsltproc is installed; prints what is skipped if not.
pub(crate) fn xsltproc_is_here() -> bool {
    static HERE: OnceLock<bool> = OnceLock::new();
    let here = *HERE.get_or_init(|| Command::new("xsltproc").arg("--version").output().is_ok());
    assert!(
        here || !is_required(),
        "ARTICULA_REQUIRE_TOOLS=1, but no xsltproc"
    );
    if !here {
        println!("skipped: the stylesheet in xsltproc (it is not installed)");
    }
    here
}

fn oracle_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../oracle")
}

fn node_is_here() -> bool {
    static HERE: OnceLock<bool> = OnceLock::new();
    let here = *HERE.get_or_init(|| {
        let packages = oracle_folder().join("node_modules/jsdom").is_dir();
        packages && Command::new("node").arg("--version").output().is_ok()
    });
    assert!(
        here || !is_required(),
        "ARTICULA_REQUIRE_TOOLS=1, but no jsdom in node"
    );
    if !here {
        println!("skipped: gBSDtoBin in node (no node, or `npm ci` was not run in oracle)");
    }
    here
}

/// Cases that other programs transform and whose streams they write, too; in the end and all
/// together, since the start of a program takes longer than its work.
pub(crate) struct Judges {
    folder: PathBuf,
    has_xsltproc: bool,
    transforms: Vec<Transform>,
    jobs: String,
    expected: Vec<(String, Vec<u8>)>,
}

/// A description that xsltproc transforms, with what is expected of it and of its stream.
struct Transform {
    what: String,
    description: String,
    parameters: Vec<(&'static str, String)>,
    native: String,
    stream: Vec<u8>,
    bytes: Vec<u8>,
}

impl Judges {
    /// Uses a folder of its own.
    pub(crate) fn new(name: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("sheet.xslt"), stylesheet()).unwrap();
        Self {
            folder,
            has_xsltproc: xsltproc_is_here(),
            transforms: Vec::new(),
            jobs: String::new(),
            expected: Vec::new(),
        }
    }

    fn file(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    }

    /// Transforms descriptions in xsltproc, with a stylesheet of the folder and the same selection.
    pub(crate) fn xslt(
        &self,
        sheet: &str,
        descriptions: &[&str],
        parameters: &[(&'static str, String)],
    ) -> Result<Vec<String>, String> {
        let mut command = Command::new("xsltproc");
        for (name, value) in parameters {
            command.args(["--stringparam", name, value]);
        }
        let inputs = descriptions.iter().enumerate();
        let inputs = inputs.map(|(i, text)| self.file(&format!("in{i}.xml"), text.as_bytes()));
        let sheet = self.folder.join(sheet);
        let output = command.arg(sheet).args(inputs).output().unwrap();
        if !output.status.success() {
            return Err(String::from_utf8_lossy(&output.stderr).into_owned());
        }
        let results = documents(&String::from_utf8(output.stdout).unwrap());
        assert_eq!(results.len(), descriptions.len(), "{parameters:?}");
        Ok(results)
    }

    /// Checks that the native transformation and the cut by the map agree, and, in the end, the
    /// stylesheet.
    pub(crate) fn check(
        &mut self,
        what: &str,
        description: &str,
        stream: &[u8],
        selection: &Selection,
    ) -> Vec<u8> {
        let native = adapt_gbsd(
            description.as_bytes(),
            selection,
            AdaptMode::Conformant,
            &LIMITS,
        )
        .unwrap_or_else(|e| panic!("{what}: {e}"));
        let bytes = gbsd_to_bin(native.as_bytes(), stream, Holes::Skip, &LIMITS)
            .unwrap_or_else(|e| panic!("{what}: {e}"));
        let map = read_gbsd(description.as_bytes(), &LIMITS).unwrap().unit;
        let part = cut(stream, &map, |unit| selection.keeps(unit)).unwrap();
        assert!(
            part.bytes == bytes,
            "{what}: the cut has {} bytes, the description {}",
            part.bytes.len(),
            bytes.len()
        );
        if self.has_xsltproc {
            self.transforms.push(Transform {
                what: what.to_owned(),
                description: description.to_owned(),
                parameters: selection.parameters(),
                native,
                stream: stream.to_vec(),
                bytes: bytes.clone(),
            });
        }
        bytes
    }

    /// Compares what xsltproc makes of the descriptions, one run for all with the same parameters,
    /// and lets node write the streams of that.
    fn transform(&mut self) {
        let mut groups = BTreeMap::<_, Vec<Transform>>::new();
        for case in std::mem::take(&mut self.transforms) {
            groups
                .entry(case.parameters.clone())
                .or_default()
                .push(case);
        }
        for (parameters, cases) in groups {
            let descriptions: Vec<&str> = cases.iter().map(|c| c.description.as_str()).collect();
            let others = self.xslt("sheet.xslt", &descriptions, &parameters);
            let others = others.unwrap_or_else(|e| panic!("{parameters:?}: {e}"));
            for (case, other) in cases.iter().zip(others) {
                let what = &case.what;
                assert_eq!(canonical(&case.native), canonical(&other), "{what}");
                self.expect(what, &other, &case.stream, &case.bytes);
            }
        }
    }

    /// Lets node write the stream of a description.
    fn expect(&mut self, what: &str, description: &str, stream: &[u8], bytes: &[u8]) {
        let number = self.expected.len();
        let description = self.file(&format!("{number}.xml"), description.as_bytes());
        let stream = self.file(&format!("{number}.bin"), stream);
        let out = self.folder.join(format!("{number}.out"));
        writeln!(
            self.jobs,
            "{{\"description\": {description:?}, \"stream\": {stream:?}, \"out\": {out:?}}}"
        )
        .unwrap();
        self.expected.push((what.to_owned(), bytes.to_vec()));
    }

    /// Compares what xsltproc transforms and node writes.
    pub(crate) fn finish(mut self) {
        self.transform();
        if self.expected.is_empty() || !node_is_here() {
            return;
        }
        let mut node = Command::new("node")
            .arg(oracle_folder().join("gbsd_to_bin.mjs"))
            .stdin(Stdio::piped())
            .spawn()
            .unwrap();
        let mut input = node.stdin.take().unwrap();
        input.write_all(self.jobs.as_bytes()).unwrap();
        drop(input);
        assert!(node.wait().unwrap().success());
        for (number, (what, bytes)) in self.expected.iter().enumerate() {
            let found = std::fs::read(self.folder.join(format!("{number}.out"))).unwrap();
            assert!(found == *bytes, "{what}: node writes other bytes");
        }
    }
}

/// Documents that follow each other, each with a declaration of its own.
fn documents(text: &str) -> Vec<String> {
    let starts: Vec<usize> = text.match_indices("<?xml ").map(|(at, _)| at).collect();
    assert_eq!(starts.first(), Some(&0));
    let ends = starts[1..].iter().copied().chain([text.len()]);
    let ranges = starts.iter().zip(ends);
    ranges
        .map(|(start, end)| text[*start..end].into())
        .collect()
}

/// Elements with sorted attributes, and texts; without declarations of namespaces and comments.
pub(crate) fn canonical(text: &str) -> Vec<String> {
    let mut reader = quick_xml::Reader::from_str(text);
    reader.config_mut().expand_empty_elements = true;
    let mut out: Vec<String> = Vec::new();
    loop {
        match reader.read_event().unwrap() {
            Event::Start(start) => {
                let mut attributes: Vec<String> = start
                    .attributes()
                    .map(|a| a.unwrap())
                    .filter(|a| !a.key.into_inner().starts_with("xmlns"))
                    .map(|a| {
                        let value = a
                            .normalized_value(quick_xml::XmlVersion::Implicit1_0)
                            .unwrap();
                        format!("{}={value}", a.key.into_inner())
                    })
                    .collect();
                attributes.sort();
                let name = start.name().into_inner().to_owned();
                out.push(format!("<{name} {}", attributes.join(" ")));
            }
            Event::End(_) => out.push(">".into()),
            Event::Text(text) => add(&mut out, &text.into_inner()),
            Event::CData(text) => add(&mut out, &text.into_inner()),
            Event::Eof => break,
            _ => {}
        }
    }
    // After the last element there is only white space; that around a number says nothing.
    out.truncate(out.iter().rposition(|t| t == ">").map_or(0, |at| at + 1));
    let trimmed = |text: String| match text.strip_prefix('"') {
        Some(text) => format!("\"{}", text.trim()),
        None => text,
    };
    out.into_iter().map(trimmed).collect()
}

/// Adds a text to the one before, if there is one.
fn add(out: &mut Vec<String>, text: &str) {
    match out.last_mut() {
        Some(last) if last.starts_with('"') => last.push_str(text),
        Some(_) => out.push(format!("\"{text}")),
        // Ahead of the first element there is only white space.
        None => {}
    }
}
