//! What was flown, in a person's units.

use adcs_app::LawParameters;
use adcs_core::control::b_dot::BDotGain;
use adcs_core::control::guidance::{AimParameters, GuidanceParameters};
use adcs_core::sensing::TriadParameters;
use adcs_sim::devices::SpiFault;
use adcs_sim::scenario::{Readings, Scenario, SensorTruth, WorldParameters};

use crate::mission::Mission;

/// One heading and one text for each fact.
pub fn facts(mission: &Mission) -> Vec<(&'static str, String)> {
    let scenario = &mission.scenario;
    let world = &scenario.world;
    let files = mission.files.iter().map(|file| file.display().to_string());
    let mut facts = vec![
        ("files", files.collect::<Vec<_>>().join(", built on ")),
        ("law", law(scenario.flight.law)),
        (
            "schedule",
            format!(
                "torquers on {} s, off {} s; cycle {} s",
                seconds(scenario.flight.schedule.on_us),
                seconds(scenario.flight.schedule.off_us),
                seconds(scenario.flight.cycle_us)
            ),
        ),
        ("start", world.start.to_string()),
        (
            "attitude at the start",
            format!("q = ({}), Eci to Body, scalar last", list(&world.attitude_xyzw)),
        ),
        (
            "rate at the start",
            format!("({}) deg/s", rounded(world.omega_bi_rad_s.map(f64::to_degrees))),
        ),
        ("mass", format!("{} kg", mission.mass_kg)),
    ];
    let rows = world.inertia_kg_m2.map(|row| format!("[{}]", list(&row)));
    facts.push(("inertia", format!("[{}] kg·m²", rows.join(", "))));
    facts.push(("inertia", mission.inertia_source.clone()));
    facts.push(("torques that act", torques(scenario)));
    facts.push((
        "torquers",
        format!(
            "±{} A·m² each, {} steps",
            scenario.flight.torquers.max_dipole_am2, world.torquer_steps
        ),
    ));
    facts.push(("readings", readings(scenario).to_owned()));
    if scenario.readings == Readings::Drivers {
        let nt = |t: f64| t * 1e9;
        facts.push(("magnetometer", sensor(&world.magnetometer, "nT", nt)));
        facts.push(("magnetometer", calibration(&scenario.flight.magnetometer, "nT", nt)));
        facts.push((
            "magnetometer",
            match world.magnetometer_offset_m {
                Some(offset) => {
                    format!("feels the torquers, which sit at −({}) m from it", list(&offset))
                }
                None => "does not feel the torquers".to_owned(),
            },
        ));
        facts.push(("gyros", sensor(&world.gyro, "deg/s", f64::to_degrees)));
        facts.push(("gyros", calibration(&scenario.flight.gyro, "deg/s", f64::to_degrees)));
        facts.push(("Sun sensors", sun_sensors(world)));
        facts.push(("seed of the noise", world.seed.to_string()));
    }
    facts.push(("orbit", mission.tle[0].clone()));
    facts.push(("orbit", mission.tle[1].clone()));
    facts.push(("step of the truth", format!("{} s", seconds(world.step_us))));
    facts
}

fn sun_sensors(world: &WorldParameters) -> String {
    let Some(sensors) = &world.sun_sensors else { return "none".to_owned() };
    let broken = sensors.faces.iter().filter(|face| face.fault.is_some()).count();
    format!(
        "noise {:.3} deg, albedo of the Earth {}, {broken} of six faces broken",
        sensors.noise_rad.to_degrees(),
        sensors.albedo
    )
}

fn law(law: LawParameters) -> String {
    match law {
        LawParameters::Off => "none: the torquers stay off".to_owned(),
        LawParameters::BDot(BDotGain::Plain { gain_am2_s_per_t }) => {
            format!("B-dot, m = k (ω × B), k = {gain_am2_s_per_t} A·m²·s/T")
        }
        LawParameters::BDot(BDotGain::Normalised { gain_n_m_s }) => {
            format!("B-dot normalised, m = K (ω × B) / |B|², K = {gain_n_m_s} N·m·s")
        }
        LawParameters::BangBang(law) => format!(
            "B-dot by sign, {} A·m² on each axis beyond {} σ of its noise",
            law.dipole_am2, law.dead_band_sigmas
        ),
        LawParameters::CrossProduct { law, guidance } => format!(
            "cross-product, m = (B × u) / |B|², K_p = {:e} N·m/rad, K_d = {:e} N·m·s, towards {}",
            law.stiffness_n_m_per_rad,
            law.damping_n_m_s,
            target(&guidance)
        ),
        LawParameters::Periodic { law, guidance, .. } => format!(
            "periodic optimal, weights {:.3} deg, {:.4} deg/s, {} A·m², {} s ahead, towards {}",
            f64::from(law.attitude_weight_rad).to_degrees(),
            f64::from(law.rate_weight_rad_s).to_degrees(),
            law.dipole_weight_am2,
            law.horizon_s,
            target(&guidance)
        ),
    }
}

/// Where a law points.
fn target(guidance: &GuidanceParameters) -> String {
    let aim = match guidance.aim {
        AimParameters::Nadir => "nadir".to_owned(),
        AimParameters::Inertial { attitude_xyzw } => {
            format!("the attitude ({})", list(&attitude_xyzw))
        }
        AimParameters::Sun(aim) => {
            let spin = f64::from(aim.spin_rad_s).to_degrees();
            let spin =
                if spin == 0.0 { String::new() } else { format!(", spinning at {spin:.3} deg/s") };
            format!("the Sun with ({}){spin}", list(&aim.axes.boresight))
        }
        AimParameters::Site(site) => format!(
            "the place at {:.4} deg north, {:.4} deg east with ({}), or nadir",
            site.latitude_rad.to_degrees(),
            site.longitude_rad.to_degrees(),
            list(&site.axes.boresight)
        ),
    };
    match guidance.slew_rad_s {
        Some(rate) => format!("{aim}, led there at {:.3} deg/s", f64::from(rate).to_degrees()),
        None => aim,
    }
}

fn torques(scenario: &Scenario) -> String {
    let world = &scenario.world;
    let parts = [
        Some("torquers".to_owned()),
        world.residual_dipole_am2.map(|m| format!("residual dipole ({}) A·m²", list(&m))),
        world.gravity_gradient.then(|| "gravity gradient".to_owned()),
        world.drag.map(|drag| {
            format!(
                "drag (density {:e} kg/m³, coefficient {})",
                drag.density_kg_m3, drag.coefficient
            )
        }),
        world
            .solar_pressure
            .map(|sun| format!("solar pressure (reflectivity {})", sun.coefficient)),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn readings(scenario: &Scenario) -> &'static str {
    match (scenario.readings, scenario.converter_fault) {
        (Readings::Exact, _) => "exact: handed over without converter, noise or errors",
        (Readings::Drivers, None) => "through the drivers and register-level models of the chips",
        (Readings::Drivers, Some(SpiFault::Zeros)) => {
            "through the drivers; the converter's bus answers nothing"
        }
        (Readings::Drivers, Some(SpiFault::Ones)) => {
            "through the drivers; the converter answers all ones"
        }
        (Readings::Drivers, Some(SpiFault::Error)) => {
            "through the drivers; the converter's bus reports errors"
        }
    }
}

fn sensor(truth: &SensorTruth, unit: &str, to_unit: impl Fn(f64) -> f64) -> String {
    let mut text = format!(
        "really: noise {:.4} {unit}, bias ({}) {unit}",
        to_unit(truth.noise),
        rounded(truth.bias.map(&to_unit))
    );
    if truth.matrix != SensorTruth::PERFECT.matrix {
        let rows = truth.matrix.map(|row| format!("[{}]", list(&row)));
        text.push_str(&format!(", matrix [{}]", rows.join(", ")));
    }
    text
}

fn calibration(known: &TriadParameters, unit: &str, to_unit: impl Fn(f64) -> f64) -> String {
    let bias = known.bias.map(|bias| to_unit(f64::from(bias)));
    format!(
        "as the flight software takes it: scale ({}), bias ({}) {unit}",
        list(&known.scale),
        rounded(bias)
    )
}

fn seconds(micros: u32) -> f64 {
    f64::from(micros) / 1e6
}

fn list<T: ToString>(values: &[T]) -> String {
    values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// Without the last digits that a conversion of units leaves.
fn rounded(values: [f64; 3]) -> String {
    list(&values.map(|value| (value * 1e6).round() / 1e6))
}
