import { Vector3 } from 'three';
import type { Stage } from '../view3d/stage';
import type { LiveTwin } from './live_twin';

/** Way that arrows pull, as a share of the distance of the camera. */
const REACH = 0.3;

/** What keys do beside moving the camera. */
export interface KeyActions {
  reset(): void;
  pause(): void;
  letGo(): void;
  /** Something was grabbed or released. */
  moved(): void;
}

/**
 * Keys of an embedded twin: Space, R and L are the buttons, and with Shift held arrows pull the object at the node
 * nearest to where the camera looks.
 */
export function listenToKeys(stage: Stage, twin: LiveTwin, actions: KeyActions): void {
  const held = new Set<string>();
  let from: Vector3 | null = null;
  const draw = (): void => {
    if (held.size === 0) {
      if (from !== null) twin.release();
      from = null;
      return actions.moved();
    }
    if (from === null) {
      const node = middleNode(stage, twin);
      from = new Vector3().fromArray(twin.nodes, 3 * node);
      twin.grab(node);
    }
    const way = new Vector3();
    const [right, up] = [0, 1].map((column) => new Vector3().setFromMatrixColumn(stage.camera.matrix, column));
    if (held.has('ArrowLeft')) way.sub(right!);
    if (held.has('ArrowRight')) way.add(right!);
    if (held.has('ArrowUp')) way.add(up!);
    if (held.has('ArrowDown')) way.sub(up!);
    const reach = REACH * stage.camera.position.distanceTo(stage.controls.target);
    twin.drag(...way.multiplyScalar(reach).add(from).toArray());
    actions.moved();
  };
  const { canvas } = stage;
  canvas.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const isArrow = event.key.startsWith('Arrow');
    if (isArrow && !event.shiftKey) return;
    if (isArrow) held.add(event.key);
    else if (event.repeat) return;
    else if (event.key === ' ') actions.pause();
    else if (event.key === 'r' || event.key === 'R') actions.reset();
    else if (event.key === 'l' || event.key === 'L') actions.letGo();
    else return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (isArrow) draw();
  }, { capture: true });
  const end = (event: Event): void => {
    const before = held.size;
    if (event instanceof KeyboardEvent && event.key !== 'Shift') held.delete(event.key);
    else held.clear();
    if (held.size !== before) draw();
  };
  canvas.addEventListener('keyup', end);
  canvas.addEventListener('blur', end);
}

/** The node nearest to what the camera looks at. */
function middleNode({ controls }: Stage, { nodes }: LiveTwin): number {
  const place = new Vector3();
  let [best, least] = [0, Infinity];
  for (let node = 0; 3 * node < nodes.length; node += 1) {
    const distance = place.fromArray(nodes, 3 * node).distanceTo(controls.target);
    if (distance < least) [best, least] = [node, distance];
  }
  return best;
}
