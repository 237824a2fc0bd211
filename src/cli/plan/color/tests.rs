use super::{COLORS, ColorMap, Shading, color_of};
use std::collections::BTreeSet;

#[test]
fn numbers_have_colours() {
    let color = |value: f64| color_of(value, [10.0, 20.0]);
    assert_eq!(color(10.0), Some(0));
    assert_eq!(color(20.0), Some(255));
    assert_eq!(color(15.0), Some(128));
    assert_eq!((color(-1e300), color(1e300)), (Some(0), Some(255)));
    assert_eq!((color(f64::NAN), color(f64::INFINITY)), (None, None));
    // Reversed, equal, and as far apart as numbers are.
    assert_eq!(color_of(10.0, [20.0, 10.0]), Some(255));
    assert_eq!(color_of(3.0, [3.0, 3.0]), Some(COLORS / 2));
    assert_eq!(color_of(0.0, [-f64::MAX, f64::MAX]), Some(128));
    assert_eq!(color_of(f64::MAX, [-f64::MAX, f64::MAX]), Some(255));
    assert!(color_of(0.0, [0.0, f64::from_bits(1)]).is_some());
}

#[test]
fn maps_have_names_and_colours() {
    let names: BTreeSet<&str> = ColorMap::ALL.map(ColorMap::name).into();
    assert_eq!(names.len(), ColorMap::ALL.len());
    for map in ColorMap::ALL {
        assert_eq!(ColorMap::named(map.name()), Some(map));
        assert_eq!(ColorMap::named(&map.name().to_uppercase()), Some(map));
        let colors = map.colors();
        assert!(
            colors
                .as_flattened()
                .iter()
                .all(|channel| (0.0..=1.0).contains(channel))
        );
        assert!(colors[0] != colors[128], "{map:?}");
    }
    assert_eq!(ColorMap::default().name(), "viridis");
    // Those of matplotlib.
    assert_eq!(
        ColorMap::default().colors()[0].map(|channel| channel * 255.0),
        [68.0, 1.0, 84.0]
    );
    assert_eq!(
        ColorMap::default().colors()[255].map(|channel| channel * 255.0),
        [253.0, 231.0, 37.0]
    );
}

#[test]
fn coordinates_have_names() {
    assert_eq!(Shading::named("z"), Shading::Coordinate(2));
    assert_eq!(Shading::named("z").name(), Some("z"));
    assert_eq!(Shading::named("Z").name(), Some("Z"));
    assert_eq!(Shading::named("quality"), Shading::Property("quality".into()));
    assert_eq!(Shading::default().name(), None);
}
