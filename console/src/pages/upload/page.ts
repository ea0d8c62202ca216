import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { cli, command } from '../../ui/empty';
import { field } from '../../ui/form';
import { count, name, size } from '../../ui/format';
import { TEXTS, type OtherTexts } from '../parts/labels';
import { readSettings } from '../parts/settings';
import { readTags } from '../parts/tags';
import { forget, type Kept } from './kept';
import { offerList } from './offers';
import { transferList } from './rows';
import { intake, take, transfersOf } from './take';
import { isUnderWay, type Transfers } from './transfers';
import './upload.css';

/** The page on which captures are uploaded. */
export const open: OpenPage = (context) => {
  context.setTitle('Upload');
  const transfers = transfersOf(context.api);
  const busy = h('p', { role: 'status' });
  const tell = (): void => void (busy.textContent = intake.busy > 0 ? 'Looking through the files…' : '');
  intake.addEventListener('change', tell, { signal: context.signal });
  tell();
  const element = h(
    'div',
    {},
    dropZone(context),
    busy,
    offerList(intake, context),
    transferList(transfers, context),
    interrupted(transfers, context),
    labels(),
    h('h2', {}, 'From a terminal'),
    command(cli('bendtwin capture push FOLDER --watch')),
  );
  return { element };
};

function dropZone({ api }: PageContext): HTMLElement {
  return h(
    'div',
    { class: 'drop-zone card' },
    h(
      'p',
      {},
      h('strong', {}, 'Drop recordings here'),
      ', or anywhere on any page: folders, .zip, .tar, .tar.gz, .mcap, and markers as .c3d, .csv or .trc, also several together.',
    ),
    h(
      'p',
      { class: 'muted' },
      'You see what was found before it is sent. Of a folder only the needed files are sent, and an interrupted upload resumes where it stopped.',
    ),
    h('div', { class: 'buttons' }, chooser('Choose files', api, false), chooser('Choose a folder', api, true)),
  );
}

/** A button that opens the browser's own dialog. */
function chooser(text: string, api: PageContext['api'], isFolder: boolean): HTMLElement[] {
  const input = h('input', {
    type: 'file',
    hidden: true,
    multiple: true,
    webkitdirectory: isFolder,
    'aria-label': text,
  });
  input.addEventListener('change', () => {
    take(api, [...(input.files ?? [])]);
    input.value = '';
  });
  const button = h(
    'button',
    { type: 'button', class: isFolder ? null : 'primary', onclick: () => input.click() },
    text,
  );
  return [button, input];
}

/** Fields of the labels for the next files. */
function labels(): HTMLElement {
  const given = intake.options;
  const named = h('input', { maxlength: '200', value: given.labels.name });
  const texts = TEXTS.captures.flatMap(({ key, label }) => {
    if (key === 'display_name') return [];
    const input = h('input', { maxlength: '200', value: given.labels.texts[key] ?? '' });
    return [{ key, label, input }];
  });
  const note = h('textarea', { rows: '3', maxlength: '10000' }, given.labels.note);
  const tags = h('input', { value: given.labels.tags.join(' '), spellcheck: 'false' });
  const settings = h('textarea', { rows: '2', spellcheck: 'false', class: 'code' });
  settings.value =
    given.ingest === ''
      ? ''
      : Object.entries(JSON.parse(given.ingest) as object)
          .map(([k, v]) => `${k} = ${JSON.stringify(v)}`)
          .join('\n');
  const fault = h('p', { class: 'fault', role: 'alert' });
  const update = (): void => {
    const read = readSettings(settings.value);
    const wrong = readTags(tags.value).faults;
    fault.textContent = [...read.faults.map(({ text }) => text), ...wrong].join(' ');
    const stated = texts.map(({ key, input }) => [key, input.value.trim()]).filter(([, text]) => text !== '');
    intake.options = {
      labels: {
        name: named.value.trim(),
        texts: Object.fromEntries(stated) as OtherTexts,
        note: note.value.trim(),
        tags: readTags(tags.value).tags,
      },
      ingest: read.isEmpty ? '' : JSON.stringify(read.value),
    };
  };
  for (const control of [named, ...texts.map(({ input }) => input), note, tags, settings]) control.addEventListener('input', update);
  return h(
    'details',
    { class: 'card' },
    h('summary', {}, 'Facts and settings of the next files'),
    field('Name', named, 'Default: the name of the file or folder. Applies only to a single file or folder.'),
    ...texts.map(({ label, input }) => field(label, input)),
    field('Note', note),
    field('Tags', tags, 'Words, separated by spaces.'),
    field('Settings of the ingest', settings, [
      'One a line, as ',
      h('code', {}, 'spacing_m = 0.004'),
      '. Others keep their defaults.',
    ]),
    fault,
  );
}

/** Uploads that did not end before the page was closed: the browser has to be given their files again. */
function interrupted(transfers: Transfers, context: PageContext): HTMLElement {
  const element = h('section', { 'aria-label': 'Interrupted uploads' });
  let last = '';
  const update = (): void => {
    const own = new Set(transfers.all.filter(isUnderWay).map(({ name: text }) => text));
    const all = transfers.interrupted;
    const state = JSON.stringify([all, [...own]]);
    if (state === last) return;
    last = state;
    element.hidden = all.length === 0;
    element.replaceChildren(
      h('h2', {}, 'Interrupted'),
      h(
        'p',
        {},
        'These uploads were begun in this browser. ',
        'Choose or drop the same files again to resume them.',
      ),
      h('ul', { class: 'transfers' }, ...all.map((upload) => interruptedRow(upload, transfers, context))),
    );
  };
  transfers.addEventListener('change', update, { signal: context.signal });
  update();
  return element;
}

function interruptedRow(upload: Kept, transfers: Transfers, { api }: PageContext): HTMLElement {
  const drop = (): void => {
    transfers.forget(upload);
    forget(upload.files);
  };
  return h(
    'li',
    { class: 'card' },
    h(
      'div',
      { class: 'transfer-head' },
      h('strong', {}, name(upload.name)),
      h('span', { class: 'muted' }, `${upload.kind} `, h('bdi', {}, upload.source), `, ${size(upload.sizeBytes)}`),
      chooser(upload.kind === 'folder' ? 'Choose the folder' : 'Choose the file', api, upload.kind === 'folder'),
      h('button', { type: 'button', class: 'small', onclick: drop, 'aria-label': `Forget ${upload.name}` }, 'Forget'),
    ),
    upload.tags.length > 0 && h('p', { class: 'muted' }, `${count(upload.tags.length)} tags: ${upload.tags.join(' ')}`),
  );
}
