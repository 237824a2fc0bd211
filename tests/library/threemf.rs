//! Hostile 3MF files: each is loaded or refused soon, within its memory.

use crate::targets::archive::{of_model, stored};
use octray::{
    format::{Loaded, load_any},
    scene::SceneBuilder,
};
use std::{
    path::Path,
    time::{Duration, Instant},
};

/// Far more than any file here needs on a slow, busy machine.
const MOST_TIME: Duration = Duration::from_secs(20);

const TRIANGLE: &str = "<mesh><vertices><vertex x='0' y='0' z='0'/><vertex x='1' y='0' z='0'/><vertex x='0' y='1' z='0'/>\
    </vertices><triangles><triangle v1='0' v2='1' v3='2'/></triangles></mesh>";

/// What is said about a file that may take so much memory, or how many triangles it has.
fn within(bytes: &[u8], memory: u64) -> String {
    let start = Instant::now();
    let said = match load_any(bytes, Path::new("a.3mf"), &mut Vec::new(), memory) {
        Ok(Loaded::Mesh(mesh)) => {
            let triangles = mesh.columns.triangles.len();
            let added = mesh.add_to(&mut SceneBuilder::within(memory), None);
            added.map_or_else(|error| error.to_string(), |()| triangles.to_string())
        }
        Ok(Loaded::Scene(_)) => panic!("an archive is no scene"),
        Err(error) => error.to_string(),
    };
    assert!(start.elapsed() < MOST_TIME, "{:?}: {said}", start.elapsed());
    said
}

/// Layers whose group takes their id, which would have no end.
#[test]
fn layers_are_kept_with_their_group() {
    let resources = format!(
        "<m:colorgroup id='1'><m:color color='#FF0000'/></m:colorgroup>\
         <m:multiproperties id='1' pids='1'><m:multi pindices='0'/></m:multiproperties>\
         <object id='2' pid='1' pindex='0'>{TRIANGLE}</object>"
    );
    assert_eq!(within(&model(&resources, "<item objectid='2'/>"), 1 << 30), "1");
}

fn model(resources: &str, build: &str) -> Vec<u8> {
    of_model(format!("<model><resources>{resources}</resources><build>{build}</build></model>").as_bytes())
}

/// A list of `count` elements; `%` is the number of each.
fn list(element: &str, count: usize) -> String {
    (0..count).map(|i| element.replace('%', &i.to_string())).collect()
}

#[test]
fn memory_is_counted_before_it_is_taken() {
    let triangle = format!("<object id='1'>{TRIANGLE}</object>");
    let item = "<item objectid='1'/>";
    let large = |resources: &str| model(&(resources.to_owned() + &triangle), item);
    let vertices = list("<vertex x='%' y='0' z='0'/>", 50_000);
    let files = [
        model(
            &format!("<object id='1'><mesh><vertices>{vertices}</vertices></mesh></object>{triangle}"),
            item,
        ),
        model(&triangle, &item.repeat(100_000)),
        large(&format!(
            "<object id='2'><components>{}</components></object>",
            "<component objectid='1'/>".repeat(25_000)
        )),
        large(&format!(
            "<m:colorgroup id='2'>{}</m:colorgroup>",
            "<m:color color='#000000'/>".repeat(75_000)
        )),
        large(&list(
            "<basematerials id='%'><base displaycolor='#123456'/></basematerials>",
            25_000,
        )),
        large(&list("<object id='1%'/>", 25_000)),
        large(&list("<m:texture2d id='%' path='/%.png'/>", 25_000)),
    ];
    for (i, file) in files.iter().enumerate() {
        let said = within(file, 1 << 30);
        assert!(said.parse::<usize>().is_ok(), "file {i}: {said}");
        let said = within(file, file.len() as u64 * 23 / 10);
        assert!(
            said.contains("loading takes") || said.contains("the scene takes"),
            "file {i}: {said}"
        );
    }
}

#[test]
fn time_is_bounded() {
    let triangle = format!("<object id='1'>{TRIANGLE}</object>");
    // Components that multiply, with and without anything in them.
    for (first, said) in [
        (TRIANGLE, "triangles, counted once"),
        ("", "objects and components"),
    ] {
        let doubled = (2..60).map(|i| {
            let component = format!("<component objectid='{}'/>", i - 1);
            format!("<object id='{i}'><components>{component}{component}</components></object>")
        });
        let all = format!("<object id='1'>{first}</object>{}", doubled.collect::<String>());
        let found = within(&model(&all, "<item objectid='59'/>"), u64::MAX);
        assert!(found.contains(said), "{found}");
    }
    // A long chain, from its end and from its start.
    let chain = |order: &mut dyn Iterator<Item = usize>| -> String {
        let link = |i: usize| {
            format!(
                "<object id='{i}'><components><component objectid='{}'/></components></object>",
                i - 1
            )
        };
        order.map(link).collect()
    };
    let items: String = (1..50_000).map(|i| format!("<item objectid='{i}'/>")).collect();
    for (links, build) in [
        (chain(&mut (2..50_000)), "<item objectid='49999'/>"),
        (chain(&mut (2..50_000).rev()), &items[..]),
    ] {
        let found = within(&model(&(triangle.clone() + &links), build), u64::MAX);
        assert!(found.contains("components nest more than 64 deep"), "{found}");
    }
    // Deep and long XML, many attributes, long lists.
    let deep = within(&of_model(&b"<model>".repeat(200_000)), u64::MAX);
    assert!(deep.contains("nest more than 64 deep"), "{deep}");
    let attributes = list(" a%='1'", 200_000);
    let wide = format!("<object id='1'{attributes}>{TRIANGLE}</object>");
    assert_eq!(within(&model(&wide, "<item objectid='1'/>"), u64::MAX), "1");
    let required = format!(
        "<model {attributes} xmlns:p='urn:p' requiredextensions='{}'/>",
        "p ".repeat(200_000)
    );
    let found = within(&of_model(required.as_bytes()), u64::MAX);
    assert!(found.contains("requires the extension `urn:p`"), "{found}");
    let known = required.replace(
        "urn:p",
        "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    );
    assert_eq!(within(&of_model(known.as_bytes()), u64::MAX), "0");
    let mixtures = format!(
        "<basematerials id='2'><base displaycolor='#123456'/></basematerials><m:compositematerials id='3' matid='2' \
         matindices='{}'>{}</m:compositematerials>{triangle}",
        "0 ".repeat(200_000),
        "<m:composite values='1'/>".repeat(50_000)
    );
    assert_eq!(within(&model(&mixtures, "<item objectid='1'/>"), u64::MAX), "1");
    // Many parts, and a part that many name.
    let names: Vec<String> = (0..50_000).map(|i| format!("3D/{i}.model")).collect();
    let other = format!("<model><resources>{triangle}</resources></model>");
    let parts = names.iter().map(|name| (&name[..], other.as_bytes()));
    let component = list("<component objectid='1' p:path='/3D/%.model'/>", 50_000);
    let root = format!(
        "<model><resources><object id='1'><components>{component}</components></object></resources>\
         <build><item objectid='1'/></build></model>"
    );
    let all = stored(std::iter::once(("3D/.model", root.as_bytes())).chain(parts));
    assert_eq!(within(&all, u64::MAX), "50000");
}

/// Models and archives that are cut, flipped, and repeat parts of themselves.
#[test]
fn broken_models() {
    let mut random = fastrand::Rng::with_seed(5);
    let seeds = crate::seeds::all().into_iter();
    for (_, name, seed) in seeds.filter(|(target, ..)| *target == "threemf") {
        for round in 0..1500 {
            let bytes = crate::seeds::broken(&seed, &mut random);
            println!("{name}, round {round}");
            crate::targets::threemf(&bytes);
        }
    }
}
