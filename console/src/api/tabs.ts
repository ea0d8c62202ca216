import { ownToken, setToken } from './token';

/** Time in which other tabs answer [ms]. */
const ANSWER_MS = 150;

type Said = { readonly says: 'ask' | 'forget' } | { readonly says: 'token'; readonly token: string };

/**
 * The token among tabs of the console: a tab that is opened beside others need not be logged in
 * again, and logging out of one logs out of all. Only pages of this server hear what is said.
 */
export class Tabs {
  private readonly channel = new BroadcastChannel('bendtwin.token');

  /** `onForget` is called when another tab logs out. */
  constructor(onForget: () => void) {
    this.channel.addEventListener('message', ({ data }: MessageEvent<Said>) => {
      const mine = ownToken();
      if (data.says === 'ask' && mine !== null) this.say({ says: 'token', token: mine });
      if (data.says === 'forget' && mine !== null) {
        setToken(null);
        onForget();
      }
    });
  }

  /** Logs out of all tabs. */
  forget(): void {
    setToken(null);
    this.say({ says: 'forget' });
  }

  /** Takes the token of another tab; false without another tab that has a different token. */
  take(): Promise<boolean> {
    return new Promise((resolve) => {
      const end = (taken: boolean): void => {
        clearTimeout(timer);
        this.channel.removeEventListener('message', hear);
        resolve(taken);
      };
      const hear = ({ data }: MessageEvent<Said>): void => {
        if (data.says !== 'token' || data.token === ownToken()) return;
        setToken(data.token);
        end(true);
      };
      const timer = setTimeout(() => end(false), ANSWER_MS);
      this.channel.addEventListener('message', hear);
      this.say({ says: 'ask' });
    });
  }

  private say(said: Said): void {
    this.channel.postMessage(said);
  }
}
