import { idOf } from '../../api/routes';
import type { Twin } from '../../api/types';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { empty } from '../../ui/empty';
import { count, millimetres, time } from '../../ui/format';
import { captureLink } from '../parts/capture';
import { comparedIds, compareTable, differingSettings, distinctNames, type Line } from '../parts/compare';
import { isolated } from '../parts/text';
import { levelBadge } from './level';
import { readTwinFile } from './file';
import { comparedText, headlineOf, measuresOf, rowsOf, type Errors, type Quality } from './quality';

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
  const element = h(
    'div',
    {},
    ...sentences(twins, names.map(isolated)).map((text) => h('p', {}, h('bdi', {}, text))),
    compareTable('Twins side by side', names, [...factLines(context, twins), ...errorLines(twins)]),
    h('h2', {}, 'Settings that differ'),
    differing.length > 0 ? compareTable('Settings that differ', names, differing) : h('p', { class: 'muted' }, 'None.'),
  );
  return { element };
};

/** The first twin beside each other one, in words. */
function sentences(twins: readonly Twin[], names: readonly string[]): string[] {
  const [first, ...others] = twins;
  if (first === undefined) return [];
  return others.flatMap((other, index) => {
    const [a, b] = [names[0] ?? '', names[index + 1] ?? ''];
    if (!first.capture || first.capture !== other.capture) {
      return [
        `${a} and ${b} were measured on different captures: their errors are not comparable. Evaluate both on one capture.`,
      ];
    }
    const error = comparedText(a, b, headlineOf(first.quality as Quality)?.error_m ?? null, headlineOf(other.quality as Quality)?.error_m ?? null);
    const nodes =
      first.node_count === other.node_count
        ? 'They have equally many nodes.'
        : `${a} has ${count(first.node_count)} nodes, ${b} ${count(other.node_count)}.`;
    return error === null ? [nodes] : [`${error} ${nodes}`];
  });
}

function factLines(context: PageContext, twins: readonly Twin[]): Line[] {
  const line = (text: string, cell: (twin: Twin) => Line['cells'][number]): Line => ({ text, cells: twins.map(cell) });
  return [
    line('Twin', ({ name }) => [
      h('a', { href: `#/twins/${idOf(name)}` }, 'Open'),
      ' ',
      h('a', { href: `#/twins/${idOf(name)}/play` }, 'Play'),
    ]),
    line('Capture', ({ capture }) => (capture ? captureLink(context, capture) : 'imported')),
    line('Trust', ({ quality }) => {
      const level = (quality as Quality).assessment?.level;
      return levelBadge(level);
    }),
    line('Created', ({ create_time }) => time(create_time)),
    line('Nodes', ({ node_count }) => count(node_count)),
    line('Springs', ({ spring_count }) => count(spring_count)),
    line('Bending triplets', ({ triplet_count }) => count(triplet_count)),
    line('Substeps per frame', ({ substeps }) => count(substeps)),
  ];
}

/** Errors of the twins themselves, by measure, of training and future frames. */
function errorLines(twins: readonly Twin[]): Line[] {
  const own = twins.map(({ quality }) => rowsOf(quality as Quality)[0]);
  const measures = measuresOf(own.filter((row) => row !== undefined));
  return (['future', 'train'] as const).flatMap((part) =>
    measures.map(([measure, words]) => ({
      text: `${part === 'train' ? 'Training' : 'Future'} error, ${words}`,
      cells: own.map((row) => millimetres((row?.[part] as Errors | undefined)?.[measure])),
    })),
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
