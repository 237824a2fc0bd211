//! Decides which colours and textures of a file are shown, and names the others.

use super::{
    faces::Translucent,
    header::{Element, Header, Role, Step},
    slots::{COLOR_SLOT, SPLAT_COLOR, UV_SLOT},
};
use crate::{error::quote, format::left_out::LeftOut};
use serde_ply::ScalarType;

/// Names of channels of colours.
const COLORS: [&str; 11] = [
    "red",
    "green",
    "blue",
    "alpha",
    "diffuse_red",
    "diffuse_green",
    "diffuse_blue",
    "r",
    "g",
    "b",
    "a",
];

/// Names of what places textures.
const COORDINATES: [&str; 10] = [
    "s",
    "t",
    "u",
    "v",
    "texture_u",
    "texture_v",
    "texture_s",
    "texture_t",
    "texcoord",
    "texnumber",
];

/// The channels without which there is no colour.
const WHOLE_COLORS: [&[&str]; 3] = [
    &["red", "green", "blue"],
    &["diffuse_red", "diffuse_green", "diffuse_blue"],
    &["r", "g", "b"],
];

/// The coordinates without which there is no place in a texture.
const WHOLE_COORDINATES: [&[&str]; 5] = [
    &["s", "t"],
    &["u", "v"],
    &["texture_u", "texture_v"],
    &["texture_s", "texture_t"],
    &["texcoord"],
];

/// Whether a property of this name, of an element with all of these, is part of a colour, or places a texture.
pub(super) fn is_color_or_coordinate(name: &str, all: &[String]) -> bool {
    let has = |other: &str| all.iter().any(|name| name == other);
    let is_part = |groups: &[&[&str]], parts: &[&str]| {
        parts.contains(&name) && groups.iter().any(|group| group.iter().all(|part| has(part)))
    };
    is_part(&WHOLE_COLORS, &COLORS) || is_part(&WHOLE_COORDINATES, &COORDINATES)
}

impl Header {
    /// Reads what programs write into comments: `comment up z`, and MeshLab's `comment TextureFile NAME`.
    pub(super) fn read_comments(&mut self, text: &str) {
        for line in text.lines() {
            let Some(comment) = line.trim_start().strip_prefix("comment") else {
                continue;
            };
            if !comment.starts_with(char::is_whitespace) {
                continue;
            }
            let comment = comment.trim();
            let (word, rest) = comment.split_once(char::is_whitespace).unwrap_or((comment, ""));
            let rest = rest.trim_start();
            if rest.is_empty() {
                continue;
            }
            if word.eq_ignore_ascii_case("up") && !rest.contains(char::is_whitespace) {
                match rest.parse() {
                    Ok(axis) => self.up = Some(axis),
                    Err(_) => self.odd_up = Some(quote(rest.as_bytes())),
                }
            } else if word.eq_ignore_ascii_case("TextureFile") {
                let unquoted = rest.strip_prefix('"').and_then(|name| name.strip_suffix('"'));
                // As Windows writes it.
                self.textures.push(unquoted.unwrap_or(rest).replace('\\', "/"));
            }
        }
    }

    /// Makes lines of the edges of a file without faces.
    fn choose_edges(&mut self) {
        if self.has_faces() {
            return;
        }
        let mut elements = self.elements.iter_mut();
        let Some(element) = elements.find(|element| element.name == "edge" && element.count > 0) else {
            return;
        };
        let places = ["vertex1", "vertex2"].map(|end| {
            let i = element.property_names.iter().position(|name| name == end)?;
            match *element.steps.get(i)? {
                Step::Skip(scalar) if !matches!(scalar, ScalarType::F32 | ScalarType::F64) => {
                    Some((i, scalar))
                }
                _ => None,
            }
        });
        let [Some(first), Some(second)] = places else {
            return;
        };
        element.role = Role::Edge;
        for (slot, (i, scalar)) in [first, second].into_iter().enumerate() {
            element.steps[i] = Step::Keep { slot, scalar };
        }
    }

    /// Skips what would not be shown: texture coordinates without an image or faces, those of vertices if corners have
    /// some, and colours of faces if vertices have some.
    pub(super) fn choose(&mut self) {
        self.choose_edges();
        let is_corner_uvs = |step: &Step| matches!(step, Step::CornerUvs { .. });
        let has_image = !self.textures.is_empty() && self.has_faces();
        self.has_corner_uvs = has_image && self.any_step(Role::Face, is_corner_uvs);
        if !self.has_corner_uvs {
            self.skip(is_corner_uvs);
        }
        let is_uv = |step: &Step| matches!(step, Step::Keep { slot: UV_SLOT.., .. });
        self.has_uvs = has_image && !self.has_corner_uvs && self.any_step(Role::Vertex, is_uv);
        if !self.has_uvs {
            self.skip(is_uv);
        }
        let is_number = |step: &Step| matches!(step, Step::TextureNumber(_));
        self.has_texture_numbers = self.shows_textures() && self.any_step(Role::Face, is_number);
        if !self.has_texture_numbers {
            self.skip(is_number);
        }
        let is_color = |step: &Step| {
            matches!(
                step,
                Step::Keep {
                    slot: COLOR_SLOT..,
                    ..
                }
            )
        };
        self.has_face_colors = !self.has_colors && self.any_step(Role::Face, is_color);
        if !self.has_face_colors {
            let faces = self
                .elements
                .iter_mut()
                .filter(|element| element.role == Role::Face);
            for step in faces
                .flat_map(|element| &mut element.steps)
                .filter(|step| is_color(step))
            {
                *step = step.skipped();
            }
        }
    }

    /// Ignores colours and textures: values that would be faults, such as NaN, are then allowed.
    pub(super) fn skip_colors(&mut self) {
        (self.has_colors, self.has_face_colors) = (false, false);
        (self.has_uvs, self.has_corner_uvs, self.has_texture_numbers) = (false, false, false);
        self.skip(|step| {
            matches!(
                step,
                Step::Keep {
                    slot: COLOR_SLOT..,
                    ..
                } | Step::CornerUvs { .. }
                    | Step::TextureNumber(_)
            )
        });
    }

    /// Whether the vertices are Gaussian splats, and their colours coefficients.
    pub(super) fn has_splats(&self) -> bool {
        let vertices = self.elements.iter().find(|element| element.role == Role::Vertex);
        vertices.is_some_and(|element| {
            let mut properties = element.steps.iter().zip(&element.property_names);
            properties.any(|(step, name)| {
                name == SPLAT_COLOR[0] && matches!(step, Step::Keep { slot: COLOR_SLOT, .. })
            })
        })
    }

    /// Whether there are images and coordinates on them.
    pub(super) fn shows_textures(&self) -> bool {
        self.has_uvs || self.has_corner_uvs
    }

    /// Whether a record of this role has such a property.
    fn any_step(&self, role: Role, is: impl Fn(&Step) -> bool) -> bool {
        let elements = self.elements.iter();
        let mut elements = elements.filter(|element| element.role == role && element.count > 0);
        elements.any(|element| element.steps.iter().any(&is))
    }

    /// Skips such properties.
    fn skip(&mut self, is: impl Fn(&Step) -> bool) {
        let steps = self.elements.iter_mut().flat_map(|element| &mut element.steps);
        for step in steps.filter(|step| is(step)) {
            *step = step.skipped();
        }
    }

    /// The contents of the file that are not read.
    pub(super) fn left_out(&self, translucent: Translucent) -> LeftOut {
        let mut left_out = LeftOut::default();
        for element in self.elements.iter().filter(|element| element.count > 0) {
            let noun = match element.role {
                Role::Vertex => "vertex",
                Role::Face => "face",
                Role::Strips => "strip",
                Role::Edge => "edge",
                Role::Other => {
                    let name = quote(element.name.as_bytes());
                    let (one, many) = (format!("{name} record"), format!("{name} records"));
                    left_out.count(element.count, &one, &many);
                    continue;
                }
            };
            self.add_properties(element, noun, &mut left_out);
            let is_translucent = match element.role {
                Role::Vertex => translucent.vertex,
                Role::Face => translucent.face,
                _ => false,
            };
            if is_translucent {
                left_out.add(&format!("{noun} alpha"));
            }
        }
        if let Some(word) = &self.odd_up {
            left_out.add(&format!("a comment that {word} is up, which is no axis"));
        }
        if !self.textures.is_empty() && !self.shows_textures() && !self.shows_numbers {
            left_out.add("textures");
        }
        left_out
    }

    /// Adds the properties of an element that are skipped, unless all make way for numbers.
    fn add_properties(&self, element: &Element, noun: &str, left_out: &mut LeftOut) {
        if self.shows_numbers {
            return;
        }
        let is_left_out = |step: &Step| matches!(step, Step::Skip(_) | Step::SkipList { .. });
        let names = element.steps.iter().zip(&element.property_names);
        let (mut others, mut is_splat) = (Vec::new(), false);
        for (_, name) in names.filter(|(step, _)| is_left_out(step)) {
            match name.as_str() {
                name if self.has_splats() && is_of_splat(name) => is_splat = true,
                // Where all are opaque, nothing is lost.
                "alpha" | "a" if element.keeps(COLOR_SLOT) => {}
                name if COLORS.contains(&name) => {
                    let more = if element.keeps(COLOR_SLOT) { "more " } else { "" };
                    left_out.add(&format!("{more}{noun} colours"));
                }
                name if COORDINATES.contains(&name) => {
                    // MeshLab writes those of corners and those of vertices, which are the same where they can be.
                    if !(self.has_corner_uvs && element.role == Role::Vertex) {
                        let more = if self.shows_textures() { "more " } else { "" };
                        left_out.add(&format!("{more}texture coordinates"));
                    }
                }
                name => others.push(name),
            }
        }
        if is_splat {
            left_out.add("shapes, opacity and reflections of Gaussian splats");
        }
        left_out.names(&format!("{noun} properties"), others);
    }
}

/// Whether programs write this property for Gaussian splats.
fn is_of_splat(name: &str) -> bool {
    name == "opacity"
        || ["f_rest_", "scale_", "rot_"]
            .iter()
            .any(|start| name.starts_with(start))
}
