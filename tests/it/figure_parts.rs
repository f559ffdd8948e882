//! Of what figures are laid out: ticks, texts, shapes, cells, labels and colours, and how a drawing is written.

use kinetostat::{
    Machine,
    figures::{
        Colours, Figure, PoseFigure, Surroundings,
        axis::{degree_ticks, label_with_power, linear_ticks, logarithmic_ticks, widened},
        cyclic_colour, diverging_colour,
        drawing::{Drawing, Item, Point, Rect, Rgb, Stroke, Text},
        field::{Picture, edges},
        labels::{Occupied, rect_around},
        png::dashes,
        shapes::{contour, hatching_beyond, hatching_lines, simplify_line},
        svg::{svg, with_dark_theme},
        text::{Weight, width, wrap},
    },
    machine::catalogue,
};

fn at_home(machine: &Machine) -> PoseFigure {
    PoseFigure {
        title: machine.title.clone(),
        subtitle: String::new(),
        pose: machine.rigid_skeleton(&machine.home),
        displaced: None,
        rails: Vec::new(),
        workspace: [machine.workspace.min.into(), machine.workspace.max.into()],
        surroundings: Surroundings::default(),
        note: None,
    }
}

fn drawing(figure: PoseFigure) -> Drawing {
    Figure::Pose(Box::new(figure)).drawing(Colours::Viridis).unwrap()
}

fn texts(figure: PoseFigure) -> Vec<Text> {
    let items = drawing(figure).items.into_iter();
    items.filter_map(|item| if let Item::Text(text) = item { Some(text) } else { None }).collect()
}

#[test]
fn no_label_of_a_machine_of_the_catalogue_covers_another() {
    for name in catalogue::names() {
        let machine = Machine::named_or_file(name).unwrap();
        let texts = texts(at_home(&machine));
        let labels = texts.iter().filter(|text| text.content.starts_with("chain ")).count();
        assert_eq!(labels, machine.chains.len(), "{name}");
        for (i, text) in texts.iter().enumerate() {
            for other in &texts[..i] {
                let shared = text.bounds().overlap(&other.bounds());
                assert!(shared == 0.0, "{name}: \"{}\" over \"{}\"", text.content, other.content);
            }
        }
    }
}

#[test]
fn springs_and_masses_are_drawn_and_told_where_there_are_any() {
    let legend = |name: &str| {
        let machine = Machine::named_or_file(name).unwrap();
        let texts = texts(at_home(&machine));
        ["spring", "mass (diameter: cube root)", "passive joint"].map(|words| texts.iter().any(|t| t.content == words))
    };
    assert_eq!(legend("orthoglide"), [false, false, true]);
    assert_eq!(legend("kr270"), [false, false, false]);
    assert_eq!(legend("fanuc_r2000ic"), [false, true, false]);
    assert_eq!(legend("hybrid_3ups"), [false, true, true]);
    assert_eq!(legend("tests/machines/robot_6r.toml"), [true, true, false]);
}

#[test]
fn what_stands_beside_the_links_is_on_the_page() {
    for name in ["fanuc_r2000ic", "tests/machines/robot_6r.toml"] {
        let figure = at_home(&Machine::named_or_file(name).unwrap());
        let told = (figure.pose.springs().count(), figure.pose.masses().count());
        assert!(told.0 + told.1 > 0, "{name}");
        let page = drawing(figure);
        // Springs are zigzags, masses discs; those of the legend come last.
        let spring = |item: &Item| match item {
            Item::Line { points, stroke } if stroke.width == 3.5 && points.len() == 11 => Some(points.clone()),
            _ => None,
        };
        let mass = |item: &Item| match item {
            Item::Convex { corners, .. } if corners.len() == 40 => Some(corners.clone()),
            _ => None,
        };
        let springs: Vec<Vec<Point>> = page.items.iter().filter_map(spring).take(told.0).collect();
        let masses: Vec<Vec<Point>> = page.items.iter().filter_map(mass).take(told.1).collect();
        assert_eq!((springs.len(), masses.len()), told, "{name}");
        for [x, y] in springs.into_iter().chain(masses).flatten() {
            assert!(x > 28.0 && x < page.width - 28.0 && y > 0.0 && y < page.height, "{name}: ({x}, {y})");
        }
    }
}

#[test]
fn lines_end_at_the_border() {
    let square = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    assert_eq!(hatching_lines(&square, 5.0)[0], [[0.0, 5.0], [5.0, 0.0]]);
    assert_eq!(hatching_lines(&square, 5.0).len(), 3);
    assert!(hatching_lines(&[], 5.0).is_empty());
}

/// Over a plane the limit is a line, which cuts every hatching line in two parts of known length; a missing node takes its cells.
#[test]
fn hatching_covers_what_is_beyond_a_plane_limit() {
    let (x, y, page) = ([0.0, 1.0, 4.0], [-1.0, 0.0, 1.0], [[100.0, 50.0], [500.0, 250.0]]);
    let mut values: Vec<Option<f64>> = y.iter().flat_map(|_| x.map(|x| Some(x - 1.5))).collect();
    let square = [[250.0, 50.0], [500.0, 50.0], [500.0, 250.0], [250.0, 250.0]];
    let total = |lines: &[[Point; 2]]| lines.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum::<f64>();
    let found = hatching_beyond(&x, &y, &values, page, 20.0);
    assert!(found.iter().flatten().all(|[x, y]| *x >= 250.0 - 1e-9 && (50.0..=250.0).contains(y)), "{found:?}");
    assert!((total(&found) - total(&hatching_lines(&square, 20.0))).abs() < 1e-6 * total(&found));
    values[8] = None;
    let found = hatching_beyond(&x, &y, &values, page, 20.0);
    assert!(found.iter().flatten().all(|[x, y]| *x <= 204.0 || *y >= 146.0), "{found:?}");
    assert!(!found.is_empty());
}

#[test]
fn the_line_of_a_plane_is_straight_and_stops_at_missing_nodes() {
    let (x, y) = ([0.0, 1.0, 2.0, 4.0], [0.0, 2.0, 3.0]);
    let mut values: Vec<Option<f64>> = y.iter().flat_map(|y| x.map(|x| Some(x + y))).collect();
    let pieces = contour(&x, &y, &values, 2.5);
    assert!(!pieces.is_empty());
    assert!(pieces.iter().flatten().all(|(x, y)| (x + y - 2.5).abs() < 1e-12), "{pieces:?}");
    let length = |pieces: &[[(f64, f64); 2]]| pieces.iter().map(|[a, b]| (a.0 - b.0).hypot(a.1 - b.1)).sum::<f64>();
    assert!((length(&pieces) - 2.5 * 2f64.sqrt()).abs() < 1e-12);
    // The cell of the missing node holds the line from (0.5, 2) to (1, 1.5).
    values[0] = None;
    assert!((length(&contour(&x, &y, &values, 2.5)) - 2.0 * 2f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_saddle_gives_two_pieces_around_the_corners_off_the_middle() {
    let values = [1.0, -1.0, -1.0, 2.0].map(Some);
    let pieces = contour(&[0.0, 1.0], &[0.0, 1.0], &values, 0.0);
    assert_eq!(pieces[0], [(0.5, 0.0), (1.0, 1.0 / 3.0)]);
    assert_eq!(pieces.len(), 2);
    assert_eq!(contour(&[0.0, 1.0], &[0.0, 1.0], &values.map(|v| v.map(|v| -v)), 0.0).len(), 2);
}

#[test]
fn corners_stay_and_points_on_the_way_go() {
    let line = [[0.0, 0.0], [5.0, 0.1], [10.0, 0.0], [10.0, 10.0], [10.2, 15.0], [10.0, 20.0]];
    assert_eq!(simplify_line(&line), [[0.0, 0.0], [10.0, 0.0], [10.0, 20.0]]);
    let closed = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 0.0]];
    assert_eq!(simplify_line(&closed), closed);
}

#[test]
fn ticks_are_round_numbers_inside_the_range() {
    let ticks = linear_ticks(-73.65, 126.35, 5);
    assert_eq!(ticks.labels, ["\u{2212}50", "0", "50", "100"]);
    assert_eq!(linear_ticks(0.0, 1.0, 5).labels, ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
}

#[test]
fn angles_over_a_turn_are_marked_at_right_angles_or_their_halves() {
    assert_eq!(degree_ticks(-14.4, 374.4, 7).labels, ["0", "90", "180", "270", "360"]);
    assert_eq!(degree_ticks(0.0, 360.0, 8).values.len(), 9);
}

#[test]
fn small_and_large_numbers_move_their_power_of_ten_to_the_label() {
    let ticks = linear_ticks(0.0, 1.2e-5, 4);
    assert_eq!(ticks.exponent, -6);
    assert_eq!(ticks.labels, ["0", "5", "10"]);
    assert_eq!(label_with_power("error [mm]", -6), "error [10⁻⁶ mm]");
    assert_eq!(linear_ticks(0.0, 3e6, 3).labels, ["0", "1", "2", "3"]);
}

#[test]
fn logarithmic_ticks_are_decades_thinned_to_the_target() {
    assert_eq!(logarithmic_ticks(0.05, 2000.0, 10).labels, ["10⁻¹", "10⁰", "10¹", "10²", "10³"]);
    assert!(logarithmic_ticks(1e-30, 1e30, 6).labels.len() <= 8);
    assert_eq!(logarithmic_ticks(1.5, 7.0, 6).labels, ["2", "5"]);
}

#[test]
fn a_constant_is_widened_and_still_has_ticks() {
    for value in [0.0, 1.0, -1e-60, 1e90, 1e6 + 0.1] {
        let (low, high) = widened(value, value);
        assert!(low < value && value < high);
        assert!(linear_ticks(low, high, 5).values.len() >= 2, "{value}");
    }
}

/// Relative luminance of an sRGB colour.
fn luminance(colour: Rgb) -> f64 {
    let [r, g, b] = colour.map(|v| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    });
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// CIE lightness, 0..100.
fn lightness(colour: Rgb) -> f64 {
    116.0 * luminance(colour).cbrt() - 16.0
}

#[test]
fn lightness_rises_steadily_in_all_colours() {
    for colours in [Colours::Viridis, Colours::Cividis, Colours::Grey] {
        let steps: Vec<f64> = (0..=20).map(|k| lightness(colours.colour_at(f64::from(k) / 20.0))).collect();
        let even = (steps[20] - steps[0]) / 20.0;
        assert!(even > 3.0, "{colours:?} spans {} of 100", steps[20] - steps[0]);
        for (k, pair) in steps.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            assert!(step > 0.4 * even && step < 1.7 * even, "{colours:?}, step {k}: {step}, {even} on average");
        }
        assert_eq!(colours.colour_at(-1.0), colours.colour_at(0.0));
        assert_eq!(colours.colour_at(2.0), colours.colour_at(1.0));
    }
}

#[test]
fn a_turn_closes_and_zero_is_the_lightest() {
    assert_eq!(cyclic_colour(0.0), cyclic_colour(1.0));
    assert!(lightness(cyclic_colour(0.5)) < 20.0 && lightness(cyclic_colour(0.0)) > 85.0);
    let [low, zero, high] = [-1.0, 0.0, 1.0].map(diverging_colour);
    assert!(low[2] > low[0] && high[0] > high[2], "{low:?} {high:?}");
    assert!(lightness(zero) > 93.0);
}

#[test]
fn the_ends_are_those_published() {
    assert_eq!([Colours::Viridis.colour_at(0.0), Colours::Viridis.colour_at(1.0)], [[68, 1, 84], [254, 232, 37]]);
    let near = |found: Rgb, published: Rgb| found.iter().zip(published).all(|(a, b)| a.abs_diff(b) <= 6);
    assert!(near(Colours::Cividis.colour_at(0.0), [0, 32, 77]), "{:?}", Colours::Cividis.colour_at(0.0));
    assert!(near(Colours::Cividis.colour_at(1.0), [255, 234, 70]), "{:?}", Colours::Cividis.colour_at(1.0));
}

fn contrast(a: Rgb, b: Rgb) -> f64 {
    let (a, b) = (luminance(a), luminance(b));
    (a.max(b) + 0.05) / (a.min(b) + 0.05)
}

/// Colours of letters: ink, what is muted, outlines of a part and of room for it, and what is in the way.
const OF_TEXT: [Rgb; 5] = [[26, 26, 26], [80, 80, 80], [11, 79, 138], [184, 84, 0], [192, 57, 43]];

/// A colour as a document has it, "1a2b3c".
fn read(hex: &str) -> Rgb {
    [0, 2, 4].map(|at| u8::from_str_radix(&hex[at..at + 2], 16).unwrap())
}

#[test]
fn what_can_be_read_on_paper_can_be_read_on_a_dark_page() {
    let page = with_dark_theme(&svg(&Drawing { width: 100.0, height: 50.0, ..Drawing::default() }).unwrap());
    let rules = page.split("[fill=\"#").skip(1).map(|rule| rule.split_once("\"]{fill:#").unwrap());
    let dark: Vec<(Rgb, Rgb)> = rules.map(|(light, dark)| (read(light), read(&dark[..6]))).collect();
    let paper = dark[0];
    assert_eq!((paper.0, dark.len()), ([255; 3], 18));
    assert!(OF_TEXT.iter().all(|text| dark.iter().any(|(light, _)| light == text)), "{dark:?}");
    for (light, dark) in &dark[1..] {
        for (colour, ground) in [(*light, paper.0), (*dark, paper.1)] {
            let least = if OF_TEXT.contains(light) { 4.5 } else { 1.1 };
            assert!(contrast(colour, ground) >= least, "{colour:?} on {ground:?}: {}", contrast(colour, ground));
        }
    }
}

#[test]
fn lines_of_one_stroke_are_one_element_with_relative_places() {
    let mut drawing = Drawing { width: 100.0, height: 50.0, ..Drawing::default() };
    let stroke = Stroke { colour: [1, 2, 3], width: 2.0, dash: &[4.0, 3.0] };
    drawing.line(vec![[1.0, 1.0], [11.0, 1.0], [11.0, 0.0]], stroke);
    drawing.line(vec![[0.0, 0.0], [0.0, 5.0]], stroke);
    let document = svg(&drawing).unwrap();
    let path = "<path stroke=\"#010203\" stroke-width=\"6\" stroke-dasharray=\"12 9\" d=\"m3 3l30 0 0-3m-33 0l0 15\"/>";
    assert!(document.contains(path), "{document}");
}

#[test]
fn colours_of_a_dark_page_stand_in_what_is_shown_there_alone() {
    let drawing = Drawing { title: "a".into(), width: 100.0, height: 50.0, ..Drawing::default() };
    let bare = svg(&drawing).unwrap();
    assert!(bare.contains("fill=\"#ffffff\"") && !bare.contains("<style>"), "{bare}");
    let shown = with_dark_theme(&bare);
    assert!(shown.contains("prefers-color-scheme:dark"), "{shown}");
    assert!(shown.contains("[fill=\"#ffffff\"]{fill:#14171b}"), "{shown}");
    assert_eq!(with_dark_theme("<svg/>"), "<svg/>");
}

#[test]
fn cells_end_at_the_outer_nodes() {
    assert_eq!(edges([&[0.0, 2.0, 4.0]]), [[0.0, 1.0, 3.0, 4.0]]);
    assert_eq!(edges([&[3.0]]), [[2.5, 3.5]]);
}

#[test]
fn rows_start_at_the_top_and_only_missing_cells_are_hatched() {
    let rect = Rect { x: 100.0, y: 0.0, width: 40.0, height: 40.0 };
    let colour = |column, row| (column != 0 || row != 1).then_some([column as u8, row as u8, 0, 255]);
    let picture = Picture::new(rect.frame(), &[1.0, 2.0, 3.0], &[0.0, 10.0, 40.0], colour);
    let cells: Vec<_> = picture.cells().collect();
    assert_eq!(cells[0], ([0.0, 0.5], [0.0, 0.75], None));
    assert_eq!(cells[3], ([0.5, 1.0], [0.75, 1.0], Some([1, 0, 0, 255])));
    let hatching_lines = picture.hatching();
    assert_eq!(hatching_lines[0], [[100.0, 22.0], [120.0, 2.0]]);
    assert!(hatching_lines.iter().flatten().all(|[x, y]| (100.0..=120.0).contains(x) && (0.0..=30.0).contains(y)));
}

#[test]
fn wrapped_lines_keep_every_word_and_the_limit() {
    let lines = wrap("errors of the worst point over the workspace", 20.0, Weight::Regular, 200.0);
    assert!(lines.len() > 1);
    assert!(lines.iter().all(|line| width(line, 20.0, Weight::Regular) <= 200.0));
    assert_eq!(lines.join(" "), "errors of the worst point over the workspace");
}

#[test]
fn width_grows_with_size_and_long_words_are_broken() {
    let natural = width("workspace", 20.0, Weight::Regular);
    assert!((width("workspace", 40.0, Weight::Regular) - 2.0 * natural).abs() < 1e-3);
    let lines = wrap("a workspace", 20.0, Weight::Bold, 50.0);
    assert!(lines.iter().all(|line| width(line, 20.0, Weight::Bold) <= 50.0));
    assert_eq!(lines.concat(), "aworkspace");
}

#[test]
fn labels_of_points_that_crowd_do_not_cover_each_other() {
    let page = Rect { x: 0.0, y: 0.0, width: 1600.0, height: 1200.0 };
    let points: Vec<Point> =
        (0..12).map(|k| [800.0 + f64::from(k % 4) * 9.0, 600.0 + f64::from(k / 4) * 7.0]).collect();
    let mut occupied =
        Occupied { marks: points.iter().map(|p| rect_around(*p, [19.0; 2])).collect(), ..Occupied::default() };
    let spots: Vec<Rect> = points.iter().map(|p| occupied.place_label(*p, 19.0, [60.0, 24.0], page).rect).collect();
    for (k, spot) in spots.iter().enumerate() {
        assert!(spots[..k].iter().all(|other| other.overlap(spot) == 0.0), "{k}");
        assert!(points.iter().all(|p| rect_around(*p, [19.0; 2]).overlap(spot) == 0.0), "{k}");
        assert!((spot.overlap(&page) - spot.width * spot.height).abs() < 1e-6, "{k}");
    }
}

#[test]
fn dashes_leave_the_gaps_out_and_go_round_corners() {
    let parts = dashes(&[[0.0, 0.0], [6.0, 0.0], [6.0, 5.0]], &[3.0, 2.0]);
    assert_eq!(
        parts,
        [vec![[0.0, 0.0], [3.0, 0.0]], vec![[5.0, 0.0], [6.0, 0.0], [6.0, 2.0]], vec![[6.0, 4.0], [6.0, 5.0]]]
    );
}
