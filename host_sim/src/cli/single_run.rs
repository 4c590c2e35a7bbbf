//! One run: what is printed of it and written about it.

use controller_core::safety::StopCause;
use host_sim::contender::Contender;
use host_sim::mission::MissionResult;
use host_sim::run_log;
use host_sim::scenario::Scenario;
use serde_json::{Value, json};

use super::error::CliError;
use super::output::{OutputFolder, hex};
use super::table::{facts, millimetres, table};

/// The run and what made it: enough to repeat it.
pub struct SingleRun<'a> {
    pub scenario: &'a Scenario,
    pub controller: Contender,
    pub scalar: &'static str,
    pub result: &'a MissionResult,
}

/// Names of the files that [`SingleRun::write`] writes.
pub fn file_names(scenario: &Scenario) -> [String; 2] {
    [format!("{}.svg", scenario.name), format!("{}.csv", scenario.name)]
}

impl SingleRun<'_> {
    /// Writes figure and log; their paths.
    pub fn write(&self, folder: &OutputFolder) -> Result<Vec<String>, CliError> {
        let [svg, csv] = file_names(self.scenario);
        let label = format!("{}, seed {}", self.controller.name(), self.result.seed);
        let figure = run_log::figure(self.scenario, &label, self.result);
        let log = run_log::csv(&self.result.samples);
        Ok(vec![folder.write(&svg, figure.as_bytes())?, folder.write(&csv, log.as_bytes())?])
    }

    /// What it was and how it went.
    pub fn text(&self) -> String {
        let Self { scenario, result, .. } = self;
        let run =
            format!("seed {}, scalar {}, controller {}", result.seed, self.scalar, self.controller.name());
        let head = facts([
            ("scenario", format!("{}: {} ({})", scenario.name, scenario.title, scenario.source)),
            ("run", run),
        ]);
        let sums = facts([
            ("contacts", result.contacts.to_string()),
            ("path", format!("{:.2} m", result.way_m)),
            ("duration", format!("{:.1} s", result.duration_s)),
            ("state hash", hex(result.hash)),
        ]);
        format!("{head}\n{}\n{sums}", self.arrivals())
    }

    /// A line for each checkpoint, also for those that were not reached.
    fn arrivals(&self) -> String {
        let checkpoints = self.result.checkpoints.len();
        let mut rows = vec![["checkpoint", "x m", "y m", "error mm", "time s"].map(String::from).to_vec()];
        for (i, (x, y)) in self.result.checkpoints.iter().enumerate() {
            let name = if i + 1 == checkpoints { String::from("goal") } else { (i + 1).to_string() };
            let arrival = self.result.arrivals.get(i);
            let or_dash = |text: Option<String>| text.unwrap_or_else(|| String::from("-"));
            rows.push(vec![
                name,
                format!("{x:.3}"),
                format!("{y:.3}"),
                or_dash(arrival.map(|arrival| millimetres(arrival.error_m))),
                or_dash(arrival.map(|arrival| format!("{:.1}", arrival.t_s))),
            ]);
        }
        table(&rows)
    }

    /// One sentence.
    pub fn verdict(&self) -> String {
        let result = self.result;
        let tolerance = millimetres(self.scenario.tolerance_m);
        let tolerance = tolerance.trim_end_matches(".0");
        if result.success {
            return format!("ok: goal reached without contact, every checkpoint within {tolerance} mm\n");
        }
        let mut reasons = Vec::new();
        if !result.reached {
            reasons.push(format!("goal not reached within {} s", self.scenario.time_limit_s));
            reasons.extend(result.stopped.map(|cause| stop_text(cause).to_owned()));
        }
        if result.contacts > 0 {
            reasons.push(format!(
                "{} contact{}",
                result.contacts,
                if result.contacts == 1 { "" } else { "s" }
            ));
        }
        if result.arrivals.iter().any(|arrival| arrival.error_m >= self.scenario.tolerance_m) {
            reasons.push(format!("a checkpoint passed at {tolerance} mm or more"));
        }
        format!("FAILED: {}\n", reasons.join(", "))
    }

    /// The same for programs.
    pub fn json(&self, training: &Value, files: &[String]) -> Value {
        json!({
            "scenario": self.scenario.name,
            "seed": self.result.seed,
            "scalar": self.scalar,
            "controller": self.controller.name(),
            "training": training,
            "result": result_json(self.result),
            "files": files,
        })
    }
}

/// Why the safety gate stopped the wheels.
pub fn stop_text(cause: StopCause) -> &'static str {
    match cause {
        StopCause::EmergencyStop => "emergency stop",
        StopCause::NotArmed => "motors not armed",
        StopCause::UntrainedMap => "the map is untrained (learn for more --steps)",
        StopCause::ScanTooOld => "proximity sensors silent for too long",
        StopCause::CommandTooOld => "no command for too long",
        StopCause::Stalled => "a wheel stalled under way",
        StopCause::LinkSilent => "the link was silent for too long",
        StopCause::DeadlineMissed => "the board missed a deadline",
        StopCause::DriveInvalid => "the servo gave no usable drive",
    }
}

/// A result with its hash in hexadecimal: many readers of JSON have no 64-bit integers.
pub fn result_json(result: &MissionResult) -> Value {
    let mut value = json!(result);
    value["hash"] = json!(hex(result.hash));
    value
}
