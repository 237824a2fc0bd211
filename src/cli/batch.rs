//! Which pictures a call of `octray render` makes: of each scene one, or those of a turntable.

use super::{
    CliError,
    aov_files::AovFiles,
    args::RenderArgs,
    compare::{Comparison, Verdict},
    memory::PixelBytes,
    names,
    output::Output,
    turntable::Frames,
};
use std::{
    collections::{HashMap, hash_map::Entry},
    io::{self, Write},
    path::{Path, PathBuf},
};

/// The pictures of one scene.
#[derive(Debug)]
pub struct Job<'a> {
    pub scene: &'a Path,
    pub shots: Vec<Shot>,
}

impl Job<'_> {
    /// What a pixel takes of the picture that takes most.
    pub fn pixel_bytes(&self, args: &RenderArgs) -> PixelBytes {
        let exr = self.shots.iter().any(|shot| shot.output.is_linear());
        PixelBytes {
            film: match (args.picture.transparent(), exr || args.picture.srgb) {
                (true, _) => 16,
                (false, true) => 12,
                (false, false) => 3,
            },
            exr,
            aovs: !args.picture.aovs.is_empty(),
            compared: args.comparison.compare.is_some(),
        }
    }
}

/// One picture.
#[derive(Debug)]
pub struct Shot {
    pub output: Output,
    /// What else is told of its pixels.
    pub aovs: AovFiles,
    /// Its number in a turntable, and how many pictures that has.
    pub turn: Option<(u32, u32)>,
    pub comparison: Option<Comparison>,
}

/// Names and checks all pictures, before anything is loaded. Those that --skip-existing leaves out are not among them,
/// nor scenes of which none is left.
///
/// # Errors
/// [`CliError`]: names that cannot be, or two pictures of one name.
pub fn plan(args: &RenderArgs, size: (u32, u32)) -> Result<Vec<Job<'_>>, CliError> {
    let mut places = Places::default();
    let mut jobs = Vec::new();
    for scene in &args.scenes {
        let mut shots = Vec::new();
        for turn in turns(args) {
            let shot = shot(args, size, scene, turn, &mut places)?;
            let skipped = args.series.skip_existing && shot.output.exists();
            if !skipped {
                shots.push(shot);
            }
        }
        if !shots.is_empty() {
            jobs.push(Job { scene, shots });
        }
    }
    Ok(jobs)
}

fn turns(args: &RenderArgs) -> Vec<Option<(u32, u32)>> {
    let Some(count) = args.series.turntable else {
        return vec![None];
    };
    let Frames { first, last } = args.series.frames.unwrap_or(Frames {
        first: 1,
        last: count,
    });
    (first..=last).map(|number| Some((number, count))).collect()
}

fn shot(
    args: &RenderArgs,
    (width, height): (u32, u32),
    scene: &Path,
    turn: Option<(u32, u32)>,
    places: &mut Places,
) -> Result<Shot, CliError> {
    let number = turn.map(|(number, _)| number);
    if let (Some((number, count)), Some(frames)) = (turn, args.series.frames)
        && number > count
    {
        return Err(CliError::Usage(format!(
            "--frames {}-{}: the turntable has {count} pictures, expected numbers from 1 to {count}",
            frames.first, frames.last
        )));
    }
    let stem = names::stem(scene);
    let name = |pattern: &Path| names::expand(pattern, stem, number);
    let default = if turn.is_some() {
        "{stem}-####.png"
    } else {
        "{stem}.png"
    };
    let path = name(args.output.as_deref().unwrap_or(Path::new(default)));
    let output = Output::prepare(&path, scene, width, height)?;
    output.check(&args.picture)?;
    places.claim(&output, scene, turn.is_some())?;
    let aovs = AovFiles::prepare(&args.picture, &output, &path, scene, [width, height])?;
    for file in aovs.files() {
        places.claim(file, scene, turn.is_some())?;
    }

    let mut comparison = None;
    if let Some(reference) = &args.comparison.compare {
        let difference = match &args.comparison.difference {
            Some(pattern) => name(pattern),
            None if output.is_file() => names::beside(&path, "-difference", "png"),
            None => names::beside(&name(Path::new(default)), "-difference", "png"),
        };
        let difference = Output::prepare(&difference, scene, width, height)?;
        places.claim(&difference, scene, turn.is_some())?;
        let prepared = Comparison::prepare(&args.comparison, name(reference), difference, (width, height))?;
        for output in [&output, &prepared.output] {
            if prepared.would_replace_reference(output) {
                return Err(CliError::Usage(format!(
                    "{} would replace the reference",
                    output.name()
                )));
            }
        }
        comparison = Some(prepared);
    }
    Ok(Shot {
        output,
        aovs,
        turn,
        comparison,
    })
}

/// What each place will hold.
#[derive(Default)]
struct Places(HashMap<PathBuf, PathBuf>);

impl Places {
    fn claim(&mut self, output: &Output, scene: &Path, turning: bool) -> Result<(), CliError> {
        let first = match self.0.entry(output.place().to_owned()) {
            Entry::Vacant(place) => {
                place.insert(scene.to_owned());
                return Ok(());
            }
            Entry::Occupied(place) => place.get().clone(),
        };
        let name = output.name();
        Err(CliError::Usage(if first != scene {
            format!(
                "{} and {} would both be written to {name}; {{stem}} in a name stands for the scene's own, without \
                 folder and extension",
                first.display(),
                scene.display()
            )
        } else if turning {
            format!(
                "several pictures would be written to {name}; give it a run of # for their numbers, as in a-####.png"
            )
        } else {
            format!("{} would be written to {name} twice", scene.display())
        }))
    }
}

/// What the comparisons of all pictures found.
#[derive(Default)]
pub struct Verdicts {
    compared: usize,
    differing: Vec<String>,
}

impl Verdicts {
    /// Notes what was found, and tells it if it is good.
    pub fn add(&mut self, verdict: Verdict, quiet: bool) {
        self.compared += 1;
        if !verdict.agrees {
            self.differing.push(verdict.text);
        } else if !quiet {
            // The picture is written: that nobody reads standard error is no failure.
            let _ = writeln!(io::stderr(), "octray: {}", verdict.text);
        }
    }

    /// # Errors
    /// [`CliError::Differs`], with a line for each picture that does.
    pub fn finish(self) -> Result<(), CliError> {
        match self.differing.len() {
            0 => Ok(()),
            1 if self.compared == 1 => Err(CliError::Differs(self.differing.join("\n"))),
            many => Err(CliError::Differs(format!(
                "{many} of {} pictures differ from their references\n  {}",
                self.compared,
                self.differing.join("\n  ")
            ))),
        }
    }
}
