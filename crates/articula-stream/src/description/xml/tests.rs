//! Bounded XML: places, texts, and what is refused.

use super::*;

fn parsed(text: &str) -> Result<Document<'_>, StreamError> {
    Document::parse(text.as_bytes(), &DescriptionLimits::default())
}

#[test]
fn elements_with_places_names_and_texts() {
    let text = "<?xml version=\"1.0\"?><a xmlns='urn:articula:VH:1' xmlns:x='urn:mpeg:mpeg21:2003:01-dia-ns'>\
                <x:b n='1 &lt; 2' x:n='3'/>t&amp;<![CDATA[<u>]]><c><d/></c></a>";
    let document = parsed(text).unwrap();
    let [a, b, c, d] = document.elements.as_slice() else {
        panic!("four elements");
    };
    assert_eq!((a.namespace, b.namespace), (Namespace::Vh, Namespace::Dia));
    assert_eq!((b.prefix, b.name, c.end, d.end), ("x:", "b", 4, 4));
    assert_eq!(&text[b.span.clone()], "<x:b n='1 &lt; 2' x:n='3'/>");
    assert_eq!(&text[c.span.clone()], "<c><d/></c>");
    assert_eq!(document.value(1, "N"), Some("1 < 2"));
    let other = document.attribute(1, Namespace::Dia, "n").unwrap();
    assert_eq!(&text[other.place.clone()], "3");
    assert_eq!(document.text(0), "t&<u>");
    assert_eq!(document.children(0).collect::<Vec<_>>(), [1, 2]);
}

#[test]
fn what_is_refused() {
    let refused = |text: &str| parsed(text).unwrap_err().to_string();
    assert!(refused("<!DOCTYPE a [<!ENTITY e 'x'>]><a>&e;</a>").contains("document type"));
    assert!(refused("<a>&e;</a>").contains("entity"));
    assert!(refused("<a b='&e;'/>").contains("cannot be read"));
    assert!(refused("<a>\n<b></a>").starts_with("line 2"));
    assert!(refused("<a><b/>").contains("truncated"));
    assert!(refused("<a/><b/>").contains("after the end"));
    assert!(refused("<a/>x").contains("outside"));
    assert!(refused("").contains("expected an element"));
    assert!(refused("<x:a/>").contains("prefix x"));
    assert!(refused("<a b='1' b='2'/>").contains("cannot be read"));
    assert!(refused("<?xml version='1.0' encoding='UTF-16'?><a/>").contains("UTF-16"));
    assert!(refused(&"<a>".repeat(65)).contains("the limit is 64"));
    let many: String = (0..65).map(|i| format!(" a{i}=''")).collect();
    assert!(refused(&format!("<a{many}/>")).contains("65 attributes"));
    assert!(refused("<a>\n\0</a>").starts_with("line 2: U+0000"));
    assert!(refused("<a>&#1;</a>").contains("does not exist"));
    assert!(refused("<a b='&#1;'/>").contains("cannot hold"));
    assert!(refused("<a b='\u{ffff}'/>").contains("U+FFFF"));
    assert!(Document::parse(b"\xff\xfe<\0a\0", &DescriptionLimits::default()).is_err());
    let limits = DescriptionLimits {
        bytes: 10,
        nodes: 2,
    };
    assert!(Document::parse(b"<a><b/></a>", &limits).is_err());
    let limits = DescriptionLimits {
        bytes: 100,
        nodes: 2,
    };
    assert!(Document::parse(b"<a><b/></a>", &limits).is_ok());
    assert!(Document::parse(b"<a><b/><b/></a>", &limits).is_err());
}

#[test]
fn what_is_escaped_comes_back() {
    let text = "a <b> & \"c\"\t\n\r'ü";
    let document = format!("<a b=\"{0}\">{0}</a>", escape(text));
    let document = parsed(&document).unwrap();
    assert_eq!(document.value(0, "b"), Some(text));
    assert_eq!(document.text(0), text);
    assert_eq!(escape("\u{1}"), "\u{fffd}");
}
