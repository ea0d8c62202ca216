/** A tube along nodes, as `crates/core/src/twin/surface.rs` has it: both must give the same numbers. */
export interface Tube {
  /** Nodes, at least 2; the last is the first where the tube is closed. */
  readonly nodes: Uint32Array;
  /** [m] */
  readonly radius: number;
}

/** Vertices around a tube at each of its nodes. */
export const AROUND = 8;

type Vector = readonly [number, number, number];

/** Number of vertices: around the nodes, and one at each end. */
export function vertexCount(tube: Tube): number {
  return sectionCount(tube) * AROUND + (isClosed(tube) ? 0 : 2);
}

/** The node that vertex v of a tube is around, or at which it ends. */
export function nodeOf(tube: Tube, v: number): number {
  const sections = sectionCount(tube);
  const ring = Math.floor(v / AROUND);
  return tube.nodes[ring < sections ? ring : v % AROUND === 0 ? 0 : sections - 1]!;
}

/**
 * Places the vertices of a tube along nodes [N, 3] from vertex `first` of `out` on. The axes around a node are those
 * around the one before, turned as little as possible (double reflection, Wang et al. 2008, "Computation of rotation
 * minimizing frames").
 */
export function placeTube(tube: Tube, nodes: Float32Array, out: Float32Array, first: number): void {
  const sections = sectionCount(tube);
  const last = sections - 1;
  const closed = isClosed(tube);
  const place = (k: number): Vector => {
    const at = 3 * tube.nodes[k]!;
    return [nodes[at]!, nodes[at + 1]!, nodes[at + 2]!];
  };
  const tangent = (k: number): Vector => {
    const before = closed ? (k + last) % sections : Math.max(k - 1, 0);
    const after = closed ? (k + 1) % sections : Math.min(k + 1, last);
    return unit(sub(place(after), place(before)), [0, 0, 1]);
  };
  let at = 3 * first;
  const put = ([x, y, z]: Vector): void => {
    out[at] = x;
    out[at + 1] = y;
    out[at + 2] = z;
    at += 3;
  };
  let along = tangent(0);
  let across = anyNormal(along);
  for (let k = 0; k < sections; k += 1) {
    if (k > 0) {
      const [step, next] = [sub(place(k), place(k - 1)), tangent(k)];
      across = reflected(reflected(across, step), sub(next, reflected(along, step)));
      // Rounding, and steps of no length, must not add up.
      across = unit(sub(across, scaled(next, dot(across, next))), anyNormal(next));
      along = next;
    }
    const [centre, other] = [place(k), cross(along, across)];
    for (let spoke = 0; spoke < AROUND; spoke += 1) {
      const angle = (2 * Math.PI * spoke) / AROUND;
      const [c, s] = [tube.radius * Math.cos(angle), tube.radius * Math.sin(angle)];
      put([
        centre[0] + c * across[0] + s * other[0],
        centre[1] + c * across[1] + s * other[1],
        centre[2] + c * across[2] + s * other[2],
      ]);
    }
  }
  if (closed) return;
  put(place(0));
  put(place(last));
}

/** Appends the triangles of a tube whose first vertex has the number `first`. */
export function addTubeFaces(tube: Tube, first: number, faces: number[]): void {
  const sections = sectionCount(tube);
  const closed = isClosed(tube);
  const vertex = (section: number, spoke: number): number => first + (section % sections) * AROUND + (spoke % AROUND);
  for (let section = 0; section < (closed ? sections : sections - 1); section += 1) {
    for (let spoke = 0; spoke < AROUND; spoke += 1) {
      const [a, b] = [vertex(section, spoke), vertex(section, spoke + 1)];
      const [c, d] = [vertex(section + 1, spoke), vertex(section + 1, spoke + 1)];
      faces.push(a, b, d, a, d, c);
    }
  }
  if (closed) return;
  const ends = first + sections * AROUND;
  for (let spoke = 0; spoke < AROUND; spoke += 1) {
    faces.push(ends, vertex(0, spoke + 1), vertex(0, spoke));
    faces.push(ends + 1, vertex(sections - 1, spoke), vertex(sections - 1, spoke + 1));
  }
}

function isClosed({ nodes }: Tube): boolean {
  return nodes.length > 3 && nodes[0] === nodes[nodes.length - 1];
}

/** Number of nodes with vertices around them: of a closed tube the last is the first. */
function sectionCount(tube: Tube): number {
  return tube.nodes.length - (isClosed(tube) ? 1 : 0);
}

/** A vector reflected at the plane through the origin that is perpendicular to `at`. */
function reflected(v: Vector, at: Vector): Vector {
  const square = dot(at, at);
  return square > 0 ? sub(v, scaled(at, (2 * dot(at, v)) / square)) : v;
}

/** A unit vector perpendicular to another. */
function anyNormal(along: Vector): Vector {
  const axis: Vector = Math.abs(along[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  return unit(sub(axis, scaled(along, dot(along, axis))), [0, 1, 0]);
}

function unit(v: Vector, otherwise: Vector): Vector {
  const length = Math.sqrt(dot(v, v));
  return length > 0 && Number.isFinite(length) ? scaled(v, 1 / length) : otherwise;
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function sub(a: Vector, b: Vector): Vector {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

function scaled(a: Vector, by: number): Vector {
  return [a[0] * by, a[1] * by, a[2] * by];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
