//! Compressed geometry: buffer views by meshopt (`EXT_meshopt_compression`, 2021, and `KHR_meshopt_compression`, 2025),
//! primitives by Draco (`KHR_draco_mesh_compression`, 2018).
//!
//! The gltf crate reads neither, so their parts of the JSON are parsed separately. The crates meshoptimizer-rs and
//! draco-core decode; both get a memory limit first. Decoded bytes replace a view or an accessor. In total at most as many
//! bytes as the file has are decoded, or a small file could be decoded for hours.

use super::{
    super::budget::BudgetError,
    buffers::{Buffers, Bytes},
};
use crate::error::{LoadError, LoadErrorKind, quote};
use draco_core::{DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute};
use gltf::{Accessor, Document, Primitive, Semantic, accessor::DataType, buffer::View, json};
use meshoptimizer_rs::{Limits, Workspace, codec};
use serde::Deserialize;
use std::{collections::HashMap, path::Path};

/// The extensions that are read.
const EXTENSIONS: [&str; 3] = [
    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression",
    "KHR_meshopt_compression",
];

/// How much memory Draco's decoder takes for a triangle at most, its own tables included, bytes.
const DRACO_TRIANGLE: u64 = 256;

/// Restores what an encoder changed in decoded elements of a count and a size.
type Filter = fn(&mut [u8], usize, usize, &mut Workspace) -> Result<(), meshoptimizer_rs::Error>;

/// The compressed parts of a file.
pub(super) struct Compression<'d> {
    document: &'d Document,
    /// By index.
    views: Vec<Option<Meshopt>>,
    /// By mesh and primitive.
    primitives: Vec<Vec<Option<Draco>>>,
}

/// The compressed bytes of a view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Meshopt {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    count: usize,
    mode: String,
    filter: Option<String>,
}

/// The compressed bytes of a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Draco {
    buffer_view: usize,
    /// Ids of its attributes in these bytes.
    attributes: HashMap<String, u32>,
}

/// The parts of the JSON that matter here.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct File {
    #[serde(default)]
    buffer_views: Vec<Extended<Views>>,
    #[serde(default)]
    meshes: Vec<Primitives>,
}

#[derive(Deserialize)]
struct Primitives {
    #[serde(default)]
    primitives: Vec<Extended<Geometry>>,
}

#[derive(Deserialize)]
struct Extended<T> {
    extensions: Option<T>,
}

#[derive(Deserialize)]
struct Views {
    #[serde(rename = "KHR_meshopt_compression")]
    standard: Option<Meshopt>,
    #[serde(rename = "EXT_meshopt_compression")]
    older: Option<Meshopt>,
}

#[derive(Deserialize)]
struct Geometry {
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<Draco>,
}

impl<'d> Compression<'d> {
    /// Reads the JSON once more, but only if the file names an extension.
    pub(super) fn of(text: &[u8], path: &Path, document: &'d Document) -> Result<Self, LoadError> {
        let mut used = document.extensions_used().chain(document.extensions_required());
        let Some(extension) = used.find(|name| EXTENSIONS.contains(name)) else {
            return Ok(Self {
                document,
                views: Vec::new(),
                primitives: Vec::new(),
            });
        };
        let file: File = json::deserialize::from_slice(text).map_err(|error| {
            let place = [error.line(), error.column()];
            LoadError::in_json(path, place, &format!("not valid {extension}"), &error.to_string())
        })?;
        let views = file.buffer_views.into_iter();
        let of_mesh = |mesh: Primitives| {
            let primitives = mesh.primitives.into_iter();
            primitives.map(|primitive| primitive.extensions?.draco).collect()
        };
        let of_view = |view: Extended<Views>| {
            let Views { standard, older } = view.extensions?;
            standard.or(older)
        };
        Ok(Self {
            document,
            views: views.map(of_view).collect(),
            primitives: file.meshes.into_iter().map(of_mesh).collect(),
        })
    }

    /// The decoded bytes of a view; `None` if it is not compressed.
    pub(super) fn view<'a>(
        &self,
        view: &View<'_>,
        buffers: &mut Buffers<'a>,
    ) -> Result<Option<Bytes<'a>>, LoadError> {
        let index = view.index();
        let Some(Some(meshopt)) = self.views.get(index) else {
            return Ok(None);
        };
        if let Some(decoded) = buffers.decoded(index) {
            return Ok(Some(decoded));
        }
        let source = match self.document.buffers().nth(meshopt.buffer) {
            Some(buffer) => buffers.bytes(&buffer)?,
            None => {
                return Err(buffers.refused(format!("bufferViews[{index}]: no buffer {}", meshopt.buffer)));
            }
        };
        let end = meshopt.byte_offset.saturating_add(meshopt.byte_length);
        let Some(source) = source.get(meshopt.byte_offset..end) else {
            return Err(buffers.refused(format!(
                "bufferViews[{index}] reaches beyond its buffer: the file is cut short or broken"
            )));
        };
        buffers.count_decoded(source.len())?;
        let decoded = meshopt.decode(source, view, buffers)?;
        Ok(Some(buffers.keep_decoded(index, decoded)))
    }

    /// Decodes a primitive's indices and attributes, if it is compressed and they are not there yet.
    pub(super) fn primitive(
        &self,
        mesh: usize,
        primitive: &Primitive<'_>,
        buffers: &mut Buffers<'_>,
    ) -> Result<(), LoadError> {
        let index = primitive.index();
        let primitives = self.primitives.get(mesh);
        let Some(Some(draco)) = primitives.and_then(|primitives| primitives.get(index)) else {
            return Ok(());
        };
        // An accessor with a buffer view is a fallback for readers without Draco.
        let is_missing = |accessor: &Accessor<'_>, buffers: &Buffers<'_>| {
            accessor.view().is_none() && !buffers.has_read(accessor.index())
        };
        let indices = primitive
            .indices()
            .filter(|accessor| is_missing(accessor, buffers));
        let mut attributes = Vec::new();
        let known = primitive.attributes();
        let known = known.filter(|(semantic, _)| is_read(semantic, primitive));
        let known = known.map(|(semantic, accessor)| (semantic.to_string(), accessor));
        let own = buffers.scalars().of_primitive([mesh, index]);
        for (name, accessor) in known.chain(own) {
            if !is_missing(&accessor, buffers) {
                continue;
            }
            match draco.attributes.get(&name) {
                Some(&id) => attributes.push((id, accessor)),
                // Tangents that are zeros count as missing.
                None if accessor.sparse().is_some() || name == "TANGENT" => {}
                // Only their ranges are wanted.
                None if name.starts_with('_') && !buffers.scalars().is_named() => {}
                // Zeros would hide the mistake.
                None => {
                    return Err(buffers.refused(format!(
                        "accessors[{}] has no buffer view, and the Draco data of meshes[{mesh}].primitives[{index}] has \
                         no {name}",
                        accessor.index()
                    )));
                }
            }
        }
        if indices.is_none() && attributes.is_empty() {
            return Ok(());
        }
        let name = format!("meshes[{mesh}].primitives[{index}]");
        let decoded = self.draco(draco, &name, buffers)?;
        if let Some(accessor) = indices {
            room(decoded.num_faces(), 12, buffers)?;
            let corners = decoded.faces().iter().flatten();
            let bytes = corners.flat_map(|corner| corner.0.to_le_bytes()).collect();
            buffers.keep(&accessor, DataType::U32, 4, bytes);
        }
        for (id, accessor) in attributes {
            let attribute = decoded.attribute_by_unique_id(id).ok_or_else(|| {
                buffers.refused(format!("{name}: there is no attribute {id} in its Draco data"))
            })?;
            let numbers = accessor.dimensions().multiplicity();
            room(decoded.num_points(), 4 * numbers, buffers)?;
            let bytes = floats(attribute, decoded.num_points(), numbers);
            buffers.keep(&accessor, DataType::F32, 4 * numbers, bytes);
        }
        Ok(())
    }

    /// Decodes Draco's bytes. `name` is what errors call the primitive.
    fn draco(&self, draco: &Draco, name: &str, buffers: &mut Buffers<'_>) -> Result<Mesh, LoadError> {
        let Some(view) = self.document.views().nth(draco.buffer_view) else {
            let (view, count) = (draco.buffer_view, self.document.views().len());
            return Err(buffers.refused(format!(
                "{name}: buffer view {view}, but the file has only {count}"
            )));
        };
        let (bytes, range) = buffers.view(&view)?;
        let Some(bytes) = bytes.get(range) else {
            return Err(buffers.refused(format!(
                "bufferViews[{}] reaches beyond its buffer: the file is cut short or broken",
                view.index()
            )));
        };
        buffers.count_decoded(bytes.len())?;
        let left = buffers.budget().left();
        let limits = DecodeLimits::default()
            .with_max_faces(left / DRACO_TRIANGLE)
            .with_max_decoded_bytes(left / 4);
        let mut decoded = Mesh::new();
        MeshDecoder::new()
            .decode(&mut DecoderBuffer::new(bytes).with_limits(limits), &mut decoded)
            .map_err(|error| match error.kind() {
                ErrorKind::LimitExceeded => over_limit(buffers),
                kind => {
                    let refused = buffers.refused(format!("{name}: cannot decode its Draco data: {error}"));
                    if matches!(
                        kind,
                        ErrorKind::UnsupportedVersion | ErrorKind::UnsupportedFeature
                    ) {
                        refused.with_kind(LoadErrorKind::Unsupported)
                    } else {
                        refused
                    }
                }
            })?;
        Ok(decoded)
    }
}

impl Meshopt {
    /// Decodes the bytes of a view.
    fn decode(&self, source: &[u8], view: &View<'_>, buffers: &Buffers<'_>) -> Result<Vec<u8>, LoadError> {
        let index = view.index();
        let failed = |error: meshoptimizer_rs::Error| match error {
            meshoptimizer_rs::Error::LimitExceeded | meshoptimizer_rs::Error::AllocationFailed => {
                over_limit(buffers)
            }
            _ => buffers.refused(format!(
                "bufferViews[{index}]: cannot decode its meshopt data: {error}"
            )),
        };
        let (count, stride) = (self.count, self.byte_stride);
        let unknown = |what: &str, name: &str| {
            let found = quote(name.as_bytes());
            buffers.refused(format!(
                "bufferViews[{index}]: there is no meshopt {what} {found}"
            ))
        };
        let decode = match self.mode.as_str() {
            "ATTRIBUTES" => codec::decode_vertex_buffer,
            "TRIANGLES" => codec::decode_index_buffer,
            "INDICES" => codec::decode_index_sequence,
            other => return Err(unknown("mode", other)),
        };
        let filter: Option<Filter> = match self.filter.as_deref() {
            None | Some("NONE") => None,
            Some("OCTAHEDRAL") => Some(codec::decode_filter_oct),
            Some("QUATERNION") => Some(codec::decode_filter_quat),
            Some("EXPONENTIAL") => Some(codec::decode_filter_exp),
            Some("COLOR") => Some(codec::decode_filter_color),
            Some(other) => return Err(unknown("filter", other)),
        };
        let size = count.saturating_mul(stride);
        if size < view.length() {
            let length = view.length();
            return Err(buffers.refused(format!(
                "bufferViews[{index}] has {length} bytes, but {count} elements of {stride} bytes are compressed"
            )));
        }
        room(count, stride, buffers)?;
        let mut workspace = Workspace::new(Limits {
            max_bytes: size.saturating_mul(2),
            ..Limits::default()
        });
        let mut decoded = decode(count, stride, source, &mut workspace).map_err(failed)?;
        if let Some(filter) = filter {
            filter(&mut decoded, count, stride, &mut workspace).map_err(failed)?;
        }
        Ok(decoded)
    }
}

/// Takes room for elements of this size.
fn room(count: usize, size: usize, buffers: &Buffers<'_>) -> Result<(), LoadError> {
    let room = buffers.budget().take(count.saturating_mul(size));
    room.map_err(|error| buffers.no_room(error))
}

/// The error about memory that a decoder would take.
fn over_limit(buffers: &Buffers<'_>) -> LoadError {
    let limit = buffers.budget().limit();
    buffers.no_room(BudgetError::OverLimit { needed: limit, limit })
}

/// Whether octray reads an attribute of this kind of a primitive.
fn is_read(semantic: &Semantic, primitive: &Primitive<'_>) -> bool {
    match semantic {
        Semantic::Tangents => primitive.material().normal_texture().is_some(),
        Semantic::Positions
        | Semantic::Normals
        | Semantic::Colors(0)
        | Semantic::TexCoords(_)
        | Semantic::Joints(_)
        | Semantic::Weights(_) => true,
        Semantic::Colors(_) => false,
    }
}

/// Some numbers of each point, packed.
fn floats(attribute: &PointAttribute, points: usize, numbers: usize) -> Vec<u8> {
    bytemuck::cast_slice(&attribute.read_f32s(points, numbers)).to_vec()
}
