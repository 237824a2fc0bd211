//! The part of Embree 4's C interface that the bench uses, declared by hand and loaded at run time.
//!
//! Layouts are those of `rtcore_ray.h` and `rtcore_scene.h` of Embree 4.4, built as its authors build it: one
//! instance level, instance arrays on, no minimum curve width. `device::self_check` shows that they fit the
//! library at hand.

use libloading::Library;
use std::{
    ffi::{c_char, c_int, c_uint, c_void},
    path::{Path, PathBuf},
};

/// Where `fetch.sh` unpacks the library.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/target/embree/embreex.libs");

/// `RTC_INVALID_GEOMETRY_ID`.
pub const NONE: u32 = u32::MAX;
/// `RTC_GEOMETRY_TYPE_TRIANGLE`.
pub const TRIANGLE: c_uint = 0;
/// `RTC_GEOMETRY_TYPE_SPHERE_POINT`.
pub const SPHERE_POINT: c_uint = 50;
/// `RTC_GEOMETRY_TYPE_USER`.
pub const USER: c_uint = 120;
/// `RTC_GEOMETRY_TYPE_INSTANCE`.
pub const INSTANCE: c_uint = 121;
/// `RTC_BUFFER_TYPE_INDEX`.
pub const INDEX: c_uint = 0;
/// `RTC_BUFFER_TYPE_VERTEX`.
pub const VERTEX: c_uint = 1;
/// `RTC_FORMAT_UINT3`.
pub const UINT3: c_uint = 0x5003;
/// `RTC_FORMAT_FLOAT3`.
pub const FLOAT3: c_uint = 0x9003;
/// `RTC_FORMAT_FLOAT4`.
pub const FLOAT4: c_uint = 0x9004;
/// `RTC_FORMAT_FLOAT3X4_ROW_MAJOR`.
pub const ROWS_3X4: c_uint = 0x9134;
/// `RTC_BUILD_QUALITY_MEDIUM`.
pub const MEDIUM: c_uint = 1;
/// `RTC_BUILD_QUALITY_HIGH`.
pub const HIGH: c_uint = 2;
/// `RTC_SCENE_FLAG_ROBUST`.
pub const ROBUST: c_uint = 1 << 2;
/// `RTC_RAY_QUERY_FLAG_COHERENT`; incoherent is 0.
pub const COHERENT: c_uint = 1 << 16;

/// `RTCDevice`, `RTCScene` or `RTCGeometry`.
pub type Handle = *mut c_void;

/// `RTCRay`, `RTCRay8`, `RTCRay16`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Rays<const N: usize> {
    pub origin: [[f32; N]; 3],
    pub t_near: [f32; N],
    pub direction: [[f32; N]; 3],
    pub time: [f32; N],
    pub t_far: [f32; N],
    pub mask: [u32; N],
    pub id: [u32; N],
    pub flags: [u32; N],
}

/// `RTCRayHit`, `RTCRayHit8`, `RTCRayHit16`. Aligned as the widest of them.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct RayHits<const N: usize> {
    pub rays: Rays<N>,
    pub normal: [[f32; N]; 3],
    pub u: [f32; N],
    pub v: [f32; N],
    pub primitive: [u32; N],
    pub geometry: [u32; N],
    pub instance: [u32; N],
    pub instance_primitive: [u32; N],
}

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which have the same layout.
#[repr(C)]
pub struct Arguments {
    pub flags: c_uint,
    pub feature_mask: c_uint,
    pub context: *const c_void,
    pub filter: *const c_void,
    pub callback: *const c_void,
}

impl Arguments {
    pub fn new(coherent: bool) -> Self {
        Self {
            flags: if coherent { COHERENT } else { 0 },
            feature_mask: c_uint::MAX,
            context: std::ptr::null(),
            filter: std::ptr::null(),
            callback: std::ptr::null(),
        }
    }
}

/// `RTCBoundsFunctionArguments`.
#[repr(C)]
pub struct BoundsArguments {
    pub user_data: *mut c_void,
    pub primitive: c_uint,
    pub time_step: c_uint,
    /// `RTCBounds`: lower corner, a gap, upper corner, a gap.
    pub bounds: *mut [f32; 8],
}

/// `RTCIntersectFunctionNArguments` and `RTCOccludedFunctionNArguments`, which differ in the packet alone: rays and
/// hits, or rays.
#[repr(C)]
pub struct UserArguments {
    pub valid: *const c_int,
    pub user_data: *mut c_void,
    pub primitive: c_uint,
    pub context: *const c_void,
    pub packet: *mut c_void,
    pub width: c_uint,
    pub geometry: c_uint,
}

/// `RTCBoundsFunction`.
pub type BoundsFunction = unsafe extern "C" fn(*const BoundsArguments);
/// `RTCIntersectFunctionN`, `RTCOccludedFunctionN`.
pub type UserFunction = unsafe extern "C" fn(*const UserArguments);

/// `rtcIntersect8`, `rtcOccluded8` and the like: an occluded call reads and writes the rays alone.
pub type TracePacket<const N: usize> =
    unsafe extern "C" fn(*const c_int, Handle, *mut RayHits<N>, *const Arguments);
/// `rtcIntersect1`, `rtcOccluded1`.
pub type TraceOne = unsafe extern "C" fn(Handle, *mut RayHits<1>, *const Arguments);

macro_rules! api {
    ($($field:ident: $symbol:literal: $signature:ty,)*) => {
        /// Functions of the library, by their C names without the prefix.
        pub struct Api {
            $(pub $field: $signature,)*
        }

        impl Api {
            /// # Safety
            /// `library` is an Embree 4, whose functions have these signatures.
            unsafe fn from_library(library: &'static Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: passed on to the caller.
                    $($field: unsafe { *library.get::<$signature>($symbol)? },)*
                })
            }
        }
    };
}

api! {
    new_device: b"rtcNewDevice\0": unsafe extern "C" fn(*const c_char) -> Handle,
    release_device: b"rtcReleaseDevice\0": unsafe extern "C" fn(Handle),
    device_error: b"rtcGetDeviceError\0": unsafe extern "C" fn(Handle) -> c_uint,
    new_scene: b"rtcNewScene\0": unsafe extern "C" fn(Handle) -> Handle,
    release_scene: b"rtcReleaseScene\0": unsafe extern "C" fn(Handle),
    set_scene_flags: b"rtcSetSceneFlags\0": unsafe extern "C" fn(Handle, c_uint),
    set_scene_build_quality: b"rtcSetSceneBuildQuality\0": unsafe extern "C" fn(Handle, c_uint),
    commit_scene: b"rtcCommitScene\0": unsafe extern "C" fn(Handle),
    new_geometry: b"rtcNewGeometry\0": unsafe extern "C" fn(Handle, c_uint) -> Handle,
    release_geometry: b"rtcReleaseGeometry\0": unsafe extern "C" fn(Handle),
    set_geometry_build_quality: b"rtcSetGeometryBuildQuality\0": unsafe extern "C" fn(Handle, c_uint),
    set_shared_geometry_buffer: b"rtcSetSharedGeometryBuffer\0":
        unsafe extern "C" fn(Handle, c_uint, c_uint, c_uint, *const c_void, usize, usize, usize),
    set_geometry_user_primitive_count: b"rtcSetGeometryUserPrimitiveCount\0":
        unsafe extern "C" fn(Handle, c_uint),
    set_geometry_user_data: b"rtcSetGeometryUserData\0": unsafe extern "C" fn(Handle, *mut c_void),
    set_geometry_bounds_function: b"rtcSetGeometryBoundsFunction\0":
        unsafe extern "C" fn(Handle, BoundsFunction, *mut c_void),
    set_geometry_intersect_function: b"rtcSetGeometryIntersectFunction\0":
        unsafe extern "C" fn(Handle, UserFunction),
    set_geometry_occluded_function: b"rtcSetGeometryOccludedFunction\0":
        unsafe extern "C" fn(Handle, UserFunction),
    set_geometry_instanced_scene: b"rtcSetGeometryInstancedScene\0": unsafe extern "C" fn(Handle, Handle),
    set_geometry_transform: b"rtcSetGeometryTransform\0":
        unsafe extern "C" fn(Handle, c_uint, c_uint, *const c_void),
    commit_geometry: b"rtcCommitGeometry\0": unsafe extern "C" fn(Handle),
    attach_geometry: b"rtcAttachGeometry\0": unsafe extern "C" fn(Handle, Handle) -> c_uint,
    intersect1: b"rtcIntersect1\0": TraceOne,
    intersect8: b"rtcIntersect8\0": TracePacket<8>,
    intersect16: b"rtcIntersect16\0": TracePacket<16>,
    occluded1: b"rtcOccluded1\0": TraceOne,
    occluded8: b"rtcOccluded8\0": TracePacket<8>,
    occluded16: b"rtcOccluded16\0": TracePacket<16>,
}

impl Api {
    /// Loads the library, for the rest of the process.
    ///
    /// # Errors
    /// Says what is missing.
    pub fn load() -> Result<Self, String> {
        let path = find(Path::new(FOLDER)).ok_or_else(|| {
            format!("there is no Embree in {FOLDER}; benches/embree/fetch.sh puts it there (Linux, x86-64)")
        })?;
        let explain = |error: libloading::Error| format!("cannot load {}: {error}", path.display());
        // SAFETY: the library's initialisers only query the CPU. It finds the thread pool that it needs in its own
        // folder.
        let library = unsafe { Library::new(&path) }.map_err(explain)?;
        // SAFETY: the name says that it is an Embree 4.
        unsafe { Self::from_library(Box::leak(Box::new(library))) }.map_err(explain)
    }
}

fn find(folder: &Path) -> Option<PathBuf> {
    let files = std::fs::read_dir(folder).ok()?;
    let is_embree = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("libembree4") && name.ends_with(".so.4")
    };
    files
        .filter_map(Result::ok)
        .map(|file| file.path())
        .find(is_embree)
}
