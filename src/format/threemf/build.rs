//! Places what a model builds: items, their components, and the components of these.
//!
//! Everything is counted before any of it is placed, so that a file whose components multiply is refused at once.

use super::{
    model::{Mesh, Model, Reference, Shape, parse},
    package::Package,
    properties::Palette,
};
use crate::{
    error::{LoadError, LoadErrorKind, SceneError, quote},
    format::{
        budget::BudgetError,
        mesh::most_triangles,
        offset::Offset,
        place::TextFault,
        reason::Reason,
        vertices::{NONE, add_position},
    },
    scene::{TriangleMesh, check_memory},
};
use glam::{DAffine3, DVec3};
use std::{collections::HashMap, ops::Range};

/// How deep components nest.
const MAX_DEPTH: usize = 64;

/// The most objects that a file places; an object counts each time it is placed.
const MAX_PLACED: usize = 1 << 20;

/// Memory of an entry of the maps, bytes: they may be half empty, and move as they grow.
const ENTRY_BYTES: usize = 256;

/// An object: the number of its model part, and its id there.
type Key = (usize, u32);

/// What an object places.
#[derive(Clone, Copy, Default)]
struct Total {
    objects: usize,
    triangles: usize,
    vertices: usize,
    has_colors: bool,
    has_uvs: bool,
    /// How deep components nest in it.
    depth: usize,
}

impl Total {
    fn of(mesh: &Mesh) -> Self {
        let has = |which: usize| mesh.attributes.iter().flatten().any(|own| own[which] != NONE);
        Self {
            triangles: mesh.triangles.len(),
            vertices: mesh.positions.len(),
            has_colors: has(0),
            has_uvs: has(1),
            ..Self::default()
        }
    }

    fn add(&mut self, other: Self) {
        self.objects = self.objects.saturating_add(other.objects).saturating_add(1);
        self.triangles = self.triangles.saturating_add(other.triangles);
        self.vertices = self.vertices.saturating_add(other.vertices);
        self.has_colors |= other.has_colors;
        self.has_uvs |= other.has_uvs;
        self.depth = self.depth.max(other.depth + 1);
    }
}

/// The model parts of a file, and what they place.
pub(super) struct Building<'a> {
    pub(super) package: Package<'a>,
    pub(super) palette: Palette,
    /// With their names.
    models: Vec<(String, Model)>,
    model_by_part: HashMap<String, usize>,
    /// `None` while an object is counted.
    totals: HashMap<Key, Option<Total>>,
    pub(super) columns: TriangleMesh,
    pub(super) surface_of: Vec<u32>,
    /// How many references are to objects of the type `other`.
    others: usize,
    /// The error about the first position that is NaN or too large.
    pub(super) unusable: Option<LoadError>,
}

impl<'a> Building<'a> {
    pub(super) fn new(package: Package<'a>) -> Self {
        Self {
            package,
            palette: Palette::default(),
            models: Vec::new(),
            model_by_part: HashMap::new(),
            totals: HashMap::new(),
            columns: TriangleMesh::default(),
            surface_of: Vec::new(),
            others: 0,
            unusable: None,
        }
    }

    /// Places all that the model part `part` builds.
    pub(super) fn build(&mut self, part: &str) -> Result<(), LoadError> {
        let root = self.model(part)?;
        let mut total = Total::default();
        for i in 0..self.models[root].1.items.len() {
            total.add(self.count(root, None, i, 0)?);
        }
        self.make_room(total)?;
        for i in 0..self.models[root].1.items.len() {
            let item = &self.models[root].1.items[i];
            let (key, transform) = ((item.model, item.id), item.transform);
            self.place(key, transform, &(root, item.place.clone()))?;
        }
        self.note();
        Ok(())
    }

    /// The number of a model part, which is read if it is new.
    fn model(&mut self, part: &str) -> Result<usize, LoadError> {
        if let Some(&known) = self.model_by_part.get(part) {
            return Ok(known);
        }
        let budget = self.package.budget();
        let text = self.package.read(part)?;
        let path = self.package.path_of(part);
        let located = |fault: TextFault| fault.into_error(&text, &path);
        let mut model = parse(&text, &mut self.palette, budget).map_err(located)?;
        let unusable = model.unusable.take().filter(|_| self.unusable.is_none());
        self.unusable = self.unusable.take().or(unusable.map(located));
        budget.give_back(text.capacity());
        let taken = budget.take(ENTRY_BYTES + 2 * part.len());
        taken.map_err(|error| self.no_room(error))?;
        self.models.push((part.to_owned(), model));
        self.model_by_part.insert(part.to_owned(), self.models.len() - 1);
        Ok(self.models.len() - 1)
    }

    /// Counts what a reference places: number `i` of the components of `object`, or of the items of the build.
    fn count(
        &mut self,
        model: usize,
        object: Option<u32>,
        i: usize,
        depth: usize,
    ) -> Result<Total, LoadError> {
        let Some(reference) = self.reference(model, object, i) else {
            return Ok(Total::default());
        };
        let (id, part, place) = (reference.id, reference.part.clone(), reference.place.clone());
        let found = match part {
            None => model,
            Some(name) => {
                let Some(part) = self.package.find(&name) else {
                    let message = format!("the archive has no part {}", quote(name.as_bytes()));
                    return Err(self.fault(model, place, message));
                };
                self.model(&part)?
            }
        };
        if let Some(reference) = self.reference(model, object, i) {
            reference.model = found;
        }
        let key = (found, id);
        let too_deep = |builder: &mut Self, place| {
            let message = format!("components nest more than {MAX_DEPTH} deep");
            let fault = builder.fault(model, place, message);
            fault.with_kind(LoadErrorKind::Limit)
        };
        let total = match self.totals.get(&key) {
            Some(Some(total)) => *total,
            Some(None) => {
                return Err(self.fault(model, place, format!("object {id} contains itself")));
            }
            None if depth == MAX_DEPTH => return Err(too_deep(self, place)),
            None => {
                let Some(object) = self.models[found].1.objects.get(&id) else {
                    return Err(self.fault(model, place, format!("there is no object {id}")));
                };
                if object.is_other {
                    self.others += 1;
                    return Ok(Total::default());
                }
                self.count_object(key, depth)?
            }
        };
        if total.depth > MAX_DEPTH {
            return Err(too_deep(self, place));
        }
        Ok(total)
    }

    fn count_object(&mut self, key: Key, depth: usize) -> Result<Total, LoadError> {
        let taken = self.package.budget().take(ENTRY_BYTES);
        taken.map_err(|error| self.no_room(error))?;
        self.totals.insert(key, None);
        let mut total = Total::default();
        let components = match self.models[key.0]
            .1
            .objects
            .get(&key.1)
            .map(|object| &object.shape)
        {
            Some(Shape::Mesh(mesh)) => {
                total = Total::of(mesh);
                0
            }
            Some(Shape::Components(components)) => components.len(),
            None => 0,
        };
        for i in 0..components {
            total.add(self.count(key.0, Some(key.1), i, depth + 1)?);
        }
        self.totals.insert(key, Some(total));
        Ok(total)
    }

    fn reference(&mut self, model: usize, object: Option<u32>, i: usize) -> Option<&mut Reference> {
        let model = &mut self.models[model].1;
        let Some(object) = object else {
            return model.items.get_mut(i);
        };
        match &mut model.objects.get_mut(&object)?.shape {
            Shape::Components(components) => components.get_mut(i),
            Shape::Mesh(_) => None,
        }
    }

    /// An error about a place in a model part.
    fn fault(&mut self, model: usize, place: Range<usize>, message: String) -> LoadError {
        let part = self.models[model].0.clone();
        self.package.fault(&part, TextFault::new(place, message))
    }

    fn no_room(&self, error: BudgetError) -> LoadError {
        error.into_error(self.package.path())
    }

    /// Refuses too many triangles, and makes room for all others.
    fn make_room(&mut self, total: Total) -> Result<(), LoadError> {
        let refused = |reason: Reason| reason.of_file(self.package.path());
        let size = self.package.size();
        let most = most_triangles(size);
        if total.triangles > most || total.vertices > 3 * most {
            return Err(refused(Reason::limit(format!(
                "{} triangles, counted once for each component that places them, expected at most {most} from \
                 {size} bytes",
                total.triangles.max(total.vertices / 3)
            ))));
        }
        if total.objects > MAX_PLACED {
            let message = format!(
                "{} objects and components, expected at most {MAX_PLACED}",
                total.objects
            );
            return Err(refused(Reason::limit(message)));
        }
        let vertices = total.vertices;
        let [colors, uvs] = [total.has_colors, total.has_uvs].map(|has| if has { vertices } else { 0 });
        let budget = self.package.budget();
        // The scene would refuse it later.
        check_memory([total.triangles, 0, vertices + colors + uvs], 0, budget.limit())
            .map_err(|error| refused(error.into()))?;
        let columns = &mut self.columns;
        let room = [&mut columns.x, &mut columns.y, &mut columns.z]
            .into_iter()
            .try_for_each(|column| budget.reserve(column, vertices))
            .and_then(|()| budget.reserve(&mut columns.colors, colors))
            .and_then(|()| budget.reserve(&mut columns.uvs, uvs))
            .and_then(|()| budget.reserve(&mut columns.triangles, total.triangles))
            .and_then(|()| budget.reserve(&mut self.surface_of, total.triangles));
        room.map_err(|error| self.no_room(error))
    }

    /// Places an object; `at` is the reference to it: its model part, and where in that.
    fn place(&mut self, key: Key, world: DAffine3, at: &(usize, Range<usize>)) -> Result<(), LoadError> {
        let object = self
            .models
            .get(key.0)
            .and_then(|(_, model)| model.objects.get(&key.1));
        let Some(object) = object.filter(|object| !object.is_other) else {
            return Ok(());
        };
        match &object.shape {
            Shape::Mesh(mesh) => {
                let base = self.columns.x.len() as u32;
                let placed = add_positions(&mut self.columns, mesh, &world, self.package.budget().offset());
                let is_mirrored = world.matrix3.determinant() < 0.0;
                let corners = mesh.triangles.iter().map(|corners| {
                    let [a, b, c] = corners.map(|corner| corner + base);
                    // Mirrored triangles keep their front.
                    if is_mirrored { [a, c, b] } else { [a, b, c] }
                });
                self.columns.triangles.extend(corners);
                self.surface_of.extend_from_slice(&mesh.surface_of);
                add_attributes(&mut self.columns, mesh, &self.palette);
                if let (Err((vertex, error)), None) = (placed, &self.unusable) {
                    let message = format!("vertex {vertex} of object {}: {error}", key.1);
                    self.unusable = Some(self.fault(at.0, at.1.clone(), message));
                }
            }
            Shape::Components(components) => {
                for i in 0..components.len() {
                    let Some(component) = self.reference(key.0, Some(key.1), i) else {
                        break;
                    };
                    let within = (component.model, component.id);
                    let (transform, place) = (world * component.transform, component.place.clone());
                    self.place(within, transform, &(key.0, place))?;
                }
            }
        }
        Ok(())
    }

    /// Notes what is not shown.
    fn note(&mut self) {
        let root = self.models.first();
        let items = root.map_or(0, |(_, model)| model.items_left_out);
        let left_out = &mut self.palette.left_out;
        left_out.names("elements", self.palette.unknown.iter().map(String::as_str));
        left_out.count(
            items,
            "item that is not to be printed",
            "items that are not to be printed",
        );
        left_out.count(
            self.others,
            "object of the type `other`",
            "objects of the type `other`",
        );
        let objects = self.models.iter().enumerate().flat_map(|(i, (_, model))| {
            let all = model.objects.iter().filter(|(_, object)| !object.is_other);
            all.map(move |(id, _)| (i, *id))
        });
        let unused = objects.filter(|key| !self.totals.contains_key(key)).count();
        left_out.count(unused, "object that is not built", "objects that are not built");
        left_out.count(
            self.palette.odd_uvs,
            "texture coordinate that is NaN or too large",
            "texture coordinates that are NaN or too large",
        );
    }
}

/// Adds the positions of a mesh. The error has the index of the first unusable one; all are added.
fn add_positions(
    columns: &mut TriangleMesh,
    mesh: &Mesh,
    world: &DAffine3,
    offset: Offset,
) -> Result<(), (usize, SceneError)> {
    let is_identity = *world == DAffine3::IDENTITY && offset.is_none();
    let (own, offset) = (mesh.offset.vector(), offset.vector());
    let mut first = Ok(());
    for (i, position) in mesh.positions.iter().enumerate() {
        let position = if is_identity {
            *position
        } else {
            let position = own + DVec3::from_array(position.map(f64::from));
            let placed = world.transform_point3(position) - offset;
            placed.as_vec3().to_array()
        };
        let added = add_position(columns, position).map_err(|error| (i, error));
        first = first.and(added);
    }
    first
}

/// Adds colours and texture coordinates of the vertices that were added last, if the file has any.
fn add_attributes(columns: &mut TriangleMesh, mesh: &Mesh, palette: &Palette) {
    let vertices = columns.x.len();
    let own = |i: usize| mesh.attributes.get(i).copied().flatten().unwrap_or([NONE; 2]);
    // Capacity was reserved for either if any object has it.
    if columns.colors.capacity() > 0 {
        let color = |i: usize| {
            palette
                .colors
                .get(own(i)[0] as usize)
                .copied()
                .unwrap_or([1.0; 3])
        };
        columns.colors.extend((0..mesh.positions.len()).map(color));
        debug_assert_eq!(columns.colors.len(), vertices);
    }
    if columns.uvs.capacity() > 0 {
        let uv = |i: usize| palette.uvs.get(own(i)[1] as usize).copied().unwrap_or_default();
        columns.uvs.extend((0..mesh.positions.len()).map(uv));
        debug_assert_eq!(columns.uvs.len(), vertices);
    }
}
