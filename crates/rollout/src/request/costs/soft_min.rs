//! The soft minimum over frames: `-T log mean exp(-c / T)`, which is low if a cost c is low in any
//! frame. Its derivative by the cost of a frame is `exp(-c / T) / sum exp(-c / T)`.

/// Soft minimum of values; infinite of none.
pub(super) fn value(costs: &[f64], temperature: f64) -> f64 {
    let least = least(costs);
    if !least.is_finite() {
        return f64::INFINITY;
    }
    let sum: f64 = costs.iter().map(|c| (-(c - least) / temperature).exp()).sum();
    least - temperature * (sum / costs.len() as f64).ln()
}

/// Derivatives of the soft minimum by the values.
pub(super) fn shares(costs: &[f64], temperature: f64) -> Vec<f64> {
    let least = least(costs);
    let powers: Vec<f64> = costs.iter().map(|c| (-(c - least) / temperature).exp()).collect();
    let sum: f64 = powers.iter().sum();
    powers.into_iter().map(|power| power / sum).collect()
}

fn least(costs: &[f64]) -> f64 {
    costs.iter().copied().fold(f64::INFINITY, f64::min)
}
