//! The meaning of each statement. `docs/scene-language.md` is the reference.

use super::{
    Place, Reader, Seen,
    arguments::{Arguments, IN_SINGLE_PRECISION, is_not_0},
    nearest::nearest,
    words::Word,
};
use crate::{
    error::{LoadError, SceneError, quote},
    scene::{Background, Checker, MAX_ALPHA, Material, MaterialId, Opacity, SurfaceTextures},
};
use glam::Vec3;

/// The kinds of materials; the first four in the order of their classic numbers.
const KINDS: [&str; 5] = ["silhouette", "matte", "blinn_phong", "reflection", "glass"];

/// Names of materials in other programs.
const OTHER_NAMES: [(&str, &str); 8] = [
    ("phong", "blinn_phong"),
    ("blinn", "blinn_phong"),
    ("mirror", "reflection"),
    ("diffuse", "matte"),
    ("lambert", "matte"),
    ("dielectric", "glass"),
    ("refraction", "glass"),
    ("transparent", "glass"),
];

/// Gives meshes the materials of their files again, as before the first `material`.
const OWN: &str = "own";
/// May follow it: their colours and textures are decoded from sRGB.
const SRGB: &str = "srgb";

const BACKGROUND_USAGE: &str = "background r g b";

/// The statements and how they are written.
pub(super) const STATEMENTS: [(&str, &str); 17] = [
    ("light", "light x y z intensity"),
    ("directional_light", "directional_light x y z intensity"),
    ("sphere", "sphere x y z radius"),
    ("triangle", "triangle x y z x y z x y z"),
    ("plane", "plane x y z normal x y z"),
    ("mesh", "mesh PATH"),
    ("instance", "instance PATH"),
    ("ply_file", "ply_file PATH"),
    ("material", "material NAME"),
    ("camera", "camera eye x y z target x y z"),
    ("background", BACKGROUND_USAGE),
    ("environment", "environment PATH"),
    ("ambient", "ambient intensity"),
    ("ambient_specular", "ambient_specular"),
    ("smooth_shadows", "smooth_shadows"),
    ("at", "at T"),
    ("include", "include PATH"),
];

impl Reader<'_> {
    /// Reads a statement, one of [`STATEMENTS`].
    pub(super) fn statement(&mut self, arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        match arguments.name {
            "light" => self.light(arguments),
            "directional_light" => self.directional_light(arguments),
            "sphere" => self.sphere(arguments),
            "triangle" => self.triangle(arguments),
            "plane" => self.plane(arguments),
            "mesh" => self.mesh(arguments),
            "instance" => self.instance(arguments),
            "ply_file" => self.ply_file(arguments),
            "material" => self.material(arguments),
            "camera" => self.camera(arguments),
            "background" => self.background(arguments),
            "environment" => self.environment(arguments),
            "ambient" => self.ambient(arguments),
            "ambient_specular" => self.ambient_specular(&arguments),
            "smooth_shadows" => self.smooth_shadows(&arguments),
            "at" => self.at(arguments),
            _ => self.include(arguments),
        }
    }

    fn sphere(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [x, y, z, radius] = arguments.leading()?;
        arguments.end()?;
        let center = arguments.numbers3([x, y, z], ["x", "y", "z"])?;
        let size = arguments.number(radius, "radius")?;
        let material = self.shape_material();
        self.builder
            .add_sphere(Vec3::from_array(center), size, material)
            .map_err(|error| arguments.refused(&error, &[("x", x), ("y", y), ("z", z), ("radius", radius)]))
    }

    fn triangle(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let words: [Word<'_>; 9] = arguments.leading()?;
        arguments.end()?;
        let names = ["x", "y", "z"];
        let [a, b, c, d, e, f, g, h, i] = words;
        let mut corners = [Vec3::ZERO; 3];
        for (corner, words) in corners.iter_mut().zip([[a, b, c], [d, e, f], [g, h, i]]) {
            *corner = Vec3::from_array(arguments.numbers3(words, names)?);
        }
        let named: Vec<_> = names.into_iter().cycle().zip(words).collect();
        let material = self.shape_material();
        self.builder
            .add_triangle(corners, material)
            .map_err(|error| arguments.refused(&error, &named))
    }

    fn plane(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let words: [Word<'_>; 3] = arguments.leading()?;
        let names = ["x", "y", "z"];
        let point = arguments.numbers3(words, names)?;
        arguments.needs = &["normal"];
        let Some((key, _)) = arguments.key_once(&["normal"])? else {
            return Err(arguments.missing("normal", words[2].end()));
        };
        let across = arguments.take(key, "normal x y z")?;
        let normal = arguments.numbers3(across, names)?;
        arguments.end()?;
        let named: Vec<_> = names
            .into_iter()
            .cycle()
            .zip(words.into_iter().chain(across))
            .collect();
        let material = self.shape_material();
        self.builder
            .add_plane(Vec3::from_array(point), Vec3::from_array(normal), material)
            .map_err(|error| match error {
                SceneError::NotPositive { what, value: 0.0 } if across.into_iter().any(is_not_0) => {
                    let normal = across.map(|word| word.number()).join(" ");
                    let message =
                        format!("{what} is that of {normal}{IN_SINGLE_PRECISION}, expected a number above 0");
                    arguments.line.error_at(&across[2], message)
                }
                error => arguments.refused(&error, &named),
            })
    }

    /// The material of the next shape that has none of its own.
    pub(super) fn shape_material(&mut self) -> MaterialId {
        self.needs_light |= !self.is_silhouette;
        self.material.unwrap_or_default()
    }

    fn material(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [name] = arguments.leading()?;
        if name.text == OWN.as_bytes() {
            self.own_is_srgb = arguments.peek().is_some_and(|word| word.text == SRGB.as_bytes());
            let expected = if self.own_is_srgb {
                arguments.next();
                "the end of the line".to_owned()
            } else {
                format!("`{SRGB}` or the end of the line")
            };
            if let Some(extra) = arguments.peek() {
                let message = format!(
                    "found {} after `material own`, expected {expected}",
                    quote(extra.text)
                );
                return Err(arguments.unexpected(&extra, message));
            }
            self.material = None;
            self.is_silhouette = true;
            return Ok(());
        }
        let Some(kind) = KINDS.iter().position(|kind| kind.as_bytes() == name.text) else {
            let classic = self.classic_material(&arguments, name)?;
            if let Some(extra) = arguments.peek() {
                let kind = KINDS.get(classic.0 as usize).unwrap_or(&"");
                let message = format!(
                    "found {} after `material NUMBER`, expected the end of the line; constants follow a name, such as \
                     `material {kind}`",
                    quote(extra.text)
                );
                return Err(arguments.unexpected(&extra, message));
            }
            self.material = Some(classic);
            self.is_silhouette = classic == MaterialId::default();
            return Ok(());
        };
        let (material, textures, named) = read_material(kind, &mut arguments)?;
        // Glass shows what is around it, so it needs no light either.
        self.is_silhouette = matches!(material, Material::Silhouette { .. } | Material::Glass { .. });
        let added = self.builder.add_textured_material(material, textures);
        self.material = Some(added.map_err(|error| arguments.refused(&error, &named))?);
        Ok(())
    }

    fn classic_material(
        &self,
        arguments: &Arguments<'_, '_>,
        word: Word<'_>,
    ) -> Result<MaterialId, LoadError> {
        word.as_str()
            .and_then(|text| text.parse().ok())
            .and_then(|number| self.builder.classic_material(number).ok())
            .ok_or_else(|| {
                let found = quote(word.text);
                let other_name = OTHER_NAMES.iter().find(|(name, _)| name.as_bytes() == word.text);
                let meant = other_name.map(|(_, kind)| *kind);
                let message = match meant.or_else(|| nearest(word.text, KINDS.into_iter().chain([OWN]))) {
                    Some(near) => format!("unknown material {found}, did you mean `{near}`?"),
                    None => format!(
                        "unknown material {found}, expected 0 (silhouette), 1 (matte), 2 (blinn_phong), 3 (reflection), \
                         one of these names, `glass` or `own`"
                    ),
                };
                arguments.line.error_at(&word, message)
            })
    }

    fn background(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let is_gradient = arguments
            .peek()
            .is_some_and(|word| nearest(word.text, ["bottom", "top"]).is_some());
        let background = if is_gradient {
            arguments.gradient("background bottom r g b top r g b")?
        } else {
            let words = arguments.leading()?;
            arguments.hint = " (two colours: `background bottom r g b top r g b`)";
            arguments.end()?;
            Background::constant(arguments.color(words)?)
        };
        Seen::once(
            &mut self.seen.background,
            &arguments,
            "`background` or `environment`",
        )?;
        let set = self.builder.set_background(background);
        set.map_err(|error| arguments.refused(&error, &[]))
    }

    fn ambient(&mut self, mut arguments: Arguments<'_, '_>) -> Result<(), LoadError> {
        let [word] = arguments.leading()?;
        let ambient = arguments.share(word, "ambient")?;
        let mut reach = None;
        while let Some((key, _)) = arguments.key_once(&["reach"])? {
            let [word] = arguments.take(key, "reach number")?;
            reach = Some((arguments.number(word, "reach")?, word));
        }
        Seen::once(&mut self.seen.ambient, &arguments, "`ambient`")?;
        self.has_lights |= ambient > 0.0;
        let set = self.builder.set_ambient(ambient);
        set.map_err(|error| arguments.refused(&error, &[("ambient", word)]))?;
        let Some((reach, word)) = reach else {
            return Ok(());
        };
        let set = self.builder.set_ambient_reach(Some(reach));
        set.map_err(|error| arguments.refused(&error, &[("reach", word)]))
    }

    fn ambient_specular(&mut self, arguments: &Arguments<'_, '_>) -> Result<(), LoadError> {
        arguments.end()?;
        Seen::once(&mut self.seen.ambient_specular, arguments, "`ambient_specular`")?;
        self.builder.set_ambient_specular(true);
        Ok(())
    }

    fn smooth_shadows(&mut self, arguments: &Arguments<'_, '_>) -> Result<(), LoadError> {
        arguments.end()?;
        Seen::once(&mut self.seen.smooth_shadows, arguments, "`smooth_shadows`")?;
        self.builder.set_smooth_shadows(true);
        Ok(())
    }
}

/// Words by their role.
type Named<'a> = Vec<(&'static str, Word<'a>)>;

/// A material of a kind: the defaults, with the constants of keys replaced. Its colour is white if it has a checkerboard.
/// Also returns its textures, and the numbers that only the builder checks, by their keys.
fn read_material<'a>(
    kind: usize,
    arguments: &mut Arguments<'_, 'a>,
) -> Result<(Material, SurfaceTextures, Named<'a>), LoadError> {
    let mut material = Material::CLASSIC.get(kind).copied().unwrap_or(Material::GLASS);
    let mut named = Named::new();
    let (mut other, mut size, mut opacity, mut tinted) = (None, None, None, None);
    let (name, keys) = keys_of(&material);
    arguments.name = name;
    while let Some((word, key)) = arguments.key_once(keys)? {
        if matches!(key, "cd" | "cs" | "tint" | "checker") {
            let words = arguments.take(word, &format!("{key} r g b"))?;
            let given = arguments.color(words)?;
            match (key, &mut material) {
                ("checker", _) => other = Some(given),
                ("cs", Material::BlinnPhong { specular, .. }) => *specular = given,
                (_, material) => *material.base_color_mut() = given,
            }
            continue;
        }
        if key == "tinted" {
            tinted = Some(word);
            continue;
        }
        let [value] = arguments.take(word, &format!("{key} number"))?;
        match (key, &mut material) {
            ("size", _) => {
                size = Some((arguments.number(value, key)?, value));
                named.push((key, value));
            }
            ("opacity", _) => opacity = Some(arguments.share(value, key)?),
            ("alpha", Material::BlinnPhong { alpha, .. }) => {
                *alpha = arguments.whole(value, key, (1, MAX_ALPHA))?;
            }
            ("kd", Material::BlinnPhong { k_d, .. }) => *k_d = arguments.share(value, key)?,
            (_, Material::BlinnPhong { k_s, .. }) => *k_s = arguments.share(value, key)?,
            (_, Material::Reflection { mirror_share, .. }) => *mirror_share = arguments.share(value, key)?,
            (_, Material::Glass { index, depth, .. }) => {
                *(if key == "ior" { index } else { depth }) = arguments.number(value, key)?;
                named.push((key, value));
            }
            (_, Material::Silhouette { .. } | Material::Matte { .. }) => {}
        }
    }
    let textures = SurfaceTextures {
        checker: checker(arguments, &mut material, other, size)?,
        opacity: see_through(arguments, opacity, tinted)?,
        ..SurfaceTextures::NONE
    };
    Ok((material, textures, named))
}

/// The name of a kind of material, and its keys.
fn keys_of(material: &Material) -> (&'static str, &'static [&'static str]) {
    match material {
        Material::Silhouette { .. } => ("material silhouette", &["cd", "opacity", "tinted"]),
        Material::Matte { .. } => ("material matte", &["cd", "opacity", "tinted", "checker", "size"]),
        Material::BlinnPhong { .. } => (
            "material blinn_phong",
            &[
                "cd", "cs", "kd", "ks", "alpha", "opacity", "tinted", "checker", "size",
            ],
        ),
        Material::Reflection { .. } => (
            "material reflection",
            &["cd", "mix", "opacity", "tinted", "checker", "size"],
        ),
        Material::Glass { .. } => ("material glass", &["ior", "tint", "depth"]),
    }
}

/// The opacity of a material; `None` if it is opaque.
fn see_through(
    arguments: &Arguments<'_, '_>,
    factor: Option<f32>,
    tinted: Option<Word<'_>>,
) -> Result<Option<Opacity>, LoadError> {
    if let (None, Some(word)) = (factor, tinted) {
        let message = "`tinted` without `opacity a`, how much of its own colour it shows";
        return Err(arguments.line.error_at(&word, message));
    }
    let opacity = factor.and_then(|factor| Opacity::new(factor, None));
    Ok(opacity.map(|opacity| Opacity {
        is_tinted: tinted.is_some(),
        ..opacity
    }))
}

/// The checkerboard of a material and `other`, which takes its colour.
fn checker(
    arguments: &Arguments<'_, '_>,
    material: &mut Material,
    other: Option<[f32; 3]>,
    size: Option<(f32, Word<'_>)>,
) -> Result<Option<Checker>, LoadError> {
    match (other, size) {
        (None, None) => Ok(None),
        (None, Some((_, word))) => {
            let message = "`size` without `checker r g b`, the colour of every second cell";
            Err(arguments.line.error_at(&word, message))
        }
        (Some(other), size) => Ok(Some(Checker {
            colors: [std::mem::replace(material.base_color_mut(), [1.0; 3]), other],
            size: size.map_or(1.0, |(size, _)| size),
        })),
    }
}

/// The error about a repeated statement.
pub(super) fn again(arguments: &Arguments<'_, '_>, what: &str, first: &Place) -> LoadError {
    let mut message = format!("second {what}, expected one; the first is at {}", first.at);
    if first.at == Place::of(arguments).at {
        let mut includes = first.includes.iter().zip(arguments.line.includes);
        if let Some((other, _)) = includes.find(|(first, second)| first != second) {
            message += &format!(", included at {other}");
        }
    }
    arguments.line.error_at(&arguments.keyword, message)
}
