//! Colours of the facets of binary files, in their two attribute bytes: five bits for each channel.
//!
//! The 15 lower bits of VisCAM and SolidView are red, green, blue from the highest on; the highest bit says that the facet
//! has a colour. In files of Materialise Magics, whose header has `COLOR=` and a default, they are blue, green, red, and
//! the highest bit says that the facet has the default, whose alpha is ignored. MeshLab writes that header, too, but sets the
//! highest bit of facets with a colour.

use super::{FACET, HEADER, PIECE};
use crate::format::{
    budget::{Budget, BudgetError},
    left_out::LeftOut,
    mesh::Surface,
    source::Pieces,
};

/// Bit 15: a facet's colour counts, or in Magics does not.
const FLAG: u16 = 1 << 15;

/// Which colours a file has.
enum Scheme {
    VisCam,
    Magics {
        /// Red, green, blue, alpha of facets without a colour of their own.
        default: [u8; 4],
        /// Whether the highest bit says that a facet has a colour, as MeshLab has it.
        is_reversed: bool,
    },
    /// Attributes of some other kind.
    Unknown,
    /// No colours.
    Plain,
}

/// Which bits of attributes are set, over all facets.
#[derive(Clone, Copy)]
pub(super) struct Bits {
    /// Those set in any facet.
    any: u16,
    /// Those set in all facets.
    all: u16,
}

impl Bits {
    /// Of no facets.
    pub(super) const NONE: Self = Self {
        any: 0,
        all: u16::MAX,
    };

    /// Of one facet.
    pub(super) fn of(facet: &[u8; FACET]) -> Self {
        let bits = attributes(facet);
        Self { any: bits, all: bits }
    }

    /// Of the facets of both.
    pub(super) fn join(self, other: Self) -> Self {
        Self {
            any: self.any | other.any,
            all: self.all & other.all,
        }
    }
}

/// Colours of facets.
#[derive(Default)]
pub(super) struct Colors {
    pub(super) surfaces: Vec<Surface>,
    /// By facet; empty if none has a colour.
    pub(super) surface_of: Vec<u32>,
}

/// Reads the colours of `count` facets; none if the file has none. `None` if bytes that were there can no longer be read.
pub(super) fn read(
    source: &impl Pieces,
    count: usize,
    bits: Bits,
    left_out: &mut LeftOut,
    budget: &Budget,
) -> Result<Option<Colors>, BudgetError> {
    match Scheme::of(source, bits) {
        None => Ok(None),
        Some(Scheme::Plain) => Ok(Some(Colors::default())),
        Some(Scheme::Unknown) => {
            left_out.add("attribute bytes of facets");
            Ok(Some(Colors::default()))
        }
        Some(scheme) => scheme.read(source, count, budget),
    }
}

impl Scheme {
    /// The scheme of a file, by its header and all facets; `None` as in [`read`]. One value in all facets is padding, such
    /// as spaces, unless it is a colour.
    fn of(source: &impl Pieces, bits: Bits) -> Option<Self> {
        let mut header = Vec::new();
        let header = source.piece(0, HEADER - 4, &mut header)?;
        const KEY: &[u8] = b"COLOR=";
        if let Some(at) = header.windows(KEY.len()).position(|word| word == KEY)
            && let Some(rest) = header.get(at + KEY.len()..)
            && let Some(&default) = rest.first_chunk()
        {
            // Magics has an alpha and a comma there. Its facets would not differ if all had the default.
            let is_meshlab = rest.get(3..).is_some_and(|rest| rest.starts_with(b" MATERIAL="));
            let all_differ = bits.all & FLAG != 0 && bits.any != bits.all;
            return Some(Self::Magics {
                default,
                is_reversed: is_meshlab || all_differ,
            });
        }
        let value = bits.any;
        Some(match (value & FLAG != 0, value & !bits.all != 0) {
            (true, true) => Self::VisCam,
            // Facets that are all black, or all white, have padding rather than colours.
            (true, false) if value != FLAG && value != u16::MAX => Self::VisCam,
            (false, true) => Self::Unknown,
            (_, false) => Self::Plain,
        })
    }

    /// The colour of a facet; `None` if it has none of its own.
    fn color(&self, attributes: u16) -> Option<[f32; 3]> {
        let channel = |shift: u32| f32::from(attributes >> shift & 31) / 31.0;
        let has_flag = attributes & FLAG != 0;
        match self {
            Self::VisCam if has_flag => Some([10, 5, 0].map(channel)),
            Self::Magics { is_reversed, .. } if has_flag == *is_reversed => Some([0, 5, 10].map(channel)),
            _ => None,
        }
    }

    /// What facets without a colour of their own show.
    fn default(&self) -> Surface {
        match *self {
            Self::Magics {
                default: [red, green, blue, _],
                ..
            } => Surface {
                diffuse: [red, green, blue].map(|channel| f32::from(channel) / 255.0),
                ..Surface::WHITE
            },
            _ => Surface::NEUTRAL,
        }
    }

    /// Reads the colours of `count` facets. `None` if bytes that were there can no longer be read.
    fn read(
        &self,
        source: &impl Pieces,
        count: usize,
        budget: &Budget,
    ) -> Result<Option<Colors>, BudgetError> {
        /// No surface has been made for a colour.
        const NONE: u32 = u32::MAX;
        let mut number_of = vec![NONE; FLAG.into()];
        let mut colors = Colors::default();
        budget.reserve(&mut colors.surface_of, count)?;
        budget.reserve(&mut colors.surfaces, 1)?;
        colors.surfaces.push(self.default());
        // Programs that know only the header leave zeros, which would be black.
        let mut is_all_zero = true;
        let mut buffer = Vec::new();
        for start in (0..count).step_by(PIECE) {
            let length = PIECE.min(count - start);
            let Some(facets) = source.piece(HEADER + start * FACET, length * FACET, &mut buffer) else {
                return Ok(None);
            };
            for attributes in facets.as_chunks().0.iter().map(attributes) {
                is_all_zero &= attributes == 0;
                let mut surface = 0;
                if let Some(color) = self.color(attributes) {
                    let number = &mut number_of[usize::from(attributes & !FLAG)];
                    if *number == NONE {
                        *number = colors.surfaces.len() as u32;
                        budget.reserve(&mut colors.surfaces, 1)?;
                        colors.surfaces.push(Surface {
                            diffuse: color,
                            ..Surface::WHITE
                        });
                    }
                    surface = *number;
                }
                colors.surface_of.push(surface);
            }
        }
        if is_all_zero {
            colors.surfaces.truncate(1);
            colors.surface_of.fill(0);
        }
        Ok(Some(colors))
    }
}

/// The attribute bytes of a facet.
fn attributes(facet: &[u8; FACET]) -> u16 {
    u16::from_le_bytes([facet[FACET - 2], facet[FACET - 1]])
}
