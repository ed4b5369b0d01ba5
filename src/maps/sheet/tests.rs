use super::*;

const GRID: MapGrid = MapGrid { columns: 100, rows: 60, west: 1000.0, north: 2600.0, cell: 10.0 };

fn drawn(marks: &[Mark]) -> String {
    let bed: Vec<f64> = (0..6000).map(|i| 500.0 - (i % 100) as f64).collect();
    let depth: Vec<f64> = (0..6000)
        .map(|i| if (30..60).contains(&(i % 100)) && (20..40).contains(&(i / 100)) { 3.0 } else { 0.0 })
        .collect();
    let classes = Classes::depth(5.0);
    let panel = Panel { caption: "now".to_string(), values: &depth, classes: &classes, under: None, wide: true };
    let panels = vec![panel.clone(), Panel { wide: false, ..panel.clone() }, Panel { wide: false, ..panel }];
    let (title, subtitle, crs, note) = ("A & B", "depth", "local metres", "");
    map_sheet(&Sheet { title, subtitle, grid: &GRID, bed: &bed, panels, marks, crs, note })
}

#[test]
fn the_sheet_is_well_formed_and_complete() {
    let svg = drawn(&[Mark { name: "G<1>".to_string(), place: (1400.0, 2300.0) }]);
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
    assert!(svg.contains("A &amp; B") && svg.contains("G&lt;1&gt;") && svg.contains("local metres"));
    assert_eq!(svg.matches("<use ").count(), 3, "three maps share one picture of the terrain");
    assert_eq!(svg.matches("id=\"terrain-").count(), 1);
    assert_eq!(svg.matches("Water depth (m)").count(), 1, "one legend for three maps of the same classes");
}

#[test]
fn the_window_holds_the_flood_and_the_marks_with_a_margin() {
    let bed = vec![0.0; 6000];
    let mut depth = vec![f64::NAN; 6000];
    depth[30 * 100 + 50] = 1.0;
    let classes = Classes::depth(5.0);
    let panel = Panel { caption: String::new(), values: &depth, classes: &classes, under: None, wide: true };
    let mark = Mark { name: "far".to_string(), place: (1905.0, 2305.0) };
    let sheet = Sheet {
        title: "",
        subtitle: "",
        grid: &GRID,
        bed: &bed,
        panels: vec![panel],
        marks: std::slice::from_ref(&mark),
        crs: "",
        note: "",
    };
    let Window { first_column, first_row, columns, rows } = window(&sheet);
    assert!(first_column <= 47 && first_column + columns >= 94 && first_column + columns <= 100);
    assert!(first_row <= 26 && first_row + rows >= 34 && rows >= columns * 4 / 9 - 5);
}

#[test]
fn names_of_close_marks_do_not_cover_each_other() {
    let marks: Vec<Mark> =
        (0..3).map(|k| Mark { name: format!("gauge {k}"), place: (1400.0 + 4.0 * f64::from(k), 2300.0) }).collect();
    let svg = drawn(&marks);
    let places: Vec<&str> = svg
        .lines()
        .filter(|line| line.contains("gauge") && line.contains("#222"))
        .filter_map(|l| l.split(" font").next())
        .collect();
    assert_eq!(places.len(), 9);
    assert!((1..3).all(|k| places[k] != places[0]) && places[1] != places[2]);
}
