import {
  BufferAttribute,
  BufferGeometry,
  Group,
  LineBasicMaterial,
  LineSegments,
  Quaternion,
  Vector3,
} from 'three';
import type { Plane } from '../shape';
import type { Layer } from '../stage';

/** Side of a square [m], and squares from the middle to the edge. */
export const SQUARE_M = 0.1;
const SQUARES = 14;
/** Interval of the stronger lines [lines]. */
const STRONG = 5;
/** Squares that a piece of a line is long, at the ends of which its opacity is set. */
const PIECE = 2;

/**
 * The ground: a grid of squares of 10 cm, which fades away from the middle. It has no sheet: to blend one over most of
 * the picture takes a fifth of the time of a picture without a GPU.
 */
export class GroundLayer implements Layer {
  readonly object = new Group();
  readonly #grid = new LineSegments(
    gridOf(), new LineBasicMaterial({ vertexColors: true, transparent: true, depthWrite: false }),
  );
  readonly #bar = new LineSegments(barOf(), new LineBasicMaterial({ color: 0x7a8794 }));

  constructor() {
    this.#grid.renderOrder = -2;
    this.object.add(this.#grid, this.#bar);
  }

  /** Lies where a plane is, under a point; the bar of one square lies `reach` [m] before it. Hidden without a plane. */
  place(plane: Plane | null, under: Vector3, reach: number): void {
    this.object.visible = plane !== null;
    if (plane === null) return;
    const normal = new Vector3(...plane.normal).normalize();
    this.object.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
    // Whole squares, so that its lines stay where they are when it follows something.
    const step = STRONG * SQUARE_M;
    const middle = under.clone().divideScalar(step).round().multiplyScalar(step);
    this.object.position.copy(middle).addScaledVector(normal, plane.offset_m - middle.dot(normal));
    this.object.updateMatrixWorld();
    const at = this.object.worldToLocal(under.clone());
    this.#bar.position.set(Math.round(at.x / SQUARE_M - 0.5) * SQUARE_M, at.y - reach, 0.0005);
  }

  /** Where the scale is written: the middle of the bar. */
  get scaleAt(): Vector3 {
    return this.object.localToWorld(this.#bar.position.clone().add(new Vector3(SQUARE_M / 2, 0, 0)));
  }

  dispose(): void {
    for (const part of [this.#grid, this.#bar]) {
      part.geometry.dispose();
      part.material.dispose();
    }
  }
}

/** Lines of the grid in pieces, so that they fade, shape [L, 2]. */
function gridOf(): BufferGeometry {
  const [places, colours]: [number[], number[]] = [[], []];
  const add = (x: number, y: number, isStrong: boolean): void => {
    places.push(x * SQUARE_M, y * SQUARE_M, 0);
    const share = Math.max(1 - Math.hypot(x, y) / SQUARES, 0);
    colours.push(0.22, 0.25, 0.29, (isStrong ? 0.75 : 0.4) * Math.sqrt(share));
  };
  for (let line = -SQUARES; line <= SQUARES; line += 1) {
    for (let piece = -SQUARES; piece < SQUARES; piece += PIECE) {
      if (Math.hypot(line, piece + PIECE / 2) > SQUARES) continue;
      const isStrong = line % STRONG === 0;
      add(line, piece, isStrong);
      add(line, piece + PIECE, isStrong);
      add(piece, line, isStrong);
      add(piece + PIECE, line, isStrong);
    }
  }
  return new BufferGeometry()
    .setAttribute('position', new BufferAttribute(new Float32Array(places), 3))
    .setAttribute('color', new BufferAttribute(new Float32Array(colours), 4));
}

/** A bar as long as a square, with ticks at its ends. */
function barOf(): BufferGeometry {
  const tick = 0.08 * SQUARE_M;
  const ends = [[0, 0], [SQUARE_M, 0], [0, -tick], [0, tick], [SQUARE_M, -tick], [SQUARE_M, tick]];
  const places = ends.flatMap(([x, y]) => [x!, y!, 0]);
  return new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(places), 3));
}
