//! The cases, one file per family.

pub mod bowls;
pub mod circles;
pub mod dam_breaks;
pub mod lakes;
pub mod open_channels;
pub mod slopes;
pub mod stability;
pub mod steady;

use super::case::{Case, Suite};

/// Every case, in the order of tables.
pub fn all() -> impl Iterator<Item = &'static Case> {
    [dam_breaks::CASES, circles::CASES, lakes::CASES, bowls::CASES, steady::CASES, slopes::CASES, open_channels::CASES]
        .into_iter()
        .chain(stability::FAMILIES.iter().copied())
        .flatten()
}

/// The cases of a suite.
pub fn of_suite(suite: Suite) -> impl Iterator<Item = &'static Case> {
    all().filter(move |case| case.suite == suite)
}

/// The case of a name.
pub fn named(name: &str) -> Option<&'static Case> {
    all().find(|case| case.name == name)
}

/// The case of a name, and those that belong to it: the same scene in a plane of many rows is named after it.
pub fn with_companions(name: &str) -> impl Iterator<Item = &'static Case> {
    let companion = format!("{name}_plane");
    named(name).into_iter().chain(named(&companion))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::methods::Core;

    #[test]
    fn every_case_is_complete() {
        let mut names: Vec<&str> = all().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all().count(), "names are not unique");
        for case in all() {
            let least = if case.suite == Suite::Analytic { 3 } else { 1 };
            assert!(case.spacings.len() >= least && case.tested >= 1, "{}: too few spacings", case.name);
            assert!(case.spacings.windows(2).all(|pair| pair[0] > pair[1]), "{}: the coarsest comes first", case.name);
            assert!(case.about.ends_with('.'), "{}: not a sentence", case.name);
            for spacing in case.acceptance_limits.iter().filter_map(|acceptance_limit| acceptance_limit.spacing) {
                assert!(
                    case.spacings.iter().any(|s| (s / spacing - 1.0).abs() < 1e-9),
                    "{}: acceptance limit at {spacing}",
                    case.name
                );
            }
        }
    }

    #[test]
    fn every_setup_holds_the_same_water_for_cells_and_particles() {
        for case in all() {
            let volume = |core: Core| {
                let setup = (case.setup)(case.spacings[0], core).ok()?;
                let lattice = &setup.problem.bed.lattice;
                Some(match core {
                    Core::Variational => setup.seeds.iter().map(|seed| seed.volume).sum::<f64>(),
                    Core::Eulerian | Core::Lagrangian => {
                        let area = if lattice.rows == 1 { lattice.spacing } else { lattice.cell_area() };
                        setup.problem.initial_depth.iter().sum::<f64>() * area
                    }
                })
            };
            let (Some(cells), Some(particles)) = (volume(Core::Eulerian), volume(Core::Variational)) else {
                continue;
            };
            // Curved shores are cut by the lattice in different ways.
            assert!((cells - particles).abs() <= 0.05 * cells, "{}: {cells} and {particles} m3", case.name);
        }
    }
}
