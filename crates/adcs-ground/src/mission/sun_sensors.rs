//! Section `sun_sensors`: how the faces are made and wired, what the flight software takes them
//! for, and what they really do. A satellite without the section has none.

use adcs_core::frames::{Body, Rotation, SunFaceAxes};
use adcs_core::sensing::sun_faces::{CUBE_XYZW, FACES};
use adcs_core::sensing::{
    SunFaceError, SunFaceParameters, SunFaces, SunFacesError, SunFacesParameters,
};
use adcs_hal::analog_triad::ConverterConfig;
use adcs_hal::psd_face::{ConfigError, PsdFace, PsdFaceConfig};
use adcs_sim::scenario::{SunFaceFault, SunFaceTruth, SunSensorsTruth};

use super::misalignment;
use super::problem::Fault;
use super::section::Section;
use super::typed::{Check, POSITIVE, TURN_DEG};

const M_PER_MM: f64 = 1e-3;
const A_PER_UA: f64 = 1e-6;
const A_PER_NA: f64 = 1e-9;
const OHM_PER_KOHM: f64 = 1e3;

const LENGTH_MM: Check = Check::new(|x| x > 0.0 && x <= 100.0, "positive and at most 100 mm");
const HALF_CONE_DEG: Check = Check::new(|x| x > 0.0 && x < 90.0, "between 0 and 90 deg");
const FRACTION: Check = Check::new(|x| x > 0.0 && x < 1.0, "between 0 and 1");
const MULTIPLE: Check = Check::new(|x| x > 1.0 && x <= 10.0, "above 1 and at most 10");
const SIGMA_DEG: Check = Check::new(|x| x > 0.0 && x <= 30.0, "positive and at most 30 deg");
const NOISE_DEG: Check = Check::new(|x| (0.0..=30.0).contains(&x), "from 0 to 30 deg");
const NOISE_NA: Check = Check::new(|x| (0.0..=1e5).contains(&x), "from 0 to 100000 nA");
const ALBEDO: Check = Check::new(|x| (0.0..=1.0).contains(&x), "from 0 (black) to 1 (white)");
const DARK_V: Check = Check::new(|x| (0.0..=5.5).contains(&x), "from 0 to 5.5 V");
const SCALE: Check = Check::new(|x| (0.0..=10.0).contains(&x), "from 0 to 10");

/// The Sun sensors of a mission.
pub(super) struct SunSensors {
    pub wiring: [PsdFaceConfig; FACES],
    pub known: SunFacesParameters,
    pub truth: SunSensorsTruth,
}

/// `Some(None)` on a satellite without; `None` when something is wrong.
pub(super) fn sun_sensors(
    root: &Section,
    converter: Option<ConverterConfig>,
) -> Option<Option<SunSensors>> {
    let Some(section) = root.section_if_any("sun_sensors")? else { return Some(None) };
    let usual = SunFacesParameters::SPROUT;
    let cube = CUBE_XYZW.map(|xyzw| xyzw.map(f64::from));
    let alignment = section.quaternions_or("alignment_xyzw", cube);
    let active_length_mm = section.number("active_length_mm", LENGTH_MM);
    let height_mm = section.number("height_mm", LENGTH_MM);
    let half_cone_deg = section.number("half_cone_deg", HALF_CONE_DEG);
    let full_sun_ua = section.number("full_sun_ua", POSITIVE);
    let threshold = section.number("threshold", FRACTION);
    let sigma_deg = section.number("sigma_deg", SIGMA_DEG);
    let faintest = section.number_or("faintest", FRACTION, f64::from(usual.faintest));
    let brightest = section.number_or("brightest", MULTIPLE, f64::from(usual.brightest));
    let gate = section.number_or("gate", POSITIVE, f64::from(usual.gate));
    let dark_v = section.number("dark_v", DARK_V);
    let transimpedance_kohm = section.number("transimpedance_kohm", POSITIVE);
    let calibration = section.section_or_empty("calibration");
    let calibrated = calibration.and_then(|below| calibrated(&below, alignment?));
    let errors = section.section_or_empty("errors").map(|below| errors(&below));
    section.finish();

    let (active_length_m, height_m) = (active_length_mm? * M_PER_MM, height_mm? * M_PER_MM);
    let (full_sun_a, half_cone_rad) = (full_sun_ua? * A_PER_UA, half_cone_deg?.to_radians());
    let (alignment, threshold) = (alignment?, threshold?);
    let known = SunFacesParameters {
        faces: calibrated?.map(|xyzw| SunFaceParameters {
            alignment_xyzw: xyzw.map(|x| x as f32),
            active_length_m: active_length_m as f32,
            height_m: height_m as f32,
            full_sun_a: full_sun_a as f32,
            threshold: threshold as f32,
            half_cone_rad: half_cone_rad as f32,
        }),
        sigma_rad: sigma_deg?.to_radians() as f32,
        faintest: faintest? as f32,
        brightest: brightest? as f32,
        gate: gate? as f32,
    };
    accept(&section, &known);
    let (dark_v, transimpedance_ohm) = (dark_v? as f32, transimpedance_kohm? * OHM_PER_KOHM);
    let wiring = PsdFaceConfig::SPROUT.map(|face| PsdFaceConfig {
        dark_v,
        transimpedance_ohm: transimpedance_ohm as f32,
        ..face
    });
    accept_wiring(&section, &wiring, converter?);

    let Errors { noise_rad, current_noise_a, albedo, scale, turned_deg, faults } = errors??;
    let face = |face: usize| {
        let nominal: Rotation<Body, SunFaceAxes, f64> =
            Rotation::from_attitude_quaternion(alignment[face])?;
        let alignment_xyzw = match misalignment::<SunFaceAxes>(turned_deg[face], false) {
            None => alignment[face],
            Some(turned) => (nominal * turned).attitude_quaternion(),
        };
        let full_sun_a = full_sun_a * scale[face];
        let fault = faults[face];
        Some(SunFaceTruth {
            alignment_xyzw,
            active_length_m,
            height_m,
            full_sun_a,
            half_cone_rad,
            fault,
        })
    };
    let faces = [face(0)?, face(1)?, face(2)?, face(3)?, face(4)?, face(5)?];
    let truth = SunSensorsTruth { faces, noise_rad, current_noise_a, albedo };
    Some(Some(SunSensors { wiring, known, truth }))
}

/// How the flight software takes the faces to be mounted. `drawn` is how they should be, and really are but for
/// their errors.
fn calibrated(section: &Section, drawn: [[f64; 4]; FACES]) -> Option<[[f64; 4]; FACES]> {
    let alignment = section.quaternions_or("alignment_xyzw", drawn);
    section.finish();
    alignment
}

fn accept(section: &Section, known: &SunFacesParameters) {
    let Err(error) = SunFaces::new(known) else { return };
    let key = match error {
        SunFacesError::Face { error: SunFaceError::HalfCone { .. }, .. } => "half_cone_deg",
        SunFacesError::Face { error: SunFaceError::FullSun { .. }, .. } => "full_sun_ua",
        SunFacesError::Sigma { .. } => "sigma_deg",
        SunFacesError::Gate { .. } => "gate",
        _ => "height_mm",
    };
    section.refuse(key, Fault::new(error.to_string()));
}

fn accept_wiring(section: &Section, wiring: &[PsdFaceConfig; FACES], converter: ConverterConfig) {
    let refused = wiring.iter().find_map(|&face| PsdFace::new(face, converter).err());
    let Some(error) = refused else { return };
    let key = match error {
        ConfigError::Transimpedance { .. } => "transimpedance_kohm",
        _ => "dark_v",
    };
    section.refuse(key, Fault::new(error.to_string()));
}

/// Section `sun_sensors.errors`, what is switched off left out.
struct Errors {
    noise_rad: f64,
    current_noise_a: f64,
    albedo: f64,
    scale: [f64; FACES],
    turned_deg: [[f64; 3]; FACES],
    faults: [Option<SunFaceFault>; FACES],
}

fn errors(section: &Section) -> Option<Errors> {
    const FAULTS: &[(&str, Option<SunFaceFault>)] =
        &[("none", None), ("dark", Some(SunFaceFault::Dark)), ("stuck", Some(SunFaceFault::Stuck))];
    const WORDS: &[(&str, &str)] = &[
        ("noise", "noise"),
        ("current_noise", "current_noise"),
        ("albedo", "albedo"),
        ("scale", "scale"),
        ("misalignment", "misalignment"),
        ("faults", "faults"),
    ];
    let noise_deg = section.number_or("noise_deg", NOISE_DEG, 0.0);
    let current_noise_na = section.number_or("current_noise_na", NOISE_NA, 0.0);
    let albedo = section.number_or("albedo", ALBEDO, 0.0);
    let scale = section.numbers_or("scale", SCALE, [1.0; FACES]);
    let turned_deg = section.vectors_or("misalignment_deg", TURN_DEG, [[0.0; 3]; FACES]);
    let faults = section.words_or("faults", FAULTS, [None; FACES]);
    let off = section.choices("switched_off", WORDS);
    section.finish();

    let off = off?;
    let on = |word| !off.contains(&word);
    Some(Errors {
        noise_rad: noise_deg.map(|x| if on("noise") { x.to_radians() } else { 0.0 })?,
        current_noise_a: current_noise_na
            .map(|x| if on("current_noise") { x * A_PER_NA } else { 0.0 })?,
        albedo: albedo.map(|x| if on("albedo") { x } else { 0.0 })?,
        scale: scale.map(|x| if on("scale") { x } else { [1.0; FACES] })?,
        turned_deg: turned_deg.map(|x| if on("misalignment") { x } else { [[0.0; 3]; FACES] })?,
        faults: faults.map(|x| if on("faults") { x } else { [None; FACES] })?,
    })
}
