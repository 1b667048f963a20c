//! Where the components of a multiplier lie.

use contact3d::contact::MultiplierLayout;

#[test]
fn every_component_has_one_place() {
    let layout = MultiplierLayout::new(3, 3);
    let places = (0..3).flat_map(|pane| {
        let [first, second] = layout.tangential(pane).expect("friction");
        [(layout.normal(pane), pane), (first, pane), (second, pane)]
    });
    let mut panes = [None; 9];
    for (place, pane) in places {
        assert_eq!(panes[place].replace(pane), None);
        assert_eq!(layout.pane_of(place), pane);
    }
    assert_eq!(layout.n_multipliers(), panes.len());
    let vector: Vec<f64> = (0..9).map(f64::from).collect();
    let (normal, pairs) = layout.split(&vector);
    assert_eq!(normal, [0.0, 1.0, 2.0]);
    assert_eq!(pairs[1], layout.pair(&vector, 1));
    assert_eq!(pairs[1], [5.0, 6.0]);
}

#[test]
fn without_friction_there_are_no_pairs() {
    let layout = MultiplierLayout::new(2, 0);
    assert_eq!(layout.n_multipliers(), 2);
    assert_eq!(layout.tangential(1), None);
    assert_eq!(layout.tangentials(), 2..2);
    assert_eq!(layout.pair(&[1.0, 2.0], 1), [0.0; 2]);
}

#[test]
fn panes_with_friction_come_first() {
    let layout = MultiplierLayout::new(3, 1);
    assert_eq!(layout.n_multipliers(), 5);
    assert_eq!(layout.tangential(0), Some([3, 4]));
    assert_eq!(layout.tangential(1), None);
    assert_eq!([3, 4].map(|j| layout.pane_of(j)), [0, 0]);
    let (normal, pairs) = layout.split(&[1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!((normal.len(), pairs), (3, &[[4.0, 5.0]][..]));
}
