use super::*;

/// The names of all elements, each with its depth.
fn tree(text: &str) -> Result<String, String> {
    fn visit(xml: &mut Xml<'_>, depth: usize, found: &mut String) -> Result<(), TextFault> {
        while let Some(tag) = xml.child()? {
            *found += &format!("{depth}{} ", String::from_utf8_lossy(tag.name()));
            if tag.name() == b"skip" {
                xml.skip()?;
            } else {
                visit(xml, depth + 1, found)?;
            }
        }
        Ok(())
    }
    let mut found = String::new();
    let all = Xml::new(text.as_bytes()).and_then(|mut xml| visit(&mut xml, 0, &mut found));
    let path = std::path::Path::new("a");
    all.map_err(|fault| fault.into_error(text.as_bytes(), path).to_string())?;
    Ok(found)
}

#[test]
fn elements_are_walked_in_order() {
    let text =
        "\u{feff}<?xml version='1.0'?>\n<!-- <no/> --><a><b x='>'/><m:c>text &amp; <d></d></m:c></a>\n";
    assert_eq!(tree(text).as_deref(), Ok("0a 1b 1c 2d "));
    let text = "<a><skip><b/><c><skip/></c></skip><skip/><d/></a>";
    assert_eq!(tree(text).as_deref(), Ok("0a 1skip 1skip 1d "));
    assert_eq!(tree("").as_deref(), Ok(""));
}

#[test]
fn broken_xml_has_a_place() {
    let fault = |text: &str| tree(text).expect_err("it is broken");
    assert_eq!(fault("<a>\n<b></a>"), "a:2:4: found `</a>`, expected `</b>`");
    assert_eq!(fault("<a>\n<b>"), "a:2:4: the XML ends before `</b>`");
    assert_eq!(
        fault("</a>"),
        "a:1:1: found `</a>`, expected no end of an element"
    );
    assert_eq!(
        fault("<a>\n <b"),
        "a:2:2: not valid XML: syntax error: tag not closed: `>` not found before end of input"
    );
    assert_eq!(
        fault("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>"),
        "a:1:1: found a document type definition, which octray does not read"
    );
    assert_eq!(
        fault(&"<a>".repeat(100_000)),
        "a:1:193: XML elements nest more than 64 deep"
    );
    assert_eq!(
        fault("<\0a\0>\0"),
        "a:1:2: found a NUL byte: this is binary data, expected XML"
    );
}

#[test]
fn attributes_have_names_and_places() {
    let text = b"<a x=\"1.5\" m:pid=' 7' path='a&amp;b'><b c='1' bad/>";
    let mut xml = Xml::new(text).expect("it is text");
    let tag = xml.root("a").expect("there is an element");
    assert_eq!(tag.get("x").expect("it is there").place, 6..9);
    let number = |name| tag.get(name).and_then(|attribute| attribute.index());
    assert_eq!(number("pid").ok(), Some(7));
    assert!(number("x").is_err() && number("y").is_err());
    assert_eq!(
        tag.get("path").and_then(|path| path.text()).ok(),
        Some("a&b".to_owned())
    );
    assert!(tag.attributes().all(|attribute| attribute.is_ok()));
    let broken = xml.child().ok().flatten().expect("there is another");
    assert!(broken.get("c").is_ok() && broken.get("d").is_err());
    assert!(broken.attributes().any(|attribute| attribute.is_err()));
}
