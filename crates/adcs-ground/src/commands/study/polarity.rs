//! `adcs study polarity`: wrong wirings against guard and check.

use std::path::PathBuf;
use std::process::ExitCode;

use adcs_core::polarity::PolarityParameters;
use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::closed_loop::{Conditions, Device, Fault, Sampling};
use adcs_ground::study::despin::share;
use adcs_ground::study::polarity::{
    CheckFigures, Checked, GuardFigures, Guarded, conditions, faults, fly_check, fly_guarded,
};
use anyhow::{Context as _, Result};

use super::super::console::print;
use super::{finish, flown, table, write};

const HELP: &str = "\
SPROUT's preset A2 with the paper's sensors, inertia told 5 % wrong, about any axis, anywhere within two days.
Magnetometer, gyro or torquers are wired in each of the 47 wrong ways (signed permutations of the axes).

  guard         B-dot is flown for 1200 s under the guard, which has listened before (--listen), and once
                without. Harmful are the wirings with which the energy then grows.
  check         the active check alone: a pulse of a torquer each round until the wiring is known
  sound         nothing is wrong: how often the guard stops control all the same, and what the check says

Examples
  $ adcs study polarity
  $ adcs study polarity --flights 5 --sound 5000 --csv polarity.csv
  $ adcs study polarity --rate 1 --flights 1        slower: less to tell wirings apart by";

/// Wrong signs and exchanged axes: how fast they are stopped, how well they are named, false alarms
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Flights of each wrong wiring of each device
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=10_000))]
    flights: u64,

    /// Flights of a satellite that is wired well
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    sound: u64,

    /// Rate at the start, deg/s
    #[arg(long, default_value_t = 5.0, value_parser = rate)]
    rate: f64,

    /// How long the guard listens before the loop is closed, s
    #[arg(long, default_value_t = 125.0, value_parser = listen)]
    listen: f64,

    /// The gyro is read in every cycle of 0.5 s instead of once a second
    #[arg(long)]
    gyro_every_cycle: bool,

    /// Also write one row a flight
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
}

fn rate(text: &str) -> Result<f64, String> {
    within(text, 0.0..=30.0)
}

fn listen(text: &str) -> Result<f64, String> {
    within(text, 0.0..=6000.0)
}

fn within(text: &str, range: std::ops::RangeInclusive<f64>) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if range.contains(&value) => Ok(value),
        _ => Err(format!("a number from {} to {} is wanted", range.start(), range.end())),
    }
}

impl Args {
    fn conditions(&self, fault: Option<Fault>) -> Conditions {
        let sampling =
            if self.gyro_every_cycle { Sampling::EveryCycle } else { Sampling::OnceASecond };
        conditions(self.rate, sampling, fault)
    }

    /// The wiring of flight number `number` of the faulty ones, counted from 1.
    fn fault(&self, faults: &[Fault], number: u64) -> Result<Fault> {
        let at = usize::try_from((number - 1) / self.flights)?;
        faults.get(at).copied().context("a wiring")
    }
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    let parameters = PolarityParameters::default();
    let faults = faults();
    let count = faults.len() as u64 * args.flights;
    if count > 0 {
        let guarded = flown(count, |hear| {
            let fly = |number| {
                let conditions = args.conditions(Some(args.fault(&faults, number)?));
                fly_guarded(&conditions, &parameters, args.listen, number, true)
            };
            fly_all(count, fly, hear)
        })?;
        show_guarded(&guarded);
        for (number, flight) in (1..).zip(&guarded) {
            write(&mut table, &guarded_row("guard", number, flight))?;
        }
        let checked = flown(count, |hear| {
            let fly = |number| {
                let conditions = args.conditions(Some(args.fault(&faults, number)?));
                fly_check(&conditions, &parameters, number)
            };
            fly_all(count, fly, hear)
        })?;
        show_checked(&Device::ALL.map(Some), &checked);
        for (number, check) in (1..).zip(&checked) {
            write(&mut table, &checked_row(number, check))?;
        }
    }
    if args.sound > 0 {
        let conditions = args.conditions(None);
        let sound = flown(args.sound, |hear| {
            let fly = |seed| fly_guarded(&conditions, &parameters, args.listen, seed, false);
            fly_all(args.sound, fly, hear)
        })?;
        show_sound(&sound);
        let checked = flown(args.sound, |hear| {
            let fly = |seed| fly_check(&conditions, &parameters, seed);
            fly_all(args.sound, fly, hear)
        })?;
        show_checked(&[None], &checked);
        for (number, check) in (1..).zip(&checked) {
            write(&mut table, &checked_row(number, check))?;
        }
        for (number, flight) in (1..).zip(&sound) {
            write(&mut table, &guarded_row("sound", number, flight))?;
        }
    }
    finish(table)?;
    Ok(ExitCode::SUCCESS)
}

fn show_guarded(flights: &[Guarded]) {
    print(
        "\nguard          harmful  stopped within, %               energy until the stop     to the end",
    );
    print(
        "               flights   60 s   120 s   300 s  1200 s   below 1.3, %   largest    largest",
    );
    for device in Device::ALL {
        let of = GuardFigures::of(device, flights);
        let within = |t_s| 100.0 * of.stopped_within(t_s);
        print(format_args!(
            "  {:12} {:8} {:6.1} {:7.1} {:7.1} {:7.1} {:14.1} {:9.2} {:10.2}",
            device.name(),
            of.count(),
            within(60.0),
            within(120.0),
            within(300.0),
            within(1200.0),
            100.0 * of.within_bounds(),
            of.largest_controlled(),
            of.largest(),
        ));
    }
}

fn show_checked(devices: &[Option<Device>], checks: &[Checked]) {
    print("\nactive check             named right, %   undecided     lasted, s            energy");
    print("                checks  device  wiring           %  median   95 %    all  largest");
    for device in devices {
        let of = CheckFigures::of(*device, checks);
        let lasted = |share| of.lasted_s(share);
        print(format_args!(
            "  {:12} {:8} {:7.1} {:7.1} {:11.1} {:7.0} {:6.0} {:6.0} {:8.2}",
            device.map_or("none", Device::name),
            of.count(),
            100.0 * of.device_named(),
            100.0 * of.wiring_named(),
            100.0 * of.undecided(),
            lasted(0.5),
            lasted(0.95),
            lasted(1.0),
            of.largest(),
        ));
    }
}

fn show_sound(flights: &[Guarded]) {
    let alarms = flights.iter().filter(|flight| flight.stop.is_some()).count();
    let share = 100.0 * share(flights.iter().map(|flight| flight.stop.is_some()));
    print(format_args!(
        "\nsound          {alarms} of {} flights stopped, {share:.2} %",
        flights.len()
    ));
    for (seed, flight) in (1..).zip(flights) {
        if let Some((t_s, suspect)) = flight.stop {
            print(format_args!("  flight {seed}: after {t_s} s, {suspect}"));
        }
    }
}

const COLUMNS: [&str; 9] = [
    "campaign",
    "flight",
    "device",
    "wiring",
    "after_s",
    "verdict",
    "largest_energy_until_stop",
    "largest_energy",
    "energy_at_end_unguarded",
];

fn fault_cells(fault: Option<Fault>) -> [String; 2] {
    fault.map_or([String::new(), String::new()], |it| {
        [it.device.name().to_owned(), it.wiring.to_string()]
    })
}

fn guarded_row(campaign: &str, number: u64, flight: &Guarded) -> [String; 9] {
    let [device, wiring] = fault_cells(flight.fault);
    let (after, verdict) =
        flight.stop.map_or((String::new(), "not stopped".to_owned()), |(t_s, suspect)| {
            (t_s.to_string(), suspect.to_string())
        });
    [
        campaign.to_owned(),
        number.to_string(),
        device,
        wiring,
        after,
        verdict,
        flight.controlled.to_string(),
        flight.largest.to_string(),
        flight.unguarded.map_or(String::new(), |ratio| ratio.to_string()),
    ]
}

fn checked_row(number: u64, check: &Checked) -> [String; 9] {
    let [device, wiring] = fault_cells(check.fault);
    [
        "check".to_owned(),
        number.to_string(),
        device,
        wiring,
        check.t_s.to_string(),
        check.report.to_string(),
        String::new(),
        check.largest.to_string(),
        String::new(),
    ]
}
