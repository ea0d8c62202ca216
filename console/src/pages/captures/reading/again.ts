import type { Capture } from '@bendtwin/client';
import type { PageContext } from '../../../page';
import { h } from '../../../ui/dom';
import { field } from '../../../ui/form';
import { problemBox } from '../../../ui/problem';
import { changed, keptSettings } from '../../parts/ingest';
import { readSettings } from '../../parts/settings';

/** A form that has a capture read again, with other settings. */
export function ingestAgain(
  context: PageContext,
  path: string,
  latest: () => Capture,
  onStart: (capture: Capture) => void,
): HTMLElement {
  const settings = h('textarea', { rows: '3', spellcheck: 'false', class: 'code' });
  const fault = h('div');
  const button = h('button', { type: 'submit' }, 'Read again');
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    const read = readSettings(settings.value);
    if (read.faults.length > 0) {
      return fault.replaceChildren(problemBox(new Error(read.faults.map(({ text }) => text).join(' '))));
    }
    button.disabled = true;
    fault.replaceChildren();
    try {
      const body = { settings: changed(keptSettings(latest()), read.value) };
      onStart(await context.api.send<Capture>('POST', `${path}/ingest`, body, context.signal));
      details.open = false;
    } catch (error) {
      if (!context.signal.aborted) fault.replaceChildren(problemBox(error));
    }
    button.disabled = false;
  };
  const hint = ['One a line, as ', h('code', {}, 'spacing_m = 0.004'), '. Others keep their defaults; marks and calibration stay.'];
  const details = h(
    'details',
    { class: 'card' },
    h('summary', {}, 'Read again with other settings'),
    h(
      'form',
      { onsubmit: (event) => void submit(event) },
      field('Settings of the ingest', settings, hint),
      fault,
      h('div', { class: 'buttons' }, button),
    ),
  );
  return details;
}
