//! Every constant of the methods, a tenth less and a tenth more: what it changes, and that it changes something.
//!
//! Each case returns one number, 0 at best and never that: an error, or how much of the ground or the water a rule takes for what it is
//! not. The table with these numbers, and those at half and twice the value, is written by
//!
//! ```text
//! cargo test --release --locked --test analytic table_of_constants -- --ignored
//! ```
//!
//! and `python3 docs/validation/build.py` makes `docs/validation/sensitivity.md` of it.

#![expect(clippy::unwrap_used, reason = "a case that cannot be made or run is a failed test")]

mod beds;
mod flows;
mod still;

use floodsim::constants::{Constant, Constants};

/// Something made on which constants can be felt.
pub struct Case {
    /// Its name in the table.
    pub name: &'static str,
    /// What it is, and what its number says.
    pub about: &'static str,
    /// The constants that it is run with; names, or the beginning of some.
    pub feels: &'static [&'static str],
    /// The number.
    pub run: fn(&Constants) -> f64,
}

impl Case {
    fn is_of(&self, constant: &Constant) -> bool {
        self.feels.iter().any(|name| is_named(constant, name))
    }
}

/// Whether a name, or the beginning of one that ends with a low line, is that of a constant.
fn is_named(constant: &Constant, name: &str) -> bool {
    constant.name == name || name.ends_with('_') && constant.name.starts_with(name)
}

fn cases() -> impl Iterator<Item = &'static Case> {
    [flows::CASES, beds::CASES, still::CASES].into_iter().flatten()
}

/// A tenth less of a constant that enters to the second power, as a threshold of heights enters a volume, makes a number 0.81 times as large: a
/// factor of 1.235, and a hundredth more for what is made of a finite number of cells. More says that a method stands on the value of one number.
/// A tenth that leaves the range of a constant may break more.
const MOST: f64 = 1.01 / (0.9 * 0.9);
/// The same for one more of two, the fewest that a whole number is.
const MOST_OF_WHOLE: f64 = 1.5 * 1.5;

/// A case with a constant varied: by how much its number differs, as a factor of 1 or more.
fn factor(number: f64, as_it_is: f64) -> f64 {
    (number / as_it_is).max(as_it_is / number)
}

#[test]
fn no_result_stands_on_a_tenth_of_a_constant_and_none_does_nothing() {
    let is_known = |name: &&str| Constants::all().any(|constant| is_named(constant, name));
    assert!(cases().flat_map(|case| case.feels).all(is_known), "a case feels what is no constant");
    let as_they_are: Vec<f64> = cases().map(|case| (case.run)(&Constants::DEFAULT)).collect();
    let mut wrong = Vec::new();
    for constant in Constants::all() {
        let mut acts = false;
        for (case, &as_it_is) in cases().zip(&as_they_are).filter(|(case, _)| case.is_of(constant)) {
            for by in [0.9, 1.1] {
                let number = (case.run)(&constant.times(by));
                let found = factor(number, as_it_is);
                acts |= found > 1.0 + 1e-9;
                let is_sensible = (constant.range.0..=constant.range.1).contains(&constant.of(&constant.times(by)));
                // False for not-a-number.
                let is_kept = found <= if constant.is_whole { MOST_OF_WHOLE } else { MOST };
                if is_sensible && !is_kept {
                    wrong.push(format!("{} times {by}: {} {as_it_is} to {number}", constant.name, case.name));
                }
            }
        }
        if !acts {
            wrong.push(format!("{} does nothing", constant.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[ignore = "writes docs/validation/sensitivity.csv"]
fn table_of_constants() {
    const COLUMNS: &str =
        "constant,value,unit,what,source,low,high,outside,case,about,as it is,half,tenth less,tenth more,double";
    let mut lines = vec![COLUMNS.to_owned()];
    for constant in Constants::all() {
        let Constant { name, unit, what, source, range: (low, high), outside, .. } = constant;
        let value = constant.of(&Constants::DEFAULT);
        for Case { name: case, about, run, .. } in cases().filter(|case| case.is_of(constant)) {
            let as_it_is = run(&Constants::DEFAULT);
            let [half, less, more, double] = [0.5, 0.9, 1.1, 2.0].map(|by| run(&constant.times(by)));
            let numbers = [as_it_is, half, less, more, double].map(|number| format!("{number:.6e}")).join(",");
            let of_constant = format!("{name},{value},{unit},\"{what}\",\"{source}\",{low},{high},\"{outside}\"");
            lines.push(format!("{of_constant},\"{case}\",\"{about}\",{numbers}"));
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/validation/sensitivity.csv");
    std::fs::write(path, lines.join("\n") + "\n").unwrap();
}
