import { idOf } from '@bendtwin/client';
import type { OpenPage } from '../page';
import { PlayPage } from './play_page';
import type { Ready, Text } from './protocol/messages';
import { openSocket } from './protocol/socket';
import { loadTwin } from './twin';

/** A play of someone else, to be watched. */
export const open: OpenPage = async (context) => {
  const path = `/v1/plays/${encodeURIComponent(context.parameters['id'] ?? '')}/watch`;
  const id = idOf(await twinOf(path, context.signal));
  const page = new PlayPage(context, await loadTwin(context, id));
  page.connect(path, false);
  return page;
};

/** The twin of a play, which its first message names. */
function twinOf(path: string, signal: AbortSignal): Promise<string> {
  return new Promise((resolve, reject) => {
    const socket = openSocket(path);
    const end = (): void => socket.close();
    signal.addEventListener('abort', end);
    socket.addEventListener('message', ({ data }: MessageEvent<string | ArrayBuffer>) => {
      if (typeof data !== 'string') return;
      const text = JSON.parse(data) as Text;
      if (text.type === 'ready') resolve((text satisfies Ready).twin);
      end();
    });
    socket.addEventListener('close', () => reject(new Error('This play has ended, or there never was one.')));
  });
}
