//! A model part: its objects and what it builds.
//!
//! Formats: *3MF Core Specification* and *3MF Production Extension*, 3MF Consortium.

use super::properties::{Groups, Look, Palette};
use crate::{
    error::{LoadErrorKind, SceneError, quote},
    format::{
        budget::{Budget, BudgetError},
        offset::Offset,
        place::{TextFault, Words},
        vertices::{NONE, Vertices},
        xml::{Attribute, Tag, Xml},
    },
    scene::is_usable,
};
use glam::{DAffine3, DVec3};
use std::{collections::HashMap, ops::Range};

/// Memory of an object besides its arrays, bytes: the map may be half empty, and is copied as it grows.
const OBJECT_BYTES: usize = 768;

/// Memory of a part's name in a reference, bytes.
const NAME_BYTES: usize = 32;

/// The most required extensions that are checked.
const MOST_EXTENSIONS: usize = 64;

/// Extensions that octray reads, or that change nothing it shows.
const READ: [&str; 8] = [
    "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
    "http://schemas.3mf.io/3dmanufacturing/production/",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/",
    "http://schemas.microsoft.com/3dmanufacturing/slice/",
    "http://schemas.microsoft.com/3dmanufacturing/packages/",
    "http://schemas.microsoft.com/3dmanufacturing/2013/01",
];

/// Names of unsupported extensions in errors, by a part of their namespace.
const NOT_READ: [(&str, &str); 6] = [
    ("beamlattice", "beam lattices"),
    ("securecontent", "encryption"),
    ("displacement", "displacement"),
    ("booleanoperations", "boolean operations"),
    ("volumetric", "volumes"),
    ("implicit", "volumes"),
];

/// A model part.
#[derive(Default)]
pub(super) struct Model {
    /// Objects by id.
    pub(super) objects: HashMap<u32, Object>,
    /// What is built.
    pub(super) items: Vec<Reference>,
    /// The number of items marked as not printable.
    pub(super) items_left_out: usize,
    /// The fault of the first coordinate that is NaN or too large.
    pub(super) unusable: Option<TextFault>,
}

/// An object.
pub(super) struct Object {
    /// Its type is `other`: it is neither built nor shown.
    pub(super) is_other: bool,
    pub(super) shape: Shape,
}

/// The content of an object.
pub(super) enum Shape {
    Mesh(Mesh),
    Components(Vec<Reference>),
}

/// A placed object: an item of the build, or a component of another object.
pub(super) struct Reference {
    pub(super) id: u32,
    /// The part that defines the object, unless it is this one.
    pub(super) part: Option<Box<str>>,
    /// The number of that part, once it is read.
    pub(super) model: usize,
    pub(super) transform: DAffine3,
    /// Where it is in the text.
    pub(super) place: Range<usize>,
}

/// Triangles of one object.
#[derive(Default)]
pub(super) struct Mesh {
    /// Relative to `offset`.
    pub(super) positions: Vec<[f32; 3]>,
    /// None, unless the whole file is read relative to one; then the first usable vertex, since objects are moved when they
    /// are placed.
    pub(super) offset: Offset,
    has_offset: bool,
    pub(super) triangles: Vec<[u32; 3]>,
    /// The surface of each triangle.
    pub(super) surface_of: Vec<u32>,
    /// Each vertex's indices into the colours and the texture coordinates; empty if no triangle has either.
    pub(super) attributes: Vec<Option<[u32; 2]>>,
}

/// Reads a model part, and adds its properties to the palette.
pub(super) fn parse(text: &[u8], palette: &mut Palette, budget: &Budget) -> Result<Model, TextFault> {
    let mut reader = Reader {
        xml: Xml::new(text)?,
        palette,
        groups: Groups::default(),
        budget,
        model: Model::default(),
    };
    let root = reader.xml.root("model")?;
    check_extensions(&root)?;
    while let Some(tag) = reader.xml.child()? {
        match tag.name() {
            b"resources" => reader.resources()?,
            b"build" => reader.build()?,
            _ => reader.xml.skip()?,
        }
    }
    Ok(reader.model)
}

/// Refuses a file that requires an extension that octray does not read.
fn check_extensions(root: &Tag<'_>) -> Result<(), TextFault> {
    let Some(required) = root.find("requiredextensions")? else {
        return Ok(());
    };
    let prefixes = Words::new(required.value, 0..required.value.len());
    // Each prefix, and the namespace it stands for.
    let mut all: Vec<(&[u8], &[u8])> = prefixes
        .take(MOST_EXTENSIONS)
        .map(|(prefix, _)| (prefix, prefix))
        .collect();
    for attribute in root.attributes() {
        let attribute = attribute?;
        if let Some(name) = attribute.name.strip_prefix(b"xmlns:") {
            let named = all.iter_mut().filter(|(prefix, _)| *prefix == name);
            named.for_each(|(_, namespace)| *namespace = attribute.value);
        }
    }
    for (_, namespace) in all {
        if READ.iter().any(|read| namespace.starts_with(read.as_bytes())) {
            continue;
        }
        let has = |part: &str| {
            namespace
                .windows(part.len())
                .any(|window| window == part.as_bytes())
        };
        let known = NOT_READ.iter().find(|(part, _)| has(part));
        let name = known.map_or_else(
            || format!("the extension {}", quote(namespace)),
            |(_, name)| (*name).to_owned(),
        );
        let fault = required.fault(format!("the file requires {name}, which octray does not support"));
        return Err(fault.with_kind(LoadErrorKind::Unsupported));
    }
    Ok(())
}

/// The state of reading a model part.
struct Reader<'a, 'b> {
    xml: Xml<'a>,
    palette: &'b mut Palette,
    groups: Groups,
    budget: &'b Budget,
    model: Model,
}

impl<'b> Reader<'_, 'b> {
    fn resources(&mut self) -> Result<(), TextFault> {
        while let Some(tag) = self.xml.child()? {
            if tag.name() == b"object" {
                self.object(&tag)?;
            } else {
                self.groups.read(&tag, &mut self.xml, self.palette, self.budget)?;
            }
        }
        Ok(())
    }

    fn build(&mut self) -> Result<(), TextFault> {
        while let Some(tag) = self.xml.child()? {
            if tag.name() == b"item" {
                if tag
                    .find("printable")?
                    .is_some_and(|printable| printable.value == b"0")
                {
                    self.model.items_left_out += 1;
                } else {
                    let item = reference(&tag, self.budget)?;
                    self.budget.reserve(&mut self.model.items, 1)?;
                    self.model.items.push(item);
                }
            }
            self.xml.skip()?;
        }
        Ok(())
    }

    fn object(&mut self, tag: &Tag<'_>) -> Result<(), TextFault> {
        let id = tag.get("id")?.index()?;
        let is_other = tag.find("type")?.is_some_and(|kind| kind.value == b"other");
        let group = match tag.find("pid")? {
            Some(pid) => Some((pid.index()?, pid.place)),
            None => None,
        };
        let index = match tag.find("pindex")? {
            Some(index) => index.index()?,
            None => 0,
        };
        let mut shape = Shape::Components(Vec::new());
        while let Some(tag) = self.xml.child()? {
            match tag.name() {
                b"mesh" => shape = Shape::Mesh(self.mesh(group.as_ref(), index)?),
                b"components" => shape = Shape::Components(self.components()?),
                name => {
                    self.palette.leave_out(name);
                    self.xml.skip()?;
                }
            }
        }
        self.budget.take(OBJECT_BYTES)?;
        self.model.objects.insert(id, Object { is_other, shape });
        Ok(())
    }

    fn components(&mut self) -> Result<Vec<Reference>, TextFault> {
        let mut components = Vec::new();
        while let Some(tag) = self.xml.child()? {
            if tag.name() == b"component" {
                let component = reference(&tag, self.budget)?;
                self.budget.reserve(&mut components, 1)?;
                components.push(component);
            }
            self.xml.skip()?;
        }
        Ok(components)
    }

    /// Reads a mesh; `group` and `index` are the default properties of its triangles.
    fn mesh(&mut self, group: Option<&(u32, Range<usize>)>, index: u32) -> Result<Mesh, TextFault> {
        let mut corners = Corners::default();
        while let Some(tag) = self.xml.child()? {
            match tag.name() {
                b"vertices" if !corners.mesh.triangles.is_empty() => {
                    return Err(TextFault::new(tag.place, "found vertices after triangles"));
                }
                b"triangles" if !corners.mesh.triangles.is_empty() => {
                    return Err(TextFault::new(
                        tag.place,
                        "a second list of triangles, expected one",
                    ));
                }
                b"vertices" => self.vertices(&mut corners.mesh)?,
                b"triangles" => self.triangles(&mut corners, group, index)?,
                name => {
                    self.palette.leave_out(name);
                    self.xml.skip()?;
                }
            }
        }
        Ok(corners.finish())
    }

    fn vertices(&mut self, mesh: &mut Mesh) -> Result<(), TextFault> {
        while let Some(tag) = self.xml.child()? {
            if tag.name() == b"vertex" {
                let unusable = &mut self.model.unusable;
                let mut position = position(&tag, mesh.offset, unusable)?;
                let is_usable = position.into_iter().all(is_usable);
                if is_usable && !mesh.has_offset && !self.budget.offset().is_none() {
                    mesh.has_offset = true;
                    mesh.offset = Offset::new(DVec3::from_array(position.map(f64::from)));
                    position = self::position(&tag, mesh.offset, unusable)?;
                }
                self.budget.reserve(&mut mesh.positions, 1)?;
                mesh.positions.push(position);
            }
            self.xml.skip()?;
        }
        Ok(())
    }

    fn triangles(
        &mut self,
        corners: &mut Corners<'b>,
        group: Option<&(u32, Range<usize>)>,
        index: u32,
    ) -> Result<(), TextFault> {
        // Counted now: corners that are split add vertices.
        let vertices = corners.mesh.positions.len();
        while let Some(tag) = self.xml.child()? {
            if tag.name() == b"triangle" {
                let triangle = Triangle::of(&tag, vertices)?;
                if triangle.is_painted {
                    self.palette.left_out.add("colours painted in a slicer");
                }
                let own = triangle.group.as_ref().or(group);
                let look = match (own, triangle.properties) {
                    (None, _) => Look::NONE,
                    (Some((id, at)), [Some(first), second, third]) => {
                        let indices = [first, second.unwrap_or(first), third.unwrap_or(first)];
                        self.groups.look(self.palette, (*id, at), indices, &tag.place)?
                    }
                    (Some(_), [None, ..]) => match group {
                        Some((id, at)) => self.groups.look(self.palette, (*id, at), [index; 3], at)?,
                        None => Look::NONE,
                    },
                };
                corners.add(triangle.corners, &look, self.budget)?;
            }
            self.xml.skip()?;
        }
        Ok(())
    }
}

/// The position of a vertex, less an offset. `unusable` becomes the fault of the first coordinate that is NaN or too large.
fn position(tag: &Tag<'_>, offset: Offset, unusable: &mut Option<TextFault>) -> Result<[f32; 3], TextFault> {
    let mut position = [None; 3];
    for attribute in tag.attributes() {
        let attribute = attribute?;
        let axis = match attribute.name {
            b"x" => 0,
            b"y" => 1,
            b"z" => 2,
            _ => continue,
        };
        position[axis] = Some(attribute.coordinate(axis, offset, unusable)?);
    }
    let [x, y, z] = position;
    Ok([
        x.ok_or_else(|| tag.lacks("x"))?,
        y.ok_or_else(|| tag.lacks("y"))?,
        z.ok_or_else(|| tag.lacks("z"))?,
    ])
}

/// The attributes of a triangle.
struct Triangle {
    corners: [u32; 3],
    group: Option<(u32, Range<usize>)>,
    properties: [Option<u32>; 3],
    /// A slicer has painted it, in its own format.
    is_painted: bool,
}

impl Triangle {
    fn of(tag: &Tag<'_>, vertices: usize) -> Result<Self, TextFault> {
        let (mut corners, mut properties, mut group) = ([None; 3], [None; 3], None);
        let mut is_painted = false;
        for attribute in tag.attributes() {
            let attribute = attribute?;
            match attribute.name {
                b"v1" => corners[0] = Some(corner(&attribute, vertices)?),
                b"v2" => corners[1] = Some(corner(&attribute, vertices)?),
                b"v3" => corners[2] = Some(corner(&attribute, vertices)?),
                b"p1" => properties[0] = Some(attribute.index()?),
                b"p2" => properties[1] = Some(attribute.index()?),
                b"p3" => properties[2] = Some(attribute.index()?),
                b"pid" => group = Some((attribute.index()?, attribute.place)),
                b"paint_color" | b"slic3rpe:mmu_segmentation" => is_painted = true,
                _ => {}
            }
        }
        let [first, second, third] = corners;
        Ok(Self {
            corners: [
                first.ok_or_else(|| tag.lacks("v1"))?,
                second.ok_or_else(|| tag.lacks("v2"))?,
                third.ok_or_else(|| tag.lacks("v3"))?,
            ],
            group,
            properties,
            is_painted,
        })
    }
}

fn corner(attribute: &Attribute<'_>, vertices: usize) -> Result<u32, TextFault> {
    let index = attribute.index()?;
    if (index as usize) < vertices {
        return Ok(index);
    }
    Err(attribute.fault(format!(
        "vertex index {index}, but the mesh has only {vertices} vertices"
    )))
}

/// An item or a component.
fn reference(tag: &Tag<'_>, budget: &Budget) -> Result<Reference, TextFault> {
    let id = tag.get("objectid")?.index()?;
    let part = match tag.find("path")? {
        Some(path) => {
            budget.take(NAME_BYTES + path.value.len())?;
            Some(path.text()?.into())
        }
        None => None,
    };
    let transform = match tag.find("transform")? {
        Some(numbers) => transform(&numbers)?,
        None => DAffine3::IDENTITY,
    };
    Ok(Reference {
        id,
        part,
        model: usize::MAX,
        transform,
        place: tag.place.clone(),
    })
}

/// A matrix of four rows: three axes and a translation. It is multiplied by row vectors on its left.
fn transform(attribute: &Attribute<'_>) -> Result<DAffine3, TextFault> {
    let mut numbers = [0.0_f64; 12];
    let mut words = Words::new(attribute.value, 0..attribute.value.len());
    for number in &mut numbers {
        let Some((word, place)) = words.next() else {
            return Err(attribute.fault("a transform of fewer than 12 numbers"));
        };
        let start = attribute.place.start;
        let place = start + place.start..start + place.end;
        *number = fast_float2::parse(word).map_err(|_| {
            let message = format!("found {}, expected a number of a transform", quote(word));
            TextFault::new(place.clone(), message)
        })?;
        let value = *number as f32;
        if !is_usable(value) {
            let what = "a number of the transform";
            let error = SceneError::NotUsable { what, value };
            return Err(TextFault::new(place, error.to_string()));
        }
    }
    let [x, y, z, translation] = [0, 3, 6, 9].map(|i| DVec3::from_slice(&numbers[i..]));
    Ok(DAffine3::from_cols(x, y, z, translation))
}

/// A mesh whose vertices are split where their corners have different properties.
#[derive(Default)]
struct Corners<'b> {
    mesh: Mesh,
    /// `Some` once a corner has properties.
    vertices: Option<Vertices<'b>>,
}

impl<'b> Corners<'b> {
    fn add(&mut self, corners: [u32; 3], look: &Look, budget: &'b Budget) -> Result<(), BudgetError> {
        let mesh = &mut self.mesh;
        let has_properties = look.corners.as_flattened().iter().any(|&index| index != NONE);
        if self.vertices.is_none() && has_properties {
            let mut vertices = Vertices::new(mesh.positions.len(), budget)?;
            for &corner in mesh.triangles.as_flattened() {
                vertices.vertex(corner, [NONE; 2])?;
            }
            self.vertices = Some(vertices);
        }
        let mut triangle = corners;
        if let Some(vertices) = &mut self.vertices {
            for (corner, own) in triangle.iter_mut().zip(look.corners) {
                let position = *corner as usize;
                *corner = vertices.vertex(*corner, own)?;
                if *corner as usize == mesh.positions.len() {
                    budget.reserve(&mut mesh.positions, 1)?;
                    mesh.positions.push(mesh.positions[position]);
                }
            }
        }
        budget.reserve(&mut mesh.triangles, 1)?;
        budget.reserve(&mut mesh.surface_of, 1)?;
        mesh.triangles.push(triangle);
        mesh.surface_of.push(look.surface);
        Ok(())
    }

    fn finish(mut self) -> Mesh {
        if let Some(vertices) = self.vertices {
            self.mesh.attributes = vertices.into_attributes();
        }
        self.mesh
    }
}
