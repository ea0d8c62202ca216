import type { Api } from '../../api/client';
import { visitedTwin } from '../../api/visit';
import { h } from '../../ui/dom';
import { counted, percent } from '../../ui/format';
import { isUnderWay } from './transfers';
import { take, transfersOf } from './take';

/** Takes files and folders that are dropped anywhere in the window, and shows the progress of uploads. */
export function acceptDrops(api: Api): void {
  const veil = h('div', { class: 'drop-veil', hidden: true, 'aria-hidden': 'true' }, h('p', {}, 'Drop to upload'));
  let depth = 0;
  const carriesFiles = (event: DragEvent): boolean => 
    visitedTwin() === null && event.dataTransfer?.types.includes('Files') === true;
  const enter = (by: number): void => {
    depth = Math.max(depth + by, 0);
    veil.hidden = depth === 0;
  };
  addEventListener('dragenter', (event) => carriesFiles(event) && enter(1));
  addEventListener('dragleave', (event) => carriesFiles(event) && enter(-1));
  addEventListener('dragover', (event) => carriesFiles(event) && event.preventDefault());
  addEventListener('drop', (event) => {
    if (event.dataTransfer === null || !carriesFiles(event)) return;
    event.preventDefault();
    enter(-depth);
    take(api, event.dataTransfer);
  });
  document.body.append(veil, uploadLine(api));
}

/** A link to the uploads, while there are some under way. */
function uploadLine(api: Api): HTMLElement {
  const link = h('a', { class: 'upload-line', href: '#/upload', hidden: true });
  const transfers = transfersOf(api);
  transfers.addEventListener('change', () => {
    const busy = transfers.all.filter(isUnderWay);
    link.hidden = busy.length === 0;
    const [sent, size] = busy.reduce(([s, all], t) => [s + t.offset, all + t.sizeBytes], [0, 0]);
    link.textContent = `${counted(busy.length, 'upload')}, ${percent(size > 0 ? sent / size : 0)}`;
  });
  // A closed window ends what it sends; the browser asks.
  addEventListener('beforeunload', (event) => {
    if (transfers.isBusy) event.preventDefault();
  });
  return link;
}
