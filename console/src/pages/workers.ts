import { idOf, type Worker } from '@bendtwin/client';
import type { OpenPage } from '../page';
import { badge } from '../ui/badge';
import { h } from '../ui/dom';
import type { Child } from '../ui/dom';
import { empty } from '../ui/empty';
import { keepingFocus } from '../ui/focus';
import { facts, progress } from '../ui/form';
import { counted, duration, percent, since, size } from '../ui/format';
import { refresh } from '../ui/refresh';
import { askOwners, ownersTable } from './parts/usage';

const EVERY_MS = 2000;
/** Pause between questions for the usage of all owners, which takes the server longer [ms]. */
const USAGE_EVERY_MS = 30_000;
/** Time after which a worker that says nothing is taken for silent [ms]; heartbeats come every few seconds. */
const SILENT_MS = 20_000;

/**
 * The workers: their devices, what they do, and the twins that they have loaded; for operators also what
 * is stored for each owner.
 */
export const open: OpenPage = async (context) => {
  context.setTitle('Workers');
  const element = h('div');
  const usage = h('div');
  await refresh(context, EVERY_MS, async () => {
    const { workers } = await context.api.get('/v1/workers', { signal: context.signal });
    keepingFocus(element, () => element.replaceChildren(workers.length === 0 ? none() : all(workers)));
  });
  let mayAsk = true;
  await refresh(context, USAGE_EVERY_MS, async () => {
    const owners = mayAsk ? await askOwners(context) : null;
    mayAsk = owners !== null;
    if (owners !== null) keepingFocus(usage, () => usage.replaceChildren(ownersTable(owners)));
  });
  return { element: h('div', {}, element, usage) };
};

function none(): HTMLElement {
  return empty(
    'No worker is connected. The server starts its own. On a trusted network it also accepts others, with a token and an address for them:',
    'bendtwin server --workers 1',
    'bendtwin server --listen-workers 0.0.0.0:7071 --worker-token TOKEN --insecure',
    'bendtwin worker --server http://HOST:7071 --token TOKEN',
  );
}

function all(workers: readonly Worker[]): HTMLElement {
  const busy = workers.filter((worker) => tasks(worker).length > 0).length;
  return h(
    'div',
    {},
    h('p', { class: 'muted' }, `${counted(workers.length, 'worker')}, ${busy} at work.`),
    h('ul', { class: 'workers', 'aria-label': 'Workers' }, ...workers.map(one)),
  );
}

function one(worker: Worker): HTMLElement {
  const isSilent = since(worker.last_seen_time) > SILENT_MS;
  const doing = tasks(worker);
  const state = isSilent
    ? badge('silent', 'warn')
    : worker.draining
      ? badge('draining', 'warn')
      : doing.length > 0
        ? badge('busy', 'busy')
        : badge('idle', 'good');
  return h(
    'li',
    { class: 'card' },
    h('h2', { class: 'first' }, worker.backend === 'cpu' ? 'CPU' : worker.backend.toUpperCase(), ' ', state),
    h('p', {}, h('bdi', {}, worker.device)),
    facts([
      ['At work on', doing.length > 0 ? doing : 'nothing'],
      ['Device memory', memory(worker)],
      ['Running for', duration(since(worker.start_time) / 1000)],
      ['Last heartbeat', `${duration(since(worker.last_seen_time) / 1000)} ago`],
      ['Build', worker.build],
      ['Labels', worker.labels.length > 0 ? worker.labels.join(', ') : 'none'],
    ]),
    h('h3', {}, 'Loaded twins'),
    warm(worker),
    h('p', { class: 'muted' }, h('code', {}, worker.name)),
  );
}

/** Current tasks of a worker, with links to them. */
function tasks(worker: Worker): Child[] {
  const { fit, ingest, rollouts_in_flight: rollouts } = worker;
  return [
    ...(fit ? [h('div', {}, h('a', { href: `#/${fit}` }, 'a fit'))] : []),
    ...(ingest ? [h('div', {}, 'reading ', h('a', { href: `#/${ingest}` }, 'a capture'))] : []),
    ...(rollouts > 0 ? [h('div', {}, counted(rollouts, 'rollout'))] : []),
  ];
}

function memory({ memory_used_bytes: used, memory_total_bytes: total }: Worker): Child {
  if (used === null || used === undefined || !total) return 'unknown for this device';
  return [`${size(used)} of ${size(total)} (${percent(used / total)})`, progress('Memory in use', used / total)];
}

function warm({ warm_twins: twins }: Worker): HTMLElement {
  if (twins.length === 0) return h('p', { class: 'muted' }, 'None: a twin is loaded at its first use.');
  const links = twins.map((twin) => h('li', {}, h('a', { href: `#/${twin}` }, h('code', {}, idOf(twin)))));
  return h('ul', { class: 'plain' }, ...links);
}
