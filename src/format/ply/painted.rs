//! Faces with colours or textures, read value by value.

use super::{
    at::At,
    faces::{Faces, UNKNOWN_UV, upper_left},
    fault::Fault,
    header::{Element, Header, Step, color_scale},
    rows::{Values, Wrong, end_record, list_length, read_corners, skip, uv_number},
    slots::{COLOR_SLOT, VALUE_SLOT},
};
use crate::{
    format::{
        budget::{Budget, BudgetError},
        mesh::Owner,
        vertices::NONE,
    },
    scene::MAX_MATERIALS,
};
use serde_ply::ScalarType;
use std::collections::HashMap;

/// A triangle without texture coordinates.
const NO_UVS: [[u32; 2]; 3] = [[NONE; 2]; 3];

/// How many looks may have exact colours; further ones are rounded. A scene needs other materials, too.
const MOST_EXACT: usize = MAX_MATERIALS / 2;

/// How many looks may have a colour.
const MOST_COLORED: usize = MAX_MATERIALS / 4 * 3;

/// Longer lists of texture coordinates are skipped.
const MOST_NUMBERS: usize = 1 << 20;

/// How many steps a channel of a rounded colour has.
const STEPS: f32 = 31.0;

/// Memory of an entry of [`Paint::index_of`], bytes: the map may be half empty, and is copied as it grows.
const ENTRY_BYTES: usize = 96;

/// What a face shows.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Look {
    /// The bits of its colour.
    pub(super) color: Option<[u32; 3]>,
    /// The number of its texture.
    pub(super) texture: Option<u32>,
}

/// The colours and textures of faces.
#[derive(Default)]
pub(super) struct Paint {
    /// The bits of the texture coordinates of each triangle's corners; empty unless the file has some.
    pub(super) uvs: Vec<[[u32; 2]; 3]>,
    /// What faces show, each look once.
    pub(super) looks: Vec<Look>,
    /// An index into `looks` for each triangle; empty if no face has a colour or a texture.
    pub(super) look_of: Vec<u32>,
    /// The index of each look in `looks`.
    index_of: HashMap<Look, u32>,
    /// The index of the last look.
    last: u32,
    /// How many triangles have no texture coordinates.
    pub(super) untextured: usize,
    /// How many faces have the number of a texture that is not there.
    pub(super) wrong_numbers: usize,
    /// How many faces have a colour that is not from 0 to 1.
    pub(super) clamped: usize,
    /// How many faces have a rounded colour, or none, because there are too many colours.
    pub(super) rounded: usize,
}

/// A face while it is read.
#[derive(Default)]
struct Face {
    uvs: Vec<[f32; 2]>,
    /// Whether some numbers of the list are not in `uvs`: it has an odd length, or is too long.
    is_incomplete: bool,
    texture: Option<u32>,
    color: [f32; 3],
    /// What is shown instead.
    value: f64,
}

/// Reads faces and what they show.
pub(super) fn read_faces<V: Values>(
    element: &Element,
    header: &Header,
    values: &mut V,
    faces: &mut Faces<'_>,
) -> Result<(), Fault> {
    let budget = faces.budget;
    let alpha = element.alpha();
    let mut face = Face::default();
    if header.has_corner_uvs {
        let triangles = faces.triangles.capacity();
        budget.reserve(&mut faces.paint.uvs, triangles)?;
    }
    for record in 1..=element.count {
        let start = values.begin_record();
        let at = |step_i| At {
            element,
            step_i,
            start,
            record,
        };
        let before = faces.triangles.len();
        face.uvs.clear();
        for (step_i, step) in element.steps.iter().enumerate() {
            let at = at(step_i);
            match *step {
                Step::Indices { count, item } => {
                    let corners = list_length(count, item, values, &at)?;
                    read_corners(corners, item, header.vertices, values, faces, &at)?;
                }
                Step::CornerUvs { count, item } => {
                    let length = list_length(count, item, values, &at)?;
                    faces.odd_uvs += face.read_uvs(length, item, values, &at, budget)?;
                }
                Step::Keep {
                    slot: VALUE_SLOT,
                    scalar,
                } => face.value = values.double(scalar).map_err(|wrong| at.wrong(values, wrong))?,
                Step::TextureNumber(scalar) => face.texture = texture_number(scalar, values, &at)?,
                Step::Keep { slot, scalar } => {
                    let value = values.real(scalar).map_err(|wrong| at.wrong(values, wrong))?;
                    if !value.is_finite() {
                        return Err(at.unusable(values, slot, value));
                    }
                    if let Some(channel) = face.color.get_mut(slot - COLOR_SLOT) {
                        *channel = value / color_scale(scalar);
                    }
                }
                Step::Skip(scalar) if alpha == Some(step_i) => {
                    faces.translucent.face |= is_translucent(scalar, values, &at)?;
                }
                _ => skip(step, values, &at)?,
            }
        }
        end_record(&at(0), values)?;
        faces.paint_from(before, &face, header)?;
    }
    budget.give_back(face.uvs.capacity() * size_of::<[f32; 2]>());
    Ok(())
}

/// The number of a texture; `None` for any other value.
fn texture_number<V: Values>(scalar: ScalarType, values: &mut V, at: &At<'_>) -> Result<Option<u32>, Fault> {
    match values.whole(scalar) {
        Ok(number) => Ok(u32::try_from(number).ok()),
        Err(Wrong::End) => Err(at.wrong(values, Wrong::End)),
        Err(_) => Ok(None),
    }
}

/// Reads an alpha and returns whether it is less than opaque.
pub(super) fn is_translucent<V: Values>(
    scalar: ScalarType,
    values: &mut V,
    at: &At<'_>,
) -> Result<bool, Fault> {
    match values.real(scalar) {
        Ok(alpha) => Ok(alpha != color_scale(scalar)),
        Err(Wrong::End) => Err(at.wrong(values, Wrong::End)),
        Err(_) => Ok(true),
    }
}

impl Face {
    /// Reads a list of texture coordinates and returns how many are not usable.
    fn read_uvs<V: Values>(
        &mut self,
        length: usize,
        item: ScalarType,
        values: &mut V,
        at: &At<'_>,
        budget: &Budget,
    ) -> Result<usize, Fault> {
        let pairs = if length > MOST_NUMBERS { 0 } else { length / 2 };
        budget.reserve(&mut self.uvs, pairs)?;
        self.is_incomplete = length != 2 * pairs;
        let mut odd = 0;
        for _ in 0..pairs {
            let uv = upper_left([uv_number(item, values, at)?, uv_number(item, values, at)?]);
            odd += usize::from(uv.is_none());
            self.uvs.push(uv.unwrap_or(UNKNOWN_UV));
        }
        let last = values.skip(item, length - 2 * pairs);
        last.map_err(|wrong| at.wrong(values, wrong))?;
        Ok(odd)
    }
}

impl Faces<'_> {
    /// Paints the triangles from `start` on, which are one face.
    fn paint_from(&mut self, start: usize, face: &Face, header: &Header) -> Result<(), BudgetError> {
        let end = self.triangles.len();
        if start == end {
            return Ok(());
        }
        self.paint_plain(start, header)?;
        if header.valued == Some(Owner::Faces) {
            return self.add_value(face.value, end);
        }
        let (paint, budget) = (&mut self.paint, self.budget);
        let mut texture = header.shows_textures().then_some(0);
        if header.has_texture_numbers {
            texture = face
                .texture
                .filter(|&number| (number as usize) < header.textures.len());
            paint.wrong_numbers += usize::from(texture.is_none());
        }
        if header.has_corner_uvs {
            budget.reserve(&mut paint.uvs, end - start)?;
            match &face.uvs[..] {
                [first, others @ ..] if others.len() == end - start + 1 && !face.is_incomplete => {
                    let fan = others.windows(2).map(|pair| [*first, pair[0], pair[1]]);
                    let bits = fan.map(|uvs| uvs.map(|uv| uv.map(f32::to_bits)));
                    paint.uvs.extend(bits);
                }
                _ => {
                    paint.uvs.resize(end, NO_UVS);
                    if texture.take().is_some() {
                        paint.untextured += end - start;
                    }
                }
            }
        }
        let color = header.has_face_colors.then(|| {
            let clamped = face.color.map(|channel| channel.clamp(0.0, 1.0));
            paint.clamped += usize::from(clamped != face.color);
            clamped.map(f32::to_bits)
        });
        paint.add(Look { color, texture }, end, budget)
    }

    /// Gives a number to the triangles before `end` that have none yet.
    fn add_value(&mut self, value: f64, end: usize) -> Result<(), BudgetError> {
        let values = &mut self.values.of_faces;
        self.budget.reserve(values, end - values.len())?;
        values.resize(end, value);
        Ok(())
    }

    /// Paints the triangles before `end` that are not painted yet: strips, and faces without colours.
    pub(super) fn paint_plain(&mut self, end: usize, header: &Header) -> Result<(), BudgetError> {
        if header.valued == Some(Owner::Faces) {
            return self.add_value(f64::NAN, end);
        }
        let (paint, budget) = (&mut self.paint, self.budget);
        let missing = end - paint.look_of.len();
        if missing == 0 || !(header.shows_textures() || header.has_face_colors) {
            return Ok(());
        }
        if header.has_corner_uvs {
            budget.reserve(&mut paint.uvs, missing)?;
            paint.uvs.resize(end, NO_UVS);
            paint.untextured += missing;
        }
        let look = Look {
            color: None,
            texture: header.has_uvs.then_some(0),
        };
        paint.add(look, end, budget)
    }
}

impl Paint {
    /// Paints triangles that are a face each.
    #[cfg(any(feature = "cli", feature = "vtk"))]
    pub(super) fn of(colors: &[[f32; 3]], budget: &Budget) -> Result<Self, BudgetError> {
        let mut paint = Self::default();
        budget.reserve(&mut paint.look_of, colors.len())?;
        for (end, color) in (1..).zip(colors) {
            let look = Look {
                color: Some(color.map(f32::to_bits)),
                texture: None,
            };
            paint.add(look, end, budget)?;
        }
        paint.forget_looks(budget);
        Ok(paint)
    }

    /// Gives a look to the triangles up to `end`.
    fn add(&mut self, mut look: Look, end: usize, budget: &Budget) -> Result<(), BudgetError> {
        if self.looks.get(self.last as usize) != Some(&look) {
            let possible = self.within_limits(look);
            self.rounded += usize::from(possible != look);
            look = possible;
            self.last = match self.index_of.get(&look) {
                Some(&index) => index,
                None => self.add_look(look, budget)?,
            };
        }
        let missing = end - self.look_of.len();
        budget.reserve(&mut self.look_of, missing)?;
        self.look_of.resize(end, self.last);
        Ok(())
    }

    /// A look within the limits: this one, or one that is rounded or has no colour.
    fn within_limits(&self, look: Look) -> Look {
        let fits = |look: &Look, most| self.looks.len() < most || self.index_of.contains_key(look);
        if look.color.is_none() || fits(&look, MOST_EXACT) {
            return look;
        }
        let round = |bits: u32| ((f32::from_bits(bits) * STEPS).round() / STEPS).to_bits();
        let color = look.color.map(|color| color.map(round));
        let rounded = Look { color, ..look };
        if fits(&rounded, MOST_COLORED) {
            return rounded;
        }
        Look { color: None, ..look }
    }

    fn add_look(&mut self, look: Look, budget: &Budget) -> Result<u32, BudgetError> {
        budget.take(ENTRY_BYTES)?;
        let reserved = self.index_of.try_reserve(1);
        reserved.map_err(|_| BudgetError::NoMemory)?;
        budget.reserve(&mut self.looks, 1)?;
        let index = self.looks.len() as u32;
        self.looks.push(look);
        self.index_of.insert(look, index);
        Ok(index)
    }

    /// Frees the lookup table of looks.
    pub(super) fn forget_looks(&mut self, budget: &Budget) {
        budget.give_back(self.index_of.len() * ENTRY_BYTES);
        self.index_of = HashMap::new();
    }
}
