//! What triangles look like: base materials, colours, textures, and mixtures of these.
//!
//! Format: *3MF Materials and Properties Extension*, 3MF Consortium.

use crate::{
    error::{LoadErrorKind, quote},
    format::{
        budget::Budget,
        left_out::LeftOut,
        mesh::Surface,
        place::{TextFault, Words},
        vertices::NONE,
        xml::{Attribute, Tag, Xml},
    },
    scene::{MAX_MATERIALS, Opacity, SurfaceTextures, Texture, Wrap, is_usable},
};
use std::{
    collections::{HashMap, hash_map::Entry},
    ops::Range,
};

/// A triangle without properties.
pub(super) const NO_SURFACE: u32 = u32::MAX;

/// A triangle whose corners have colours.
pub(super) const COLORED: u32 = u32::MAX - 1;

/// Memory of an entry of a hash map, bytes: the map may be half empty, and is copied as it grows.
const ENTRY_BYTES: usize = 128;

/// The most names of unknown elements that are kept, and the most bytes of each.
const MOST_UNKNOWN: usize = 8;
const MOST_NAME: usize = 64;

/// The properties of all model parts of a file.
#[derive(Default)]
pub(super) struct Palette {
    /// Display values.
    pub(super) colors: Vec<[f32; 3]>,
    /// Their origin is the upper left corner of the texture.
    pub(super) uvs: Vec<[f32; 2]>,
    /// The number of texture coordinates that are not usable.
    pub(super) odd_uvs: usize,
    pub(super) surfaces: Vec<Surface>,
    /// The parts with the images of textures, by the index of the image.
    pub(super) images: Vec<String>,
    image_by_part: HashMap<String, u32>,
    surface_by_color: HashMap<[u8; 4], u32>,
    /// Surfaces of base materials, group after group.
    materials: Vec<u32>,
    /// Indices of layered properties into the group of the top layer.
    layers: Vec<u32>,
    pub(super) left_out: LeftOut,
    /// Names of the first few elements that octray does not know.
    pub(super) unknown: Vec<String>,
}

/// The groups of properties of one model part and its textures, by id.
#[derive(Default)]
pub(super) struct Groups {
    groups: HashMap<u32, Group>,
    textures: HashMap<u32, Texture>,
}

/// Properties of one kind, as ranges of the arrays of [`Palette`].
#[derive(Clone)]
enum Group {
    Materials(Range<usize>),
    Colors(Range<usize>),
    Uvs {
        uvs: Range<usize>,
        surface: u32,
    },
    Layers {
        indices: Range<usize>,
        of: Box<(u32, Group)>,
    },
    /// A kind that octray does not read.
    Other,
}

impl Group {
    fn len(&self) -> usize {
        match self {
            Self::Materials(range) | Self::Colors(range) => range.len(),
            Self::Uvs { uvs, .. } => uvs.len(),
            Self::Layers { indices, .. } => indices.len(),
            Self::Other => usize::MAX,
        }
    }
}

/// What a triangle looks like: its surface, and for each corner an index into the colours and into the texture
/// coordinates.
pub(super) struct Look {
    pub(super) surface: u32,
    pub(super) corners: [[u32; 2]; 3],
}

impl Look {
    pub(super) const NONE: Self = Self {
        surface: NO_SURFACE,
        corners: [[NONE; 2]; 3],
    };
}

impl Groups {
    /// Reads a resource other than an object.
    pub(super) fn read(
        &mut self,
        tag: &Tag<'_>,
        xml: &mut Xml<'_>,
        palette: &mut Palette,
        budget: &Budget,
    ) -> Result<(), TextFault> {
        let group = match tag.name() {
            b"basematerials" => palette.materials(xml, budget)?,
            b"colorgroup" => palette.colors(xml, budget)?,
            b"texture2d" => return self.texture(tag, xml, palette, budget),
            b"texture2dgroup" => self.uvs(tag, xml, palette, budget)?,
            b"compositematerials" => self.mixtures(tag, xml, palette, budget)?,
            b"multiproperties" => self.layers(tag, xml, palette, budget)?,
            name => {
                palette.leave_out(name);
                xml.skip()?;
                Group::Other
            }
        };
        if let Some(id) = tag.find("id")? {
            budget.take(ENTRY_BYTES)?;
            self.groups.insert(id.index()?, group);
        }
        Ok(())
    }

    /// An image and how it repeats.
    fn texture(
        &mut self,
        tag: &Tag<'_>,
        xml: &mut Xml<'_>,
        palette: &mut Palette,
        budget: &Budget,
    ) -> Result<(), TextFault> {
        let path = tag.get("path")?;
        budget.take(2 * (ENTRY_BYTES + path.value.len()))?;
        let next = palette.images.len() as u32;
        let image = match palette.image_by_part.entry(path.text()?) {
            Entry::Occupied(known) => *known.get(),
            Entry::Vacant(new) => {
                palette.images.push(new.key().clone());
                *new.insert(next)
            }
        };
        let wrap = |name: &str| -> Result<Wrap, TextFault> {
            let style = tag.find(name)?;
            Ok(match style.map_or(&b"wrap"[..], |style| style.value) {
                b"mirror" => Wrap::Mirror,
                b"clamp" | b"none" => Wrap::Clamp,
                _ => Wrap::Repeat,
            })
        };
        let texture = Texture {
            image,
            wrap: [wrap("tilestyleu")?, wrap("tilestylev")?],
            nearest: tag
                .find("filter")?
                .is_some_and(|filter| filter.value == b"nearest"),
        };
        self.textures.insert(tag.get("id")?.index()?, texture);
        xml.skip()
    }

    fn uvs(
        &self,
        tag: &Tag<'_>,
        xml: &mut Xml<'_>,
        palette: &mut Palette,
        budget: &Budget,
    ) -> Result<Group, TextFault> {
        let id = tag.get("texid")?;
        let Some(&texture) = self.textures.get(&id.index()?) else {
            return Err(id.fault(format!("there is no texture {} before this", quote(id.value))));
        };
        let surface = palette.add_surface(
            Surface {
                textures: SurfaceTextures {
                    base: Some(texture),
                    ..SurfaceTextures::NONE
                },
                ..Surface::WHITE
            },
            tag,
            budget,
        )?;
        let start = palette.uvs.len();
        while let Some(tag) = xml.child()? {
            if tag.name() == b"tex2coord" {
                let [u, v] = [tag.get("u")?, tag.get("v")?].map(|number| {
                    fast_float2::parse::<f32, _>(number.value.trim_ascii()).unwrap_or(f32::NAN)
                });
                let is_odd = !is_usable(u) || !is_usable(v);
                palette.odd_uvs += usize::from(is_odd);
                budget.reserve(&mut palette.uvs, 1)?;
                palette.uvs.push(if is_odd { [0.0; 2] } else { [u, 1.0 - v] });
            }
            xml.skip()?;
        }
        let uvs = start..palette.uvs.len();
        Ok(Group::Uvs { uvs, surface })
    }

    /// Mixtures of base materials, by their colours.
    fn mixtures(
        &self,
        tag: &Tag<'_>,
        xml: &mut Xml<'_>,
        palette: &mut Palette,
        budget: &Budget,
    ) -> Result<Group, TextFault> {
        let id = tag.get("matid")?;
        let Some(Group::Materials(materials)) = self.groups.get(&id.index()?).cloned() else {
            return Err(id.fault(format!(
                "there are no base materials {} before this",
                quote(id.value)
            )));
        };
        let (mut colors, mut is_transparent) = (Vec::new(), false);
        let parts = tag.get("matindices")?;
        for index in indices(&parts) {
            let index = index?;
            let surface = palette
                .materials
                .get(materials.clone())
                .and_then(|all| all.get(index as usize));
            let Some(&surface) = surface else {
                return Err(beyond(&parts, index, materials.len()));
            };
            let surface = palette
                .surfaces
                .get(surface as usize)
                .unwrap_or(&Surface::NEUTRAL);
            budget.reserve(&mut colors, 1)?;
            colors.push(surface.diffuse);
            is_transparent |= surface.textures.opacity.is_some();
        }
        if is_transparent {
            palette.left_out.add("transparency of mixtures");
        }
        let start = palette.materials.len();
        let even = mixed(&colors, &b"1 ".repeat(colors.len())).unwrap_or([0; 3]);
        while let Some(tag) = xml.child()? {
            if tag.name() == b"composite" {
                let color = mixed(&colors, tag.get("values")?.value).unwrap_or(even);
                let [red, green, blue] = color;
                palette.add_material([red, green, blue, u8::MAX], &tag, budget)?;
            }
            xml.skip()?;
        }
        budget.give_back(colors.capacity() * size_of::<[f32; 3]>());
        Ok(Group::Materials(start..palette.materials.len()))
    }

    /// Properties in layers; the top one is shown.
    fn layers(
        &self,
        tag: &Tag<'_>,
        xml: &mut Xml<'_>,
        palette: &mut Palette,
        budget: &Budget,
    ) -> Result<Group, TextFault> {
        let ids = tag.get("pids")?;
        let mut shown = None;
        for (layer, id) in indices(&ids).enumerate() {
            let id = id?;
            match self.groups.get(&id) {
                Some(Group::Other | Group::Layers { .. }) => {}
                Some(group) => shown = Some((layer, (id, group.clone()))),
                None => return Err(ids.fault(format!("there is no property group {id} before this"))),
            }
            if layer == 1 {
                palette.left_out.add("lower layers of properties");
            }
        }
        let Some((layer, of)) = shown else {
            xml.skip()?;
            return Ok(Group::Other);
        };
        let start = palette.layers.len();
        while let Some(tag) = xml.child()? {
            if tag.name() == b"multi" {
                let index = indices(&tag.get("pindices")?).nth(layer);
                budget.reserve(&mut palette.layers, 1)?;
                palette.layers.push(index.unwrap_or(Ok(0))?);
            }
            xml.skip()?;
        }
        Ok(Group::Layers {
            indices: start..palette.layers.len(),
            of: Box::new(of),
        })
    }

    /// The properties `indices` of the group `id`. Errors about the indices are at `at`.
    pub(super) fn look(
        &self,
        palette: &Palette,
        id: (u32, &Range<usize>),
        indices: [u32; 3],
        at: &Range<usize>,
    ) -> Result<Look, TextFault> {
        let (id, id_at) = id;
        let Some(group) = self.groups.get(&id) else {
            let message = format!("there is no property group {id} before this");
            return Err(TextFault::new(id_at.clone(), message));
        };
        let indices = checked(id, group, indices, at)?;
        // Layers never nest. They hold a copy of their group, because a later group may take its id.
        let (group, indices) = match group {
            Group::Layers { indices: own, of } => {
                let (id, below) = &**of;
                let layers = indices.map(|index| palette.layers[own.start + index as usize]);
                (below, checked(*id, below, layers, at)?)
            }
            group => (group, indices),
        };
        let all = |start: usize| indices.map(|index| start as u32 + index);
        Ok(match group {
            Group::Materials(range) => Look {
                // Materials do not blend: a triangle has that of its first corner.
                surface: palette.materials[range.start + indices[0] as usize],
                ..Look::NONE
            },
            Group::Colors(range) => Look {
                surface: COLORED,
                corners: all(range.start).map(|color| [color, NONE]),
            },
            Group::Uvs { uvs, surface } => Look {
                surface: *surface,
                corners: all(uvs.start).map(|uv| [NONE, uv]),
            },
            Group::Layers { .. } | Group::Other => Look::NONE,
        })
    }
}

/// Refuses properties that a group does not have.
fn checked(id: u32, group: &Group, indices: [u32; 3], at: &Range<usize>) -> Result<[u32; 3], TextFault> {
    match indices.iter().find(|&&index| index as usize >= group.len()) {
        Some(index) => {
            let message = format!("property {index}, but group {id} has only {}", group.len());
            Err(TextFault::new(at.clone(), message))
        }
        None => Ok(indices),
    }
}

impl Palette {
    fn materials(&mut self, xml: &mut Xml<'_>, budget: &Budget) -> Result<Group, TextFault> {
        let start = self.materials.len();
        while let Some(tag) = xml.child()? {
            if tag.name() == b"base" {
                if let Some(color) = tag.find("displaycolor")? {
                    let mut color = color.color()?;
                    if let [.., alpha @ 0] = &mut color {
                        // Mostly a mistake: it would be invisible.
                        *alpha = u8::MAX;
                        self.left_out.add("full transparency");
                    }
                    self.add_material(color, &tag, budget)?;
                } else {
                    budget.reserve(&mut self.materials, 1)?;
                    self.materials.push(NO_SURFACE);
                }
            }
            xml.skip()?;
        }
        Ok(Group::Materials(start..self.materials.len()))
    }

    fn colors(&mut self, xml: &mut Xml<'_>, budget: &Budget) -> Result<Group, TextFault> {
        let start = self.colors.len();
        while let Some(tag) = xml.child()? {
            if tag.name() == b"color" {
                let [color @ .., alpha] = tag.get("color")?.color()?;
                if alpha < u8::MAX {
                    self.left_out.add("transparency of vertex colours");
                }
                budget.reserve(&mut self.colors, 1)?;
                self.colors.push(color.map(|channel| f32::from(channel) / 255.0));
            }
            xml.skip()?;
        }
        Ok(Group::Colors(start..self.colors.len()))
    }

    /// Adds a base material; materials of equal colour share a surface.
    fn add_material(&mut self, color: [u8; 4], tag: &Tag<'_>, budget: &Budget) -> Result<(), TextFault> {
        let surface = if let Some(&surface) = self.surface_by_color.get(&color) {
            surface
        } else {
            budget.take(ENTRY_BYTES)?;
            let [diffuse @ .., alpha] = color.map(|channel| f32::from(channel) / 255.0);
            let surface = Surface {
                diffuse,
                textures: SurfaceTextures {
                    opacity: Opacity::new(alpha, None),
                    ..SurfaceTextures::NONE
                },
                ..Surface::WHITE
            };
            let added = self.add_surface(surface, tag, budget)?;
            *self.surface_by_color.entry(color).or_insert(added)
        };
        budget.reserve(&mut self.materials, 1)?;
        self.materials.push(surface);
        Ok(())
    }

    fn add_surface(&mut self, surface: Surface, tag: &Tag<'_>, budget: &Budget) -> Result<u32, TextFault> {
        // Two are kept for triangles without a material.
        if self.surfaces.len() + 2 >= MAX_MATERIALS {
            let message = format!("more than {} materials and textures", MAX_MATERIALS - 2);
            let fault = TextFault::new(tag.place.clone(), message);
            return Err(fault.with_kind(LoadErrorKind::Limit));
        }
        budget.reserve(&mut self.surfaces, 1)?;
        self.surfaces.push(surface);
        Ok(self.surfaces.len() as u32 - 1)
    }

    /// Notes an element that octray does not read.
    pub(super) fn leave_out(&mut self, name: &[u8]) {
        let what = match name {
            b"beamlattice" => "beam lattices",
            b"slicestack" => "slices",
            b"displacementmesh" | b"displacement2d" | b"disp2dgroup" | b"normvectorgroup" => "displacement",
            b"booleanshape" => "boolean shapes",
            b"levelset" | b"volumedata" | b"functionfromimage3d" | b"implicitfunction" | b"image3d" => {
                "volumes"
            }
            b"pbspecular"
            | b"pbspeculardisplayproperties"
            | b"pbmetallicdisplayproperties"
            | b"pbspeculartexturedisplayproperties"
            | b"pbmetallictexturedisplayproperties"
            | b"translucentdisplayproperties" => "display properties",
            // Names of sets of triangles.
            b"trianglesets" | b"metadatagroup" | b"metadata" => return,
            _ => {
                let name = String::from_utf8_lossy(name.get(..MOST_NAME).unwrap_or(name));
                if self.unknown.len() < MOST_UNKNOWN && !self.unknown.iter().any(|known| *known == name) {
                    self.unknown.push(name.into_owned());
                }
                return;
            }
        };
        self.left_out.add(what);
    }
}

/// The numbers of a list.
fn indices(attribute: &Attribute<'_>) -> impl Iterator<Item = Result<u32, TextFault>> {
    let words = Words::new(attribute.value, 0..attribute.value.len());
    words.map(|(word, place)| {
        let start = attribute.place.start;
        let place = start + place.start..start + place.end;
        let word = Attribute {
            name: attribute.name,
            value: word,
            place,
        };
        word.index()
    })
}

fn beyond(attribute: &Attribute<'_>, index: u32, count: usize) -> TextFault {
    attribute.fault(format!("base material {index}, but the group has only {count}"))
}

/// The mean of colours, weighted by a list of shares; missing ones are 0. `None` if all are 0.
fn mixed(colors: &[[f32; 3]], shares: &[u8]) -> Option<[u8; 3]> {
    let shares = Words::new(shares, 0..shares.len()).map(|(word, _)| fast_float2::parse::<f32, _>(word));
    let shares = shares.map(|share| share.unwrap_or(0.0).clamp(0.0, 1.0));
    let (mut sum, mut total) = ([0.0_f32; 3], 0.0);
    for (color, share) in colors.iter().zip(shares) {
        for (sum, channel) in sum.iter_mut().zip(color) {
            *sum += share * channel;
        }
        total += share;
    }
    (total > 0.0).then(|| sum.map(|channel| (255.0 * channel / total).round().clamp(0.0, 255.0) as u8))
}
