import type { Collider } from '@bendtwin/client';
import { Vector3 } from 'three';
import { h } from '../../ui/dom';
import type { Panel, Playing } from '../playing';
import { button, panel } from './parts';

/** Directions that buttons move an obstacle in. */
const WAYS: readonly (readonly [string, readonly [number, number, number]])[] = [
  ['−x', [-1, 0, 0]],
  ['+x', [1, 0, 0]],
  ['−y', [0, -1, 0]],
  ['+y', [0, 1, 0]],
  ['−z', [0, 0, -1]],
  ['+z', [0, 0, 1]],
];

/** Obstacles: spheres and boxes that are put in, dragged and taken out. */
export function obstaclesPanel({ model, scene, driver, ready, sendWorld, say }: Playing): Panel {
  const list = h('div');
  let shown = '';
  const add = (kind: 'sphere' | 'box'): void => {
    if (model.colliders.length >= (ready()?.most_colliders ?? 8)) return say('There is no room for more obstacles.');
    const place = inFrontOf(scene.motion.shown.positions, scene.size);
    // Beside those that are there already.
    place.x += 0.25 * scene.size * model.colliders.length;
    model.add(newCollider(kind, scene.size, place));
    scene.put(model.colliders);
    sendWorld();
    refresh();
  };
  const shift = (index: number, way: readonly [number, number, number]): void => {
    const at = new Vector3().fromArray(model.colliders[index]?.pose ?? [0, 0, 0]);
    at.addScaledVector(new Vector3(...way), scene.size / 25);
    model.moveTo(index, at.toArray());
    driver.moveCollider(index, at);
  };
  const refresh = (): void => {
    const now = model.colliders.map((collider) => nameOf(collider)).join();
    if (now === shown) return;
    shown = now;
    list.replaceChildren(...model.colliders.map((collider, c) => row(`${nameOf(collider)} ${c + 1}`, c)));
  };
  const row = (name: string, c: number): HTMLElement => {
    const out = button('Take out', () => {
      model.remove(c);
      scene.put(model.colliders);
      sendWorld();
      refresh();
    }, { class: 'small', 'aria-label': `Take out ${name}` });
    const ways = WAYS.map(([text, way]) =>
      button(text, () => shift(c, way), { class: 'small', 'aria-label': `Move ${name} along ${text}` }));
    return h('div', { class: 'obstacle' }, h('span', {}, name), out, h('div', { class: 'ways' }, ...ways));
  };
  return {
    element: panel('Obstacles', false,
      h('div', { class: 'row' },
        button('Put a ball in', () => add('sphere')),
        button('Put a box in', () => add('box'))),
      h('p', { class: 'hint' }, 'Drag it with the mouse, or move it with the buttons.'), list),
    refresh,
  };
}

function nameOf({ sphere, cuboid }: Collider): string {
  return sphere !== undefined ? 'Ball' : cuboid !== undefined ? 'Box' : 'Obstacle';
}

function newCollider(kind: 'sphere' | 'box', size: number, place: Vector3): Collider {
  const half = 0.09 * size;
  const shape = kind === 'sphere'
    ? { sphere: { radius_m: half } }
    : { cuboid: { low: [-half, -half, -half], high: [half, half, half] } };
  return { ...shape, friction: 0.5, margin_m: 0.01 * size, pose: [...place.toArray(), 0, 0, 0, 1] };
}

/** A place in front of the object, at the height of its middle: nothing is inside an obstacle there. */
function inFrontOf(positions: Float32Array, size: number): Vector3 {
  const [middle, low] = [new Vector3(), new Vector3().setScalar(Infinity)];
  const count = Math.max(positions.length / 3, 1);
  for (let i = 0; i < positions.length; i += 3) {
    const point = new Vector3().fromArray(positions, i);
    middle.addScaledVector(point, 1 / count);
    low.min(point);
  }
  return new Vector3(middle.x, low.y - 0.2 * size, middle.z);
}
