//! One panel's body: from surface and lines to pixels.

use crate::{
    Colouring, Image, Panel,
    camera::{Camera, Vec3},
    colour::{Rgb, SrgbTable, category_colour, to_linear},
    occlusion::{self, Relief},
    raster::{Corner, Pen, Raster},
    surface::{self, EdgeKind, Normals},
};

/// How far behind the body's surface a wire is still drawn, in radii of what the camera sees.
const WIRE_DEPTH: f64 = 0.06;
/// Samples per pixel along each axis.
const SAMPLES: usize = 3;
const INK: Rgb = [0x1d, 0x23, 0x2e];
const GHOST: Rgb = [0x8a, 0x94, 0xa3];

/// Where a body goes, and in which colours.
pub(crate) struct Placement<'a> {
    pub(crate) camera: &'a Camera,
    /// Pixels per unit of length at the body's centre.
    pub(crate) scale: f64,
    /// Width and height of the view in pixels.
    pub(crate) size: [usize; 2],
    /// Ends of the colour scale, for scalar colouring.
    pub(crate) range: [f64; 2],
    /// Thickness of a thin line in pixels.
    pub(crate) stroke: f64,
}

/// The pixels of a view, from its upper left corner.
pub(crate) struct View {
    size: [usize; 2],
    pixels: Vec<Rgb>,
}

impl View {
    /// The view as a picture of its own.
    pub(crate) fn into_image(self) -> Image {
        let mut image = Image::new(self.size[0], self.size[1], [0xff; 3]);
        self.paste(&mut image, [0, 0]);
        image
    }

    /// Copies the view into a picture with its upper left corner at `[x, y]`.
    pub(crate) fn paste(&self, image: &mut Image, [x, y]: [usize; 2]) {
        for (at, colour) in self.pixels.iter().enumerate() {
            image.set(x + at % self.size[0], y + at / self.size[0], *colour);
        }
    }
}

/// Draws a validated panel's body on `paper`.
pub(crate) fn draw(panel: &Panel, placement: &Placement, paper: Rgb) -> View {
    let normals = Normals::new(&panel.surface, placement.camera);
    let projected = panel.surface.positions.iter().map(|p| placement.sample(*p)).collect();
    let palette = Palette::new(&panel.colouring, placement.range);
    let body = Body { panel, placement, normals, projected, palette };
    let mut raster = Raster::new(SAMPLES * placement.size[0], SAMPLES * placement.size[1]);
    body.draw_quads(&mut raster);
    body.draw_edges(&mut raster);
    body.draw_lines(&mut raster);
    let sky = body.sky_seen(&raster);
    View { size: placement.size, pixels: body.resolve(&raster, &sky, paper) }
}

/// A panel's body, ready to be drawn.
struct Body<'a> {
    panel: &'a Panel,
    placement: &'a Placement<'a>,
    normals: Normals,
    /// Vertices in samples: x, y, closeness.
    projected: Vec<Vec3>,
    palette: Palette<'a>,
}

impl Placement<'_> {
    /// A point in samples: x to the right, y downwards, closeness.
    fn sample(&self, p: Vec3) -> Vec3 {
        let [x, y, z] = self.camera.project(p);
        let [[left, bottom], [right, top]] = self.camera.bounds;
        let s = self.scale * SAMPLES as f64;
        let middle = self.size.map(|n| 0.5 * (SAMPLES * n) as f64);
        [middle[0] + s * (x - 0.5 * (left + right)), middle[1] - s * (y - 0.5 * (bottom + top)), s * z]
    }

    fn pen(&self, layer: usize, width: f64, opacity: f64) -> Pen {
        let samples = SAMPLES as f64;
        let bias = (0.006 * self.camera.radius * self.scale * samples).max(2.5);
        Pen { layer, radius: 0.5 * width * self.stroke * samples, opacity, bias }
    }
}

/// The colours of a panel: a table, and the tone at which each corner looks it up.
struct Palette<'a> {
    table: Vec<[f32; 3]>,
    colouring: &'a Colouring,
    range: [f64; 2],
}

impl<'a> Palette<'a> {
    fn new(colouring: &'a Colouring, range: [f64; 2]) -> Self {
        let colours: Vec<Rgb> = match colouring {
            Colouring::Plain(colour) => vec![*colour],
            Colouring::Category { legend, .. } => {
                legend.iter().enumerate().map(|(i, c)| c.colour.unwrap_or_else(|| category_colour(i))).collect()
            }
            Colouring::Scalar { scale, .. } | Colouring::QuadScalar { scale, .. } => {
                (0..1024).map(|i| scale.colour(f64::from(i) / 1023.0)).collect()
            }
        };
        Self { table: colours.into_iter().map(to_linear).collect(), colouring, range }
    }

    fn tone(&self, quad: usize, vertex: u32) -> f64 {
        let along = |value: f64| ((value - self.range[0]) / (self.range[1] - self.range[0])).clamp(0.0, 1.0);
        match self.colouring {
            Colouring::Plain(_) => 0.0,
            Colouring::Category { of_quad, .. } => f64::from(of_quad[quad]) / (self.table.len() - 1).max(1) as f64,
            Colouring::Scalar { at_vertex, .. } => along(at_vertex[vertex as usize]),
            Colouring::QuadScalar { of_quad, .. } => along(of_quad[quad]),
        }
    }

    fn colour(&self, tone: u16) -> [f32; 3] {
        let last = self.table.len() - 1;
        self.table[(usize::from(tone) * last + 32767) / 65535]
    }
}

impl Body<'_> {
    fn draw_quads(&self, raster: &mut Raster) {
        for (quad, vertices) in self.panel.surface.quads.iter().enumerate() {
            let corner = |i: usize| {
                let [x, y, closeness] = self.projected[vertices[i] as usize];
                let light = surface::light(self.placement.camera.turn(self.normals.of_corner[quad][i]));
                Corner { x, y, closeness, tone: self.palette.tone(quad, vertices[i]), light }
            };
            let corners: [Corner; 4] = std::array::from_fn(corner);
            let [a, b, c, d] = corners;
            let is_triangle = vertices[2] == vertices[3];
            let large = !is_triangle && (a.x - c.x).abs().max((a.y - c.y).abs()) > 6.0 * SAMPLES as f64;
            if large {
                let centre = Corner::mean(&corners);
                for [p, q] in [[a, b], [b, c], [c, d], [d, a]] {
                    raster.triangle(quad as u32, [p, q, centre]);
                }
            } else {
                raster.triangle(quad as u32, [a, b, c]);
                if !is_triangle {
                    raster.triangle(quad as u32, [a, c, d]);
                }
            }
        }
    }

    fn draw_edges(&self, raster: &mut Raster) {
        let category = |quad: usize| match &self.panel.colouring {
            Colouring::Category { of_quad, .. } => of_quad[quad],
            _ => 0,
        };
        let edges = surface::edges(&self.panel.surface, &self.normals, category);
        let ends = |edge: &surface::Edge| edge.vertices.map(|v| self.projected[v as usize]);
        let length = |[a, b]: [Vec3; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let mean = edges.iter().map(|e| length(ends(e))).sum::<f64>() / edges.len() as f64 / SAMPLES as f64;
        // Cell edges fade in as cells grow from 5 to 14 pixels: a denser mesh would only be a grey veil.
        let room = ((mean / self.placement.stroke - 5.0) / 9.0).clamp(0.0, 1.0);
        for edge in &edges {
            let (width, opacity) = match edge.kind {
                EdgeKind::Boundary => (1.0, 0.22 + 0.38 * room),
                EdgeKind::Rim => (1.2, 0.60),
                EdgeKind::Silhouette => (1.1, 0.30 + 0.25 * room),
                EdgeKind::Crease => (0.9, 0.40 * room),
                EdgeKind::Cell => (0.8, 0.20 * room),
            };
            if opacity > 0.02 {
                let [a, b] = ends(edge);
                raster.line(a, b, self.placement.pen(1, width, opacity));
            }
        }
    }

    fn draw_lines(&self, raster: &mut Raster) {
        for (lines, pen) in
            [(&self.panel.ghost, self.placement.pen(0, 1.2, 0.8)), (&self.panel.grid, self.placement.pen(1, 1.5, 0.85))]
        {
            for line in lines {
                let [a, b] = line.map(|p| self.placement.sample(p));
                raster.line(a, b, pen);
            }
        }
        let pen = self.placement.pen(1, 1.6, 0.85);
        let samples = self.placement.scale * SAMPLES as f64;
        let pen = Pen { bias: (WIRE_DEPTH * self.placement.camera.radius * samples).max(pen.bias), ..pen };
        for edge in surface::edges_to_eye(&self.panel.wires, self.placement.camera) {
            let [a, b] = edge.map(|v| self.placement.sample(self.panel.wires.positions[v as usize]));
            raster.line(a, b, pen);
        }
    }

    fn sky_seen(&self, raster: &Raster) -> Vec<f32> {
        let [width, height] = self.placement.size;
        let middle =
            |at: usize| (at / width * SAMPLES + SAMPLES / 2) * raster.width + at % width * SAMPLES + SAMPLES / 2;
        let found = |at: usize| raster.closeness[middle(at)];
        let closeness =
            (0..width * height).map(|at| Some(found(at) / SAMPLES as f32).filter(|z| z.is_finite())).collect();
        let turned: Vec<Vec3> = self.normals.of_quad.iter().map(|n| self.placement.camera.turn(*n)).collect();
        let normal = (0..width * height).map(|at| turned[raster.quad[middle(at)] as usize]).collect();
        let radius = (0.12 * self.placement.camera.radius * self.placement.scale).max(6.0);
        occlusion::sky_seen(&Relief { width, height, closeness, normal }, radius)
    }

    /// Averages the samples of every pixel in linear light.
    fn resolve(&self, raster: &Raster, sky: &[f32], paper: Rgb) -> Vec<Rgb> {
        let table = SrgbTable::new();
        let [ink, ghost, empty] = [INK, GHOST, paper].map(to_linear);
        let width = self.placement.size[0];
        let colour = |i: usize, sky: f32| {
            if raster.closeness[i] == f32::NEG_INFINITY {
                return inked(inked(empty, ghost, raster.ink[i][0]), ink, raster.ink[i][1]);
            }
            let [tone, light] = raster.tone[i];
            let light = f32::from(light) / 65535.0 * (0.25 + 0.75 * sky);
            inked(self.palette.colour(tone).map(|c| c * light), ink, raster.ink[i][1])
        };
        let blank = |i: usize| raster.closeness[i] == f32::NEG_INFINITY && raster.ink[i] == [0; 2];
        let pixel = |at: usize| {
            let corner = at / width * SAMPLES * raster.width + at % width * SAMPLES;
            let samples = || (0..SAMPLES * SAMPLES).map(|s| corner + s / SAMPLES * raster.width + s % SAMPLES);
            if samples().all(blank) {
                return paper;
            }
            let sum = samples().map(|i| colour(i, sky[at])).fold([0.0; 3], |a, b| std::array::from_fn(|c| a[c] + b[c]));
            table.encode(sum.map(|c| c / (SAMPLES * SAMPLES) as f32))
        };
        (0..sky.len()).map(pixel).collect()
    }
}

fn inked(under: [f32; 3], ink: [f32; 3], opacity: u8) -> [f32; 3] {
    std::array::from_fn(|c| under[c] + f32::from(opacity) / 255.0 * (ink[c] - under[c]))
}
