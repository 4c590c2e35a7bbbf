//! P1 Figs. 4, 5a, 5b and 6 as SVG, with the paper's values marked.

use host_sim::figure::{Axis, Series, Style, draw_chart};
use host_sim::positioning::{EPSILONS_MM, TargetResult, steps_per_metre};

use super::Analytic;
use super::report::{PAPER, within};
use super::trials::Kind;

/// The files, in the order of [`draw`].
pub const FILES: [&str; 4] = ["p1_fig4.svg", "p1_fig5a.svg", "p1_fig5b.svg", "p1_fig6.svg"];

/// All figures.
pub fn draw(kinds: &[Kind], analytic: &[Analytic]) -> [String; 4] {
    [error(kinds), probability(kinds, analytic), time(kinds, analytic), extent(kinds)]
}

fn line(label: &str, points: Vec<(f64, f64)>) -> Series {
    Series { label: label.to_owned(), points, style: Style::Line }
}

fn reference(label: &str, points: Vec<(f64, f64)>) -> Series {
    Series { label: label.to_owned(), points, style: Style::Reference }
}

fn linear(label: &str, ticks: &[f64]) -> Axis {
    let range = (ticks.first().copied().unwrap_or(0.0), ticks.last().copied().unwrap_or(1.0));
    Axis { label: label.to_owned(), range, ticks: ticks.to_vec(), is_logarithmic: false }
}

/// ε in mm with what there is at it.
fn over_epsilons(at: impl Fn(usize, f64) -> f64) -> Vec<(f64, f64)> {
    let mut epsilon_mm = 0.0;
    (1..=EPSILONS_MM)
        .map(|number| {
            epsilon_mm += 1.0;
            (epsilon_mm, at(number, epsilon_mm))
        })
        .collect()
}

/// The curves of all kinds and of the analytic inverses.
fn of_results(
    kinds: &[Kind],
    analytic: &[Analytic],
    points: impl Fn(&[TargetResult]) -> Vec<(f64, f64)>,
) -> Vec<Series> {
    let kinds = kinds.iter().map(|kind| line(kind.name(), points(&kind.last())));
    kinds.chain(analytic.iter().map(|of| reference(&of.name, points(&of.results)))).collect()
}

/// P1 Fig. 4: E over the training steps.
fn error(kinds: &[Kind]) -> String {
    let millimetres = |(steps, error_m): (u32, f64)| (f64::from(steps), error_m * 1000.0);
    let curve = |kind: &Kind| kind.mean_curve().into_iter().map(millimetres).collect();
    let mut series: Vec<Series> = kinds.iter().map(|kind| line(kind.name(), curve(kind))).collect();
    let end = series.iter().flat_map(|series| &series.points).map(|point| point.0).fold(1.0, f64::max);
    for paper in &PAPER {
        let error_mm = paper.error_m * 1000.0;
        series.push(reference(paper.name, vec![(0.0, error_mm), (end, error_mm)]));
    }
    let x = linear("training steps", &[0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * end));
    let y = Axis {
        label: String::from("mean positioning error in mm"),
        range: (0.1, 300.0),
        ticks: vec![0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0],
        is_logarithmic: true,
    };
    draw_chart("Positioning error (P1 Fig. 4)", &x, &y, &series)
}

/// P1 Fig. 5a: P(ε).
fn probability(kinds: &[Kind], analytic: &[Analytic]) -> String {
    let points = |results: &[TargetResult]| {
        over_epsilons(|_, epsilon_mm| within(results, epsilon_mm / 1000.0).share())
    };
    let mut series = of_results(kinds, analytic, points);
    // Above it lies the paper's indirect map, near the target below it its direct one.
    series.push(reference("P1, figure: 0.9", vec![(0.0, 0.9), (25.0, 0.9)]));
    let x = linear("ε in mm", &[0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
    let y = linear("P(ε): share of the targets approached to less than ε", &[0.0, 0.25, 0.5, 0.75, 1.0]);
    draw_chart("Target reaching probability (P1 Fig. 5a)", &x, &y, &series)
}

/// P1 Fig. 5b: T(ε).
fn time(kinds: &[Kind], analytic: &[Analytic]) -> String {
    let points = |results: &[TargetResult]| over_epsilons(|number, _| steps_per_metre(results, number));
    let mut series = of_results(kinds, analytic, points);
    for paper in &PAPER {
        series.push(reference(paper.name, vec![(0.0, paper.steps_per_metre), (25.0, paper.steps_per_metre)]));
    }
    let x = linear("ε in mm", &[0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
    let y = linear("T(ε): steps per metre until nearer than ε", &[0.0, 5.0, 10.0, 15.0, 20.0, 25.0]);
    draw_chart("Normalised time to target (P1 Fig. 5b)", &x, &y, &series)
}

/// P1 Fig. 6: the trained neurons of each kind's first trial.
fn extent(kinds: &[Kind]) -> String {
    let degrees = |&[bearing, distance_m]: &[f64; 2]| (bearing.to_degrees(), distance_m * 1000.0);
    let dots = |kind: &Kind| {
        let neurons = kind.curves.first().map_or(&[][..], |curve| &curve.neurons);
        let points = neurons.iter().map(degrees).collect();
        Series { label: kind.name().to_owned(), points, style: Style::Dots }
    };
    let mut series: Vec<Series> = kinds.iter().map(dots).collect();
    for paper in &PAPER {
        let extent_mm = paper.extent_m * 1000.0;
        series.push(reference(paper.name, vec![(-180.0, extent_mm), (180.0, extent_mm)]));
    }
    let x = linear("bearing in degrees", &[-180.0, -90.0, 0.0, 90.0, 180.0]);
    let y = linear("distance in mm", &[0.0, 40.0, 80.0, 120.0, 160.0, 200.0]);
    draw_chart("Trained neurons (P1 Fig. 6)", &x, &y, &series)
}
