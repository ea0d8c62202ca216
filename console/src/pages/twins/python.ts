import type { Twin } from '@bendtwin/client';
import { snippet } from '../../ui/copy';
import { showDialog } from '../../ui/dialog';
import { h } from '../../ui/dom';

/** A program that loads a twin with the Python client and predicts a motion: client/python/README.md. */
export function pythonOf(twin: string, server: string): string {
  return `import numpy as np
from bendtwin import Client, Returns

with Client("${server}") as client:
    twin = client.twin("${twin}")
    # All control points rise by 5 cm in 30 frames: [B, F + 1, C, 3], metres.
    lift = np.linspace(0, 1, 31)[:, None, None] * [0, 0, 0.05]
    actions = (twin.geometry().controls + lift)[None]
    result = twin.rollout(trajectories=actions, returns=Returns(every_frames=1))
    print(result.positions.shape)  # [B, F, N, 3]
`;
}

/** A button that shows how the twin is used in Python. */
export function pythonButton(twin: Pick<Twin, 'name'>): HTMLElement {
  const show = (): void =>
    showDialog(
      'Use in Python',
      h('p', {}, 'Install the client:'),
      snippet('pip install bendtwin', 'installation of the client'),
      h('p', {}, 'Then load this twin and predict a motion:'),
      snippet(pythonOf(twin.name, location.origin), 'program that uses this twin'),
      h(
        'p',
        { class: 'muted' },
        'The token of a server of yours on this machine is found by itself; for others set ',
        h('code', {}, 'BENDTWIN_TOKEN'),
        '.',
      ),
    );
  return h('button', { type: 'button', onclick: show }, 'Use in Python');
}
