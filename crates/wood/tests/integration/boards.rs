//! Boards told from round stems.

use crate::support;
use crate::support::stem_at as at;
use greenstick_wood::primitive::{board, cylinder};
use greenstick_wood::stem::StemKind;
use std::f64::consts::TAU;

#[test]
fn boards_are_known_by_their_sections() {
    let found = at(&[board(0.9, 0.2, 0.03)], "0.5").unwrap();
    let stem = &found.stem;
    assert_eq!(stem.kind, StemKind::Board);
    assert!(
        (stem.length - 0.9).abs() < 1e-9
            && (stem.radius * stem.radius * TAU / 2.0 - 0.006).abs() < 1e-9
    );
    let pith = stem.rings.pith();
    assert!(pith.x.abs() < 1e-9 && (pith.y.abs() - 0.15).abs() < 1e-9);
    // No place of it, at any length, is farther out than the outermost ring, and one is there.
    let ring = |x: f64, y: f64, s: f64| {
        let fibre = stem.grain.from_section(glam::DVec2::new(x, y), s);
        stem.rings.address(fibre).0
    };
    let outermost = (0..=90).map(|k| ring(0.1, 0.015, 0.01 * f64::from(k)));
    let outermost = outermost.fold(0.0, f64::max);
    assert!((outermost - 1.0).abs() < 2e-3, "{outermost}");
    assert!(ring(0.0, -0.015, 0.4) < ring(0.0, 0.015, 0.4));
    assert_eq!(
        at(&[cylinder(0.03, 0.9, 24)], "0.5").unwrap().stem.kind,
        StemKind::Round
    );
}

#[test]
fn a_cutting_board_is_a_board() {
    let board = support::gltf(&support::data::data("homecart_cutting_board.gltf"));
    let stem = at(&[board], "0.45").unwrap().stem;
    assert_eq!(stem.kind, StemKind::Board);
    assert!((stem.length - 0.9864).abs() < 1e-6);
    assert!(stem.grain.axis().frame(0.1).tangent.z.abs() > 1.0 - 1e-9);
}
