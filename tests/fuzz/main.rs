//! Inputs that are changed at random (`cargo fuzz-inputs`): whatever they are, a run of the program ends with a documented exit code.
//!
//! Each case is made from sound inputs, a seed and its number, and runs the program as a process, so that crashes of the libraries
//! for rasters and NetCDF are seen, too. `FLOODSIM_FUZZ_CASES` is the number of cases of each target, `FLOODSIM_FUZZ_SEED` the seed and
//! `FLOODSIM_FUZZ_FIRST` the number of the first case. The inputs of a case that fails are kept in a folder that the test names.
#![allow(clippy::unwrap_used, reason = "a test that cannot set up its files has failed")]

mod binary;
mod judge;
mod mutate;
mod random;
mod scene;
mod sound;
mod texts;
mod words;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use tempfile::TempDir;

use random::Random;
use scene::SCENE;

/// What of the inputs is changed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    Scenarios,
    Tables,
    Vectors,
    Rasters,
    Netcdf,
}

/// Bytes at the beginning of a file of numbers that say what it is.
const HEAD: usize = 600;

impl Target {
    /// How the names of the files end that are changed.
    fn ends(self) -> &'static [&'static str] {
        match self {
            Target::Scenarios => &[],
            Target::Tables => &[".csv", ".xyz"],
            Target::Vectors => &[".geojson", ".gpkg", ".shp", ".shx", ".dbf"],
            Target::Rasters => &[".asc", ".tif"],
            Target::Netcdf => &[".nc"],
        }
    }

    fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// Inputs of which one file is changed.
struct Case {
    /// The scenario that was taken, and the file that was changed.
    from: String,
    scenario: Vec<u8>,
    changed: Option<(String, Vec<u8>)>,
}

impl Case {
    fn of(target: Target, seed: u64, number: usize) -> Case {
        let random = &mut Random::of(seed ^ (target as u64) << 32, number);
        if target == Target::Scenarios {
            let (name, scenario) = &SCENE.scenarios[random.below(SCENE.scenarios.len())];
            let others: Vec<&str> = SCENE.scenarios.iter().map(|(_, text)| text.as_str()).collect();
            return Case { from: name.clone(), scenario: mutate::scenario(random, scenario, &others), changed: None };
        }
        let named = |(name, text): &'static (String, String)| {
            SCENE.named_in(text, target.ends()).into_iter().map(move |file| (name, text, file))
        };
        let pairs: Vec<_> = SCENE.scenarios.iter().flat_map(named).collect();
        let (name, scenario, file) = pairs[random.below(pairs.len())];
        let content = &SCENE.files[file];
        let is_text = [".csv", ".xyz", ".geojson", ".asc"].iter().any(|end| file.ends_with(end));
        let content = if is_text { mutate::table(random, content) } else { mutate::bytes(random, content, HEAD) };
        Case {
            from: format!("{name}, {file}"),
            scenario: scenario.clone().into_bytes(),
            changed: Some((file.to_owned(), content)),
        }
    }

    fn write(&self, folder: &Path) {
        SCENE.write(folder);
        std::fs::write(folder.join("s.yaml"), &self.scenario).unwrap();
        if let Some((name, content)) = &self.changed {
            std::fs::write(folder.join(name), content).unwrap();
        }
    }
}

/// A number from the environment.
fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is not a whole number")))
}

/// The seed, and the numbers of the cases, of which there are so many where nothing else is said.
fn settings(cases: u64) -> (u64, std::ops::Range<usize>) {
    let first = setting("FLOODSIM_FUZZ_FIRST").unwrap_or(0) as usize;
    let cases = setting("FLOODSIM_FUZZ_CASES").unwrap_or(cases) as usize;
    (setting("FLOODSIM_FUZZ_SEED").unwrap_or(1), first..first + cases)
}

/// Keeps the inputs of a case that failed; the folder that they are in.
fn keep(case: &Case, name: &str, said: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    case.write(&folder);
    std::fs::write(folder.join("stderr"), said).unwrap();
    folder
}

/// Runs the cases of a target; fails where one of them ends otherwise than documented.
fn assert_bears(target: Target, cases: u64) {
    let (seed, numbers) = settings(cases);
    let (start, mut codes, mut faults) = (Instant::now(), BTreeMap::<String, usize>::new(), Vec::new());
    for number in numbers.clone() {
        let case = Case::of(target, seed, number);
        let folder = TempDir::new().unwrap();
        case.write(folder.path());
        let ended = judge::run(folder.path(), "out");
        *codes.entry(ended.code.map_or("signal".to_owned(), |code| code.to_string())).or_default() += 1;
        let name = format!("{}-{seed}-{number}", target.name());
        if let Some(fault) = judge::fault(&ended, &folder.path().join("out")) {
            let kept = keep(&case, &name, &ended.said);
            println!("{name} ({}): {fault}; kept in {}", case.from, kept.display());
            faults.push(name);
        } else if matches!(ended.code, Some(6..=8)) {
            println!("{name} ({}): exit code {:?}", case.from, ended.code);
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{target:?}: {} cases of seed {seed} in {seconds:.0} s, exit codes {codes:?}", numbers.len());
    assert!(faults.is_empty(), "not as documented: {faults:?}");
}

#[test]
fn scenarios() {
    assert_bears(Target::Scenarios, 60);
}

#[test]
fn tables() {
    assert_bears(Target::Tables, 30);
}

#[test]
fn vectors() {
    assert_bears(Target::Vectors, 30);
}

#[test]
fn rasters() {
    assert_bears(Target::Rasters, 30);
}

#[test]
fn netcdf_files() {
    assert_bears(Target::Netcdf, 30);
}
