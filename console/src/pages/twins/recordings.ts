import { PlaybackFile } from '../../playback/file/file';
import type { PageContext } from '../../page';
import { h } from '../../ui/dom';
import { capitalised, counted, duration, millimetres, percent } from '../../ui/format';
import { table } from '../../ui/table';
import { measuresOf, type Recording } from './quality';

/** Errors in each of several recordings. */
export function recordingsView(recordings: readonly Recording[]): HTMLElement | null {
  if (recordings.length === 0) return null;
  const measures = measuresOf(recordings.map((own) => ({ ...own, text: own.name })));
  return h(
    'div',
    {},
    h('h3', {}, 'By recording'),
    table<Recording>({
      caption: 'Errors in each recording, and the first frame of those that the twin was registered to',
      rows: recordings,
      columns: [
        { header: 'Recording', cell: ({ name }) => h('bdi', {}, name) },
        ...(['future', 'train'] as const).flatMap((part) =>
          measures.map(([measure, word]) => ({
            header: capitalised(word),
            group: part === 'future' ? 'Later frames' : 'Fitted frames',
            isNumeric: true,
            cell: (own: Recording) => millimetres(own[part][measure]),
          })),
        ),
        {
          header: 'Median distance',
          group: 'First frame',
          isNumeric: true,
          cell: ({ registered }) => (registered === undefined ? '–' : `${registered.median_mm.toFixed(1)} mm`),
        },
        {
          header: 'Explained',
          group: 'First frame',
          isNumeric: true,
          cell: ({ registered }) => (registered === undefined ? '–' : percent(registered.explained)),
        },
      ],
    }),
  );
}

/** A sequence of a capture: its words, its length, and the address of its playback beside a twin. */
interface Played {
  readonly text: string;
  readonly frames: number;
  readonly seconds: number;
  readonly href: string;
}

/** All sequences that a twin's capture has, each with its playback; hidden for a single one, and for captures without a playback. */
export function sequencesView({ api, signal }: PageContext, capture: string, twin: string): HTMLElement {
  const element = h('section', { hidden: true }, h('h2', {}, 'Recordings'));
  const load = async (): Promise<void> => {
    const { head } = await PlaybackFile.open(api, capture, signal);
    if (head.sequences.length < 2) return;
    const rows = head.sequences.map(({ recording_name: recording, name, frame_count, fps }, index): Played => {
      const text = recording === name || name === '' ? recording : `${recording}, ${name}`;
      const query = new URLSearchParams({ twin, sequence: String(index) });
      return { text: text || `Sequence ${index + 1}`, frames: frame_count, seconds: frame_count / fps, href: `#/captures/${capture}/playback?${query}` };
    });
    element.append(sequenceTable(rows));
    element.hidden = false;
  };
  // The page of the capture says why it has no playback.
  load().catch(() => undefined);
  return element;
}

function sequenceTable(rows: readonly Played[]): HTMLElement {
  return table<Played>({
    caption: 'Sequences that the twin was fitted to',
    hidesCaption: true,
    rows,
    columns: [
      { header: 'Recording', cell: ({ text }) => h('bdi', {}, text) },
      { header: 'Length', isNumeric: true, cell: ({ frames, seconds }) => `${counted(frames, 'frame')}, ${duration(seconds)}` },
      { header: 'Playback', cell: ({ text, href }) => h('a', { href, 'aria-label': `Play back ${text}` }, 'Beside the twin') },
    ],
  });
}
