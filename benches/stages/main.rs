//! Each stage on its own: loading, building, tracing each kind of rays, whole frames.
//!
//! ```text
//! cargo bench --bench stages
//! cargo bench --bench stages -- mirror
//! ```
//!
//! `octray bench` compares ways of tracing in turn and checks their hits.

mod scenes;
#[path = "../common/view.rs"]
mod view;

use divan::{Bencher, black_box, counter};
use octray::{
    accel::Bvh,
    bench::{Kind, Results, reference, trace_set},
    render::{Mode, Settings, render},
    trace::{Method, Tracer},
};
use scenes::{NAMES, ready};
use std::ops::ControlFlow;

fn main() {
    divan::main();
}

/// From files in memory to a scene.
#[divan::bench(args = NAMES, max_time = 1)]
fn load(bencher: Bencher, name: &str) {
    let files = &ready(name).files;
    bencher
        .counter(counter::BytesCount::new(files.bytes()))
        .bench(|| files.load());
}

/// From a scene to its BVH, on all threads.
#[divan::bench(args = NAMES, max_time = 1)]
fn build(bencher: Bencher, name: &str) {
    let scene = &ready(name).scene;
    bencher
        .counter(counter::ItemsCount::new(scene.primitive_count()))
        .bench(|| Bvh::build(black_box(scene)));
}

/// From rays in memory to hits in memory, on one thread; items are rays. `None`: the scalar reference.
fn trace(bencher: Bencher, name: &str, kind: Kind, method: Option<Method>) {
    let ready = ready(name);
    let Some(set) = ready.workload.sets.iter().find(|set| set.kind == kind) else {
        return;
    };
    let bencher = bencher.counter(counter::ItemsCount::new(set.count));
    match method {
        None => bencher.bench_local(|| reference(&ready.scene, &ready.bvh, set)),
        Some(method) => {
            let mut tracer = Tracer::with_method(&ready.bvh, method);
            let mut results = Results::default();
            bencher.bench_local(|| {
                trace_set(&mut tracer, black_box(set), &mut results);
                results.hits.len() + results.blocked.len()
            });
        }
    }
}

macro_rules! trace_benches {
    ($($module:ident: $kind:expr,)*) => {$(
        #[divan::bench_group(max_time = 0.5)]
        mod $module {
            use super::{Bencher, Kind, Method, NAMES};

            #[divan::bench(args = NAMES)]
            fn scalar(bencher: Bencher, name: &str) {
                super::trace(bencher, name, $kind, None);
            }

            #[divan::bench(args = NAMES)]
            fn packet(bencher: Bencher, name: &str) {
                super::trace(bencher, name, $kind, Some(Method::Packet));
            }

            #[divan::bench(args = NAMES)]
            fn single(bencher: Bencher, name: &str) {
                super::trace(bencher, name, $kind, Some(Method::Single));
            }

            #[divan::bench(args = NAMES)]
            fn render(bencher: Bencher, name: &str) {
                super::trace(bencher, name, $kind, Some(Method::Adaptive));
            }
        }
    )*};
}

trace_benches! {
    camera: Kind::Camera,
    shadow: Kind::Shadow,
    mirror: Kind::Mirror,
    diffuse: Kind::Diffuse,
    ao: Kind::Ao,
}

/// 512x512 with shadows and three levels, without encoding.
#[divan::bench_group(max_time = 1)]
mod frame {
    use super::{Bencher, ControlFlow, Mode, NAMES, Settings, ready};

    fn frame(bencher: Bencher, name: &str, mode: Mode, threads: Option<usize>) {
        let ready = ready(name);
        let settings = Settings {
            mode,
            threads,
            ..Settings::default()
        };
        bencher.bench_local(|| {
            super::render(&ready.scene, &ready.bvh, &ready.camera, &settings, &|_| {
                ControlFlow::Continue(())
            })
            .map(|frame| frame.elapsed)
        });
    }

    #[divan::bench(args = NAMES)]
    fn scalar_one_thread(bencher: Bencher, name: &str) {
        frame(bencher, name, Mode::Scalar, Some(1));
    }

    #[divan::bench(args = NAMES)]
    fn one_thread(bencher: Bencher, name: &str) {
        frame(bencher, name, Mode::Packet, Some(1));
    }

    #[divan::bench(args = NAMES)]
    fn all_threads(bencher: Bencher, name: &str) {
        frame(bencher, name, Mode::Packet, None);
    }
}
