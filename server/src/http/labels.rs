//! Changes of name, note and tags, and the selections of lists.

use bendtwin_store::{PageRequest, State};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use crate::app::{Change, Error, Listing, Result};

/// Fields to change; those that are left out or null stay.
#[derive(Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct LabelUpdate {
    /// Up to 200 characters.
    display_name: Option<String>,
    /// Up to 10,000 bytes.
    note: Option<String>,
    /// All tags: up to 32 words of up to 50 letters, digits and `-_.:/`.
    tags: Option<Vec<String>>,
    /// Tags to add to those that there are; not beside `tags`.
    #[serde(default)]
    add_tags: Vec<String>,
    /// Tags to take from those that there are; not beside `tags`.
    #[serde(default)]
    remove_tags: Vec<String>,
}

impl From<LabelUpdate> for Change {
    fn from(update: LabelUpdate) -> Self {
        let LabelUpdate { display_name, note, tags, add_tags, remove_tags } = update;
        Self { display_name, note, tags, add_tags, remove_tags }
    }
}

/// Selection of captures.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct CaptureList {
    /// 0 means 50; more than 1000 counts as 1000.
    #[serde(default)]
    page_size: u32,
    /// `next_page_token` of the previous page, with the same filters and order.
    #[serde(default)]
    page_token: String,
    /// Text in display name or note, whatever its case.
    #[serde(default)]
    #[param(max_length = 200)]
    search: String,
    /// A tag.
    #[serde(default)]
    tag: String,
    /// An owner.
    #[serde(default)]
    #[param(max_length = 200)]
    owner: String,
    /// `create_time` or `name`, ascending or, followed by ` desc`, descending. Newest first if empty.
    #[serde(default)]
    #[param(pattern = "^((create_time|name)( asc| desc)?)?$")]
    order_by: String,
}

/// Selection of fits.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct FitList {
    /// 0 means 50; more than 1000 counts as 1000.
    #[serde(default)]
    page_size: u32,
    /// `next_page_token` of the previous page, with the same filters and order.
    #[serde(default)]
    page_token: String,
    /// Restricts the list to this capture.
    #[serde(default)]
    #[param(pattern = "^(captures/[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12})?$")]
    capture: String,
    /// QUEUED, RUNNING, SUCCEEDED, FAILED or CANCELLED.
    #[serde(default)]
    #[param(pattern = "^(QUEUED|RUNNING|SUCCEEDED|FAILED|CANCELLED)?$")]
    state: String,
    /// Text in display name or note, whatever its case.
    #[serde(default)]
    #[param(max_length = 200)]
    search: String,
    /// A tag.
    #[serde(default)]
    tag: String,
    /// An owner.
    #[serde(default)]
    #[param(max_length = 200)]
    owner: String,
    /// `create_time`, `name` or `error`, ascending or, followed by ` desc`, descending. Newest first
    /// if empty.
    #[serde(default)]
    #[param(pattern = "^((create_time|name|error)( asc| desc)?)?$")]
    order_by: String,
}

/// Selection of twins.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct TwinList {
    /// 0 means 50; more than 1000 counts as 1000.
    #[serde(default)]
    page_size: u32,
    /// `next_page_token` of the previous page, with the same filters and order.
    #[serde(default)]
    page_token: String,
    /// Restricts the list to this capture.
    #[serde(default)]
    #[param(pattern = "^(captures/[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12})?$")]
    capture: String,
    /// Text in display name or note, whatever its case.
    #[serde(default)]
    #[param(max_length = 200)]
    search: String,
    /// A tag.
    #[serde(default)]
    tag: String,
    /// An owner.
    #[serde(default)]
    #[param(max_length = 200)]
    owner: String,
    /// `create_time`, `name` or `error`, ascending or, followed by ` desc`, descending. Newest first
    /// if empty.
    #[serde(default)]
    #[param(pattern = "^((create_time|name|error)( asc| desc)?)?$")]
    order_by: String,
}

impl From<CaptureList> for Listing {
    fn from(list: CaptureList) -> Self {
        let CaptureList { page_size, page_token, search, tag, owner, order_by } = list;
        let page = PageRequest { size: page_size, token: page_token };
        Self { page, search, tag, owner, order_by, ..Self::default() }
    }
}

impl TryFrom<FitList> for Listing {
    type Error = Error;
    fn try_from(list: FitList) -> Result<Self> {
        let FitList { page_size, page_token, capture, state, search, tag, owner, order_by } = list;
        let page = PageRequest { size: page_size, token: page_token };
        let state = match state.as_str() {
            "" => None,
            word => Some(read_state(word)?),
        };
        Ok(Self { page, search, tag, capture, state, owner, order_by })
    }
}

impl From<TwinList> for Listing {
    fn from(list: TwinList) -> Self {
        let TwinList { page_size, page_token, capture, search, tag, owner, order_by } = list;
        let page = PageRequest { size: page_size, token: page_token };
        Self { page, search, tag, capture, owner, order_by, ..Self::default() }
    }
}

fn read_state(word: &str) -> Result<State> {
    let states = [State::Queued, State::Running, State::Succeeded, State::Failed, State::Cancelled];
    let found = states.into_iter().find(|state| state.as_str().to_uppercase() == word);
    let fault = "is none of QUEUED, RUNNING, SUCCEEDED, FAILED, CANCELLED";
    found.ok_or_else(|| Error::invalid("state", fault))
}

/// Losses of a fit.
#[derive(Serialize, ToSchema)]
pub(super) struct Losses {
    curves: Vec<LossCurve>,
}

/// Losses of one model over the iterations of a stage. Of a long stage every second iteration is
/// kept, every fourth and so on, and the last.
#[derive(Serialize, ToSchema)]
struct LossCurve {
    /// `search` or `refine`.
    stage: &'static str,
    /// `bending` or `axial`, of several starts followed by which: `bending 2/3`.
    variant: String,
    /// Ascending, from 1.
    iterations: Vec<u32>,
    /// One for each iteration; null where it was not finite.
    losses: Vec<Option<f64>>,
    /// The lowest up to each iteration.
    best_losses: Vec<Option<f64>>,
}

impl From<Vec<bendtwin_core::ModelLoss>> for Losses {
    fn from(losses: Vec<bendtwin_core::ModelLoss>) -> Self {
        let mut curves: Vec<LossCurve> = Vec::new();
        for loss in losses {
            let stage = loss.stage.as_str();
            let is_next = |c: &LossCurve| c.stage == stage && c.variant == loss.variant;
            if !curves.last().is_some_and(is_next) {
                let (iterations, losses, best_losses) = (Vec::new(), Vec::new(), Vec::new());
                let variant = loss.variant;
                curves.push(LossCurve { stage, variant, iterations, losses, best_losses });
            }
            if let Some(curve) = curves.last_mut() {
                curve.iterations.push(loss.iteration);
                curve.losses.push(loss.loss);
                curve.best_losses.push(loss.best_loss);
            }
        }
        Self { curves }
    }
}
