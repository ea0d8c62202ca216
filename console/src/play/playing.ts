import type { PageContext } from '../page';
import type { Driver } from './input/driver';
import type { Facts, Message, Ready } from './protocol/messages';
import type { PlayScene } from './scene';
import type { WorldModel } from './world_model';

/** A play as the panels of its page have it. */
export interface Playing {
  readonly context: PageContext;
  readonly scene: PlayScene;
  readonly driver: Driver;
  readonly model: WorldModel;
  readonly name: string;
  /** The play under way, or null. */
  ready(): Ready | null;
  send(message: Message): boolean;
  /** Sends the world of the model. */
  sendWorld(): void;
  /** Says something on the page and to a screen reader. */
  say(text: string): void;
}

/** A part of the page that shows facts of the play. */
export interface Panel {
  readonly element: HTMLElement;
  /** Shows facts, every second and after every change. */
  update?(facts: Facts): void;
  /** Shows what is selected and what is held. */
  refresh?(): void;
}
