//! Rays and hits, single and in packets of eight. Coordinates are relative to the origin of the scene.

use crate::lanes::{F32x8, LANES, Vec3x8};
use glam::Vec3;

/// The id of a primitive: triangles from 0, then spheres, then the planes of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct PrimitiveId(pub u32);

impl PrimitiveId {
    /// No primitive; the id of a miss.
    pub const NONE: Self = Self(u32::MAX);
}

/// The number of an instance in its scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct InstanceId(pub u32);

impl InstanceId {
    /// No instance: the id of primitives outside of instances, and of misses.
    pub const NONE: Self = Self(u32::MAX);
}

/// The `t_max` of a ray without end. Finite, so that products with 0 are not NaN.
pub const T_MAX: f32 = f32::MAX;

/// A ray for t in (0, t_max), both ends excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point at t = 0, scene units.
    pub origin: Vec3,
    /// A unit vector, so that t is a distance in scene units.
    pub direction: Vec3,
    /// The end of the ray, scene units.
    pub t_max: f32,
}

impl Ray {
    /// Makes a ray without end.
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            t_max: T_MAX,
        }
    }

    /// Returns whether origin, direction and end are finite and the direction is not zero. Invalid rays hit nothing.
    #[inline(always)]
    #[must_use]
    pub fn is_valid(&self) -> bool {
        // 0 times NaN or infinity is NaN: fewer instructions than a look at each exponent.
        let zeros = self.origin * 0.0 + self.direction * 0.0 + self.t_max * 0.0;
        zeros == Vec3::ZERO && self.direction != Vec3::ZERO
    }

    /// Returns this ray if it is [valid](Self::is_valid), else one that ends where it begins.
    #[inline(always)]
    #[must_use]
    pub(crate) fn or_nothing(self) -> Self {
        if self.is_valid() { self } else { Self::NOTHING }
    }

    /// A ray that ends where it begins.
    const NOTHING: Self = Self {
        origin: Vec3::ZERO,
        direction: Vec3::X,
        t_max: 0.0,
    };
}

/// A hit of a ray. The default is a miss at infinity.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Hit {
    /// Distance along the ray, in lengths of its direction. A miss has infinity from [`Geometry`](crate::Geometry), and
    /// from a tracer the ray's `t_max`, or 0 if the ray is invalid.
    pub t: f32,
    /// Barycentric weight of a triangle's second corner; 0 on spheres.
    pub u: f32,
    /// Barycentric weight of a triangle's third corner; 0 on spheres.
    pub v: f32,
    /// The primitive; [`PrimitiveId::NONE`] for a miss.
    pub primitive: PrimitiveId,
}

impl Default for Hit {
    fn default() -> Self {
        Self::miss(f32::INFINITY)
    }
}

impl Hit {
    /// Makes a miss of a ray that ends at `t_max`.
    #[inline(always)]
    #[must_use]
    pub fn miss(t_max: f32) -> Self {
        Self {
            t: t_max,
            u: 0.0,
            v: 0.0,
            primitive: PrimitiveId::NONE,
        }
    }

    /// Returns whether a candidate at `t` on `primitive` replaces this hit: a smaller t, or an equal t and a lower id.
    /// A candidate at a miss's `t_max` is excluded.
    #[inline(always)]
    #[must_use]
    pub fn loses_to(&self, t: f32, primitive: PrimitiveId) -> bool {
        t < self.t || (t == self.t && self.primitive != PrimitiveId::NONE && primitive < self.primitive)
    }

    /// Returns whether this is a hit, not a miss.
    #[inline(always)]
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.primitive != PrimitiveId::NONE
    }
}

/// A hit in a scene with instances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneHit {
    /// The hit, with t in the scene's units.
    pub hit: Hit,
    /// The instance that the primitive was hit in, or [`InstanceId::NONE`].
    pub instance: InstanceId,
}

impl SceneHit {
    /// Makes a miss of a ray that ends at `t_max`.
    #[inline(always)]
    #[must_use]
    pub fn miss(t_max: f32) -> Self {
        Hit::miss(t_max).into()
    }
}

impl From<Hit> for SceneHit {
    /// A hit outside of instances.
    #[inline(always)]
    fn from(hit: Hit) -> Self {
        Self {
            hit,
            instance: InstanceId::NONE,
        }
    }
}

impl std::ops::Deref for SceneHit {
    type Target = Hit;

    #[inline(always)]
    fn deref(&self) -> &Hit {
        &self.hit
    }
}

/// Directions and ends of eight rays, two cache lines. Origins are separate ([`Origins`]), because packets often share one.
/// A lane without a ray has `t_max` 0 and any unit direction.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct RayPacket {
    /// Unit vectors.
    pub direction: Vec3x8,
    /// The ends of the rays, scene units.
    pub t_max: F32x8,
}

impl RayPacket {
    /// Returns lane `i` as a ray from `origin`.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, i: usize, origin: Vec3) -> Ray {
        Ray {
            origin,
            direction: self.direction.lane(i),
            t_max: self.t_max.as_array()[i],
        }
    }

    /// Replaces invalid rays by rays that end where they begin.
    pub(crate) fn make_valid(&mut self, origin: &mut Vec3x8) {
        let rays = std::array::from_fn(|lane| self.ray(lane, origin.lane(lane)).or_nothing());
        *origin = Vec3x8::from_lanes(rays.map(|ray| ray.origin));
        self.direction = Vec3x8::from_lanes(rays.map(|ray| ray.direction));
        self.t_max = rays.map(|ray| ray.t_max).into();
    }
}

/// The origins of packets of rays, scene units.
#[derive(Clone, Copy, Debug)]
pub enum Origins<'a> {
    /// One origin of all rays.
    Shared(Vec3),
    /// One origin per ray, eight for each packet.
    Separate(&'a [Vec3x8]),
}

/// Packets of rays with shared or separate origins.
#[derive(Clone, Debug, Default)]
pub struct RayPackets {
    packets: Vec<RayPacket>,
    /// The shared origin; `None` for separate ones.
    shared: Option<Vec3>,
    /// As long as `packets`, or empty with a shared origin.
    origins: Vec<Vec3x8>,
}

impl RayPackets {
    /// Makes an empty list for rays with a shared origin; the default is for separate origins.
    #[must_use]
    pub fn sharing(origin: Vec3) -> Self {
        Self {
            shared: Some(origin),
            ..Self::default()
        }
    }

    /// Removes all rays. The next ones start at `origin`, or at separate origins if `None`.
    pub fn restart(&mut self, origin: Option<Vec3>) {
        self.packets.clear();
        self.origins.clear();
        self.shared = origin;
    }

    /// Reserves memory for this many packets.
    pub fn reserve(&mut self, packets: usize) {
        self.packets.reserve(packets);
        self.origins.reserve(packets);
    }

    /// Adds a packet that starts at the shared origin.
    ///
    /// # Panics
    /// If there is no shared origin; see [`RayPackets::push_from`].
    #[inline(always)]
    pub fn push(&mut self, packet: RayPacket) {
        assert!(
            self.shared.is_some(),
            "a packet without origins needs a shared origin"
        );
        self.packets.push(packet);
    }

    /// Adds a packet with separate origins.
    ///
    /// # Panics
    /// If there is a shared origin.
    #[inline(always)]
    pub fn push_from(&mut self, origin: Vec3x8, packet: RayPacket) {
        assert!(
            self.shared.is_none(),
            "a packet with origins cannot have a shared origin"
        );
        self.packets.push(packet);
        self.origins.push(origin);
    }

    /// Adds eight rays. With a shared origin, their own origins are ignored.
    pub fn push_rays(&mut self, rays: &[Ray; LANES]) {
        let packet = RayPacket {
            direction: Vec3x8::from_lanes(rays.map(|ray| ray.direction)),
            t_max: rays.map(|ray| ray.t_max).into(),
        };
        match self.shared {
            Some(_) => self.push(packet),
            None => self.push_from(Vec3x8::from_lanes(rays.map(|ray| ray.origin)), packet),
        }
    }

    /// Returns the packets.
    #[inline(always)]
    #[must_use]
    pub fn packets(&self) -> &[RayPacket] {
        &self.packets
    }

    /// Returns the packets, to change them.
    #[inline(always)]
    pub(crate) fn packets_mut(&mut self) -> &mut [RayPacket] {
        &mut self.packets
    }

    /// Returns the origins of all packets.
    #[inline(always)]
    #[must_use]
    pub fn origins(&self) -> Origins<'_> {
        match self.shared {
            Some(origin) => Origins::Shared(origin),
            None => Origins::Separate(&self.origins),
        }
    }

    /// Returns the origins of packet `i`.
    #[inline(always)]
    #[must_use]
    pub fn origin(&self, i: usize) -> Vec3x8 {
        match self.shared {
            Some(origin) => Vec3x8::splat(origin),
            None => self.origins[i],
        }
    }

    /// Returns a ray of packet `i`.
    #[must_use]
    pub fn ray(&self, i: usize, lane: usize) -> Ray {
        let origin = match self.shared {
            Some(origin) => origin,
            None => self.origins[i].lane(lane),
        };
        self.packets[i].ray(lane, origin)
    }
}

/// The closest hits of eight rays, the fields of [`Hit`] as arrays. Two cache lines.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct HitPacket {
    /// Distances, scene units.
    pub t: F32x8,
    /// Barycentric weights of the second corner.
    pub u: F32x8,
    /// Barycentric weights of the third corner.
    pub v: F32x8,
    /// Primitives, the raw values of [`PrimitiveId`].
    pub primitive: [u32; LANES],
}

impl HitPacket {
    /// Makes eight misses of rays that end at `t_max`.
    #[must_use]
    pub fn miss(t_max: F32x8) -> Self {
        Self {
            t: t_max,
            u: F32x8::ZERO,
            v: F32x8::ZERO,
            primitive: [u32::MAX; LANES],
        }
    }

    /// Returns lane `i` as a hit.
    #[must_use]
    pub fn hit(&self, i: usize) -> Hit {
        Hit {
            t: self.t.as_array()[i],
            u: self.u.as_array()[i],
            v: self.v.as_array()[i],
            primitive: PrimitiveId(self.primitive[i]),
        }
    }

    /// Sets lane `i` to `hit`.
    #[inline(always)]
    pub fn set_hit(&mut self, i: usize, hit: &Hit) {
        self.t.as_mut_array()[i] = hit.t;
        self.u.as_mut_array()[i] = hit.u;
        self.v.as_mut_array()[i] = hit.v;
        self.primitive[i] = hit.primitive.0;
    }
}
