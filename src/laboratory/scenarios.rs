//! The scenarios of the experiments, with the small files that they name: the program carries them within itself and writes them where it runs them.
//!
//! So `floodsim validate` needs no folder of the source. The data themselves, which `${FLOODSIM_DATA}` in a scenario stands for, are not here.

use std::path::Path;

use crate::error::Error;

macro_rules! carried {
    ($($name:literal,)*) => {
        &[$(($name, include_str!(concat!("../../scenarios/", $name)))),*]
    };
}

/// Each file of `scenarios` that an experiment needs: its path there, and what it holds.
#[rustfmt::skip]
const FILES: &[(&str, &str)] = carried![
    "laboratory/big_tujunga.yaml",
    "laboratory/downstream.geojson",
    "laboratory/downstream_6b.geojson",
    "laboratory/ea_test1.yaml",
    "laboratory/ea_test4.yaml",
    "laboratory/ea_test4_gauges.csv",
    "laboratory/ea_test6b.yaml",
    "laboratory/ea_test6b_scaled.yaml",
    "laboratory/isolated_obstacle.yaml",
    "laboratory/marin_box.yaml",
    "laboratory/merewether.yaml",
    "laboratory/merewether_inflow.geojson",
    "laboratory/monai_sea.geojson",
    "laboratory/monai_valley.yaml",
    "laboratory/parma_gauges.csv",
    "laboratory/parma_partial_dam_break.yaml",
    "laboratory/radial_dam_break.yaml",
    "laboratory/radial_gauges.csv",
    "laboratory/rajar_a.asc",
    "laboratory/rajar_a.yaml",
    "laboratory/rajar_a_channel.yaml",
    "laboratory/rajar_a_coupled.yaml",
    "laboratory/rajar_a_middle.asc",
    "laboratory/rajar_a_sections.csv",
    "laboratory/rajar_a_tail.geojson",
    "laboratory/rajar_a_tail_middle.geojson",
    "laboratory/rajar_b.asc",
    "laboratory/rajar_b.yaml",
    "laboratory/rajar_b_channel.yaml",
    "laboratory/rajar_b_coupled.yaml",
    "laboratory/rajar_b_middle.asc",
    "laboratory/rajar_b_sections.csv",
    "laboratory/rajar_b_tail.geojson",
    "laboratory/rajar_b_tail_middle.geojson",
    "laboratory/rajar_reservoir.geojson",
    "malpasset/scenario.yaml",
];

/// Writes the scenarios into a folder, laid out as `scenarios` is.
///
/// # Errors
/// `Error::Output` where one cannot be written.
pub(super) fn write_all(folder: &Path) -> Result<(), Error> {
    for (name, text) in FILES {
        let path = folder.join(name);
        let inside = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        inside
            .and_then(|()| std::fs::write(&path, text))
            .map_err(|cause| Error::Output { path: path.clone(), cause: cause.to_string() })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_file_of_the_laboratory_is_carried() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/laboratory");
        let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let lying: BTreeSet<String> =
            names.filter(|name| name != "README.md").map(|name| format!("laboratory/{name}")).collect();
        let carried: BTreeSet<String> =
            FILES.iter().map(|(name, _)| (*name).to_owned()).filter(|name| name.starts_with("laboratory/")).collect();
        assert_eq!(carried, lying);
        for experiment in super::super::all() {
            assert!(FILES.iter().any(|(name, _)| *name == experiment.scenario), "{}", experiment.name);
        }
    }

    #[test]
    fn they_are_written_as_they_are() {
        let folder = tempfile::tempdir().unwrap();
        write_all(folder.path()).unwrap();
        let of_source = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
        for (name, _) in FILES {
            let written = std::fs::read(folder.path().join(name)).unwrap();
            assert!(written == std::fs::read(of_source.join(name)).unwrap(), "{name}");
        }
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        assert!(matches!(write_all(&file), Err(Error::Output { .. })));
    }
}
