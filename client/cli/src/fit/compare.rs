//! `bendtwin fit compare`: what differs between fits, and which is better on what.

use std::collections::BTreeSet;

use bendtwin_client::{Fit, FitId};
use bendtwin_core::quality::{ErrorSummary, Predictor, Score};
use serde::Serialize;
use serde_json::Value;

use super::{losses, settings, show::Details};
use crate::{failure::Usage, global::Global, output, table::Table};

/// A number of each fit, the lower the better.
#[derive(Debug, PartialEq, Serialize)]
struct Measure {
    name: String,
    /// Values by fit; `None` for fits without one.
    values: Vec<Option<f64>>,
    /// The fit with the lowest, from 0; none where they tie or cannot be compared.
    best: Option<usize>,
}

impl Measure {
    /// True if the lowest is lower than all others by more than seeds make them differ.
    fn is_clear(&self) -> bool {
        let Some(lowest) = self.best.and_then(|best| self.values[best]) else { return false };
        let others = self.values.iter().enumerate().filter(|(i, _)| Some(*i) != self.best);
        others.filter_map(|(_, value)| *value).all(|value| bendtwin_eval::differ([lowest, value]))
    }
}

/// A setting that is not the same in all fits.
#[derive(Debug, PartialEq, Serialize)]
struct Difference {
    name: String,
    values: Vec<Value>,
}

#[derive(Debug, Serialize)]
struct Comparison {
    fits: Vec<Details>,
    settings: Vec<Difference>,
    losses: Vec<Measure>,
    /// Errors [m].
    errors: Vec<Measure>,
    /// Reasons for which numbers are not those of the same thing.
    notes: Vec<String>,
}

pub(super) async fn run(names: Vec<FitId>, global: &Global) -> anyhow::Result<()> {
    let distinct: BTreeSet<&FitId> = names.iter().collect();
    if distinct.len() < names.len() {
        return Err(Usage::error("name each fit once"));
    }
    let client = global.connect().await?;
    let mut fits = Vec::with_capacity(names.len());
    for name in names {
        fits.push(Details::fetch(&client, name).await?);
    }
    let comparison = Comparison::of(fits);
    output::print(global, &comparison, || comparison.text())
}

impl Comparison {
    fn of(fits: Vec<Details>) -> Self {
        let same = |of: fn(&Fit) -> Value| fits.windows(2).all(|w| of(&w[0].fit) == of(&w[1].fit));
        let same_capture = same(|fit| fit.capture.to_string().into());
        // A loss is that of its weights, over its frames.
        let same_loss = same_capture && same(|fit| fit.job.settings["loss"].clone());
        let mut notes = Vec::new();
        if !same_capture {
            notes.push("the fits are of different captures: losses and errors are, too".to_owned());
        } else if !same_loss {
            notes.push("the fits weigh losses differently: compare their errors".to_owned());
        }
        let (settings, losses, errors) = (differences(&fits), losses_of(&fits), errors_of(&fits));
        let judge = |measures: Vec<Measure>, comparable: bool| {
            let judged = measures.into_iter().map(|m| {
                let best = best(&m.values).filter(|_| comparable);
                Measure { best, ..m }
            });
            judged.collect::<Vec<_>>()
        };
        let (losses, errors) = (judge(losses, same_loss), judge(errors, same_capture));
        Self { fits, settings, losses, errors, notes }
    }

    fn text(&self) -> String {
        let letters: Vec<String> = (0..self.fits.len()).map(letter).collect();
        let mut table = Table::new(["", "NAME", "STATE", "TOOK", "WHAT", "CAPTURE"]);
        for (letter, details) in letters.iter().zip(&self.fits) {
            let Details { fit, capture_display_name, .. } = details;
            let took = fit.job.start_time.zip(fit.job.end_time);
            let took = took.map(|(s, e)| output::duration(e.duration_since(s).as_secs_f64()));
            table.row([
                letter.clone(),
                fit.name.to_string(),
                fit.job.state.as_str().to_owned(),
                took.unwrap_or_default(),
                fit.display_name.clone(),
                capture_display_name.clone().unwrap_or_else(|| "deleted".to_owned()),
            ]);
        }
        let mut text = table.text();
        let header = || std::iter::once("").chain(letters.iter().map(String::as_str));
        text += "\n\nsettings that differ\n";
        if self.settings.is_empty() {
            text += "  none";
        } else {
            let mut table = Table::new(header());
            for Difference { name, values } in &self.settings {
                let cells = values.iter().map(|value| settings::word(Some(value)));
                table.row(std::iter::once(name.clone()).chain(cells));
            }
            text += &table.text();
        }
        let losses = |l: f64| format!("{l:.2e}");
        text += &section("best losses (* lowest)", header(), &self.losses, losses);
        let errors = |e: f64| format!("{:.2}", 1e3 * e);
        text += &section("errors in mm (* lowest)", header(), &self.errors, errors);
        for note in &self.notes {
            text += &format!("\n\nnote: {note}");
        }
        text + &self.verdict(&letters)
    }

    /// Measures on which each fit is the best, a line each, and those without a best fit.
    fn verdict(&self, letters: &[String]) -> String {
        let named = |of: &dyn Fn(&Measure) -> bool| -> String {
            let names = self.errors.iter().filter(|m| m.best.is_some() && of(m));
            names.map(|m| m.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let mut text = String::new();
        for (index, letter) in letters.iter().enumerate() {
            let names = named(&|m| m.best == Some(index) && m.is_clear());
            if !names.is_empty() {
                text += &format!("\n{letter} is nearest on: {names}");
            }
        }
        let names = named(&|m| !m.is_clear());
        if !names.is_empty() {
            text += &format!("\nno difference beyond what seeds make on: {names}");
        }
        if text.is_empty() { text } else { format!("\n{text}") }
    }
}

/// A, B, and so on; beyond Z numbers.
fn letter(index: usize) -> String {
    match u8::try_from(index) {
        Ok(index) if index < 26 => char::from(b'A' + index).to_string(),
        _ => (index + 1).to_string(),
    }
}

fn section<'h>(
    title: &str,
    header: impl Iterator<Item = &'h str>,
    measures: &[Measure],
    number: impl Fn(f64) -> String,
) -> String {
    if measures.is_empty() {
        return String::new();
    }
    let mut table = Table::new(header);
    for measure in measures {
        let cell = |(index, value): (usize, &Option<f64>)| {
            let mark = if measure.best == Some(index) { " *" } else { "" };
            value.map(|v| number(v) + mark).unwrap_or_default()
        };
        let cells = measure.values.iter().enumerate().map(cell);
        table.row(std::iter::once(measure.name.clone()).chain(cells));
    }
    format!("\n\n{title}\n{}", table.text())
}

fn differences(fits: &[Details]) -> Vec<Difference> {
    let all: Vec<_> = fits.iter().map(|d| settings::flat(&d.fit.job.settings)).collect();
    let mut names: Vec<&String> = Vec::new();
    for (name, _) in all.iter().flatten() {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let values = |name: &str| -> Vec<Value> {
        let value = |of: &Vec<(String, Value)>| settings::value(of, name).cloned();
        all.iter().map(|of| value(of).unwrap_or_default()).collect()
    };
    let difference = |name: &String| Difference { name: name.clone(), values: values(name) };
    let differs = |d: &Difference| d.values.windows(2).any(|w| w[0] != w[1]);
    names.into_iter().map(difference).filter(differs).collect()
}

/// The best loss of each stage and kind of model, of several starts the lowest.
fn losses_of(fits: &[Details]) -> Vec<Measure> {
    let mut measures = Vec::new();
    for stage in ["search", "refine"] {
        for model in ["bending", "axial"] {
            let values: Vec<_> = fits
                .iter()
                .map(|d| {
                    let own = |c: &&bendtwin_client::LossCurve| {
                        c.stage == stage && c.variant.starts_with(model)
                    };
                    d.losses.iter().filter(own).filter_map(losses::best).reduce(f64::min)
                })
                .collect();
            if values.iter().any(Option::is_some) {
                measures.push(Measure { name: format!("{stage} {model}"), values, best: None });
            }
        }
    }
    measures
}

/// Errors over future and training frames, of the twin and of its axial-only model.
fn errors_of(fits: &[Details]) -> Vec<Measure> {
    type Error = fn(&ErrorSummary) -> Option<f64>;
    let errors: [(&str, Error); 4] = [
        ("track", |e| e.track_m),
        ("CD", |e| e.chamfer_l1_m),
        ("coordinate", |e| e.coordinate_m),
        ("padded RMS", |e| e.padded_rms_m),
    ];
    type Span = fn(&Score) -> &ErrorSummary;
    let spans: [(&str, Span); 2] = [("future", |s| &s.future), ("train", |s| &s.train)];
    let own = |d: &Details| d.quality.as_ref().and_then(|q| q.scores.first().cloned());
    let axial = |d: &Details| {
        let quality = d.quality.as_ref()?;
        let score = quality.score(Predictor::Axial)?;
        // Of a fit without bending it is the twin itself.
        (quality.scores.first() != Some(score)).then(|| score.clone())
    };
    type Row<'r> = &'r dyn Fn(&Details) -> Option<Score>;
    let rows: [(&str, Row<'_>); 2] = [("", &own), (", axial only", &axial)];
    let mut measures = Vec::new();
    for (of, score) in rows {
        for (span, part) in spans {
            for (error, measure) in errors {
                let value = |d: &Details| measure(part(&score(d)?));
                let values: Vec<_> = fits.iter().map(value).collect();
                if values.iter().any(Option::is_some) {
                    let name = format!("{error} {span}{of}");
                    measures.push(Measure { name, values, best: None });
                }
            }
        }
    }
    measures
}

/// The place of the only lowest value, if there are several to compare.
fn best(values: &[Option<f64>]) -> Option<usize> {
    let known = || values.iter().enumerate().filter_map(|(i, v)| Some((i, (*v)?)));
    let (index, lowest) = known().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let rivals = known().filter(|(i, _)| *i != index);
    let beaten = rivals.map(|(_, v)| v > lowest).reduce(|a, b| a && b)?;
    beaten.then_some(index)
}

#[cfg(test)]
mod tests;
