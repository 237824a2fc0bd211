//! octray ray-traces triangle meshes and spheres on the CPU, with SIMD, on all cores. The same scene gives the same
//! bytes on any number of threads, whether SIMD or scalar code traces it.
//!
//! [`Geometry`] finds hits of rays, distances of points, and what is inside, [`InstancedGeometry`] hits of placed geometries.
//! [`render::render`] makes pictures of scenes, with textures, soft shadows, mirrors and glass. docs/library.md has more
//! examples, and what is exact.
//!
//! # Ray queries
//! ```
//! use octray::{Geometry, Hit, Ray};
//! # fn main() -> Result<(), octray::QueryError> {
//! let positions = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
//! let geometry = Geometry::from_triangles(&positions, &[[0, 1, 2]])?;
//! let rays = [Ray::new([0.25, 0.25, 3.0], [0.0, 0.0, -2.0]), Ray::new([0.25, 0.25, 3.0], [1.0, 0.0, 0.0])];
//! let mut hits = [Hit::default(); 2];
//! geometry.closest_hits(&rays, &mut hits);
//! assert_eq!(hits[0].t, 1.5); // in units of the direction's length
//! assert!(!hits[1].is_hit());
//! # Ok(())
//! # }
//! ```
//!
//! # A scene from code
//! ```
//! use octray::{accel::Bvh, glam::{DVec3, Vec3}, render::{Settings, Transfer, render}, scene::{Camera, SceneBuilder}};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut builder = SceneBuilder::new();
//! let mirror = builder.classic_material(3)?;
//! builder.add_light(Vec3::new(4.0, -3.0, 8.0), 0.9)?;
//! builder.add_sphere(Vec3::new(0.0, 0.0, 0.5), 0.5, mirror)?;
//! let scene = builder.finish();
//! let camera = Camera::look_at(DVec3::new(4.0, 2.0, 2.0), DVec3::new(0.0, 0.0, 0.5), DVec3::Z, 40.0)?;
//! let settings = Settings { width: 64, height: 48, samples: 4, ..Settings::default() };
//! let frame = render(&scene, &Bvh::build(&scene), &camera, &settings, &|_| std::ops::ControlFlow::Continue(()))?;
//! let rgb: Vec<u8> = frame.film.to_bytes(Transfer::Srgb);
//! let ppm = [b"P6 64 48 255\n", &rgb[..]].concat(); // a picture file
//! # assert_eq!((frame.rays.camera, ppm.len()), (64 * 48 * 4, 13 + 64 * 48 * 3));
//! # Ok(())
//! # }
//! ```
//!
//! # A scene from a file
//! ```
//! use octray::{accel::Bvh, format, render::{Settings, render}, scene::Camera};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
//! let scene = format::load("scenes/reflections.scn".as_ref())?;
//! let camera = Camera::classic_view(1).ok_or("there are six viewpoints")?;
//! let settings = Settings { width: 64, height: 64, ..Settings::default() };
//! // The callback gets the progress after every tile; `Break` cancels the frame.
//! let frame = render(&scene, &Bvh::build(&scene), &camera, &settings, &|_| std::ops::ControlFlow::Continue(()))?;
//! # assert_eq!(frame.film.to_rgb8().len(), 64 * 64 * 3);
//! # Ok(())
//! # }
//! ```
//!
//! # Modules
//! | module | contents |
//! |---|---|
//! | [`query`] | geometry, and queries with rays and points |
//! | [`scene`], [`mod@format`], [`generate`] | scenes built by code, read from files, or made from a seed |
//! | [`accel`], [`render`] | the BVH of a scene; frames, settings, film |
//! | [`Level`] | the instruction set, chosen at run time |
//! | [`error`] | errors with file, line and column |
//!
//! # Features
//! | feature | adds | default |
//! |---|---|---|
//! | `png` | [`render::Film`]'s `save_png` | yes |
//! | `gltf` | glTF files | yes |
//! | `threemf` | 3MF files | yes |
//! | `vtk` | VTK files: .vtk, .vtp and .vtu | yes |
//! | `textures` | images of materials: PNG, JPEG, WebP, BMP, TGA, GIF, TIFF | yes |
//! | `cli` | the program `octray`; implies `png`, `gltf`, `threemf`, `vtk` and `textures` | yes |
//! | `viewer` | the command `octray view`; implies `cli` | yes |
//! | `embree-bench` | the benchmark against Intel's Embree, loaded at run time | no |

pub use glam;
pub use octray_engine::{
    Aabb, Geometry, Hit, InstanceId, InstancedGeometry, InstancedHit, Level, LevelError, PrimitiveId,
    QueryError, Ray, Rays, isa,
};
#[doc(inline)]
pub use octray_engine::{accel, error, query, render, scene};
#[doc(hidden)]
pub use octray_engine::{classic, geometry, lanes, math, ray, reference, shade, trace};
#[allow(unused_imports, reason = "the bare library needs neither")]
pub(crate) use octray_engine::{simd, sobol, whole_file};

#[doc(hidden)]
pub mod bench;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod format;
pub mod generate;
#[cfg(feature = "cli")]
mod heat;
#[doc(hidden)]
pub mod verify;
#[cfg(feature = "viewer")]
#[doc(hidden)]
pub mod viewer;

/// The examples of the documents compile.
#[cfg(all(doctest, feature = "png"))]
mod documents {
    #[doc = include_str!("../README.md")]
    mod readme {}
    #[doc = include_str!("../docs/library.md")]
    mod library {}
}
