//! Walks a scene's nodes from its roots to its leaves.

use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};

use super::{
    damaged,
    document::{Document, Node},
};
use crate::Error;

/// Calls `show` with every mesh of the default scene and its transform. A document without nodes
/// shows each mesh once.
pub(super) fn visit(
    at: &str,
    document: &Document,
    mut show: impl FnMut(usize, &Matrix4<f64>) -> Result<(), Error>,
) -> Result<(), Error> {
    if document.nodes.is_empty() {
        return (0..document.meshes.len()).try_for_each(|m| show(m, &Matrix4::identity()));
    }
    // Nodes must form trees: a node met twice could be met for ever, or exponentially often.
    let mut met = vec![false; document.nodes.len()];
    let mut left: Vec<(usize, Matrix4<f64>)> = Vec::new();
    left.extend(roots(document).into_iter().rev().map(|root| (root, Matrix4::identity())));
    while let Some((index, above)) = left.pop() {
        let node = document
            .nodes
            .get(index)
            .ok_or_else(|| damaged(at, "its scene has a node that is not there"))?;
        if std::mem::replace(&mut met[index], true) {
            return Err(damaged(at, "a node of its scene has two parents"));
        }
        let transform = above * local(node);
        if let Some(mesh) = node.mesh {
            show(mesh, &transform)?;
        }
        left.extend(node.children.iter().rev().map(|child| (*child, transform)));
    }
    Ok(())
}

fn roots(document: &Document) -> Vec<usize> {
    match document.scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.clone(),
        None => {
            let mut is_root = vec![true; document.nodes.len()];
            for child in document.nodes.iter().flat_map(|n| &n.children) {
                if let Some(root) = is_root.get_mut(*child) {
                    *root = false;
                }
            }
            (0..is_root.len()).filter(|n| is_root[*n]).collect()
        }
    }
}

fn local(node: &Node) -> Matrix4<f64> {
    if let Some(matrix) = &node.matrix {
        return Matrix4::from_column_slice(matrix.as_slice());
    }
    let shift = Vector3::from(node.translation.unwrap_or_default());
    let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]));
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Matrix4::new_translation(&shift)
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&scale)
}
