//! The CPU rasteriser on several threads.

use bendtwin_splat::{Cpu, Rasteriser as _};
use bendtwin_splat_kit::{SceneOptions, random_bar, random_camera, random_gaussians};

fn on_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

#[test]
fn threads_change_no_bit() {
    let options = SceneOptions { count: 2_000, ..SceneOptions::default() };
    let gaussians = random_gaussians(1, &options);
    let camera = random_camera(1, 200, 150);
    let bar = random_bar(1, &camera);
    let work = || {
        let mut cpu = Cpu::default();
        let image = cpu.render(&gaussians, &camera).unwrap();
        (image, cpu.gradients(&gaussians, &camera, &bar).unwrap())
    };
    let alone = on_threads(1, work);
    assert!(alone.0.alpha.iter().any(|a| *a > 0.5));
    for threads in [2, 5] {
        assert!(on_threads(threads, work) == alone, "{threads} threads");
    }
}
