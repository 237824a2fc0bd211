//! Scratch memory of a bundle: sixteen packets of up to sixteen rays, or sixteen of thirty-two.

use super::{PACKETS, bits, bundle::Culling, rays::Packet, sheared::ShearedPacket, slabs::PacketSlabs};
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Column, Lanes, Memory, Pair, Portable, Simd, Vec3Lanes, WideColumn};
use glam::Vec3;

/// Scratch memory of a bundle.
#[derive(Debug)]
pub(super) struct BundleScratch<M> {
    pub packets: Box<[Packet<M>; PACKETS]>,
    /// The shared origin in all packets, as bits, and in how many lanes: the next call often has the same.
    shared: Option<([u32; 3], usize)>,
    /// Sheared rays, only for bundles with separate origins; separate, to keep packets small.
    // Tuned: see docs/lab-notes.md#packet-memory
    pub sheared: Box<[ShearedPacket<M>; PACKETS]>,
    /// Like `sheared`.
    pub slabs: Box<[PacketSlabs<M>; PACKETS]>,
}

impl<M: Memory> BundleScratch<M> {
    fn new() -> Self {
        Self {
            packets: Box::new([Packet::EMPTY; PACKETS]),
            shared: None,
            sheared: Box::new([ShearedPacket::EMPTY; PACKETS]),
            slabs: Box::new([PacketSlabs::EMPTY; PACKETS]),
        }
    }

    /// Gives all packets this origin.
    #[inline(always)]
    pub fn start_at<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, origin: Vec3) {
        // By bits: 0 and -0 are equal but make edge functions of different signs.
        let bits = [origin.x.to_bits(), origin.y.to_bits(), origin.z.to_bits()];
        let now = Some((bits, V::COUNT));
        if self.shared != now {
            for packet in self.packets.iter_mut() {
                Vec3Lanes::<V>::splat(simd, origin).store(&mut packet.origin);
            }
            self.shared = now;
        }
    }

    /// Sets what only rays with separate origins need.
    #[inline(always)]
    pub fn see_apart<V: Lanes<Memory = M>>(&mut self, simd: V::Simd, packets: u32, culling: &Culling<'_, V>) {
        for p in bits(packets) {
            let packet = &self.packets[p % PACKETS];
            self.slabs[p % PACKETS].set::<V>(simd, packet, culling.octant.is_some());
            self.sheared[p % PACKETS].set::<V>(simd, packet, &culling.space);
        }
    }

    /// Forgets the shared origin: packets now have separate ones.
    pub fn start_apart(&mut self) {
        self.shared = None;
    }
}

/// Scratch memory for every packet width.
#[derive(Debug)]
pub(super) struct Scratch {
    narrow: BundleScratch<Column>,
    wide: BundleScratch<WideColumn>,
}

impl Scratch {
    pub fn new() -> Self {
        Self {
            narrow: BundleScratch::new(),
            wide: BundleScratch::new(),
        }
    }

    /// The scratch memory of packets with these lanes.
    #[inline(always)]
    pub fn of<V: RayLanes>(&self) -> &BundleScratch<V::Memory> {
        V::Memory::of(self)
    }

    /// As [`of`](Self::of).
    #[inline(always)]
    pub fn of_mut<V: RayLanes>(&mut self) -> &mut BundleScratch<V::Memory> {
        V::Memory::of_mut(self)
    }
}

/// The memory of a packet of a width that [`Scratch`] has.
pub(super) trait ScratchMemory: Memory {
    fn of(scratch: &Scratch) -> &BundleScratch<Self>;
    fn of_mut(scratch: &mut Scratch) -> &mut BundleScratch<Self>;
}

impl ScratchMemory for Column {
    #[inline(always)]
    fn of(scratch: &Scratch) -> &BundleScratch<Self> {
        &scratch.narrow
    }
    #[inline(always)]
    fn of_mut(scratch: &mut Scratch) -> &mut BundleScratch<Self> {
        &mut scratch.narrow
    }
}

impl ScratchMemory for WideColumn {
    #[inline(always)]
    fn of(scratch: &Scratch) -> &BundleScratch<Self> {
        &scratch.wide
    }
    #[inline(always)]
    fn of_mut(scratch: &mut Scratch) -> &mut BundleScratch<Self> {
        &mut scratch.wide
    }
}

/// Lanes of rays.
pub(super) trait RayLanes: Lanes<Memory: ScratchMemory> {}

impl<V: Lanes<Memory: ScratchMemory>> RayLanes for V {}

/// How many rays a packet holds at a level.
// Tuned: see docs/lab-notes.md#pairs-of-vectors and #packets-of-32
pub(super) trait Widths: Simd {
    /// Closest hits of rays that share their origin.
    type Shared: RayLanes<Simd = Self>;
    /// Occlusion of rays that share their origin.
    type SharedAny: RayLanes<Simd = Self>;
    /// Rays with separate origins.
    type Separate: RayLanes<Simd = Self>;
}

impl Widths for Portable {
    type Shared = Self::V8;
    type SharedAny = Self::V8;
    type Separate = Self::V8;
}

#[cfg(target_arch = "x86_64")]
impl Widths for Avx2 {
    type Shared = Self::V16;
    type SharedAny = Self::V16;
    type Separate = Self::V8;
}

#[cfg(target_arch = "x86_64")]
impl Widths for Avx512 {
    type Shared = Self::V16;
    type SharedAny = Pair<Self::V16>;
    type Separate = Self::V16;
}
