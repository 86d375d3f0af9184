//! Fig. 7: a wheel of cheese with holes of various sizes in one half.

use grosgrain::homogenization::SimplexModel;
use grosgrain::material::{Elasticity, IsotropicMaterial, Material, MaterialTable};
use grosgrain::mesh::Label;
use grosgrain::simplex::{Boundary, SimplexCylinder, SimplexMesh};
use grosgrain_picture::View;

use super::super::super::row::{Row, digits};
use super::super::super::{Findings, Study};
use super::Model;
use super::course::{self, Seen};
use super::films::{Look, Recorder};
use super::moduli::mean_compliance;
use super::pair::{Fall, Pair};
use super::stills;
use super::text::{self, Published};
use crate::commands::simulate::keep_or_warn;
use crate::failure::Failure;
use crate::outcome::failed;
use crate::results;

/// Name of the artefact.
pub const NAME: &str = "cheese";

const PUBLISHED: Published = Published {
    name: NAME,
    ratio: 150.0,
    words: "“the coarse animation runs 150 times faster than the fine one”, 200 of 35K tets",
};
const TITLE: &str = "a wheel of cheese with holes in one half falls flat";
const LOOK: Look = Look {
    name: NAME,
    title: "Cheese with holes in one half",
    materials: &[(0, "cheese", [0xf2, 0xc8, 0x4b])],
    view: Some(View { toward: [-0.85, 0.3, -0.45], up: [0.0, 0.0, 1.0], perspective: 0.35 }),
    sections: &[([1.0, 0.0, 0.0], &[], "Section upright"), ([0.0, 0.0, 1.0], &[], "Section level")],
    edges: true,
};

/// Radius and height \[m\].
const RADIUS: f64 = 0.15;
const HEIGHT: f64 = 0.08;
/// Radii \[m\] of holes and how many are wished of each; those that find no room are left out.
const HOLES: [(f64, usize); 5] = [(0.030, 6), (0.024, 4), (0.018, 10), (0.014, 20), (0.011, 30)];
/// Least distance \[m\] between holes, and of holes from the outside: about an edge of the fine mesh. Holes that are closer than the edges between them join.
const GAP: f64 = 0.009;
/// Least distance \[m\] of holes from the other half.
const MARGIN: f64 = 0.004;
/// Places that are tried for a hole.
const TRIES: usize = 20_000;
/// Irrational steps of a sequence that fills a cube evenly, powers of the inverse of the root of x⁴ = x + 1.
const STEPS: [f64; 3] = [0.819_172_513_396_164_5, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];

/// So soft that the wheel sags under its weight \[Pa\].
const YOUNG: f64 = 1e4;
const POISSON: f64 = 0.4;
const DENSITY: f64 = 1000.0;
/// The ground yields to a pressure as a layer of the fine mesh does.
const FALL: Fall = Fall { step: 2.5e-3, steps: 40, speed: 0.3, clearance: 0.002, stiffness: YOUNG * 8.0 / HEIGHT };

/// The halves of the wheel, y above and below zero.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Half {
    Holed,
    Solid,
}

impl Half {
    const ALL: [Self; 2] = [Self::Holed, Self::Solid];

    const fn name(self) -> &'static str {
        match self {
            Self::Holed => "holed half",
            Self::Solid => "solid half",
        }
    }

    fn has(self, at: [f64; 3]) -> bool {
        (at[1] > 0.0) == (self == Self::Holed)
    }
}

/// A ball that is not cheese.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hole {
    centre: [f64; 3],
    radius: f64,
}

impl Hole {
    fn distance(&self, at: [f64; 3]) -> f64 {
        (0..3).map(|r| (at[r] - self.centre[r]).powi(2)).sum::<f64>().sqrt() - self.radius
    }

    /// How deep its centre lies in the wheel \[m\].
    fn depth(&self) -> f64 {
        let [x, y, z] = self.centre;
        (RADIUS - x.hypot(y)).min(z).min(HEIGHT - z)
    }
}

/// Holes in the half of positive y, the largest first, each at the first place of an even sequence where it fits.
fn holes() -> Vec<Hole> {
    let mut holes: Vec<Hole> = Vec::new();
    let mut sequence = (1..).map(|n| STEPS.map(|step| (0.5 + f64::from(n) * step).fract()));
    let sizes = HOLES.iter().flat_map(|(radius, count)| std::iter::repeat_n(*radius, *count));
    for radius in sizes {
        let hole = |[a, b, c]: [f64; 3]| Hole { centre: [RADIUS * (2.0 * a - 1.0), RADIUS * b, HEIGHT * c], radius };
        let fits = |hole: &Hole| {
            let is_clear = holes.iter().all(|other| other.distance(hole.centre) >= radius + GAP);
            hole.centre[1] >= radius + MARGIN && hole.depth() >= radius + GAP && is_clear
        };
        let found = sequence.by_ref().take(TRIES).map(hole).find(fits);
        holes.extend(found);
    }
    holes
}

/// The fine mesh.
fn wheel(holes: &[Hole]) -> Result<SimplexMesh, Failure> {
    let cylinder = SimplexCylinder { radius: RADIUS, height: HEIGHT, rings: 16, layers: 8 };
    let mesh = cylinder.mesh().map_err(|error| failed(&error))?;
    let depth = |at| holes.iter().map(|hole| hole.distance(at)).fold(f64::INFINITY, f64::min);
    mesh.carved(depth).map_err(|error| failed(&error))
}

/// What the halves did: by how much the wheel is lower in them than at rest, in percent of its height, at most.
#[derive(Default)]
struct Squeeze {
    /// By half, then in the order of [`Model::ALL`].
    most: [[f64; 4]; 2],
}

impl Squeeze {
    fn add(&mut self, mesh: &SimplexMesh, seen: &Seen<'_>) {
        for (half, most) in Half::ALL.into_iter().zip(&mut self.most) {
            for (most, displacement) in most.iter_mut().zip(seen.displacements) {
                *most = most.max(lowered(mesh, half, displacement));
            }
        }
    }
}

/// Mean displacement of the lower end of a half less that of its upper end, in percent of the height.
fn lowered(mesh: &SimplexMesh, half: Half, displacement: &[f64]) -> f64 {
    let mean = |z: f64| {
        let at_end = |(_, at): &(usize, &[f64; 3])| half.has(**at) && (at[2] - z).abs() < 1e-9;
        let nodes = || mesh.nodes().iter().enumerate().filter(at_end);
        nodes().map(|(node, _)| displacement[3 * node + 2]).sum::<f64>() / nodes().count().max(1) as f64
    };
    100.0 * (mean(0.0) - mean(HEIGHT)) / HEIGHT
}

/// Lets the wheel fall.
pub fn run(study: &Study) -> Result<Findings, Failure> {
    let holes = holes();
    let fine = wheel(&holes)?;
    let mut materials = MaterialTable::new();
    let elasticity = IsotropicMaterial::new(YOUNG, POISSON).map_err(|error| failed(&error))?;
    materials.insert(Label(0), Material::linear("cheese", Elasticity::Isotropic(elasticity), DENSITY));
    let model = SimplexModel::new(fine, &materials).map_err(|error| failed(&error))?;
    let coarse = SimplexCylinder { radius: RADIUS, height: HEIGHT, rings: 3, layers: 1 };
    let pair = Pair::new(study, model, &coarse.mesh().map_err(|error| failed(&error))?)?;
    let mut recorder = study.folder.as_ref().map(|_| Recorder::new(&pair, &FALL, LOOK)).transpose()?;
    let mut squeeze = Squeeze::default();
    let course = course::run(study, &pair, &FALL, |seen| {
        squeeze.add(pair.fine.mesh(), seen);
        recorder.iter_mut().for_each(|recorder| recorder.add(seen));
    })?;
    let text = format!(
        "Fig. 7 of kharevych2009numerical: {TITLE}\n{}\n{}\n{}\n{}",
        holes_in_words(&holes, &pair)?,
        text::sizes(&pair),
        halves(&pair, &squeeze),
        text::tables(study, &PUBLISHED, &FALL, &course),
    );
    let mut rows = text::rows(study, &PUBLISHED, &pair, &course);
    rows.extend(rows_of_halves(study, &pair, &squeeze));
    let mut written = Vec::new();
    if let (Some(folder), Some(recorder)) = (&study.folder, recorder) {
        written.extend(keep_or_warn(stills::write(&pair, &LOOK, folder), study.progress).into_iter().flatten());
        written.extend(recorder.write(&course, folder, study.progress));
    }
    Ok(Findings { rows, text, written, stopped: course.stopped })
}

fn holes_in_words(holes: &[Hole], pair: &Pair) -> Result<String, Failure> {
    let boundary = Boundary::of_mesh(pair.fine.mesh()).map_err(|error| failed(&error))?;
    let cavities = boundary.shells().iter().filter(|shell| shell.is_cavity()).count();
    let range =
        holes.iter().fold([f64::INFINITY, 0.0f64], |[low, high], hole| [low.min(hole.radius), high.max(hole.radius)]);
    let missing = 1.0 - pair.fine.mesh().total_measure() / (std::f64::consts::PI * RADIUS * RADIUS * HEIGHT);
    Ok(format!(
        "{} holes of radius {:.0} to {:.0} mm, which make {cavities} cavities, take {:.1} % of one half of a wheel {:.0} mm across",
        holes.len(),
        1e3 * range[0],
        1e3 * range[1],
        200.0 * missing,
        2e3 * RADIUS,
    ))
}

/// Mean compliances of the halves along z in the coarse models, the holed one first, relative to the cheese.
fn compliances(pair: &Pair) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|n| Half::ALL.map(|half| mean_compliance(&pair.coarse[n], |at| half.has(at)) * YOUNG))
}

fn halves(pair: &Pair, squeeze: &Squeeze) -> String {
    let compliance = compliances(pair);
    let heading = ["the side with the holes is softer", Half::Holed.name(), Half::Solid.name(), "ratio"];
    let mut lines = vec![heading.map(String::from)];
    let mut add = |name: String, [holed, solid]: [f64; 2]| {
        lines.push([name, digits(holed), digits(solid), digits(holed / solid)]);
    };
    for (n, model) in Model::COARSE.into_iter().enumerate() {
        add(format!("mean upright compliance over that of cheese, {}", model.label()), compliance[n]);
    }
    for (n, model) in Model::ALL.into_iter().enumerate() {
        add(format!("most compressed in the fall [%], {}", model.label()), [squeeze.most[0][n], squeeze.most[1][n]]);
    }
    results::columns(&lines)
}

fn rows_of_halves(study: &Study, pair: &Pair, squeeze: &Squeeze) -> Vec<Row> {
    let compliance = compliances(pair);
    let mut rows = Vec::new();
    for (h, half) in Half::ALL.into_iter().enumerate() {
        for (n, model) in Model::ALL.into_iter().enumerate() {
            let of = |quantity, unit, measured| Row {
                pattern: Some(half.name()),
                method: Some(model.name()),
                measured: Some(measured),
                note: Some("“the side containing the holes behaves softer”".into()),
                ..Row::new(study, NAME, quantity, unit)
            };
            if n > 0 {
                rows.push(of("compliance over that of cheese", "1", compliance[n - 1][h]));
            }
            rows.push(of("largest compression", "%", squeeze.most[h][n]));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_are_cavities_of_one_half_and_open_nowhere() {
        let holes = holes();
        let mesh = wheel(&holes).unwrap();
        let boundary = Boundary::of_mesh(&mesh).unwrap();
        let mut radii: Vec<f64> = holes.iter().map(|hole| hole.radius).collect();
        radii.dedup();
        assert!(holes.len() >= 10 && radii.len() >= 3, "holes of various sizes: {holes:?}");
        let shells = boundary.shells();
        let count = shells.iter().filter(|shell| shell.is_cavity()).count();
        assert_eq!(shells.len(), count + 1, "one outer boundary, which no hole opens");
        assert!(holes.len() - 4 <= count && count <= holes.len(), "{count} cavities of {} holes", holes.len());
        let cavities = boundary.faces().iter().filter(|face| boundary.is_cavity(face));
        assert!(cavities.flat_map(|face| face.nodes()).all(|node| mesh.nodes()[*node as usize][1] > 0.0));
        let least = (0..mesh.cell_count()).map(|cell| mesh.shape_quality(cell)).fold(f64::INFINITY, f64::min);
        assert!((33_000..38_000).contains(&mesh.cell_count()) && least > 0.1, "{} {least}", mesh.cell_count());
    }

    #[test]
    fn a_half_that_is_pressed_together_is_lowered_by_so_much() {
        let mesh = SimplexCylinder { radius: RADIUS, height: HEIGHT, rings: 2, layers: 2 }.mesh().unwrap();
        let squeezed = |at: &[f64; 3]| [0.1, 0.0, -0.2 * at[2] * f64::from(u8::from(at[1] > 0.0)) + 0.3];
        let displacement: Vec<f64> = mesh.nodes().iter().flat_map(squeezed).collect();
        assert!((lowered(&mesh, Half::Holed, &displacement) - 20.0).abs() < 1e-12);
        assert!(lowered(&mesh, Half::Solid, &displacement).abs() < 1e-12);
    }
}
