import { Vector3 } from 'three';
import { h } from '../../ui/dom';
import { millimetres } from '../../ui/format';
import type { GoalProgress } from '../protocol/messages';
import type { Panel, Playing } from '../playing';
import { button, panel, press, toggle } from './parts';

const TOLERANCE_M = 0.01;
const STATES: Readonly<Record<GoalProgress['state'], string>> = {
  planning: 'The planner is searching for a motion',
  moving: 'On the way',
  reached: 'Reached',
  not_reached: 'Not reached: this is the nearest that the planner found',
  stopped: 'Stopped',
};

/** A panel of goals, and whether dragging sets one. */
export interface GoalPanel extends Panel {
  readonly sets: boolean;
  /** A target was dragged to its place. */
  set(node: number): void;
}

/** Goals: points that the server's planner is asked to bring to places. */
export function goalPanel({ scene, send, say }: Playing): GoalPanel {
  const { goal, stage } = scene;
  const state = h('p', { role: 'status' });
  const mode = toggle('Set a goal', (on) => {
    if (on) say('Drag a point of the object to its goal.');
  });
  const fields = [
    h('input', { type: 'number', step: 1, min: 0, 'aria-label': 'Node' }),
    ...['x', 'y', 'z'].map((axis) =>
      h('input', { type: 'number', step: 0.001, 'aria-label': `${axis} of its goal in metres` })),
  ];
  const [node, ...place] = fields as [HTMLInputElement, HTMLInputElement, HTMLInputElement, HTMLInputElement];
  const show = (n: number): void => {
    node.value = String(n);
    const at = goal.targets.get(n);
    place.forEach((field, i) => (field.value = at === undefined ? '' : at.getComponent(i).toFixed(3)));
  };
  const typed = (): void => {
    const [n, x, y, z] = fields.map((field) => field.valueAsNumber) as [number, number, number, number];
    const nodes = scene.motion.shown.positions.length / 3;
    if (!(Number.isInteger(n) && n >= 0 && n < nodes)) return say(`Nodes are numbered from 0 to ${nodes - 1}.`);
    if (![x, y, z].every((value) => Math.abs(value) < 100)) return say('Give x, y and z in metres.');
    goal.targets.set(n, new Vector3(x, y, z));
    stage.invalidate();
    refresh();
  };
  const go = button('Ask the planner', () => {
    send({ type: 'goal', targets: goal.list, tolerance_m: TOLERANCE_M });
  }, { class: 'primary' });
  const stop = button('Stop', () => send({ type: 'stop' }));
  const clear = button('Clear', () => {
    goal.targets.clear();
    state.textContent = '';
    stage.invalidate();
    refresh();
  });
  const refresh = (): void => {
    go.disabled = clear.disabled = goal.targets.size === 0;
  };
  refresh();
  stop.disabled = true;
  return {
    element: panel('Goal', false,
      h('p', { class: 'hint' },
        'The planner moves the hands that hold the object so that its points reach their goals.'),
      h('div', { class: 'row' }, mode, go, stop, clear),
      state,
      h('details', {}, h('summary', {}, 'By numbers'),
        h('div', { class: 'numbers' }, ...fields, button('Set', typed)))),
    get sets() {
      return mode.getAttribute('aria-pressed') === 'true';
    },
    set: (n) => {
      press(mode, false);
      show(n);
      refresh();
      say('The goal is set: ask the planner to reach it.');
    },
    update: ({ goal: progress }) => {
      stop.disabled = progress === null || !['planning', 'moving'].includes(progress.state);
      if (progress === null) return;
      const planned = progress.planned_m === null ? '' : `, planned to ${millimetres(progress.planned_m)}`;
      state.textContent = `${STATES[progress.state]}: ${millimetres(progress.distance_m)} away${planned}, ` +
        `round ${progress.round}, ${progress.simulated} simulations.`;
    },
    refresh,
  };
}
