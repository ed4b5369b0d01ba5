//! Which methods a run takes: members of families, written as the keys of `numerics:` in a scenario.
//!
//! The scenario's own reader fills in the defaults and refuses what does not exist, so that both say the same.

use std::path::Path;

use crate::error::{Error, Problem};
use crate::scenario::methods::Motion;
use crate::scenario::{Numerics, resolve};

/// The family by which runs are told apart unless the user says otherwise.
const MOTION: &str = "motion";
/// The family whose members name a motion of their own.
const PRESET: &str = "preset";
/// Keys of `numerics:` that belong to the cases: each brings its bed and its particles.
const FIXED: [&str; 3] = ["gravity", "bed", "seeding"];

/// A family and the members that are to be tried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Varied {
    /// The key, such as `motion`.
    pub family: String,
    /// Its values.
    pub members: Vec<String>,
}

impl Varied {
    /// Reads `family=a,b,c`.
    ///
    /// # Errors
    /// A message for the user.
    pub fn read(text: &str) -> Result<Varied, String> {
        let (family, members) = text.split_once('=').ok_or(format!("`{text}` is not of the form family=a,b,c"))?;
        let members: Vec<String> = members.split(',').map(|member| member.trim().to_owned()).collect();
        if members.iter().any(String::is_empty) {
            return Err(format!("`{text}` names an empty member"));
        }
        Ok(Varied { family: family.trim().to_owned(), members })
    }
}

/// The methods of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// All of them.
    pub numerics: Numerics,
    /// What was asked for, as family and member; the rest are defaults.
    pub given: Vec<(String, String)>,
    /// Whether they are the defaults of their motion.
    pub is_default: bool,
}

impl Choice {
    /// The entries whose family has no column in a row, each as `cfl 0.8`.
    pub fn without_column(&self) -> impl Iterator<Item = String> + '_ {
        let columns = ["formulation", "motion", "kernel", "stabilisation", "integrator"];
        let given = self.given.iter().filter(move |(family, _)| !columns.contains(&family.as_str()));
        given.map(|(family, member)| format!("{family} {member}"))
    }

    /// The methods of `numerics:` with the given entries.
    ///
    /// # Errors
    /// `Error::Problems` as for a scenario, `Error::Usage` for an unknown family.
    pub fn new(given: &[(&str, &str)]) -> Result<Choice, Error> {
        if let Some((family, _)) = given.iter().find(|(family, _)| FIXED.contains(family)) {
            return Err(Error::Usage(format!("`{family}` is given by the cases")));
        }
        let numerics = numerics(given)?;
        let of_motion = numerics_of_motion(numerics.motion)?;
        let is_default = numerics == of_motion;
        let given = given.iter().map(|(family, member)| ((*family).to_owned(), (*member).to_owned())).collect();
        Ok(Choice { numerics, given, is_default })
    }

    /// The dry depth (m), when it was asked for.
    pub fn dry_depth(&self) -> Option<f64> {
        self.given.iter().any(|(family, _)| family == "dry_depth").then_some(self.numerics.dry_depth)
    }

    /// The members that were asked for, in one line: `lagrangian, heun`.
    pub fn label(&self) -> String {
        let named = |(family, member): &(String, String)| {
            if member.starts_with(|c: char| c.is_alphabetic()) { member.clone() } else { format!("{family} {member}") }
        };
        self.given.iter().map(named).collect::<Vec<_>>().join(", ")
    }
}

fn numerics_of_motion(motion: Motion) -> Result<Numerics, Error> {
    numerics(&[(MOTION, motion.name())])
}

fn numerics(given: &[(&str, &str)]) -> Result<Numerics, Error> {
    const SCENARIO: &str = "floodsim: 1
title: methods
crs: local
terrain: {layers: [{raster: none.tif}]}
initial: [{reservoir: none.geojson, level: 1 m}]
roughness: {manning: 0.03}
resolution: 1 m
time: {end: 1 s}
";
    let overrides: Vec<String> = given.iter().map(|(key, value)| format!("numerics.{key}={value}")).collect();
    let numerics = resolve(SCENARIO, Path::new("methods.yaml"), &overrides)?.scenario.numerics;
    // Water at rest is to be seen at rest.
    Ok(Numerics { sleeps: false, ..numerics })
}

/// Every combination of the members that exists, and a line on each one that does not.
///
/// Both motions are taken unless `motion` is among the families, or `preset`, which names one; a combination that only this would make impossible is no news.
///
/// # Errors
/// `Error::Usage` for an unknown family or member, with the nearest name, and when nothing is left.
pub fn choices(varied: &[Varied]) -> Result<(Vec<Choice>, Vec<String>), Error> {
    let mut families = varied.to_vec();
    let is_motion_implied = !families.iter().any(|varied| [MOTION, PRESET].contains(&varied.family.as_str()));
    if is_motion_implied {
        let members = Motion::ALL.iter().map(|motion| motion.name().to_owned()).collect();
        families.insert(0, Varied { family: MOTION.to_owned(), members });
    }
    let (mut found, mut refused) = (Vec::<Choice>::new(), Vec::new());
    let combinations: usize = families.iter().map(|family| family.members.len()).product();
    for number in 0..combinations {
        let mut rest = number;
        // The first family varies slowest.
        let mut given: Vec<(&str, &str)> = families
            .iter()
            .rev()
            .map(|varied| {
                let member = &varied.members[rest % varied.members.len()];
                rest /= varied.members.len();
                (varied.family.as_str(), member.as_str())
            })
            .collect();
        given.reverse();
        match Choice::new(&given) {
            Ok(choice) => {
                if !found.iter().any(|other| other.numerics == choice.numerics) {
                    found.push(choice);
                }
            }
            // A refused scenario lists its missing files as well, which are of no interest here.
            Err(Error::Problems(mut problems)) => {
                problems.retain(|problem| problem.key.starts_with("numerics"));
                let (what, why) = (words(&given), first_message(&problems));
                if problems.iter().all(|problem| problem.code == "method-combination") {
                    refused.push(format!("{what}: {why}"));
                } else {
                    let remedy = problems.first().and_then(|p| p.remedy.clone()).unwrap_or_default();
                    return Err(Error::Usage(format!("--vary {what}: {why}; {remedy}")));
                }
            }
            Err(Error::Usage(message)) => return Err(Error::Usage(message.replace("--set numerics.", "--vary "))),
            Err(other) => return Err(other),
        }
    }
    if found.is_empty() {
        return Err(Error::Usage(format!("no such combination of methods:\n{}", refused.join("\n"))));
    }
    if is_motion_implied {
        refused.clear();
    }
    Ok((found, refused))
}

fn first_message(problems: &[Problem]) -> String {
    problems.first().map(|problem| problem.message.clone()).unwrap_or_default()
}

fn words(given: &[(&str, &str)]) -> String {
    given.iter().map(|(family, member)| format!("{family}={member}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choices_of(texts: &[&str]) -> Result<(Vec<Choice>, Vec<String>), Error> {
        choices(&texts.iter().map(|text| Varied::read(text).unwrap()).collect::<Vec<_>>())
    }

    #[test]
    fn both_motions_are_the_default() {
        let (found, _) = choices_of(&[]).unwrap();
        assert_eq!(found.iter().map(|c| c.numerics.motion).collect::<Vec<_>>(), Motion::ALL);
        assert!(found.iter().all(|choice| choice.is_default));
    }

    #[test]
    fn what_does_not_exist_is_left_out() {
        let (found, refused) = choices_of(&["formulation=balanced,variational"]).unwrap();
        assert_eq!((found.len(), refused.len()), (3, 0));
        assert!(!found[2].is_default);
        let (found, refused) = choices_of(&["motion=eulerian,lagrangian", "turbulence=mixing_length"]).unwrap();
        assert_eq!((found.len(), refused.len()), (1, 1));
        assert_eq!(found[0].label(), "eulerian, mixing_length");
        assert!(choices_of(&["motion=eulerian", "integrator=leapfrog"]).is_err());
    }

    #[test]
    fn wrong_names_are_usage_errors_with_the_nearest_name() {
        for (text, near) in [("kernl=cubic_spline", "kernel"), ("kernel=cubic_splin", "cubic_spline")] {
            let Err(Error::Usage(message)) = choices_of(&[text]) else { panic!("{text} is not refused") };
            assert!(message.contains(&format!("did you mean `{near}`?")), "{message}");
        }
        assert!(Varied::read("kernel").is_err() && Varied::read("kernel=a,,b").is_err());
        assert!(matches!(choices_of(&["gravity=1.6"]), Err(Error::Usage(_))));
    }

    #[test]
    fn presets_bring_their_own_motion() {
        let (found, refused) = choices_of(&["preset=fast,balanced,accurate"]).unwrap();
        assert_eq!(found.iter().map(Choice::label).collect::<Vec<_>>(), ["fast", "balanced", "accurate"]);
        assert!(refused.is_empty() && found.iter().all(|choice| choice.numerics.motion == Motion::Eulerian));
        assert_eq!(found.iter().map(|choice| choice.is_default).collect::<Vec<_>>(), [false, true, false]);
    }

    #[test]
    fn numbers_can_be_varied_too() {
        let (found, _) = choices_of(&["cfl=0.2,0.5", "motion=lagrangian"]).unwrap();
        assert_eq!(found.iter().map(Choice::label).collect::<Vec<_>>(), ["cfl 0.2, lagrangian", "cfl 0.5, lagrangian"]);
        assert!(found[1].is_default && !found[0].is_default);
    }
}
