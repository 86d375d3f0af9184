//! What a scene may ask for and this version checks but does not compute.

use crate::failure::Failure;
use crate::problem::Problem;

impl Problem {
    /// Refuses all but static runs of linear materials between parts that stand still.
    ///
    /// # Errors
    /// The first thing that the scene asks for beyond that.
    pub fn require_linear_statics(&self) -> Result<(), Failure> {
        let scene = &self.scene;
        let edited = !scene.edits.is_empty();
        let nonlinear = scene.materials.iter().find(|material| material.law != grosgrain::material::Law::Linear);
        let moving = scene.fixes.iter().find(|fix| fix.motion.is_some());
        let spring = scene.loads.iter().find(|load| load.is_spring());
        let growing = scene.loads.iter().find(|load| edited && load.span.varies());
        let beyond = [
            scene.is_dynamic().then(|| ("time.mode".into(), "a dynamic run")),
            nonlinear.map(|material| (format!("materials.{}.model", material.name), "a law for large deformation")),
            moving.map(|fix| (format!("{}.move", fix.key), "a moving part")),
            spring.map(|load| (format!("{}.spring", load.key), "springs")),
            growing.map(|load| (load.key.clone(), "a load that grows from step to step")),
            (edited && !scene.coarsening.update)
                .then(|| ("coarsening.update".into(), "old shape functions after edits")),
            (edited && scene.output.animation).then(|| ("output.animation".into(), "an animated picture")),
        ];
        match beyond.into_iter().flatten().next() {
            None => Ok(()),
            Some((key, what)) => Err(scene
                .unusable(&key, format!("asks for {what}, which this version checks but cannot compute"))
                .into()),
        }
    }
}
