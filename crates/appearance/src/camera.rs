//! Cameras of views as renderers take them.

use bendtwin_core::ViewCamera;
use bendtwin_splat::Camera;

/// The camera of a view in a frame, for whole images.
pub(crate) fn whole(camera: &ViewCamera, frame: u32) -> Camera {
    Camera {
        width: camera.size[0],
        height: camera.size[1],
        fx: camera.focal[0] as f32,
        fy: camera.focal[1] as f32,
        cx: camera.centre[0] as f32,
        cy: camera.centre[1] as f32,
        world_to_camera: camera.pose(frame).map(|row| row.map(|x| x as f32)),
    }
}
