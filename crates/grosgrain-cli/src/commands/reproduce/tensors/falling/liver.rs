//! Fig. 1: a liver with two systems of veins, extracted from a scan.

use std::path::Path;

use grosgrain::homogenization::SimplexModel;
use grosgrain::io::mesh::read_mesh;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::Label;
use grosgrain::simplex::SimplexMesh;

use super::super::super::repository::MESHES;
use super::super::super::row::{Row, digits};
use super::super::super::{Findings, Study};
use super::Model;
use super::course;
use super::films::{Look, Recorder};
use super::moduli::median_young;
use super::pair::{Fall, Pair};
use super::stills;
use super::text::{self, Published};
use crate::commands::simulate::keep_or_warn;
use crate::failure::Failure;
use crate::outcome::failed;

/// Name of the artefact.
pub const NAME: &str = "liver";

const PUBLISHED: Published = Published {
    name: NAME,
    ratio: 100.0,
    words: "“about a hundred times faster than it would take to compute the elastic behavior on the fine mesh”, 640 of 200K tets",
};
const TITLE: &str = "a liver with its veins falls on the ground";
/// The fine mesh before its edges are halved, and the coarse one, in millimetres.
const FILES: [&str; 2] = ["liver_veins_mid.mesh", "liver_coarse.mesh"];
const MILLIMETRE: f64 = 1e-3;
const TISSUE: Label = Label(1);
/// Label, name and Young's modulus \[Pa\] of what there is.
const MATERIALS: [(Label, &str, f64); 3] =
    [(TISSUE, "liver", YOUNG), (Label(2), "vena cava", STIFF), (Label(3), "portal vein", STIFF)];
const YOUNG: f64 = 2e4;
const STIFF: f64 = 1e6;
const POISSON: f64 = 0.45;
const DENSITY: f64 = 1060.0;
const LOOK: Look = Look {
    name: NAME,
    title: "Liver with veins",
    materials: &[
        (1, "liver", [0xb8, 0x5c, 0x50]),
        (2, "vena cava", [0x3c, 0x6e, 0xb4]),
        (3, "portal vein", [0xe8, 0xc0, 0x5a]),
    ],
    view: None,
    sections: &[([0.0, -1.0, 0.0], &[2, 3], "Cut open, veins whole"), ([0.0, -1.0, 0.0], &[], "Section")],
    edges: false,
};
/// The ground yields to a pressure as a layer of tissue does that is as thick as a cell of the fine mesh.
const FALL: Fall = Fall { step: 2.5e-3, steps: 16, speed: 1.0, clearance: 0.002, stiffness: YOUNG / 0.004 };

fn read(study: &Study, name: &str) -> Result<SimplexMesh, Failure> {
    let file = MESHES.find(name, study.meshes.as_deref())?;
    let told = |path: &Path, error: &dyn std::fmt::Display| Failure::Failed(format!("{}: {error}", path.display()));
    let contents = read_mesh(&file).map_err(|error| told(&file, &error))?;
    contents.scaled(MILLIMETRE).into_mesh().map_err(|error| told(&file, &error))
}

fn materials() -> Result<MaterialTable, Failure> {
    let mut table = MaterialTable::new();
    for (label, name, young) in MATERIALS {
        let elasticity = IsotropicMaterial::new(young, POISSON).map_err(|error| failed(&error))?;
        table.insert(label, Material::linear(name, Elasticity::Isotropic(elasticity), DENSITY));
    }
    Ok(table)
}

/// Lets the liver fall.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let [veins, coarse] = FILES.map(|name| read(study, name));
    let fine = veins?.refined().map_err(|error| failed(&error))?;
    let model = SimplexModel::new(fine, &materials()?).map_err(|error| failed(&error))?;
    let pair = Pair::new(study, model, &coarse?)?;
    let mut recorder = study.folder.as_ref().map(|_| Recorder::new(&pair, &FALL, LOOK)).transpose()?;
    let course = course::run(study, &pair, &FALL, |seen| {
        recorder.iter_mut().for_each(|recorder| recorder.add(seen));
    })?;
    let text = format!(
        "Fig. 1 of kharevych2009numerical: {TITLE}\n{}\n{}\n{}",
        text::sizes(&pair),
        reinforcement(&pair),
        text::tables(study, &PUBLISHED, &FALL, &course)
    );
    let mut rows = text::rows(study, &PUBLISHED, &pair, &course);
    rows.extend(Model::COARSE.into_iter().enumerate().map(|(n, model)| Row {
        method: Some(model.name()),
        measured: Some(stiffness(&pair, n)),
        note: Some("“the veins act as reinforcement, rendering the liver stiffer”".into()),
        ..Row::new(study, NAME, "modulus over that of liver", "1")
    }));
    let mut written = Vec::new();
    if let (Some(folder), Some(recorder)) = (&study.folder, recorder) {
        written.extend(keep_or_warn(stills::write(&pair, &LOOK, folder), study.progress).into_iter().flatten());
        written.extend(recorder.write(&course, folder, study.progress));
    }
    Ok(Findings { rows, text, written, stopped: course.stopped })
}

/// Median modulus of a coarse model over that of liver.
fn stiffness(pair: &Pair, model: usize) -> f64 {
    median_young(&pair.coarse[model]) / YOUNG
}

fn reinforcement(pair: &Pair) -> String {
    let share = |label: Label| {
        let mesh = pair.fine.mesh();
        let cells = (0..mesh.cell_count()).filter(|cell| mesh.tags()[*cell] == label.0);
        100.0 * cells.map(|cell| mesh.measure(cell)).sum::<f64>() / mesh.total_measure()
    };
    let moduli: Vec<String> = Model::COARSE
        .into_iter()
        .enumerate()
        .map(|(n, model)| format!("{} {}", digits(stiffness(pair, n)), model.label()))
        .collect();
    format!(
        "veins take {:.1} % of the volume and are {} times stiffer; median modulus of the coarse cells over that of liver: {}",
        share(MATERIALS[1].0) + share(MATERIALS[2].0),
        STIFF / YOUNG,
        moduli.join(", ")
    )
}
