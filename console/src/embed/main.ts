import { bytesOfBase64 } from '@bendtwin/client';
import '../ui/colors.css';
import './embed.css';
import { h } from '../ui/dom';
import { twinPage } from './page';

// The entry of a page that shows one twin: its file is in the page, its name is the title.
try {
  const content = bytesOfBase64(document.querySelector('#twin')?.textContent?.trim() ?? '');
  document.body.append(twinPage(document.title, content));
} catch (error) {
  const why = error instanceof Error ? error.message : String(error);
  document.body.append(h('main', { class: 'embed-fault' }, h('h1', {}, document.title), h('p', { role: 'alert' }, why)));
}
