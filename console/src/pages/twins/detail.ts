import { idOf } from '../../api/routes';
import type { Capture, Twin } from '../../api/types';
import type { OpenPage, PageContext } from '../../page';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { count, size, time } from '../../ui/format';
import { deleteButton, download, faultPlace } from '../parts/actions';
import { captureText, findCapture } from '../parts/capture';
import { LabelEditor } from '../parts/labels';
import { LossView } from '../fits/curves';
import { assessmentView, qualityView } from './assessment';
import { evaluationView } from './evaluate';
import { identifiabilityView } from './identifiability';
import { parametersView } from './parameters';
import { shareButton } from './share';
import type { Quality } from './quality';

/** The page of a twin: what it is worth, what it is made of, and what can be done with it. */
export const open: OpenPage = async (context) => {
  const id = context.parameters['id'] ?? '';
  const path = `/v1/twins/${encodeURIComponent(id)}`;
  const twin = await context.api.get('/v1/twins/{id}', { id, signal: context.signal });
  const capture = twin.capture ? await findCapture(context, twin.capture) : null;
  const setTitle = ({ display_name }: Twin): void => context.setTitle(display_name || 'Twin without a name');
  setTitle(twin);
  const faults = faultPlace();
  const quality = twin.quality as Quality;
  const losses = twin.fit ? new LossView(context, idOf(twin.fit)) : null;
  void losses?.update(true);
  const element = h(
    'div',
    {},
    h('div', { class: 'buttons' }, ...actions(context, capture, twin, path, faults)),
    faults,
    new LabelEditor<Twin>(context, 'twins', path, twin, setTitle).element,
    ...[assessmentView(quality)].filter((view) => view !== null),
    twinFacts(twin, capture),
    qualityView(quality),
    ...[identifiabilityView(quality, `#/twins/${id}/view?colour=uncertainty&layers=skin,shadow`)].filter((view) => view !== null),
    evaluationView(context, twin),
    parametersView(context, id, () => settingsAsked(context, twin.fit ?? null)),
    losses?.element ?? '',
  );
  return { element, dispose: () => losses?.dispose() };
};

function actions(
  context: PageContext,
  capture: Capture | null,
  twin: Twin,
  path: string,
  faults: HTMLElement,
): HTMLElement[] {
  const id = idOf(twin.name);
  const own = capture === null ? {} : { capture: idOf(capture.name) };
  const question = { title: 'Delete this twin?', text: 'It goes to the trash, if this server has one. Its capture and its fit are kept.' };
  return [
    h('a', { class: 'button primary', href: `#/twins/${id}/play` }, 'Play'),
    h('a', { class: 'button', href: `#/twins/${id}/view` }, 'View in 3D'),
    ...(capture === null
      ? []
      : [h('a', { class: 'button', href: `#/captures/${own.capture}/playback?twin=${id}` }, 'Beside its recording')]),
    h('a', { class: 'button', href: `#/fits/new?${new URLSearchParams({ from: id, ...own })}` }, 'Refine'),
    download(context, 'Download the file', `${path}/content`, `${id}.safetensors`, faults),
    shareButton(context, twin),
    deleteButton(context, path, question, '#/twins', faults),
  ];
}

function twinFacts(twin: Twin, capture: Capture | null): HTMLElement {
  return facts([
    ['Capture', twin.capture ? captureText(capture) : 'imported'],
    ...(twin.fit ? ([['Fit', h('a', { href: `#/fits/${idOf(twin.fit)}` }, 'Open')]] as const) : []),
    ['Created', time(twin.create_time)],
    ['Nodes', count(twin.node_count)],
    ['Springs', count(twin.spring_count)],
    ['Bending triplets', count(twin.triplet_count)],
    ['Control points', count(twin.control_count)],
    ['Frames per second', twin.fps],
    ['Substeps per frame', twin.substeps],
    ['Mass', twin.mass_kg === undefined ? 'unknown' : `${twin.mass_kg} kg`],
    ['File', size(twin.size_bytes)],
  ]);
}

/** The settings that its fit was asked for; null if it is not there any more. */
async function settingsAsked({ api, signal }: PageContext, fit: string | null): Promise<unknown> {
  if (fit === null) return null;
  try {
    return (await api.get('/v1/fits/{id}', { id: idOf(fit), signal })).job.settings;
  } catch {
    return null;
  }
}
