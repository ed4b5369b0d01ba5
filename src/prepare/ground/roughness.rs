//! Roughness of the ground: one n everywhere, a raster of n, a raster of classes with their table, and polygons on top.
//!
//! A raster is read by the cell that holds the place, never between cells: a class has no neighbours that it could be mixed with.

use geo::MultiPolygon;

use crate::error::{Problem, ProblemKind, input_error};
use crate::geodata::{Crs, Table, read_text, readable_file};
use crate::lattice::Lattice;
use crate::math::Vec2;
use crate::prepare::findings::Findings;
use crate::prepare::polygons::{ValuedArea, cells_inside};
use crate::prepare::{places, water};
use crate::scenario::{Roughness, Scenario, Sourced, VectorSource};
use crate::terrain::{Placing, Raster};

/// Greatest n (s·m^(−1/3)): beyond it a value is something else.
const GREATEST: f64 = 0.5;
/// Names of the attribute and of the column that hold n.
const NAMES: [&str; 3] = ["n", "manning", "manning_n"];
/// Classes are numbers; two that are nearer than this are one.
const SAME_CLASS: f64 = 1e-6;
/// So many classes without a value are named.
const NAMED: usize = 12;

/// What could be opened; map coordinates.
#[derive(Debug, Default)]
pub struct Opened {
    raster: Option<(Raster, Option<Placing>)>,
    /// Of each class its n; none where the raster holds n itself.
    table: Option<Vec<(f64, f64)>>,
    /// Areas and their n, later ones on top.
    areas: Vec<ValuedArea>,
}

/// Opens every file of the roughness.
pub fn open(scenario: &Scenario, crs: Option<&Crs>, findings: &mut Findings) -> Opened {
    let roughness = &scenario.roughness;
    let read = |file| crate::prepare::raster::read_in_place(file, scenario, crs, findings);
    let raster = roughness.raster.as_ref().and_then(read);
    let table = roughness.table.as_ref().and_then(|file| findings.take(file, table(file)));
    let areas = roughness.polygons.as_ref().map_or_else(Vec::new, |file| areas(file, crs, scenario, findings));
    Opened { raster, table, areas }
}

/// Whether a value can be a Manning roughness (s·m^(−1/3)).
fn is_sound(n: f64) -> bool {
    n > 0.0 && n <= GREATEST
}

/// The n of each class of a CSV file with the columns `class` and `n`.
fn table(file: &Sourced<std::path::PathBuf>) -> Result<Vec<(f64, f64)>, Problem> {
    let path = &file.value;
    let name = path.display();
    readable_file(path)?;
    let text = read_text(path).map_err(|error| {
        input_error("not-a-table", format!("{name} is no table of classes"))
            .with_cause(error.to_string())
            .with_remedy("name a CSV file with the columns class,name,n")
    })?;
    let table = Table::parse(&text, |_| true);
    let column = |names: &[&str]| {
        table.column(names).ok_or_else(|| {
            let columns = table.header.clone().unwrap_or_default().join(", ");
            input_error("missing-column", format!("{name} has no column `{}`", names[0]))
                .with_cause(format!("its columns are {columns}"))
                .with_remedy("give it a first line with the names class,name,n")
        })
    };
    let (class, n) = (column(&["class", "code", "value"])?, column(&NAMES)?);
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (line, fields) in &table.rows {
        let number = |column: usize| fields.get(column).and_then(|f| f.parse::<f64>().ok()).filter(|v| v.is_finite());
        let bad = |code, message: String, remedy: &str| {
            let cause = format!("it reads `{}`", fields.join(","));
            Err(input_error(code, message).with_cause(cause).with_remedy(remedy))
        };
        let (Some(class), Some(n)) = (number(class), number(n)) else {
            let message = format!("line {line} of {name} does not give a class and its n as two numbers");
            return bad("not-a-number", message, "write numbers with a point as decimal sign");
        };
        if !is_sound(n) {
            let message = format!("line {line} of {name} gives the class {class} a roughness of {n} s/m^(1/3)");
            return bad("roughness-range", message, "give a Manning roughness above 0, and at most 0.5");
        }
        if found.iter().any(|(other, _)| (other - class).abs() < SAME_CLASS) {
            let message = format!("line {line} of {name} gives the class {class} once more");
            return bad("duplicate-class", message, "keep one line for each class");
        }
        found.push((class, n));
    }
    Ok(found)
}

/// The areas of a polygon file and the n of each.
fn areas(
    file: &Sourced<VectorSource>,
    crs: Option<&Crs>,
    scenario: &Scenario,
    findings: &mut Findings,
) -> Vec<ValuedArea> {
    let name = file.value.path.display();
    let Some(features) = places::features_near(file, crs, scenario, findings) else { return Vec::new() };
    let mut found = Vec::new();
    findings.add_all(file, places::left_out(file, &features, "polygon", |feature| !feature.polygons.is_empty()));
    for feature in features.into_iter().filter(|feature| !feature.polygons.is_empty()) {
        let is_usable =
            feature.polygons.iter().all(|polygon| water::check_polygon(file, feature.number, polygon, findings));
        match NAMES.iter().find_map(|name| feature.number(name)) {
            Some(n) if is_sound(n) => {
                found.extend(is_usable.then(|| ValuedArea { area: MultiPolygon::new(feature.polygons), value: n }))
            }
            Some(n) => {
                let message = format!("polygon {} of {name} has a roughness of {n} s/m^(1/3)", feature.number);
                let remedy = "give a Manning roughness above 0, and at most 0.5";
                findings.add(file, input_error("roughness-range", message).with_remedy(remedy));
            }
            None => {
                let message = format!("polygon {} of {name} has no roughness", feature.number);
                let remedy = "give it an attribute `n` with its Manning roughness";
                let cause = format!("its attributes: {}", feature.attribute_names());
                findings.add(file, input_error("no-roughness", message).with_cause(cause).with_remedy(remedy));
            }
        }
    }
    if found.is_empty() && !findings.has_errors_of(&file.key) {
        let problem = input_error("empty-polygon", format!("{name} holds no polygon"));
        findings.add(file, problem.with_remedy("draw areas with an attribute `n`, or take the key away"));
    }
    found
}

/// n (s·m^(−1/3)) at every cell; `bed` is its elevation, NaN without terrain. What has none is listed with its area.
pub fn on_lattice(
    opened: &Opened,
    roughness: &Roughness,
    lattice: &Lattice,
    bed: &[f64],
    findings: &mut Findings,
) -> Vec<f64> {
    let mut values = vec![roughness.manning.unwrap_or(f64::NAN); lattice.len()];
    let mut missing = Missing::default();
    let mut outside: Option<(usize, f64)> = None;
    for (cell, value) in values_of_raster(opened, roughness, lattice, findings).into_iter().enumerate() {
        match opened.of_value(value) {
            Some(found) if !is_sound(found) => {
                outside.get_or_insert((cell, found));
            }
            Some(found) => values[cell] = found,
            None if !bed[cell].is_nan() => missing.add(value, cell),
            None => {}
        }
    }
    let mut is_beside = !opened.areas.is_empty();
    for ValuedArea { area, value: n } in &opened.areas {
        for cell in cells_inside(area, lattice) {
            values[cell] = *n;
            missing.take(cell);
            is_beside = false;
        }
    }
    if let Some(file) = roughness.polygons.as_ref().filter(|_| is_beside) {
        let message = format!("no cell of the terrain lies in the polygons of {}", file.value.path.display());
        let problem = input_error("outside-terrain", message);
        findings.add(file, problem.with_remedy("check that the file and the terrain have the same CRS"));
    }
    if let Some(file) = &roughness.raster {
        let name = file.value.display();
        if let Some((cell, n)) = outside {
            let message = format!("{name} holds a roughness of {n} s/m^(1/3)");
            let problem = input_error("roughness-range", message)
                .with_cause("a Manning roughness lies above 0 and is at most 0.5")
                .with_remedy("correct it; a raster of classes needs `table: FILE.csv` with the columns class,name,n")
                .with_at(lattice.to_map(lattice.centre(cell)));
            findings.add(file, problem);
        }
        findings.add_all(file, missing.problem(roughness, &name.to_string(), lattice));
    }
    // What is not known was reported as an error, and stops the run.
    values.into_iter().map(|n| if n.is_nan() { 0.0 } else { roughness.factor * n }).collect()
}

/// The value of the raster at every cell, NaN for no data; empty without a raster, or without the table of its classes.
fn values_of_raster(opened: &Opened, roughness: &Roughness, lattice: &Lattice, findings: &mut Findings) -> Vec<f64> {
    let is_complete = roughness.table.is_some() == opened.table.is_some();
    let found = opened.raster.as_ref().zip(roughness.raster.as_ref()).filter(|_| is_complete);
    let Some(((raster, placing), file)) = found else { return Vec::new() };
    let mut places: Vec<Vec2> = (0..lattice.len()).map(|cell| lattice.to_map(lattice.centre(cell))).collect();
    let result = placing.as_ref().map_or(Ok(()), |placing| placing.apply(&mut places, &file.value));
    if findings.take(file, result).is_none() {
        return Vec::new();
    }
    let at = |place| raster.cell_at(place).map_or(f64::NAN, |(column, row)| raster.value(column, row));
    places.into_iter().map(at).collect()
}

impl Opened {
    /// n (s·m^(−1/3)) of a value of the raster: that of its class where there is a table.
    fn of_value(&self, value: f64) -> Option<f64> {
        match &self.table {
            Some(table) => table.iter().find(|(class, _)| (class - value).abs() < SAME_CLASS).map(|(_, n)| *n),
            None => (!value.is_nan()).then_some(value),
        }
    }
}

/// Cells with terrain that have no n: the value of the raster there, NaN for no data, and their numbers.
#[derive(Debug, Default)]
struct Missing {
    classes: Vec<(f64, Vec<usize>)>,
}

impl Missing {
    fn add(&mut self, value: f64, cell: usize) {
        let is_it = |class: f64| (class.is_nan() && value.is_nan()) || (class - value).abs() < SAME_CLASS;
        match self.classes.iter_mut().find(|(class, _)| is_it(*class)) {
            Some((_, cells)) => cells.push(cell),
            None => self.classes.push((value, vec![cell])),
        }
    }

    /// A cell got its n from somewhere else. The cells of a class rise.
    fn take(&mut self, cell: usize) {
        for (_, cells) in &mut self.classes {
            if let Ok(index) = cells.binary_search(&cell) {
                cells.remove(index);
            }
        }
    }

    /// All of it in one problem: an error without a default, a warning with one.
    fn problem(mut self, roughness: &Roughness, name: &str, lattice: &Lattice) -> Option<Problem> {
        self.classes.retain(|(_, cells)| !cells.is_empty());
        self.classes.sort_by(|a, b| b.1.len().cmp(&a.1.len()).then(a.0.total_cmp(&b.0)));
        let first = self.classes.first()?.1[0];
        let one = |(class, cells): &(f64, Vec<usize>)| {
            let what = if class.is_nan() { "no data".to_owned() } else { format!("class {class}") };
            format!("{what} ({})", area(cells.len() as f64 * lattice.cell_area()))
        };
        let mut list = self.classes.iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ");
        if self.classes.len() > NAMED {
            list += &format!(" and {} more", self.classes.len() - NAMED);
        }
        let at = lattice.to_map(lattice.centre(first));
        Some(match roughness.manning {
            Some(n) => {
                let message =
                    format!("the default roughness of {n} s/m^(1/3) is taken where {name} gives none: {list}");
                Problem::warning(ProblemKind::Input, "roughness-default", "", message).with_at(at)
            }
            None => {
                let message = format!("{name} gives the terrain no roughness here: {list}");
                let remedy = match roughness.table {
                    Some(_) => "add these classes to the table, or give `roughness.default`",
                    None => "give it values there, or `roughness.default`",
                };
                input_error("roughness-gap", message).with_remedy(remedy).with_at(at)
            }
        })
    }
}

/// An area (m²) in words.
fn area(square_metres: f64) -> String {
    if square_metres >= 1e6 {
        format!("{:.2} km²", square_metres / 1e6)
    } else if square_metres >= 1e4 {
        format!("{:.2} ha", square_metres / 1e4)
    } else {
        format!("{square_metres:.1} m²")
    }
}
