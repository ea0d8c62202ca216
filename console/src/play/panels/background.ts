import { h } from '../../ui/dom';
import { PLAIN, type Background, type Choice } from '../background/background';
import { panel } from './parts';

/** What is around the twin. Recordings are read as soon as the panel is opened, or an address names one. */
export function backgroundPanel(background: Background, asked: Choice | null): HTMLElement {
  const fault = h('p', { role: 'status', class: 'hint' });
  const select = h('select', { 'aria-label': 'Background' });
  const list = (choices: readonly (readonly [Choice, string])[]): void => {
    select.replaceChildren(...choices.map(([value, text]) => h('option', { value }, text)));
    select.value = background.choice;
  };
  const show = async (choice: Choice): Promise<void> => {
    fault.textContent = '';
    try {
      await background.show(choice);
    } catch (error) {
      fault.textContent = `It cannot be shown: ${error instanceof Error ? error.message : String(error)}`;
    }
    select.value = background.choice;
  };
  const load = async (): Promise<void> => {
    try {
      list(await background.choices());
    } catch {
      fault.textContent = 'There are no images of the recording.';
    }
  };
  list(PLAIN);
  select.addEventListener('change', () => void show(select.value));
  background.onLeave = () => (select.value = background.choice);
  const element = panel('Background', false, select,
    h('p', { class: 'hint' }, 'In the image of a camera you look from where the camera stood. Turning the view leaves it.'),
    fault);
  let isLoaded = false;
  const once = (): void => {
    if (!isLoaded) void load();
    isLoaded = true;
  };
  element.addEventListener('toggle', once);
  if (asked !== null && asked !== 'grid') {
    once();
    void show(asked);
  }
  return element;
}
