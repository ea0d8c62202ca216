import type { Question } from '../../ui/dialog';
import { counted } from '../../ui/format';

/** The question before fits are cancelled. */
export function cancelQuestion({ length: count }: readonly unknown[]): Question {
  const many = count > 1;
  return {
    title: many ? `Cancel ${counted(count, 'fit')}?` : 'Cancel this fit?',
    text: `${many ? 'They end' : 'It ends'} without a twin, and what ${many ? 'they' : 'it'} computed so far cannot be continued.`,
    action: many ? 'Cancel the fits' : 'Cancel the fit',
    decline: many ? 'Keep them' : 'Keep it',
    isDangerous: true,
  };
}
