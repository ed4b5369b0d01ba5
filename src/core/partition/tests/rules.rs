//! Rules.
use super::checks::*;
use crate::partition::*;
use super::super::{lines::Network, window::Window, inside::Outlines, seeds::Seeds, voronoi, cut};

#[test]
fn debug_scene() {
  for seed in [4, 6] {
    let lines = super::random::scene(seed);
    let lattice = lattice(30, 30, 1.0);
    let network = Network::new(Window::new(30, 30), &lines, 1.0);
    let made = Partition::new(&lattice, |_| true, &lines);
    for (i, s) in network.segments.iter().enumerate() { println!("{i} {s:?} {:?}", network.kinds[s.line]); }
    for f in &made.faces {
        let one = Partition { faces: vec![*f], ..made.clone() };
        if std::panic::catch_unwind(|| check_lines(&one, &lattice, &lines)).is_err() {
            let m = (f.from + f.to) * 0.5;
            println!("{f:?} {:?}", network.at(m));
            for (i, s) in network.segments.iter().enumerate() {
                if s.distance(m) < 0.3 { println!("   {i} {:e} {:e}", s.distance(f.from), s.distance(f.to)); }
            }
            let outlines = Outlines::new(&network);
            let seeds = Seeds::new(&network, &outlines);
            for (i, p) in seeds.places.iter().enumerate() {
                if (*p - m).norm() < 1.0 {
                    let v = voronoi::cell(*p, &seeds);
                    println!("seed {i} {p:?} {v:?}\n -> {:?}", cut::parts(v.clone(), &network, &|_, _| true));
                }
            }
            break;
        }
    }
  }
}
