//! Sets of pairs of a node's child and a packet, as bits.
// Tuned: see docs/lab-notes.md#branch-free-loops

use super::PACKETS;

/// Sixteen bits a child, four children a word. Two fields instead of an array, so that both stay in registers.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pairs {
    /// Children 0 to 3.
    pub low: u64,
    /// Children 4 to 7.
    pub high: u64,
}

impl Pairs {
    /// Sets the packets of child `c`, which had none.
    #[inline(always)]
    pub fn put(&mut self, c: usize, packets: u32) {
        let bits = u64::from(packets) << (c % 4 * PACKETS);
        let is_high = u64::from(c >= 4).wrapping_neg();
        self.low |= bits & !is_high;
        self.high |= bits & is_high;
    }

    /// From the children of packets 0 to 7 and of 8 to 15, a byte per packet.
    #[inline(always)]
    pub fn of_packets(low: u64, high: u64) -> Self {
        let (first, second) = (transposed(low), transposed(high));
        Self {
            low: spread(first) | spread(second) << 8,
            high: spread(first >> 32) | spread(second >> 32) << 8,
        }
    }

    /// The packets of child `c`, a bit each.
    #[inline(always)]
    pub fn packets(&self, c: usize) -> u32 {
        let word = if c < 4 { self.low } else { self.high };
        (word >> (c % 4 * PACKETS)) as u32 & 0xffff
    }

    /// The children whose sixteen bits are not 0, a bit each.
    #[inline(always)]
    pub fn children(&self) -> u32 {
        // The product brings the top bits next to each other.
        let spread = nonzero(self.low) | nonzero(self.high) << 4;
        (spread.wrapping_mul(1 << 48 | 1 << 33 | 1 << 18 | 1 << 3) >> 48) as u32 & 0xff
    }
}

/// The lowest bit of each group of sixteen tells whether the group is not 0.
#[inline(always)]
fn nonzero(word: u64) -> u64 {
    const LOW: u64 = 0x7fff_7fff_7fff_7fff;
    ((((word & LOW) + LOW) | word) & !LOW) >> 15
}

/// Transposes eight rows of eight bits (Warren, *Hacker's Delight*, 7-3).
#[inline(always)]
fn transposed(mut rows: u64) -> u64 {
    for (by, those) in [
        (7, 0x00aa_00aa_00aa_00aa),
        (14, 0x0000_cccc_0000_cccc),
        (28, 0x0000_0000_f0f0_f0f0),
    ] {
        let differ = (rows ^ (rows >> by)) & those;
        rows ^= differ | differ << by;
    }
    rows
}

/// The four low bytes, each with a zero byte above it.
#[inline(always)]
fn spread(bytes: u64) -> u64 {
    let pairs = ((bytes & 0xffff) | bytes << 16) & 0x0000_ffff_0000_ffff;
    (pairs | pairs << 8) & 0x00ff_00ff_00ff_00ff
}

#[cfg(test)]
mod tests;
