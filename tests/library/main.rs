//! Tests of the library, in one program: linking takes longer than running them.

#[path = "../common/images.rs"]
mod images;
#[path = "../common/long.rs"]
mod long;
mod random;
mod seeds;
mod targets;

mod adaptive;
mod blending;
mod broken_inputs;
mod build;
mod cameras;
mod classic_files;
mod classic_images;
mod coincident;
mod documents;
mod edges;
mod error_kinds;
mod errors;
mod generated_files;
mod glass;
mod golden;
mod instance_limits;
mod instances;
mod layering;
mod levels;
mod lights;
mod lines;
mod map_coordinates;
mod mesh_files;
mod moving;
mod normal_maps;
mod numbers;
mod occlusion_maps;
mod odd_scenes;
mod one_sided;
mod picture;
mod planes;
mod queries;
mod reference;
mod replay;
mod same_hits;
mod sameness;
mod scaling;
mod scene_language;
#[cfg(feature = "gltf")]
mod shared_meshes;
mod smooth_shadows;
mod soft_light;
mod spots;
mod strangers_mesh;
mod strangers_scene;
#[cfg(feature = "textures")]
mod textures;
#[cfg(feature = "threemf")]
mod threemf;
mod tracer;
#[cfg(feature = "gltf")]
mod transmission;
#[cfg(feature = "vtk")]
mod vtk;
mod water;
mod watertight;

/// Loads `scenes/NAME.scn`.
fn shipped_scene(name: &str) -> octray::scene::Scene {
    let path = images::package().join("scenes").join(format!("{name}.scn"));
    octray::format::load(&path).unwrap_or_else(|error| panic!("{error}"))
}
