use super::*;

fn rows<const N: usize>(rows: [(f64, f64); N]) -> Vec<Row> {
    rows.map(|(elevation, width)| Row { elevation, width }).to_vec()
}

fn trapezoid() -> Vec<Row> {
    rows([(10.0, 2.0), (11.0, 4.0), (11.0, 6.0), (13.0, 6.0)])
}

#[test]
fn strips_have_the_area_of_the_section_at_every_row() {
    let strips = strips(&trapezoid());
    let area = |level: f64| strips.iter().map(|strip| strip.width * (level - strip.bed).max(0.0)).sum::<f64>();
    for (level, expected) in [(10.0, 0.0), (11.0, 3.0), (13.0, 15.0), (14.0, 21.0)] {
        assert!((area(level) - expected).abs() < 1e-12, "{level}: {}", area(level));
    }
    assert!(strips.windows(2).all(|pair| pair[0].bed <= pair[1].bed));
}

#[test]
fn rough_walls_are_wetted_and_smooth_ones_are_not() {
    let side = 2.0 * 2.0_f64.sqrt();
    let rough = perimeter(&trapezoid(), ChannelWalls::Rough);
    let expected = [(0.0, 2.0), (1.0, 2.0 + side), (1.0, 4.0 + side), (3.0, 8.0 + side), (4.0, 10.0 + side)];
    for (found, expected) in rough.iter().zip(expected) {
        assert!((found.0 - expected.0).abs() + (found.1 - expected.1).abs() < 1e-12, "{rough:?}");
    }
    let smooth = perimeter(&trapezoid(), ChannelWalls::Smooth);
    assert!((smooth[4].1 - 6.0).abs() < 1e-12);
}

#[test]
fn sections_are_linear_between_those_of_the_table() {
    let table = |distance, bed: f64, width| Table { distance, rows: rows([(bed, width), (bed + 2.0, width + 4.0)]) };
    let sections = [table(0.0, 5.0, 1.0), table(10.0, 4.0, 3.0)];
    assert_eq!(rows_at(&sections, 2.5), rows([(4.75, 1.5), (6.75, 5.5)]));
    assert_eq!(rows_at(&sections, -1.0), rows_at(&sections, 0.0));
    assert_eq!(rows_at(&sections, 11.0), rows_at(&sections, 10.0));
}
