import type { Api } from '../api/client';
import { h } from './dom';
import './thumbnail.css';

/** Pictures that are fetched together; others wait for their turn. */
const AT_ONCE = 4;
/** Distance from the window at which a picture is fetched. */
const NEAR = '200px';

/**
 * A small picture of a resource in a box of 80 x 60 CSS pixels, fetched from `path` of the API (as
 * `/v1/twins/ID/thumbnail`) when it comes near the window; a neutral box until then, and without
 * one. Drawn again within the life of `signal`, which is that of the page, it is there immediately.
 */
export function thumbnail(api: Api, path: string, alt: string, signal: AbortSignal): HTMLElement {
  const box = placeholder();
  const show = (address: string | null): void => {
    if (address === null || signal.aborted) return;
    box.classList.remove('thumbnail-empty');
    box.replaceChildren(h('img', { src: address, alt, width: '80', height: '60', decoding: 'async' }));
  };
  const pictures = picturesOf(api, signal);
  const known = pictures.peek(path);
  if (known !== undefined) show(known);
  else whenNear(box, signal, () => void pictures.load(path).then(show));
  return box;
}

/** The box of a thumbnail without a picture, as for what is not read yet. */
export function placeholder(): HTMLElement {
  return h('span', { class: 'thumbnail thumbnail-empty' });
}

/** Pictures of a page by their paths. All are released when its signal is aborted. */
export class Pictures {
  readonly #all = new Map<string, Promise<string | null>>();
  readonly #known = new Map<string, string | null>();
  readonly #waiting: (() => void)[] = [];
  #running = 0;

  constructor(
    private readonly api: Pick<Api, 'fetch'>,
    private readonly signal: AbortSignal,
  ) {
    signal.addEventListener('abort', () => {
      for (const address of this.#known.values()) if (address !== null) URL.revokeObjectURL(address);
    });
  }

  /** The address of a picture that was loaded, null without one; undefined before. */
  peek(path: string): string | null | undefined {
    return this.#known.get(path);
  }

  /** The address of a picture (`blob:`), fetched once; null without one. */
  load(path: string): Promise<string | null> {
    const own = this.#all.get(path) ?? this.#fetch(path);
    this.#all.set(path, own);
    return own;
  }

  async #fetch(path: string): Promise<string | null> {
    while (this.#running >= AT_ONCE) await new Promise<void>((resolve) => this.#waiting.push(resolve));
    this.#running += 1;
    let address: string | null = null;
    try {
      const answer = await this.api.fetch(path, { signal: this.signal });
      const picture = await answer.blob();
      if (!this.signal.aborted) address = URL.createObjectURL(picture);
    } catch {
      // Not every resource has one, and a list is complete without it.
    }
    this.#running -= 1;
    this.#waiting.shift()?.();
    this.#known.set(path, address);
    return address;
  }
}

const PAGES = new WeakMap<AbortSignal, Pictures>();

function picturesOf(api: Api, signal: AbortSignal): Pictures {
  const own = PAGES.get(signal) ?? new Pictures(api, signal);
  PAGES.set(signal, own);
  return own;
}

const OBSERVERS = new WeakMap<AbortSignal, IntersectionObserver>();
const ACTIONS = new WeakMap<Element, () => void>();

/** Calls `act` once, when an element comes near the window. */
function whenNear(element: Element, signal: AbortSignal, act: () => void): void {
  let observer = OBSERVERS.get(signal);
  if (observer === undefined) {
    const own = new IntersectionObserver(
      (entries) => {
        for (const { isIntersecting, target } of entries) {
          if (!isIntersecting) continue;
          own.unobserve(target);
          ACTIONS.get(target)?.();
        }
      },
      { rootMargin: NEAR },
    );
    signal.addEventListener('abort', () => own.disconnect());
    OBSERVERS.set(signal, own);
    observer = own;
  }
  ACTIONS.set(element, act);
  observer.observe(element);
}
