use super::*;

#[test]
fn uris_are_moved() {
    let text = br#"{"asset":{"version":"2.0"},"images":[{"uri":"data:;base64,AAAA"},{"bufferView":3,"mimeType":"a"},{}]}"#;
    let mut root: Root = gltf::json::deserialize::from_slice(text).expect("it is JSON");
    let held = root.images[0].uri.as_ref().map(|uri| uri.as_ptr());
    let sources = sources(&mut root);
    assert!(root.images.iter().all(|image| image.uri.is_none()));
    let [Source::Uri(uri), Source::View(3), Source::View(usize::MAX)] = &sources[..] else {
        panic!("other sources");
    };
    assert_eq!(Some(uri.as_ptr()), held);
}
