import { idOf, type Share, type Twin } from '@bendtwin/client';
import { ownToken } from '../../api/token';
import { visitAddress } from '../../api/visit';
import type { PageContext } from '../../page';
import { confirm } from '../../ui/dialog';
import { h } from '../../ui/dom';
import { field } from '../../ui/form';
import { name, time } from '../../ui/format';
import { problemBox } from '../../ui/problem';
import './share.css';

const DAYS: readonly (readonly [number, string])[] = [[1, '1 day'], [7, '7 days'], [30, '30 days'], [90, '90 days']];
const USUAL_DAYS = 7;
const DAY_S = 86_400;

/** A button that opens the links of a twin. */
export function shareButton(context: PageContext, twin: Twin): HTMLElement {
  return h('button', { type: 'button', class: 'quiet', onclick: () => openShares(context, idOf(twin.name)) }, 'Share');
}

/** Opens a dialog that makes, lists and revokes links by which people without a token play with a twin, from a moment on. */
export function openShares(context: PageContext, id: string, moment = new URLSearchParams()): void {
  const dialog = h('dialog', { class: 'dialog shares', 'aria-labelledby': 'shares-title' });
  const list = new ShareList(context, id);
  const close = (): void => dialog.close();
  dialog.append(
    h('h2', { id: 'shares-title' }, 'Share this twin'),
    ...(ownToken() === null ? openLink(id, moment) : [
      h('p', { class: 'hint' }, 'People with a link see this twin and play with it, without a token. They reach nothing else.'),
      form(context, id, moment, () => void list.update()),
      list.element,
    ]),
    h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: close }, 'Close')),
  );
  dialog.addEventListener('close', () => dialog.remove());
  context.signal.addEventListener('abort', close, { once: true });
  document.body.append(dialog);
  dialog.showModal();
  if (ownToken() !== null) void list.update();
}

/** The link of a server that requires no token: its address alone. */
function openLink(id: string, moment: URLSearchParams): HTMLElement[] {
  const hint = 'This server requires no token: everyone who reaches it can open this address, and it does not expire.';
  return [h('p', { class: 'hint' }, 'People with the link see this twin and play with it.'), linkField(visitAddress(id, null, moment), hint)];
}

/** The form of a new link, and the link. */
function form(context: PageContext, id: string, moment: URLSearchParams, made: () => void): HTMLElement {
  const { api, signal } = context;
  const days = h('select', {}, ...DAYS.map(([n, text]) => h('option', { value: n, selected: n === USUAL_DAYS }, text)));
  const whom = h('input', { type: 'text', maxlength: 200, autocomplete: 'off' });
  const exports = h('input', { type: 'checkbox' });
  const button = h('button', { type: 'submit', class: 'primary' }, 'Create link');
  const place = h('div', {});
  const submit = async (event: Event): Promise<void> => {
    event.preventDefault();
    button.disabled = true;
    const body = { display_name: whom.value.trim(), ttl_s: Number(days.value) * DAY_S, allow_export: exports.checked };
    try {
      const path = `/v1/twins/${encodeURIComponent(id)}/shares`;
      const { secret_key } = await api.send<{ secret_key: string }>('POST', path, body, signal);
      const hint = 'Copy it now: it is shown only once.';
      place.replaceChildren(linkField(visitAddress(id, secret_key, moment), hint));
      made();
    } catch (error) {
      if (!context.signal.aborted) place.replaceChildren(problemBox(error));
    }
    button.disabled = false;
  };
  return h('form', { onsubmit: (event) => void submit(event) },
    h('div', { class: 'shares-form' },
      field('Expires after', days),
      field('For', whom, 'For the list below. Visitors do not see it.')),
    h('div', { class: 'shares-row' }, h('label', {}, exports, ' Allow downloads of the twin'), button),
    place);
}

/** A link, and a button that copies it. */
function linkField(link: string, hint: string): HTMLElement {
  const input = h('input', { type: 'text', readonly: true, value: link, onfocus: () => input.select() });
  const said = h('span', { role: 'status', class: 'hint' });
  const copy = async (): Promise<void> => {
    input.select();
    try {
      await navigator.clipboard.writeText(link);
      said.textContent = 'Copied';
    } catch {
      // Browsers have a clipboard for pages of this machine and for those with TLS only.
      said.textContent = 'Copy it from the field.';
    }
  };
  const labelled = field('Link', input, hint);
  input.after(h('button', { type: 'button', onclick: () => void copy() }, 'Copy'));
  labelled.append(said);
  return h('div', { class: 'shares-link' }, labelled);
}

/** The links that are valid. */
class ShareList {
  readonly element = h('div', {});

  constructor(
    private readonly context: PageContext,
    private readonly id: string,
  ) {}

  /** Asks for them. */
  async update(): Promise<void> {
    const { api, signal } = this.context;
    try {
      const { shares } = await api.get('/v1/twins/{id}/shares', { id: this.id, query: { page_size: 1000 }, signal });
      const valid = shares.filter((share) => !share.revoke_time && Date.parse(share.expire_time) > Date.now());
      this.element.replaceChildren(...(valid.length === 0 ? [] : [this.list(valid)]));
    } catch (error) {
      if (!signal.aborted) this.element.replaceChildren(problemBox(error, () => void this.update()));
    }
  }

  private list(shares: readonly Share[]): HTMLElement {
    return h('section', {}, h('h3', {}, 'Links in use'), h('ul', { class: 'shares-list' }, ...shares.map((s) => this.row(s))));
  }

  private row(share: Share): HTMLElement {
    const revoke = h('button', { type: 'button', class: 'small danger' }, 'Revoke');
    if (share.display_name !== '') revoke.setAttribute('aria-label', `Revoke: ${share.display_name}`);
    revoke.addEventListener('click', () => void this.revoke(share));
    return h('li', {},
      h('div', {},
        h('div', {}, name(share.display_name, 'Link'), share.allow_export && ' (with downloads)'),
        h('div', { class: 'hint' },
          'Expires ', time(share.expire_time), ', ',
          share.last_use_time ? ['last used ', time(share.last_use_time)] : 'not used yet')),
      revoke);
  }

  private async revoke(share: Share): Promise<void> {
    const question = { title: 'Revoke this link?', text: 'It stops working, and plays through it end.' };
    if (!(await confirm({ ...question, action: 'Revoke', isDangerous: true }))) return;
    try {
      await this.context.api.fetch(`/v1/shares/${idOf(share.name)}`, { method: 'DELETE', signal: this.context.signal });
      await this.update();
    } catch (error) {
      if (!this.context.signal.aborted) this.element.prepend(problemBox(error));
    }
  }
}
