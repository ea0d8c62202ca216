import type { Labels } from './kept';
import type { Package } from './select';
import type { Survey } from './survey/survey';

/** Options for the next files. */
export interface Options {
  readonly labels: Labels;
  /** Settings of the ingest as JSON, or empty. */
  readonly ingest: string;
}

/** Files that wait for a person to upload them, with what was found in them. */
export interface Offer {
  readonly id: number;
  /** Fingerprint of the files. */
  readonly files: string;
  readonly source: Package;
  readonly survey: Survey;
  /** True if nothing else was dropped with them: a name that was given is theirs. */
  readonly isOnly: boolean;
}

/** A sentence about files that were not taken. */
export interface Refusal {
  readonly id: number;
  readonly text: string;
}

/** What was dropped or chosen: offers and refusals stay until somebody decides, also on other pages. Event `change`. */
export class Intake extends EventTarget {
  options: Options = { labels: { name: '', texts: {}, note: '', tags: [] }, ingest: '' };
  /** Number of drops whose files are being looked through. */
  busy = 0;
  #offers: readonly Offer[] = [];
  #refusals: readonly Refusal[] = [];
  #count = 0;

  get offers(): readonly Offer[] {
    return this.#offers;
  }

  get refusals(): readonly Refusal[] {
    return this.#refusals;
  }

  /** Notes that files are looked through, and, with -1, that they no longer are. */
  look(by: 1 | -1): void {
    this.busy += by;
    this.#changed();
  }

  /** Offers files, in the place of an offer of the same ones. */
  offer(offer: Omit<Offer, 'id'>): void {
    this.#offers = [...this.#offers.filter(({ files }) => files !== offer.files), { ...offer, id: (this.#count += 1) }];
    this.#changed();
  }

  refuse(text: string): void {
    this.#refusals = [...this.#refusals.filter((own) => own.text !== text), { id: (this.#count += 1), text }];
    this.#changed();
  }

  /** Takes an offer or a refusal away. */
  dismiss(wanted: number): void {
    this.#offers = this.#offers.filter(({ id }) => id !== wanted);
    this.#refusals = this.#refusals.filter(({ id }) => id !== wanted);
    this.#changed();
  }

  #changed(): void {
    this.dispatchEvent(new Event('change'));
  }
}
