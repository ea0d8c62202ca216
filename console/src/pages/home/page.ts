import type { OpenPage } from '../../page';
import { h } from '../../ui/dom';
import { keepingFocus } from '../../ui/focus';
import { refresh } from '../../ui/refresh';
import { ownUsage } from '../parts/usage';
import { ask } from './numbers';
import type { Numbers } from './numbers';
import { newest } from './newest';
import { nextSteps } from './next_steps';
import { tiles } from './tiles';
import './home.css';

const EVERY_MS = 4000;

/** The first page: what is here, in numbers, what is newest, and what to do next. */
export const open: OpenPage = async (context) => {
  context.setTitle('BendTwin');
  const element = h('div');
  let shown = '';
  const draw = (numbers: Numbers): void => {
    // Unchanged content is not redrawn, for those who select or read it.
    const text = JSON.stringify(numbers);
    if (text === shown) return;
    shown = text;
    const parts = [nextSteps(numbers), tiles(numbers), newest(context, numbers), ownUsage(numbers.usage)];
    keepingFocus(element, () => element.replaceChildren(...parts));
  };
  await refresh(context, EVERY_MS, async () => draw(await ask(context)));
  return { element };
};
