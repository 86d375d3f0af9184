//! One ray through a volume, front to back.

use super::{
    VolumeScene,
    field::{Blocks, Field, Gradients},
    transfer::TransferTable,
};
use crate::camera::{Camera, Vec3, dot, unit};

/// Light that is left when a ray is given up.
const SPENT: f64 = 0.004;
/// Opacity of a segment from which on it is worth shading.
const SHADED: f64 = 5e-4;

/// Everything that rays share.
pub(crate) struct March<'a> {
    pub(crate) field: Field<'a>,
    /// In units of the steepness at which shading is half of full.
    pub(crate) gradients: Gradients,
    pub(crate) table: TransferTable,
    /// `None` steps through empty space too.
    pub(crate) blocks: Option<Blocks>,
    pub(crate) camera: &'a Camera,
    pub(crate) spacing: Vec3,
    pub(crate) origin: Vec3,
    /// Half-spaces that are kept, as point, unit normal pointing out of them, and whether they cut the body.
    pub(crate) kept: Vec<(Vec3, Vec3, bool)>,
    /// Length of a step \[m\].
    pub(crate) step: f64,
    /// Difference of values at its ends from which on a step is halved.
    pub(crate) coarse: f32,
    /// Thickness \[m\] that a cut face shows.
    pub(crate) face: f64,
}

/// Light gathered along a ray: linear colour, and the share of the background that shines through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gathered {
    pub(crate) light: [f64; 3],
    pub(crate) left: f64,
}

impl Gathered {
    fn add(&mut self, colour: [f64; 3], opacity: f64) {
        (0..3).for_each(|c| self.light[c] += self.left * opacity * colour[c]);
        self.left *= 1.0 - opacity;
    }
}

impl<'a> March<'a> {
    pub(crate) fn new(scene: &'a VolumeScene, camera: &'a Camera) -> Self {
        let field = scene.field();
        let table = TransferTable::new(&scene.transfer);
        let blocks = scene.skip_empty.then(|| Blocks::new(&field, &table));
        let (spacing, origin) = (scene.spacing, scene.origin);
        let low: Vec3 = std::array::from_fn(|a| origin[a] - spacing[a]);
        let high: Vec3 = std::array::from_fn(|a| origin[a] + spacing[a] * scene.size[a] as f64);
        let mut kept = box_sides([low, high], false);
        if let Some([low, high]) = scene.clip_box {
            kept.extend(box_sides([low, high], true));
        }
        kept.extend(scene.clip_planes.iter().filter_map(|p| Some((p.point, unit(p.normal)?, true))));
        let smallest = spacing.into_iter().fold(f64::INFINITY, f64::min);
        let nodes = &scene.transfer.nodes;
        let contrast = nodes.last().map_or(0.0, |n| n.value) - nodes.first().map_or(0.0, |n| n.value);
        let edge = 0.03 * contrast.max(1e-12) / smallest;
        let coarse = (0.04 * contrast) as f32;
        let gradients = Gradients::new(&field, spacing, edge);
        let step = scene.step * smallest;
        Self { field, gradients, table, blocks, camera, spacing, origin, kept, step, coarse, face: scene.face }
    }

    /// Follows the ray through a point of the picture plane; its steps begin `phase` of a step after the entry.
    pub(crate) fn gather(&self, x: f64, y: f64, phase: f64) -> Gathered {
        let mut gathered = Gathered { light: [0.0; 3], left: 1.0 };
        let (start, direction, nearest) = self.camera.ray(x, y);
        let Some(Interval { enter, leave, cut }) = self.interval(start, direction, nearest) else { return gathered };
        let voxel: Vec3 = std::array::from_fn(|a| (start[a] - self.origin[a]) / self.spacing[a]);
        let along: Vec3 = std::array::from_fn(|a| direction[a] / self.spacing[a]);
        let at = |t: f64| -> Vec3 { std::array::from_fn(|a| voxel[a] + t * along[a]) };
        if let Some(normal) = cut {
            self.cut_face(at(enter), normal, direction, &mut gathered);
        }
        // The first segment has the length `phase`, all others but the last a whole step.
        let place = |k: usize| (enter + (k as f64 - 1.0 + phase) * self.step).clamp(enter, leave);
        let count = ((leave - enter) / self.step - phase).floor() as usize + 2;
        let mut k = 0;
        let mut before: Option<f32> = None;
        while k < count && gathered.left > SPENT {
            let here = at(place(k));
            if let Some(empty) = self.blocks.as_ref().and_then(|b| b.empty_around(here)) {
                let exit = exit(empty, voxel, along);
                let last = (((exit - enter) / self.step - phase).floor() + 1.0).clamp(0.0, count as f64) as usize;
                if last > k {
                    (k, before) = (last, None);
                    continue;
                }
            }
            let ends = [place(k), place(k + 1)];
            let first = before.unwrap_or_else(|| self.field.value(here));
            let next = self.field.value(at(ends[1]));
            self.refine(&at, ends, [first, next], direction, &mut gathered);
            (k, before) = (k + 1, Some(next));
        }
        gathered
    }

    /// Adds a step of a ray, in halves and quarters where its values at the ends differ much.
    fn refine(
        &self,
        at: &impl Fn(f64) -> Vec3,
        [t, u]: [f64; 2],
        [a, b]: [f32; 2],
        direction: Vec3,
        gathered: &mut Gathered,
    ) {
        let middle = 0.5 * (t + u);
        if (b - a).abs() > self.coarse && (u - t) > 0.2 * self.step {
            let m = self.field.value(at(middle));
            self.refine(at, [t, middle], [a, m], direction, gathered);
            self.refine(at, [middle, u], [m, b], direction, gathered);
        } else {
            self.segment((a, b), at(middle), u - t, direction, gathered);
        }
    }

    /// Adds a segment of a ray whose values are `a` and `b` at its ends and whose middle is at `p`.
    fn segment(&self, (a, b): (f32, f32), p: Vec3, length: f64, direction: Vec3, gathered: &mut Gathered) {
        let [red, green, blue, extinction] = self.table.mean(a, b);
        if extinction <= 0.0 {
            return;
        }
        let opacity = 1.0 - (-extinction * length).exp();
        let light = match opacity > SHADED {
            true => self.light(p, direction),
            false => [1.0, 0.0],
        };
        gathered.add([red, green, blue].map(|c| c / extinction * light[0] + light[1]), opacity);
    }

    /// Light that a surface at `p` reflects: diffuse factor and highlight; surfaces are where the value changes fast.
    fn light(&self, p: Vec3, direction: Vec3) -> [f64; 2] {
        let gradient = self.gradients.at(p).map(f64::from);
        let steep = dot(gradient, gradient);
        let surface = steep / (steep + 1.0);
        let Some(normal) = unit(gradient) else { return [FLAT, 0.0] };
        let [diffuse, shine] = self.lit(normal, direction);
        [FLAT + surface * (diffuse - FLAT), surface * shine]
    }

    /// Diffuse light and highlight on a surface with this normal, whichever side faces the eye.
    fn lit(&self, normal: Vec3, direction: Vec3) -> [f64; 2] {
        let normal = if dot(normal, direction) > 0.0 { normal.map(|x| -x) } else { normal };
        let n = self.camera.turn(normal);
        let lambert = |lamp: Vec3| dot(n, lamp).max(0.0);
        let sky = 0.5 + 0.5 * n[1];
        [0.16 + 0.14 * sky + 0.50 * lambert(LAMP) + 0.30 * lambert([0.0, 0.0, 1.0]), 0.06 * lambert(HALF).powi(24)]
    }

    /// What a plane through the body shows: the values on it, as a layer of thickness `face`.
    fn cut_face(&self, p: Vec3, normal: Vec3, direction: Vec3, gathered: &mut Gathered) {
        let value = self.field.value(p);
        let [red, green, blue, extinction] = self.table.mean(value, value);
        if extinction > 0.0 {
            let [diffuse, _] = self.lit(normal, direction);
            let colour = [red, green, blue].map(|c| c / extinction * (0.35 + 0.65 * diffuse));
            gathered.add(colour, 1.0 - (-extinction * self.face).exp());
        }
    }

    /// The part of a ray within all kept half-spaces; `cut` is the normal of the clip that it enters through.
    fn interval(&self, start: Vec3, direction: Vec3, nearest: f64) -> Option<Interval> {
        let mut found = Interval { enter: nearest, leave: f64::INFINITY, cut: None };
        for (point, normal, clips) in &self.kept {
            let (slope, inside) = (dot(*normal, direction), dot(*normal, std::array::from_fn(|a| point[a] - start[a])));
            if slope == 0.0 {
                if inside < 0.0 {
                    return None;
                }
            } else if slope > 0.0 {
                found.leave = found.leave.min(inside / slope);
            } else if inside / slope > found.enter {
                found.enter = inside / slope;
                found.cut = clips.then_some(*normal);
            }
        }
        (found.enter < found.leave).then_some(found)
    }
}

/// Brightness where there is no surface.
const FLAT: f64 = 0.80;
/// The lamp, a little to the upper left of the eye, and the direction halfway between both; unit vectors.
const LAMP: Vec3 = [-0.382_359, 0.546_227, 0.745_292];
const HALF: Vec3 = [-0.204_682, 0.292_403, 0.934_131];

struct Interval {
    enter: f64,
    leave: f64,
    cut: Option<Vec3>,
}

fn box_sides([low, high]: [Vec3; 2], clips: bool) -> Vec<(Vec3, Vec3, bool)> {
    let axis = |a: usize, sign: f64| std::array::from_fn(|i| if i == a { sign } else { 0.0 });
    (0..3).flat_map(|a| [(low, axis(a, -1.0), clips), (high, axis(a, 1.0), clips)]).collect()
}

/// Where a line that is in a box leaves it.
fn exit([low, high]: [Vec3; 2], start: Vec3, along: Vec3) -> f64 {
    let side = |a: usize| match along[a] {
        0.0 => f64::INFINITY,
        d if d > 0.0 => (high[a] - start[a]) / d,
        d => (low[a] - start[a]) / d,
    };
    (0..3).map(side).fold(f64::INFINITY, f64::min)
}
