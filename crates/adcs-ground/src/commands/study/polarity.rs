//! `adcs study polarity`: wrong wirings and dead torquers against guard and check.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

use adcs_core::modes::Cause;
use adcs_core::polarity::PolarityParameters;
use adcs_ground::study::campaign::fly_all;
use adcs_ground::study::closed_loop::{Conditions, Device, Fault, Sampling, StartingRate};
use adcs_ground::study::despin::{quantile, share};
use adcs_ground::study::polarity::pointing::{Naming, Pointed, Trouble, fly_pointing, troubles};
use adcs_ground::study::polarity::{
    CheckFigures, Checked, DEAD, DeadFigures, GuardFigures, Guarded, conditions, dead_name, faults,
    fly_check, fly_guarded, told_of_errors, with_all_errors,
};
use anyhow::{Context as _, Result};

use super::super::console::print;
use super::{finish, flown, orbits, table, write};

const HELP: &str = "\
SPROUT's preset A2 with the paper's sensors, inertia told 5 % wrong, about any axis, anywhere within two days.
Magnetometer, gyro or torquers are wired in each of the 47 wrong ways (signed permutations of the axes).

  guard         B-dot is flown for 1200 s under the guard, which has listened before (--listen), and once
                without. Harmful are the wirings with which the energy then grows.
  check         the active check alone: a pulse of a torquer each round until the wiring is known
  dead          one torquer, or all, obey and do nothing: the same guard and check. Left over is the energy
                after 1200 s without guard, over that at the start
  sound         nothing is wrong: how often the guard stops control all the same, and what the check says
  pointing      nothing is wrong, but everything else is (case `everything` of `adcs study pointing`): from
                separation on, by the mode machine, until it has pointed for --orbits
  turns wrong   the same, and after one orbit of pointing one axis, or all, of a device is turned round,
                or one torquer, or all, die. Named by the guard that stops it, and by the active
                check that the ground commands then: right, the device alone right, wrong

Examples
  $ adcs study polarity
  $ adcs study polarity --flights 5 --sound 5000 --csv polarity.csv
  $ adcs study polarity --rate 1 --flights 1        slower: less to tell wirings apart by
  $ adcs study polarity --flights 0 --sound 0 --dead 50
  $ adcs study polarity --flights 0 --sound 5000 --first-seed 100001
  $ adcs study polarity --flights 0 --sound 5000 --listen 0 --all-errors
  $ adcs study polarity --flights 0 --sound 0 --pointing 200 --turns-wrong 20";

/// Wrong signs, exchanged axes, dead torquers: how fast they are stopped, how well they are named, false alarms
#[derive(Debug, clap::Args)]
#[command(after_help = HELP)]
pub struct Args {
    /// Flights of each wrong wiring of each device
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=10_000))]
    flights: u64,

    /// Flights with each torquer dead, and with all of them
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=10_000))]
    dead: u64,

    /// Flights of a satellite that is wired well
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    sound: u64,

    /// Flights of a satellite that is wired well, from separation to pointing
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
    pointing: u64,

    /// Flights of each device that turns wrong, and of torquers that die, while it points
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u64).range(0..=10_000))]
    turns_wrong: u64,

    /// How long it points, or from what has gone wrong on, orbits
    #[arg(long, default_value_t = 3.0, value_parser = orbits)]
    orbits: f64,

    /// The seed of the first flight of each kind; another one is another set of flights
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    first_seed: u64,

    /// Rate at the start, deg/s
    #[arg(long, default_value_t = 5.0, value_parser = rate)]
    rate: f64,

    /// How long the guard listens before the loop is closed, s
    #[arg(long, default_value_t = 125.0, value_parser = listen)]
    listen: f64,

    /// Odds at which the guard stops, natural logarithm
    #[arg(long, default_value_t = PolarityParameters::default().log_odds, value_parser = odds)]
    odds: f32,

    /// Everything else is wrong too, as in case `everything` of `adcs study pointing`
    #[arg(long)]
    all_errors: bool,

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

fn odds(text: &str) -> Result<f32, String> {
    within(text, 3.0..=100.0).map(|odds| odds as f32)
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
        let plain = conditions(self.rate, sampling, fault);
        if self.all_errors { with_all_errors(&plain) } else { plain }
    }

    /// What guard and check are told.
    fn parameters(&self) -> PolarityParameters {
        let told = PolarityParameters { log_odds: self.odds, ..PolarityParameters::default() };
        if self.all_errors { told_of_errors(&told) } else { told }
    }

    /// Its seed.
    fn seed(&self, number: u64) -> u64 {
        self.first_seed + number - 1
    }

    /// The wiring of flight number `number` of the faulty ones, counted from 1.
    fn fault(&self, faults: &[Fault], number: u64) -> Result<Fault> {
        let at = usize::try_from((number - 1) / self.flights)?;
        faults.get(at).copied().context("a wiring")
    }
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let mut table = table(args.csv.as_deref(), &COLUMNS)?;
    let parameters = args.parameters();
    let faults = faults();
    let count = faults.len() as u64 * args.flights;
    if count > 0 {
        let guarded = flown(count, |hear| {
            let fly = |number| {
                let conditions = args.conditions(Some(args.fault(&faults, number)?));
                fly_guarded(&conditions, &parameters, args.listen, args.seed(number), true)
            };
            fly_all(count, fly, hear)
        })?;
        show_guarded(&guarded);
        for (number, flight) in (args.first_seed..).zip(&guarded) {
            write(&mut table, &guarded_row("guard", number, flight))?;
        }
        let checked = flown(count, |hear| {
            let fly = |number| {
                let conditions = args.conditions(Some(args.fault(&faults, number)?));
                fly_check(&conditions, &parameters, args.seed(number))
            };
            fly_all(count, fly, hear)
        })?;
        show_checked(&Device::ALL.map(Some), &checked);
        for (number, check) in (args.first_seed..).zip(&checked) {
            write(&mut table, &checked_row(number, check))?;
        }
    }
    if args.dead > 0 {
        print(
            "\ndead             stopped by the guard within, %            left over      check   named, %            lasted, s",
        );
        print(
            "        flights    60 s   120 s   300 s  1200 s  named, %   median    95 %    right   wrong  median   95 %    all",
        );
    }
    for dead in DEAD.iter().filter(|_| args.dead > 0) {
        let conditions = Conditions { dead: *dead, ..args.conditions(None) };
        let guarded = flown(args.dead, |hear| {
            let fly = |number| {
                fly_guarded(&conditions, &parameters, args.listen, args.seed(number), true)
            };
            fly_all(args.dead, fly, hear)
        })?;
        let checked = flown(args.dead, |hear| {
            let fly = |number| fly_check(&conditions, &parameters, args.seed(number));
            fly_all(args.dead, fly, hear)
        })?;
        show_dead(dead_name(*dead), args.dead, &DeadFigures::of(&guarded, &checked));
        for (number, flight) in (args.first_seed..).zip(&guarded) {
            write(&mut table, &guarded_row("dead", number, flight))?;
        }
        for (number, check) in (args.first_seed..).zip(&checked) {
            write(&mut table, &checked_row(number, check))?;
        }
    }
    if args.sound > 0 {
        let conditions = args.conditions(None);
        let sound = flown(args.sound, |hear| {
            let fly = |number| {
                fly_guarded(&conditions, &parameters, args.listen, args.seed(number), false)
            };
            fly_all(args.sound, fly, hear)
        })?;
        show_sound(&sound, args.first_seed);
        let checked = flown(args.sound, |hear| {
            let fly = |number| fly_check(&conditions, &parameters, args.seed(number));
            fly_all(args.sound, fly, hear)
        })?;
        show_checked(&[None], &checked);
        for (number, check) in (args.first_seed..).zip(&checked) {
            write(&mut table, &checked_row(number, check))?;
        }
        for (number, flight) in (args.first_seed..).zip(&sound) {
            write(&mut table, &guarded_row("sound", number, flight))?;
        }
    }
    let pointed = point(args)?;
    for row in &pointed {
        write(&mut table, row)?;
    }
    finish(table)?;
    Ok(ExitCode::SUCCESS)
}

/// The flights that point, one row each.
fn point(args: &Args) -> Result<Vec<[String; 9]>> {
    let mut rows = Vec::new();
    let rate = StartingRate::AnyAxis(args.rate.to_radians());
    if args.pointing > 0 {
        let flights = flown(args.pointing, |hear| {
            let fly = |number| fly_pointing(rate, args.orbits, None, args.seed(number));
            fly_all(args.pointing, fly, hear)
        })?;
        show_pointing(&flights, args);
        rows.extend((args.first_seed..).zip(&flights).map(|it| pointed_row("pointing", it)));
    }
    if args.turns_wrong > 0 {
        print("\nturns wrong                     pointing ended by");
        print(
            "                      flights   guard (right device wrong) check (right device wrong)  error    rate  attitude  other   median   95 %    all, s   not ended",
        );
        for trouble in troubles() {
            let flights = flown(args.turns_wrong, |hear| {
                let fly =
                    |number| fly_pointing(rate, args.orbits, Some(trouble), args.seed(number));
                fly_all(args.turns_wrong, fly, hear)
            })?;
            show_turned(trouble, &flights);
            rows.extend((args.first_seed..).zip(&flights).map(|it| pointed_row("turned", it)));
        }
    }
    Ok(rows)
}

fn show_pointing(flights: &[Pointed], args: &Args) {
    let stopped = |flight: &&Pointed| matches!(flight.ended, Some((_, Cause::Miswired(_))));
    let alarms = flights.iter().filter(stopped).count();
    let pointed = flights.iter().filter(|flight| flight.began_s.is_some()).count();
    print(format_args!(
        "\npointing       {} flights from {} deg/s, {pointed} came to point: {alarms} stopped by the guard",
        flights.len(),
        args.rate
    ));
    for (seed, flight) in (args.first_seed..).zip(flights) {
        if let Some((t_s, cause)) = flight.ended {
            let from = if flight.began_s.is_some() { "pointing" } else { "power-on" };
            print(format_args!("  seed {seed}: {t_s:.0} s from {from} on, {}", named(cause)));
        }
    }
}

fn named(cause: Cause) -> String {
    match cause {
        Cause::Miswired(suspect) => suspect.to_string(),
        other => format!("{other:?}"),
    }
}

fn show_turned(trouble: Trouble, flights: &[Pointed]) {
    let [device, what] = trouble_cells(Some(trouble));
    let suspects = flights.iter().filter_map(|flight| match flight.left?.1.cause {
        Cause::Miswired(suspect) => Some(trouble.naming(suspect)),
        _ => None,
    });
    let checks = flights.iter().filter_map(|flight| match flight.checked? {
        Cause::Miswired(suspect) => Some(trouble.naming(suspect)),
        _ => None,
    });
    let named = |naming| suspects.clone().filter(|it| *it == naming).count();
    let checked = |naming| checks.clone().filter(|it| *it == naming).count();
    let mut by = BTreeMap::<&str, usize>::new();
    for (_, transition) in flights.iter().filter_map(|flight| flight.left) {
        let kind = match transition.cause {
            Cause::Miswired(_) => "guard",
            Cause::ErrorGrows => "error",
            Cause::RateGrows | Cause::Tumbling => "rate",
            Cause::AttitudeLost => "attitude",
            _ => "other",
        };
        *by.entry(kind).or_default() += 1;
    }
    let count = |kind| by.get(kind).copied().unwrap_or_default();
    let times = || flights.iter().filter_map(|flight| Some(flight.left?.0)).collect::<Vec<_>>();
    let after = |share| if times().is_empty() { f64::NAN } else { quantile(times(), share) };
    let on = flights.iter().filter(|flight| flight.left.is_none());
    let worst = on.clone().map(|flight| flight.mean_deg).fold(0.0, f64::max);
    let on = on.count();
    print(format_args!(
        "  {device:12} {what:12} {:4} {:7} {:6} {:6} {:5}  {:12} {:6} {:5}  {:7} {:7} {:9} {:6} {:8.0} {:6.0} {:9.0}   {on}, mean to {worst:.1} deg",
        flights.len(),
        count("guard"),
        named(Naming::Right),
        named(Naming::Device),
        named(Naming::Wrong),
        checked(Naming::Right),
        checked(Naming::Device),
        checked(Naming::Wrong),
        count("error"),
        count("rate"),
        count("attitude"),
        count("other"),
        after(0.5),
        after(0.95),
        after(1.0),
    ));
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

fn show_dead(name: &str, count: u64, of: &DeadFigures<'_>) {
    let within = |t_s| 100.0 * of.stopped_within(t_s);
    print(format_args!(
        "  {name:9} {count:4} {:7.1} {:7.1} {:7.1} {:7.1} {:9.1} {:8.2} {:7.2} {:8.1} {:7.1} {:7.0} {:6.0} {:6.0}",
        within(60.0),
        within(120.0),
        within(300.0),
        within(1200.0),
        100.0 * of.named_by_guard(),
        of.left_over(0.5),
        of.left_over(0.95),
        100.0 * of.named_by_check(),
        100.0 * of.misnamed_by_check(),
        of.lasted_s(0.5),
        of.lasted_s(0.95),
        of.lasted_s(1.0),
    ));
}

fn show_sound(flights: &[Guarded], first_seed: u64) {
    let alarms = flights.iter().filter(|flight| flight.stop.is_some()).count();
    let share = 100.0 * share(flights.iter().map(|flight| flight.stop.is_some()));
    print(format_args!(
        "\nsound          {alarms} of {} flights stopped, {share:.2} %",
        flights.len()
    ));
    for (seed, flight) in (first_seed..).zip(flights) {
        if let Some((t_s, suspect)) = flight.stop {
            print(format_args!("  seed {seed}: after {t_s} s, {suspect}"));
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

fn fault_cells(fault: Option<Fault>, dead: [bool; 3]) -> [String; 2] {
    match fault {
        Some(it) => [it.device.name().to_owned(), it.wiring.to_string()],
        None if dead == [false; 3] => [String::new(), String::new()],
        None => [Device::Torquers.name().to_owned(), dead_name(dead).to_owned()],
    }
}

fn trouble_cells(trouble: Option<Trouble>) -> [String; 2] {
    match trouble {
        Some(Trouble::Turned(fault)) => fault_cells(Some(fault), [false; 3]),
        Some(Trouble::Dead(dead)) => fault_cells(None, dead),
        None => fault_cells(None, [false; 3]),
    }
}

/// A row in the order of the header; an energy that there is none of is left empty.
fn row(campaign: &str, number: u64, told: [String; 4], energies: [Option<f64>; 3]) -> [String; 9] {
    let [device, wiring, after, verdict] = told;
    let [until_stop, largest, at_end] =
        energies.map(|it| it.map_or(String::new(), |ratio| ratio.to_string()));
    let (campaign, number) = (campaign.to_owned(), number.to_string());
    [campaign, number, device, wiring, after, verdict, until_stop, largest, at_end]
}

fn pointed_row(campaign: &str, (number, flight): (u64, &Pointed)) -> [String; 9] {
    let [device, wiring] = trouble_cells(flight.trouble);
    let left = flight.left.map(|(t_s, transition)| (t_s, transition.cause));
    let (after, verdict) =
        left.or(flight.ended).map_or((String::new(), "not ended".to_owned()), |(t_s, cause)| {
            (t_s.to_string(), named(cause))
        });
    row(campaign, number, [device, wiring, after, verdict], [None; 3])
}

fn guarded_row(campaign: &str, number: u64, flight: &Guarded) -> [String; 9] {
    let [device, wiring] = fault_cells(flight.fault, flight.dead);
    let (after, verdict) =
        flight.stop.map_or((String::new(), "not stopped".to_owned()), |(t_s, suspect)| {
            (t_s.to_string(), suspect.to_string())
        });
    let energies = [Some(flight.controlled), Some(flight.largest), flight.unguarded];
    row(campaign, number, [device, wiring, after, verdict], energies)
}

fn checked_row(number: u64, check: &Checked) -> [String; 9] {
    let [device, wiring] = fault_cells(check.fault, check.dead);
    let told = [device, wiring, check.t_s.to_string(), check.report.to_string()];
    row("check", number, told, [None, Some(check.largest), None])
}
