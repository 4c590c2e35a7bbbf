//! A seeded search for a controller's numbers: the same for all controllers, so that none is tuned better than others.
//!
//! A plain (μ + λ) evolution strategy, which asks nothing of the score but that more is better. Each generation draws
//! its own runs, the same for all of its candidates; what survives is run again with the next ones, so that luck with
//! some seeds does not last. Scores are of single runs; a candidate's is the mean over scenes, and half of it that of
//! its worst quarter of scenes, since one parameter set is to do for all.

use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::random::{Purpose, Stream};

/// How a number is drawn between its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Uniform.
    Linear,
    /// Uniform in the logarithm, for what differs by factors.
    Log,
}

/// A number that is searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimension {
    /// As written in a configuration file.
    pub name: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// How it is drawn.
    pub scale: Scale,
}

impl Dimension {
    /// A number that is drawn uniformly.
    #[must_use]
    pub const fn linear(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, scale: Scale::Linear }
    }

    /// A number that is drawn uniformly in its logarithm; bounds above 0.
    #[must_use]
    pub const fn log(name: &'static str, low: f64, high: f64) -> Self {
        Self { name, low, high, scale: Scale::Log }
    }

    /// The value at a place in 0..=1.
    fn at(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.low + (self.high - self.low) * place,
            Scale::Log => self.low * libm::pow(self.high / self.low, place),
        }
    }

    /// The place of a value in 0..=1.
    fn place(&self, value: f64) -> f64 {
        let value = value.clamp(self.low, self.high);
        match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Log => libm::log(value / self.low) / libm::log(self.high / self.low),
        }
    }
}

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchPlan {
    /// Seed of what is drawn, and of the first run.
    pub seed: u64,
    /// Generations.
    pub generations: u32,
    /// Candidates of a generation, its survivors included.
    pub candidates: u32,
    /// Candidates that survive.
    pub survivors: u32,
    /// Runs of each scene for each candidate in a generation.
    pub runs: u32,
}

impl SearchPlan {
    /// All runs together of a search over so many scenes.
    #[must_use]
    pub fn total_runs(&self, scenes: usize) -> u64 {
        let each = u64::from(self.generations) * u64::from(self.candidates) * u64::from(self.runs);
        each * u64::try_from(scenes).unwrap_or(u64::MAX)
    }
}

/// A set of numbers and what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// One value for each dimension.
    pub values: Vec<f64>,
    /// Its score over all runs so far, see the module.
    pub score: f64,
    /// Per scene, the sum of scores.
    sums: Vec<f64>,
    /// Runs of each scene so far.
    runs: u32,
}

impl Candidate {
    fn new(values: Vec<f64>, scenes: usize) -> Self {
        Self { values, score: 0.0, sums: vec![0.0; scenes], runs: 0 }
    }

    /// Mean score of each scene.
    pub fn means(&self) -> impl Iterator<Item = f64> {
        self.sums.iter().map(|sum| sum / f64::from(self.runs.max(1)))
    }

    fn add(&mut self, scores: &[f64], runs: u32) {
        let per_scene = scores.chunks(usize::try_from(runs.max(1)).unwrap_or(1));
        for (sum, scores) in self.sums.iter_mut().zip(per_scene) {
            *sum += scores.iter().sum::<f64>();
        }
        self.runs += runs;
        let mut means: Vec<f64> = self.means().collect();
        means.sort_by(f64::total_cmp);
        let worst = means.len().div_ceil(4);
        let mean =
            |means: &[f64]| means.iter().sum::<f64>() / means.iter().map(|_| 1.0).sum::<f64>().max(1.0);
        self.score = f64::midpoint(mean(&means), mean(means.get(..worst).unwrap_or_default()));
    }
}

/// Width of a mutation at first, as a share of a dimension's range; it halves over the search.
const MUTATION: f64 = 0.15;
/// Share of a first generation that is drawn from the whole space; the others are near the start.
const FAR_SHARE: u32 = 2;

struct Drawing<'a> {
    space: &'a [Dimension],
    stream: Stream,
}

impl Drawing<'_> {
    fn anywhere(&mut self) -> Vec<f64> {
        self.space.iter().map(|dimension| dimension.at(self.stream.between(0.0, 1.0))).collect()
    }

    /// Each number of one of two parents, half of them changed by about `width` of their range.
    fn child(&mut self, mother: &[f64], father: &[f64], width: f64) -> Vec<f64> {
        let mut values = Vec::with_capacity(self.space.len());
        for ((dimension, &a), &b) in self.space.iter().zip(mother).zip(father) {
            let from = if self.stream.symmetric() < 0.0 { a } else { b };
            let changes = self.stream.symmetric() < 0.0;
            // A sum of three is bell-shaped enough.
            let step = self.stream.symmetric() + self.stream.symmetric() + self.stream.symmetric();
            let place = dimension.place(from) + if changes { step * width } else { 0.0 };
            values.push(dimension.at(place.clamp(0.0, 1.0)));
        }
        values
    }

    /// One of so many, the first ones more often.
    fn index(&mut self, count: usize) -> usize {
        self.stream.below(count).min(self.stream.below(count))
    }
}

/// Searches from `start` on; `score(values, scene, seed)` is the score of one run, `report` hears of each generation's
/// survivors, the best first.
pub fn search(
    space: &[Dimension],
    start: &[f64],
    scenes: usize,
    plan: &SearchPlan,
    score: impl Fn(&[f64], usize, u64) -> f64 + Sync,
    mut report: impl FnMut(u32, &[Candidate]),
) -> Vec<Candidate> {
    let mut drawing = Drawing { space, stream: Stream::new(plan.seed, Purpose::Search) };
    let mut population = vec![Candidate::new(start.to_vec(), scenes)];
    for number in 1..plan.candidates {
        let is_far = number % FAR_SHARE == 0;
        let values = if is_far { drawing.anywhere() } else { drawing.child(start, start, 2.0 * MUTATION) };
        population.push(Candidate::new(values, scenes));
    }
    let mut seed = plan.seed;
    for generation in 0..plan.generations {
        let runs = plan.runs;
        let jobs: Vec<(usize, usize, u64)> = (0..population.len())
            .flat_map(|candidate| {
                (0..scenes).flat_map(move |scene| {
                    (0..runs).map(move |run| (candidate, scene, seed.wrapping_add(u64::from(run))))
                })
            })
            .collect();
        let scores: Vec<f64> = jobs
            .into_par_iter()
            .map(|(candidate, scene, seed)| score(&population[candidate].values, scene, seed))
            .collect();
        let each = scores.len() / population.len().max(1);
        for (candidate, scores) in population.iter_mut().zip(scores.chunks(each.max(1))) {
            candidate.add(scores, runs);
        }
        seed = seed.wrapping_add(u64::from(runs));
        population.sort_by(|a, b| b.score.total_cmp(&a.score));
        population.truncate(usize::try_from(plan.survivors.max(1)).unwrap_or(usize::MAX));
        report(generation, &population);
        if generation + 1 == plan.generations {
            break;
        }
        let width = MUTATION * (1.0 - 0.5 * f64::from(generation) / f64::from(plan.generations));
        let survivors = population.len();
        while population.len() < usize::try_from(plan.candidates).unwrap_or(usize::MAX) {
            let (mother, father) = (drawing.index(survivors), drawing.index(survivors));
            let values = drawing.child(&population[mother].values, &population[father].values, width);
            population.push(Candidate::new(values, scenes));
        }
    }
    population
}

#[cfg(test)]
mod tests {
    use super::{Dimension, SearchPlan, search};

    #[test]
    fn finds_the_top_of_a_hill_and_says_the_same_twice() {
        let space = [Dimension::linear("x", -1.0, 3.0), Dimension::log("y", 0.01, 10.0)];
        let plan = SearchPlan { seed: 3, generations: 20, candidates: 20, survivors: 5, runs: 2 };
        // Two scenes that want different things, and a grain of noise that depends on the seed.
        let score = |values: &[f64], scene: usize, seed: u64| {
            let wish = if scene == 0 { 0.9 } else { 1.1 };
            let noise = if seed.is_multiple_of(2) { 0.001 } else { -0.001 };
            -(values[0] - wish).powi(2) - libm::log(values[1] / 0.2).powi(2) + noise
        };
        let find = || search(&space, &[3.0, 10.0], 2, &plan, score, |_, _| {});
        let found = find();
        let best = &found[0].values;
        assert!((best[0] - 1.0).abs() < 0.15 && (libm::log(best[1] / 0.2)).abs() < 0.3, "{best:?}");
        assert_eq!(found, find());
        assert_eq!(plan.total_runs(2), 1600);
    }

    #[test]
    fn values_stay_within_bounds() {
        let space = [Dimension::log("x", 0.1, 0.2)];
        let plan = SearchPlan { seed: 1, generations: 5, candidates: 10, survivors: 3, runs: 1 };
        let found = search(&space, &[0.2], 1, &plan, |values, _, _| values[0], |_, _| {});
        assert!(found.iter().all(|candidate| (0.1..=0.2 + 1e-12).contains(&candidate.values[0])));
    }
}
