//! A grid of ready pictures with labels: rows of methods, columns of times.

use crate::{
    Category, Colouring, Image, Panel, PictureError,
    image::Rect,
    key,
    text::Style,
    theme::{PAPER, RULE, Theme},
};

/// Height of a line of text in em.
const LEADING: f32 = 1.32;

/// Pictures of equal size in rows and columns, with a label at the left of each row and at the top of each column.
///
/// ```
/// use grosgrain_picture::{Sheet, SheetPicture, TransferFunction, VolumeScene};
/// let samples = vec![100.0; 4096];
/// let scene = VolumeScene { width: 90, height: 70, ..VolumeScene::new(&samples, [16; 3], [0.01; 3], TransferFunction::ct()) };
/// let picture = SheetPicture { image: Some(scene.render()?), note: "error 1.2 %".into() };
/// let sheet = Sheet {
///     title: "A block".into(),
///     rows: vec!["fine".into()],
///     columns: vec!["0.0 s".into(), "0.5 s".into()],
///     pictures: vec![picture.clone(), picture],
///     ..Sheet::default()
/// };
/// assert!(sheet.render()?.width() > 180);
/// # Ok::<(), grosgrain_picture::PictureError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Heading; empty for none.
    pub title: String,
    /// Label of each row; empty strings take no room.
    pub rows: Vec<String>,
    /// Label of each column; empty strings take no room.
    pub columns: Vec<String>,
    /// The pictures, row by row.
    pub pictures: Vec<SheetPicture>,
    /// Colours that all pictures share; empty for none.
    pub legend: Vec<Category>,
    /// Small lines under the pictures.
    pub footer: Vec<String>,
    /// Height of the labels' letters in pixels, 8 to 100.
    pub letters: f32,
    /// The sheet is at least this wide \[pixels\].
    pub width: usize,
}

impl Default for Sheet {
    fn default() -> Self {
        let (title, rows, columns, pictures) = (String::new(), vec![], vec![], vec![]);
        Self { title, rows, columns, pictures, legend: vec![], footer: vec![], letters: 20.0, width: 0 }
    }
}

/// A picture on a sheet.
#[derive(Clone, Debug, Default)]
pub struct SheetPicture {
    /// The picture; `None` leaves its place empty.
    pub image: Option<Image>,
    /// A line under it; empty for none.
    pub note: String,
}

impl Sheet {
    /// Draws the sheet.
    ///
    /// # Errors
    /// A number of pictures that is not rows × columns, none at all, pictures of different sizes, letters outside 8 to 100.
    pub fn render(&self) -> Result<Image, PictureError> {
        let size = self.validate()?;
        let theme = Theme::with_letters(self.letters)?;
        let key = self.key();
        let layout = SheetLayout::new(self, &theme, &key, size);
        let mut image = Image::new(layout.width as usize, layout.height as usize, PAPER);
        layout.draw(self, &key, &mut image);
        Ok(image)
    }

    fn key(&self) -> Panel {
        let colouring = match self.legend.is_empty() {
            true => Colouring::default(),
            false => Colouring::Category { of_quad: vec![], legend: self.legend.clone() },
        };
        Panel { colouring, ..Panel::default() }
    }

    /// The size that all pictures have.
    fn validate(&self) -> Result<[usize; 2], PictureError> {
        let (rows, columns, found) = (self.rows.len(), self.columns.len(), self.pictures.len());
        if found != rows * columns {
            return Err(PictureError::SheetCount { rows, columns, found });
        }
        let mut sizes = self.pictures.iter().filter_map(|p| p.image.as_ref()).map(|i| [i.width(), i.height()]);
        let first = sizes.next().ok_or(PictureError::SheetCount { rows, columns, found: 0 })?;
        match sizes.find(|size| *size != first) {
            Some(other) => Err(PictureError::PictureSizes { first, other }),
            None => Ok(first),
        }
    }
}

/// What a sheet takes besides its pictures.
pub(crate) struct Borders {
    pub(crate) margin: f32,
    pub(crate) gap: f32,
    /// Width of the row labels with the gap after them.
    pub(crate) labels: f32,
}

impl Borders {
    pub(crate) fn new(theme: &Theme, rows: &[String]) -> Self {
        let em = theme.caption().size;
        let lines = rows.iter().flat_map(|r| theme.face.wrap(r, theme.caption(), 8.0 * em));
        let widest = lines.map(|line| theme.face.width(&line, theme.caption())).fold(0.0, f32::max);
        let labels = if widest > 0.0 { widest + 0.9 * em } else { 0.0 };
        Self { margin: em.round(), gap: (0.6 * em).round(), labels: labels.ceil() }
    }

    /// Width in pixels that each of `columns` pictures has on a sheet `width` pixels wide.
    pub(crate) fn picture_width(&self, width: usize, columns: usize) -> f32 {
        let free = width as f32 - 2.0 * self.margin - self.labels - self.gap * (columns.max(1) - 1) as f32;
        (free / columns.max(1) as f32).floor()
    }
}

struct SheetLayout<'a> {
    theme: &'a Theme,
    borders: Borders,
    size: [f32; 2],
    title: Vec<String>,
    footer: Vec<String>,
    /// Where the first row of pictures begins, and the distance to the next.
    top: f32,
    pitch: f32,
    key: f32,
    width: f32,
    height: f32,
}

impl<'a> SheetLayout<'a> {
    fn new(sheet: &Sheet, theme: &'a Theme, key: &Panel, size: [usize; 2]) -> Self {
        let borders = Borders::new(theme, &sheet.rows);
        let size = size.map(|n| n as f32);
        let columns = sheet.columns.len() as f32;
        let Borders { margin, gap, labels } = borders;
        let width = 2.0 * margin + labels + columns * size[0] + gap * (columns - 1.0);
        let title = theme.face.wrap(&sheet.title, theme.title(), width - 2.0 * margin);
        let wrapped = |line: &String| theme.face.wrap(line, theme.small(), width - 2.0 * margin);
        let footer: Vec<String> = sheet.footer.iter().flat_map(wrapped).collect();
        let mut top = margin + LEADING * theme.title().size * title.len() as f32;
        if sheet.columns.iter().any(|c| !c.is_empty()) {
            top += 1.2 * LEADING * theme.caption().size;
        }
        let note = if sheet.pictures.iter().any(|p| !p.note.is_empty()) { LEADING * theme.detail().size } else { 0.0 };
        let (top, pitch) = (top.round(), (size[1] + note + gap).round());
        let key = key::height(key, theme, width - 2.0 * margin);
        let mut height = top + pitch * sheet.rows.len() as f32 - gap + margin;
        height += if key > 0.0 { key + 0.6 * margin } else { 0.0 };
        height += LEADING * theme.small().size * footer.len() as f32;
        Self {
            theme,
            borders,
            size,
            title,
            footer,
            top,
            pitch,
            key,
            width: width.ceil().max(sheet.width as f32),
            height: height.ceil(),
        }
    }

    fn draw(&self, sheet: &Sheet, key: &Panel, image: &mut Image) {
        let Borders { margin, gap, labels } = self.borders;
        let face = &self.theme.face;
        draw_lines(self.theme, image, [margin, margin], &self.title, self.theme.title());
        let left = |column: usize| (margin + labels + (self.size[0] + gap) * column as f32).round();
        for (column, label) in sheet.columns.iter().enumerate() {
            let style = self.theme.caption();
            let at = [left(column) + 0.5 * self.size[0], self.top - 0.45 * style.size];
            face.draw_centred(image, at, &face.cut(label, style, self.size[0]), style);
        }
        for (row, label) in sheet.rows.iter().enumerate() {
            let y = self.top + self.pitch * row as f32;
            if row > 0 {
                let line = y - 0.5 * gap;
                image.stroke([margin, line], [self.width - margin, line], 1.0, RULE);
            }
            self.draw_row_label(label, y, image);
            for column in 0..sheet.columns.len() {
                self.draw_picture(&sheet.pictures[row * sheet.columns.len() + column], [left(column), y], image);
            }
        }
        let mut y = self.top + self.pitch * sheet.rows.len() as f32 - gap + 0.6 * margin;
        if self.key > 0.0 {
            let area = Rect { x: margin, y, width: self.width - 2.0 * margin, height: self.key };
            key::draw(key, self.theme, image, area);
            y += self.key;
        }
        draw_lines(self.theme, image, [margin, y], &self.footer, self.theme.small());
    }

    fn draw_row_label(&self, label: &str, y: f32, image: &mut Image) {
        let style = self.theme.caption();
        let lines = self.theme.face.wrap(label, style, self.borders.labels);
        let height = LEADING * style.size * lines.len() as f32;
        draw_lines(self.theme, image, [self.borders.margin, y + 0.5 * (self.size[1] - height)], &lines, style);
    }

    fn draw_picture(&self, picture: &SheetPicture, [x, y]: [f32; 2], image: &mut Image) {
        if let Some(drawn) = &picture.image {
            image.paste(drawn, [x as usize, y as usize]);
        }
        let style = self.theme.detail();
        let note = self.theme.face.cut(&picture.note, style, self.size[0]);
        self.theme.face.draw_centred(
            image,
            [x + 0.5 * self.size[0], y + self.size[1] + 0.95 * style.size],
            &note,
            style,
        );
    }
}

fn draw_lines(theme: &Theme, image: &mut Image, [x, mut y]: [f32; 2], lines: &[String], style: Style) {
    for line in lines {
        theme.face.draw(image, [x, y + 0.95 * style.size], line, style);
        y += LEADING * style.size;
    }
}
