//! Tests of whole figures: laid-out text, robustness, determinism.

mod sample;

use std::sync::Arc;

use contact3d_plots::*;
use resvg::{
    tiny_skia::Pixmap,
    usvg::{Group, Node, Options, Rect, Tree, fontdb},
};
use units::{Dimension, Unit};

use sample::Sample;

/// The SVG with its text laid out by the renderer.
fn parse(svg: &str) -> Tree {
    let mut fonts = fontdb::Database::new();
    for font in [
        dejavu::sans::regular(),
        dejavu::sans::oblique(),
        dejavu::sans::bold(),
        dejavu::sans::bold_oblique(),
    ] {
        fonts.load_font_source(fontdb::Source::Binary(Arc::new(font)));
    }
    let options = Options {
        fontdb: Arc::new(fonts),
        ..Options::default()
    };
    Tree::from_str(svg, &options).expect("valid SVG")
}

/// Boxes of all texts after layout with the embedded font; checks that the font has every glyph.
fn text_boxes(tree: &Tree) -> Vec<(String, Rect)> {
    fn collect(group: &Group, boxes: &mut Vec<(String, Rect)>) {
        for node in group.children() {
            match node {
                Node::Group(inner) => collect(inner, boxes),
                Node::Text(text) => {
                    let content: String = text.chunks().iter().map(|c| c.text()).collect();
                    for span in text.layouted() {
                        let missing = span.positioned_glyphs.iter().any(|g| g.id.0 == 0);
                        assert!(!missing, "a glyph of {content:?} is missing");
                    }
                    boxes.push((content, text.abs_bounding_box()));
                }
                Node::Path(_) | Node::Image(_) => {}
            }
        }
    }
    let mut boxes = Vec::new();
    collect(tree.root(), &mut boxes);
    boxes
}

/// Checks that no text leaves the page and that no two texts overlap.
fn assert_readable(svg: &str) {
    let tree = parse(svg);
    let boxes = text_boxes(&tree);
    assert!(!boxes.is_empty());
    let (width, height) = (tree.size().width(), tree.size().height());
    for (index, (text, area)) in boxes.iter().enumerate() {
        let inside = area.left() >= 2.0
            && area.top() >= 2.0
            && area.right() <= width - 2.0
            && area.bottom() <= height - 2.0;
        assert!(inside, "{text:?} leaves the page: {area:?}");
        for (other, second) in &boxes[..index] {
            // Boxes include the space above and below the letters: 3 px of these may overlap.
            let apart = area.left() >= second.right()
                || second.left() >= area.right()
                || area.top() + 3.0 >= second.bottom()
                || second.top() + 3.0 >= area.bottom();
            assert!(apart, "{text:?} and {other:?} overlap");
        }
    }
}

fn assert_all_readable(picture: &ContactPicture<'_>) {
    for (_, figure) in panels(picture) {
        assert_readable(&figure.svg());
    }
    assert_readable(&page(picture).svg());
}

#[test]
fn figures_are_readable_for_contact_faces_of_many_shapes() {
    let shapes = [
        ([3.0, 1.0, 1.0], [12, 4, 4]),
        ([3.0, 1.0, 1.0], [96, 32, 2]),
        ([1.0, 1.0, 1.0], [2, 2, 2]),
        ([1.5, 1.0, 1.0], [6, 4, 2]),
        ([0.01, 0.04, 0.01], [8, 32, 4]),
        ([3000.0, 1.0, 1.0], [48, 4, 2]),
        ([1.0, 3000.0, 1.0], [4, 48, 2]),
        ([3e-7, 1e-7, 1e-7], [12, 4, 2]),
        ([1.0, 1.0, 1e-4], [8, 8, 2]),
    ];
    for (size, cells) in shapes {
        assert_all_readable(&Sample::brick(size, cells).picture());
    }
}

#[test]
fn figures_survive_constant_huge_and_missing_values() {
    for value in [
        0.0,
        0.3,
        -1e-300,
        1e-30,
        4.2e17,
        f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ] {
        let mut sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
        sample.pressure.fill(value);
        for pane in &mut sample.friction {
            pane.scaled_tangential = value;
            pane.semi_axes = [value, 1e6 * value];
            pane.stress = [value; 2];
        }
        sample.displacement.fill([value; 3]);
        assert_all_readable(&sample.picture());
        sample.pressure[1] = f64::NAN;
        sample.pressure[2] = 2.0 * value + 1e-9;
        sample.friction[3].semi_axes[1] = f64::NAN;
        sample.displacement[5] = [1.0, f64::NAN, -1.0];
        assert_all_readable(&sample.picture());
    }
}

#[test]
fn one_missing_value_is_explained_beside_the_colour_bar() {
    for size in [[3.0, 1.0, 1.0], [1.0, 1.0, 1.0]] {
        let mut sample = Sample::brick(size, [4, 4, 4]);
        sample.pressure[1] = f64::NAN;
        let panels = panels(&sample.picture());
        assert!(panels[0].1.svg().contains("no value"));
        assert!(!panels[1].1.svg().contains("no value"));
    }
}

#[test]
fn title_is_escaped_and_cut_to_the_page() {
    let mut sample = Sample::brick([3.0, 1.0, 1.0], [4, 2, 2]);
    sample.title = "a < b & \"c\" > 'd' \u{1} ".repeat(20);
    let svg = page(&sample.picture()).svg();
    assert!(svg.contains("a &lt; b &amp; &quot;c&quot; &gt; &apos;d&apos;"));
    assert_readable(&svg);
    sample.title.clear();
    assert_readable(&page(&sample.picture()).svg());
}

#[test]
fn png_has_the_asked_width_and_is_not_blank() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let figure = page(&sample.picture());
    let png = figure.png(700).unwrap();
    let picture = Pixmap::decode_png(&png).unwrap();
    assert_eq!(picture.width(), 700);
    let coloured = picture.pixels().iter().filter(|pixel| {
        let channels = [pixel.red(), pixel.green(), pixel.blue()];
        channels.iter().max() != channels.iter().min()
    });
    // The maps cover more than a fifth of the page.
    assert!(coloured.count() * 5 > picture.pixels().len());
    assert!(matches!(figure.png(0), Err(PngError::Width(0))));
}

/// The fonts are part of the program: with its words a picture is another one, also in letters that they lack.
#[test]
fn a_png_has_its_text() {
    let mut sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let pixels = |title: &str| {
        sample.title = title.to_owned();
        let png = page(&sample.picture()).png(1280).unwrap();
        Pixmap::decode_png(&png).unwrap()
    };
    let [none, words, foreign] = ["", "AVA, Tokio", "\u{65e5}"].map(pixels);
    let dark = |picture: &Pixmap| picture.pixels().iter().filter(|p| p.red() < 64).count();
    assert!(dark(&words) > dark(&none) + 200);
    assert!(dark(&foreign) > dark(&none));
}

#[test]
fn same_picture_gives_the_same_bytes() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let [first, second] = [(); 2].map(|()| page(&sample.picture()));
    assert_eq!(first.svg(), second.svg());
    assert_eq!(first.png(300).unwrap(), second.png(300).unwrap());
}

#[test]
fn without_friction_there_are_stress_and_body_only() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let mut picture = sample.picture();
    picture.friction = None;
    let panels = panels(&picture);
    let names: Vec<_> = panels.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["a_contact_pressure", "c_deformed_body"]);
    assert_all_readable(&picture);
}

#[test]
fn an_empty_or_open_boundary_surface_is_drawn_as_it_is() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let mut picture = sample.picture();
    for boundary in [&[], &sample.boundary_triangles[..100]] {
        picture.boundary_triangles = boundary;
        assert_all_readable(&picture);
    }
}

#[test]
fn a_body_without_contact_has_one_panel() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [4, 2, 2]);
    let mut picture = sample.picture();
    picture.contact_triangles = &[];
    picture.contact_triangle_pane = &[];
    picture.pressure = &[];
    picture.friction = None;
    let panels = panels(&picture);
    assert_eq!(panels.len(), 1);
    assert!(!panels[0].1.svg().contains("grey: obstacle"));
    assert_all_readable(&picture);
}

#[test]
fn a_coefficient_that_does_not_vary_is_said_and_not_drawn() {
    let mut sample = Sample::brick([1.0, 1.0, 1.0], [16, 16, 2]);
    for pane in &mut sample.friction {
        pane.semi_axes = [0.3; 2];
    }
    let drawn = panels(&sample.picture());
    let names: Vec<_> = drawn.iter().map(|(name, _)| &name[..1]).collect();
    assert_eq!(names, ["a", "b", "c", "d"]);
    let texts = text_boxes(&parse(&drawn[3].1.svg()));
    let said = |words: &str| texts.iter().any(|(text, _)| text == words);
    assert!(said("F1 = F2 = 0.3") && said("F = 0.3"), "{texts:?}");
    assert_all_readable(&sample.picture());
    sample.friction[1].semi_axes[1] = 0.2;
    assert_eq!(panels(&sample.picture()).len(), 5);
}

/// Of 16 × 16 panes the four in a corner touch and are drawn with what is beside them.
#[test]
fn a_face_that_is_mostly_open_is_framed_around_what_touches() {
    let mut sample = Sample::brick([1.0, 1.0, 1.0], [32, 32, 2]);
    let pressure = (0..256).map(|pane| if pane % 16 < 2 && pane < 32 { 1.0 } else { 0.0 });
    sample.pressure = pressure.collect();
    let panes = |picture: &ContactPicture<'_>| {
        let svg = panels(picture)[0].1.svg();
        svg.matches("<title>pane ").count()
    };
    // A margin of a quarter of two panes reaches into the next ones.
    assert_eq!(panes(&sample.picture()), 9);
    assert_all_readable(&sample.picture());
    sample.pressure[255] = 1.0;
    assert_eq!(panes(&sample.picture()), 256);
}

/// A hill below the face is drawn where it is, beside a body whose displacements are not drawn larger; what is far away is cut off.
#[test]
fn an_obstacle_is_drawn_where_it_is() {
    let sample = Sample::brick([1.0, 1.0, 1.0], [8, 8, 2]);
    let nodes = || sample.coordinates.iter().filter(|x| x[2] == 0.0);
    let shape = |gap: &dyn Fn(f64) -> f64| DrawnObstacle {
        points: nodes().copied().collect(),
        gaps: nodes().map(|x| [0.0, 0.0, -gap(x[0])]).collect(),
        triangles: sample.contact_triangles.clone(),
    };
    let regions = |obstacle: &DrawnObstacle, is_to_scale: bool| {
        let mut picture = sample.picture();
        picture.obstacle = Some(obstacle);
        picture.is_to_scale = is_to_scale;
        assert_all_readable(&picture);
        let body = panels(&picture)[2].1.svg();
        let bare = panels(&sample.picture())[2].1.svg();
        let as_it_is = body.contains("displacement × 1,");
        assert!(body.contains("grey: obstacle"));
        (
            body.matches("<path").count() - bare.matches("<path").count(),
            as_it_is,
        )
    };
    assert_eq!(regions(&shape(&|_| 0.0), false), (1, false));
    let (near, as_it_is) = regions(&shape(&|x| 1e-4 * x * x), true);
    assert!(as_it_is && near == sample.contact_triangles.len());
    let (far, _) = regions(&shape(&|x| x * x), true);
    assert!(far > 0 && far < near, "{far}");
    // A plane that the body does not touch yet.
    assert_eq!(regions(&shape(&|_| 1e-3), true), (1, true));
}

/// Each kind of mark on the upper face of a slender brick, whose arrows would leave the panel at the scale of the body alone.
#[test]
fn clamps_and_loads_are_drawn_and_explained() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [8, 4, 4]);
    let nodes: Vec<usize> = (0..sample.coordinates.len())
        .filter(|&node| sample.coordinates[node][2] == 1.0)
        .collect();
    let mark = |kind, vector: [f64; 3]| BodyMark {
        kind,
        vectors: vec![vector; nodes.len()],
        normals: vec![[0.0, 0.0, 1.0]; nodes.len()],
        nodes: nodes.clone(),
    };
    let down = [0.0, 0.0, -1.0];
    let cases = [
        (mark(BodyMarkKind::Held, [1.0; 3]), "held"),
        (
            mark(BodyMarkKind::Held, [0.0, 1.0, 0.0]),
            "held along an axis",
        ),
        (mark(BodyMarkKind::Spring, down), "springs"),
        (mark(BodyMarkKind::Moved, down), "moved"),
        (mark(BodyMarkKind::Load, down), "load"),
        (mark(BodyMarkKind::Volume, down), "load"),
    ];
    for (mark, word) in cases {
        let marks = [mark];
        let mut picture = sample.picture();
        picture.marks = &marks;
        assert_all_readable(&picture);
        let texts = text_boxes(&parse(&panels(&picture)[2].1.svg()));
        assert!(
            texts.iter().any(|(text, _)| text == word),
            "{word}: {texts:?}"
        );
    }
    let nothing = [mark(BodyMarkKind::Load, [0.0; 3])];
    let mut picture = sample.picture();
    picture.marks = &nothing;
    let texts = text_boxes(&parse(&panels(&picture)[2].1.svg()));
    assert!(texts.iter().all(|(text, _)| text != "load"), "{texts:?}");
}

/// Faces of a mesh have their names in the legend, also where there are more than fit.
#[test]
fn faces_of_a_mesh_are_named() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let count = sample.boundary_triangles.len();
    for n_faces in [1, 6, 100] {
        let face: Vec<usize> = (0..count).map(|k| k * n_faces / count).collect();
        let names: Vec<String> = (0..n_faces).map(|k| format!("face number {k}")).collect();
        let picture = MeshPicture {
            title: "part.msh",
            coordinates: &sample.coordinates,
            triangles: &sample.boundary_triangles,
            bodies: &[],
            face: &face,
            names: &names,
        };
        let svg = mesh_page(&picture).svg();
        assert_readable(&svg);
        assert!(svg.contains("face number 0<") && svg.contains("from below"));
        assert_eq!(svg.contains("and 60 more"), n_faces == 100);
    }
}

#[test]
fn fields_are_readable_on_bodies_of_any_shape() {
    for size in [[3.0, 1.0, 1.0], [1.0, 1.0, 3.0]] {
        let sample = Sample::brick(size, [4, 4, 4]);
        let values: Vec<f64> = (0..sample.coordinates.len()).map(|k| k as f64).collect();
        let field = BodyField {
            title: "A field",
            symbol: "f",
            dimension: Dimension::STRESS,
            values: &values,
        };
        let figure = body_figure(&sample.picture(), &field, ["one side", "the other"]);
        assert_readable(&figure.svg());
    }
}

#[test]
fn turned_ellipses_are_drawn_as_outlines() {
    let mut sample = Sample::brick([3.0, 1.0, 1.0], [4, 2, 2]);
    let straight = page(&sample.picture()).svg();
    for pane in &mut sample.friction {
        pane.turn = 0.5;
    }
    let turned = page(&sample.picture()).svg();
    assert!(turned.matches("<ellipse").count() < straight.matches("<ellipse").count());
    assert_all_readable(&sample.picture());
}

#[test]
fn axes_that_turn_the_body_are_named() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [4, 2, 2]);
    let mut picture = sample.picture();
    picture.axis_1 = [0.6, 0.8, 0.0];
    picture.axis_2 = [-0.8, 0.6, 0.0];
    assert_all_readable(&picture);
    picture.axis_1 = [-1.0, 0.0, 0.0];
    picture.axis_2 = [0.0, -1.0, 0.0];
    let panels = panels(&picture);
    assert!(
        panels[0]
            .1
            .svg()
            .contains("−<tspan font-style=\"italic\">x</tspan>")
    );
}

fn chart(scale: AxisScale, factor: f64, n_series: usize) -> Chart {
    let axis = |label: &str| ChartAxis {
        label: label.to_owned(),
        unit: Unit::none(),
        scale,
        ticks: Vec::new(),
    };
    let series = (0..n_series).map(|k| {
        let points = (0..6).map(|i| ChartPoint {
            x: factor * 10_f64.powi(i - 3) * (k + 1) as f64,
            y: factor * 10_f64.powi(-2 * i),
            text: format!("point <{i}> & more"),
        });
        Series::new(&format!("fixed point (a), explicit, {k}"), points)
    });
    Chart {
        title: "Work and precision".to_owned(),
        x: axis("seconds [s]"),
        y: axis("error"),
        legend: "method, operator".to_owned(),
        series: series.collect(),
    }
}

#[test]
fn charts_are_readable_on_any_scale() {
    for scale in [AxisScale::Linear, AxisScale::Logarithmic] {
        for factor in [1e-9, 1.0, 3e7] {
            for n_series in [0, 1, 5, 9] {
                assert_readable(&chart(scale, factor, n_series).figure().svg());
            }
        }
    }
}

#[test]
fn a_point_that_no_axis_can_show_is_left_out() {
    let mut with = chart(AxisScale::Logarithmic, 1.0, 1);
    let expected = with.figure().svg();
    for y in [0.0, -1.0, f64::INFINITY] {
        with.series[0].points.push(ChartPoint {
            x: 1.0,
            y,
            text: String::new(),
        });
    }
    assert_eq!(with.figure().svg(), expected);
}

/// A point without a value is a gap in its line, with a cross that says why.
#[test]
fn a_point_without_a_value_is_a_gap() {
    let mut chart = chart(AxisScale::Linear, 1.0, 1);
    let lines = |svg: &str| svg.matches('M').count();
    let whole = chart.figure().svg();
    chart.series[0].points[3].y = f64::NAN;
    chart.series[0].points[3].text = "lost".to_owned();
    let with_gap = chart.figure().svg();
    assert_readable(&with_gap);
    assert!(with_gap.contains("<title>lost") && with_gap.contains("no solution"));
    // One part more of the line, and two strokes for each cross, of which the legend has one.
    assert_eq!(lines(&with_gap), lines(&whole) + 1 + 2 * 2);
}

/// Parts of a path of one kind are one entry of the legend, marks say where they are.
#[test]
fn paths_of_solutions_are_readable() {
    let point = |x: f64| ChartPoint {
        x,
        y: x * x,
        text: format!("fold {x}"),
    };
    let path = |style| Series::of_path(style, vec![point(1.0), point(2.0)]);
    let mut chart = chart(AxisScale::Linear, 1.0, 0);
    chart.series = vec![
        path(SeriesStyle::Attracting),
        path(SeriesStyle::NegativeDeterminant),
        path(SeriesStyle::Attracting),
        Series::of_path(SeriesStyle::Fold, vec![point(2.0)]),
    ];
    let svg = chart.figure().svg();
    assert_readable(&svg);
    assert_eq!(svg.matches(">attracting").count(), 1);
    assert_eq!(svg.matches("<title>fold 2").count(), 1);
}

#[test]
fn every_pane_and_every_point_says_its_value() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [12, 4, 4]);
    let picture = sample.picture();
    // Open panes have no ellipse that could say it again.
    let pressed = picture.pressure.iter().filter(|p| **p > 0.0).count();
    assert!(pressed < picture.pressure.len());
    for (name, figure) in panels(&picture) {
        let panes = figure.svg().matches("<title>pane ").count();
        let expected = match name {
            "c_deformed_body" => 0,
            "d_friction_ellipses" => picture.pressure.len() + pressed,
            _ => picture.pressure.len(),
        };
        assert_eq!(panes, expected, "{name}");
    }
    let svg = chart(AxisScale::Logarithmic, 1.0, 3).figure().svg();
    assert_eq!(svg.matches("<title>point &lt;").count(), 18);
}

/// Any viewer reads it, and it says which program made it.
#[test]
fn pngs_name_this_program() {
    let sample = Sample::brick([3.0, 1.0, 1.0], [4, 2, 2]);
    let png = page(&sample.picture()).png(640).unwrap();
    let picture = Pixmap::decode_png(&png).unwrap();
    assert_eq!(picture.width(), 640);
    assert_eq!(
        &png[37..],
        &[b"tEXtSoftware\0contact3d-pipe", &png[64..]].concat()[..]
    );
}
