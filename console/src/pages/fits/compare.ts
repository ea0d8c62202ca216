import { idOf, tookS, type Fit, type LossCurve } from '@bendtwin/client';
import type { OpenPage } from '../../page';
import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { empty } from '../../ui/empty';
import { duration, time } from '../../ui/format';
import { comparedIds, compareTable, differingSettings, distinctNames, type Line } from '../parts/compare';
import { isolated } from '../parts/text';
import { comparedText } from '../twins/quality';
import { LOSSES, StageCharts } from './chart';
import { captureLink } from '../parts/capture';
import { errorWords } from '../parts/error';
import { chartsOf, lastLosses, lossText } from './losses';

/** Fits beside each other: their results, losses, and settings that differ. */
export const open: OpenPage = async (context) => {
  context.setTitle('Compare fits');
  const ids = comparedIds(context.query);
  if (ids.length < 2) return { element: empty('Choose two or more fits in the list of fits.') };
  const { api, signal } = context;
  const fits = await Promise.all(ids.map((id) => api.get('/v1/fits/{id}', { id, signal })));
  const losses = await Promise.all(ids.map((id) => api.get('/v1/fits/{id}/losses', { id, signal })));
  const names = distinctNames(fits.map(({ display_name }) => display_name));
  const charts = new StageCharts(LOSSES);
  const named = losses.flatMap(({ curves }, index) =>
    curves.map((curve) => ({ ...curve, variant: `${names[index]}: ${curve.variant}` })),
  );
  charts.update(chartsOf(named));
  const differing = differingSettings(fits.map(({ job }) => job.settings));
  const lines: Line[] = [
    { text: 'Fit', cells: fits.map((fit) => h('a', { href: `#/fits/${idOf(fit.name)}` }, 'Open')) },
    { text: 'Twin', cells: fits.map(({ twin }) => (twin ? h('a', { href: `#/twins/${idOf(twin)}` }, 'Open') : '–')) },
    { text: 'Capture', cells: fits.map(({ capture }) => captureLink(context, capture)) },
    { text: 'State', cells: fits.map(({ job }) => badge(job.state)) },
    { text: 'Error on later frames', cells: fits.map(({ error_m, measure }) => errorWords(error_m, measure)) },
    { text: 'Lowest loss', cells: losses.map(({ curves }) => lowest(curves)) },
    { text: 'Took', cells: fits.map(({ job }) => duration(tookS(job))) },
    { text: 'Created', cells: fits.map(({ job }) => time(job.create_time)) },
  ];
  const element = h(
    'div',
    {},
    sentences(fits, names.map(isolated)),
    compareTable('Fits side by side', names, lines),
    h('h2', {}, 'Settings that differ'),
    differing.length > 0 ? compareTable('Settings that differ', names, differing) : h('p', { class: 'muted' }, 'None.'),
    h('h2', {}, 'Losses'),
    charts.element,
  );
  return { element, dispose: () => charts.dispose() };
};

/** The first fit beside each other one, in words. */
function sentences(fits: readonly Fit[], names: readonly string[]): HTMLElement {
  const [first, ...others] = fits;
  const texts = others.flatMap((other, index) => {
    if (first === undefined) return [];
    if (first.capture !== other.capture)
      return [`${names[0]} and ${names[index + 1]} are of different captures: their errors are not comparable.`];
    const text = comparedText(names[0] ?? '', names[index + 1] ?? '', first.error_m ?? null, other.error_m ?? null);
    return text === null ? [] : [text];
  });
  return h('div', {}, ...texts.map((text) => h('p', {}, h('bdi', {}, text))));
}

function lowest(curves: readonly LossCurve[]): string {
  const all = lastLosses(curves).flatMap(({ best }) => (best === null ? [] : [best]));
  return all.length === 0 ? '–' : lossText(Math.min(...all));
}
