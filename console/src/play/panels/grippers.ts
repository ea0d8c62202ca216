import { h } from '../../ui/dom';
import { toggleGrasp } from '../input/keys';
import type { Panel, Playing } from '../playing';
import { button, panel } from './parts';

/** A panel of grippers, and whether what is grasped is held on to. */
export interface GrippersPanel extends Panel {
  readonly keeps: boolean;
}

/** Hands and pointers: which of them keys move, and what they hold. */
export function grippersPanel({ scene, driver }: Playing, selected: () => void): GrippersPanel {
  const list = h('div', { role: 'radiogroup', 'aria-label': 'Gripper moved by keys' });
  const keeps = h('input', { type: 'checkbox' });
  let shown = '';
  const refresh = (): void => {
    const rows = driver.usable.map((g) => ({ g, holds: driver.isHolding(g) || driver.held.has(g) }));
    const now = JSON.stringify([rows, driver.selected]);
    if (now === shown) return;
    shown = now;
    const focused = document.activeElement instanceof HTMLElement && list.contains(document.activeElement)
      ? document.activeElement.dataset['key'] : undefined;
    list.replaceChildren(...rows.map(({ g, holds }) => row(g, holds)));
    const again = [...list.querySelectorAll<HTMLElement>('[data-key]')].find((e) => e.dataset['key'] === focused);
    again?.focus();
  };
  const row = (g: number, holds: boolean): HTMLElement => {
    const name = g < driver.hands ? `Hand ${g + 1}` : `Pointer ${g - driver.hands + 1}`;
    const select = (): void => {
      driver.selected = g;
      selected();
    };
    const radio = h('input', { type: 'radio', name: 'gripper', checked: g === driver.selected, onchange: select });
    radio.dataset['key'] = `select ${g}`;
    const action = holds ? (g < driver.hands ? 'Drop' : 'Let go') : 'Grasp';
    const act = button(action, () => {
      select();
      toggleGrasp(scene, driver);
      selected();
    }, { class: 'small', 'aria-label': `${action}: ${name}` });
    act.dataset['key'] = `act ${g}`;
    return h('div', { class: 'gripper' }, h('label', {}, radio, ` ${name}${holds ? ' holds' : ''}`), act);
  };
  const element = panel('Hands and pointers', true, list,
    h('label', {}, keeps, ' Keep hold of what I grasp (or Shift)'));
  return {
    element,
    refresh,
    get keeps() {
      return keeps.checked;
    },
  };
}
