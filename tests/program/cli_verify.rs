//! `octray verify`. (Exit code 5 is tested beside the command's code, where a fault can be injected.)

use crate::program::{Folder, Run, assert_contains};
use serde_json::Value;

#[test]
fn all_methods_agree_and_counts_are_printed() {
    let folder = Folder::new();
    let run = folder.run(&["verify", "--rays", "20000", "--threads", "2"]);
    let words = [
        concat!("octray ", env!("CARGO_PKG_VERSION"), " ("),
        "brute force",
        "scalar BVH",
        "render",
        "packets",
        "seed 1",
        "all agree, bit for bit",
    ];
    assert_contains(run.succeeded().text(), &words);
}

#[test]
fn counts_depend_only_on_the_seed() {
    let folder = Folder::new();
    let counts = |seed, threads| {
        let run = folder.run_line(&format!(
            "verify --rays 8000 --seed {seed} --threads {threads} --json -"
        ));
        let mut json: Value = serde_json::from_str(run.succeeded().text()).unwrap();
        for timing in ["seconds", "rays_per_s"] {
            json.as_object_mut().unwrap().remove(timing).unwrap();
        }
        json
    };
    let first = counts(5, 1);
    assert_eq!(first, counts(5, 2));
    assert_ne!(first["hits"], counts(6, 2)["hits"]);
    assert!(first["rays"].as_u64() >= Some(8_000) && first["agree"] == true && first["fault"].is_null());
    for method in first["methods"].as_array().unwrap() {
        assert_eq!(method["rays"], first["rays"], "{method}");
    }
}

#[test]
fn one_scene_can_be_repeated() {
    let folder = Folder::new();
    let run = folder.run(&["verify", "--scene", "123456", "--seed", "9"]);
    assert!(run.succeeded().text().contains("in 1 scene of"), "{run:?}");
}

#[test]
fn invalid_arguments_are_refused() {
    let folder = Folder::new();
    folder.fails(&["verify", "--rays", "0"], 2, "--rays");
    folder.fails(&["verify", "--seconds=-1"], 2, "--seconds");
    folder.fails(&["verify", "--seconds", "nan"], 2, "a number of seconds");
    folder.fails(
        &["verify", "--scene", "1", "--rays", "5"],
        2,
        "cannot be used with",
    );
}

#[cfg(unix)]
#[test]
fn a_signal_prints_the_counts_so_far() {
    let folder = Folder::new();
    // Wait until the program catches signals, since before that one would end it at once, and has worked for half a second.
    let script = "\"$0\" verify --seconds 300 --threads 1 > counts & \
        while ! grep -q '^SigCgt:.*[2367abef]$' /proc/$!/status 2>/dev/null; do sleep 0.1; done; \
        while [ \"$(cut -d ' ' -f 14 /proc/$!/stat)\" -lt 50 ]; do sleep 0.1; done; kill -INT $!; wait $!";
    if !cfg!(target_os = "linux") {
        println!("skipped: this needs /proc");
        return;
    }
    let run: Run = folder.shell(script);
    assert_eq!((run.code, run.stderr.as_str()), (Some(130), ""));
    let counts = std::fs::read_to_string(folder.path("counts")).unwrap();
    assert!(counts.contains("all agree so far; interrupted"), "{counts}");
}
