//! Usable scenes become the bodies that they describe.

use std::path::{Path, PathBuf};

use grosgrain::coarsening::{BaseKind, Objective};
use grosgrain::homogenization::{Blending, Downsampling};
use grosgrain::material::Elasticity;
use grosgrain::mesh::{Axis, Blade, Brush, Cut, Label, PlaneAt, Selector};
use grosgrain::training::TrainingKind;
use grosgrain_cli::body::{Body, build_body, loose_when_held, solid_counts};
use grosgrain_cli::scene::{
    CoarseMeshSource, LoadKind, MeshCoarsening, MeshSource, Scene, Source, Training, read_scene,
};

const CONDITIONS: &str = "
[coarsening]
degree = 2
[[fix]]
where = { plane = \"x\", at = \"min\" }
[[load]]
gravity = [0, 0, -9.81]
";

fn ct() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ct_torso/example_ct.nii.gz")
}

/// Writes `labels.npy` (4 × 2 × 2, 0 1 2 1 along x) and `moduli.npy` (the same size, 1e6 but 0 where i = 0).
fn write_volumes(folder: &Path) {
    let npy = |name: &str, descr: &str, data: &[u8]| {
        let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 2, 4), }}");
        header.push_str(&" ".repeat(63 - (header.len() + 10) % 64));
        header.push('\n');
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((header.len() as u16).to_le_bytes());
        file.extend(header.as_bytes());
        file.extend(data);
        std::fs::write(folder.join(name), file).unwrap();
    };
    npy("labels.npy", "|u1", &[0, 1, 2, 1].repeat(4));
    let row: Vec<u8> = [0.0, 1e6, 2e6, 3e6f64].iter().flat_map(|e| e.to_le_bytes()).collect();
    npy("moduli.npy", "<f8", &row.repeat(4));
}

fn read(text: &str) -> (Scene, Body) {
    let folder = tempfile::tempdir().unwrap();
    write_volumes(folder.path());
    let file = folder.path().join("scene.toml");
    std::fs::write(&file, text).unwrap();
    let scene = read_scene(&file).unwrap_or_else(|error| panic!("{error}"));
    let body = build_body(&scene).unwrap_or_else(|error| panic!("{error}"));
    (scene, body)
}

fn counts(body: &Body) -> Vec<(i32, usize)> {
    solid_counts(&body.grid).into_iter().map(|(label, n)| (label.0, n)).collect()
}

#[test]
fn the_static_scene_of_a_ct_volume_is_read_in_full() {
    let text = format!(
        r#"
        title = "Abdomen, cut"
        [body]
        volume = {:?}
        spacing = [0.01, 0.01, 0.01]
        resample = [24, 24, 18]
        labels = [ {{ label = 0, below = -300, void = true }}, {{ label = 1, below = 150 }}, {{ label = 2 }} ]
        [materials.soft]
        label = 1
        model = "neo-hookean"
        young = 1e5
        poisson = 0.45
        density = 1000.0
        [materials.bone]
        label = 2
        young = 1e8
        poisson = 0.45
        density = 1500.0
        [coarsening]
        degree = 2
        training = "one-ring"
        fields = 6
        base = "harmonic"
        [time]
        mode = "static"
        [[fix]]
        where = {{ plane = "x", at = "min" }}
        [[load]]
        gravity = [0, 0, -9.81]
        [output]
        frames = 10
        picture = true
        volume = true
        compare = "fine"
        "#,
        ct()
    );
    let (scene, body) = read(&text);
    assert_eq!((scene.title.as_str(), scene.coarsening.degree), ("Abdomen, cut", 2));
    assert_eq!(scene.coarsening.training, Training::Kind(TrainingKind::OneRing));
    assert!(scene.output.compare_with_fine && scene.output.picture && scene.output.volume);
    assert_eq!(scene.warnings, Vec::<String>::new());
    assert_eq!(body.grid.lattice.cells, [24, 24, 18]);
    let extent: [f64; 3] = std::array::from_fn(|a| body.grid.spacing[a] * body.grid.lattice.cells[a] as f64);
    for (found, voxels) in extent.iter().zip([122.0, 101.0, 112.0]) {
        assert!((found - 0.01 * voxels).abs() < 1e-12, "extent {extent:?}");
    }
    let found = counts(&body);
    assert_eq!(found.iter().map(|(label, _)| *label).collect::<Vec<_>>(), [1, 2]);
    assert!(found[0].1 > found[1].1, "more soft tissue than bone: {found:?}");
    assert!(scene.require_conditions().is_ok());
}

#[test]
fn defaults_are_those_that_the_documentation_names() {
    let (scene, body) = read(&format!(
        "[body]
        grid = {{ cells = [4, 2, 2], size = [0.4, 0.2, 0.1] }}
        pattern = {{ kind = \"checkerboard\", labels = [3, 4] }}
        void = [4]
        [materials.only]
        label = 3
        young = 2.5e5
        poisson = 0.3
        density = 1200
        {CONDITIONS}"
    ));
    assert_eq!(scene.title, "scene");
    let coarsening = scene.coarsening;
    assert_eq!(
        (coarsening.training, coarsening.base, coarsening.objective, coarsening.split),
        (Training::Kind(TrainingKind::OneRing), BaseKind::Harmonic, Objective::ClosedForm, true)
    );
    assert_eq!(body.grid.spacing, [0.1, 0.1, 0.05]);
    assert_eq!(counts(&body), [(3, 8)]);
    assert_eq!(scene.fixes[0].selection, Selector::Plane { axis: Axis::X, at: PlaneAt::Min });
    assert_eq!(scene.loads[0].kind, LoadKind::Gravity([0.0, 0.0, -9.81]));
    let material = body.materials.get(Label(3)).unwrap();
    let Elasticity::Isotropic(elasticity) = material.elasticity else { panic!("isotropic") };
    assert_eq!((elasticity.young(), elasticity.poisson(), material.density), (2.5e5, 0.3, 1200.0));
}

#[test]
fn every_selector_is_read() {
    let selector = |text: &str| {
        let (scene, _) = read(&format!(
            "[body]
            grid = {{ cells = [4, 2, 2], size = [4, 2, 2] }}
            pattern = {{ kind = \"layers\", direction = [1, 0, 0], period = 4, labels = [0, 1] }}
            [materials.a]
            label = 0
            young = 1
            poisson = 0
            [materials.b]
            label = 1
            young = 1
            poisson = 0
            [coarsening]
            degree = 1
            [[fix]]
            where = {text}
            "
        ));
        scene.fixes[0].selection.clone()
    };
    let plane = |axis, at| Selector::Plane { axis, at };
    assert_eq!(selector("\"all\""), Selector::All);
    assert_eq!(selector("{ all = true }"), Selector::All);
    assert_eq!(selector("{ plane = \"z\", at = \"max\" }"), plane(Axis::Z, PlaneAt::Max));
    assert_eq!(selector("{ plane = \"y\", at = 1.0 }"), plane(Axis::Y, PlaneAt::Coordinate(1.0)));
    let corner = Selector::Box { low: [0.0; 3], high: [1.0, 2.0, 3.0] };
    assert_eq!(selector("{ box = [[0, 0, 0], [1, 2, 3]] }"), corner);
    let ball = Selector::Sphere { centre: [1.0, 1.0, 0.0], radius: 1.5 };
    assert_eq!(selector("{ sphere = { centre = [1, 1, 0], radius = 1.5 } }"), ball);
    assert_eq!(selector("{ label = 1 }"), Selector::Label(Label(1)));
    let cut = Cut { point: [1.0, 1.0, 1.0], normal: [1.0, 0.0, 2.0], radius: None };
    assert_eq!(selector("{ cut = { point = [1, 1, 1], normal = [1, 0, 2] } }"), Selector::Cut(cut.clone()));
    let disc = Selector::Cut(Cut { radius: Some(0.9), ..cut });
    assert_eq!(selector("{ cut = { point = [1, 1, 1], normal = [1, 0, 2], radius = 0.9 } }"), disc);
    let edge = [[0.0, 0.0, 0.5], [4.0, 0.0, 0.5]];
    let blade = Selector::Blade(Blade { edge, sweep: [0.0, 1.5, 0.0] });
    assert_eq!(selector("{ blade = { edge = [[0, 0, 0.5], [4, 0, 0.5]], sweep = [0, 1.5, 0] } }"), blade);
    let path = Selector::blade_path(edge, &[[0.0, 1.5, 0.0], [0.0, 0.0, 1.0]]);
    assert_eq!(selector("{ blade = { edge = [[0, 0, 0.5], [4, 0, 0.5]], sweep = [[0, 1.5, 0], [0, 0, 1]] } }"), path);
    let brush = Selector::Brush(Brush { path: vec![[0.0; 3], [4.0, 2.0, 2.0]], radius: 0.75 });
    assert_eq!(selector("{ brush = { path = [[0, 0, 0], [4, 2, 2]], radius = 0.75 } }"), brush);
    assert_eq!(
        selector("{ and = [{ not = { label = 1 } }, { or = [\"all\", { label = 0 }] }] }"),
        Selector::And(vec![
            Selector::Not(Box::new(Selector::Label(Label(1)))),
            Selector::Or(vec![Selector::All, Selector::Label(Label(0))]),
        ])
    );
}

#[test]
fn every_pattern_fills_its_grid() {
    for (pattern, labels) in [
        ("{ kind = \"layers\", direction = [1, 0, 0], period = 4, labels = [0, 1] }", vec![(0, 8), (1, 8)]),
        ("{ kind = \"checkerboard\", size = 1, labels = [0, 1] }", vec![(0, 8), (1, 8)]),
        ("{ kind = \"random\", seed = 3, labels = [0, 1], fractions = [1.0, 0.0] }", vec![(0, 16)]),
        ("{ kind = \"spheres\", radius = 0.6, centres = [[0.5, 0.5, 0.5]], labels = [0, 1] }", vec![(0, 15), (1, 1)]),
        ("{ kind = \"spheres\", radius = 0.5, period = 2, labels = [0, 1] }", vec![(0, 16)]),
        ("{ kind = \"grid\", period = [2, 2, 2], width = 1, labels = [0, 1] }", vec![(0, 8), (1, 8)]),
        ("{ kind = \"from-file\", file = \"labels.npy\" }", vec![(0, 4), (1, 8), (2, 4)]),
    ] {
        let materials: String = (0..3)
            .map(|label| format!("[materials.m{label}]\nlabel = {label}\nyoung = 1\npoisson = 0\ndensity = 1\n"))
            .collect();
        let grid = "grid = { cells = [4, 2, 2], size = [4, 2, 2] }";
        let (_, body) = read(&format!("[body]\n{grid}\npattern = {pattern}\n{materials}{CONDITIONS}"));
        assert_eq!(counts(&body), labels, "{pattern}");
    }
}

#[test]
fn values_lists_gather_labels_and_voids_of_a_file_stay_void() {
    let (_, body) = read(&format!(
        "[body]
        volume = \"labels.npy\"
        spacing = [1, 1, 1]
        labels = [{{ label = 9, values = [0], void = true }}, {{ label = 5, values = [1, 2] }}]
        [materials.m]
        label = 5
        young = 1
        poisson = 0
        density = 1
        {CONDITIONS}"
    ));
    assert_eq!(counts(&body), [(5, 12)]);
    assert_eq!(body.grid.void[..4], [true, false, false, false]);
}

#[test]
fn a_file_of_moduli_alone_makes_a_body_with_voids_where_it_is_zero() {
    let (_, body) = read(&format!(
        "[body]
        young = \"moduli.npy\"
        spacing = [1, 1, 1]
        [materials.m]
        label = 0
        poisson = 0.3
        density = 1
        {CONDITIONS}"
    ));
    assert_eq!(counts(&body), [(0, 12)]);
    assert_eq!(body.grid.young.as_ref().unwrap()[..4], [0.0, 1e6, 2e6, 3e6]);
}

#[test]
fn materials_with_constants_of_their_own_keep_them_beside_moduli_per_voxel() {
    let (_, body) = read(&format!(
        "[body]
        volume = \"labels.npy\"
        spacing = [1, 1, 1]
        young = \"moduli.npy\"
        [materials.own]
        label = 0
        young = 7e5
        poisson = 0.4
        density = 1
        [materials.one]
        label = 1
        poisson = 0.3
        density = 1
        [materials.two]
        label = 2
        poisson = 0.2
        density = 1
        {CONDITIONS}"
    ));
    assert_eq!(body.grid.young.as_ref().unwrap()[..4], [7e5, 1e6, 2e6, 3e6]);
    assert_eq!(body.grid.solid_count(), 16);
}

#[test]
fn a_power_law_gives_modulus_and_density_and_needs_no_material() {
    let (_, body) = read(&format!(
        "[body]
        volume = \"labels.npy\"
        spacing = [1, 1, 1]
        modulus = {{ law = \"power\", coefficient = 2e9, exponent = 2, density = {{ slope = 1, intercept = 0 }}, poisson = 0.3 }}
        {CONDITIONS}"
    ));
    assert_eq!(counts(&body), [(0, 12)]);
    assert_eq!(body.grid.young.as_ref().unwrap()[..4], [0.0, 2e9, 8e9, 2e9]);
    assert_eq!(body.grid.density.as_ref().unwrap()[..4], [0.0, 1000.0, 2000.0, 1000.0]);
    let Elasticity::Isotropic(elasticity) = body.materials.get(Label(0)).unwrap().elasticity else {
        panic!("isotropic")
    };
    assert_eq!(elasticity.poisson(), 0.3);
}

#[test]
fn parts_that_nothing_holds_are_told_or_left_out() {
    let scene = |keep: &str| {
        format!(
            "[body]
            volume = \"labels.npy\"
            spacing = [1, 1, 1]
            void = [2]
            {keep}
            [materials.a]
            label = 0
            young = 1
            poisson = 0
            density = 1
            [materials.b]
            label = 1
            young = 1
            poisson = 0
            density = 1
            {CONDITIONS}"
        )
    };
    for (keep, solid, remark) in [
        ("keep = \"largest\"", 8, "left out 1 part with 4 cells outside the largest part"),
        ("keep = \"supported\"", 8, "left out 1 part with 4 cells that nothing holds"),
    ] {
        let (_, body) = read(&scene(keep));
        assert_eq!(body.grid.solid_count(), solid, "{keep}");
        assert!(body.remarks.iter().any(|r| r.starts_with(remark)), "{keep}: {:?}", body.remarks);
    }
    let (all, body) = read(&scene(""));
    assert_eq!((body.grid.solid_count(), body.remarks.len()), (12, 0));
    let sentence = loose_when_held(&all, &body.grid).unwrap().unwrap();
    assert!(sentence.starts_with("a part of 4 cells around cell (3, 0, 0) is held by nothing; "), "{sentence}");
}

#[test]
fn a_scene_without_conditions_can_be_read_but_not_run() {
    let (scene, _) = read(
        "[body]
        grid = { cells = [2, 2, 2], size = [1, 1, 1] }
        pattern = { kind = \"checkerboard\", labels = [0] }
        [materials.m]
        label = 0
        young = 1
        poisson = 0
        [coarsening]
        degree = 1",
    );
    let message = scene.require_conditions().unwrap_err().to_string();
    assert!(message.contains("the body hangs on nothing; expected at least one table [[fix]]"), "{message}");
    assert!(message.contains("expected at least one table [[load]]"), "{message}");
}

#[test]
fn keys_of_dynamic_runs_are_checked_and_told_to_have_no_effect_in_a_static_one() {
    let text = format!(
        "[body]\nvolume = \"labels.npy\"\nspacing = [0.01, 0.01, 0.01]\nvoid = [0]\n\
         [materials.a]\nlabel = 1\nyoung = 1e5\npoisson = 0.3\ndensity = 1000.0\n\
         [materials.b]\nlabel = 2\nyoung = 1e6\npoisson = 0.3\ndensity = 1000.0\n\
         [time]\nmode = \"static\"\nstep = 0.01\nsteps = 200\nintegrator = \"midpoint\"\ndamping = 0.0\n{CONDITIONS}"
    );
    let (scene, _) = read(&text);
    let told = ["step", "steps", "integrator", "damping"];
    let expected = told.map(|key| format!("time.{key} has no effect in a static run"));
    assert_eq!(scene.warnings, expected);
}

#[test]
fn scenes_of_meshes_tell_where_fine_and_coarse_meshes_come_from() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |body: &str, coarsening: &str| {
        let file = folder.path().join("scene.toml");
        let materials =
            "[materials.gel]\nlabel = 1\nmodel = \"corotational\"\nyoung = 1e5\npoisson = 0.3\ndensity = 1e3\n";
        std::fs::write(&file, format!("[body]\n{body}\n{materials}{coarsening}")).unwrap();
        read_scene(&file).unwrap_or_else(|error| panic!("{error}"))
    };
    for name in ["fine.mesh", "coarse.msh"] {
        std::fs::write(folder.path().join(name), "").unwrap();
    }
    let plain = scene("mesh = \"fine.mesh\"", "");
    let source = MeshSource { file: folder.path().join("fine.mesh"), scale: 1.0 };
    assert!(plain.is_mesh() && plain.is_nonlinear());
    assert_eq!(
        (&plain.body.source, &plain.mesh_coarsening),
        (&Source::Mesh(source.clone()), &MeshCoarsening::default())
    );
    let full = scene(
        "mesh = \"fine.mesh\"\nscale = 0.001",
        "[coarsening]\nmesh = \"coarse.msh\"\ndownsampling = \"fitted\"\nheld = true\nmap = \"harmonic\"",
    );
    let mesh = CoarseMeshSource::File(folder.path().join("coarse.msh"));
    assert_eq!(full.body.source, Source::Mesh(MeshSource { scale: 0.001, ..source }));
    let map = Some(Blending::PerCell);
    assert_eq!(full.mesh_coarsening, MeshCoarsening { mesh, downsampling: Downsampling::Fitted, held: true, map });
    let lattice = scene("mesh = \"fine.mesh\"", "[coarsening]\ncells = 600");
    assert_eq!(lattice.mesh_coarsening.mesh, CoarseMeshSource::Lattice(600));
}
