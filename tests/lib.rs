//! Helpers shared by the scenario tests: flying a mission file, and reading reference tables.

use std::path::{Path, PathBuf};

use adcs_core::commissioning::{CommissioningParameters, StepTime};
use adcs_ground::mission::{self, Mission};
use adcs_hal::fault::Fault;
use adcs_link::{CycleRecord, Message, TruthRecord};
use adcs_sim::fly::{self, Outcome};
use adcs_sim::scenario::Scenario;
use nalgebra::Vector3;

/// The path of a file of the repository.
pub fn repository(path: impl AsRef<Path>) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The mission `missions/NAME.toml`, which must load.
pub fn mission(name: &str) -> Mission {
    match mission::load(repository("missions").join(name).with_extension("toml")) {
        Ok(mission) => mission,
        Err(error) => panic!("{error}"),
    }
}

/// A whole flight, cycle by cycle.
pub struct Flight {
    /// The truth at the start of each cycle.
    pub truth: Vec<TruthRecord>,
    /// What the satellite made of it.
    pub records: Vec<CycleRecord>,
    /// How it ended.
    pub outcome: Outcome,
    cycle_us: u32,
}

/// Flies a scenario on the host.
pub fn fly(scenario: &Scenario) -> Flight {
    fly_with_faults(scenario, &[])
}

/// Flies a scenario on the host with sensors that fail.
pub fn fly_with_faults(scenario: &Scenario, faults: &[Fault]) -> Flight {
    let (mut truth, mut records) = (Vec::new(), Vec::new());
    let flown = fly::fly_with_faults(scenario, faults, |message| {
        match message {
            Message::Truth(state) => truth.push(*state),
            Message::Cycle(record) => records.push(*record),
            Message::Hello(_) | Message::End(_) => {}
        }
        Ok::<(), ()>(())
    });
    let outcome = flown.unwrap_or_else(|stopped| panic!("{stopped:?}"));
    Flight { truth, records, outcome, cycle_us: scenario.flight.cycle_us }
}

impl Flight {
    /// Seconds of a cycle since the start.
    pub fn time_s(&self, cycle: u32) -> f64 {
        f64::from(cycle) * f64::from(self.cycle_us) * 1e-6
    }

    /// The truth at `time_s`, which must be the instant of a cycle.
    pub fn truth_at(&self, time_s: f64) -> &TruthRecord {
        self.truth
            .iter()
            .find(|truth| (self.time_s(truth.cycle) - time_s).abs() < 1e-9)
            .unwrap_or_else(|| panic!("no cycle at {time_s} s"))
    }

    /// The true rate at `time_s`, Body, deg/s.
    pub fn rate_deg_s(&self, time_s: f64) -> Vector3<f64> {
        Vector3::from(self.truth_at(time_s).omega_bi_rad_s).map(f64::to_degrees)
    }

    /// |ω| at the end over |ω| at the start.
    pub fn rate_ratio(&self) -> f64 {
        let norm = |truth: Option<&TruthRecord>| {
            Vector3::from(truth.expect("a flight has cycles").omega_bi_rad_s).norm()
        };
        norm(self.truth.last()) / norm(self.truth.first())
    }
}

/// A reference table: rows with columns by name.
pub struct Table {
    headers: csv::StringRecord,
    rows: Vec<csv::StringRecord>,
}

/// One row of a [`Table`].
pub struct Row<'t> {
    headers: &'t csv::StringRecord,
    row: &'t csv::StringRecord,
}

impl Table {
    /// Reads `tests/data/PATH`.
    pub fn read(path: &str) -> Self {
        let path = repository("tests/data").join(path);
        let mut reader =
            csv::Reader::from_path(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let headers = reader.headers().expect("a header").clone();
        let rows = reader.records().collect::<Result<_, _>>().expect("rows as long as the header");
        Self { headers, rows }
    }

    /// The rows in order.
    pub fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|row| Row { headers: &self.headers, row })
    }
}

impl Row<'_> {
    /// The text in a column.
    pub fn text(&self, column: &str) -> &str {
        let index = self.headers.iter().position(|header| header == column);
        index.and_then(|index| self.row.get(index)).unwrap_or_else(|| panic!("no column {column}"))
    }

    /// The number in a column.
    pub fn number(&self, column: &str) -> f64 {
        let text = self.text(column);
        text.parse().unwrap_or_else(|_| panic!("{column}: {text} is no number"))
    }

    /// The numbers in several columns.
    pub fn numbers<const N: usize>(&self, columns: [&str; N]) -> [f64; N] {
        columns.map(|column| self.number(column))
    }
}

/// The mission `sprout/commissioning` with rungs of minutes and gates that these pass.
pub fn brief_commissioning() -> Scenario {
    let mut scenario = mission("sprout/commissioning").scenario;
    let modes = scenario.flight.modes.as_mut().expect("the mission has modes");
    let ladder = modes.commissioning.as_mut().expect("the mission has a ladder");
    let brief = |least_s| StepTime { least_s, most_s: 600.0 };
    *ladder = CommissioningParameters {
        magnetometer: brief(200.0),
        coupling: brief(60.0),
        gyro: brief(100.0),
        sun: brief(60.0),
        momentum: brief(200.0),
        scale_sigma: 0.05,
        bias_sigma_t: 2e-6,
        coupling_sigma_t_per_am2: 1e-5,
        gyro_sigma_rad_s: 0.01,
        sun_sigma_rad: 0.05,
        dipole_sigma_am2: 0.2,
        inertia_sigma: 0.2,
        ..*ladder
    };
    scenario.cycles = 2_800;
    scenario
}
