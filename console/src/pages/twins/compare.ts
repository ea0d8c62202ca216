import { idOf, type Twin } from '@bendtwin/client';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { empty } from '../../ui/empty';
import { count, millimetres, time } from '../../ui/format';
import { captureLink } from '../parts/capture';
import { comparedIds, compareTable, differingSettings, distinctNames, numberLine, type Line } from '../parts/compare';
import { isolated } from '../parts/text';
import { thumbnail } from '../../ui/thumbnail';
import { levelBadge } from './verdict/level';
import { readTwinFile } from './file';
import { bestText, comparedText, headlineOf, measuresOf, rowsOf, type Errors, type Quality } from './quality';

/** Twins beside each other: errors, sizes, settings that differ, and the differences in words. */
export const open: OpenPage = async (context) => {
  context.setTitle('Compare twins');
  const ids = comparedIds(context.query);
  if (ids.length < 2) return { element: empty('Choose two or more twins in the list of twins.') };
  const { api, signal } = context;
  const twins = await Promise.all(ids.map((id) => api.get('/v1/twins/{id}', { id, signal })));
  const settings = await Promise.all(ids.map((id) => settingsOf(context, id)));
  const names = distinctNames(twins.map(({ display_name }) => display_name));
  const differing = differingSettings(settings);
  // Errors on different recordings say nothing about each other.
  const isFair = twins.every(({ capture }) => capture && capture === twins[0]?.capture);
  const element = h(
    'div',
    {},
    h('p', {}, h('bdi', {}, sentence(twins, names.map(isolated), isFair))),
    compareTable('Twins side by side', names, [...factLines(context, twins), ...errorLines(twins, isFair), ...sizeLines(twins)]),
    h('h2', {}, 'Settings that differ'),
    differing.length > 0 ? compareTable('Settings that differ', names, differing) : h('p', { class: 'muted' }, 'None.'),
  );
  return { element };
};

/** What the comparison comes to, in words. */
function sentence(twins: readonly Twin[], names: readonly string[], isFair: boolean): string {
  if (!isFair) {
    return 'They were measured on different captures: their errors are not comparable. Evaluate all of them on one capture.';
  }
  const errors = twins.map(({ quality }) => headlineOf(quality as Quality)?.error_m ?? null);
  const [first = '', second = ''] = names;
  const text = names.length === 2 ? comparedText(first, second, errors[0] ?? null, errors[1] ?? null) : bestText(names, errors);
  return text ?? 'Not all of them have errors on frames that were not fitted.';
}

function factLines(context: PageContext, twins: readonly Twin[]): Line[] {
  const line = (text: string, cell: (twin: Twin) => Line['cells'][number]): Line => ({ text, cells: twins.map(cell) });
  return [
    line('Picture', ({ name }) => thumbnail(context.api, `/v1/${name}/thumbnail`, '', context.signal)),
    line('Twin', ({ name }) => [
      h('a', { class: 'button small', href: `#/twins/${idOf(name)}` }, 'Open'),
      ' ',
      h('a', { class: 'button small', href: `#/twins/${idOf(name)}/play` }, 'Play'),
    ]),
    line('Capture', ({ capture }) => (capture ? captureLink(context, capture) : 'imported')),
    line('Verdict', ({ quality }) => levelBadge((quality as Quality).assessment?.level)),
    line('Created', ({ create_time }) => time(create_time)),
  ];
}

function sizeLines(twins: readonly Twin[]): Line[] {
  const line = (text: string, cell: (twin: Twin) => string): Line => ({ text, cells: twins.map(cell) });
  return [
    line('Nodes', ({ node_count }) => count(node_count)),
    line('Springs', ({ spring_count }) => count(spring_count)),
    line('Bending triplets', ({ triplet_count }) => count(triplet_count)),
    line('Substeps per frame', ({ substeps }) => count(substeps)),
  ];
}

/** Errors of the twins themselves, by measure, on later and fitted frames; the best is marked if that is fair. */
function errorLines(twins: readonly Twin[], isFair: boolean): Line[] {
  const own = twins.map(({ quality }) => rowsOf(quality as Quality)[0]);
  const measures = measuresOf(own.filter((row) => row !== undefined));
  return (['future', 'train'] as const).flatMap((part) =>
    measures.map(([measure, words]) =>
      numberLine(
        `Error on ${part === 'train' ? 'fitted' : 'later'} frames, ${words}`,
        own.map((row) => (row?.[part] as Errors | undefined)?.[measure]),
        millimetres,
        isFair,
      ),
    ),
  );
}

/** The settings in force when a twin was fitted; null if its file does not say. */
async function settingsOf({ api, signal }: PageContext, id: string): Promise<unknown> {
  try {
    const { document } = await readTwinFile(api, id, signal);
    return document.provenance?.settings ?? null;
  } catch {
    return null;
  }
}
