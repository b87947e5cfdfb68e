//! What mission files become.

use std::fs;

use adcs_core::control::b_dot::BDotGain;
use adcs_core::frames::{Body, MagnetometerAxes, Rotation, SunFaceAxes, Vector};
use adcs_core::sensing::SunFacesParameters;
use adcs_ground::mission;
use adcs_sim::scenario::{Readings, SensorTruth, SunFaceFault, SunFaceTruth, SunSensorsTruth};

use super::refused::assert_says;
use super::workshop::{MISSION, SATELLITE, Workshop, missions};

#[test]
fn every_mission_of_the_repository_loads() {
    let mut loaded = 0;
    for folder in ["sprout", "reference"] {
        for entry in fs::read_dir(missions().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            match mission::load(&path) {
                Ok(mission) => assert_eq!(Some(mission.name.as_ref()), path.file_stem()),
                Err(error) => panic!("{error}"),
            }
            loaded += 1;
        }
    }
    assert!(loaded >= 14, "only {loaded} missions");
}

#[test]
fn persons_units_become_si() {
    let mission = mission::load(missions().join(MISSION)).unwrap();
    let scenario = mission.scenario;
    assert_eq!(mission.name, "despin-calibrated");
    assert_eq!((scenario.cycles, scenario.flight.cycle_us), (2400, 500_000));
    assert_eq!(scenario.flight.schedule.on_us, 10_000_000);
    assert_eq!(scenario.flight.schedule.off_us, 2_500_000);
    assert_eq!(scenario.world.start.to_string(), "2015-11-19T03:31:21.392832Z");
    assert_eq!(scenario.world.omega_bi_rad_s, [3.573, 1.866, 8.175].map(f64::to_radians));
    assert_eq!(scenario.world.magnetometer.noise, 586e-9);
    assert_eq!(scenario.world.gyro.noise, 0.163_f64.to_radians());
    // 50,000 nT/V and 20 mV/(deg/s), as the drivers' own presets have them.
    assert_eq!(scenario.board, adcs_hal::driver_board::DriverBoardConfig::SPROUT);
    // And the Sun sensors as the flight software's own preset has them.
    assert_eq!(scenario.flight.sun_sensors, Some(SunFacesParameters::SPROUT));
    assert_eq!(scenario.world.sun_sensors.unwrap().noise_rad, 0.664_f64.to_radians());
    assert_eq!(scenario.readings, Readings::Drivers);
}

#[test]
fn a_satellite_without_sun_sensors_says_nothing_of_them() {
    let workshop = Workshop::new();
    let satellite = fs::read_to_string(missions().join(SATELLITE)).unwrap();
    let (before, sensors) = satellite.split_once("[sun_sensors]").unwrap();
    let (_, after) = sensors.split_once("[orbit]").unwrap();
    workshop.write(SATELLITE, format!("{before}[orbit]{after}"));
    let scenario = workshop.load().unwrap().scenario;
    assert_eq!((scenario.flight.sun_sensors, scenario.board.sun), (None, None));
    assert_eq!(scenario.world.sun_sensors, None);
}

#[test]
fn each_error_of_the_sun_sensors_is_switched_off_alone() {
    let workshop = Workshop::new();
    workshop.change(
        SATELLITE,
        "noise_deg = 0.664 ",
        "scale = [1, 1, 1, 1, 1, 0.5]\nmisalignment_deg = [[0, 0, 0], [0, 0, 0], [0, 0, 0], \
         [0, 0, 0], [0, 0, 90], [0, 0, 0]]\nfaults = [\"none\", \"dark\", \"stuck\", \"none\", \
         \"none\", \"none\"]\nnoise_deg = 0.664 ",
    );
    let with = |off: &str| {
        workshop.write(
            "sprout/some-off.toml",
            format!(
                "base = \"despin-calibrated.toml\"\n[mission]\ntitle = \"t\"\ndescription = \"d\"\n\
                 [sun_sensors.errors]\nswitched_off = [{off}]\n"
            ),
        );
        let mission = mission::load(workshop.folder.join("sprout/some-off.toml")).unwrap();
        mission.scenario.world.sun_sensors.unwrap()
    };
    let all = with("");
    let faults = all.faces.map(|face| face.fault);
    assert_eq!(faults[..3], [None, Some(SunFaceFault::Dark), Some(SunFaceFault::Stuck)]);
    assert_eq!(all.faces[5].full_sun_a, all.faces[0].full_sun_a / 2.0);
    // The face's axes turned by +90 deg about its z, which is Body's: its x is Body y.
    let axes: Rotation<Body, SunFaceAxes, f64> =
        Rotation::from_attitude_quaternion(all.faces[4].alignment_xyzw).unwrap();
    assert!((axes * Vector::new(1.0, 0.0, 0.0)).xyz.y > 1.0 - 1e-15);
    let faces = |change: &dyn Fn(usize, &mut SunFaceTruth)| {
        let mut faces = all.faces;
        faces.iter_mut().enumerate().for_each(|(number, face)| change(number, face));
        SunSensorsTruth { faces, ..all }
    };
    assert_eq!(with("\"noise\""), SunSensorsTruth { noise_rad: 0.0, ..all });
    assert_eq!(with("\"current_noise\""), SunSensorsTruth { current_noise_a: 0.0, ..all });
    assert_eq!(with("\"albedo\""), SunSensorsTruth { albedo: 0.0, ..all });
    assert_eq!(with("\"faults\""), faces(&|_, face| face.fault = None));
    let full_sun_a = all.faces[0].full_sun_a;
    assert_eq!(with("\"scale\""), faces(&|_, face| face.full_sun_a = full_sun_a));
    let straight = [0.0, 0.0, 0.0, 1.0];
    let aligned = faces(&|n, face| {
        face.alignment_xyzw = if n == 4 { straight } else { face.alignment_xyzw };
    });
    assert_eq!(with("\"misalignment\""), aligned);
}

#[test]
fn a_start_is_a_date_or_a_time_after_the_epoch() {
    let workshop = Workshop::new();
    let by_date = workshop.load().unwrap().scenario;
    workshop.change(MISSION, "utc = 2015-11-19T03:31:21.392832Z ", "after_tle_epoch_s = 2160 ");
    assert_eq!(workshop.load().unwrap().scenario, by_date);
    let quoted = Workshop::new();
    quoted.change(MISSION, "2015-11-19T03:31:21.392832Z", "\"2015-11-19T03:31:21.392832Z\"");
    assert_eq!(quoted.load().unwrap().scenario, by_date);
}

#[test]
fn the_normalised_law_and_none_have_their_own_keys() {
    let workshop = Workshop::new();
    workshop.change(
        MISSION,
        "kind = \"b-dot\"                        # m = k (ω × B)\ngain_am2_s_per_t = 100_000 ",
        "kind = \"b-dot-normalised\"\ngain_n_m_s = 1e-4 ",
    );
    let law = workshop.load().unwrap().scenario.flight.law;
    let gain = BDotGain::Normalised { gain_n_m_s: 1e-4 };
    assert_eq!(law, adcs_app::LawParameters::BDot(gain));
    let workshop = Workshop::new();
    workshop.change(MISSION, "kind = \"b-dot\" ", "kind = \"none\" ");
    let problem = workshop.problem();
    assert_says(&problem, "law.gain_am2_s_per_t", "no meaning with this kind", "remove it");
}

#[test]
fn bang_bang_takes_its_dipole_and_noise_from_the_satellite_and_cross_product_its_inertia() {
    const LAW: &str =
        "kind = \"b-dot\"                        # m = k (ω × B)\ngain_am2_s_per_t = 100_000 ";
    let workshop = Workshop::new();
    workshop.change(MISSION, LAW, "kind = \"bang-bang\"\ncut_hold = true\nrate = \"field\" ");
    let flight = workshop.load().unwrap().scenario.flight;
    let adcs_app::LawParameters::BangBang(law) = flight.law else { panic!("{:?}", flight.law) };
    assert_eq!((law.dipole_am2, law.dead_band_sigmas), (0.6, 3.0));
    assert!((law.field_noise_t - 5.86e-7).abs() < 1e-12);
    assert!((law.rate_noise_rad_s.to_degrees() - 0.163).abs() < 1e-6);
    assert!(flight.steering.cut_hold && flight.steering.feed_forward_sigma_am2.is_none());

    let workshop = Workshop::new();
    let pointing = "kind = \"cross-product\"\ntarget = \"nadir\"\nstiffness_n_m_per_rad = 1e-7\n\
                    damping_n_m_s = 2e-4\nresidual_dipole_sigma_am2 = 0.03 ";
    workshop.change(MISSION, LAW, pointing);
    let flight = workshop.load().unwrap().scenario.flight;
    let adcs_app::LawParameters::CrossProduct { law, .. } = flight.law else {
        panic!("{:?}", flight.law)
    };
    assert_eq!(law.inertia_kg_m2[0], [0.05184, 0.00058, -0.00077]);
    assert_eq!(flight.steering.feed_forward_sigma_am2, Some(0.03));
    workshop.change(MISSION, "damping_n_m_s = 2e-4\n", "damping_n_m_s = -2e-4\n");
    assert_says(&workshop.problem(), "law.damping_n_m_s", "must be positive", "");
}

#[test]
fn each_error_of_a_sensor_is_switched_off_alone() {
    let workshop = Workshop::new();
    workshop.change(
        SATELLITE,
        "noise_nt = 586 ",
        "matrix = [[1.1, 0, 0], [0, 1, 0], [0, 0, 1]]\nmisalignment_deg = [0, 0, 90]\nnoise_nt = 586 ",
    );
    workshop.change(SATELLITE, "bias_nt = [0, 0, 0]\noffset", "bias_nt = [100, 200, 300]\noffset");
    let with = |off: &str| {
        workshop.write(
            "sprout/some-off.toml",
            format!(
                "base = \"despin-calibrated.toml\"\n[mission]\ntitle = \"t\"\ndescription = \"d\"\n\
                 [magnetometer.errors]\nswitched_off = [{off}]\n"
            ),
        );
        mission::load(workshop.folder.join("sprout/some-off.toml")).unwrap().scenario.world
    };
    let all = with("");
    assert_eq!(all.magnetometer.bias, [100.0 / 1e9, 200.0 / 1e9, 300.0 / 1e9]);
    assert_eq!(all.magnetometer.matrix[0][0], 1.1);
    assert!(all.magnetometer.noise > 0.0 && all.magnetometer_offset_m.is_some());
    // Sensor axes turned by +90 deg about z: what the sensor calls x is Body y.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let [x, y, z, w] = all.magnetometer.alignment_xyzw;
    assert!(x.abs() + y.abs() + (z.abs() - half).abs() + (w - half).abs() < 1e-15);
    let axes: Rotation<Body, MagnetometerAxes, f64> =
        Rotation::from_attitude_quaternion(all.magnetometer.alignment_xyzw).unwrap();
    let x_in_body = axes * Vector::new(1.0, 0.0, 0.0);
    assert!((x_in_body.xyz.y - 1.0).abs() < 1e-15, "{x_in_body:?}");

    let perfect = SensorTruth::PERFECT;
    let without = |off: &str| (with(off).magnetometer, with(off).magnetometer_offset_m);
    let (m, offset) = (all.magnetometer, all.magnetometer_offset_m);
    assert_eq!(without("\"noise\""), (SensorTruth { noise: 0.0, ..m }, offset));
    assert_eq!(without("\"bias\""), (SensorTruth { bias: [0.0; 3], ..m }, offset));
    assert_eq!(without("\"matrix\""), (SensorTruth { matrix: perfect.matrix, ..m }, offset));
    let straight = SensorTruth { alignment_xyzw: perfect.alignment_xyzw, ..m };
    assert_eq!(without("\"misalignment\""), (straight, offset));
    assert_eq!(without("\"torquer_field\""), (m, None));
    let every = "\"noise\", \"bias\", \"matrix\", \"misalignment\", \"torquer_field\"";
    assert_eq!(without(every), (perfect, None));
}

#[test]
fn torquers_may_be_weaker_reversed_and_turned_than_the_flight_software_knows() {
    let workshop = Workshop::new();
    let nominal = workshop.load().unwrap().scenario;
    workshop.change(
        SATELLITE,
        "steps = 4200 ",
        "errors = { scale = [1.0, -1.0, 0.5], misalignment_deg = [0, 0, 90] }\nsteps = 4200 ",
    );
    let scenario = workshop.load().unwrap().scenario;
    assert_eq!(scenario.world.torquer_full_dipole_am2, [0.6, -0.6, 0.3]);
    assert_ne!(scenario.world.torquer_alignment_xyzw, nominal.world.torquer_alignment_xyzw);
    assert_eq!((scenario.flight, scenario.board), (nominal.flight, nominal.board));
}

#[test]
fn a_mission_overrides_its_base_key_by_key() {
    let mission = mission::load(missions().join("sprout/despin-on5.toml")).unwrap();
    let schedule = mission.scenario.flight.schedule;
    assert_eq!((schedule.on_us, schedule.off_us), (5_000_000, 2_500_000));
    assert_eq!(mission.files.len(), 3);
    let none = mission::load(missions().join("sprout/no-control.toml")).unwrap();
    // The gain that the base gives has no meaning any more, and is no problem.
    assert_eq!(none.scenario.flight.law, adcs_app::LawParameters::Off);
}

#[test]
fn the_readme_lists_every_key() {
    let readme = fs::read_to_string(missions().join("README.md")).unwrap();
    let sections = [
        "mission",
        "satellite",
        "torques",
        "orbit",
        "start",
        "law",
        "modes",
        "modes.detumble",
        "modes.experiment",
        "modes.commissioning",
        "commands",
        "schedule",
        "attitude",
        "torquers",
        "torquers.errors",
        "converter",
        "magnetometer",
        "magnetometer.calibration",
        "magnetometer.errors",
        "gyro",
        "gyro.calibration",
        "gyro.errors",
        "sun_sensors",
        "sun_sensors.calibration",
        "sun_sensors.errors",
        "simulation",
    ];
    let mut keys = 0;
    for section in sections {
        assert!(readme.contains(&format!("`[{section}]`")), "[{section}]");
        let workshop = Workshop::new();
        workshop.write(
            "sprout/odd.toml",
            format!(
                "base = \"despin-calibrated.toml\"\nmission.title = \"t\"\n\
                 mission.description = \"d\"\n{section}.odd_one_out = 1\n"
            ),
        );
        let error = mission::load(workshop.folder.join("sprout/odd.toml")).unwrap_err();
        // Sections that were not there may miss keys besides.
        let mut advice = error.problems.iter().map(|problem| &problem.advice);
        let known = advice.find_map(|advice| advice.strip_prefix("known here: "));
        let known = known.unwrap_or_else(|| panic!("{error}"));
        for key in known.split(", ") {
            let is_section = sections.contains(&format!("{section}.{key}").as_str());
            assert!(is_section || readme.contains(&format!("`{key}`")), "{section}.{key}");
            keys += 1;
        }
    }
    assert!(keys > 80, "only {keys} keys");
}

#[test]
fn the_readmes_own_mission_flies() {
    let readme = fs::read_to_string(missions().join("README.md")).unwrap();
    let (_, example) = readme.split_once("```toml\n").unwrap();
    let (example, _) = example.split_once("```").unwrap();
    let workshop = Workshop::new();
    workshop.write("mine.toml", example);
    let mission = mission::load(workshop.folder.join("mine.toml")).unwrap();
    let gain = BDotGain::Plain { gain_am2_s_per_t: 5e4 };
    assert_eq!(mission.scenario.flight.law, adcs_app::LawParameters::BDot(gain));
    assert_eq!(mission.name, "mine");
}
