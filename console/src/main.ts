import { Api } from './api/client';
import { takeReturnFromAddress } from './api/sign_in';
import { takeTokenFromAddress } from './api/token';
import { acceptDrops } from './pages/upload/anywhere';
import { start } from './router';

takeReturnFromAddress();
takeTokenFromAddress();
const app = document.getElementById('app');
const api = new Api();
if (app !== null) start(app, api);
acceptDrops(api);
