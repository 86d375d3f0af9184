//! Tables in Markdown.

/// Rows under a header; numbers stand to the right.
pub struct Table {
    lines: Vec<String>,
}

impl Table {
    pub fn new(header: &[&str]) -> Self {
        let rule: Vec<&str> = header.iter().map(|_| "---:").collect();
        Self { lines: vec![format!("| {} |", header.join(" | ")), format!("| {} |", rule.join(" | "))] }
    }

    pub fn row(&mut self, cells: &[String]) {
        self.lines.push(format!("| {} |", cells.join(" | ")));
    }

    pub fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }
}
