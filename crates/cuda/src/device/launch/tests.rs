use super::*;

#[test]
fn errors_name_the_whole_shape_of_a_launch() {
    let grid = [132, 1, 1];
    let launch = LaunchShape { grid, threads: 512, shared_bytes: 163_840, cluster: Some(16) };
    let expected = "grid 132 x 1 x 1, block 512, 163840 bytes of shared memory, cluster 16";
    assert_eq!(launch.to_string(), expected);
    let launch = LaunchShape { grid: [3, 40, 2], threads: 256, shared_bytes: 0, cluster: None };
    assert_eq!(launch.to_string(), "grid 3 x 40 x 2, block 256, 0 bytes of shared memory");
}
