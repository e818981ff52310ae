//! Errors as text.

use std::fmt;

use super::metrics::LightError;

/// The errors as a table in plain text, one light a line.
#[derive(Clone, Copy, Debug)]
pub struct ErrorTable<'a>(pub &'a [LightError]);

impl fmt::Display for ErrorTable<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let head = [
            "light",
            "compared",
            "other tri",
            "boundary",
            "band",
            "wrong",
            "leak",
            "false",
            "out of band",
            "outside",
            "rmse",
            "penumbra",
            "mean",
            "p99",
            "max",
            "dist mean",
            "dist max",
            "verdict",
        ];
        let mut rows = vec![head.map(String::from)];
        let lights = self.0.iter().flat_map(|light| std::iter::once(light).chain(&light.channels));
        rows.extend(lights.map(|e| {
            [
                e.name.clone(),
                e.compared.to_string(),
                e.different_triangle.to_string(),
                e.boundary_pixels.to_string(),
                e.band_pixels.to_string(),
                e.wrong.to_string(),
                e.leak.to_string(),
                e.false_shadow.to_string(),
                e.wrong_outside_band.to_string(),
                e.outside_bounds.to_string(),
                format!("{:.5}", e.rmse),
                format!("{:.5}", e.penumbra_rmse),
                format!("{:+.5}", e.signed_mean),
                format!("{:.3}", e.p99),
                format!("{:.3}", e.max),
                format!("{:.2}", e.boundary_distance_mean_px),
                format!("{:.2}", e.boundary_distance_max_px),
                e.verdict().to_string(),
            ]
        }));
        let widths: Vec<usize> = (0..head.len())
            .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
            .collect();
        for (index, row) in rows.iter().enumerate() {
            // Names to the left, numbers to the right.
            write!(f, "{:<width$}", row[0], width = widths[0])?;
            for (cell, width) in row[1..].iter().zip(&widths[1..]) {
                write!(f, "  {cell:>width$}")?;
            }
            if index + 1 < rows.len() {
                writeln!(f)?;
            }
        }
        Ok(())
    }
}
