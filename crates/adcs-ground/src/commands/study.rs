//! `adcs study`: how well the filters do.

use std::process::ExitCode;

use adcs_ground::study::campaign;
use adcs_ground::study::figures::Figures;
use adcs_ground::study::run::Flight;
use adcs_ground::study::scene::{Motion, PointingGains, Scene};
use anyhow::Result;

#[derive(Debug, clap::Args)]
pub struct Args {
    #[arg(long, default_value_t = 20)]
    flights: u64,
    #[arg(long)]
    only: Option<usize>,
}

pub fn run(args: &Args) -> Result<ExitCode> {
    let scenes = [
        ("tumble 3e-8", Scene::of(Motion::Tumble)),
        ("nadir 3e-8", Scene::of(Motion::Nadir(PointingGains::STIFF))),
        ("nadir soft", Scene::of(Motion::Nadir(PointingGains::SOFT))),
        ("tumble 3e-7", Scene { torque_n_m: 3e-7, ..Scene::of(Motion::Tumble) }),
        ("nadir 3e-7", Scene { torque_n_m: 3e-7, ..Scene::of(Motion::Nadir(PointingGains::STIFF)) }),
        ("tumble jump", Scene { dipole_jump_am2: 0.03, ..Scene::of(Motion::Tumble) }),
        ("nadir jump", Scene { dipole_jump_am2: 0.03, ..Scene::of(Motion::Nadir(PointingGains::STIFF)) }),
        ("tumble 10%", Scene { inertia_error: 0.10, ..Scene::of(Motion::Tumble) }),
        ("nadir 10%", Scene { inertia_error: 0.10, ..Scene::of(Motion::Nadir(PointingGains::STIFF)) }),
    ];
    for (index, (name, scene)) in scenes.iter().enumerate() {
        if args.only.is_some_and(|only| only != index) {
            continue;
        }
        let flights = campaign::fly(scene, args.flights, || ())?;
        let mut all = Flight::default();
        flights.iter().for_each(|flight| all.join(flight));
        println!("{name}: ratio {:.3} chosen {:.3} (bound {:.3}); eclipse over bound: dyn {:.3} mekf {:.3}",
            all.dynamic.eclipse.rms() / all.mekf.eclipse.rms(),
            all.chosen.eclipse.rms() / all.mekf.eclipse.rms(),
            all.dynamic_bound.eclipse.rms() / all.mekf_bound.eclipse.rms(),
            all.dynamic.eclipse.rms() / all.dynamic_bound.eclipse.rms(),
            all.mekf.eclipse.rms() / all.mekf_bound.eclipse.rms());
        for (name, f) in [("mekf", &all.mekf), ("  bound", &all.mekf_bound), ("dyn", &all.dynamic), ("  bound", &all.dynamic_bound), ("chosen", &all.chosen)] {
            line(name, f);
        }
        let worst = flights.iter().map(|f| f.dynamic.eclipse.rms().to_degrees()).fold(0.0, f64::max);
        println!("  worst flight eclipse {worst:.2}");
    }
    Ok(ExitCode::SUCCESS)
}

fn line(name: &str, f: &Figures) {
    println!("  {name:8} sunlit {:6.3} eclipse {:6.3} rate {:7.4} bias {:7.4} nees {:5.2} M {:.4?} without {} distrusted {} starts {}",
        f.sunlit.rms().to_degrees(), f.eclipse.rms().to_degrees(), f.rate.rms().to_degrees(), f.bias.rms().to_degrees(), f.nees.mean(), f.dipole, f.without, f.distrusted, f.starts);
}
