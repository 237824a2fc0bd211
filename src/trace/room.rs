//! The memory of a bundle: sixteen packets of up to sixteen rays, or sixteen of thirty-two.

use super::{PACKETS, bits, bundle::Culling, rays::Packet, sheared::ShearedPacket, slabs::PacketSlabs};
#[cfg(target_arch = "x86_64")]
use crate::simd::{Avx2, Avx512};
use crate::simd::{Column, Lanes, Memory, Pair, Portable, Simd, Vec3Lanes, WideColumn};
use glam::Vec3;

/// Memory of a bundle.
#[derive(Debug)]
pub(super) struct Room<M> {
    pub packets: Box<[Packet<M>; PACKETS]>,
    /// The shared origin, as bits, that is written in all packets, and in how many lanes. The next call often has the
    /// same.
    shared: Option<([u32; 3], usize)>,
    /// Sheared rays, only for bundles with separate origins. Apart from the packets, which it would make larger.
    // Tuned: see docs/lab-notes.md#packet-memory
    pub sheared: Box<[ShearedPacket<M>; PACKETS]>,
    /// Like `sheared`.
    pub slabs: Box<[PacketSlabs<M>; PACKETS]>,
}

impl<M: Memory> Room<M> {
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

    /// Packets get separate origins.
    pub fn start_apart(&mut self) {
        self.shared = None;
    }
}

/// Memory for every width.
#[derive(Debug)]
pub(super) struct Rooms {
    narrow: Room<Column>,
    wide: Room<WideColumn>,
}

impl Rooms {
    pub fn new() -> Self {
        Self {
            narrow: Room::new(),
            wide: Room::new(),
        }
    }

    /// That of packets with these lanes.
    #[inline(always)]
    pub fn of<V: RayLanes>(&self) -> &Room<V::Memory> {
        V::Memory::of(self)
    }

    /// That of packets with these lanes.
    #[inline(always)]
    pub fn of_mut<V: RayLanes>(&mut self) -> &mut Room<V::Memory> {
        V::Memory::of_mut(self)
    }
}

/// Memory of a width that [`Rooms`] has.
pub(super) trait InRooms: Memory {
    fn of(rooms: &Rooms) -> &Room<Self>;
    fn of_mut(rooms: &mut Rooms) -> &mut Room<Self>;
}

impl InRooms for Column {
    #[inline(always)]
    fn of(rooms: &Rooms) -> &Room<Self> {
        &rooms.narrow
    }
    #[inline(always)]
    fn of_mut(rooms: &mut Rooms) -> &mut Room<Self> {
        &mut rooms.narrow
    }
}

impl InRooms for WideColumn {
    #[inline(always)]
    fn of(rooms: &Rooms) -> &Room<Self> {
        &rooms.wide
    }
    #[inline(always)]
    fn of_mut(rooms: &mut Rooms) -> &mut Room<Self> {
        &mut rooms.wide
    }
}

/// Lanes that are rays.
pub(super) trait RayLanes: Lanes<Memory: InRooms> {}

impl<V: Lanes<Memory: InRooms>> RayLanes for V {}

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
