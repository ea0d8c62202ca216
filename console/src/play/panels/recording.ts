import { h } from '../../ui/dom';
import { download, fileName } from '../share/download';
import type { Panel, Playing } from '../playing';
import { csvOf, type RecordingDocument } from '../share/recording';
import { button, panel, press, toggle } from './parts';

/** Recordings: begin and end one, show it again, save it. */
export function recordingPanel({ context, ready, send, say, name }: Playing): Panel {
  const record = toggle('Record', (on) => send({ type: 'record', on }));
  const replay = toggle('Replay', (on) => send({ type: on ? 'replay' : 'stop' }));
  const state = h('p', { role: 'status' });
  const save = (extension: 'json' | 'csv') => async (): Promise<void> => {
    const path = ready()?.recording;
    if (path === undefined) return say('There is no play now.');
    try {
      const text = await (await context.api.fetch(path, { signal: context.signal })).text();
      const content = extension === 'json' ? text : csvOf(JSON.parse(text) as RecordingDocument);
      const type = extension === 'json' ? 'application/json' : 'text/csv';
      download(new Blob([content], { type }), fileName(`${name} recording`, extension));
    } catch (error) {
      say(`The recording was not saved: ${error instanceof Error ? error.message : String(error)}`);
    }
  };
  const saves = [
    button('Save as JSON', () => void save('json')()),
    button('Save as CSV', () => void save('csv')()),
  ];
  const enable = (recorded: boolean): void => {
    for (const element of [replay, ...saves]) element.disabled = !recorded;
  };
  enable(false);
  return {
    element: panel('Recording', false,
      h('div', { class: 'row' }, record, replay, ...saves), state,
      h('p', { class: 'hint' }, 'JSON has rollouts that reproduce the motion, CSV the poses of the grippers.')),
    update: (facts) => {
      press(record, facts.recording !== null);
      press(replay, facts.replay !== null);
      enable(facts.recorded !== null);
      state.textContent = facts.replay !== null ? `Replaying frame ${facts.replay[0]} of ${facts.replay[1]}.`
        : facts.recording !== null ? `Recording: ${facts.recording} frames.`
          : facts.recorded !== null ? `Recorded: ${facts.recorded} frames.` : 'Nothing is recorded yet.';
    },
  };
}
