//! Losses of a fit by stage, model and iteration, kept as its worker reports them.
//!
//! A fit keeps a few thousand rows at most: beyond that only every second iteration is kept, then
//! every fourth and so on, and the last of each curve. Losses of an attempt replace those that an
//! earlier one computed from that iteration on, since it resumed from a checkpoint before it.

use std::collections::BTreeMap;

use bendtwin_core::{ModelLoss, Stage, ids::FitId};

use super::{Jobs, row::Row};
use crate::{
    Error, Result,
    sql::{Transaction, query, query_scalar, row::row},
};

/// Most losses that are kept of a fit.
const MOST: i64 = 4096;
/// Stride beyond which there are too many curves, and not too many iterations.
const LARGEST_STRIDE: i64 = 1 << 32;

row! {
    struct LossRow {
        stage: String,
        variant: String,
        iteration: i64,
        loss: Option<f64>,
        best_loss: Option<f64>,
        error_m: Option<f64>,
    }
}

impl Jobs<'_> {
    /// The losses of a fit, stage by stage, each model's in the order of iterations.
    ///
    /// # Errors
    /// [`Error::NotFound`].
    pub async fn losses(&self, fit: FitId) -> Result<Vec<ModelLoss>> {
        let key = fit.uuid().to_string();
        let rows: Vec<LossRow> = query(
            "select stage, variant, iteration, loss, best_loss, error_m from losses
                 where fit = $1",
        )
        .bind(&key)
        .fetch_all(self.store.inner.database.read())
        .await?;
        self.get(fit).await?;
        let corrupt = |stage: &str| Error::CorruptRow {
            name: fit.to_string(),
            fault: format!("a loss of the stage `{stage}`"),
        };
        let mut losses = Vec::with_capacity(rows.len());
        for LossRow { stage, variant, iteration, loss, best_loss, error_m } in rows {
            let stage = Stage::parse(&stage).ok_or_else(|| corrupt(&stage))?;
            let iteration = u32::try_from(iteration).unwrap_or(u32::MAX);
            losses.push(ModelLoss { stage, variant, iteration, loss, best_loss, error_m });
        }
        // Of `bending 2/12` and `bending 10/12` the shorter comes first, of bending and axial the
        // model that becomes the twin.
        losses.sort_by(|a, b| {
            let place = |l: &ModelLoss| (l.stage, !l.variant.starts_with("bending"));
            let curve = |l: &ModelLoss| (l.variant.chars().count(), l.variant.clone());
            place(a)
                .cmp(&place(b))
                .then_with(|| (curve(a), a.iteration).cmp(&(curve(b), b.iteration)))
        });
        Ok(losses)
    }
}

/// Stores losses of a running fit, whose row this is, within the caller's transaction.
pub(super) async fn record(tx: &mut Transaction, row: &Row, losses: &[ModelLoss]) -> Result<()> {
    if losses.is_empty() {
        return Ok(());
    }
    let mut curves: BTreeMap<(Stage, &str), Vec<&ModelLoss>> = BTreeMap::new();
    for loss in losses {
        curves.entry((loss.stage, &loss.variant)).or_default().push(loss);
    }
    for ((stage, variant), curve) in curves {
        forget_later(tx, row, stage, variant, &curve).await?;
        for loss in &curve {
            insert(tx, row, loss).await?;
        }
        // The one that was the last is not any more.
        let last = curve.iter().map(|loss| loss.iteration).max().unwrap_or(0);
        query(
            "delete from losses where fit = $1 and stage = $2 and variant = $3
                 and iteration < $4 and iteration % $5 <> 0",
        )
        .bind(&row.id)
        .bind(stage.as_str())
        .bind(variant)
        .bind(i64::from(last))
        .bind(row.loss_stride)
        .execute(&mut *tx)
        .await?;
    }
    thin_out(tx, row).await
}

/// Forgets what earlier attempts computed from the first iteration of a curve on.
async fn forget_later(
    tx: &mut Transaction,
    row: &Row,
    stage: Stage,
    variant: &str,
    curve: &[&ModelLoss],
) -> Result<()> {
    let first = curve.iter().map(|loss| loss.iteration).min().unwrap_or(0);
    query(
        "delete from losses where fit = $1 and stage = $2 and variant = $3 and iteration >= $4
             and epoch < $5",
    )
    .bind(&row.id)
    .bind(stage.as_str())
    .bind(variant)
    .bind(i64::from(first))
    .bind(row.lease_epoch)
    .execute(&mut *tx)
    .await?;
    if stage == Stage::Search {
        query("delete from losses where fit = $1 and stage = $2 and epoch < $3")
            .bind(&row.id)
            .bind(Stage::Refine.as_str())
            .bind(row.lease_epoch)
            .execute(&mut *tx)
            .await?;
    }
    Ok(())
}

async fn insert(tx: &mut Transaction, row: &Row, loss: &ModelLoss) -> Result<()> {
    query(
        "insert into losses (fit, stage, variant, iteration, loss, best_loss, epoch, error_m)
         values ($1, $2, $3, $4, $5, $6, $7, $8)
         on conflict (fit, stage, variant, iteration) do update set loss = excluded.loss,
             best_loss = excluded.best_loss, epoch = excluded.epoch, error_m = excluded.error_m",
    )
    .bind(&row.id)
    .bind(loss.stage.as_str())
    .bind(&loss.variant)
    .bind(i64::from(loss.iteration))
    .bind(loss.loss)
    .bind(loss.best_loss)
    .bind(row.lease_epoch)
    .bind(loss.error_m)
    .execute(&mut *tx)
    .await?;
    Ok(())
}

/// Doubles the stride until there are no more losses than may be.
async fn thin_out(tx: &mut Transaction, row: &Row) -> Result<()> {
    let count = "select count(*) from losses where fit = $1";
    let mut stride = row.loss_stride.max(1);
    while query_scalar(count).bind(&row.id).fetch_one::<i64>(&mut *tx).await? > MOST {
        if stride > LARGEST_STRIDE {
            // No fit has this many models.
            let all = "delete from losses where fit = $1";
            query(all).bind(&row.id).execute(&mut *tx).await?;
            break;
        }
        stride *= 2;
        query(
            "delete from losses where fit = $1 and iteration % $2 <> 0 and iteration < (
                 select max(l.iteration) from losses as l
                 where l.fit = losses.fit and l.stage = losses.stage
                     and l.variant = losses.variant)",
        )
        .bind(&row.id)
        .bind(stride)
        .execute(&mut *tx)
        .await?;
    }
    if stride != row.loss_stride {
        query("update jobs set loss_stride = $2 where id = $1")
            .bind(&row.id)
            .bind(stride)
            .execute(&mut *tx)
            .await?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
