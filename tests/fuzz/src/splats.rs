//! Files of Gaussians.

use bendtwin_exchange::splats::{MOST_GAUSSIANS, read, write_ply};

/// Largest scale and colour at which rounding cannot leave the range that is read.
const MOST: f32 = 1e5;

/// A `.ply` of Gaussian splatting, or a `.spz`.
pub fn splats(data: &[u8]) {
    let Ok(loaded) = read(data) else { return };
    let gaussians = loaded.gaussians;
    assert!(!gaussians.is_empty() && gaussians.len() <= MOST_GAUSSIANS);
    assert_eq!(gaussians.check(), Ok(()));
    let numbers = gaussians.scales_m.iter().chain(&gaussians.colors).flatten();
    if !numbers.into_iter().all(|x| x.abs() < MOST) {
        return;
    }
    let mut written = Vec::new();
    write_ply(&gaussians, &mut written).expect("memory can be written to");
    let again = read(&written).expect("what was written is read").gaussians;
    assert_eq!(again.means_m, gaussians.means_m);
    assert_eq!(again.len(), gaussians.opacities.len());
}
