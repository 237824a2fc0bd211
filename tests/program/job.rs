//! `octray job`: the files that engines run. Their commands are run here by `sh`, each separately; GNU parallel is used if it
//! is installed.

use crate::program::{Folder, PROGRAM, Run, names_in};
use std::{env, fs, path::Path};

fn read(folder: &Folder, name: &str) -> String {
    fs::read_to_string(folder.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Runs a script with octray on the PATH.
fn shell(folder: &Folder, script: &str) -> Run {
    let programs = Path::new(PROGRAM).parent().expect("a folder").to_owned();
    let path = env::var_os("PATH").unwrap_or_default();
    let path = env::join_paths([programs].into_iter().chain(env::split_paths(&path))).expect("a PATH");
    Run::new(
        folder
            .any_command("sh", &["-c", script])
            .env("PATH", path)
            .output()
            .expect("a shell"),
    )
}

/// Runs every line of a file by a shell of its own, and twice: tasks may be repeated.
fn run_lines(folder: &Folder, file: &str) {
    for line in read(folder, file).lines() {
        for _ in 0..2 {
            shell(folder, line).succeeded();
        }
    }
}

fn assert_same(folder: &Folder, a: &str, b: &str) {
    let [a_bytes, b_bytes] =
        [a, b].map(|name| fs::read(folder.path(name)).unwrap_or_else(|e| panic!("{name}: {e}")));
    assert!(a_bytes == b_bytes, "{a} differs from {b}");
}

#[test]
fn tiles_of_a_picture() {
    let folder = Folder::new();
    let options = "--size 41x30 --samples 4 --aov depth,id --eye -3,1,2";
    folder
        .run_line(&format!("a.scn -o whole.png --quiet {options}"))
        .succeeded();
    folder
        .run_line(&format!(
            "job a.scn -o a.png {options} --for parallel --into farm --tiles 2x2"
        ))
        .succeeded();
    assert_eq!(
        names_in(&folder.path("farm")),
        ["commands.txt", "merge.txt", "run.sh", "tiles"]
    );
    let common = "octray render --no-config --quiet --skip-existing --size=41x30 --aov='depth,id' --samples=4 --eye='-3,1,2'";
    let expected: String = ["0,0,20,15", "20,0,41,15", "0,15,20,30", "20,15,41,30"]
        .iter()
        .zip(["0-0", "20-0", "0-15", "20-15"])
        .map(|(crop, name)| format!("{common} --crop='{crop}' --output=farm/tiles/{name}.png -- a.scn\n"))
        .collect();
    assert_eq!(read(&folder, "farm/commands.txt"), expected);
    let merge = |kind: &str| {
        let tiles = ["0-0", "20-0", "0-15", "20-15"].map(|tile| format!(" farm/tiles/{tile}{kind}.png"));
        format!("octray merge --quiet --output=a{kind}.png --{}\n", tiles.concat())
    };
    assert_eq!(
        read(&folder, "farm/merge.txt"),
        [merge(""), merge(".depth"), merge(".id")].concat()
    );
    run_lines(&folder, "farm/commands.txt");
    run_lines(&folder, "farm/merge.txt");
    for kind in ["", ".depth", ".id"] {
        assert_same(&folder, &format!("a{kind}.png"), &format!("whole{kind}.png"));
    }
    if shell(&folder, "parallel --version")
        .stdout
        .starts_with(b"GNU parallel")
    {
        for name in ["a.png", "a.depth.png", "a.id.png"] {
            fs::remove_file(folder.path(name)).expect("a file");
        }
        let run = "cd /; sh \"$OLDPWD\"/farm/run.sh";
        assert_eq!(shell(&folder, run).code, Some(0));
        assert_same(&folder, "a.png", "whole.png");
        // Again, without a tile and the picture.
        for name in ["a.png", "farm/tiles/20-15.png"] {
            fs::remove_file(folder.path(name)).expect("a file");
        }
        assert_eq!(shell(&folder, run).code, Some(0));
        assert_same(&folder, "a.png", "whole.png");
    } else {
        println!("skipped: this needs GNU parallel");
    }
}

/// A single picture has tiles by default; names are quoted for the shell, options of the config file are written out.
#[test]
fn odd_names_and_a_config_file() {
    let folder = Folder::new();
    let scene = "it's $HOME; {stem}.scn";
    fs::copy(folder.path("a.scn"), folder.path(scene)).expect("a scene");
    folder.write("c.toml", "samples = 4\nsize = \"20x3\"\n");
    let whole = ["render", scene, "-o", "whole.exr", "--config=c.toml", "--quiet"];
    folder.run(&whole).succeeded();
    let job = [
        "job",
        scene,
        "-o",
        "a b.exr",
        "--config=c.toml",
        "--for=parallel",
        "--into=my farm",
    ];
    folder.run(&job).succeeded();
    let commands = read(&folder, "my farm/commands.txt");
    assert_eq!(commands.lines().count(), 4 * 3);
    let first = commands.lines().next().expect("a line");
    assert!(
        first.starts_with(
            "octray render --no-config --quiet --skip-existing --size=20x3 --samples=4 --crop='0,0,5,1' "
        ),
        "{first}"
    );
    run_lines(&folder, "my farm/commands.txt");
    run_lines(&folder, "my farm/merge.txt");
    assert_same(&folder, "a b.exr", "whole.exr");
}

/// Names that look like options with values are quoted whole.
#[test]
fn names_are_no_commands() {
    let folder = Folder::new();
    let (scene, into) = ("--$(touch pwned)=a.scn", "--$(touch pwned)=d");
    fs::copy(folder.path("a.scn"), folder.path(scene)).expect("a scene");
    let into_option = format!("--into={into}");
    let job = [
        "job",
        "--for=parallel",
        &into_option,
        "--size=8x8",
        "-o",
        "b.png",
        "--",
        scene,
    ];
    folder.run(&job).succeeded();
    for file in ["commands.txt", "merge.txt"] {
        run_lines(&folder, &format!("{into}/{file}"));
    }
    assert!(folder.path("b.png").exists() && !folder.path("pwned").exists());
}

/// A task that was killed between its files: the AOV exists, the picture does not. QOI files are not marked.
#[test]
fn aovs_of_a_killed_task() {
    let folder = Folder::new();
    let options = "a.scn --size 8x6 --aov depth";
    for (into, more, made) in [
        ("frames", "--turntable 2 -o a-#.qoi", "a-1"),
        ("tiles", "-o b.qoi --tiles 1x1 --force", "tiles/tiles/0-0"),
    ] {
        let job = format!("job {options} {more} --for parallel --into {into}");
        folder.run_line(&job).succeeded();
        let commands = format!("{into}/commands.txt");
        run_lines(&folder, &commands);
        fs::remove_file(folder.path(&format!("{made}.qoi"))).expect("a picture");
        run_lines(&folder, &commands);
        assert!(folder.path(&format!("{made}.qoi")).exists());
    }
    folder.write("c-1.depth.qoi", "somebody's");
    let job = format!("job {options} --turntable 2 -o c-#.qoi --for parallel --into more");
    folder.fails(
        &job.split(' ').collect::<Vec<_>>(),
        1,
        "c-1.depth.qoi exists and may be another program's",
    );
}

#[test]
fn frames_of_a_turntable() {
    let folder = Folder::new();
    let options = "a.scn --size 16x12 --turntable 7";
    folder
        .run_line(&format!("{options} -o whole-#.png --quiet"))
        .succeeded();
    let job = format!("job {options} -o t-#.png --frames 2-7 --chunk 4 --for slurm --into farm");
    folder.run_line(&job).succeeded();
    assert_eq!(
        names_in(&folder.path("farm")),
        ["commands.txt", "submit.sh", "task.sh", "tasks.sbatch"]
    );
    let call =
        "octray render --no-config --quiet --skip-existing --size=16x12 --turntable=7 --output='t-#.png'";
    assert_eq!(
        read(&folder, "farm/commands.txt"),
        format!("{call} --frames=2-5 --json=- -- a.scn # 4\n{call} --frames=6-7 --json=- -- a.scn # 2\n")
    );
    let sbatch = read(&folder, "farm/tasks.sbatch");
    assert!(sbatch.contains("#SBATCH --array=1-2\n"), "{sbatch}");
    for (task, shares) in [(1, &[25, 50, 75, 100][..]), (2, &[50, 100]), (2, &[100])] {
        let run = shell(
            &folder,
            &format!("SLURM_ARRAY_TASK_ID={task} sh farm/tasks.sbatch"),
        );
        let shares: String = shares
            .iter()
            .map(|share| format!("progress: {share}\n"))
            .collect();
        assert_eq!(run.succeeded().text(), shares);
    }
    for frame in 2..=7 {
        assert_same(&folder, &format!("t-{frame}.png"), &format!("whole-{frame}.png"));
    }
    assert!(!folder.path("t-1.png").exists());
    // Tiles of every frame.
    let job = format!("job {options} -o u-#.png --tiles 2x1 --chunk 3 --for slurm --into more");
    folder.run_line(&job).succeeded();
    assert_eq!(
        names_in(&folder.path("more")),
        [
            "commands.txt",
            "merge.sbatch",
            "merge.txt",
            "submit.sh",
            "task.sh",
            "tasks.sbatch",
            "tiles"
        ]
    );
    assert!(read(&folder, "more/tasks.sbatch").contains("--array=1-5\n"));
    // What `sbatch` does, without a queue.
    folder.write(
        "sbatch",
        "#!/bin/sh\necho \"$@\" >> sbatch.log\nfor last; do :; done\ncase $last in\n\
         *tasks*) for i in 1 2 3 4 5; do SLURM_ARRAY_TASK_ID=$i sh \"$last\" >> progress.log; done; echo '17;cluster' ;;\n\
         *) sh \"$last\" ;;\nesac\n",
    );
    let run = shell(
        &folder,
        "chmod +x sbatch; PATH=$PWD:$PATH; export PATH; cd /; sh \"$OLDPWD\"/more/submit.sh --partition=night",
    );
    assert_eq!(run.succeeded().text(), "tasks: 17;cluster\n");
    assert_eq!(
        read(&folder, "sbatch.log"),
        "--parsable --output=more/%A_%a.log --partition=night more/tasks.sbatch\n\
         --dependency=afterok:17 --kill-on-invalid-dep=yes --output=more/merge.log --partition=night more/merge.sbatch\n"
    );
    let progress = read(&folder, "progress.log");
    assert!(
        progress.starts_with("progress: 33\nprogress: 66\nprogress: 100\n"),
        "{progress}"
    );
    assert!(progress.ends_with("progress: 50\nprogress: 100\n"), "{progress}");
    for frame in 1..=7 {
        assert_same(&folder, &format!("u-{frame}.png"), &format!("whole-{frame}.png"));
    }
}

/// The template of Open Job Description, word for word. `openjd check` accepts it.
#[test]
fn a_template_for_openjd() {
    let folder = Folder::new();
    folder
        .run_line("job a.scn -s 16x12 -o a.png --tiles 2x1 --for openjd --into farm")
        .succeeded();
    let directory = fs::canonicalize(folder.path("")).expect("a folder");
    let template = read(&folder, "farm/template.yaml");
    let template = template.replace(directory.to_str().expect("UTF-8"), "/FOLDER");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/program/template.yaml");
    if env::var_os("OCTRAY_BLESS").is_some() {
        fs::write(&path, &template).expect("the expected template");
    }
    assert_eq!(
        template,
        fs::read_to_string(&path).expect("the expected template")
    );
    folder.run_line("a.scn -s 16x12 -o whole.png -q").succeeded();
    for task in 1..=2 {
        let run = shell(&folder, &format!("sh farm/task.sh {task}"));
        assert_eq!(run.succeeded().text(), "openjd_progress: 100\n");
    }
    run_lines(&folder, "farm/merge.txt");
    assert_same(&folder, "a.png", "whole.png");
    let broken = "sed -i 's/octray/echo hello; exit 7;/' farm/commands.txt; sh farm/task.sh 1";
    let run = shell(&folder, broken);
    assert_eq!((run.code, run.text()), (Some(7), "hello\n"));
}

/// The pictures that a job leaves as they are.
#[test]
fn pictures_that_exist() {
    let folder = Folder::new();
    let job = "job a.scn -s 8x6 --turntable 3 -o a-#.png --aov depth --for parallel";
    let warned = |options: &str, words: &str| {
        let run = folder.run_line(&format!("{job} {options}"));
        assert_eq!(run.code, Some(0), "{run:?}");
        assert_eq!(run.stderr, words);
    };
    warned("--into none", "");
    folder
        .run_line("a.scn -s 8x6 --turntable 3 --frames 1-2 -o a-#.png --aov depth -q")
        .succeeded();
    let words = "warning: 2 of 3 pictures exist and stay; remove them to render them again\n";
    warned("--into two", words);
    warned("--into quiet --quiet", "");
    warned("--into skipped --skip-existing", "");
    // Its tiles are merged into a new one.
    warned("--into tiles --tiles 1x1", "");
    let line = format!("{job} --into force --force");
    folder.fails(
        &line.split(' ').collect::<Vec<_>>(),
        2,
        "--force: 2 of 3 pictures exist, and the tasks of a job leave them; remove them first",
    );
    // One whose AOV is missing does not exist: its task makes both.
    let picture = fs::read(folder.path("a-2.png")).expect("a picture");
    fs::remove_file(folder.path("a-2.depth.png")).expect("an AOV");
    warned("--into one", &words.replace('2', "1"));
    run_lines(&folder, "one/commands.txt");
    assert!(folder.path("a-2.depth.png").exists() && folder.path("a-3.png").exists());
    assert!(fs::read(folder.path("a-2.png")).expect("a picture") == picture);
}

#[test]
fn skipped_scenes() {
    let folder = Folder::new();
    let job = "job no.scn -o {stem}.png --keep-going --for slurm --into farm";
    let run = folder.run_line(job);
    let expected = "error: skipped: no.scn: file not found\nerror: 1 scene was skipped\n";
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), expected));
    assert!(!folder.path("farm").exists());
    let run = folder.run_line(&format!("{job} a.scn -s 8x6"));
    assert_eq!((run.code, run.stderr.as_str()), (Some(1), expected));
    assert!(read(&folder, "farm/commands.txt").ends_with(" -- a.scn\n"));
}

/// A job is written whole or not at all, and never taken for an option.
#[test]
fn folders_of_jobs() {
    let folder = Folder::new();
    let job = "a.scn -s 8x6 -o a.png --tiles 1x1";
    for (script, words) in [
        (
            format!(
                "mkdir \"$(printf 'a\\tb')\"; cp a.scn a*b; cd a*b; \"$0\" job {job} --for openjd --into new/farm"
            ),
            "a name with control characters cannot be written into a job",
        ),
        (
            format!("\"$0\" job {job} --for slurm --into 'new\\farm'"),
            "--into new\\farm/: Slurm takes no \\ in the names of its logs",
        ),
        // Which of both scripts does not fit depends on the blocks that the shell counts: 512 or 1024 bytes.
        (
            format!("trap '' XFSZ; ulimit -f 1; exec \"$0\" job {job} --for openjd --into new/farm"),
            "cannot write new/farm/t",
        ),
    ] {
        folder
            .shell(&script)
            .failed(1 + i32::from(!words.contains("write new")), words);
        let left = folder.shell("find . -name 'new*' -o -name farm");
        assert_eq!(left.text(), "", "{script}");
    }
    folder
        .run_line(&format!("job {job} --for slurm --into=-j"))
        .succeeded();
    let run = shell(
        &folder,
        "SLURM_ARRAY_TASK_ID=1 sh ./-j/tasks.sbatch; sh ./-j/merge.sbatch",
    );
    assert_eq!(run.succeeded().text(), "progress: 100\n");
    assert!(folder.path("a.png").exists());
    let submit = read(&folder, "-j/submit.sh");
    assert!(
        submit.contains("./-j/%A_%a.log") && submit.contains(" ./-j/tasks.sbatch"),
        "{submit}"
    );
}

/// Defaults of the config file that no job takes.
#[test]
fn ignored_defaults() {
    let folder = Folder::new();
    let config = "json = 'x.json'\nstats = true\ncrop = '0,0,4,4'\n";
    folder.write("c.toml", config);
    folder.write(
        "d.toml",
        "save-poses = 'p.json'\ncompare = 'b.png'\ntolerance = 3\nsamples = 4\n",
    );
    folder.write("e.toml", "sheet = 2\n");
    for name in ["c", "d", "e"] {
        let job =
            format!("job a.scn -s 8x6 -o a.png --tiles 2x2 --for slurm --into {name} --config {name}.toml");
        folder.run_line(&job).succeeded();
        run_lines(&folder, &format!("{name}/commands.txt"));
        run_lines(&folder, &format!("{name}/merge.txt"));
    }
    assert!(read(&folder, "d/commands.txt").starts_with(
        "octray render --no-config --quiet --skip-existing --size=8x6 --samples=4 --crop='0,0,4,3' "
    ));
    let job = "job a.scn --for slurm --into f --config c.toml --json y.json";
    folder.fails(&job.split(' ').collect::<Vec<_>>(), 2, "--json cannot be used");
}

#[test]
fn what_is_no_job() {
    let folder = Folder::new();
    for (line, code, words) in [
        ("a.scn --for slurm", 2, "--into <FOLDER>"),
        (
            "a.scn --for make --into farm",
            2,
            "invalid value 'make' for '--for <ENGINE>'",
        ),
        ("--for slurm --into farm", 2, "<SCENE>"),
        (
            "a.scn --for slurm --into farm --tiles 0x4",
            2,
            "expected COLUMNSxROWS, both 1 or more, such as 4x4",
        ),
        (
            "a.scn --for slurm --into farm --tiles 600x1",
            2,
            "--tiles 600x1: a picture of 512x512 has fewer pixels than tiles",
        ),
        (
            "a.scn --for slurm --into farm --tiles 512x512",
            2,
            "262144 tiles, expected at most 100000",
        ),
        (
            "a.scn --for slurm --into farm --crop 0,0,8,8",
            2,
            "--crop cannot be used with octray job",
        ),
        (
            "a.scn --for slurm --into farm --json a.json",
            2,
            "--json cannot be used with octray job",
        ),
        (
            "a.scn --for slurm --into farm -o a.jpg",
            2,
            "a.jpg: JPEG loses detail in each tile; name a picture such as .png",
        ),
        (
            "a.scn --for slurm --into farm --turntable 3 -o a.gif",
            2,
            "a.gif: a job makes pictures in files",
        ),
        ("a.scn --for slurm --into farm -o -", 2, "name files instead of -"),
        ("none.scn --for slurm --into farm", 1, "none.scn"),
        (
            "a.scn --for slurm --into .",
            1,
            "the directory . is not empty; name a new one with --into",
        ),
        (
            "a.scn --for slurm --into a.scn",
            1,
            "cannot make the directory a.scn: `a.scn` is a file, expected a directory",
        ),
    ] {
        let line = format!("job {line}");
        folder.fails(&line.split(' ').collect::<Vec<_>>(), code, words);
    }
    folder.write("a.png", "kept");
    let job = "job a.scn --for slurm --into farm --skip-existing";
    folder.fails(&job.split(' ').collect::<Vec<_>>(), 1, "all pictures exist");
}
