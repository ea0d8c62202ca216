import type { Collider } from '@bendtwin/client';
import { BoxGeometry, CapsuleGeometry, Group, Mesh, MeshLambertMaterial, SphereGeometry, Vector3 } from 'three';
import type { BufferGeometry } from 'three';
import type { Layer } from '../stage';

/** Obstacles: spheres, capsules and boxes. Convex meshes are described in words only. */
export class CollidersLayer implements Layer {
  readonly object = new Group();
  readonly #plain = new MeshLambertMaterial({ color: 0x2f9e8f, transparent: true, opacity: 0.8 });
  readonly #selected = new MeshLambertMaterial({ color: 0x1c7ed6, transparent: true, opacity: 0.85 });
  #shape = '';

  /** The meshes, in the order of the colliders, for finding what is pointed at. */
  get meshes(): readonly Mesh[] {
    return this.object.children.flatMap((child) => child.children) as Mesh[];
  }

  /** Shows obstacles; their memory is reallocated only if they have other shapes. */
  set(colliders: readonly Collider[]): void {
    const shape = JSON.stringify(colliders.map(({ sphere, capsule, cuboid }) => [sphere, capsule, cuboid]));
    if (shape === this.#shape) return;
    this.#shape = shape;
    this.#clear();
    for (const collider of colliders) {
      const body = new Group();
      const geometry = geometryOf(collider);
      if (geometry !== null) body.add(new Mesh(geometry, this.#plain));
      this.object.add(body);
    }
  }

  /** Places them: positions and quaternions, shape [C, 7]. */
  place(poses: ArrayLike<number>, selected: number | null): void {
    this.object.children.forEach((body, c) => {
      if (7 * c + 6 >= poses.length) return;
      const at = (i: number): number => poses[7 * c + i]!;
      body.position.set(at(0), at(1), at(2));
      body.quaternion.set(at(3), at(4), at(5), at(6));
      for (const mesh of body.children as Mesh[]) mesh.material = c === selected ? this.#selected : this.#plain;
    });
  }

  dispose(): void {
    this.#clear();
    this.#plain.dispose();
    this.#selected.dispose();
  }

  #clear(): void {
    for (const mesh of this.meshes) mesh.geometry.dispose();
    this.object.clear();
  }
}

function geometryOf({ sphere, capsule, cuboid }: Collider): BufferGeometry | null {
  if (sphere !== undefined) return new SphereGeometry(sphere.radius_m, 32, 20).translate(...vector(sphere.center));
  if (cuboid !== undefined) {
    const [low, high] = [new Vector3(...vector(cuboid.low)), new Vector3(...vector(cuboid.high))];
    const size = high.clone().sub(low);
    return new BoxGeometry(size.x, size.y, size.z).translate(...low.add(high).divideScalar(2).toArray());
  }
  if (capsule === undefined) return null;
  const [from, to] = [new Vector3(...vector(capsule.from)), new Vector3(...vector(capsule.to))];
  const axis = to.clone().sub(from);
  const geometry = new CapsuleGeometry(capsule.radius_m, axis.length(), 8, 20);
  const turn = new Group();
  turn.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), axis.normalize());
  return geometry.applyQuaternion(turn.quaternion).translate(...from.add(to).divideScalar(2).toArray());
}

function vector(values: readonly number[] | undefined): [number, number, number] {
  const [x = 0, y = 0, z = 0] = values ?? [];
  return [x, y, z];
}
