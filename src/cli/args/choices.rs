//! Named values of options: how they are spelled on the command line.

use crate::{
    accel::BuildQuality,
    bench::Method,
    cli::{
        plan::{Build, ColorMap, Engine, Style},
        write::AovKind,
    },
    render::{Filter, Mode, Pattern},
};
use clap::{ValueEnum, builder::PossibleValue};

/// A value of one of the library's types.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Choice<T>(pub T);

/// Gives a type's values their names and help texts.
macro_rules! choices {
    ($type:ty: $($value:expr => $name:literal, $help:literal;)*) => {
        impl ValueEnum for $type {
            fn value_variants<'a>() -> &'a [Self] {
                &[$($value),*]
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                $(if *self == $value {
                    return Some(PossibleValue::new($name).help($help));
                })*
                None
            }
        }
    };
}

choices! { AovKind:
    Self::Depth => "depth", "Distance from the eye; in all files but EXR on a logarithmic scale, 255 near, 1 far, 0 for a miss (formula: docs/json.md)";
    Self::Normal => "normal", "Shading normal";
    Self::Albedo => "albedo", "The material's own colour";
    Self::Id => "id", "Which triangle or sphere";
    Self::Heat => "heat", "How many nodes and primitives the ray visited";
    Self::Mask => "mask", "Where the ray hits anything: 255, else 0; 8 bits, PNG or EXR only";
    Self::Z => "z", "Depth along the view in steps of --z-step, 0 for misses and beyond 65535 steps; 16 bits, PNG or EXR (units, inf for misses) only";
    Self::Instance => "instance", "0 for a miss, 1 outside of instances, 2 for the first instance, ..., 65535 for all beyond; 16 bits, PNG or EXR (32 bits) only";
}

choices! { Engine:
    Self::OpenJd => "openjd", "An Open Job Description template, version 2023-09";
    Self::Slurm => "slurm", "Slurm: an array of tasks, and a job that merges afterwards";
    Self::Parallel => "parallel", "GNU parallel, on this machine or by ssh";
}

choices! { Style:
    Self::Plain => "plain", "Two point lights with hard shadows; one sample per pixel, no gamma";
    Self::Studio => "studio", "A large soft light and ambient occlusion; up to 16 samples per pixel, tent filter, sRGB (an EXR stays linear)";
    Self::Clay => "clay", "Studio light, one colour for the whole mesh";
}

impl ValueEnum for ColorMap {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

choices! { Choice<Pattern>:
    Self(Pattern::Grid) => "grid", "A regular grid";
    Self(Pattern::Stratified) => "stratified", "A random point in each cell of a regular grid";
    Self(Pattern::Sobol) => "sobol", "A Sobol' sequence, scrambled differently in each pixel";
}

choices! { Choice<Filter>:
    Self(Filter::Box) => "box", "Constant within the pixel";
    Self(Filter::Tent) => "tent", "Falls linearly to 0 at a distance of 1 pixel";
    Self(Filter::BlackmanHarris) => "blackman-harris", "A bell that falls to 0 at a distance of 1.5 pixels";
}

choices! { Choice<Mode>:
    Self(Mode::Packet) => "packet", "SIMD packets, batched shading";
    Self(Mode::Scalar) => "scalar", "One ray at a time";
}

choices! { Build:
    Self::Auto => "auto", "fast for few rays and many primitives, else best";
    Self::Quality(BuildQuality::Fast) => "fast", "The BVH that is built fastest";
    Self::Quality(BuildQuality::Best) => "best", "The BVH that is traced fastest";
    Self::Quality(BuildQuality::Ploc) => "ploc", "A BVH by PLOC, for comparison; building takes 300 bytes per primitive instead of 100, which --max-memory does not count";
}

choices! { Method:
    Self::Scalar => "scalar", "The scalar reference over the BVH, one ray at a time";
    Self::Packet => "packet", "Packets of eight rays";
    Self::Single => "single", "One ray against eight boxes at a time";
    Self::Render => "render", "What the renderer uses: up to 512 rays together, packets or single rays";
}
