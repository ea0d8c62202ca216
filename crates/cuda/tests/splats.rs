//! The rasteriser on a device: its conformance suite, and the CPU rasteriser, which defines what is
//! correct, on fresh random Gaussians: every run draws its own seed and prints it; `BENDTWIN_SEED`
//! repeats one.

use std::sync::OnceLock;

use bendtwin_cuda::{CudaRasteriser, Options};
use bendtwin_splat::{Cpu, Error, GaussiansBar, Image, Rasteriser};
use bendtwin_splat_kit::{SceneOptions, random_bar, random_camera, random_gaussians};

fn rasteriser() -> CudaRasteriser {
    CudaRasteriser::new(&Options::default()).expect("a CUDA device")
}

bendtwin_splat_kit::conformance_tests!(rasteriser(), #[ignore = "needs a CUDA device"]);

fn seed() -> u64 {
    static SEED: OnceLock<u64> = OnceLock::new();
    *SEED.get_or_init(|| {
        let given = std::env::var("BENDTWIN_SEED").ok().and_then(|s| s.parse().ok());
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let seed = given.unwrap_or_else(|| now.map_or(0, |t| t.as_secs()));
        println!("BENDTWIN_SEED={seed}");
        seed
    })
}

/// Largest and mean absolute difference of two images' colours and coverage.
fn image_differences(a: &Image, b: &Image) -> (f64, f64) {
    let numbers =
        |i: &Image| -> Vec<f32> { i.color.iter().flatten().chain(&i.alpha).copied().collect() };
    let (a, b) = (numbers(a), numbers(b));
    assert_eq!(a.len(), b.len());
    let off: Vec<f64> = a.iter().zip(&b).map(|(a, b)| f64::from((a - b).abs())).collect();
    let most = off.iter().copied().fold(0.0, f64::max);
    (most, off.iter().sum::<f64>() / off.len().max(1) as f64)
}

/// Relative differences of the arrays of gradients.
fn bar_differences(got: &GaussiansBar, expected: &GaussiansBar) -> Vec<(&'static str, f64)> {
    let relative = |got: &[f32], expected: &[f32]| {
        let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|x| x * x).sum::<f64>().sqrt();
        let off = norm(&mut got.iter().zip(expected).map(|(a, b)| f64::from(a - b)));
        off / norm(&mut expected.iter().map(|x| f64::from(*x))).max(1e-9)
    };
    vec![
        ("means", relative(got.means_m.as_flattened(), expected.means_m.as_flattened())),
        ("scales", relative(got.scales_m.as_flattened(), expected.scales_m.as_flattened())),
        ("rotations", relative(got.rotations.as_flattened(), expected.rotations.as_flattened())),
        ("opacities", relative(&got.opacities, &expected.opacities)),
        ("colours", relative(got.colors.as_flattened(), expected.colors.as_flattened())),
        ("screen", relative(&got.screen, &expected.screen)),
    ]
}

#[test]
#[ignore = "needs a CUDA device"]
fn the_device_agrees_with_the_cpu() {
    let (mut cpu, mut device) = (Cpu::default(), rasteriser());
    let cases = [
        (1, [1, 1], [0.002, 0.03]),
        (30, [33, 17], [0.002, 0.03]),
        (500, [200, 120], [0.001, 0.02]),
        (3_000, [424, 240], [0.0005, 0.01]),
        (20_000, [424, 240], [0.0005, 0.004]),
        (50_000, [848, 480], [0.0002, 0.003]),
        (700, [1_000, 900], [0.01, 0.2]),
    ];
    for (k, (count, [width, height], scales_m)) in cases.into_iter().enumerate() {
        let seed = seed() + k as u64;
        let options = SceneOptions { count, scales_m, ..SceneOptions::default() };
        let gaussians = random_gaussians(seed, &options);
        let camera = random_camera(seed, width, height);
        let bar = random_bar(seed, &camera);
        let what = format!("{count} Gaussians at {width} x {height}, seed {seed}");
        let expected = cpu.render(&gaussians, &camera).unwrap();
        let got = device.render(&gaussians, &camera).unwrap();
        let (most, mean) = image_differences(&got, &expected);
        println!("{what}: images differ by {mean:.1e} in the mean, {most:.1e} at most");
        // A decision that falls otherwise changes a pixel by 1/255 of a colour, or by what closes
        // it; rounding by 1e-5.
        assert!(mean < 2e-5 && most < 0.02, "{what}: {mean} in the mean, {most} at most");
        let expected = cpu.gradients(&gaussians, &camera, &bar).unwrap();
        let got = device.gradients(&gaussians, &camera, &bar).unwrap();
        let off = bar_differences(&got, &expected);
        println!("{what}: {off:?}");
        // The same decisions, in a few pixels of thousands.
        assert!(off.iter().all(|(_, x)| *x < 2e-2), "{what}: {off:?}");
    }
}

/// Smaller and larger sets and images in turn use the same memory.
#[test]
#[ignore = "needs a CUDA device"]
fn memory_is_used_again() {
    let (mut cpu, mut device) = (Cpu::default(), rasteriser());
    for (k, (count, width)) in [(3_000, 300), (10, 20), (0, 50), (5_000, 40), (700, 500)]
        .into_iter()
        .cycle()
        .take(15)
        .enumerate()
    {
        let seed = seed() + 100 + k as u64;
        let gaussians = random_gaussians(seed, &SceneOptions { count, ..SceneOptions::default() });
        let camera = random_camera(seed, width, width / 2);
        let bar = random_bar(seed, &camera);
        let expected = cpu.render(&gaussians, &camera).unwrap();
        let got = device.gradients(&gaussians, &camera, &bar).unwrap();
        assert_eq!(got.len(), count);
        let (most, _) = image_differences(&device.render(&gaussians, &camera).unwrap(), &expected);
        assert!(most < 0.02, "{count} Gaussians, {width} columns: {most}");
    }
}

#[test]
#[ignore = "needs a CUDA device"]
fn memory_has_a_limit() {
    let options = Options { memory_limit: Some(8 << 20), ..Options::default() };
    let mut device = CudaRasteriser::new(&options).expect("a CUDA device");
    let small = random_gaussians(1, &SceneOptions::default());
    let camera = random_camera(1, 60, 40);
    device.render(&small, &camera).unwrap();
    let large = random_gaussians(1, &SceneOptions { count: 60_000, ..SceneOptions::default() });
    let error = device.render(&large, &camera).unwrap_err();
    assert!(matches!(error, Error::OutOfMemory { .. }), "{error}");
    assert!(device.render(&small, &camera).is_ok(), "it works after a refusal");
}
