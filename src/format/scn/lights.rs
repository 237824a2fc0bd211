//! The statements `light` and `directional_light`.

use super::{Reader, arguments::Arguments, words::Word};
use crate::{
    error::{LoadError, SceneError},
    scene::{Light, LightShape, Spot},
};
use glam::Vec3;

const SPOT_USAGE: &str = "spot x y z INNER OUTER";
const RECTANGLE_USAGE: &str = "rectangle x y z x y z";

impl Reader<'_> {
    pub(super) fn light(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [x, y, z, intensity] = arguments.leading()?;
        let position = Vec3::from_array(arguments.numbers3([x, y, z], ["x", "y", "z"])?);
        let mut light = Light::new(LightShape::Point { position });
        light.intensity = arguments.number(intensity, "intensity")?;
        let mut named = vec![("x", x), ("y", y), ("z", z)];
        let mut shape: Option<&str> = None;
        let keys = ["color", "radius", "rectangle", "falloff", "spot"];
        while let Some((word, key)) = arguments.key_once(&keys)? {
            if let ("radius" | "rectangle", Some(first)) = (key, shape) {
                let message = format!("found `{key}` beside `{first}`, expected one shape");
                return Err(arguments.line.error_at(&word, message));
            }
            match key {
                "color" => {
                    let words = arguments.take(word, "color r g b")?;
                    light.color = arguments.color(words)?;
                }
                "radius" => {
                    shape = Some(key);
                    let [radius] = arguments.take(word, "radius number")?;
                    named.push((key, radius));
                    light.shape = sphere(&arguments, position, radius)?;
                }
                "rectangle" => {
                    shape = Some(key);
                    let words: [Word<'_>; 6] = arguments.take(word, RECTANGLE_USAGE)?;
                    let edges = rectangle(&arguments, words)?;
                    light.shape = LightShape::Rectangle {
                        center: position,
                        edges,
                    };
                    named.push(("area", words[5]));
                }
                "falloff" => {
                    let [distance] = arguments.take(word, "falloff DISTANCE")?;
                    named.push((key, distance));
                    light.falloff = Some(arguments.number(distance, key)?);
                }
                _ => light.spot = Some(spot(&mut arguments, word)?),
            }
        }
        named.push(("intensity", intensity));
        self.add_light(light, &arguments, &named)
    }

    pub(super) fn directional_light(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [x, y, z, intensity] = arguments.leading()?;
        let to_light = arguments.vector([x, y, z])?;
        let strength = arguments.number(intensity, "intensity")?;
        let mut color = [1.0; 3];
        let (mut degrees, mut degrees_word) = (0.0, z);
        while let Some((word, key)) = arguments.key_once(&["color", "angle"])? {
            if key == "color" {
                let words = arguments.take(word, "color r g b")?;
                color = arguments.color(words)?;
            } else {
                [degrees_word] = arguments.take(word, "angle DEG")?;
                degrees = arguments.number(degrees_word, key)?;
            }
        }
        let shape = LightShape::directional(to_light, degrees)
            .map_err(|error| arguments.refused(&error, &[("angle", degrees_word), (LENGTH, z)]))?;
        let light = Light {
            intensity: strength,
            color,
            ..Light::new(shape)
        };
        self.add_light(light, &arguments, &[("intensity", intensity)])
    }

    fn add_light(
        &mut self,
        light: Light,
        arguments: &Arguments<'_, '_>,
        named: &[(&str, Word<'_>)],
    ) -> Result<(), LoadError> {
        self.has_lights = true;
        let added = self.builder.add(light);
        added.map_err(|error| arguments.refused(&error, named))
    }
}

/// The name of a direction's length in errors, which is no word of a line.
const LENGTH: &str = "length";

/// A sphere, or a point if its radius is 0.
fn sphere(arguments: &Arguments<'_, '_>, center: Vec3, word: Word<'_>) -> Result<LightShape, LoadError> {
    let radius = arguments.number(word, "radius")?;
    if radius < 0.0 {
        let what = "radius";
        let error = SceneError::Negative { what, value: radius };
        return Err(arguments.refused(&error, &[(what, word)]));
    }
    Ok(if radius == 0.0 {
        LightShape::Point { position: center }
    } else {
        LightShape::Sphere { center, radius }
    })
}

fn rectangle(
    arguments: &Arguments<'_, '_>,
    [a, b, c, d, e, f]: [Word<'_>; 6],
) -> Result<[Vec3; 2], LoadError> {
    let names = ["x", "y", "z"];
    let first = arguments.numbers3([a, b, c], names)?;
    let second = arguments.numbers3([d, e, f], names)?;
    Ok([first, second].map(Vec3::from_array))
}

fn spot(arguments: &mut Arguments<'_, '_>, owner: Word<'_>) -> Result<Spot, LoadError> {
    let [x, y, z, inner, outer] = arguments.take(owner, SPOT_USAGE)?;
    let direction = arguments.vector([x, y, z])?;
    let [inner_degrees, outer_degrees] = [
        arguments.number(inner, "inner")?,
        arguments.number(outer, "outer")?,
    ];
    Spot::new(direction, inner_degrees, outer_degrees)
        .map_err(|error| arguments.refused(&error, &[("inner", inner), ("outer", outer), (LENGTH, z)]))
}
