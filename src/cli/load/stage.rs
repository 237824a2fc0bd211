//! The scene around a mesh without one: lights, a background, optionally a ground.

use crate::{
    cli::plan::Style,
    error::SceneError,
    format::mesh::{LoadedMesh, Surface, exposed, sphere_around},
    math::{self, Aabb},
    scene::{
        Background, Environment, EnvironmentPicture, MAX_COORDINATE, Material, PlacedMesh, Scene,
        SceneBuilder, TriangleMesh,
    },
};
use glam::{DVec3, Vec3};

/// The bounds of a mesh, or of the spheres and tubes of a cloud.
pub(super) fn bounds_of(loaded: &LoadedMesh) -> Aabb {
    let mut bounds = PlacedMesh::bounds(&loaded.placed());
    if let Some(cloud) = &loaded.cloud
        && !bounds.is_empty()
    {
        let reach = Vec3::splat(cloud.radius(&loaded.columns));
        (bounds.lower, bounds.upper) = (bounds.lower - reach, bounds.upper + reach);
    }
    bounds
}

/// The viewing direction of the mesh, and its surroundings.
pub struct Stage<'a> {
    /// From the target to the viewer, of any length.
    pub towards_viewer: DVec3,
    /// A unit vector.
    pub up: DVec3,
    pub ground: bool,
    pub style: Style,
    /// Whether clay keeps the mesh's colours.
    pub is_colored: bool,
    /// Whether the mesh's own lights replace the style's.
    pub own_lights: bool,
    /// What the surroundings stand around instead of the mesh, with the same offset. Its lights decide how bright those of the
    /// mesh are.
    pub around: Option<&'a LoadedMesh>,
}

/// Places the lights of a mesh by the direction of the viewer.
#[derive(Clone, Copy, Debug)]
pub struct Rig {
    /// What `center` and the scene are relative to.
    offset: DVec3,
    center: DVec3,
    radius: f64,
    up: DVec3,
    style: Style,
}

impl Rig {
    /// The rig of a mesh, and the bounds of what it stands around.
    fn of(loaded: &LoadedMesh, stage: &Stage<'_>) -> (Self, Aabb) {
        let loaded = stage.around.unwrap_or(loaded);
        let bounds = bounds_of(loaded);
        let (center, radius) = sphere_around(&bounds);
        let rig = Self {
            offset: loaded.offset,
            center,
            radius,
            up: stage.up,
            style: stage.style,
        };
        (rig, bounds)
    }

    /// A scene with the lights only.
    ///
    /// # Errors
    /// [`SceneError`].
    pub fn lights(&self, towards_viewer: DVec3) -> Result<Scene, SceneError> {
        let mut builder = SceneBuilder::new();
        builder.set_offset(self.offset)?;
        self.add_lights(towards_viewer, &mut builder)?;
        Ok(builder.finish())
    }

    fn add_lights(&self, towards_viewer: DVec3, builder: &mut SceneBuilder) -> Result<(), SceneError> {
        let towards_viewer = math::moderate(towards_viewer).normalize_or(DVec3::X);
        let right = self
            .up
            .cross(towards_viewer)
            .normalize_or(self.up.any_orthonormal_vector());
        let up = towards_viewer.cross(right);
        let lights = if self.style.is_soft() {
            &[SOFT_LIGHT][..]
        } else {
            &LIGHTS
        };
        for &([to_right, upwards, forwards], intensity, size) in lights {
            let direction = right * to_right + up * upwards + towards_viewer * forwards;
            let position = self.center + direction.normalize() * (self.radius * LIGHT_DISTANCE);
            let radius = (self.radius * size) as f32;
            builder.add_sphere_light(position.as_vec3(), radius, intensity, [1.0; 3])?;
        }
        Ok(())
    }
}

const BACKGROUND: [f32; 3] = [0.93, 0.94, 0.96];
const AMBIENT: f32 = 0.2;
const GROUND: [f32; 3] = [0.95, 0.95, 0.94];

/// Key light and fill light: direction as seen by the viewer (right, up, towards the viewer), intensity, and radius in
/// radii of the mesh. Together with the ambient light they reach at most 1, so that a white mesh is not overexposed.
const LIGHTS: [([f64; 3], f32, f64); 2] = [([-0.6, 0.8, 1.0], 0.6, 0.0), ([0.5, 0.1, 1.0], 0.3, 0.0)];

/// The light of the soft styles: 23 degrees wide, like a large window across a room.
const SOFT_LIGHT: ([f64; 3], f32, f64) = ([-0.8, 0.9, 0.8], 0.73, 20.0);
/// Their ambient light, and its occlusion distance in radii of the mesh.
const SOFT_AMBIENT: (f32, f64) = (0.27, 1.2);
/// Linear, as their other colours. White surfaces that face the viewer are darker, those that face up in the default view are
/// brighter, both by at least 10 of 255 levels of sRGB.
const SOFT_BACKGROUND: [f32; 3] = [0.75, 0.76, 0.78];
const SOFT_GROUND: [f32; 3] = [0.78, 0.78, 0.78];

/// Distance of the lights, in radii of the mesh: far enough to light the ground evenly.
const LIGHT_DISTANCE: f64 = 100.0;
/// Half the side of the ground, in radii of the mesh.
const GROUND_REACH: f64 = 40.0;
/// Gap between mesh and ground, in radii of the mesh.
const GROUND_GAP: f64 = 1e-3;

/// The scene of a mesh.
pub struct Built {
    pub scene: Scene,
    /// Lights the mesh for other viewers, unless the environment or its own lights do.
    pub rig: Option<Rig>,
    /// Those of the mesh alone, or of what its surroundings stand around, relative to its offset.
    pub bounds: Aabb,
}

/// A scene of the mesh, which may take `memory` bytes.
///
/// # Errors
/// A sentence.
pub fn build(
    loaded: LoadedMesh,
    stage: &Stage<'_>,
    environment: Option<EnvironmentPicture>,
    memory: u64,
) -> Result<Built, String> {
    let (rig, bounds) = Rig::of(&loaded, stage);
    let mut builder = SceneBuilder::within(memory);
    builder
        .set_offset(loaded.offset)
        .map_err(|error| error.to_string())?;
    if let Some(environment) = environment {
        let set = builder.set_environment(Environment::Picture(environment));
        let scene = set.and_then(|()| furnished(loaded, stage, (&rig, &bounds), builder, true));
        let scene = scene.map_err(|error| error.to_string())?;
        return Ok(Built {
            scene,
            rig: None,
            bounds,
        });
    }
    let own = if stage.own_lights && stage.style == Style::Studio {
        let reference = &stage.around.unwrap_or(&loaded).lights;
        exposed(&loaded.lights, reference, SOFT_LIGHT.1, (rig.center, rig.radius))
    } else {
        Vec::new()
    };
    let is_own = !own.is_empty();
    let lit = if is_own {
        own.into_iter().try_for_each(|light| builder.add(light))
    } else {
        rig.add_lights(stage.towards_viewer, &mut builder)
    };
    lit.map_err(|error| match error {
        SceneError::NotUsable { .. } if !is_own => {
            let reach = rig.radius;
            format!(
                "the mesh reaches {reach:.1e} from its middle, so that its lights, {LIGHT_DISTANCE} times as far away, \
                 would be beyond {MAX_COORDINATE:e}; scale it down"
            )
        }
        error => error.to_string(),
    })?;
    let scene = furnished(loaded, stage, (&rig, &bounds), builder, false);
    let scene = scene.map_err(|error| error.to_string())?;
    let rig = (!is_own).then_some(rig);
    Ok(Built { scene, rig, bounds })
}

/// Adds the mesh and its surroundings to the lights. `is_lit`: by an environment, from all sides.
fn furnished(
    mut loaded: LoadedMesh,
    stage: &Stage<'_>,
    (rig, bounds): (&Rig, &Aabb),
    mut builder: SceneBuilder,
    is_lit: bool,
) -> Result<Scene, SceneError> {
    let mut ground_color = GROUND;
    if stage.style.is_soft() {
        if is_lit {
            builder.set_ambient(0.0)?;
        } else {
            let (ambient, reach) = SOFT_AMBIENT;
            builder.set_ambient(ambient)?;
            builder.set_ambient_reach(Some((reach * rig.radius).min(f64::from(MAX_COORDINATE)) as f32))?;
            builder.set_background(Background::constant(SOFT_BACKGROUND))?;
        }
        builder.set_smooth_shadows(true);
        builder.set_ambient_specular(true);
        ground_color = SOFT_GROUND;
        if stage.style == Style::Clay && !stage.is_colored {
            loaded.paint(Surface::CLAY);
        }
        loaded.linearize();
    } else {
        builder.set_ambient(AMBIENT)?;
        builder.set_background(Background::constant(BACKGROUND))?;
    }
    loaded.add_to(&mut builder, None)?;
    if stage.ground {
        let material = builder.add_material(Material::Matte { color: ground_color })?;
        builder.add_mesh_without_edges(ground(stage.up, bounds, rig.center, rig.radius), material)?;
    }
    Ok(builder.finish())
}

/// A square just below the mesh.
fn ground(up: DVec3, bounds: &Aabb, center: DVec3, radius: f64) -> TriangleMesh {
    let [lower, upper] = [bounds.lower, bounds.upper].map(|corner| corner.as_dvec3().dot(up));
    let lowest = lower.min(upper);
    let lowest = if lowest.is_finite() { lowest } else { 0.0 };
    let middle = center + up * (lowest - center.dot(up) - GROUND_GAP * radius);
    let (a, b) = up.any_orthonormal_pair();
    let reach = GROUND_REACH * radius;
    let corners =
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[s, t]| middle + (a * s + b * t) * reach);
    TriangleMesh {
        x: corners.map(|p| p.x as f32).to_vec(),
        y: corners.map(|p| p.y as f32).to_vec(),
        z: corners.map(|p| p.z as f32).to_vec(),
        normals: Vec::new(),
        colors: Vec::new(),
        uvs: Vec::new(),
        tangents: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}
