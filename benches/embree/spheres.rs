//! Spheres as user geometry. Embree's own spheres go through its code for curves, ray by ray even in packets; for a few
//! spheres among triangles a callback that tests a packet's lanes together is several times faster. So both are tried.

use crate::ffi::{Api, BoundsArguments, Handle, Rays, UserArguments};
use std::ffi::c_void;

/// Makes `geometry` out of `spheres` (centre and radius).
///
/// # Safety
/// `geometry` is a user geometry, and `spheres` outlives it.
pub unsafe fn set(api: &Api, geometry: Handle, spheres: &[[f32; 4]]) {
    let data: *const c_void = spheres.as_ptr().cast();
    // SAFETY: the callbacks take the arguments of Embree's interface, and the spheres as user data.
    unsafe {
        (api.set_geometry_user_primitive_count)(geometry, spheres.len() as u32);
        (api.set_geometry_user_data)(geometry, data.cast_mut());
        (api.set_geometry_bounds_function)(geometry, bounds, std::ptr::null_mut());
        (api.set_geometry_intersect_function)(geometry, intersect);
        (api.set_geometry_occluded_function)(geometry, occluded);
    }
}

/// # Safety
/// `arguments` describe a sphere of [`set`].
unsafe extern "C" fn bounds(arguments: *const BoundsArguments) {
    // SAFETY: Embree gives valid pointers; the user data is the slice of `set`, which has that primitive.
    unsafe {
        let arguments = &*arguments;
        let [x, y, z, radius] = *sphere(arguments.user_data, arguments.primitive);
        *arguments.bounds = [
            x - radius,
            y - radius,
            z - radius,
            0.0,
            x + radius,
            y + radius,
            z + radius,
            0.0,
        ];
    }
}

/// # Safety
/// As [`bounds`].
unsafe fn sphere<'a>(user_data: *const c_void, primitive: u32) -> &'a [f32; 4] {
    // SAFETY: as the caller promises.
    unsafe { &*user_data.cast::<[f32; 4]>().add(primitive as usize) }
}

/// # Safety
/// As [`bounds`], with a packet of `width` rays and hits.
unsafe extern "C" fn intersect(arguments: *const UserArguments) {
    // SAFETY: as above; the packet's layout is that of its width.
    unsafe {
        match (*arguments).width {
            1 => intersect_packet::<1>(&*arguments),
            8 => intersect_packet::<8>(&*arguments),
            16 => intersect_packet::<16>(&*arguments),
            _ => (),
        }
    }
}

/// # Safety
/// As [`intersect`].
unsafe extern "C" fn occluded(arguments: *const UserArguments) {
    // SAFETY: as above; only the rays are there.
    unsafe {
        match (*arguments).width {
            1 => occlude_packet::<1>(&*arguments),
            8 => occlude_packet::<8>(&*arguments),
            16 => occlude_packet::<16>(&*arguments),
            _ => (),
        }
    }
}

/// The part of [`crate::ffi::RayHits`] that a callback needs, with no more alignment than Embree's own packets have.
#[repr(C)]
struct Packet<const N: usize> {
    rays: Rays<N>,
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    primitive: [u32; N],
    geometry: [u32; N],
}

/// # Safety
/// `arguments` are for N rays and hits.
unsafe fn intersect_packet<const N: usize>(arguments: &UserArguments) {
    // SAFETY: rays and hits of the packet are ours until we return.
    let (packet, valid, sphere) = unsafe {
        (
            &mut *arguments.packet.cast::<Packet<N>>(),
            &*arguments.valid.cast::<[i32; N]>(),
            sphere(arguments.user_data, arguments.primitive),
        )
    };
    let (hit, t) = hits(&packet.rays, valid, sphere);
    take(&mut packet.rays.t_far, &hit, &t);
    take(&mut packet.u, &hit, &[0.0; N]);
    take(&mut packet.v, &hit, &[0.0; N]);
    take(&mut packet.primitive, &hit, &[arguments.primitive; N]);
    take(&mut packet.geometry, &hit, &[arguments.geometry; N]);
}

/// # Safety
/// `arguments` are for N rays.
unsafe fn occlude_packet<const N: usize>(arguments: &UserArguments) {
    // SAFETY: the rays of the packet are ours until we return.
    let (rays, valid, sphere) = unsafe {
        (
            &mut *arguments.packet.cast::<Rays<N>>(),
            &*arguments.valid.cast::<[i32; N]>(),
            sphere(arguments.user_data, arguments.primitive),
        )
    };
    let (hit, _) = hits(rays, valid, sphere);
    take(&mut rays.t_far, &hit, &[f32::NEG_INFINITY; N]);
}

#[inline(always)]
fn take<T: Copy, const N: usize>(old: &mut [T; N], hit: &[bool; N], new: &[T; N]) {
    *old = std::array::from_fn(|i| if hit[i] { new[i] } else { old[i] });
}

/// Which lanes hit the sphere within their ends, and where; the far side counts if the near one is behind. Without
/// branches, so that the compiler vectorises it.
#[expect(
    clippy::needless_bitwise_bool,
    reason = "lazy operators are branches, which keep the lanes apart"
)]
#[inline(always)]
fn hits<const N: usize>(
    rays: &Rays<N>,
    valid: &[i32; N],
    [x, y, z, radius]: &[f32; 4],
) -> ([bool; N], [f32; N]) {
    let ([ox, oy, oz], [dx, dy, dz]) = (&rays.origin, &rays.direction);
    let (mut hit, mut distance) = ([false; N], [0.0; N]);
    for i in 0..N {
        let (cx, cy, cz) = (ox[i] - x, oy[i] - y, oz[i] - z);
        let nearest = -(cx * dx[i] + cy * dy[i] + cz * dz[i]);
        let (ax, ay, az) = (cx + nearest * dx[i], cy + nearest * dy[i], cz + nearest * dz[i]);
        let discriminant = radius * radius - (ax * ax + ay * ay + az * az);
        let half_chord = discriminant.max(0.0).sqrt();
        let (near, far) = (nearest - half_chord, nearest + half_chord);
        let t = if near > rays.t_near[i] { near } else { far };
        distance[i] = t;
        let within = (t > rays.t_near[i]) & (t < rays.t_far[i]);
        hit[i] = (valid[i] != 0) & (discriminant >= 0.0) & within;
    }
    (hit, distance)
}
