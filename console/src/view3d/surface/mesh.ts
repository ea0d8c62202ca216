import { placeSkin, pointCount } from '../skin';
import type { Surface } from './surface';
import { addTubeFaces, nodeOf, placeTube, vertexCount } from './tubes';

/** A surface in one moment: all vertices, those of the tubes behind the carried ones, V of them, and their normals. */
export class SurfaceMesh {
  /** Corners of all triangles, shape [F, 3]. */
  readonly faces: Uint32Array;
  /** [m], shape [V, 3] */
  readonly positions: Float32Array;
  /** Normals to the outside, of any length, shape [V, 3]. */
  readonly normals: Float32Array;

  constructor(readonly surface: Surface) {
    const { carriers, triangles, tubes } = surface;
    const faces: number[] = [];
    let count = pointCount(carriers);
    for (const tube of tubes) {
      addTubeFaces(tube, count, faces);
      count += vertexCount(tube);
    }
    this.faces = new Uint32Array(triangles.length + faces.length);
    this.faces.set(triangles);
    this.faces.set(faces, triangles.length);
    this.positions = new Float32Array(3 * count);
    this.normals = new Float32Array(3 * count);
  }

  /** Moves the vertices with nodes [m], shape [N, 3]. */
  place(nodes: Float32Array): void {
    const { carriers, tubes } = this.surface;
    placeSkin(carriers, nodes, this.positions);
    let first = pointCount(carriers);
    for (const tube of tubes) {
      placeTube(tube, nodes, this.positions, first);
      first += vertexCount(tube);
    }
    sumNormals(this.faces, this.positions, this.normals);
  }

  /** Values of vertices, shape [V], from those of nodes, shape [N]. */
  spread(values: Float32Array, out: Float32Array): void {
    const { starts, nodes, weights } = this.surface.carriers;
    const carried = starts.length - 1;
    for (let v = 0; v < carried; v += 1) {
      let sum = 0;
      for (let k = starts[v]!, end = starts[v + 1]!; k < end; k += 1) sum += weights[k]! * values[nodes[k]!]!;
      out[v] = sum;
    }
    let at = carried;
    for (const tube of this.surface.tubes) {
      const count = vertexCount(tube);
      for (let v = 0; v < count; v += 1) out[at + v] = values[nodeOf(tube, v)]!;
      at += count;
    }
  }
}

/** Sums of the normals of the faces around each vertex, the larger the face the longer, shape [V, 3]. */
function sumNormals(faces: Uint32Array, at: Float32Array, out: Float32Array): void {
  out.fill(0);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f]!;
    const b = 3 * faces[f + 1]!;
    const c = 3 * faces[f + 2]!;
    const ux = at[b]! - at[a]!;
    const uy = at[b + 1]! - at[a + 1]!;
    const uz = at[b + 2]! - at[a + 2]!;
    const vx = at[c]! - at[a]!;
    const vy = at[c + 1]! - at[a + 1]!;
    const vz = at[c + 2]! - at[a + 2]!;
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    out[a]! += x;
    out[a + 1]! += y;
    out[a + 2]! += z;
    out[b]! += x;
    out[b + 1]! += y;
    out[b + 2]! += z;
    out[c]! += x;
    out[c + 1]! += y;
    out[c + 2]! += z;
  }
}
