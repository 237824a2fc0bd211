//! octray's rays in Embree's layout, prepared before the clock starts, and the timed loops: copy a packet, reset what the
//! last call left, call, store the hits.

use crate::{
    device::{EmbreeScene, empty},
    ffi::{self, Arguments, RayHits},
    truth::{Dispute, Distances, TOLERANCE},
};
use octray::{
    bench::{Kind, RaySet, Results},
    ray::Ray,
};
use std::ops::{Deref, DerefMut};

/// How the hits of the two programs differ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Differences {
    pub rays: u64,
    /// One hits (or is blocked), the other does not.
    pub hit_miss: u64,
    /// Both hit, but the distances differ by more than [`TOLERANCE`] of them.
    pub distance: u64,
}

impl Differences {
    /// At most 50 in a million of either.
    pub fn agree(&self) -> bool {
        self.hit_miss.max(self.distance) * 1_000_000 <= 50 * self.rays
    }

    pub fn per_million(&self, count: u64) -> f64 {
        count as f64 * 1e6 / self.rays.max(1) as f64
    }
}

/// The rays on which the two disagree.
#[derive(Clone, Debug, Default)]
pub struct Disputes {
    pub hit_miss: Vec<Dispute>,
    pub distance: Vec<Distances>,
}

/// N rays, an array per field. Its 32 N bytes align `valid` as Embree requires.
#[repr(C)]
#[derive(Clone, Copy)]
struct Packet<const N: usize> {
    origin: [[f32; N]; 3],
    direction: [[f32; N]; 3],
    t_far: [f32; N],
    /// -1 for lanes with a ray.
    valid: [i32; N],
}

/// The hit records that the timed loop leaves in memory.
#[repr(C)]
#[derive(Clone, Copy)]
struct Hits<const N: usize> {
    t: [f32; N],
    u: [f32; N],
    v: [f32; N],
    primitive: [u32; N],
    geometry: [u32; N],
}

/// Rays of one set, in packets of N. Packets without any ray are left out.
struct Width<const N: usize> {
    packets: Lines<Packet<N>>,
    /// Which lane of the set each lane is; `u32::MAX` for none.
    sources: Vec<[u32; N]>,
    hits: Lines<Hits<N>>,
    /// Rays that any hit stops: minus infinity where blocked.
    t_far: Lines<[f32; N]>,
}

/// One set of rays in every width.
pub struct Prepared {
    kind: Kind,
    one: Width<1>,
    eight: Width<8>,
    sixteen: Width<16>,
}

impl Prepared {
    /// `from_light`: shadow rays run from their light to the surface instead.
    pub fn new(set: &RaySet, from_light: bool) -> Self {
        let mut lanes = Vec::new();
        let mut first = 0;
        for (light, rays) in &set.groups {
            for packet_i in 0..rays.packets().len() {
                lanes.extend((0..8).map(|lane| {
                    let source = ((first + packet_i) * 8 + lane) as u32;
                    Lane::new(&rays.ray(packet_i, lane), source, light.filter(|_| from_light))
                }));
            }
            first += rays.packets().len();
        }
        // Pairs of packets are 4x4 pixels.
        let prepared = Self {
            kind: set.kind,
            one: Width::new(&lanes),
            eight: Width::new(&lanes),
            sixteen: Width::new(&lanes),
        };
        for rays in [
            prepared.one.rays(),
            prepared.eight.rays(),
            prepared.sixteen.rays(),
        ] {
            assert_eq!(rays, set.count, "Embree traces every ray of the set");
        }
        prepared
    }

    /// Traces the set, `width` rays per call. Only this is timed.
    pub fn trace(&mut self, scene: &EmbreeScene<'_>, width: usize, coherent: bool) {
        let arguments = &Arguments::new(coherent);
        if self.kind.is_any_hit() {
            match width {
                1 => self.one.occluded(|_, rays| scene.occluded1(rays, arguments)),
                8 => self
                    .eight
                    .occluded(|valid, rays| scene.occluded8(valid, rays, arguments)),
                _ => self
                    .sixteen
                    .occluded(|valid, rays| scene.occluded16(valid, rays, arguments)),
            }
        } else {
            match width {
                1 => self.one.closest(|_, rays| scene.intersect1(rays, arguments)),
                8 => self
                    .eight
                    .closest(|valid, rays| scene.intersect8(valid, rays, arguments)),
                _ => self
                    .sixteen
                    .closest(|valid, rays| scene.intersect16(valid, rays, arguments)),
            }
        }
    }

    /// Compares what [`Self::trace`] left in that width with octray's results; returns the rays of `set`, from which this
    /// was made, on which they disagree.
    pub fn differences(&self, width: usize, set: &RaySet, ours: &Results) -> (Differences, Disputes) {
        match width {
            1 => self.one.differences(set, ours),
            8 => self.eight.differences(set, ours),
            _ => self.sixteen.differences(set, ours),
        }
    }
}

/// A ray of the set, or a lane without one.
#[derive(Clone, Copy)]
struct Lane {
    origin: [f32; 3],
    direction: [f32; 3],
    t_far: f32,
    source: u32,
}

impl Lane {
    const NONE: Self = Self {
        origin: [0.0; 3],
        direction: [0.0, 0.0, 1.0],
        t_far: 0.0,
        source: u32::MAX,
    };

    fn new(ray: &Ray, source: u32, light: Option<glam::Vec3>) -> Self {
        let (origin, direction) = match light {
            Some(light) => (light, -ray.direction),
            None => (ray.origin, ray.direction),
        };
        Self {
            origin: origin.to_array(),
            direction: direction.to_array(),
            t_far: ray.t_max,
            source: if ray.t_max > 0.0 { source } else { u32::MAX },
        }
    }
}

impl<const N: usize> Width<N> {
    fn new(lanes: &[Lane]) -> Self {
        let is_ray = |lane: &Lane| lane.source != u32::MAX;
        let chosen = lanes.chunks(N).filter(|chunk| chunk.iter().any(is_ray));
        let chosen: Vec<[Lane; N]> = chosen
            .map(|chunk| std::array::from_fn(|i| *chunk.get(i).unwrap_or(&Lane::NONE)))
            .collect();
        let packet = |lanes: &[Lane; N]| Packet {
            origin: [0, 1, 2].map(|axis| lanes.map(|lane| lane.origin[axis])),
            direction: [0, 1, 2].map(|axis| lanes.map(|lane| lane.direction[axis])),
            t_far: lanes.map(|lane| lane.t_far),
            valid: lanes.map(|lane| if is_ray(&lane) { -1 } else { 0 }),
        };
        let miss = Hits {
            t: [0.0; N],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [ffi::NONE; N],
            geometry: [ffi::NONE; N],
        };
        Self {
            packets: Lines::new(chosen.iter().map(packet)),
            sources: chosen.iter().map(|lanes| lanes.map(|lane| lane.source)).collect(),
            hits: Lines::new(chosen.iter().map(|_| miss)),
            t_far: Lines::new(chosen.iter().map(|_| [0.0; N])),
        }
    }

    /// The number of rays.
    fn rays(&self) -> u64 {
        let sources = self.sources.iter().flatten();
        sources.filter(|&&source| source != u32::MAX).count() as u64
    }

    #[inline(always)]
    fn closest(&mut self, call: impl Fn(&[i32; N], &mut RayHits<N>)) {
        let mut work = empty::<N>();
        for (packet, hits) in self.packets.iter().zip(self.hits.iter_mut()) {
            work.rays.origin = packet.origin;
            work.rays.direction = packet.direction;
            work.rays.t_far = packet.t_far;
            work.geometry = [ffi::NONE; N];
            call(&packet.valid, &mut work);
            *hits = Hits {
                t: work.rays.t_far,
                u: work.u,
                v: work.v,
                primitive: work.primitive,
                geometry: work.geometry,
            };
        }
    }

    #[inline(always)]
    fn occluded(&mut self, call: impl Fn(&[i32; N], &mut RayHits<N>)) {
        let mut work = empty::<N>();
        for (packet, t_far) in self.packets.iter().zip(self.t_far.iter_mut()) {
            work.rays.origin = packet.origin;
            work.rays.direction = packet.direction;
            work.rays.t_far = packet.t_far;
            call(&packet.valid, &mut work);
            *t_far = work.rays.t_far;
        }
    }

    /// The ray in a lane, as Embree gets it.
    fn ray(&self, packet_i: usize, lane: usize) -> Ray {
        let packet = &self.packets[packet_i];
        Ray {
            origin: packet.origin.map(|axis| axis[lane]).into(),
            direction: packet.direction.map(|axis| axis[lane]).into(),
            t_max: packet.t_far[lane],
        }
    }

    fn differences(&self, set: &RaySet, ours: &Results) -> (Differences, Disputes) {
        let mut differences = Differences::default();
        let mut disputes = Disputes::default();
        let mut dispute = |source: u32, packet_i: usize, lane: usize, we_hit: bool| {
            disputes.hit_miss.push(Dispute {
                ours: our_ray(set, source as usize / 8, source as usize % 8),
                embree: self.ray(packet_i, lane),
                we_hit,
            });
        };
        for (packet_i, sources) in self.sources.iter().enumerate() {
            for (lane, &source) in sources.iter().enumerate() {
                if source == u32::MAX {
                    continue;
                }
                differences.rays += 1;
                let (i, our_lane) = (source as usize / 8, source as usize % 8);
                if set.kind.is_any_hit() {
                    let blocked = ours.blocked[i] >> our_lane & 1 == 1;
                    if blocked != (self.t_far[packet_i][lane] < 0.0) {
                        dispute(source, packet_i, lane, blocked);
                    }
                    continue;
                }
                let (ours, hits) = (ours.hits[i].hit(our_lane), &self.hits[packet_i]);
                if ours.is_hit() != (hits.geometry[lane] != ffi::NONE) {
                    dispute(source, packet_i, lane, ours.is_hit());
                } else if ours.is_hit() && (hits.t[lane] - ours.t).abs() > TOLERANCE * ours.t {
                    disputes.distance.push(Distances {
                        ray: self.ray(packet_i, lane),
                        ours: ours.t,
                        embree: hits.t[lane],
                    });
                }
            }
        }
        differences.hit_miss = disputes.hit_miss.len() as u64;
        differences.distance = disputes.distance.len() as u64;
        (differences, disputes)
    }
}

/// Lane `lane` of packet `packet_i` of the set, as octray traces it: shadow rays start at their light.
fn our_ray(set: &RaySet, mut packet_i: usize, lane: usize) -> Ray {
    let mut groups = set.groups.iter();
    loop {
        let (light, rays) = groups.next().expect("the set has this packet");
        if packet_i < rays.packets().len() {
            let ray = rays.ray(packet_i, lane);
            return match *light {
                None => ray,
                Some(origin) => Ray {
                    origin,
                    direction: -ray.direction,
                    ..ray
                },
            };
        }
        packet_i -= rays.packets().len();
    }
}

/// Items without gaps, from the start of a cache line.
struct Lines<T> {
    memory: Vec<Line>,
    items: usize,
    item: std::marker::PhantomData<T>,
}

#[repr(align(64))]
#[derive(Clone, Copy)]
struct Line(#[expect(dead_code, reason = "read through pointers alone")] [u8; 64]);

impl<T: Copy> Lines<T> {
    fn new(items: impl ExactSizeIterator<Item = T>) -> Self {
        const { assert!(align_of::<T>() <= 64) };
        let count = items.len();
        let bytes = count * size_of::<T>();
        let mut memory = vec![Line([0; 64]); bytes.div_ceil(64)];
        let start = memory.as_mut_ptr().cast::<T>();
        for (i, item) in items.take(count).enumerate() {
            // SAFETY: `memory` has room for `count` items and is aligned for them.
            unsafe { start.add(i).write(item) };
        }
        Self {
            memory,
            items: count,
            item: std::marker::PhantomData,
        }
    }
}

impl<T: Copy> Deref for Lines<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        // SAFETY: `new` has written that many items there; the fields are private.
        unsafe { std::slice::from_raw_parts(self.memory.as_ptr().cast(), self.items) }
    }
}

impl<T: Copy> DerefMut for Lines<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        // SAFETY: as in `deref`; the borrow is exclusive.
        unsafe { std::slice::from_raw_parts_mut(self.memory.as_mut_ptr().cast(), self.items) }
    }
}
