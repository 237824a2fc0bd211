//! Animations: the pose of the nodes at one time of one animation.
//!
//! Keyframes are interpolated as the specification says (glTF 2.0, section 3.11 and appendix C).

use super::{buffers::Buffers, elements::Elements, morphs::MorphTargets};
use crate::{
    error::{LoadError, LoadErrorKind},
    format::{
        left_out::counted,
        mesh::{MeshAnimation, Moment},
    },
    scene::slerp,
};
use glam::{DMat4, DQuat, DVec3, DVec4};
use gltf::{
    Document, Node,
    json::{
        Accessor, Root,
        animation::{Animation, Interpolation, Property},
        validation::Checked,
    },
};
use std::{collections::HashMap, rc::Rc};

/// How many weights the animations of a small file may change, counted for each channel.
const MOST_WEIGHTS: usize = 1 << 20;

/// What an animation changes: the nodes that it does not name stand as the file stores them.
#[derive(Default)]
pub(super) struct AnimatedPose(HashMap<usize, NodePose>);

#[derive(Default)]
struct NodePose {
    translation: Option<DVec3>,
    rotation: Option<DQuat>,
    scale: Option<DVec3>,
    weights: Option<Vec<f32>>,
}

impl NodePose {
    /// Sets what a track says. Returns whether that is finite.
    fn set(&mut self, property: Property, track: &Track<'_>, span: &Span, weights: Vec<f32>) -> bool {
        match property {
            Property::Translation => self.translation.insert(track.vector(span)).is_finite(),
            Property::Scale => self.scale.insert(track.vector(span)).is_finite(),
            Property::Rotation => {
                let rotation = track.rotation(span);
                self.rotation = unit(rotation);
                rotation.is_finite()
            }
            Property::MorphTargetWeights => {
                let weights = self.weights.insert(weights);
                weights.iter().all(|weight| weight.is_finite())
            }
        }
    }
}

impl AnimatedPose {
    /// The pose at a moment; nothing moves without one.
    pub(super) fn at(
        moment: Option<&Moment>,
        (animations, listed): (&[Animation], &[MeshAnimation]),
        (document, targets): (&Document, &MorphTargets<'_>),
        buffers: &mut Buffers<'_>,
    ) -> Result<Self, LoadError> {
        let Some(moment) = moment else {
            return Ok(Self::default());
        };
        let chosen = MeshAnimation::find(listed, moment.animation.as_deref());
        let chosen = chosen.map_err(|why| buffers.refused(why).with_kind(LoadErrorKind::Absent))?;
        let animation = &animations[chosen];
        let mut nodes: HashMap<usize, NodePose> = HashMap::new();
        let mut steps = 0;
        for (i, channel) in animation.channels.iter().enumerate() {
            let place = format!("animations[{chosen}].channels[{i}]");
            let Checked::Valid(property) = channel.target.path else {
                continue;
            };
            let node = document.nodes().nth(channel.target.node.value());
            let sampler = animation.samplers.get(channel.sampler.value());
            let (Some(node), Some(sampler)) = (node, sampler) else {
                return Err(buffers.refused(format!(
                    "{place} names a sampler or a node that the file does not have"
                )));
            };
            let interpolation = match sampler.interpolation {
                Checked::Valid(interpolation) => interpolation,
                Checked::Invalid => Interpolation::Linear,
            };
            let accessor = |i: usize| document.accessors().nth(i);
            let (Some(input), Some(output)) =
                (accessor(sampler.input.value()), accessor(sampler.output.value()))
            else {
                return Err(buffers.refused(format!("{place} names an accessor that the file does not have")));
            };
            let values = match property {
                Property::Translation | Property::Scale => buffers.vectors(&output)?,
                Property::Rotation => buffers.quaternions(&output)?,
                Property::MorphTargetWeights => buffers.numbers(&output)?,
            };
            let track = Track {
                times: buffers.times(&input)?,
                values,
                interpolation,
            };
            let width = track
                .width(property)
                .map_err(|why| buffers.refused(format!("{place}: {why}")))?;
            let Some(span) = track.span(moment.seconds) else {
                continue;
            };
            let mut weights = Vec::new();
            if property == Property::MorphTargetWeights {
                let most = node.mesh().map_or(0, |mesh| targets.count(mesh.index()));
                let count = width.min(most);
                steps += count;
                check_steps(steps, buffers)?;
                let room = buffers.budget().reserve(&mut weights, count);
                room.map_err(|error| buffers.no_room(error))?;
                weights.extend((0..count).map(|i| track.number(&span, [i, width]) as f32));
            }
            let pose = nodes.entry(node.index()).or_default();
            if !pose.set(property, &track, &span, weights) {
                let seconds = moment.seconds;
                return Err(buffers.refused(format!("{place}: its value at {seconds} seconds is not finite")));
            }
        }
        Ok(Self(nodes))
    }

    /// The transform of a node relative to its parent, if the animation changes it.
    pub(super) fn local(&self, node: &Node<'_>) -> Option<DMat4> {
        let pose = self.0.get(&node.index())?;
        if pose.translation.is_none() && pose.rotation.is_none() && pose.scale.is_none() {
            return None;
        }
        let (translation, rotation, scale) = node.transform().decomposed();
        let vector = |numbers: [f32; 3]| DVec3::from_array(numbers.map(f64::from));
        let stored = DVec4::from_array(rotation.map(f64::from));
        Some(DMat4::from_scale_rotation_translation(
            pose.scale.unwrap_or(vector(scale)),
            pose.rotation.unwrap_or(unit(stored).unwrap_or(DQuat::IDENTITY)),
            pose.translation.unwrap_or(vector(translation)),
        ))
    }

    /// Whether the animation moves a node.
    pub(super) fn has_translation(&self, node: usize) -> bool {
        self.0.get(&node).is_some_and(|pose| pose.translation.is_some())
    }

    /// The weights of a node's morph targets, if the animation changes them.
    pub(super) fn weights(&self, node: usize) -> Option<&[f32]> {
        self.0.get(&node)?.weights.as_deref()
    }
}

/// The animations of a file, with their names and lengths. `max` of an accessor of times is required by the specification.
pub(super) fn listed(root: &Root) -> Vec<MeshAnimation> {
    let last = |accessor: &Accessor| accessor.max.as_ref()?.get(0)?.as_f64();
    // Samplers act through channels.
    let seconds = |animation: &Animation| {
        if animation.channels.is_empty() {
            return Some(0.0);
        }
        let samplers = animation.channels.iter().map(|channel| channel.sampler.value());
        let inputs = samplers.filter_map(|sampler| Some(animation.samplers.get(sampler)?.input.value()));
        let ends = inputs.filter_map(|input| last(root.accessors.get(input)?));
        ends.reduce(f64::max).map(|end| end.max(0.0))
    };
    let listed = |animation: &Animation| MeshAnimation {
        name: animation.name.clone().unwrap_or_default(),
        seconds: seconds(animation),
    };
    root.animations.iter().map(listed).collect()
}

/// Refuses more weights than a file of this size may change.
fn check_steps(steps: usize, buffers: &Buffers<'_>) -> Result<(), LoadError> {
    let size = buffers.size();
    let most = size.saturating_mul(8).saturating_add(MOST_WEIGHTS);
    if steps <= most {
        return Ok(());
    }
    Err(buffers.too_much(format!(
        "the animation changes {steps} weights of morph targets, expected at most {most} from {size} bytes"
    )))
}

/// What one property of a node goes through.
struct Track<'a> {
    /// Seconds, ascending.
    times: Rc<Elements<'a>>,
    /// Of each time; of cubic splines between the tangents there.
    values: Rc<Elements<'a>>,
    interpolation: Interpolation,
}

/// A time between two keyframes.
struct Span {
    keyframes: [usize; 2],
    /// 0 at the first one, 1 at the second.
    share: f64,
    /// Seconds between them.
    length: f64,
}

impl Track<'_> {
    /// How many elements each keyframe has; more than one for weights alone. The error is a sentence.
    fn width(&self, property: Property) -> Result<usize, String> {
        let (found, keyframes) = (self.values.count, self.times.count);
        let needed = keyframes.checked_mul(self.parts());
        let is_weights = property == Property::MorphTargetWeights;
        let width = match needed {
            Some(0) => Some(1),
            Some(needed) if is_weights => Some(found / needed).filter(|width| width * needed == found),
            Some(needed) => Some(1).filter(|_| found >= needed),
            None => None,
        };
        width.filter(|width| *width > 0).ok_or_else(|| {
            let values = counted(found, "value", "values");
            let keyframes = counted(keyframes, "keyframe", "keyframes");
            let each = match (is_weights, self.parts()) {
                (false, 1) => "one",
                (false, _) => "three",
                (true, 1) => "one of each weight",
                (true, _) => "three of each weight",
            };
            format!("{values} for {keyframes}, expected {each} for each")
        })
    }

    /// How many values a keyframe has: with tangents three.
    fn parts(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline {
            3
        } else {
            1
        }
    }

    fn time(&self, i: usize) -> f64 {
        let [time] = self.times.numbers(i);
        f64::from(time)
    }

    /// Where a time is; before the first keyframe and after the last one nothing moves. `None` without keyframes.
    fn span(&self, seconds: f64) -> Option<Span> {
        let last = self.times.count.checked_sub(1)?;
        // Keyframes are `f32`: one that was written for 2.7 may be stored a little later.
        let rounded = f64::from(seconds as f32);
        // By bisection: the first keyframe after the time.
        let (mut before, mut after) = (0, self.times.count);
        while before < after {
            let middle = before + (after - before) / 2;
            if self.time(middle) <= rounded {
                before = middle + 1;
            } else {
                after = middle;
            }
        }
        let first = after.saturating_sub(1);
        let keyframes = [first, after.min(last)];
        let length = self.time(keyframes[1]) - self.time(first);
        let share = (seconds - self.time(first)) / length;
        let is_between = length > 0.0 && (0.0..=1.0).contains(&share);
        Some(Span {
            keyframes,
            share: if is_between { share } else { 0.0 },
            length: if is_between { length } else { 0.0 },
        })
    }

    /// Four components of a property; `of` reads element `i`.
    fn value(&self, span: &Span, [i, width]: [usize; 2], of: impl Fn(usize) -> DVec4) -> DVec4 {
        let parts = self.parts();
        let at = |keyframe: usize, part: usize| of((keyframe * parts + part) * width + i);
        let ([a, b], t) = (span.keyframes, span.share);
        match self.interpolation {
            // What does not count may be NaN.
            _ if t == 0.0 => at(a, parts / 2),
            Interpolation::Step => at(a, 0),
            Interpolation::Linear => at(a, 0).lerp(at(b, 0), t),
            Interpolation::CubicSpline => {
                let (square, cube) = (t * t, t * t * t);
                let leaves = span.length * at(a, 2);
                let arrives = span.length * at(b, 0);
                (2.0 * cube - 3.0 * square + 1.0) * at(a, 1)
                    + (cube - 2.0 * square + t) * leaves
                    + (3.0 * square - 2.0 * cube) * at(b, 1)
                    + (cube - square) * arrives
            }
        }
    }

    fn vector(&self, span: &Span) -> DVec3 {
        let of = |i: usize| DVec3::from_array(self.values.vector(i).map(f64::from)).extend(0.0);
        self.value(span, [0, 1], of).truncate()
    }

    /// Number `i` of `width`.
    fn number(&self, span: &Span, of_width: [usize; 2]) -> f64 {
        let of = |i: usize| DVec4::splat(f64::from(self.values.numbers::<1>(i)[0]));
        self.value(span, of_width, of).x
    }

    fn rotation(&self, span: &Span) -> DVec4 {
        let of = |i: usize| DVec4::from_array(self.values.numbers::<4>(i).map(f64::from));
        if self.interpolation != Interpolation::Linear || span.share == 0.0 {
            return self.value(span, [0, 1], of);
        }
        let [from, to] = span.keyframes.map(of);
        match [from, to].map(unit) {
            [Some(from), Some(to)] => slerp(from.into(), to.into(), span.share),
            _ => from.lerp(to, span.share),
        }
    }
}

/// The rotation of a quaternion; `None` if it is 0.
fn unit(quaternion: DVec4) -> Option<DQuat> {
    quaternion.try_normalize().map(DQuat::from_vec4)
}
