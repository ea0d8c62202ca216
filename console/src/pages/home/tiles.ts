import { h } from '../../ui/dom';
import { count, size } from '../../ui/format';
import type { Numbers } from './numbers';

/** Numbers of each kind of resource, each with a way to them. */
export function tiles(numbers: Numbers): HTMLElement {
  return h(
    'ul',
    { class: 'cards tiles', 'aria-label': 'What is here' },
    tile('#/captures', 'Captures', count(numbers.captures), [
      numbers.reading > 0 && `${count(numbers.reading)} being read`,
      numbers.unread > 0 && `${count(numbers.unread)} waiting`,
      numbers.unreadable > 0 && `${count(numbers.unreadable)} could not be read`,
    ]),
    tile('#/fits', 'Fits', count(numbers.fits), [
      numbers.fitsRunning > 0 && `${count(numbers.fitsRunning)} running`,
      numbers.fitsQueued > 0 && `${count(numbers.fitsQueued)} queued`,
      numbers.fitsFailed > 0 && `${count(numbers.fitsFailed)} failed`,
    ]),
    tile('#/twins', 'Twins', count(numbers.twins) + (numbers.hasMoreTwins ? '+' : ''), []),
    tile('#/workers', 'Workers', count(numbers.workers.length), [
      backends(numbers.workers),
      `${size(numbers.diskFreeBytes)} of disk free`,
    ]),
  );
}

function tile(href: string, title: string, number: string, remarks: (string | false)[]): HTMLElement {
  const said = remarks.filter((remark) => remark !== false && remark !== '');
  return h(
    'li',
    { class: 'card' },
    h('a', { href, class: 'tile' }, h('span', { class: 'tile-number' }, number), ' ', title),
    h('p', { class: 'muted' }, said.join(', ')),
  );
}

function backends(workers: readonly string[]): string {
  const words = new Set(workers.map((backend) => (backend === 'cpu' ? 'CPU' : backend.toUpperCase())));
  return [...words].join(' and ');
}
