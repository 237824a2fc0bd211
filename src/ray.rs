//! Rays and hits, single and eight-wide; which of two hits counts.

use crate::simd::{F32x8, LANES, Vec3x8, splat};
use glam::Vec3;

/// Which primitive: triangles count from 0, spheres go on where the triangles end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId(pub u32);

impl PrimitiveId {
    /// No primitive: the ray hit nothing.
    pub const NONE: Self = Self(u32::MAX);
}

/// The t of a ray that ends nowhere. Finite, so that products with 0 are not NaN.
pub const T_MAX: f32 = f32::MAX;

/// A half-line or, with a finite `t_max`, a segment: t in (0, t_max), both ends excluded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t is 0, scene units.
    pub origin: Vec3,
    /// Unit length, so that t is a distance in scene units.
    pub direction: Vec3,
    /// Hits count only below this t.
    pub t_max: f32,
}

impl Ray {
    /// A ray without end.
    #[must_use]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self {
            origin,
            direction,
            t_max: T_MAX,
        }
    }
}

/// What a ray hit first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, scene units; [`T_MAX`] (or the ray's `t_max`) for a miss.
    pub t: f32,
    /// Barycentric weight of a triangle's second corner; 0 on spheres.
    pub u: f32,
    /// Barycentric weight of a triangle's third corner; 0 on spheres.
    pub v: f32,
    /// What was hit; [`PrimitiveId::NONE`] for a miss.
    pub primitive: PrimitiveId,
}

impl Hit {
    /// No hit before `t_max`.
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

    /// Whether a candidate at `t` on `primitive` replaces this hit: nearer, or equally near with the lower
    /// id. A miss holds the ray's `t_max`, which itself is excluded.
    #[inline(always)]
    #[must_use]
    pub fn loses_to(&self, t: f32, primitive: PrimitiveId) -> bool {
        t < self.t || (t == self.t && self.primitive != PrimitiveId::NONE && primitive < self.primitive)
    }

    /// Whether anything was hit.
    #[must_use]
    pub fn is_hit(&self) -> bool {
        self.primitive != PrimitiveId::NONE
    }
}

/// Eight rays, but for where they start: that is often the same for many packets, and [`Origins`] say it. Two cache lines.
/// A lane without a ray has `t_max` 0 (and any unit direction): it hits nothing.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct RayPacket {
    /// Unit length.
    pub direction: Vec3x8,
    /// Hits count only below this t.
    pub t_max: F32x8,
}

impl RayPacket {
    /// Lane `i` as a ray from `origin`.
    #[inline(always)]
    #[must_use]
    pub fn ray(&self, i: usize, origin: Vec3) -> Ray {
        Ray {
            origin,
            direction: self.direction.lane(i),
            t_max: self.t_max.as_array()[i],
        }
    }
}

/// Where the rays of packets start: where t is 0.
#[derive(Clone, Copy, Debug)]
pub enum Origins<'a> {
    /// All at one point, scene units. What depends on it alone is shared then.
    Shared(Vec3),
    /// Each ray at a point of its own, scene units: one vector a packet.
    Separate(&'a [Vec3x8]),
}

/// Packets of rays and where they start.
#[derive(Clone, Debug, Default)]
pub struct RayPackets {
    packets: Vec<RayPacket>,
    /// Where all of them start, or `None`: as `origins` say.
    shared: Option<Vec3>,
    /// As long as `packets`, or empty.
    origins: Vec<Vec3x8>,
}

impl RayPackets {
    /// No rays yet; all will start at `origin`.
    #[must_use]
    pub fn sharing(origin: Vec3) -> Self {
        Self {
            shared: Some(origin),
            ..Self::default()
        }
    }

    /// Forgets all rays; those to come start at `origin`, or each at its own point.
    pub fn restart(&mut self, origin: Option<Vec3>) {
        self.packets.clear();
        self.origins.clear();
        self.shared = origin;
    }

    /// Makes room for so many packets.
    pub fn reserve(&mut self, packets: usize) {
        self.packets.reserve(packets);
        self.origins.reserve(packets);
    }

    /// Adds a packet.
    ///
    /// # Panics
    /// If rays start at points of their own: then these are to be told ([`RayPackets::push_from`]).
    #[inline(always)]
    pub fn push(&mut self, packet: RayPacket) {
        assert!(self.shared.is_some(), "these rays share their origin");
        self.packets.push(packet);
    }

    /// Adds a packet of rays that start at points of their own.
    ///
    /// # Panics
    /// If all rays share one origin.
    #[inline(always)]
    pub fn push_from(&mut self, origin: Vec3x8, packet: RayPacket) {
        assert!(self.shared.is_none(), "these rays have their own origins");
        self.packets.push(packet);
        self.origins.push(origin);
    }

    /// Adds eight rays. (If all share one origin, theirs must be that.)
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

    /// The packets.
    #[inline(always)]
    #[must_use]
    pub fn packets(&self) -> &[RayPacket] {
        &self.packets
    }

    /// Where the rays start.
    #[inline(always)]
    #[must_use]
    pub fn origins(&self) -> Origins<'_> {
        match self.shared {
            Some(origin) => Origins::Shared(origin),
            None => Origins::Separate(&self.origins),
        }
    }

    /// Where the rays of packet `i` start.
    #[inline(always)]
    #[must_use]
    pub fn origin(&self, i: usize) -> Vec3x8 {
        match self.shared {
            Some(origin) => Vec3x8::splat(origin),
            None => self.origins[i],
        }
    }

    /// A ray of packet `i`.
    #[must_use]
    pub fn ray(&self, i: usize, lane: usize) -> Ray {
        let origin = match self.shared {
            Some(origin) => origin,
            None => self.origins[i].lane(lane),
        };
        self.packets[i].ray(lane, origin)
    }
}

/// What eight rays hit first, a column a field of [`Hit`]. Two cache lines.
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
pub struct HitPacket {
    /// Distances.
    pub t: F32x8,
    /// Barycentric weights of the second corner.
    pub u: F32x8,
    /// Barycentric weights of the third corner.
    pub v: F32x8,
    /// Primitives, as the raw value of [`PrimitiveId`].
    pub primitive: [u32; LANES],
}

impl HitPacket {
    /// Eight misses below `t_max`.
    #[must_use]
    pub fn miss(t_max: F32x8) -> Self {
        Self {
            t: t_max,
            u: splat(0.0),
            v: splat(0.0),
            primitive: [u32::MAX; LANES],
        }
    }

    /// Lane `i` as a hit.
    #[must_use]
    pub fn hit(&self, i: usize) -> Hit {
        Hit {
            t: self.t.as_array()[i],
            u: self.u.as_array()[i],
            v: self.v.as_array()[i],
            primitive: PrimitiveId(self.primitive[i]),
        }
    }

    /// Puts `hit` into lane `i`.
    #[inline(always)]
    pub fn set_hit(&mut self, i: usize, hit: &Hit) {
        self.t.as_mut_array()[i] = hit.t;
        self.u.as_mut_array()[i] = hit.u;
        self.v.as_mut_array()[i] = hit.v;
        self.primitive[i] = hit.primitive.0;
    }
}
