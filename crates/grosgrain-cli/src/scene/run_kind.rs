//! What belongs to static and what to dynamic runs.

use grosgrain::material::Law;

use super::document::{Item, Reading};
use super::section::Section;
use super::time::Mode;
use super::{Problem, Scene, SceneError};

/// Notes what the kind of run lacks, or cannot do.
pub fn check(root: &Section, scene: &Scene) -> Reading<()> {
    let checks = match scene.time.mode {
        Mode::Static => [refuse_ends(root, scene), refuse_contact(root, scene), require_step(root, scene)],
        Mode::Dynamic => [require_ends_of_motions(root, scene), Ok(()), Ok(())],
    };
    checks.into_iter().collect()
}

/// The tables of a list, e.g. all `[[fix]]`.
fn tables<'s>(root: &Section<'s>, name: &str) -> Vec<Item<'s>> {
    root.get(name).and_then(|list| list.list("").ok()).unwrap_or_default()
}

/// The value that names lead to below a table; the table itself where there is none.
fn below<'s>(item: &Item<'s>, names: &[&str]) -> Item<'s> {
    names.iter().fold(item.clone(), |item, name| item.child(name).unwrap_or(item))
}

fn refuse_ends(root: &Section, scene: &Scene) -> Reading<()> {
    let refuse = |(item, until): (Item, Option<f64>)| match until {
        None => Ok(()),
        Some(_) => {
            let until = below(&item, &["until"]);
            let sentence = "ends during the run, which a static run cannot show; leave it out, or write mode = \"dynamic\" in [time]";
            Err(until.note(format!("{} {sentence}", until.key())))
        }
    };
    let fixes = tables(root, "fix").into_iter().zip(scene.fixes.iter().map(|fix| fix.span.until));
    let loads = tables(root, "load").into_iter().zip(scene.loads.iter().map(|load| load.span.until));
    fixes.chain(loads).map(refuse).collect::<Vec<_>>().into_iter().collect()
}

fn refuse_contact(root: &Section, scene: &Scene) -> Reading<()> {
    match scene.contact {
        None => Ok(()),
        Some(_) => {
            let sentence =
                "contact needs a dynamic run; leave it out, or write mode = \"dynamic\" with step and steps in [time]";
            Err(root.note_at(&["contact"], sentence.into()))
        }
    }
}

/// With edits, motions and loads grow from step to step, so that seconds must be known.
fn require_step(root: &Section, scene: &Scene) -> Reading<()> {
    if scene.edits.is_empty() || scene.time.step.is_some() {
        return Ok(());
    }
    let fixes = tables(root, "fix").into_iter().map(|fix| below(&fix, &["move"]));
    let loads = tables(root, "load").into_iter();
    let seconds = fixes.chain(loads).flat_map(|item| ["from", "to"].map(|name| item.child(name))).flatten();
    let refuse = |item: Item| {
        let sentence = "is in seconds, but time.step is missing; expected time.step, the seconds per step";
        Err(item.note(format!("{} {sentence}", item.key())))
    };
    seconds.map(refuse).collect::<Vec<_>>().into_iter().collect()
}

fn require_ends_of_motions(root: &Section, scene: &Scene) -> Reading<()> {
    let fixes = tables(root, "fix").into_iter().zip(&scene.fixes);
    let sudden = fixes.filter(|(_, fix)| fix.motion.is_some() && fix.span.to.is_none());
    let refuse = |(item, _)| {
        let motion = below(&item, &["move"]);
        Err(motion
            .note(format!("{}.to is missing; expected the time in seconds at which it is complete", motion.key())))
    };
    sudden.map(refuse).collect::<Vec<_>>().into_iter().collect()
}

/// What the user should know about the run's kind and length although the scene is usable.
pub fn warnings(scene: &Scene) -> Vec<String> {
    let mut warnings = idle_keys(scene);
    warnings.extend(late_keys(scene));
    if scene.is_dynamic() && scene.start.is_at_rest() && !scene.is_driven() {
        warnings.push(
            "nothing sets the body in motion: there is no load, no moving [[fix]] and no velocity in [start]".into(),
        );
    }
    warnings
}

fn idle_keys(scene: &Scene) -> Vec<String> {
    let (time, edits) = (&scene.time, !scene.edits.is_empty());
    let (dynamic, linear) = (scene.is_dynamic(), !scene.is_nonlinear());
    let is_idle = |key: &&&str| match **key {
        "step" | "steps" => !dynamic && !edits,
        "integrator" | "damping" => !dynamic,
        "tolerance" | "halvings" => !dynamic && linear,
        "increments" => dynamic || linear,
        _ => false,
    };
    let kind = if dynamic { "dynamic run" } else { "static run" };
    let of = |key: &&str| match *key {
        "tolerance" | "halvings" => " of linear materials",
        "increments" if !dynamic => " of linear materials",
        _ => "",
    };
    let idle = time.given.iter().filter(is_idle);
    let mut warnings: Vec<String> = idle.map(|k| format!("time.{k} has no effect in a {kind}{}", of(k))).collect();
    let mut tell = |idle: bool, sentence: &str| warnings.extend(idle.then(|| sentence.to_owned()));
    tell(!dynamic && !scene.start.is_at_rest(), "start has no effect in a static run");
    tell(scene.coarsening.integration.is_some() && linear, "coarsening.integration has no effect on linear materials");
    tell(!scene.coarsening.update && !edits, "coarsening.update has no effect without edits");
    tell(scene.output.animation && !dynamic && !edits, "output.animation has no effect on a single equilibrium");
    if !dynamic && !edits {
        let moves = scene.fixes.iter().map(|fix| (format!("{}.move", fix.key), fix.span));
        let spans = moves.chain(scene.loads.iter().map(|load| (load.key.clone(), load.span)));
        warnings.extend(spans.flat_map(|(key, span)| {
            let given = [("from", span.from), ("to", span.to)].into_iter().filter(|(_, given)| given.is_some());
            given.map(move |(name, _)| format!("{key}.{name} has no effect in a static run without edits"))
        }));
    }
    warnings
}

/// What begins, is complete or ends only after the run.
fn late_keys(scene: &Scene) -> Vec<String> {
    let (Some(step), Some(steps)) = (scene.time.step, scene.time.steps) else { return Vec::new() };
    if !scene.is_dynamic() && scene.edits.is_empty() {
        return Vec::new();
    }
    let end = step * steps as f64;
    let fixes = scene.fixes.iter().map(|fix| (&fix.key, "move.", fix.span));
    let spans = fixes.chain(scene.loads.iter().map(|load| (&load.key, "", load.span)));
    let late = spans.flat_map(|(key, inside, span)| {
        let times = [
            (format!("{key}.{inside}from"), span.from),
            (format!("{key}.{inside}to"), span.to),
            (format!("{key}.until"), span.until),
        ];
        times.into_iter().find_map(|(key, time)| time.filter(|time| *time > end * (1.0 + 1e-9)).map(|time| (key, time)))
    });
    late.map(|(key, time)| format!("{key} is {time} s, but the run ends at {end} s")).collect()
}

impl Scene {
    /// Whether the run has inertia.
    pub fn is_dynamic(&self) -> bool {
        self.time.mode == Mode::Dynamic
    }

    /// Whether any material has a law for large deformation.
    pub fn is_nonlinear(&self) -> bool {
        self.materials.iter().any(|material| material.law != Law::Linear)
    }

    /// Whether the run is one of static equilibria of linear materials between parts that stand still: one linear system each.
    pub fn is_linear_static(&self) -> bool {
        let edited = !self.edits.is_empty();
        let still = self.fixes.iter().all(|fix| fix.motion.is_none());
        let constant = !self.loads.iter().any(|load| load.is_spring() || edited && load.span.varies());
        let plain = self.coarsening.update || !edited;
        !self.is_dynamic() && !self.is_nonlinear() && still && constant && plain
    }

    /// Whether a load or a moving part acts on the body.
    pub fn is_driven(&self) -> bool {
        self.loads.iter().any(|load| load.acts_at_rest()) || self.fixes.iter().any(|fix| fix.motion.is_some())
    }

    /// Refuses a static run of a body that nothing holds or nothing loads.
    ///
    /// # Errors
    /// No `[[fix]]` and no spring; no `[[load]]` and no motion.
    pub fn require_conditions(&self) -> Result<(), SceneError> {
        let mut sentences = Vec::new();
        if !self.is_dynamic() && self.fixes.is_empty() && !self.loads.iter().any(|load| load.is_spring()) {
            sentences.push("the body hangs on nothing; expected at least one table [[fix]]");
        }
        if !self.is_dynamic() && !self.is_driven() {
            sentences.push("nothing loads the body, so it would not move; expected at least one table [[load]]");
        }
        let problem = |sentence: &str| Problem { line: 0, sentence: sentence.into() };
        match sentences.is_empty() {
            true => Ok(()),
            false => Err(SceneError::Unusable {
                file: self.file.clone(),
                problems: sentences.into_iter().map(problem).collect(),
            }),
        }
    }
}
