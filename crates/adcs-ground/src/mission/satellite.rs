//! Sections `satellite`, `torques` and `torquers`: the body and what turns it.

use adcs_core::control::allocation::{Allocation, TorquerParameters};
use adcs_core::frames::{Body, Rotation, TorquerAxes};
use adcs_sim::rigid_body::{Inertia, InertiaError};
use adcs_sim::scenario::{DragParameters, ShapeParameters, SolarPressureParameters};

use super::misalignment;
use super::problem::Fault;
use super::section::Section;
use super::typed::{Check, TURN_DEG};

/// From a black surface to a mirror.
const REFLECTIVITY: Check =
    Check::new(|x| (1.0..=2.0).contains(&x), "from 1 (black) to 2 (mirror)");
/// Drag coefficients of satellites lie between 2 and 4; flight below 1 or above 5 does not occur.
const DRAG: Check = Check::new(|x| (1.0..=5.0).contains(&x), "from 1 to 5");

/// Limits that no small satellite passes; what does is a slip of the unit or the decimal point.
const MASS_KG: Check = Check::new(|x| x > 0.0 && x <= 1e4, "positive and at most 10000 kg");
const SIDE_M: Check = Check::new(|x| x > 0.0 && x <= 100.0, "positive and at most 100 m");
const DISTANCE_M: Check = Check::new(|x| x.abs() <= 100.0, "within 100 m");
const DIPOLE_AM2: Check = Check::new(|x| x.abs() <= 1e3, "within 1000 A·m²");
const MAX_DIPOLE_AM2: Check = Check::new(|x| x > 0.0 && x <= 1e3, "positive and at most 1000 A·m²");
const DIPOLE_SCALE: Check = Check::new(|x| x != 0.0 && x.abs() <= 10.0, "not zero and within 10");
/// The air at 150 km.
const DENSITY_KG_M3: Check =
    Check::new(|x| (0.0..=2e-9).contains(&x), "from 0 to 2e-9 kg/m³, the air at 150 km");

/// The body.
pub(super) struct Satellite {
    pub mass_kg: f64,
    pub inertia_kg_m2: [[f64; 3]; 3],
    pub inertia_source: String,
    pub residual_dipole_am2: [f64; 3],
    pub drag_coefficient: f64,
    pub reflectivity: f64,
    pub shape: ShapeParameters,
}

pub(super) fn satellite(root: &Section) -> Option<Satellite> {
    let section = root.section("satellite")?;
    let mass_kg = section.number("mass_kg", MASS_KG);
    let inertia_kg_m2 = section.matrix("inertia_kg_m2");
    let inertia_source = section.text("inertia_source");
    let residual_dipole_am2 = section.vector("residual_dipole_am2", DIPOLE_AM2);
    let drag_coefficient = section.number("drag_coefficient", DRAG);
    let reflectivity = section.number("reflectivity", REFLECTIVITY);
    let sides_m = section.vector("sides_m", SIDE_M);
    let centre_of_pressure_m = section.vector("centre_of_pressure_m", DISTANCE_M);
    section.finish();

    let inertia_kg_m2 = inertia_kg_m2.filter(|rows| accept_inertia(&section, rows));
    if let (Some(mass_kg), Some(sides_m), Some(inertia)) = (mass_kg, sides_m, inertia_kg_m2) {
        compare_with_box(&section, &inertia, mass_kg, sides_m);
    }
    Some(Satellite {
        mass_kg: mass_kg?,
        inertia_kg_m2: inertia_kg_m2?,
        inertia_source: inertia_source?,
        residual_dipole_am2: residual_dipole_am2?,
        drag_coefficient: drag_coefficient?,
        reflectivity: reflectivity?,
        shape: ShapeParameters { sides_m: sides_m?, centre_of_pressure_m: centre_of_pressure_m? },
    })
}

fn accept_inertia(section: &Section, rows: &[[f64; 3]; 3]) -> bool {
    let key = "inertia_kg_m2";
    if let Some(axis) = (0..3).find(|&axis| rows[axis][axis] <= 0.0) {
        let reason = format!("{} is impossible: a moment of inertia is positive", rows[axis][axis]);
        section.refuse_at(section.place_within(key, &[axis, axis]), key, Fault::new(reason));
        return false;
    }
    let Err(error) = Inertia::new(*rows) else { return true };
    let (place, advice) = match error {
        InertiaError::NotSymmetric { row, column } => (
            section.place_within(key, &[row.into(), column.into()]),
            "a tensor of inertia is symmetric",
        ),
        InertiaError::NotPositive { .. } => {
            (section.place_of(key), "check the digits and the signs of the products")
        }
        InertiaError::Triangle { .. } => {
            (section.place_of(key), "check the digits and the signs of the products")
        }
        _ => (section.place_of(key), ""),
    };
    section.refuse_at(place, key, Fault::advising(format!("impossible: {error}"), advice));
    false
}

/// A box can have no larger moment about an axis than with all its mass in the corners,
/// m (b² + c²) / 4. What exceeds that was written in another unit.
fn compare_with_box(section: &Section, inertia: &[[f64; 3]; 3], mass_kg: f64, [a, b, c]: [f64; 3]) {
    for (axis, (first, second)) in [(b, c), (c, a), (a, b)].into_iter().enumerate() {
        let largest = mass_kg * (first * first + second * second) / 4.0;
        let found = inertia[axis][axis];
        if found > largest {
            let reason = format!(
                "impossible: {mass_kg} kg in a box of {a} x {b} x {c} m have at most \
                 {largest:.4} kg·m² about this axis, found {found}"
            );
            let place = section.place_within("inertia_kg_m2", &[axis, axis]);
            let advice = "is it in another unit than kg·m²?";
            section.refuse_at(place, "inertia_kg_m2", Fault::advising(reason, advice));
            return;
        }
    }
}

/// Which torques act.
pub(super) struct Torques {
    pub residual_dipole: bool,
    pub gravity_gradient: bool,
    pub drag: bool,
    pub solar_pressure: bool,
    air_density_kg_m3: f64,
}

impl Torques {
    pub fn residual_dipole_am2(&self, satellite: &Satellite) -> Option<[f64; 3]> {
        self.residual_dipole.then_some(satellite.residual_dipole_am2)
    }

    pub fn drag(&self, satellite: &Satellite) -> Option<DragParameters> {
        self.drag.then_some(DragParameters {
            density_kg_m3: self.air_density_kg_m3,
            coefficient: satellite.drag_coefficient,
        })
    }

    pub fn solar_pressure(&self, satellite: &Satellite) -> Option<SolarPressureParameters> {
        self.solar_pressure
            .then_some(SolarPressureParameters { coefficient: satellite.reflectivity })
    }
}

pub(super) fn torques(root: &Section) -> Option<Torques> {
    let section = root.section("torques")?;
    let residual_dipole = section.flag("residual_dipole");
    let gravity_gradient = section.flag("gravity_gradient");
    let drag = section.flag("drag");
    let solar_pressure = section.flag("solar_pressure");
    let density = "air_density_kg_m3";
    let air_density_kg_m3 = match drag {
        Some(true) => section.number(density, DENSITY_KG_M3),
        _ => section.number_or(density, DENSITY_KG_M3, 0.0),
    };
    section.finish();
    Some(Torques {
        residual_dipole: residual_dipole?,
        gravity_gradient: gravity_gradient?,
        drag: drag?,
        solar_pressure: solar_pressure?,
        air_density_kg_m3: air_density_kg_m3?,
    })
}

/// The torquers as the flight software knows them and as they are.
pub(super) struct Torquers {
    pub parameters: TorquerParameters,
    pub steps: u16,
    /// At full duty, with its sign, A·m².
    pub true_dipole_am2: [f64; 3],
    pub true_alignment_xyzw: [f64; 4],
}

pub(super) fn torquers(root: &Section) -> Option<Torquers> {
    let section = root.section("torquers")?;
    let max_dipole_am2 = section.number("max_dipole_am2", MAX_DIPOLE_AM2);
    let steps = section.integer("steps", 1..=i64::from(u16::MAX));
    let alignment = section.quaternion_or("alignment_xyzw", super::NO_ROTATION);
    let errors = section.section_or_empty("errors");
    section.finish();
    let errors = errors?;
    let scale = errors.vector_or("scale", DIPOLE_SCALE, [1.0; 3]);
    let turned = errors.vector_or("misalignment_deg", TURN_DEG, [0.0; 3]);
    let off =
        errors.choices("switched_off", &[("scale", "scale"), ("misalignment", "misalignment")]);
    errors.finish();

    let (max_dipole_am2, alignment, off) = (max_dipole_am2?, alignment?, off?);
    let parameters = TorquerParameters {
        max_dipole_am2: max_dipole_am2 as f32,
        alignment_xyzw: alignment.map(|x| x as f32),
    };
    if let Err(error) = Allocation::new(&parameters) {
        section.refuse("max_dipole_am2", Fault::new(error.to_string()));
    }
    let scale = if off.contains(&"scale") { [1.0; 3] } else { scale? };
    let nominal: Rotation<TorquerAxes, Body, f64> = Rotation::from_attitude_quaternion(alignment)?;
    let true_alignment_xyzw =
        match misalignment::<TorquerAxes>(turned?, off.contains(&"misalignment")) {
            None => alignment,
            Some(turned) => (turned.inverse() * nominal).attitude_quaternion(),
        };
    Some(Torquers {
        parameters,
        steps: steps? as u16,
        true_dipole_am2: scale.map(|scale| scale * max_dipole_am2),
        true_alignment_xyzw,
    })
}
