//! Other programs that transform descriptions and write streams from them: xsltproc, and a script
//! in node.

use articula_stream::description::{
    AdaptMode, Holes, Selection, adapt_gbsd, gbsd_to_bin, read_gbsd, stylesheet,
};
use articula_stream::{DescriptionLimits, cut};
use quick_xml::events::Event;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub(crate) const LIMITS: DescriptionLimits = DescriptionLimits {
    bytes: 1 << 24,
    nodes: 1 << 18,
};

fn is_required() -> bool {
    std::env::var_os("ARTICULA_REQUIRE_TOOLS").is_some_and(|v| v == "1")
}

/// Whether xsltproc is installed; prints what is skipped if not.
pub(crate) fn xsltproc_is_here() -> bool {
    let here = Command::new("xsltproc").arg("--version").output().is_ok();
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
    let packages = oracle_folder().join("node_modules/jsdom").is_dir();
    let here = packages && Command::new("node").arg("--version").output().is_ok();
    assert!(
        here || !is_required(),
        "ARTICULA_REQUIRE_TOOLS=1, but no jsdom in node"
    );
    if !here {
        println!("skipped: gBSDtoBin in node (no node, or `npm ci` was not run in oracle)");
    }
    here
}

/// Cases whose streams other programs write, too.
pub(crate) struct Judges {
    folder: PathBuf,
    has_xsltproc: bool,
    jobs: String,
    expected: Vec<(String, Vec<u8>)>,
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
            jobs: String::new(),
            expected: Vec::new(),
        }
    }

    fn file(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.folder.join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    }

    /// Transforms a description in xsltproc, with a stylesheet of the folder.
    pub(crate) fn xslt(
        &self,
        sheet: &str,
        description: &str,
        selection: &Selection,
    ) -> Result<String, String> {
        let input = self.file("in.xml", description.as_bytes());
        let mut command = Command::new("xsltproc");
        for (name, value) in selection.parameters() {
            command.args(["--stringparam", name, &value]);
        }
        let output = command
            .arg(self.folder.join(sheet))
            .arg(input)
            .output()
            .unwrap();
        if output.status.success() {
            Ok(String::from_utf8(output.stdout).unwrap())
        } else {
            Err(String::from_utf8_lossy(&output.stderr).into_owned())
        }
    }

    /// Checks that the native transformation, the stylesheet and the cut by the map agree.
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
            let other = self.xslt("sheet.xslt", description, selection);
            let other = other.unwrap_or_else(|e| panic!("{what}: {e}"));
            assert_eq!(canonical(&native), canonical(&other), "{what}");
            self.expect(what, &other, stream, &bytes);
        }
        bytes
    }

    /// Lets node write the stream of a description later.
    pub(crate) fn expect(&mut self, what: &str, description: &str, stream: &[u8], bytes: &[u8]) {
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

    /// Compares what node writes.
    pub(crate) fn finish(self) {
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
