"""Makes a link by which somebody without a token plays with a twin for a day, and revokes it."""

import os

from bendtwin import Client

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    made = client.share_twin(twin.name, display_name="the board", days=1)
    print("send this:", made.link)
    for share in client.shares(twin.name):
        print(f"{share.display_name}: valid until {share.expire_time:%d %B}")
    client.delete_share(made.share.name)
