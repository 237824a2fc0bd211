//! Embree's devices and scenes, with lifetimes.

use crate::{
    ffi::{self, Api, Arguments, Handle, RayHits, Rays},
    spheres,
};
use octray::scene::{PrototypeId, Scene};
use std::{ffi::CString, marker::PhantomData, time::Instant};

/// A scene's arrays as Embree reads them: shared, not copied.
pub struct Buffers {
    /// One extra vertex at the end, since Embree reads 16 bytes of each.
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    spheres: Vec<[f32; 4]>,
    /// The triangles of prototypes, and where instances place them: matrices by rows.
    prototypes: Vec<Vec<[u32; 3]>>,
    instances: Vec<(usize, [f32; 12])>,
}

impl Buffers {
    pub fn new(scene: &Scene) -> Self {
        let (v, s) = (scene.vertices(), scene.spheres());
        let vertices = (0..v.x.len()).map(|i| [v.x[i], v.y[i], v.z[i]]);
        Self {
            vertices: vertices.chain([[0.0; 3]]).collect(),
            triangles: triangles_of(scene, None),
            spheres: (0..s.radius.len())
                .map(|i| [s.center_x[i], s.center_y[i], s.center_z[i], s.radius[i]])
                .collect(),
            prototypes: (0..scene.prototypes().len() as u32)
                .map(|id| triangles_of(scene, Some(PrototypeId(id))))
                .collect(),
            instances: (scene.instances().iter())
                .map(|instance| (instance.prototype().0 as usize, instance.to_scene()))
                .collect(),
        }
    }

    pub fn has_spheres(&self) -> bool {
        !self.spheres.is_empty()
    }

    /// The id of the first primitive of each geometry, by its number.
    fn first_ids(&self) -> [u32; 2] {
        [0, self.triangles.len() as u32]
    }
}

/// The triangles of a prototype, or those outside of all.
fn triangles_of(scene: &Scene, prototype: Option<PrototypeId>) -> Vec<[u32; 3]> {
    let corners = &scene.triangles().corners;
    let ids = scene.ids_of(prototype).into_iter().flatten();
    ids.filter_map(|id| corners.get(id as usize).copied()).collect()
}

/// How a scene is built, and which code traces it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Build {
    /// AVX2 instead of the CPU's best instruction set.
    pub avx2: bool,
    /// High quality (with spatial splits) instead of medium.
    pub high: bool,
    /// With Embree's robust flag.
    pub robust: bool,
    /// Spheres are geometry of our own instead of Embree's.
    pub own_spheres: bool,
}

/// A built scene.
pub struct EmbreeScene<'a> {
    pub api: &'a Api,
    pub build: Build,
    /// Seconds that committing geometries and scene took.
    pub build_seconds: f64,
    device: Handle,
    scene: Handle,
    prototypes: Vec<Handle>,
    first_ids: [u32; 2],
    buffers: PhantomData<&'a Buffers>,
}

// SAFETY: tracing from any thread is what the interface allows once a scene is committed.
unsafe impl Send for EmbreeScene<'_> {}
// SAFETY: as above; nothing here changes a committed scene.
unsafe impl Sync for EmbreeScene<'_> {}

impl<'a> EmbreeScene<'a> {
    /// Builds a scene on `threads` threads.
    ///
    /// # Errors
    /// If Embree reports an error.
    pub fn new(api: &'a Api, buffers: &'a Buffers, build: Build, threads: usize) -> Result<Self, String> {
        let isa = if build.avx2 { ",isa=avx2" } else { "" };
        let config = CString::new(format!("threads={threads},set_affinity=0{isa}")).unwrap_or_default();
        let quality = if build.high { ffi::HIGH } else { ffi::MEDIUM };
        // SAFETY: handles go back to their library in the order it requires. The buffers have the formats, strides and
        // counts given with them, and outlive the scene.
        unsafe {
            let device = (api.new_device)(config.as_ptr());
            let scene = (api.new_scene)(device);
            (api.set_scene_flags)(scene, if build.robust { ffi::ROBUST } else { 0 });
            (api.set_scene_build_quality)(scene, quality);
            let mut built = Self {
                api,
                build,
                build_seconds: 0.0,
                device,
                scene,
                prototypes: Vec::new(),
                first_ids: buffers.first_ids(),
                buffers: PhantomData,
            };
            let mut geometries = Vec::new();
            if !buffers.triangles.is_empty() {
                let geometry = (api.new_geometry)(device, ffi::TRIANGLE);
                let vertices = &buffers.vertices[..buffers.vertices.len() - 1];
                share(api, geometry, ffi::VERTEX, ffi::FLOAT3, vertices);
                share(api, geometry, ffi::INDEX, ffi::UINT3, &buffers.triangles);
                geometries.push(geometry);
            }
            if !buffers.spheres.is_empty() {
                let kind = if build.own_spheres {
                    ffi::USER
                } else {
                    ffi::SPHERE_POINT
                };
                let geometry = (api.new_geometry)(device, kind);
                if build.own_spheres {
                    spheres::set(api, geometry, &buffers.spheres);
                } else {
                    share(api, geometry, ffi::VERTEX, ffi::FLOAT4, &buffers.spheres);
                }
                geometries.push(geometry);
            }
            let start = Instant::now();
            built.add_instances(buffers, quality);
            for &geometry in &geometries {
                (api.set_geometry_build_quality)(geometry, quality);
                (api.commit_geometry)(geometry);
                (api.attach_geometry)(scene, geometry);
                (api.release_geometry)(geometry);
            }
            (api.commit_scene)(scene);
            built.build_seconds = start.elapsed().as_secs_f64();
            match (api.device_error)(device) {
                0 => Ok(built),
                code => Err(format!("Embree cannot build the scene: error {code}")),
            }
        }
    }

    /// Adds the instances, and the scenes that they place.
    ///
    /// # Safety
    /// Device and scene are valid, and the scene is not committed yet.
    unsafe fn add_instances(&mut self, buffers: &Buffers, quality: u32) {
        let Self {
            api, device, scene, ..
        } = *self;
        // SAFETY: as in `new`; Embree copies the matrices.
        unsafe {
            for triangles in &buffers.prototypes {
                let prototype = (api.new_scene)(device);
                (api.set_scene_flags)(prototype, if self.build.robust { ffi::ROBUST } else { 0 });
                (api.set_scene_build_quality)(prototype, quality);
                let geometry = (api.new_geometry)(device, ffi::TRIANGLE);
                let vertices = &buffers.vertices[..buffers.vertices.len() - 1];
                share(api, geometry, ffi::VERTEX, ffi::FLOAT3, vertices);
                share(api, geometry, ffi::INDEX, ffi::UINT3, triangles);
                (api.set_geometry_build_quality)(geometry, quality);
                (api.commit_geometry)(geometry);
                (api.attach_geometry)(prototype, geometry);
                (api.release_geometry)(geometry);
                (api.commit_scene)(prototype);
                self.prototypes.push(prototype);
            }
            for (prototype, rows) in &buffers.instances {
                let geometry = (api.new_geometry)(device, ffi::INSTANCE);
                (api.set_geometry_instanced_scene)(geometry, self.prototypes[*prototype]);
                (api.set_geometry_transform)(geometry, 0, ffi::ROWS_3X4, rows.as_ptr().cast());
                (api.commit_geometry)(geometry);
                (api.attach_geometry)(scene, geometry);
                (api.release_geometry)(geometry);
            }
        }
    }

    /// The closest hits of packet `rays`.
    #[inline(always)]
    pub fn intersect1(&self, rays: &mut RayHits<1>, arguments: &Arguments) {
        // SAFETY: the scene is committed, the layouts are Embree's.
        unsafe { (self.api.intersect1)(self.scene, rays, arguments) }
    }

    /// See [`Self::intersect1`]; -1 in `valid` for lanes with a ray, else 0.
    #[inline(always)]
    pub fn intersect8(&self, valid: &[i32; 8], rays: &mut RayHits<8>, arguments: &Arguments) {
        // SAFETY: as above; `RayHits` is aligned to 64 bytes, and callers align `valid`.
        unsafe { (self.api.intersect8)(valid.as_ptr(), self.scene, rays, arguments) }
    }

    /// See [`Self::intersect8`].
    #[inline(always)]
    pub fn intersect16(&self, valid: &[i32; 16], rays: &mut RayHits<16>, arguments: &Arguments) {
        // SAFETY: as above.
        unsafe { (self.api.intersect16)(valid.as_ptr(), self.scene, rays, arguments) }
    }

    /// Sets `t_far` of a blocked ray to minus infinity.
    #[inline(always)]
    pub fn occluded1(&self, rays: &mut RayHits<1>, arguments: &Arguments) {
        // SAFETY: the scene is committed; the rays come first in `RayHits`, in Embree's layout.
        unsafe { (self.api.occluded1)(self.scene, rays, arguments) }
    }

    /// See [`Self::occluded1`] and [`Self::intersect8`].
    #[inline(always)]
    pub fn occluded8(&self, valid: &[i32; 8], rays: &mut RayHits<8>, arguments: &Arguments) {
        // SAFETY: as above.
        unsafe { (self.api.occluded8)(valid.as_ptr(), self.scene, rays, arguments) }
    }

    /// See [`Self::occluded8`].
    #[inline(always)]
    pub fn occluded16(&self, valid: &[i32; 16], rays: &mut RayHits<16>, arguments: &Arguments) {
        // SAFETY: as above.
        unsafe { (self.api.occluded16)(valid.as_ptr(), self.scene, rays, arguments) }
    }

    /// octray's id of a primitive.
    pub fn primitive_id(&self, geometry: u32, primitive: u32) -> u32 {
        match self.first_ids.get(geometry as usize) {
            Some(first) => first + primitive,
            None => ffi::NONE,
        }
    }
}

impl Drop for EmbreeScene<'_> {
    fn drop(&mut self) {
        // SAFETY: both are ours, and nothing uses them after.
        unsafe {
            (self.api.release_scene)(self.scene);
            for &prototype in &self.prototypes {
                (self.api.release_scene)(prototype);
            }
            (self.api.release_device)(self.device);
        }
    }
}

/// # Safety
/// `items` outlives `geometry`, and an item has the format.
unsafe fn share<T>(api: &Api, geometry: Handle, buffer: u32, format: u32, items: &[T]) {
    let stride = size_of::<T>();
    // SAFETY: as the caller promises.
    unsafe {
        (api.set_shared_geometry_buffer)(
            geometry,
            buffer,
            0,
            format,
            items.as_ptr().cast(),
            0,
            stride,
            items.len(),
        );
    }
}

/// Checks the layouts against the library, with rays whose lanes each have a different, known hit: down onto a row of
/// triangles (even lanes; lane 4 misses) and spheres (odd lanes).
///
/// # Errors
/// Names the lane and packet with a wrong hit.
pub fn self_check(api: &Api) -> Result<(), String> {
    let at = |lane: usize| lane as f32 * 4.0;
    let mut buffers = Buffers {
        vertices: Vec::new(),
        triangles: Vec::new(),
        spheres: Vec::new(),
        prototypes: Vec::new(),
        instances: Vec::new(),
    };
    for lane in 0..16 {
        let (x, first) = (at(lane), buffers.vertices.len() as u32);
        buffers
            .vertices
            .extend([[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]]);
        buffers.triangles.push([first, first + 1, first + 2]);
        buffers.spheres.push([x + 2.0, 0.0, 0.0, 0.5]);
    }
    buffers.vertices.push([0.0; 3]);
    for own_spheres in [false, true] {
        let build = Build {
            own_spheres,
            ..Build::default()
        };
        check_answers(&EmbreeScene::new(api, &buffers, build, 1)?, at)?;
    }
    Ok(())
}

fn check_answers(scene: &EmbreeScene<'_>, at: impl Fn(usize) -> f32) -> Result<(), String> {
    let arguments = Arguments::new(true);
    let x = |lane: usize| match lane {
        4 => at(lane) + 3.0,
        odd if odd % 2 == 1 => at(lane) + 2.0,
        _ => at(lane) + 0.25,
    };
    fn packet<const N: usize>(x: impl Fn(usize) -> f32) -> RayHits<N> {
        let mut rays = empty::<N>();
        rays.rays.origin = [std::array::from_fn(x), [0.125; N], [2.0; N]];
        rays.rays.direction = [[0.0; N], [0.0; N], [-1.0; N]];
        rays.rays.t_far = [10.0; N];
        rays
    }
    let check = |width: usize, lane: usize, t: f32, u: f32, v: f32, id: u32| {
        let (expected_t, expected_id) = match lane {
            4 => (10.0, ffi::NONE),
            odd if odd % 2 == 1 => (2.0 - (0.25f32 - 0.125 * 0.125).sqrt(), 16 + lane as u32),
            _ => (2.0, lane as u32),
        };
        // Not to the bit: Embree divides by approximate reciprocals, which differ from CPU to CPU.
        let near = |found: f32, expected: f32| (found - expected).abs() < 1e-4;
        let weights = id == ffi::NONE || id >= 16 || near(u, 0.25) && near(v, 0.125);
        if near(t, expected_t) && id == expected_id && weights {
            Ok(())
        } else {
            Err(format!(
                "this Embree has other layouts: lane {lane} of {width} hits {id} at {t}, {u}, {v}; expected \
                 {expected_id} at {expected_t}"
            ))
        }
    };
    let mut rays16 = packet::<16>(x);
    scene.intersect16(&Aligned([-1; 16]).0, &mut rays16, &arguments);
    let mut rays8 = packet::<8>(x);
    scene.intersect8(&Aligned([-1; 8]).0, &mut rays8, &arguments);
    for lane in 0..16 {
        let id = scene.primitive_id(rays16.geometry[lane], rays16.primitive[lane]);
        check(
            16,
            lane,
            rays16.rays.t_far[lane],
            rays16.u[lane],
            rays16.v[lane],
            id,
        )?;
        let mut rays1 = packet::<1>(|_| x(lane));
        scene.intersect1(&mut rays1, &arguments);
        let id = scene.primitive_id(rays1.geometry[0], rays1.primitive[0]);
        check(1, lane, rays1.rays.t_far[0], rays1.u[0], rays1.v[0], id)?;
        if lane < 8 {
            let id = scene.primitive_id(rays8.geometry[lane], rays8.primitive[lane]);
            check(8, lane, rays8.rays.t_far[lane], rays8.u[lane], rays8.v[lane], id)?;
        }
    }
    Ok(())
}

#[repr(align(64))]
struct Aligned<T>(T);

/// A packet without rays, ready for either call.
pub fn empty<const N: usize>() -> RayHits<N> {
    RayHits {
        rays: Rays {
            origin: [[0.0; N]; 3],
            t_near: [0.0; N],
            direction: [[0.0; N], [0.0; N], [1.0; N]],
            time: [0.0; N],
            t_far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        },
        normal: [[0.0; N]; 3],
        u: [0.0; N],
        v: [0.0; N],
        primitive: [ffi::NONE; N],
        geometry: [ffi::NONE; N],
        instance: [ffi::NONE; N],
        instance_primitive: [ffi::NONE; N],
    }
}
