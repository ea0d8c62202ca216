//! Plain tables: columns as wide as their widest cell.

/// Rows of cells under a header.
#[derive(Clone, Debug)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new<'h>(header: impl IntoIterator<Item = &'h str>) -> Self {
        Self { header: header.into_iter().map(str::to_owned).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        let mut cells: Vec<_> = cells.into_iter().take(self.header.len()).collect();
        cells.resize(self.header.len(), String::new());
        self.rows.push(cells);
    }

    /// The table as text, with columns aligned by spaces.
    pub fn text(&self) -> String {
        let widths = self.widths();
        let line = |cells: &[String]| {
            let padded = cells.iter().zip(&widths).map(|(c, w)| format!("{c:<w$}"));
            padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
        };
        let lines = std::iter::once(&self.header).chain(&self.rows).map(|r| line(r));
        lines.collect::<Vec<_>>().join("\n")
    }

    /// The table as Markdown, with columns aligned, too.
    pub fn markdown(&self) -> String {
        let widths = self.widths();
        let line = |cells: &[String]| {
            let padded = cells.iter().zip(&widths).map(|(c, w)| format!("{c:<w$}"));
            format!("| {} |", padded.collect::<Vec<_>>().join(" | "))
        };
        let rule: Vec<String> = widths.iter().map(|w| "-".repeat(*w)).collect();
        let lines = [&self.header, &rule].into_iter().chain(&self.rows).map(|r| line(r));
        lines.collect::<Vec<_>>().join("\n")
    }

    fn widths(&self) -> Vec<usize> {
        let width = |column: usize| {
            let cells = std::iter::once(&self.header).chain(&self.rows);
            cells.map(|r| r[column].chars().count()).max().unwrap_or(0)
        };
        (0..self.header.len()).map(width).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(["name", "nodes"]);
        table.row(["a".to_owned(), "1200".to_owned()]);
        table.row(["longer".to_owned()]);
        assert_eq!(table.text(), "name    nodes\na       1200\nlonger");
        let markdown =
            "| name   | nodes |\n| ------ | ----- |\n| a      | 1200  |\n| longer |       |";
        assert_eq!(table.markdown(), markdown);
    }
}
