import { GridHelper, Group, Mesh, MeshBasicMaterial, PlaneGeometry, Quaternion, Vector3 } from 'three';
import type { Plane } from '../shape';
import type { Layer } from '../stage';

const SIDE_M = 4;

/** The ground: a grid of squares of 10 cm, and a sheet that hides nothing. */
export class GroundLayer implements Layer {
  readonly object = new Group();
  readonly #grid = new GridHelper(SIDE_M, SIDE_M * 10, 0x6f7a86, 0x9aa4ae);
  readonly #sheet = new Mesh(
    new PlaneGeometry(SIDE_M, SIDE_M),
    new MeshBasicMaterial({ color: 0x8b97a3, transparent: true, opacity: 0.12, depthWrite: false }),
  );

  constructor() {
    this.#grid.rotation.x = Math.PI / 2;
    this.#grid.material.transparent = true;
    this.#grid.material.opacity = 0.45;
    this.object.add(this.#grid, this.#sheet);
  }

  /** Lies where a plane is, under a point; hidden without one. */
  place(plane: Plane | null, under: Vector3): void {
    this.object.visible = plane !== null;
    if (plane === null) return;
    const normal = new Vector3(...plane.normal).normalize();
    this.object.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), normal));
    // Whole squares, so that its lines stay where they are when it follows something.
    const middle = under.clone().divideScalar(0.5).round().multiplyScalar(0.5);
    this.object.position.copy(middle).addScaledVector(normal, plane.offset_m - middle.dot(normal));
  }

  dispose(): void {
    this.#grid.dispose();
    this.#sheet.geometry.dispose();
    this.#sheet.material.dispose();
  }
}
