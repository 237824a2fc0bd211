//! A picture in memory, as `octray render` makes it: for the Python package.

use super::{
    CliError, args,
    load::{self, Input, memory::PixelBytes},
    plan::{InputKind, InputPlan, PictureOptions},
    write::{self, Axis, Format, Pixels, Z_STEP, instance_number},
};
mod placed;

pub use super::{
    plan::{Backdrop, CameraOptions, ColorBy, ColorMap, MeshOptions, Shading, Side, StartView, Style},
    write::AovKind,
};
use crate::{
    accel::{BuildQuality, Bvh},
    format::{
        self,
        mesh::{LoadedMesh, UpAxis, UpSource, channels},
        ply,
    },
    ray::PrimitiveId,
    render::{Aovs, Edges, OnProgress, Renderer, Settings},
    scene::{Camera, TriangleMesh},
};
pub use placed::PlacedArrays;
use std::path::Path;

/// Loads a mesh alone, within the memory that a picture may take.
///
/// # Errors
/// [`CliError::Load`].
pub fn mesh(path: &Path) -> Result<LoadedMesh, CliError> {
    let memory = load::memory::limit(None);
    Ok(format::mesh::load_within(path, &mut Vec::new(), memory)?)
}

/// Returns the camera of a picture of `size`: of placed meshes whose z axis points up, in the style of [`picture`], or one
/// that depends on no mesh. Only the positions of the meshes are used.
///
/// # Errors
/// [`CliError::Usage`].
pub fn camera(
    meshes: Option<Vec<PlacedArrays>>,
    options: &CameraOptions,
    shown: &MeshOptions,
    [width, height]: [u32; 2],
) -> Result<Camera, CliError> {
    options.check()?;
    let Some(meshes) = meshes else {
        let missing = || CliError::Usage("the camera depends on a mesh".into());
        return options.without_scene()?.ok_or_else(missing);
    };
    let aspect = f64::from(width) / f64::from(height);
    let mesh = placed::loaded(meshes, Path::new("scene"), u64::MAX)?;
    options.for_mesh(&mesh, shown.up_axis.unwrap_or(UpAxis::Z), aspect, shown)
}

/// The subject of a picture.
#[derive(Debug)]
pub enum Subject<'a> {
    /// A scene or a mesh.
    File(&'a Path),
    /// The bytes of a scene or a mesh, with a name in messages. Files that it names are in the name's folder.
    Bytes(&'a [u8], &'a Path),
    /// A mesh in memory.
    Mesh(MeshArrays),
    /// Meshes in memory that are placed. Hits have the index of their triangle in its mesh.
    Scene(Vec<PlacedArrays>),
}

impl Subject<'_> {
    /// The index of each instance, in the order in which a scene of placed meshes stores them.
    fn instances(&self) -> Option<Vec<u32>> {
        let Self::Scene(parts) = self else { return None };
        Some(parts.iter().flat_map(|part| &part.instances).copied().collect())
    }
}

/// A mesh whose z axis points up, unless an option says otherwise.
#[derive(Debug, Default)]
pub struct MeshArrays {
    /// The mesh, with the display values of its vertices' colours if they have some.
    pub columns: TriangleMesh,
    pub shown: MeshShows,
}

/// What a mesh shows beside the colours of its vertices.
#[derive(Debug, Default)]
pub enum MeshShows {
    #[default]
    Nothing,
    /// A display value for each triangle.
    FaceColors(Vec<[f32; 3]>),
    /// A number for each vertex, instead of all colours, as [`MeshOptions::color_by`] says.
    VertexValues(Vec<f64>),
    /// The same for each triangle.
    FaceValues(Vec<f64>),
}

impl MeshArrays {
    /// A display value for each triangle; empty if they have none.
    fn face_colors(&self) -> &[[f32; 3]] {
        match &self.shown {
            MeshShows::FaceColors(colors) => colors,
            _ => &[],
        }
    }
}

/// How a picture is made: options of `octray render`.
#[derive(Debug)]
pub struct Request {
    /// Width and height, pixels.
    pub size: [u32; 2],
    pub camera: CameraOptions,
    pub mesh: MeshOptions,
    /// A value of `--samples`.
    pub samples: Option<String>,
    pub max_depth: u32,
    pub shadows: bool,
    /// Width of the edges of triangles, pixels.
    pub edges: Option<f32>,
    pub backdrop: Backdrop,
    /// Whether bytes are in sRGB; by the style if `None`.
    pub srgb: Option<bool>,
    /// Linear floats, as in an EXR file, instead of bytes.
    pub floats: bool,
    /// The frame of a scene with keyframes, from 1 on.
    pub frame: Option<u32>,
    pub aovs: Vec<AovKind>,
}

/// The values of all pixels, row by row, the top row first.
#[derive(Debug)]
pub enum Values {
    Bytes(Vec<u8>),
    Floats(Vec<f32>),
    Whole(Vec<u32>),
    Flags(Vec<bool>),
}

/// A picture in memory.
#[derive(Debug)]
pub struct Picture {
    /// Red, green, blue and, if transparent, alpha of each pixel: the bytes or floats that `octray render` writes.
    pub color: Values,
    /// The requested AOVs, by name.
    pub aovs: Vec<(&'static str, Values)>,
    /// Warnings.
    pub notes: Vec<String>,
}

impl Request {
    /// Bytes of a pixel in the arrays that are returned.
    fn array_bytes(&self) -> u64 {
        let channels = if self.backdrop.is_transparent() { 4 } else { 3 };
        let of_aov = |which: &AovKind| match which {
            AovKind::Normal | AovKind::Albedo => 12,
            AovKind::Mask => 1,
            AovKind::Depth | AovKind::Z | AovKind::Id | AovKind::Heat | AovKind::Instance => 4,
        };
        channels * if self.floats { 4 } else { 1 } + self.aovs.iter().map(of_aov).sum::<u64>()
    }

    /// Which memory a picture takes for each pixel.
    fn pixel_bytes(&self) -> PixelBytes {
        PixelBytes {
            film: self.backdrop.film_bytes(true) + self.array_bytes(),
            exr: false,
            aovs: !self.aovs.is_empty(),
            compared: false,
        }
    }
}

/// Renders a picture.
///
/// # Errors
/// [`CliError`].
pub fn picture(
    subject: Subject<'_>,
    request: Request,
    on_progress: OnProgress<'_>,
) -> Result<Picture, CliError> {
    let [width, height] = request.size;
    let settings = Settings {
        width,
        height,
        max_depth: request.max_depth,
        shadows: request.shadows,
        edges: request.edges.map(|width| Edges {
            width,
            ..Edges::default()
        }),
        ..Settings::default()
    };
    settings.validate()?;
    let memory = load::memory::limit(None);
    let memory = load::memory::beside_picture(memory, (width, height), request.pixel_bytes())?;
    let (is_soft, instances) = (request.mesh.style.is_soft(), subject.instances());
    let aspect = f64::from(width) / f64::from(height);
    let (plan, mut input) = loaded(subject, request.camera, request.mesh, aspect, memory)?;
    if let Some(frame) = request.frame {
        move_to(&mut input, &plan, frame)?;
    }
    let is_soft = input.is_mesh() && is_soft;
    let (settings, transfer) = args::look(settings, is_soft, request.samples.as_deref(), request.srgb)?;
    settings.validate()?;
    let faults = load::faults::of(&input.scene);
    if !input.is_cloud {
        input.notes.extend(faults.warning(plan.name()));
    }
    load::memory::check_build(&input.scene, BuildQuality::Best)?;
    let bvh = Bvh::build(&input.scene);
    let mut renderer = Renderer::new(&input.scene, &bvh);
    let format = if request.floats { Format::Exr } else { Format::Png };
    let options = PictureOptions {
        transfer,
        byte_transfer: transfer,
        backdrop: request.backdrop,
        aovs: Vec::new(),
        z_step: Z_STEP,
        has_color_bar: false,
    };
    let mut picture = write::Picture::new(format, &options);
    picture.render(&mut renderer, &input.camera, &settings, on_progress)?;
    let color = color(picture, request.floats);
    let aovs = if request.aovs.is_empty() {
        Vec::new()
    } else {
        let mut all = renderer.aovs(&input.camera, &settings, false, on_progress)?;
        if let Some(instances) = instances {
            placed::number(&mut all.pixels, &input.scene, &instances);
        }
        let axis = Axis::of(&input.scene, &input.camera, &settings);
        let of_kind = |which: &AovKind| (which.name(), values(&all, *which, axis));
        request.aovs.iter().map(of_kind).collect()
    };
    Ok(Picture {
        color,
        aovs,
        notes: input.notes,
    })
}

/// Loads the subject of a picture.
fn loaded(
    subject: Subject<'_>,
    camera: CameraOptions,
    mesh: MeshOptions,
    aspect: f64,
    memory: u64,
) -> Result<(InputPlan, Input), CliError> {
    match subject {
        Subject::File(path) => {
            let plan = InputPlan::new(path, camera, mesh, aspect)?;
            let input = load::load_and_list(&plan, memory, &mut Vec::new())?;
            Ok((plan, input))
        }
        Subject::Bytes(bytes, name) => {
            let plan = InputPlan::in_memory((name, InputKind::Any), camera, mesh, aspect)?;
            let input = load::load_bytes(&plan, bytes, memory)?;
            Ok((plan, input))
        }
        Subject::Mesh(MeshArrays { columns, shown }) => {
            let plan = InputPlan::in_memory((Path::new("mesh"), InputKind::Mesh), camera, mesh, aspect)?;
            let mut mesh = LoadedMesh {
                columns,
                up: UpAxis::Z,
                up_source: UpSource::Stated,
                ..LoadedMesh::default()
            };
            match shown {
                MeshShows::Nothing => {}
                MeshShows::FaceColors(colors) => {
                    ply::paint_triangles(&mut mesh, &colors, plan.name(), memory)?;
                }
                MeshShows::VertexValues(values) => {
                    mesh.columns.colors = values.into_iter().map(channels).collect();
                }
                MeshShows::FaceValues(values) => mesh.scalars.of_faces = values,
            }
            let input = load::show_mesh(&plan, mesh, memory)?;
            Ok((plan, input))
        }
        Subject::Scene(parts) => {
            let plan = InputPlan::in_memory((Path::new("scene"), InputKind::Mesh), camera, mesh, aspect)?;
            let mesh = placed::loaded(parts, plan.name(), memory)?;
            let input = load::show_mesh(&plan, mesh, memory)?;
            Ok((plan, input))
        }
    }
}

/// Moves a scene and its camera to a frame.
fn move_to(input: &mut Input, plan: &InputPlan, frame: u32) -> Result<(), CliError> {
    if input.is_mesh() {
        let why = "frame: meshes have no frames, only scenes with keyframes";
        return Err(CliError::Usage(why.into()));
    }
    let count = input.scene.frame_count();
    if frame > count {
        let why = format!("frame: expected at most {count}, the last frame of the scene, found {frame}");
        return Err(CliError::Usage(why));
    }
    let moved = input.scene.set_time(frame.into());
    moved.map_err(|error| CliError::Failed(error.to_string()))?;
    input.camera = plan.camera.for_scene(&input.scene)?;
    Ok(())
}

/// The colours of a picture.
fn color(picture: write::Picture, floats: bool) -> Values {
    match picture.pixels {
        Pixels::Linear(film) if floats => Values::Floats(film.pixels().as_flattened().to_vec()),
        Pixels::Transparent(film) if floats => Values::Floats(film.pixels().as_flattened().to_vec()),
        _ => Values::Bytes(picture.bytes().into_owned()),
    }
}

/// The values of an AOV.
fn values(aovs: &Aovs, which: AovKind, axis: Axis) -> Values {
    let pixels = &aovs.pixels;
    match which {
        AovKind::Depth => Values::Floats(pixels.iter().map(|pixel| pixel.depth).collect()),
        AovKind::Normal => Values::Floats(pixels.iter().flat_map(|pixel| pixel.normal).collect()),
        AovKind::Albedo => Values::Floats(pixels.iter().flat_map(|pixel| pixel.albedo).collect()),
        AovKind::Id => Values::Whole(pixels.iter().map(|pixel| pixel.primitive.0).collect()),
        AovKind::Heat => Values::Whole(pixels.iter().map(|pixel| pixel.cost.total()).collect()),
        AovKind::Mask => {
            let is_hit = pixels.iter().map(|pixel| pixel.primitive != PrimitiveId::NONE);
            Values::Flags(is_hit.collect())
        }
        AovKind::Z => {
            let z = pixels
                .iter()
                .enumerate()
                .map(|(i, pixel)| axis.z(i, pixel) as f32);
            Values::Floats(z.collect())
        }
        AovKind::Instance => Values::Whole(pixels.iter().map(instance_number).collect()),
    }
}
