//! octray traces rays through scenes of triangle meshes and spheres on the CPU: camera rays, shadows, matte,
//! Blinn-Phong and mirror shading (Whitted 1980), in SIMD packets of 8 to 32 rays and bundles of sixteen packets.
//! The same scene gives the same bytes, whichever code traces it and on however many threads.
//!
//! # From a file to a picture
//! ```
//! use octray::{accel::Bvh, format, render::{Settings, render}, scene::Camera};
//! use std::{ops::ControlFlow, path::Path};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # std::env::set_current_dir(env!("CARGO_MANIFEST_DIR"))?;
//! let scene = format::load(Path::new("scenes/reflections.scn"))?;
//! let bvh = Bvh::build(&scene);
//! let camera = Camera::classic_view(1).ok_or("there are six viewpoints")?;
//! let settings = Settings { width: 64, height: 64, ..Settings::default() };
//! let frame = render(&scene, &bvh, &camera, &settings, &|_| ControlFlow::Continue(()))?;
//! let rgb: Vec<u8> = frame.film.to_rgb8();
//! assert_eq!(rgb.len(), 64 * 64 * 3);
//! # Ok(())
//! # }
//! ```
//!
//! # A scene from code
//! ```
//! use glam::{DVec3, Vec3};
//! use octray::{accel::Bvh, render::{Settings, render}, scene::{Camera, MeshColumns, SceneBuilder}};
//! use std::ops::ControlFlow;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut builder = SceneBuilder::new();
//! let matte = builder.classic_material(1)?;
//! let mirror = builder.classic_material(3)?;
//! builder.add_light(Vec3::new(4.0, -3.0, 8.0), 0.9)?;
//! builder.add_sphere(Vec3::new(0.0, 0.0, 0.5), 0.5, mirror)?;
//! let floor = MeshColumns {
//!     x: vec![-2.0, 2.0, 2.0, -2.0],
//!     y: vec![-2.0, -2.0, 2.0, 2.0],
//!     z: vec![0.0; 4],
//!     normals: Vec::new(),
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//! };
//! builder.add_mesh(floor, matte)?;
//! let scene = builder.finish();
//!
//! let camera = Camera::look_at(DVec3::new(4.0, 2.0, 2.0), DVec3::new(0.0, 0.0, 0.5), DVec3::Z, 40.0)?;
//! let settings = Settings { width: 64, height: 48, samples: 4, ..Settings::default() };
//! let frame = render(&scene, &Bvh::build(&scene), &camera, &settings, &|_| ControlFlow::Continue(()))?;
//! assert_eq!(frame.rays.camera, 64 * 48 * 4);
//! # Ok(())
//! # }
//! ```
//!
//! # Progress and cancellation
//! The callback runs on the render threads after every tile; `Break` stops the rendering.
//! ```
//! use octray::{accel::Bvh, render::{RenderError, Settings, render}, scene::{Camera, SceneBuilder}};
//! use std::ops::ControlFlow;
//!
//! let scene = SceneBuilder::new().finish();
//! let camera = Camera::classic_view(2).unwrap();
//! let stopped = render(&scene, &Bvh::build(&scene), &camera, &Settings::default(), &|progress| {
//!     if progress.pixels_done * 2 < progress.pixels_total {
//!         ControlFlow::Continue(())
//!     } else {
//!         ControlFlow::Break(())
//!     }
//! });
//! assert_eq!(stopped.err(), Some(RenderError::Cancelled));
//! ```
//!
//! # A pixel's way
//! 1. [`format::load`] reads bytes into statements, each with its place; [`scene::SceneBuilder`] checks them and
//!    finishes the columns of a [`scene::Scene`].
//! 2. [`accel::Bvh::build`] divides the primitives top down and writes nodes of eight children and leaf blocks of up to
//!    eight primitives.
//! 3. [`render::Renderer`] hands bands of tiles to rayon's threads; a tile owns its pixels. [`render::render`] is
//!    one frame of it.
//! 4. [`scene::PixelRays`] fills the tile's ray queue, packets of 4x2 pixels, bundles of one or two blocks of 16x16.
//!    (A tile [without anything to hit](trace::Tracer::may_hit) takes the background and is done.)
//! 5. [`trace::Tracer::closest_hit`] fills the hit records of the whole tile.
//! 6. [`shade::queue::sort`] files hits by material; misses take the background.
//! 7. [`shade::shadow::pass`] traces one run of occlusion rays for each light, from the light.
//! 8. [`shade::material::color`] adds weight x colour by pixel, a pass for each material; mirrors push rays into
//!    the other queue, and it goes on with 5 until that is empty or the depth is reached.
//! 9. [`render::Film`] holds linear colour and turns it into bytes.
//!
//! # The rooms
//! | module | what it is |
//! |---|---|
//! | [`error`], [`math`], [`classic`] | errors with places; boxes and scalar arithmetic; the numbers of a classic scene |
//! | [`simd`], [`ray`] | eight lanes, their masks and vectors; rays and hits, single and in packets |
//! | [`geometry`] | the canonical tests of one primitive against eight rays and eight against one |
//! | [`scene`], [`mod@format`], [`generate`] | columns, from files or from a seed |
//! | [`accel`], [`trace`] | the hierarchies; closest hits and occlusion |
//! | [`shade`], [`render`] | batched passes; tiles, frames and film |
//! | [`mod@reference`] | the scalar truth that all of this is held to |
//! | [`mod@bench`] | the workload that speed is judged by |
//! | [`verify`] | random scenes and rays, on which every way of tracing must find what brute force finds |

pub use glam;

pub mod accel;
pub mod bench;
pub mod classic;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
pub mod error;
pub mod format;
pub mod generate;
pub mod geometry;
#[cfg(feature = "cli")]
mod heat;
pub mod math;
pub mod ray;
pub mod reference;
pub mod render;
pub mod scene;
pub mod shade;
pub mod simd;
pub mod trace;
pub mod verify;
#[cfg(feature = "viewer")]
#[doc(hidden)]
pub mod viewer;
#[cfg(feature = "png")]
mod whole_file;
